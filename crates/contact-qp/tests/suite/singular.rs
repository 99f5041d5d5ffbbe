//! Limit cases: no bounds, all active, singular and indefinite matrices.

use crate::support::{Problem, assert_close, assert_exact, brute_force};
use contact_qp::{BoundState, QpError, QpMethod, QpPath, QpSettings, QpStatus, solve_box};

const METHODS: [QpMethod; 3] = [QpMethod::Auto, QpMethod::Clarabel, QpMethod::ActiveSet];

fn with(method: QpMethod) -> QpSettings {
    QpSettings::default().with_method(method)
}

#[test]
fn no_bound() {
    let mut problem = Problem::random(8, 21);
    problem.lower.fill(f64::NEG_INFINITY);
    let (x, _) = brute_force(&problem);
    for method in METHODS {
        let solution = solve_box(&problem.dense(), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Solved);
        assert_close(&solution.x, &x, 1e-12);
        assert_eq!(solution.counts.clarabel_calls(), usize::from(method == QpMethod::Clarabel));
    }
}

#[test]
fn every_unknown_bounded_and_active() {
    let mut problem = Problem::random(8, 22);
    problem.lower = vec![0.0; 8];
    problem.linear = vec![1.0; 8];
    for method in METHODS {
        let solution = solve_box(&problem.dense(), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Solved);
        assert_exact(&problem.dense(), &solution);
        assert_eq!(solution.states, [BoundState::Lower; 8]);
        assert_eq!((solution.x, solution.multipliers), (vec![0.0; 8], vec![1.0; 8]));
        assert_eq!(solution.kkt.max(), 0.0);
    }
    let warm = solve_box(&problem.dense(), Some(&[BoundState::Lower; 8]), &QpSettings::default()).unwrap();
    assert_eq!(warm.path, QpPath::WarmStart);
}

/// Two unknowns joined by a spring, constrained only by the bound on the first.
fn floating(load: f64) -> Problem {
    Problem::below(vec![1.0, -1.0, -1.0, 1.0], vec![load; 2], vec![0.5, f64::NEG_INFINITY])
}

#[test]
fn a_floating_body_pressed_on_is_solved() {
    for method in METHODS {
        let solution = solve_box(&floating(1.0).dense(), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Solved, "{method:?}");
        assert_eq!(solution.x, [0.5, -0.5]);
        assert_eq!(solution.multipliers, [2.0, 0.0]);
    }
}

#[test]
fn a_floating_body_pulled_off_is_unbounded() {
    for method in METHODS {
        let solution = solve_box(&floating(-1.0).dense(), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Unbounded, "{method:?}");
        assert!(solution.kkt.max() > 1e-6);
    }
}

#[test]
fn an_indefinite_matrix_is_an_error() {
    let none = f64::NEG_INFINITY;
    let matrix = vec![2.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 2.0, 1.0];
    let indefinite = Problem::below(matrix, vec![1.0, 1.0, -2.0], vec![0.0, none, none]);
    for method in METHODS {
        let found = solve_box(&indefinite.dense(), None, &with(method));
        assert_eq!(found, Err(QpError::NotPositiveDefinite { index: 2 }), "{method:?}");
    }
    let negative = Problem::below(vec![-1.0], vec![1.0], vec![none]);
    for method in METHODS {
        let found = solve_box(&negative.dense(), None, &with(method));
        assert_eq!(found, Err(QpError::NotPositiveDefinite { index: 0 }));
    }
}

#[test]
fn springs_that_nothing_holds_are_refused() {
    let mut matrix = vec![0.0; 36];
    for (i, spring) in [0.1, 0.7, 0.3, 0.9, 0.6].into_iter().enumerate() {
        matrix[7 * i] += spring;
        matrix[7 * (i + 1)] += spring;
        matrix[6 * i + i + 1] -= spring;
        matrix[6 * (i + 1) + i] -= spring;
    }
    let pulled = Problem::below(matrix, vec![1.0; 6], vec![f64::NEG_INFINITY; 6]);
    for method in METHODS {
        let solution = solve_box(&pulled.dense(), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Unbounded, "{method:?}");
    }
}

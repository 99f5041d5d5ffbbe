//! Limit cases: no unknowns, no bounds, all active, singular and indefinite matrices.

use crate::support::{Problem, assert_close, assert_exact, brute_force};
use contact_qp::{
    ActiveSet, BoundQp, MatrixView, QpError, QpMethod, QpPath, QpSettings, QpStatus, kkt_residuals, solve,
};

const METHODS: [QpMethod; 3] = [QpMethod::Auto, QpMethod::Clarabel, QpMethod::ActiveSet];

fn with(method: QpMethod) -> QpSettings {
    QpSettings::default().with_method(method)
}

#[test]
fn no_unknown() {
    let dense = MatrixView::Dense { n: 0, values: &[] };
    let sparse = MatrixView::SparseUpper { n: 0, column_starts: &[0], row_indices: &[], values: &[] };
    for matrix in [dense, sparse] {
        let qp = BoundQp { matrix, linear: &[], bounded: &[], lower: &[] };
        for method in METHODS {
            let solution = solve(&qp, None, &with(method)).unwrap();
            assert_eq!((solution.status, solution.iterations), (QpStatus::Solved, 0));
            assert!(solution.x.is_empty() && solution.active.is_empty());
        }
        assert_eq!(kkt_residuals(&qp, &[], &[]).unwrap().max(), 0.0);
    }
}

#[test]
fn no_bound() {
    let mut problem = Problem::random(8, 21);
    problem.bounded.clear();
    problem.lower.clear();
    let (x, _) = brute_force(&problem);
    for method in METHODS {
        let solution = solve(&problem.dense(), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Solved);
        assert_close(&solution.x, &x, 1e-12);
        assert_eq!(solution.clarabel_calls, usize::from(method == QpMethod::Clarabel));
    }
}

#[test]
fn every_unknown_bounded_and_active() {
    let mut problem = Problem::random(8, 22);
    problem.bounded = (0..8).collect();
    problem.lower = vec![0.0; 8];
    problem.linear = vec![1.0; 8];
    for method in METHODS {
        let solution = solve(&problem.dense(), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Solved);
        assert_exact(&problem.dense(), &solution);
        assert_eq!(solution.active, ActiveSet::all(8));
        assert_eq!((solution.x, solution.multipliers), (vec![0.0; 8], vec![1.0; 8]));
        assert_eq!(solution.kkt.max(), 0.0);
    }
    let warm = solve(&problem.dense(), Some(&ActiveSet::all(8)), &QpSettings::default()).unwrap();
    assert_eq!(warm.path, QpPath::WarmStart);
}

/// Two unknowns joined by a spring, constrained only by the bound on the first.
fn floating(linear: &[f64]) -> BoundQp<'_> {
    let matrix = MatrixView::Dense { n: 2, values: &[1.0, -1.0, -1.0, 1.0] };
    BoundQp { matrix, linear, bounded: &[0], lower: &[0.5] }
}

#[test]
fn a_floating_body_pressed_on_is_solved() {
    for method in METHODS {
        let solution = solve(&floating(&[1.0, 1.0]), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Solved, "{method:?}");
        assert_eq!(solution.x, [0.5, -0.5]);
        assert_eq!(solution.multipliers, [2.0]);
    }
}

#[test]
fn a_floating_body_pulled_off_is_unbounded() {
    for method in METHODS {
        let solution = solve(&floating(&[-1.0, -1.0]), None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Unbounded, "{method:?}");
        assert!(solution.kkt.max() > 1e-6);
    }
}

#[test]
fn an_indefinite_matrix_is_an_error() {
    let indefinite = BoundQp {
        matrix: MatrixView::Dense { n: 3, values: &[2.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 2.0, 1.0] },
        linear: &[1.0, 1.0, -2.0],
        bounded: &[0],
        lower: &[0.0],
    };
    for method in METHODS {
        let found = solve(&indefinite, None, &with(method));
        assert_eq!(found, Err(QpError::NotPositiveDefinite { index: 2 }), "{method:?}");
    }
    let matrix = MatrixView::Dense { n: 1, values: &[-1.0] };
    let negative = BoundQp { matrix, linear: &[1.0], bounded: &[], lower: &[] };
    for method in METHODS {
        assert_eq!(solve(&negative, None, &with(method)), Err(QpError::NotPositiveDefinite { index: 0 }));
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
    let matrix = MatrixView::Dense { n: 6, values: &matrix };
    let pulled = BoundQp { matrix, linear: &[1.0; 6], bounded: &[], lower: &[] };
    for method in METHODS {
        let solution = solve(&pulled, None, &with(method)).unwrap();
        assert_eq!(solution.status, QpStatus::Unbounded, "{method:?}");
    }
}

//! Which method is used, and what is reported about it.

use crate::support::{Problem, assert_close, assert_exact, brute_force};
use contact_qp::{BoundState, QpMethod, QpPath, QpSettings, QpStatus, solve_box};

fn settings(method: QpMethod) -> QpSettings {
    QpSettings::default().with_method(method)
}

/// A matrix on which primal-dual steps from the empty set cycle with period 3.
fn cycling() -> Problem {
    let matrix = vec![4.0, 5.0, -5.0, 5.0, 9.0, -5.0, -5.0, -5.0, 7.0];
    Problem::below(matrix, vec![2.0, 1.0, -3.0], vec![0.0; 3])
}

#[test]
fn the_right_warm_start_needs_one_linear_solution() {
    let problem = Problem::random(40, 7);
    let cold = solve_box(&problem.dense(), None, &QpSettings::default()).unwrap();
    assert_eq!((cold.path, cold.counts.clarabel_calls()), (QpPath::Clarabel, 1));
    assert!(
        cold.iterations > 1 && cold.counts.polish_sets >= 1 && cold.counts.interior_points == cold.iterations
    );
    for method in [QpMethod::Auto, QpMethod::ActiveSet] {
        let warm = solve_box(&problem.dense(), Some(&cold.states), &settings(method)).unwrap();
        assert_eq!((warm.status, warm.path), (QpStatus::Solved, QpPath::WarmStart));
        assert_eq!((warm.iterations, warm.counts.clarabel_calls(), warm.counts.polish_sets), (1, 0, 0));
        assert_eq!(warm.x, cold.x);
        assert_eq!(warm.multipliers, cold.multipliers);
    }
}

#[test]
fn a_wrong_warm_start_is_not_believed() {
    let problem = Problem::random(40, 7);
    let cold = solve_box(&problem.dense(), None, &QpSettings::default()).unwrap();
    for i in problem.bounded() {
        let mut states = cold.states.clone();
        states[i] = if states[i] == BoundState::Free { BoundState::Lower } else { BoundState::Free };
        let warm = solve_box(&problem.dense(), Some(&states), &QpSettings::default()).unwrap();
        assert_eq!((warm.status, warm.path), (QpStatus::Solved, QpPath::ActiveSet));
        assert!(warm.iterations > 1 && warm.counts.clarabel_calls() == 0);
        assert_eq!(warm.states, cold.states);
    }
}

#[test]
fn method_clarabel_does_not_use_the_warm_start() {
    let problem = Problem::random(12, 3);
    let cold = solve_box(&problem.dense(), None, &settings(QpMethod::ActiveSet)).unwrap();
    assert_eq!((cold.path, cold.counts.clarabel_calls()), (QpPath::ActiveSet, 0));
    let solution = solve_box(&problem.dense(), Some(&cold.states), &settings(QpMethod::Clarabel)).unwrap();
    assert_eq!((solution.path, solution.counts.clarabel_calls()), (QpPath::Clarabel, 1));
    assert_eq!(solution.states, cold.states);
}

#[test]
fn a_cycle_falls_back_to_clarabel() {
    let problem = cycling();
    let (x, multipliers) = brute_force(&problem);
    let empty = [BoundState::Free; 3];
    for (method, start) in [(QpMethod::ActiveSet, None), (QpMethod::Auto, Some(&empty[..]))] {
        let solution = solve_box(&problem.dense(), start, &settings(method)).unwrap();
        assert_eq!((solution.status, solution.path), (QpStatus::Solved, QpPath::Clarabel));
        assert_eq!(solution.counts.clarabel_calls(), 1);
        assert_close(&solution.x, &x, 1e-14);
        assert_close(&solution.multipliers, &multipliers, 1e-14);
    }
}

#[test]
fn the_limit_of_active_set_steps_falls_back_to_clarabel() {
    let problem = Problem::random(40, 7);
    let wrong = vec![BoundState::Free; problem.n];
    for limit in [0, 1] {
        let settings = QpSettings::default().with_max_active_set_steps(limit);
        let solution = solve_box(&problem.dense(), Some(&wrong), &settings).unwrap();
        assert_eq!((solution.status, solution.path), (QpStatus::Solved, QpPath::Clarabel));
        assert_eq!(solution.counts.clarabel_calls(), 1);
        assert_exact(&problem.dense(), &solution);
    }
}

#[test]
fn too_few_iterations_are_a_status_with_honest_residuals() {
    let problem = Problem::random(40, 7);
    for limit in [0, 1] {
        let settings = settings(QpMethod::Clarabel).with_max_iterations(limit);
        // A descent has a limit of its own.
        let solution = solve_box(&problem.dense(), None, &settings).unwrap();
        assert!(solution.status.is_solved() && solution.counts.descent_steps > 0, "{:?}", solution.counts);
        let solution = solve_box(&problem.dense(), None, &settings.with_kkt_tolerance(1e-30)).unwrap();
        assert_eq!((solution.status, solution.counts.clarabel_calls()), (QpStatus::MaxIterations, 1));
        assert!(!solution.status.is_solved());
        assert_exact(&problem.dense(), &solution);
        assert!(solution.kkt.stationarity > 1e-6, "{:?}", solution.kkt);
    }
}

#[test]
fn what_clarabel_leaves_half_done_is_polished() {
    let problem = Problem::random(40, 7);
    let wanted = solve_box(&problem.dense(), None, &settings(QpMethod::ActiveSet)).unwrap();
    let clarabel = settings(QpMethod::Clarabel);
    // No floating-point iterate is that good; and five iterations do not suffice.
    for settings in [clarabel.clone().with_tolerance(1e-25), clarabel.with_max_iterations(5)] {
        let solution = solve_box(&problem.dense(), None, &settings).unwrap();
        assert_eq!((solution.status, solution.path), (QpStatus::Solved, QpPath::Clarabel));
        assert_eq!(solution.counts.clarabel_calls(), 1);
        assert_exact(&problem.dense(), &solution);
        assert_eq!(solution.states, wanted.states);
    }
}

#[test]
fn an_unattainable_kkt_tolerance_is_a_status() {
    let problem = Problem::random(40, 7);
    let settings = QpSettings::default().with_kkt_tolerance(1e-30);
    let solution = solve_box(&problem.dense(), None, &settings).unwrap();
    assert_eq!(solution.status, QpStatus::PolishFailed);
    assert_exact(&problem.dense(), &solution);
}

#[test]
fn a_bound_that_just_touches_is_active_with_multiplier_zero() {
    // The unconstrained minimiser is (1, 2), exactly on both bounds.
    let problem = Problem::below(vec![4.0, -1.0, -1.0, 4.0], vec![-2.0, -7.0], vec![1.0, 2.0]);
    let qp = problem.dense();
    let both = [BoundState::Free, BoundState::Lower];
    let starts = both.iter().flat_map(|a| both.iter().map(move |b| Some([*a, *b]))).chain([None]);
    for start in starts {
        for method in [QpMethod::Auto, QpMethod::ActiveSet, QpMethod::Clarabel] {
            let solution =
                solve_box(&qp, start.as_ref().map(<[BoundState; 2]>::as_slice), &settings(method)).unwrap();
            assert_eq!(solution.status, QpStatus::Solved, "{start:?} {method:?}");
            assert_exact(&qp, &solution);
            assert_close(&solution.x, &[1.0, 2.0], 1e-15);
            assert!(solution.multipliers.iter().all(|&r| r < 1e-14), "{solution:?}");
        }
    }
}

#[test]
fn the_words_of_the_report() {
    let words = [QpPath::WarmStart, QpPath::ActiveSet, QpPath::Clarabel].map(|path| path.to_string());
    assert_eq!(words, ["warm-start", "active-set", "clarabel"]);
    assert_eq!(format!("{:>12}", QpStatus::Solved), "      solved");
}

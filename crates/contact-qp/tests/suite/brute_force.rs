//! Small random problems against the exhaustive search over active sets.

use crate::support::{Problem, Sparse, assert_close, assert_exact, at_bounds, brute_force};
use contact_qp::{BoundState, QpMethod, QpSettings, QpStatus, solve_box};

const METHODS: [QpMethod; 3] = [QpMethod::Auto, QpMethod::Clarabel, QpMethod::ActiveSet];

#[test]
fn every_method_and_form_finds_the_answer() {
    let mut worst = 0.0f64;
    let mut active_bounds = 0;
    for seed in 0..240 {
        let problem = Problem::random(1 + seed as usize % 8, seed);
        let (x, multipliers) = brute_force(&problem);
        let sparse = Sparse::new(problem.n, &problem.matrix);
        for qp in [problem.dense(), problem.with(sparse.view())] {
            for method in METHODS {
                let solution = solve_box(&qp, None, &QpSettings::default().with_method(method)).unwrap();
                assert_eq!(solution.status, QpStatus::Solved, "seed {seed}, {method:?}");
                assert_exact(&qp, &solution);
                assert_close(&solution.x, &x, 1e-11);
                assert_close(&solution.multipliers, &multipliers, 1e-10);
                worst = worst.max(solution.kkt.max());
                active_bounds += at_bounds(&solution);
            }
        }
    }
    println!("largest KKT residual {worst:e}");
    assert!(worst < 1e-14, "{worst:e}");
    // The sample must contain contact, otherwise the test would be weak.
    assert!(active_bounds > 1000, "{active_bounds}");
}

#[test]
fn every_warm_start_gives_the_same_answer() {
    for seed in 1000..1030 {
        let problem = Problem::random(4, seed);
        let (x, _) = brute_force(&problem);
        let bounded = problem.bounded();
        for mask in 0..1usize << bounded.len() {
            let mut start = vec![BoundState::Free; problem.n];
            let active = bounded.iter().enumerate().filter(|(k, _)| mask >> k & 1 == 1);
            active.for_each(|(_, i)| start[*i] = BoundState::Lower);
            let solution = solve_box(&problem.dense(), Some(&start), &QpSettings::default()).unwrap();
            assert_eq!(solution.status, QpStatus::Solved);
            assert_exact(&problem.dense(), &solution);
            assert_close(&solution.x, &x, 1e-11);
        }
    }
}

#[test]
fn dense_and_sparse_name_the_same_active_set() {
    for seed in 0..20 {
        let problem = Problem::random(60, 5000 + seed);
        let sparse = Sparse::new(problem.n, &problem.matrix);
        for method in METHODS {
            let settings = QpSettings::default().with_method(method);
            let full = solve_box(&problem.dense(), None, &settings).unwrap();
            let thin = solve_box(&problem.with(sparse.view()), None, &settings).unwrap();
            assert_eq!((full.status, thin.status), (QpStatus::Solved, QpStatus::Solved));
            assert_eq!(full.states, thin.states);
            assert!(at_bounds(&full) > 5);
            assert_close(&thin.multipliers, &full.multipliers, 1e-10);
            assert!(full.kkt.max() < 1e-13 && thin.kkt.max() < 1e-13);
        }
    }
}

//! Neither units nor distant bounds must change the result.

use crate::support::{Problem, assert_close, assert_exact, at_bounds};
use contact_qp::{QpMethod, QpSettings, QpStatus, solve_box};

const METHODS: [QpMethod; 2] = [QpMethod::Clarabel, QpMethod::ActiveSet];

#[test]
fn other_units_give_the_same_answer() {
    for seed in 0..10 {
        let problem = Problem::random(30, 300 + seed);
        let reference = solve_box(&problem.dense(), None, &QpSettings::default()).unwrap();
        for stiffness in [1e-9, 1.0, 1e9] {
            for force in [1e-9, 1.0, 1e9] {
                let length = force / stiffness;
                let scaled = Problem {
                    matrix: problem.matrix.iter().map(|value| value * stiffness).collect(),
                    linear: problem.linear.iter().map(|value| value * force).collect(),
                    lower: problem.lower.iter().map(|value| value * length).collect(),
                    ..problem.clone()
                };
                for method in METHODS {
                    let settings = QpSettings::default().with_method(method);
                    let solution = solve_box(&scaled.dense(), None, &settings).unwrap();
                    assert_eq!(solution.status, QpStatus::Solved, "P × {stiffness:e}, q × {force:e}");
                    assert_exact(&scaled.dense(), &solution);
                    assert_eq!(solution.states, reference.states);
                    let x: Vec<f64> = solution.x.iter().map(|value| value / length).collect();
                    let r: Vec<f64> = solution.multipliers.iter().map(|value| value / force).collect();
                    assert_close(&x, &reference.x, 1e-11);
                    assert_close(&r, &reference.multipliers, 1e-11);
                }
            }
        }
    }
}

#[test]
fn far_away_bounds_count_for_nothing() {
    for seed in 0..10 {
        let near = Problem::random(20, 900 + seed);
        let mut far = near.clone();
        for distance in [1e6, 1e12, 1e20, 1e300] {
            far.lower = near.lower.iter().map(|lower| lower.max(-distance)).collect();
            far.upper = vec![distance; near.n];
            for method in METHODS {
                let settings = QpSettings::default().with_method(method);
                let wanted = solve_box(&near.dense(), None, &settings).unwrap();
                let solution = solve_box(&far.dense(), None, &settings).unwrap();
                assert_eq!(solution.status, QpStatus::Solved, "{distance:e}");
                assert_exact(&far.dense(), &solution);
                assert_eq!(at_bounds(&solution), at_bounds(&wanted));
                assert_close(&solution.x, &wanted.x, 1e-13);
            }
        }
    }
}

#[test]
fn stiffnesses_of_different_size_are_solved() {
    // D P D with D from 1e-4 to 1e4: like a soft body and a stiff one together.
    for seed in 0..10 {
        let mut problem = Problem::random(20, 1200 + seed);
        let n = problem.n;
        let scale = |i: usize| 10f64.powf(8.0 * i as f64 / (n - 1) as f64 - 4.0);
        for j in 0..n {
            problem.linear[j] *= scale(j);
            for i in 0..n {
                problem.matrix[j * n + i] *= scale(i) * scale(j);
            }
        }
        problem.lower.iter_mut().enumerate().for_each(|(i, lower)| *lower /= scale(i));
        let answers = METHODS.map(|method| {
            let settings = QpSettings::default().with_method(method);
            solve_box(&problem.dense(), None, &settings).unwrap()
        });
        for solution in &answers {
            assert_eq!(solution.status, QpStatus::Solved, "seed {seed}");
            assert_exact(&problem.dense(), solution);
        }
        assert_eq!(answers[0].states, answers[1].states);
    }
}

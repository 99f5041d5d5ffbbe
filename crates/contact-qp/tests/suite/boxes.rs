//! Programmes with bounds on both sides and equality rows, against every possible set.

use crate::support::{Problem, Random, wall};
use contact_qp::{
    BoundState, BoxQp, MatrixView, QpMethod, QpSettings, QpStatus, SparseRows, kkt_residuals, solve_box,
};

/// A full matrix.
fn full(n: usize, values: &[f64]) -> MatrixView<'_> {
    MatrixView::Dense { n, values }
}

#[test]
fn random_programmes_satisfy_the_kkt_conditions_by_every_method() {
    let mut random = Random::new(11);
    let mut fallbacks = 0;
    for case in 0..600 {
        let n = 2 + case % 9;
        let m = case % 4;
        let rank = if case % 5 == 0 { n - m.min(2).min(n - 1) } else { n };
        let programme = Problem::boxed(&mut random, n, m, rank);
        let qp = programme.dense();
        let mut found = Vec::new();
        for method in [QpMethod::ActiveSet, QpMethod::Clarabel] {
            let answer = solve_box(&qp, None, &QpSettings::default().with_method(method)).unwrap();
            assert_eq!(answer.status, QpStatus::Solved, "case {case}, {method:?}: {answer:?}");
            assert!(answer.kkt.max() <= 1e-12, "case {case}: {:?}", answer.kkt);
            let again = kkt_residuals(&qp, &answer.x, &answer.multipliers, &answer.row_multipliers);
            assert_eq!(again, answer.kkt);
            for i in 0..n {
                assert!((programme.lower[i]..=programme.upper[i]).contains(&answer.x[i]));
            }
            fallbacks += answer.counts.clarabel_calls();
            found.push(programme.objective(&answer.x));
        }
        assert!((found[0] - found[1]).abs() <= 1e-9 * (1.0 + found[0].abs()), "case {case}: {found:?}");
    }
    assert!(fallbacks < 900, "the active set alone solved too few: {fallbacks}");
}

#[test]
fn the_solution_is_the_best_of_all_sets() {
    let mut random = Random::new(5);
    for case in 0..60 {
        let (n, m) = (4, 1 + case % 2);
        let programme = Problem::boxed(&mut random, n, m, n);
        let qp = programme.dense();
        let answer = solve_box(&qp, None, &QpSettings::default()).unwrap();
        // Every set on which the signs are right has the same x.
        let mut right = 0;
        for code in 0..3usize.pow(n as u32) {
            let place = |i: usize| {
                [BoundState::Lower, BoundState::Free, BoundState::Upper][code / 3usize.pow(i as u32) % 3]
            };
            let states: Vec<BoundState> = (0..n).map(place).collect();
            let settings =
                QpSettings::default().with_max_active_set_steps(1).with_method(QpMethod::ActiveSet);
            if (0..n).any(|i| states[i] == BoundState::Upper && programme.upper[i].is_infinite()) {
                continue;
            }
            let found = solve_box(&qp, Some(&states), &settings).unwrap();
            if found.counts.clarabel_calls() == 0 {
                right += 1;
                for (a, b) in found.x.iter().zip(&answer.x) {
                    assert!((a - b).abs() < 1e-9, "case {case}: {:?} {:?}", found.x, answer.x);
                }
            }
        }
        assert!(right > 0, "case {case}");
    }
}

#[test]
fn rows_that_cannot_hold_are_infeasible_not_an_error() {
    // x ≥ 0 with x₀ + x₁ = −1.
    let [row, contradiction] =
        [&[1.0; 2][..], &[1.0, 1.0, 2.0, 2.0]].map(|rows| SparseRows::from_dense(2, rows));
    let qp = BoxQp {
        matrix: full(2, &[1.0, 0.0, 0.0, 1.0]),
        linear: &[0.0, 0.0],
        lower: &[0.0, 0.0],
        upper: &[f64::INFINITY; 2],
        rows: &row,
        right_side: &[-1.0],
    };
    let answer = solve_box(&qp, None, &QpSettings::default()).unwrap();
    assert_eq!(answer.status, QpStatus::Infeasible);
    // Two rows that contradict each other.
    let qp = BoxQp { rows: &contradiction, right_side: &[1.0, 3.0], ..qp };
    assert!(!solve_box(&qp, None, &QpSettings::default()).unwrap().status.is_solved());
}

#[test]
fn an_unknown_between_equal_bounds_may_have_a_multiplier_of_either_sign() {
    // Its own force pushes it up, the moves of the other one push it down, or the other way round.
    for sign in [1.0, -1.0] {
        let none = SparseRows::new(2);
        let qp = BoxQp {
            matrix: full(2, &[1.0, 0.9, 0.9, 1.0]),
            linear: &[sign, 3.0 * sign],
            lower: &[0.0, f64::NEG_INFINITY],
            upper: &[0.0, f64::INFINITY],
            rows: &none,
            right_side: &[],
        };
        for start in [BoundState::Lower, BoundState::Upper, BoundState::Free] {
            let answer = solve_box(&qp, Some(&[start, BoundState::Free]), &QpSettings::default()).unwrap();
            assert_eq!(
                (answer.status, answer.counts.clarabel_calls()),
                (QpStatus::Solved, 0),
                "{sign} {start:?}"
            );
            assert!((answer.multipliers[0] - sign * (1.0 - 2.7)).abs() < 1e-14, "{answer:?}");
        }
    }
}

#[test]
fn sparse_programmes_have_the_solution_of_full_ones() {
    let mut random = Random::new(23);
    let rows = wall(4, 5);
    let (m, n) = (rows.len(), rows.columns());
    // Springs between neighbours, and a pair of unknowns that only the rows determine.
    let mut matrix = vec![0.0; n * n];
    for i in 0..n {
        matrix[i * n + i] = 2.5 + random.number();
        if i > 0 {
            (matrix[i * n + i - 1], matrix[(i - 1) * n + i]) = (-0.7, -0.7);
        }
    }
    let (mut starts, mut places, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..n {
        for i in (0..=j).filter(|i| matrix[j * n + i] != 0.0) {
            places.push(i);
            values.push(matrix[j * n + i]);
        }
        starts.push(places.len());
    }
    let sparse = MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &places, values: &values };
    let linear: Vec<f64> = (0..n).map(|_| random.number()).collect();
    let load: Vec<f64> =
        (0..m).map(|k| if k % 3 == 1 { -1.0 - 0.3 * random.number() } else { 0.0 }).collect();
    let (lower, upper) = (vec![0.0; n], vec![f64::INFINITY; n]);
    let solve = |matrix| {
        let qp =
            BoxQp { matrix, linear: &linear, lower: &lower, upper: &upper, rows: &rows, right_side: &load };
        let found = solve_box(&qp, None, &QpSettings::default()).unwrap();
        assert_eq!(found.status, QpStatus::Solved);
        assert!(found.kkt.max() <= 1e-12, "{:?}", found.kkt);
        found.x
    };
    let [a, b] = [solve(full(n, &matrix)), solve(sparse)];
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1e-11), "{a:?} {b:?}");
}

#[test]
fn a_programme_without_unknowns_is_solved_by_every_method() {
    let none = SparseRows::new(0);
    let mut empty = none.clone();
    empty.push([]);
    let rows = |right_side: &'static [f64]| BoxQp {
        matrix: full(0, &[]),
        linear: &[],
        lower: &[],
        upper: &[],
        rows: if right_side.is_empty() { &none } else { &empty },
        right_side,
    };
    for method in [QpMethod::Auto, QpMethod::Clarabel, QpMethod::ActiveSet] {
        let settings = QpSettings::default().with_method(method);
        let found = solve_box(&rows(&[]), None, &settings).unwrap();
        assert_eq!(
            (found.status, found.x.len(), found.counts.clarabel_calls()),
            (QpStatus::Solved, 0, 0),
            "{method:?}"
        );
        assert_eq!(
            solve_box(&rows(&[1.0]), None, &settings).unwrap().status,
            QpStatus::Infeasible,
            "{method:?}"
        );
    }
}

//! Every way to a solution is needed: programmes that are not solved as said without it. A right start, a cycle, and what Clarabel leaves
//! half done are in `paths`.

use crate::support::{Problem, Random, assert_close, assert_exact};
use contact_qp::{BoxSolution, QpMethod, QpSettings, QpStatus, SparseRows, solve_box};

fn solved(problem: &Problem, method: QpMethod) -> BoxSolution {
    let found = solve_box(&problem.dense(), None, &QpSettings::default().with_method(method)).unwrap();
    assert_eq!(found.status, QpStatus::Solved, "{method:?} {:?} {:?}", found.counts, found.kkt);
    assert!(found.kkt.max() <= 1e-12, "{:?}", found.kkt);
    assert_exact(&problem.dense(), &found);
    found
}

#[test]
fn clarabel_is_called_with_few_of_the_bounds_of_a_large_full_matrix() {
    // A string over a flat obstacle, joined to the ground by springs.
    let n = 300;
    let mut matrix = vec![0.0; n * n];
    for i in 0..n {
        matrix[i * (n + 1)] = 2.001;
        if i > 0 {
            (matrix[i * n + i - 1], matrix[(i - 1) * n + i]) = (-1.0, -1.0);
        }
    }
    let mut problem = Problem::below(matrix, vec![1.0; n], vec![-100.0; n]);
    let large = solved(&problem, QpMethod::Clarabel);
    assert_eq!((large.counts.shrunk_calls, large.counts.whole_calls), (1, 0));
    assert!(large.counts.polish_sets > 1, "{:?}", large.counts);
    let judge = solved(&problem, QpMethod::ActiveSet);
    assert_eq!((judge.counts.clarabel_calls(), &judge.states), (0, &large.states));
    assert_close(&large.x, &judge.x, 1e-13);
    // With rows Clarabel takes the whole.
    (problem.rows, problem.right_side) = (SparseRows::from_dense(n, &vec![1.0; n]), vec![-2.0e4]);
    let whole = solved(&problem, QpMethod::Clarabel);
    assert_eq!((whole.counts.shrunk_calls, whole.counts.whole_calls), (0, 1));
}

#[test]
fn a_single_feasible_point_is_solved_although_its_multipliers_are_not_unique() {
    let (mut random, mut fitted) = (Random::new(23), 0);
    for case in 0..200 {
        let (n, m) = (1 + case % 7, 1 + case % 3);
        let mut programme = Problem::boxed(&mut random, n, m, n);
        // Positive rows that add up to zero: only x = 0 is feasible.
        let mut rows = programme.rows.dense();
        rows[..n].iter_mut().for_each(|g| *g = g.abs() + 0.1);
        programme.rows = SparseRows::from_dense(n, &rows);
        programme.right_side.fill(0.0);
        for method in [QpMethod::ActiveSet, QpMethod::Clarabel] {
            let found = solved(&programme, method);
            assert_eq!(found.x, vec![0.0; n]);
            fitted += found.counts.fitted;
        }
    }
    assert!(fitted > 50, "{fitted}");
}

#[test]
fn rows_that_cannot_hold_on_the_set_of_clarabel_are_reached_by_a_descent() {
    // The rows, or those and the bounds that are reached, leave nearly no room, so that Clarabel takes too many unknowns for fixed.
    let (mut random, mut descents) = (Random::new(29), 0);
    for (n, m) in [(2, 1), (2, 2), (2, 3), (3, 2), (3, 3)] {
        for _ in 0..300 {
            let problem = Problem::boxed(&mut random, n, m, 1);
            let [a, b] = [QpMethod::ActiveSet, QpMethod::Clarabel].map(|method| solved(&problem, method));
            let [least, other] = [&a, &b].map(|found| problem.objective(&found.x));
            assert!((least - other).abs() <= 1e-9 * (1.0 + least.abs()), "{least} {other}");
            descents += [a, b].iter().filter(|found| found.counts.descent_steps > 0).count();
        }
    }
    assert!(descents > 30, "{descents}");
}

/// A box of unit width that three rigid spheres carry, one below each of three of its nodes, which are drawn. Of a load of 1 they carry given shares.
///
/// Returns the numbers of the three contacts.
fn three_spheres(random: &mut Random, shares: [f64; 3]) -> (Problem, [usize; 3]) {
    let cells = 2 + (1.5 * (1.0 + random.number())) as usize;
    let (side, nodes) = (cells + 1, (cells + 1) * (cells + 1));
    let at = |i: usize| [i % side, i % nodes / side].map(|k| k as f64 / cells as f64 - 0.5);
    let distance = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).hypot(b - d);
    let area = |[a, b]: [f64; 2], [c, d]: [f64; 2], [e, f]: [f64; 2]| (c - a) * (f - b) - (e - a) * (d - b);
    let tops = loop {
        let tops = [(); 3].map(|()| (0.5 * (1.0 + random.number()) * nodes as f64) as usize);
        if area(at(tops[0]), at(tops[1]), at(tops[2])).abs() > 0.1 {
            break tops;
        }
    };
    // Each node may touch each sphere, of radius 2.
    let n = 3 * nodes;
    let normal = |i: usize| {
        let [x, y] = [0, 1].map(|c| 0.5 * (at(i)[c] - at(tops[i / nodes])[c]));
        [x, y, (1.0 - x * x - y * y).sqrt()]
    };
    let entry = |i: usize, j: usize| {
        let cosine: f64 = normal(i).iter().zip(normal(j)).map(|(a, b)| a * b).sum();
        1e-5 * cosine / (0.5 / cells as f64 + distance(at(i), at(j)))
    };
    let gap = |i: usize| 2.0 - (4.0 - distance(at(i), at(tops[i / nodes])).powi(2)).sqrt();
    let matrix = (0..n * n).map(|k| entry(k % n, k / n)).collect();
    let linear = (0..n).map(|i| gap(i) + 1e-5 * random.number()).collect();
    let mut problem = Problem::below(matrix, linear, vec![0.0; n]);
    // Forces, and moments about the middle of the box.
    let wrench = |i: usize| {
        let ([x, y, z], [a, b]) = (normal(i), at(i));
        [x, y, z, b * z + 0.5 * y, -0.5 * x - a * z, a * y - b * x]
    };
    let rows: Vec<f64> = (0..6).flat_map(|k| (0..n).map(move |i| wrench(i)[k])).collect();
    problem.rows = SparseRows::from_dense(n, &rows);
    let contacts = [0, 1, 2].map(|k| k * nodes + tops[k]);
    let mut forces = vec![0.0; n];
    contacts.iter().zip(shares).for_each(|(i, share)| forces[*i] = share);
    problem.right_side = problem.rows.times(&forces);
    (problem, contacts)
}

#[test]
fn forces_much_smaller_than_those_that_would_close_the_gaps_are_found() {
    // The gaps ask for forces of 1e4, next to which the smallest share is rounding for Clarabel: on its set the rows cannot hold.
    let mut random = Random::new(31);
    for k in 0..320 {
        let least = 10f64.powi(-1 - k % 8);
        let (problem, contacts) = three_spheres(&mut random, [0.6 - 0.5 * least, 0.4 - 0.1 * least, least]);
        for method in [QpMethod::ActiveSet, QpMethod::Clarabel] {
            let found = solved(&problem, method);
            let third = found.x[contacts[2]];
            assert!((third - least).abs() <= 1e-12, "{third:e} of {least:e} by {method:?}");
        }
    }
}

//! Rows with bounds: least squares, loads out of balance, the nearest numbers in balance, and rows that depend on each other.

use crate::support::{Problem, Random, wall};
use contact_qp::{
    QpSettings, QpStatus, RowSelection, SparseRows, nearest_balanced, nonnegative_least_squares, solve_box,
    unbalanced_load,
};

/// Checks that the method for sparse rows leaves the same.
fn same_residual(
    case: usize,
    (m, n): (usize, usize),
    rows: &[f64],
    e: &[f64],
    bounds: [&[f64]; 2],
    residual: &[f64],
) {
    let sparse = SparseRows::from_dense(n, rows);
    let (x, left) = unbalanced_load(&sparse, e, bounds, &[]).unwrap();
    assert!((0..n).all(|i| bounds[0][i] <= x[i] && x[i] <= bounds[1][i]), "case {case}: {x:?}");
    let products = sparse.times(&x);
    for k in 0..m {
        assert!((left[k] - residual[k]).abs() <= 1e-11, "case {case}: {left:?} {residual:?}");
        assert!((e[k] - products[k] - left[k]).abs() <= 1e-12, "case {case}");
    }
}

#[test]
fn the_load_of_a_wall_is_balanced_and_what_is_not_is_the_motion() {
    for (courses, width) in [(3, 4), (12, 8)] {
        let rows = wall(courses, width);
        let (m, n) = (rows.len(), rows.columns());
        let bounds = [&vec![0.0; n][..], &vec![f64::INFINITY; n]];
        // Weight is carried.
        let weight: Vec<f64> = (0..m).map(|k| if k % 3 == 1 { -1.0 } else { 0.0 }).collect();
        let (x, left) = unbalanced_load(&rows, &weight, bounds, &[]).unwrap();
        assert!(x.iter().all(|x| *x >= 0.0) && left.iter().all(|r| r.abs() <= 1e-12), "{left:?}");
        // A pull on the last block of a course moves that block alone; one on its first block moves the course.
        for (pulled, moving) in [(width - 1, 1), (0, width)] {
            let mut load = weight.clone();
            load[3 * pulled] = 2.0;
            let (_, left) = unbalanced_load(&rows, &load, bounds, &[]).unwrap();
            let (_, expected) = nonnegative_least_squares(&rows.dense(), &load).unwrap();
            for (a, b) in left.iter().zip(&expected) {
                assert!((a - b).abs() <= 1e-11, "{a} {b}");
            }
            let moves: Vec<usize> = (0..m).filter(|k| left[*k].abs() > 1e-12).collect();
            assert_eq!(moves.len(), moving, "{moves:?}");
        }
        // Nothing holds the courses along the joints, and no row is kept for that.
        let found =
            RowSelection::new(&rows, &weight, &(0..m).map(|k| k / 3).collect::<Vec<_>>(), 1e-3).unwrap();
        assert_eq!((found.kernel.len(), found.weak.len()), (courses, 0));
        assert_eq!(found.rows.len(), m - courses);
        for combination in &found.kernel {
            let mut t = vec![0.0; m];
            combination.iter().for_each(|(k, a)| t[*k] = *a);
            assert!(rows.transposed_times(&t).iter().all(|g| g.abs() < 1e-13));
        }
    }
}

#[test]
fn without_rows_nothing_is_left_and_nothing_is_selected() {
    let none = SparseRows::new(3);
    assert_eq!(unbalanced_load(&none, &[], [&[0.0; 3], &[1.0; 3]], &[]).unwrap(), (vec![0.0; 3], vec![]));
    assert!(RowSelection::new(&none, &[], &[], 1e-3).unwrap().rows.is_empty());
    let nearest =
        nearest_balanced(&[2.0, -1.0, 0.5], &[1.0; 3], [&[0.0; 3], &[1.0; 3]], &[], &none, &[]).unwrap();
    assert_eq!(nearest.unwrap().values, [1.0, 0.0, 0.5]);
}

#[test]
fn a_roller_whose_spin_is_hardly_resisted_keeps_its_translations() {
    // Forces along x and y, and their moments, which are nearly those of a force along x: in every order of the rows the spin is left out.
    let lines = [[1.0, 0.3, -0.8, 0.9], [0.2, 1.0, 0.9, -0.4], [0.010_1, 0.003, -0.008, 0.009]];
    for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
        let rows = SparseRows::from_dense(4, &order.map(|k| lines[k]).concat());
        let found = RowSelection::new(&rows, &order.map(|k| [0.0, -1.0, 0.0][k]), &[0; 3], 1e-3).unwrap();
        assert_eq!((found.kernel.len(), found.weak.len()), (0, 1), "{found:?}");
        assert!(found.rows.iter().all(|k| order[*k] != 2), "{found:?}");
    }
}

#[test]
fn the_load_along_a_spin_is_found_beside_a_force_many_times_larger() {
    // Normals of a circle whose centre is near the origin, and a force whose moment about the centre is small.
    let (centre, arm) = (5e-4, 0.035);
    let angles: Vec<f64> = (0..12).map(|k| 0.4 * f64::from(k)).collect();
    let row = |of: fn(f64) -> f64, factor: f64| angles.iter().map(|a| factor * of(*a)).collect::<Vec<f64>>();
    let lines = [row(f64::cos, 1.0), row(f64::sin, 1.0), row(f64::cos, centre * arm)].concat();
    let rows = SparseRows::from_dense(angles.len(), &lines);
    let load = [-2e3, 0.0, -2e3 * centre * arm + 1e-3];
    let found = RowSelection::new(&rows, &load, &[0; 3], 0.0).unwrap();
    let part = found.unbalanced(&load);
    // The whole part is along the spin about the centre.
    assert!((part[0] + centre * arm * part[2]).abs() <= 1e-14 * part[2].abs(), "{part:?}");
    assert!((part[2] - 1e-3).abs() <= 1e-9, "{part:?}");
}

#[test]
fn least_squares_residuals_separate_what_is_held_from_what_is_not() {
    let mut random = Random::new(3);
    let (mut held, mut free) = (0, 0);
    for case in 0..400 {
        let (m, n) = (1 + case % 5, 1 + case % 13);
        let rows: Vec<f64> = (0..m * n).map(|_| random.number()).collect();
        let inside: Vec<f64> = (0..n).map(|_| random.number().max(0.0)).collect();
        let times = |x: &[f64]| -> Vec<f64> {
            (0..m).map(|k| (0..n).map(|i| rows[k * n + i] * x[i]).sum()).collect()
        };
        let possible = case % 2 == 0;
        let e = if possible { times(&inside) } else { (0..m).map(|_| random.number()).collect() };
        let (x, residual) = nonnegative_least_squares(&rows, &e).unwrap();
        same_residual(case, (m, n), &rows, &e, [&vec![0.0; n], &vec![f64::INFINITY; n]], &residual);
        let size = e.iter().map(|e| e * e).sum::<f64>().sqrt();
        let left = residual.iter().map(|r| r * r).sum::<f64>().sqrt();
        assert!(x.iter().all(|x| *x >= 0.0));
        for (found, (r, e)) in times(&x).iter().zip(residual.iter().zip(&e)) {
            assert!((e - found - r).abs() <= 1e-12 * (1.0 + size), "case {case}");
        }
        // Gᵀ a ≤ 0: the residual is a motion that closes nothing.
        for i in 0..n {
            let closing: f64 = (0..m).map(|k| rows[k * n + i] * residual[k]).sum();
            assert!(closing <= 1e-12 * (1.0 + size), "case {case}: {closing}");
        }
        let work: f64 = e.iter().zip(&residual).map(|(e, r)| e * r).sum();
        assert!((work - left * left).abs() <= 1e-12 * (1.0 + size * size), "case {case}");
        if possible {
            held += 1;
            assert!(left <= 1e-12 * (1.0 + size), "case {case}: {left}");
        } else if left > 1e-8 {
            free += 1;
        }
    }
    assert!(held == 200 && free > 50, "{held} {free}");
}

#[test]
fn loads_within_bounds_end_if_two_unknowns_meet_their_bounds_at_once() {
    #[rustfmt::skip]
    let rows = [
        0.0, -1.0, 0.0, 1.0, 0.0, -1.0,
        1.0, 0.0, -1.0, 0.0, 1.0, 0.0,
        -1.5, 0.0, -0.5, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, -1.0, 0.0, 0.0,
        0.0, 0.0, 1.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.5, 0.0, 0.0, 0.0,
    ];
    let e = [-1.0, 4.0, -4.0, -2.0, 3.0, 0.0];
    let (lower, upper) =
        ([0.0, -2.0, 0.0, -1.0, 0.0, 0.0], [f64::INFINITY, 2.0, f64::INFINITY, 1.0, f64::INFINITY, 0.0]);
    let (x, residual) =
        unbalanced_load(&SparseRows::from_dense(lower.len(), &rows), &e, [&lower, &upper], &[]).unwrap();
    for i in 0..6 {
        let gain: f64 = (0..6).map(|k| rows[k * 6 + i] * residual[k]).sum();
        assert!(gain <= 1e-12 || x[i] >= upper[i] - 1e-12, "{i}: {gain}");
        assert!(gain >= -1e-12 || x[i] <= lower[i] + 1e-12, "{i}: {gain}");
    }
}

#[test]
fn loads_within_bounds_return_the_unknowns_of_their_residual() {
    // Small whole numbers: unknowns meet both bounds, and come back from them.
    let mut random = Random::new(5);
    let mut whole = |most: i32| f64::from((random.number() * 1e6) as i32 % (most + 1));
    for case in 0..4000 {
        let rows: Vec<f64> = (0..9).map(|_| whole(3)).collect();
        let e: Vec<f64> = (0..3).map(|_| whole(7)).collect();
        let (lower, upper): (Vec<f64>, Vec<f64>) =
            (0..3).map(|_| (-whole(3).abs(), 1.0 + whole(2).abs())).unzip();
        let (x, residual) =
            unbalanced_load(&SparseRows::from_dense(lower.len(), &rows), &e, [&lower, &upper], &[]).unwrap();
        for k in 0..3 {
            let left = e[k] - (0..3).map(|i| rows[3 * k + i] * x[i]).sum::<f64>();
            assert!((left - residual[k]).abs() < 1e-11, "{case}: {rows:?} {e:?} {lower:?} {upper:?}");
        }
    }
}

#[test]
fn loads_within_bounds_are_the_projection_on_what_the_bounds_allow() {
    let mut random = Random::new(11);
    let (mut held, mut free) = (0, 0);
    for case in 0..400 {
        let (m, n) = (1 + case % 4, 1 + case % 17);
        let rows: Vec<f64> = (0..m * n).map(|_| random.number()).collect();
        let ends: Vec<[f64; 2]> = (0..n)
            .map(|i| match i % 3 {
                0 => [0.0, f64::INFINITY],
                1 => [-0.3 * random.number().abs(), 0.3 * random.number().abs()],
                _ => [0.2; 2],
            })
            .collect();
        let (lower, upper): (Vec<f64>, Vec<f64>) = ends.iter().map(|[l, u]| (*l, *u)).unzip();
        let inside: Vec<f64> = (0..n).map(|i| random.number().clamp(lower[i], upper[i])).collect();
        let times = |x: &[f64]| -> Vec<f64> {
            (0..m).map(|k| (0..n).map(|i| rows[k * n + i] * x[i]).sum()).collect()
        };
        let possible = case % 2 == 0;
        let e = if possible { times(&inside) } else { (0..m).map(|_| 3.0 * random.number()).collect() };
        let (x, residual) =
            unbalanced_load(&SparseRows::from_dense(lower.len(), &rows), &e, [&lower, &upper], &[]).unwrap();
        assert!((0..n).all(|i| lower[i] <= x[i] && x[i] <= upper[i]), "case {case}: {x:?}");
        for (found, (r, e)) in times(&x).iter().zip(residual.iter().zip(&e)) {
            assert!((e - found - r).abs() <= 1e-12, "case {case}");
        }
        let left = residual.iter().map(|r| r * r).sum::<f64>().sqrt();
        // The gradient: nothing within the bounds comes nearer.
        for i in 0..n {
            let gain: f64 = (0..m).map(|k| rows[k * n + i] * residual[k]).sum();
            assert!(gain <= 1e-12 || x[i] >= upper[i] - 1e-12, "case {case}: {gain}");
            assert!(gain >= -1e-12 || x[i] <= lower[i] + 1e-12, "case {case}: {gain}");
        }
        if possible {
            held += 1;
            assert!(left <= 1e-12, "case {case}: {left}");
        } else if left > 1e-8 {
            free += 1;
        }
    }
    assert!(held == 200 && free > 50, "{held} {free}");
    // Ten pushers of at most 0.1 against a load of 1.5 leave half of it; bounds that exclude each other are refused.
    let (_, left) =
        unbalanced_load(&SparseRows::from_dense(10, &[1.0; 10]), &[1.5], [&[-0.1; 10], &[0.1; 10]], &[])
            .unwrap();
    assert!((left[0] - 0.5).abs() < 1e-14, "{left:?}");
    assert!(unbalanced_load(&SparseRows::from_dense(1, &[1.0]), &[1.0], [&[1.0], &[0.0]], &[]).is_err());
    // Far bounds leave no rounding of their own, 1e-4 here: the balance holds to 1e-13 of the load.
    let far = [&[-1e12, -3e11, 0.0][..], &[1e12, 3e11, f64::INFINITY]];
    let rows = [0.3, -0.7, 0.1, 0.9, 0.2, -0.4];
    let (_, left) = unbalanced_load(&SparseRows::from_dense(3, &rows), &[1e-3, 2e-3], far, &[]).unwrap();
    assert!(left.iter().all(|r| r.abs() <= 1e-13 * 5f64.sqrt() * 1e-3), "{left:?}");
}

#[test]
fn the_nearest_balanced_numbers_are_the_solution_of_the_programme() {
    let mut random = Random::new(17);
    for case in 0..200 {
        let (n, m) = (3 + case % 20, 1 + case % 3);
        let target: Vec<f64> = (0..n).map(|_| random.number()).collect();
        let weights: Vec<f64> = (0..n).map(|_| 0.1 + (0.5 * (1.0 + random.number()))).collect();
        let rows: Vec<f64> = (0..n * m).map(|_| random.number()).collect();
        // Every other programme has bounds on both sides for some of its unknowns.
        let two = |i: usize| case % 2 == 1 && i % 2 == 1;
        let lower: Vec<f64> = (0..n).map(|i| if two(i) { -0.4 } else { 0.0 }).collect();
        let upper: Vec<f64> = (0..n).map(|i| if two(i) { 0.3 } else { f64::INFINITY }).collect();
        let inside: Vec<f64> = (0..n).map(|i| random.number().clamp(lower[i], upper[i])).collect();
        let e: Vec<f64> = (0..m).map(|k| (0..n).map(|i| rows[k * n + i] * inside[i]).sum()).collect();
        let found =
            nearest_balanced(&target, &weights, [&lower, &upper], &[], &SparseRows::from_dense(n, &rows), &e)
                .unwrap()
                .unwrap();
        let mut matrix = vec![0.0; n * n];
        (0..n).for_each(|i| matrix[i * n + i] = weights[i]);
        let linear: Vec<f64> = target.iter().zip(&weights).map(|(t, w)| -t * w).collect();
        let programme = Problem {
            n,
            matrix,
            linear,
            lower,
            upper,
            rows: SparseRows::from_dense(n, &rows),
            right_side: e,
        };
        let expected = solve_box(&programme.dense(), None, &QpSettings::default()).unwrap();
        assert_eq!(expected.status, QpStatus::Solved, "case {case}: {:?}", expected.kkt);
        for (a, b) in found.values.iter().zip(&expected.x) {
            assert!((a - b).abs() <= 1e-10, "case {case}: {a} {b}");
        }
    }
    // Nothing that is not negative adds up to a negative number.
    let row = SparseRows::from_dense(2, &[1.0, 1.0]);
    let all = [&[0.0; 2][..], &[f64::INFINITY; 2]];
    assert_eq!(nearest_balanced(&[1.0, 1.0], &[1.0; 2], all, &[], &row, &[-1.0]).unwrap(), None);
    // Bounds may exclude a number.
    let only = nearest_balanced(&[0.0; 2], &[1.0; 2], [&[0.0; 2], &[0.0, 5.0]], &[], &row, &[1.0]);
    assert_eq!(only.unwrap().unwrap().values, [0.0, 1.0]);
}

/// Multipliers along such a motion are rounding, and divided by the softness of the last centres they are large.
#[test]
fn a_motion_that_no_force_resists_does_not_unbalance_a_load() {
    let mut random = Random::new(2);
    let (m, n) = (24, 40);
    for case in 0..100 {
        // The last motion is a combination of the others.
        let mut dense: Vec<f64> = (0..(m - 1) * n).map(|_| random.number()).collect();
        let share: Vec<f64> = (1..m).map(|_| random.number()).collect();
        dense.extend(
            (0..n).map(|j| (0..m - 1).map(|k| share[k] * dense[k * n + j]).sum::<f64>()).collect::<Vec<_>>(),
        );
        let rows = SparseRows::from_dense(n, &dense);
        // Few forces, so that the load is at the edge of what they balance.
        let forces: Vec<f64> = (0..n).map(|_| (random.number() - 0.8).max(0.0)).collect();
        let loads = rows.times(&forces);
        let (found, left) =
            unbalanced_load(&rows, &loads, [&vec![0.0; n], &vec![f64::INFINITY; n]], &[]).unwrap();
        assert!(found.iter().all(|p| *p >= 0.0), "case {case}: {found:?}");
        let size = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(size(&left) <= 1e-7 * size(&loads), "case {case}: {:e} of {:e}", size(&left), size(&loads));
    }
}

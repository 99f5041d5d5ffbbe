//! Programmes with bounds on both sides and equality rows, against every possible set, and against each other.

use crate::support::Random;
use contact_qp::{
    BoxQp, MatrixView, Place, QpMethod, QpSettings, QpStatus, RowSelection, SparseRows,
    bounded_least_squares, box_residuals, nearest_balanced, nonnegative_least_squares, solve_box,
    unbalanced_load,
};

/// A random programme that has a solution: `e = G x` of some `x` within the bounds.
struct Programme {
    matrix: Vec<f64>,
    linear: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    rows: SparseRows,
    right_side: Vec<f64>,
}

/// A full matrix.
fn full(n: usize, values: &[f64]) -> MatrixView<'_> {
    MatrixView::Dense { n, values }
}

impl Programme {
    /// * `rank`: of the matrix; with fewer than `n` the rows must hold it.
    fn random(random: &mut Random, n: usize, m: usize, rank: usize) -> Self {
        let factor: Vec<f64> = (0..n * rank).map(|_| random.number()).collect();
        let entry = |i: usize, j: usize| -> f64 {
            (0..rank).map(|k| factor[k * n + i] * factor[k * n + j]).sum::<f64>()
        };
        let matrix = (0..n * n).map(|k| entry(k % n, k / n)).collect();
        let mut rows: Vec<f64> = (0..n * m).map(|_| random.number()).collect();
        if m > 2 {
            // Dependent rows.
            for i in 0..n {
                rows[2 * n + i] = rows[i] - 2.0 * rows[n + i];
            }
        }
        let inside: Vec<f64> = (0..n).map(|_| 0.5 + (0.5 * (1.0 + random.number()))).collect();
        let right_side = (0..m).map(|k| (0..n).map(|i| rows[k * n + i] * inside[i]).sum()).collect();
        let upper =
            (0..n).map(|_| if (0.5 * (1.0 + random.number())) < 0.5 { 2.0 } else { f64::INFINITY }).collect();
        let linear = (0..n).map(|_| 3.0 * random.number()).collect();
        let rows = SparseRows::from_dense(n, &rows);
        Self { matrix, linear, lower: vec![0.0; n], upper, rows, right_side }
    }

    fn qp(&self) -> BoxQp<'_> {
        BoxQp {
            matrix: full(self.linear.len(), &self.matrix),
            linear: &self.linear,
            lower: &self.lower,
            upper: &self.upper,
            rows: &self.rows,
            right_side: &self.right_side,
        }
    }

    fn objective(&self, x: &[f64]) -> f64 {
        let n = x.len();
        let product = |i: usize| (0..n).map(|j| self.matrix[j * n + i] * x[j]).sum::<f64>();
        (0..n).map(|i| x[i] * (0.5 * product(i) + self.linear[i])).sum()
    }
}

#[test]
fn random_programmes_satisfy_the_kkt_conditions_by_every_method() {
    let mut random = Random::new(11);
    let mut fallbacks = 0;
    for case in 0..600 {
        let n = 2 + case % 9;
        let m = case % 4;
        let rank = if case % 5 == 0 { n - m.min(2).min(n - 1) } else { n };
        let programme = Programme::random(&mut random, n, m, rank);
        let qp = programme.qp();
        let mut found = Vec::new();
        for method in [QpMethod::Auto, QpMethod::Clarabel] {
            let answer = solve_box(&qp, None, &QpSettings::default().with_method(method)).unwrap();
            assert_eq!(answer.status, QpStatus::Solved, "case {case}, {method:?}: {answer:?}");
            assert!(answer.kkt.max() <= 1e-12, "case {case}: {:?}", answer.kkt);
            let again = box_residuals(&qp, &answer.x, &answer.multipliers, &answer.row_multipliers);
            assert_eq!(again, answer.kkt);
            for i in 0..n {
                assert!((programme.lower[i]..=programme.upper[i]).contains(&answer.x[i]));
            }
            fallbacks += answer.clarabel_calls;
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
        let programme = Programme::random(&mut random, n, m, n);
        let qp = programme.qp();
        let answer = solve_box(&qp, None, &QpSettings::default()).unwrap();
        // Every set on which the signs are right has the same x.
        let mut right = 0;
        for code in 0..3usize.pow(n as u32) {
            let place = |i: usize| [Place::Lower, Place::Free, Place::Upper][code / 3usize.pow(i as u32) % 3];
            let places: Vec<Place> = (0..n).map(place).collect();
            let settings =
                QpSettings::default().with_max_active_set_steps(1).with_method(QpMethod::ActiveSet);
            if (0..n).any(|i| places[i] == Place::Upper && programme.upper[i].is_infinite()) {
                continue;
            }
            let found = solve_box(&qp, Some(&places), &settings).unwrap();
            if found.clarabel_calls == 0 {
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
fn a_single_feasible_point_is_solved_although_its_multipliers_are_not_unique() {
    let mut random = Random::new(23);
    for case in 0..200 {
        let (n, m) = (1 + case % 7, 1 + case % 3);
        let mut programme = Programme::random(&mut random, n, m, n);
        // Positive rows that add up to zero: only x = 0 is feasible.
        let mut rows = programme.rows.dense();
        rows[..n].iter_mut().for_each(|g| *g = g.abs() + 0.1);
        programme.rows = SparseRows::from_dense(n, &rows);
        programme.right_side.fill(0.0);
        let qp = programme.qp();
        let answer = solve_box(&qp, None, &QpSettings::default()).unwrap();
        assert_eq!(answer.status, QpStatus::Solved, "case {case}: {:?}", answer.kkt);
        assert_eq!(answer.x, vec![0.0; n]);
        assert!(answer.kkt.max() <= 1e-12 && answer.multipliers.iter().all(|y| *y >= 0.0), "case {case}");
    }
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
        for start in [Place::Lower, Place::Upper, Place::Free] {
            let answer = solve_box(&qp, Some(&[start, Place::Free]), &QpSettings::default()).unwrap();
            assert_eq!((answer.status, answer.clarabel_calls), (QpStatus::Solved, 0), "{sign} {start:?}");
            assert!((answer.multipliers[0] - sign * (1.0 - 2.7)).abs() < 1e-14, "{answer:?}");
        }
    }
}

#[test]
fn wrong_data_are_refused() {
    let (none, row) = (SparseRows::new(1), SparseRows::from_dense(1, &[1.0]));
    let matrix = full(1, &[1.0]);
    let good = BoxQp { matrix, linear: &[0.0], lower: &[0.0], upper: &[1.0], rows: &none, right_side: &[] };
    assert!(solve_box(&good, None, &QpSettings::default()).is_ok());
    for bad in [
        BoxQp { lower: &[2.0], ..good },
        BoxQp { lower: &[f64::NAN], ..good },
        BoxQp { lower: &[f64::INFINITY], upper: &[f64::INFINITY], ..good },
        BoxQp { matrix: full(1, &[1.0, 2.0]), ..good },
        BoxQp { linear: &[f64::NAN], ..good },
        BoxQp { rows: &row, ..good },
    ] {
        assert!(solve_box(&bad, None, &QpSettings::default()).is_err(), "{bad:?}");
    }
    assert!(solve_box(&good, Some(&[]), &QpSettings::default()).is_err());
}

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
    let (x, left) = unbalanced_load(&sparse, e, bounds).unwrap();
    assert!((0..n).all(|i| bounds[0][i] <= x[i] && x[i] <= bounds[1][i]), "case {case}: {x:?}");
    let products = sparse.times(&x);
    for k in 0..m {
        assert!((left[k] - residual[k]).abs() <= 1e-11, "case {case}: {left:?} {residual:?}");
        assert!((e[k] - products[k] - left[k]).abs() <= 1e-12, "case {case}");
    }
}

/// A wall of `courses` of `width` blocks, each on two of the course below: the forces on it along two directions and about its middle,
/// from two joints at each end of each face.
fn wall(courses: usize, width: usize) -> SparseRows {
    let mut columns: Vec<Vec<(usize, f64)>> = Vec::new();
    let block = |course: usize, k: usize| course * width + k;
    for course in 0..courses {
        for k in 0..width {
            for (below, at) in [(k, -0.5), (k, -0.1), (k + 1, 0.1), (k + 1, 0.5)] {
                let upper = 3 * block(course, k);
                let mut column = vec![(upper + 1, -1.0), (upper + 2, -at)];
                if course > 0 && below < width {
                    let lower = 3 * block(course - 1, below);
                    column.extend([(lower + 1, 1.0), (lower + 2, at + if below == k { 0.5 } else { -0.5 })]);
                }
                columns.push(column);
            }
            // The heads of neighbours.
            if k + 1 < width {
                columns.push(vec![(3 * block(course, k), 1.0), (3 * block(course, k + 1), -1.0)]);
            }
        }
    }
    let mut entries = SparseRows::new(3 * courses * width);
    columns.iter_mut().for_each(|column| {
        column.sort_by_key(|(row, _)| *row);
        entries.push(column.iter().copied());
    });
    entries.transposed()
}

#[test]
fn the_load_of_a_wall_is_balanced_and_what_is_not_is_the_motion() {
    for (courses, width) in [(3, 4), (12, 8)] {
        let rows = wall(courses, width);
        let (m, n) = (rows.len(), rows.columns());
        let bounds = [&vec![0.0; n][..], &vec![f64::INFINITY; n]];
        // Weight is carried.
        let weight: Vec<f64> = (0..m).map(|k| if k % 3 == 1 { -1.0 } else { 0.0 }).collect();
        let (x, left) = unbalanced_load(&rows, &weight, bounds).unwrap();
        assert!(x.iter().all(|x| *x >= 0.0) && left.iter().all(|r| r.abs() <= 1e-12), "{left:?}");
        // A pull on the last block of a course moves that block alone; one on its first block moves the course.
        for (pulled, moving) in [(width - 1, 1), (0, width)] {
            let mut load = weight.clone();
            load[3 * pulled] = 2.0;
            let (_, left) = unbalanced_load(&rows, &load, bounds).unwrap();
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
    assert_eq!(unbalanced_load(&none, &[], [&[0.0; 3], &[1.0; 3]]).unwrap(), (vec![0.0; 3], vec![]));
    assert!(RowSelection::new(&none, &[], &[], 1e-3).unwrap().rows.is_empty());
    let nearest = nearest_balanced(&[2.0, -1.0, 0.5], &[1.0; 3], [&[0.0; 3], &[1.0; 3]], &none, &[]).unwrap();
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
fn bounded_least_squares_end_if_two_unknowns_meet_their_bounds_at_once() {
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
    let (x, residual) = bounded_least_squares(&rows, &e, [&lower, &upper]).unwrap();
    for i in 0..6 {
        let gain: f64 = (0..6).map(|k| rows[k * 6 + i] * residual[k]).sum();
        assert!(gain <= 1e-12 || x[i] >= upper[i] - 1e-12, "{i}: {gain}");
        assert!(gain >= -1e-12 || x[i] <= lower[i] + 1e-12, "{i}: {gain}");
    }
}

#[test]
fn bounded_least_squares_return_the_unknowns_of_their_residual() {
    // Small whole numbers: unknowns meet both bounds, and come back from them.
    let mut random = Random::new(5);
    let mut whole = |most: i32| f64::from((random.number() * 1e6) as i32 % (most + 1));
    for case in 0..4000 {
        let rows: Vec<f64> = (0..9).map(|_| whole(3)).collect();
        let e: Vec<f64> = (0..3).map(|_| whole(7)).collect();
        let (lower, upper): (Vec<f64>, Vec<f64>) =
            (0..3).map(|_| (-whole(3).abs(), 1.0 + whole(2).abs())).unzip();
        let (x, residual) = bounded_least_squares(&rows, &e, [&lower, &upper]).unwrap();
        for k in 0..3 {
            let left = e[k] - (0..3).map(|i| rows[3 * k + i] * x[i]).sum::<f64>();
            assert!((left - residual[k]).abs() < 1e-11, "{case}: {rows:?} {e:?} {lower:?} {upper:?}");
        }
    }
}

#[test]
fn bounded_least_squares_are_the_projection_on_what_the_bounds_allow() {
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
        let (x, residual) = bounded_least_squares(&rows, &e, [&lower, &upper]).unwrap();
        same_residual(case, (m, n), &rows, &e, [&lower, &upper], &residual);
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
    let (_, left) = bounded_least_squares(&[1.0; 10], &[1.5], [&[-0.1; 10], &[0.1; 10]]).unwrap();
    assert!((left[0] - 0.5).abs() < 1e-14, "{left:?}");
    assert!(bounded_least_squares(&[1.0], &[1.0], [&[1.0], &[0.0]]).is_err());
    // Far bounds leave no rounding of their own.
    let far = [&[-1e12, -3e11, 0.0][..], &[1e12, 3e11, f64::INFINITY]];
    let rows = [0.3, -0.7, 0.1, 0.9, 0.2, -0.4];
    let (_, left) = bounded_least_squares(&rows, &[1e-3, 2e-3], far).unwrap();
    assert!(left.iter().all(|r| r.abs() < 1e-17), "{left:?}");
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
            nearest_balanced(&target, &weights, [&lower, &upper], &SparseRows::from_dense(n, &rows), &e)
                .unwrap()
                .unwrap();
        let mut matrix = vec![0.0; n * n];
        (0..n).for_each(|i| matrix[i * n + i] = weights[i]);
        let linear: Vec<f64> = target.iter().zip(&weights).map(|(t, w)| -t * w).collect();
        let programme =
            Programme { matrix, linear, lower, upper, rows: SparseRows::from_dense(n, &rows), right_side: e };
        let expected = solve_box(&programme.qp(), None, &QpSettings::default()).unwrap();
        assert_eq!(expected.status, QpStatus::Solved, "case {case}: {:?}", expected.kkt);
        for (a, b) in found.values.iter().zip(&expected.x) {
            assert!((a - b).abs() <= 1e-10, "case {case}: {a} {b}");
        }
    }
    // Nothing that is not negative adds up to a negative number.
    let row = SparseRows::from_dense(2, &[1.0, 1.0]);
    let all = [&[0.0; 2][..], &[f64::INFINITY; 2]];
    assert_eq!(nearest_balanced(&[1.0, 1.0], &[1.0; 2], all, &row, &[-1.0]).unwrap(), None);
    // Bounds may exclude a number.
    let only = nearest_balanced(&[0.0; 2], &[1.0; 2], [&[0.0; 2], &[0.0, 5.0]], &row, &[1.0]);
    assert_eq!(only.unwrap().unwrap().values, [0.0, 1.0]);
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
            (found.status, found.x.len(), found.clarabel_calls),
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

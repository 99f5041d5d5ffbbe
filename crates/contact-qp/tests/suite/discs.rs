//! Programmes with discs, judged by their optimality conditions, computed here.

use crate::support::Random as Numbers;
use contact_qp::{
    BoundState, BoxQp, Disc, DiscStart, MatrixView, QpError, QpPath, QpSettings, SparseRows,
    nearest_balanced, solve_discs, unbalanced_load,
};

/// Random forces of `nodes` points in contact with friction: a pressure and two components of friction each.
struct Random {
    matrix: Vec<f64>,
    linear: Vec<f64>,
    limits: Vec<f64>,
    rows: SparseRows,
    right_side: Vec<f64>,
}

impl Random {
    /// * `balanced`: rows that forces within the discs can satisfy; `deficient`: directions in which nothing moves.
    fn new(random: &mut impl FnMut() -> f64, nodes: usize, balanced: usize, deficient: usize) -> Self {
        let n = 3 * nodes;
        let rank = n - deficient;
        let columns: Vec<Vec<f64>> = (0..n).map(|_| (0..rank).map(|_| random() - 0.5).collect()).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let matrix = (0..n * n).map(|k| dot(&columns[k % n], &columns[k / n])).collect();
        let load: Vec<f64> = (0..rank).map(|_| 4.0 * random() - 2.0).collect();
        let linear = columns.iter().map(|column| dot(column, &load)).collect();
        let limits: Vec<f64> =
            (0..nodes).map(|k| if k % 7 == 3 { 0.0 } else { 0.05 + 2.0 * random() }).collect();
        let mut rows = SparseRows::new(n);
        for _ in 0..balanced {
            rows.push((0..n).map(|i| (i, random() - 0.5)).collect::<Vec<_>>());
        }
        let inside: Vec<f64> = (0..n)
            .map(|i| if i < nodes { random() } else { 0.6 * limits[i % nodes] * (random() - 0.5) })
            .collect();
        let right_side = rows.times(&inside);
        Self { matrix, linear, limits, rows, right_side }
    }

    fn nodes(&self) -> usize {
        self.limits.len()
    }

    fn discs(&self) -> Vec<Disc> {
        let nodes = self.nodes();
        (0..nodes).map(|k| Disc { unknowns: [nodes + k, 2 * nodes + k], radius: self.limits[k] }).collect()
    }

    fn bounds(&self) -> [Vec<f64>; 2] {
        let upper: Vec<f64> =
            [vec![f64::INFINITY; self.nodes()], self.limits.clone(), self.limits.clone()].concat();
        let lower = upper.iter().map(|u| if u.is_finite() { -u } else { 0.0 }).collect();
        [lower, upper]
    }

    /// Measures how far a point is from optimal, over the size of the data.
    fn violation(&self, x: &[f64], a: &[f64], y: &[f64]) -> f64 {
        let (n, nodes) = (x.len(), self.nodes());
        let pulled = self.rows.transposed_times(a);
        let gradient: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| self.matrix[j * n + i] * x[j]).sum::<f64>() + self.linear[i] - pulled[i])
            .collect();
        let mut worst: f64 = 0.0;
        for i in 0..n {
            worst = worst.max((gradient[i] - y[i]).abs());
        }
        for k in 0..nodes {
            assert!(x[k] >= 0.0 && y[k] >= 0.0);
            worst = worst.max(x[k] * y[k]);
            let (q, w) = ([x[nodes + k], x[2 * nodes + k]], [-y[nodes + k], -y[2 * nodes + k]]);
            let (size, slip, s) = (q[0].hypot(q[1]), w[0].hypot(w[1]), self.limits[k]);
            assert!(size <= s * (1.0 + 1e-15));
            worst = worst.max(s * slip - q[0] * w[0] - q[1] * w[1]);
        }
        for (found, wanted) in self.rows.times(x).iter().zip(&self.right_side) {
            worst = worst.max((found - wanted).abs());
        }
        worst
    }

    fn solve(
        &self,
        sparse: bool,
        start: Option<&DiscStart>,
        settings: &QpSettings,
    ) -> contact_qp::BoxSolution {
        let n = self.linear.len();
        let [lower, upper] = self.bounds();
        let starts: Vec<usize> = (0..=n).map(|j| j * (j + 1) / 2).collect();
        let places: Vec<usize> = (0..n).flat_map(|j| 0..=j).collect();
        let values: Vec<f64> =
            (0..n).flat_map(|j| (0..=j).map(move |i| (i, j))).map(|(i, j)| self.matrix[j * n + i]).collect();
        let matrix = match sparse {
            true => {
                MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &places, values: &values }
            }
            false => MatrixView::Dense { n, values: &self.matrix },
        };
        let qp = BoxQp {
            matrix,
            linear: &self.linear,
            lower: &lower,
            upper: &upper,
            rows: &self.rows,
            right_side: &self.right_side,
        };
        solve_discs(&qp, &self.discs(), start, settings).unwrap()
    }
}

#[test]
fn forces_in_discs_are_optimal() {
    let mut numbers = Numbers::new(5);
    let mut random = || 0.5 + 0.5 * numbers.number();
    let (mut on_circles, mut inside, mut alone) = (0, 0, 0);
    let settings = QpSettings::default();
    for k in 0..240 {
        let nodes = 2 + k % 17;
        let deficient = if k % 5 == 0 { nodes / 2 } else { 0 };
        let problem = Random::new(&mut random, nodes, k % 4, deficient);
        let found = problem.solve(k % 3 == 1, None, &settings);
        assert!(found.status.is_solved(), "{k} {}: {:?}", found.status, found.kkt);
        let worst = problem.violation(&found.x, &found.row_multipliers, &found.multipliers);
        assert!(worst < 1e-10, "{k}: {worst:e}");
        let circles = (0..nodes)
            .filter(|i| problem.limits[*i] > 0.0 && found.states[nodes + i] == BoundState::Upper)
            .count();
        on_circles += circles;
        inside += (0..nodes).filter(|i| found.states[nodes + i] == BoundState::Free).count();
        // Without Clarabel, from the programme without discs.
        let own = problem.solve(k % 3 == 1, None, &settings.clone().active_sets_first());
        assert!(own.status.is_solved(), "{k} {}: {:?}", own.status, own.kkt);
        assert!(problem.violation(&own.x, &own.row_multipliers, &own.multipliers) < 1e-10);
        alone += usize::from(own.path != QpPath::Clarabel && own.counts.clarabel_calls() == 0);
        // From its own solution, with other limits.
        let mut other = problem;
        other.limits.iter_mut().for_each(|s| *s *= 1.02);
        let start = DiscStart { states: found.states, x: found.x, multipliers: found.multipliers };
        let again = other.solve(k % 3 == 1, Some(&start), &settings);
        assert!(again.status.is_solved(), "{k}");
        assert!(other.violation(&again.x, &again.row_multipliers, &again.multipliers) < 1e-10);
        if deficient == 0 {
            assert!(again.path != QpPath::Clarabel || k % 4 > 0, "{k}");
        }
    }
    assert!(on_circles > 500 && inside > 300 && alone > 230, "{on_circles} {inside} {alone}");
}

#[test]
fn numbers_in_discs_and_in_balance_are_the_nearest() {
    let mut numbers = Numbers::new(9);
    let mut random = || 0.5 + 0.5 * numbers.number();
    for k in 0..200 {
        let nodes = 2 + k % 15;
        let problem = Random::new(&mut random, nodes, 1 + k % 4, 0);
        let n = 3 * nodes;
        let target: Vec<f64> = (0..n).map(|_| 3.0 * random() - 1.0).collect();
        let mut weights: Vec<f64> = (0..n).map(|_| 0.2 + random()).collect();
        for i in 0..nodes {
            weights[2 * nodes + i] = weights[nodes + i];
        }
        let [lower, upper] = problem.bounds();
        let (discs, rows, e) = (problem.discs(), &problem.rows, &problem.right_side);
        let found = nearest_balanced(&target, &weights, [&lower, &upper], &discs, rows, e).unwrap().unwrap();
        let x = &found.values;
        for (found, wanted) in rows.times(x).iter().zip(e) {
            assert!((found - wanted).abs() < 1e-12);
        }
        // The point of each bound or disc that is nearest to t + W⁻¹ Cᵀ a.
        let pulled = rows.transposed_times(&found.row_multipliers);
        let d: Vec<f64> = (0..n).map(|i| target[i] + pulled[i] / weights[i]).collect();
        for i in 0..nodes {
            assert!((x[i] - d[i].max(0.0)).abs() < 1e-10);
            let [u, v] = [nodes + i, 2 * nodes + i];
            let (length, s) = (d[u].hypot(d[v]), problem.limits[i]);
            let factor = if length > s { s / length } else { 1.0 };
            assert!(x[u].hypot(x[v]) <= s * (1.0 + 1e-15));
            assert!((x[u] - factor * d[u]).hypot(x[v] - factor * d[v]) < 1e-9, "{k}");
        }
    }
}

/// A point that presses with 1 and rubs with at most 0.5 is pushed aside along a diagonal.
#[test]
fn a_load_along_a_diagonal_is_held_by_a_disc_and_not_by_its_square() {
    let rows = SparseRows::from_dense(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let bounds: [&[f64]; 2] = [&[0.0, -0.5, -0.5], &[f64::INFINITY, 0.5, 0.5]];
    let discs = [Disc { unknowns: [1, 2], radius: 0.5 }];
    for (push, held) in [(0.35, true), (0.36, false), (0.49, false)] {
        let load = [1.0, push, push];
        let (forces, left) = unbalanced_load(&rows, &load, bounds, &discs).unwrap();
        let size = left.iter().map(|l| l * l).sum::<f64>().sqrt();
        let wanted = (push * 2f64.sqrt() - 0.5).max(0.0);
        assert!((size - wanted).abs() < 1e-7, "{size} {wanted}");
        assert_eq!(size == 0.0, held);
        assert!(forces[1].hypot(forces[2]) <= 0.5 + 1e-7);
        let (_, square) = unbalanced_load(&rows, &load, bounds, &[]).unwrap();
        assert!(square.iter().all(|l| l.abs() < 1e-12));
        let nearest = nearest_balanced(&[0.0; 3], &[1.0; 3], bounds, &discs, &rows, &load).unwrap();
        assert_eq!(nearest.is_some(), held);
    }
}

#[test]
fn discs_that_make_no_sense_are_refused() {
    let qp = BoxQp {
        matrix: MatrixView::Dense { n: 2, values: &[1.0, 0.0, 0.0, 1.0] },
        linear: &[-1.0, -1.0],
        lower: &[-1.0; 2],
        upper: &[1.0; 2],
        rows: &SparseRows::new(2),
        right_side: &[],
    };
    let solve = |discs: &[Disc]| solve_discs(&qp, discs, None, &QpSettings::default());
    let disc = |i: usize, j: usize, radius: f64| Disc { unknowns: [i, j], radius };
    assert!(matches!(solve(&[disc(0, 2, 1.0)]), Err(QpError::Disc { place: 2, unknowns: 2 })));
    assert!(matches!(solve(&[disc(0, 0, 1.0)]), Err(QpError::Disc { place: 0, .. })));
    assert!(matches!(solve(&[disc(0, 1, -1.0)]), Err(QpError::Bounds { .. })));
    assert!(matches!(solve(&[disc(0, 1, f64::NAN)]), Err(QpError::Bounds { .. })));
    let found = solve(&[disc(0, 1, 1.0)]).unwrap();
    assert!(found.x.iter().all(|x| (x - 0.5f64.sqrt()).abs() < 1e-15), "{:?}", found.x);
}

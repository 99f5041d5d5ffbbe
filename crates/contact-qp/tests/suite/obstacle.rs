//! A string pulled down onto a flat obstacle: the contact zone is known in closed form.
//!
//! ```text
//!   0 o-.                       .-o 1      −u'' = −p on (0, 1), u(0) = u(1) = 0, u ≥ −d.
//!        '-._               _.-'           Free part u = p x²/2 − p a x, touching at x = a with slope 0:
//!            '-------------'  u = −d       d = p a² / 2, so the contact zone is [a, 1 − a], a = √(2 d / p),
//!            a            1−a              and there the obstacle carries p per length.
//! ```

use crate::support::assert_exact;
use contact_qp::{
    BoundState, BoxQp, BoxSolution, MatrixView, QpMethod, QpPath, QpSettings, QpStatus, SparseRows, solve_box,
};

const LOAD: f64 = 2.0;
const DEPTH: f64 = 0.0637;

struct StringOverObstacle {
    column_starts: Vec<usize>,
    row_indices: Vec<usize>,
    values: Vec<f64>,
    linear: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    rows: SparseRows,
    spacing: f64,
}

impl StringOverObstacle {
    fn new(n: usize) -> Self {
        let spacing = 1.0 / (n + 1) as f64;
        let (mut column_starts, mut row_indices, mut values) = (vec![0], vec![], vec![]);
        for j in 0..n {
            if j > 0 {
                row_indices.push(j - 1);
                values.push(-1.0 / spacing);
            }
            row_indices.push(j);
            values.push(2.0 / spacing);
            column_starts.push(values.len());
        }
        let linear = vec![LOAD * spacing; n];
        let (lower, upper, rows) = (vec![-DEPTH; n], vec![f64::INFINITY; n], SparseRows::new(n));
        Self { column_starts, row_indices, values, linear, lower, upper, rows, spacing }
    }

    fn sparse(&self) -> BoxQp<'_> {
        let matrix = MatrixView::SparseUpper {
            n: self.linear.len(),
            column_starts: &self.column_starts,
            row_indices: &self.row_indices,
            values: &self.values,
        };
        BoxQp {
            matrix,
            linear: &self.linear,
            lower: &self.lower,
            upper: &self.upper,
            rows: &self.rows,
            right_side: &[],
        }
    }

    /// The same matrix in full.
    fn full(&self) -> Vec<f64> {
        let n = self.linear.len();
        let mut full = vec![0.0; n * n];
        for j in 0..n {
            for k in self.column_starts[j]..self.column_starts[j + 1] {
                full[j * n + self.row_indices[k]] = self.values[k];
                full[self.row_indices[k] * n + j] = self.values[k];
            }
        }
        full
    }

    fn assert_closed_form(&self, solution: &BoxSolution) {
        let active: Vec<usize> =
            (0..self.lower.len()).filter(|&k| solution.states[k] == BoundState::Lower).collect();
        let (first, last) = (active[0], active[active.len() - 1]);
        assert_eq!(active.len(), last - first + 1, "the contact zone is one interval");
        assert_eq!(first + last, self.lower.len() - 1, "and symmetric");
        let edge = (2.0 * DEPTH / LOAD).sqrt();
        let found = (first + 1) as f64 * self.spacing;
        assert!((found - edge).abs() <= self.spacing, "edge at {found}, expected {edge}");
        let pressure = LOAD * self.spacing;
        for k in first + 1..last {
            let r = solution.multipliers[k];
            assert!((r - pressure).abs() < 1e-11 * pressure, "r = {r:e}, expected {pressure:e}");
        }
        // The slope of the string at both ends carries the rest of the load: p a each.
        let total: f64 = solution.multipliers.iter().sum();
        assert!((total - LOAD * (1.0 - 2.0 * edge)).abs() < 3.0 * pressure);
    }
}

#[test]
fn the_contact_zone_is_that_of_the_closed_form() {
    let problem = StringOverObstacle::new(200);
    let full = problem.full();
    let dense = BoxQp { matrix: MatrixView::Dense { n: 200, values: &full }, ..problem.sparse() };
    for qp in [problem.sparse(), dense] {
        for method in [QpMethod::Clarabel, QpMethod::ActiveSet] {
            let solution = solve_box(&qp, None, &QpSettings::default().with_method(method)).unwrap();
            assert_eq!(solution.status, QpStatus::Solved, "{method:?}");
            assert_exact(&qp, &solution);
            assert!(solution.kkt.max() < 1e-15, "{:?}", solution.kkt);
            problem.assert_closed_form(&solution);
            println!("{method:?} {} iterations, {:?}", solution.iterations, solution.kkt);
        }
    }
}

#[test]
fn a_long_string_is_solved_in_the_sparse_form() {
    let problem = StringOverObstacle::new(20_000);
    let solution = solve_box(&problem.sparse(), None, &QpSettings::default()).unwrap();
    println!(
        "{} {} {} {:?}",
        solution.status, solution.iterations, solution.counts.polish_sets, solution.kkt
    );
    assert_eq!((solution.status, solution.path), (QpStatus::Solved, QpPath::Clarabel));
    assert_exact(&problem.sparse(), &solution);
    assert!(solution.kkt.max() < 1e-14, "{:?}", solution.kkt);
}

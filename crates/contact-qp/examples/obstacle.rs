//! A membrane over a flat obstacle, with contact zone and pressure known in closed form.
//!
//! `−Δu = f` on (−1, 1)² where `u > 0`, and `u ≥ 0`. With `ρ² = x² + y²`, `r² = 0.49`:
//! ```text
//! u = max(ρ² − r², 0)²      f = −8 (2ρ² − r²) outside the circle of radius r,  −8 r² (1 + r² − ρ²) inside
//! ```
//! so that the obstacle carries `p = −f` inside the circle, in total `8π r⁴ (1 + r²/2)`.
#![allow(clippy::print_stdout)]

use contact_qp::{BoundState, BoxQp, BoxSolution, MatrixView, QpError, QpSettings, SparseRows, solve_box};
use std::f64::consts::PI;

/// Radius² of the contact zone.
const R2: f64 = 0.49;

/// The five-point Laplacian on `m × m` inner nodes, and the exact solution there.
struct Membrane {
    column_starts: Vec<usize>,
    row_indices: Vec<usize>,
    values: Vec<f64>,
    linear: Vec<f64>,
    exact: Vec<f64>,
    spacing: f64,
}

fn exact(x: f64, y: f64) -> f64 {
    (x * x + y * y - R2).max(0.0).powi(2)
}

fn load(x: f64, y: f64) -> f64 {
    let rho2 = x * x + y * y;
    if rho2 > R2 { -8.0 * (2.0 * rho2 - R2) } else { -8.0 * R2 * (1.0 + R2 - rho2) }
}

/// Force on the obstacle in closed form.
fn exact_force() -> f64 {
    8.0 * PI * R2 * R2 * (1.0 + 0.5 * R2)
}

impl Membrane {
    fn new(m: usize) -> Self {
        let h = 2.0 / (m + 1) as f64;
        let at = |i: usize| -1.0 + i as f64 * h;
        let (mut column_starts, mut row_indices, mut values) = (vec![0], vec![], vec![]);
        let (mut linear, mut solution) = (vec![], vec![]);
        for (j, i) in (1..=m).flat_map(|j| (1..=m).map(move |i| (j, i))) {
            // The upper triangle of −h²Δ by columns: the nodes below and to the left, then the diagonal.
            let k = (j - 1) * m + i - 1;
            for (there, number) in [(j > 1, k.wrapping_sub(m)), (i > 1, k.wrapping_sub(1)), (true, k)] {
                if there {
                    row_indices.push(number);
                    values.push(if number == k { 4.0 } else { -1.0 });
                }
            }
            column_starts.push(values.len());
            // The values on the boundary move to the right-hand side.
            let around = [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)];
            let on_boundary = around.iter().filter(|(i, j)| [*i, *j].iter().any(|k| *k == 0 || *k == m + 1));
            let given: f64 = on_boundary.map(|(i, j)| exact(at(*i), at(*j))).sum();
            linear.push(-h * h * load(at(i), at(j)) - given);
            solution.push(exact(at(i), at(j)));
        }
        Self { column_starts, row_indices, values, linear, exact: solution, spacing: h }
    }

    fn solve(&self, load_factor: f64, warm_start: Option<&BoxSolution>) -> Result<BoxSolution, QpError> {
        let n = self.linear.len();
        let matrix = MatrixView::SparseUpper {
            n,
            column_starts: &self.column_starts,
            row_indices: &self.row_indices,
            values: &self.values,
        };
        let linear: Vec<f64> = self.linear.iter().map(|q| load_factor * q).collect();
        let (lower, upper, rows) = (vec![0.0; n], vec![f64::INFINITY; n], SparseRows::new(n));
        let qp =
            BoxQp { matrix, linear: &linear, lower: &lower, upper: &upper, rows: &rows, right_side: &[] };
        solve_box(&qp, warm_start.map(|s| s.states.as_slice()), &QpSettings::default())
    }

    fn largest_error(&self, solution: &BoxSolution) -> f64 {
        solution.x.iter().zip(&self.exact).map(|(x, u)| (x - u).abs()).fold(0.0, f64::max)
    }

    fn contact_area(&self, solution: &BoxSolution) -> f64 {
        let touching = solution.states.iter().filter(|place| **place == BoundState::Lower).count();
        touching as f64 * self.spacing * self.spacing
    }
}

fn main() -> Result<(), QpError> {
    println!(
        "   nodes  error       area ({:.4})  force ({:.4})  largest KKT residual",
        PI * R2,
        exact_force()
    );
    for m in [15, 31, 63] {
        let membrane = Membrane::new(m);
        let s = membrane.solve(1.0, None)?;
        let (error, area) = (membrane.largest_error(&s), membrane.contact_area(&s));
        let force: f64 = s.multipliers.iter().sum();
        println!("{:8}  {error:.3e}  {area:13.4}  {force:14.4}  {:.1e}", m * m, s.kkt.max());
        // All data doubled: the contact zone is the same; it is tried first and is correct.
        let twice = membrane.solve(2.0, Some(&s))?;
        println!("          with twice the data: {} by {}", twice.status, twice.path);
    }
    Ok(())
}

#[test]
fn error_area_and_force_tend_to_the_closed_form() {
    for m in [15, 31, 63] {
        let membrane = Membrane::new(m);
        let s = membrane.solve(1.0, None).unwrap();
        assert!(s.status.is_solved() && s.kkt.max() < 1e-12, "{:?}", s.kkt);
        let h = membrane.spacing;
        assert!((membrane.contact_area(&s) - PI * R2).abs() < 2.0 * PI * R2.sqrt() * h);
        let force: f64 = s.multipliers.iter().sum();
        assert!((force / exact_force() - 1.0).abs() < h, "{force}");
        let twice = membrane.solve(2.0, Some(&s)).unwrap();
        assert_eq!((twice.path, twice.counts.clarabel_calls()), (contact_qp::QpPath::WarmStart, 0));
        // Second order; the constant depends on the positions of the nodes relative to the circle.
        let error = membrane.largest_error(&s);
        assert!(error < 0.5 * h * h, "{error}");
    }
}

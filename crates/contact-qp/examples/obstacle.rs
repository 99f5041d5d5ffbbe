//! A string pulled down onto a parabolic obstacle; prints the contact zone and the KKT residuals.
#![allow(clippy::print_stdout)]

use contact_qp::{BoundQp, MatrixView, QpError, QpSettings, solve};

/// Number of nodes between the two ends, tension 1, length 1.
const NODES: usize = 199;

fn main() -> Result<(), QpError> {
    let spacing = 1.0 / (NODES + 1) as f64;
    let position = |i: usize| (i + 1) as f64 * spacing;

    // Upper triangle of the stiffness tridiag(−1, 2, −1) / h, by columns.
    let (mut column_starts, mut row_indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..NODES {
        if j > 0 {
            row_indices.push(j - 1);
            values.push(-1.0 / spacing);
        }
        row_indices.push(j);
        values.push(2.0 / spacing);
        column_starts.push(values.len());
    }
    let linear = vec![spacing; NODES];
    let bounded: Vec<usize> = (0..NODES).collect();
    let lower: Vec<f64> = (0..NODES).map(|i| -0.02 - 0.8 * (position(i) - 0.4).powi(2)).collect();

    let matrix = MatrixView::SparseUpper {
        n: NODES,
        column_starts: &column_starts,
        row_indices: &row_indices,
        values: &values,
    };
    let qp = BoundQp { matrix, linear: &linear, bounded: &bounded, lower: &lower };
    let solution = solve(&qp, None, &QpSettings::default())?;

    println!("{} by {} in {} iterations", solution.status, solution.path, solution.iterations);
    let touching: Vec<usize> = (0..NODES).filter(|&k| solution.active.is_active(k)).collect();
    if let (Some(&first), Some(&last)) = (touching.first(), touching.last()) {
        let (count, from, to) = (touching.len(), position(first), position(last));
        println!("contact at {count} nodes, from {from} to {to}");
    }
    println!("force on the obstacle {:.6} of a load of 1", solution.multipliers.iter().sum::<f64>());
    let kkt = solution.kkt;
    println!("stationarity    {:8.1e}", kkt.stationarity);
    println!("primal          {:8.1e}", kkt.primal);
    println!("dual            {:8.1e}", kkt.dual);
    println!("complementarity {:8.1e}", kkt.complementarity);

    // A little more load: the contact zone of before is tried first.
    let heavier: Vec<f64> = linear.iter().map(|value| 1.02 * value).collect();
    let again = solve(&BoundQp { linear: &heavier, ..qp }, Some(&solution.active), &QpSettings::default())?;
    println!("2 % more load: {} by {} in {} iterations", again.status, again.path, again.iterations);
    Ok(())
}

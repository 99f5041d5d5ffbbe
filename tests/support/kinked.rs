//! Blocks above and below a line that is straight for `x ≤ 0` and an arc for `x ≥ 0`, which begins at an angle.
//!
//! ```text
//!   ┌───────────┬───────────┐   y = 1
//!   │           │     Ω₁    │
//!    ‾‾‾‾flat‾‾‾│‾round‾─__      y = f(x)
//!   │           │     Ω₂    │
//!   └───────────┴───────────┘   y = −1, x from −1 to 1
//! ```

use crate::model::{Made, NodeId, TriMesh, Vector, block};
use crate::shapes::moved;

/// Radius of the arc.
pub const RADIUS: f64 = 3.0;

/// The parts of the line, as groups.
pub const PARTS: [&str; 2] = ["flat", "round"];

/// Computes the height of the line, which turns by an angle at x = 0, down if it is positive, and then down along the arc.
pub fn height(x: f64, angle: f64) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let x = x.max(0.0);
    let past = x + RADIUS * sine;
    // Without a difference of nearly equal numbers.
    -x * (x + 2.0 * RADIUS * sine) / ((RADIUS * RADIUS - past * past).sqrt() + RADIUS * cosine)
}

/// Makes the mesh of the body above or below the line, with its other sides as groups and the two parts of the line.
///
/// * `cells`: an even number along the line, and across.
///
/// # Errors
/// None, for angles of at most 25 degrees.
pub fn mesh(above: bool, angle: f64, cells: [usize; 2]) -> Made<TriMesh> {
    let mesh = block([-1.0, if above { 0.0 } else { -1.0 }], [2.0, 1.0], cells)?;
    let mesh = moved(&mesh, |p| p + (1.0 - p[1].abs()) * height(p[0], angle) * Vector::y())?;
    let line = if above { "bottom" } else { "top" };
    let mut groups: Vec<(String, Vec<[NodeId; 2]>)> =
        PARTS.iter().map(|part| ((*part).to_owned(), Vec::new())).collect();
    for (name, edges) in mesh.groups() {
        let ends = edges.iter().map(|edge| mesh.topology().facets()[*edge]);
        if name == line {
            for (edge, ends) in edges.iter().zip(ends) {
                groups[usize::from(mesh.facet_middle(*edge)[0] > 0.0)].1.push(ends);
            }
        } else {
            groups.push((name.clone(), ends.collect()));
        }
    }
    Ok(TriMesh::new(mesh.points().to_vec(), mesh.cells().to_vec(), groups)?)
}

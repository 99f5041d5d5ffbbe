//! Meshes of other shapes, made from structured blocks by moving their nodes or leaving out cells.

use fem_core::geometry::Vector;
use fem_core::mesh::generate::block;
use fem_core::mesh::{MeshError, TriMesh};

/// Moves the nodes of a mesh and keeps its triangles and groups.
///
/// # Errors
/// A motion that turns a triangle inside out.
pub fn moved(mesh: &TriMesh, motion: impl Fn(Vector) -> Vector) -> Result<TriMesh, MeshError> {
    let points = mesh.points().iter().map(|x| motion(*x)).collect();
    let edges = mesh.topology().edges();
    let groups = mesh
        .groups()
        .iter()
        .map(|(name, group)| (name.clone(), group.iter().map(|&e| edges[e as usize]).collect()))
        .collect();
    TriMesh::new(points, mesh.triangles().to_vec(), groups)
}

/// Turns a vector by an angle, radians.
pub fn turn(angle: f64, x: Vector) -> Vector {
    let (sin, cos) = angle.sin_cos();
    [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]]
}

/// Turns a mesh about the origin by an angle, radians; the angle 0 leaves every bit as it is.
///
/// # Errors
/// None.
pub fn turned(mesh: &TriMesh, angle: f64) -> Result<TriMesh, MeshError> {
    moved(mesh, |x| if angle == 0.0 { x } else { turn(angle, x) })
}

/// Meshes the L-shape `(−1,1)² ∖ [0,1)×(−1,0]` with `2n × 2n` cells less those of the missing quadrant. Its groups
/// are `faces`, the two sides of the re-entrant corner at the origin, and `outer`, the rest of the boundary.
///
/// # Errors
/// None for `n ≥ 1`.
pub fn l_shape(n: usize) -> Result<TriMesh, MeshError> {
    let whole = block([-1.0, -1.0], [2.0, 2.0], [2 * n, 2 * n])?;
    let missing = |t: &&[u32; 3]| {
        let [x, y] = [0, 1].map(|c| t.iter().map(|&i| whole.points()[i as usize][c]).sum::<f64>());
        !(x > 0.0 && y < 0.0)
    };
    let triangles: Vec<[u32; 3]> = whole.triangles().iter().filter(missing).copied().collect();
    let mut number = vec![u32::MAX; whole.points().len()];
    let mut points = Vec::new();
    let mut renumber = |i: u32| {
        let place = &mut number[i as usize];
        if *place == u32::MAX {
            *place = points.len() as u32;
            points.push(whole.points()[i as usize]);
        }
        *place
    };
    let triangles: Vec<[u32; 3]> = triangles.into_iter().map(|t| t.map(&mut renumber)).collect();
    let bare = TriMesh::new(points.clone(), triangles.clone(), Vec::new())?;
    let edge = |e: &u32| bare.topology().edges()[*e as usize];
    let outside = |e: &[u32; 2]| {
        let middle = [0, 1].map(|c| 0.5 * (points[e[0] as usize][c] + points[e[1] as usize][c]));
        middle[0].abs().max(middle[1].abs()) > 1.0 - 0.25 / n as f64
    };
    let (outer, faces) = bare.topology().boundary_edges().iter().map(edge).partition(outside);
    TriMesh::new(points.clone(), triangles, vec![("outer".into(), outer), ("faces".into(), faces)])
}

/// Evaluates a nodal field of a structured block at the nodes of the block with `factor` times as many cells in
/// each direction, which contains its mesh.
///
/// * `cells`: of the coarse block.
pub fn interpolate_block(field: &[Vector], cells: [usize; 2], factor: usize) -> Vec<Vector> {
    let node = |i: usize, j: usize| field[j * (cells[0] + 1) + i];
    let mut fine = Vec::new();
    for j in 0..=cells[1] * factor {
        for i in 0..=cells[0] * factor {
            let (ci, cj) = ((i / factor).min(cells[0] - 1), (j / factor).min(cells[1] - 1));
            let [s, t] = [i - ci * factor, j - cj * factor].map(|k| k as f64 / factor as f64);
            // The diagonal of a cell runs from its lower left to its upper right corner.
            let weights = if s >= t { [1.0 - s, s - t, t, 0.0] } else { [1.0 - t, 0.0, s, t - s] };
            let corners = [node(ci, cj), node(ci + 1, cj), node(ci + 1, cj + 1), node(ci, cj + 1)];
            fine.push([0, 1].map(|c| (0..4).map(|k| weights[k] * corners[k][c]).sum()));
        }
    }
    fine
}

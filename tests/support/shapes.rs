//! Meshes of other shapes, made from structured blocks by moving their nodes or leaving out cells.

use crate::model::{NodeId, TriMesh, Vector, block, sides};
use crate::random::Random;
use fem_core::geometry::angle_between;
use fem_core::mesh::MeshError;
use fem_core::mesh::id::FacetId;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Moves the nodes of a mesh and keeps its triangles and groups.
///
/// # Errors
/// A motion that turns a triangle inside out.
pub fn moved(mesh: &TriMesh, motion: impl Fn(Vector) -> Vector) -> Result<TriMesh, MeshError> {
    let points = mesh.points().iter().map(|x| motion(*x)).collect();
    TriMesh::new(points, mesh.cells().to_vec(), sides(mesh))
}

/// Turns a vector by an angle, radians.
pub fn turn(angle: f64, x: impl Into<Vector>) -> Vector {
    let x = x.into();
    let (sin, cos) = angle.sin_cos();
    Vector::new(cos * x[0] - sin * x[1], sin * x[0] + cos * x[1])
}

/// Turns a mesh about the origin by an angle, radians; the angle 0 leaves every bit as it is.
///
/// # Errors
/// None.
pub fn turned(mesh: &TriMesh, angle: f64) -> Result<TriMesh, MeshError> {
    moved(mesh, |x| if angle == 0.0 { x } else { turn(angle, x) })
}

/// Meshes the L-shape `(−1,1)² ∖ [0,1)×(−1,0]` with `2n × 2n` cells, without the cells of the missing quadrant. Its groups
/// are `faces`, the two sides of the re-entrant corner at the origin, and `outer`, the rest of the boundary.
///
/// # Errors
/// None for `n ≥ 1`.
pub fn l_shape(n: usize) -> Result<TriMesh, MeshError> {
    let whole = block([-1.0, -1.0], [2.0, 2.0], [2 * n, 2 * n])?;
    let missing = |t: &&[NodeId; 3]| {
        let [x, y] = [0, 1].map(|c| t.iter().map(|&i| whole.points()[i][c]).sum::<f64>());
        !(x > 0.0 && y < 0.0)
    };
    let triangles: Vec<[NodeId; 3]> = whole.cells().iter().filter(missing).copied().collect();
    let mut number = vec![NodeId::NONE; whole.points().len()];
    let mut points = Vec::new();
    let mut renumber = |i: NodeId| {
        let place = &mut number[i];
        if *place == NodeId::NONE {
            *place = NodeId::new(points.len());
            points.push(whole.points()[i]);
        }
        *place
    };
    let triangles: Vec<[NodeId; 3]> = triangles.into_iter().map(|t| t.map(&mut renumber)).collect();
    let bare = TriMesh::new(points.clone(), triangles.clone(), Vec::new())?;
    let edge = |e: &FacetId| bare.topology().facets()[*e];
    let outside = |e: &[NodeId; 2]| {
        let middle = [0, 1].map(|c| 0.5 * (points[e[0]][c] + points[e[1]][c]));
        middle[0].abs().max(middle[1].abs()) > 1.0 - 0.25 / n as f64
    };
    let (outer, faces) = bare.topology().boundary_facets().iter().map(edge).partition(outside);
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
            fine.push((0..4).map(|k| weights[k] * corners[k]).sum());
        }
    }
    fine
}

/// Meshes the rectangle `origin + [0, size_x] × [0, size_y]` without any structure but on its sides, which have the nodes and
/// names of [`block`]: rows of nodes shifted against each other and moved at random, joined so that no circle through the
/// corners of a triangle holds a node if cells are drawn as squares.
///
/// # Errors
/// See [`block`].
pub fn unstructured(
    origin: impl Into<Vector>,
    size: impl Into<Vector>,
    cells: [usize; 2],
    shake: f64,
    random: &mut Random,
) -> Result<TriMesh, MeshError> {
    let (origin, size) = (origin.into(), size.into());
    let [nx, ny] = cells.map(|n| n as f64);
    let squares = block([0.0; 2], [nx, ny], cells)?;
    let mut points = squares.points().to_vec();
    for x in &mut points {
        let inside = |c: usize, n: f64| x[c] > 0.5 && x[c] < n - 0.5;
        if inside(0, nx) && inside(1, ny) {
            let shift = if x[1] as usize % 2 == 1 { 0.25 } else { -0.25 };
            *x = Vector::new(x[0] + shift + shake * random.signed(), x[1] + shake * random.signed());
        }
    }
    let triangles = delaunay(&points, squares.cells().to_vec());
    let place = |x: &Vector| origin + Vector::new(size[0] * (x[0] / nx), size[1] * (x[1] / ny));
    TriMesh::new(points.iter().map(place).collect(), triangles, sides(&squares))
}

/// Exchanges diagonals of pairs of triangles until the angles opposite to each add up to at most 180 degrees.
fn delaunay(points: &[Vector], mut triangles: Vec<[NodeId; 3]>) -> Vec<[NodeId; 3]> {
    let angle = |apex: NodeId, a: NodeId, b: NodeId| {
        let [p, a, b] = [apex, a, b].map(|n| points[n]);
        angle_between(a - p, b - p)
    };
    loop {
        let mut seen: HashMap<[NodeId; 2], usize> = HashMap::new();
        let mut found = None;
        'search: for t in 0..triangles.len() {
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|m| triangles[t][(k + m) % 3]);
                let Some(other) = seen.insert([a.min(b), a.max(b)], t) else { continue };
                let apex = triangles[other].into_iter().find(|n| *n != a && *n != b).unwrap_or(a);
                if angle(c, a, b) + angle(apex, a, b) > PI + 1e-9 {
                    found = Some(([t, other], [[c, a, apex], [c, apex, b]]));
                    break 'search;
                }
            }
        }
        let Some((places, new)) = found else { return triangles };
        for (t, corners) in places.into_iter().zip(new) {
            triangles[t] = corners;
        }
    }
}

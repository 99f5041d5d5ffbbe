//! The field of a file on a mesh of a case.

use crate::space::ReportSpace;
use fem_core::geometry::norm;
use fem_core::mesh::Mesh;
use fem_core::mesh::cell_tree::{CellAt, CellTree};
use fem_core::mesh::id::NodeId;
use mesh_io::vtu::PointVectors;

/// Points closer than this fraction of the body's diagonal are the same.
const SAME: f64 = 1e-6;
/// A point between the nodes may be off by this fraction of the largest difference of displacement in its cell: numbers are written with
/// few digits. The deviation is part of the bound.
const LINEAR: f64 = 1e-4;
/// Rounding of displacements in single precision, over their size.
const SINGLE: f64 = 2e-7;

/// Values at the nodes of a mesh, and the cells in which a file has further points with other values.
pub(super) struct Matched<'a, S: ReportSpace> {
    pub(super) mesh: &'a Mesh<S>,
    /// At the nodes of the mesh, m.
    pub(super) field: Vec<S::Vector>,
    /// `∫ |∇d|²` over the mesh is at most this, with the difference `d` between the file's field and the one of the nodes, m².
    pub(super) spread: f64,
}

/// Why a file has no field on a mesh.
pub(super) enum Mismatch {
    /// A node of the mesh has no point, and the nearest one is so far away, m.
    Node { node: usize, nearest: f64 },
    /// A point, from 0, has another value than the field.
    Point(usize),
}

/// Finds the values at the nodes, and checks that all other points in the mesh have the values of that field; else another field than that
/// of the file would be certified. Points outside the mesh are left out.
pub(super) fn matched<'a, S: ReportSpace>(
    read: &PointVectors<S>,
    mesh: &'a Mesh<S>,
) -> Result<Matched<'a, S>, Mismatch> {
    let tree = CellTree::new(mesh);
    let width = SAME * mesh.diagonal();
    let around: Vec<Vec<CellAt<S>>> = read.points.iter().map(|point| tree.around(*point, width)).collect();
    let corners = |at: &CellAt<S>| mesh.cells()[at.cell];
    // The nearest point of each node.
    let mut taken: Vec<Option<(f64, usize)>> = vec![None; mesh.points().len()];
    let mut node_of: Vec<Option<NodeId>> = vec![None; around.len()];
    for (k, (point, cells)) in read.points.iter().zip(&around).enumerate() {
        let distance = |node: NodeId| norm(mesh.points()[node] - *point);
        let nodes = cells.iter().flat_map(corners).map(|node| (distance(node), node));
        let nearest = nodes.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((distance, node)) = nearest.filter(|(distance, _)| *distance <= width) else { continue };
        node_of[k] = Some(node);
        if taken[node.index()].is_none_or(|(least, _)| distance < least) {
            taken[node.index()] = Some((distance, k));
        }
    }
    let value = |(node, found): (usize, &Option<(f64, usize)>)| {
        found.map(|(_, k)| read.values[k]).ok_or_else(|| {
            let point = mesh.points()[node];
            let nearest = read.points.iter().map(|p| norm(*p - point)).fold(f64::INFINITY, f64::min);
            Mismatch::Node { node, nearest }
        })
    };
    let field = taken.iter().enumerate().map(value).collect::<Result<Vec<S::Vector>, Mismatch>>()?;
    let others = (0..around.len()).filter(|k| {
        node_of[*k].is_none_or(|node| taken[node.index()].is_none_or(|(_, nearest)| nearest != *k))
    });
    let mut off: Vec<Off> = Vec::new();
    for k in others {
        off.extend(offsets(mesh, &field, &around[k], read.values[k], node_of[k]).ok_or(Mismatch::Point(k))?);
    }
    Ok(Matched { mesh, field, spread: spread(&tree, off) })
}

/// The difference of a value between the nodes from the linear field of a cell, `by` in m.
struct Off {
    cell: usize,
    by: f64,
}

/// Compares a further point with the field in the cells around it; `None` if it is another field.
fn offsets<S: ReportSpace>(
    mesh: &Mesh<S>,
    field: &[S::Vector],
    around: &[CellAt<S>],
    value: S::Vector,
    node: Option<NodeId>,
) -> Option<Vec<Off>> {
    let mut found = Vec::with_capacity(around.len());
    for at in around {
        let nodes = mesh.cells()[at.cell];
        let corners = S::corners(|k| field[nodes[k]]);
        let linear = corners.into_iter().zip(at.weights).map(|(u, weight)| u * weight).sum();
        let by = norm(value - node.map_or(linear, |node| field[node]));
        let pairs = (0..=S::DIM).flat_map(|i| (0..i).map(move |j| (i, j)));
        let difference = pairs.map(|(i, j)| norm(corners[i] - corners[j])).fold(0.0, f64::max);
        let size = corners.into_iter().map(norm).fold(0.0, f64::max);
        if !(by <= LINEAR * difference + SINGLE * size) {
            return None;
        }
        found.push(Off { cell: at.cell, by });
    }
    Some(found)
}

/// Bounds `∫ |∇d|²`. In a cell with `k` points that are off by at most `D`, such as the middles of the sides of a quadratic element, `|∇d|` is at most
/// `2 (k + 1) D` over the smallest height.
fn spread<S: ReportSpace>(tree: &CellTree<'_, S>, mut off: Vec<Off>) -> f64 {
    off.sort_by_key(|off| off.cell);
    let in_cell = |all: &[Off]| {
        let cell = all[0].cell;
        let by = all.iter().fold(0.0, |most: f64, off| most.max(off.by));
        let height = tree.heights(cell).into_iter().fold(f64::INFINITY, f64::min);
        let slope = 2.0 * (all.len() + 1) as f64 * by / height;
        tree.mesh().measure(cell) * slope * slope
    };
    off.chunk_by(|a, b| a.cell == b.cell).map(in_cell).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::geometry::Vector;
    use fem_core::mesh::generate::block;

    #[test]
    fn points_that_are_no_nodes_must_have_the_values_of_the_field() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        let field: Vec<Vector> = mesh.points().iter().map(|x| Vector::new(x[0] * x[1], 1.0 - x[0])).collect();
        let mut read =
            PointVectors { points: mesh.points().to_vec(), values: field.clone(), ..PointVectors::default() };
        let found = matched(&read, &mesh).ok().unwrap();
        assert_eq!((found.field, found.spread), (field, 0.0));
        // In the middle of an edge the field is linear; outside of the body there may be anything.
        read.points.extend([Vector::new(0.25, 0.0), Vector::new(3.0, 0.5)]);
        read.values.extend([Vector::new(0.0, 0.75), Vector::new(9.0, 9.0)]);
        assert_eq!(matched(&read, &mesh).ok().unwrap().spread, 0.0);
        // A node twice with two values, as on a contact line of two bodies in one file; a node of a finer or a quadratic mesh.
        for (point, value) in [([2.0, 1.0], [2.0, 0.0]), ([0.25, 0.25], [0.07, 0.75])] {
            read.points.push(point.into());
            read.values.push(value.into());
            assert!(matches!(matched(&read, &mesh), Err(Mismatch::Point(17))));
            read.points.pop();
            read.values.pop();
        }
    }

    #[test]
    fn a_motion_of_the_whole_body_hides_no_other_field() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        for moved in [0.0, 1.0, 1e3] {
            let values: Vec<Vector> =
                mesh.points().iter().map(|x| Vector::new(moved, moved - 1e-3 * x[1])).collect();
            let mut read = PointVectors { points: mesh.points().to_vec(), values, ..PointVectors::default() };
            read.points.push(Vector::new(0.25, 0.5));
            read.values.push(Vector::new(moved, moved - 5e-4 + 1e-4 * moved.max(1.0)));
            assert!(matches!(matched(&read, &mesh), Err(Mismatch::Point(15))), "{moved}");
            // A deviation that can be rounding enters the bound.
            read.values[15] = Vector::new(moved, moved - 5e-4 + 1e-8);
            let spread = matched(&read, &mesh).ok().unwrap().spread;
            assert!(spread > (1e-8f64 / 0.5).powi(2) * 0.125, "{moved}: {spread}");
        }
    }
}

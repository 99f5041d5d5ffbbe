//! The recovered stress: a continuous picture of the equilibrated one, with one value per node and material.

use fem_core::body::Body;
use fem_core::geometry::Vector;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use fem_core::tensor::SymTensor2;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// A patch of fewer cells is extended by the cells at its corners: boundary nodes have few.
const FEWEST: usize = 5;
/// Below this determinant of the scaled equations the cells of a patch lie on a line, and their mean is taken.
const FLAT: f64 = 1e-3;
/// Smallest number of cells or nodes per parallel task.
const FEWEST_PER_TASK: usize = 1024;

/// A continuous stress, linear in each cell, with a value of its own for each material that meets at a node, since the stress jumps
/// there. The value at a node is taken from the linear function that best fits the equilibrated stress of the cells around it.
///
/// It is smoother than the stress of the cells, and usually closer to the exact one at a side, but it is not in equilibrium and bounds
/// nothing. Source: the patch recovery of Zienkiewicz and Zhu 1992, here of a stress in equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct RecoveredStress {
    /// The value of each node and material, sorted: node, place of the material in [`fem_core::material::Materials::list`], Pa.
    values: Vec<(NodeId, u32, SymTensor2)>,
}

/// The mean stress of a cell.
struct Cell {
    centre: Vector,
    area: f64,
    stress: SymTensor2,
}

impl RecoveredStress {
    /// Fits the mean stresses of the triangles.
    ///
    /// * `means`: one per triangle, such as [`crate::Estimate::mean_stress`], Pa.
    ///
    /// # Panics
    /// If there is not one for every triangle.
    pub fn new(body: &Body, means: &[SymTensor2]) -> Self {
        let mesh = body.mesh();
        let count = mesh.cells().len();
        assert!(means.len() == count, "{} stresses of {count} triangles", means.len());
        let cell = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            Cell { centre: (a + b + c) / 3.0, area: mesh.measure(t), stress: means[t] }
        };
        let cells: Vec<Cell> = (0..count).into_par_iter().with_min_len(FEWEST_PER_TASK).map(cell).collect();
        let material = |t: u32| body.materials().index(t as usize) as u32;
        let at_node = |n: usize| {
            let node = NodeId::new(n);
            let around = mesh.topology().cells_around(node);
            let mut materials: Vec<u32> = around.iter().map(|t| material(*t)).collect();
            materials.sort_unstable();
            materials.dedup();
            let (point, cells) = (mesh.points()[node], &cells);
            materials.into_iter().map(move |m| {
                let patch = patch(mesh, node, |t| material(t) == m);
                (node, m, fit(point, patch.iter().map(|t| &cells[*t as usize])))
            })
        };
        let nodes = (0..mesh.points().len()).into_par_iter().with_min_len(FEWEST_PER_TASK);
        Self { values: nodes.flat_map_iter(at_node).collect() }
    }

    /// Lists the values: node, place of the material in the body's list, stress in Pa.
    pub fn values(&self) -> impl Iterator<Item = (NodeId, usize, SymTensor2)> + '_ {
        self.values.iter().map(|(node, material, stress)| (*node, *material as usize, *stress))
    }

    /// Computes the von Mises stress of a value, Pa; `None` if the out-of-plane stress of the material is unknown.
    fn von_mises(body: &Body, material: usize, stress: SymTensor2) -> Option<f64> {
        body.materials().list().get(material)?.von_mises(stress)
    }

    /// Finds the largest von Mises stress, Pa, and its node; `None` if the out-of-plane stress of a material is unknown.
    pub fn largest_von_mises(&self, body: &Body) -> Option<(f64, NodeId)> {
        let mut largest = None;
        for (node, material, stress) in self.values() {
            let found = Self::von_mises(body, material, stress)?;
            if largest.is_none_or(|(most, _)| found > most) {
                largest = Some((found, node));
            }
        }
        largest
    }

    /// Chooses one value per node, with the place of its material: the value with the largest von Mises stress if several materials
    /// meet there.
    pub fn by_node(&self, body: &Body) -> Vec<(usize, SymTensor2)> {
        let mut chosen: Vec<(usize, SymTensor2)> = Vec::with_capacity(body.mesh().points().len());
        let size = |(m, s): (usize, SymTensor2)| Self::von_mises(body, m, s).unwrap_or(0.0);
        for (node, material, stress) in self.values() {
            match chosen.get_mut(node.index()) {
                None => chosen.push((material, stress)),
                Some(known) if size((material, stress)) > size(*known) => *known = (material, stress),
                Some(_) => {}
            }
        }
        chosen
    }
}

/// Lists the cells around a node, ascending: at least [`FEWEST`], if there are this many within two cells.
///
/// * `belongs`: whether a cell has the material.
fn patch(mesh: &TriMesh, node: NodeId, belongs: impl Fn(u32) -> bool) -> Vec<u32> {
    let around = |n: NodeId| mesh.topology().cells_around(n).iter().copied().filter(|t| belongs(*t));
    let mut patch: Vec<u32> = around(node).collect();
    if patch.len() < FEWEST {
        let corners = patch.iter().flat_map(|t| mesh.cells()[*t as usize]);
        patch = corners.flat_map(around).collect();
    }
    patch.sort_unstable();
    patch.dedup();
    patch
}

/// Computes the value at a point of the linear function that is nearest to the means of cells: least squares, weighted by areas.
fn fit<'a>(point: Vector, cells: impl ExactSizeIterator<Item = &'a Cell> + Clone) -> SymTensor2 {
    let area: f64 = cells.clone().map(|cell| cell.area).sum();
    let size = (area / cells.len() as f64).sqrt();
    let mut matrix = Matrix3::zeros();
    let mut sums = [Vector3::zeros(); 3];
    for cell in cells {
        let way = (cell.centre - point) / size;
        let basis = Vector3::new(1.0, way[0], way[1]);
        let weight = cell.area / area;
        matrix += weight * basis * basis.transpose();
        let SymTensor2 { xx, yy, xy } = cell.stress;
        for (sum, component) in sums.iter_mut().zip([xx, yy, xy]) {
            *sum += weight * component * basis;
        }
    }
    // The first row of the inverse, times the determinant.
    let first = matrix.column(1).cross(&matrix.column(2));
    let determinant = first.dot(&matrix.column(0));
    let [xx, yy, xy] =
        sums.map(|sum| if determinant > FLAT { first.dot(&sum) / determinant } else { sum[0] });
    SymTensor2::new(xx, yy, xy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_stress_is_fitted_exactly_and_cells_on_a_line_give_their_mean() {
        let exact = |p: Vector| SymTensor2::new(1.0 + p[0], p[0] - 2.0 * p[1], 0.5 * p[1]);
        let cell = |(x, y, area): (f64, f64, f64)| {
            let centre = Vector::new(x, y);
            Cell { centre, area, stress: exact(centre) }
        };
        let places = [(0.1, 0.2, 0.5), (1.1, 0.1, 0.4), (0.9, 1.2, 0.7), (0.2, 0.8, 0.6), (2.0, 0.4, 0.1)];
        let cells: Vec<Cell> = places.map(cell).into();
        let point = Vector::new(-0.3, 0.1);
        let found = fit(point, cells.iter());
        let off = found.minus(exact(point));
        assert!(off.xx.abs().max(off.yy.abs()).max(off.xy.abs()) < 1e-13, "{found:?}");
        let line: Vec<Cell> = [(0.0, 0.0, 1.0), (2.0, 0.0, 3.0)].map(cell).into();
        let mean = fit(point, line.iter());
        assert!((mean.xx - 2.5).abs() < 1e-15, "{mean:?}");
    }
}

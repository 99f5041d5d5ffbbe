//! The recovered stress: a continuous picture of the equilibrated one, with one value per node and material.

use crate::recovery::Recovery;
use fem_core::body::Body;
use fem_core::mesh::Mesh;
use fem_core::mesh::id::NodeId;
use fem_core::space::{Plane, Space};
use rayon::prelude::*;

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
pub struct RecoveredStress<S: Space = Plane> {
    /// The value of each node and material, sorted: node, place of the material in [`fem_core::material::Materials::list`], Pa.
    values: Vec<(NodeId, u32, S::Tensor)>,
}

/// The mean stress of a cell.
struct Cell<S: Space> {
    centre: S::Vector,
    measure: f64,
    stress: S::Components<f64>,
}

impl<S: Recovery> RecoveredStress<S> {
    /// Fits the mean stresses of the cells.
    ///
    /// * `means`: one per cell, such as [`crate::Estimate::mean_stress`], Pa.
    ///
    /// # Panics
    /// If there is not one for every cell.
    pub fn new(body: &Body<S>, means: &[S::Tensor]) -> Self {
        let mesh = body.mesh();
        let count = mesh.cells().len();
        assert!(means.len() == count, "{} stresses of {count} cells", means.len());
        let cell = |t: usize| {
            let corners = mesh.corners(t);
            let corners = corners.as_ref();
            let sum = corners[1..].iter().fold(corners[0], |sum, corner| sum + *corner);
            Cell { centre: sum / corners.len() as f64, measure: mesh.measure(t), stress: means[t].into() }
        };
        let cells: Vec<Cell<S>> =
            (0..count).into_par_iter().with_min_len(FEWEST_PER_TASK).map(cell).collect();
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
    pub fn values(&self) -> impl Iterator<Item = (NodeId, usize, S::Tensor)> + '_ {
        self.values.iter().map(|(node, material, stress)| (*node, *material as usize, *stress))
    }

    /// Returns the value at a node for a material by its place in the list, Pa; `None` if no cell of the material is there.
    pub fn at(&self, node: NodeId, material: usize) -> Option<S::Tensor> {
        let key = (node, material as u32);
        let place = self.values.binary_search_by_key(&key, |(node, material, _)| (*node, *material)).ok()?;
        Some(self.values[place].2)
    }

    /// Computes the von Mises stress of a value, Pa; `None` if the out-of-plane stress of the material is unknown.
    fn von_mises(body: &Body<S>, node: NodeId, material: usize, stress: S::Tensor) -> Option<f64> {
        let temperature = body.temperature().get(node.index()).copied().unwrap_or_default();
        S::von_mises(body.materials().list().get(material)?, stress, temperature)
    }

    /// Finds the largest von Mises stress, Pa, and its node; `None` if the out-of-plane stress of a material is unknown.
    pub fn largest_von_mises(&self, body: &Body<S>) -> Option<(f64, NodeId)> {
        let mut largest = None;
        for (node, material, stress) in self.values() {
            let found = Self::von_mises(body, node, material, stress)?;
            if largest.is_none_or(|(most, _)| found > most) {
                largest = Some((found, node));
            }
        }
        largest
    }

    /// Finds the smallest and the largest principal stress, Pa, and their nodes; in the plane those in the plane.
    pub fn extreme_principal(&self) -> Option<[(f64, NodeId); 2]> {
        let mut extreme: Option<[(f64, NodeId); 2]> = None;
        for (node, _, stress) in self.values() {
            let values = S::principal(stress);
            let [low, high] = [values[0], values[S::DIM - 1]];
            let [smallest, largest] = extreme.get_or_insert([(low, node), (high, node)]);
            if low < smallest.0 {
                *smallest = (low, node);
            }
            if high > largest.0 {
                *largest = (high, node);
            }
        }
        extreme
    }

    /// Chooses one value per node, with the place of its material: the value with the largest von Mises stress if several materials
    /// meet there.
    pub fn by_node(&self, body: &Body<S>) -> Vec<(usize, S::Tensor)> {
        let mut chosen: Vec<(usize, S::Tensor)> = Vec::with_capacity(body.mesh().points().len());
        let size = |n, (m, s): (usize, S::Tensor)| Self::von_mises(body, n, m, s).unwrap_or(0.0);
        for (node, material, stress) in self.values() {
            match chosen.get_mut(node.index()) {
                None => chosen.push((material, stress)),
                Some(known) if size(node, (material, stress)) > size(node, *known) => {
                    *known = (material, stress)
                }
                Some(_) => {}
            }
        }
        chosen
    }
}

/// Lists the cells around a node, ascending: more than twice as many as there are axes, if there are this many within two cells. Boundary
/// nodes have few.
///
/// * `belongs`: whether a cell has the material.
fn patch<S: Space>(mesh: &Mesh<S>, node: NodeId, belongs: impl Fn(u32) -> bool) -> Vec<u32> {
    let around = |n: NodeId| mesh.topology().cells_around(n).iter().copied().filter(|t| belongs(*t));
    let mut patch: Vec<u32> = around(node).collect();
    if patch.len() <= 2 * S::DIM {
        let corners = patch.iter().flat_map(|t| mesh.cells()[*t as usize]);
        patch = corners.flat_map(around).collect();
    }
    patch.sort_unstable();
    patch.dedup();
    patch
}

/// Computes the value at a point of the linear function that is nearest to the means of cells: least squares, weighted by measures.
fn fit<'a, S: Space>(
    point: S::Vector,
    cells: impl ExactSizeIterator<Item = &'a Cell<S>> + Clone,
) -> S::Tensor {
    let measure: f64 = cells.clone().map(|cell| cell.measure).sum();
    let size = (measure / cells.len() as f64).powf(1.0 / S::DIM as f64);
    let mut matrix = S::corners(|_| S::corners(|_| 0.0));
    let mut sums = S::components(|_| S::corners(|_| 0.0));
    for cell in cells {
        let way = (cell.centre - point) / size;
        let basis = S::corners(|k| if k == 0 { 1.0 } else { way[k - 1] });
        let weight = cell.measure / measure;
        for i in 0..=S::DIM {
            let weighted = weight * basis[i];
            for j in 0..=S::DIM {
                matrix[i][j] += weighted * basis[j];
            }
            for k in 0..S::COMPONENTS {
                sums[k][i] += weight * cell.stress[k] * basis[i];
            }
        }
    }
    // The first row of the inverse, times the determinant.
    let first = S::corners(|left_out| {
        let row = |j: usize| if j < left_out { j } else { j + 1 };
        let minor = S::axes(|i| S::axes(|j| matrix[row(j)][i + 1]));
        let determinant = product::<S>(&S::cofactors(&minor)[0], &minor[0]);
        if left_out % 2 == 0 { determinant } else { -determinant }
    });
    let along = |column: &S::Corners<f64>| {
        (1..=S::DIM).fold(first[0] * column[0], |sum, k| sum + first[k] * column[k])
    };
    let determinant = along(&matrix[0]);
    S::components(|k| if determinant > FLAT { along(&sums[k]) / determinant } else { sums[k][0] }).into()
}

/// Computes `Σ a_k b_k`.
fn product<S: Space>(a: &S::Axes<f64>, b: &S::Axes<f64>) -> f64 {
    (1..S::DIM).fold(a[0] * b[0], |sum, k| sum + a[k] * b[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::geometry::Vector;
    use fem_core::tensor::SymTensor2;

    #[test]
    fn a_linear_stress_is_fitted_exactly_and_cells_on_a_line_give_their_mean() {
        let exact = |p: Vector| SymTensor2::new(1.0 + p[0], p[0] - 2.0 * p[1], 0.5 * p[1]);
        let cell = |(x, y, measure): (f64, f64, f64)| -> Cell<Plane> {
            let centre = Vector::new(x, y);
            Cell { centre, measure, stress: exact(centre).into() }
        };
        let places = [(0.1, 0.2, 0.5), (1.1, 0.1, 0.4), (0.9, 1.2, 0.7), (0.2, 0.8, 0.6), (2.0, 0.4, 0.1)];
        let cells: Vec<Cell<Plane>> = places.map(cell).into();
        let point = Vector::new(-0.3, 0.1);
        let found = fit(point, cells.iter());
        let off = found.minus(exact(point));
        assert!(off.xx.abs().max(off.yy.abs()).max(off.xy.abs()) < 1e-13, "{found:?}");
        let line: Vec<Cell<Plane>> = [(0.0, 0.0, 1.0), (2.0, 0.0, 3.0)].map(cell).into();
        let mean = fit(point, line.iter());
        assert!((mean.xx - 2.5).abs() < 1e-15, "{mean:?}");
    }
}

//! Relaxation on edge stars: face moments of less energy, in exact equilibrium at every step.
//!
//! The stress is corrected by the bars and wrenches of [`super::potentials`]. A step is one of conjugate gradients in the moments,
//! preconditioned by one sweep over the edges and one back (block Gauss-Seidel): each edge takes the best wrench and bars
//! of its ring. Energy matrices and inverses are in single precision; moments are not, and those of one wrench go through all its faces, so
//! equilibrium is exact.

use super::cell::{CellMap, CellMoments, MOMENTS};
use super::clusters::clusters;
use super::potentials::{EdgeFace, EdgeSpace, FaceMoment, Potentials};
use super::rings::{Ring, Rings};
use crate::atomic_slots::AtomicSlots;
use crate::equilibrated::EquilibratedStress;
use crate::relaxation::{Relaxation, RelaxationReport, conjugate_gradients};
use fem_core::body::Body;
use fem_core::mesh::TetMesh;
use fem_core::mesh::id::FacetId;
use fem_core::parallel::{each_task, for_each_task};
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use nalgebra::{Vector3, Vector6};

/// Numbers of a face.
const FACE: usize = 9;

/// A pivot of the block of an edge below this fraction of its diagonal entry is round-off of single precision: the edge is left out.
const DEPENDENT: f64 = 1e-7;

/// Cells or edges handled by one task.
const CHUNK: usize = 256;

/// The edge stars of a body.
pub(crate) struct EdgeStars<'a> {
    potentials: Potentials<'a>,
    rings: Rings,
    /// The edges of clusters, by colour: clusters of one colour share no face.
    colours: Vec<Vec<Vec<u32>>>,
    /// The unit of energies of moments, 1/(Pa m): single precision has a small range.
    unit: f64,
    /// The energy matrix of each cell for the moments of its faces as the mesh stores them, row by row, over the unit.
    energy: Vec<[f32; MOMENTS * MOMENTS]>,
    /// The edges, each with the inverse of its block, row by row.
    edges: Vec<(EdgeSpace, Vec<f32>)>,
}

/// Counts the bytes of the edge stars of a mesh and of the vectors of a relaxation.
///
/// A cell has its energy matrix, an edge with `n` cells a block of `3 n + 6` unknowns in single precision; the conjugate gradients have six vectors of
/// the moments of all faces.
pub(crate) fn bytes(mesh: &TetMesh) -> usize {
    let (cells, faces) = (mesh.cells().len(), mesh.topology().facets().len());
    let block = |rings: usize| (3 * rings + 6) * (3 * rings + 6) * size_of::<f32>();
    // Euler's formula of a ball; each cell has six edges.
    let edges = (mesh.points().len() + faces).saturating_sub(cells + 1);
    let around = (6 * cells).div_ceil(edges.max(1));
    cells * MOMENTS * MOMENTS * size_of::<f32>()
        + edges * block(around + 1)
        + 6 * FACE * faces * size_of::<f64>()
}

/// The order of the face moments of a cell: for each corner of each face its place on the face, and the sign of the face.
pub(crate) fn order(body: &Body<Solid>, cell: usize) -> [([usize; 3], f64); 4] {
    let mesh = body.mesh();
    let (corners, topology) = (mesh.cells()[cell], mesh.topology());
    std::array::from_fn(|k| {
        let face = topology.cell_facets()[cell][k];
        let nodes = topology.facets()[face];
        let place = |corner: usize| nodes.iter().filter(|node| **node < corners[corner]).count();
        let sign = if topology.facet_cells()[face][0] as usize == cell { 1.0 } else { -1.0 };
        (Solid::facet(k).map(place), sign)
    })
}

fn get(slots: &AtomicSlots, face: FacetId) -> FaceMoment {
    let at = |j: usize| Vector3::from_fn(|axis, _| slots.get(FACE * face.index() + 3 * j + axis));
    [at(0), at(1), at(2)]
}

fn add(slots: &AtomicSlots, face: FacetId, change: &FaceMoment) {
    for (k, change) in change.iter().flat_map(|v| v.iter()).enumerate() {
        let slot = FACE * face.index() + k;
        slots.set(slot, slots.get(slot) + change);
    }
}

fn numbers(moment: &FaceMoment) -> [f64; FACE] {
    std::array::from_fn(|k| moment[k / 3][k % 3])
}

impl<'a> EdgeStars<'a> {
    /// Assembles and inverts the blocks of all edges.
    pub(crate) fn new(body: &'a Body<Solid>, stress: &EquilibratedStress<Solid>) -> Self {
        let rings = Rings::new(body.mesh());
        let potentials = Potentials::new(body, &stress.conditions);
        let cells = body.mesh().cells().len();
        let tension = SymTensor3 { xx: 1.0, ..SymTensor3::default() };
        let unit = body.material(0).complementary(tension, tension) / body.mesh().diagonal();
        let chunks = each_task(cells.div_ceil(CHUNK), |k| {
            let cells = k * CHUNK..cells.min((k + 1) * CHUNK);
            cells.map(|cell| energy(body, cell, unit)).collect::<Vec<_>>()
        });
        let energy: Vec<[f32; MOMENTS * MOMENTS]> = chunks.into_iter().flatten().collect();
        let edges = each_task(rings.len().div_ceil(CHUNK), |k| {
            let edges = k * CHUNK..rings.len().min((k + 1) * CHUNK);
            let edge = |k: usize| {
                let edge = potentials.edge(rings.get(k));
                let inverse = inverse(&potentials, (&edge, rings.get(k)), &energy);
                (edge, inverse)
            };
            edges.map(edge).collect::<Vec<_>>()
        });
        let colours = clusters(body.mesh(), &rings);
        Self { potentials, rings, colours, unit, energy, edges: edges.into_iter().flatten().collect() }
    }

    /// Relaxes a stress in place.
    pub(crate) fn relax(
        &self,
        stress: &mut EquilibratedStress<Solid>,
        relaxation: Relaxation,
    ) -> RelaxationReport {
        let body = self.potentials.body;
        let residual = residual(body, stress);
        let energies = [stress.distance_squared(body), stress.finite_element_energy(body)];
        residual.update(|_, r| r / self.unit);
        let z_residual = AtomicSlots::zeros(residual.len());
        let precondition = |r: &AtomicSlots, z: &AtomicSlots| self.precondition((r, &z_residual), z);
        let multiply = |p: &AtomicSlots, to: &AtomicSlots| self.multiply(p, to);
        let (x, report) =
            conjugate_gradients(relaxation, (&residual, self.unit), energies, [&precondition, &multiply]);
        if report.steps > 0 {
            for (face, moments) in stress.facet_moments.iter_mut().enumerate() {
                let change = get(&x, FacetId::new(face));
                moments.iter_mut().zip(change).for_each(|(moment, change)| *moment += change);
            }
        }
        report
    }

    /// Computes the moments `z` of one sweep over all edges and one back.
    ///
    /// * `left`: memory for the residual that is left.
    fn precondition(&self, (r, left): (&AtomicSlots, &AtomicSlots), z: &AtomicSlots) {
        left.update(|i, _| r.get(i));
        z.update(|_, _| 0.0);
        let sweep = |colour: &Vec<Vec<u32>>, back: bool| {
            for_each_task(colour.len(), &|k| {
                let edges = colour[k].iter();
                if back {
                    edges.rev().for_each(|edge| self.improve(*edge as usize, left, z));
                } else {
                    edges.for_each(|edge| self.improve(*edge as usize, left, z));
                }
            });
        };
        self.colours.iter().for_each(|colour| sweep(colour, false));
        self.colours.iter().rev().for_each(|colour| sweep(colour, true));
    }

    /// Adds the best wrench and bars of an edge to `z`, and takes their part from the residual.
    fn improve(&self, number: usize, left: &AtomicSlots, z: &AtomicSlots) {
        let ring = self.rings.get(number);
        let (edge, inverse) = &self.edges[number];
        if inverse.is_empty() {
            return;
        }
        let products = products(&self.potentials, edge, left);
        let amount = |row: &[f32]| row.iter().zip(&products).map(|(c, g)| f64::from(*c) * g).sum();
        let amounts: Vec<f64> = inverse.chunks_exact(products.len()).map(amount).collect();
        let wrench = edge.wrench(&amounts);
        let mut first = edge.wrenches;
        let changes: Vec<FaceMoment> = edge
            .faces
            .iter()
            .map(|face| {
                let bars = &amounts[first..first + face.bars];
                first += face.bars;
                let change = self.potentials.moments(edge, face, &wrench, bars);
                add(z, face.face, &change);
                change
            })
            .collect();
        let facets = self.potentials.body.mesh().topology().cell_facets();
        for around in ring.cells {
            let matrix = &self.energy[around.cell as usize];
            let mut sums = [0f32; MOMENTS];
            for (local, place) in around.faces.iter().zip(around.places) {
                for (k, amount) in numbers(&changes[place as usize]).into_iter().enumerate() {
                    let row = &matrix[(FACE * usize::from(*local) + k) * MOMENTS..][..MOMENTS];
                    let amount = amount as f32;
                    sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum -= amount * entry);
                }
            }
            for (face, sums) in facets[around.cell as usize].iter().zip(sums.chunks_exact(FACE)) {
                for (k, sum) in sums.iter().enumerate() {
                    let slot = FACE * face.index() + k;
                    left.set(slot, left.get(slot) + f64::from(*sum));
                }
            }
        }
    }

    /// Computes `H p`.
    fn multiply(&self, p: &AtomicSlots, to: &AtomicSlots) {
        let mesh = self.potentials.body.mesh();
        let topology = mesh.topology();
        let cells = mesh.cells().len();
        let of_cells = AtomicSlots::zeros(MOMENTS * cells);
        for_each_task(cells.div_ceil(CHUNK), &|k| {
            for cell in k * CHUNK..cells.min((k + 1) * CHUNK) {
                let mut sums = [0.0; MOMENTS];
                let matrix = &self.energy[cell];
                for (local, face) in topology.cell_facets()[cell].iter().enumerate() {
                    for (k, amount) in numbers(&get(p, *face)).into_iter().enumerate() {
                        let row = &matrix[(FACE * local + k) * MOMENTS..][..MOMENTS];
                        sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum += amount * f64::from(*entry));
                    }
                }
                sums.iter().enumerate().for_each(|(i, sum)| of_cells.set(MOMENTS * cell + i, *sum));
            }
        });
        to.update(|i, _| {
            let face = FacetId::new(i / FACE);
            let around = topology.facet_cells()[face].into_iter().filter(|cell| (*cell as usize) < cells);
            let part = |cell: u32| {
                let local = topology.facet_in(cell as usize, face);
                of_cells.get(MOMENTS * cell as usize + FACE * local + i % FACE)
            };
            around.map(part).sum()
        });
    }
}

/// Computes the products of a residual with the unit wrenches and bars of an edge.
fn products(potentials: &Potentials<'_>, edge: &EdgeSpace, residual: &AtomicSlots) -> Vec<f64> {
    let wrenches = edge.wrenches;
    let mut products = vec![0.0; wrenches + edge.faces.iter().map(|face| face.bars).sum::<usize>()];
    let mut wrench = Vector6::zeros();
    let mut first = wrenches;
    for face in &edge.faces {
        let bars = &mut products[first..first + face.bars];
        first += face.bars;
        potentials.products(edge, face, &get(residual, face.face), (&mut wrench, bars));
    }
    edge.components(&wrench, &mut products[..wrenches]);
    products
}

/// The energy matrix of a cell for the moments of its faces as the mesh stores them.
fn energy(body: &Body<Solid>, cell: usize, unit: f64) -> [f32; MOMENTS * MOMENTS] {
    let mut own = [0f32; MOMENTS * MOMENTS];
    let map = CellMap::new(body.mesh().corners(cell));
    map.energy(|stress| body.material(cell).strain(stress), unit, &mut own);
    let order = order(body, cell);
    let place = |k: usize| {
        let (places, sign) = order[k / FACE];
        (FACE * (k / FACE) + 3 * places[k % FACE / 3] + k % 3, sign as f32)
    };
    let places: [(usize, f32); MOMENTS] = std::array::from_fn(place);
    let mut stored = [0f32; MOMENTS * MOMENTS];
    for (row, (i, first)) in own.chunks_exact(MOMENTS).zip(places) {
        for (entry, (j, second)) in row.iter().zip(places) {
            stored[i * MOMENTS + j] = first * second * entry;
        }
    }
    stored
}

/// The moments of one unknown on a face of a ring.
type Column = (usize, [f64; FACE]);

/// Computes the moments of unit wrenches and bars on each face of a ring, and the number of unknowns.
fn columns(potentials: &Potentials<'_>, edge: &EdgeSpace) -> (Vec<Vec<Column>>, usize) {
    let unit = |k: usize, size: usize| (0..size).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
    let wrenches: Vec<Vector6<f64>> =
        (0..edge.wrenches).map(|k| edge.wrench(&unit(k, edge.wrenches))).collect();
    let mut size = edge.wrenches;
    let of_face = |face: &EdgeFace| {
        let of_wrench = |w: &Vector6<f64>| numbers(&potentials.moments(edge, face, w, &[]));
        let of_bar =
            |k: usize| numbers(&potentials.moments(edge, face, &Vector6::zeros(), &unit(k, face.bars)));
        let first = size;
        size += face.bars;
        let bars = (0..face.bars).map(|k| (first + k, of_bar(k)));
        wrenches.iter().map(of_wrench).enumerate().chain(bars).collect()
    };
    (edge.faces.iter().map(of_face).collect(), size)
}

/// Computes the inverse of the block `Bᵀ H B` of an edge, row by row.
fn inverse(
    potentials: &Potentials<'_>,
    (edge, ring): (&EdgeSpace, Ring<'_>),
    energy: &[[f32; MOMENTS * MOMENTS]],
) -> Vec<f32> {
    let (columns, size) = columns(potentials, edge);
    let mut block = vec![0.0; size * size];
    for around in ring.cells {
        let matrix = &energy[around.cell as usize];
        let sides = around.faces.into_iter().zip(around.places);
        for (column, other) in sides.clone() {
            // H B of one face on both, by rows of H.
            let rows: [_; FACE] =
                std::array::from_fn(|k| &matrix[(FACE * usize::from(column) + k) * MOMENTS..][..MOMENTS]);
            for (j, right) in &columns[other as usize] {
                let mut image = [0.0; MOMENTS];
                for (row, amount) in rows.iter().zip(right) {
                    image.iter_mut().zip(*row).for_each(|(sum, h)| *sum += amount * f64::from(*h));
                }
                for (row, place) in sides.clone() {
                    let image = &image[FACE * usize::from(row)..][..FACE];
                    for (i, left) in columns[place as usize].iter().filter(|(i, _)| i <= j) {
                        let product: f64 = left.iter().zip(image).map(|(l, m)| l * m).sum();
                        block[i * size + j] += product;
                    }
                }
            }
        }
    }
    for (i, j) in (0..size).flat_map(|i| (0..i).map(move |j| (i, j))) {
        block[i * size + j] = block[j * size + i];
    }
    if !invert(&mut block, size) {
        return Vec::new();
    }
    block.iter().map(|entry| *entry as f32).collect()
}

/// Inverts a symmetric positive definite matrix in place (Gauss-Jordan); false if a pivot is round-off.
fn invert(matrix: &mut [f64], n: usize) -> bool {
    let floors: Vec<f64> = (0..n).map(|k| DEPENDENT * matrix[k * (n + 1)]).collect();
    for (k, floor) in floors.into_iter().enumerate() {
        let pivot = matrix[k * (n + 1)];
        if !(pivot > floor) {
            return false;
        }
        let mut row: Vec<f64> = matrix[k * n..][..n].iter().map(|entry| entry / pivot).collect();
        row[k] = 1.0 / pivot;
        for (i, other) in matrix.chunks_exact_mut(n).enumerate() {
            if i == k {
                continue;
            }
            let factor = other[k];
            other[k] = 0.0;
            other.iter_mut().zip(&row).for_each(|(entry, r)| *entry -= factor * r);
        }
        matrix[k * n..][..n].copy_from_slice(&row);
    }
    true
}

/// Computes the negative gradient of half the energy by the face moments.
fn residual(body: &Body<Solid>, stress: &EquilibratedStress<Solid>) -> AtomicSlots {
    let mesh = body.mesh();
    let topology = mesh.topology();
    let residual = AtomicSlots::zeros(FACE * topology.facets().len());
    for cell in 0..mesh.cells().len() {
        let work = gradient(body, stress, cell);
        for (k, (places, sign)) in order(body, cell).into_iter().enumerate() {
            let mut change = [Vector3::zeros(); 3];
            places.iter().zip(work[k]).for_each(|(place, w)| change[*place] -= sign * w);
            add(&residual, topology.cell_facets()[cell][k], &change);
        }
    }
    residual
}

/// The derivatives of `½ ‖τ − σ̂‖²` in a cell by its moments.
fn gradient(body: &Body<Solid>, stress: &EquilibratedStress<Solid>, cell: usize) -> CellMoments {
    let (at, constant) = (stress.cell(body, cell), stress.finite_element[cell]);
    let strains = at.map(|part| part.map(|at| body.material(cell).strain(at.minus(constant))));
    CellMap::new(body.mesh().corners(cell)).work(&strains)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_one_and_a_singular_one_has_none() {
        let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0];
        let mut inverse = matrix;
        assert!(invert(&mut inverse, 3));
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let product: f64 = (0..3).map(|k| matrix[3 * i + k] * inverse[3 * k + j]).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j} {product}");
        }
        assert!(!invert(&mut [1.0, 2.0, 2.0, 4.0], 2));
    }
}

//! Relaxation on edge stars: face moments of less energy, in exact equilibrium at every step.
//!
//! The stress is corrected by the bars and wrenches of [`super::potentials`]. A step is one of conjugate gradients in the coordinates of the faces,
//! preconditioned by one sweep over the edges and one back (block Gauss-Seidel): each edge takes the best wrench and bars
//! of its ring. Energy matrices, inverses and what a sweep leaves of the residual are in single precision; coordinates are not, and those of one
//! wrench go through all its faces, so equilibrium is exact.

use super::blocks::Blocks;
use super::cell::{CellMap, CellMoments, FACE, order};
use super::clusters::clusters;
use super::coefficients::Coefficients;
use super::energy::EnergyMatrix;
use super::potentials::{FaceSpaces, rims};
use super::rings::Rings;
use super::stars::{Cluster, Matrices};
use super::sweep::Sweep;
use super::with_offset;
use crate::atomic_slots::AtomicSlots;
use crate::equilibrated::EquilibratedStress;
use crate::recovery::StarMemory;
use crate::relaxation::{Relaxation, RelaxationReport, conjugate_gradients};
use fem_core::body::{Body, FacetCondition};
use fem_core::mesh::TetMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::norm::sum_over_cells;
use fem_core::parallel::{each_task, for_each_task};
use fem_core::space::Solid;
use fem_core::tensor::SymTensor3;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::collections::HashSet;
use std::ops::Range;

/// Cells, faces or edges handled by one task.
const CHUNK: usize = 256;

/// The steps have lost their way in round-off if the energy found is off the promised one by this fraction of the one before: they begin again, from the best
/// stress along their sum, if that has less than [`RESTARTED`] times the energy.
const DRIFT: f64 = 1e-3;
const RESTARTED: f64 = 0.99;

/// The edge stars of a body.
pub struct EdgeStars<'a> {
    coefficients: Coefficients<'a>,
    /// See [`rims`].
    rims: HashSet<[NodeId; 2]>,
    clusters: Vec<Cluster>,
    /// The blocks of each; empty if they are computed again.
    blocks: Vec<Blocks>,
    /// Clusters of one colour share no face.
    colours: Vec<Vec<u32>>,
}

/// Counts the bytes of the edge stars of a mesh and of the vectors of a relaxation.
///
/// If coefficients are stored, a cell has its energy matrix, an edge with `n` cells a block of `3 n + 6` unknowns in single precision; the conjugate gradients have seven
/// vectors of the coordinates of all faces.
pub(crate) fn bytes(mesh: &TetMesh, stored: bool) -> usize {
    /// Of a face and of a cell of a ring.
    const RING: usize = 56;
    let (cells, faces) = (mesh.cells().len(), mesh.topology().facets().len());
    let block = |rings: usize| (3 * rings + 6).next_multiple_of(8) * (3 * rings + 6) * size_of::<f32>();
    // Euler's formula of a ball; each cell has six edges.
    let edges = (mesh.points().len() + faces).saturating_sub(cells + 1);
    let around = (6 * cells).div_ceil(edges.max(1));
    let matrix = if stored { size_of::<EnergyMatrix>() } else { 0 };
    cells * (matrix + 6 * RING)
        + if stored { edges * block(around + 1) } else { 0 }
        + faces * 7 * FACE * size_of::<f64>()
}

impl<'a> EdgeStars<'a> {
    /// Assembles and inverts the blocks of all edges, if they are stored.
    ///
    /// * `memory`: of the coefficients.
    pub(crate) fn new(
        body: &'a Body<Solid>,
        conditions: &[FacetCondition<Solid>],
        memory: StarMemory<EdgeStars<'_>>,
    ) -> Self {
        let mesh = body.mesh();
        let tension = SymTensor3 { xx: 1.0, ..SymTensor3::default() };
        let spaces = FaceSpaces::new(body, conditions);
        let length = spaces.length;
        let unit = body.material(0).complementary(tension, tension) / length;
        let memory = memory.map(|used| used.coefficients);
        let coefficients = Coefficients::new(spaces, unit, memory);
        let rims = rims(body);
        let rings = Rings::new(mesh);
        let (edges, colours) = clusters(mesh, &rings);
        let clusters = each_task(edges.len(), |k| Cluster::new(mesh, &rings, &edges[k], length));
        drop(rings);
        let stored = if coefficients.are_stored() { clusters.len() } else { 0 };
        let blocks = each_task(stored, |k| coefficients.blocks(&clusters[k], &rims, Blocks::default()));
        Self { coefficients, rims, clusters, blocks, colours }
    }

    /// Prepares the stars for other conditions: only what is near a face whose reactions have other directions is computed again.
    pub(crate) fn restate(&mut self, conditions: &[FacetCondition<Solid>]) {
        let Self { coefficients, rims, clusters, blocks, .. } = self;
        let changed = coefficients.spaces.restate(conditions);
        coefficients.renew(&changed);
        let near = |cluster: &Cluster| cluster.cells().iter().any(|cell| changed.binary_search(cell).is_ok());
        let all = blocks.par_iter_mut().zip(&*clusters).filter(|(_, cluster)| near(cluster));
        all.for_each(|(blocks, cluster)| {
            *blocks = coefficients.blocks(cluster, rims, std::mem::take(blocks));
        });
    }

    /// Relaxes a stress in place.
    pub(crate) fn relax(
        &self,
        stress: &mut EquilibratedStress<Solid>,
        relaxation: Relaxation,
    ) -> RelaxationReport {
        let of_elements = stress.finite_element_energy(self.body());
        let second = AtomicSlots::zeros(FACE * self.faces());
        let mut report = RelaxationReport::unrelaxed(stress.distance_squared(self.body()));
        loop {
            let residual = self.residual(stress, &second);
            let energies = [report.energy(), of_elements];
            let rest = relaxation.at_most(relaxation.max_steps() - report.steps);
            let operator = (residual, self.coefficients.unit);
            let (x, part) = conjugate_gradients(rest, operator, energies, &|r, z, product| {
                self.precondition((r, product), z);
                self.multiply(z, (product, &second));
            });
            if part.steps == 0 {
                report.stationary = part.stationary;
                return report;
            }
            self.shift(stress, &x, 1.0);
            let [before, promised, found] =
                [report.energy(), part.energy(), stress.distance_squared(self.body())];
            report.steps += part.steps;
            report.energy_history.extend(&part.energy_history[1..]);
            report.stationary = part.stationary;
            if (found - promised).abs() <= DRIFT * before {
                return report;
            }
            // The energy along x is a parabola, of which the middle is a third value.
            self.shift(stress, &x, -0.5);
            let curvature = 2.0 * (before + found - 2.0 * stress.distance_squared(self.body()));
            let best = (0.5 * (before - found + curvature) / curvature).clamp(0.0, 1.0);
            self.shift(stress, &x, if best.is_finite() { best - 0.5 } else { -0.5 });
            let energy = stress.distance_squared(self.body());
            // What round-off promised was not gained.
            report.energy_history.iter_mut().for_each(|promised| *promised = promised.max(energy));
            if report.steps >= relaxation.max_steps() || !(energy < RESTARTED * before) {
                return report;
            }
        }
    }

    /// Adds coordinates of the faces, times a factor.
    fn shift(&self, stress: &mut EquilibratedStress<Solid>, x: &AtomicSlots, factor: f64) {
        let moments = stress.facet_moments.par_iter_mut().enumerate().with_min_len(CHUNK);
        moments.for_each(|(face, moments)| {
            for (k, column) in self.coefficients.spaces.columns(FacetId::new(face)).iter().enumerate() {
                let amount = factor * x.get(FACE * face + k);
                moments.iter_mut().zip(column).for_each(|(moment, unit)| *moment += unit * amount);
            }
        });
    }

    fn body(&self) -> &'a Body<Solid> {
        self.coefficients.spaces.body
    }

    /// The number of cells.
    fn cells(&self) -> usize {
        self.body().mesh().cells().len()
    }

    /// The number of faces.
    fn faces(&self) -> usize {
        self.body().mesh().topology().facets().len()
    }

    /// Computes the coordinates `z` of one sweep over all edges and one back.
    ///
    /// * `left`: memory for the residual that is left.
    fn precondition(&self, (r, left): (&AtomicSlots, &AtomicSlots), z: &AtomicSlots) {
        let size = sum_over_cells(r.len(), |i| r.get(i) * r.get(i)).sqrt();
        let scale = if size > 0.0 { size } else { 1.0 };
        left.update(|i, _| r.get(i) / scale);
        z.update(|_, _| 0.0);
        let sweep = |colour: &Vec<u32>, back: bool| {
            for_each_task(colour.len(), &|k| {
                let (number, mesh) = (colour[k] as usize, self.body().mesh());
                let cluster = &self.clusters[number];
                self.coefficients.with_cluster(
                    (cluster, &self.rims),
                    self.blocks.get(number),
                    |energy, blocks| {
                        pulp::Arch::new().dispatch(Sweep {
                            mesh,
                            energy,
                            cluster,
                            blocks,
                            back,
                            left,
                            z,
                            scale,
                        });
                    },
                );
            });
        };
        self.colours.iter().for_each(|colour| sweep(colour, false));
        self.colours.iter().rev().for_each(|colour| sweep(colour, true));
    }

    /// Computes `H p`. What the sweeps leave of the residual says it as well, but only to single precision: long relaxations would end early.
    ///
    /// * `second`: memory for the parts of the second cell at each face; zero at the faces of the boundary.
    fn multiply(&self, p: &AtomicSlots, (to, second): (&AtomicSlots, &AtomicSlots)) {
        for_each_task(self.cells().div_ceil(CHUNK), &|k| {
            let cells = k * CHUNK..self.cells().min((k + 1) * CHUNK);
            self.coefficients.with(cells.clone(), |energy| {
                pulp::Arch::new().dispatch(Product { stars: self, cells, energy, p, to: [to, second] });
            });
        });
        to.update(|i, x| x + second.get(i));
    }

    /// Tells which of the one or two cells at each of its faces a cell is.
    fn places(&self, cell: usize) -> [usize; 4] {
        let topology = self.body().mesh().topology();
        topology.cell_facets()[cell].map(|face| usize::from(topology.facet_cells()[face][0] != cell as u32))
    }

    /// Subtracts the part of the springs from the negative gradient of half the energy by the moments of a face.
    fn less_springs(
        &self,
        stress: &EquilibratedStress<Solid>,
        face: FacetId,
        moments: [Vector3<f64>; 3],
    ) -> [Vector3<f64>; 3] {
        if self.coefficients.spaces.springs(face).is_none() {
            return moments;
        }
        let topology = self.body().mesh().topology();
        let springs = &stress.conditions[topology.boundary_place(face)].springs;
        let strained = springs.strained(&stress.spring_defect(self.body(), face, springs));
        std::array::from_fn(|k| moments[k] - strained[k])
    }

    /// Computes the negative gradient of half the energy by the coordinates of the faces, over the unit.
    ///
    /// * `second`: see [`Self::multiply`].
    fn residual(&self, stress: &EquilibratedStress<Solid>, second: &AtomicSlots) -> AtomicSlots {
        let to = AtomicSlots::zeros(FACE * self.faces());
        let topology = self.body().mesh().topology();
        for_each_task(self.cells().div_ceil(CHUNK), &|k| {
            for cell in k * CHUNK..self.cells().min((k + 1) * CHUNK) {
                let work = gradient(self.body(), stress, cell);
                let faces = topology.cell_facets()[cell].into_iter().zip(self.places(cell));
                for ((face, of), ((places, sign), work)) in
                    faces.zip(order(self.body(), cell).into_iter().zip(work))
                {
                    for (place, work) in places.into_iter().zip(work) {
                        let slot = FACE * face.index() + 3 * place;
                        (0..3).for_each(|axis| [&to, second][of].set(slot + axis, -sign * work[axis]));
                    }
                }
            }
        });
        for_each_task(self.faces().div_ceil(CHUNK), &|k| {
            for face in k * CHUNK..self.faces().min((k + 1) * CHUNK) {
                let slot = FACE * face;
                let sum = |i: usize| to.get(slot + i) + second.get(slot + i);
                let moments = [0, 3, 6].map(|j| Vector3::from_fn(|axis, _| sum(j + axis)));
                let face = FacetId::new(face);
                let moments = self.less_springs(stress, face, moments);
                for (k, column) in self.coefficients.spaces.columns(face).iter().enumerate() {
                    let product: f64 =
                        column.iter().zip(&moments).map(|(unit, moment)| unit.dot(moment)).sum();
                    to.set(slot + k, product / self.coefficients.unit);
                }
            }
        });
        to
    }
}

/// The product of the energy matrices of some cells with the coordinates of their faces.
struct Product<'a> {
    stars: &'a EdgeStars<'a>,
    cells: Range<usize>,
    energy: Matrices<'a>,
    p: &'a AtomicSlots,
    /// The parts of the first and of the second cell at each face.
    to: [&'a AtomicSlots; 2],
}

impl pulp::NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { stars, cells, energy, p, to } = self;
        let facets = stars.body().mesh().topology().cell_facets();
        for (place, cell) in cells.enumerate() {
            let mut sums = [0.0; 40];
            let matrix = energy.of(cell as u32, place);
            for (face, rows) in facets[cell].iter().zip(matrix.chunks_exact(FACE)) {
                for (i, row) in rows.iter().enumerate() {
                    let amount = p.get(FACE * face.index() + i);
                    for (sum, h) in sums.iter_mut().zip(row) {
                        *sum += amount * f64::from(*h);
                    }
                }
            }
            for ((face, of), sums) in facets[cell].iter().zip(stars.places(cell)).zip(sums.chunks_exact(FACE))
            {
                for (i, sum) in sums.iter().enumerate() {
                    to[of].set(FACE * face.index() + i, *sum);
                }
            }
        }
    }
}

/// The derivatives of `½ ‖τ − σ̂‖²` in a cell by its moments.
fn gradient(body: &Body<Solid>, stress: &EquilibratedStress<Solid>, cell: usize) -> CellMoments {
    let (mut at, constant) = (stress.cell(body, cell), stress.finite_element[cell]);
    if let Some(fixed) = stress.fixed(body, cell) {
        at = with_offset(&at, &fixed);
    }
    let strains = at.map(|part| part.map(|at| body.material(cell).strain(at.minus(constant))));
    CellMap::new(body.mesh().corners(cell)).work(&strains)
}

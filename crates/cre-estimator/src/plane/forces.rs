//! The force residuals of a body, and in the same pass what the bound needs of its triangles.

use crate::cells::{Cells, Gathered, Residuals, load_tensor, set_tensor};
use crate::equilibrated::EquilibratedStress;
use crate::lanes::{LaneRow, MOST_LANES};
use crate::measures::{Accuracy, Against, CellMeasures, Forces};
use crate::size::{larger, square};
use fem_core::body::Body;
use fem_core::double_double::DoubleDouble;
use fem_core::geometry::Vector;
use fem_core::mesh::id::FacetId;
use fem_core::parallel::each_task;
use fem_core::space::Plane;
use fem_core::tensor::SymTensor2;
use pulp::Simd;
use std::ops::Range;

/// Tractions times length on the edges of a triangle, from its stress: edge `k` at corners `k`, `k+1`.
pub(super) type CellForces = [[Vector; 2]; 3];

/// Triangles per block: most edges have both sides within a block, and its edge forces stay in the cache.
const BLOCK: usize = 8192;

/// Finds the force residuals of a body, block by block, and measures its triangles if `measured` says against what and how accurately.
pub(super) fn forces(
    body: &Body,
    stress: &EquilibratedStress,
    measured: Option<(Against<'_>, Accuracy)>,
) -> (Forces, CellMeasures) {
    let triangles = body.mesh().cells().len();
    for given in measured.iter().flat_map(|(against, _)| against).flatten() {
        assert!(given.len() == triangles, "a stress of {} triangles on {triangles}", given.len());
    }
    let blocks: Vec<(Forces, CellMeasures)> = each_task(triangles.div_ceil(BLOCK), |k| {
        let triangles = k * BLOCK..triangles.min((k + 1) * BLOCK);
        pulp::Arch::new().dispatch(BlockForces { body, stress, triangles, measured })
    });
    let mut all = CellMeasures::default();
    if let Some((against, accuracy)) = measured {
        all.reserve(triangles, against, accuracy);
    }
    let mut worst = Forces::default();
    for (found, CellMeasures { distances, mean, exact_mean }) in blocks {
        worst = worst.max(found);
        for (all, part) in all.distances.iter_mut().zip(distances) {
            all.extend_from_slice(&part);
        }
        all.mean.extend_from_slice(&mean);
        all.exact_mean.extend_from_slice(&exact_mean);
    }
    (worst, all)
}

/// The force residuals of a block.
struct BlockForces<'a> {
    body: &'a Body,
    stress: &'a EquilibratedStress,
    triangles: Range<usize>,
    measured: Option<(Against<'a>, Accuracy)>,
}

/// The triangles that are side by side, and the stresses to which their distances are measured.
#[derive(Default)]
struct Gathering {
    cells: Gathered,
    against: [[LaneRow; 3]; 2],
}

impl pulp::WithSimd for BlockForces<'_> {
    type Output = (Forces, CellMeasures);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Forces, CellMeasures) {
        let Self { body, stress, triangles, measured } = self;
        let mut worst = Forces::default();
        let mut cells: Vec<CellForces> = Vec::with_capacity(triangles.len());
        let mut measures = CellMeasures::default();
        if let Some((against, accuracy)) = measured {
            measures.reserve(triangles.len(), against, accuracy);
        }
        let mut gathering = Gathering::default();
        for first in triangles.clone().step_by(S::F64_LANES) {
            let group = first..triangles.end.min(first + S::F64_LANES);
            // Lanes without a triangle keep the one that they had before, whose results are not read.
            for (lane, t) in group.clone().enumerate() {
                gathering.cells.set(lane, body, stress, t);
                let Some((against, _)) = measured else { continue };
                for (rows, given) in gathering.against.iter_mut().zip(against) {
                    if let Some(given) = given {
                        set_tensor(rows, lane, given[t]);
                    }
                }
            }
            let found = Cells::new(simd, &gathering.cells);
            let Residuals { equilibrium, forces } = found.residuals();
            let mut rows = [[0.0; MOST_LANES]; 1 + 12];
            equilibrium.store(&mut rows[0]);
            for (pair, force) in rows[1..].chunks_exact_mut(2).zip(forces.as_flattened()) {
                force[0].store(&mut pair[0]);
                force[1].store(&mut pair[1]);
            }
            for (lane, t) in group.clone().enumerate() {
                worst.equilibrium = larger(worst.equilibrium, rows[0][lane]);
                worst.scale = larger(worst.scale, square(body.mesh().measure(t) * body.force(t).mean));
                let mut forces = CellForces::default();
                for (force, pair) in forces.as_flattened_mut().iter_mut().zip(rows[1..].chunks_exact(2)) {
                    *force = Vector::new(pair[0][lane], pair[1][lane]);
                }
                cells.push(forces);
            }
            if let Some((against, accuracy)) = measured {
                measure(simd, &found, (&gathering.against, against), (group.len(), accuracy), &mut measures);
            }
        }
        let block = Block { body, stress, first: triangles.start, cells };
        for t in triangles {
            for k in 0..3 {
                block.edge(t, k, &mut worst);
            }
        }
        (worst, measures)
    }
}

/// Measures the first `count` of some triangles.
#[inline(always)]
fn measure<S: Simd>(
    simd: S,
    cells: &Cells<S>,
    (rows, against): (&[[LaneRow; 3]; 2], Against<'_>),
    (count, accuracy): (usize, Accuracy),
    measures: &mut CellMeasures,
) {
    for k in 0..2 {
        if against[k].is_some() {
            let mut distances = [0.0; MOST_LANES];
            cells.distance_squared(load_tensor(simd, &rows[k])).store(&mut distances);
            measures.distances[k].extend_from_slice(&distances[..count]);
        }
    }
    let mut sums = [[[0.0; MOST_LANES]; 3]; 2];
    for (rows, parts) in sums.as_flattened_mut().iter_mut().zip(cells.sum().as_flattened()) {
        parts.store(rows);
    }
    for lane in 0..count {
        let mean = |c: usize| sums[0][c][lane] / 9.0;
        measures.mean.push(SymTensor2::new(mean(0), mean(1), mean(2)));
        if accuracy == Accuracy::Refined {
            let sum = |c: usize| DoubleDouble { high: sums[0][c][lane], low: sums[1][c][lane] };
            measures.exact_mean.push([0, 1, 2].map(|c| sum(c) / DoubleDouble::from(9.0)));
        }
    }
}

/// Computes the tractions times length on the edges of a triangle.
pub(super) fn edge_tractions(body: &Body, stress: &EquilibratedStress, t: usize) -> CellForces {
    let corners = body.mesh().corners(t);
    let (tau, fixed) = (stress.cell(body, t), stress.fixed(body, t));
    [0, 1, 2].map(|k: usize| {
        let along = corners[(k + 1) % 3] - corners[k];
        let normal = Vector::new(along[1], -along[0]);
        let fixed = fixed.map_or([Vector::zeros(); 2], |fixed| fixed.loads[k]);
        [tau[k][0].apply(normal) + fixed[0], tau[k][1].apply(normal) + fixed[1]]
    })
}

/// Consecutive triangles with the forces on their edges.
struct Block<'a> {
    body: &'a Body,
    stress: &'a EquilibratedStress,
    first: usize,
    cells: Vec<CellForces>,
}

impl Block<'_> {
    /// Compares the forces on edge `k` of triangle `t` from both sides, or with the given ones, and raises `worst` to their differences. Each edge
    /// is checked once, by its first triangle.
    fn edge(&self, t: usize, k: usize, worst: &mut Forces) {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let edge = topology.cell_facets()[t][k];
        let [owner, other] = topology.facet_cells()[edge].map(|t| t as usize);
        if owner != t {
            return;
        }
        let own = self.edge_forces(t, edge);
        if topology.is_boundary(edge) {
            let condition = &self.stress.conditions[topology.boundary_place(edge)];
            worst.compare_given::<Plane>(&own, condition, mesh.facet_measure(edge));
        } else {
            worst.compare::<Plane>(&own, &self.edge_forces(other, edge));
        }
    }

    /// Tractions times length at the ends of an edge, in its own order, from triangle `t`.
    fn edge_forces(&self, t: usize, edge: FacetId) -> [Vector; 2] {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let k = topology.facet_in(t, edge);
        let forces = match self.cells.get(t.wrapping_sub(self.first)) {
            Some(forces) => forces[k],
            None => edge_tractions(self.body, self.stress, t)[k],
        };
        let first = topology.facets()[edge][0] == mesh.cells()[t][k];
        if first { forces } else { [forces[1], forces[0]] }
    }
}

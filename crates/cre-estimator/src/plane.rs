//! The recovery of stresses in the plane.

mod forces;

use crate::equilibrated::{EquilibratedStress, FacetMoments};
use crate::friction::mean_on_edge;
use crate::measures::{Accuracy, Against, CellMeasures, Forces, Shape};
use crate::recovery::{Recovery, StarMemory};
use crate::relaxation::{Relaxation, RelaxationReport};
use crate::size::larger;
use crate::star_relaxation::{StarRelaxation, bytes_of_stars, relax_with_stars};
use crate::{cells, eet, lift};
use fem_core::body::{Body, FacetCondition};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair};
use fem_core::material::LinearElastic;
use fem_core::mesh::TriMesh;
use fem_core::space::Plane;
use fem_core::tensor::SymTensor2;
use forces::{edge_tractions, forces};

impl Recovery for Plane {
    const BALANCED_BY_FACET: bool = false;

    type Stars<'a> = StarRelaxation<'a>;

    fn facet_moments(body: &Body, stress: &[SymTensor2], conditions: &[FacetCondition]) -> FacetMoments {
        eet::facet_moments(body, stress, conditions)
    }

    fn relax_with<'a>(
        body: &'a Body,
        stress: &mut EquilibratedStress,
        relaxation: Relaxation,
        stars: &mut Option<StarRelaxation<'a>>,
        memory: StarMemory<StarRelaxation<'_>>,
    ) -> RelaxationReport {
        let used = match memory {
            StarMemory::Stored(used) => used,
            StarMemory::Recomputed => None,
        };
        relax_with_stars(body, stress, relaxation, stars, used)
    }

    fn principal(stress: SymTensor2) -> [f64; 2] {
        stress.principal()
    }

    fn von_mises(material: &LinearElastic, stress: SymTensor2, temperature: f64) -> Option<f64> {
        material.von_mises(stress, temperature)
    }

    fn holes(_: [usize; 2], parts: usize, pieces: usize) -> usize {
        // Each piece has one outer boundary.
        parts.saturating_sub(pieces)
    }

    fn bytes_of_relaxation(mesh: &TriMesh, _: bool) -> usize {
        bytes_of_stars(mesh)
    }

    fn distance_squared(body: &Body, stress: &EquilibratedStress) -> f64 {
        cells::distance_squared(body, stress)
    }

    fn cell_distance_squared(
        body: &Body,
        stress: &EquilibratedStress,
        cell: usize,
        constant: SymTensor2,
    ) -> f64 {
        stress.cell_distance_squared(body, cell, constant)
    }

    fn measured(
        body: &Body,
        stress: &EquilibratedStress,
        measured: Option<(Against<'_>, Accuracy)>,
    ) -> (Forces, CellMeasures) {
        forces(body, stress, measured)
    }

    fn facet_forces(body: &Body, stress: &EquilibratedStress, cell: usize, k: usize) -> [Vector; 2] {
        // ∫ F φ_j of linear functions, from the tractions times length.
        let [a, b] = edge_tractions(body, stress, cell)[k];
        [1.0 / 6.0 * (2.0 * a + b), 1.0 / 6.0 * (a + 2.0 * b)]
    }

    fn shape(c: &[Vector; 3], area: f64) -> Shape {
        // By the square: the guard of `hypot` against overflow costs more than all the rest.
        let lengths = [0, 1, 2].map(|k| {
            let side = c[(k + 1) % 3] - c[k];
            side.dot(&side).sqrt()
        });
        let longest = lengths.iter().fold(0.0, |m, l| larger(m, *l));
        Shape {
            boundary: lengths.iter().sum(),
            largest: longest,
            flatness: larger(1.0, longest * longest / (4.0 * area)),
        }
    }

    fn twist(corners: &[Vector; 3], u: &[Vector; 3]) -> f64 {
        // ∮ u·ds = 2 ω A, with u linear along the edges.
        let along = |k: usize| {
            let next = (k + 1) % 3;
            0.5 * (u[k] + u[next]).dot(&(corners[next] - corners[k]))
        };
        0.5 * (along(0) + along(1) + along(2))
    }

    fn middle_openings(interface: &ContactInterface, displacement: [&[Vector]; 2]) -> Vec<f64> {
        let jump = |k: usize| {
            let [a, b] = interface.pairs()[k].nodes;
            displacement[0][a] - displacement[1][b]
        };
        interface.facets().iter().map(|edge| interface.middle_opening(edge, jump)).collect()
    }

    fn contact_work(edge: &ContactFacet, pressure: &[f64; 2], opening: &[f64; 2], middle: &[f64]) -> f64 {
        edge.work(*pressure, *opening, middle[0])
    }

    fn depth([a, b]: &[f64; 2], middle: &[f64]) -> f64 {
        lift::depth_of_edge(middle[0], [*a, *b])
    }

    fn mean_sliding(
        pair: &ContactPair,
        edge: &ContactFacet,
        limit: &[f64; 2],
        friction: &[Vector; 2],
        jump: &[Vector; 2],
    ) -> f64 {
        mean_on_edge(&pair.interface, edge, *limit, *friction, *jump)
    }
}

//! Stresses in exact equilibrium in solid bodies: tetrahedra.
//!
//! What the plane has in [`crate::eet`], [`crate::johnson_mercier`] and [`crate::star_relaxation`] is here for tetrahedra: face moments in equilibrium,
//! a stress of four parts in each cell, and corrections along bars and wrenches.

mod blocks;
mod cell;
mod clusters;
mod coefficients;
mod eet;
mod energy;
mod face_opening;
mod forces;
mod potentials;
mod relaxation;
mod rings;
mod stars;
mod sweep;
#[cfg(test)]
mod tests;

use crate::equilibrated::{EquilibratedStress, FacetMoments, product};
use crate::fixed::FixedPart;
use crate::friction::mean_on_face;
use crate::measures::{Accuracy, Against, CellMeasures, Forces, Shape};
use crate::recovery::{Recovery, StarMemory};
use crate::relaxation::{Relaxation, RelaxationReport};
use crate::size::larger;
use cell::{CellMap, CellMoments, CellStress};
use fem_core::body::{Body, FacetCondition};
use fem_core::element::Element;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair};
use fem_core::material::LinearElastic;
use fem_core::mesh::TetMesh;
use fem_core::norm::sum_over_cells;
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use nalgebra::Vector3;
use relaxation::EdgeStars;

impl Recovery for Solid {
    const BALANCED_BY_FACET: bool = true;

    type Stars<'a> = EdgeStars<'a>;

    fn facet_moments(
        body: &Body<Self>,
        stress: &[SymTensor3],
        conditions: &[FacetCondition<Self>],
    ) -> FacetMoments<Self> {
        eet::facet_moments(body, stress, conditions)
    }

    fn relax_with<'a>(
        body: &'a Body<Self>,
        stress: &mut EquilibratedStress<Self>,
        relaxation: Relaxation,
        stars: &mut Option<EdgeStars<'a>>,
        memory: StarMemory<EdgeStars<'_>>,
    ) -> RelaxationReport {
        if relaxation.max_steps() == 0 {
            return RelaxationReport::unrelaxed(stress.distance_squared(body));
        }
        match stars {
            Some(stars) => {
                drop(memory);
                stars.restate(&stress.conditions);
                stars.relax(stress, relaxation)
            }
            None => stars.insert(EdgeStars::new(body, &stress.conditions, memory)).relax(stress, relaxation),
        }
    }

    fn principal(stress: SymTensor3) -> [f64; 3] {
        stress.principal()
    }

    fn von_mises(_material: &LinearElastic<Self>, stress: SymTensor3, _temperature: f64) -> Option<f64> {
        Some(stress.von_mises())
    }

    fn holes([nodes, faces]: [usize; 2], parts: usize, _: usize) -> usize {
        // Half of 2 − V + E − F for each part; each edge belongs to two faces.
        (2 * parts + faces / 2).saturating_sub(nodes) / 2
    }

    fn bytes_of_relaxation(mesh: &TetMesh, stored: bool) -> usize {
        relaxation::bytes(mesh, stored)
    }

    fn distance_squared(body: &Body<Self>, stress: &EquilibratedStress<Self>) -> f64 {
        let of_cell =
            |cell: usize| Self::cell_distance_squared(body, stress, cell, stress.finite_element[cell]);
        sum_over_cells(body.mesh().cells().len(), of_cell)
    }

    fn cell_distance_squared(
        body: &Body<Self>,
        stress: &EquilibratedStress<Self>,
        cell: usize,
        constant: SymTensor3,
    ) -> f64 {
        stress.distance_in_cell(body, cell, &stress.cell(body, cell), constant)
    }

    fn measured(
        body: &Body<Self>,
        stress: &EquilibratedStress<Self>,
        measured: Option<(Against<'_, Self>, Accuracy)>,
    ) -> (Forces, CellMeasures<Self>) {
        forces::forces(body, stress, measured)
    }

    fn facet_forces(
        body: &Body<Self>,
        stress: &EquilibratedStress<Self>,
        cell: usize,
        k: usize,
    ) -> [Vector3<f64>; 3] {
        let forces = forces::face_tractions(body, cell, &stress.cell(body, cell), stress)[k];
        let sum = forces[0] + forces[1] + forces[2];
        forces.map(|force| (sum + force) / 12.0)
    }

    fn shape(corners: &[Vector3<f64>; 4], volume: f64) -> Shape {
        let faces = [0, 1, 2, 3].map(|k| Self::facet_measure(&Self::facet(k).map(|c| corners[c])));
        let largest = faces.iter().fold(0.0, |m, area| larger(m, *area));
        let edges = (0..4).flat_map(|i| (0..i).map(move |j| (corners[i] - corners[j]).length()));
        let longest = edges.fold(0.0, larger);
        // √54 in a sixth of a cube.
        let flatness = larger(1.0, longest * largest / (54.0f64.sqrt() * volume));
        Shape { boundary: faces.iter().sum(), largest, flatness }
    }

    fn middle_openings(interface: &ContactInterface<Self>, displacement: [&[Vector3<f64>]; 2]) -> Vec<f64> {
        let jump = |k: usize| {
            let [a, b] = interface.pairs()[k].nodes;
            displacement[0][a.index()] - displacement[1][b.index()]
        };
        interface.middle_openings(jump)
    }

    fn contact_work(
        facet: &ContactFacet<Self>,
        pressure: &[f64; 3],
        opening: &[f64; 3],
        middle: &[f64],
    ) -> f64 {
        facet.work(pressure, opening, middle)
    }

    fn depth(opening: &[f64; 3], middle: &[f64]) -> f64 {
        face_opening::depth(*opening, [middle[0], middle[1], middle[2]])
    }

    fn mean_sliding(
        pair: &ContactPair<Self>,
        facet: &ContactFacet<Self>,
        limit: &[f64; 3],
        friction: &[Vector3<f64>; 3],
        jump: &[Vector3<f64>; 3],
    ) -> f64 {
        let normals = [0, 1, 2].map(|corner: usize| pair.interface.corner_pair(facet, corner).normal);
        mean_on_face(&normals, limit, friction, jump)
    }

    fn twist(corners: &[Vector3<f64>; 4], displacement: &[Vector3<f64>; 4]) -> Vector3<f64> {
        // Half of the curl.
        let element = Element::<Self>::new(*corners);
        let curls = element.gradients.iter().zip(displacement).map(|(g, u)| g.cross(u));
        curls.sum::<Vector3<f64>>() * (0.5 * element.measure)
    }
}

/// Adds what is fixed to the stress of a cell.
fn with_offset(stress: &CellStress, fixed: &FixedPart<Solid>) -> CellStress {
    std::array::from_fn(|part| std::array::from_fn(|v| stress[part][v].plus(fixed.offset[part][v])))
}

impl EquilibratedStress<Solid> {
    /// Computes `‖σ̂‖²`, J.
    fn finite_element_energy(&self, body: &Body<Solid>) -> f64 {
        product(body, &self.finite_element, &self.finite_element)
    }

    /// The moments of the tractions that act on a cell, N.
    fn cell_moments(&self, body: &Body<Solid>, cell: usize) -> CellMoments {
        let order = cell::order(body, cell);
        std::array::from_fn(|k| {
            let (places, sign) = order[k];
            let moments = &self.facet_moments[body.mesh().topology().cell_facets()[cell][k].index()];
            places.map(|place| sign * moments[place])
        })
    }

    /// Computes the distance² of a stress of this cell to one by its mean.
    fn distance_in_cell(
        &self,
        body: &Body<Solid>,
        cell: usize,
        stress: &CellStress,
        constant: SymTensor3,
    ) -> f64 {
        let fixed = self.fixed(body, cell);
        let stress = fixed.as_ref().map_or(*stress, |fixed| with_offset(stress, fixed));
        let strain = |s| body.material(cell).strain(s);
        let distance = cell::distance_squared(&stress, constant, body.mesh().measure(cell), strain);
        distance + fixed.map_or(0.0, |fixed| fixed.energy)
    }

    /// Computes the stress in a tetrahedron, Pa, if the body force varies there without its quadratic part: a part for each face, in the order of [`Solid::facet`], linear between the three corners of the face
    /// and the barycentre.
    pub fn cell(&self, body: &Body<Solid>, cell: usize) -> [[SymTensor3; 4]; 4] {
        let corners = body.mesh().corners(cell);
        let mut moments = self.cell_moments(body, cell);
        if !body.has_force() {
            return CellMap::new(corners).stress(&moments);
        }
        let particular = cell::particular(&corners, body.force(cell).mean);
        let mut known = cell::moments_of(&corners, &particular);
        if body.has_varying_force()
            && let Some(fixed) = self.fixed(body, cell)
        {
            for (known, loads) in known.iter_mut().zip(fixed.loads) {
                let sum = loads[0] + loads[1] + loads[2];
                known.iter_mut().zip(loads).for_each(|(known, load)| *known += (sum + load) / 12.0);
            }
        }
        moments.iter_mut().flatten().zip(known.iter().flatten()).for_each(|(moment, known)| *moment -= known);
        let mut stress = CellMap::new(corners).stress(&moments);
        // It vanishes at the barycentre.
        for (part, corners) in stress.iter_mut().zip((0..4).map(Solid::facet)) {
            for (at, corner) in part.iter_mut().zip(corners) {
                *at = at.plus(particular[corner]);
            }
        }
        stress
    }
}

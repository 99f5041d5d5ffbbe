//! Stresses in exact equilibrium in solid bodies: tetrahedra.
//!
//! What the plane has in [`crate::eet`], [`crate::johnson_mercier`] and [`crate::star_relaxation`] is here for tetrahedra: face moments in equilibrium,
//! a stress of four parts in each cell, and corrections along bars and wrenches.

mod cell;
mod clusters;
mod eet;
mod potentials;
mod relaxation;
mod rings;
#[cfg(test)]
mod tests;

use crate::equilibrated::{EquilibratedStress, FacetMoments};
use crate::recovery::Recovery;
use crate::relaxation::{Relaxation, RelaxationReport};
use cell::{CellMap, CellMoments, CellStress};
use fem_core::body::{Body, FacetCondition};
use fem_core::element::Element;
use fem_core::geometry::Coordinates;
use fem_core::norm::sum_over_cells;
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use nalgebra::Vector3;
use relaxation::EdgeStars;

impl Recovery for Solid {
    fn facet_moments(
        body: &Body<Self>,
        stress: &[SymTensor3],
        conditions: &[FacetCondition<Self>],
    ) -> FacetMoments<Self> {
        eet::facet_moments(body, stress, conditions)
    }

    fn relax(
        body: &Body<Self>,
        stress: &mut EquilibratedStress<Self>,
        relaxation: Relaxation,
    ) -> RelaxationReport {
        if relaxation.max_steps() == 0 {
            return RelaxationReport::unrelaxed(stress.distance_squared(body));
        }
        EdgeStars::new(body, stress).relax(stress, relaxation)
    }

    fn distance_squared(body: &Body<Self>, stress: &EquilibratedStress<Self>) -> f64 {
        stress.distance_squared_to(body, &stress.finite_element)
    }
}

impl EquilibratedStress<Solid> {
    /// Computes the distance² to a stress that is constant in every tetrahedron, in the complementary norm, J.
    pub fn distance_squared_to(&self, body: &Body<Solid>, constant: &[SymTensor3]) -> f64 {
        let mesh = body.mesh();
        sum_over_cells(mesh.cells().len(), |cell| {
            let stress = self.cell(body, cell);
            cell::distance_squared(&stress, constant[cell], mesh.measure(cell), |s| {
                body.material(cell).strain(s)
            })
        })
    }

    /// Computes `‖σ̂‖²`, J.
    fn finite_element_energy(&self, body: &Body<Solid>) -> f64 {
        let of_cell = |cell: usize| {
            let stress = self.finite_element[cell];
            body.mesh().measure(cell) * body.material(cell).complementary(stress, stress)
        };
        sum_over_cells(body.mesh().cells().len(), of_cell)
    }

    /// Computes the largest force and moment by which a tetrahedron is out of equilibrium, relative to the sum of the forces on its faces; the moment
    /// about its centroid over its size.
    pub fn imbalance(&self, body: &Body<Solid>) -> f64 {
        let mesh = body.mesh();
        let of_cell = |cell: usize| {
            let corners = mesh.corners(cell);
            let middle = corners.iter().sum::<Vector3<f64>>() / 4.0;
            let element = Element::<Solid>::new(corners);
            let mut force = body.body_force() * element.measure;
            let mut turn = Vector3::zeros();
            let (mut size, mut arm) = (force.length(), 0.0f64);
            for (k, moments) in self.cell_moments(body, cell).iter().enumerate() {
                for (corner, moment) in Solid::facet(k).iter().zip(moments) {
                    force += moment;
                    turn += (corners[*corner] - middle).cross(moment);
                    size += moment.length();
                    arm = arm.max((corners[*corner] - middle).length());
                }
            }
            if size > 0.0 { force.length().max(turn.length() / arm) / size } else { 0.0 }
        };
        (0..mesh.cells().len()).map(of_cell).fold(0.0, f64::max)
    }

    /// The moments of the tractions that act on a cell, N.
    fn cell_moments(&self, body: &Body<Solid>, cell: usize) -> CellMoments {
        let order = relaxation::order(body, cell);
        std::array::from_fn(|k| {
            let (places, sign) = order[k];
            let moments = &self.facet_moments[body.mesh().topology().cell_facets()[cell][k].index()];
            places.map(|place| sign * moments[place])
        })
    }

    /// Computes the stress in a cell.
    fn cell(&self, body: &Body<Solid>, cell: usize) -> CellStress {
        let corners = body.mesh().corners(cell);
        let mut moments = self.cell_moments(body, cell);
        let force = body.body_force();
        if force == Vector3::zeros() {
            return CellMap::new(corners).stress(&moments);
        }
        let particular = cell::particular(&corners, force);
        let known = cell::moments_of(&corners, &particular);
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

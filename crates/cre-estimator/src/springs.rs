//! Springs between the boundary of a body and the ground, in the bound.
//!
//! On a side on springs the traction along them is unknown, and what it misses of Hooke's law of the springs is part of the bound:
//! ```math
//! e_CRE² = ∑ ‖τ − σ(v)‖² + ∫ (1/k) |τ n + k (v − u₀)|² + 2 ∫ p o ≥ ‖u − v‖² + ∫ k |u − v|²     (41)
//! ```
//! EET and the relaxation choose it. The split is as without springs, with the displacement `û` of the FE stress: `∫ (1/k) |τ n + k (û − u₀)|²`
//! in the part of the mesh, `∫ k |û − v|²` in the other.

use crate::equilibrated::EquilibratedStress;
use fem_core::body::{Body, FacetCondition, FacetSprings, moments, tractions};
use fem_core::directions::Directions;
use fem_core::geometry::Coordinates;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::Space;

/// Springs softer than the cells beside them by this factor keep the traction of the FE displacement: next to nothing can be gained, and the
/// coefficients of the relaxation are in single precision.
const SOFT: f64 = 1e3;

/// Two directions closer than this (sine of the angle) are the same.
pub(crate) const SAME_DIRECTION: f64 = 1e-9;

/// Computes the stiffness of the cell beside a facet over the smallest one of its springs, `E/(k h)`.
pub(crate) fn softness<S: Space>(body: &Body<S>, facet: FacetId, springs: &FacetSprings<S>) -> f64 {
    let mesh = body.mesh();
    let size = mesh.facet_measure(facet).powf(1.0 / (S::DIM - 1) as f64);
    let cell = mesh.topology().facet_cells()[facet][0] as usize;
    let along = springs.directions.basis().iter();
    let soft = along.map(|d| springs.strained(&S::axes(|_| *d))[0].times(d)).fold(0.0, f64::max);
    body.material(cell).axial_modulus() * soft / size
}

/// Returns the directions in which the traction on a facet is unknown: of its supports, and of springs that are not very soft.
pub(crate) fn reaction<S: Space>(
    body: &Body<S>,
    facet: FacetId,
    condition: &FacetCondition<S>,
) -> Directions<S> {
    let springs = &condition.springs;
    if springs.directions.is_none() || softness(body, facet, springs) > SOFT {
        return condition.reaction;
    }
    condition.carried()
}

/// Returns the conditions with the springs as a displacement stretches them, and their tractions unknown.
///
/// * `conditions`: with the springs of the body, at zero displacement.
/// * `displacement`: of each node, as a sum of fields, m.
pub fn released<S: Space>(
    body: &Body<S>,
    mut conditions: Vec<FacetCondition<S>>,
    displacement: &[&[S::Vector]],
) -> Vec<FacetCondition<S>> {
    let topology = body.mesh().topology();
    for (facet, _) in body.facet_springs() {
        let condition = &mut conditions[topology.boundary_place(facet)];
        condition.reaction = reaction(body, facet, condition);
        for field in displacement {
            condition.springs = stretched(body, facet, &condition.springs, field);
        }
    }
    conditions
}

/// Stretches the springs on a facet by a displacement of the nodes.
pub(crate) fn stretched<S: Space>(
    body: &Body<S>,
    facet: FacetId,
    springs: &FacetSprings<S>,
    displacement: &[S::Vector],
) -> FacetSprings<S> {
    let nodes = body.mesh().topology().facets()[facet];
    springs.stretched(&S::axes(|k| displacement[nodes[k]]))
}

/// Tells whether the traction along the springs of a facet may differ from that of the FE displacement.
pub(crate) fn relaxes<S: Space>(condition: &FacetCondition<S>) -> bool {
    let mut directions = condition.springs.directions.basis().iter();
    !condition.springs.directions.is_none()
        && directions.all(|d| condition.reaction.contains(*d, SAME_DIRECTION))
}

impl<S: Space> EquilibratedStress<S> {
    /// Computes by how much the traction on a facet on springs differs from the given one and a traction of the springs, at its corners, Pa.
    ///
    /// * `springs`: as the displacement stretches them.
    pub(crate) fn spring_defect(
        &self,
        body: &Body<S>,
        facet: FacetId,
        springs: &FacetSprings<S>,
    ) -> S::Axes<S::Vector> {
        let mesh = body.mesh();
        let condition = &self.conditions[mesh.topology().boundary_place(facet)];
        let own = tractions::<S>(&self.facet_moments[facet.index()], mesh.facet_measure(facet));
        let of_springs = springs.traction();
        S::axes(|k| own[k] - condition.traction[k] - of_springs[k])
    }

    /// Lists the facets on springs with their cells and `∫ (1/k) |τ n + k (v − u₀)|²`, J/m in the plane, J in space.
    ///
    /// * `displacement`: v of each node, m; `None`: of the FE stress.
    pub(crate) fn spring_terms<'a>(
        &'a self,
        body: &'a Body<S>,
        displacement: Option<&'a [S::Vector]>,
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        let (mesh, topology) = (body.mesh(), body.mesh().topology());
        body.facet_springs().map(move |(facet, at_zero)| {
            let own = &self.conditions[topology.boundary_place(facet)].springs;
            let springs = match displacement {
                Some(u) if !own.directions.is_none() => stretched(body, facet, at_zero, u),
                _ => *own,
            };
            let defect = self.spring_defect(body, facet, &springs);
            let cell = topology.facet_cells()[facet][0] as usize;
            (cell, springs.complementary(&defect, mesh.facet_measure(facet)))
        })
    }

    /// Sums up [`Self::spring_terms`] of the FE stress.
    pub(crate) fn spring_energy(&self, body: &Body<S>) -> f64 {
        self.spring_terms(body, None).map(|(_, term)| term).sum()
    }

    /// Computes `∫ k |û − v|²` with the displacement `û` of the FE stress, J/m in the plane, J in space.
    ///
    /// * `displacement`: v of each node, m.
    pub(crate) fn spring_distance(&self, body: &Body<S>, displacement: &[S::Vector]) -> f64 {
        let (mesh, topology) = (body.mesh(), body.mesh().topology());
        let of_facet = |(facet, at_zero): (FacetId, &FacetSprings<S>)| {
            let own = &self.conditions[topology.boundary_place(facet)].springs;
            let given = stretched(body, facet, at_zero, displacement);
            let difference = S::axes(|k| own.stretch[k] - given.stretch[k]);
            own.energy(&difference, mesh.facet_measure(facet))
        };
        body.facet_springs().map(of_facet).sum()
    }

    /// Lists the nodal forces of the tractions along springs, N/m in the plane, N in space.
    pub fn spring_forces(&self, body: &Body<S>) -> Vec<(NodeId, S::Vector)> {
        let (mesh, topology) = (body.mesh(), body.mesh().topology());
        let mut forces = Vec::new();
        for (facet, springs) in body.facet_springs() {
            let condition = &self.conditions[topology.boundary_place(facet)];
            // Without springs of its own the condition has their traction as a given one.
            let others = if condition.springs.directions.is_none() { S::ZEROS } else { condition.traction };
            let others = moments::<S>(&others, mesh.facet_measure(facet));
            let own = self.facet_moments[facet.index()];
            let of_node = |k: usize| springs.directions.project(own[k] - others[k]);
            forces.extend(topology.facets()[facet].into_iter().enumerate().map(|(k, n)| (n, of_node(k))));
        }
        forces
    }
}

//! The recovery of stresses in exact equilibrium, in any space.

use crate::equilibrated::{EquilibratedStress, FacetMoments};
use crate::relaxation::{Relaxation, RelaxationReport};
use fem_core::body::{Body, FacetCondition};
use fem_core::space::Space;

/// The recovery of stresses in exact equilibrium: all that differs by idea between the plane and solid bodies.
pub trait Recovery: Space {
    /// Computes facet moments in equilibrium with an FE stress that is in FE equilibrium with the conditions.
    ///
    /// * `stress`: of each cell, Pa; `conditions`: of each boundary facet, in the order of
    ///   [`fem_core::mesh::topology::Topology::boundary_facets`].
    fn facet_moments(
        body: &Body<Self>,
        stress: &[Self::Tensor],
        conditions: &[FacetCondition<Self>],
    ) -> FacetMoments<Self>;

    /// Lowers `‖τ − σ̂‖` in place; loads and given tractions stay the same to the last digit.
    fn relax(
        body: &Body<Self>,
        stress: &mut EquilibratedStress<Self>,
        relaxation: Relaxation,
    ) -> RelaxationReport;

    /// Computes `‖τ − σ̂‖²` over a body, J/m in the plane, J in space. It does not depend on the number of threads.
    fn distance_squared(body: &Body<Self>, stress: &EquilibratedStress<Self>) -> f64;
}

impl<S: Recovery> EquilibratedStress<S> {
    /// Recovers an equilibrated stress from an FE stress that is in FE equilibrium with the conditions.
    pub fn recover(
        body: &Body<S>,
        finite_element: Vec<S::Tensor>,
        conditions: Vec<FacetCondition<S>>,
    ) -> Self {
        let facet_moments = S::facet_moments(body, &finite_element, &conditions);
        Self { facet_moments, conditions, finite_element }
    }

    /// Computes the distance² `‖τ − σ̂‖²` to the FE stress over the whole body, in the complementary norm, J/m in the plane, J in space.
    /// It does not depend on the number of threads.
    pub fn distance_squared(&self, body: &Body<S>) -> f64 {
        S::distance_squared(body, self)
    }
}

/// Relaxes an equilibrated stress in place: steps of
/// ```math
/// min_φ ‖τ_EET + R ∇²φ Rᵀ − σ̂‖²,   φ of Hsieh, Clough and Tocher     (21)
/// ```
/// in the plane, and in space with bars and wrenches instead of `φ`.
///
/// * `stress`: as recovered by EET; on return with the facet moments of the last iterate, in exact equilibrium
///   with the same loads and given tractions.
///
/// If no reduction is possible (a body at rest, a uniform stress), it is not changed. To relax several stresses of
/// one body of the plane under the same kind of conditions, prepare a [`crate::StarRelaxation`] once.
pub fn relax<S: Recovery>(
    body: &Body<S>,
    stress: &mut EquilibratedStress<S>,
    relaxation: Relaxation,
) -> RelaxationReport {
    S::relax(body, stress, relaxation)
}

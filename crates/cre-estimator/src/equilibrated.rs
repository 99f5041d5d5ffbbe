//! Stresses in exact equilibrium, stored as the moments of their facet tractions.

use crate::eet;
use crate::johnson_mercier::{self, CellLoads, CellStress};
use crate::star_relaxation::{Relaxation, RelaxationReport};
use fem_core::body::{Body, FacetCondition};
use fem_core::geometry::Vector;
use fem_core::space::{Plane, Space};
use fem_core::tensor::SymTensor2;

/// Moments `∫_Γ F_Γ φ_j ds` about the nodes of every facet, N/m in the plane, N in space. `F_Γ` acts on the facet's first cell.
pub type FacetMoments<S = Plane> = Vec<<S as Space>::Axes<<S as Space>::Vector>>;

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

/// A stress in exact equilibrium with given facet tractions: Johnson-Mercier in every cell.
#[derive(Clone, Debug)]
pub struct EquilibratedStress<S: Recovery = Plane> {
    /// Moments of the facet tractions.
    pub facet_moments: FacetMoments<S>,
    /// The condition on each boundary facet, in the order of the mesh's boundary facets.
    pub conditions: Vec<FacetCondition<S>>,
    /// The FE stress it was recovered from, one per cell, Pa.
    pub finite_element: Vec<S::Tensor>,
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

impl Recovery for Plane {
    fn facet_moments(body: &Body, stress: &[SymTensor2], conditions: &[FacetCondition]) -> FacetMoments {
        eet::facet_moments(body, stress, conditions)
    }

    fn relax(body: &Body, stress: &mut EquilibratedStress, relaxation: Relaxation) -> RelaxationReport {
        crate::star_relaxation::relax_with_stars(body, stress, relaxation, &mut None, None)
    }

    fn distance_squared(body: &Body, stress: &EquilibratedStress) -> f64 {
        crate::cells::distance_squared(body, stress)
    }
}

impl EquilibratedStress {
    /// Computes the loads (traction times length) on the edges of a triangle, N/m.
    #[inline(always)]
    pub fn cell_loads(&self, body: &Body, triangle: usize) -> CellLoads {
        let topology = body.mesh().topology();
        let corners = body.mesh().cells()[triangle];
        let mut loads = CellLoads::default();
        for (k, loads) in loads.iter_mut().enumerate() {
            let edge = topology.cell_facets()[triangle][k];
            let [a, b] = self.facet_moments[edge];
            // |Γ| F_a = 4 b_a − 2 b_b
            let at = |near: Vector, far: Vector| 4.0 * near - 2.0 * far;
            let sign = if topology.facet_cells()[edge][0] as usize == triangle { 1.0 } else { -1.0 };
            let ends = [sign * at(a, b), sign * at(b, a)];
            // An edge begins at its smaller node.
            *loads = if corners[k] < corners[(k + 1) % 3] { ends } else { [ends[1], ends[0]] };
        }
        loads
    }

    /// Computes the stress in a triangle.
    #[inline(always)]
    pub fn cell(&self, body: &Body, triangle: usize) -> CellStress {
        let loads = self.cell_loads(body, triangle);
        johnson_mercier::cell_stress(body.mesh().corners(triangle), &loads, body.body_force())
    }

    /// Computes the distance² to a constant stress in a triangle, in the complementary norm, J/m.
    pub fn cell_distance_squared(&self, body: &Body, triangle: usize, constant: SymTensor2) -> f64 {
        let stress = self.cell(body, triangle);
        johnson_mercier::distance_squared(
            &stress,
            constant,
            body.mesh().measure(triangle),
            body.material(triangle),
        )
    }
}

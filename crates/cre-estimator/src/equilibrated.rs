//! Stresses in exact equilibrium, stored as the moments of their facet tractions.

use crate::fixed::{FixedPart, fixed};
use crate::johnson_mercier::{self, CellLoads, CellStress};
use fem_core::body::{Body, Cut, FacetCondition};
use fem_core::geometry::{Coordinates, Vector};
use fem_core::norm::sum_over_cells;
use fem_core::space::{Plane, Space};
use fem_core::tensor::SymTensor2;

/// Moments `∫_Γ F_Γ φ_j ds` about the nodes of every facet, N/m in the plane, N in space. `F_Γ` acts on the facet's first cell.
pub type FacetMoments<S = Plane> = Vec<<S as Space>::Axes<<S as Space>::Vector>>;

/// A stress in exact equilibrium with given facet tractions: Johnson-Mercier in every cell.
#[derive(Clone, Debug)]
pub struct EquilibratedStress<S: Space = Plane> {
    /// Moments of the facet tractions.
    pub facet_moments: FacetMoments<S>,
    /// The condition on each boundary facet, in the order of the mesh's boundary facets.
    pub conditions: Vec<FacetCondition<S>>,
    /// The FE stress it was recovered from, one per cell, Pa.
    pub finite_element: Vec<S::Tensor>,
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

    /// Computes the stress in a triangle; if the body force varies there, without its quadratic part.
    #[inline(always)]
    pub fn cell(&self, body: &Body, triangle: usize) -> CellStress {
        let mut loads = self.cell_loads(body, triangle);
        if body.has_varying_force()
            && let Some(fixed) = self.fixed(body, triangle)
        {
            subtract(&mut loads, &fixed.loads);
        }
        johnson_mercier::cell_stress(body.mesh().corners(triangle), &loads, body.force(triangle).mean)
    }

    /// Computes the distance² to a constant stress in a triangle, in the complementary norm, J/m.
    pub fn cell_distance_squared(&self, body: &Body, triangle: usize, constant: SymTensor2) -> f64 {
        let mut stress = self.cell(body, triangle);
        let fixed = self.fixed(body, triangle).unwrap_or_default();
        for (stress, offset) in stress.as_flattened_mut().iter_mut().zip(fixed.offset.as_flattened()) {
            *stress = stress.plus(*offset);
        }
        let (area, material) = (body.mesh().measure(triangle), body.material(triangle));
        johnson_mercier::distance_squared(&stress, constant, area, material) + fixed.energy
    }
}

impl<S: Space> EquilibratedStress<S> {
    /// Computes what is fixed in the stress of a cell; `None` if there is nothing.
    pub(crate) fn fixed(&self, body: &Body<S>, cell: usize) -> Option<FixedPart<S>> {
        fixed(body, cell, &self.conditions)
    }
}

/// Subtracts loads.
pub(crate) fn subtract(loads: &mut CellLoads, others: &CellLoads) {
    let others = others.as_flattened();
    loads.as_flattened_mut().iter_mut().zip(others).for_each(|(load, other)| *load -= other);
}

/// Computes `∫ σ : 𝔼⁻¹ τ` of stresses that are constant in each cell, J/m in the plane, J in space.
pub(crate) fn product<S: Space>(body: &Body<S>, stress: &[S::Tensor], other: &[S::Tensor]) -> f64 {
    let of_cell = |cell: usize| {
        body.mesh().measure(cell) * body.material(cell).complementary(stress[cell], other[cell])
    };
    sum_over_cells(stress.len(), of_cell)
}

/// Computes the force in a cut along its axis, and the sum of the sizes of its terms, N/m in the plane, N in space.
pub(crate) fn cut_resultant<S: Space>(body: &Body<S>, cut: &Cut<S>, moments: &FacetMoments<S>) -> [f64; 2] {
    let [mut sum, mut size] = [0.0; 2];
    for (facet, a) in &cut.facets {
        // The traction acts on the first cell of the facet.
        let sign = if body.mesh().topology().facet_cells()[*facet][0] == *a { 1.0 } else { -1.0 };
        for moment in moments[facet.index()] {
            sum += sign * moment.times(&cut.axis);
            size += moment.length();
        }
    }
    [sum, size]
}

/// Adds a multiple of some facet moments to others.
pub(crate) fn add<S: Space>(moments: &mut FacetMoments<S>, factor: f64, others: &FacetMoments<S>) {
    let numbers = moments.iter_mut().flat_map(|of| of.as_mut());
    let others = others.iter().flat_map(|of| of.as_ref());
    numbers.zip(others).for_each(|(sum, part)| *sum += *part * factor);
}

//! The recovery of stresses in the plane.

use crate::equilibrated::{EquilibratedStress, FacetMoments};
use crate::recovery::Recovery;
use crate::relaxation::{Relaxation, RelaxationReport};
use crate::star_relaxation::relax_with_stars;
use crate::{cells, eet};
use fem_core::body::{Body, FacetCondition};
use fem_core::space::Plane;
use fem_core::tensor::SymTensor2;

impl Recovery for Plane {
    fn facet_moments(body: &Body, stress: &[SymTensor2], conditions: &[FacetCondition]) -> FacetMoments {
        eet::facet_moments(body, stress, conditions)
    }

    fn relax(body: &Body, stress: &mut EquilibratedStress, relaxation: Relaxation) -> RelaxationReport {
        relax_with_stars(body, stress, relaxation, &mut None, None)
    }

    fn distance_squared(body: &Body, stress: &EquilibratedStress) -> f64 {
        cells::distance_squared(body, stress)
    }
}

//! Springs between the boundary of a body and the ground.
//!
//! Along their directions the traction is `t = −k (u − u₀)`, with `k` constant and `u₀` linear on each facet. The energy norm of a body on springs is
//! ```math
//! ‖w‖² = a(w, w) + ∫ k w²
//! ```

use super::facet_functions::moments;
use crate::directions::Directions;
use crate::geometry::Coordinates;
use crate::mesh::id::FacetId;
use crate::space::{Plane, Space};

/// All springs on a boundary facet together: the traction `−K (u − u₀)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetSprings<S: Space = Plane> {
    /// The directions in which they act.
    pub directions: Directions<S>,
    /// The rows of `K`, Pa/m.
    pub stiffness: S::Axes<S::Vector>,
    /// The rows of its inverse in these directions, m/Pa.
    pub compliance: S::Axes<S::Vector>,
    /// `u − u₀` at the corners of the facet in these directions, m: in a [`super::Body`] of the displacement zero.
    pub stretch: S::Axes<S::Vector>,
}

impl<S: Space> FacetSprings<S> {
    /// No springs.
    pub const NONE: Self =
        Self { directions: Directions::NONE, stiffness: S::ZEROS, compliance: S::ZEROS, stretch: S::ZEROS };

    /// Returns the same springs after a displacement of the corners of the facet, m.
    #[must_use]
    pub fn stretched(&self, displacement: &S::Axes<S::Vector>) -> Self {
        let stretch = S::axes(|k| self.stretch[k] + self.directions.project(displacement[k]));
        Self { stretch, ..*self }
    }

    /// Computes the traction at the corners, Pa.
    pub fn traction(&self) -> S::Axes<S::Vector> {
        S::axes(|k| -times::<S>(&self.stiffness, self.stretch[k]))
    }

    /// Computes `∫ w·K w`, J/m in the plane, J in space.
    ///
    /// * `field`: w at the corners, m; `measure`: of the facet.
    pub fn energy(&self, field: &S::Axes<S::Vector>, measure: f64) -> f64 {
        product::<S>(field, &S::axes(|k| times::<S>(&self.stiffness, field[k])), measure)
    }

    /// Computes `∫ t·K⁻¹ t` of a traction along the directions, J/m in the plane, J in space.
    ///
    /// * `traction`: t at the corners, Pa; `measure`: of the facet.
    pub fn complementary(&self, traction: &S::Axes<S::Vector>, measure: f64) -> f64 {
        product::<S>(traction, &self.strained(traction), measure)
    }

    /// Computes `K⁻¹ t` at the corners, m.
    pub fn strained(&self, traction: &S::Axes<S::Vector>) -> S::Axes<S::Vector> {
        S::axes(|k| times::<S>(&self.compliance, traction[k]))
    }
}

/// Multiplies a matrix, given by its rows, by a vector.
pub(super) fn times<S: Space>(rows: &S::Axes<S::Vector>, vector: S::Vector) -> S::Vector {
    S::Vector::of(|i| rows[i].times(&vector))
}

/// Computes `∫ a·b` of two linear functions on a facet by their values at its corners.
pub(crate) fn product<S: Space>(a: &S::Axes<S::Vector>, b: &S::Axes<S::Vector>, measure: f64) -> f64 {
    let moments = moments::<S>(b, measure);
    (1..S::DIM).fold(a[0].times(&moments[0]), |sum, k| sum + a[k].times(&moments[k]))
}

/// The springs of one condition on a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringFacet<S: Space = Plane> {
    /// The facet.
    pub facet: FacetId,
    /// The directions in which they act.
    pub directions: Directions<S>,
    /// `k`, Pa/m.
    pub stiffness: f64,
    /// `u₀` at the corners, m.
    pub rest: S::Axes<S::Vector>,
}

/// A side on springs.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringSide<S: Space = Plane> {
    /// The group of facets the condition names.
    pub group: String,
    /// Its facets.
    pub facets: Vec<SpringFacet<S>>,
}

impl<S: Space> SpringSide<S> {
    pub(super) fn facet_ids(&self) -> Vec<FacetId> {
        self.facets.iter().map(|of| of.facet).collect()
    }
}

impl<S: Space> SpringFacet<S> {
    /// Computes the traction on the body at the corners, Pa.
    ///
    /// * `displacement`: of the corners, m.
    pub fn traction(&self, displacement: &S::Axes<S::Vector>) -> S::Axes<S::Vector> {
        S::axes(|k| self.directions.project(displacement[k] - self.rest[k]) * -self.stiffness)
    }

    /// Returns the rows of the projection on the directions, times a factor.
    pub(super) fn rows(&self, factor: f64) -> S::Axes<S::Vector> {
        S::axes(|i| self.directions.project(S::AXES[i]) * factor)
    }
}

#[cfg(test)]
mod tests;

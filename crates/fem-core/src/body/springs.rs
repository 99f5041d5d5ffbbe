//! Springs between the boundary of a body and the ground.
//!
//! Along their directions the traction is `t = −k (u − u₀)`, with `k` constant and `u₀` linear on each facet. The energy norm of a body on springs is
//! ```math
//! ‖w‖² = a(w, w) + ∫ k w²
//! ```

use super::conditions::{Evaluation, SAME_DIRECTION, Selected, finite, linear_by_moments};
use super::{BodyError, ConditionList, ConditionPlace};
use crate::boundary::{BoundaryConditions, SpringCondition, SpringDirection, SpringRest};
use crate::dense::pseudo_inverse;
use crate::directions::Directions;
use crate::geometry::{Coordinates, norm};
use crate::mesh::id::FacetId;
use crate::space::{Plane, Space};
use nalgebra::DMatrix;

/// Springs that are stiffer than the cells beside them by more than this are a support: the rounding of `u` hides their force.
const STIFFEST: f64 = 1e6;

/// Springs that are softer than the cells beside them by more than this hold nothing: the rounding of `u` hides the strains.
const SOFTEST: f64 = 1e12;

/// A singular value of a stiffness below this fraction of the largest one is round-off.
const DEPENDENT: f64 = 1e-12;

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
fn times<S: Space>(rows: &S::Axes<S::Vector>, vector: S::Vector) -> S::Vector {
    S::Vector::of(|i| rows[i].times(&vector))
}

/// Computes `∫ a·b` of two linear functions on a facet by their values at its corners.
pub(crate) fn product<S: Space>(a: &S::Axes<S::Vector>, b: &S::Axes<S::Vector>, measure: f64) -> f64 {
    let moments = moments::<S>(b, measure);
    (1..S::DIM).fold(a[0].times(&moments[0]), |sum, k| sum + a[k].times(&moments[k]))
}

/// Computes `∫ f φ_k` of a linear function on a facet by its values at the corners.
pub fn moments<S: Space>(values: &S::Axes<S::Vector>, measure: f64) -> S::Axes<S::Vector> {
    // ∫ φ_j φ_k is the measure over d (d + 1) on a facet with d corners, twice that if j is k.
    let share = measure / (S::DIM * (S::DIM + 1)) as f64;
    S::axes(|k| {
        let others = (0..S::DIM).filter(|j| *j != k);
        others.fold(values[k] * 2.0, |sum, j| sum + values[j]) * share
    })
}

/// Computes the linear function on a facet, by its values at the corners, that has given moments `∫ f φ_k`.
pub fn tractions<S: Space>(moments: &S::Axes<S::Vector>, measure: f64) -> S::Axes<S::Vector> {
    let values = linear_by_moments::<S, S::Vector>(moments);
    S::axes(|k| values[k] / measure)
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
    fn rows(&self, factor: f64) -> S::Axes<S::Vector> {
        S::axes(|i| self.directions.project(S::AXES[i]) * factor)
    }
}

/// Adds up all springs on a facet.
fn together<S: Space>(all: &[SpringFacet<S>]) -> FacetSprings<S> {
    let (mut stiffness, mut at_zero, mut directions) = (S::ZEROS, S::ZEROS, Directions::NONE);
    for one in all {
        let (rows, traction) = (one.rows(one.stiffness), one.traction(&S::ZEROS));
        for k in 0..S::DIM {
            stiffness[k] += rows[k];
            at_zero[k] += traction[k];
        }
        directions = one.directions.basis().iter().fold(directions, |span, d| span.with(*d, SAME_DIRECTION));
    }
    let compliance = match all {
        [only] => only.rows(1.0 / only.stiffness),
        _ => {
            let matrix = DMatrix::from_fn(S::DIM, S::DIM, |i, j| stiffness[i][j]);
            let zero = DEPENDENT * matrix.norm();
            let inverse = pseudo_inverse(matrix, zero).unwrap_or_else(|| DMatrix::zeros(S::DIM, S::DIM));
            S::axes(|i| S::Vector::of(|j| inverse[(i, j)]))
        }
    };
    let stretch = S::axes(|k| -times::<S>(&compliance, at_zero[k]));
    FacetSprings { directions, stiffness, compliance, stretch }
}

impl<S: Space> Evaluation<'_, S> {
    /// Puts all springs on their facets; returns those of each condition.
    pub(super) fn spring_all(
        &mut self,
        conditions: &BoundaryConditions<S>,
        inherited: Option<&Selected>,
    ) -> Result<Vec<SpringSide<S>>, BodyError> {
        let (mut sides, mut all) = (Vec::new(), Vec::new());
        for (index, condition) in conditions.springs.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Spring, index };
            let facets = self.edges_of(place, &condition.edges, inherited.map(|known| &known.springs))?;
            let mut side = SpringSide { group: condition.edges.on.clone(), facets: Vec::new() };
            for (facet, position) in self.places(&facets) {
                let found = self.springs_on(place, (facet, position), condition)?;
                side.facets.push(found);
                if found.stiffness > 0.0 {
                    all.push((position, found));
                }
            }
            sides.push(side);
        }
        all.sort_by_key(|(position, _)| *position);
        for same in all.chunk_by(|a, b| a.0 == b.0) {
            let springs: Vec<_> = same.iter().map(|(_, springs)| *springs).collect();
            self.facets[same[0].0].springs = together(&springs);
        }
        Ok(sides)
    }

    /// Evaluates the springs of a condition on one facet.
    fn springs_on(
        &self,
        place: ConditionPlace,
        (facet, position): (FacetId, usize),
        condition: &SpringCondition<S>,
    ) -> Result<SpringFacet<S>, BodyError> {
        let (normal, middle) = (self.mesh.facet_normal(facet), self.mesh.facet_middle(facet));
        let held = self.facets[position].reaction;
        let direction = match condition.along {
            SpringDirection::All => None,
            SpringDirection::Normal => Some(normal),
            SpringDirection::Vector(vector) => Some(vector / norm(vector)),
        };
        let occupied = BodyError::SpringOnSupport { place, point: middle.into() };
        let directions = match direction {
            None if held.is_all() => return Err(occupied),
            None if held.is_none() => Directions::ALL,
            None => held.complement(),
            Some(d) if norm(held.components(d)) > SAME_DIRECTION => return Err(occupied),
            Some(d) => Directions::along(d),
        };
        let stiffness = condition.stiffness.at(middle);
        if !(stiffness >= 0.0 && stiffness.is_finite()) {
            return Err(BodyError::Stiffness { place, point: middle.into(), value: stiffness });
        }
        let cell = self.mesh.topology().facet_cells()[facet][0] as usize;
        let size = self.mesh.facet_measure(facet).powf(1.0 / (S::DIM - 1) as f64);
        let ratio = stiffness * size / self.materials.of(cell).axial_modulus();
        if ratio > STIFFEST {
            return Err(BodyError::TooStiff { place, point: middle.into(), ratio });
        }
        if stiffness > 0.0 && ratio * SOFTEST < 1.0 {
            return Err(BodyError::TooSoft { place, point: middle.into(), ratio });
        }
        let corners = self.mesh.facet_corners(facet);
        let mut rest = S::ZEROS;
        for (k, x) in corners.into_iter().enumerate() {
            rest[k] = match &condition.rest {
                SpringRest::Component(data) => {
                    direction.map_or(S::Vector::ZERO, |d| d) * finite(place, x, data.at(x))?
                }
                SpringRest::Vector(all) => {
                    let mut values = S::Vector::ZERO;
                    for c in 0..S::DIM {
                        values[c] = finite(place, x, all[c].at(x))?;
                    }
                    values
                }
            };
        }
        Ok(SpringFacet { facet, directions, stiffness, rest })
    }
}

#[cfg(test)]
mod tests;

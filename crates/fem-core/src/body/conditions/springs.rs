//! Puts springs on the facets that conditions choose.

use super::{Evaluation, SAME_DIRECTION, Selected, finite};
use crate::body::springs::{FacetSprings, SpringFacet, SpringSide, times};
use crate::body::{BodyError, ConditionList, ConditionPlace};
use crate::boundary::{BoundaryConditions, SpringCondition, SpringDirection, SpringRest};
use crate::dense::pseudo_inverse;
use crate::directions::Directions;
use crate::geometry::{Coordinates, norm};
use crate::mesh::id::FacetId;
use crate::space::Space;
use nalgebra::DMatrix;

/// Springs that are stiffer than the cells beside them by more than this are a support: the rounding of `u` hides their force.
const STIFFEST: f64 = 1e6;

/// Springs that are softer than the cells beside them by more than this hold nothing: the rounding of `u` hides the strains.
const SOFTEST: f64 = 1e12;

/// A singular value of a stiffness below this fraction of the largest one is round-off.
const DEPENDENT: f64 = 1e-12;

/// Adds up all springs on a facet.
fn together<S: Space>(all: &[SpringFacet<S>]) -> FacetSprings<S> {
    let (mut stiffness, mut at_zero, mut directions) = (S::ZEROS, S::ZEROS, Directions::NONE);
    for one in all {
        let (rows, traction) = (one.rows(one.stiffness), one.traction(&S::ZEROS));
        for k in 0..S::DIM {
            stiffness[k] += rows[k];
            at_zero[k] += traction[k];
        }
        directions = directions.joined(&one.directions, SAME_DIRECTION);
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

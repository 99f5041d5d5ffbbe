//! The displacement condition of one node.

use crate::directions::{Directions, with_products};
use crate::geometry::{Coordinates, norm};
use crate::space::{Plane, Space};

/// The displacement condition of one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeConstraint<S: Space = Plane> {
    /// The directions in which the displacement is imposed, or follows a rigid side: all of them at such a node.
    pub held: Directions<S>,
    /// Imposed displacement along each vector of the basis of `held`, m; zero beyond. At a node of a rigid side, the displacement that the imposed
    /// part of the side's motion gives.
    pub imposed: S::Vector,
    /// The number of the rigid side that the node follows, if the side is free to move, see [`super::Body::rigid_sides`].
    pub rigid_side: Option<u32>,
}

impl<S: Space> NodeConstraint<S> {
    /// No condition.
    pub const FREE: Self = Self { held: Directions::NONE, imposed: S::Vector::ZERO, rigid_side: None };

    /// Holds a direction that is not held yet.
    ///
    /// * `direction`: unit vector; `value`: the component along it, m.
    pub(super) fn impose(&mut self, direction: S::Vector, value: f64) {
        let (known, imposed) = (self.held, self.imposed);
        self.held = known.with(direction, 0.0);
        let last = known.count();
        self.imposed = match last + 1 {
            1 => S::Vector::of(|k| if k == 0 { value } else { 0.0 }),
            count if count == S::DIM => with_products::<S>(
                S::axes(|k| if k < last { known.basis()[k] } else { direction }),
                S::axes(|k| if k < last { imposed[k] } else { value }),
            ),
            // The new vector of the basis has a part of the known ones taken away from the direction.
            _ => {
                let beside = (value - known.components(direction).times(&imposed))
                    / self.held.basis()[last].times(&direction);
                S::Vector::of(|k| if k == last { beside } else { imposed[k] })
            }
        };
    }

    /// Returns the directions in which supports hold the node: none if it follows a rigid side.
    pub fn supported(&self) -> Directions<S> {
        if self.rigid_side.is_some() { Directions::NONE } else { self.held }
    }

    /// Tells whether supports hold all directions.
    pub fn is_clamped(&self) -> bool {
        self.supported().is_all()
    }

    /// Lists the held directions, each with the component imposed along it, m.
    pub fn components(&self) -> impl Iterator<Item = (S::Vector, f64)> + '_ {
        self.held.basis().iter().copied().zip(self.imposed.entries().iter().copied())
    }

    /// Returns the imposed displacement, m; zero in free directions.
    pub fn displacement(&self) -> S::Vector {
        self.held.combined(self.imposed)
    }

    /// Computes how far a displacement is from the imposed one in the held directions, m.
    pub fn violation(&self, displacement: S::Vector) -> f64 {
        norm(self.held.components(displacement) - self.imposed)
    }

    /// Computes the displacement nearest to a given one that satisfies the condition, m.
    pub fn nearest(&self, displacement: S::Vector) -> S::Vector {
        match self.held.is_all() {
            true => self.displacement(),
            false => displacement + self.held.combined(self.imposed - self.held.components(displacement)),
        }
    }
}

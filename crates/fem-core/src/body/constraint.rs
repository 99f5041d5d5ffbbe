//! The displacement condition of one node.

use crate::directions::{Directions, with_products};
use crate::geometry::{Vector, norm};

/// The displacement condition of one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeConstraint {
    /// The directions in which the displacement is imposed, or follows a rigid side: all of them at such a node.
    pub held: Directions,
    /// Imposed displacement along each vector of the basis of `held`, m; zero beyond. At a node of a rigid side, the displacement that the imposed
    /// part of the side's motion gives.
    pub imposed: Vector,
    /// The number of the rigid side that the node follows, if the side is free to move, see [`super::Body::rigid_sides`].
    pub rigid_side: Option<u32>,
}

impl NodeConstraint {
    /// No condition.
    pub const FREE: Self = Self { held: Directions::NONE, imposed: Vector::new(0.0, 0.0), rigid_side: None };

    /// Holds a direction that is not held yet.
    ///
    /// * `direction`: unit vector; `value`: the component along it, m.
    pub(super) fn impose(&mut self, direction: Vector, value: f64) {
        (self.held, self.imposed) = match self.held.basis() {
            [] => (Directions::along(direction), Vector::new(value, 0.0)),
            [known, ..] => (Directions::ALL, with_products([*known, direction], [self.imposed[0], value])),
        };
    }

    /// Returns the directions in which supports hold the node: none if it follows a rigid side.
    pub fn supported(&self) -> Directions {
        if self.rigid_side.is_some() { Directions::NONE } else { self.held }
    }

    /// Tells whether supports hold all directions.
    pub fn is_clamped(&self) -> bool {
        self.supported().is_all()
    }

    /// Lists the held directions, each with the component imposed along it, m.
    pub fn components(&self) -> impl Iterator<Item = (Vector, f64)> + '_ {
        self.held.basis().iter().copied().zip(self.imposed.iter().copied())
    }

    /// Returns the imposed displacement, m; zero in free directions.
    pub fn displacement(&self) -> Vector {
        self.held.combined(self.imposed)
    }

    /// Computes how far a displacement is from the imposed one in the held directions, m.
    pub fn violation(&self, displacement: Vector) -> f64 {
        norm(self.held.components(displacement) - self.imposed)
    }

    /// Computes the displacement nearest to a given one that satisfies the condition, m.
    pub fn nearest(&self, displacement: Vector) -> Vector {
        match self.held.is_all() {
            true => self.displacement(),
            false => displacement + self.held.combined(self.imposed - self.held.components(displacement)),
        }
    }
}

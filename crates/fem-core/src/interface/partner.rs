//! A body or an obstacle.

use std::fmt::{self, Display};

/// A body or an obstacle, by its number among the bodies or the obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Partner {
    /// An elastic body.
    Body(usize),
    /// A rigid obstacle.
    Obstacle(usize),
}

impl Partner {
    /// Returns the number of the body; `None` for an obstacle.
    pub fn body(self) -> Option<usize> {
        match self {
            Self::Body(body) => Some(body),
            Self::Obstacle(_) => None,
        }
    }

    /// Tells whether it is an obstacle.
    pub fn is_obstacle(self) -> bool {
        self.body().is_none()
    }

    /// Returns its place in a list of all bodies and then all obstacles.
    ///
    /// * `bodies`: their number.
    pub fn place(self, bodies: usize) -> usize {
        match self {
            Self::Body(body) => body,
            Self::Obstacle(obstacle) => bodies + obstacle,
        }
    }
}

impl Display for Partner {
    /// Counts from 1.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Body(body) => write!(f, "body {}", body + 1),
            Self::Obstacle(obstacle) => write!(f, "obstacle {}", obstacle + 1),
        }
    }
}

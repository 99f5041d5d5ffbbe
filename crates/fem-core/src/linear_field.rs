//! Vector fields that are linear in the position.

use crate::space::{Plane, Space};

/// A vector field that is linear in the position, `value + Σ_j gradient_j (x − point)_j`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearField<S: Space = Plane> {
    /// A point, m.
    pub point: S::Vector,
    /// The value there.
    pub value: S::Vector,
    /// The derivative along each axis, per m.
    pub gradient: S::Axes<S::Vector>,
}

impl<S: Space> LinearField<S> {
    /// Evaluates the field.
    pub fn at(&self, x: S::Vector) -> S::Vector {
        self.value + along::<S>(&self.gradient, x - self.point)
    }
}

/// Computes `Σ_j gradient_j arm_j`.
pub(crate) fn along<S: Space>(gradient: &S::Axes<S::Vector>, arm: S::Vector) -> S::Vector {
    (1..S::DIM).fold(gradient[0] * arm[0], |sum, j| sum + gradient[j] * arm[j])
}

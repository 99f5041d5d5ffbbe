//! Rotations, moments and forces of friction.

use serde::{Deserialize, Serialize};

/// A rotation, a moment or a force of friction: a number in the plane, the components of a vector in space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Spin {
    /// About the z axis, positive counter-clockwise; friction along the tangent.
    Plane(f64),
    /// About the axes x, y and z.
    Solid([f64; 3]),
}

impl Default for Spin {
    fn default() -> Self {
        Self::Plane(0.0)
    }
}

impl Spin {
    /// Returns the number, or the length of the vector.
    pub fn size(&self) -> f64 {
        match self {
            Self::Plane(number) => *number,
            Self::Solid(vector) => vector.iter().map(|x| x * x).sum::<f64>().sqrt(),
        }
    }

    /// Returns its components.
    pub fn components(&self) -> &[f64] {
        match self {
            Self::Plane(number) => std::slice::from_ref(number),
            Self::Solid(vector) => vector,
        }
    }
}

//! Rotations and moments.

use serde::Serialize;

/// A rotation or a moment: a number in the plane, the components of a vector in space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "read-report", derive(serde::Deserialize))]
#[serde(untagged)]
pub enum Spin {
    /// About the z axis, positive counter-clockwise.
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
    /// Returns its components.
    pub fn components(&self) -> &[f64] {
        match self {
            Self::Plane(number) => std::slice::from_ref(number),
            Self::Solid(vector) => vector,
        }
    }
}

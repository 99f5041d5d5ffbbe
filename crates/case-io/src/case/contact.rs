//! `[[contact]]`: which sides touch, and what a side may touch besides another body.

use super::{Imposed, Value};
use fem_core::interface::{self, RigidLine};
use serde::Serialize;

/// `[[contact]]`, or the single table `[contact]`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Contact {
    /// Its name, which also names its output files.
    pub name: String,
    /// The bodies, by their numbers in the file's order: two, or one before an obstacle.
    pub bodies: Vec<usize>,
    /// An edge group of each of these bodies.
    pub surfaces: Vec<String>,
    /// The obstacle that the only body touches; `None` for a pair of bodies.
    pub obstacle: Option<Obstacle>,
    /// Initial gap, m, ≥ 0; it overrides the geometry.
    pub gap: Value,
    /// `gap = "geometric"`: the gap is measured between the meshes along the contact normal.
    pub geometric: bool,
    /// A fixed direction of contact, out of the first body; averaged at the nodes if it is left out.
    pub normal: Option<[f64; 2]>,
    /// Which body of this pair carries λ, if not the one that the solver chooses for all.
    pub imposed: Option<Imposed>,
    /// The law of friction; `None`: the surfaces slide freely.
    pub friction: Option<Friction>,
    /// The path of its table: `contact`, or `contact.` and its number.
    pub(crate) path: String,
}

impl Contact {
    /// Returns its name as the stem of a file name, see [`super::BodyCase::file_stem`].
    pub fn file_stem(&self) -> String {
        super::body::file_stem(&self.name)
    }
}

/// `friction`: how much traction along the contact line a pair resists.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "law", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Friction {
    /// A given limit.
    Tresca {
        /// Largest traction along the contact line, Pa, ≥ 0.
        limit: Value,
    },
    /// A limit in proportion to the pressure.
    Coulomb {
        /// The coefficient, ≥ 0.
        mu: f64,
    },
}

impl Friction {
    /// Returns the name of the law in the case file.
    pub fn law(&self) -> &'static str {
        match self {
            Self::Tresca { .. } => "tresca",
            Self::Coulomb { .. } => "coulomb",
        }
    }

    /// Returns the law of fem-core.
    pub(super) fn of_core(&self) -> interface::Friction {
        match self {
            Self::Tresca { limit } => interface::Friction::tresca(limit.scalar()),
            Self::Coulomb { mu } => interface::Friction::Coulomb { mu: *mu },
        }
    }
}

/// `obstacle`: a rigid line, fixed, moved, or free to move under a force.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Obstacle {
    /// Its shape.
    #[serde(flatten)]
    pub shape: Shape,
    /// Its imposed motion and its loads.
    #[serde(flatten)]
    pub rigid: Rigid,
}

/// The shape of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Shape {
    /// A straight line.
    Plane {
        /// A point of it, m.
        point: [f64; 2],
        /// Out of the obstacle; of any length except zero.
        normal: [f64; 2],
    },
    /// A circle.
    Circle {
        /// Centre, m.
        centre: [f64; 2],
        /// Radius, m.
        radius: f64,
        /// On which side of it the body is.
        side: CircleSide,
    },
}

/// The side of a circle on which a body is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CircleSide {
    /// The body is outside; the obstacle is a disc.
    #[default]
    Outside,
    /// The body is inside; the obstacle is a hole.
    Inside,
}

/// The motion of something rigid: each component is imposed, or free under its load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Rigid {
    /// Imposed displacement in x, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ux: Option<f64>,
    /// Imposed displacement in y, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uy: Option<f64>,
    /// Imposed rotation, radians, counter-clockwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<f64>,
    /// Resultant of the load, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<[f64; 2]>,
    /// Moment of the load about [`Self::about`], N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moment: Option<f64>,
    /// The point about which it rotates, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub about: Option<[f64; 2]>,
}

impl Shape {
    /// Returns the line of fem-core.
    pub(super) fn of_core(&self) -> RigidLine {
        match *self {
            Self::Plane { point, normal } => RigidLine::Plane { point: point.into(), normal: normal.into() },
            Self::Circle { centre, radius, side } => {
                RigidLine::Circle { centre: centre.into(), radius, inside: side == CircleSide::Inside }
            }
        }
    }
}

impl Obstacle {
    /// Returns the obstacle of fem-core.
    pub(super) fn of_core(&self) -> interface::Obstacle {
        let Rigid { ux, uy, rotation, force, moment, about } = self.rigid;
        let fixed = interface::Obstacle::fixed(self.shape.of_core());
        let about = about.unwrap_or(fixed.about.into());
        fixed.stamp([ux, uy, rotation], (force.unwrap_or_default(), moment.unwrap_or_default()), about)
    }
}

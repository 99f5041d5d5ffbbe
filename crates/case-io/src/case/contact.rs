//! `[[contact]]`: which sides touch, and what a side may touch besides another body.

use super::{Dimension, Imposed, Value};
use fem_core::geometry::Coordinates;
use fem_core::interface::{self, RigidLine};
use fem_core::space::{Plane, Space};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// `[[contact]]`, or the single table `[contact]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Contact<S: Dimension = Plane> {
    /// Its name, which also names its output files.
    pub name: String,
    /// The bodies, by their numbers in the file's order: two, or one before an obstacle.
    pub bodies: Vec<usize>,
    /// A side of each of these bodies.
    pub surfaces: Vec<String>,
    /// The obstacle that the only body touches; `None` for a pair of bodies.
    pub obstacle: Option<Obstacle<S>>,
    /// True if the file gives the name: load steps can scale the gap by it.
    pub(crate) named: bool,
    /// Initial gap, m; it overrides the geometry. A negative one is an interference.
    pub gap: Value,
    /// `gap = "geometric"`: the gap is measured between the meshes along the contact normal.
    pub geometric: bool,
    /// True if a measured gap keeps an overlap that is drawn.
    pub interference: bool,
    /// `law = "bonded"` with its `offset`, the displacement of the first body less that of the second, m; `None`: they touch and part.
    pub bond: Option<S::Axes<f64>>,
    /// A fixed direction of contact, out of the first body; averaged at the nodes if it is left out.
    pub normal: Option<S::Axes<f64>>,
    /// Which body of this pair carries λ, if not the one that the solver chooses for all.
    pub imposed: Option<Imposed>,
    /// The law of friction; `None`: the surfaces slide freely.
    pub friction: Option<Friction>,
    /// The path of its table: `contact`, or `contact.` and its number.
    pub(crate) path: String,
}

impl<S: Dimension> Contact<S> {
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
    pub(super) fn of_core<S: Space>(&self) -> interface::Friction<S> {
        match self {
            Self::Tresca { limit } => interface::Friction::tresca(limit.scalar::<S>()),
            Self::Coulomb { mu } => interface::Friction::Coulomb { mu: *mu },
        }
    }
}

/// `obstacle`: a rigid line, in space a surface, fixed, moved, or free to move under a force.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(bound = "")]
#[non_exhaustive]
pub struct Obstacle<S: Dimension = Plane> {
    /// Its shape.
    #[serde(flatten)]
    pub shape: Shape<S>,
    /// Its imposed motion and its loads.
    #[serde(flatten)]
    pub rigid: Rigid<S>,
}

/// The shape of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape<S: Dimension = Plane> {
    /// A straight line, or a plane.
    Plane {
        /// A point of it, m.
        point: S::Axes<f64>,
        /// Out of the obstacle; of any length except zero.
        normal: S::Axes<f64>,
    },
    /// A circle, or a sphere.
    Circle {
        /// Centre, m.
        centre: S::Axes<f64>,
        /// Radius, m.
        radius: f64,
        /// On which side of it the body is.
        side: CircleSide,
    },
    /// A cylinder without ends, for solids.
    Cylinder {
        /// A point of its axis, m.
        point: S::Axes<f64>,
        /// Along its axis; of any length except zero.
        axis: S::Axes<f64>,
        /// Radius, m.
        radius: f64,
        /// On which side of it the body is.
        side: CircleSide,
    },
}

/// The side of a circle, a sphere or a cylinder on which a body is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CircleSide {
    /// The body is outside; the obstacle is a disc, a ball or a round bar.
    #[default]
    Outside,
    /// The body is inside; the obstacle is a hole, a hollow or a bore.
    Inside,
}

/// The motion of something rigid: each component is imposed, or free under its load.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rigid<S: Dimension = Plane> {
    /// Imposed displacements along the axes, m, and rotations, radians; `None`: free.
    pub motion: S::Components<Option<f64>>,
    /// Resultant of the load, N/m in the plane, N in space.
    pub force: Option<S::Axes<f64>>,
    /// Moment of the load about [`Self::about`], N in the plane, N m in space.
    pub moment: Option<S::Spin>,
    /// The point about which it rotates, m.
    pub about: Option<S::Axes<f64>>,
}

impl<S: Dimension> Default for Rigid<S> {
    fn default() -> Self {
        Self { motion: S::components(|_| None), force: None, moment: None, about: None }
    }
}

impl<S: Dimension> Serialize for Rigid<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let mut map = serializer.serialize_map(None)?;
        for k in 0..S::DIM {
            if let Some(u) = self.motion[k] {
                map.serialize_entry(S::MOTIONS[k], &u)?;
            }
        }
        // The components of a rotation are given together.
        if self.motion.into_iter().skip(S::DIM).all(|component| component.is_some()) {
            let motion = S::components(|k| self.motion[k].unwrap_or_default());
            map.serialize_entry("rotation", &S::spin_written(S::parts(&motion).1))?;
        }
        if let Some(force) = &self.force {
            map.serialize_entry("force", force.as_ref())?;
        }
        if let Some(moment) = self.moment {
            map.serialize_entry("moment", &S::spin_written(moment))?;
        }
        if let Some(about) = &self.about {
            map.serialize_entry("about", about.as_ref())?;
        }
        map.end()
    }
}

impl<S: Dimension> Rigid<S> {
    /// Returns the resultant of the load, zero by default.
    pub(super) fn force(&self) -> S::Vector {
        self.force.as_ref().map_or(S::Vector::ZERO, S::vector)
    }
}

impl<S: Dimension> Serialize for Shape<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self {
            Self::Plane { point, normal } => {
                map.serialize_entry("kind", "plane")?;
                map.serialize_entry("point", point.as_ref())?;
                map.serialize_entry("normal", normal.as_ref())?;
            }
            Self::Circle { centre, radius, side } => {
                map.serialize_entry("kind", S::CIRCLE)?;
                map.serialize_entry("centre", centre.as_ref())?;
                map.serialize_entry("radius", radius)?;
                map.serialize_entry("side", side)?;
            }
            Self::Cylinder { point, axis, radius, side } => {
                map.serialize_entry("kind", "cylinder")?;
                map.serialize_entry("point", point.as_ref())?;
                map.serialize_entry("axis", axis.as_ref())?;
                map.serialize_entry("radius", radius)?;
                map.serialize_entry("side", side)?;
            }
        }
        map.end()
    }
}

impl<S: Dimension> Shape<S> {
    /// Returns the line of fem-core.
    pub(super) fn of_core(&self) -> RigidLine<S> {
        match self {
            Self::Plane { point, normal } => {
                RigidLine::Plane { point: S::vector(point), normal: S::vector(normal) }
            }
            Self::Circle { centre, radius, side } => RigidLine::Circle {
                centre: S::vector(centre),
                radius: *radius,
                inside: *side == CircleSide::Inside,
            },
            Self::Cylinder { point, axis, radius, side } => RigidLine::Cylinder {
                point: S::vector(point),
                axis: S::vector(axis),
                radius: *radius,
                inside: *side == CircleSide::Inside,
            },
        }
    }
}

impl<S: Dimension> Obstacle<S> {
    /// Returns the obstacle of fem-core.
    pub(super) fn of_core(&self) -> interface::Obstacle<S> {
        let Rigid { motion, moment, about, .. } = self.rigid;
        let fixed = interface::Obstacle::fixed(self.shape.of_core());
        let about = about.as_ref().map_or(fixed.about, S::vector);
        fixed.stamp(motion, (self.rigid.force(), moment.unwrap_or_default()), about)
    }
}

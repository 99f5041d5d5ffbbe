//! Straight lines, circles, planes, spheres and cylinders: of rigid obstacles, and of declared surfaces.

use crate::geometry::{Coordinates, norm};
use crate::space::{Plane, Space};

/// The line of a rigid obstacle, in space its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidLine<S: Space = Plane> {
    /// A straight line, or a plane.
    Plane {
        /// A point of it, m.
        point: S::Vector,
        /// Out of the obstacle, to the body; of any length except zero.
        normal: S::Vector,
    },
    /// A circle, or a sphere.
    Circle {
        /// Its centre, m.
        centre: S::Vector,
        /// Its radius, m.
        radius: f64,
        /// True if the body is inside, so that the obstacle is a hole.
        inside: bool,
    },
    /// An endless cylinder in space; in the plane a strip.
    Cylinder {
        /// A point of its axis, m.
        point: S::Vector,
        /// The direction of its axis, of any length except zero.
        axis: S::Vector,
        /// Its radius, m.
        radius: f64,
        /// True if the body is inside, so that the obstacle is a bore.
        inside: bool,
    },
}

impl<S: Space> RigidLine<S> {
    /// Computes the distance of a point from the line, m, negative inside the obstacle, and the unit normal out of the
    /// body, into the obstacle.
    pub fn distance(&self, point: S::Vector) -> (f64, S::Vector) {
        match *self {
            Self::Plane { point: origin, normal } => {
                let out = normal / norm(normal);
                ((point - origin).times(&out), -out)
            }
            Self::Circle { centre, radius, inside } => round::<S>(point - centre, radius, inside),
            Self::Cylinder { point: start, axis, radius, inside } => {
                round::<S>(across::<S>(point - start, axis), radius, inside)
            }
        }
    }

    /// Computes the frozen normal of a body at a point, into the obstacle: `±(x − c)/R` if it is round, from its centre or its axis, and of length
    /// one if it is a plane. With one `R` for all nodes, `n_i·(ω × x_j) + n_j·(ω × x_i) = 0`: rotations about the centre or the axis open nothing.
    pub fn frozen_normal(&self, point: S::Vector) -> S::Vector {
        let out =
            |arm: S::Vector, radius: f64, inside: bool| arm * (if inside { 1.0 } else { -1.0 } / radius);
        match *self {
            Self::Plane { .. } => self.distance(point).1,
            Self::Circle { centre, radius, inside } => out(point - centre, radius, inside),
            Self::Cylinder { point: start, axis, radius, inside } => {
                out(across::<S>(point - start, axis), radius, inside)
            }
        }
    }
}

/// Computes the part of an arm across an axis.
fn across<S: Space>(arm: S::Vector, axis: S::Vector) -> S::Vector {
    arm - axis * (arm.times(&axis) / axis.times(&axis))
}

/// Computes distance and normal of a round obstacle, see [`RigidLine::distance`].
///
/// * `arm`: from its centre or its axis.
fn round<S: Space>(arm: S::Vector, radius: f64, inside: bool) -> (f64, S::Vector) {
    let length = norm(arm);
    let out = if length > 0.0 { arm * (1.0 / length) } else { S::AXES[0] };
    if inside { (radius - length, out) } else { (length - radius, -out) }
}

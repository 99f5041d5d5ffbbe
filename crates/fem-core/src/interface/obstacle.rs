//! Rigid obstacles: lines that do not deform, held or moved, or free to move under a force.

use super::{ContactInterface, NodePair};
use crate::body::{Body, RigidMotion};
use crate::geometry::{self, Coordinates, norm};
use crate::rigid_line::RigidLine;
use crate::space::{Plane, Space};

/// A rigid obstacle in a pair with one body: each component of its motion is imposed, or free under its load.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Obstacle<S: Space = Plane> {
    /// Its line.
    pub line: RigidLine<S>,
    /// Imposed displacements along the axes, m, and rotations about [`Self::about`], radians, in the order of [`Space::MOTIONS`]; `None`: free.
    pub motion: S::Components<Option<f64>>,
    /// Resultant of its load, N/m; it acts along free components only.
    pub force: S::Vector,
    /// Moment of its load about [`Self::about`], N.
    pub moment: S::Spin,
    /// The point about which it rotates, m.
    pub about: S::Vector,
    /// The point that faces each contact node of the body, m; set by [`super::ContactProblem::obstacle`].
    pub(super) points: Vec<S::Vector>,
}

impl<S: Space> Obstacle<S> {
    /// Creates a fixed obstacle.
    pub fn fixed(line: RigidLine<S>) -> Self {
        let about = match line {
            RigidLine::Plane { point, .. } | RigidLine::Cylinder { point, .. } => point,
            RigidLine::Circle { centre, .. } => centre,
        };
        Self {
            line,
            motion: S::components(|_| Some(0.0)),
            force: S::Vector::ZERO,
            moment: S::Spin::default(),
            about,
            points: Vec::new(),
        }
    }

    /// Imposes a translation.
    ///
    /// * `by`: the displacement, m.
    #[must_use]
    pub fn moved(mut self, by: impl Into<S::Vector>) -> Self {
        let by = by.into();
        self.motion = S::components(|k| if k < S::DIM { Some(by[k]) } else { self.motion[k] });
        self
    }

    /// Lets the components without an imposed value move under a load.
    ///
    /// * `motion`: imposed values, see [`Self::motion`]; `None`: free. `force`, N/m, and `moment` about `about`, N.
    #[must_use]
    pub fn stamp(
        mut self,
        motion: S::Components<Option<f64>>,
        (force, moment): (impl Into<S::Vector>, S::Spin),
        about: impl Into<S::Vector>,
    ) -> Self {
        self.motion = motion;
        (self.force, self.moment, self.about) = (force.into(), moment, about.into());
        self
    }

    /// Returns the points that face the contact nodes, m.
    pub fn points(&self) -> &[S::Vector] {
        &self.points
    }

    /// Computes the imposed displacement of each of its points, m: zero along free components.
    pub fn imposed(&self) -> Vec<S::Vector> {
        self.points.iter().map(|p| self.imposed_at(*p)).collect()
    }

    fn imposed_at(&self, point: S::Vector) -> S::Vector {
        let (translation, spin) = S::parts(&S::components(|k| self.motion[k].unwrap_or(0.0)));
        translation + S::turned(spin, point - self.about)
    }

    /// Tells whether its motion is imposed.
    pub fn is_held(&self) -> bool {
        self.motion.as_ref().iter().all(Option::is_some)
    }

    /// Returns what is imposed on a node of a body and on the obstacle's point that faces it, if a support clamps the node, m.
    pub(super) fn clamped(&self, body: &Body<S>, pair: &NodePair<S>) -> Option<[S::Vector; 2]> {
        let constraint = &body.node_constraints()[pair.nodes[0]];
        let facing = || self.imposed_at(self.point_facing(body, pair));
        constraint.is_clamped().then(|| [constraint.displacement(), facing()])
    }

    /// Returns the nearest point to a node; the node itself if its normal is not of length one. Both move alike along the normal, and between
    /// nodes a rotation about the centre then opens nothing.
    fn point_facing(&self, body: &Body<S>, pair: &NodePair<S>) -> S::Vector {
        let point = body.mesh().points()[pair.nodes[0]];
        if pair.normal_length() != 1.0 {
            return point;
        }
        point + pair.normal * self.line.distance(point).0
    }

    /// Lists its free motions, each with the work of the load along a unit of the motion.
    pub fn free_motions(&self) -> Vec<(RigidMotion<S>, f64)> {
        let size = self.size();
        let load = S::motion(self.force, self.moment);
        let free = (0..S::COMPONENTS).filter(|k| self.motion[*k].is_none());
        free.map(|k| {
            // A rotation is scaled so that it is comparable with a translation.
            let unit = if k < S::DIM { 1.0 } else { 1.0 / size };
            let (translation, spin) = S::parts(&S::components(|j| if j == k { unit } else { 0.0 }));
            let motion = RigidMotion { piece: 0, translation, spin, centre: self.about };
            (motion, if k < S::DIM { load[k] } else { load[k] / size })
        })
        .collect()
    }

    /// Computes the size of its load, N/m: the moment counts by the size of the contact.
    pub fn load_size(&self) -> f64 {
        let load = S::motion(self.force, self.moment);
        let moments = (S::DIM..S::COMPONENTS).map(|k| load[k].abs());
        norm(self.force) + moments.fold(0.0, f64::hypot) / self.size()
    }

    /// Returns the size of the contact, m.
    fn size(&self) -> f64 {
        geometry::diagonal(&self.points).max(f64::MIN_POSITIVE)
    }

    /// Computes the displacement of each of its points in a rigid motion, m.
    pub(crate) fn moved_by(&self, motion: &RigidMotion<S>) -> Vec<S::Vector> {
        self.points.iter().map(|p| motion.at(*p)).collect()
    }

    /// Takes the points that face the contact nodes of its body.
    pub(super) fn facing(mut self, body: &Body<S>, interface: &ContactInterface<S>) -> Self {
        self.points = interface.pairs().iter().map(|pair| self.point_facing(body, pair)).collect();
        self
    }
}

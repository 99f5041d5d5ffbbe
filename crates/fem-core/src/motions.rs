//! The rigid motions that the supports of the bodies leave free.

use crate::assembly::external_forces;
use crate::body::RigidMotion;
use crate::geometry::Vector;
use crate::interface::{ContactProblem, LeftOut};

/// The load of a motion below this fraction of its terms is the rounding of their sum.
const ROUNDING: f64 = 1e-13;

/// A rigid motion that the supports of a body leave free, with the load along it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyMotion {
    /// The body, or the obstacle: these are numbered after the bodies.
    pub body: usize,
    /// The motion `R`.
    pub motion: RigidMotion,
    /// `e = f·R`, the work of tractions and body force along the motion, N/m times the motion's unit.
    pub load: f64,
}

impl BodyMotion {
    /// Takes a motion without a load.
    pub fn new(body: usize, motion: RigidMotion) -> Self {
        Self { body, motion, load: 0.0 }
    }
}

impl ContactProblem {
    /// Lists the rigid motions of all floating bodies and of the obstacles that are free to move, in their order: for each
    /// of them a basis.
    pub fn rigid_motions(&self) -> Vec<BodyMotion> {
        self.rigid_motions_under(&self.bodies.iter().map(external_forces).collect::<Vec<_>>())
    }

    /// * `external_forces`: of each body, N/m.
    pub(crate) fn rigid_motions_under(&self, external_forces: &[Vec<Vector>]) -> Vec<BodyMotion> {
        let mut found = Vec::new();
        for (b, body) in self.bodies.iter().enumerate() {
            for motion in body.rigid_motions() {
                let moved = motion.displacements(body);
                let terms = || external_forces[b].iter().zip(&moved).map(|(f, u)| f.dot(u));
                let (load, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
                let load = if load.abs() > ROUNDING * size { load } else { 0.0 };
                found.push(BodyMotion { body: b, motion, load });
            }
        }
        for (k, obstacle) in self.obstacles.iter().enumerate() {
            let of = |(motion, load)| BodyMotion { body: self.bodies.len() + k, motion, load };
            found.extend(obstacle.free_motions().into_iter().map(of));
        }
        found
    }

    /// Leaves the load along a rotation of a body out: a constant traction along its whole boundary, without resultant, balances it.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn leave_out(&mut self, body: usize, motion: RigidMotion) {
        let of = &self.bodies[body];
        let (forces, moved) = (external_forces(of), motion.displacements(of));
        let load: f64 = forces.iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
        let size: f64 = forces.iter().zip(&moved).map(|(f, u)| f.norm() * u.norm()).sum();
        let area: f64 = (0..of.mesh().triangles().len()).map(|t| of.mesh().area(t)).sum();
        self.bodies[body].turn(-load / (2.0 * area * motion.spin));
        self.left_out.push(LeftOut { body, motion, load, share: load.abs() / size });
    }

    /// Computes the displacement of each node in a rigid motion of its body, or of each point of its obstacle, m.
    pub fn moved_by(&self, of: &BodyMotion) -> Vec<Vector> {
        match self.bodies.get(of.body) {
            Some(body) => of.motion.displacements(body),
            None => self.obstacles[of.body - self.bodies.len()].moved_by(&of.motion),
        }
    }
}

//! The rigid motions that the supports of the bodies leave free.

use crate::assembly::external_forces;
use crate::body::RigidMotion;
use crate::geometry::{Coordinates, perpendicular};
use crate::interface::{ContactProblem, LeftOut, Partner};
use crate::space::{Plane, Space};

/// The load of a motion below this fraction of its terms is the rounding of their sum.
const ROUNDING: f64 = 1e-13;

/// Centres closer than this fraction of the radius of a line are the same.
const SAME_CENTRE: f64 = 1e-6;

/// A rigid motion that the supports of a body leave free, with the load along it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyMotion<S: Space = Plane> {
    /// The body or the obstacle.
    pub partner: Partner,
    /// The motion `R`.
    pub motion: RigidMotion<S>,
    /// `e = f·R`, the work of tractions and body force along the motion, N/m times the motion's unit.
    pub load: f64,
}

impl<S: Space> BodyMotion<S> {
    /// Takes a motion without a load.
    pub fn new(partner: Partner, motion: RigidMotion<S>) -> Self {
        Self { partner, motion, load: 0.0 }
    }
}

/// A rigid motion of an assembly.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AssemblyMotion<S: Space = Plane> {
    /// The bodies and obstacles that move, each with its motion; the largest displacement of all is 1 m.
    pub bodies: Vec<(Partner, RigidMotion<S>)>,
    /// The largest displacement of each of them, m.
    pub largest: Vec<f64>,
    /// The load along the motion: its work over its largest displacement, N/m.
    pub load: f64,
}

impl<S: Space> ContactProblem<S> {
    /// Sums up rigid motions to one of the assembly.
    ///
    /// * `motions`: see [`Self::rigid_motions`]; `amounts`: number and amount, by number; `work`: of the loads along their sum, J/m; `least`: bodies
    ///   that move by at most this fraction of the one that moves most do not count.
    ///
    /// # Panics
    /// If there is no such motion.
    pub fn assembly_motion(
        &self,
        motions: &[BodyMotion<S>],
        amounts: &[(usize, f64)],
        work: f64,
        least: f64,
    ) -> AssemblyMotion<S> {
        let mut bodies: Vec<BodyMotion<S>> = Vec::new();
        for (number, amount) in amounts {
            let of = &motions[*number];
            let scaled = BodyMotion { motion: of.motion.scaled(*amount), ..*of };
            let mut of_body = bodies.iter_mut().rev().take_while(|known| known.partner == of.partner);
            match of_body.find(|known| known.motion.piece == of.motion.piece) {
                Some(sum) => {
                    sum.motion.translation += scaled.motion.translation;
                    sum.motion.spin += scaled.motion.spin;
                }
                None => bodies.push(scaled),
            }
        }
        let sizes: Vec<f64> = bodies.iter().map(|of| largest(&self.moved_by(of))).collect();
        let most = sizes.iter().copied().fold(0.0, f64::max);
        let moved = bodies.iter().zip(&sizes).filter(|(_, size)| **size > least * most);
        let (bodies, largest) =
            moved.map(|(of, size)| ((of.partner, of.motion.scaled(1.0 / most)), size / most)).unzip();
        AssemblyMotion { bodies, largest, load: work / most }
    }

    /// Lists the rigid motions of all floating bodies and of the obstacles that are free to move, in their order: for each
    /// of them a basis.
    pub fn rigid_motions(&self) -> Vec<BodyMotion<S>> {
        self.rigid_motions_under(&self.bodies.iter().map(external_forces).collect::<Vec<_>>())
    }

    /// * `external_forces`: of each body, N/m.
    pub(crate) fn rigid_motions_under(&self, external_forces: &[Vec<S::Vector>]) -> Vec<BodyMotion<S>> {
        let mut found = Vec::new();
        for (b, body) in self.bodies.iter().enumerate() {
            for motion in body.rigid_motions() {
                let moved = motion.displacements(body);
                let terms = || external_forces[b].iter().zip(&moved).map(|(f, u)| f.times(u));
                let (load, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
                let load = if load.abs() > ROUNDING * size { load } else { 0.0 };
                found.push(BodyMotion { partner: Partner::Body(b), motion, load });
            }
        }
        for (k, obstacle) in self.obstacles.iter().enumerate() {
            let of = |(motion, load)| BodyMotion { partner: Partner::Obstacle(k), motion, load };
            found.extend(obstacle.free_motions().into_iter().map(of));
        }
        found
    }

    /// Computes the displacement of each node in a rigid motion of its body, or of each point of its obstacle, m.
    pub fn moved_by(&self, of: &BodyMotion<S>) -> Vec<S::Vector> {
        match of.partner {
            Partner::Body(body) => of.motion.displacements(&self.bodies[body]),
            Partner::Obstacle(obstacle) => self.obstacles[obstacle].moved_by(&of.motion),
        }
    }
}

impl ContactProblem {
    /// Leaves the loads along some motions out, if each of them is a rotation about the centre of all contact lines of a body that only they hold,
    /// with a load that the error of the polygon explains:
    /// ```math
    /// |e·a| ≤ ∑_i P_i |(n_i − (x_i − c)/R)·R a|
    /// ```
    /// with the means `n_i` of the polygon's normals. `None` if one is not.
    ///
    /// * `motion`: of the assembly; `forces`: `P`, which balance all other loads, by row, N/m.
    pub fn without_spins(&self, motion: &AssemblyMotion, forces: &[f64]) -> Option<Self> {
        let mut without = self.clone();
        for (&(partner, motion), size) in motion.bodies.iter().zip(&motion.largest) {
            let unit = motion.scaled(1.0 / size);
            let body = partner.body()?;
            if !self.is_explained(body, unit, forces) {
                return None;
            }
            without.leave_out(body, unit);
        }
        Some(without)
    }

    /// * `motion`: whose largest displacement is 1 m.
    fn is_explained(&self, body: usize, motion: RigidMotion, forces: &[f64]) -> bool {
        let of = &self.bodies[body];
        if !of.has_no_support() || motion.spin == 0.0 {
            return false;
        }
        let centre = motion.centre + 1.0 / motion.spin * perpendicular(motion.translation);
        let moved = motion.displacements(of);
        let mut allowed = 0.0;
        for (pair, rows) in self.contacts.iter().zip(self.normal_rows()) {
            let Some(side) = pair.side_of(Partner::Body(body)) else { continue };
            let Some(own) = pair.interface.centre() else { return false };
            // The largest displacement is 1 m, at the radius 1/|spin|.
            if !((own - centre).norm() * motion.spin.abs() <= SAME_CENTRE) {
                return false;
            }
            let polygon = pair.interface.polygon_normals(of, side);
            for ((node, polygon), force) in pair.interface.pairs().iter().zip(&polygon).zip(&forces[rows]) {
                allowed += force * (polygon - node.normal).dot(&moved[node.nodes[side]]).abs();
            }
        }
        let load: f64 = external_forces(of).iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
        load.abs() <= allowed
    }

    /// Leaves the load along a rotation of a body out: a constant traction along its whole boundary, without resultant, balances it.
    fn leave_out(&mut self, body: usize, motion: RigidMotion) {
        let of = &self.bodies[body];
        let (forces, moved) = (external_forces(of), motion.displacements(of));
        let load: f64 = forces.iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
        let size: f64 = forces.iter().zip(&moved).map(|(f, u)| f.norm() * u.norm()).sum();
        let area: f64 = (0..of.mesh().cells().len()).map(|t| of.mesh().measure(t)).sum();
        self.bodies[body].turn(-load / (2.0 * area * motion.spin));
        self.left_out.push(LeftOut { body, motion, load, share: load.abs() / size });
    }
}

/// Returns the largest displacement, m.
pub(crate) fn largest<V: Coordinates>(moved: &[V]) -> f64 {
    moved.iter().map(|u| u.times(u).sqrt()).fold(0.0, f64::max)
}

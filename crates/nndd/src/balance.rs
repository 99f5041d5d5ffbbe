//! The balance of the floating bodies, and what nothing holds.

use crate::error::NnddError;
use crate::rows::{Rows, sign};
use crate::unheld::UnheldMotion;
use contact_qp::nonnegative_least_squares;
use fem_core::body::{Body, RigidMotion};
use fem_core::geometry::Vector;
use fem_core::prepared::PreparedProblem;
use std::ops::Range;

/// A load of a motion below this fraction of all loads is round-off.
const NO_LOAD: f64 = 1e-10;

/// The load of a motion below this fraction of its terms is the rounding of their sum.
const ROUNDING: f64 = 1e-13;

/// `G P = e`: one line per rigid motion of a floating body.
pub(crate) struct Balance {
    /// Bodies with their rigid motions, body after body.
    pub(crate) motions: Vec<(usize, RigidMotion)>,
    /// `G = (B R)ᵀ`, line after line.
    pub(crate) rows: Vec<f64>,
    /// `e = Rᵀ f`.
    pub(crate) loads: Vec<f64>,
}

impl Balance {
    pub(crate) fn new(problem: &PreparedProblem, rows: &Rows) -> Self {
        let contact = problem.problem();
        let bodies = contact.bodies.iter().enumerate();
        let of_body =
            |(b, body): (usize, &Body)| body.rigid_motions().into_iter().map(move |motion| (b, motion));
        let motions: Vec<(usize, RigidMotion)> = bodies.flat_map(of_body).collect();
        let count = rows.len();
        let mut matrix = vec![0.0; motions.len() * count];
        let mut loads = vec![0.0; motions.len()];
        for (m, (b, motion)) in motions.iter().enumerate() {
            let body = &contact.bodies[*b];
            let (piece_of, _) = body.mesh().topology().pieces();
            let at = |node: usize| {
                let moves = piece_of[node] == motion.piece;
                if moves { motion.at(body.mesh().points()[node]) } else { Vector::zeros() }
            };
            for (k, side) in contact.sides_of(*b) {
                for (i, pair) in contact.contacts[k].interface.pairs().iter().enumerate() {
                    let trace = at(pair.nodes[side].index()).dot(&pair.normal);
                    matrix[m * count + rows.at(k, i)] += sign(side) * trace;
                }
            }
            let terms = || problem.external_forces()[*b].iter().enumerate().map(|(n, f)| f.dot(&at(n)));
            let load: f64 = terms().sum();
            if load.abs() > ROUNDING * terms().map(f64::abs).sum::<f64>() {
                loads[m] = load;
            }
        }
        Self { motions, rows: matrix, loads }
    }

    /// Returns the lines of a body.
    pub(crate) fn of_body(&self, body: usize) -> Range<usize> {
        let before = |b: usize| self.motions.partition_point(|(of, _)| *of < b);
        before(body)..before(body + 1)
    }

    /// Checks that the assembly is held.
    ///
    /// # Errors
    /// [`NnddError::NotHeld`] with the motion that the loads cause and nothing resists.
    pub(crate) fn check_held(&self, problem: &PreparedProblem) -> Result<(), NnddError> {
        if self.motions.is_empty() {
            return Ok(());
        }
        let (_, free) = nonnegative_least_squares(&self.rows, &self.loads)?;
        let forces = problem.external_forces().iter().flatten();
        let size = forces.map(|f| f.norm()).sum::<f64>();
        let norm = free.iter().map(|a| a * a).sum::<f64>().sqrt();
        if norm <= NO_LOAD * size {
            return Ok(());
        }
        Err(NnddError::NotHeld { motion: self.motion(problem, &free) })
    }

    /// Describes the motion with the given amounts.
    fn motion(&self, problem: &PreparedProblem, free: &[f64]) -> UnheldMotion {
        let mut bodies: Vec<(usize, RigidMotion)> = Vec::new();
        for ((b, motion), a) in self.motions.iter().zip(free) {
            let mut scaled = *motion;
            scaled.translation *= *a;
            scaled.spin *= *a;
            match bodies.iter_mut().find(|(of, known)| of == b && known.piece == motion.piece) {
                Some((_, sum)) => {
                    sum.translation += scaled.translation;
                    sum.spin += scaled.spin;
                }
                None => bodies.push((*b, scaled)),
            }
        }
        let largest = |(b, motion): &(usize, RigidMotion)| {
            let body = &problem.problem().bodies[*b];
            let (piece_of, _) = body.mesh().topology().pieces();
            let points =
                body.mesh().points().iter().zip(&piece_of).filter(|(_, piece)| **piece == motion.piece);
            points.map(|(point, _)| motion.at(*point).norm()).fold(0.0, f64::max)
        };
        let most = bodies.iter().map(largest).fold(0.0, f64::max);
        bodies.retain(|moved| largest(moved) > NO_LOAD * most);
        for (_, motion) in &mut bodies {
            motion.translation /= most;
            motion.spin /= most;
        }
        let work: f64 = self.loads.iter().zip(free).map(|(e, a)| e * a).sum();
        UnheldMotion { bodies, load: work / most }
    }
}

//! The balance of the floating bodies: which assemblies are held.
//!
//! With `R` the rigid motions that the supports leave free, `G = (B R)ᵀ` and their loads `e = Rᵀ f`, forces are in balance if
//! `G P = e`. There is a solution `P ≥ 0` if and only if no motion that opens or keeps all pairs, `B R a ≤ 0`, has a load
//! `e·a > 0` (Farkas). The residual of `min |G P − e|, P ≥ 0` is such a motion, if it is not zero.
//!
//! The forces of friction are bounded on both sides, and the residual is what they leave of the load. With the law of Coulomb the forces of
//! a pair of nodes are in a cone, whose two edges take the place of its rows.

use crate::error::NnddError;
use crate::rows::Rows;
use crate::rows::sign;
use crate::unheld::UnheldMotion;
use contact_qp::{IndependentRows, bounded_least_squares};
use fem_core::assembly::external_forces;
use fem_core::body::RigidMotion;
use fem_core::geometry::{Vector, perpendicular};
use fem_core::interface::{ContactProblem, ContactRow, NodePair};
use fem_core::prepared::BodyMotion;

/// A load of a motion below this fraction of all loads is round-off.
const NO_LOAD: f64 = 1e-10;

/// A motion without load is free if the pairs resist it by less than this fraction of what they resist best: normals of curved lines
/// are no better than that. A body that moves by less than this fraction of the one that moves most does not count as part of it.
const WEAK: f64 = 1e-3;

/// A body whose motion is below this fraction of the largest one does not move.
const NO_TRACE: f64 = 1e-9;

/// How an assembly is held.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Support {
    /// The motion that the loads cause and nothing resists; `None` if the assembly is held.
    pub unheld: Option<UnheldMotion>,
    /// The motions that no pair resists and no load drives: each with the bodies that move, the one that moves most (by 1 m) first.
    /// They stay at zero.
    pub free_motions: Vec<Vec<(usize, RigidMotion)>>,
}

/// Tells how an assembly is held, without solving anything.
///
/// # Errors
/// Numbers that are not finite; [`NnddError::OutsideCones`] if no forces within the cones of Coulomb friction balance the loads.
pub fn support(problem: &ContactProblem) -> Result<Support, NnddError> {
    let problem = &without_spin(problem.clone())?;
    let motions = problem.rigid_motions();
    let balance = Balance::new(problem, &motions);
    let unheld = balance.unheld(problem, Rows::new(problem).limits())?;
    let unheld =
        unheld.map(|(motion, cones)| if cones { Err(outside(&motion)) } else { Ok(motion) }).transpose()?;
    let free = balance.independent.kernel().iter().chain(balance.independent.weak()).map(|amounts| {
        let bodies = combined(problem, &motions, amounts);
        let most = bodies.iter().map(|of| largest(problem, of)).fold(0.0, f64::max);
        let mut moved: Vec<(f64, &BodyMotion)> = bodies
            .iter()
            .map(|of| (largest(problem, of) / most, of))
            .filter(|(size, _)| *size > WEAK)
            .collect();
        moved.sort_by(|a, b| b.0.total_cmp(&a.0));
        moved.into_iter().map(|(_, of)| (of.body, of.motion.scaled(1.0 / most))).collect()
    });
    let mut free: Vec<Vec<(usize, RigidMotion)>> = free.collect();
    free.sort_by_key(|bodies| bodies.first().map(|(body, _)| *body));
    Ok(Support { unheld, free_motions: free })
}

/// Leaves loads out along rotations that a contact line on a declared arc does not resist, if the error of the polygon explains them: the moment
/// of the loads of a polygon about the centre of the arc is not exactly the curve's. It explains up to
/// ```math
/// |e·a| ≤ (∑_i P_i)  max_i |(n_i − (x_i − c)/R)·R a|
/// ```
/// with the means `n_i` of the polygon's normals. A problem with larger loads is returned as it is, and is not held.
///
/// # Errors
/// Numbers that are not finite.
pub fn without_spin(problem: ContactProblem) -> Result<ContactProblem, NnddError> {
    if problem.contacts.iter().all(|pair| pair.interface.centre().is_none()) {
        return Ok(problem);
    }
    let motions = problem.rigid_motions();
    let Some(spins) = Balance::new(&problem, &motions).explained(&problem)? else { return Ok(problem) };
    let mut without = problem.clone();
    for of in spins {
        without.leave_out(of.body, of.motion);
    }
    let motions = without.rigid_motions();
    let rest = Balance::new(&without, &motions);
    let left = size(&rest.independent.unbalanced(&rest.loads));
    Ok(if left <= NO_LOAD * load_size(&problem) { without } else { problem })
}

/// Centres closer than this fraction of the radius of a line are the same.
const SAME_CENTRE: f64 = 1e-6;

/// Computes the sum of the sizes of all loads, N/m.
fn load_size(problem: &ContactProblem) -> f64 {
    let of_body = |body| external_forces(body).iter().map(|f| f.norm()).sum::<f64>();
    let on_bodies: f64 = problem.bodies.iter().map(of_body).sum();
    on_bodies + problem.obstacles.iter().map(|obstacle| obstacle.load_size()).sum::<f64>()
}

fn size(values: &[f64]) -> f64 {
    values.iter().map(|a| a * a).sum::<f64>().sqrt()
}

/// `G P = e`: one line per rigid motion of a floating body.
pub(crate) struct Balance {
    /// The rigid motions, body after body.
    pub(crate) motions: Vec<BodyMotion>,
    /// `G = (B R)ᵀ`, line after line.
    rows: Vec<f64>,
    /// `e = Rᵀ f`.
    loads: Vec<f64>,
    /// Independent combinations of the lines: one per motion that the pairs resist.
    pub(crate) independent: IndependentRows,
}

impl Balance {
    pub(crate) fn new(problem: &ContactProblem, motions: &[BodyMotion]) -> Self {
        let limits = Rows::new(problem);
        let limits = limits.limits();
        let mut rows = Vec::with_capacity(motions.len() * limits.len());
        for of in motions {
            let (moved, mut limits) = (problem.moved_by(of), limits.iter());
            for contact in &problem.contacts {
                let side = contact.side_of(of.body);
                let entry = |(row, limit): (ContactRow, &f64)| match side {
                    // A row that has no force resists nothing.
                    Some(side) if *limit > 0.0 => sign(side) * moved[row.nodes[side]].dot(&row.direction),
                    _ => 0.0,
                };
                rows.extend(contact.rows().zip(limits.by_ref()).map(entry));
            }
        }
        let loads: Vec<f64> = motions.iter().map(|of| of.load).collect();
        let independent = IndependentRows::without_weak(&rows, &loads, WEAK);
        Self { motions: motions.to_vec(), rows, loads, independent }
    }

    /// Tells whether no motion changes a row, but for rounding.
    pub(crate) fn leaves_alone(&self, row: usize) -> bool {
        let count = self.rows.len().checked_div(self.loads.len()).unwrap_or(0);
        let alone = |line: &[f64]| {
            line[row].abs() <= NO_TRACE * line.iter().fold(0.0f64, |most, entry| most.max(entry.abs()))
        };
        self.rows.chunks_exact(count.max(1)).all(alone)
    }

    /// Checks that the assembly is held.
    ///
    /// * `limits`: of the forces by row, infinite along normals, N/m.
    ///
    /// # Errors
    /// [`NnddError::NotHeld`] with the motion that the loads cause and nothing resists; [`NnddError::OutsideCones`].
    pub(crate) fn check_held(&self, problem: &ContactProblem, limits: &[f64]) -> Result<(), NnddError> {
        match self.unheld(problem, limits)? {
            None => Ok(()),
            Some((motion, true)) => Err(outside(&motion)),
            Some((motion, false)) => Err(NnddError::NotHeld { motion }),
        }
    }

    /// Lists the forces that can balance the loads: `G` in them, and their bounds. With the law of Coulomb and an infinite limit they are
    /// along the edges of the cones, `P n ± μ P t`.
    fn forces(&self, problem: &ContactProblem, limits: &[f64]) -> (Vec<f64>, [Vec<f64>; 2], bool) {
        let rows = Rows::new(problem);
        let (mut matrix, mut bounds, mut cones) = (self.rows.clone(), rows.bounds(limits), false);
        let count = limits.len();
        for (k, pair) in problem.contacts.iter().enumerate() {
            let Some(mu) = pair.friction.coulomb() else { continue };
            for (n, t) in rows.normal(k).zip(rows.tangential(k)).filter(|(_, t)| limits[*t] == f64::INFINITY)
            {
                cones = true;
                bounds[0][t] = 0.0;
                for line in matrix.chunks_exact_mut(count.max(1)) {
                    (line[n], line[t]) = (line[n] + mu * line[t], line[n] - mu * line[t]);
                }
            }
        }
        (matrix, bounds, cones)
    }

    /// Finds the rotations that carry a load which no forces balance, if the polygon explains each, see [`without_spin`]; `None` if there is no such load,
    /// or if the polygon does not explain it.
    fn explained(&self, problem: &ContactProblem) -> Result<Option<Vec<BodyMotion>>, NnddError> {
        let unbalanced = self.independent.unbalanced(&self.loads);
        if !(size(&unbalanced) > NO_LOAD * load_size(problem)) {
            return Ok(None);
        }
        let rows = Rows::new(problem);
        let (matrix, [lower, upper], _) = self.forces(problem, rows.limits());
        let loads: Vec<f64> = self.loads.iter().zip(&unbalanced).map(|(e, part)| e - part).collect();
        let (forces, _) = bounded_least_squares(&matrix, &loads, [&lower, &upper])?;
        let bodies = combined(problem, &self.motions, &unbalanced);
        let most = bodies.iter().map(|of| largest(problem, of)).fold(0.0, f64::max);
        let moved = bodies.iter().filter(|of| largest(problem, of) > NO_TRACE * most);
        let spin = |of: &BodyMotion| {
            let unit = BodyMotion::new(of.body, of.motion.scaled(1.0 / largest(problem, of)));
            is_explained(problem, &unit, &rows, &forces).then_some(unit)
        };
        Ok(moved.map(spin).collect())
    }

    /// Finds the motion that the loads cause and nothing resists, and whether cones of friction were taken into account; `None` if the
    /// assembly is held.
    fn unheld(
        &self,
        problem: &ContactProblem,
        limits: &[f64],
    ) -> Result<Option<(UnheldMotion, bool)>, NnddError> {
        let motions = &self.motions;
        if motions.is_empty() {
            return Ok(None);
        }
        // What no forces balance is set apart: lines of round-off must not balance it. The rest is measured in the motions
        // themselves, so that only bodies move that must.
        let unbalanced = self.independent.unbalanced(&self.loads);
        let loads: Vec<f64> = self.loads.iter().zip(&unbalanced).map(|(e, part)| e - part).collect();
        let (matrix, [lower, upper], cones) = self.forces(problem, limits);
        let (forces, mut free) = bounded_least_squares(&matrix, &loads, [&lower, &upper])?;
        free.iter_mut().zip(&unbalanced).for_each(|(a, part)| *a += part);
        if !(size(&free) > NO_LOAD * load_size(problem)) {
            return Ok(None);
        }
        let bodies = combined(problem, motions, &free);
        let most = bodies.iter().map(|of| largest(problem, of)).fold(0.0, f64::max);
        let moved = bodies.iter().filter(|of| largest(problem, of) > NO_LOAD * most);
        let unit = |of: &BodyMotion| (of.body, of.motion.scaled(1.0 / most));
        let mut work: f64 = self.loads.iter().zip(&free).map(|(e, a)| e * a).sum();
        // Friction at its limit resists a part of the load.
        for (i, force) in forces.iter().enumerate().filter(|(i, force)| lower[*i] < 0.0 && **force != 0.0) {
            let lines = matrix.chunks_exact(limits.len().max(1)).zip(&free);
            work -= force * lines.map(|(line, a)| line[i] * a).sum::<f64>();
        }
        Ok(Some((UnheldMotion { bodies: moved.map(unit).collect(), load: work / most }, cones)))
    }
}

/// Tells whether a motion is a rotation about the centre of all contact lines of a body that only they hold, with a load that the error of the
/// polygon explains.
fn is_explained(problem: &ContactProblem, of: &BodyMotion, rows: &Rows, forces: &[f64]) -> bool {
    let motion = of.motion;
    let Some(body) = problem.bodies.get(of.body).filter(|body| body.has_no_support() && motion.spin != 0.0)
    else {
        return false;
    };
    let centre = motion.centre + 1.0 / motion.spin * perpendicular(motion.translation);
    let moved = motion.displacements(body);
    let mut allowed = 0.0;
    for (k, side) in problem.sides_of(of.body) {
        let interface = &problem.contacts[k].interface;
        let Some(own) = interface.centre() else { return false };
        // The largest displacement is 1 m, at the radius 1/|spin|.
        if !((own - centre).norm() * motion.spin.abs() <= SAME_CENTRE) {
            return false;
        }
        let polygon = interface.polygon_normals(body, side);
        let off = |(pair, polygon): (&NodePair, &Vector)| {
            (polygon - pair.normal).dot(&moved[pair.nodes[side]]).abs()
        };
        let most = interface.pairs().iter().zip(&polygon).map(off).fold(0.0, f64::max);
        allowed += most * rows.normal(k).map(|row| forces[row]).sum::<f64>();
    }
    let load: f64 = external_forces(body).iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
    load.abs() <= allowed
}

/// Says that the loads are outside the cones of friction: the motion of the cone is not the true one.
fn outside(motion: &UnheldMotion) -> NnddError {
    NnddError::OutsideCones { load: motion.load }
}

/// Adds up the motions of each piece of each body.
fn combined(problem: &ContactProblem, motions: &[BodyMotion], amounts: &[f64]) -> Vec<BodyMotion> {
    let mut bodies: Vec<BodyMotion> = Vec::with_capacity(problem.bodies.len());
    for (of, a) in motions.iter().zip(amounts) {
        let scaled = BodyMotion::new(of.body, of.motion.scaled(*a));
        match bodies.iter_mut().find(|known| known.body == of.body && known.motion.piece == of.motion.piece) {
            Some(sum) => {
                sum.motion.translation += scaled.motion.translation;
                sum.motion.spin += scaled.motion.spin;
            }
            None => bodies.push(scaled),
        }
    }
    bodies
}

/// Computes the largest displacement in a motion, m.
fn largest(problem: &ContactProblem, of: &BodyMotion) -> f64 {
    problem.moved_by(of).iter().map(|u| u.norm()).fold(0.0, f64::max)
}

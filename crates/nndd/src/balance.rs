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
use contact_qp::{Combination, RowSelection, SparseRows, unbalanced_load};
use fem_core::assembly::external_forces;
use fem_core::body::RigidMotion;
use fem_core::geometry::{Vector, perpendicular};
use fem_core::interface::{ContactProblem, ContactRow, NodePair};
use fem_core::prepared::BodyMotion;
use std::collections::BTreeMap;

/// A load of a motion below this fraction of all loads is round-off.
const NO_LOAD: f64 = 1e-10;

/// A motion without load is free if the pairs resist it by less than this fraction of what they resist best: normals of curved lines
/// are no better than that. A body that moves by less than this fraction of the one that moves most does not count as part of it.
const WEAK: f64 = 1e-3;

/// An entry of a motion or of its load below this fraction of its terms is round-off: forces of 1e16 would balance a load with it.
const ROUND_OFF: f64 = 1e-12;

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
    /// Forces that balance the loads, for [`ContactProblem::balancing`]; empty if none are needed, or none do.
    pub forces: Vec<f64>,
}

/// The answer to the question whether an assembly is held.
enum Held {
    /// It is, by these forces; none are needed if no body floats.
    By(Vec<f64>),
    /// It is not: the motion that the loads cause and nothing resists.
    Not(UnheldMotion),
    /// It is not by forces within the cones of friction.
    OutsideCones(UnheldMotion),
}

/// Tells how an assembly is held, without solving anything.
///
/// # Errors
/// Numbers that are not finite; [`NnddError::OutsideCones`] if no forces within the cones of Coulomb friction balance the loads.
pub fn support(problem: &ContactProblem) -> Result<Support, NnddError> {
    let problem = &without_spin(problem.clone())?;
    let motions = problem.rigid_motions();
    let balance = Balance::new(problem, &motions)?;
    let (unheld, forces) = match balance.question(problem, Rows::new(problem).limits())? {
        Held::By(forces) => (None, forces),
        Held::OutsideCones(motion) => return Err(outside(&motion)),
        Held::Not(motion) => (Some(motion), Vec::new()),
    };
    Ok(Support { unheld, free_motions: balance.free_motions(problem), forces })
}

/// Lists the motions that no pair resists and no load drives, see [`Support::free_motions`], without asking whether the assembly is held.
///
/// # Errors
/// Numbers that are not finite.
pub fn free_motions(problem: &ContactProblem) -> Result<Vec<Vec<(usize, RigidMotion)>>, NnddError> {
    let problem = &without_spin(problem.clone())?;
    Ok(Balance::new(problem, &problem.rigid_motions())?.free_motions(problem))
}

/// Leaves loads out along rotations that a contact line on a declared arc does not resist, if the error of the polygon explains them: the moment
/// of the loads of a polygon about the centre of the arc is not exactly the curve's. It explains up to
/// ```math
/// |e·a| ≤ ∑_i P_i |(n_i − (x_i − c)/R)·R a|
/// ```
/// with the means `n_i` of the polygon's normals, and forces `P_i` that balance all other loads. A problem with larger loads is returned as it
/// is, and is not held.
///
/// # Errors
/// Numbers that are not finite.
pub fn without_spin(problem: ContactProblem) -> Result<ContactProblem, NnddError> {
    if problem.contacts.iter().all(|pair| pair.interface.centre().is_none()) {
        return Ok(problem);
    }
    let motions = problem.rigid_motions();
    let Some(spins) = Balance::new(&problem, &motions)?.explained(&problem)? else { return Ok(problem) };
    let mut without = problem.clone();
    for of in spins {
        without.leave_out(of.body, of.motion);
    }
    let motions = without.rigid_motions();
    let rest = Balance::new(&without, &motions)?;
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
    /// `G = (B R)ᵀ`, one line per motion.
    rows: SparseRows,
    /// `e = Rᵀ f`.
    loads: Vec<f64>,
    /// The lines that the pairs resist, and the motions that they do not.
    pub(crate) independent: RowSelection,
}

impl Balance {
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn new(problem: &ContactProblem, motions: &[BodyMotion]) -> Result<Self, NnddError> {
        let all = Rows::new(problem);
        let limits = all.limits();
        let (mut rows, mut loads) = (SparseRows::new(limits.len()), Vec::with_capacity(motions.len()));
        let sides = problem.sides();
        for of in motions {
            let moved = problem.moved_by(of);
            let most = moved.iter().map(|u| u.norm()).fold(0.0, f64::max);
            let of_pair = |&(k, side): &(usize, usize)| {
                let (pair, first) = (&problem.contacts[k], all.at(k, 0));
                let entry = |row: ContactRow| sign(side) * moved[row.nodes[side]].dot(&row.direction);
                let entries: Vec<f64> = pair.rows().map(entry).collect();
                entries.into_iter().enumerate().map(move |(i, entry)| (first + i, entry))
            };
            // A row that has no force resists nothing, and round-off must not: directions are of length one.
            let resists = |(row, entry): &(usize, f64)| limits[*row] > 0.0 && entry.abs() > ROUND_OFF * most;
            rows.push(sides[of.body].iter().flat_map(of_pair).filter(resists));
            let load_size = match problem.bodies.get(of.body) {
                Some(body) => external_forces(body).iter().map(|f| f.norm()).sum::<f64>() * most,
                None => problem.obstacles[of.body - problem.bodies.len()].load_size() * most,
            };
            loads.push(if of.load.abs() > ROUND_OFF * load_size { of.load } else { 0.0 });
        }
        let groups: Vec<usize> = motions.iter().map(|of| of.body).collect();
        let independent = RowSelection::new(&rows, &loads, &groups, WEAK)?;
        Ok(Self { motions: motions.to_vec(), rows, loads, independent })
    }

    /// Lists the motions that no pair resists and no load drives, the body that moves most first.
    fn free_motions(&self, problem: &ContactProblem) -> Vec<Vec<(usize, RigidMotion)>> {
        let Self { motions, independent, .. } = self;
        let free = independent.kernel.iter().chain(&independent.weak).map(|amounts: &Combination| {
            let bodies = combined(amounts.iter().map(|(k, a)| (&motions[*k], *a)));
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
        free
    }

    /// Returns the lines that the pairs resist, and their loads.
    pub(crate) fn resisted(&self) -> (SparseRows, Vec<f64>) {
        let Self { rows, loads, independent, .. } = self;
        (rows.select(&independent.rows), independent.rows.iter().map(|k| loads[*k]).collect())
    }

    /// Tells for each row whether no motion changes it, but for rounding.
    pub(crate) fn leaves_alone(&self) -> Vec<bool> {
        let mut alone = vec![true; self.rows.columns()];
        for line in 0..self.rows.len() {
            let most = self.rows.row(line).fold(0.0f64, |most, (_, entry)| most.max(entry.abs()));
            let moved = self.rows.row(line).filter(|(_, entry)| entry.abs() > NO_TRACE * most);
            moved.for_each(|(row, _)| alone[row] = false);
        }
        alone
    }

    /// Checks that the assembly is held.
    ///
    /// * `limits`: of the forces by row, infinite along normals, N/m.
    ///
    /// # Errors
    /// [`NnddError::NotHeld`] with the motion that the loads cause and nothing resists; [`NnddError::OutsideCones`].
    pub(crate) fn check_held(&self, problem: &ContactProblem, limits: &[f64]) -> Result<(), NnddError> {
        match self.question(problem, limits)? {
            Held::By(_) => Ok(()),
            Held::OutsideCones(motion) => Err(outside(&motion)),
            Held::Not(motion) => Err(NnddError::NotHeld { motion }),
        }
    }

    /// Lists the forces that can balance the loads: `G` in them, and their bounds. With the law of Coulomb and an infinite limit they are
    /// along the edges of the cones, `P n ± μ P t`.
    fn forces(&self, problem: &ContactProblem, limits: &[f64]) -> (SparseRows, [Vec<f64>; 2], bool) {
        let rows = Rows::new(problem);
        let mut bounds = rows.bounds(limits);
        // The other row of each cone, the friction coefficient, and the sign of its edge.
        let mut cones: Vec<Option<(usize, f64, f64)>> = vec![None; limits.len()];
        for (k, pair) in problem.contacts.iter().enumerate() {
            let Some(mu) = pair.friction.coulomb() else { continue };
            for (n, t) in rows.normal(k).zip(rows.tangential(k)).filter(|(_, t)| limits[*t] == f64::INFINITY)
            {
                bounds[0][t] = 0.0;
                (cones[n], cones[t]) = (Some((t, mu, 1.0)), Some((n, mu, -1.0)));
            }
        }
        if cones.iter().all(Option::is_none) {
            return (self.rows.clone(), bounds, false);
        }
        let mut matrix = SparseRows::new(limits.len());
        for line in self.rows.rows() {
            let mut entries: BTreeMap<usize, f64> = BTreeMap::new();
            for (i, g) in line {
                // `n + μ t` in the place of the normal, `n − μ t` in that of the tangent.
                let own = match cones[i] {
                    Some((n, mu, sign)) if sign < 0.0 => {
                        *entries.entry(n).or_default() += mu * g;
                        -mu * g
                    }
                    Some((t, ..)) => {
                        *entries.entry(t).or_default() += g;
                        g
                    }
                    None => g,
                };
                *entries.entry(i).or_default() += own;
            }
            matrix.push(entries);
        }
        (matrix, bounds, true)
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
        let (forces, _) = unbalanced_load(&matrix, &loads, [&lower, &upper])?;
        let bodies = combined(self.motions.iter().zip(unbalanced.iter().copied()));
        let most = bodies.iter().map(|of| largest(problem, of)).fold(0.0, f64::max);
        let moved = bodies.iter().filter(|of| largest(problem, of) > NO_TRACE * most);
        let spin = |of: &BodyMotion| {
            let unit = BodyMotion::new(of.body, of.motion.scaled(1.0 / largest(problem, of)));
            is_explained(problem, &unit, &rows, &forces).then_some(unit)
        };
        Ok(moved.map(spin).collect())
    }

    /// Asks whether the assembly is held. Forces that are known to balance the loads answer it, see [`ContactProblem::balancing`].
    fn question(&self, problem: &ContactProblem, limits: &[f64]) -> Result<Held, NnddError> {
        let motions = &self.motions;
        if motions.is_empty() {
            return Ok(Held::By(Vec::new()));
        }
        let (matrix, [lower, upper], cones) = self.forces(problem, limits);
        let most = NO_LOAD * load_size(problem);
        let left = |forces: &[f64]| -> Vec<f64> {
            matrix.times(forces).iter().zip(&self.loads).map(|(product, e)| e - product).collect()
        };
        let known = &problem.balancing;
        let within = |(i, force): (usize, &f64)| (lower[i]..=upper[i]).contains(force);
        if known.len() == lower.len() && known.iter().enumerate().all(within) && size(&left(known)) <= most {
            return Ok(Held::By(known.clone()));
        }
        // What no forces balance is set apart: lines of round-off must not balance it. The rest is measured in the motions
        // themselves, so that only bodies move that must.
        let unbalanced = self.independent.unbalanced(&self.loads);
        let loads: Vec<f64> = self.loads.iter().zip(&unbalanced).map(|(e, part)| e - part).collect();
        let (forces, mut free) = unbalanced_load(&matrix, &loads, [&lower, &upper])?;
        free.iter_mut().zip(&unbalanced).for_each(|(a, part)| *a += part);
        if !(size(&free) > most) {
            return Ok(Held::By(forces));
        }
        let bodies = combined(motions.iter().zip(free.iter().copied()));
        let most = bodies.iter().map(|of| largest(problem, of)).fold(0.0, f64::max);
        let moved = bodies.iter().filter(|of| largest(problem, of) > NO_LOAD * most);
        let unit = |of: &BodyMotion| (of.body, of.motion.scaled(1.0 / most));
        let mut work: f64 = self.loads.iter().zip(&free).map(|(e, a)| e * a).sum();
        // Friction at its limit resists a part of the load.
        for (i, opened) in matrix.transposed_times(&free).iter().enumerate().filter(|(i, _)| lower[*i] < 0.0)
        {
            work -= forces[i] * opened;
        }
        let motion = UnheldMotion { bodies: moved.map(unit).collect(), load: work / most };
        Ok(if cones { Held::OutsideCones(motion) } else { Held::Not(motion) })
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
        let off =
            |pair: &NodePair, polygon: &Vector| (polygon - pair.normal).dot(&moved[pair.nodes[side]]).abs();
        let terms = interface.pairs().iter().zip(&polygon).zip(rows.normal(k));
        allowed += terms.map(|((pair, polygon), row)| forces[row] * off(pair, polygon)).sum::<f64>();
    }
    let load: f64 = external_forces(body).iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
    load.abs() <= allowed
}

/// Says that the loads are outside the cones of friction: the motion of the cone is not the true one.
fn outside(motion: &UnheldMotion) -> NnddError {
    NnddError::OutsideCones { load: motion.load }
}

/// Adds up the motions of each piece of each body, which follow each other.
fn combined<'a>(motions: impl Iterator<Item = (&'a BodyMotion, f64)>) -> Vec<BodyMotion> {
    let mut bodies: Vec<BodyMotion> = Vec::new();
    for (of, a) in motions {
        let scaled = BodyMotion::new(of.body, of.motion.scaled(a));
        let mut of_body = bodies.iter_mut().rev().take_while(|known| known.body == of.body);
        match of_body.find(|known| known.motion.piece == of.motion.piece) {
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

//! The contact conditions at the traces of an inner iteration, and the iterate that bounds its error for the contact solution.
//!
//! ```math
//! P̃ ≥ 0 nearest to P, in balance;   v: u_D lifted where it penetrates;   η_c² = ∑_α ‖û(P̃) − v‖² + 2 P̃ᵀ o(v)
//! ```
//! `η_c` bounds `‖u_h − v‖` whether or not the set is right: the algebra of η_NNDD on the page of this crate. On the right set it is
//! `η² = r·M r`, without further solves.

use crate::active_set::ActiveSet;
use crate::balance::{Balance, NearestForces};
use crate::error::NnddError;
use crate::exact::ExactSolution;
use crate::friction::PairFriction;
use crate::iterate::{Iterate, OwnFields, Recovery, UnilateralSolution, precision};
use contact_qp::{KktResiduals, QpPath, QpStatus, RowSelection};
use fem_core::contact_system::{BodyField, BodyFields, BodyRow};
use fem_core::dense::pseudo_inverse;
use fem_core::norm::from_squared;
use nalgebra::{DMatrix, DVector};
use neumann_neumann::{Balancing, Broken, Inner, Skeleton, dot, leaders, traced};
use std::collections::BTreeMap;

/// A force or an opening with the wrong sign below this fraction of the largest force or trace is rounding.
const ROUNDING: f64 = 1e-11;

/// Singular values of the rows of a node below this fraction of the largest one are zero.
const DEPENDENT: f64 = 1e-9;

/// Sweeps that lift penetrating traces, at most.
const SWEEPS: usize = 200;

/// Forces and openings by row.
pub(crate) struct Contact {
    /// `P` in balance in the closed rows, N/m.
    forces: Vec<f64>,
    /// Exactly 0 in closed rows, m.
    pub(crate) openings: Vec<f64>,
    /// The rows that hold.
    closed: Vec<bool>,
    /// The rows with the wrong sign of a force or an opening.
    pub(crate) wrong: Vec<usize>,
    /// The traces, without motions that the closed rows leave free, m, and the amounts of all motions.
    pub(crate) x: Vec<f64>,
    amounts: Vec<f64>,
}

/// What holds subdomains together, without contact: bounds the energy of forces in balance.
pub(crate) struct Bonds(
    /// None of bodies in one piece, whose energy is known.
    Option<Balancing>,
);

impl Bonds {
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn new(broken: &Broken<'_>) -> Result<Self, NnddError> {
        if !broken.shares() {
            return Ok(Self(None));
        }
        let (open, openings) = (vec![false; broken.rows.len()], vec![0.0; broken.rows.len()]);
        Ok(Self(Some(Balancing::new(broken, Skeleton::new(broken, &open, &openings))?)))
    }

    /// Bounds `fᵀ S⁺ f`.
    fn energy(&self, broken: &Broken<'_>, forces: &[f64]) -> f64 {
        match &self.0 {
            None => dot(forces, &broken.flexibility(forces)),
            Some(bonds) => bonds.energy_bound(broken, forces),
        }
    }
}

impl Contact {
    /// Computes forces and openings in all rows, and finds those with a wrong sign.
    ///
    /// * `free`: see [`Balance::left_by`].
    pub(crate) fn new(
        broken: &Broken<'_>,
        linear: &Balancing,
        inner: &Inner,
        (balance, free): (&Balance<'_>, &RowSelection),
    ) -> Self {
        let count = broken.rows.len();
        let closed = linear.skeleton.held(count);
        let forces = linear.skeleton.forces(&broken.gathered(linear.balanced(inner)), count);
        // Motions that nothing resists stay at zero.
        let mut x = inner.x.clone();
        let stiffness: Vec<f64> =
            broken.load.forces.iter().zip(&inner.forces).map(|(load, f)| load - f).collect();
        let mut amounts = broken.amounts(&x, &stiffness);
        let resisted: Vec<f64> = balance.independent.rows.iter().map(|number| amounts[*number]).collect();
        let left = balance.independent.rows.iter().zip(free.unbalanced(&resisted));
        for (number, free) in left.filter(|(_, free)| *free != 0.0) {
            amounts[*number] -= free;
            broken.add_motion(*number, -free, &mut x);
        }
        let mut openings = broken.openings(&x);
        openings.iter_mut().zip(&closed).filter(|(_, closed)| **closed).for_each(|(o, _)| *o = 0.0);
        let largest = |values: &[f64]| values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        let size = [ROUNDING * largest(&forces), ROUNDING * largest(&x).max(largest(&broken.gaps))];
        let is_wrong = |row: &usize| match closed[*row] {
            true => forces[*row] < -size[0],
            false => openings[*row] < -size[1],
        };
        let wrong = (0..count).filter(is_wrong).collect();
        Self { forces, openings, closed, wrong, x, amounts }
    }

    /// Returns the next set: the rows whose force or opening has the wrong sign change sides.
    pub(crate) fn next(&self) -> Vec<bool> {
        let mut next = self.closed.clone();
        self.wrong.iter().for_each(|row| next[*row] = !next[*row]);
        next
    }

    /// Makes the iterate.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn iterate(
        self,
        (broken, bonds): (&Broken<'_>, &Bonds),
        (balance, nearest): (&Balance<'_>, &mut NearestForces),
        inner: &Inner,
        (iteration, step): (usize, usize),
    ) -> Result<Iterate, NnddError> {
        let (next, system) = (self.next(), broken.system());
        let rows = &system.rows;
        let Bounded { forces, openings, mut x, mut amounts, held, squared } =
            self.bounded((broken, bonds), nearest, inner)?;
        for (number, free) in balance.independent.unbalanced(&amounts).into_iter().enumerate() {
            if free != 0.0 {
                amounts[number] -= free;
                broken.add_motion(number, -free, &mut x);
            }
        }
        broken.spread(&mut x);
        let field = |b: usize| match broken.floats(b) {
            true => BodyField::Forces(held[broken.of_body(b)].iter().map(|f| 0.0 - f).collect()),
            false => BodyField::Traces(x[broken.of_body(b)].to_vec()),
        };
        let bodies: Vec<BodyField> = (0..system.bodies.len()).map(field).collect();
        // Rounding is no imbalance.
        let [first, second] = match squared == 0.0 {
            true => [forces.clone(), forces.clone()],
            false => by_role(broken, &forces, &held),
        };
        let exact = ExactSolution {
            fields: BodyFields { bodies: Vec::new(), amounts },
            traces: traces(broken, &x),
            contact_force: rows.by_pair(&forces),
            opening: rows.by_pair(&openings),
            friction: vec![PairFriction::default(); rows.pairs.len()],
            status: QpStatus::Solved,
            path: QpPath::ActiveSet,
            iterations: inner.count,
            clarabel_calls: 0,
            kkt: KktResiduals::default(),
        };
        let made = exact.iterate(system);
        let reaction: Vec<f64> = first.iter().map(|p| 0.0 - p).collect();
        Ok(Iterate {
            iteration,
            step: [step, inner.count],
            eta_nndd: from_squared(squared),
            precision: precision(rows, &reaction, &forces),
            recovery: Recovery::Traces,
            reaction,
            contact: UnilateralSolution { active: ActiveSet::new(next), ..made.contact },
            own: Some(OwnFields { bodies, reaction: second }),
            ..made
        })
    }

    /// Computes `P̃`, `v` and `η_c²`.
    fn bounded(
        self,
        (broken, bonds): (&Broken<'_>, &Bonds),
        nearest: &mut NearestForces,
        inner: &Inner,
    ) -> Result<Bounded, NnddError> {
        let Self { forces, openings, x, amounts, .. } = self;
        let held = inner.forces.clone();
        if forces.iter().chain(&openings).all(|value| *value >= 0.0) {
            return Ok(Bounded { forces, openings, x, amounts, held, squared: inner.squared });
        }
        let (mut lifted, openings, is_open) = lift(broken, &x, openings);
        broken.spread(&mut lifted);
        let balanced = nearest.to(&forces, |i| openings[i] == 0.0)?;
        let is_balanced = balanced.is_some();
        let forces = balanced.unwrap_or_else(|| forces.iter().map(|p| p.max(0.0)).collect());
        let change: Vec<f64> = lifted.iter().zip(&x).map(|(v, x)| v - x).collect();
        let taken = broken.stiffness(&change);
        let held: Vec<f64> = held.iter().zip(&taken).map(|(f, taken)| f - taken).collect();
        let stiffness: Vec<f64> = broken.load.forces.iter().zip(&held).map(|(load, f)| load - f).collect();
        let amounts = broken.amounts(&lifted, &stiffness);
        let pressed = broken.pressed(&forces);
        let mut rest: Vec<f64> = held.iter().zip(&pressed).map(|(f, pressed)| f - pressed).collect();
        (0..rest.len()).filter(|k| broken.is_obstacle(*k)).for_each(|k| rest[k] = 0.0);
        let squared = bonds.energy(broken, &rest) + 2.0 * dot(&forces, &openings);
        let squared = if is_balanced && is_open { squared } else { f64::INFINITY };
        Ok(Bounded { forces, openings, x: lifted, amounts, held, squared })
    }
}

/// An admissible pair and its bound.
struct Bounded {
    /// `P̃`, N/m.
    forces: Vec<f64>,
    openings: Vec<f64>,
    /// `v`, m, with the amounts of its motions.
    x: Vec<f64>,
    amounts: Vec<f64>,
    /// The forces that hold it, `g − S v`, N/m.
    held: Vec<f64>,
    squared: f64,
}

/// Moves penetrating traces apart: each row shares its penetration among its unknowns by flexibility, until no row penetrates. Returns the traces,
/// the openings, and whether it came to an end.
fn lift(broken: &Broken<'_>, x: &[f64], mut openings: Vec<f64>) -> (Vec<f64>, Vec<f64>, bool) {
    let mut lifted = x.to_vec();
    if openings.iter().all(|o| *o >= 0.0) {
        return (lifted, openings, true);
    }
    let mut rows_of = vec![Vec::new(); broken.len()];
    for (row, terms) in broken.rows.iter().enumerate() {
        terms.iter().for_each(|(k, a)| rows_of[*k].push((row, *a)));
    }
    let stiffness = broken.gathered(broken.diagonal.clone());
    let soft = |k: usize| if broken.is_obstacle(k) { 0.0 } else { 1.0 / stiffness[k] };
    let mut todo: Vec<usize> = (0..openings.len()).filter(|row| openings[*row] < 0.0).collect();
    for _ in 0..SWEEPS {
        for row in std::mem::take(&mut todo) {
            let terms = &broken.rows[row];
            let own: f64 = terms.iter().map(|(k, a)| a * a * soft(*k)).sum();
            if !(openings[row] < 0.0 && own > 0.0) {
                continue;
            }
            let force = openings[row] / own;
            for (k, a) in terms {
                let change = force * a * soft(*k);
                lifted[*k] += change;
                for (other, b) in &rows_of[*k] {
                    openings[*other] -= b * change;
                    if openings[*other] < 0.0 {
                        todo.push(*other);
                    }
                }
            }
            openings[row] = 0.0;
        }
        todo.sort_unstable();
        todo.dedup();
        if todo.is_empty() {
            break;
        }
    }
    // Rounding may be left; more than that if nothing in a row can move.
    let size = x.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let is_open = openings.iter().all(|o| *o >= -ROUNDING * size);
    openings.iter_mut().for_each(|o| *o = o.max(0.0));
    (lifted, openings, is_open)
}

/// Shares the forces that hold the bodies among their rows, by row, N/m: those of Ω₁ and of Ω₂. Each row has `P̃`. The first row with an unknown has
/// the rest too; rows with several unknowns have the smallest forces that make up their rest. An obstacle has `P̃` alone. The springs of motions that the
/// pairs hardly resist take a part of the rest, which is left out: reactions are in balance.
fn by_role(broken: &Broken<'_>, forces: &[f64], held: &[f64]) -> [Vec<f64>; 2] {
    let system = broken.system();
    let held = broken.gathered(held.to_vec());
    let mut rest: Vec<f64> =
        held.iter().zip(broken.pressed(forces)).map(|(f, pressed)| f - pressed).collect();
    let mut by_role = [forces.to_vec(), forces.to_vec()];
    for (b, of_body) in system.of_body.iter().enumerate() {
        // What is left on a subdomain, others balance.
        if system.subdomains[b].numbers.is_empty() {
            broken.without_motions(b, &mut rest);
        }
        let rest = &rest[broken.of_body(b)];
        let leaders = leaders(rest.len(), of_body.iter().map(|row| &*row.terms));
        let mut groups: BTreeMap<usize, Vec<&BodyRow>> = BTreeMap::new();
        for row in of_body.iter().filter(|row| !row.terms.is_empty()) {
            groups.entry(leaders[row.terms[0].0]).or_default().push(row);
        }
        for (row, force) in groups.into_values().flat_map(|rows| shared(&rows, rest)) {
            let role = system.rows.pairs[system.rows.rows[row.row].pair].roles.of_side(row.side);
            by_role[role][row.row] += force;
        }
    }
    by_role
}

/// Shares forces on unknowns among the rows that have them, `Bᵀ P = f`.
fn shared<'a>(rows: &[&'a BodyRow], f: &[f64]) -> Vec<(&'a BodyRow, f64)> {
    if rows.iter().all(|row| row.terms.len() == 1) {
        let (unknown, factor) = rows[0].terms[0];
        return vec![(rows[0], f[unknown] / factor)];
    }
    let mut unknowns: Vec<usize> = rows.iter().flat_map(|row| row.terms.iter().map(|(k, _)| *k)).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    let factor = |i: usize, j: usize| {
        rows[j].terms.iter().find(|(k, _)| *k == unknowns[i]).map_or(0.0, |(_, factor)| *factor)
    };
    let transposed = DMatrix::from_fn(unknowns.len(), rows.len(), factor);
    let f = DVector::from_iterator(unknowns.len(), unknowns.iter().map(|k| f[*k]));
    let zero = DEPENDENT * transposed.norm();
    let forces = pseudo_inverse(transposed, zero).map(|inverse| inverse * f);
    rows.iter().copied().zip(forces.iter().flatten().copied()).collect()
}

/// Computes the traces of both sides of all rows along their own outward normals, m.
fn traces(broken: &Broken<'_>, x: &[f64]) -> [Vec<f64>; 2] {
    let system = broken.system();
    let of_obstacle = |row: usize| {
        let motions = broken.rows[row].iter().filter(|(k, _)| broken.is_obstacle(*k));
        motions.map(|(k, a)| a * x[*k]).sum::<f64>() + system.rows.rows[row].obstacle.unwrap_or(0.0)
    };
    let mut traces = [vec![0.0; system.rows.len()], (0..system.rows.len()).map(of_obstacle).collect()];
    for (b, of_body) in system.of_body.iter().enumerate() {
        for row in of_body {
            traces[row.side][row.row] = traced(&row.terms, &x[broken.of_body(b)]) + row.imposed;
        }
    }
    traces
}

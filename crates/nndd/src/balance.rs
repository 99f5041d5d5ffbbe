//! The balance of the floating bodies: which assemblies are held.
//!
//! With `R` the rigid motions that the supports leave free, `G = (B R)ᵀ` and their loads `e = Rᵀ f`, forces are in balance if
//! `G P = e`. There is a solution `P ≥ 0` if and only if no motion that opens or keeps all pairs, `B R a ≤ 0`, has a load
//! `e·a > 0` (Farkas). The residual of `min |G P − e|, P ≥ 0` is such a motion, if it is not zero.
//!
//! The forces of friction are bounded on both sides, and the residual is what they leave of the load. With the law of Coulomb the forces of
//! a pair of nodes are in a cone, whose two edges take the place of its rows.

use crate::error::NnddError;
use crate::unresisted::UnresistedMotion;
use contact_qp::{BalanceRows, Combination, Disc, RowSelection, SparseRows, unbalanced_load};
use fem_core::contact_system::{ContactRows, ROUNDING, RowLaw};
use std::collections::BTreeMap;

/// Forces are nearly in balance if the square of their distance to balanced ones is this fraction of their own square.
const NEARLY: f64 = 0.25;

/// A set holds no more if it leaves more than this fraction of the loads.
const NOT_HELD: f64 = 1e-9;

/// A row whose trace is below this fraction of the largest one does not move.
const NO_TRACE: f64 = 1e-9;

/// How an assembly is held.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Support {
    /// The motion that the loads cause and nothing resists; `None` if the assembly is held.
    pub unresisted: Option<UnresistedMotion>,
    /// See [`free_motions`].
    pub free_motions: Vec<UnresistedMotion>,
    /// Forces of the rows that balance the loads, N/m; empty if none are needed, or none do.
    pub forces: Vec<f64>,
}

/// The answer to the question whether an assembly is held.
enum Held {
    /// It is, by these forces; none are needed if no body floats.
    By(Vec<f64>),
    /// It is not: the motion that the loads cause and nothing resists.
    Not(UnresistedMotion),
    /// It is not by forces within the cones of friction.
    OutsideCones(UnresistedMotion),
}

/// Tells how an assembly is held, without solving anything.
///
/// # Errors
/// Numbers that are not finite; [`NnddError::OutsideCones`] if no forces within the cones of Coulomb friction balance the loads.
pub fn support(rows: &ContactRows) -> Result<Support, NnddError> {
    let balance = Balance::new(rows)?;
    let (unresisted, forces) = match balance.question(&rows.limits())? {
        Held::By(forces) => (None, forces),
        Held::OutsideCones(motion) => return Err(NnddError::OutsideCones { motion }),
        Held::Not(motion) => (Some(motion), Vec::new()),
    };
    Ok(Support { unresisted, free_motions: balance.free_motions(), forces })
}

/// Lists the motions that no pair resists, without asking whether the assembly is held. Those that no load drives have no work and stay at zero;
/// the others are not held, unless their load is left out.
///
/// # Errors
/// Numbers that are not finite.
pub fn free_motions(rows: &ContactRows) -> Result<Vec<UnresistedMotion>, NnddError> {
    Ok(Balance::new(rows)?.free_motions())
}

/// A load that no forces balance, whatever their sign.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Unbalanced {
    /// The motion along the load.
    pub motion: UnresistedMotion,
    /// Forces of the rows that balance the rest of the loads, N/m.
    pub forces: Vec<f64>,
}

/// Finds the part of the loads that no forces balance, whatever their sign; `None` if it is round-off.
///
/// # Errors
/// Numbers that are not finite.
pub fn unbalanced(rows: &ContactRows) -> Result<Option<Unbalanced>, NnddError> {
    let balance = Balance::new(rows)?;
    let (unbalanced, rest) = balance.parts();
    if !(size(&unbalanced) > ROUNDING * rows.load_size) {
        return Ok(None);
    }
    let limits = rows.limits();
    let (matrix, [lower, upper], _) = balance.forces(&limits);
    let (forces, _) = unbalanced_load(&matrix, &rest, [&lower, &upper], &discs(rows, &limits))?;
    Ok(Some(Unbalanced { motion: UnresistedMotion::along(&unbalanced), forces }))
}

/// Lists the discs of friction in space.
///
/// * `limits`: `S` by row, N/m; a row without limit or with the limit 0 is in none.
pub(crate) fn discs(rows: &ContactRows, limits: &[f64]) -> Vec<Disc> {
    let counts =
        |[i, j]: &[usize; 2]| [i, j].iter().all(|row| limits[**row] > 0.0 && limits[**row].is_finite());
    let planes = rows.tangential_planes().filter(counts);
    planes.map(|unknowns| Disc { unknowns, radius: limits[unknowns[0]] }).collect()
}

fn size(values: &[f64]) -> f64 {
    values.iter().map(|a| a * a).sum::<f64>().sqrt()
}

/// Returns the place of the body or obstacle of each motion.
fn groups(rows: &ContactRows) -> Vec<usize> {
    rows.motions.iter().map(|of| of.partner.place(rows.bodies)).collect()
}

/// `G P = e`: one line per rigid motion of a floating body.
pub(crate) struct Balance<'a> {
    rows: &'a ContactRows,
    /// `G = (B R)ᵀ`, one line per motion.
    lines: SparseRows,
    /// `e = Rᵀ f`.
    loads: Vec<f64>,
    /// The lines that the pairs resist, and the motions that they do not.
    pub(crate) independent: RowSelection,
}

impl<'a> Balance<'a> {
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn new(rows: &'a ContactRows) -> Result<Self, NnddError> {
        let limits = rows.limits();
        let (mut lines, mut loads) = (SparseRows::new(rows.len()), Vec::with_capacity(rows.motions.len()));
        for of in &rows.motions {
            // A row that has no force resists nothing.
            let resists = |(row, trace): &(usize, f64)| limits[*row] > 0.0 && *trace != 0.0;
            lines.push(of.traces.iter().copied().filter(resists));
            loads.push(of.load);
        }
        let independent = RowSelection::new(&lines, &loads, &groups(rows), rows.normal_error)?;
        Ok(Self { rows, lines, loads, independent })
    }

    /// Lists the motions that no pair resists, with the work of the loads along them.
    fn free_motions(self) -> Vec<UnresistedMotion> {
        let Self { rows, loads, independent: RowSelection { kernel, weak, .. }, .. } = self;
        let most = ROUNDING * rows.load_size;
        let motion = |amounts: Combination, weak: bool| {
            let work: f64 = amounts.iter().map(|(k, amount)| amount * loads[*k]).sum();
            UnresistedMotion { amounts, work: if work.abs() > most { work } else { 0.0 }, weak }
        };
        let free = kernel.into_iter().map(|amounts| motion(amounts, false));
        free.chain(weak.into_iter().map(|amounts| motion(amounts, true))).collect()
    }

    /// Returns the lines that the pairs resist, and their loads.
    pub(crate) fn resisted(&self) -> (SparseRows, Vec<f64>) {
        let Self { lines, loads, independent, .. } = self;
        (lines.select(&independent.rows), independent.rows.iter().map(|k| loads[*k]).collect())
    }

    /// Finds the motions that the closed rows leave free, of those that the pairs resist.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn left_by(&self, closed: &[bool]) -> Result<RowSelection, NnddError> {
        let (resisted, loads) = self.resisted();
        let mut lines = SparseRows::new(closed.len());
        resisted.rows().for_each(|line| lines.push(line.filter(|(row, _)| closed[*row])));
        let all = groups(self.rows);
        let groups: Vec<usize> = self.independent.rows.iter().map(|k| all[*k]).collect();
        Ok(RowSelection::new(&lines, &loads, &groups, self.rows.normal_error)?)
    }

    /// Tells for each row whether no motion changes it, but for rounding.
    pub(crate) fn leaves_alone(&self) -> Vec<bool> {
        let mut alone = vec![true; self.lines.columns()];
        for line in self.lines.rows() {
            let entries: Vec<(usize, f64)> = line.collect();
            let most = entries.iter().fold(0.0f64, |most, (_, entry)| most.max(entry.abs()));
            let moved = entries.iter().filter(|(_, entry)| entry.abs() > NO_TRACE * most);
            moved.for_each(|(row, _)| alone[*row] = false);
        }
        alone
    }

    /// Splits the loads into what no forces balance, whatever their sign, and the rest.
    fn parts(&self) -> (Vec<f64>, Vec<f64>) {
        let unbalanced = self.independent.unbalanced(&self.loads);
        let rest = self.loads.iter().zip(&unbalanced).map(|(e, part)| e - part).collect();
        (unbalanced, rest)
    }

    /// Returns forces that balance as much of the loads as possible, by row, N/m, and the loads that they balance.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn balanced(&self) -> Result<(Vec<f64>, Vec<f64>), NnddError> {
        let limits = self.rows.limits();
        let (matrix, [lower, upper], _) = self.forces(&limits);
        let discs = discs(self.rows, &limits);
        let (forces, _) = unbalanced_load(&matrix, &self.parts().1, [&lower, &upper], &discs)?;
        let loads = matrix.times(&forces);
        Ok((forces, loads))
    }

    /// Checks that the assembly is held.
    ///
    /// * `limits`: of the forces by row, infinite along normals, N/m.
    ///
    /// # Errors
    /// [`NnddError::NotHeld`] with the motion that the loads cause and nothing resists; [`NnddError::OutsideCones`].
    pub(crate) fn check_held(&self, limits: &[f64]) -> Result<(), NnddError> {
        match self.question(limits)? {
            Held::By(_) => Ok(()),
            Held::OutsideCones(motion) => Err(NnddError::OutsideCones { motion }),
            Held::Not(motion) => Err(NnddError::NotHeld { motion }),
        }
    }

    /// Lists the forces that can balance the loads: `G` in them, and their bounds. With the law of Coulomb and an infinite limit they are
    /// along the edges of the cones, `P n ± μ P t`.
    fn forces(&self, limits: &[f64]) -> (SparseRows, [Vec<f64>; 2], bool) {
        let mut bounds = self.rows.bounds(limits);
        // The other row of each cone, the friction coefficient, and the sign of its edge.
        let mut cones: Vec<Option<(usize, f64, f64)>> = vec![None; limits.len()];
        for pair in &self.rows.pairs {
            let both = pair.normal.clone().zip(pair.tangential.clone());
            for (n, t) in both.filter(|(_, t)| limits[*t] == f64::INFINITY) {
                let RowLaw::Coulomb { mu } = self.rows.rows[t].law else { continue };
                bounds[0][t] = 0.0;
                (cones[n], cones[t]) = (Some((t, mu, 1.0)), Some((n, mu, -1.0)));
            }
        }
        if cones.iter().all(Option::is_none) {
            return (self.lines.clone(), bounds, false);
        }
        let mut matrix = SparseRows::new(limits.len());
        for line in self.lines.rows() {
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

    /// Asks whether the assembly is held. Forces that are known to balance the loads answer it, see [`ContactRows::balancing`].
    fn question(&self, limits: &[f64]) -> Result<Held, NnddError> {
        if self.rows.motions.is_empty() {
            return Ok(Held::By(Vec::new()));
        }
        let (matrix, [lower, upper], cones) = self.forces(limits);
        let most = ROUNDING * self.rows.load_size;
        let left = |forces: &[f64]| -> Vec<f64> {
            matrix.times(forces).iter().zip(&self.loads).map(|(product, e)| e - product).collect()
        };
        let known = &self.rows.balancing;
        let discs = discs(self.rows, limits);
        let within = |(i, force): (usize, &f64)| (lower[i]..=upper[i]).contains(force);
        let in_disc = |disc: &Disc| size(&disc.unknowns.map(|i| known[i])) <= disc.radius;
        if known.len() == lower.len()
            && known.iter().enumerate().all(within)
            && discs.iter().all(in_disc)
            && size(&left(known)) <= most
        {
            return Ok(Held::By(known.clone()));
        }
        // What no forces balance is set apart: lines of round-off must not balance it. The rest is measured in the motions
        // themselves, so that only bodies move that must.
        let (unbalanced, rest) = self.parts();
        let (forces, mut free) = unbalanced_load(&matrix, &rest, [&lower, &upper], &discs)?;
        free.iter_mut().zip(&unbalanced).for_each(|(a, part)| *a += part);
        if !(size(&free) > most) {
            return Ok(Held::By(forces));
        }
        let motion = UnresistedMotion::along(&free);
        Ok(if cones { Held::OutsideCones(motion) } else { Held::Not(motion) })
    }
}

/// The projection on the forces `P̃` within their bounds that balance all floating bodies.
pub(crate) struct NearestForces {
    lines: BalanceRows,
    /// Inverse tributary lengths by row, 1/m: forces are near each other as pressures.
    weights: Vec<f64>,
    /// By row, N/m.
    bounds: [Vec<f64>; 2],
    tangential: Vec<bool>,
}

impl NearestForces {
    pub(crate) fn new(balance: &Balance<'_>) -> Self {
        let ((lines, loads), rows) = (balance.resisted(), balance.rows);
        Self {
            lines: BalanceRows::new(lines, loads),
            weights: rows.rows.iter().map(|row| 1.0 / row.length).collect(),
            bounds: rows.bounds(&rows.limits()),
            tangential: rows.rows.iter().map(|row| row.law.is_tangential()).collect(),
        }
    }

    /// Finds the forces in balance that are nearest to given ones within the bounds; `None` if no forces are in balance.
    ///
    /// * `touches`: tells of the rows along normals where forces do no work.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn to(
        &mut self,
        forces: &[f64],
        touches: impl Fn(usize) -> bool,
    ) -> Result<Option<Vec<f64>>, NnddError> {
        let Self { lines, weights, bounds: [lower, upper], tangential } = self;
        let bound = |(i, upper): (usize, &f64)| if touches(i) || tangential[i] { *upper } else { 0.0 };
        let of_touching: Vec<f64> = upper.iter().enumerate().map(bound).collect();
        let distance = |of: &[f64]| -> f64 {
            let change = of.iter().zip(forces).zip(&*weights);
            change.map(|((a, b), weight)| weight * (a - b) * (a - b)).sum()
        };
        let size = distance(&vec![0.0; forces.len()]);
        // Forces in open rows do work there, even the smallest: they appear only if the others are far from balance.
        let found = match lines.nearest(forces, weights, [lower, &of_touching])? {
            Some(found) if distance(&found.values) <= NEARLY * size => Some(found),
            far => lines.nearest(forces, weights, [lower, upper])?.or(far),
        };
        Ok(found.map(|found| found.values))
    }

    /// Returns the part of the loads that no forces balance in the closed rows, whatever their sign; `None` if it is round-off.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn left_by(&mut self, closed: &[bool]) -> Result<Option<Vec<f64>>, NnddError> {
        let size = size(self.lines.right_side());
        if size == 0.0 {
            return Ok(None);
        }
        let upper: Vec<f64> = closed.iter().map(|closed| if *closed { f64::INFINITY } else { 0.0 }).collect();
        let lower: Vec<f64> = upper.iter().map(|u| 0.0 - u).collect();
        let (_, left) = self.lines.unbalanced([&lower, &upper])?;
        Ok(Some(left).filter(|left| self::size(left) > NOT_HELD * size))
    }

    /// Returns the rate at which each row closes in a motion of the resisted lines.
    pub(crate) fn rates(&self, motion: &[f64]) -> Vec<f64> {
        self.lines.rows().transposed_times(motion)
    }
}

//! Coulomb friction: a fixed point of problems with the friction of Tresca.
//!
//! ```math
//! Sᵏ⁺¹ = μ P(Sᵏ),   P(S) of the exact solution with |Q| ≤ S
//! ```
//! from full stick, `S⁰ = ∞`, or from the limits of an earlier load step; each step from the active set of the last one. Full stick may hold a
//! body where nothing presses, such as a pin with clearance, and the limits of the next step are too small to balance its loads. Then it starts again
//! from the pressures without friction, under the part of the loads that they balance. If these limits are too small as well, they are doubled, a few
//! times at most. The existence and the uniqueness of solutions for large μ are open: what is found is *one* solution.

use crate::balance::Balance;
use crate::error::NnddError;
use crate::exact::{ExactSolution, ForceQp};
use crate::unresisted::UnresistedMotion;
use contact_qp::{BoundState, DiscStart, IndependentRows, QpSettings};
use fem_core::contact_system::{ContactSystem, RowLaw};
use nalgebra::DMatrix;

/// The balance of the floating bodies holds if the residual of its rows is at most this fraction of their terms.
const BALANCED: f64 = 1e-10;

/// Forces below this fraction of the ones that the data have are rounding: pairs that carry nothing would never agree.
const ROUND_OFF: f64 = 1e-14;

/// Limits that are too small to balance the loads are replaced this many times: by those of the pressures without friction, then by twice as much.
const MOST_RESTARTS: usize = 4;

/// Settings of [`solve_coulomb`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CoulombSettings {
    /// Ends with `‖s_k − s_{k−1}‖ ≤ tolerance · ‖s_k‖`, in the norm `Σ ℓ s²`; default 1e-6.
    pub tolerance: f64,
    /// Maximum number of steps; default 50.
    pub max_steps: usize,
    /// How each problem with the friction of Tresca is solved.
    pub qp: QpSettings,
}

impl Default for CoulombSettings {
    fn default() -> Self {
        Self { tolerance: 1e-6, max_steps: 50, qp: QpSettings::default() }
    }
}

/// How the fixed point ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoulombStatus {
    /// The change is at most the tolerance.
    Converged,
    /// All steps were used.
    MaxSteps,
    /// The limits were too small to balance the loads, again and again.
    TooSmall,
    /// A step was not solved, or its forces do not balance the loads.
    Unsolved,
    /// The caller ended it.
    Interrupted,
}

/// Where the fixed point starts, instead of full stick.
#[derive(Clone, Debug)]
pub struct CoulombStart {
    limits: Vec<f64>,
    programme: DiscStart,
}

/// The result of [`solve_coulomb`]: one solution of the discrete problem with Coulomb friction, if it converged.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CoulombSolution {
    /// The exact solution of the last step, with the limits of that step.
    pub exact: ExactSolution,
    /// How it ended.
    pub status: CoulombStatus,
    /// Problems with the friction of Tresca that were solved.
    pub steps: usize,
    /// `‖s_k − s_{k−1}‖ / ‖s_k‖` of each step after the first.
    pub changes: Vec<f64>,
    /// How often limits that were too small were replaced by larger ones.
    pub restarts: usize,
    /// The motion that the limits `μ P` of the pressures found do not resist, with the load that is left; `None` unless they were too small in the end.
    pub unresisted: Option<UnresistedMotion>,
    /// Where the next load step starts.
    pub start: CoulombStart,
}

/// Solves the discrete contact problem with the friction of Coulomb; pairs with another law keep it.
///
/// * `start`: that of an earlier load step of the same problem; from full stick without it, and if its limits cannot balance the loads.
/// * `proceed`: asked after each step whether to continue.
///
/// # Errors
/// [`NnddError::OutsideCones`] if no forces within the cones of friction balance the loads; a programme that is rejected.
pub fn solve_coulomb(
    system: &ContactSystem<'_>,
    settings: &CoulombSettings,
    start: Option<CoulombStart>,
    mut proceed: impl FnMut() -> bool,
) -> Result<CoulombSolution, NnddError> {
    let programme = ForceQp::new(system)?;
    let known = start.filter(|start| start.limits.len() == system.rows.len());
    let (mut limits, first) = match known {
        Some(start) if programme.unresisted(&start.limits)?.is_none() => {
            (start.limits, Some(start.programme))
        }
        _ => (system.rows.limits(), None),
    };
    let (mut exact, mut last) = programme.solve(&limits, first.as_ref(), &settings.qp)?;
    let (mut steps, mut restarts, mut changes) = (1, 0, Vec::new());
    let mut unresisted = None;
    let status = loop {
        if !exact.status.is_solved() || !(exact.kkt.rows <= BALANCED) {
            break CoulombStatus::Unsolved;
        }
        let mut next = programme.coulomb_limits(&limits, &exact);
        let change = programme.change(&limits, &next);
        if steps > 1 {
            changes.push(change);
        }
        if change <= settings.tolerance {
            break CoulombStatus::Converged;
        }
        if steps >= settings.max_steps {
            break CoulombStatus::MaxSteps;
        }
        if !proceed() {
            break CoulombStatus::Interrupted;
        }
        let mut start = programme.within(&last, &exact, &limits, &next);
        unresisted = programme.unresisted(&next)?;
        if restarts == 0 && (unresisted.is_some() || programme.nothing_presses(&next)) {
            restarts = 1;
            (next, start) = programme.without_friction(&settings.qp)?;
            unresisted = programme.unresisted(&next)?;
        }
        let mut held = unresisted.is_none();
        while !held && restarts < MOST_RESTARTS {
            restarts += 1;
            programme.double_coulomb(&mut next);
            held = programme.unresisted(&next)?.is_none();
        }
        if !held {
            break CoulombStatus::TooSmall;
        }
        limits = next;
        (exact, last) = programme.solve(&limits, Some(&start), &settings.qp)?;
        steps += 1;
    };
    let unresisted = unresisted.filter(|_| status == CoulombStatus::TooSmall);
    let start = CoulombStart { limits, programme: last };
    Ok(CoulombSolution { exact, status, steps, changes, restarts, unresisted, start })
}

impl ForceQp<'_> {
    /// Returns the start with other limits: rows whose limit is zero are fixed, those whose limit was zero continue as they slip.
    fn within(&self, last: &DiscStart, exact: &ExactSolution, before: &[f64], limits: &[f64]) -> DiscStart {
        let mut start = last.clone();
        for (pair, friction) in self.system.rows.pairs.iter().zip(&exact.friction) {
            for (row, slip) in pair.tangential.clone().zip(&friction.slip) {
                start.states[row] = match limits[row] {
                    0.0 => BoundState::Lower,
                    _ if before[row] != 0.0 => last.states[row],
                    _ if *slip > 0.0 => BoundState::Upper,
                    _ if *slip < 0.0 => BoundState::Lower,
                    _ => BoundState::Free,
                };
            }
        }
        start
    }

    /// Returns the limits `S = μ P` of the pairs with Coulomb friction, and the given ones of all other rows.
    fn coulomb_limits(&self, limits: &[f64], exact: &ExactSolution) -> Vec<f64> {
        let mut next = limits.to_vec();
        for (pair, forces) in self.system.rows.pairs.iter().zip(&exact.contact_force) {
            for (row, force) in pair.tangential.clone().zip(forces.iter().cycle()) {
                if let RowLaw::Coulomb { mu } = self.system.rows.rows[row].law {
                    next[row] = mu * force;
                }
            }
        }
        next
    }

    /// Computes `‖s − s'‖/‖s'‖` over the rows with Coulomb friction; infinite from full stick, 0 if both differ by rounding alone.
    fn change(&self, limits: &[f64], next: &[f64]) -> f64 {
        let (mut difference, mut size, mut rounding) = (0.0, 0.0, 0.0);
        let noise = ROUND_OFF * self.force_size();
        for (row, of) in self.system.rows.rows.iter().enumerate() {
            if let RowLaw::Coulomb { mu } = of.law {
                // ℓ s² of a nodal limit S = ℓ s.
                difference += (next[row] - limits[row]).powi(2) / of.length;
                size += next[row].powi(2) / of.length;
                rounding += (mu * noise).powi(2) / of.length;
            }
        }
        if difference <= rounding { 0.0 } else { (difference / size).sqrt() }
    }

    fn double_coulomb(&self, limits: &mut [f64]) {
        for (limit, row) in limits.iter_mut().zip(&self.system.rows.rows) {
            if matches!(row.law, RowLaw::Coulomb { .. }) {
                *limit *= 2.0;
            }
        }
    }

    /// Returns the limits `μ P` of the pressures without the friction of Coulomb, and the start with them. Loads that only this
    /// friction resists are left out.
    fn without_friction(&self, settings: &QpSettings) -> Result<(Vec<f64>, DiscStart), NnddError> {
        let mut system = self.system.clone();
        for row in &mut system.rows.rows {
            if matches!(row.law, RowLaw::Coulomb { .. }) {
                row.law = RowLaw::Coulomb { mu: 0.0 };
            }
        }
        let (forces, loads) = Balance::new(&system.rows)?.balanced()?;
        system.rows.balancing = forces;
        system.rows.motions.iter_mut().zip(loads).for_each(|(motion, load)| motion.load = load);
        let limits = system.rows.limits();
        let (exact, last) = ForceQp::new(&system)?.solve(&limits, None, settings)?;
        let next = self.coulomb_limits(&limits, &exact);
        let start = self.within(&last, &exact, &limits, &next);
        Ok((next, start))
    }

    /// Tells whether all limits of the friction of Coulomb are zero.
    fn nothing_presses(&self, limits: &[f64]) -> bool {
        let mut rows = self.system.rows.rows.iter().zip(limits);
        rows.all(|(row, limit)| *limit == 0.0 || !matches!(row.law, RowLaw::Coulomb { .. }))
    }

    /// Returns the motion that forces within limits do not resist; `None` if they can balance the loads.
    fn unresisted(&self, limits: &[f64]) -> Result<Option<UnresistedMotion>, NnddError> {
        match self.balance().check_held(limits) {
            Ok(()) => Ok(None),
            Err(NnddError::NotHeld { motion } | NnddError::OutsideCones { motion }) => Ok(Some(motion)),
            Err(other) => Err(other),
        }
    }
}

/// Computes the coupling `c` between pressure and slip with Coulomb friction, on the mesh:
/// ```math
/// c   = sup (∫ μ θ π ω)/(|||π||| |||ω|||) over π, ω
/// c²  = max eig(Θ F_tt Θ, F_nn − F_nt F_tt⁻¹ F_tn)
/// Θ   = diag(μ θ)
/// ```
/// π is the normal traction of a self-equilibrated stress, its energy least over the friction, ω a slip with the normal free. For
/// one pair `c = μ κ`. With floating bodies each is in balance on its own: `G_n π = 0`, `G_t q = 0`. It is a value of the mesh, which may
/// grow as the mesh is refined.
///
/// * `signs`: θ of each pair, the sign of its slips; 0 for pairs that do not count.
///
/// Returns `None` if the matrices are singular, and in space: slips have directions there, not signs.
///
/// # Errors
/// See [`solve_coulomb`].
///
/// # Panics
/// If there is not one sign per pair.
pub fn coulomb_coupling(system: &ContactSystem<'_>, signs: &[f64]) -> Result<Option<f64>, NnddError> {
    let rows = &system.rows;
    let pairs = &rows.pairs;
    assert!(signs.len() == pairs.len(), "{} signs, and {} pairs", signs.len(), pairs.len());
    if rows.tangential_planes().next().is_some() {
        return Ok(None);
    }
    let programme = ForceQp::new(system)?;
    let limits = rows.limits();
    let normal: Vec<usize> = (0..rows.len()).filter(|i| !rows.is_tangential(*i)).collect();
    let tangential: Vec<usize> =
        (0..rows.len()).filter(|i| rows.is_tangential(*i) && limits[*i] > 0.0).collect();
    let tangential: Vec<usize> = tangential.into_iter().filter(|i| !programme.is_imposed(*i)).collect();
    let block =
        |a: &[usize], b: &[usize]| DMatrix::from_fn(a.len(), b.len(), |i, j| programme.entry(a[i], b[j]));
    // Self-equilibrated: within the kernels of the rows of the balance.
    let (of_n, of_t) = (programme.kernel(&normal), programme.kernel(&tangential));
    let across = block(&tangential, &normal);
    let Some(factor) = (of_t.transpose() * block(&tangential, &tangential) * &of_t).cholesky() else {
        return Ok(None);
    };
    let slipping = of_t.transpose() * &across * &of_n;
    let least =
        of_n.transpose() * block(&normal, &normal) * &of_n - slipping.transpose() * factor.solve(&slipping);
    let mut weights = DMatrix::zeros(tangential.len(), normal.len());
    for (pair, sign) in pairs.iter().zip(signs) {
        for (n, t) in pair.normal.clone().zip(pair.tangential.clone()) {
            let RowLaw::Coulomb { mu } = rows.rows[t].law else { continue };
            if let (Ok(i), Ok(j)) = (tangential.binary_search(&t), normal.binary_search(&n)) {
                weights[(i, j)] = mu * sign;
            }
        }
    }
    // (ZᵀF_tt Θ π)ᵀ (ZᵀF_tt Z)⁻¹ (ZᵀF_tt Θ π).
    let pushed = of_t.transpose() * block(&tangential, &tangential) * weights * &of_n;
    let largest = pushed.transpose() * factor.solve(&pushed);
    let Some(least) = least.cholesky() else { return Ok(None) };
    let Some(half) = least.l().solve_lower_triangular(&largest) else { return Ok(None) };
    let Some(whole) = least.l().solve_lower_triangular(&half.transpose()) else { return Ok(None) };
    let eigenvalues = (0.5 * (&whole + whole.transpose())).symmetric_eigenvalues();
    let largest = eigenvalues.iter().copied().fold(0.0, f64::max);
    Ok(Some(largest.sqrt()).filter(|c| c.is_finite()))
}

impl ForceQp<'_> {
    /// Computes an orthonormal basis of the forces in some rows that are in balance on their own.
    fn kernel(&self, rows: &[usize]) -> DMatrix<f64> {
        let count = self.system.rows.len();
        let lines = self.lines().rows.dense();
        let lines = lines.chunks_exact(count.max(1));
        let entries: Vec<f64> = lines.flat_map(|line| rows.iter().map(|i| line[*i])).collect();
        let zero = vec![0.0; entries.len().checked_div(rows.len()).unwrap_or(0)];
        let basis = IndependentRows::new(&entries, &zero).rows;
        if basis.is_empty() {
            return DMatrix::identity(rows.len(), rows.len());
        }
        let span =
            DMatrix::from_column_slice(rows.len(), basis.len().checked_div(rows.len()).unwrap_or(0), &basis);
        let projector = DMatrix::identity(rows.len(), rows.len()) - &span * span.transpose();
        let eigen = projector.symmetric_eigen();
        let kept: Vec<usize> = (0..rows.len()).filter(|k| eigen.eigenvalues[*k] > 0.5).collect();
        eigen.eigenvectors.select_columns(&kept)
    }
}

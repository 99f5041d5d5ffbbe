//! The steps from a problem with Coulomb friction to one solution of it, with its residual.

use crate::coulomb::CoulombResult;
use crate::error::SolveError;
use crate::observer::{Observer, Phase};
use crate::pretension;
use crate::results::results;
use crate::solve::{Previous, prepare};
use crate::space::ContactSpace;
use crate::state::state_of;
use cre_estimator::{Relaxation, estimate_with};
use fem_core::contact_system::{ContactSystem, PairRows, RowLaw};
use fem_core::interface::{Bonds, ContactPair, ContactProblem};
use fem_core::prepared::FactorisedBody;
use nndd::{CoulombSettings, CoulombStart, NnddError, PairFriction, coulomb_coupling};

/// Solves a contact problem with Coulomb friction in one or more of its pairs. The other pairs keep their law.
///
/// * `relaxation`: how far the equilibrated stresses of the residual are relaxed.
///
/// # Errors
/// A body without unique solution; loads that no forces within the cones of friction balance; a problem
/// without Coulomb friction, which [`crate::solve`] certifies. No convergence is a status of the solution.
pub fn solve_coulomb<S: ContactSpace>(
    problem: ContactProblem<S>,
    settings: &CoulombSettings,
    relaxation: Relaxation,
    observer: &mut dyn Observer<S>,
) -> Result<CoulombResult<S>, SolveError<S>> {
    Ok(solve_coulomb_step(problem, Previous::default(), settings, relaxation, observer)?.0)
}

/// A load step with Coulomb friction, and the factorised bodies.
pub(crate) type CoulombStep<S> = (CoulombResult<S>, Vec<FactorisedBody<S>>);

/// Solves a load step with Coulomb friction, and returns the factorised bodies as well.
pub(crate) fn solve_coulomb_step<S: ContactSpace>(
    problem: ContactProblem<S>,
    previous: Previous<CoulombStart, S>,
    settings: &CoulombSettings,
    relaxation: Relaxation,
    observer: &mut dyn Observer<S>,
) -> Result<CoulombStep<S>, SolveError<S>> {
    if problem.contacts.iter().all(|pair| pair.friction.coulomb().is_none()) {
        return Err(SolveError::NoCoulomb);
    }
    pretension::check(&problem, false)?;
    // Friction beside bonds is refused.
    Bonds::new(&problem)?;
    let prepared = prepare(problem, previous.bodies, &[], observer)?;
    observer.phase(Phase::Iterations);
    let proceed = || !observer.should_stop() && !observer.must_stop();
    let system = prepared.system();
    let of_nndd = |error| SolveError::of_nndd(prepared.problem(), error);
    let solution = nndd::solve_coulomb(&system, settings, previous.start, proceed).map_err(of_nndd)?;
    if observer.must_stop() {
        return Err(SolveError::Stopped);
    }
    observer.phase(Phase::Estimate);
    let last = solution.exact.iterate(&system);
    let displacement = prepared.displacements(&solution.exact.fields);
    let fields = displacement.iter().map(Vec::as_slice).collect();
    let estimate = estimate_with(&prepared, &state_of(&prepared, &last, fields), relaxation)?;
    let signs = signs(prepared.problem(), &solution.exact.friction);
    let (kappa, coupling) = match &signs {
        Some(signs) => couplings(&system, signs).map_err(of_nndd)?,
        None => (None, None),
    };
    let results = results((prepared.problem(), prepared.external_forces(), &[]), &last, &estimate, None);
    let unknowns = prepared.bodies().iter().map(FactorisedBody::unknowns).collect();
    let (problem, bodies) = prepared.into_parts();
    let one_sign = signs.is_some();
    let result = CoulombResult {
        problem,
        solution,
        displacement,
        last,
        results,
        unknowns,
        estimate,
        one_sign,
        kappa,
        coupling,
    };
    Ok((result, bodies))
}

/// Computes the coupling between pressure and slip without and with the coefficients of friction, `κ_h` and `c`.
fn couplings(system: &ContactSystem<'_>, signs: &[f64]) -> Result<(Option<f64>, Option<f64>), NnddError> {
    let coupling = coulomb_coupling(system, signs)?;
    let of_pair = |pair: &PairRows| match system.rows.rows[pair.all()].last().map(|row| row.law) {
        Some(RowLaw::Coulomb { mu }) => mu,
        _ => 0.0,
    };
    let coefficients: Vec<f64> = system.rows.pairs.iter().map(of_pair).collect();
    let mut acting = coefficients.iter().copied().filter(|mu| *mu > 0.0);
    let kappa = match acting.next() {
        None => None,
        // c = μ κ.
        Some(mu) if acting.all(|other| other == mu) => coupling.map(|c| c / mu),
        Some(_) => {
            let unweighted = coefficients.iter().zip(signs);
            let unweighted = unweighted.map(|(mu, sign)| if *mu > 0.0 { sign / mu } else { 0.0 });
            coulomb_coupling(system, &unweighted.collect::<Vec<_>>())?
        }
    };
    Ok((kappa, coupling))
}

/// Returns the common sign of all slips of each pair with Coulomb friction, open parts included, 0 for other pairs; `None` if a pair slips
/// in both directions, and in space.
fn signs<S: ContactSpace>(problem: &ContactProblem<S>, friction: &[PairFriction]) -> Option<Vec<f64>> {
    let of_pair = |(pair, friction): (&ContactPair<S>, &PairFriction)| {
        if pair.friction.coulomb().is_none() {
            return Some(0.0);
        }
        let forwards = friction.slip.iter().any(|w| *w > 0.0);
        let backwards = friction.slip.iter().any(|w| *w < 0.0);
        (!forwards || !backwards).then_some(if backwards { -1.0 } else { 1.0 })
    };
    if S::ONE_TANGENT { problem.contacts.iter().zip(friction).map(of_pair).collect() } else { None }
}

//! What is called: checks what is given, sets the steps up, and iterates or solves exactly.

use crate::active_set::ActiveSet;
use crate::balance::Balance;
use crate::error::NnddError;
use crate::exact::refuse_coulomb;
use crate::exact_iterate;
use crate::iteration::Start;
use crate::newton_nn;
use crate::paper::iteration;
use crate::settings::{Method, NnddSettings};
use crate::solution::NnddSolution;
use crate::stopping::StoppingCriterion;
use fem_core::contact_system::{ContactSystem, PairRows, Partner};

/// Solves a contact problem of any number of bodies and pairs by the Neumann-Neumann iteration (8)-(11), or exactly.
///
/// * `lambda`: the initial trace λ of each Ω₁ at its pairs of nodes, pair after pair, m; with friction each pair's tangential
///   traces follow its normal ones. The exact solution does not use it.
/// * `method`: settings of either, such as [`NnddSettings::default`].
/// * `stop`: called after every iteration. The exact solution, see [`crate::solve_exactly`], is the only iterate.
///
/// The pair of step 1 of the last iteration is in `last`; it is kinematically admissible exactly.
///
/// # Errors
/// Sizes that do not match, a θ that is not positive, a contact problem that is rejected, a criterion that fails; bodies that the
/// loads move and nothing holds, [`NnddError::NotHeld`]; for the iteration [`NnddError::DependentRows`]. No convergence is a status,
/// not an error.
pub fn solve(
    system: &ContactSystem<'_>,
    lambda: Vec<f64>,
    method: impl Into<Method>,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    solve_from(system, Start { lambda, active: None }, &method.into(), stop)
}

/// Solves a contact problem like [`solve`], starting from the result of a similar one.
///
/// # Errors
/// See [`solve`].
pub fn solve_from(
    system: &ContactSystem<'_>,
    start: Start,
    method: &Method,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    check(system, &start, method)?;
    match method {
        Method::Newton(settings) => exact_iterate::solve(system, settings, stop),
        Method::Nndd(settings) => {
            refuse_coulomb(system)?;
            if let Some(pair) = system.rows.pairs.iter().position(is_within_a_body) {
                return Err(NnddError::WithinABody { pair });
            }
            if let Some([row, _]) = system.rows.tangential_planes().next() {
                return Err(NnddError::FrictionInSpace { pair: system.rows.rows[row].pair });
            }
            let balance = Balance::new(&system.rows)?;
            balance.check_held(&system.rows.limits())?;
            iteration((system, &balance), start, settings, stop)
        }
        Method::NewtonNn(settings) => match system.rows.pairs.iter().any(needs_exact) {
            true => exact_iterate::solve(system, settings, stop),
            false => newton_nn::solve(system, start, settings, stop),
        },
    }
}

/// Tells whether both sides of a pair belong to one body, which bonds made.
fn is_within_a_body(pair: &PairRows) -> bool {
    pair.partner == Partner::Body(pair.body)
}

/// Tells whether Newton's method leaves a pair to the exact solution.
fn needs_exact(pair: &PairRows) -> bool {
    pair.has_friction() || is_within_a_body(pair)
}

/// Checks what is given.
fn check(
    system: &ContactSystem<'_>,
    Start { lambda, active }: &Start,
    method: &Method,
) -> Result<(), NnddError> {
    let (expected, found) = (system.rows.len(), lambda.len());
    if found != expected {
        return Err(NnddError::Length { what: "lambda", found, expected });
    }
    if let Some(pair) = lambda.iter().position(|l| !l.is_finite()) {
        return Err(NnddError::Lambda { pair, found: lambda[pair] });
    }
    let expected = system.rows.node_pairs();
    let found = active.as_ref().map_or(expected, ActiveSet::len);
    if found != expected {
        return Err(NnddError::Length { what: "the active set at the start", found, expected });
    }
    match method {
        Method::Nndd(NnddSettings { theta: Some(found), .. }) if !(*found > 0.0 && found.is_finite()) => {
            Err(NnddError::Theta { found: *found })
        }
        _ => Ok(()),
    }
}

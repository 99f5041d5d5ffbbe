//! From the case file's words to the libraries' settings.

use case_io::Case;
use case_io::case;
use case_io::case::Dimension;
use certified_contact::{Criterion, Imposed, Settings};
use contact_qp::QpMethod;
use cre_estimator::Relaxation;
use fem_core::interface::{Bonds, ContactProblem};
use nndd::{Acceleration, CoulombSettings, Method, NewtonSettings, NnddSettings, Weights};

/// Makes the settings of a solve from the settings in a case.
pub fn settings<S: Dimension>(case: &Case<S>) -> Settings<S> {
    let solver = &case.solver;
    let mut settings = Settings::default();
    settings.imposed = imposed(solver.imposed);
    settings.lambda = solver.lambda.scalar();
    settings.criterion = match solver.stop.criterion {
        case::Criterion::Estimator => {
            let case::Stop { ratio, force_balance, .. } = solver.stop;
            Criterion::Estimator { ratio, force_balance }
        }
        case::Criterion::Precision => Criterion::Precision { tolerance: solver.stop.tolerance },
        case::Criterion::EtaNndd => Criterion::EtaNndd { tolerance: solver.stop.tolerance },
        case::Criterion::Iterations => Criterion::Iterations,
    };
    settings.relaxation = relaxation(case);
    settings.subdomains = match solver.subdomains {
        case::Subdomains::Auto => 1,
        case::Subdomains::Count(count) => count,
    };
    settings.estimate_every = case.estimator.every;
    settings.imposed_by_pair = case.contacts.iter().map(|contact| contact.imposed.map(imposed)).collect();
    let exact = newton(solver, solver.max_iterations);
    match solver.method {
        case::Method::Newton | case::Method::Exact => settings.with_method(exact),
        case::Method::Nndd => settings.with_method(iteration(solver)),
        case::Method::NewtonNn => settings.with_method(Method::NewtonNn(exact)),
        case::Method::Auto if asks_for_iteration(case) => settings.with_method(iteration(solver)),
        case::Method::Auto => {
            let mut settings = settings.with_method(Method::NewtonNn(exact.clone()));
            settings.exact = Some(exact);
            settings
        }
    }
}

/// Returns how far a case relaxes the stresses.
pub fn relaxation<S: Dimension>(case: &Case<S>) -> Relaxation {
    match case.estimator.until {
        None => Relaxation::Steps(case.estimator.relaxation),
        Some(until) => Relaxation::Tolerance { tolerance: until.tolerance, max_steps: until.max_steps },
    }
}

/// Makes the settings of a solve with Coulomb friction from the settings in a case.
pub(crate) fn coulomb<S: Dimension>(case: &Case<S>) -> CoulombSettings {
    let mut settings = CoulombSettings::default();
    settings.tolerance = case.solver.friction_tolerance;
    settings.max_steps = case.solver.friction_steps;
    settings.qp.method = qp(&case.solver);
    settings
}

/// Tells whether settings of the paper's iteration, or a number of iterations, choose it.
fn asks_for_iteration<S: Dimension>(case: &Case<S>) -> bool {
    !case.given_update_settings().is_empty() || case.solver.stop.criterion == case::Criterion::Iterations
}

/// Returns the method that solves a problem: the one of the case, or what its `auto` chooses.
pub fn method<S: Dimension>(case: &Case<S>, problem: &ContactProblem<S>) -> case::Method {
    let bonds = Bonds::new(problem).ok().flatten();
    match settings(case).method_for(bonds.as_ref().map_or(problem, |bonds| &bonds.joined)) {
        Method::Nndd(_) => case::Method::Nndd,
        Method::NewtonNn(_) => case::Method::NewtonNn,
        _ => case::Method::Exact,
    }
}

/// Tells whether a case is solved exactly, without an iteration.
pub(crate) fn is_exact<S: Dimension>(case: &Case<S>, problem: &ContactProblem<S>) -> bool {
    method(case, problem) == case::Method::Exact
}

fn imposed(word: case::Imposed) -> Imposed {
    match word {
        case::Imposed::First => Imposed::First,
        case::Imposed::Second => Imposed::Second,
        case::Imposed::Auto => Imposed::Auto,
    }
}

/// The settings of the exact solution.
fn newton(solver: &case::Solver, max_iterations: usize) -> NewtonSettings {
    let mut newton = NewtonSettings::default();
    newton.max_iterations = max_iterations;
    newton.qp.method = qp(solver);
    newton
}

fn qp(solver: &case::Solver) -> QpMethod {
    match solver.qp {
        case::QpChoice::Auto => QpMethod::Auto,
        case::QpChoice::Clarabel => QpMethod::Clarabel,
        case::QpChoice::ActiveSet => QpMethod::ActiveSet,
    }
}

/// The settings of the iteration.
fn iteration(solver: &case::Solver) -> NnddSettings {
    let mut nndd = NnddSettings::default();
    nndd.theta = match solver.theta {
        case::Theta::Auto => None,
        case::Theta::Value(theta) => Some(theta),
    };
    nndd.weights = match solver.weights {
        case::Weights::Half => Weights::Half,
        case::Weights::Stiffness => Weights::Stiffness,
    };
    nndd.acceleration = match solver.acceleration {
        case::Acceleration::None => Acceleration::None,
        // The word of old cases, with a note.
        case::Acceleration::Aitken | case::Acceleration::Anderson => Acceleration::Anderson,
    };
    nndd.coarse = solver.coarse;
    nndd.max_iterations = solver.max_iterations;
    nndd.qp.method = qp(solver);
    nndd
}

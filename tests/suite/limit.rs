//! The iteration's limit is the interface Newton method's answer, for all weights, accelerations and roles.

use fem_core::interface::{ContactProblem, Roles};
use nndd::{Acceleration, Iterate, NnddSettings, NnddStatus, Weights};
use tests::run::{newton, norm_and_distance, relative_difference};
use tests::{certify, displacements, heavy, iterates, paper, prepare};

/// Stiffness contrasts: moduli and a traction that keeps the displacements moderate.
const EQUAL: ([f64; 2], f64) = ([1500.0, 1500.0], 30.0);
const PAPER: ([f64; 2], f64) = (paper::YOUNG, paper::TRACTION);
const STIFF: ([f64; 2], f64) = ([20000.0, 1000.0], 30.0);
const SOFT: ([f64; 2], f64) = ([50.0, 1000.0], 1.0);
const VERY_STIFF: ([f64; 2], f64) = ([1e6, 1000.0], 30.0);

fn problem((young, traction): ([f64; 2], f64)) -> ContactProblem {
    paper::problem_with(paper::COARSE, young, traction, paper::PUSH, 0.0).unwrap()
}

fn touching(iterate: &Iterate) -> Vec<bool> {
    iterate.contact.normal_reaction.iter().map(|r| *r > 0.0).collect()
}

/// Runs the iteration to 1e-11 and compares it with Newton; returns the number of iterations.
fn reaches_newton(problem: &ContactProblem, settings: &NnddSettings) -> usize {
    let prepared = prepare(problem);
    let reference = newton(&prepared).unwrap();
    let (solution, all) = iterates(&prepared, settings, 1e-11).unwrap();
    let how = format!("{:?} {:?} {:?}", settings.weights, settings.acceleration, settings.theta);
    assert_eq!(solution.status, NnddStatus::StoppedByCriterion, "{how}");
    let (u, v) = (displacements(&prepared, &reference), displacements(&prepared, &solution.last));
    let [norm, distance] = norm_and_distance(problem, &u, &v);
    assert!(distance < 1e-9 * norm, "{how}: {:e} after {} iterations", distance / norm, all.len());
    assert_eq!(touching(&reference), touching(&solution.last), "{how}");
    all.len()
}

/// θ from the spectrum.
const AUTO: Option<f64> = None;

fn with(weights: Weights, acceleration: Acceleration, theta: Option<f64>) -> NnddSettings {
    let mut settings = NnddSettings::default();
    settings.weights = weights;
    settings.acceleration = acceleration;
    settings.theta = theta;
    settings.max_iterations = 250;
    settings
}

#[test]
fn half_weights_reach_the_newton_solution() {
    use Acceleration::{Anderson, None};
    for (case, acceleration, theta) in [
        (EQUAL, None, Some(0.5)),
        (EQUAL, None, AUTO),
        (PAPER, None, Some(0.4)),
        (PAPER, Anderson, AUTO),
        (STIFF, None, AUTO),
        (STIFF, Anderson, AUTO),
        (SOFT, Anderson, AUTO),
    ] {
        reaches_newton(&problem(case), &with(Weights::Half, acceleration, theta));
    }
}

#[test]
fn stiffness_weights_reach_the_newton_solution() {
    use Acceleration::{Anderson, None};
    for (case, acceleration) in [
        (EQUAL, None),
        (PAPER, None),
        (PAPER, Anderson),
        (STIFF, None),
        (STIFF, Anderson),
        (SOFT, Anderson),
        (VERY_STIFF, None),
        (VERY_STIFF, Anderson),
    ] {
        reaches_newton(&problem(case), &with(Weights::Stiffness, acceleration, AUTO));
    }
}

#[test]
fn gaps_rollers_and_body_forces_reach_the_newton_solution() {
    for angle in [0.0, 0.3, 2.0] {
        reaches_newton(&heavy::problem(angle, 8).unwrap(), &NnddSettings::default());
    }
}

#[test]
fn exchanged_roles_give_the_same_solution_and_certificate() {
    for problem in [problem(PAPER), problem(STIFF), heavy::problem(0.3, 8).unwrap()] {
        let run = |problem: &ContactProblem| {
            let prepared = prepare(problem);
            let (solution, _) = iterates(&prepared, &NnddSettings::default(), 1e-11).unwrap();
            assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
            let estimate = certify(&prepared, &solution.last).unwrap();
            (displacements(&prepared, &solution.last), estimate, solution.last)
        };
        let (u, estimate, last) = run(&problem);
        let (v, other, other_last) = run(&problem.clone().with_roles(Roles::SECOND));
        let [norm, distance] = norm_and_distance(&problem, &u, &v);
        assert!(distance < 1e-9 * norm, "{:e}", distance / norm);
        assert_eq!(touching(&last), touching(&other_last));
        assert!(relative_difference(&[estimate.cre.e_cre()], &[other.cre.e_cre()]) < 1e-9);
        assert!(other.admissibility.is_valid(), "{:?}", other.admissibility);
        for b in 0..2 {
            let cells = [&estimate.cre.by_cell[b], &other.cre.by_cell[b]];
            assert!(relative_difference(cells[0], cells[1]) < 1e-7);
        }
    }
}

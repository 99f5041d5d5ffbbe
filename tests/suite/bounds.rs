//! Bounds of energies and of the contact force, against exact solutions.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, Bounds, Criterion, Settings, Silent, solve, solve_adaptively,
};
use cre_estimator::Relaxation;
use fem_core::interface::ContactProblem;
use fem_core::norm::energy_error_squared;
use nndd::NnddSettings;
use tests::columns::Columns;
use tests::signorini;

fn family() -> Vec<Columns> {
    let soft = [(2000.0, 0.3), (1000.0, 0.2)];
    let base = Columns { materials: soft, weights: [0.0; 2], push: 0.01, gap: 0.0 };
    vec![
        base,
        Columns { gap: 0.004, ..base },
        Columns { weights: [30.0, 50.0], ..base },
        Columns { weights: [30.0, -50.0], gap: 0.002, ..base },
        Columns { weights: [40.0, -10.0], materials: [(100.0, 0.0), (1000.0, 0.45)], ..base },
        // The gap stays open: no pressure.
        Columns { weights: [3.0, 5.0], gap: 0.1, ..base },
    ]
}

fn bounds(problem: ContactProblem, settings: &Settings) -> Bounds {
    let answer = solve(problem, settings, &mut Silent).unwrap();
    assert!(answer.is_certified(), "{:?}", answer.estimate.map(|e| e.admissibility));
    answer.bounds.unwrap()
}

#[track_caller]
fn holds(what: &str, [low, high]: [f64; 2], exact: f64) {
    assert!(low <= exact && exact <= high, "{what}: {exact} outside [{low}, {high}]");
}

fn all_hold(columns: &Columns, found: &Bounds) {
    let exact = columns.exact();
    // If an answer is exact the interval is as wide as round-off; the reference has round-off too.
    let slack = |x: [f64; 2], scale: f64| [x[0] - 1e-13 * scale, x[1] + 1e-13 * scale];
    let norm = exact.energy_norm_squared.sqrt();
    holds("energy norm", slack(found.energy_norm, norm), norm);
    let scale = exact.potential_energy.abs() + exact.energy_norm_squared;
    holds("potential energy", slack(found.potential_energy, scale), exact.potential_energy);
    let force = found.contact_force.unwrap();
    holds("contact force", slack(force, exact.contact_force.max(norm)), exact.contact_force);
}

#[test]
fn they_hold_on_exact_columns_and_close_in() {
    for columns in family() {
        let widths: Vec<[f64; 3]> = [2, 4, 8, 16]
            .into_iter()
            .map(|n| {
                let found = bounds(columns.problem(n).unwrap(), &Settings::default());
                all_hold(&columns, &found);
                let width = |x: [f64; 2]| x[1] - x[0];
                [width(found.energy_norm), width(found.potential_energy), width(found.contact_force.unwrap())]
            })
            .collect();
        if columns.weights == [0.0; 2] {
            continue;
        }
        // Norm and force with h, the energy with h².
        for (k, least) in [(0, 1.7), (1, 3.0), (2, 1.7)] {
            for w in widths.windows(2) {
                assert!(w[0][k] > least * w[1][k], "{columns:?}: {widths:?}");
            }
        }
    }
}

#[test]
fn they_hold_at_every_iteration_however_far_from_the_limit() {
    for columns in family() {
        for iterations in 1..6 {
            for theta in [0.1, 0.25, 0.4] {
                let mut settings = Settings::default();
                settings.method = NnddSettings::paper(theta).into();
                settings.method = settings.method.with_max_iterations(iterations);
                settings.criterion = Criterion::Iterations;
                // Pressed together from the start: a body that is moved without load has nothing but round-off to check.
                settings.lambda = 0.005.into();
                all_hold(&columns, &bounds(columns.problem(4).unwrap(), &settings));
            }
        }
    }
}

#[test]
fn roles_do_not_matter() {
    for columns in family() {
        let problem = columns.problem(6).unwrap();
        for imposed in [certified_contact::Imposed::First, certified_contact::Imposed::Second] {
            let mut settings = Settings::default();
            settings.imposed = imposed;
            all_hold(&columns, &bounds(problem.clone(), &settings));
        }
    }
}

#[test]
fn they_hold_on_the_exact_signorini_problem_and_close_in_adaptively() {
    // Its data are interpolated: an error of the order h² beside intervals of the order h.
    let materials = [(1.0, 0.3), (1.0, 0.3)];
    let norm = (2.0 * signorini::ENERGY).sqrt();
    let problem = signorini::problem(materials, 0.0, [16, 8]).unwrap();
    let mut target = AdaptSettings::new(0.02);
    target.max_nodes = 20_000;
    let answer = solve_adaptively(problem, &Settings::default(), &target, &mut Silent).unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    let found = answer.solution.bounds.unwrap();
    holds("energy norm", found.energy_norm, norm);
    // ∫ √x over (0, 1).
    let force = found.contact_force.unwrap();
    holds("contact force", force, 2.0 / 3.0);
    assert!(force[1] - force[0] < 0.1, "{force:?}");
    // The error itself is known: the certificate of the last mesh is above it, and within 10 %.
    let exact = signorini::exact(materials, 0.0);
    let estimate = answer.solution.estimate.as_ref().unwrap();
    let error: f64 = [0, 1]
        .map(|b| {
            let body = &answer.solution.problem.bodies[b];
            energy_error_squared(body, &estimate.pair.bodies[b].displacement, |x| exact[b].stress(x))
        })
        .iter()
        .sum::<f64>()
        .sqrt();
    let effectivity = estimate.unchecked().e_cre / error;
    assert!((1.0..1.1).contains(&effectivity), "{effectivity}");
}

#[test]
fn a_body_that_is_only_moved_is_not_refused() {
    // From λ = 0 the first iteration moves the upper body without strain: nothing but round-off to check, on every mesh.
    let base = Columns { materials: [(2000.0, 0.3), (1000.0, 0.2)], weights: [0.0; 2], push: 0.01, gap: 0.0 };
    let mut settings = Settings::default();
    settings.method = settings.method.with_max_iterations(1);
    settings.criterion = Criterion::Iterations;
    for (materials, push) in [
        (base.materials, 0.01),
        ([(2000.0, 0.3), (1000.0, 0.2)], 0.0137),
        ([(3.7, 0.0), (2.0, 0.45)], 1.0 / 3.0),
    ] {
        for n in [2, 3, 4, 5, 8, 13, 16, 32, 64] {
            for relaxation in [Relaxation::NONE, Relaxation::Steps(2)] {
                settings.relaxation = relaxation;
                let columns = Columns { materials, push, ..base };
                let answer = solve(columns.problem(n).unwrap(), &settings, &mut Silent).unwrap();
                let estimate = answer.estimate.as_ref().unwrap();
                assert!(answer.is_certified(), "{materials:?} {push} {n}: {:?}", estimate.admissibility);
                // The allowance stays round-off beside the energy of the pushed column.
                let allowance = estimate.unchecked().e_cre - estimate.cre.e_cre();
                let norm = columns.exact().energy_norm_squared.sqrt();
                assert!(allowance < 1e-10 * norm, "{n}: {allowance:e} against {norm}");
            }
        }
    }
}

#[test]
fn a_moved_body_with_an_unbalanced_side_is_refused() {
    // The allowance excuses round-off, not a millionth of the force that the push would need.
    let columns =
        Columns { materials: [(2000.0, 0.3), (1000.0, 0.2)], weights: [0.0; 2], push: 0.01, gap: 0.0 };
    let problem = columns.problem(4).unwrap();
    let prepared = tests::prepare(&problem);
    let iterate = tests::run::pair_of(&prepared, vec![0.0; 5]).unwrap();
    let mut pair = tests::certify(&prepared, &iterate).unwrap().pair;
    assert!(cre_estimator::check(&problem, &pair).is_valid());
    let force = columns.exact().contact_force;
    let interface = problem.contacts[0].interface.facets()[0].facets[0].index();
    pair.bodies[0].equilibrated.facet_moments[interface][0][1] += 1e-6 * force;
    assert!(!cre_estimator::check(&problem, &pair).is_valid());
}

//! The whole way by one call: statuses, criteria, roles, and what a user reads off.

use certified_contact::{CertifiedSolution, Criterion, Imposed, Results, Settings, Silent, solve};
use fem_core::condensation::CondensedBody;
use fem_core::geometry::{Vector, norm};
use fem_core::interface::ContactProblem;
use fem_core::norm::energy_norm_squared;
use nndd::{NnddSettings, NnddStatus};
use tests::run::solve_alone;
use tests::shapes::turn;
use tests::{heavy, paper, prepare};

fn coarse() -> ContactProblem {
    paper::problem(paper::COARSE).unwrap()
}

fn with(nndd: NnddSettings, criterion: Criterion) -> Settings {
    let mut settings = Settings::default();
    settings.imposed = Imposed::First;
    settings.method = nndd.into();
    settings.criterion = criterion;
    settings
}

fn paper_settings(theta: f64, max_iterations: usize) -> NnddSettings {
    let mut settings = NnddSettings::paper(theta);
    settings.max_iterations = max_iterations;
    settings
}

fn carried_by(imposed: Imposed, tolerance: f64) -> Settings {
    let mut settings = with(NnddSettings::default(), Criterion::EtaNndd { tolerance });
    settings.imposed = imposed;
    settings
}

fn by_estimator(imposed: Imposed) -> Settings {
    let mut settings = Settings::default();
    settings.imposed = imposed;
    settings
}

fn run(problem: ContactProblem, settings: &Settings) -> CertifiedSolution {
    solve(problem, settings, &mut Silent).unwrap()
}

fn results(answer: &CertifiedSolution) -> &Results {
    answer.results.as_ref().unwrap()
}

#[test]
fn the_defaults_stop_when_the_iteration_is_good_enough_for_the_mesh() {
    for cells in [paper::COARSE, paper::FINE] {
        let answer = run(paper::problem(cells).unwrap(), &Settings::default());
        assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
        assert!(answer.is_certified());
        let row = answer.rows.last().unwrap();
        assert!(row.iteration.eta_nndd <= 0.1 * row.eta_dis.unwrap());
        assert_eq!(answer.rows.len(), answer.nndd.history.len());
        let e_cre = answer.estimate.as_ref().unwrap().unchecked().e_cre;
        assert_eq!(row.e_cre, Some(e_cre));
        let energy: f64 = results(&answer).energy_norm_squared.iter().sum();
        let relative = e_cre / energy.sqrt();
        assert!((answer.relative().unwrap() - relative).abs() < 1e-14);
        assert!((answer.relative_guaranteed().unwrap() - relative / (1.0 - relative)).abs() < 1e-14);
    }
}

#[test]
fn with_an_estimate_in_every_iteration_the_first_good_enough_is_the_last() {
    let mut settings =
        with(NnddSettings::paper(0.4), Criterion::Estimator { ratio: 0.03, force_balance: None });
    settings.estimate_every = 1;
    // The prototype's η_dis below is by EET alone.
    settings.relaxation = cre_estimator::Relaxation::NONE;
    let answer = run(coarse(), &settings);
    assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
    let good: Vec<bool> =
        answer.rows.iter().map(|row| row.iteration.eta_nndd <= 0.03 * row.eta_dis.unwrap()).collect();
    // η_NNDD of the prototype: 0.0199 and 0.0087, against 0.03 · 0.51.
    assert_eq!(good, [false, false, false, false, true]);
}

#[test]
fn each_criterion_stops_where_it_says() {
    let nndd = NnddSettings::paper(0.4);
    // The prototype's table says which iteration is the first to satisfy each.
    for (criterion, expected) in [
        (Criterion::Precision { tolerance: 0.5 }, 4),
        (Criterion::Precision { tolerance: 0.44 }, 5),
        (Criterion::EtaNndd { tolerance: 0.04 }, 3),
        (Criterion::EtaNndd { tolerance: 0.0072 }, 5),
    ] {
        let answer = run(coarse(), &with(nndd.clone(), criterion));
        assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
        assert_eq!(answer.rows.len(), expected, "{criterion:?}");
        assert!(answer.is_certified());
    }
    for max_iterations in [1, 3] {
        let nndd = paper_settings(0.4, max_iterations);
        let answer = run(coarse(), &with(nndd, Criterion::Iterations));
        assert_eq!(answer.nndd.status, NnddStatus::MaxIterations);
        assert_eq!(answer.rows.len(), max_iterations);
        assert!(answer.is_certified());
    }
}

#[test]
fn estimates_come_as_often_as_asked() {
    let mut settings = with(NnddSettings::paper(0.4), Criterion::Iterations);
    settings.method = settings.method.with_max_iterations(7);
    settings.estimate_every = 3;
    let answer = run(coarse(), &settings);
    let estimated: Vec<bool> = answer.rows.iter().map(|row| row.e_cre.is_some()).collect();
    assert_eq!(estimated, [false, false, true, false, false, true, true]);
}

/// The largest eigenvalue of `½(S₁⁻¹ + S₂⁻¹)(S₁ + S₂)` by the power method.
fn largest_eigenvalue(prepared: &fem_core::prepared::PreparedProblem) -> f64 {
    let bodies: Vec<&CondensedBody> = prepared.bodies().iter().filter_map(|body| body.whole()).collect();
    let n = bodies[0].interface().len();
    let mut v: Vec<f64> = (0..n).map(|i| (1.0 + i as f64).sqrt().sin()).collect();
    let mut value = 0.0;
    for _ in 0..3000 {
        let mut sum = vec![0.0; n];
        let mut next = vec![0.0; n];
        let mut work = vec![0.0; n];
        for body in &bodies {
            body.interface().apply_schur(&v, &mut work);
            sum.iter_mut().zip(&work).for_each(|(s, w)| *s += w);
        }
        for body in &bodies {
            body.interface().trace_from_force(&sum, &mut work);
            next.iter_mut().zip(&work).for_each(|(x, w)| *x += 0.5 * w);
        }
        value = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        v = next.iter().map(|x| x / value).collect();
    }
    value
}

#[test]
fn too_large_a_theta_is_noticed_early_and_the_limit_is_named() {
    let expected = 2.0 / largest_eigenvalue(&prepare(&coarse()));
    let answer = run(coarse(), &with(NnddSettings::paper(5.0), Criterion::EtaNndd { tolerance: 1e-8 }));
    let NnddStatus::Diverged { best, theta_limit: Some(limit) } = answer.nndd.status else {
        panic!("{:?}", answer.nndd.status)
    };
    assert!(answer.rows.len() <= 8, "{}", answer.rows.len());
    assert!(best > 0.0 && best <= answer.rows[0].iteration.eta_nndd);
    assert!((limit / expected - 1.0).abs() < 5e-3, "{limit} against {expected}");
    // The last iterate is still certified.
    assert!(answer.is_certified());
}

#[test]
fn the_range_of_theta_is_what_the_limit_says() {
    // Glued by a push without traction, so that all pairs stay in contact and the spectrum rules.
    let pressed = || paper::problem_with(paper::COARSE, paper::YOUNG, 0.0, paper::PUSH, 0.0).unwrap();
    let limit = 2.0 / largest_eigenvalue(&prepare(&pressed()));
    let status = |factor: f64| {
        let nndd = paper_settings(factor * limit, 400);
        run(pressed(), &with(nndd, Criterion::EtaNndd { tolerance: 1e-6 })).nndd.status
    };
    let [below, above] = [status(0.95), status(1.1)];
    assert_eq!(below, NnddStatus::StoppedByCriterion);
    // Contact that opens and closes keeps the iterates bounded: beyond the limit they may only wander.
    let failed =
        matches!(above, NnddStatus::Diverged { .. } | NnddStatus::Stalled { at_round_off: false, .. });
    assert!(failed, "{above:?}");
}

#[test]
fn a_small_theta_converges_slowly_but_steadily() {
    let iterations = |theta| {
        let nndd = paper_settings(theta, 60);
        let answer = run(coarse(), &with(nndd, Criterion::EtaNndd { tolerance: 1e-3 }));
        let etas: Vec<f64> = answer.rows.iter().map(|row| row.iteration.eta_nndd).collect();
        assert!(etas.windows(2).all(|e| e[1] < e[0]), "{theta}: {etas:?}");
        (answer.nndd.status, etas.len())
    };
    assert_eq!(iterations(0.02), (NnddStatus::MaxIterations, 60));
    let (slow, fast) = (iterations(0.1), iterations(0.4));
    assert_eq!((slow.0, fast.0), (NnddStatus::StoppedByCriterion, NnddStatus::StoppedByCriterion));
    assert!(slow.1 > 2 * fast.1, "{slow:?} {fast:?}");
}

#[test]
fn a_gap_that_does_not_close_leaves_the_bodies_alone() {
    let problem =
        paper::problem_with(paper::COARSE, paper::YOUNG, paper::TRACTION, paper::PUSH, 0.05).unwrap();
    let alone = energy_norm_squared(&problem.bodies[0], &solve_alone(&problem.bodies[0]));
    for imposed in [Imposed::First, Imposed::Second] {
        for settings in [carried_by(imposed, 1e-11), by_estimator(imposed)] {
            let answer = run(problem.clone(), &settings);
            assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
            assert!(answer.is_certified());
            let results = results(&answer);
            assert_eq!([results.contact_force, results.max_pressure, results.max_facet_pressure], [0.0; 3]);
            assert!(results.contact_intervals.is_empty());
            assert!(results.min_opening > 0.0);
            if settings.criterion != Criterion::default() {
                let (first, second) = (results.energy_norm_squared[0], results.energy_norm_squared[1]);
                assert!((first / alone - 1.0).abs() < 1e-9, "{imposed:?}: {first} against {alone}");
                assert!(second < 1e-18 * alone, "{imposed:?}: {second}");
            }
        }
    }
}

#[test]
fn no_load_gives_nothing_and_certifies_it() {
    for imposed in [Imposed::First, Imposed::Second] {
        let problem = paper::problem_with(paper::COARSE, paper::YOUNG, 0.0, 0.0, 0.0).unwrap();
        let answer = run(problem, &by_estimator(imposed));
        assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
        assert_eq!(answer.rows.len(), 1);
        assert!(answer.is_certified());
        let estimate = answer.estimate.as_ref().unwrap();
        assert_eq!((estimate.unchecked().e_cre, estimate.unchecked().eta_dis), (0.0, 0.0));
        assert_eq!(answer.relative(), None);
        assert_eq!(results(&answer).energy_norm_squared, [0.0, 0.0]);
        assert_eq!(results(&answer).max_displacement, 0.0);
    }
}

#[test]
fn results_of_the_papers_problem() {
    let answer = run(coarse(), &with(NnddSettings::default(), Criterion::EtaNndd { tolerance: 1e-11 }));
    let r = results(&answer);
    assert!((r.contact_force - paper::FORCE).abs() < 1e-8 * paper::FORCE);
    for b in 0..2 {
        assert!((r.energy_norm_squared[b] - paper::ENERGIES[b]).abs() < 1e-8 * paper::ENERGIES[b]);
    }
    let [[start, end]] = r.contact_intervals[..] else { panic!("{:?}", r.contact_intervals) };
    assert_eq!(start, 0.0);
    assert!((end - paper::CONTACT_END).abs() < 1e-12);
    assert!(r.min_opening == 0.0);
    // Each body is in balance with its loads, supports and the contact force.
    assert!(
        r.balance.iter().all(|b| norm(b.force).max(b.moment.abs()) < 1e-11 * r.contact_force),
        "{:?}",
        r.balance
    );
    let named = |on: &str| r.reactions.iter().find(|x| x.on == on).unwrap();
    let [left, top, bottom] = ["left", "top", "bottom"].map(named);
    assert_eq!([left.body, top.body, bottom.body], [0, 0, 1]);
    let close = |a: Vector, x: f64, y: f64| norm(a - Vector::new(x, y)) < 1e-8 * r.contact_force;
    assert!(close(bottom.force, 0.0, r.contact_force), "{:?}", bottom.force);
    assert!(close(top.force, 0.0, -r.contact_force - paper::TRACTION), "{:?}", top.force);
    assert!(close(left.force, 0.0, 0.0), "{:?}", left.force);
    // The largest mean pressure of an edge lies between the mean pressure and the largest nodal one.
    let pressures = &answer.estimate.as_ref().unwrap().pair.contacts[0].pressure;
    let largest = pressures.iter().copied().fold(0.0, f64::max);
    assert_eq!(r.max_pressure, largest);
    assert!(r.max_facet_pressure < largest && r.max_facet_pressure > r.contact_force / paper::CONTACT_END);
    assert!(r.max_displacement >= 0.02);
}

#[test]
fn reactions_carry_the_loads_at_any_angle() {
    for angle in [0.0, 0.3, 2.0] {
        let answer = run(heavy::problem(angle, 8).unwrap(), &Settings::default());
        assert!(answer.is_certified());
        let r = results(&answer);
        let scale: f64 = r.reactions.iter().map(|x| norm(x.force)).sum();
        assert!(
            r.balance.iter().all(|b| norm(b.force).max(b.moment.abs()) < 1e-11 * scale),
            "{angle}: {:?}",
            r.balance
        );
        // No force passes along the interface.
        let total = |body: usize| {
            let sum = r.reactions.iter().filter(|x| x.body == body).map(|x| x.force).sum::<Vector>();
            turn(-angle, sum)
        };
        let [b1, b2] = heavy::BODY_FORCES;
        let area = [2.0 * 0.8, 2.0];
        assert!((total(0)[0] + b1[0] * area[0]).abs() < 1e-10 * scale, "{angle}");
        assert!((total(1)[0] + b2[0] * area[1] + heavy::TRACTION[0]).abs() < 1e-10 * scale, "{angle}");
        // Across it (the pressure acts on a length of 1.5): what leaves one body enters the other, once the iteration has converged.
        let mut settings = Settings::default();
        settings.criterion = Criterion::EtaNndd { tolerance: 1e-11 };
        let converged = run(heavy::problem(angle, 8).unwrap(), &settings);
        let r = results(&converged);
        let sum = r.reactions.iter().map(|x| x.force).sum::<Vector>();
        let down = b1[1] * area[0] + b2[1] * area[1] - 1.5 * heavy::PRESSURE + heavy::TRACTION[1];
        assert!((turn(-angle, sum)[1] + down).abs() < 1e-9 * scale, "{angle}: {sum:?} {down}");
    }
}

#[test]
fn results_come_in_the_order_handed_over_whoever_carries_lambda() {
    for problem in [coarse(), heavy::problem(0.3, 8).unwrap()] {
        let runs = [Imposed::First, Imposed::Second, Imposed::Auto]
            .map(|imposed| run(problem.clone(), &carried_by(imposed, 1e-11)));
        assert_eq!([0, 1].map(|k| runs[k].roles()[0].imposed()), [0, 1]);
        let expected = results(&runs[0]);
        for answer in &runs {
            let r = results(answer);
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-8 * b.abs();
            for b in 0..2 {
                assert!(close(r.energy_norm_squared[b], expected.energy_norm_squared[b]));
                assert_eq!(answer.unknowns[b], runs[0].unknowns[b]);
                let body = &answer.problem.bodies[b];
                assert_eq!(body.mesh().points(), problem.bodies[b].mesh().points());
            }
            assert!(close(r.contact_force, expected.contact_force));
            assert!(close(r.max_pressure, expected.max_pressure));
            assert!(close(r.max_facet_pressure, expected.max_facet_pressure));
            assert!(close(r.max_von_mises.unwrap(), expected.max_von_mises.unwrap()));
            assert!(close(r.max_displacement, expected.max_displacement));
            assert_eq!(r.contact_intervals.len(), expected.contact_intervals.len());
            assert_eq!(r.reactions.len(), expected.reactions.len());
            for (a, b) in r.reactions.iter().zip(&expected.reactions) {
                assert_eq!((a.body, &a.on), (b.body, &b.on));
                assert!(norm(a.force - b.force) < 1e-7 * expected.contact_force, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn the_stiffer_body_carries_lambda_by_default() {
    for (young, imposed) in [([2000.0, 1000.0], 0), ([100.0, 1000.0], 1)] {
        let problem = paper::problem_with(paper::COARSE, young, 1.0, paper::PUSH, 0.0).unwrap();
        let answer = run(problem, &Settings::default());
        assert_eq!(answer.roles()[0].imposed(), imposed, "{:?}", answer.role_reason);
    }
}

/// A body moved rigidly (gap 0.05, pushed 0.02, no load) is free of stress: its residuals are round-off over
/// round-off, and must not cost it the certificate.
#[test]
fn a_stress_free_rigid_motion_is_certified() {
    let problem = paper::problem_with(paper::COARSE, paper::YOUNG, 0.0, paper::PUSH, 0.05).unwrap();
    for imposed in [Imposed::First, Imposed::Second] {
        let mut settings = Settings::default();
        settings.imposed = imposed;
        settings.criterion = Criterion::EtaNndd { tolerance: 1e-10 };
        let answer = solve(problem.clone(), &settings, &mut Silent).unwrap();
        let estimate = answer.estimate.as_ref().unwrap();
        assert!(
            answer.is_certified(),
            "{imposed:?} {:?} {:e}",
            estimate.admissibility,
            estimate.unchecked().e_cre
        );
        assert!(estimate.unchecked().e_cre < 1e-9);
    }
}

/// A θ 10 % above the limit: opening and closing of the contact keeps η bounded, so the iteration stalls
/// rather than diverges; the usable range is still named.
#[test]
fn a_theta_just_above_the_limit_stalls_and_the_range_is_named() {
    let problem = paper::problem_with(paper::COARSE, paper::YOUNG, 0.0, paper::PUSH, 0.0).unwrap();
    let mut settings = Settings::default();
    settings.imposed = Imposed::First;
    settings.method = NnddSettings::paper(1.1 * 0.7708262296050389).into();
    settings.method = settings.method.with_max_iterations(400);
    settings.criterion = Criterion::EtaNndd { tolerance: 1e-6 };
    let answer = solve(problem, &settings, &mut Silent).unwrap();
    assert!(matches!(answer.nndd.status, NnddStatus::Stalled { at_round_off: false, .. }));
    let limit = answer.nndd.spectrum.unwrap().theta_limit();
    assert!((limit - 0.7708262296050389).abs() < 1e-6, "{limit}");
}

//! When the iteration stops by default, and what happens if it does not converge.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, CertifiedSolution, Criterion, Settings, Silent, solve, solve_adaptively,
};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use nndd::{NnddSettings, NnddStatus};
use tests::blocks::Blocks;
use tests::receding;
use tests::run::newton;
use tests::{paper, prepare};

fn run(problem: ContactProblem, settings: &Settings) -> CertifiedSolution {
    solve(problem, settings, &mut Silent).unwrap()
}

/// The contact force of the discrete solution, by interface Newton.
fn discrete_force(problem: &ContactProblem) -> f64 {
    newton(&prepare(problem)).unwrap().contact_force()
}

/// Two squares that lose contact at both ends, with different materials and pushed sideways.
fn squares() -> ContactProblem {
    let material = |e, nu| LinearElastic::isotropic(e, nu, Hypothesis::PlaneStrain).unwrap();
    let size = [0.01; 2];
    let held = BoundaryConditions::new().displace("top", Some(0.0.into()), Some((-5e-7).into()));
    let upper = Body::new(block([0.0, 0.01], size, [60, 60]).unwrap(), material(20e9, 0.4), &held).unwrap();
    let pushed = BoundaryConditions::new()
        .fix("bottom")
        .traction("left", [1e5.into(), (-1e6).into()])
        .traction("right", [(-1e5).into(), (-1e6).into()]);
    let lower = Body::new(block([0.0, 0.0], size, [60, 60]).unwrap(), material(15e9, 0.2), &pushed).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between([upper, lower], interface)
}

#[test]
fn the_default_stop_leaves_the_contact_force_within_a_thousandth_of_the_discrete_one() {
    let mut problems = vec![squares(), paper::problem(paper::COARSE).unwrap()];
    for contrast in [1e-3, 0.05, 1.0, 20.0, 1e3] {
        problems.push(Blocks::contrast(contrast).problem().unwrap());
        problems.push(Blocks::half_open(contrast).problem().unwrap());
    }
    for problem in problems {
        let expected = discrete_force(&problem);
        let answer = run(problem, &Settings::default());
        assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
        for force in answer.rows.last().unwrap().contact_forces {
            assert!((force / expected - 1.0).abs() <= 1e-3, "{force} against {expected}");
        }
    }
}

#[test]
fn a_given_ratio_alone_does_not_ask_for_equal_forces() {
    let mut settings = Settings::default();
    settings.criterion = Criterion::Estimator { ratio: 0.1, force_balance: None };
    let [first, second] = run(squares(), &settings).rows.last().unwrap().contact_forces;
    assert!((first - second).abs() > 1e-3 * first.max(second), "{first} {second}");
    let [first, second] = run(squares(), &Settings::default()).rows.last().unwrap().contact_forces;
    assert!((first - second).abs() <= 1e-3 * first.max(second), "{first} {second}");
}

#[test]
fn contact_forces_are_in_the_order_handed_over() {
    use certified_contact::Imposed;
    // From λ = 0 the body that carries λ is pressed, the other one lies still.
    let first_row = |imposed| {
        let mut settings = Settings::default();
        settings.imposed = imposed;
        run(paper::problem(paper::COARSE).unwrap(), &settings).rows[0].contact_forces
    };
    let [upper, lower] = first_row(Imposed::First);
    assert!(upper > 0.0 && lower == 0.0, "{upper} {lower}");
    let [upper, lower] = first_row(Imposed::Second);
    assert!(upper > 0.0 && lower == 0.0, "{upper} {lower}");
}

#[test]
fn receding_contact_and_unlike_bodies_converge_by_default() {
    let receding = [10.0, 30.0, 100.0].map(|ratio| receding::problem(ratio, 6).unwrap());
    let unlike = [1e-3, 1e3].map(|ratio| Blocks::half_open(ratio).cells(40).problem().unwrap());
    for problem in receding.into_iter().chain(unlike) {
        let expected = discrete_force(&problem);
        let answer = run(problem, &Settings::default());
        assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
        assert!(answer.is_certified());
        let force = answer.results.as_ref().unwrap().contact_force;
        assert!((force / expected - 1.0).abs() <= 1e-3, "{force} against {expected}");
    }
}

#[test]
fn the_iteration_ends_after_its_iterations_whatever_settings_it_has() {
    let problem = || Blocks::half_open(1.0).problem().unwrap();
    for theta in [None, Some(0.5)] {
        let mut nndd = NnddSettings::default();
        (nndd.theta, nndd.max_iterations) = (theta, 2);
        let answer = run(problem(), &Settings::default().with_method(nndd));
        assert_eq!((answer.nndd.status, answer.rows.len()), (NnddStatus::MaxIterations, 2));
        assert!(answer.is_certified());
    }
}

#[test]
fn a_criterion_below_round_off_is_not_met_by_newton_either() {
    for by_newton in [true, false] {
        let iteration = Settings::default().with_method(NnddSettings::default());
        let mut settings = if by_newton { Settings::default() } else { iteration };
        settings.criterion = Criterion::EtaNndd { tolerance: 1e-30 };
        let answer = run(paper::problem(paper::COARSE).unwrap(), &settings);
        assert!(
            matches!(answer.nndd.status, NnddStatus::Stalled { at_round_off: true, .. }),
            "{:?}",
            answer.nndd.status
        );
        assert!(answer.is_certified());
    }
}

#[test]
fn bodies_without_strain_energy_get_no_percentage_and_meet_any_target() {
    // The upper block is lifted off: both bodies move without strain, or not at all.
    let lifted = || paper::problem_with([8, 4], paper::YOUNG, 0.0, 0.5, 0.0).unwrap();
    let answer = run(lifted(), &Settings::default());
    assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
    assert!(answer.is_certified() && answer.holds_no_energy());
    assert_eq!((answer.relative(), answer.relative_guaranteed()), (None, None));
    let answer =
        solve_adaptively(lifted(), &Settings::default(), &AdaptSettings::new(0.02), &mut Silent).unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert_eq!(answer.history.len(), 1);
    // A body that is strained does have one.
    assert!(!run(paper::problem(paper::COARSE).unwrap(), &Settings::default()).holds_no_energy());
}

//! When the iteration stops by default, and what happens if it does not converge.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, CertifiedSolution, Checkpoint, Criterion, Observer, Settings, Silent,
    resume_adaptively, solve, solve_adaptively,
};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactInterface, ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use nndd::{Method, NnddSettings, NnddStatus};
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

/// Settings with which the iteration does not converge: few iterations from λ = 0.
fn hurried(iterations: usize) -> Settings {
    let mut settings = Settings::default().with_method(NnddSettings::default());
    settings.method = settings.method.with_max_iterations(iterations);
    settings
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
        ContactInterface::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
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
        assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion, "{:?}", answer.nndd.switch);
        assert!(answer.is_certified());
        let force = answer.results.as_ref().unwrap().contact_force;
        assert!((force / expected - 1.0).abs() <= 1e-3, "{force} against {expected}");
    }
}

#[test]
fn newton_takes_over_where_the_iteration_ends_early_and_leaves_no_iteration_error() {
    let problem = || Blocks::half_open(1.0).problem().unwrap();
    let expected = newton(&prepare(&problem())).unwrap();
    for iterations in [0, 1, 3] {
        let answer = run(problem(), &hurried(iterations));
        assert_eq!(answer.nndd.status, NnddStatus::StoppedByCriterion);
        let switch = answer.nndd.switch.unwrap();
        assert_eq!(switch.after, NnddStatus::MaxIterations);
        assert_eq!(answer.rows.len(), iterations.max(1) + 1);
        // The iterations before the switch stay in the history.
        assert!(answer.rows[0].iteration.theta > 0.0);
        let last = answer.rows.last().unwrap();
        assert_eq!((last.iteration.iteration, last.iteration.theta), (answer.rows.len(), 0.0));
        assert!(last.iteration.eta_nndd < 1e-10 * answer.rows[0].iteration.eta_nndd);
        let force = answer.last().contact_force();
        assert!((force / expected.contact_force() - 1.0).abs() < 1e-10);
        assert!(answer.is_certified());
    }
}

#[test]
fn an_explicit_choice_of_the_iteration_never_switches() {
    let problem = || Blocks::half_open(1.0).problem().unwrap();
    let status = |change: &dyn Fn(&mut Settings)| {
        let mut settings = hurried(2);
        change(&mut settings);
        let answer = run(problem(), &settings);
        assert!(answer.nndd.switch.is_none() && answer.rows.len() == 2);
        answer.nndd.status
    };
    let changed = |change: &dyn Fn(&mut NnddSettings)| {
        let mut nndd = NnddSettings::default();
        nndd.max_iterations = 2;
        change(&mut nndd);
        Method::from(nndd)
    };
    assert_eq!(status(&|s| s.method = changed(&|nndd| nndd.newton = None)), NnddStatus::MaxIterations);
    assert_eq!(status(&|s| s.method = changed(&|nndd| nndd.theta = Some(0.5))), NnddStatus::MaxIterations);
    assert_eq!(status(&|s| s.criterion = Criterion::Iterations), NnddStatus::MaxIterations);
    // The same settings without such a choice do.
    assert!(run(problem(), &hurried(2)).nndd.switch.is_some());
}

#[test]
fn a_criterion_below_round_off_is_not_met_by_newton_either() {
    for by_newton in [true, false] {
        let iteration = Settings::default().with_method(NnddSettings::default());
        let mut settings = if by_newton { Settings::default() } else { iteration };
        settings.criterion = Criterion::EtaNndd { tolerance: 1e-30 };
        let answer = run(paper::problem(paper::COARSE).unwrap(), &settings);
        assert_eq!(answer.nndd.switch.is_none(), by_newton);
        assert!(
            matches!(answer.nndd.status, NnddStatus::Stalled { at_round_off: true, .. }),
            "{:?}",
            answer.nndd.status
        );
        assert!(answer.is_certified());
    }
}

/// Keeps the checkpoints of a run.
#[derive(Default)]
struct Record(Vec<Checkpoint>);

impl Observer for Record {
    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.0.push(checkpoint.clone());
    }
}

#[test]
fn a_resumed_run_whose_meshes_switched_to_newton_is_the_same_bit_for_bit() {
    let problem = Blocks::half_open(1.0).problem().unwrap();
    let (settings, adapt) = (hurried(2), AdaptSettings::new(0.06));
    let mut record = Record::default();
    let whole = solve_adaptively(problem.clone(), &settings, &adapt, &mut record).unwrap();
    assert!(matches!(whole.end, AdaptiveEnd::TargetMet), "{:?}", whole.end);
    assert!(whole.solution.nndd.switch.is_some() && record.0.len() >= 2);
    for checkpoint in record.0 {
        let found = resume_adaptively(problem.clone(), checkpoint, &settings, &adapt, &mut Record::default())
            .unwrap();
        assert_eq!(found.history, whole.history);
        assert_eq!(found.solution.rows, whole.solution.rows);
        let bits = |s: &CertifiedSolution| {
            let e = s.estimate.as_ref().unwrap();
            let fields = e.pair.bodies.iter().flat_map(|b| b.displacement.iter().flatten());
            fields
                .chain(&s.last().lambda)
                .chain([&e.unchecked().e_cre, &e.unchecked().eta_dis])
                .map(|x| x.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(&found.solution), bits(&whole.solution));
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

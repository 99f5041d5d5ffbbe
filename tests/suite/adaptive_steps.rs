//! Load steps on meshes that are refined: one sequence of meshes serves all steps.

use certified_contact::nndd::{CoulombSettings, CoulombStatus};
use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSteps, CertifiedSolution, Checkpoint, LoadSteps, Observer, Phase,
    Settings, Silent, SolveError, Step, StepFactors, solve_adaptively, solve_coulomb_steps_adaptively,
    solve_steps_adaptively,
};
use cre_estimator::Relaxation;
use fem_core::body::{Body, ConditionList, ConditionPlace};
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::{ContactProblem, Friction, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use tests::friction::{blocks, pushed_over_plane};

/// Makes two blocks, the upper one under a pressure that is called up in two parts: of the left half of its top, and of the right half.
fn two_parts() -> ContactProblem {
    let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    // Linear on the edges of every mesh.
    let pressed = BoundaryConditions::new()
        .pressure("top", ScalarData::function(|x| 60.0 * (1.0 - x[0]).max(0.0)))
        .pressure("top", ScalarData::function(|x| 60.0 * (x[0] - 1.0).max(0.0)))
        .displace("left", Some(0.0.into()), None);
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [4, 2]).unwrap(), steel.clone(), &pressed).unwrap();
    let held = BoundaryConditions::new().fix("bottom");
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap(), steel, &held).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between([upper, lower], interface)
}

/// Factors of the two loads of [`two_parts`].
fn parts(factors: [f64; 2]) -> impl Fn(usize, ConditionPlace) -> f64 {
    move |body, place| match (body, place.list) {
        (0, ConditionList::Traction) => factors[place.index],
        _ => 1.0,
    }
}

fn run(
    problem: ContactProblem,
    factors: &[&dyn Fn(usize, ConditionPlace) -> f64],
    checkpoint: Option<Checkpoint>,
    target: f64,
    observer: &mut dyn Observer,
) -> Result<AdaptiveSteps, SolveError> {
    let gaps = vec![1.0; problem.contacts.len()];
    let factors: Vec<_> =
        factors.iter().map(|conditions| StepFactors { conditions, gaps: gaps.clone() }).collect();
    let adapt = AdaptSettings::new(target);
    solve_steps_adaptively(problem, &factors, checkpoint, &Settings::default(), &adapt, observer)
}

#[test]
fn the_meshes_serve_every_step() {
    let (left, right) = (parts([1.0, 0.0]), parts([0.0, 1.0]));
    let both = run(two_parts(), &[&left, &right], None, 0.08, &mut Silent).unwrap();
    assert!(matches!(both.end, AdaptiveEnd::TargetMet), "{:?}", both.end);
    assert!(both.solution.is_complete() && both.solution.of == 2);
    let relative: Vec<f64> = both.solution.steps.iter().map(|step| step.relative().unwrap()).collect();
    assert!(relative.iter().all(|relative| *relative <= 0.08), "{relative:?}");
    // The row of a mesh is that of its worst step.
    let last = both.history.last().unwrap();
    let largest = relative.iter().copied().fold(0.0, f64::max);
    assert_eq!(last.relative, Some(largest));
    assert_eq!(relative[last.load_step.unwrap() - 1], largest);
    // The mesh of one load alone does not certify the other.
    for (alone, other) in [(&left, &right), (&right, &left)] {
        let of_one = run(two_parts(), &[alone], None, 0.08, &mut Silent).unwrap();
        let mut steps = LoadSteps::new(of_one.solution.problem);
        let missed = steps.solve(other, &Settings::default(), &mut Silent).unwrap().relative().unwrap();
        assert!(missed > 0.085, "{missed}");
        assert!(of_one.history.last().unwrap().nodes < last.nodes);
    }
    // Each certificate is that of the step alone on this mesh.
    for (factor, found) in [&left, &right].into_iter().zip(&both.solution.steps) {
        let mut steps = LoadSteps::new(both.solution.problem.clone());
        let alone = steps.solve(factor, &Settings::default(), &mut Silent).unwrap();
        let difference = alone.relative().unwrap() - found.relative().unwrap();
        assert!(difference.abs() < 1e-9, "{difference:e}");
    }
}

#[test]
fn a_step_without_any_load_does_not_keep_a_run_from_its_target() {
    let (left, none) = (parts([1.0, 0.0]), parts([0.0, 0.0]));
    let found = run(two_parts(), &[&left, &none], None, 0.1, &mut Silent).unwrap();
    assert!(matches!(found.end, AdaptiveEnd::TargetMet), "{:?}", found.end);
    let [first, second] = &found.solution.steps[..] else { panic!() };
    assert!(first.relative().is_some() && second.relative().is_none() && second.holds_no_energy());
    assert_eq!(found.history.last().unwrap().load_step, Some(1));
}

#[test]
fn one_whole_step_is_an_ordinary_run() {
    let plain =
        solve_adaptively(two_parts(), &Settings::default(), &AdaptSettings::new(0.06), &mut Silent).unwrap();
    let stepped = run(two_parts(), &[&|_, _| 1.0], None, 0.06, &mut Silent).unwrap();
    let numbers = |history: &[Step]| -> Vec<_> {
        history.iter().map(|step| (step.nodes, step.e_cre, step.relative, step.peak_stress)).collect()
    };
    assert_eq!(numbers(&plain.history), numbers(&stepped.history));
    assert!(plain.history.len() > 2);
}

/// Keeps the checkpoints, and may end the run after some phases of estimating.
#[derive(Default)]
struct Record {
    checkpoints: Vec<Checkpoint>,
    estimates: usize,
    patience: Option<usize>,
}

impl Observer for Record {
    fn phase(&mut self, phase: Phase) {
        self.estimates += usize::from(phase == Phase::Assembly);
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.checkpoints.push(checkpoint.clone());
    }

    fn should_stop(&mut self) -> bool {
        self.patience.is_some_and(|patience| self.estimates >= patience)
    }
}

/// Factors of [`blocks`]: of what moves the top, and of the traction at its side.
fn loaded(top: f64, traction: f64) -> impl Fn(usize, ConditionPlace) -> f64 {
    move |body, place| match (body, place.list) {
        (0, ConditionList::Displacement) => top,
        (0, ConditionList::Traction) => traction,
        _ => 1.0,
    }
}

#[test]
fn friction_follows_its_path_on_every_mesh_and_a_run_is_resumed() {
    let (press, push, back) = (loaded(1.0, 0.0), loaded(1.0, 1.0), loaded(0.8, -0.5));
    let factors: [&dyn Fn(usize, ConditionPlace) -> f64; 3] = [&press, &push, &back];
    let problem = || blocks([8, 4], Friction::tresca(4.0)).unwrap();
    let mut record = Record::default();
    let whole = run(problem(), &factors, None, 0.09, &mut record).unwrap();
    assert!(matches!(whole.end, AdaptiveEnd::TargetMet), "{:?}", whole.end);
    assert!(whole.history.len() > 1);
    // The same path on the last mesh.
    let mut steps = LoadSteps::new(whole.solution.problem.clone());
    for (factor, found) in factors.iter().zip(&whole.solution.steps) {
        let again = steps.solve(factor, &Settings::default(), &mut Silent).unwrap();
        let slips = again.last().tangential.slip.iter().zip(&found.last().tangential.slip);
        assert!(slips.into_iter().all(|(a, b)| (a - b).abs() < 1e-10));
        assert!((again.relative().unwrap() - found.relative().unwrap()).abs() < 1e-7);
    }
    // What was slipped before counts: the last step alone is another problem.
    let mut alone = LoadSteps::new(whole.solution.problem.clone());
    let alone = alone.solve(&back, &Settings::default(), &mut Silent).unwrap();
    let last = whole.solution.steps.last().unwrap();
    let slips = alone.last().tangential.slip.iter().zip(&last.last().tangential.slip);
    assert!(slips.into_iter().any(|(a, b)| (a - b).abs() > 1e-6));
    // From every checkpoint the same run.
    for checkpoint in record.checkpoints {
        let resumed = run(problem(), &factors, Some(checkpoint), 0.09, &mut Silent).unwrap();
        assert_eq!(resumed.history, whole.history);
        let relative = |of: &AdaptiveSteps| {
            of.solution.steps.iter().map(CertifiedSolution::relative).collect::<Vec<_>>()
        };
        assert_eq!(relative(&resumed), relative(&whole));
    }
}

#[test]
fn a_run_that_is_ended_between_two_steps_keeps_the_mesh_before() {
    let (press, push) = (loaded(1.0, 0.0), loaded(1.0, 1.0));
    let factors: [&dyn Fn(usize, ConditionPlace) -> f64; 2] = [&press, &push];
    let problem = || blocks([8, 4], Friction::tresca(4.0)).unwrap();
    // In the first step of the first mesh: that step is the answer.
    let mut record = Record { patience: Some(1), ..Record::default() };
    let first = run(problem(), &factors, None, 0.02, &mut record).unwrap();
    assert!(matches!(first.end, AdaptiveEnd::Interrupted), "{:?}", first.end);
    assert!(!first.solution.is_complete() && first.solution.steps.len() == 1);
    assert!(!first.history[0].certified && first.history[0].relative.is_none());
    // On a later mesh: all steps of the mesh before.
    let mut ended = 0;
    for patience in 2..8 {
        let mut record = Record { patience: Some(patience), ..Record::default() };
        let found = run(problem(), &factors, None, 0.02, &mut record).unwrap();
        if matches!(found.end, AdaptiveEnd::Interrupted)
            && found.history.last().is_some_and(|step| !step.certified)
        {
            let complete = found.history.len() > 1;
            assert_eq!(found.solution.is_complete(), complete, "{patience}");
            ended += usize::from(complete);
        }
    }
    assert!(ended > 0);
}

#[test]
fn a_step_that_cannot_be_solved_is_named() {
    let wrong: [&dyn Fn(usize, ConditionPlace) -> f64; 2] = [&|_, _| 1.0, &|_, _| f64::NAN];
    let failed = run(two_parts(), &wrong, None, 0.06, &mut Silent).unwrap_err();
    assert!(matches!(failed, SolveError::LoadStep { step: 2, .. }), "{failed}");
    assert!(failed.to_string().starts_with("load step 2: "), "{failed}");
}

#[test]
fn with_coulomb_friction_every_step_has_its_residual() {
    let pushed = |amount: f64| {
        move |body: usize, place: ConditionPlace| match (body, place.list, place.index) {
            (0, ConditionList::Traction, 0) => amount,
            _ => 1.0,
        }
    };
    let problem = pushed_over_plane(8, Friction::Coulomb { mu: 1.0 }).unwrap();
    let (half, whole) = (pushed(0.5), pushed(1.0));
    let of = |conditions| StepFactors { conditions, gaps: vec![1.0] };
    let factors = [of(&half as &dyn Fn(usize, ConditionPlace) -> f64), of(&whole)];
    let method = (CoulombSettings::default(), Relaxation::Steps(2));
    let adapt = AdaptSettings::new(0.04);
    let found =
        solve_coulomb_steps_adaptively(problem, &factors, None, &method, &adapt, &mut Silent).unwrap();
    assert!(matches!(found.end, AdaptiveEnd::TargetMet), "{:?}", found.end);
    assert!(found.history.len() > 1);
    for step in &found.solution.steps {
        assert_eq!(step.solution.status, CoulombStatus::Converged);
        assert!(step.relative_residual().unwrap() <= 0.04);
    }
}

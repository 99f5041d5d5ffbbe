//! A resumed adaptive run equals an uninterrupted one bit for bit: from every checkpoint, however it ended.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, Checkpoint, Criterion, Observer, Settings, SolveError,
    resume_adaptively, solve_adaptively,
};
use fem_core::body::CurveKind;
use fem_core::interface::{ContactProblem, Friction};
use nndd::NnddSettings;
use tests::blocks::Blocks;
use tests::{friction, heavy, paper, pin};

/// Keeps the checkpoints of a run, and may end it.
#[derive(Default)]
struct Record {
    checkpoints: Vec<Checkpoint>,
    /// Memory for this many nodes.
    room: Option<usize>,
}

impl Observer for Record {
    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        assert_eq!(checkpoint.meshes.len(), checkpoint.history.len());
        self.checkpoints.push(checkpoint.clone());
    }

    fn fits_in_memory(&mut self, problem: &ContactProblem) -> bool {
        self.room
            .is_none_or(|room| problem.bodies.iter().map(|b| b.mesh().points().len()).sum::<usize>() <= room)
    }
}

fn run(problem: &ContactProblem, target: f64, record: &mut Record) -> AdaptiveSolution {
    solve_adaptively(problem.clone(), &Settings::default(), &AdaptSettings::new(target), record).unwrap()
}

fn resume(
    problem: &ContactProblem,
    from: &Checkpoint,
    target: f64,
    record: &mut Record,
) -> Result<AdaptiveSolution, SolveError> {
    let adapt = AdaptSettings::new(target);
    resume_adaptively(problem.clone(), from.clone(), &Settings::default(), &adapt, record)
}

/// Everything of a solution, to the last bit.
fn bits(a: &AdaptiveSolution) -> Vec<u64> {
    let estimate = a.solution.estimate.as_ref().unwrap();
    let fields = estimate.pair.bodies.iter().flat_map(|b| b.displacement.iter().flatten());
    let meshes = a.solution.problem.bodies.iter().flat_map(|b| b.mesh().points().iter().flatten());
    fields
        .chain(meshes)
        .chain(&a.solution.last().lambda)
        .chain(&a.solution.last().tangential.lambda)
        .chain(estimate.cre.by_cell.iter().flatten())
        .map(|x| x.to_bits())
        .collect()
}

fn same(found: &AdaptiveSolution, expected: &AdaptiveSolution) {
    assert_eq!((found.step, &found.history), (expected.step, &expected.history));
    assert_eq!(found.solution.rows, expected.solution.rows);
    assert_eq!(bits(found), bits(expected));
    assert_eq!(format!("{:?}", found.end), format!("{:?}", expected.end));
}

#[test]
fn every_checkpoint_leads_to_the_same_end() {
    let half_open = Blocks::half_open(20.0).problem().unwrap();
    let soft_above = Blocks::contrast(0.1).problem().unwrap();
    // Its new nodes are moved onto the arcs.
    let curved = pin::problem(16, [4, 2], Some(CurveKind::Arc)).unwrap();
    let problems =
        [(heavy::problem(0.3, 6).unwrap(), 0.04), (half_open, 0.06), (soft_above, 0.03), (curved, 0.1)];
    for (problem, target) in problems {
        let mut record = Record::default();
        let whole = run(&problem, target, &mut record);
        assert!(record.checkpoints.len() >= 2 && record.checkpoints.len() + 1 == whole.history.len());
        for checkpoint in &record.checkpoints {
            same(&resume(&problem, checkpoint, target, &mut Record::default()).unwrap(), &whole);
        }
    }
}

#[test]
fn every_checkpoint_of_a_run_with_friction_leads_to_the_same_end() {
    // Two blocks, and a body that only friction holds.
    let sliding = friction::blocks([8, 4], Friction::tresca(4.0)).unwrap();
    let pushed = friction::pushed_middle(6.0, [6, 3], &Friction::tresca(4.0)).unwrap();
    let settings = [Settings::default(), Settings::default().with_method(NnddSettings::default())];
    for (problem, target) in [(sliding, 0.06), (pushed, 0.04)] {
        for settings in &settings {
            let adapt = AdaptSettings::new(target);
            let mut record = Record::default();
            let whole = solve_adaptively(problem.clone(), settings, &adapt, &mut record).unwrap();
            assert!(matches!(whole.end, AdaptiveEnd::TargetMet), "{:?}", whole.end);
            assert!(record.checkpoints.len() >= 2 && record.checkpoints.len() + 1 == whole.history.len());
            for checkpoint in record.checkpoints {
                // λ along the tangents is part of the state.
                let start = &checkpoint.meshes.last().unwrap().start;
                assert_eq!(start.lambda.len(), 2 * start.active.as_ref().unwrap().len());
                let mut record = Record::default();
                let found =
                    resume_adaptively(problem.clone(), checkpoint, settings, &adapt, &mut record).unwrap();
                same(&found, &whole);
            }
        }
    }
}

#[test]
fn the_best_certificate_is_found_again_where_it_is_an_earlier_one() {
    let problem = Blocks::half_open(1.0).problem().unwrap();
    let adapt = AdaptSettings::new(0.01);
    let mut settings = Settings::default();
    settings.method = NnddSettings::paper(0.7).into();
    settings.criterion = Criterion::Iterations;
    // Two or three iterations of a bad θ: the last mesh has a worse bound than the second or the first.
    for (iterations, best) in [(2, 2), (3, 1)] {
        settings.method = settings.method.clone().with_max_iterations(iterations);
        let mut record = Record::default();
        let whole = solve_adaptively(problem.clone(), &settings, &adapt, &mut record).unwrap();
        assert_eq!((whole.step, whole.history.len()), (best, best + 1));
        for checkpoint in record.checkpoints {
            let mut record = Record::default();
            let found =
                resume_adaptively(problem.clone(), checkpoint, &settings, &adapt, &mut record).unwrap();
            same(&found, &whole);
        }
    }
}

#[test]
fn a_mesh_without_room_sends_the_run_back_to_the_one_before() {
    let problem = paper::problem(paper::COARSE).unwrap();
    let mut record = Record::default();
    let whole = run(&problem, 0.02, &mut record);
    for step in 1..whole.history.len() {
        let room = Some(whole.history[step].nodes - 1);
        let meant = run(&problem, 0.02, &mut Record { room, ..Record::default() });
        assert!(matches!(meant.end, AdaptiveEnd::OutOfMemory { .. }), "{:?}", meant.end);
        let checkpoint = &record.checkpoints[step - 1];
        same(&resume(&problem, checkpoint, 0.02, &mut Record { room, ..Record::default() }).unwrap(), &meant);
    }
}

#[test]
fn a_checkpoint_of_something_else_is_refused() {
    let problem = paper::problem(paper::COARSE).unwrap();
    let mut record = Record::default();
    run(&problem, 0.05, &mut record);
    let sound = record.checkpoints.last().unwrap();
    let refused = |change: &dyn Fn(&mut Checkpoint)| {
        let mut checkpoint = sound.clone();
        change(&mut checkpoint);
        let found = resume(&problem, &checkpoint, 0.05, &mut Record::default());
        assert!(matches!(found, Err(SolveError::Checkpoint { .. })), "{found:?}");
    };
    refused(&|c| c.meshes[0].rounds[0][1].push(u32::MAX));
    refused(&|c| c.meshes[0].rounds.clear());
    refused(&|c| c.meshes.last_mut().unwrap().start.lambda.push(0.0));
    refused(&|c| c.history.clear());
}

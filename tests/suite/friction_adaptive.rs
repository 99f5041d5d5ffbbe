//! Adaptive runs with friction: with Tresca's to a certified error, with Coulomb's to a residual.

use certified_contact::nndd::{CoulombSettings, CoulombStatus, NewtonSettings, NnddSettings};
use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, CertifiedSolution, Checkpoint, CoulombResult, Observer,
    Settings, Silent, SolveError, Step, resume_coulomb_adaptively, solve, solve_adaptively,
    solve_coulomb_adaptively,
};
use cre_estimator::Relaxation;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Friction};
use fem_core::mesh::refine::RefinementEdges;
use fem_core::norm::energy_distance_squared;
use tests::friction::{blocks, pushed_middle};

/// Keeps the bounds of every mesh.
#[derive(Default)]
struct Record {
    energies: Vec<[f64; 2]>,
    calls: Vec<usize>,
}

impl Observer for Record {
    fn step(&mut self, step: &Step, solution: &CertifiedSolution) {
        println!("{} nodes, {:?}, {} iterations", step.nodes, step.relative, step.iterations);
        assert!(step.certified);
        self.energies.push(solution.bounds.unwrap().potential_energy);
        self.calls.push(solution.nndd.clarabel_calls);
    }
}

fn run(problem: ContactProblem, settings: &Settings, target: f64, record: &mut Record) -> AdaptiveSolution {
    let answer = solve_adaptively(problem, settings, &AdaptSettings::new(target), record).unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert!(answer.solution.is_certified() && answer.solution.relative().unwrap() <= target);
    answer
}

/// Computes the distance of a solution to that on its mesh with all edges halved, square root of J/m.
fn distance_to_finer(solution: &CertifiedSolution) -> f64 {
    let problem = &solution.problem;
    let edges: Vec<RefinementEdges> =
        problem.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect();
    let all: Vec<Vec<bool>> =
        problem.bodies.iter().map(|body| vec![true; body.mesh().topology().facets().len()]).collect();
    let found = contact_geometry::refined(problem, &edges, &all).unwrap();
    let coarse = solution.estimate.as_ref().unwrap();
    let on_finer: Vec<Vec<Vector>> = found
        .refinements
        .iter()
        .zip(&coarse.pair.bodies)
        .map(|(refinement, fields)| refinement.prolong(&fields.displacement))
        .collect();
    let finer = solve(found.problem, &Settings::default(), &mut Silent).unwrap();
    let fields = &finer.estimate.as_ref().unwrap().pair.bodies;
    let squared = finer.problem.bodies.iter().zip(&on_finer).zip(fields);
    squared.map(|((body, u), v)| energy_distance_squared(body, u, &v.displacement)).sum::<f64>().sqrt()
}

/// Asserts that intervals of the same number have a common part, and that the last one is the narrowest.
fn agree(intervals: &[[f64; 2]]) {
    let low = intervals.iter().map(|i| i[0]).fold(f64::NEG_INFINITY, f64::max);
    let high = intervals.iter().map(|i| i[1]).fold(f64::INFINITY, f64::min);
    let width = |i: &[f64; 2]| i[1] - i[0];
    assert!(low <= high && width(&intervals[intervals.len() - 1]) < width(&intervals[0]), "{intervals:?}");
}

#[test]
fn two_per_cent_are_certified_with_friction() {
    let mut record = Record::default();
    let problem = blocks([18, 9], Friction::tresca(4.0)).unwrap();
    let answer = run(problem, &Settings::default(), 0.02, &mut record);
    agree(&record.energies);
    // The distance to a finer solution is most of the error: half an edge leaves about half of the error.
    let bound = answer.solution.estimate.as_ref().unwrap().certificate().unwrap().e_cre;
    let distance = distance_to_finer(&answer.solution);
    println!("bound {bound:.4e}, distance to a finer solution {distance:.4e}");
    assert!(bound > distance && bound < 1.6 * distance, "{bound} {distance}");
    // The zones lie as on the first mesh.
    let friction = answer.solution.results.as_ref().unwrap().contacts[0].friction.as_ref().unwrap();
    assert!(friction.stick_intervals[0][1] > 1.1 && friction.stick_intervals[0][1] < 1.5, "{friction:?}");
    // Refined where the error is, so that fewer nodes are needed than with equal cells.
    let last = answer.history.last().unwrap();
    assert!(answer.history.len() > 2 && last.nodes < 20_000, "{:?}", answer.history);
}

#[test]
fn the_iteration_starts_on_finer_meshes_from_both_traces() {
    let iteration = Settings::default().with_method(NnddSettings::default());
    let exact = Settings::default().with_method(NewtonSettings::default());
    for problem in [
        blocks([8, 4], Friction::tresca(4.0)).unwrap(),
        pushed_middle(6.0, [6, 3], &Friction::tresca(4.0)).unwrap(),
    ] {
        let [mut a, mut b] = [Record::default(), Record::default()];
        let iterated = run(problem.clone(), &iteration, 0.08, &mut a);
        let solved = run(problem, &exact, 0.08, &mut b);
        agree(&a.energies.iter().chain(&b.energies).copied().collect::<Vec<_>>());
        let [a, b] = [&iterated, &solved].map(|answer| answer.solution.relative().unwrap());
        assert!((a / b - 1.0).abs() < 0.05, "{a} {b}");
        // The coarser solution is nearer than zero.
        let cold = solve(iterated.solution.problem.clone(), &iteration, &mut Silent).unwrap();
        let [warm, cold] = [&iterated.solution, &cold].map(|solution| &solution.rows);
        println!("{} iterations, from zero {}", warm.len(), cold.len());
        assert!(warm.len() <= cold.len() && warm[0].iteration.eta_nndd < 0.3 * cold[0].iteration.eta_nndd);
    }
}

/// Keeps the checkpoints and the residuals of a run with Coulomb friction.
#[derive(Default)]
struct Residuals {
    checkpoints: Vec<Checkpoint>,
    found: Vec<f64>,
}

impl Observer for Residuals {
    fn step(&mut self, _: &Step, _: &CertifiedSolution) {
        panic!("nothing is certified");
    }

    fn coulomb_step(&mut self, step: &Step, result: &CoulombResult) {
        assert!(!step.certified && step.e_cre.is_none() && step.relative.is_none());
        assert_eq!((step.e_b, step.relative_residual), (result.residual(), result.relative_residual()));
        self.found.push(step.relative_residual.unwrap());
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.checkpoints.push(checkpoint.clone());
    }
}

#[test]
fn a_run_with_coulomb_friction_ends_with_its_residual_and_resumes_bit_for_bit() {
    let (settings, relaxation) = (CoulombSettings::default(), Relaxation::Steps(2));
    let coulomb = Friction::Coulomb { mu: 0.3 };
    for (problem, target) in [
        (blocks([8, 4], coulomb.clone()).unwrap(), 0.06),
        (pushed_middle(6.0, [6, 3], &coulomb).unwrap(), 0.06),
    ] {
        let (adapt, mut record) = (AdaptSettings::new(target), Residuals::default());
        let run = solve_coulomb_adaptively(problem.clone(), &settings, relaxation, &adapt, &mut record);
        let whole = run.unwrap();
        assert!(matches!(whole.end, AdaptiveEnd::TargetMet), "{:?}", whole.end);
        println!("{:?}", record.found);
        assert!(record.found.len() > 2 && record.found.windows(2).all(|w| w[1] < w[0]), "{:?}", record.found);
        assert!(whole.solution.relative_residual().unwrap() <= target);
        let bits = |answer: &AdaptiveSolution<CoulombResult>| -> Vec<u64> {
            let fields = answer.solution.displacement().iter().flatten().flatten();
            fields.chain(answer.solution.by_cell().iter().flatten()).map(|x| x.to_bits()).collect()
        };
        for checkpoint in record.checkpoints {
            let mut record = Residuals::default();
            let resumed = resume_coulomb_adaptively(
                problem.clone(),
                checkpoint,
                &settings,
                relaxation,
                &adapt,
                &mut record,
            );
            let resumed = resumed.unwrap();
            assert_eq!((resumed.step, &resumed.history), (whole.step, &whole.history));
            assert_eq!(bits(&resumed), bits(&whole));
        }
    }
}

#[test]
fn a_run_whose_fixed_point_does_not_converge_has_not_met_its_target() {
    let mut settings = CoulombSettings::default();
    settings.max_steps = 2;
    let problem = blocks([8, 4], Friction::Coulomb { mu: 0.3 }).unwrap();
    let adapt = AdaptSettings::new(0.9);
    let run = solve_coulomb_adaptively(problem, &settings, Relaxation::Steps(2), &adapt, &mut Silent);
    let end = run.unwrap().end;
    assert!(matches!(end, AdaptiveEnd::FixedPoint(CoulombStatus::MaxSteps)), "{end:?}");
    let frictionless = blocks([8, 4], Friction::None).unwrap();
    let refused =
        solve_coulomb_adaptively(frictionless, &settings, Relaxation::Steps(2), &adapt, &mut Silent);
    assert!(matches!(refused, Err(SolveError::NoCoulomb)));
}

//! The phases of a solve, one after another by public functions, in the order and with the settings of a whole run.

use crate::counts::{self, Stars};
use crate::record::{Count, Recorder};
use case_io::Case;
use case_io::template::PAPER;
use cre_estimator::{
    AdmissiblePair, EquilibratedStress, Relaxation, StarRelaxation, admissible_pair, check, estimate_with,
};
use fem_core::assembly::System;
use fem_core::cholesky::{Cholesky, SymbolicCholesky};
use fem_core::condensation::CondensedBody;
use fem_core::dof::DofMap;
use fem_core::interface::{ContactProblem, ContactState};
use fem_core::prepared::PreparedProblem;
use fem_core::{each_body, field};
use nndd::stopping::{Decision, StoppingCriterion};
use nndd::{Iterate, NnddSolution};
use nndd_report::{Host, RunDirectory, RunResult, Stopwatch, convert, files, run};
use rayon::prelude::*;
use serde_json::{Map, json};
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// The clock of a whole run.
struct Clock(Instant);

impl Host for Clock {
    fn elapsed(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// Ends an iteration where the whole run ended.
struct After(usize);

impl StoppingCriterion for After {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn std::error::Error + Send + Sync>> {
        Ok(if iterate.iteration < self.0 { Decision::Continue } else { Decision::Stop })
    }
}

/// Measures the phases of the paper's case with other settings.
pub(crate) fn measure(rounds: usize, settings: &[String]) {
    let case = Case::parse(PAPER, "paper.toml", &run::overrides(settings).unwrap()).unwrap();
    let Whole { problem, nndd, record } = whole(&case, rounds);
    let relaxation = convert::relaxation(&case);
    of_factors(&record, &problem);
    let problem = PreparedProblem::new(problem).unwrap();
    let pair = of_solution(&record, &problem, &case, &nndd);
    of_stresses(&record, problem.problem(), &pair, relaxation);
}

/// The results of a whole run that the phases need.
struct Whole {
    problem: ContactProblem,
    nndd: NnddSolution,
    record: Recorder,
}

/// Runs the case as the program does, with its files, and prints the times that its report has.
fn whole(case: &Case, rounds: usize) -> Whole {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let mut host = Clock(Instant::now());
    let mut watch = Stopwatch::start(host.elapsed());
    let built = run::build(case, &host).unwrap_or_else(|e| panic!("{e:?}"));
    let mut place = RunDirectory::open(case, folder.path(), true).unwrap_or_else(|e| panic!("{e:?}"));
    let solved =
        run::solve(case, built, &mut place, &mut watch, &mut host).unwrap_or_else(|e| panic!("{e:?}"));
    let solution = solved.answer.certified().unwrap();
    assert!(solution.estimate.as_ref().is_some_and(|e| e.certificate().is_some()), "there is no certificate");
    let record = Recorder { rounds, unknowns: solution.unknowns.iter().sum() };
    let mut timings = None;
    drop(place);
    let open = || RunDirectory::open(case, folder.path(), true).unwrap_or_else(|e| panic!("{e:?}"));
    let (_, seconds) = record.time(open, |place| {
        let written = files::write(case, &solved, place, Map::new(), &mut watch, &host)
            .unwrap_or_else(|e| panic!("{e:?}"));
        timings.get_or_insert(written.report.timings);
    });
    let run = json!({ "kind": "run", "threads": rayon::current_num_threads(), "unknowns": record.unknowns,
        "iterations": solution.nndd.history.len(),
        "estimates": solution.rows.iter().filter(|row| row.e_cre.is_some()).count(), "seconds": timings });
    println!("{run}");
    record.print("files", &seconds, Count { flops: 0.0, bytes: bytes_in(folder.path()) });
    let RunResult::Certified(solution) = solved.answer else { panic!("the solution is not certified") };
    Whole { problem: solution.problem, nndd: solution.nndd, record }
}

/// Bytes of the files in a folder and those below it.
fn bytes_in(folder: &Path) -> f64 {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let size = |path: std::path::PathBuf| {
        if path.is_dir() { bytes_in(&path) } else { path.metadata().unwrap().len() as f64 }
    };
    entries.map(size).sum()
}

/// From the order of the unknowns to the operators of the interface.
fn of_factors(record: &Recorder, problem: &ContactProblem) {
    let bodies = &problem.bodies;
    let count = bodies.len();
    let of_mesh =
        |count: fn(&fem_core::mesh::TriMesh) -> Count| Count::sum(bodies.iter().map(|b| count(b.mesh())));
    let order = |()| each_body(count, |b| DofMap::new(&bodies[b], &problem.side(b)));
    let (dofs, seconds) = record.time(|| (), order);
    record.print("dissection", &seconds, of_mesh(counts::dissection));

    let assemble = |dofs: Vec<DofMap>| -> Vec<System> {
        let numbered = dofs.into_par_iter().enumerate().with_max_len(1);
        numbered.map(|(b, dofs)| System::stabilised(&bodies[b], dofs).unwrap()).collect()
    };
    let (systems, seconds) = record.time(|| dofs.clone(), assemble);
    let sizes = bodies.iter().zip(&systems).map(|(body, system)| counts::assembly(body.mesh(), system));
    record.print("assembly", &seconds, Count::sum(sizes));
    drop(dofs);

    let analyse = |b: usize| {
        let System { dofs, stiffness, .. } = &systems[b];
        Arc::new(SymbolicCholesky::analyse(stiffness, dofs.fronts()).unwrap())
    };
    let (symbolic, seconds) = record.time(|| (), |()| each_body(count, analyse));
    let both = || systems.iter().zip(&symbolic);
    record.print("analysis", &seconds, Count::sum(both().map(|(system, s)| counts::analysis(system, s))));

    let factorise = |b: usize| Cholesky::factorise(symbolic[b].clone(), &systems[b].stiffness).unwrap();
    let (factors, seconds) = record.time(|| (), |()| each_body(count, factorise));
    record.print(
        "factorisation",
        &seconds,
        Count::sum(both().map(|(system, s)| counts::factorisation(system, s))),
    );

    let loads = || systems.iter().map(|system| system.load.clone()).collect::<Vec<_>>();
    let (_, seconds) = record.time(loads, |loads| {
        let all = loads.into_par_iter().enumerate().with_max_len(1);
        all.map(|(b, load)| condense(&factors[b], &systems[b], load)).collect::<Vec<_>>()
    });
    let sizes = both().map(|(system, s)| counts::condensation(s, &system.dofs));
    record.print("condensation", &seconds, Count::sum(sizes));
}

/// The steps of [`CondensedBody::factorise`] after the factor: `S` and the condensed load's substitution.
fn condense(factor: &Cholesky, system: &System, mut load: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    let n = system.dofs.interface_len();
    let block = factor.trailing_block(n);
    let schur = fem_core::dense::square(&block, n);
    factor.forward(&mut load);
    (schur, load)
}

/// The iteration, its fields, and the Neumann problems of the estimate.
fn of_solution(
    record: &Recorder,
    problem: &PreparedProblem,
    case: &Case,
    whole: &NnddSolution,
) -> AdmissiblePair {
    let bodies: Vec<&CondensedBody> = problem.bodies().iter().filter_map(|body| body.whole()).collect();
    let method = convert::settings(case).method;
    let iterations = whole.history.len();
    let solve =
        |lambda| nndd::solve(&problem.system(), lambda, method.clone(), &mut After(iterations)).unwrap();
    let (found, seconds) = record.time(|| vec![0.0; problem.rows()], solve);
    assert_eq!(found.history.len(), iterations, "the iteration is not that of the whole run");
    let lanczos = found.spectrum.map_or(0, |spectrum| spectrum.steps);
    record.print("iteration", &seconds, counts::iteration(problem.rows(), lanczos, &found.history));

    let substitutions = |trace: bool| -> Count {
        let of_body = |body: &&CondensedBody| counts::substitution(body.stored_values(), body.dofs(), trace);
        Count::sum(bodies.iter().map(of_body))
    };
    let (displacement, seconds) =
        record.time(|| (), |()| problem.displacements(&found.last.fields(&problem.system())));
    record.print("recovery", &seconds, substitutions(true));

    let [first, second] = [0, 1].map(|b| displacement[b].as_slice());
    let last = &found.last;
    let state = ContactState::between([first, second], &last.contact.normal_reaction, &last.opening);
    let relaxation = convert::relaxation(case);
    let (_, seconds) = record.time(|| (), |()| estimate_with(problem, &state, relaxation).unwrap());
    // Of its parts only some are public: xtask takes these away from it.
    record.print("whole estimate", &seconds, Count::default());
    let pair = admissible_pair(problem, &state, Relaxation::NONE).unwrap();
    let load: Vec<f64> = problem.problem().contacts[0].interface.mass(&pair.contacts[0].pressure);
    let neumann = |b: usize| {
        let forces = load.iter().map(|f| if b == 0 { -f } else { *f }).collect();
        let forces = bodies[b].dofs().interface_forces(&[forces]);
        field::stresses(&problem.problem().bodies[b], &bodies[b].displacement_from_force(&forces))
    };
    let (_, seconds) = record.time(|| (), |()| each_body(bodies.len(), neumann));
    let stresses = problem.problem().bodies.iter().map(|body| counts::stress(body.mesh()));
    record.print("Neumann problems", &seconds, Count::sum(stresses.chain([substitutions(false)])));
    pair
}

/// Stresses in equilibrium, their relaxation and their checks.
fn of_stresses(record: &Recorder, problem: &ContactProblem, pair: &AdmissiblePair, relaxation: Relaxation) {
    let bodies = &problem.bodies;
    let of_mesh =
        |count: fn(&fem_core::mesh::TriMesh) -> Count| Count::sum(bodies.iter().map(|b| count(b.mesh())));
    let stress = |b: usize| &pair.bodies[b].equilibrated;
    let given =
        || (0..bodies.len()).map(|b| (stress(b).finite_element.clone(), stress(b).conditions.clone()));
    let (_, seconds) = record.time(
        || given().collect::<Vec<_>>(),
        |given| {
            let all = given.into_par_iter().enumerate().with_max_len(1);
            let recover =
                |(b, (stress, conditions))| EquilibratedStress::recover(&bodies[b], stress, conditions);
            all.map(recover).collect::<Vec<_>>()
        },
    );
    record.print("EET", &seconds, of_mesh(counts::eet));

    let energy = |b: usize| black_box(stress(b).distance_squared(&bodies[b]));
    let (_, seconds) = record.time(|| (), |()| each_body(bodies.len(), energy));
    record.print("Johnson-Mercier", &seconds, of_mesh(counts::johnson_mercier));

    // One body after the other, as in an estimate.
    let prepare = |b: usize| StarRelaxation::new(&bodies[b], &stress(b).conditions);
    let (stars, seconds) = record.time(|| (), |()| (0..bodies.len()).map(prepare).collect::<Vec<_>>());
    let sizes: Vec<Stars> =
        bodies.iter().zip(&stars).map(|(body, stars)| Stars::new(body.mesh(), stars)).collect();
    record.print("star set-up", &seconds, Count::sum(sizes.iter().map(Stars::set_up)));

    let copies = || (0..bodies.len()).map(|b| stress(b).clone()).collect::<Vec<_>>();
    let relax = |relaxation: Relaxation| {
        let stars = &stars;
        move |mut copies: Vec<EquilibratedStress>| -> Vec<usize> {
            let all = copies.iter_mut().zip(stars);
            all.map(|(stress, stars)| stars.relax(stress, relaxation).steps).collect()
        }
    };
    let (_, start) = record.time(copies, relax(Relaxation::NONE));
    record.print("star residual", &start, Count::sum(sizes.iter().map(Stars::start)));
    let (steps, seconds) = record.time(copies, relax(relaxation));
    let steps = sizes.iter().zip(steps).map(|(sizes, steps)| sizes.sweeps(steps));
    let beyond: Vec<f64> = seconds.iter().zip(&start).map(|(all, start)| all - start).collect();
    record.print("star sweeps", &beyond, Count::sum(steps));
    drop(stars);

    let (_, seconds) = record.time(|| (), |()| check(problem, pair));
    record.print("checks", &seconds, of_mesh(counts::checks));
}

//! Adaptive runs of random assemblies, whose bounds are judged on a mesh with all cells of the last one halved three times, with friction twice.

use super::build::{Assembly, Condition, Linear};
use super::judge::{ROUNDING, of_run};
use super::{Problem, Trial};
use crate::matrix::Promise;
use crate::model::Made;
use certified_contact::{
    AdaptSettings, AdaptiveEnd, Bounds, CertifiedSolution, Checkpoint, Observer, Settings, Silent,
    SolveError, Step, solve, solve_adaptively,
};
use contact_geometry::{RefinedSolids, edge_order, halved};
use cre_estimator::Relaxation;
use fem_core::interface::ContactProblem;
use fem_core::mesh::bisect::EdgeOrder;
use fem_core::norm::energy_distance_squared;
use fem_core::space::Solid;
use nalgebra::Vector3;
use nndd::NewtonSettings;

/// A mesh of an adaptive run has at most this many nodes.
const NODES: usize = 320;

type Fields = Vec<Vec<Vector3<f64>>>;

/// A certified solution on one mesh of a run.
struct Claim {
    displacement: Fields,
    e_cre: f64,
    bounds: Option<Bounds>,
}

/// Keeps each solution of a run and the cells that were refined.
#[derive(Default)]
struct Record {
    claims: Vec<(usize, Claim)>,
    checkpoint: Option<Checkpoint>,
    solutions: Vec<CertifiedSolution<Solid>>,
}

impl Observer<Solid> for Record {
    fn step(&mut self, step: &Step, solution: &CertifiedSolution<Solid>) {
        self.solutions.push(solution.clone());
        let Some(estimate) = solution.estimate.as_ref().filter(|_| solution.is_certified()) else { return };
        let displacement = estimate.pair.bodies.iter().map(|body| body.displacement.clone()).collect();
        let claim = Claim { displacement, e_cre: estimate.unchecked().e_cre, bounds: solution.bounds };
        self.claims.push((step.step, claim));
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.checkpoint = Some(checkpoint.clone());
    }
}

/// The assembly without what a finer mesh changes: declared surfaces, round obstacles, and gaps between bent sides.
pub(super) fn flat(assembly: &Assembly) -> Assembly {
    let mut flat = assembly.clone();
    for touch in &mut flat.touches {
        touch.declared = None;
        if flat.grid.is_bent() {
            touch.gap = Linear::constant(0.0);
        }
    }
    for side in flat.parts.iter_mut().flat_map(|part| &mut part.sides) {
        if let Condition::Round(_, drive) = *side {
            *side = Condition::Plane(Linear::constant(0.0), drive);
        }
    }
    flat
}

/// A problem on the meshes of a run, with fields that are carried along.
struct Nested {
    problem: ContactProblem<Solid>,
    order: EdgeOrder,
    fields: Vec<Fields>,
}

impl Nested {
    fn halve(&mut self, cells: &[Vec<u32>]) -> Made<()> {
        let RefinedSolids { problem, refinements, order, .. } = halved(&self.problem, &self.order, cells)?;
        for field in &mut self.fields {
            for (values, refinement) in field.iter_mut().zip(&refinements) {
                for [a, b] in &refinement.parent_nodes {
                    values.push((values[a.index()] + values[b.index()]) * 0.5);
                }
            }
        }
        (self.problem, self.order) = (problem, order);
        Ok(())
    }
}

/// Refines a problem adaptively, and judges each of its meshes.
///
/// * `first`: on the first meshes.
pub(super) fn judge(problem: &Problem, first: ContactProblem<Solid>, trial: &mut Trial) -> Made<()> {
    let mut adapt = AdaptSettings::new(1e-3);
    adapt.max_steps = 2 + (problem.number % 3) as usize;
    adapt.max_nodes = NODES.max(first.nodes());
    adapt.fraction = [0.5, 0.2, 0.9][(problem.number / 3 % 3) as usize];
    let mut settings = problem.second.clone();
    settings.criterion = Settings::<Solid>::default().criterion;
    let mut record = Record::default();
    trial.runs += 1;
    let end = match solve_adaptively(first.clone(), &settings, &adapt, &mut record) {
        Ok(found) => found.end,
        Err(error) => {
            let of_method = matches!(error, SolveError::Nndd(_));
            let refusal = matches!(
                error,
                SolveError::NotHeld { .. } | SolveError::CutForce { .. } | SolveError::Bonds(_)
            ) || of_method;
            trial.say(Promise::Status, refusal, || format!("adaptive: {error}"));
            return Ok(());
        }
    };
    if let AdaptiveEnd::Failed(error) = &end {
        let of_method = matches!(error, SolveError::Nndd(_) | SolveError::NotHeld { .. });
        trial.say(Promise::Status, of_method, || format!("adaptive: {error}"));
    }
    for solution in &record.solutions {
        of_run("adaptive", solution, &settings, trial);
    }
    // The meshes of the run, and then all cells halved.
    let mut nested = Nested { order: edge_order(&first)?, problem: first, fields: Vec::new() };
    let mut bounds = Vec::new();
    let meshes = record.checkpoint.map(|checkpoint| checkpoint.meshes).unwrap_or_default();
    for step in 1..=meshes.len() + 1 {
        for claim in record.claims.iter().filter(|(of, _)| *of == step).map(|(_, claim)| claim) {
            nested.fields.push(claim.displacement.clone());
            bounds.push((step, claim.e_cre, claim.bounds));
        }
        if step <= meshes.len() {
            meshes[step - 1].rounds.iter().try_for_each(|cells| nested.halve(cells))?;
        }
    }
    // Friction has three rows for each pair of nodes.
    let rounds = if nested.problem.has_friction() { 2 } else { 3 };
    for _ in 0..rounds {
        let all = |body: &fem_core::body::Body<Solid>| (0..body.mesh().cells().len() as u32).collect();
        let all: Vec<Vec<u32>> = nested.problem.bodies.iter().map(all).collect();
        nested.halve(&all)?;
    }
    let mut exact = Settings::<Solid>::default().with_method(NewtonSettings::default());
    exact.relaxation = Relaxation::Steps(1);
    let finest = match solve(nested.problem, &exact, &mut Silent) {
        Ok(finest) => finest,
        Err(error) => {
            trial.say(Promise::Status, bounds.is_empty(), || format!("finest of adaptive: {error}"));
            return Ok(());
        }
    };
    let Some(estimate) = finest.estimate.as_ref().filter(|_| finest.is_certified()) else { return Ok(()) };
    trial.refined += bounds.len();
    let slack = ROUNDING * estimate.energy_norm();
    let inexact = estimate.unchecked().eta_nndd.max(finest.last().eta_nndd) + estimate.round_off;
    for ((step, e_cre, of), field) in bounds.iter().zip(&nested.fields) {
        let bodies = finest.problem.bodies.iter().zip(&estimate.pair.bodies).zip(field);
        let squared: f64 =
            bodies.map(|((body, fine), u)| energy_distance_squared(body, u, &fine.displacement)).sum();
        let distance = squared.max(0.0).sqrt();
        // Fields that are carried along have no jump: with cuts the intervals are judged alone.
        if problem.family != "cuts" {
            trial.say(Promise::Error, distance <= e_cre + inexact + slack, || {
                format!("adaptive, mesh {step}: {distance:e} apart, e_cre {e_cre:e}, finer one {inexact:e}")
            });
            if distance > 10.0 * (inexact + slack) {
                trial.effectivity = Some(e_cre / distance);
            }
        }
        let Some((a, b)) = of.zip(finest.bounds) else { continue };
        let intervals = [
            (Promise::Norm, Some((a.energy_norm, b.energy_norm))),
            (Promise::Energy, Some((a.potential_energy, b.potential_energy))),
            (Promise::Force, a.contact_force.ok().zip(b.contact_force.ok())),
        ];
        for (promise, both) in intervals {
            let Some((x, y)) = both else { continue };
            let slack = ROUNDING * x.iter().chain(&y).fold(0.0f64, |m, x| m.max(x.abs()));
            let meet = x[0] <= y[1] + slack && y[0] <= x[1] + slack;
            trial.say(promise, meet, || format!("adaptive, mesh {step}: {x:?} and {y:?} are apart"));
        }
    }
    Ok(())
}

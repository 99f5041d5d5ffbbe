//! The certified loop: solve, estimate, mark, refine, until the bound is as small as asked for.

use crate::history::Step;
use crate::observer::{Observer, Phase};
use crate::refine::{self, Finer, Refined};
use crate::settings::{Criterion, Settings};
use crate::solve::{CertifiedSolution, Roles, SolveError, solve, solve_again};
use fem_core::interface::ContactProblem;
use fem_core::mesh::refine::RefinementEdges;
use nndd::NnddStatus;

/// Refining is worth the while where the mesh contributes at least this share of the squared bound.
const LEAST_SHARE: f64 = 0.1;

/// When an adaptive run ends, and how it refines.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AdaptSettings {
    /// The certified relative error to reach, of [`CertifiedSolution::relative`]; where the energy norm is zero, a bound
    /// of zero is asked for.
    pub target: f64,
    /// Most meshes, the first among them; default 30.
    pub max_steps: usize,
    /// Most nodes of both bodies together; default 2 000 000. The first mesh is solved whatever its size.
    pub max_nodes: usize,
    /// Share of the squared error that each round of marking takes, in (0, 1]; default ½.
    pub fraction: f64,
}

impl AdaptSettings {
    /// Sets a target, everything else by default.
    pub fn new(target: f64) -> Self {
        Self { target, max_steps: 30, max_nodes: 2_000_000, fraction: 0.5 }
    }
}

/// How an adaptive run ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum AdaptiveEnd {
    /// The certified relative error is at most the target.
    TargetMet,
    /// All allowed meshes were used.
    MaxSteps,
    /// A finer mesh worth solving would have more nodes than allowed.
    MaxNodes,
    /// The target lies below what floating-point numbers can certify.
    RoundOff {
        /// The attainable relative error: the allowance for round-off over the energy norm.
        floor: f64,
    },
    /// The iteration on the last mesh did not meet its criterion: see [`nndd::NnddSolution::status`].
    Iteration(NnddStatus),
    /// Nearly all of the last mesh's bound is the iteration's error, which no finer mesh lowers: it was stopped too early.
    IterationError,
    /// The checks of the last mesh's bound fail, or it has none.
    NotCertified,
    /// The observer ended the run.
    Interrupted,
    /// The observer has no room for the next mesh.
    NoRoom {
        /// Nodes of that mesh.
        nodes: usize,
    },
    /// The next mesh could not be made or solved.
    Failed(SolveError),
}

/// The result of an adaptive run.
#[derive(Debug)]
#[non_exhaustive]
pub struct AdaptiveSolution {
    /// The solution with the smallest valid bound: normally that of the last mesh.
    pub solution: CertifiedSolution,
    /// Its step in `history`, from 1.
    pub step: usize,
    /// One entry per mesh solved.
    pub history: Vec<Step>,
    /// How the run ended.
    pub end: AdaptiveEnd,
}

/// Solves a contact problem on finer and finer meshes until the certified relative error is at most the target.
///
/// * `problem`: bodies in the user's order, on their first meshes; every finer mesh poses the same problem.
/// * `settings`: of the solve on every mesh. The criterion that compares the iteration with the mesh is the one that
///   makes sense here. Roles and λ are chosen on the first mesh and carried over.
///
/// # Example
/// Two blocks, the upper one pressed down and held at its left side: a certified 8 % from a very coarse start.
/// ```
/// use certified_contact::{AdaptSettings, AdaptiveEnd, Settings, Silent, solve_adaptively};
/// use fem_core::{body::Body, boundary::BoundaryConditions, interface::{ContactInterface, ContactProblem, Gap},
///     material::{Hypothesis, LinearElastic}, mesh::generate::block};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
/// let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [4, 2])?, steel.clone(), &BoundaryConditions::new()
///     .displace("left", Some(0.0.into()), None).displace("top", None, Some((-0.01).into())))?;
/// let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [4, 2])?, steel, &BoundaryConditions::new().fix("bottom"))?;
/// let interface = ContactInterface::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
/// let problem = ContactProblem { bodies: [upper, lower], interface };
/// let answer = solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(0.08), &mut Silent)?;
/// assert!(matches!(answer.end, AdaptiveEnd::TargetMet));
/// assert!(answer.history.len() > 1 && answer.solution.is_certified());
/// # Ok(()) }
/// ```
///
/// # Errors
/// The first mesh cannot be solved. What happens later is told by [`AdaptiveSolution::end`], beside the best certificate.
pub fn solve_adaptively(
    problem: ContactProblem,
    settings: &Settings,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer,
) -> Result<AdaptiveSolution, SolveError> {
    let mut solution = solve(problem, settings, observer)?;
    let mut edges = [0, 1].map(|b| RefinementEdges::longest(solution.problem.bodies[b].mesh()));
    let mut history = Vec::new();
    let mut best = None;
    let end = loop {
        let step = Step::new(history.len() + 1, &solution);
        history.push(step);
        observer.step(&step, &solution);
        if let Some(end) = ended(&step, &solution, settings, adapt, observer) {
            break end;
        }
        // Mark and refine; carry λ and the active set over.
        observer.phase(Phase::Refinement);
        let wanted = refine::next_size(step.nodes, step.relative, adapt.target, adapt.max_nodes);
        let Finer { problem, refinement_edges, start } =
            match refine::refine(&solution, &edges, adapt.fraction, wanted, adapt.max_nodes) {
                Ok(Refined::Finer(finer)) => *finer,
                Ok(Refined::NothingToRefine) => break AdaptiveEnd::IterationError,
                Ok(Refined::NoRoom) => break AdaptiveEnd::MaxNodes,
                Err(error) => break AdaptiveEnd::Failed(error.into()),
            };
        if !observer.has_room_for(&problem) {
            let nodes = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
            break AdaptiveEnd::NoRoom { nodes };
        }
        // Solve and estimate.
        let roles = Roles { swapped: solution.swapped, reason: solution.role_reason };
        let finer = match solve_again(problem, roles, start, settings, observer) {
            Ok(finer) => finer,
            Err(error) => break AdaptiveEnd::Failed(error),
        };
        edges = refinement_edges;
        let coarser = std::mem::replace(&mut solution, finer);
        if !is_better(&solution, &coarser) {
            keep_better(&mut best, coarser, step.step);
        }
    };
    let last = history.len();
    let (step, solution) = match best {
        Some((step, kept)) if !is_better(&solution, &kept) => (step, kept),
        _ => (last, solution),
    };
    Ok(AdaptiveSolution { solution, step, history, end })
}

/// Decides whether the mesh just solved is the last one.
fn ended(
    step: &Step,
    solution: &CertifiedSolution,
    settings: &Settings,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer,
) -> Option<AdaptiveEnd> {
    if !step.certified {
        return Some(AdaptiveEnd::NotCertified);
    }
    let met = step.relative.map_or(step.e_cre == Some(0.0), |relative| relative <= adapt.target);
    if met {
        return Some(AdaptiveEnd::TargetMet);
    }
    match solution.nndd.status {
        NnddStatus::StoppedByCriterion => {}
        NnddStatus::MaxIterations if settings.criterion == Criterion::Iterations => {}
        NnddStatus::Interrupted => return Some(AdaptiveEnd::Interrupted),
        status => return Some(AdaptiveEnd::Iteration(status)),
    }
    let floor = round_off(solution);
    if floor > adapt.target {
        return Some(AdaptiveEnd::RoundOff { floor });
    }
    if refine::mesh_share(solution) < LEAST_SHARE {
        return Some(AdaptiveEnd::IterationError);
    }
    if step.step >= adapt.max_steps {
        return Some(AdaptiveEnd::MaxSteps);
    }
    if !refine::has_room(step.nodes, adapt.max_nodes) {
        return Some(AdaptiveEnd::MaxNodes);
    }
    observer.should_stop().then_some(AdaptiveEnd::Interrupted)
}

/// Computes the allowance for round-off over the energy norm: no relative error below it can be certified.
fn round_off(solution: &CertifiedSolution) -> f64 {
    solution.estimate.as_ref().map_or(0.0, |e| {
        let norm = e.energy_norm_squared.iter().sum::<f64>().sqrt();
        let allowance = e.e_cre - e.cre.e_cre();
        if norm > 0.0 { allowance / norm } else { 0.0 }
    })
}

/// Tells whether a solution has a valid bound, smaller than that of the other if that has one.
fn is_better(this: &CertifiedSolution, other: &CertifiedSolution) -> bool {
    let bound = |s: &CertifiedSolution| {
        let absolute = s.estimate.as_ref().map(|e| e.e_cre);
        if s.is_certified() { s.relative().or(absolute) } else { None }
    };
    match (bound(this), bound(other)) {
        (Some(this), Some(other)) => this < other,
        (this, _) => this.is_some(),
    }
}

/// Keeps a solution if it is better than the one kept so far.
fn keep_better(best: &mut Option<(usize, CertifiedSolution)>, solution: CertifiedSolution, step: usize) {
    if best.as_ref().is_none_or(|(_, kept)| is_better(&solution, kept)) {
        *best = Some((step, solution));
    }
}

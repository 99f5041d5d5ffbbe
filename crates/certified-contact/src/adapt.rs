//! The certified loop: solve, estimate, mark, refine, until the bound is at most the target; with Coulomb friction the residual.

mod in_steps;
mod solve_on_mesh;

use crate::checkpoint::{Checkpoint, FinerMesh};
use crate::coulomb::CoulombResult;
use crate::error::SolveError;
use crate::history::Step;
use crate::observer::{Observer, Phase, Silent};
use crate::refine::{self, Finer, Refined};
use crate::settings::Settings;
use crate::solution::CertifiedSolution;
use crate::space::ContactSpace;
use cre_estimator::{Estimate, Relaxation};
use fem_core::interface::ContactProblem;
use fem_core::space::{Plane, Space};
use in_steps::InSteps;
use nndd::{CoulombSettings, CoulombStatus, NnddStatus};
use solve_on_mesh::SolveOnMesh;

pub use in_steps::{StepFactors, StepSolutions};

/// Refining is worthwhile if the mesh contributes at least this share of the squared bound.
const LEAST_SHARE: f64 = 0.1;

/// When an adaptive run ends, and how it refines.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AdaptSettings {
    /// The certified relative error to reach, of [`CertifiedSolution::relative`]; if the bodies have no strain
    /// energy, a bound of zero to round-off is the target. With Coulomb friction the relative residual, of
    /// [`CoulombResult::relative_residual`].
    pub target: f64,
    /// Maximum number of meshes, including the first; default 30.
    pub max_steps: usize,
    /// Maximum number of nodes of all bodies together; default 2 000 000. The first mesh is solved whatever its size.
    pub max_nodes: usize,
    /// Share of the squared error that each round of marking takes, in (0, 1]; default ½.
    pub fraction: f64,
}

impl AdaptSettings {
    /// Sets a target and leaves the other settings at their defaults.
    pub fn new(target: f64) -> Self {
        Self { target, max_steps: 30, max_nodes: 2_000_000, fraction: 0.5 }
    }
}

/// How an adaptive run ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum AdaptiveEnd<S: Space = Plane> {
    /// The certified relative error is at most the target; with Coulomb friction the relative residual is.
    TargetMet,
    /// All allowed meshes were used.
    MaxSteps,
    /// A finer mesh worth solving would have more nodes than allowed.
    MaxNodes,
    /// The target is below what floating-point arithmetic can certify.
    RoundOff {
        /// The attainable relative error: the allowance for round-off over the energy norm.
        floor: f64,
    },
    /// The iteration on the last mesh did not meet its criterion: see [`nndd::NnddSolution::status`].
    Iteration(NnddStatus),
    /// The fixed point of Coulomb friction on the last mesh did not converge.
    FixedPoint(CoulombStatus),
    /// Nearly all of the last mesh's bound is the iteration's error, which a finer mesh does not lower: the iteration
    /// was stopped too early.
    IterationError,
    /// The relative bound, or the residual, rose on two meshes in a row.
    Rose,
    /// The checks of the bound on the last mesh fail, or there is no bound.
    NotCertified {
        /// The checks that fail, each with its residual; none if there is no bound.
        failed: Vec<(&'static str, f64)>,
    },
    /// The observer ended the run.
    Interrupted,
    /// The observer reports too little memory for the next mesh.
    OutOfMemory {
        /// Nodes of that mesh.
        nodes: usize,
    },
    /// The next mesh could not be made or solved.
    Failed(SolveError<S>),
}

/// The result of an adaptive run.
#[derive(Debug)]
#[non_exhaustive]
pub struct AdaptiveSolution<A = CertifiedSolution, S: Space = Plane> {
    /// The solution with the smallest valid bound or, with Coulomb friction, the smallest residual: normally on the last mesh.
    pub solution: A,
    /// Its step in `history`, from 1.
    pub step: usize,
    /// One entry per mesh solved.
    pub history: Vec<Step>,
    /// How the run ended.
    pub end: AdaptiveEnd<S>,
}

/// The result of an adaptive run with load steps.
pub type AdaptiveSteps<A = CertifiedSolution, S = Plane> = AdaptiveSolution<StepSolutions<A, S>, S>;

impl<A, S: Space> AdaptiveSolution<A, S> {
    /// Computes the change of the largest von Mises stress ([`crate::PeakStress`]) from the previous mesh to the mesh of the
    /// solution, relative to the previous value; `None` on the first mesh.
    pub fn peak_change(&self) -> Option<f64> {
        let peak = |step: usize| self.history.get(step.checked_sub(1)?)?.peak_stress;
        let (before, now) = (peak(self.step.checked_sub(1)?)?, peak(self.step)?);
        (before > 0.0).then(|| (now - before) / before)
    }
}

/// Solves a contact problem on finer and finer meshes until the certified relative error is at most the target.
///
/// * `problem`: bodies in the user's order, on their first meshes; every finer mesh poses the same problem,
///   except for data that are interpolated linearly along edges.
/// * `settings`: of the solve on every mesh. The default criterion, which compares the iteration error with the mesh
///   error, is recommended. The roles of the bodies and λ are chosen on the first mesh and kept.
///
/// # Example
/// Two blocks, the upper one pressed down and held at its left side: a certified 8 % from a very coarse start.
/// ```
/// use certified_contact::{AdaptSettings, AdaptiveEnd, Settings, Silent, solve_adaptively};
/// use fem_core::{body::Body, boundary::BoundaryConditions, interface::{ContactProblem, Gap},
///     material::{Hypothesis, LinearElastic}, mesh::generate::block};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
/// let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [4, 2])?, steel.clone(), &BoundaryConditions::new()
///     .displace("left", Some(0.0.into()), None).displace("top", None, Some((-0.01).into())))?;
/// let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [4, 2])?, steel, &BoundaryConditions::new().fix("bottom"))?;
/// let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
/// let problem = ContactProblem::between([upper, lower], interface);
/// let answer = solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(0.08), &mut Silent)?;
/// assert!(matches!(answer.end, AdaptiveEnd::TargetMet));
/// assert!(answer.history.len() > 1 && answer.solution.is_certified());
/// # Ok(()) }
/// ```
///
/// # Errors
/// The first mesh cannot be solved. Later failures are reported in [`AdaptiveSolution::end`], with the best certificate.
pub fn solve_adaptively<S: ContactSpace>(
    problem: ContactProblem<S>,
    settings: &Settings<S>,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<CertifiedSolution<S>, S>, SolveError<S>> {
    begin(problem, settings, adapt, observer)
}

/// Solves a contact problem with Coulomb friction on finer and finer meshes until the relative residual is at most the target. The
/// residual is no bound of the error: see [`CoulombResult`].
///
/// # Errors
/// See [`crate::solve_coulomb`], of the first mesh. Later failures are reported in [`AdaptiveSolution::end`].
pub fn solve_coulomb_adaptively<S: ContactSpace>(
    problem: ContactProblem<S>,
    settings: &CoulombSettings,
    relaxation: Relaxation,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<CoulombResult<S>, S>, SolveError<S>> {
    begin(problem, &(settings.clone(), relaxation), adapt, observer)
}

/// Resumes an interrupted run of [`solve_coulomb_adaptively`], see [`resume_adaptively`].
///
/// # Errors
/// See [`solve_coulomb_adaptively`]; [`SolveError::Checkpoint`] if the checkpoint belongs to another problem.
pub fn resume_coulomb_adaptively<S: ContactSpace>(
    problem: ContactProblem<S>,
    checkpoint: Checkpoint,
    settings: &CoulombSettings,
    relaxation: Relaxation,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<CoulombResult<S>, S>, SolveError<S>> {
    resume(problem, checkpoint, &(settings.clone(), relaxation), adapt, observer)
}

/// Resumes an interrupted adaptive run. The result is the same as of an uninterrupted run.
///
/// * `problem`: on its first mesh, in the order passed in, as at the start of the run.
/// * `checkpoint`: the last argument of [`Observer::checkpoint`]. The run resumes with the mesh that was to be solved
///   next. If that mesh cannot be solved, or memory is too small for it, the previous mesh is solved again.
/// * `settings`, `adapt`: as given to the run.
///
/// # Errors
/// See [`solve_adaptively`]; [`SolveError::Checkpoint`] if the checkpoint belongs to another problem.
pub fn resume_adaptively<S: ContactSpace>(
    problem: ContactProblem<S>,
    checkpoint: Checkpoint,
    settings: &Settings<S>,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<CertifiedSolution<S>, S>, SolveError<S>> {
    resume(problem, checkpoint, settings, adapt, observer)
}

/// Solves load steps on finer and finer meshes, all steps on each mesh, until every step has at most the target.
///
/// The bound of a step is that of its increment, from the slip that was computed before it on the same mesh. The cells are marked by their
/// contributions summed over the steps, each relative to the squared energy norm of its step.
///
/// * `problem`: its conditions with the factor 1.
/// * `checkpoint`: of an interrupted run, see [`resume_adaptively`].
///
/// # Errors
/// See [`solve_adaptively`]; on the first mesh those of a step as [`SolveError::LoadStep`].
pub fn solve_steps_adaptively<S: ContactSpace>(
    problem: ContactProblem<S>,
    factors: &[StepFactors<'_>],
    checkpoint: Option<Checkpoint>,
    settings: &Settings<S>,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSteps<CertifiedSolution<S>, S>, SolveError<S>> {
    run(problem, checkpoint, &InSteps { method: settings, factors }, adapt, observer)
}

/// Solves load steps with Coulomb friction on finer and finer meshes, until the relative residual of every step is at most the target, see
/// [`solve_steps_adaptively`].
///
/// # Errors
/// See [`solve_steps_adaptively`] and [`crate::solve_coulomb`].
pub fn solve_coulomb_steps_adaptively<S: ContactSpace>(
    problem: ContactProblem<S>,
    factors: &[StepFactors<'_>],
    checkpoint: Option<Checkpoint>,
    settings: &(CoulombSettings, Relaxation),
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSteps<CoulombResult<S>, S>, SolveError<S>> {
    run(problem, checkpoint, &InSteps { method: settings, factors }, adapt, observer)
}

/// Starts a run, or resumes it.
fn run<S: ContactSpace, M: SolveOnMesh<S>>(
    problem: ContactProblem<S>,
    checkpoint: Option<Checkpoint>,
    method: &M,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<M::Solution, S>, SolveError<S>> {
    match checkpoint {
        None => begin(problem, method, adapt, observer),
        Some(checkpoint) => resume(problem, checkpoint, method, adapt, observer),
    }
}

/// Starts a run on its first mesh.
fn begin<S: ContactSpace, M: SolveOnMesh<S>>(
    problem: ContactProblem<S>,
    method: &M,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<M::Solution, S>, SolveError<S>> {
    let solution = method.solve(problem, None, observer)?;
    follow(Course::new::<M>(solution)?, None, method, adapt, observer)
}

/// Resumes a run with the last mesh of its checkpoint that can be solved.
fn resume<S: ContactSpace, M: SolveOnMesh<S>>(
    problem: ContactProblem<S>,
    checkpoint: Checkpoint,
    method: &M,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<M::Solution, S>, SolveError<S>> {
    let mut record = checkpoint;
    if record.history.len() != record.meshes.len() {
        return Err(SolveError::Checkpoint { what: "it does not have one row per mesh solved" });
    }
    observer.phase(Phase::Refinement);
    while !record.meshes.is_empty() {
        let step = record.meshes.len() + 1;
        let (finer, cuts) = record.replay(&problem, step)?;
        if observer.fits_in_memory(&finer) {
            let start = record.start_of(step)?.clone();
            match method.solve(finer, Some((record.role_reason, start)), observer) {
                Ok(solution) => {
                    let course = Course { solution, cuts, record, best: None };
                    return follow(course, Some(&problem), method, adapt, observer);
                }
                Err(SolveError::Stopped) => return Err(SolveError::Stopped),
                Err(_) => {}
            }
        }
        record.step_back();
    }
    begin(problem, method, adapt, observer)
}

/// An adaptive run whose current mesh has just been solved.
struct Course<A, S: ContactSpace> {
    solution: A,
    cuts: S::Cuts,
    /// History of the meshes before the current one.
    record: Checkpoint,
    /// An earlier solution that is better than all later ones, and its step.
    best: Option<(usize, A)>,
}

impl<A, S: ContactSpace> Course<A, S> {
    /// Starts with the solution on the first mesh.
    fn new<M: SolveOnMesh<S, Solution = A>>(solution: A) -> Result<Self, SolveError<S>> {
        let problem = M::problem(&solution);
        let (cuts, roles) = (S::cuts(problem)?, problem.roles());
        let role_reason = M::role_reason(&solution);
        let record = Checkpoint { roles, role_reason, meshes: Vec::new(), history: Vec::new() };
        Ok(Self { solution, cuts, record, best: None })
    }
}

/// Refines and solves until there is a reason to end.
///
/// * `first`: the problem on its first mesh, if the run was resumed.
fn follow<S: ContactSpace, M: SolveOnMesh<S>>(
    course: Course<M::Solution, S>,
    first: Option<&ContactProblem<S>>,
    method: &M,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Result<AdaptiveSolution<M::Solution, S>, SolveError<S>> {
    let Course { mut solution, mut cuts, mut record, mut best } = course;
    let end = loop {
        let step = M::step(&solution, record.history.len() + 1);
        record.history.push(step);
        M::tell(observer, &step, &solution);
        if let Some(end) = ended(&step, &solution, method, adapt, observer) {
            break end;
        }
        if rose_twice(&record.history) {
            break AdaptiveEnd::Rose;
        }
        // Mark and refine; carry λ and the active set over.
        observer.phase(Phase::Refinement);
        let problem = M::problem(&solution);
        let contributions = refine::contributions(problem, &M::estimates(&solution));
        let of_mesh = (problem, contributions.as_slice());
        let wanted = refine::next_size(of_mesh, step.measured(), adapt.target, adapt.max_nodes);
        let from = (problem, contributions, M::last(&solution));
        let Finer { problem, cuts: finer_cuts, rounds, start } =
            match refine::refine(from, &cuts, adapt.fraction, wanted, adapt.max_nodes) {
                Ok(Refined::Finer(finer)) => *finer,
                Ok(Refined::NothingToRefine) => break AdaptiveEnd::IterationError,
                Ok(Refined::OutOfMemory) => break AdaptiveEnd::MaxNodes,
                Err(error) => break AdaptiveEnd::Failed(error.into()),
            };
        if !observer.fits_in_memory(&problem) {
            let nodes = problem.nodes();
            break AdaptiveEnd::OutOfMemory { nodes };
        }
        record.meshes.push(FinerMesh { rounds, start: start.clone() });
        observer.checkpoint(&record);
        if observer.should_stop() {
            break AdaptiveEnd::Interrupted;
        }
        // Solve and estimate.
        let finer = match method.solve(problem, Some((record.role_reason, start)), observer) {
            Ok(finer) => finer,
            Err(SolveError::Stopped) => break AdaptiveEnd::Interrupted,
            Err(error) => break AdaptiveEnd::Failed(error),
        };
        cuts = finer_cuts;
        let coarser = std::mem::replace(&mut solution, finer);
        let next = M::step(&solution, step.step + 1);
        if best_step(record.history.iter().chain([&next])) == Some(step.step) {
            best = Some((step.step, coarser));
        }
    };
    let end = match end {
        AdaptiveEnd::MaxNodes | AdaptiveEnd::IterationError
            if record.history.last().is_none_or(|step| !step.is_sound()) =>
        {
            AdaptiveEnd::NotCertified { failed: failed_checks(&M::estimates(&solution)) }
        }
        end => end,
    };
    let step = best_step(&record.history).unwrap_or(record.history.len());
    let solution = match (best, first) {
        _ if step == record.history.len() => solution,
        (Some((kept, better)), _) if kept == step => better,
        // It was solved before the run was resumed.
        (_, Some(first)) => solve_step(first, &record, step, method)?,
        _ => solution,
    };
    Ok(AdaptiveSolution { solution, step, history: record.history, end })
}

/// Solves the mesh of an earlier step again.
fn solve_step<S: ContactSpace, M: SolveOnMesh<S>>(
    first: &ContactProblem<S>,
    record: &Checkpoint,
    step: usize,
    method: &M,
) -> Result<M::Solution, SolveError<S>> {
    if step == 1 {
        return method.solve(first.clone(), None, &mut Silent);
    }
    let (problem, _) = record.replay(first, step)?;
    let start = record.start_of(step)?.clone();
    method.solve(problem, Some((record.role_reason, start)), &mut Silent)
}

/// Finds the first step with the smallest valid bound or residual.
fn best_step<'a>(history: impl IntoIterator<Item = &'a Step>) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for step in history {
        let bound = step.measured().or(step.e_cre).or(step.e_b).filter(|_| step.is_sound());
        if let Some(bound) = bound
            && best.is_none_or(|(_, least)| bound < least)
        {
            best = Some((step.step, bound));
        }
    }
    best.map(|(step, _)| step)
}

/// Tells whether the relative bound or residual rose on each of the last two meshes.
fn rose_twice(history: &[Step]) -> bool {
    let Some(last) = history.last_chunk::<3>() else { return false };
    let measured = last.map(|step| step.measured().filter(|_| step.is_sound()));
    matches!(measured, [Some(first), Some(second), Some(third)] if first < second && second < third)
}

/// Computes the allowance for round-off over the energy norm, the largest of all load steps in which there is strain energy; 0 without either.
fn floor<S: ContactSpace>(estimates: &[&Estimate<S>]) -> f64 {
    let counts = |e: &&&Estimate<S>| estimates.len() == 1 || !e.holds_no_energy();
    let relative = estimates.iter().filter(counts).map(|e| e.round_off / e.energy_norm());
    relative.filter(|floor| floor.is_finite()).fold(0.0, f64::max)
}

/// Lists the checks of the bound that fail, those of the first load step with any; none if there is no bound.
fn failed_checks<S: ContactSpace>(estimates: &[&Estimate<S>]) -> Vec<(&'static str, f64)> {
    let failed = estimates.iter().map(|e| e.admissibility.failed().collect::<Vec<_>>());
    failed.into_iter().find(|failed| !failed.is_empty()).unwrap_or_default()
}

/// Decides whether the mesh just solved is the last one.
fn ended<S: ContactSpace, M: SolveOnMesh<S>>(
    step: &Step,
    solution: &M::Solution,
    method: &M,
    adapt: &AdaptSettings,
    observer: &mut dyn Observer<S>,
) -> Option<AdaptiveEnd<S>> {
    let (problem, estimates) = (M::problem(solution), M::estimates(solution));
    if let Some(end) = M::cut_short(solution) {
        return Some(end);
    }
    if !step.is_sound() {
        let failed = failed_checks(&estimates);
        // On these meshes no pressure keeps a body in balance; on finer ones there may be one.
        // Then the stress is not in equilibrium either.
        let of_stress = ["rigid_balance", "boundary_traction", "equilibrium", "traction_jump"];
        let of_balance = |(name, _): &(&str, f64)| of_stress.contains(name);
        let finer = failed.iter().any(|(name, _)| *name == "rigid_balance") && failed.iter().all(of_balance);
        let allowed = step.step < adapt.max_steps && refine::has_room(step.nodes, adapt.max_nodes);
        if finer && allowed {
            return observer.should_stop().then_some(AdaptiveEnd::Interrupted);
        }
        return Some(AdaptiveEnd::NotCertified { failed });
    }
    if method.meets(step, solution, adapt.target) {
        return Some(AdaptiveEnd::TargetMet);
    }
    if let Some(end) = method.unsolved(solution) {
        return Some(end);
    }
    let floor = floor(&estimates);
    if floor > adapt.target {
        return Some(AdaptiveEnd::RoundOff { floor });
    }
    if refine::mesh_share(problem, &estimates) < LEAST_SHARE {
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

#[cfg(test)]
mod tests;

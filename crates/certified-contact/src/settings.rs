//! Settings of a solve: roles, method, and the criteria to stop.

use crate::error::SolveError;
use cre_estimator::Relaxation;
use fem_core::body::Body;
use fem_core::boundary::ScalarData;
use fem_core::interface::{ContactPair, ContactProblem};
use fem_core::space::{Plane, Space};
use fem_core::subdomains::may_be_cut;
use nndd::{Method, NewtonSettings};

/// Which body carries λ, the paper's Ω₁.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Imposed {
    /// The first body.
    First,
    /// The second body.
    Second,
    /// The stiffer one under a uniform pressure on the interface.
    #[default]
    Auto,
}

/// When the iteration stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// `η_NNDD ≤ ratio · η_dis`: the iteration error is small compared with the mesh error. An
    /// `η_dis` above `e_CRE` is replaced by `e_CRE`.
    Estimator {
        /// The ratio.
        ratio: f64,
        /// If given, also `|F₁ − F₂| ≤ force_balance · max(|F₁|, |F₂|)` or round-off, with the contact forces
        /// [`nndd::Iterate::contact_forces`] of the two bodies.
        force_balance: Option<f64>,
    },
    /// `ε_t ≤ tolerance`, the paper's precision. It does not bound the error; prefer `Estimator`.
    Precision {
        /// The tolerance.
        tolerance: f64,
    },
    /// `η_NNDD ≤ tolerance · η_NNDD(1)`.
    EtaNndd {
        /// The tolerance.
        tolerance: f64,
    },
    /// A fixed number of iterations.
    Iterations,
}

impl Default for Criterion {
    /// `η_NNDD ≤ 0.01 η_dis`, and contact forces that agree to 0.1 %.
    fn default() -> Self {
        Self::Estimator { ratio: 0.01, force_balance: Some(1e-3) }
    }
}

/// Settings of [`crate::solve`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Settings<S: Space = Plane> {
    /// Which body carries λ.
    pub imposed: Imposed,
    /// Which body of each pair carries λ, if not the one that `imposed` says; missing entries count as `None`.
    pub imposed_by_pair: Vec<Option<Imposed>>,
    /// The algorithm, with its settings.
    pub method: Method,
    /// The exact solution is used instead where it is faster, see [`prefers_exact`]; `None`: `method` is used for every problem.
    pub exact: Option<NewtonSettings>,
    /// The number of subdomains of each body that has no rigid side and no cut; 1: bodies stay in one piece. More than one is for
    /// problems without friction, and Newton's method with Neumann-Neumann steps inside solves them.
    pub subdomains: usize,
    /// Such a body is cut into more subdomains if each would have more nodes than this: a power of two, since halves are compact.
    pub subdomain_nodes: usize,
    /// The estimator of solids computes its coefficients again in each sweep: about a fifth of their memory, and two to three times the time of an estimate, see
    /// [`StarMemory`](cre_estimator::StarMemory).
    pub recomputes: bool,
    /// Initial λ: normal displacement along the contact normal out of the body that carries it, m.
    pub lambda: ScalarData<S>,
    /// When to stop.
    pub criterion: Criterion,
    /// How far the equilibrated stresses are relaxed, [`Relaxation`]: a fixed number of steps, or until little is left to gain. The bound is strict
    /// after every step. Default: until less than 2 % is left to gain, at most 100 steps.
    pub relaxation: Relaxation,
    /// Estimate after this many iterations each time; 0: only when the criterion needs it, and at the end.
    pub estimate_every: usize,
}

impl<S: Space> Settings<S> {
    /// Sets the algorithm for every problem: [`nndd::NnddSettings`] or [`nndd::NewtonSettings`].
    #[must_use]
    pub fn with_method(mut self, method: impl Into<Method>) -> Self {
        (self.method, self.exact) = (method.into(), None);
        self
    }

    /// Returns the algorithm that is used for a problem.
    pub fn method_for(&self, problem: &ContactProblem<S>) -> Method {
        let cut = problem.bodies.iter().any(|body| self.subdomains_of_body(body) > 1);
        match &self.exact {
            Some(exact) if !cut && prefers_exact(problem) => exact.clone().into(),
            _ => self.method.clone(),
        }
    }

    /// Returns the number of subdomains of each body of a problem.
    ///
    /// # Errors
    /// [`SolveError::Subdomains`] if they are asked for with another method than Newton's with Neumann-Neumann steps inside, with friction, or with a given
    /// force in a cut.
    pub fn subdomains_of(&self, problem: &ContactProblem<S>) -> Result<Vec<usize>, SolveError<S>> {
        let counts: Vec<usize> = problem.bodies.iter().map(|body| self.subdomains_of_body(body)).collect();
        if counts.iter().all(|count| *count == 1) {
            return Ok(counts);
        }
        let reason = if !matches!(self.method, Method::NewtonNn(_)) {
            Some("another method than newton-nn")
        } else if problem.has_friction() {
            Some("friction")
        } else if problem.bodies.iter().any(Body::has_cut_forces) {
            Some("a given force in a cut")
        } else {
            None
        };
        reason.map_or(Ok(counts), |with| Err(SolveError::Subdomains { with }))
    }

    fn subdomains_of_body(&self, body: &Body<S>) -> usize {
        let nodes = body.mesh().points().len();
        if may_be_cut(body) { subdomains(nodes, self.subdomains, self.subdomain_nodes) } else { 1 }
    }
}

/// Computes the number of subdomains of a body that may be cut.
///
/// * `least`, `most`: see [`Settings::subdomains`] and [`Settings::subdomain_nodes`], in the mean.
pub fn subdomains(nodes: usize, least: usize, most: usize) -> usize {
    nodes.div_ceil(most.max(1)).next_power_of_two().max(least)
}

/// Up to this many rows of a body, in the mean, the exact solution of an assembly is faster than Newton's method with Neumann-Neumann steps
/// inside. Measured on stacks and walls of 3 to 288 bodies: at 38 rows it takes a third of the time, at 60 as long or less, at 162 twice as long.
const FEW_ROWS: usize = 100;

/// Tells whether a problem is left to the exact solution unless a method is named: one with friction, one with obstacles, one with a pair
/// within a bonded body, one with a given force in a cut, and an assembly whose
/// bodies have few rows each, unless it is the paper's problem.
pub fn prefers_exact<S: Space>(problem: &ContactProblem<S>) -> bool {
    // Most rows are those of two bodies.
    let few = 2 * problem.node_pairs() <= FEW_ROWS * problem.bodies.len();
    // Measured on one body above 1 to 64 obstacles, and on beams on rollers: with few rows newton-nn takes four times as long, with 642 to 1752 half
    // as long to twice as long.
    let on_obstacles = !problem.obstacles.is_empty();
    // The shortening is found for the exact solution.
    let tightened = problem.bodies.iter().any(Body::has_cut_forces);
    let within = problem.contacts.iter().any(ContactPair::<S>::is_within_a_body);
    within || tightened || problem.has_friction() || (few || on_obstacles) && !suits_iteration(problem)
}

/// Tells whether a problem is the paper's: one pair without friction, of two bodies that their supports hold, apart from its nodes along the
/// normal. Bodies that touch nothing do not count.
pub fn suits_iteration<S: Space>(problem: &ContactProblem<S>) -> bool {
    let held = |b: &usize| problem.bodies[*b].free_motion().is_none();
    problem.plain_pair().is_some_and(|pair| pair.bodies().is_some_and(|both| both.iter().all(held)))
}

impl<S: Space> Default for Settings<S> {
    fn default() -> Self {
        Self {
            imposed: Imposed::default(),
            imposed_by_pair: Vec::new(),
            method: Method::default(),
            exact: Some(NewtonSettings::default()),
            subdomains: 1,
            subdomain_nodes: usize::MAX,
            recomputes: false,
            lambda: 0.0.into(),
            criterion: Criterion::default(),
            relaxation: Relaxation::default(),
            estimate_every: 0,
        }
    }
}

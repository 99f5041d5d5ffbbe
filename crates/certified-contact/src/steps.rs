//! Load steps: what friction does depends on the path of the loads, not only on their last values.
//!
//! In every step the law of friction holds for the slip of that step, `w − w₀`, with the slip `w₀` that the earlier steps left. All else is as in
//! one step. So the bound holds for the increment of its step, from the computed `w₀`: the error that the steps accumulate has no bound.

use crate::coulomb::CoulombResult;
use crate::error::SolveError;
use crate::observer::Observer;
use crate::settings::Settings;
use crate::solution::CertifiedSolution;
use crate::solve::{Previous, solve_step};
use crate::solve_coulomb::solve_coulomb_step;
use cre_estimator::{Estimate, Relaxation};
use fem_core::body::ConditionPlace;
use fem_core::condensation::CondensedBody;
use fem_core::interface::{ContactFacet, ContactProblem, SlipBefore};
use nndd::{CoulombSettings, CoulombStart, CoulombStatus, Start};

/// Load steps on one mesh. Each begins with the slip that the solved ones left; a step that fails changes nothing.
///
/// # Example
/// A block is pressed onto another one, and then pushed aside. Friction holds it: the second step has no slip at the left end.
/// ```
/// use certified_contact::{LoadSteps, Settings, Silent};
/// use fem_core::{body::{Body, ConditionList}, boundary::BoundaryConditions, interface::{ContactProblem, Friction, Gap},
///     material::{Hypothesis, LinearElastic}, mesh::generate::block};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
/// let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [8, 4])?, steel.clone(), &BoundaryConditions::new()
///     .displace("top", None, Some((-0.02).into())).displace("top", Some(0.004.into()), None))?;
/// let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [8, 4])?, steel, &BoundaryConditions::new().fix("bottom"))?;
/// let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
/// let problem = ContactProblem::between([upper, lower], interface).with_friction(0, Friction::tresca(8.0))?;
/// let mut steps = LoadSteps::new(problem);
/// // The second condition of the first body pushes.
/// let push = |amount: f64| move |body, place: fem_core::body::ConditionPlace|
///     if (body, place.list, place.index) == (0, ConditionList::Displacement, 1) { amount } else { 1.0 };
/// let pressed = steps.solve(push(0.0), &Settings::default(), &mut Silent)?;
/// let pushed = steps.solve(push(1.0), &Settings::default(), &mut Silent)?;
/// assert!(pressed.is_certified() && pushed.is_certified() && steps.count() == 2);
/// # Ok(()) }
/// ```
///
/// The bodies are factorised once, as long as their supports are the same. Each step starts from the solution of the one before.
#[derive(Clone, Debug)]
pub struct LoadSteps {
    problem: ContactProblem,
    count: usize,
    /// Of the last step that was solved.
    bodies: Vec<CondensedBody>,
    start: Option<Start>,
    coulomb_start: Option<CoulombStart>,
}

impl LoadSteps {
    /// Starts from rest.
    ///
    /// * `problem`: its conditions with the factor 1.
    pub fn new(problem: ContactProblem) -> Self {
        Self { problem, count: 0, bodies: Vec::new(), start: None, coulomb_start: None }
    }

    /// Counts the steps that were solved.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Solves and certifies the next step.
    ///
    /// * `factor`: of each condition of each body at the end of the step; gaps, obstacles and body forces have none.
    ///
    /// # Errors
    /// See [`crate::solve`]; conditions that contradict each other with these factors.
    pub fn solve(
        &mut self,
        factor: impl Fn(usize, ConditionPlace) -> f64,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<CertifiedSolution, SolveError> {
        let problem = self.next(&factor)?;
        let previous = Previous { bodies: std::mem::take(&mut self.bodies), start: self.start.clone() };
        let (solution, bodies) = solve_step(problem, previous, settings, observer)?;
        self.bodies = bodies;
        if let (true, Some(estimate)) = (solution.is_certified(), &solution.estimate) {
            let last = solution.last();
            let lambda = solution.problem.by_row(&last.lambda, &last.tangential.lambda);
            self.start = Some(Start { lambda, active: Some(last.contact.active.clone()) });
            let slip = &last.tangential.slip;
            self.take(estimate, solution.problem.tangential_blocks().map(|of| &slip[of]))?;
        }
        Ok(solution)
    }

    /// Solves the next step of a problem with Coulomb friction.
    ///
    /// * `factor`: as in [`Self::solve`].
    ///
    /// # Errors
    /// See [`crate::solve_coulomb`]; conditions that contradict each other with these factors.
    pub fn solve_coulomb(
        &mut self,
        factor: impl Fn(usize, ConditionPlace) -> f64,
        settings: &CoulombSettings,
        relaxation: Relaxation,
        observer: &mut dyn Observer,
    ) -> Result<CoulombResult, SolveError> {
        let problem = self.next(&factor)?;
        let bodies = std::mem::take(&mut self.bodies);
        let previous = Previous { bodies, start: self.coulomb_start.clone() };
        let (result, bodies) = solve_coulomb_step(problem, previous, settings, relaxation, observer)?;
        self.bodies = bodies;
        if result.solution.status == CoulombStatus::Converged {
            self.coulomb_start = Some(result.solution.start.clone());
            let slip = result.solution.exact.friction.iter().map(|of| of.slip.as_slice());
            self.take(result.estimate(), slip)?;
        }
        Ok(result)
    }

    fn next(&self, factor: &dyn Fn(usize, ConditionPlace) -> f64) -> Result<ContactProblem, SolveError> {
        Ok(self.problem.with_factors(factor)?)
    }

    /// Adds the slip of a step to the slip of the earlier ones.
    ///
    /// * `slip`: at the pairs of nodes of each pair, m; empty without friction.
    fn take<'a>(
        &mut self,
        estimate: &Estimate,
        slip: impl Iterator<Item = &'a [f64]>,
    ) -> Result<(), SolveError> {
        let mut problem = self.problem.clone();
        for (k, (slip, contact)) in slip.zip(&estimate.pair.contacts).enumerate() {
            let pair = &problem.contacts[k];
            if !pair.friction.acts() {
                continue;
            }
            let mut edges = contact.edge_friction.slip.clone();
            for (edge, of_fields) in pair.interface.facets().iter().zip(&mut edges) {
                settle(edge, slip, of_fields);
            }
            let mut sum = SlipBefore::new(slip.to_vec(), edges);
            if let Some(before) = &pair.slip_before {
                sum.nodes.iter_mut().zip(&before.nodes).for_each(|(sum, w)| *sum += w);
                let edges = sum.edges.as_flattened_mut().iter_mut().zip(before.edges.as_flattened());
                edges.for_each(|(sum, w)| *sum += w);
            }
            problem = problem.with_slip(k, sum)?;
        }
        self.problem = problem;
        self.count += 1;
        Ok(())
    }
}

/// Gives the slip of the fields along an edge the one of the pairs of nodes at its ends: nodes that stick have none. The rounding of
/// the fields would be all there is if the next step takes the loads off.
///
/// * `slip`: at the pairs of nodes, m; `of_fields`: Bernstein coefficients along the edge, m.
fn settle(edge: &ContactFacet, slip: &[f64], of_fields: &mut [f64; 3]) {
    let before = *of_fields;
    for end in edge.free_corners() {
        of_fields[2 * end] = slip[edge.pairs[end] as usize];
    }
    let [first, _, last] = *of_fields;
    // The slip is linear along a straight edge.
    of_fields[1] = match edge.bent {
        true => before[1] + 0.5 * (first - before[0] + last - before[2]),
        false => 0.5 * (first + last),
    };
}

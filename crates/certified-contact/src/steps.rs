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
use crate::space::ContactSpace;
use cre_estimator::{Estimate, Relaxation};
use fem_core::body::ConditionPlace;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactFacet, ContactPair, ContactProblem, SlipBefore};
use fem_core::prepared::FactorisedBody;
use fem_core::space::{Plane, Space};
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
pub struct LoadSteps<S: Space = Plane> {
    problem: ContactProblem<S>,
    /// The factor of the gap of each pair in the next steps.
    of_gaps: Vec<f64>,
    count: usize,
    /// Of the last step that was solved.
    bodies: Vec<FactorisedBody<S>>,
    start: Option<Start>,
    coulomb_start: Option<CoulombStart>,
}

impl<S: ContactSpace> LoadSteps<S> {
    /// Starts from rest.
    ///
    /// * `problem`: its conditions with the factor 1.
    pub fn new(problem: ContactProblem<S>) -> Self {
        let of_gaps = vec![1.0; problem.contacts.len()];
        Self { problem, of_gaps, count: 0, bodies: Vec::new(), start: None, coulomb_start: None }
    }

    /// Counts the steps that were solved.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Starts the iteration of the next step from these values.
    pub(crate) fn start_from(&mut self, start: Start) {
        self.start = Some(start);
    }

    /// Multiplies the gaps of the pairs in the next steps; at first by 1.
    ///
    /// * `factors`: one per pair, of its gap as it is posed.
    ///
    /// # Panics
    /// If there is not one factor per pair.
    pub fn scale_gaps(&mut self, factors: Vec<f64>) {
        let (found, expected) = (factors.len(), self.problem.contacts.len());
        assert!(found == expected, "{found} factors of gaps are given, the problem has {expected} pairs");
        self.of_gaps = factors;
    }

    /// Solves and certifies the next step.
    ///
    /// * `factor`: of each condition of each body at the end of the step; obstacles and body forces have none. Gaps: [`Self::scale_gaps`].
    ///
    /// # Errors
    /// See [`crate::solve`]; conditions that contradict each other with these factors.
    pub fn solve(
        &mut self,
        factor: impl Fn(usize, ConditionPlace) -> f64,
        settings: &Settings<S>,
        observer: &mut dyn Observer<S>,
    ) -> Result<CertifiedSolution<S>, SolveError<S>> {
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
        observer: &mut dyn Observer<S>,
    ) -> Result<CoulombResult<S>, SolveError<S>> {
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

    fn next(
        &self,
        factor: &dyn Fn(usize, ConditionPlace) -> f64,
    ) -> Result<ContactProblem<S>, SolveError<S>> {
        Ok(self.problem.with_factors(factor, &|pair| self.of_gaps[pair])?)
    }

    /// Adds the slip of a step to the slip of the earlier ones.
    ///
    /// * `slip`: at the pairs of nodes of each pair, m; empty without friction.
    fn take<'a>(
        &mut self,
        estimate: &Estimate<S>,
        slip: impl Iterator<Item = &'a [f64]>,
    ) -> Result<(), SolveError<S>> {
        let mut problem = self.problem.clone();
        for (k, (slip, contact)) in slip.zip(&estimate.pair.contacts).enumerate() {
            let pair = &problem.contacts[k];
            if !pair.friction.acts() {
                continue;
            }
            let mut jumps = contact.facet_friction.jump.clone();
            for (facet, jump) in pair.interface.facets().iter().zip(&mut jumps) {
                settle(pair, facet, slip, jump);
            }
            let mut sum = SlipBefore::new(slip.to_vec(), jumps);
            if let Some(before) = &pair.slip_before {
                sum.rows.iter_mut().zip(&before.rows).for_each(|(sum, w)| *sum += w);
                let jumps: &mut [S::Axes<S::Vector>] = &mut sum.jumps;
                for (sum, before) in jumps.iter_mut().zip(&before.jumps) {
                    *sum = S::axes(|corner| sum[corner] + before[corner]);
                }
            }
            problem = problem.with_slip(k, sum)?;
        }
        self.problem = problem;
        self.count += 1;
        Ok(())
    }
}

/// Gives the jump of the fields on a facet the slip of the pairs of nodes at its corners: nodes that stick have none. The rounding of
/// the fields would be all there is if the next step takes the loads off.
///
/// * `slip`: in the rows along tangents, m; `jump`: at the corners of the facet, m.
fn settle<S: Space>(
    pair: &ContactPair<S>,
    facet: &ContactFacet<S>,
    slip: &[f64],
    jump: &mut S::Axes<S::Vector>,
) {
    let of_fields = *jump;
    for corner in facet.free_corners() {
        let k = facet.pairs[corner] as usize;
        let tangents = pair.tangents(k);
        let values = slip[k..].iter().step_by(pair.interface.pairs().len());
        for ((tangent, own), slip) in
            tangents.as_ref().iter().zip(pair.tangential_parts(k, of_fields[corner])).zip(values)
        {
            jump[corner] += *tangent * ((slip - own) / tangent.times(tangent));
        }
    }
}

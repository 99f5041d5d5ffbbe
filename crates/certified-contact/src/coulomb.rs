//! Coulomb friction: one solution of the discrete problem, and a residual. Nothing here is a certificate: no bound of the error is known.

use crate::error::in_bodies;
use crate::history::{IterationRecord, Step};
use crate::results::Results;
use cre_estimator::Estimate;
use fem_core::interface::ContactProblem;
use fem_core::prepared::AssemblyMotion;
use fem_core::space::{Plane, Space};
use nndd::{CoulombSolution, Iterate, NodeState};

/// The conditional estimate is not made beyond this coupling: near 1 it has no digits.
const LARGEST_COUPLING: f64 = 0.9;

/// One solution of a discrete problem with Coulomb friction, with the residual of its equations. See [`crate::theory`], (34) and (35).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CoulombResult<S: Space = Plane> {
    /// The problem passed in.
    pub problem: ContactProblem<S>,
    /// The solution of the discrete problem, and how the fixed point ended.
    pub solution: CoulombSolution,
    pub(crate) displacement: Vec<Vec<S::Vector>>,
    /// The solution as an iterate.
    pub last: Iterate,
    /// The quantities of interest.
    pub results: Results<S>,
    /// Unknowns of each body.
    pub unknowns: Vec<usize>,
    pub(crate) estimate: Estimate<S>,
    pub(crate) one_sign: bool,
    pub(crate) kappa: Option<f64>,
    pub(crate) coupling: Option<f64>,
}

impl<S: Space> CoulombResult<S> {
    /// Returns the displacements of each body, Cartesian, m.
    pub fn displacement(&self) -> &[Vec<S::Vector>] {
        &self.displacement[..self.problem.bodies.len()]
    }

    /// Returns the state of each pair of nodes.
    pub fn states(&self) -> impl Iterator<Item = &[NodeState]> {
        self.solution.exact.friction.iter().map(|of| of.state.as_slice())
    }

    /// Returns the motion that friction with the pressures found does not resist, with the load that is left along it; `None` unless the limits of
    /// friction were too small in the end. Other pressures may hold the bodies: that is not known.
    pub fn unresisted(&self) -> Option<AssemblyMotion<S>> {
        Some(in_bodies(&self.problem, self.solution.unresisted.as_ref()?))
    }

    /// Returns the equilibrated stresses and the admissible pair behind the residual. There is no [`Estimate::certificate`] of it.
    pub fn estimate(&self) -> &Estimate<S> {
        &self.estimate
    }

    /// Returns the solution as the only row of a history, without a bound.
    pub fn row(&self) -> IterationRecord {
        IterationRecord::new(&self.last, &self.problem)
    }

    /// Sums up the solution as a step of an adaptive run.
    ///
    /// * `step`: its number, from 1.
    pub(crate) fn step(&self, step: usize) -> Step {
        Step {
            step,
            nodes: self.problem.nodes(),
            pairs: self.problem.node_pairs(),
            load_step: None,
            e_cre: None,
            relative: None,
            certified: false,
            e_b: self.residual(),
            relative_residual: self.relative_residual(),
            iterations: self.solution.steps,
            energy_norm_squared: Some(self.estimate.energy_norm_squared.iter().sum()),
            peak_stress: self.results.peak_stress.map(|peak| peak.von_mises),
        }
    }

    /// Computes the energy norm of the displacements, square root of J/m.
    pub fn energy_norm(&self) -> f64 {
        self.estimate.energy_norm()
    }

    /// Returns the residual `e_b`, square root of J/m: zero only for an exact solution, and **no bound** of the error. `None` if a check of
    /// its stresses failed.
    pub fn residual(&self) -> Option<f64> {
        self.estimate.for_frozen_limit().map(|found| found.e_cre)
    }

    /// Returns the residual over the energy norm; `None` without one, or without strain energy.
    pub fn relative_residual(&self) -> Option<f64> {
        self.estimate.over_norm(self.residual()?)
    }

    /// Returns the bound of the distance to the solution of *another* problem: with Tresca friction whose limit is
    /// [`Self::frozen_limit`]. It is the same number as [`Self::residual`]. `None` if a contact line with Coulomb friction is bent: there
    /// the limit of that problem is constant along each edge, and not given by its values at the pairs of nodes.
    pub fn bound_for_frozen_limit(&self) -> Option<f64> {
        let coulomb = self.problem.contacts.iter().filter(|pair| pair.friction.coulomb().is_some());
        let straight = coulomb.into_iter().all(|pair| !pair.interface.has_bent_facets());
        self.residual().filter(|_| straight)
    }

    /// Returns the limit of friction `s = μ p` at the pairs of nodes of each pair, Pa, for which [`Self::bound_for_frozen_limit`] holds; empty
    /// without friction.
    pub fn frozen_limit(&self) -> impl Iterator<Item = &[f64]> {
        self.estimate.pair.contacts.iter().map(|contact| contact.friction_limit.as_slice())
    }

    /// Tells whether all slips of each pair with Coulomb friction have one sign, open parts included.
    pub fn has_one_sign(&self) -> bool {
        self.one_sign
    }

    /// Returns the coupling `κ_h` between pressure and slip without the coefficients of friction, computed on this mesh; `None` if a pair
    /// slips in both directions, or no coefficient is positive.
    pub fn kappa(&self) -> Option<f64> {
        self.kappa
    }

    /// Returns the coupling `c` with the coefficients of friction, `c = μ κ_h` if they are equal, computed on this mesh; `None` if a pair
    /// slips in both directions.
    pub fn coupling(&self) -> Option<f64> {
        self.coupling
    }

    /// Returns `e_b/√(1 − c²)`, square root of J/m: an **estimate** of the error if the exact slips have the signs of the computed ones. It is no
    /// bound, since `κ` is computed on the mesh. `None` if a pair slips in both directions, or `c ≥ 0.9`.
    pub fn conditional_estimate(&self) -> Option<f64> {
        let c = self.coupling.filter(|c| *c < LARGEST_COUPLING)?;
        Some(self.residual()? / (1.0 - c * c).sqrt())
    }

    /// Returns the residuals of the checks of the stresses, with their names and the largest values that are round-off.
    pub fn checks(&self) -> [(&'static str, f64, f64); 10] {
        self.estimate.admissibility.checks()
    }

    /// Returns the contributions to the square of the residual of every triangle of each body, J/m: a finer mesh helps in the largest ones.
    pub fn by_cell(&self) -> &[Vec<f64>] {
        &self.estimate.cre.by_cell
    }
}

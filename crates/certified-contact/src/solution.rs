//! A certified solution and the quantities derived from it.

use crate::bounds::Bounds;
use crate::history::{IterationRecord, Step};
use crate::results::Results;
use cre_estimator::{Estimate, EstimatorError};
use fem_core::interface::{ContactProblem, Roles};
use fem_core::space::{Plane, Space};
use nndd::{Iterate, Method, NnddSolution};

/// Why this body carries λ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RoleReason {
    /// The settings said so.
    Given,
    /// It is the stiffer one: compliances `ℓᵀ S⁻¹ ℓ` of the two bodies under a uniform unit pressure, m³/N.
    Stiffer {
        /// In the order of the bodies passed in.
        compliance: [f64; 2],
    },
}

/// A solved problem and its certificate.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CertifiedSolution<S: Space = Plane> {
    /// The problem passed in, with the roles of the iteration.
    pub problem: ContactProblem<S>,
    /// Why this body carries λ.
    pub role_reason: RoleReason,
    /// The algorithm that was used.
    pub method: Method,
    /// The iteration.
    pub nndd: NnddSolution,
    /// One row per iteration.
    pub rows: Vec<IterationRecord>,
    /// The certificate of the last iteration; `None` if its numbers are not finite.
    pub estimate: Option<Estimate<S>>,
    /// Why the estimate is missing. `None` if it exists or if the run was stopped first.
    pub no_estimate: Option<EstimatorError>,
    /// Bounds of the exact solution's energies and contact force; `None` without estimate. They hold if
    /// [`Self::is_certified`].
    pub bounds: Option<Bounds>,
    /// The quantities of interest.
    pub results: Option<Results<S>>,
    /// Unknowns of each body.
    pub unknowns: Vec<usize>,
    /// Subdomains of each body; 1 of one in one piece. Bonded bodies are cut together.
    pub subdomains: Vec<usize>,
}

impl<S: Space> CertifiedSolution<S> {
    /// Tells which body of each pair carries λ.
    pub fn roles(&self) -> Vec<Roles> {
        self.problem.roles()
    }

    /// Returns the last iteration.
    pub fn last(&self) -> &Iterate {
        &self.nndd.last
    }

    /// Tells whether the bodies have no strain energy: see [`Estimate::holds_no_energy`].
    pub fn holds_no_energy(&self) -> bool {
        self.estimate.as_ref().is_some_and(Estimate::<S>::holds_no_energy)
    }

    /// Returns the certified relative error `e_CRE / √(a₁+a₂)`; `None` unless [`Self::is_certified`], or if the
    /// bodies have no strain energy.
    pub fn relative(&self) -> Option<f64> {
        let estimate = self.estimate.as_ref()?;
        estimate.over_norm(estimate.certificate()?.e_cre)
    }

    /// Returns a guaranteed bound of the error over the *exact* energy norm, `e_CRE / (√(a₁+a₂) − e_CRE)`;
    /// `None` if the difference is not positive, or unless [`Self::is_certified`].
    pub fn relative_guaranteed(&self) -> Option<f64> {
        let estimate = self.estimate.as_ref()?;
        let (norm, e_cre) = (estimate.energy_norm(), estimate.certificate()?.e_cre);
        (norm > e_cre).then(|| e_cre / (norm - e_cre))
    }

    /// Tells whether there is a certificate and its checks pass.
    pub fn is_certified(&self) -> bool {
        self.estimate.as_ref().is_some_and(|e| e.certificate().is_some())
    }

    /// Computes the allowance for round-off over the energy norm: no relative error below it can be certified.
    pub fn round_off(&self) -> f64 {
        self.estimate.as_ref().map_or(0.0, |e| {
            let norm = e.energy_norm();
            if norm > 0.0 { e.round_off / norm } else { 0.0 }
        })
    }

    /// Sums up the solution as a step of an adaptive run.
    ///
    /// * `step`: its number, from 1.
    pub(crate) fn step(&self, step: usize) -> Step {
        let estimate = self.estimate.as_ref();
        Step {
            step,
            nodes: self.problem.nodes(),
            pairs: self.problem.node_pairs(),
            load_step: None,
            e_cre: estimate.map(|e| e.unchecked().e_cre),
            relative: self.relative(),
            certified: self.is_certified(),
            e_b: None,
            relative_residual: None,
            iterations: self.rows.len(),
            energy_norm_squared: estimate.map(|e| e.energy_norm_squared.iter().sum()),
            peak_stress: self.results.as_ref().and_then(|r| r.peak_stress).map(|peak| peak.von_mises),
        }
    }
}

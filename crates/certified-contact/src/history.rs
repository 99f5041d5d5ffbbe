//! The history of a run.

use cre_estimator::Estimate;
use fem_core::interface::ContactProblem;
use fem_core::space::Space;
use nndd::{Iterate, IterationRow};

/// One iteration with its estimate, if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationRecord {
    /// The data of the iteration.
    pub iteration: IterationRow,
    /// The contact forces on the first and on the second bodies of the pairs, `∑ P_i |n_i|`, N/m, positive in compression: equal at the discrete
    /// solution.
    pub contact_forces: [f64; 2],
    /// The discretisation indicator, if it was computed.
    pub eta_dis: Option<f64>,
    /// The guaranteed bound of this iteration's pair, if it was computed.
    pub e_cre: Option<f64>,
}

impl IterationRecord {
    /// Creates the row of an iterate without estimate.
    pub(crate) fn new<S: Space>(iterate: &Iterate, problem: &ContactProblem<S>) -> Self {
        let mut contact_forces = [0.0; 2];
        let [first, second] = iterate.forces();
        for (pair, block) in problem.contacts.iter().zip(problem.blocks()) {
            let pressed = |forces: &[f64]| -> f64 {
                let of_pairs = pair.interface.pairs().iter().zip(&forces[block.clone()]);
                of_pairs.map(|(pair, force)| force * pair.normal_length()).fold(0.0, |sum, force| sum + force)
            };
            let by_side = pair.roles.by_side([0.0 - pressed(first), pressed(second)]);
            contact_forces.iter_mut().zip(by_side).for_each(|(sum, force)| *sum += force);
        }
        Self { iteration: iterate.into(), contact_forces, eta_dis: None, e_cre: None }
    }

    /// Copies the estimated values.
    pub(crate) fn take<S: Space>(&mut self, estimate: &Estimate<S>) {
        let found = estimate.unchecked();
        self.eta_dis = Some(found.eta_dis);
        self.e_cre = Some(found.e_cre);
        self.iteration.eta_nndd = self.iteration.eta_nndd.max(found.eta_nndd);
    }
}

/// One mesh of an adaptive run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Number, from 1.
    pub step: usize,
    /// Nodes of all bodies together.
    pub nodes: usize,
    /// Pairs on the interface.
    pub pairs: usize,
    /// In load steps the step, from 1, with the largest relative bound or residual: the step of the numbers below.
    pub load_step: Option<usize>,
    /// The guaranteed bound, if there is one.
    pub e_cre: Option<f64>,
    /// The bound over the energy norm; `None` if the bodies have no strain energy, or without a bound.
    pub relative: Option<f64>,
    /// True if the checks of the bound pass.
    pub certified: bool,
    /// With Coulomb friction, which has no bound: the residual of [`crate::CoulombResult::residual`], if there is one.
    pub e_b: Option<f64>,
    /// That residual over the energy norm.
    pub relative_residual: Option<f64>,
    /// Iterations on this mesh, of all load steps together.
    pub iterations: usize,
    /// `a(u, u)` of all bodies together, J/m.
    pub energy_norm_squared: Option<f64>,
    /// Largest von Mises stress of the recovered stress, Pa, in the last load step, if it is known.
    pub peak_stress: Option<f64>,
}

impl Step {
    /// Tells whether the checks of the stresses pass, so that the bound or the residual is one.
    pub(crate) fn is_sound(&self) -> bool {
        self.certified || self.e_b.is_some()
    }

    /// Returns the relative number that a target is compared with: the bound, with Coulomb friction the residual.
    pub(crate) fn measured(&self) -> Option<f64> {
        self.relative.or(self.relative_residual)
    }
}

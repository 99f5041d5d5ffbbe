//! Stopping criteria, called once per iteration with everything that is known.

use crate::iterate::Iterate;
use std::error::Error;

/// What to do after an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Continue.
    Continue,
    /// The criterion is met.
    Stop,
    /// The caller wants to end it, whatever the criterion says.
    Interrupt,
}

/// Decides after every iteration whether to continue.
pub trait StoppingCriterion {
    /// Looks at an iterate.
    ///
    /// # Errors
    /// Whatever prevents the decision; the iteration then ends with [`crate::NnddError::Criterion`].
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn Error + Send + Sync>>;

    /// Tells whether the criterion can ever be met. If not, a run that ends after its iterations has not failed.
    fn can_stop(&self) -> bool {
        true
    }

    /// Tells, after each inner iteration of [`crate::Method::NewtonNn`], whether the caller wants to end it: the iterate then is the last.
    fn is_interrupted(&mut self) -> bool {
        false
    }
}

/// Stops when the paper's precision `ε_t` is at most the tolerance. It does not bound the error: prefer [`EtaNndd`].
#[derive(Clone, Copy, Debug)]
pub struct Precision(pub f64);

impl StoppingCriterion for Precision {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn Error + Send + Sync>> {
        Ok(if iterate.precision <= self.0 { Decision::Stop } else { Decision::Continue })
    }
}

/// Stops when `η_NNDD ≤ tolerance · η_NNDD(1)`.
#[derive(Clone, Copy, Debug)]
pub struct EtaNndd {
    /// Requested reduction.
    pub tolerance: f64,
    first: Option<f64>,
}

impl EtaNndd {
    /// Creates the criterion.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, first: None }
    }
}

impl StoppingCriterion for EtaNndd {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn Error + Send + Sync>> {
        let first = *self.first.get_or_insert(iterate.eta_nndd);
        Ok(if iterate.eta_nndd <= self.tolerance * first { Decision::Stop } else { Decision::Continue })
    }
}

/// Never stops: the iteration ends after `max_iterations`.
#[derive(Clone, Copy, Debug)]
pub struct Never;

impl StoppingCriterion for Never {
    fn check(&mut self, _iterate: &Iterate) -> Result<Decision, Box<dyn Error + Send + Sync>> {
        Ok(Decision::Continue)
    }

    fn can_stop(&self) -> bool {
        false
    }
}

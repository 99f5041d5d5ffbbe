//! Settings of a solve: method, tolerances, limits.

use crate::error::QpError;

/// The method that finds the active set; the solution is polished on it in every case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum QpMethod {
    /// With a start: active sets from it, then Clarabel. Without: Clarabel, unless nothing is bounded.
    #[default]
    Auto,
    /// Always Clarabel; the polish then checks and corrects its active set; the start is not used.
    Clarabel,
    /// Active sets from the start, or from all unknowns between their bounds; Clarabel when they fail.
    ActiveSet,
}

/// The settings of [`solve_box`](crate::solve_box). Start from [`QpSettings::default`] and use the `with_`
/// functions.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct QpSettings {
    /// Method that finds the active set; default [`QpMethod::Auto`].
    pub method: QpMethod,
    /// Clarabel's absolute gap, relative gap and feasibility tolerance, on the problem scaled to `P_ii = 1` and a
    /// load of 1; dimensionless, default 1e-6. The polish makes the solution exact, so Clarabel only has to come
    /// close to the active set.
    pub tolerance: f64,
    /// Clarabel's static regularisation of its scaled KKT matrix; dimensionless, default 1e-12. Clarabel's own
    /// 1e-8 is too much for a tight tolerance.
    pub static_regularization: f64,
    /// Maximum iterations of Clarabel, and of the active-set steps that polish its solution; a descent has a limit of its own. Default 200.
    pub max_iterations: usize,
    /// Maximum number of active sets tried before Clarabel is called, including the start; default 50. The smaller
    /// of this and `max_iterations` applies.
    pub max_active_set_steps: usize,
    /// Largest [`KktResiduals::max`](crate::KktResiduals::max) of a solved problem;
    /// dimensionless, default 1e-12.
    pub kkt_tolerance: f64,
}

impl Default for QpSettings {
    fn default() -> Self {
        Self {
            method: QpMethod::Auto,
            tolerance: 1e-6,
            static_regularization: 1e-12,
            max_iterations: 200,
            max_active_set_steps: 50,
            kkt_tolerance: 1e-12,
        }
    }
}

impl QpSettings {
    /// Sets the method that finds the active set.
    #[must_use]
    pub fn with_method(self, method: QpMethod) -> Self {
        Self { method, ..self }
    }

    /// Begins with active sets if [`QpMethod::Auto`] would begin with Clarabel.
    #[must_use]
    pub fn active_sets_first(self) -> Self {
        let method = if self.method == QpMethod::Auto { QpMethod::ActiveSet } else { self.method };
        self.with_method(method)
    }

    /// Sets Clarabel's tolerance (> 0, dimensionless).
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Sets Clarabel's static regularisation (≥ 0, dimensionless).
    #[must_use]
    pub fn with_static_regularization(self, static_regularization: f64) -> Self {
        Self { static_regularization, ..self }
    }

    /// Sets the maximum iterations of each inner method.
    #[must_use]
    pub fn with_max_iterations(self, max_iterations: usize) -> Self {
        Self { max_iterations, ..self }
    }

    /// Sets the maximum number of active sets tried before Clarabel is called.
    #[must_use]
    pub fn with_max_active_set_steps(self, max_active_set_steps: usize) -> Self {
        Self { max_active_set_steps, ..self }
    }

    /// Sets the largest KKT residual of a solved problem (> 0, dimensionless).
    #[must_use]
    pub fn with_kkt_tolerance(self, kkt_tolerance: f64) -> Self {
        Self { kkt_tolerance, ..self }
    }

    /// Active sets tried before Clarabel solves the whole programme.
    pub(crate) fn step_limit(&self) -> usize {
        self.max_active_set_steps.min(self.max_iterations)
    }

    /// Checks the ranges.
    pub(crate) fn check(&self) -> Result<(), QpError> {
        let positive = [("tolerance", self.tolerance), ("kkt_tolerance", self.kkt_tolerance)];
        for (what, found) in positive {
            if !(found > 0.0 && found.is_finite()) {
                return Err(QpError::Setting { what, found, expected: "a positive finite number" });
            }
        }
        let found = self.static_regularization;
        if !(found >= 0.0 && found.is_finite()) {
            let what = "static_regularization";
            return Err(QpError::Setting { what, found, expected: "a finite number, not negative" });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_checked() {
        let good = QpSettings::default();
        assert_eq!(good.check(), Ok(()));
        for bad in [
            good.clone().with_tolerance(0.0),
            good.clone().with_tolerance(f64::NAN),
            good.clone().with_kkt_tolerance(f64::INFINITY),
            good.clone().with_static_regularization(-1e-12),
        ] {
            assert!(matches!(bad.check(), Err(QpError::Setting { .. })), "{bad:?}");
        }
    }
}

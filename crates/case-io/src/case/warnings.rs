//! What is allowed but probably not meant.

use super::{Case, Criterion, Method};
use crate::diagnostic::{Diagnostic, code};

/// From this ratio on P1 triangles lock noticeably in plane strain.
const LOCKING: f64 = 0.49;

/// From this ratio of moduli on round-off shows in the interface.
const MODULI: f64 = 1e6;

/// Settings that the interface Newton method does not use.
const NNDD_ONLY: [&str; 7] = ["imposed", "path", "theta", "weights", "acceleration", "lambda", "stop"];

impl Case {
    /// Lists what is allowed but probably not meant: materials that lock, settings without effect,
    /// slivers and cracks in meshes that were read.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let mut warnings = self.mesh_warnings();
        for material in self.materials.iter().filter(|m| m.poisson >= LOCKING) {
            let path = format!("materials.{}.poisson", material.name);
            let message = format!(
                "Poisson's ratio {} is nearly incompressible: linear triangles lock, and the certified error shows it",
                material.poisson
            );
            warnings.push(self.diagnostic(code::VALUE, &path, message));
        }
        if let (Some(a), Some(b)) = (self.material_of(0), self.material_of(1)) {
            let ratio = (a.young / b.young).max(b.young / a.young);
            if ratio > MODULI {
                let message = format!("the moduli of the two bodies differ by a factor of {ratio:.1e}");
                warnings.push(self.diagnostic(code::VALUE, "materials", message));
            }
        }
        for material in &self.materials {
            if self.bodies.iter().all(|b| b.material != material.name) {
                let message = format!("no body uses the material \"{}\"", material.name);
                warnings.push(self.diagnostic(
                    code::REFERENCE,
                    &format!("materials.{}", material.name),
                    message,
                ));
            }
        }
        let unused: Vec<&str> =
            NNDD_ONLY.into_iter().filter(|key| self.is_given(&format!("solver.{key}"))).collect();
        if self.solver.method == Method::Newton && !unused.is_empty() {
            let message = format!(
                "the Newton method uses only `max_iterations` and `qp`; it ignores `{}`",
                unused.join("`, `")
            );
            warnings.push(self.diagnostic(code::VALUE, "solver.method", message));
        }
        let criterion = self.solver.stop.criterion;
        if self.adapt.is_some() && self.solver.method == Method::Nndd && criterion != Criterion::Estimator {
            let message = format!(
                "an adaptive run with the criterion \"{criterion}\": the iteration may end long before or after its error is \
                 small against the mesh's; criterion = \"estimator\" compares the two"
            );
            warnings.push(self.diagnostic(code::VALUE, "solver.stop.criterion", message));
        }
        warnings
    }
}

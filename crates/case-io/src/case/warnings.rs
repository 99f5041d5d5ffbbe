//! Warnings: input that is allowed but probably not meant.

use super::{Acceleration, BodyCase, Case, Criterion, Dimension, Material, MaterialLaw, Method};
use crate::diagnostic::{Diagnostic, MOST_DIAGNOSTICS, code};
use std::collections::HashSet;

/// From this ratio on P1 triangles lock noticeably in plane strain.
const LOCKING: f64 = 0.49;

/// From this ratio of moduli on round-off shows in the interface.
const MODULI: f64 = 1e6;

/// Settings that the exact solution does not use.
const NNDD_ONLY: [&str; 6] = ["imposed", "theta", "weights", "acceleration", "lambda", "stop"];

impl<S: Dimension> Case<S> {
    /// Lists the keys of `[solver]` that only the iteration uses.
    pub fn iteration_settings(&self) -> &'static [&'static str] {
        &NNDD_ONLY
    }

    /// Lists the keys of `[solver]` that only the iteration uses and that this case gives.
    pub fn given_iteration_settings(&self) -> Vec<&'static str> {
        NNDD_ONLY.into_iter().filter(|key| self.is_given(&format!("solver.{key}"))).collect()
    }

    /// Lists the keys of `[solver]` that set the update of λ in the paper's iteration and that this case gives.
    pub fn given_update_settings(&self) -> Vec<&'static str> {
        let of_update = |key: &&str| ["theta", "weights", "acceleration"].contains(key);
        self.given_iteration_settings().into_iter().filter(of_update).collect()
    }

    /// Lists what is allowed but probably not meant: materials that lock, settings without effect,
    /// slivers and cracks in meshes that were read. At most [`MOST_DIAGNOSTICS`], the others are counted in one more.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let mut warnings = self.mesh_warnings();
        warnings.extend(self.material_warnings());
        warnings.extend(self.solver_warnings());
        warnings.extend(self.step_warnings());
        let omitted = warnings.len().saturating_sub(MOST_DIAGNOSTICS);
        if omitted > 0 {
            warnings.truncate(MOST_DIAGNOSTICS);
            warnings.push(Diagnostic::new(code::VALUE, None, format!("and {omitted} more warnings")));
        }
        warnings
    }

    fn material_warnings(&self) -> Vec<Diagnostic> {
        let mut warnings = Vec::new();
        for material in &self.materials {
            let MaterialLaw::Isotropic { poisson, .. } = material.law else { continue };
            if poisson < LOCKING {
                continue;
            }
            let path = format!("materials.{}.poisson", material.name);
            let message = format!(
                "Poisson's ratio {poisson} is nearly incompressible: linear {} lock, and the certified error shows it",
                S::WORDS.cells
            );
            warnings.push(self.diagnostic(code::VALUE, &path, message));
        }
        let used: Vec<&Material<S>> =
            (0..self.bodies.len()).flat_map(|body| self.materials_of(body)).collect();
        let mut asked = HashSet::new();
        for material in used.iter().filter(|material| asked.insert(material.name.as_str())) {
            let said =
                self.units.as_ref().and_then(|units| units.impossible_modulus(material.largest_modulus()));
            if let Some(message) = said {
                warnings.push(self.diagnostic(code::VALUE, &format!("materials.{}", material.name), message));
            }
        }
        let moduli = || used.iter().map(|material| material.largest_modulus());
        let ratio = moduli().fold(0.0, f64::max) / moduli().fold(f64::INFINITY, f64::min);
        if ratio > MODULI {
            let factor =
                if ratio.is_finite() { format!("{ratio:.1e}") } else { "more than 1e308".to_owned() };
            let message = format!("the moduli of the materials differ by a factor of {factor}");
            warnings.push(self.diagnostic(code::VALUE, "materials", message));
        }
        let used: HashSet<&str> = used.iter().map(|material| material.name.as_str()).collect();
        for material in self.materials.iter().filter(|material| !used.contains(material.name.as_str())) {
            let message = format!("no body uses the material \"{}\"", material.name);
            let path = format!("materials.{}", material.name);
            warnings.push(self.diagnostic(code::REFERENCE, &path, message));
        }
        warnings
    }

    /// Conditions with a name that no load step uses have the factor 0 throughout.
    fn step_warnings(&self) -> Vec<Diagnostic> {
        if self.steps.is_empty() {
            return Vec::new();
        }
        let used: HashSet<&str> =
            self.steps.iter().flat_map(|step| &step.factors).map(|(name, _)| name.as_str()).collect();
        let mut unused = HashSet::new();
        let names = self.bodies.iter().flat_map(BodyCase::<S>::condition_names);
        let names: Vec<&str> = names.filter(|name| !used.contains(name) && unused.insert(*name)).collect();
        let warn = |name: &str| {
            let message =
                format!("no load step names the condition \"{}\", so it never acts", name.escape_debug());
            self.diagnostic(code::VALUE, "step", message)
        };
        names.into_iter().map(warn).collect()
    }

    fn solver_warnings(&self) -> Vec<Diagnostic> {
        let mut warnings = Vec::new();
        if self.is_given("solver.path") {
            let message = "`solver.path` has no effect: every step is solved in the interface unknowns";
            warnings.push(self.diagnostic(code::VALUE, "solver.path", message.to_owned()));
        }
        if self.solver.acceleration == Acceleration::Aitken {
            let message = "acceleration \"aitken\" is read as \"anderson\", which takes its place";
            warnings.push(self.diagnostic(code::VALUE, "solver.acceleration", message.to_owned()));
        }
        let exact = matches!(self.solver.method, Method::Newton | Method::Exact);
        let (uses, unused) = match self.solver.method {
            Method::Newton | Method::Exact => {
                ("the exact method uses only `max_iterations` and `qp`", self.given_iteration_settings())
            }
            Method::NewtonNn => ("method newton-nn updates lambda on its own", self.given_update_settings()),
            Method::Auto | Method::Nndd => ("", Vec::new()),
        };
        if !unused.is_empty() {
            let message = format!("{uses}; it ignores `{}`", unused.join("`, `"));
            warnings.push(self.diagnostic(code::VALUE, "solver.method", message));
        }
        let criterion = self.solver.stop.criterion;
        if self.adapt.is_some() && !exact && criterion != Criterion::Estimator {
            let message = format!(
                "an adaptive run with the criterion \"{criterion}\": the iteration may end long before or after its error is \
                 small against the mesh's; criterion = \"estimator\" compares the two"
            );
            warnings.push(self.diagnostic(code::VALUE, "solver.stop.criterion", message));
        }
        warnings
    }
}

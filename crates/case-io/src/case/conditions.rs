//! Boundary conditions: from the case's words to fem-core's.

use super::{Case, Displacement, Imposition, Load, Part, Traction, Value};
use crate::diagnostic::{CaseError, code, excerpt};
use fem_core::boundary::{self, BoundaryConditions, EdgeSelection, ScalarData, Support};

impl Case {
    /// Returns what is imposed on a body, 0 or 1, in the file's order.
    ///
    /// # Errors
    /// A value that is an expression, which no case that was read from a file has.
    pub fn boundary_conditions(&self, body: usize) -> Result<BoundaryConditions, CaseError> {
        let mut faults = Vec::new();
        let mut conditions = BoundaryConditions::new().body_force(self.bodies[body].body_force);
        for (k, given) in self.bodies[body].displacements.iter().enumerate() {
            match self.support(given, &format!("body.{body}.displacement.{k}")) {
                Ok(support) => {
                    let edges = selection(&given.on, given.part);
                    conditions.displacements.push(boundary::DisplacementCondition { edges, support });
                }
                Err(fault) => faults.extend(fault.diagnostics),
            }
        }
        for (k, given) in self.bodies[body].tractions.iter().enumerate() {
            match self.load(given, &format!("body.{body}.traction.{k}")) {
                Ok(load) => {
                    let edges = selection(&given.on, given.part);
                    conditions.tractions.push(boundary::TractionCondition { edges, load });
                }
                Err(fault) => faults.extend(fault.diagnostics),
            }
        }
        if faults.is_empty() { Ok(conditions) } else { Err(CaseError::new(faults)) }
    }

    fn support(&self, given: &Displacement, path: &str) -> Result<Support, CaseError> {
        let component = |value: &Option<Value>, key: &str| {
            value.as_ref().map(|v| self.scalar(v, &format!("{path}.{key}"))).transpose()
        };
        Ok(match &given.imposition {
            Imposition::Fixed => Support::Components([Some(0.0.into()), Some(0.0.into())]),
            Imposition::Normal(value) => Support::Normal(self.scalar(value, &format!("{path}.normal"))?),
            Imposition::Components([ux, uy]) => {
                Support::Components([component(ux, "ux")?, component(uy, "uy")?])
            }
        })
    }

    fn load(&self, given: &Traction, path: &str) -> Result<boundary::Load, CaseError> {
        Ok(match &given.load {
            Load::Vector([x, y]) => boundary::Load::Vector([
                self.scalar(x, &format!("{path}.vector.0"))?,
                self.scalar(y, &format!("{path}.vector.1"))?,
            ]),
            Load::Pressure(value) => {
                boundary::Load::Pressure(self.scalar(value, &format!("{path}.pressure"))?)
            }
        })
    }

    /// Makes fem-core's datum of a value. Expressions become functions here when they can be evaluated.
    pub(super) fn scalar(&self, value: &Value, path: &str) -> Result<ScalarData, CaseError> {
        match value {
            Value::Number(number) => Ok((*number).into()),
            Value::Expression(text) => {
                let message = format!("the expression {}: not in this version yet", excerpt(text));
                Err(self.diagnostic(code::UNSUPPORTED, path, message).expected("a number").into())
            }
        }
    }
}

fn selection(on: &str, part: Part) -> EdgeSelection {
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let edges = EdgeSelection::group(on);
    match part {
        Part { x: None, y: None } => edges,
        Part { x, y } => edges.within([x.unwrap_or(free), y.unwrap_or(free)]),
    }
}

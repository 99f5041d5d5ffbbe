//! Boundary conditions: from the case's words to fem-core's.

use super::{Case, Displacement, Imposition, Load, Part, RigidCase, Traction, Value};
use fem_core::boundary::{self, BoundaryConditions, FacetSelection, Support};

impl Case {
    /// Returns what is imposed on a body, 0 or 1, in the file's order.
    pub(crate) fn boundary_conditions(&self, body: usize) -> BoundaryConditions {
        let given = &self.bodies[body];
        let mut conditions = BoundaryConditions::new().body_force(given.body_force);
        let point = |on: &str| given.sides.iter().find(|side| side.name == on)?.point;
        for wanted in &given.displacements {
            let mut condition = displacement(wanted);
            if let Some(point) = point(&wanted.on) {
                condition.edges = FacetSelection::node(&wanted.on, point);
            }
            conditions.displacements.push(condition);
        }
        conditions.tractions.extend(given.tractions.iter().map(traction));
        conditions.rigid.extend(given.rigid.iter().map(rigid));
        conditions
    }
}

fn displacement(given: &Displacement) -> boundary::DisplacementCondition {
    let support = match &given.imposition {
        Imposition::Fixed => Support::Components([Some(0.0.into()), Some(0.0.into())]),
        Imposition::Normal(value) => Support::Normal(value.scalar()),
        Imposition::Components(components) => {
            Support::Components(components.each_ref().map(|c| c.as_ref().map(Value::scalar)))
        }
    };
    boundary::DisplacementCondition { edges: selection(&given.on, given.part), support }
}

fn traction(given: &Traction) -> boundary::TractionCondition {
    let load = match &given.load {
        Load::Vector(components) => boundary::Load::Vector(components.each_ref().map(Value::scalar)),
        Load::Pressure(value) => boundary::Load::Pressure(value.scalar()),
    };
    boundary::TractionCondition { edges: selection(&given.on, given.part), load }
}

fn rigid(given: &RigidCase) -> boundary::RigidCondition {
    boundary::RigidCondition {
        edges: selection(&given.on, given.part),
        motion: [given.rigid.ux, given.rigid.uy, given.rigid.rotation],
        force: given.rigid.force.unwrap_or_default().into(),
        moment: given.rigid.moment.unwrap_or_default(),
        about: given.rigid.about.map(Into::into),
    }
}

fn selection(on: &str, part: Part) -> FacetSelection {
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let edges = FacetSelection::group(on);
    match part {
        Part { x: None, y: None } => edges,
        Part { x, y } => edges.within([x.unwrap_or(free), y.unwrap_or(free)]),
    }
}

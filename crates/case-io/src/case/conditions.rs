//! Boundary conditions: from the case's words to fem-core's.

use super::{
    Case, CutCase, Dimension, Displacement, Imposition, Inertia, Load, Part, RigidCase, SpringCase, Traction,
    Value,
};
use fem_core::boundary::{self, BoundaryConditions, FacetSelection, Support};

impl<S: Dimension> Case<S> {
    /// Returns what is imposed on a body, 0 or 1, in the file's order.
    pub(crate) fn boundary_conditions(&self, body: usize) -> BoundaryConditions<S> {
        let given = &self.bodies[body];
        let mut conditions = BoundaryConditions::default();
        let numbers: Option<Vec<f64>> = given.body_force.as_ref().iter().map(Value::number).collect();
        match numbers {
            Some(numbers) => conditions.body_force = S::vector(&S::axes(|c| numbers[c])),
            None => conditions.force_field = Some(S::data(|c| given.body_force[c].scalar())),
        }
        conditions.per_mass = self.inertia.as_ref().map(Inertia::per_mass);
        conditions.temperatures = given.temperatures.iter().map(|given| given.value.scalar()).collect();
        let point = |on: &str| given.sides.iter().find(|side| side.name == on)?.point.as_ref().map(S::vector);
        for wanted in &given.displacements {
            let mut condition = displacement(wanted);
            if let Some(point) = point(&wanted.on) {
                condition.edges = FacetSelection::node(&wanted.on, point);
            }
            conditions.displacements.push(condition);
        }
        conditions.tractions.extend(given.tractions.iter().map(traction));
        conditions.rigid.extend(given.rigid.iter().map(rigid));
        conditions.springs.extend(given.springs.iter().map(spring));
        conditions.cuts.extend(given.cuts.iter().map(CutCase::condition));
        conditions
    }
}

fn displacement<S: Dimension>(given: &Displacement<S>) -> boundary::DisplacementCondition<S> {
    let support = match &given.imposition {
        Imposition::Fixed => Support::Components(S::data(|_| Some(0.0.into()))),
        Imposition::Normal(value) => Support::Normal(value.scalar()),
        Imposition::Components(components) => {
            Support::Components(S::data(|c| components[c].as_ref().map(Value::scalar)))
        }
    };
    boundary::DisplacementCondition { edges: selection(&given.on, given.part), support }
}

fn traction<S: Dimension>(given: &Traction<S>) -> boundary::TractionCondition<S> {
    let load = match &given.load {
        Load::Vector(components) => boundary::Load::Vector(S::data(|c| components[c].scalar())),
        Load::Pressure(value) => boundary::Load::Pressure(value.scalar()),
    };
    boundary::TractionCondition { edges: selection(&given.on, given.part), load }
}

fn rigid<S: Dimension>(given: &RigidCase<S>) -> boundary::RigidCondition<S> {
    boundary::RigidCondition {
        edges: selection(&given.on, given.part),
        motion: given.rigid.motion,
        force: given.rigid.force(),
        moment: given.rigid.moment.unwrap_or_default(),
        about: given.rigid.about.as_ref().map(S::vector),
    }
}

fn spring<S: Dimension>(given: &SpringCase<S>) -> boundary::SpringCondition<S> {
    boundary::SpringCondition {
        edges: selection(&given.on, given.part),
        stiffness: given.stiffness.scalar(),
        along: given.direction(),
        rest: given.at_rest(),
    }
}

fn selection<S: Dimension>(on: &str, part: Part<S>) -> FacetSelection<S> {
    FacetSelection { part: part.axes(), ..FacetSelection::group(on) }
}

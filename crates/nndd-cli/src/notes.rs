//! What is worth knowing about a run that is allowed but may not be meant: it goes to stderr and into report.json.

use crate::outcome;
use case_io::Case;
use certified_contact::CertifiedSolution;
use fem_core::body::{Body, Difference, NodeConstraint};
use fem_core::geometry::{bounding_box, norm, sub};
use nndd::NnddStatus;

/// From this strain on the theory of small strains is doubtful.
const STRAIN: f64 = 0.1;

/// From this ratio of an imposed displacement to the body's size on, it is doubtful too.
const DISPLACEMENT: f64 = 0.1;

/// Lists everything about a case and its mesh files, its warnings in words without places.
pub(crate) fn of_case(case: &Case) -> Vec<String> {
    let warnings = case.warnings().into_iter().map(|warning| warning.message);
    case.notes().iter().cloned().chain(warnings).collect()
}

/// Lists what can be said of a problem without solving it; bodies in the file's order.
pub(crate) fn of_problem(case: &Case, bodies: [&Body; 2], gap: Option<Difference>) -> Vec<String> {
    let mut notes = case.data_notes(bodies, gap);
    for (given, body) in case.bodies.iter().zip(bodies) {
        let imposed = body.node_constraints().iter().map(|constraint| match constraint {
            NodeConstraint::Free => 0.0,
            NodeConstraint::Along { value, .. } => value.abs(),
            NodeConstraint::Fixed { value } => norm(*value),
        });
        let largest = imposed.fold(0.0, f64::max);
        let [low, high] = bounding_box(body.mesh().points());
        let size = norm(sub(high, low));
        if largest > DISPLACEMENT * size {
            notes.push(format!(
                "body \"{}\": an imposed displacement of {largest:.2e} on a body of size {size:.2e}: small strains may not be \
                 a fair assumption; check the units",
                given.name
            ));
        }
    }
    notes
}

/// Lists what can be said of a solution and its problem.
pub(crate) fn of_solution(case: &Case, solution: &CertifiedSolution) -> Vec<String> {
    let problem = &solution.problem;
    let bodies = [0, 1].map(|body| &problem.bodies[solution.role(body)]);
    let mut notes = of_problem(case, bodies, problem.interpolated_gap());
    notes.extend(bent_contact(solution));
    let Some(estimate) = &solution.estimate else { return notes };
    if matches!(solution.nndd.status, NnddStatus::Diverged { .. }) {
        // The last iterate says nothing about the bodies.
        return notes;
    }
    // Without [adapt] the reason of the status says so.
    let switch = solution.nndd.switch.filter(|_| case.adapt.is_some());
    notes.extend(
        switch
            .map(|s| format!("on the last mesh {}; method newton was used", outcome::given_up(solution, s))),
    );
    notes.extend(unfinished_iteration(solution));
    if solution.last().contact.normal_reaction.iter().all(|r| *r <= 0.0) {
        notes.push("no contact: no force passes between the bodies".to_owned());
    }
    for (body, given) in case.bodies.iter().enumerate() {
        let role = solution.role(body);
        let model = &problem.bodies[role];
        let strains = estimate.pair.stress[role].iter().enumerate().map(|(t, stress)| {
            let strain = model.material(t).strain(*stress);
            // The larger principal strain by its size.
            let middle = 0.5 * (strain.xx + strain.yy);
            middle.abs() + (0.5 * (strain.xx - strain.yy)).hypot(strain.xy)
        });
        let largest = strains.fold(0.0, f64::max);
        if largest > STRAIN {
            notes.push(format!(
                "body \"{}\": the largest strain is {} %, above the {} % up to which small strains are a fair \
                 assumption; check the units of the loads and moduli",
                given.name,
                if largest < 100.0 { format!("{:.1}", 100.0 * largest) } else { format!("{:.1e}", 100.0 * largest) },
                100.0 * STRAIN
            ));
        }
    }
    notes
}

/// Says that an iteration which met its criterion leaves most of the bound.
fn unfinished_iteration(solution: &CertifiedSolution) -> Option<String> {
    let estimate = solution.estimate.as_ref()?;
    let cre = &estimate.cre;
    let stopped = solution.nndd.status == NnddStatus::StoppedByCriterion;
    // Round-off is no iteration's.
    let larger = cre.algebraic_squared > cre.discretisation_squared.max(estimate.round_off.powi(2));
    (stopped && larger).then(|| {
        "the iteration contributes more to the bound than the mesh, although its criterion is met: more iterations would \
         lower the bound; use a smaller solver.stop.ratio or tolerance"
            .to_owned()
    })
}

/// Says what the bound of a bent contact line is a bound of.
fn bent_contact(solution: &CertifiedSolution) -> Option<String> {
    let estimate = solution.estimate.as_ref()?;
    solution.problem.interface.has_bent_edges().then(|| {
        format!(
            "the contact line bends: the bound is for the meshed polygons with normals averaged at their nodes, and the \
             difference to a curved line is outside it; to penetrate nowhere between the nodes, the contact nodes of one \
             body were moved by at most {:.1e}",
            estimate.pair.lift.largest()
        )
    })
}

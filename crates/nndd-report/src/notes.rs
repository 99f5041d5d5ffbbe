//! Notes about settings that are allowed but perhaps not intended: it goes to stderr and into report.json.

use crate::check::{self, MOST_NAMED};
use crate::convert;
use crate::corners;
use crate::curves;
use crate::solved::{Fields, RunResult, Solved};
use crate::verdict::is_round_off;
use crate::words;
use case_io::Case;
use case_io::case::{BodyCase, MaterialLaw, Method};
use certified_contact::CertifiedSolution;
use cre_estimator::Estimate;
use fem_core::body::Body;
use fem_core::geometry::{Vector, norm, shown};
use fem_core::interface::ContactProblem;
use fem_core::material::Hypothesis;
use nndd::NnddStatus;

/// From this strain on the theory of small strains is doubtful.
const STRAIN: f64 = 0.1;

/// Contact nodes that were moved by less than this part of the largest displacement need no note.
const MOVED: f64 = 1e-4;

/// From this ratio of an imposed displacement to the body's size on, it is doubtful too.
const DISPLACEMENT: f64 = 0.1;

/// Lists everything about a case and its first meshes, its warnings in words without places.
///
/// * `built`: see [`crate::run::build`].
pub fn of_case(case: &Case, built: &[String]) -> Vec<String> {
    let warnings = case.warnings().into_iter().map(|warning| warning.message);
    built.iter().cloned().chain(warnings).collect()
}

/// Lists what can be said of a problem without solving it; bodies in the file's order.
pub fn of_problem(case: &Case, problem: &ContactProblem) -> Vec<String> {
    let mut notes = case.data_notes(problem);
    let unused = case.given_iteration_settings();
    let coulomb = case.coulomb_pair();
    let ignores = coulomb.is_some() || convert::is_exact(case, problem);
    if case.solver.method == Method::Auto && ignores && !unused.is_empty() {
        let [what, advice] = match coulomb {
            None => [
                "the exact solution of an assembly uses only `max_iterations` and `qp`",
                "; method = \"nndd\" asks for the iteration",
            ],
            Some(_) => ["Coulomb friction uses only `friction_tolerance`, `friction_steps` and `qp`", ""],
        };
        notes.push(format!("{what}; it ignores `{}`{advice}", unused.join("`, `")));
    }
    let free = check::free_motions(case, problem).unwrap_or_default();
    match free.as_slice() {
        [] => {}
        [motion] => notes.push(format!("free motion: {motion}; no load drives it, and it stays at zero")),
        motions => notes.push(format!(
            "free motions: {}{}; no load drives them, and they stay at zero",
            motions.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join("; "),
            motions
                .len()
                .checked_sub(MOST_NAMED + 1)
                .map_or_else(String::new, |more| format!("; {} more", more + 1))
        )),
    }
    for (given, body) in case.bodies.iter().zip(&problem.bodies) {
        let imposed = body.node_constraints().iter().map(|constraint| norm(constraint.imposed));
        let largest = imposed.fold(0.0, f64::max);
        let [low, high] = body.mesh().bounding_box();
        let size = norm(high - low);
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

/// Lists everything of a report, the important first.
pub(crate) fn of_report(case: &Case, solved: &Solved) -> Vec<String> {
    [of_answer(case, &solved.answer, &solved.notes), of_case(case, &solved.case_notes)].concat()
}

/// Lists what can be said of a solution and its problem: first what limits the use of the answer, then how the case was read.
fn of_answer(case: &Case, answer: &RunResult, run: &[String]) -> Vec<String> {
    let (fields, certified) = (answer.fields(), answer.certified());
    // The last iterate of a run that diverged says nothing about the bodies.
    let diverged = |solution: &CertifiedSolution| matches!(solution.nndd.status, NnddStatus::Diverged { .. });
    let mut notes = Vec::new();
    if let Some(estimate) = fields.estimate.filter(|_| !certified.is_some_and(diverged)) {
        notes.extend(certified.into_iter().flat_map(|solution| what_dominates(case, solution)));
        notes.extend(of_fields(case, &fields, estimate));
    }
    notes.extend_from_slice(run);
    notes.extend(bent_contact(&fields));
    notes.extend(curves::of_solution(case, &fields));
    notes.extend(of_problem(case, fields.problem));
    notes
}

/// Lists what can be said of the displacements that were found.
fn of_fields(case: &Case, fields: &Fields<'_>, estimate: &Estimate) -> Vec<String> {
    let problem = fields.problem;
    let mut notes = Vec::new();
    if !problem.contacts.is_empty() && fields.last.contact.normal_reaction.iter().all(|r| *r <= 0.0) {
        notes.push("no contact: no force passes between the bodies".to_owned());
    }
    for (body, given) in case.bodies.iter().enumerate() {
        let model = &problem.bodies[body];
        notes.extend(moved_far(given, model, &estimate.pair.bodies[body].displacement));
        let strains = estimate.pair.bodies[body].stress.iter().enumerate().map(|(t, stress)| {
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
    notes.extend(corners::of_fields(case, fields));
    notes.extend(short_sides(case, fields));
    notes
}

/// Cosine of the largest turn of a smooth outline, 30 degrees.
const SMOOTH: f64 = 0.866;

/// Names the contact lines with the largest pressure at an end at which the bodies continue smoothly: nothing ends contact there but the side.
fn short_sides(case: &Case, fields: &Fields<'_>) -> Vec<String> {
    let problem = fields.problem;
    let mut rest = fields.last.contact.normal_reaction.as_slice();
    let mut notes = Vec::new();
    for (pair, named) in problem.contacts.iter().zip(&case.contacts) {
        let nodes = pair.interface.pairs();
        let (forces, others) = rest.split_at(nodes.len().min(rest.len()));
        rest = others;
        let pressure = nodes.iter().zip(forces).map(|(node, force)| force / node.weight);
        let Some((k, largest)) = pressure.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let mut edges = pair.interface.facets().iter().filter(|edge| edge.pairs.contains(&(k as u32)));
        let (Some(edge), None) = (edges.next(), edges.next()) else { continue };
        let smooth = |(side, b): (usize, usize)| {
            let mesh = problem.bodies[b].mesh();
            let beyond = mesh.topology().boundary_beyond(edge.facets[side], nodes[k].nodes[side]);
            let beyond = beyond.filter(|e| !corners::touches(problem, b, *e));
            beyond.is_some_and(|e| mesh.facet_normal(e).dot(&mesh.facet_normal(edge.facets[side])) >= SMOOTH)
        };
        if largest > 0.0 && edge.clamped.is_none() && pair.elastic_sides().all(smooth) {
            let at = problem.bodies[pair.body].mesh().points()[nodes[k].nodes[0]];
            notes.push(format!(
                "contact \"{}\": the pressure is largest at an end of the contact line, at ({}, {}), where the bodies continue smoothly: is \
                 a contact side too short? Add the sides beyond it to `surfaces`, with gap = \"geometric\"",
                named.name,
                shown(at[0]),
                shown(at[1])
            ));
        }
    }
    notes
}

/// Says that a body that only contact holds moves far.
fn moved_far(given: &BodyCase, body: &Body, displacement: &[Vector]) -> Option<String> {
    body.free_motion()?;
    let largest = displacement.iter().map(|u| norm(*u)).fold(0.0, f64::max);
    let size = body.mesh().diagonal();
    (largest > DISPLACEMENT * size).then(|| {
        format!(
            "body \"{}\", which only contact holds, moves by {largest:.2e} and has the size {size:.2e}: small displacements may not \
             be a fair assumption",
            given.name
        )
    })
}

/// From this share of the bound on, round-off gets a note.
const ROUND_OFF_SHARE: f64 = 0.1;

/// From this bound over the norm on, a material near incompressibility is the likely cause.
const LOCKING_BOUND: f64 = 0.5;

/// From this Poisson's ratio on, triangles with linear displacements lock.
const LOCKING_RATIO: f64 = 0.49;

/// Says what makes the bound large, if it is not the mesh, and what helps.
fn what_dominates(case: &Case, solution: &CertifiedSolution) -> Vec<String> {
    let Some(estimate) = &solution.estimate else { return Vec::new() };
    let found = estimate.unchecked();
    let stopped = solution.nndd.status == NnddStatus::StoppedByCriterion;
    let mut notes = Vec::new();
    match found.parts.largest() {
        "iteration" if stopped => notes.push(
            "the iteration contributes more to the bound than the mesh, although its criterion is met: lower solver.stop.ratio or \
             solver.stop.tolerance"
                .to_owned(),
        ),
        "contact" => notes.push(
            "most of the bound comes from the contact law between the nodes, which only a finer mesh at the contact line lowers"
                .to_owned(),
        ),
        "lift" | "gap_data" => notes.push(
            "most of the bound comes from the bent contact line, and a finer mesh there lowers it".to_owned(),
        ),
        _ => {}
    }
    let round_off = found.parts.round_off;
    if found.e_cre > 0.0 && round_off >= ROUND_OFF_SHARE * found.e_cre {
        let share = format!("{:.0} %", 100.0 * round_off / found.e_cre);
        notes.push(if is_round_off(round_off, found.e_cre) {
            format!(
                "the bound is round-off: the allowance for it, {}, is {share} of the bound, and no finer mesh lowers it",
                words::rounded_up(round_off)
            )
        } else {
            format!("round-off is {share} of the bound, which no finer mesh lowers")
        });
    }
    if found.e_cre > LOCKING_BOUND * estimate.energy_norm() && nearly_incompressible(case) {
        notes.push(
            "a material is nearly incompressible, so the displacements are too small and the bound is large: use a finer mesh \
             ([adapt] target_relative_error) or a smaller Poisson's ratio"
                .to_owned(),
        );
    }
    notes
}

/// Tells whether an isotropic material in plane strain is near incompressibility.
fn nearly_incompressible(case: &Case) -> bool {
    case.model.hypothesis == Hypothesis::PlaneStrain
        && case.materials.iter().any(
            |material| matches!(material.law, MaterialLaw::Isotropic { poisson, .. } if poisson >= LOCKING_RATIO),
        )
}

/// Says what the bound, or the residual, of a bent contact line is one of, and by how much its nodes were moved.
fn bent_contact(solution: &Fields<'_>) -> Vec<String> {
    let Some(estimate) = solution.estimate else { return Vec::new() };
    if !solution.problem.contacts.iter().any(|pair| pair.interface.has_bent_facets()) {
        return Vec::new();
    }
    let mut notes = vec![format!(
        "the contact line bends: {} is for the meshed polygons with normals averaged at their nodes, not for a curved line",
        solution.what()
    )];
    let largest = estimate.pair.contacts.iter().map(|contact| contact.lift.largest()).fold(0.0, f64::max);
    let displacements = estimate.pair.bodies.iter().flat_map(|body| &body.displacement);
    if largest > MOVED * displacements.map(|u| norm(*u)).fold(0.0, f64::max) {
        notes.push(format!(
            "the contact nodes of one body were moved by at most {largest:.1e}, so that bent edges do not penetrate between them"
        ));
    }
    notes
}

//! Notes about settings that are allowed but perhaps not intended: it goes to stderr and into report.json.

mod rigid;

use crate::check::{self, MOST_NAMED, NamedMotion};
use crate::convert;
use crate::solved::{Fields, RunResult, Solved};
use crate::space::ReportSpace;
use crate::verdict::is_round_off;
use crate::words;
use case_io::Case;
use case_io::case::{BodyCase, Method};
use case_io::diagnostic::significant;
use certified_contact::CertifiedSolution;
use cre_estimator::Estimate;
use fem_core::body::Body;
use fem_core::geometry::norm;
use fem_core::interface::ContactProblem;
use nndd::{CoulombStatus, NnddStatus};

/// From this strain on the theory of small strains is doubtful.
const STRAIN: f64 = 0.1;

/// From this ratio of an imposed displacement to the body's size on, it is doubtful too.
const DISPLACEMENT: f64 = 0.1;

/// Lists everything about a case and its first meshes, its warnings in words without places.
///
/// * `built`: see [`crate::run::build`].
pub fn of_case<S: ReportSpace>(case: &Case<S>, built: &[String]) -> Vec<String> {
    let warnings = case.warnings().into_iter().map(|warning| warning.message);
    built.iter().cloned().chain(warnings).collect()
}

/// Lists what can be said of a problem without solving it; bodies in the file's order.
pub fn of_problem<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>) -> Vec<String> {
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
    notes.extend(of_free_motions(&free, case.adapt.is_some()));
    notes.extend(rigid::free_aside(case, problem));
    for (given, body) in case.bodies.iter().zip(&problem.bodies) {
        notes.extend(rigid::shared_reactions(given, body));
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

/// Says which motions nothing resists.
///
/// * `refined`: whether finer meshes follow, whose polygons have other loads.
fn of_free_motions(free: &[NamedMotion], refined: bool) -> Vec<String> {
    let [alone, all_alone] = match refined {
        false => ["no load drives it, and it stays at zero", "no load drives them, and they stay at zero"],
        true => [
            "no load drives it on this mesh, and it stays at zero",
            "no load drives them on this mesh, and they stay at zero",
        ],
    };
    let (loaded, unloaded): (Vec<_>, Vec<_>) = free.iter().partition(|(_, load, _)| *load != 0.0);
    let (weak, on_arcs): (Vec<_>, Vec<_>) = loaded.into_iter().partition(|(.., weak)| *weak);
    let with_load = |motions: Vec<&NamedMotion>| -> Vec<String> {
        let words = |(motion, load, _): &&NamedMotion| {
            format!("{motion}, with a load {} along it", significant(load.abs()))
        };
        motions.iter().map(words).collect()
    };
    let unloaded: Vec<String> = unloaded.iter().map(|(motion, ..)| motion.clone()).collect();
    let all = [
        (unloaded, ["free motion", alone], ["free motions", all_alone]),
        (
            with_load(weak),
            [
                "free motion but for the error of normals",
                "the motion stays at zero, and the contact forces of the solution balance that load only up to this error, \
             see `results.balance`; the pressures of the bound balance it",
            ],
            [
                "free motions but for the error of normals",
                "the motions stay at zero, and the contact forces of the solution balance these loads only up to this error, \
             see `results.balance`; the pressures of the bound balance them",
            ],
        ),
        (
            with_load(on_arcs),
            [
                "free motion along declared arcs",
                "that load is left out, and the motion stays at zero, if the error of the polygon explains the \
             load; otherwise the body is not held",
            ],
            [
                "free motions along declared arcs",
                "these loads are left out, and the motions stay at zero, if the error of the polygons explains the \
             loads; otherwise the bodies are not held",
            ],
        ),
    ];
    let note = |(motions, one, several): (Vec<String>, [&str; 2], [&str; 2])| {
        let [name, end] = if motions.len() == 1 { one } else { several };
        let named = motions.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join("; ");
        let more = motions.len().saturating_sub(MOST_NAMED);
        let more = if more == 0 { String::new() } else { format!("; {more} more") };
        (!motions.is_empty()).then(|| format!("{name}: {named}{more}; {end}"))
    };
    all.into_iter().filter_map(note).collect()
}

/// Lists everything of a report, the important first.
pub(crate) fn of_report<S: ReportSpace>(case: &Case<S>, solved: &Solved<S>) -> Vec<String> {
    [of_answer(case, &solved.answer, &solved.notes), of_case(case, &solved.case_notes)].concat()
}

/// Lists what can be said of a solution and its problem: first what limits the use of the answer, then how the case was read.
fn of_answer<S: ReportSpace>(case: &Case<S>, answer: &RunResult<S>, run: &[String]) -> Vec<String> {
    let (fields, certified) = (answer.fields(), answer.certified());
    // The last iterate of a run that diverged says nothing about the bodies.
    let diverged =
        |solution: &CertifiedSolution<S>| matches!(solution.nndd.status, NnddStatus::Diverged { .. });
    let mut notes = Vec::new();
    if let Some(estimate) = fields.estimate.filter(|_| !certified.is_some_and(diverged)) {
        let valid = certified.filter(|solution| solution.is_certified());
        notes.extend(valid.into_iter().flat_map(|solution| what_dominates(case, solution)));
        notes.extend(no_contact(answer));
        notes.extend(of_fields(case, &fields, estimate));
    }
    notes.extend_from_slice(run);
    notes.extend(S::notes_on_shapes(case, &fields));
    notes.extend(of_problem(case, fields.problem));
    notes
}

/// Says that nothing touches, if that is known: the forces of an iterate may be far from those of the solution.
fn no_contact<S: ReportSpace>(answer: &RunResult<S>) -> Option<String> {
    let converged = match answer {
        RunResult::Certified(solution) => solution.nndd.status == NnddStatus::StoppedByCriterion,
        RunResult::Coulomb(result) => result.solution.status == CoulombStatus::Converged,
    };
    let fields = answer.fields();
    let presses = fields.last.contact.normal_reaction.iter().any(|force| *force > 0.0);
    let may_touch = fields.problem.contacts.iter().any(|pair| !pair.is_bonded());
    let none = converged && !presses && may_touch;
    none.then(|| "no contact: no pressure acts between the bodies".to_owned())
}

/// Lists what can be said of the displacements that were found.
fn of_fields<S: ReportSpace>(case: &Case<S>, fields: &Fields<'_, S>, estimate: &Estimate<S>) -> Vec<String> {
    let problem = fields.problem;
    let mut notes = Vec::new();
    for (body, given) in case.bodies.iter().enumerate() {
        let model = &problem.bodies[body];
        notes.extend(moved_far(given, model, &estimate.pair.bodies[body].displacement));
        let strains = estimate.pair.bodies[body]
            .stress
            .iter()
            .enumerate()
            .map(|(t, stress)| S::principal(model.material(t).strain(*stress)));
        let largest =
            strains.fold(0.0, |most, values| values.as_ref().iter().fold(most, |m: f64, e| m.max(e.abs())));
        // An imposed strain of just the limit is not above it.
        if largest > STRAIN * (1.0 + 1e-9) {
            notes.push(format!(
                "body \"{}\": the largest strain is {} %, above the {} % up to which small strains are a fair \
                 assumption; check the units of the loads and moduli",
                given.name,
                if largest < 100.0 { format!("{:.1}", 100.0 * largest) } else { format!("{:.1e}", 100.0 * largest) },
                100.0 * STRAIN
            ));
        }
    }
    if let Some(until) = &case.estimator.until {
        let relaxed = case.bodies.iter().zip(&estimate.pair.bodies);
        let cut =
            relaxed.filter(|(_, of)| of.relaxation.steps == until.max_steps && !of.relaxation.stationary);
        let names: Vec<String> = cut.map(|(given, _)| format!("\"{}\"", given.name)).collect();
        if !names.is_empty() {
            notes.push(format!(
                "the relaxation of {} ended after {}, the most of estimator.max_steps, though more than {} may be left to gain: raise it",
                names.join(", "),
                words::counted(until.max_steps, "step"),
                until.tolerance
            ));
        }
    }
    notes.extend(S::notes_on_results(case, fields));
    notes
}

/// Says that a body that only contact holds moves far.
fn moved_far<S: ReportSpace>(
    given: &BodyCase<S>,
    body: &Body<S>,
    displacement: &[S::Vector],
) -> Option<String> {
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

/// From this part of the bound over the norm on, that of the mesh, a material near incompressibility is the likely cause.
const LOCKING_BOUND: f64 = 0.5;

/// From this Poisson's ratio on, triangles with linear displacements lock.
pub(crate) const LOCKING_RATIO: f64 = 0.49;

/// Says what makes the bound large, if it is not the mesh, and what helps.
fn what_dominates<S: ReportSpace>(case: &Case<S>, solution: &CertifiedSolution<S>) -> Vec<String> {
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
            format!("most of the bound comes from the contact law between the nodes, which only a finer mesh at the {} lowers", S::INTERFACE),
        ),
        "lift" | "gap_data" => notes.push(
            format!("most of the bound comes from the bent {}, and a finer mesh there lowers it", S::INTERFACE),
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
    if found.parts.mesh > LOCKING_BOUND * estimate.energy_norm() && S::locks(case) {
        notes.push(
            format!(
                "a material is nearly incompressible, so the displacements are too small and the bound is large: {} or take a smaller \
                 Poisson's ratio",
                S::FINER_MESH
            ),
        );
    }
    notes
}

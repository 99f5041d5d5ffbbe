//! Judges of the guarantees that the program prints.

use super::layouts::{Column, Torque};
use super::runs::{CaseText, Done, Quiet, resume, run, run_and_write};
use super::{Measured, Problem, Trial};
use crate::finer::{carried, finer, halve};
use crate::model::{Made, Vector};
use crate::random::Random;
use certified_contact::{CertifiedSolution, Settings, Silent, solve, suits_iteration};
use fem_core::body::Body;
use fem_core::field;
use fem_core::interface::{ContactPair, NodePair};
use fem_core::mesh::id::FacetId;
use fem_core::norm::{energy_distance_squared, spring_energy};
use fem_core::prepared::PreparedProblem;
use nndd::stopping::Never;
use nndd::{Method, NnddSettings, Start};
use nndd_report::sweep::{SweepOptions, sweep_of};
use nndd_report::{Failure, certify, verdict};
use std::path::Path;

/// A guarantee that the program prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Promise {
    /// The bound of the error.
    Error,
    /// The bound of the error of the iteration.
    Iteration,
    /// The bound of the error of the mesh for a frozen iteration.
    Mesh,
    /// The interval of the energy norm.
    Norm,
    /// The interval of the potential energy.
    Energy,
    /// The interval of the contact force.
    Force,
    /// Intervals and bounds against exact values.
    Exact,
    /// Forces on each body that add up to zero.
    Balance,
    /// The exit status.
    Status,
    /// Words and numbers that agree with each other.
    Words,
    /// The bound of a field that is given.
    Field,
    /// The rows of a sweep.
    Sweep,
    /// The resumed run.
    Resume,
    /// Load steps.
    Steps,
}

impl Promise {
    /// All promises, in the order of the table.
    pub const ALL: [(Self, &'static str); 14] = [
        (Self::Error, "e_cre"),
        (Self::Iteration, "eta_nndd"),
        (Self::Mesh, "eta_dis"),
        (Self::Norm, "energy_norm"),
        (Self::Energy, "potential_energy"),
        (Self::Force, "contact_force"),
        (Self::Exact, "exact values"),
        (Self::Balance, "balance"),
        (Self::Status, "status"),
        (Self::Words, "words"),
        (Self::Field, "certify"),
        (Self::Sweep, "sweep"),
        (Self::Resume, "resume"),
        (Self::Steps, "load steps"),
    ];
}

/// The verdict on a promise.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The promise.
    pub promise: Promise,
    /// True if it was kept.
    pub holds: bool,
    /// The numbers that were compared.
    pub said: String,
}

/// Numbers whose difference is below this part of them are equal: the judge computes in double precision.
const ROUNDING: f64 = 1e-11;

impl Trial {
    fn say(&mut self, promise: Promise, holds: bool, said: impl FnOnce() -> String) {
        let said = if holds { String::new() } else { said() };
        self.verdicts.push(Verdict { promise, holds, said });
    }

    /// Judges that a bound is not below a number that it bounds; a NaN violates it.
    fn above(&mut self, promise: Promise, what: &str, bound: f64, least: f64, slack: f64) {
        self.say(promise, bound >= least - slack, || format!("{what}: {bound:e} < {least:e}"));
    }

    /// Judges that two intervals have a point in common, up to a part of their ends.
    fn meet(&mut self, promise: Promise, what: &str, [a, b]: [[f64; 2]; 2], part: f64) {
        let slack = part * a.iter().chain(&b).fold(0.0f64, |m, x| m.max(x.abs()));
        let meet = a[0] <= b[1] + slack && b[0] <= a[1] + slack;
        self.say(promise, meet, || format!("{what}: {a:?} and {b:?} are apart"));
    }
}

/// A certified run, with its claims about the exact solution.
struct Claim<'a> {
    solution: &'a CertifiedSolution,
    displacement: Vec<Vec<Vector>>,
    e_cre: f64,
    eta_nndd: f64,
    norm: f64,
}

impl<'a> Claim<'a> {
    fn new(solution: &'a CertifiedSolution) -> Option<Self> {
        let estimate = solution.estimate.as_ref().filter(|_| solution.is_certified())?;
        let found = estimate.unchecked();
        Some(Self {
            solution,
            displacement: estimate.pair.displacements().into_iter().map(<[Vector]>::to_vec).collect(),
            e_cre: found.e_cre,
            eta_nndd: found.eta_nndd.max(solution.last().eta_nndd),
            norm: estimate.energy_norm(),
        })
    }

    fn bodies(&self) -> &[Body] {
        &self.solution.problem.bodies
    }
}

/// Estimates the rounding of coordinates far from the origin when cells are halved, as a part of the energy norm.
fn rounding(bodies: &[Body]) -> f64 {
    let of_body = |body: &Body| {
        let points = body.mesh().points();
        let reach = points.iter().fold(0.0f64, |m, x| m.max(x.amax()));
        let edges = (0..body.mesh().topology().facets().len()).map(FacetId::new);
        reach / edges.map(|edge| body.mesh().facet_measure(edge)).fold(f64::INFINITY, f64::min)
    };
    ROUNDING + 8.0 * f64::EPSILON * bodies.iter().map(of_body).fold(0.0, f64::max)
}

fn distance(bodies: &[Body], u: &[Vec<Vector>], v: &[Vec<Vector>]) -> f64 {
    between((bodies, u), (bodies, v))
}

/// The distance of fields on the same meshes, whose cuts may have different shortenings.
fn between((a, u): (&[Body], &[Vec<Vector>]), (b, v): (&[Body], &[Vec<Vector>])) -> f64 {
    let of_body = |k: usize| {
        let (body, u, v) = (&b[k], &u[k], &v[k]);
        if body.cuts().is_empty() {
            return energy_distance_squared(body, u, v);
        }
        let [s, t] = [field::stresses(&a[k], u), field::stresses(body, v)];
        let of_cell = |cell: usize| {
            let apart = s[cell].minus(t[cell]);
            body.mesh().measure(cell) * body.material(cell).complementary(apart, apart)
        };
        let moved: Vec<Vector> = u.iter().zip(v).map(|(u, v)| u - v).collect();
        (0..s.len()).map(of_cell).sum::<f64>() + spring_energy(body, &moved)
    };
    (0..b.len()).map(of_body).sum::<f64>().sqrt()
}

fn same_meshes(a: &[Body], b: &[Body]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.mesh().points() == b.mesh().points())
}

/// Runs and judges a problem.
pub(super) fn judge(problem: &Problem, folder: &Path, trial: &mut Trial) -> Made<()> {
    let source = CaseText { text: problem.text.clone(), folder: folder.to_owned() };
    let out = folder.join("out");
    let first = run(&source, &out, &mut Quiet::new());
    trial.runs += 1;
    let done = match first {
        Ok(done) => done,
        Err(failure) => {
            refused(&failure, trial);
            if let Some(torque) = &problem.known.torque {
                of_torque(torque, None, trial);
            }
            return Ok(());
        }
    };
    trial.code = done.report.status.code;
    trial.reason = done.report.status.reason.clone();
    let cells = |body: &Body| body.mesh().cells().len();
    trial.cells = [
        done.problem.bodies.iter().map(cells).sum(),
        done.problem.bodies.iter().map(cells).min().unwrap_or(0),
    ];
    of_report(&done, problem.load, trial);
    if done.report.adaptive.len() > 1 {
        trial.features.insert("adaptive");
        if !done.report.steps.is_empty() {
            trial.features.insert("adaptive load steps");
        }
        of_resume(&source, &done, &folder.join("resumed"), trial);
    }
    if !done.report.steps.is_empty() && trial.code != 0 {
        // An earlier step is the answer.
        return Ok(());
    }
    if let Some(torque) = &problem.known.torque {
        of_torque(torque, Some(&done), trial);
    }
    let Some(claim) = done.solved.answer.certified().and_then(Claim::new) else { return Ok(()) };
    if let Some(column) = &problem.known.column {
        of_column(column, &claim, trial);
    }
    if let (Some(force), Some(interval)) =
        (problem.known.force, claim.solution.bounds.and_then(|bounds| bounds.contact_force.ok()))
    {
        let slack = ROUNDING * force.abs();
        trial.say(Promise::Force, interval[0] <= force + slack && force <= interval[1] + slack, || {
            format!("the force {force:e} is not within {interval:?}")
        });
    }
    let fine = if problem.comparable && problem.nested { finer_solution(&claim, trial) } else { None };
    let fine = fine.as_ref().and_then(Claim::new);
    if let Some(fine) = &fine {
        of_finer(&claim, fine, trial);
    }
    if problem.comparable {
        of_other(problem, folder, (&claim, fine.as_ref()), trial);
    }
    of_frozen(&claim, trial);
    of_field(problem, &done, (&claim, fine.as_ref()), trial);
    of_sweep(problem, &source, &done, folder, trial);
    Ok(())
}

/// Judges a run without a report: an exit status of its own, and a message that says more.
fn refused(failure: &Failure, trial: &mut Trial) {
    trial.code = failure.code;
    trial.reason = failure.findings().iter().map(|f| f.found.as_str()).collect();
    let said = || format!("{}: {:?}", failure.code, failure.findings());
    trial.say(Promise::Status, matches!(failure.code, 3 | 4), said);
    let findings = failure.findings();
    let spoken = findings.iter().all(|f| !f.found.is_empty()) && !findings.is_empty();
    trial.say(Promise::Words, spoken, said);
}

/// Judges the status, the words and the numbers of a report.
///
/// * `load`: a typical force.
fn of_report(done: &Done, load: f64, trial: &mut Trial) {
    let (report, text) = (&done.report, verdict::verdict(&done.report));
    let status = &report.status;
    let valid = report.valid_certificate().is_some();
    let residual = report.coulomb.as_ref().is_some_and(|coulomb| coulomb.e_b.is_some());
    let fits = match status.code {
        0 => {
            matches!(status.word.as_str(), "converged" | "completed") && (valid || residual)
                || status.word == "residual_reached" && residual
        }
        4 => !report.steps.is_empty(),
        5 => matches!(status.word.as_str(), "max_iterations" | "diverged" | "stalled"),
        // The certificate of the mesh before may be valid.
        6 => matches!(status.word.as_str(), "target_missed" | "not_certified") || !valid && !residual,
        _ => false,
    };
    trial.say(Promise::Status, fits, || format!("{status:?}, valid: {valid}"));
    let json = report.to_json();
    trial.say(Promise::Words, json.is_ok(), || format!("{:?}", json.err()));
    let says = text.contains("certified error") && !text.contains("NOT certified");
    let bounds = report.certificate.as_ref().is_some_and(|c| c.bounds.energy_norm.is_some());
    trial.say(Promise::Words, says == valid && (valid || !bounds), || format!("valid: {valid}, and {text}"));
    if let Some(found) = report.certificate.as_ref().filter(|c| c.valid) {
        let [Some(e), Some(dis), Some(nndd)] = [found.e_cre, found.eta_dis, found.eta_nndd] else {
            trial.say(Promise::Words, false, || format!("no numbers in {found:?}"));
            return;
        };
        let [a, b] = [found.split.discretisation, found.split.algebraic].map(|x| x.unwrap_or(f64::NAN));
        let sums = (a.hypot(b) - e).abs() <= 1e-9 * e && [dis, nndd, a, b].iter().all(|x| *x >= 0.0);
        let fair = match (found.relative, found.relative_guaranteed) {
            (Some(relative), Some(guaranteed)) => guaranteed >= relative,
            (None, Some(_)) => false,
            _ => true,
        };
        trial.say(Promise::Words, sums && fair, || format!("{found:?}"));
    }
    let results = &report.results;
    let forces = results.reactions.iter().flatten().flat_map(|r| [r.fx, r.fy]);
    let resultants = report.contact.iter().filter_map(|c| c.resultant.as_ref()).flatten().copied();
    let largest = forces.chain(resultants).chain(results.contact_force).fold(0.0f64, |m, x| m.max(x.abs()));
    // A run that is ended before contact has no forces but its loads, and the loads of a body may cancel.
    let largest = largest.max(load);
    for balance in results.balance.iter().flatten().filter(|_| status.code == 0) {
        let rest = balance[0].abs().max(balance[1].abs());
        trial.say(Promise::Balance, rest <= 1e-6 * largest, || format!("{balance:?} of {largest:e}"));
    }
    // Every load step meets the target of an adaptive run that says so.
    let met = done.case.adapt.as_ref().filter(|_| status.code == 0).map(|adapt| adapt.target.value());
    for step in &report.steps {
        let relative = step.certificate.as_ref().and_then(|c| c.relative);
        let relative = relative.or(step.coulomb.as_ref().and_then(|c| c.relative));
        let meets = met.zip(relative).is_none_or(|(target, relative)| relative <= target);
        trial.say(Promise::Steps, meets, || format!("{relative:?} with the target {met:?}"));
        let valid = step.certificate.as_ref().is_some_and(|c| c.valid) || step.coulomb.is_some();
        trial.say(Promise::Steps, step.status.code != 0 || valid, || format!("{:?}", step.status));
    }
}

/// Judges a run that is interrupted after its first mesh and resumed.
fn of_resume(source: &CaseText, done: &Done, out: &Path, trial: &mut Trial) {
    trial.runs += 2;
    let mut host = Quiet::new();
    host.meshes_until_stop = 1;
    let interrupted = run_and_write(source, out, &mut host).map(|report| report.status.code);
    let again = resume(source, out);
    let same = |again: &Done| {
        let (a, b) = (&again.report, &done.report);
        (a.certificate == b.certificate && a.results == b.results && a.adaptive == b.adaptive)
            && (a.coulomb == b.coulomb && a.status == b.status)
    };
    trial.say(Promise::Resume, again.as_ref().is_ok_and(same), || {
        format!("{interrupted:?}: {:?}", again.map(|again| (again.report.status, again.report.certificate)))
    });
}

/// Judges what is said of a torque on a pin: one that the polygon explains is left out, with its size; a larger one is not held.
///
/// * `done`: the run, if the program did not refuse it.
fn of_torque(torque: &Torque, done: Option<&Done>, trial: &mut Trial) {
    let Torque { loads: [torque, weight], angle } = *torque;
    // The moment of the polygon's normals, as a part of the weight.
    let of_polygon = 0.1 * angle * angle * weight + ROUNDING * torque.abs();
    let not_held = |reason: &str| reason.contains("is not held");
    if trial.code == 4 || not_held(&trial.reason) {
        trial.say(Promise::Status, torque != 0.0, || "without a torque a pin is held".to_owned());
        return;
    }
    let Some(certificate) = done.and_then(|done| done.report.valid_certificate()) else { return };
    let left_out: f64 = certificate.projected_load.iter().map(|of| of.load).sum();
    let rest = torque.abs() - left_out.abs();
    trial.say(Promise::Words, rest.abs() <= of_polygon, || format!("{left_out:e} of {torque:e} left out"));
    trial.say(Promise::Status, torque.abs() <= of_polygon, || {
        format!("a torque of {torque:e} beside {weight:e} is not left out by the error of the polygon")
    });
}

/// Judges against the exact displacements of a column.
fn of_column(column: &Column, claim: &Claim<'_>, trial: &mut Trial) {
    let exact: Vec<Vec<Vector>> =
        claim.bodies().iter().enumerate().map(|(b, body)| column.at(b, body)).collect();
    let error = distance(claim.bodies(), &claim.displacement, &exact);
    trial.above(Promise::Exact, "e_cre", claim.e_cre, error, ROUNDING * claim.norm);
    let zero: Vec<Vec<Vector>> = exact.iter().map(|u| vec![Vector::zeros(); u.len()]).collect();
    let norm = distance(claim.bodies(), &exact, &zero);
    let Some(bounds) = claim.solution.bounds else { return };
    // The loads do twice the elastic energy of work.
    for ([low, high], value) in [(bounds.energy_norm, norm), (bounds.potential_energy, -0.5 * norm * norm)] {
        let slack = ROUNDING * value.abs();
        trial.say(Promise::Exact, low <= value + slack && value <= high + slack, || {
            format!("{value:e} is not within [{low:e}, {high:e}]")
        });
    }
}

impl Column {
    fn at(&self, b: usize, body: &Body) -> Vec<Vector> {
        let (low, [across, along]) = self.blocks[b];
        let at = |x: &Vector| Vector::new(across * (x[0] - self.left), self.sunk[b] + along * (x[1] - low));
        body.mesh().points().iter().map(at).collect()
    }
}

/// Solves the problem of a claim on halved cells, if they are not too many.
fn finer_solution(claim: &Claim<'_>, trial: &mut Trial) -> Option<CertifiedSolution> {
    let halved = halve(&claim.solution.problem).ok()?;
    trial.runs += 1;
    solve(halved.problem, &Settings::default(), &mut Silent).ok()
}

/// Judges two claims of the same exact solution by intervals.
fn of_intervals(a: &Claim<'_>, b: &Claim<'_>, what: &str, trial: &mut Trial) {
    let (Some(x), Some(y)) = (a.solution.bounds, b.solution.bounds) else { return };
    // Halved cells have rounded coordinates; on one mesh there is nothing to allow for.
    let part = if same_meshes(a.bodies(), b.bodies()) { 0.0 } else { rounding(b.bodies()) };
    trial.meet(Promise::Norm, what, [x.energy_norm, y.energy_norm], part);
    trial.meet(Promise::Energy, what, [x.potential_energy, y.potential_energy], part);
    if let (Ok(x), Ok(y)) = (x.contact_force, y.contact_force) {
        trial.meet(Promise::Force, what, [x, y], part);
    }
}

/// Judges a claim against one on nested finer meshes: intervals, distance, and a finer admissible field as a witness.
fn of_finer(claim: &Claim<'_>, fine: &Claim<'_>, trial: &mut Trial) {
    of_intervals(claim, fine, "halved cells", trial);
    let problem = &claim.solution.problem;
    let Ok((coarse, carried)) = finer(problem.clone(), claim.displacement.clone(), 1) else { return };
    let apart = between((&coarse.bodies, &carried), (fine.bodies(), &fine.displacement));
    let both = claim.e_cre + fine.e_cre;
    let slack = rounding(fine.bodies()) * claim.norm;
    trial.above(Promise::Error, "finer field", both, apart, slack);
    let largest = claim.solution.estimate.as_ref().map_or("", |found| found.unchecked().parts.largest());
    // Bodies without strain energy, such as those that supports move, are apart by rounding alone.
    let strained = claim.solution.estimate.as_ref().is_none_or(|found| !found.holds_no_energy());
    let above_rounding = strained && apart > 1e3 * slack;
    trial.measured = Some(Measured { bound: claim.e_cre, distance: apart, above_rounding, largest });
    // On straight lines without friction the finer solution has the least energy of fields that hold this one.
    let straight = problem.contacts.iter().all(|pair| is_straight(pair) && !pair.friction.acts());
    if straight {
        let one = claim.e_cre + fine.eta_nndd;
        trial.above(Promise::Error, "finer solution", one, apart, slack);
    }
}

fn is_straight(pair: &ContactPair) -> bool {
    let pairs = pair.interface.pairs();
    pairs.iter().all(|p| p.normal == pairs[0].normal)
}

/// Judges the same problem by other settings.
fn of_other(
    problem: &Problem,
    folder: &Path,
    (claim, fine): (&Claim<'_>, Option<&Claim<'_>>),
    trial: &mut Trial,
) {
    let source = CaseText { text: problem.other.clone(), folder: folder.to_owned() };
    trial.runs += 1;
    let done = match run(&source, &folder.join("other"), &mut Quiet::new()) {
        Ok(done) => done,
        Err(failure) => {
            let said = || format!("other settings: {:?}", failure.findings());
            trial.say(Promise::Status, failure.code != 1, said);
            return;
        }
    };
    of_report(&done, problem.load, trial);
    if !done.report.steps.is_empty() && done.report.status.code != 0 {
        return;
    }
    let Some(other) = done.solved.answer.certified().and_then(Claim::new) else { return };
    // Of the same problem, if the meshes are the same or nested.
    if same_meshes(claim.bodies(), other.bodies()) {
        of_intervals(claim, &other, "other settings", trial);
        let apart = between((claim.bodies(), &claim.displacement), (other.bodies(), &other.displacement));
        let slack = ROUNDING * claim.norm;
        trial.above(Promise::Error, "other settings", claim.e_cre + other.e_cre, apart, slack);
        trial.above(Promise::Iteration, "other settings", claim.eta_nndd + other.eta_nndd, apart, slack);
    } else if problem.nested {
        of_intervals(claim, &other, "other settings and mesh", trial);
    }
    if let Some(fine) = fine {
        of_intervals(&other, fine, "other settings, halved cells", trial);
    }
    if problem.text.contains("[[step]]") && !problem.other.contains("[[step]]") {
        let bounds = [claim, &other].map(|c| c.solution.bounds.map_or([f64::NAN; 2], |b| b.potential_energy));
        trial.meet(Promise::Steps, "without steps", bounds, 0.0);
    }
}

/// Judges the bound of the mesh for a frozen λ: the pair of step 1 on halved cells is not farther away.
fn of_frozen(claim: &Claim<'_>, trial: &mut Trial) {
    let problem = &claim.solution.problem;
    let by_iteration = matches!(claim.solution.method, Method::Nndd(_));
    let pair = problem.plain_pair().filter(|_| by_iteration && suits_iteration(problem));
    let Some(pair) = pair else { return };
    let straight = is_straight(pair);
    let Some(eta_dis) = claim.solution.rows.last().and_then(|row| row.eta_dis).filter(|_| straight) else {
        return;
    };
    let frozen = || -> Made<f64> {
        let halved = halve(problem)?;
        let u = carried(problem, &halved, &claim.displacement);
        // λ is the trace of its carrier, also on edges at removed ends, which have one pair of nodes only.
        let finer = &halved.problem.contacts[0];
        let (side, sign) = (finer.roles.imposed(), [1.0, -1.0][finer.roles.imposed()]);
        let field = &u[finer.partners()[side].place(u.len())];
        let trace = |p: &NodePair| sign * field[p.nodes[side]].dot(&p.normal);
        let lambda = finer.interface.pairs().iter().map(trace).collect();
        let prepared = PreparedProblem::new(halved.problem)?;
        let mut method = NnddSettings::default();
        method.max_iterations = 1;
        let method = Method::from(method);
        let found =
            nndd::solve_from(&prepared.system(), Start { lambda, active: None }, &method, &mut Never)?;
        Ok(distance(
            &prepared.problem().bodies,
            &u,
            &prepared.displacements(&found.last.fields(&prepared.system())),
        ))
    };
    if let Ok(apart) = frozen() {
        trial.above(Promise::Mesh, "frozen λ", eta_dis, apart, ROUNDING * claim.norm);
    }
}

/// Judges the certificate of a field that is wrong: noise on the computed one, or on the exact one.
fn of_field(
    problem: &Problem,
    done: &Done,
    (claim, fine): (&Claim<'_>, Option<&Claim<'_>>),
    trial: &mut Trial,
) {
    let solved = &claim.solution.problem;
    let mut random = Random::new(problem.number);
    let bonded = solved.contacts.iter().any(ContactPair::is_bonded);
    let cut = solved.bodies.iter().any(|body| !body.cuts().is_empty());
    if bonded || cut || solved.has_friction() || random.unit() > 0.3 {
        return;
    }
    let Ok(own) = done.case.build_bodies() else { return };
    let column = problem.known.column.as_ref();
    let mut field = match column {
        Some(column) => own.iter().enumerate().map(|(b, body)| column.at(b, body)).collect(),
        None if same_meshes(&own, &solved.bodies) => claim.displacement.clone(),
        None => return,
    };
    let largest = field.iter().flatten().fold(0.0f64, |m, u: &Vector| m.max(u.amax()));
    let size = largest * 10f64.powf(-9.0 + 8.0 * random.unit());
    let exact = field.clone();
    field.iter_mut().flatten().for_each(|u| *u += size * Vector::new(random.signed(), random.signed()));
    let pressures: Option<Vec<Vec<f64>>> = (random.unit() < 0.4).then(|| {
        let of_pair = |pair: &ContactPair| {
            let nodes = own[pair.body].mesh().points().len();
            (0..nodes).map(|_| claim.norm * random.unit()).collect()
        };
        solved.contacts.iter().map(of_pair).collect()
    });
    trial.runs += 1;
    let found = certify::of_fields(&done.case, &done.problem, &field, pressures.as_deref());
    let bound = match found {
        Ok(found) => found.bound(),
        Err(failure) => {
            trial.say(Promise::Field, failure.code != 1, || format!("{:?}", failure.findings()));
            return;
        }
    };
    let Some(bound) = bound else { return };
    if column.is_some() {
        let error = distance(&own, &field, &exact);
        trial.above(Promise::Field, "exact field", bound, error, ROUNDING * claim.norm);
        return;
    }
    let apart = distance(&own, &field, &claim.displacement);
    trial.above(Promise::Field, "computed field", bound + claim.e_cre, apart, ROUNDING * claim.norm);
    if let (Some(fine), Ok((finer, carried))) = (fine, finer(done.problem.clone(), field, 1)) {
        let apart = distance(&finer.bodies, &carried, &fine.displacement);
        let slack = rounding(fine.bodies()) * claim.norm;
        trial.above(Promise::Field, "finer field", bound + fine.e_cre, apart, slack);
    }
}

/// Judges a sweep: a bound that it prints is one.
fn of_sweep(problem: &Problem, source: &CaseText, done: &Done, folder: &Path, trial: &mut Trial) {
    let theta = 0.1 + 0.8 * Random::new(problem.number + 1).unit();
    if !problem.number.is_multiple_of(8)
        || !done.case.steps.is_empty()
        || done.case.adapt.is_some()
        || !suits_iteration(&done.problem)
    {
        return;
    }
    let mut options = SweepOptions::new(Path::new("case.toml"), &format!("solver.theta=[{theta:?}]"));
    options.set = vec!["solver.method=nndd".into()];
    options.out = Some(folder.join("sweep"));
    trial.runs += 2;
    let Ok(swept) = sweep_of(source, &options, &mut Quiet::new()) else { return };
    let settings = format!(
        "solver.method = \"nndd\"\nsolver.theta = {theta:?}\nsolver.max_iterations = 3\nsolver.stop.criterion = \"iterations\"\n"
    );
    let kept = problem.text.lines().filter(|line| {
        let own = ["solver.method", "solver.theta", "solver.max_iterations", "solver.stop"];
        !own.iter().any(|key| line.starts_with(key))
    });
    let text = kept.fold(String::new(), |text, line| text + line + "\n");
    let text = text.replacen("schema = 1\n", &format!("schema = 1\n{settings}"), 1);
    let alone = CaseText { text, folder: folder.to_owned() };
    let Ok(alone) = run(&alone, &folder.join("alone"), &mut Quiet::new()) else { return };
    let valid = alone.report.valid_certificate().is_some();
    for row in swept.record.panels.iter().flat_map(|panel| &panel.rows) {
        let bound = row.iteration.e_cre;
        let expected = alone.report.iterations.last().and_then(|row| row.e_cre).filter(|_| valid);
        trial.say(Promise::Sweep, row.valid == valid && bound == expected, || {
            format!("{bound:?} in the sweep, valid: {}, {expected:?} alone, valid: {valid}", row.valid)
        });
    }
}

//! The steps every test shares: factorise, iterate, recover, certify, measure.

use crate::model::{Body, ContactProblem, Gap, Made, SymTensor2, Vector, pair};
use contact_geometry::ContactNormal;
use contact_geometry::common_refinement::{Changes, common_refinement};
use contact_qp::QpSettings;
use cre_estimator::{EquilibratedStress, Estimate, EstimatorError, Relaxation, estimate_with};
use fem_core::assembly::System;
use fem_core::condensation::CondensedBody;
use fem_core::geometry::cross;
use fem_core::interface::{ContactState, InterfaceSide, PairState};
use fem_core::norm::energy_norm_squared;
use fem_core::prepared::{AssemblyMotion, PreparedProblem};
use fem_core::quadrature::RADON7;
use nndd::stopping::{Decision, EtaNndd, Never, StoppingCriterion};
use nndd::{ExactSolution, Iterate, NewtonSettings, NnddError, NnddSettings, NnddSolution};

/// Assembles and factorises a body that is known to be sound.
///
/// # Panics
/// If it is not.
pub fn condense(body: &Body, side: &InterfaceSide) -> CondensedBody {
    let system = System::assemble(body, side)
        .unwrap_or_else(|e| unreachable!("the reference body cannot be assembled: {e}"));
    CondensedBody::factorise(system, body.mesh().points())
        .unwrap_or_else(|e| unreachable!("the reference body cannot be factorised: {e}"))
}

/// Pairs the bodies of a problem in the other order: the surface "top" first, "bottom" second. The gap is constant.
///
/// # Panics
/// If the surfaces cannot be paired.
pub fn exchanged(problem: ContactProblem) -> ContactProblem {
    let gap = Gap::Given(problem.contacts[0].interface.pairs()[0].gap.into());
    let Ok([first, second]) = <[Body; 2]>::try_from(problem.bodies) else { unreachable!("two bodies") };
    pair([second, first], ["top", "bottom"], &gap)
        .unwrap_or_else(|e| unreachable!("the surfaces cannot be paired in the other order: {e}"))
}

/// Prepares a reference problem.
///
/// # Panics
/// If its bodies cannot be factorised.
pub fn prepare(problem: &ContactProblem) -> PreparedProblem {
    PreparedProblem::new(problem.clone())
        .unwrap_or_else(|e| unreachable!("the reference problem cannot be prepared: {e}"))
}

/// Solves a body without interface.
pub fn solve_alone(body: &Body) -> Vec<Vector> {
    condense(body, &InterfaceSide::default()).displacement_from_force(&[])
}

/// Recovers the displacements of an iteration.
pub fn displacements(prepared: &PreparedProblem, iterate: &Iterate) -> Vec<Vec<Vector>> {
    prepared.displacements(&iterate.fields(&prepared.system()))
}

/// Puts an exact solution together with its displacements.
pub fn state_of<'a>(exact: &'a ExactSolution, displacement: &'a [Vec<Vector>]) -> ContactState<'a> {
    let pairs = exact.contact_force.iter().zip(&exact.opening).zip(&exact.friction);
    let contacts = pairs.map(|((contact_force, opening), friction)| PairState {
        contact_force,
        opening,
        friction_force: &friction.force,
        slip: &friction.slip,
    });
    ContactState {
        displacement: displacement.iter().map(Vec::as_slice).collect(),
        contacts: contacts.collect(),
    }
}

/// Returns the motion that the loads of a problem cause and nothing resists.
///
/// # Panics
/// If the problem is held, or solved.
pub fn unresisted(problem: &ContactProblem) -> AssemblyMotion {
    let solved = nndd::solve_exactly(&prepare(problem).system(), &QpSettings::default());
    match (solved, certified_contact::support(problem).map(|support| support.unresisted)) {
        (Err(NnddError::NotHeld { .. }), Ok(Some(motion))) => motion,
        other => unreachable!("{other:?}"),
    }
}

/// Certifies an iteration by EET alone.
///
/// # Errors
/// None, for finite numbers.
pub fn certify(prepared: &PreparedProblem, iterate: &Iterate) -> Result<Estimate, EstimatorError> {
    certify_with(prepared, iterate, Relaxation::NONE)
}

/// Certifies an iteration.
///
/// # Errors
/// None, for finite numbers.
pub fn certify_with(
    prepared: &PreparedProblem,
    iterate: &Iterate,
    relaxation: Relaxation,
) -> Result<Estimate, EstimatorError> {
    let u = displacements(prepared, iterate);
    let state = ContactState::between([&u[0], &u[1]], &iterate.contact.normal_reaction, &iterate.opening);
    estimate_with(prepared, &state, relaxation)
}

/// Pairs the surfaces "bottom" and "top" of two bodies without gap, after a common refinement.
///
/// # Errors
/// Surfaces without a common refinement.
pub fn refined_in_common(bodies: [Body; 2]) -> Made<(ContactProblem, Option<Changes>)> {
    paired_in_common(bodies, ["bottom", "top"], &Gap::Given(0.0.into()), ContactNormal::Averaged)
}

/// Pairs two surfaces after a common refinement.
///
/// # Errors
/// Surfaces without a common refinement.
pub fn paired_in_common(
    bodies: [Body; 2],
    surfaces: [&str; 2],
    gap: &Gap,
    normal: ContactNormal,
) -> Made<(ContactProblem, Option<Changes>)> {
    let common = common_refinement(bodies, surfaces, normal)?;
    let interface = contact_geometry::pair_refined(&common, surfaces, gap, normal)?;
    Ok((ContactProblem::between(common.bodies, interface), common.changes))
}

struct Recorder {
    inner: EtaNndd,
    iterates: Vec<Iterate>,
}

impl StoppingCriterion for Recorder {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn std::error::Error + Send + Sync>> {
        self.iterates.push(iterate.clone());
        self.inner.check(iterate)
    }
}

/// Iterates from λ = 0 until `η_NNDD ≤ tolerance · η_NNDD(1)`, and keeps every iteration.
///
/// # Errors
/// Settings that make no sense.
pub fn iterates(
    prepared: &PreparedProblem,
    settings: &NnddSettings,
    tolerance: f64,
) -> Result<(NnddSolution, Vec<Iterate>), NnddError> {
    let mut recorder = Recorder { inner: EtaNndd::new(tolerance), iterates: Vec::new() };
    let lambda = vec![0.0; prepared.rows()];
    let solution = nndd::solve(&prepared.system(), lambda, settings, &mut recorder)?;
    Ok((solution, recorder.iterates))
}

/// Takes the admissible pair of one given λ: step 1 alone.
///
/// # Errors
/// λ of the wrong length.
pub fn pair_of(prepared: &PreparedProblem, lambda: Vec<f64>) -> Result<Iterate, NnddError> {
    let mut settings = NnddSettings::paper(0.4);
    settings.max_iterations = 1;
    Ok(nndd::solve(&prepared.system(), lambda, &settings, &mut Never)?.last)
}

/// Solves the discrete contact problem by the interface Newton method.
///
/// # Errors
/// None, for sound problems.
pub fn newton(prepared: &PreparedProblem) -> Result<Iterate, NnddError> {
    let lambda = vec![0.0; prepared.rows()];
    Ok(nndd::solve(&prepared.system(), lambda, NewtonSettings::default(), &mut Never)?.last)
}

/// Computes `‖u‖` and `‖u − v‖` of two pairs of displacement fields, square roots of energies.
pub fn norm_and_distance(problem: &ContactProblem, u: &[Vec<Vector>], v: &[Vec<Vector>]) -> [f64; 2] {
    let mut squared = [0.0; 2];
    for (b, body) in problem.bodies.iter().enumerate() {
        squared[0] += energy_norm_squared(body, &u[b]);
        squared[1] += fem_core::norm::energy_distance_squared(body, &u[b], &v[b]);
    }
    squared.map(f64::sqrt)
}

/// Computes the largest difference of two arrays over the largest entry of the second.
pub fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let largest =
        |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, |m: f64, x| if x.is_nan() { x } else { m.max(x) });
    let difference = largest(&mut a.iter().zip(b).map(|(a, b)| (a - b).abs()));
    let scale = largest(&mut b.iter().map(|b| b.abs()));
    if difference == 0.0 && a.len() == b.len() { 0.0 } else { difference / scale }
}

/// Computes the observed order of convergence between two meshes whose cells differ by a factor 2.
pub fn rate(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

/// Computes `‖σ − τ‖²` of an equilibrated stress against a known one, in the complementary norm, J/m.
pub fn stress_error_squared(
    body: &Body,
    stress: &EquilibratedStress,
    exact: impl Fn(Vector) -> SymTensor2,
) -> f64 {
    let mesh = body.mesh();
    let mut sum = 0.0;
    for t in 0..mesh.cells().len() {
        let corners = mesh.corners(t);
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        for (k, values) in stress.cell(body, t).iter().enumerate() {
            let points = [corners[k], corners[(k + 1) % 3], centre];
            for (l, w) in RADON7 {
                let x = l[0] * points[0] + l[1] * points[1] + l[2] * points[2];
                let tau = values[0].scaled(l[0]).plus(values[1].scaled(l[1])).plus(values[2].scaled(l[2]));
                let d = tau.minus(exact(x));
                sum += w * mesh.measure(t) / 3.0 * body.material(t).complementary(d, d);
            }
        }
    }
    sum
}

/// Computes the largest unbalanced force and moment of any triangle under its edge loads and the body force, over
/// the largest edge load (moments over that times the largest edge as well).
pub fn cell_imbalance(body: &Body, stress: &EquilibratedStress) -> [f64; 2] {
    let mesh = body.mesh();
    let (mut force, mut moment, mut largest, mut size) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for t in 0..mesh.cells().len() {
        let corners = mesh.corners(t);
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        let mut total = mesh.measure(t) * body.force(t).mean;
        let mut turn = 0.0;
        for (k, ends) in stress.cell_loads(body, t).iter().enumerate() {
            let points = [corners[k], corners[(k + 1) % 3]];
            size = size.max(fem_core::geometry::norm(points[1] - points[0]));
            for m in 0..2 {
                // Of a traction linear along the edge: half the end values, two thirds of the way to that end.
                let arm = (2.0 * points[m] + points[1 - m]) / 3.0 - centre;
                let half = 0.5 * ends[m];
                total += half;
                turn += cross(arm, half);
                largest = largest.max(fem_core::geometry::norm(ends[m]));
            }
        }
        force = force.max(fem_core::geometry::norm(total));
        moment = moment.max(turn.abs());
    }
    [force / largest, moment / (largest * size)]
}

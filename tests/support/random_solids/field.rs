//! Fields that are wrong, certified as those of other programs, and judged by runs on nested meshes.

use super::judge::{Claim, ROUNDING, distance};
use super::{Problem, Trial};
use crate::matrix::Promise;
use crate::random::Random;
use cre_estimator::{AdmissibleBody, EstimatorError, FieldCertificate, certify};
use fem_core::interface::{ContactPair, ContactProblem};
use fem_core::mesh_field::MeshField;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nalgebra::Vector3;

/// A field of the exact method has the bound of its run to this part of the bound without relaxation, whose steps are in single precision; its contact
/// forces are computed again from the field.
const SAME: f64 = 1e-6;

/// The displacements of each body.
type Fields = Vec<Vec<Vector3<f64>>>;

/// Judges certificates of fields with errors, and of the field of the exact method as it is.
pub(super) fn judge(problem: &Problem, claims: &[Claim], trial: &mut Trial) {
    let mut random = Random::new(17 * problem.number + 5);
    if let Some(exact) = claims.iter().find(|claim| claim.halved == 1) {
        own_field(problem, exact, trial);
    }
    let Some(first) = claims.iter().find(|claim| claim.halved == 0) else { return };
    let Some(fine) = claims.iter().max_by_key(|claim| claim.halved) else { return };
    let Ok(made) = problem.assembly.problem(0) else { return };
    for _ in 0..2 {
        let field = with_errors(&made, &first.displacement, &mut random);
        let pressures = (random.unit() < 0.3).then(|| random_pressures(&made, first.norm, &mut random));
        let Some(found) = certified(&made, &field, pressures.as_deref(), first, trial) else { continue };
        let Some(bound) = found.bound() else { continue };
        trial.fields += 1;
        let slack = ROUNDING * fine.norm.max(found.estimate.energy_norm());
        let inexact = if fine.halved == 0 { fine.e_cre } else { fine.eta_nndd + fine.round_off };
        let Some(apart) = distance(problem, (&field, 0), fine) else { continue };
        trial.say(Promise::Field, apart <= bound + inexact + slack, || {
            format!(
                "{apart:e} apart, bound {bound:e}, that of the other field {inexact:e}, change {:e}",
                found.change
            )
        });
    }
}

/// Judges that the certificate of the field of a run is the certificate of the run.
fn own_field(problem: &Problem, exact: &Claim, trial: &mut Trial) {
    let Ok(made) = problem.assembly.problem(exact.halved) else { return };
    let Some(found) = certified(&made, &exact.displacement, None, exact, trial) else { return };
    if !is_plain(&made) || found.estimate.holds_no_energy() {
        return;
    }
    // A field is given in double precision: with contrasts of moduli its forces may not balance well enough, and then there is no bound.
    let Some(bound) = found.bound() else { return };
    let rounding = exact.round_off + found.estimate.round_off + exact.eta_nndd + exact.last_digit;
    // Nodes can be lifted along several normals, and which one is taken first may hang on the last digit of an opening.
    let without = |bound: f64, lift: f64| (bound * bound - lift * lift).max(0.0).sqrt();
    let lift = found.estimate.unchecked().parts.lift;
    let apart = without(bound, lift) - without(exact.e_cre, exact.lift);
    let relaxed =
        |body: &AdmissibleBody<Solid>| body.relaxation.energy_history.first().copied().unwrap_or(0.0);
    let unrelaxed = found.estimate.pair.bodies.iter().map(relaxed).sum::<f64>().sqrt();
    let same = apart.abs() <= SAME * exact.e_cre.max(unrelaxed) + 10.0 * rounding;
    trial.say(Promise::Field, same, || {
        format!("own field: {bound:e}, its run {:e}, change {:e}", exact.e_cre, found.change)
    });
}

/// Certifies a field; `None` with a verdict if it is refused.
fn certified(
    made: &ContactProblem<Solid>,
    field: &Fields,
    pressures: Option<&[Vec<f64>]>,
    claim: &Claim,
    trial: &mut Trial,
) -> Option<FieldCertificate<Solid>> {
    trial.runs += 1;
    let prepared = match PreparedProblem::new(made.clone()) {
        Ok(prepared) => prepared,
        Err(error) => {
            trial.say(Promise::Field, false, || format!("solved, and not prepared: {error}"));
            return None;
        }
    };
    let given: Vec<MeshField<'_, Solid>> =
        made.bodies.iter().zip(field).map(|(body, u)| MeshField::new(body.mesh(), u)).collect();
    match certify(&prepared, &given, pressures, claim.relaxation) {
        Ok(found) => Some(found),
        Err(error) => {
            // The motion of a free plane is not among the displacements.
            let refused = matches!(error, EstimatorError::FreeObstacle { .. });
            trial.say(Promise::Field, refused, || error.to_string());
            None
        }
    }
}

/// Adds errors to a field: of any size at all nodes or at those without support, smooth ones, those of few digits, or a small turn.
fn with_errors(made: &ContactProblem<Solid>, field: &Fields, random: &mut Random) -> Fields {
    let mut field = field.clone();
    let largest = field.iter().flatten().fold(0.0f64, |most, u| most.max(u.amax()));
    let size = largest * 10f64.powf(-9.0 + 9.0 * random.unit());
    let kind = random.integer(0, 4);
    let turn = Vector3::from_fn(|_, _| random.signed());
    for (body, field) in made.bodies.iter().zip(&mut field) {
        let extent = body.mesh().diagonal();
        for (node, u) in field.iter_mut().enumerate() {
            let is_free = body.node_constraints()[node].supported().is_none();
            let x = body.mesh().points()[fem_core::mesh::id::NodeId::new(node)] / extent;
            match kind {
                0 => *u += size * Vector3::from_fn(|_, _| random.signed()),
                1 if is_free => *u += size * Vector3::from_fn(|_, _| random.signed()),
                2 if is_free => *u *= 1.0 + size / largest.max(f64::MIN_POSITIVE),
                3 => *u = u.map(|value| f64::from(value as f32)),
                4 if is_free => *u += size * turn.cross(&x),
                _ => {}
            }
        }
    }
    field
}

/// Draws pressures at the pairs, also negative ones, which count as none.
fn random_pressures(made: &ContactProblem<Solid>, size: f64, random: &mut Random) -> Vec<Vec<f64>> {
    let mut of_pair =
        |pair: &ContactPair<Solid>| pair.interface.pairs().iter().map(|_| size * random.signed()).collect();
    made.contacts.iter().map(&mut of_pair).collect()
}

/// Tells if the contact forces follow from the field: no node belongs to two pairs or to a rigid side.
fn is_plain(made: &ContactProblem<Solid>) -> bool {
    let mut used: Vec<(usize, usize)> = Vec::new();
    for pair in &made.contacts {
        for (side, b) in pair.elastic_sides() {
            used.extend(pair.interface.pairs().iter().map(|p| (b, p.nodes[side].index())));
        }
    }
    let count = used.len();
    used.sort_unstable();
    used.dedup();
    used.len() == count && made.bodies.iter().all(|body| body.rigid_sides().is_empty())
}

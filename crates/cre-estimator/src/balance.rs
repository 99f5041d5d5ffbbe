//! Contact pressures and forces that keep floating bodies in balance.
//!
//! A body that its supports do not hold is in equilibrium only if the pressure balances its loads exactly, moments
//! included. `p_i = r²_i/ℓ_i` does not, since `ℓ ≠ M` at ends and on graded meshes. The nearest admissible pressure is
//! ```math
//! \min_p \sum_i ℓ_i (p_i - r^2_i/ℓ_i)^2, \qquad p ≥ 0, \qquad C p = e                                         \qquad (31)
//! ```
//! with one row per rigid motion `R` of a floating body: `C p` is the work of the pressure along it, `−e` that of the loads.
//! Where the bodies are far apart, the pressure stays zero if the others can keep the balance.

use crate::error::EstimatorError;
use crate::pressure;
use contact_qp::{IndependentRows, nearest_balanced};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactEdge, ContactState};
use fem_core::prepared::PreparedProblem;

/// Forces on a body below this fraction of those on another one are not resolved beyond it: the balance is checked to 1e-10.
const LIGHTLY_LOADED: f64 = 1e-6;

/// The nearest pressure in balance is looked for among the pairs that carry a force if on all pairs `∫ p o` would be this many
/// times larger.
const DEAR: f64 = 2.0;

/// The pressure of an admissible stress at the pairs of each contact line.
#[derive(Clone, Debug)]
pub(crate) struct Pressure {
    /// At each pair, ≥ 0, Pa.
    pub(crate) by_pair: Vec<Vec<f64>>,
    /// Its change against `r²_i/ℓ_i`, relative, in the norm of (31); 0 if nothing floats.
    pub(crate) shift: f64,
    /// The largest resultant that is left on a floating body, relative to the forces on it; 0 if nothing floats.
    pub(crate) imbalance: f64,
}

/// Computes the admissible pressure of a state: `r²_i/ℓ_i`, or the nearest one in balance, (31). If nothing is in balance, it is
/// `r²_i/ℓ_i` with its imbalance.
///
/// # Errors
/// A programme that is rejected.
pub(crate) fn pressure(
    prepared: &PreparedProblem,
    state: &ContactState<'_>,
) -> Result<Pressure, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let of_pair =
        |k: usize| pressure::nodal_pressure(&contacts[k].interface, state.contacts[k].contact_force);
    let by_pair: Vec<Vec<f64>> = (0..contacts.len()).map(of_pair).collect();
    if prepared.rigid_motions().is_empty() {
        return Ok(Pressure { by_pair, shift: 0.0, imbalance: 0.0 });
    }
    let target: Vec<f64> = by_pair.iter().flatten().copied().collect();
    let weights = lengths(prepared);
    let rows = Rows::new(prepared, |k, traction| pressure_work(&contacts[k].interface, traction));
    let independent = IndependentRows::new(&rows.matrix, &rows.loads);
    let IndependentRows { rows: matrix, right_side, .. } = &independent;
    let found = nearest_balanced(&target, &weights, matrix, right_side, None)?;
    let Some(mut found) = found else {
        return Ok(Pressure { by_pair, shift: 0.0, imbalance: rows.imbalance(prepared, &target) });
    };
    // A little pressure where the bodies are far apart costs much in 2∫ p o.
    let cost = |pressure: &[f64]| -> f64 {
        let of_pair = |(k, p): (usize, Vec<f64>)| -> f64 {
            let (interface, opening) = (&contacts[k].interface, state.contacts[k].opening);
            let mean = |edge: &ContactEdge| 0.5 * edge.openings(opening).iter().sum::<f64>();
            let middle: Vec<f64> = interface.edges().iter().map(mean).collect();
            let edge_pressure = pressure::edge_pressure(interface, &p);
            pressure::contact_terms(interface, &edge_pressure, opening, &middle).iter().sum()
        };
        split(prepared, pressure).into_iter().enumerate().map(of_pair).sum()
    };
    let loaded: Vec<bool> = target.iter().map(|p| *p > 0.0).collect();
    if cost(&found.values) > DEAR * cost(&target)
        && let Some(near) = nearest_balanced(&target, &weights, matrix, right_side, Some(&loaded))?
        && cost(&found.values) > DEAR * cost(&near.values)
    {
        found = near;
    }
    let size = |values: &mut dyn Iterator<Item = f64>| {
        values.zip(&weights).map(|(v, w)| w * v * v).sum::<f64>().sqrt()
    };
    let change = size(&mut found.values.iter().zip(&target).map(|(p, t)| p - t));
    let whole = size(&mut target.iter().copied());
    Ok(Pressure {
        shift: if change > 0.0 { change / whole.max(change) } else { 0.0 },
        imbalance: rows.imbalance(prepared, &found.values),
        by_pair: split(prepared, &found.values),
    })
}

/// Computes the contact forces nearest to those of a state that balance the floating bodies, N/m: on the pairs that carry
/// a force, or on all pairs if those cannot. The given ones if nothing floats, or if no forces are in balance.
///
/// # Errors
/// A programme that is rejected.
pub(crate) fn forces(
    prepared: &PreparedProblem,
    state: &ContactState<'_>,
) -> Result<Vec<Vec<f64>>, EstimatorError> {
    let given: Vec<Vec<f64>> = state.contacts.iter().map(|pair| pair.contact_force.to_vec()).collect();
    if prepared.rigid_motions().is_empty() {
        return Ok(given);
    }
    let contacts = &prepared.problem().contacts;
    let target: Vec<f64> = given.iter().flatten().copied().collect();
    let weights: Vec<f64> = lengths(prepared).iter().map(|l| 1.0 / l).collect();
    let normal = |k: usize, motion: &[Vector]| -> Vec<f64> {
        contacts[k].interface.pairs().iter().zip(motion).map(|(pair, u)| u.dot(&pair.normal)).collect()
    };
    let rows = Rows::new(prepared, normal);
    let independent = IndependentRows::new(&rows.matrix, &rows.loads);
    let IndependentRows { rows: matrix, right_side, .. } = &independent;
    let loaded: Vec<bool> = target.iter().map(|p| *p > 0.0).collect();
    let mut found = nearest_balanced(&target, &weights, matrix, right_side, Some(&loaded))?;
    if found.is_none() {
        found = nearest_balanced(&target, &weights, matrix, right_side, None)?;
    }
    Ok(found.map_or(given, |found| split(prepared, &found.values)))
}

/// Lists the tributary lengths of all pairs, m.
fn lengths(prepared: &PreparedProblem) -> Vec<f64> {
    let contacts = prepared.problem().contacts.iter();
    contacts.flat_map(|of| of.interface.pairs().iter().map(|pair| pair.tributary_length)).collect()
}

fn split(prepared: &PreparedProblem, values: &[f64]) -> Vec<Vec<f64>> {
    let mut rest = values;
    let of_pair = |count: usize| {
        let (own, others) = rest.split_at(count.min(rest.len()));
        rest = others;
        own.to_vec()
    };
    prepared.problem().contacts.iter().map(|of| of.interface.pairs().len()).map(of_pair).collect()
}

/// Computes the work of a unit pressure at each pair on a motion along the normals, per unit pressure.
///
/// * `motion`: at the pairs, m.
fn pressure_work(interface: &fem_core::interface::ContactInterface, motion: &[Vector]) -> Vec<f64> {
    let mut work = vec![0.0; motion.len()];
    for edge in interface.edges() {
        let [i, j] = edge.pairs.map(|k| k as usize);
        let [a, b] = [i, j].map(|k| interface.pairs()[k].normal);
        let mut moved = [motion[i], motion[j]];
        if let Some(clamped) = edge.clamped {
            moved[clamped.end] = Vector::zeros();
        }
        // ∫ (p_i n_i φ_i + p_j n_j φ_j)·u, as in the nodal forces of the pressure.
        let at = [
            edge.length / 6.0 * a.dot(&(2.0 * moved[0] + moved[1])),
            edge.length / 6.0 * b.dot(&(moved[0] + 2.0 * moved[1])),
        ];
        // A bent edge carries the mean of its two ends.
        let at = if edge.bent { [0.5 * (at[0] + at[1]); 2] } else { at };
        work[i] += at[0];
        work[j] += at[1];
    }
    work
}

/// The rows of the balance: one per rigid motion of a floating body.
struct Rows {
    /// Row after row: the work on the motion's body of a unit value at each pair, signs reversed.
    matrix: Vec<f64>,
    /// `e`, the work of the loads.
    loads: Vec<f64>,
    count: usize,
}

impl Rows {
    /// * `work`: of unit values at the pairs of contact line `k` on a motion of the contact nodes.
    fn new(prepared: &PreparedProblem, work: impl Fn(usize, &[Vector]) -> Vec<f64>) -> Self {
        let problem = prepared.problem();
        let (mut matrix, mut loads) = (Vec::new(), Vec::new());
        for of in prepared.rigid_motions() {
            let moved = prepared.moved_by(of);
            for (k, contact) in problem.contacts.iter().enumerate() {
                let pairs = contact.interface.pairs();
                let Some(side) = contact.side_of(of.body) else {
                    matrix.extend(std::iter::repeat_n(0.0, pairs.len()));
                    continue;
                };
                let motion: Vec<Vector> = pairs.iter().map(|pair| moved[pair.nodes[side]]).collect();
                // The pressure acts against the normal on the first body.
                let sign = if side == 0 { 1.0 } else { -1.0 };
                matrix.extend(work(k, &motion).iter().map(|w| sign * w));
            }
            loads.push(of.load);
        }
        Self { matrix, loads, count: prepared.node_pairs() }
    }

    /// Computes the largest resultant of a floating body, over the sum of the sizes of all forces on it.
    ///
    /// * `pressure`: at all pairs, Pa.
    fn imbalance(&self, prepared: &PreparedProblem, pressure: &[f64]) -> f64 {
        let problem = prepared.problem();
        let lengths = lengths(prepared);
        let mut found = Vec::new();
        let rows = self.matrix.chunks_exact(self.count.max(1)).zip(&self.loads);
        for ((row, load), of) in rows.zip(prepared.rigid_motions()) {
            let moved = prepared.moved_by(of);
            let mut size = prepared.external_forces().get(of.body).map_or(load.abs(), |forces| {
                forces.iter().zip(&moved).map(|(f, u)| f.norm() * u.norm()).sum()
            });
            let mut first = 0;
            for contact in &problem.contacts {
                let pairs = contact.interface.pairs();
                if let Some(side) = contact.side_of(of.body) {
                    let forces = lengths[first..].iter().zip(&pressure[first..]);
                    let terms = pairs.iter().zip(forces);
                    size += terms.map(|(pair, (l, p))| l * p * moved[pair.nodes[side]].norm()).sum::<f64>();
                }
                first += pairs.len();
            }
            let rest = (row.iter().zip(pressure).map(|(c, p)| c * p).sum::<f64>() - load).abs();
            found.push((rest, size));
        }
        // A body almost without forces is compared with the others: its forces are the rounding of theirs.
        let least = LIGHTLY_LOADED * found.iter().fold(0.0, |largest: f64, (_, size)| largest.max(*size));
        let relative = |(rest, size): &(f64, f64)| if *rest > 0.0 { rest / size.max(least) } else { 0.0 };
        found.iter().map(relative).fold(0.0, f64::max)
    }
}

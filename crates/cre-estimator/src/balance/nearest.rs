//! The tractions in balance that are nearest to given ones: within given limits of friction, or within the cones of Coulomb's.

use super::tractions::{LineTractions, Tractions};
use super::{Rows, admissible_limits};
use crate::error::EstimatorError;
use crate::pressure;
use crate::recovery::Recovery;
use contact_qp::{BoxQp, Disc, MatrixView, QpSettings, SparseRows, nearest_balanced, solve_box};
use fem_core::interface::{ContactFacet, ContactPair, ContactState};
use fem_core::mesh::id::FacetId;
use fem_core::prepared::PreparedProblem;
use std::collections::BTreeMap;

/// Limits of Coulomb friction that change by this fraction of the largest one agree, after at most this many changes.
const AGREED: f64 = 1e-14;
const MOST_CONES: usize = 60;

/// Openings count in the choice of the pressure in balance if `∫ p o` of the nearest one is this many times that of the given one.
const DEAR: f64 = 2.0;

/// They count a tenth of that, and so on down to this share, if their pressures are so large that no balance is found beside them.
const LEAST_SHARE: f64 = 1e-4;

/// The bounds of pressure and friction, Pa, or of their forces, N/m.
///
/// * `limits`: of friction, by pair, see [`LineTractions::limits`]; `allowed`: which pressures may be positive; `None`: all.
pub(super) fn bounds<S: Recovery>(
    prepared: &PreparedProblem<S>,
    tractions: &Tractions,
    limits: &[Vec<f64>],
    allowed: Option<&[bool]>,
) -> [Vec<f64>; 2] {
    let (mut lower, mut upper) = (vec![0.0; tractions.count()], vec![f64::INFINITY; tractions.count()]);
    for ((pair, line), limits) in prepared.problem().contacts.iter().zip(&tractions.lines).zip(limits) {
        for k in 0..line.count() {
            let place = line.start + k;
            if let Some(limit) = line.disc_of(&pair.interface, k).and_then(|disc| limits.get(disc)) {
                (lower[place], upper[place]) = (-limit, *limit);
            } else if line.is_idle(k) || allowed.is_some_and(|allowed| !allowed[place]) {
                upper[place] = 0.0;
            }
        }
    }
    [lower, upper]
}

/// Lists the discs of friction in space.
///
/// * `limits`: of friction, by pair, see [`LineTractions::limits`].
pub(super) fn discs<S: Recovery>(
    contacts: &[ContactPair<S>],
    tractions: &Tractions,
    limits: &[Vec<f64>],
) -> Vec<Disc> {
    let of_pair = |((pair, line), limits): ((&ContactPair<S>, &LineTractions), &Vec<f64>)| {
        let nodes = pair.interface.pairs().len();
        let own = line.start + line.rows;
        let disc = |(k, radius): (usize, &f64)| {
            let (first, count) = match k.checked_sub(nodes) {
                None => (line.start + nodes + k, nodes),
                Some(k) => (own + line.facets.len() + k, line.facets.len()),
            };
            Disc { unknowns: [first, first + count], radius: *radius }
        };
        limits.iter().enumerate().filter(|_| !S::ONE_TANGENT).map(disc).collect::<Vec<_>>()
    };
    contacts.iter().zip(&tractions.lines).zip(limits).flat_map(of_pair).collect()
}

/// Subtracts from pressures those that would close the openings `o`, about `E o/L` over the loaded length `L`. The pressure in balance that is nearest to
/// the rest makes the energy of the change, about `L/E ∑ ℓ (p − t)²`, small together with the work on the openings, `2 ∑ ℓ p o`.
///
/// * `target`: pressure and friction, `t`, Pa; `share`: of these pressures.
fn less_openings<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    tractions: &Tractions,
    target: &[f64],
    share: f64,
) -> Vec<f64> {
    let mut wanted = target.to_vec();
    for ((pair, of), line) in prepared.problem().contacts.iter().zip(&state.contacts).zip(&tractions.lines) {
        let stiffness = stiffness(prepared, pair);
        let own = line.start..line.start + line.count();
        let (values, openings) = (&mut wanted[own], line.openings(&pair.interface, of.opening));
        let loaded: f64 =
            openings.iter().map(|(k, _)| if values[*k] > 0.0 { line.weights[*k] } else { 0.0 }).sum();
        let least = line.weights.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let length = loaded.max(least).powf(1.0 / (S::DIM - 1) as f64);
        openings
            .into_iter()
            .for_each(|(k, opening)| values[k] -= share * stiffness * opening.max(0.0) / length);
    }
    wanted
}

/// Computes about the modulus of elasticity of the bodies of a pair together, Pa: `1/E` is the sum of theirs.
fn stiffness<S: Recovery>(prepared: &PreparedProblem<S>, pair: &ContactPair<S>) -> f64 {
    let bodies = &prepared.problem().bodies;
    let flexibility = |body: usize, facet: FacetId| -> f64 {
        let cell = bodies[body].mesh().topology().facet_cells()[facet][0] as usize;
        let along = |k: usize| S::components(|i| if i == k { 1.0 } else { 0.0 }).into();
        let material = bodies[body].material(cell);
        (0..S::DIM).map(|k| material.complementary(along(k), along(k)) / S::DIM as f64).sum()
    };
    pair.interface.facets().first().map_or(0.0, |facet| {
        let [own, other] = facet.facets;
        1.0 / (flexibility(pair.body, own) + pair.partner.body().map_or(0.0, |body| flexibility(body, other)))
    })
}

/// Finds tractions in balance within the cones of Coulomb friction of solids: again and again the nearest ones within the limits `μ p` of the pressures
/// before, until these agree. `None` if they do not, or nothing is in balance.
pub(super) fn nearest_in_round_cones<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    tractions: &Tractions,
    near: (&[f64], &[f64]),
    rows: &Rows<S>,
) -> Result<Option<Vec<f64>>, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let mut values = near.0.to_vec();
    for _ in 0..MOST_CONES {
        let limits_of = |values: &[f64]| -> Vec<Vec<f64>> {
            let lines = contacts.iter().zip(tractions.split(values));
            let of_line = |(pair, (line, values)): (&ContactPair<S>, (&LineTractions, &[f64]))| {
                let (by_facet, by_pair) = line.pressure(&pair.interface, values);
                line.limits(pair, admissible_limits(prepared, pair, &by_pair), &by_facet)
            };
            lines.map(of_line).collect()
        };
        let limits = limits_of(&values);
        let Some(found) = nearest(prepared, state, tractions, near, rows, &limits)? else { return Ok(None) };
        let inside = limits_of(&found);
        let change = limits.iter().flatten().zip(inside.iter().flatten()).map(|(a, b)| (a - b).abs());
        let largest = inside.iter().flatten().fold(0.0f64, |most, s| most.max(*s));
        if change.fold(0.0, f64::max) <= AGREED * largest {
            return Ok(Some(found));
        }
        values = found;
    }
    Ok(None)
}

/// Finds the nearest tractions in balance within given limits of friction, (31); `None` if nothing is in balance.
pub(super) fn nearest<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    tractions: &Tractions,
    (target, weights): (&[f64], &[f64]),
    Rows { independent: (matrix, loads), .. }: &Rows<S>,
    limits: &[Vec<f64>],
) -> Result<Option<Vec<f64>>, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let discs = discs(contacts, tractions, limits);
    let [lower, upper] = bounds(prepared, tractions, limits, None);
    let near = |target: &[f64]| nearest_balanced(target, weights, [&lower, &upper], &discs, matrix, loads);
    let Some(mut found) = near(target)? else { return Ok(None) };
    // A little pressure where the bodies are far apart costs much in 2∫ p o.
    let cost = |values: &[f64]| -> f64 {
        let of_pair = |(k, (line, values)): (usize, (&LineTractions, &[f64]))| -> f64 {
            let (interface, opening) = (&contacts[k].interface, state.contacts[k].opening);
            let mean = |facet: &ContactFacet<S>| facet.mean_openings(opening);
            let middle: Vec<f64> = interface.facets().iter().flat_map(mean).collect();
            let (by_facet, _) = line.pressure(interface, values);
            pressure::contact_terms(interface, &by_facet, opening, &middle).iter().sum()
        };
        tractions.split(values).enumerate().map(of_pair).sum()
    };
    let mut share = 1.0;
    while cost(&found.values) > DEAR * cost(target) && share > LEAST_SHARE {
        let near = near(&less_openings(prepared, state, tractions, target, share))?;
        if let Some(near) = near {
            if cost(&found.values) > DEAR * cost(&near.values) {
                found = near;
            }
            break;
        }
        share *= 0.1;
    }
    Ok(Some(found.values))
}

/// Finds the nearest tractions in balance within the cones of Coulomb friction: with `p = α + β`, `q = μ (α − β)` and `α, β ≥ 0` a
/// programme with bounds. `None` if nothing is in balance.
pub(super) fn nearest_in_cones<S: Recovery>(
    prepared: &PreparedProblem<S>,
    tractions: &Tractions,
    (target, weights): (&[f64], &[f64]),
    Rows { independent: (matrix, loads), .. }: &Rows<S>,
) -> Result<Option<Vec<f64>>, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let n = target.len();
    let limits: Vec<Vec<f64>> = contacts
        .iter()
        .map(|pair| admissible_limits(prepared, pair, &vec![0.0; pair.interface.pairs().len()]))
        .collect();
    let [lower, mut upper] = bounds(prepared, tractions, &limits, None);
    let mut linear: Vec<f64> = weights.iter().zip(target).map(|(w, t)| -w * t).collect();
    // Of each row: its own weight, and the row of the same node before it with the weight of their product.
    let mut columns: Vec<(f64, Option<(usize, f64)>)> = weights.iter().map(|w| (*w, None)).collect();
    let mut lines = matrix.transposed();
    let mut cones = Vec::new();
    for (pair, LineTractions { start, .. }) in contacts.iter().zip(&tractions.lines) {
        let nodes = pair.interface.pairs().len();
        if let Some(mu) = pair.friction.coulomb().filter(|mu| *mu > 0.0) {
            cones.extend((*start..start + nodes).map(|i| (i, i + nodes, mu)));
        }
    }
    for &(i, j, mu) in &cones {
        upper[j] = f64::INFINITY;
        let [p, q] = [weights[i], mu * mu * weights[j]];
        (columns[i], columns[j]) = ((p + q, None), (p + q, Some((i, p - q))));
        (linear[i], linear[j]) = (linear[i] + mu * linear[j], linear[i] - mu * linear[j]);
    }
    lines = in_cones(&lines, &cones);
    let (mut starts, mut places, mut values) = (vec![0], Vec::new(), Vec::new());
    for (j, (own, before)) in columns.into_iter().enumerate() {
        for (i, value) in before.into_iter().chain([(j, own)]) {
            places.push(i);
            values.push(value);
        }
        starts.push(places.len());
    }
    let matrix = MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &places, values: &values };
    let (rows, right_side) = (&lines.transposed(), loads);
    let qp = BoxQp { matrix, linear: &linear, lower: &lower, upper: &upper, rows, right_side };
    let mut found = solve_box(&qp, None, &QpSettings::default().active_sets_first())?;
    if !found.status.is_solved() {
        return Ok(None);
    }
    for &(i, j, mu) in &cones {
        (found.x[i], found.x[j]) = (found.x[i] + found.x[j], mu * (found.x[i] - found.x[j]));
    }
    Ok(Some(found.x))
}

/// Takes the columns of rows along the edges of cones, `n + μ t` and `n − μ t` in the places of `n` and `t`.
///
/// * `columns`: column after column; `cones`: the places of `n` and `t`, and `μ`.
fn in_cones(columns: &SparseRows, cones: &[(usize, usize, f64)]) -> SparseRows {
    let sum = |n: usize, t: usize, mu: f64| {
        let mut entries: BTreeMap<usize, f64> = columns.row(n).collect();
        columns.row(t).for_each(|(k, g)| *entries.entry(k).or_default() += mu * g);
        entries
    };
    let mut edges: BTreeMap<usize, BTreeMap<usize, f64>> = BTreeMap::new();
    for &(n, t, mu) in cones {
        edges.extend([(n, sum(n, t, mu)), (t, sum(n, t, -mu))]);
    }
    let mut found = SparseRows::new(columns.columns());
    for k in 0..columns.len() {
        match edges.remove(&k) {
            Some(edge) => found.push(edge),
            None => found.push(columns.row(k)),
        }
    }
    found
}

//! Contact pressures and forces that keep floating bodies in balance.
//!
//! A body that its supports do not hold is in equilibrium only if the pressure balances its loads exactly, moments
//! included. `p_i = r²_i/ℓ_i` does not, since `ℓ ≠ M` at ends and on graded meshes. The nearest admissible pressure is
//! ```math
//! min_p ∑_i ℓ_i (p_i − r^2_i/ℓ_i)²,   p ≥ 0,   C p = e     (31)
//! ```
//! with one row per rigid motion `R` of a floating body: `C p` is the work of the pressure along it, `−e` the work of the loads.
//! At pairs that are far apart the pressure stays zero if the other pairs can keep the balance.

use crate::error::EstimatorError;
use crate::friction::tangent;
use crate::imposed_slip;
use crate::pressure;
use crate::recovery::Recovery;
use crate::size::length;
use contact_qp::{BoxQp, MatrixView, QpSettings, RowSelection, SparseRows, nearest_balanced, solve_box};
use fem_core::contact_system::without_rounding;
use fem_core::geometry::Coordinates;
use fem_core::interface::{
    ContactFacet, ContactInterface, ContactPair, ContactProblem, ContactState, PairState, Partner,
};
use fem_core::prepared::PreparedProblem;
use std::collections::BTreeMap;

/// The imbalance of a body is measured against its own forces, and at least against this fraction of the largest forces on a body,
/// since the balance is checked to 1e-10 only.
const LIGHTLY_LOADED: f64 = 1e-6;

/// The nearest pressure in balance is looked for among the pairs that carry a force if on all pairs `∫ p o` would be this many
/// times larger.
const DEAR: f64 = 2.0;

/// The pressure and friction of an admissible stress at the pairs of each contact line.
#[derive(Clone, Debug)]
pub(crate) struct Pressure {
    /// At each pair, ≥ 0, Pa.
    pub(crate) by_pair: Vec<Vec<f64>>,
    /// Friction at each pair, at most its limit, Pa; empty without friction.
    pub(crate) friction: Vec<Vec<f64>>,
    /// The limit of friction at each pair, ≥ 0, Pa: the given one, or `μ p` of this pressure.
    pub(crate) limit: Vec<Vec<f64>>,
    /// Its change against `r²_i/ℓ_i`, relative, in the norm of (31); 0 if nothing floats.
    pub(crate) shift: f64,
    /// The largest resultant that is left on a floating body, relative to the forces on it; 0 if nothing floats.
    pub(crate) imbalance: f64,
}

impl Pressure {
    /// Takes the tractions of all rows, Pa.
    fn new<S: Recovery>(
        prepared: &PreparedProblem<S>,
        tractions: &[f64],
        [shift, imbalance]: [f64; 2],
    ) -> Self {
        let contacts = &prepared.problem().contacts;
        let (mut by_pair, mut friction, mut limit) = (Vec::new(), Vec::new(), Vec::new());
        for (of, mut pressure) in contacts.iter().zip(split(prepared, tractions)) {
            let mut q = pressure.split_off(of.interface.pairs().len());
            let s = limits(prepared, of, &pressure);
            // At the limit but for rounding.
            let most = admissible_limits(prepared, of, &pressure);
            q.iter_mut().zip(most).for_each(|(q, s)| *q = q.max(-s).min(s));
            by_pair.push(pressure);
            friction.push(q);
            limit.push(s);
        }
        Self { by_pair, friction, limit, shift, imbalance }
    }
}

/// Computes the largest friction of an admissible stress at the pairs of a contact line, Pa: on a bent edge, on which friction is the mean of its
/// ends, at most the smaller limit of its ends.
fn admissible_limits<S: Recovery>(
    prepared: &PreparedProblem<S>,
    pair: &ContactPair<S>,
    pressure: &[f64],
) -> Vec<f64> {
    let mut found = limits(prepared, pair, pressure);
    // Means of `|q| ≤ μ p` are within `μ` times the mean of `p`.
    if pair.friction.coulomb().is_none() && !found.is_empty() {
        let given = found.clone();
        for edge in pair.interface.facets().iter().filter(|edge| edge.bent) {
            let least = pair.interface.corners(edge, &given).into_iter().fold(f64::INFINITY, f64::min);
            edge.pairs.as_ref().iter().for_each(|k| found[*k as usize] = found[*k as usize].min(least));
        }
    }
    found
}

/// Computes the limit of friction at the pairs of a contact line, Pa: the given one, or `μ p`; nothing without friction.
fn limits<S: Recovery>(prepared: &PreparedProblem<S>, pair: &ContactPair<S>, pressure: &[f64]) -> Vec<f64> {
    if let Some(mu) = pair.friction.coulomb() {
        return pressure.iter().map(|p| mu * p).collect();
    }
    pair.friction_limit(&prepared.problem().bodies[pair.body]).unwrap_or_default()
}

/// Computes the limit of the friction force at the pairs of each contact line of a state, N/m: `ℓ s`, or `μ P` of the given forces.
pub(crate) fn force_limits<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
) -> Vec<Vec<f64>> {
    let of_pair = |(pair, given): (&ContactPair<S>, &PairState<'_>)| -> Vec<f64> {
        let nodes = pair.interface.pairs();
        let pressure = pressure::nodal_pressure(&pair.interface, given.contact_force);
        let limits = limits(prepared, pair, &pressure);
        nodes.iter().zip(limits).map(|(node, s)| node.weight * s).collect()
    };
    prepared.problem().contacts.iter().zip(&state.contacts).map(of_pair).collect()
}

/// Computes the admissible pressure of a state: `r²_i/ℓ_i`, or the nearest one in balance, (31). If nothing is in balance, it is
/// `r²_i/ℓ_i` with its imbalance. Friction `Q_i/ℓ_i` is at most its limit, and part of the balance.
///
/// # Errors
/// A programme that is rejected.
pub(crate) fn pressure<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
) -> Result<Pressure, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let (mut pressures, mut friction, mut limits) = (Vec::new(), Vec::new(), Vec::new());
    for (pair, given) in contacts.iter().zip(&state.contacts) {
        let pressure = pressure::nodal_pressure(&pair.interface, given.contact_force);
        let most = admissible_limits(prepared, pair, &pressure);
        let q = pressure::nodal_pressure(&pair.interface, given.friction_force);
        friction.push(q.iter().zip(&most).map(|(q, s)| q.max(-s).min(*s)).collect());
        pressures.push(pressure);
        limits.push(most);
    }
    imposed_slip::continued(prepared, state, &mut friction, &limits);
    let target: Vec<f64> = pressures.into_iter().zip(friction).flat_map(|(p, q)| [p, q].concat()).collect();
    if prepared.rigid_motions().is_empty() {
        return Ok(Pressure::new(prepared, &target, [0.0; 2]));
    }
    let weights = lengths(prepared);
    let work = |k: usize, motion: &[S::Vector]| {
        let interface = &contacts[k].interface;
        let mut work = traction_work(interface, motion, |normal| normal);
        if contacts[k].friction.acts() {
            work.extend(traction_work(interface, motion, tangent::<S>));
        }
        work
    };
    let rows = Rows::new(prepared, &weights, work)?;
    let found = if contacts.iter().any(|pair| pair.friction.coulomb().is_some()) {
        nearest_in_cones(prepared, (&target, &weights), &rows)?
    } else {
        nearest(prepared, state, (&target, &weights), &rows)?
    };
    let Some(found) = found else {
        return Ok(Pressure::new(prepared, &target, [0.0, rows.imbalance(prepared, &target)]));
    };
    let size = |values: &mut dyn Iterator<Item = f64>| {
        values.zip(&weights).map(|(v, w)| w * v * v).sum::<f64>().sqrt()
    };
    let change = size(&mut found.iter().zip(&target).map(|(p, t)| p - t));
    let whole = size(&mut target.iter().copied());
    let shift = if change > 0.0 { change / whole.max(change) } else { 0.0 };
    let imbalance = rows.imbalance(prepared, &found);
    Ok(Pressure::new(prepared, &found, [shift, imbalance]))
}

/// The bounds of pressure and friction by row, Pa, or of their forces, N/m.
///
/// * `limits`: of friction, by pair; `allowed`: which rows along normals may be positive; `None`: all.
fn bounds<S: Recovery>(
    prepared: &PreparedProblem<S>,
    limits: &[Vec<f64>],
    allowed: Option<&[bool]>,
) -> [Vec<f64>; 2] {
    let (mut lower, mut upper): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for (pair, limits) in prepared.problem().contacts.iter().zip(limits) {
        for _ in pair.interface.pairs() {
            let open = allowed.is_some_and(|allowed| !allowed[lower.len()]);
            lower.push(0.0);
            upper.push(if open { 0.0 } else { f64::INFINITY });
        }
        lower.extend(limits.iter().map(|s| -s));
        upper.extend(limits);
    }
    [lower, upper]
}

/// Finds the nearest tractions in balance within given limits of friction, (31), by row; `None` if nothing is in balance.
fn nearest<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    (target, weights): (&[f64], &[f64]),
    Rows { independent: (matrix, loads), .. }: &Rows,
) -> Result<Option<Vec<f64>>, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let limits: Vec<Vec<f64>> = contacts.iter().map(|pair| admissible_limits(prepared, pair, &[])).collect();
    let near = |allowed: Option<&[bool]>| {
        let [lower, upper] = bounds(prepared, &limits, allowed);
        nearest_balanced(target, weights, [&lower, &upper], matrix, loads)
    };
    let Some(mut found) = near(None)? else { return Ok(None) };
    // A little pressure where the bodies are far apart costs much in 2∫ p o.
    let cost = |pressure: &[f64]| -> f64 {
        let of_pair = |(k, p): (usize, Vec<f64>)| -> f64 {
            let (interface, opening) = (&contacts[k].interface, state.contacts[k].opening);
            let mean = |facet: &ContactFacet<S>| facet.mean_openings(opening);
            let middle: Vec<f64> = interface.facets().iter().flat_map(mean).collect();
            let edge_pressure = pressure::facet_pressure(interface, &p);
            pressure::contact_terms(interface, &edge_pressure, opening, &middle).iter().sum()
        };
        split(prepared, pressure).into_iter().enumerate().map(of_pair).sum()
    };
    let loaded: Vec<bool> = target.iter().map(|p| *p > 0.0).collect();
    if cost(&found.values) > DEAR * cost(target)
        && let Some(near) = near(Some(&loaded))?
        && cost(&found.values) > DEAR * cost(&near.values)
    {
        found = near;
    }
    Ok(Some(found.values))
}

/// Finds the nearest tractions in balance within the cones of Coulomb friction: with `p = α + β`, `q = μ (α − β)` and `α, β ≥ 0` a
/// programme with bounds. `None` if nothing is in balance.
fn nearest_in_cones<S: Recovery>(
    prepared: &PreparedProblem<S>,
    (target, weights): (&[f64], &[f64]),
    Rows { independent: (matrix, loads), .. }: &Rows,
) -> Result<Option<Vec<f64>>, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let n = target.len();
    let limits: Vec<Vec<f64>> = contacts
        .iter()
        .map(|pair| admissible_limits(prepared, pair, &vec![0.0; pair.interface.pairs().len()]))
        .collect();
    let [lower, mut upper] = bounds(prepared, &limits, None);
    let mut linear: Vec<f64> = weights.iter().zip(target).map(|(w, t)| -w * t).collect();
    // Of each row: its own weight, and the row of the same node before it with the weight of their product.
    let mut columns: Vec<(f64, Option<(usize, f64)>)> = weights.iter().map(|w| (*w, None)).collect();
    let mut lines = matrix.transposed();
    let (mut start, mut cones) = (0, Vec::new());
    for pair in contacts {
        let nodes = pair.interface.pairs().len();
        if let Some(mu) = pair.friction.coulomb().filter(|mu| *mu > 0.0) {
            cones.extend((start..start + nodes).map(|i| (i, i + nodes, mu)));
        }
        start += pair.row_count();
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

/// Computes the contact forces that balance the floating bodies and are nearest to the forces of a state, N/m, by row: on the
/// pairs that carry a force, or on all pairs if these cannot. Returns the given forces if no body floats or no balance exists.
///
/// # Errors
/// A programme that is rejected.
pub(crate) fn forces<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
) -> Result<Vec<Vec<f64>>, EstimatorError> {
    let limits = force_limits(prepared, state);
    let given = |(pair, limits): (&PairState<'_>, &Vec<f64>)| -> Vec<f64> {
        let friction = pair.friction_force.iter().zip(limits).map(|(q, s)| q.max(-s).min(*s));
        pair.contact_force.iter().copied().chain(friction).collect()
    };
    let given: Vec<Vec<f64>> = state.contacts.iter().zip(&limits).map(given).collect();
    if prepared.rigid_motions().is_empty() {
        return Ok(given);
    }
    let contacts = &prepared.problem().contacts;
    let target: Vec<f64> = given.iter().flatten().copied().collect();
    let weights: Vec<f64> = lengths(prepared).iter().map(|l| 1.0 / l).collect();
    let along = |k: usize, motion: &[S::Vector]| -> Vec<f64> {
        contacts[k].rows().map(|row| motion[row.pair].times(&row.direction)).collect()
    };
    let rows = Rows::new(prepared, &vec![1.0; target.len()], along)?;
    let near = |allowed: Option<&[bool]>| {
        let [lower, upper] = bounds(prepared, &limits, allowed);
        nearest_balanced(&target, &weights, [&lower, &upper], &rows.independent.0, &rows.independent.1)
    };
    let loaded: Vec<bool> = target.iter().map(|p| *p > 0.0).collect();
    let mut found = near(Some(&loaded))?;
    if found.is_none() {
        found = near(None)?;
    }
    Ok(found.map_or(given, |found| split(prepared, &found.values)))
}

/// Lists the tributary lengths of all rows, m.
fn lengths<S: Recovery>(prepared: &PreparedProblem<S>) -> Vec<f64> {
    let contacts = prepared.problem().contacts.iter();
    contacts.flat_map(|of| of.rows().map(|row| of.interface.pairs()[row.pair].weight)).collect()
}

/// Sorts one value per row by pair.
fn split<S: Recovery>(prepared: &PreparedProblem<S>, values: &[f64]) -> Vec<Vec<f64>> {
    let mut rest = values;
    let of_pair = |count: usize| {
        let (own, others) = rest.split_at(count.min(rest.len()));
        rest = others;
        own.to_vec()
    };
    prepared.problem().contacts.iter().map(ContactPair::row_count).map(of_pair).collect()
}

/// Computes the work of a unit traction at each pair on a motion, per unit traction.
///
/// * `motion`: at the pairs, m; `direction`: of the traction, from the normal.
fn traction_work<S: Recovery>(
    interface: &ContactInterface<S>,
    motion: &[S::Vector],
    direction: impl Fn(S::Vector) -> S::Vector,
) -> Vec<f64> {
    let mut work = vec![0.0; motion.len()];
    for facet in interface.facets() {
        let moved = S::axes(|corner| match facet.clamped[corner] {
            None => motion[facet.pairs[corner] as usize],
            Some(_) => S::Vector::ZERO,
        });
        // ∫ (Σ p_i n_i φ_i)·u, as in the nodal forces of the pressure.
        let mut at = S::axes(|corner| {
            let others = (0..S::DIM).filter(|other| *other != corner);
            let sum = others.fold(moved[corner] * 2.0, |sum, other| sum + moved[other]);
            facet.measure / (S::DIM * (S::DIM + 1)) as f64
                * direction(interface.corner_pair(facet, corner).normal).times(&sum)
        });
        // A bent facet carries the mean of its corners.
        if facet.bent {
            let mean = at.as_ref().iter().sum::<f64>() / S::DIM as f64;
            at = S::axes(|_| mean);
        }
        for corner in 0..S::DIM {
            let sources = interface.sources(facet, corner);
            sources.iter().for_each(|k| work[*k as usize] += at[corner] / sources.len() as f64);
        }
    }
    work
}

/// Lists the first row of each pair.
fn starts<S: Recovery>(problem: &ContactProblem<S>) -> Vec<usize> {
    let after =
        |start: &mut usize, pair: &ContactPair<S>| Some(std::mem::replace(start, *start + pair.row_count()));
    problem.contacts.iter().scan(0, after).collect()
}

/// The rows of the balance: one per rigid motion of a floating body.
struct Rows {
    /// The work on the motion's body of a unit value in each row, signs reversed.
    matrix: SparseRows,
    /// `e`, the work of the loads.
    loads: Vec<f64>,
    /// The linearly independent rows and their loads: rows of round-off must not become a condition.
    independent: (SparseRows, Vec<f64>),
}

impl Rows {
    /// * `sizes`: of the forces of unit values, by row; `work`: of unit values in the rows of contact line `k` on a motion of the contact nodes.
    fn new<S: Recovery>(
        prepared: &PreparedProblem<S>,
        sizes: &[f64],
        work: impl Fn(usize, &[S::Vector]) -> Vec<f64>,
    ) -> Result<Self, EstimatorError> {
        let problem = prepared.problem();
        let (mut matrix, mut loads) = (SparseRows::new(prepared.rows()), Vec::new());
        let (sides, starts) = (problem.sides(), starts(problem));
        for of in prepared.rigid_motions() {
            let moved = prepared.moved_by(of);
            let most = moved.iter().map(|u| length(*u)).fold(0.0, f64::max);
            let mut line = Vec::new();
            for &(k, side) in &sides[of.partner.place(problem.bodies.len())] {
                let pairs = problem.contacts[k].interface.pairs();
                let motion: Vec<S::Vector> = pairs.iter().map(|pair| moved[pair.nodes[side]]).collect();
                // The pressure acts against the normal on the first body.
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let entries = work(k, &motion).into_iter().zip(starts[k]..);
                line.extend(entries.map(|(w, row)| (row, sign * without_rounding(w, most * sizes[row]))));
            }
            matrix.push(line);
            loads.push(of.load);
        }
        let groups: Vec<usize> =
            prepared.rigid_motions().iter().map(|of| of.partner.place(problem.bodies.len())).collect();
        let RowSelection { rows, .. } = RowSelection::new(&matrix, &loads, &groups, 0.0)?;
        let independent = (matrix.select(&rows), rows.iter().map(|k| loads[*k]).collect());
        Ok(Self { matrix, loads, independent })
    }

    /// Computes the largest resultant of a floating body, over the sum of the sizes of all forces on it.
    ///
    /// * `pressure`: pressure and friction by row, Pa.
    fn imbalance<S: Recovery>(&self, prepared: &PreparedProblem<S>, pressure: &[f64]) -> f64 {
        let problem = prepared.problem();
        let lengths = lengths(prepared);
        let (sides, starts) = (problem.sides(), starts(problem));
        let mut found = Vec::new();
        let products = self.matrix.times(pressure);
        for ((product, load), of) in products.iter().zip(&self.loads).zip(prepared.rigid_motions()) {
            let moved = prepared.moved_by(of);
            let mut size = match of.partner {
                Partner::Obstacle(_) => load.abs(),
                Partner::Body(body) => {
                    let forces = prepared.external_forces()[body].iter().zip(&moved);
                    forces.map(|(f, u)| length(*f) * length(*u)).sum()
                }
            };
            for &(k, side) in &sides[of.partner.place(problem.bodies.len())] {
                let forces = lengths[starts[k]..].iter().zip(&pressure[starts[k]..]);
                let terms = problem.contacts[k].rows().zip(forces);
                size += terms.map(|(row, (l, p))| l * p.abs() * length(moved[row.nodes[side]])).sum::<f64>();
            }
            let rest = (product - load).abs();
            found.push((rest, size));
        }
        // A body almost without forces is compared with the others: its forces are rounding errors of their forces.
        let least = LIGHTLY_LOADED * found.iter().fold(0.0, |largest: f64, (_, size)| largest.max(*size));
        let relative = |(rest, size): &(f64, f64)| if *rest > 0.0 { rest / size.max(least) } else { 0.0 };
        found.iter().map(relative).fold(0.0, f64::max)
    }
}

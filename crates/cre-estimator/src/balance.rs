//! Contact pressures and forces that keep floating bodies in balance.
//!
//! A body that its supports do not hold is in equilibrium only if the pressure balances its loads exactly, moments
//! included. `p_i = r²_i/ℓ_i` does not, since `ℓ ≠ M` at ends and on graded meshes. The nearest admissible pressure is
//! ```math
//! min_p ∑_i ℓ_i (p_i − r^2_i/ℓ_i)²,   p ≥ 0,   C p = e     (31)
//! ```
//! with one row per rigid motion `R` of a floating body: `C p` is the work of the pressure along it, `−e` the work of the loads; and one for each cut
//! with a given force: by reciprocity the force does not change if the pressure does the same work as `r²` along the displacements of a unit shortening.
//! If it does much work on openings, which is part of the bound, the openings count in the choice. On bent facets of solids the unknowns are the pressures and
//! the friction of the facets, with the measure of the facet for `ℓ`: nearer ones are in balance than those that are means of values at the corners.

mod nearest;
mod tractions;

use crate::error::EstimatorError;
use crate::friction::{OnFacets, all_within, facet_limit};
use crate::imposed_slip;
use crate::pressure;
use crate::recovery::Recovery;
use crate::size::length;
use contact_qp::{RowSelection, SparseRows, nearest_balanced};
use fem_core::contact_system::without_rounding;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactPair, ContactState, PairState, Partner};
use fem_core::prepared::PreparedProblem;
use fem_core::space::Space;
use nearest::{bounds, discs, nearest, nearest_in_cones, nearest_in_round_cones};
use tractions::Tractions;

/// The imbalance of a body is measured against its own forces, and at least against this fraction of the largest forces on a body,
/// since the balance is checked to 1e-10 only.
const LIGHTLY_LOADED: f64 = 1e-6;

/// The pressure and friction of an admissible stress at the pairs of each contact line.
#[derive(Clone, Debug)]
pub(crate) struct Pressure<S: Space> {
    /// At each pair, ≥ 0, Pa.
    pub(crate) by_pair: Vec<Vec<f64>>,
    /// At the corners of each facet, ≥ 0, Pa.
    pub(crate) by_facet: Vec<Vec<S::Axes<f64>>>,
    /// Friction at each pair, at most its limit, Pa; empty without friction.
    pub(crate) friction: Vec<Vec<f64>>,
    /// The limit of friction at each pair, ≥ 0, Pa: the given one, or `μ p` of this pressure.
    pub(crate) limit: Vec<Vec<f64>>,
    /// Friction and its limit at the corners of each facet, Pa; empty without friction.
    pub(crate) facet_friction: Vec<OnFacets<S>>,
    /// Its change against `r²_i/ℓ_i`, relative, in the norm of (31); 0 if nothing floats.
    pub(crate) shift: f64,
    /// The largest resultant that is left on a floating body, relative to the forces on it; 0 if nothing floats.
    pub(crate) imbalance: f64,
}

impl<S: Recovery> Pressure<S> {
    /// Takes tractions, Pa.
    fn new(
        prepared: &PreparedProblem<S>,
        tractions: &Tractions,
        values: &[f64],
        [shift, imbalance]: [f64; 2],
    ) -> Self {
        let contacts = &prepared.problem().contacts;
        let (mut by_pair, mut by_facet) = (Vec::new(), Vec::new());
        let (mut friction, mut limit, mut facet_friction) = (Vec::new(), Vec::new(), Vec::new());
        for (of, (line, values)) in contacts.iter().zip(tractions.split(values)) {
            let (facets, pressure) = line.pressure(&of.interface, values);
            let s = limits(prepared, of, &pressure);
            let on_facets = match of.friction.acts() {
                true => {
                    let all = of.interface.facets().iter().zip(&facets);
                    all.map(|(facet, p)| facet_limit(of, facet, &s, Some(p))).collect()
                }
                false => Vec::new(),
            };
            let (mut q, tractions) = line.friction(of, values, &on_facets);
            // At the limit but for rounding.
            let most = admissible_limits(prepared, of, &pressure);
            all_within(&mut q, &most);
            by_pair.push(pressure);
            by_facet.push(facets);
            friction.push(q);
            limit.push(s);
            facet_friction.push((tractions, on_facets));
        }
        Self { by_pair, by_facet, friction, limit, facet_friction, shift, imbalance }
    }
}

/// Computes the largest friction of an admissible stress at the pairs of a contact line, Pa: on a bent edge of the plane, on which friction is the mean
/// of its ends, at most the smaller limit of its ends.
fn admissible_limits<S: Recovery>(
    prepared: &PreparedProblem<S>,
    pair: &ContactPair<S>,
    pressure: &[f64],
) -> Vec<f64> {
    let mut found = limits(prepared, pair, pressure);
    // Means of `|q| ≤ μ p` are within `μ` times the mean of `p`.
    if !S::BALANCED_BY_FACET && pair.friction.coulomb().is_none() && !found.is_empty() {
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
) -> Result<Pressure<S>, EstimatorError> {
    let contacts = &prepared.problem().contacts;
    let (mut pressures, mut friction, mut limits) = (Vec::new(), Vec::new(), Vec::new());
    for (pair, given) in contacts.iter().zip(&state.contacts) {
        let pressure = pressure::nodal_pressure(&pair.interface, given.contact_force);
        let most = admissible_limits(prepared, pair, &pressure);
        let by_tangent = given.friction_force.chunks(pair.interface.pairs().len().max(1));
        let mut q: Vec<f64> =
            by_tangent.flat_map(|force| pressure::nodal_pressure(&pair.interface, force)).collect();
        all_within(&mut q, &most);
        friction.push(q);
        pressures.push(pressure);
        limits.push(most);
    }
    imposed_slip::continued(prepared, state, &mut friction, &limits);
    let given: Vec<Vec<f64>> = pressures.into_iter().zip(friction).map(|(p, q)| [p, q].concat()).collect();
    let unbalanced = |imbalance: f64| {
        Ok(Pressure::new(
            prepared,
            &Tractions::of_rows(prepared.problem()),
            &given.concat(),
            [0.0, imbalance],
        ))
    };
    let motions = motions(prepared, state);
    if motions.is_empty() {
        return unbalanced(0.0);
    }
    let tractions = Tractions::of_facets(prepared.problem());
    let (target, mut weights) = (tractions.targets(prepared.problem(), &given), tractions.weights());
    let work = |k: usize, motion: &[S::Vector]| tractions.lines[k].work(&contacts[k], motion);
    let rows = Rows::new((prepared, motions), &tractions, &weights, work)?;
    // Idle unknowns stay zero at any weight.
    let most = weights.iter().copied().fold(0.0, f64::max);
    weights.iter_mut().filter(|weight| **weight == 0.0).for_each(|weight| *weight = most);
    let coulomb = contacts.iter().any(|pair| pair.friction.coulomb().is_some());
    let near = (&target[..], &weights[..]);
    let found = if coulomb && S::ONE_TANGENT {
        nearest_in_cones(prepared, &tractions, near, &rows)?
    } else if coulomb {
        nearest_in_round_cones(prepared, state, &tractions, near, &rows)?
    } else {
        let limits: Vec<Vec<f64>> = (contacts.iter().zip(&tractions.lines))
            .map(|(pair, line)| line.limits(pair, admissible_limits(prepared, pair, &[]), &[]))
            .collect();
        nearest(prepared, state, &tractions, near, &rows, &limits)?
    };
    let Some(found) = found else {
        return unbalanced(rows.imbalance(prepared, &tractions, &target));
    };
    let size = |values: &mut dyn Iterator<Item = f64>| {
        values.zip(&weights).map(|(v, w)| w * v * v).sum::<f64>().sqrt()
    };
    let change = size(&mut found.iter().zip(&target).map(|(p, t)| p - t));
    let whole = size(&mut target.iter().copied());
    let shift = if change > 0.0 { change / whole.max(change) } else { 0.0 };
    let imbalance = rows.imbalance(prepared, &tractions, &found);
    Ok(Pressure::new(prepared, &tractions, &found, [shift, imbalance]))
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
        let mut friction = pair.friction_force.to_vec();
        all_within(&mut friction, limits);
        [pair.contact_force, &friction].concat()
    };
    let given: Vec<Vec<f64>> = state.contacts.iter().zip(&limits).map(given).collect();
    let motions = motions(prepared, state);
    if motions.is_empty() {
        return Ok(given);
    }
    let contacts = &prepared.problem().contacts;
    let tractions = Tractions::of_rows(prepared.problem());
    let target: Vec<f64> = given.concat();
    let weights: Vec<f64> = tractions.weights().iter().map(|l| 1.0 / l).collect();
    let along = |k: usize, motion: &[S::Vector]| -> Vec<f64> {
        contacts[k].rows().map(|row| motion[row.pair].times(&row.direction)).collect()
    };
    let rows = Rows::new((prepared, motions), &tractions, &vec![1.0; target.len()], along)?;
    let discs = discs(contacts, &tractions, &limits);
    let near = |allowed: Option<&[bool]>| {
        let [lower, upper] = bounds(prepared, &tractions, &limits, allowed);
        nearest_balanced(
            &target,
            &weights,
            [&lower, &upper],
            &discs,
            &rows.independent.0,
            &rows.independent.1,
        )
    };
    let loaded: Vec<bool> = target.iter().map(|p| *p > 0.0).collect();
    let mut found = near(Some(&loaded))?;
    if found.is_none() {
        found = near(None)?;
    }
    let by_line = |values: &[f64]| tractions.split(values).map(|(_, values)| values.to_vec()).collect();
    Ok(found.map_or(given, |found| by_line(&found.values)))
}

/// Displacements along which the work of the contact is known.
struct Motion<S: Space> {
    partner: Partner,
    /// At each node, or at each point of an obstacle.
    moved: Vec<S::Vector>,
    /// The work of the contact, signs reversed.
    load: f64,
}

/// Lists the rigid motions of floating bodies, and the displacements of a unit shortening of each cut whose force is given.
fn motions<S: Recovery>(prepared: &PreparedProblem<S>, state: &ContactState<'_, S>) -> Vec<Motion<S>> {
    let problem = prepared.problem();
    let rigid = prepared.rigid_motions().iter();
    let rigid = rigid.map(|of| Motion { partner: of.partner, moved: prepared.moved_by(of), load: of.load });
    let of_cut = |(body, moved): (usize, Vec<S::Vector>)| {
        let on_side = |(k, side): (usize, usize)| {
            let (pair, given) = (&problem.contacts[k], &state.contacts[k]);
            let forces = given.contact_force.iter().chain(given.friction_force);
            let work =
                pair.rows().zip(forces).map(|(row, f)| f * moved[row.nodes[side]].times(&row.direction));
            if side == 0 { work.sum::<f64>() } else { -work.sum::<f64>() }
        };
        let load = problem.sides_of(Partner::Body(body)).map(on_side).sum();
        Motion { partner: Partner::Body(body), moved, load }
    };
    rigid.chain(prepared.cut_responses().into_iter().map(of_cut)).collect()
}

/// The rows of the balance: one per motion.
struct Rows<S: Space> {
    motions: Vec<Motion<S>>,
    /// The work on the motion's body of a unit of each unknown, signs reversed.
    matrix: SparseRows,
    /// The linearly independent rows and their loads: rows of round-off must not become a condition.
    independent: (SparseRows, Vec<f64>),
}

impl<S: Recovery> Rows<S> {
    /// * `sizes`: of the forces of unit values; `work`: of unit values of the unknowns of contact line `k` on a motion of the contact nodes.
    fn new(
        (prepared, motions): (&PreparedProblem<S>, Vec<Motion<S>>),
        tractions: &Tractions,
        sizes: &[f64],
        work: impl Fn(usize, &[S::Vector]) -> Vec<f64>,
    ) -> Result<Self, EstimatorError> {
        let problem = prepared.problem();
        let mut matrix = SparseRows::new(tractions.count());
        let sides = problem.sides();
        for Motion { partner, moved, .. } in &motions {
            let most = moved.iter().map(|u| length(*u)).fold(0.0, f64::max);
            let mut line = Vec::new();
            for &(k, side) in &sides[partner.place(problem.bodies.len())] {
                let pairs = problem.contacts[k].interface.pairs();
                let motion: Vec<S::Vector> = pairs.iter().map(|pair| moved[pair.nodes[side]]).collect();
                // The pressure acts against the normal on the first body.
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let entries = work(k, &motion).into_iter().zip(tractions.lines[k].start..);
                line.extend(entries.map(|(w, at)| (at, sign * w)));
            }
            // A pair within a body has both sides there.
            line.sort_by_key(|(at, _)| *at);
            line.dedup_by(|next, sum| {
                let same = next.0 == sum.0;
                sum.1 += if same { next.1 } else { 0.0 };
                same
            });
            matrix.push(line.into_iter().map(|(at, w)| (at, without_rounding(w, most * sizes[at]))));
        }
        let loads: Vec<f64> = motions.iter().map(|of| of.load).collect();
        let groups: Vec<usize> = motions.iter().map(|of| of.partner.place(problem.bodies.len())).collect();
        let RowSelection { rows, .. } = RowSelection::new(&matrix, &loads, &groups, 0.0)?;
        let independent = (matrix.select(&rows), rows.iter().map(|k| loads[*k]).collect());
        Ok(Self { motions, matrix, independent })
    }

    /// Computes the largest resultant of a floating body and the largest change of a given force in a cut, over the sum of the sizes of all forces on it.
    ///
    /// * `values`: pressure and friction, Pa.
    fn imbalance(&self, prepared: &PreparedProblem<S>, tractions: &Tractions, values: &[f64]) -> f64 {
        let problem = prepared.problem();
        let sides = problem.sides();
        let mut found = Vec::new();
        let products = self.matrix.times(values);
        for (product, Motion { partner, moved, load }) in products.iter().zip(&self.motions) {
            let mut size = match *partner {
                Partner::Obstacle(_) => load.abs(),
                Partner::Body(body) => {
                    let forces = prepared.external_forces()[body].iter().zip(moved);
                    forces.map(|(f, u)| length(*f) * length(*u)).sum()
                }
            };
            for &(k, side) in &sides[partner.place(problem.bodies.len())] {
                let (pair, line) = (&problem.contacts[k], &tractions.lines[k]);
                let forces: Vec<f64> =
                    line.weights.iter().zip(&values[line.start..]).map(|(l, p)| l * p.abs()).collect();
                let (rows, facets) = forces.split_at(line.rows);
                let at_rows = pair.rows().zip(rows).map(|(row, f)| f * length(moved[row.nodes[side]]));
                let on_facets = line.facets.iter().cycle().zip(facets).map(|(k, f)| {
                    let facet = &pair.interface.facets()[*k];
                    let corners = facet.free_corners().map(|corner| facet.pairs[corner] as usize);
                    let moved = corners.map(|k| length(moved[pair.interface.pairs()[k].nodes[side]]));
                    f * moved.fold(0.0, f64::max)
                });
                size += at_rows.sum::<f64>() + on_facets.sum::<f64>();
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

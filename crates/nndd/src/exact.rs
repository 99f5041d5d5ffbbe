//! The exact solution of the discrete problem, for any number of bodies and pairs, floating ones among them.
//!
//! With one row per pair of nodes, `B_α` the normal trace of body α along the normals (+ for the first body of a pair,
//! − for the second), `K_α⁺` an inverse that is exact for loads in balance, and `R` the rigid motions of the floating bodies:
//! ```math
//! min_P ½ Pᵀ F P + qᵀ P,   P ≥ 0,                     G P = e
//! F = ∑_α B_α K_α⁺ B_αᵀ,   q = g − ∑_α B_α K_α⁺ f_α,   G = (B R)ᵀ,   e = Rᵀ f
//! ```
//! `G P = e` is the balance of the floating bodies, its multiplier `a` their rigid motion, and the gradient `F P + q − Gᵀ a` the
//! opening. `u_α = K_α⁺ (f_α − B_αᵀ P) + R_α a`.
//!
//! # Friction
//! With friction each pair of nodes has a second row along its tangent, with a force `Q` within `−S ≤ Q ≤ S`, `S = ℓ s`, and the slip before the load step for its gap, 0 from rest. The
//! gradient there is the slip with the opposite sign: `Q = S` if it slips forwards, `−S` if backwards, and zero slip between. In space there are two
//! tangents, and `Q` is in a disc, `|Q| ≤ S`. Rows that
//! supports impose in both bodies slip by a given amount: their force is at its limit, or zero without slip, and moves nothing.

use crate::balance::{Balance, discs};
use crate::error::NnddError;
use crate::friction::{NodeState, PairFriction};
use contact_qp::{
    BoundState, BoxQp, DiscStart, IndependentRows, KktResiduals, QpPath, QpSettings, QpStatus, SparseRows,
    SymmetricMatrix, solve_discs,
};
use fem_core::contact_system::{
    BodyField, BodyFields, BodyRow, ContactRow, ContactRows, ContactSystem, PairRows, RowLaw,
};
use fem_core::dense::mirror;
use fem_core::{condensation::InterfaceOperator, each_body};
use neumann_neumann::leaders;

/// A flexibility below this fraction of what its two rows have alone is negligible: far below the rounding of these, even if many add up.
const NEGLIGIBLE: f64 = 1e-20;

/// Smaller programmes have a full matrix.
const LARGE: usize = 512;

/// A row along a tangent whose own flexibility is below this fraction of the largest one is imposed on both sides.
const IMPOSED: f64 = 1e-20;

/// A slip that supports impose below this fraction of the largest trace is zero.
const ROUND_OFF: f64 = 1e-12;

/// The exact solution of the discrete problem.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ExactSolution {
    /// The forces and motions that determine the displacements, for [`fem_core::prepared::PreparedProblem::displacements`].
    pub fields: BodyFields,
    /// Traces of the first and of the second body or obstacle of each row, along its own outward normal or tangent, m.
    pub(crate) traces: [Vec<f64>; 2],
    /// Contact force at the pairs of nodes of each pair, `P ≥ 0`, N/m.
    pub contact_force: Vec<Vec<f64>>,
    /// Opening at the pairs of nodes of each pair, ≥ 0, exactly 0 where there is a force, m.
    pub opening: Vec<Vec<f64>>,
    /// Friction of each pair.
    pub friction: Vec<PairFriction>,
    /// How the programme ended.
    pub status: QpStatus,
    /// Method that solved it.
    pub path: QpPath,
    /// Active sets tried, or iterations of Clarabel.
    pub iterations: usize,
    /// Number of calls of Clarabel.
    pub clarabel_calls: usize,
    /// Residuals of its KKT conditions.
    pub kkt: KktResiduals,
}

/// Solves the discrete contact problem, without friction or with that of Tresca.
///
/// # Errors
/// [`NnddError::NotHeld`] if the loads move bodies that nothing holds, with the motion; [`NnddError::Coulomb`]; a programme that is
/// rejected.
pub fn solve_exactly(system: &ContactSystem<'_>, settings: &QpSettings) -> Result<ExactSolution, NnddError> {
    refuse_coulomb(system)?;
    let programme = ForceQp::new(system)?;
    Ok(programme.solve(&system.rows.limits(), None, settings)?.0)
}

/// Refuses the law of Coulomb, which is no programme.
pub(crate) fn refuse_coulomb(system: &ContactSystem<'_>) -> Result<(), NnddError> {
    match system.rows.rows.iter().find(|row| matches!(row.law, RowLaw::Coulomb { .. })) {
        Some(row) => Err(NnddError::Coulomb { pair: row.pair }),
        None => Ok(()),
    }
}

/// The programme of the forces of all rows.
pub(crate) struct ForceQp<'a> {
    pub(crate) system: &'a ContactSystem<'a>,
    balance: Balance<'a>,
    flexibility: SymmetricMatrix,
    /// `q`.
    linear: Vec<f64>,
    /// The lines of the balance that the pairs resist, and their loads.
    lines: Lines,
    /// Rows along tangents that are imposed on both sides.
    imposed: Vec<bool>,
}

/// `G` and `e` of the programme.
pub(crate) struct Lines {
    pub(crate) rows: SparseRows,
    loads: Vec<f64>,
    /// Set if the rows are orthonormal combinations of those that the pairs resist.
    combined: Option<IndependentRows>,
}

impl Lines {
    /// * `few`: the rows may meet all forces, as long as they are orthonormal.
    fn new(balance: &Balance<'_>, few: bool) -> Self {
        let (rows, loads) = balance.resisted();
        if !few {
            return Self { rows, loads, combined: None };
        }
        let combined = IndependentRows::new(&rows.dense(), &loads);
        let rows = SparseRows::from_dense(rows.columns(), &combined.rows);
        Self { rows, loads: combined.right_side.clone(), combined: Some(combined) }
    }

    /// Returns the multipliers of the lines that the pairs resist.
    fn expanded(&self, multipliers: &[f64]) -> Vec<f64> {
        self.combined.as_ref().map_or_else(|| multipliers.to_vec(), |rows| rows.expanded(multipliers))
    }
}

/// Computes `F`, the sum of one block per body: a sparse matrix if it is large and at most a quarter of its entries is more than negligible, as in
/// assemblies of many bodies, and in long bodies that are held all along.
fn flexibility(system: &ContactSystem<'_>) -> SymmetricMatrix {
    let n = system.rows.len();
    let inverses = each_body(system.bodies.len(), |b| system.bodies[b].flexibility());
    let mut entries = entries(system.of_body.iter().map(Vec::len));
    if n >= LARGE && is_full(n, entries) {
        entries = 0;
        each_entry(system, &inverses, NEGLIGIBLE, |i, j, _| entries += if i == j { 1 } else { 2 });
    }
    if !is_full(n, entries) {
        let mut upper = Vec::with_capacity(entries / 2 + n);
        each_entry(system, &inverses, NEGLIGIBLE, |i, j, value| upper.push((i, j, value)));
        return SymmetricMatrix::sparse(n, upper);
    }
    let mut values = vec![0.0; n * n];
    each_entry(system, &inverses, 0.0, |i, j, value| values[i * n + j] += value);
    drop(inverses);
    mirror(&mut values, n);
    SymmetricMatrix::Full { n, values }
}

/// Passes the entries of the blocks of all bodies to a function, by row and column, the row at most the column: only one of two equal ones, or round-off
/// would make `F` unsymmetric.
///
/// * `inverses`: `S⁻¹` of each body; `negligible`: entries below this fraction of what their rows have alone are left out.
fn each_entry(
    system: &ContactSystem<'_>,
    inverses: &[Vec<f64>],
    negligible: f64,
    mut add: impl FnMut(usize, usize, f64),
) {
    for ((condensed, inverse), rows) in system.bodies.iter().zip(inverses).zip(&system.of_body) {
        let size = condensed.len();
        let mut column = vec![0.0; size];
        let fill = |of: &BodyRow, column: &mut [f64]| {
            column.fill(0.0);
            for (q, b) in &of.terms {
                column.iter_mut().zip(&inverse[q * size..(q + 1) * size]).for_each(|(c, v)| *c += b * v);
            }
        };
        let own = |of: &BodyRow| -> f64 {
            let of_term = |(q, b): &(usize, f64)| {
                b * of.terms.iter().map(|(p, a)| a * inverse[q * size + p]).sum::<f64>()
            };
            of.terms.iter().map(of_term).sum()
        };
        let roots: Vec<f64> = rows.iter().map(|of| own(of).max(0.0).sqrt()).collect();
        for (of_j, root) in rows.iter().zip(&roots) {
            fill(of_j, &mut column);
            let least = negligible * root;
            for (of_i, root) in rows.iter().zip(&roots).filter(|(of_i, _)| of_i.row >= of_j.row) {
                let value = of_i.of(&column);
                if value.abs() >= least * root {
                    add(of_j.row, of_i.row, value);
                }
            }
        }
    }
}

/// Adds up the entries of the blocks of the bodies.
fn entries(rows: impl Iterator<Item = usize>) -> usize {
    rows.map(|rows| rows * rows).sum()
}

/// Tells whether the flexibility is stored as a full matrix.
///
/// * `count`: of rows; `entries`: of the blocks of all bodies together.
fn is_full(count: usize, entries: usize) -> bool {
    count < LARGE || 4 * entries > count * count
}

/// Counts the entries of the flexibility of an assembly, at most, as it is stored: of a full matrix, or of one block per body.
pub fn flexibility_entries(rows: &ContactRows) -> usize {
    let mut of_body = vec![0; rows.bodies];
    for pair in &rows.pairs {
        for body in [Some(pair.body), pair.partner.body()].into_iter().flatten() {
            of_body[body] += pair.all().len();
        }
    }
    let (count, entries) = (rows.len(), entries(of_body.into_iter()));
    if is_full(count, entries) { count * count } else { entries }
}

impl<'a> ForceQp<'a> {
    /// Sets up the programme of an assembly.
    ///
    /// # Errors
    /// Those of [`Balance::check_held`].
    pub(crate) fn new(system: &'a ContactSystem<'a>) -> Result<Self, NnddError> {
        let rows = &system.rows;
        let balance = Balance::new(rows)?;
        balance.check_held(&rows.limits())?;
        let flexibility = flexibility(system);
        let own = |i: usize| flexibility.entry(i, i);
        let largest = (0..rows.len()).map(own).fold(0.0, f64::max);
        let alone = balance.leaves_alone();
        let imposed = |i: usize| rows.is_tangential(i) && own(i) <= IMPOSED * largest && alone[i];
        let imposed = (0..rows.len()).map(imposed).collect();
        let lines = Lines::new(&balance, matches!(flexibility, SymmetricMatrix::Full { .. }));
        Ok(Self { linear: linear(system), system, balance, flexibility, lines, imposed })
    }

    /// Returns an entry of `F`.
    pub(crate) fn entry(&self, i: usize, j: usize) -> f64 {
        self.flexibility.entry(i, j)
    }

    /// Tells whether supports impose a row in both bodies.
    pub(crate) fn is_imposed(&self, row: usize) -> bool {
        self.imposed[row]
    }

    /// Computes the size of the forces that the data have, N/m: the largest one that alone would keep the gap of its row as the loads leave
    /// it, `|q_i| / F_ii`, or the loads of the floating bodies.
    pub(crate) fn force_size(&self) -> f64 {
        let own = |i: usize| (self.linear[i].abs(), self.entry(i, i));
        let alone = (0..self.system.rows.len()).map(own).filter(|(_, f)| *f > 0.0).map(|(q, f)| q / f);
        alone.chain(self.lines.loads.iter().map(|e| e.abs())).fold(0.0, f64::max)
    }

    /// Returns the lines of the balance.
    pub(crate) fn lines(&self) -> &Lines {
        &self.lines
    }

    /// Returns the balance of the floating bodies.
    pub(crate) fn balance(&self) -> &Balance<'_> {
        &self.balance
    }

    /// Solves it, and returns where a programme with other limits starts.
    ///
    /// * `limits`: `S` by row, infinite along normals, N/m; `start`: see [`solve_discs`].
    pub(crate) fn solve(
        &self,
        limits: &[f64],
        start: Option<&DiscStart>,
        settings: &QpSettings,
    ) -> Result<(ExactSolution, DiscStart), NnddError> {
        let Self { system, balance, .. } = self;
        let rows = &system.rows;
        let own = self.own_limits(limits);
        let [lower, upper] = rows.bounds(&own);
        let discs = discs(rows, &own);
        let qp = BoxQp {
            matrix: self.flexibility.view(),
            linear: &self.linear,
            lower: &lower,
            upper: &upper,
            rows: &self.lines.rows,
            right_side: &self.lines.loads,
        };
        let first = if start.is_none() { self.without_crowds() } else { None };
        let first = first.map(|states| DiscStart { states, ..DiscStart::default() });
        let start = start.or(first.as_ref());
        let mut found = solve_discs(&qp, &discs, start, &settings.clone().active_sets_first())?;
        let start =
            DiscStart { x: found.x.clone(), multipliers: found.multipliers.clone(), states: found.states };
        let amounts = balance.independent.expanded(&self.lines.expanded(&found.row_multipliers));
        let force = |b: usize| system.on_unknowns(b, |row| -found.x[row.row]);
        let forces = each_body(system.bodies.len(), force);
        let traces = traces(system, &forces, &amounts);
        // What supports impose on both sides is equal but for round-off, or slips.
        let largest = traces.iter().flatten().fold(0.0f64, |most, trace| most.max(trace.abs()));
        let mut opening = found.multipliers;
        let equal = |y: &f64| y.abs() <= ROUND_OFF * largest;
        let imposed = opening.iter_mut().zip(&self.imposed).filter(|(y, imposed)| **imposed && equal(y));
        imposed.for_each(|(y, _)| *y = 0.0);
        // Where they slip, friction moves nothing; it is at its limit, or the bound would count its work.
        let slips = |i: usize| own[i] == 0.0 && self.imposed[i] && opening[i] != 0.0 && limits[i].is_finite();
        (0..rows.len()).filter(|i| slips(*i)).for_each(|i| found.x[i] = -limits[i].copysign(opening[i]));
        let of_pair = |pair: &PairRows| self.friction(pair, limits, &found.x, &opening, &start.states);
        let solution = ExactSolution {
            fields: BodyFields { bodies: forces.into_iter().map(BodyField::Forces).collect(), amounts },
            traces,
            opening: rows.by_pair(&opening),
            contact_force: rows.by_pair(&found.x),
            friction: rows.pairs.iter().map(of_pair).collect(),
            status: found.status,
            path: found.path,
            iterations: found.iterations,
            clarabel_calls: found.counts.clarabel_calls(),
            kkt: found.kkt,
        };
        Ok((solution, start))
    }

    /// Returns a first set for a problem without friction in which nodes have more rows against obstacles than unknowns; `None` if there is no such node. Of these rows only
    /// the tightest one is closed: they depend on each other, and one obstacle of many is near.
    fn without_crowds(&self) -> Option<Vec<BoundState>> {
        let ContactSystem { rows, of_body, bodies, .. } = self.system;
        let mut states = vec![BoundState::Free; rows.len()];
        for (of_body, body) in of_body.iter().zip(bodies) {
            let leaders = leaders(body.len(), of_body.iter().map(|row| &*row.terms));
            let (mut unknowns, mut crowds) = (vec![0; body.len()], vec![Vec::new(); body.len()]);
            leaders.iter().for_each(|leader| unknowns[*leader] += 1);
            // Rows between two bodies depend on each other in both, or not at all.
            let alone = |of: &&BodyRow| rows.rows[of.row].obstacle.is_some() && !of.terms.is_empty();
            for of in of_body.iter().filter(alone) {
                crowds[leaders[of.terms[0].0]].push(of.row);
            }
            for (crowd, _) in crowds.iter().zip(unknowns).filter(|(crowd, unknowns)| crowd.len() > *unknowns)
            {
                let tightest = crowd.iter().min_by(|a, b| self.linear[**a].total_cmp(&self.linear[**b]));
                let others = crowd.iter().filter(|row| Some(*row) != tightest);
                others.for_each(|row| states[*row] = BoundState::Lower);
            }
        }
        let has_friction = rows.pairs.iter().any(PairRows::has_friction);
        (!has_friction && states.contains(&BoundState::Lower)).then_some(states)
    }

    /// Returns the limits that the programme has: none of imposed rows, which no force moves. In a disc that slips an imposed row counts.
    fn own_limits(&self, limits: &[f64]) -> Vec<f64> {
        let mut own: Vec<f64> =
            limits.iter().zip(&self.imposed).map(|(s, imposed)| if *imposed { 0.0 } else { *s }).collect();
        let most = self.linear.iter().fold(0.0f64, |most, q| most.max(q.abs()));
        for row in self.system.rows.tangential_planes().flatten() {
            if self.imposed[row] && self.linear[row].abs() > ROUND_OFF * most {
                own[row] = limits[row];
            }
        }
        own
    }

    /// Takes what belongs to the friction of a pair.
    fn friction(
        &self,
        pair: &PairRows,
        limits: &[f64],
        x: &[f64],
        y: &[f64],
        states: &[BoundState],
    ) -> PairFriction {
        let tangential = pair.tangential.clone();
        let sticks = |t: usize| states[t] == BoundState::Free || self.imposed[t] && y[t] == 0.0;
        let state = |(k, n): (usize, usize)| match states[n] {
            BoundState::Lower => NodeState::Open,
            _ if pair.tangents(k).all(sticks) => NodeState::Stick,
            _ => NodeState::Slip,
        };
        let nodes = if pair.has_friction() { pair.normal.clone() } else { 0..0 };
        PairFriction {
            force: x[tangential.clone()].to_vec(),
            slip: y[tangential.clone()].iter().map(|y| 0.0 - y).collect(),
            limit: limits[tangential.clone()].to_vec(),
            state: nodes.enumerate().map(state).collect(),
        }
    }
}

/// Computes the traces of both sides of all rows under forces on the interface unknowns, m.
fn traces(system: &ContactSystem<'_>, forces: &[Vec<f64>], amounts: &[f64]) -> [Vec<f64>; 2] {
    let rows = &system.rows;
    let mut traces =
        [vec![0.0; rows.len()], rows.rows.iter().map(|row| row.obstacle.unwrap_or(0.0)).collect()];
    let unknowns = each_body(system.bodies.len(), |b| unknowns(system.bodies[b], Some(&forces[b])));
    for (of_body, unknowns) in system.of_body.iter().zip(&unknowns) {
        of_body.iter().for_each(|row| traces[row.side][row.row] = row.of(unknowns) + row.imposed);
    }
    for (motion, amount) in rows.motions.iter().zip(amounts) {
        for (row, trace) in &motion.traces {
            let side = usize::from(rows.pairs[rows.rows[*row].pair].partner == motion.partner);
            traces[side][*row] += amount * trace;
        }
    }
    traces
}

/// Computes the interface unknowns of a body under its load and further forces, m.
fn unknowns(body: &InterfaceOperator, forces: Option<&[f64]>) -> Vec<f64> {
    let mut sum = body.condensed_load().to_vec();
    sum.iter_mut().zip(forces.unwrap_or_default()).for_each(|(sum, force)| *sum += force);
    let mut unknowns = vec![0.0; body.len()];
    body.trace_from_force(&sum, &mut unknowns);
    unknowns
}

/// Computes `q`.
fn linear(system: &ContactSystem<'_>) -> Vec<f64> {
    let gap = |row: &ContactRow| row.gap - row.obstacle.unwrap_or(0.0);
    let mut linear: Vec<f64> = system.rows.rows.iter().map(gap).collect();
    for (body, of_body) in system.bodies.iter().zip(&system.of_body) {
        let free = unknowns(body, None);
        of_body.iter().for_each(|row| linear[row.row] -= row.of(&free) + row.imposed);
    }
    linear
}

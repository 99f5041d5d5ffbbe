//! The paper's iteration begins, Newton ends: two Neumann-Neumann steps find a set of closed pairs, and Newton's method corrects it; the linear
//! problem of each set is solved by the paper's two steps with the set held, for which they are linear.
//!
//! Step 1 is the paper's (8) on every body, since with the set held (9) is an equality on closed rows and freedom on open ones; step 2 is
//! (10) and (11) with the weights `D` in place of ½; θ is the one of conjugate gradients. One step of steepest descent with `D = ½` in full contact
//! is the paper's update. Every iterate is an admissible pair with the bound `η_c`: `newton_state.rs`.

use crate::balance::{Balance, NearestForces};
use crate::error::NnddError;
use crate::exact::solve_exactly;
use crate::iterate::{Iterate, IterationRow};
use crate::iteration::{Start, verdict};
use crate::newton_state::{Bonds, Contact};
use crate::paper::{FALLBACK, iteration};
use crate::set_search::{SetSearch, Turn};
use crate::settings::{Acceleration, NewtonSettings, NnddSettings};
use crate::solution::{NnddSolution, NnddStatus};
use crate::stopping::StoppingCriterion;
use fem_core::contact_system::ContactSystem;
use neumann_neumann::{Balancing, Broken, Skeleton};
use std::borrow::Cow;

/// Neumann-Neumann steps that begin.
const FIRST_STEPS: usize = 2;

/// The linear problem of a set that may be wrong is solved to this fraction of its first η.
const INEXACT: f64 = 0.1;

/// So it is near the set of the exact solution, in which no row may look wrong that is right.
const ACCURATE: f64 = 1e-6;

/// η below this fraction of the energy norm is rounding.
const FLOOR: f64 = 1e-14;

/// A row that closes at less than this fraction of the fastest one does not.
const NO_RATE: f64 = 1e-9;

/// Rows that close at the same time, to this fraction.
const TOGETHER: f64 = 1e-9;

/// The run so far.
struct Run<'a> {
    settings: &'a NewtonSettings,
    stop: &'a mut dyn StoppingCriterion,
    history: Vec<IterationRow>,
    clarabel_calls: usize,
}

/// Solves a contact problem without friction.
///
/// * `start`: with a set, such as the one of a coarser mesh, there are no Neumann-Neumann steps first.
pub(crate) fn solve(
    system: &ContactSystem<'_>,
    start: Start,
    settings: &NewtonSettings,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    // Refuse what is not held.
    let balance = Balance::new(&system.rows)?;
    balance.check_held(&system.rows.limits())?;
    // The operators, once.
    let broken = Broken::new(Cow::Borrowed(system), &balance.independent.rows)?;
    let bonds = Bonds::new(&broken)?;
    let mut nearest = NearestForces::new(&balance);
    let mut run = Run { settings, stop, history: Vec::new(), clarabel_calls: 0 };
    let (mut closed, mut x) = match run.first_set((system, &balance, &broken), &mut nearest, start)? {
        First::Set(closed, x) => (closed, x),
        First::Ended(ended) => return Ok(*ended),
    };
    let (mut search, mut step, mut settled) = (SetSearch::default(), 0, false);
    let mut openings = broken.openings(&x);
    loop {
        step += 1;
        // A set that holds no more is repaired: the rows close that are nearest along the free motion.
        hold(&mut nearest, &mut closed, &openings)?;
        search.see(&closed);
        // Clusters of unknowns, the weights D, and the coarse space of all motions.
        let (set, before) = (closed.clone(), openings.clone());
        let operators = || Balancing::new(&broken, Skeleton::new(&broken, &set, &before));
        let mut linear = operators()?;
        // Step 1: λ imposed on both sides of closed rows (8), all bodies in balance.
        let mut inner = linear.step_1(&broken, &broken.load, &x);
        let free = balance.left_by(&linear.skeleton.held(closed.len()))?;
        let floor = FLOOR * FLOOR * inner.energy;
        if inner.squared <= floor {
            inner.squared = 0.0;
        }
        let mut gains = true;
        loop {
            let is_first = run.history.is_empty();
            // Step 2 (10), (11), and the update of λ: until η has fallen to a tenth; on the right set of bodies in one piece one at a time.
            let part = if search.knows { ACCURATE } else { INEXACT };
            // An iterate of subdomains costs as much as many inner iterations.
            let goal = match inner.count == 0 || broken.shares() {
                true => part * part * inner.squared,
                false => inner.squared,
            };
            // The first iterate of a run is the one that all others are measured against.
            while !is_first && gains && inner.squared >= goal && !run.stop.is_interrupted() {
                gains = inner.squared > floor && linear.update(&broken, &mut inner);
            }
            // Forces, openings, wrong signs; P̃ and η_c in the place of η_NNDD (22).
            let contact = Contact::new(&broken, &linear, &inner, (&balance, &free));
            let is_right = contact.wrong.is_empty() || settled;
            let wrong = contact.wrong.clone();
            (closed, openings, x) = (contact.next(), contact.openings.clone(), contact.x.clone());
            let number = (run.history.len() + 1, step);
            let last = contact.iterate((&broken, &bonds), (&balance, &mut nearest), &inner, number)?;
            // An estimate of subdomains needs the memory of the operators.
            let kept = (!broken.shares()).then_some(linear);
            // Stop, or give up?
            if let Some(status) = run.verdict(&last, gains || !is_right)? {
                return Ok(run.ended(status, last));
            }
            if !is_right && !is_first {
                // All wrong rows change sides, unless that leads nowhere.
                match search.turn(&wrong, &closed) {
                    Turn::All => {}
                    // There is no exact solution of bodies in subdomains: from now on the linear problems are solved accurately.
                    Turn::Exact if broken.shares() => {}
                    Turn::Exact => closed = run.exact_set(system)?,
                    Turn::One(row) => {
                        wrong.iter().filter(|k| **k != row).for_each(|k| closed[*k] = !closed[*k]);
                    }
                    Turn::GiveUp => settled = true,
                }
                break;
            }
            linear = kept.map_or_else(operators, Ok)?;
        }
    }
}

/// How a run begins.
enum First {
    /// With a set of closed rows, and traces.
    Set(Vec<bool>, Vec<f64>),
    /// It ends in the first steps.
    Ended(Box<NnddSolution>),
}

impl Run<'_> {
    /// Finds the first set: none if nothing presses, else the one of a coarser mesh, of two steps of the paper's iteration, or all rows.
    fn first_set(
        &mut self,
        (system, balance, broken): (&ContactSystem<'_>, &Balance<'_>, &Broken<'_>),
        nearest: &mut NearestForces,
        Start { lambda, active }: Start,
    ) -> Result<First, NnddError> {
        let rows = system.rows.len();
        // No forces are needed, and none appear: they are zero, and not what rounding leaves of those before.
        let x = broken.flexibility(&broken.load.forces);
        let apart = vec![false; rows];
        // Subdomains are not solved one by one, unless there is nothing to solve.
        let is_solved = !broken.shares() || broken.load.forces.iter().all(|f| *f == 0.0);
        if is_solved && nearest.left_by(&apart)?.is_none() && broken.openings(&x).iter().all(|o| *o >= 0.0) {
            return Ok(First::Set(apart, x));
        }
        if let Some(active) = active {
            let traces = |row: usize| [lambda[row], system.rows.rows[row].gap - lambda[row]];
            return Ok(First::Set(active.as_slice().to_vec(), traces_of(broken, traces)));
        }
        // Bodies that contact alone holds, and bodies in subdomains, begin with all rows: their programmes cost more than the Newton steps that they save.
        let full = || First::Set(vec![true; rows], vec![0.0; broken.len()]);
        if broken.shares() || system.rows.motions.iter().any(|of| !of.traces.is_empty()) {
            return Ok(full());
        }
        Ok(match self.first_steps((system, balance), &lambda)? {
            None => full(),
            Some(ended)
                if ended.status != NnddStatus::MaxIterations
                    || self.settings.max_iterations <= FIRST_STEPS =>
            {
                First::Ended(Box::new(ended))
            }
            Some(NnddSolution { last, .. }) => {
                let [first, second] = last.traces();
                let traces = traces_of(broken, |row| [first[row], 0.0 - second[row]]);
                First::Set(last.contact.active.as_slice().to_vec(), traces)
            }
        })
    }

    /// Takes two steps of the paper's iteration; `None` if rows depend on each other, which it does not allow.
    fn first_steps(
        &mut self,
        problem: (&ContactSystem<'_>, &Balance<'_>),
        lambda: &[f64],
    ) -> Result<Option<NnddSolution>, NnddError> {
        let settings = NnddSettings {
            theta: Some(FALLBACK),
            acceleration: Acceleration::None,
            max_iterations: self.settings.max_iterations.min(FIRST_STEPS),
            // Active sets are cheaper than Clarabel for a set that need not be exact.
            qp: self.settings.qp.clone().active_sets_first(),
            ..NnddSettings::default()
        };
        let start = Start { lambda: lambda.to_vec(), active: None };
        let found = match iteration(problem, start, &settings, &mut *self.stop) {
            Err(NnddError::DependentRows { .. }) => return Ok(None),
            found => found?,
        };
        self.history.clone_from(&found.history);
        self.clarabel_calls = found.clarabel_calls;
        Ok(Some(found))
    }

    /// Takes an iterate into the history, and tells whether and how the run ends with it.
    ///
    /// * `gains`: whether inner iterations can still lower η.
    fn verdict(&mut self, last: &Iterate, gains: bool) -> Result<Option<NnddStatus>, NnddError> {
        self.history.push(IterationRow::from(last));
        let floor = self.history.iter().map(|row| row.eta_nndd).fold(f64::INFINITY, f64::min);
        let judge = |_| (!gains).then_some(NnddStatus::Stalled { floor, at_round_off: true });
        verdict(last, self.settings.max_iterations, self.stop, judge)
    }

    fn ended(self, status: NnddStatus, last: Iterate) -> NnddSolution {
        let Self { history, clarabel_calls, .. } = self;
        NnddSolution { status, history, last, theta: 0.0, spectrum: None, clarabel_calls }
    }

    /// Returns the set of the exact solution: active sets, Clarabel and single pivots find it.
    fn exact_set(&mut self, system: &ContactSystem<'_>) -> Result<Vec<bool>, NnddError> {
        let exact = solve_exactly(system, &self.settings.qp)?;
        self.clarabel_calls += exact.clarabel_calls;
        Ok(exact.contact_force.concat().iter().map(|p| *p > 0.0).collect())
    }
}

/// Repairs a set that does not hold all bodies: while `G_A P = e` has no solution, the rows close that are nearest along what it leaves.
fn hold(nearest: &mut NearestForces, closed: &mut [bool], openings: &[f64]) -> Result<(), NnddError> {
    while let Some(left) = nearest.left_by(closed)? {
        let rates = nearest.rates(&left);
        let largest = rates.iter().fold(0.0f64, |most, rate| most.max(rate.abs()));
        let closing: Vec<usize> =
            (0..closed.len()).filter(|row| !closed[*row] && rates[*row] > NO_RATE * largest).collect();
        let after = |row: &usize| openings[*row].max(0.0) / rates[*row];
        let first = closing.iter().map(after).fold(f64::INFINITY, f64::min);
        if closing.is_empty() {
            break;
        }
        closing
            .iter()
            .filter(|row| after(row) <= first * (1.0 + TOGETHER))
            .for_each(|row| closed[*row] = true);
    }
    Ok(())
}

/// Returns the interface unknowns from traces of both bodies of each row, of Ω₁ and Ω₂ along their own outward normals, m.
fn traces_of(broken: &Broken<'_>, traces: impl Fn(usize) -> [f64; 2]) -> Vec<f64> {
    let system = broken.system();
    let mut x = vec![0.0; broken.len()];
    for (b, of_body) in system.of_body.iter().enumerate() {
        for row in of_body {
            if let [(unknown, factor)] = row.terms[..] {
                let role = system.rows.pairs[system.rows.rows[row.row].pair].roles.of_side(row.side);
                x[broken.of_body(b).start + unknown] = (traces(row.row)[role] - row.imposed) / factor;
            }
        }
    }
    broken.spread(&mut x);
    x
}

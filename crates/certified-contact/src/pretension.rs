//! Cuts with a given force: the shortening is found with which the exact solution has this force.
//!
//! The force is the derivative of the potential energy by the shortening, so it does not fall if the shortening grows, and as long as the contact
//! does not change it is linear in it. Quasi-Newton steps solve `F(δ) = F`: with differences at first, then with Broyden's update as long as it does
//! well.

use crate::error::SolveError;
use crate::observer::Observer;
use crate::space::ContactSpace;
use contact_qp::QpSettings;
use fem_core::body::Body;
use fem_core::interface::ContactProblem;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Space;
use nalgebra::{DMatrix, DVector};

/// Forces that differ by less, relative to the largest one, are equal.
const SAME_FORCE: f64 = 1e-13;
/// Forces that differ by less are near enough if no step brings them nearer.
const NEAR: f64 = 1e-11;
/// At most this many solutions.
const MOST_SOLUTIONS: usize = 100;
/// A step that leaves more of the difference needs new differences.
const GOOD_STEP: f64 = 0.1;
/// Combinations of shortenings whose stiffness is below this part of the largest one do not change the forces.
const DEPENDENT: f64 = 1e-8;
/// Least stiffness, as a part of that of the cells beyond the cut alone: a bolt whose head touches nothing yet has none.
const LEAST_STIFFNESS: f64 = 1e-4;
/// The step of a difference, as a part of what the missing force would shorten the cells beyond the cut.
const DIFFERENCE: f64 = 1e-2;
/// Between a part of a step that is too short and one that is too long, the next one is at least this part of their distance away from both.
const NEAREST: f64 = 0.05;
/// The next part of a step that is too short, over the last one.
const FARTHER: f64 = 8.0;

/// A cut whose force is given: its body, and its place there.
#[derive(Clone, Copy, Debug)]
struct Tightened {
    body: usize,
    cut: usize,
    /// The given force, N/m.
    force: f64,
    /// The stiffness of the cells beyond the cut, N/m per m.
    stiffness: f64,
    /// The size of the body, m: a bolt is not shortened by more.
    size: f64,
}

/// A prepared problem with shortenings, and the forces of its solution less the given ones.
struct State<S: Space> {
    prepared: PreparedProblem<S>,
    shortenings: DVector<f64>,
    difference: DVector<f64>,
    /// The largest of the given forces and the sums of the terms of those of the solution, N/m.
    size: f64,
}

/// Refuses given forces in cuts without the exact solution.
pub(crate) fn check<S: Space>(problem: &ContactProblem<S>, exact: bool) -> Result<(), SolveError<S>> {
    match tightened(problem).first() {
        Some(Tightened { body, cut, .. }) if !exact => {
            let name = problem.bodies[*body].cuts()[*cut].name.clone();
            Err(SolveError::CutMethod { name })
        }
        _ => Ok(()),
    }
}

/// Finds the shortenings of all cuts whose forces are given. A problem without such a cut is not changed.
///
/// # Errors
/// Forces that no shortening gives, an assembly that is not held.
pub(crate) fn tighten<S: ContactSpace>(
    prepared: PreparedProblem<S>,
    observer: &mut dyn Observer<S>,
) -> Result<PreparedProblem<S>, SolveError<S>> {
    let cuts = tightened(prepared.problem());
    if cuts.is_empty() {
        return Ok(prepared);
    }
    let known = cuts.iter().map(|of| prepared.problem().bodies[of.body].cuts()[of.cut].shortening);
    let known = DVector::from_iterator(cuts.len(), known);
    let mut solutions = 0;
    let mut solved = |prepared: PreparedProblem<S>, shortenings: DVector<f64>| {
        solutions += 1;
        if observer.must_stop() {
            return Err(SolveError::Stopped);
        }
        let state = solved_state(prepared, &cuts, shortenings)?;
        if solutions < MOST_SOLUTIONS || state.is_near() { Ok(state) } else { Err(state.unreached(&cuts)) }
    };
    let mut now = solved(prepared, known)?;
    let mut updated: Option<DMatrix<f64>> = None;
    while now.difference.amax() > SAME_FORCE * now.size {
        let fresh = updated.is_none();
        let matrix = match updated.take() {
            Some(matrix) => matrix,
            None => {
                let (matrix, state) = differences(now, &cuts, &mut solved)?;
                now = state;
                matrix
            }
        };
        let before = now.difference.clone();
        let Some(step) = newton_step(&matrix, &before, &cuts) else { return Err(now.unreached(&cuts)) };
        let from = now.shortenings.clone();
        now = along(now, &cuts, &step, &mut solved)?;
        if now.difference.amax() <= GOOD_STEP * before.amax() {
            let taken = &now.shortenings - from;
            let missed = &now.difference - &before - &matrix * &taken;
            updated = Some(matrix + missed * taken.transpose() / taken.norm_squared());
        } else if fresh && now.is_near() {
            break;
        }
    }
    Ok(now.prepared)
}

impl<S: Space> State<S> {
    /// Tells whether the forces are the given ones but for rounding.
    fn is_near(&self) -> bool {
        self.difference.amax() <= NEAR * self.size
    }

    /// Says which force is farthest from the given one.
    fn unreached(&self, cuts: &[Tightened]) -> SolveError<S> {
        let worst = self.difference.iamax();
        let Tightened { body, cut, force, .. } = cuts[worst];
        let of = &self.prepared.problem().bodies[body].cuts()[cut];
        SolveError::CutForce {
            name: of.name.clone(),
            force,
            found: force + self.difference[worst],
            shortening: of.shortening,
        }
    }
}

/// Lists the cuts whose forces are given.
fn tightened<S: Space>(problem: &ContactProblem<S>) -> Vec<Tightened> {
    let of_body = |(body, of): (usize, &Body<S>)| -> Vec<Tightened> {
        let given = of.cuts().iter().enumerate().filter_map(|(cut, found)| Some((cut, found, found.force?)));
        let tightened = |(cut, found, force)| {
            let (stiffness, size) = (of.cut_stiffness(found), of.mesh().diagonal());
            Tightened { body, cut, force, stiffness, size }
        };
        given.map(tightened).collect()
    };
    problem.bodies.iter().enumerate().flat_map(of_body).collect()
}

/// Solves the problem with some shortenings.
fn solved_state<S: ContactSpace>(
    prepared: PreparedProblem<S>,
    cuts: &[Tightened],
    shortenings: DVector<f64>,
) -> Result<State<S>, SolveError<S>> {
    let (mut problem, bodies) = prepared.into_parts();
    for (b, body) in problem.bodies.iter_mut().enumerate().filter(|(_, body)| body.has_cut_forces()) {
        let mut all: Vec<f64> = body.cuts().iter().map(|cut| cut.shortening).collect();
        let own = cuts.iter().zip(&shortenings).filter(|(of, _)| of.body == b);
        own.for_each(|(of, shortening)| all[of.cut] = *shortening);
        body.shorten(&all);
    }
    let prepared =
        PreparedProblem::prepare_again(problem, bodies, &[], |_| true).map_err(SolveError::Prepare)?;
    let solution = nndd::solve_exactly(&prepared.system(), &QpSettings::default())
        .map_err(|error| SolveError::of_nndd(prepared.problem(), error))?;
    let displacement = prepared.displacements(&solution.fields);
    let bodies = prepared.problem().bodies.iter().zip(&displacement);
    let found: Vec<Vec<[f64; 2]>> = bodies.map(|(body, of)| body.cut_forces(of)).collect();
    let difference = cuts.iter().map(|of| found[of.body][of.cut][0] - of.force);
    let difference = DVector::from_iterator(cuts.len(), difference);
    // Rounding of the displacements beyond a cut is that of the force of its shortening alone.
    let sizes = cuts.iter().zip(&shortenings).map(|(of, shortening)| {
        of.force.abs().max(found[of.body][of.cut][1]).max(of.stiffness * shortening.abs())
    });
    let size = sizes.fold(0.0, f64::max);
    Ok(State { prepared, shortenings, difference, size })
}

/// Computes the shortest step in the norm of the stiffnesses that should take the differences away, as far as one can: two cuts of a ring have one
/// force. `None` if the matrix is not finite.
fn newton_step(matrix: &DMatrix<f64>, difference: &DVector<f64>, cuts: &[Tightened]) -> Option<DVector<f64>> {
    let scale = DVector::from_iterator(cuts.len(), cuts.iter().map(|of| of.stiffness.sqrt().recip()));
    let scaled = DMatrix::from_fn(cuts.len(), cuts.len(), |i, k| scale[i] * matrix[(i, k)] * scale[k]);
    if !scaled.iter().chain(difference).all(|x| x.is_finite()) {
        return None;
    }
    let decomposed = scaled.svd(true, true);
    let least = DEPENDENT * decomposed.singular_values.amax();
    let step = decomposed.solve(&-difference.component_mul(&scale), least).ok()?.component_mul(&scale);
    step.iter().all(|x| x.is_finite()).then_some(step)
}

/// Goes along a step to where the potential energy is about least. Its derivative by the part of the step, the work of the differences, grows with it.
fn along<S: ContactSpace>(
    from: State<S>,
    cuts: &[Tightened],
    step: &DVector<f64>,
    solved: &mut impl FnMut(PreparedProblem<S>, DVector<f64>) -> Result<State<S>, SolveError<S>>,
) -> Result<State<S>, SolveError<S>> {
    let start = from.shortenings.clone();
    let slope = from.difference.dot(step);
    // Parts of the step that are too short and too long, with the derivatives there.
    let (mut low, mut high) = ([0.0, slope], None);
    let farthest = |k: usize| (cuts[k].size - start[k] * step[k].signum()) / step[k].abs();
    let farthest = (0..cuts.len()).map(farthest).fold(f64::INFINITY, f64::min);
    let (mut now, mut part) = (from, farthest.min(1.0));
    loop {
        now = solved(now.prepared, &start + step * part)?;
        let found = now.difference.dot(step);
        if !(found.abs() > GOOD_STEP * slope.abs()) || now.is_near() {
            return Ok(now);
        }
        if found < 0.0 && part >= farthest {
            return Err(now.unreached(cuts));
        }
        match found < 0.0 {
            true => low = [part, found],
            false => high = Some([part, found]),
        }
        let [a, from] = low;
        let Some([b, to]) = high else {
            part = farthest.min(part * FARTHER);
            continue;
        };
        if b - a <= f64::EPSILON * b {
            return Ok(now);
        }
        // The zero of the line between both ends, but not too near to one of them.
        let zero = from / (from - to);
        part = a + (b - a) * zero.clamp(NEAREST, 1.0 - NEAREST);
    }
}

/// Computes the change of each force per unit of each shortening, and goes back to where it was.
fn differences<S: ContactSpace>(
    state: State<S>,
    cuts: &[Tightened],
    solved: &mut impl FnMut(PreparedProblem<S>, DVector<f64>) -> Result<State<S>, SolveError<S>>,
) -> Result<(DMatrix<f64>, State<S>), SolveError<S>> {
    let State { mut prepared, shortenings, difference, size } = state;
    let mut matrix = DMatrix::zeros(cuts.len(), cuts.len());
    for (k, of) in cuts.iter().enumerate() {
        let step = DIFFERENCE * difference[k].abs().max(DIFFERENCE * size) / of.stiffness;
        let mut moved = shortenings.clone();
        moved[k] += step;
        let found = solved(prepared, moved)?;
        matrix.set_column(k, &((&found.difference - &difference) / step));
        matrix[(k, k)] = matrix[(k, k)].max(LEAST_STIFFNESS * of.stiffness);
        prepared = found.prepared;
    }
    Ok((matrix, State { prepared, shortenings, difference, size }))
}

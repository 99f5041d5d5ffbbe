//! Improves the solution to the accuracy that double precision allows.
//!
//! The factorised operators are those of the rounded stiffness. If a soft part supports a stiff one, their solution may
//! have few correct digits or no correct digit. Defect correction repairs that: the forces of the current fields are
//! evaluated without rounding, and the same contact problem is solved for the *increments* with the same operators,
//! ```math
//! r^α = r₀^α + S_α x^α,   r₀^α = K u₀^α − f,   o = (g − [v₀]) − (x^1 − x^2) ≥ 0
//! ```
//! until the increments vanish: (28) of [`crate::theory`].

use fem_core::double_double::DoubleDouble;
use fem_core::interface::{ContactPair, NodePair};
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};
use nndd::stopping::EtaNndd;
use nndd::{ContactAnswer, Iterate, Method, NnddError, NnddSettings, Path, Start};
use rayon::prelude::*;

/// An increment larger than this fraction of the previous one is the last.
const WORTHWHILE: f64 = 0.7;
/// Maximum number of corrections.
const MOST_CORRECTIONS: usize = 40;
/// In each correction the iteration lowers η_NNDD by this factor.
const REDUCTION: f64 = 1e-2;
/// Maximum number of iterations of one correction.
const MOST_ITERATIONS: usize = 30;

/// An iterate and its fields.
pub(crate) struct Corrected {
    pub(crate) iterate: Iterate,
    pub(crate) fields: Vec<SplitField>,
}

/// Corrects an iterate by its own defect.
///
/// * `problem`: its gaps and condensed loads change and are restored.
/// * `fields`: of the iterate.
/// * `advance`: whether λ may change; if not, only step 1 is repeated for the same λ.
///
/// Returns `None` if no improvement is possible: the first increment is not finite, or the operators are not the
/// condensed ones.
///
/// # Errors
/// See [`nndd::solve_from`].
pub(crate) fn correct(
    problem: &mut PreparedProblem,
    iterate: &Iterate,
    fields: Vec<SplitField>,
    method: &Method,
    advance: bool,
) -> Result<Option<Corrected>, NnddError> {
    if matches!(method, Method::Nndd(NnddSettings { path: Path::Literal, .. })) {
        return Ok(None);
    }
    let Some(pair) = problem.problem().plain_pair() else { return Ok(None) };
    let gaps: Vec<f64> = pair.interface.pairs().iter().map(|p| p.gap).collect();
    let loads: Vec<Vec<f64>> = problem.bodies().iter().map(|body| body.condensed_load().to_vec()).collect();
    let pair = pair.clone();
    let method = method.clone().with_max_iterations(if advance { MOST_ITERATIONS } else { 1 });
    let mut correction = Correction { increments: problem, pair, gaps, method };
    let found = correction.run(iterate, fields);
    let Correction { increments: problem, gaps, .. } = correction;
    problem.replace_gaps(0, &gaps);
    for (body, load) in problem.bodies_mut().iter_mut().zip(loads) {
        body.replace_condensed_load(load);
    }
    found
}

struct Correction<'a> {
    /// The problem for increments about the current fields: its gaps and condensed loads are what the fields leave.
    increments: &'a mut PreparedProblem,
    /// The only pair, with its own gaps.
    pair: ContactPair,
    gaps: Vec<f64>,
    method: Method,
}

impl Correction<'_> {
    fn run(
        &mut self,
        iterate: &Iterate,
        mut fields: Vec<SplitField>,
    ) -> Result<Option<Corrected>, NnddError> {
        let mut best: Option<Corrected> = None;
        let mut active = iterate.contact.active.clone();
        let mut before = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            let forces = self.restate(&mut fields);
            let start = Start { lambda: vec![0.0; active.len()], active: Some(active) };
            let mut stop = EtaNndd::new(REDUCTION);
            let found = nndd::solve_from(self.increments, start, &self.method, &mut stop)?.last;
            let size = increment_energy(&found, &forces);
            if !(size < before) {
                break;
            }
            let (sides, bodies) = (self.increments.sides(0), [self.pair.imposed(), self.pair.unilateral()]);
            for (role, x) in found.traces().into_iter().enumerate() {
                fields[bodies[role]].add(&sides[role].correction_from_trace(x));
            }
            active = found.contact.active.clone();
            let worthwhile = size < WORTHWHILE * before && size > 0.0;
            before = size;
            best = Some(Corrected { iterate: self.total(iterate, found, &fields), fields: fields.clone() });
            if !worthwhile {
                break;
            }
        }
        Ok(best)
    }

    /// Brings the fields into equilibrium for their traces and sets up the problem for increments from them. Returns
    /// the forces of both bodies on the interface.
    fn restate(&mut self, fields: &mut [SplitField]) -> [Vec<f64>; 2] {
        let Self { increments, pair, gaps, .. } = self;
        let of_body = |b: usize, field: &mut SplitField| {
            let (body, condensed) = (&increments.problem().bodies[b], &increments.bodies()[b]);
            condensed.refine(body, &[], true, field);
            condensed.interface_forces(&residual::of_field(body, field))
        };
        let forces: Vec<Vec<f64>> =
            fields.par_iter_mut().enumerate().map(|(b, field)| of_body(b, field)).collect();
        for (body, r) in increments.bodies_mut().iter_mut().zip(&forces) {
            body.replace_condensed_load(r.iter().map(|r| -r).collect());
        }
        let [first, second] = pair.bodies.map(|b| &fields[b]);
        let pairs = pair.interface.pairs().iter().zip(gaps.iter());
        let opening = |(pair, gap): (&NodePair, &f64)| opening([first, second], pair, *gap).rounded();
        let openings: Vec<f64> = pairs.map(opening).collect();
        increments.replace_gaps(0, &openings);
        let sign = pair.roles.sign();
        [pair.imposed(), pair.unilateral()].map(|b| forces[b].iter().map(|r| sign * r).collect())
    }

    /// Converts an iterate of the increments into one of the problem.
    fn total(&self, iterate: &Iterate, found: Iterate, fields: &[SplitField]) -> Iterate {
        let roles = self.pair.roles;
        let trace = |role: usize| -> Vec<f64> {
            let side = roles.sides()[role];
            let pairs = self.pair.interface.pairs().iter();
            pairs
                .map(|p| {
                    let u = fields[self.pair.bodies[side]].at(p.nodes[side].index());
                    roles.sign() * (u[0] * p.normal[0] + u[1] * p.normal[1]).rounded()
                })
                .collect()
        };
        Iterate {
            lambda: trace(0),
            contact: ContactAnswer { normal_trace: trace(1), ..found.contact },
            programme: iterate.programme,
            iteration: iterate.iteration,
            theta: iterate.theta,
            reaction: found.reaction,
            opening: found.opening,
            precision: found.precision,
            eta_nndd: found.eta_nndd,
            recovery: found.recovery,
            motions: found.motions,
            tangential: found.tangential,
        }
    }
}

/// Computes the opening `g − (u¹ − u²)·n` of a pair.
fn opening(fields: [&SplitField; 2], pair: &NodePair, gap: f64) -> DoubleDouble {
    let [a, b] = [0, 1].map(|b: usize| fields[b].at(pair.nodes[b].index()));
    (b[0] - a[0]) * pair.normal[0] + (b[1] - a[1]) * pair.normal[1] + gap
}

/// Computes `Σ x·S x` of the increments of both bodies, J/m.
fn increment_energy(found: &Iterate, forces: &[Vec<f64>; 2]) -> f64 {
    let energy = |x: &[f64], r: &[f64], before: &[f64]| -> f64 {
        x.iter().zip(r.iter().zip(before)).map(|(x, (r, r0))| x * (r - r0)).sum()
    };
    let first = energy(&found.lambda, &found.reaction, &forces[0]);
    let second = energy(&found.contact.normal_trace, &found.contact.normal_reaction, &forces[1]);
    first.max(0.0) + second.max(0.0)
}

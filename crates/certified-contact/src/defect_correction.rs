//! Improves the solution to the accuracy that double precision allows.
//!
//! The factorised operators are those of the rounded stiffness. If a soft part supports a stiff one, their solution may
//! have few correct digits or no correct digit. Defect correction repairs that: the forces of the current fields are
//! evaluated without rounding, and the same contact problem is solved for the *increments* with the same operators,
//! ```math
//! r^α = r^α_0 + S_α x^α, \qquad r^α_0 = K u^α_0 - f, \qquad o = (g - [v_0]) - (x^1 - x^2) ≥ 0
//! ```
//! until the increments vanish: (28) of [`crate::theory`].

use fem_core::double_double::DoubleDouble;
use fem_core::interface::Pair;
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};
use nndd::stopping::EtaNndd;
use nndd::{Iterate, NnddError, NnddSettings, Path, Start};

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
    pub(crate) fields: [SplitField; 2],
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
    fields: [SplitField; 2],
    settings: &NnddSettings,
    advance: bool,
) -> Result<Option<Corrected>, NnddError> {
    if settings.path == Path::Literal {
        return Ok(None);
    }
    let gaps: Vec<f64> = problem.problem().interface.pairs().iter().map(|p| p.gap).collect();
    let loads = problem.bodies().each_ref().map(|body| body.condensed_load().to_vec());
    let mut settings = settings.clone();
    settings.max_iterations = if advance { MOST_ITERATIONS } else { 1 };
    let mut correction = Correction { increments: problem, gaps, settings };
    let found = correction.run(iterate, fields);
    let Correction { increments: problem, gaps, .. } = correction;
    problem.replace_gaps(&gaps);
    for (body, load) in problem.bodies_mut().iter_mut().zip(loads) {
        body.replace_condensed_load(load);
    }
    found
}

struct Correction<'a> {
    /// The problem for increments about the current fields: its gaps and condensed loads are what the fields leave.
    increments: &'a mut PreparedProblem,
    /// The gaps of the problem itself.
    gaps: Vec<f64>,
    settings: NnddSettings,
}

impl Correction<'_> {
    fn run(
        &mut self,
        iterate: &Iterate,
        mut fields: [SplitField; 2],
    ) -> Result<Option<Corrected>, NnddError> {
        let mut best: Option<Corrected> = None;
        let mut active = iterate.contact.active.clone();
        let mut before = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            let forces = self.restate(&mut fields);
            let start = Start { lambda: vec![0.0; active.len()], active: Some(active) };
            let mut stop = EtaNndd::new(REDUCTION);
            let found = nndd::solve_from(self.increments, start, &self.settings, &mut stop)?.last;
            let size = increment_energy(&found, &forces);
            if !(size < before) {
                break;
            }
            let (sides, bodies) = (self.increments.sides(), self.increments.roles().bodies());
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
    fn restate(&mut self, fields: &mut [SplitField; 2]) -> [Vec<f64>; 2] {
        let Self { increments, gaps, .. } = self;
        let [first, second] = fields;
        let of_body = |b: usize, field: &mut SplitField| {
            let (body, condensed) = (&increments.problem().bodies[b], &increments.bodies()[b]);
            condensed.refine(body, &[], true, field);
            condensed.interface_forces(&residual::of_field(body, field))
        };
        let (r1, r2) = rayon::join(|| of_body(0, first), || of_body(1, second));
        for (body, r) in increments.bodies_mut().iter_mut().zip([&r1, &r2]) {
            body.replace_condensed_load(r.iter().map(|r| -r).collect());
        }
        let pairs = increments.problem().interface.pairs().iter().zip(gaps.iter());
        let openings: Vec<f64> = pairs.map(|(pair, gap)| opening(fields, pair, *gap).rounded()).collect();
        increments.replace_gaps(&openings);
        let sign = increments.roles().sign();
        let by_body = [r1, r2].map(|r| r.into_iter().map(|r| sign * r).collect());
        increments.roles().by_body(by_body)
    }

    /// Converts an iterate of the increments into one of the problem.
    fn total(&self, iterate: &Iterate, found: Iterate, fields: &[SplitField; 2]) -> Iterate {
        let roles = self.increments.roles();
        let trace = |role: usize| -> Vec<f64> {
            let b = roles.bodies()[role];
            let pairs = self.increments.problem().interface.pairs().iter();
            pairs
                .map(|p| {
                    let u = fields[b].at(p.nodes[b] as usize);
                    roles.sign() * (u[0] * p.normal[0] + u[1] * p.normal[1]).rounded()
                })
                .collect()
        };
        let mut contact = found.contact;
        contact.normal_trace = trace(1);
        contact.path = iterate.contact.path;
        contact.iterations = iterate.contact.iterations;
        Iterate {
            lambda: trace(0),
            contact,
            iteration: iterate.iteration,
            theta: iterate.theta,
            reaction: found.reaction,
            opening: found.opening,
            precision: found.precision,
            eta_nndd: found.eta_nndd,
        }
    }
}

/// Computes the opening `g − (u¹ − u²)·n` of a pair.
fn opening(fields: &[SplitField; 2], pair: &Pair, gap: f64) -> DoubleDouble {
    let [a, b] = [0, 1].map(|b: usize| fields[b].at(pair.nodes[b] as usize));
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

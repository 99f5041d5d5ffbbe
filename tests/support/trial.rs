//! One random problem: solved, certified, and its certificate held against other solutions.

use crate::adversarial::Family;
use crate::model::{ContactProblem, Made};
use crate::precise::{Precise, energy, minus, precise, rounded};
use crate::random::Random;
use crate::run::{certify_with, prepare};
use crate::witness::{Ladder, Law};
use certified_contact::{
    AdaptSettings, CertifiedSolution, Criterion, Imposed, Settings, Silent, solve, solve_adaptively,
};
use cre_estimator::{AdmissiblePair, Relaxation};
use nndd::NewtonSettings;

/// Nodes up to which cells are halved twice.
const SMALL: usize = 500;

/// A problem of a family, and what its certificate was held against.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Its number in the family.
    pub number: u64,
    /// Nodes of both bodies.
    pub nodes: usize,
    /// `√a(v, v)`.
    pub norm: f64,
    /// `e_CRE` with two steps of relaxation, and with the default.
    pub bounds: [f64; 2],
    /// The least error that the finer field proves; `None` without such a field.
    pub error: Option<f64>,
    /// The largest error that the finer solution's own bound leaves.
    pub largest: f64,
    /// `η_NNDD`, and the distance from another discrete solution.
    pub eta: [f64; 2],
    /// What is violated: `e_CRE` with two steps, by default, `η_NNDD`, the intervals of energy norm, potential energy and contact
    /// force.
    pub violations: [bool; 6],
}

impl Trial {
    /// Solves a member and holds its certificate against finer fields; `None` if there is no certificate.
    ///
    /// # Errors
    /// None, for problems that are solved.
    pub fn new(family: Family, number: u64) -> Made<Option<Self>> {
        let Some(solution) = solved(family, number) else { return Ok(None) };
        let (Some(estimate), Some(bounds)) = (&solution.estimate, &solution.bounds) else { return Ok(None) };
        let problem = &solution.problem;
        let prepared = prepare(problem);
        let iterate = solution.last();
        let two = certify_with(&prepared, iterate, Relaxation::Steps(2))?;
        let nodes = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
        let ladder = Ladder::new(problem, if nodes <= SMALL { 2 } else { 1 })?;
        let mut settings = Settings::default();
        settings.imposed = Imposed::First;
        let fine = solve(ladder.finest().clone(), &settings, &mut Silent).ok();
        let v = estimate.pair.displacements();
        let finer = fine.as_ref().and_then(|f| f.estimate.as_ref());
        let witness = finer.and_then(|finer| {
            let w = finer.pair.displacements();
            ladder.witness([v[0], v[1]], [w[0], w[1]], Law::Everywhere)
        });
        let discrete = discrete(problem, &estimate.pair, iterate.eta_nndd);
        let apart = |a: [f64; 2], b: [f64; 2]| !(a[0] <= b[1] && b[0] <= a[1]);
        let certified = fine.as_ref().filter(|f| f.is_certified()).and_then(|f| f.bounds);
        let force = certified.and_then(|b| b.contact_force.ok()).zip(bounds.contact_force.ok());
        let relaxed = [two.unchecked().e_cre, estimate.unchecked().e_cre];
        Ok(Some(Trial {
            number,
            nodes,
            norm: estimate.energy_norm(),
            bounds: relaxed,
            error: witness.map(|w| w.error()),
            largest: witness.zip(finer).map_or(f64::INFINITY, |(w, f)| w.error().hypot(f.unchecked().e_cre)),
            eta: [iterate.eta_nndd, discrete.map_or(f64::NAN, |d| d.0)],
            violations: [
                witness.is_some_and(|w| w.refutes(relaxed[0])),
                witness.is_some_and(|w| w.refutes(relaxed[1])),
                discrete.is_some_and(|d| d.1),
                certified.is_some_and(|b| apart(b.energy_norm, bounds.energy_norm)),
                certified.is_some_and(|b| apart(b.potential_energy, bounds.potential_energy)),
                force.is_some_and(|(a, b)| apart(a, b)),
            ],
        }))
    }

    /// Computes the effectivity: at most this, since the error is at least what the finer field proves.
    ///
    /// * `bound`: which of [`Self::bounds`].
    pub fn effectivity(&self, bound: usize) -> Option<f64> {
        self.error.filter(|e| *e > 0.0).map(|e| self.bounds[bound] / e)
    }
}

/// How a member is solved: mostly by default, some stopped early, some by Newton's method.
fn settings(random: &mut Random) -> Settings {
    let mut settings = Settings::default();
    let choice = random.unit();
    if choice < 0.25 {
        settings.criterion = Criterion::Iterations;
        settings.method = settings.method.with_max_iterations(1 + (random.unit() * 4.0) as usize);
    } else if choice < 0.4 {
        settings.method = NewtonSettings::default().into();
    }
    settings
}

fn solved(family: Family, number: u64) -> Option<CertifiedSolution> {
    let problem = family.problem(number).ok()?;
    let settings = settings(&mut Random::new(number));
    let solution = if family == Family::Adaptive {
        let mut adapt = AdaptSettings::new(1e-3);
        adapt.max_steps = 2 + (number % 3) as usize;
        adapt.max_nodes = 1500;
        solve_adaptively(problem, &Settings::default(), &adapt, &mut Silent).ok()?.solution
    } else {
        solve(problem, &settings, &mut Silent).ok()?
    };
    solution.is_certified().then_some(solution)
}

/// Holds `η_NNDD` of a pair against the discrete solution by Newton's method with the roles exchanged: how far the pair is from
/// it, and whether that violates one of the two, or the energy does; `None` without such a solution.
fn discrete(problem: &ContactProblem, pair: &AdmissiblePair, eta: f64) -> Option<(f64, bool)> {
    let mut settings = Settings::default();
    settings.imposed = Imposed::Second;
    settings.method = NewtonSettings::default().into();
    let other = solve(problem.clone(), &settings, &mut Silent).ok()?;
    let estimate = other.estimate.as_ref()?;
    let (v, w) = (pair.displacements(), estimate.pair.displacements());
    let squared = |b: usize| {
        let difference: Vec<Precise> =
            v[b].iter().zip(w[b]).map(|(v, w)| minus(precise(*v), precise(*w))).collect();
        energy(&problem.bodies[b], &difference)
    };
    let distance = rounded((squared(0) + squared(1)).sqrt());
    // Each claims to be that near to the discrete solution.
    let apart = !(distance <= eta + other.last().eta_nndd);
    let witness = Ladder::new(problem, 0).ok()?.witness([v[0], v[1]], [w[0], w[1]], Law::Nodes);
    Some((distance, apart || witness.is_some_and(|w| w.refutes(eta))))
}

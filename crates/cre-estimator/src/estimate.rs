//! The whole computation of a certificate, in one call.

use crate::admissible::{AdmissibleBody, AdmissibleContact, AdmissiblePair, check_state};
use crate::balance;
use crate::check::{Admissibility, FORCE_TOLERANCE, check_and_measure};
use crate::cre::Cre;
use crate::equilibrated::product;
use crate::error::EstimatorError;
use crate::indicators::{eta_dis, eta_nndd_squared, state_residuals};
use crate::measures::Accuracy;
use crate::openings;
use crate::parts::{Parts, parts};
use crate::recovery::Recovery;
use crate::relaxation::Relaxation;
use crate::relaxed::{KeptStars, pair_and_frozen};
use crate::round_off::{self, Noise};
use crate::size::{larger, largest_of, length};
use fem_core::body::Body;
use fem_core::element::Element;
use fem_core::interface::{ContactPair, ContactProblem, ContactState, PairState};
use fem_core::memory::fits_in_memory;
use fem_core::norm::{from_squared, sum_over_cells};
use fem_core::prepared::PreparedProblem;
use fem_core::space::{Plane, Space};
use neumann_neumann::{BodySolver, BodySolvers, ResidualEnergy};
use rayon::prelude::*;

/// Rounding is relative to squares above this, and a product of two of their roundings does not underflow.
const SMALLEST_SQUARE: f64 = 1e-250;

/// Refinement of the solves pays if rounding takes more than this share of the bound.
pub const ROUND_OFF_SHARE: f64 = 1e-3;

/// Allowance for the rounding of a sum over the interface and of what enters it: if `η_NNDD` equals the distance,
/// its own rounding could make it too small.
const ROUNDING_OF_A_SUM: f64 = 1e-12;

/// The estimate of a contact state.
///
/// [`Self::certificate`] returns the bound if its checks pass. [`Self::unchecked`] is for reports of failures.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Estimate<S: Space = Plane> {
    /// The admissible pair on which the bound is based.
    pub pair: AdmissiblePair<S>,
    /// The constitutive relation error and its split.
    pub cre: Cre,
    /// Residuals of admissibility, each the larger one of the stress of the bound and the stress of `η_dis`.
    pub admissibility: Admissibility,
    /// The part of `e_CRE` that is an allowance for round-off: smaller errors cannot be distinguished from
    /// zero.
    pub round_off: f64,
    /// `∫ σ(u) : E⁻¹ σ(u)` of the state's displacements in each body, J/m: `a(u, u)` without heat. Springs have no part in it.
    pub energy_norm_squared: Vec<f64>,
    /// The energy norm of each body up to which its displacements may be rigid motions and rounding, square root of J/m.
    pub(crate) energy_rounding: Vec<f64>,
    /// The mean of `τ` in every triangle of each body, Pa.
    pub mean_stress: Vec<Vec<S::Tensor>>,
    pub(crate) indicators: Indicators,
    /// True if a limit of friction is `μ p` of the estimate itself.
    pub(crate) coulomb: bool,
}

/// The numbers that are bounds if the checks pass, square root of J/m.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Indicators {
    /// `e_CRE` bounds the energy error of the state's displacements, round-off allowance included.
    pub e_cre: f64,
    /// `η_dis`, the error of the mesh for a frozen λ, round-off allowance included.
    pub eta_dis: f64,
    /// `η_NNDD`, a bound of the distance to the solution of the discrete problem, round-off included.
    pub eta_nndd: f64,
    /// The parts of `e_CRE`.
    pub parts: Parts,
}

impl<S: Space> Estimate<S> {
    /// Computes the energy norm of the state's displacements, `√Σ a`, square root of J/m.
    pub fn energy_norm(&self) -> f64 {
        self.energy_norm_squared.iter().sum::<f64>().sqrt()
    }

    /// Tells whether the bodies hold no strain energy: the energy norm of each is at most `64 ε` of what displacements of this size could
    /// give.
    pub fn holds_no_energy(&self) -> bool {
        self.energy_norm_squared
            .iter()
            .zip(&self.energy_rounding)
            .all(|(squared, least)| squared.sqrt() <= *least)
    }

    /// Divides a bound by the energy norm; `None` if the bodies hold no strain energy.
    pub fn over_norm(&self, bound: f64) -> Option<f64> {
        (!self.holds_no_energy()).then(|| bound / self.energy_norm())
    }

    /// Tells why there is no certificate: `lift` if the bodies penetrate each other and no lift parts them, `pressure` if no pressure balances
    /// the floating bodies, `rotation`, or the name of another check; `None` if all checks hold.
    pub fn reason(&self) -> Option<&'static str> {
        let (name, _) = self.admissibility.failed().next()?;
        Some(match name {
            "penetration" => "lift",
            "rigid_balance" if !(self.pair.rigid_balance <= FORCE_TOLERANCE) => "pressure",
            name => name,
        })
    }

    /// Computes `∫ p ds` of the pressure of the equilibrated stress along each contact line, N/m.
    ///
    /// * `problem`: the one that was estimated.
    pub fn pressure_forces(&self, problem: &ContactProblem<S>) -> Vec<f64> {
        let of_pair = |(of, contact): (&ContactPair<S>, &AdmissibleContact<S>)| -> f64 {
            let facets = of.interface.facets().iter().zip(&contact.edge_pressure);
            let sum = |p: &S::Axes<f64>| p.as_ref().iter().sum::<f64>();
            facets.map(|(facet, p)| facet.measure / S::DIM as f64 * sum(p)).sum()
        };
        problem.contacts.iter().zip(&self.pair.contacts).map(of_pair).collect()
    }

    /// Returns the bounds; `None` if a check of admissibility fails: then they are not bounds. Also `None` with Coulomb friction, for which no
    /// bound is known.
    pub fn certificate(&self) -> Option<&Indicators> {
        (self.admissibility.is_valid() && !self.coulomb).then_some(&self.indicators)
    }

    /// Returns the bounds of the problem with Tresca friction whose limit is the `μ p` of this estimate; they are **not** bounds of the problem
    /// with Coulomb friction. `None` if a check fails, and if the problem has no Coulomb friction: then see [`Self::certificate`].
    pub fn for_frozen_limit(&self) -> Option<&Indicators> {
        (self.admissibility.is_valid() && self.coulomb).then_some(&self.indicators)
    }

    /// Returns the same numbers even if they are not bounds: see [`Self::certificate`].
    pub fn unchecked(&self) -> &Indicators {
        &self.indicators
    }
}

/// Estimates the error of a contact state, whatever its source, by EET alone: [`estimate_with`] without
/// relaxation.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite.
pub fn estimate<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
) -> Result<Estimate<S>, EstimatorError> {
    estimate_with(prepared, state, Relaxation::NONE)
}

/// Estimates the error of a contact state, whatever its source: [`Estimator::estimate`] of a single state.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite, a lack of memory.
pub fn estimate_with<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    relaxation: Relaxation,
) -> Result<Estimate<S>, EstimatorError> {
    Estimator::new(prepared, relaxation).estimate(state)
}

/// Estimates the errors of several states of one problem. It keeps the stars of the relaxation: of small bodies from the
/// first estimate on, of large bodies from the second one.
pub struct Estimator<'a, S: Recovery = Plane> {
    prepared: &'a PreparedProblem<S>,
    /// From the first estimate on.
    solvers: Option<BodySolvers<'a, S>>,
    relaxation: Relaxation,
    /// Of each body, from the first estimate on.
    noise: Vec<Noise>,
    stars: KeptStars<'a, S>,
}

impl<'a, S: Recovery> Estimator<'a, S> {
    /// Creates an estimator.
    ///
    /// * `relaxation`: how far the equilibrated stresses are relaxed. The bound is strict at every step; more
    ///   steps make it sharper.
    pub fn new(prepared: &'a PreparedProblem<S>, relaxation: Relaxation) -> Self {
        Self { prepared, solvers: None, relaxation, noise: Vec::new(), stars: KeptStars::default() }
    }

    /// Computes the coefficients of the relaxation of solids again in each sweep, if asked: see [`StarMemory::Recomputed`](crate::recovery::StarMemory).
    pub fn recomputing(mut self, recomputes: bool) -> Self {
        self.stars.recomputes = recomputes;
        self
    }

    /// Estimates the error of a contact state, whatever its source. The result does not depend on the states before.
    ///
    /// If rounding takes a noticeable share of the bound, the estimate is repeated with iterative refinement and
    /// residuals in double-double numbers.
    ///
    /// # Errors
    /// Arrays of the wrong length, values that are not finite, a lack of memory.
    pub fn estimate(&mut self, state: &ContactState<'_, S>) -> Result<Estimate<S>, EstimatorError> {
        let prepared = self.prepared;
        check_state(prepared, state)?;
        if self.relaxation.max_steps() > 0 {
            let bodies = prepared.problem().bodies.iter().enumerate();
            let missing = bodies.filter(|(b, _)| !self.stars.has(*b));
            let bytes: usize =
                missing.map(|(_, body)| S::bytes_of_relaxation(body.mesh(), !self.stars.recomputes)).sum();
            if bytes > 0 && !fits_in_memory(bytes) {
                return Err(EstimatorError::OutOfMemory { bytes });
            }
        }
        if self.noise.is_empty() {
            self.noise = Noise::of_bodies(prepared.problem());
        }
        let own = openings::own(prepared.problem(), state);
        let slips = openings::own_slips(prepared.problem(), state);
        let contacts = state.contacts.iter().zip(own.iter().zip(&slips)).map(|(of, (own, slip))| PairState {
            opening: own.as_deref().unwrap_or(of.opening),
            slip: slip.as_deref().unwrap_or(of.slip),
            ..*of
        });
        let state = &ContactState { contacts: contacts.collect(), displacement: state.displacement.clone() };
        // The bound of the iteration also needs forces in balance. The pressure is computed from the given forces.
        let balanced = balance::forces(prepared, state)?;
        let first = self.estimate_once(state, &balanced, Accuracy::Double)?;
        // Loads of a floating body add up to zero only to rounding; an initial strain may leave a much smaller stress than the strain would give;
        // conjugate gradients over subdomains lose digits of nearly incompressible materials.
        let strained = prepared.problem().bodies.iter().any(Body::has_initial_strain);
        let cut = prepared.bodies().iter().any(|body| body.cut().is_some());
        let once = prepared.rigid_motions().is_empty() && !strained && !cut;
        let passes = first.estimate.admissibility.is_valid() || once;
        if passes && first.residual <= ROUND_OFF_SHARE * first.estimate.unchecked().e_cre {
            return Ok(first.estimate);
        }
        Ok(self.estimate_once(state, &balanced, Accuracy::Refined)?.estimate)
    }

    fn estimate_once(
        &mut self,
        state: &ContactState<'_, S>,
        balanced: &[Vec<f64>],
        accuracy: Accuracy,
    ) -> Result<Measured<S>, EstimatorError> {
        let Self { prepared, relaxation, ref noise, ref mut stars, ref mut solvers } = *self;
        let solvers = match solvers {
            Some(solvers) => solvers,
            None => solvers.insert(BodySolvers::new(prepared)?),
        };
        let problem = prepared.problem();
        let (pair, frozen) = pair_and_frozen(solvers, state, (relaxation, accuracy), stars)?;
        // A single pass over the cells.
        let (mut admissibility, mut cells) = check_and_measure(problem, &pair, noise, accuracy);
        let distances = cells.iter_mut().map(|cells| std::mem::take(&mut cells.distances)).collect();
        let cre = Cre::from_cells(problem, &pair, distances);
        let energy_norm_squared = energies(problem, &pair);
        check_sizes(&pair, &energy_norm_squared)?;
        let residuals = round_off::residuals(solvers, &pair, &cells, accuracy);
        let mean_stress = cells.into_iter().map(|cells| cells.mean).collect();
        let dis = eta_dis(solvers, &pair, &cre, (relaxation, accuracy), frozen, noise);
        admissibility = admissibility.worst(dis.admissibility);
        let model = round_off::model(noise, &pair);
        let energy: f64 = energy_norm_squared.iter().sum();
        let allowance = |residuals: &[f64]| {
            round_off::allowance(problem, &pair, energy, model.iter().copied().zip(residuals))
        };
        let ResidualNorms { stress, frozen, state: of_state } = ResidualNorms::new(
            solvers,
            residuals,
            dis.residuals,
            state_residuals(solvers, state, balanced, accuracy),
        );
        let round_off = allowance(&stress);
        let [imbalance, rounding] = eta_nndd_squared(prepared, state, balanced, of_state);
        // The rounding on the interface itself cannot be seen: the rounding elsewhere is added once more for it.
        let mut eta_nndd = (1.0 + ROUNDING_OF_A_SUM) * (imbalance + rounding).sqrt() + rounding.sqrt();
        let mut eta_dis = from_squared(dis.squared) + allowance(&frozen);
        let mut pairs = problem.contacts.iter().zip(&state.contacts);
        let of = |pair: &ContactPair<S>| problem.places_of(pair).map(|place| state.displacement[place]);
        if pairs.any(|(pair, given)| openings::penetrate(pair, of(pair), given)) {
            // Both are for displacements that penetrate at no node.
            let lift = from_squared(pair.lift_energy);
            (eta_nndd, eta_dis) = (eta_nndd + lift, eta_dis + lift);
        }
        let indicators = Indicators {
            e_cre: cre.e_cre() + round_off,
            eta_dis,
            eta_nndd,
            parts: parts(solvers, (state, balanced), (&pair, &cre), eta_nndd, round_off),
        };
        if ![indicators.e_cre, indicators.eta_dis, indicators.eta_nndd].iter().all(|x| x.is_finite()) {
            return Err(EstimatorError::NotFinite { what: "the estimate".into() });
        }
        let residual = stress.iter().sum::<f64>() + rounding.sqrt();
        let coulomb = problem.contacts.iter().any(|pair| pair.friction.coulomb().is_some());
        let energy_rounding = energy_rounding(problem, &pair);
        let estimate = Estimate {
            pair,
            cre,
            admissibility,
            round_off,
            energy_norm_squared,
            energy_rounding,
            mean_stress,
            indicators,
            coulomb,
        };
        Ok(Measured { estimate, residual })
    }
}

/// Energy norms of residuals.
struct ResidualNorms {
    /// `√(R·K⁻¹ R)` of the stress of the bound in each body, square root of J/m.
    stress: Vec<f64>,
    /// The same of the stress of `η_dis`.
    frozen: Vec<f64>,
    /// `R·K⁻¹ R` of the given displacements of all bodies together, J/m: interior and interface.
    state: [f64; 2],
}

impl ResidualNorms {
    /// Computes them from the residuals of each body, with one substitution for all of a body.
    ///
    /// * `frozen`: `None` in bodies whose stress of the bound is also the stress of `η_dis`.
    fn new<S: Recovery>(
        solvers: &BodySolvers<'_, S>,
        stress: Vec<Vec<f64>>,
        frozen: Vec<Option<Vec<f64>>>,
        state: Vec<Vec<f64>>,
    ) -> Self {
        let all: Vec<_> = stress.into_iter().zip(state).zip(frozen).collect();
        let of_body = |(body, ((stress, state), frozen)): (&BodySolver<'_, S>, ((_, _), Option<_>))| {
            body.residual_energies([stress, state].into_iter().chain(frozen).collect())
        };
        let all: Vec<Vec<ResidualEnergy>> =
            solvers.bodies().par_iter().zip(all).with_max_len(1).map(of_body).collect();
        let stress: Vec<f64> = all.iter().map(|of| of[0].whole().sqrt()).collect();
        // For a frozen λ the part of the interface is a reaction, not a residual.
        let frozen =
            |(of, bound): (&Vec<ResidualEnergy>, &f64)| of.get(2).map_or(*bound, |of| of.inside.sqrt());
        let inside = all.iter().map(|of| of[1].inside).sum();
        let interface = all.iter().map(|of| of[1].interface).sum();
        Self { frozen: all.iter().zip(&stress).map(frozen).collect(), state: [inside, interface], stress }
    }
}

/// An estimate, and the measured part of its round-off.
struct Measured<S: Space> {
    estimate: Estimate<S>,
    residual: f64,
}

/// Computes `64 ε √(Σ A tr(E) (Σ_k |u_k| |∇φ_k|)²)` of the triangles of each body: the energy norm without the cancellation of a rigid
/// motion.
pub(crate) fn energy_rounding<S: Recovery>(
    problem: &ContactProblem<S>,
    pair: &AdmissiblePair<S>,
) -> Vec<f64> {
    let energy = |(body, fields): (&Body<S>, &AdmissibleBody<S>)| {
        let mesh = body.mesh();
        sum_over_cells(fields.stress.len(), |t| {
            let element = Element::<S>::new(mesh.corners(t));
            let corners = mesh.cells()[t].as_ref().iter().zip(element.gradients.as_ref());
            let strain: f64 = corners.map(|(n, g)| length(fields.displacement[*n]) * length(*g)).sum();
            let stiffness = body.material(t).stiffness();
            let trace = (1..S::COMPONENTS).fold(stiffness[(0, 0)], |sum, k| sum + stiffness[(k, k)]);
            element.measure * trace * strain * strain
        })
    };
    problem.bodies.iter().zip(&pair.bodies).map(|of| 64.0 * f64::EPSILON * energy(of).sqrt()).collect()
}

/// Computes `∫ σ : E⁻¹ σ` of each body, J/m: `a(u, u)` without heat.
pub(crate) fn energies<S: Recovery>(problem: &ContactProblem<S>, pair: &AdmissiblePair<S>) -> Vec<f64> {
    let energy = |(body, fields): (&Body<S>, &AdmissibleBody<S>)| {
        product(body, &fields.stress, &fields.stress)
            + sum_over_cells(fields.stress.len(), |t| body.heat_energy(t))
    };
    problem.bodies.iter().zip(&pair.bodies).map(energy).collect()
}

/// Refuses energies that underflow.
fn check_sizes<S: Recovery>(pair: &AdmissiblePair<S>, energies: &[f64]) -> Result<(), EstimatorError> {
    // Squares of smaller numbers underflow, and the checks with them.
    let largest = |fields: &AdmissibleBody<S>| {
        largest_of(fields.stress.len(), |t| {
            let s: S::Components<f64> = fields.stress[t].into();
            s.as_ref().iter().fold(0.0, |most, s| larger(most, s.abs()))
        })
    };
    let stress = pair.bodies.iter().map(largest).fold(0.0, larger);
    let energy: f64 = energies.iter().sum();
    if stress > 0.0 && (stress * stress).min(energy) < SMALLEST_SQUARE {
        return Err(EstimatorError::TooSmall { stress, energy });
    }
    Ok(())
}

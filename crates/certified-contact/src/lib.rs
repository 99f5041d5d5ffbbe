//! Two bodies in contact, solved and certified by one library call.
//!
//! # The bound
//! For displacements `v` that satisfy supports and contact condition, and a stress `τ` in exact equilibrium whose pressure is `p ≥ 0`:
//! ```math
//! ‖u − v‖² + ‖σ − τ‖² ≤ e_CRE² = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫_Γ_C p o
//! ```
//! | symbol | what | where |
//! |---|---|---|
//! | u, σ | the exact solution of the two-body problem | |
//! | v | displacements of both bodies, two numbers per node | [`cre_estimator::AdmissiblePair`] |
//! | τ | nine stress tensors per triangle | [`cre_estimator::EquilibratedStress`] |
//! | p, o | pressure and opening, one number per pair of contact nodes | [`cre_estimator::AdmissiblePair`] |
//!
//! [`theory`] has every formula, numbered, with the function that computes it.
//!
//! # Types, in the order one meets them
//! ```text
//! ContactProblem ─► assemble, factorise (both bodies at once) ─► iterate ─► estimate ─► stop? ─► Certificate
//! ```
//! A [`fem_core::interface::ContactProblem`], [`Settings`], [`solve`], and the
//! [`CertifiedSolution`] with its rows, its estimate, its [`Bounds`] and its results. [`solve_adaptively`] does so on
//! finer and finer meshes, until the certified error is at most the requested one.
//!
//! The percentage is [`CertifiedSolution::relative`]: `e_CRE` over the energy norm of the *computed* displacements.
//! [`CertifiedSolution::relative_guaranteed`] bounds the error over the norm of the *exact* ones and is a little larger.
//!
//! # Example
//! A program needs only this crate: the others whose types it uses are re-exported ([`fem_core`], [`nndd`],
//! [`cre_estimator`]). In its `Cargo.toml`, with this repository in the folder `nndd` beside it:
//! ```toml
//! [dependencies]
//! certified-contact = { path = "../nndd/crates/certified-contact" }
//! ```
//! ```
//! use certified_contact::fem_core::{body::Body, boundary::BoundaryConditions,
//!     interface::{ContactProblem, Gap}, material::{Hypothesis, LinearElastic}, mesh::generate::block};
//! use certified_contact::{Settings, Silent, solve};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
//! let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [16, 8])?, steel.clone(),
//!     &BoundaryConditions::new().displace("top", Some(0.0.into()), Some((-0.01).into())))?;
//! let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [16, 8])?, steel, &BoundaryConditions::new().fix("bottom"))?;
//! let interface = certified_contact::contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
//! let problem = ContactProblem::between([upper, lower], interface);
//! let answer = solve(problem, &Settings::default(), &mut Silent)?;
//! assert!(answer.is_certified());
//! println!("certified error <= {:e} of the energy norm", answer.relative().unwrap_or(f64::NAN));
//! # Ok(()) }
//! ```
//!
//! [`tutorial`] goes from one body to a certified contact problem. `examples/two_percent.rs` refines until 2 % are
//! certified. [`contact_geometry::paired`] pairs sides of bodies by
//! their names, and refines surfaces that do not match.
//!
//! # What this crate does not do
//! It has no file formats and draws no pictures. It does not print, and does not read the clock or the environment: an
//! [`Observer`] reports its progress.

mod adapt;
mod bonded;
mod bounds;
mod checkpoint;
mod contact_force;
mod coulomb;
mod defect_correction;
mod error;
mod history;
mod lines;
mod means;
mod observer;
mod pair_forces;
mod pretension;
mod reactions;
mod recovered_pressure;
mod refine;
mod results;
mod settings;
mod solution;
mod solve;
mod solve_coulomb;
mod space;
mod spin;
mod state;
mod steps;
mod stopping;
mod support;
pub mod theory;
pub mod tutorial;

pub use adapt::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, AdaptiveSteps, StepFactors, StepSolutions,
    resume_adaptively, resume_coulomb_adaptively, solve_adaptively, solve_coulomb_adaptively,
    solve_coulomb_steps_adaptively, solve_steps_adaptively,
};
pub use bounds::Bounds;
pub use checkpoint::{Checkpoint, FinerMesh};
pub use contact_force::NoContactForce;
pub use contact_geometry;
pub use coulomb::CoulombResult;
pub use cre_estimator;
pub use error::SolveError;
pub use fem_core;
pub use history::{IterationRecord, Step};
pub use lines::Stretch;
pub use nndd;
pub use observer::{Observer, Phase, Silent};
pub use reactions::{Balance, Reaction, RigidSideResults, SpringForce};
pub use recovered_pressure::recovered_pressure;
pub use results::{
    BondResults, CutResults, FrictionResults, PairResults, PatchResults, PeakStress, PrincipalStress, Results,
};
pub use settings::{Criterion, Imposed, Settings, prefers_exact, subdomains, suits_iteration};
pub use solution::{CertifiedSolution, RoleReason};
pub use solve::solve;
pub use solve_coulomb::solve_coulomb;
pub use space::ContactSpace;
pub use state::estimate;
pub use steps::LoadSteps;
pub use support::{FreeMotion, PartnerMotions, Support, free_motions, support};

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

//! The Neumann-Neumann domain decomposition of Choi, Gallimard and Sassi for frictionless unilateral contact.
//!
//! # The algorithm
//! Given a normal trace λ on the interface Γ_C, `n` out of Ω₁ into Ω₂:
//! ```text
//! step 1   (8)  Ω₁:  v¹ = λ imposed            →  reaction r¹
//!          (9)  Ω₂:  v² ≥ λ − g unilateral     →  contact force r² ≥ 0
//! step 2  (10)  Ω₁:  K¹ w¹ = −½(r¹ + r²) n
//!         (11)  Ω₂:  K² w² = +½(r¹ + r²) n
//! update        λ ← λ + θ (w¹ − w²)·n
//! ```
//! `η_NNDD = ‖w̄‖`, `w̄ = S₁⁻¹(r¹ + r²)` (`= 2‖w¹‖` with the halves above), bounds the iteration's error
//! `‖u_h − u_p‖` from above, at every iteration; `ε_t = 2 max|t¹+t²| / (max|t¹| + max|t²|)` does not.
//!
//! | symbol | what | size |
//! |---|---|---|
//! | λ, r^α, w^α | interface vectors, one number per pair | `n_c` |
//! | S_α | Steklov-Poincaré operators, [`fem_core::condensation::CondensedBody`] | `n_c × n_c` |
//!
//! In the order one meets them: [`NnddSettings`], a [`stopping::StoppingCriterion`], [`solve`],
//! [`NnddSolution`] with its [`NnddStatus`], [`IterationRow`]s and last [`Iterate`].
//!
//! # Example
//! Two equal blocks pressed together: one iteration is exact.
//! ```
//! use fem_core::{assembly::System, body::Body, boundary::BoundaryConditions, condensation::CondensedBody,
//!     interface::{ContactInterface, ContactProblem, Gap}, material::{Hypothesis, LinearElastic},
//!     mesh::generate::block};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
//! let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [8, 4])?, steel.clone(),
//!     &BoundaryConditions::new().displace("top", Some(0.0.into()), Some((-0.01).into())))?;
//! let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [8, 4])?, steel, &BoundaryConditions::new().fix("bottom"))?;
//! let interface = ContactInterface::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
//! let condense = |body: &Body, side| -> Result<CondensedBody, Box<dyn std::error::Error>> {
//!     Ok(CondensedBody::factorise(System::assemble(body, side)?, body.mesh().points())?)
//! };
//! let bodies = [condense(&upper, &interface.sides()[0])?, condense(&lower, &interface.sides()[1])?];
//! let problem = ContactProblem { bodies: [upper, lower], interface };
//! let solution = nndd::solve(&problem, &bodies, vec![0.0; 9], &nndd::NnddSettings::paper(0.5),
//!     &mut nndd::stopping::EtaNndd::new(1e-10))?;
//! assert_eq!(solution.status, nndd::NnddStatus::StoppedByCriterion);
//! assert!(solution.last.contact_force() > 0.0);
//! # Ok(()) }
//! ```
//!
//! # What this crate does not know
//! No estimator of the discretisation, no file. It does not print, read the clock or the environment.

mod acceleration;
mod error;
mod iterate;
mod literal;
mod monitor;
mod monolithic;
mod settings;
mod solution;
mod solve;
mod spectrum;
mod steps;
pub mod stopping;
mod weights;

pub use error::NnddError;
pub use iterate::{ContactAnswer, Iterate, IterationRow};
pub use settings::{Acceleration, Method, NnddSettings, Path, Theta, Weights};
pub use solution::{NnddSolution, NnddStatus};
pub use solve::{Start, solve, solve_from};
pub use spectrum::Spectrum;

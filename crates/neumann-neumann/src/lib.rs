//! Linear problems of bonded bodies by balanced Neumann-Neumann domain decomposition.
//!
//! # The problem
//! Bodies, or the subdomains of one body, are condensed on the displacements that they share ([`Broken`]). A set of closed contact rows ties more of them.
//! One λ is left for each cluster of tied displacements ([`Skeleton`]):
//! ```math
//! x = x₀ + N λ,   S_A λ = Nᵀ (g̃ − S x₀),   S_A = Nᵀ S N
//! ```
//! # The method
//! Conjugate gradients, preconditioned by the Neumann problems of all bodies with weights by stiffness, and balanced by a coarse space of all rigid
//! motions ([`Balancing`]; Mandel 1993):
//! ```math
//! M = (I − Z C⁺ Zᵀ S_A) Dᵀ S⁺ D,   D = K N (Nᵀ K N)⁻¹,   K = diag S,   Z = Dᵀ R,   C = Zᵀ S_A Z
//! ```
//! With exact solves of all bodies the number `η² = r·M r` that conjugate gradients compute anyway bounds the energy of the error at every iteration,
//! `‖u − u_D‖ ≤ η`, with the continuous displacement `u_D`.
//!
//! [`BodySolvers`] use it for the bodies of a prepared problem: their loads, forces at nodes, and the energies of residuals.
//!
//! # What this crate does not do
//! It does not decide which rows are closed, and has no contact law: see the crate `nndd`.

mod balancing;
mod body;
mod broken;
mod coarse;
mod error;
mod fixed_traces;
mod lists;
mod skeleton;
mod structure;
mod vector;

pub use balancing::{Balancing, Inner};
pub use body::{BodySolver, BodySolvers, ResidualEnergy, correction_from_traces};
pub use broken::{Broken, Load, Sparse, traced};
pub use error::BalancingError;
pub use skeleton::{Skeleton, leaders};
pub use vector::dot;

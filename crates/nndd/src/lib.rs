//! The Neumann-Neumann domain decomposition of Choi, Gallimard and Sassi for unilateral contact.
//!
//! # The algorithm
//! Given a normal trace λ on the interface Γ_C, `n` out of Ω₁ into Ω₂:
//! ```math
//! step 1   v^1 = λ imposed on Ω₁          → reaction r^1             (8)
//!          v^2 ≥ λ − g unilateral on Ω₂   → contact force r^2 ≥ 0    (9)
//! step 2   S₁ w^1 = −½ (r^1 + r^2)                                   (10)
//!          S₂ w^2 = +½ (r^1 + r^2)                                   (11)
//! update   λ ← λ + θ (w^1 − w^2)
//! ```
//! The first indicator bounds the iteration's error from above, at every iteration; the paper's precision does not:
//! ```math
//! ‖u_h − u_p‖ ≤ η_NNDD = ‖S₁⁻¹ (r^1 + r^2)‖,   ε_t = 2 max |t^1 + t^2| / (max |t^1| + max |t^2|)
//! ```
//! | symbol | what | size |
//! |---|---|---|
//! | λ, v^α, w^α | normal displacements on the interface, one number per pair, m | `n_c` |
//! | r^α, t^α | normal nodal forces, N/m; over the tributary length, Pa | `n_c` |
//! | S_α | Steklov-Poincaré operators, [`fem_core::condensation::InterfaceOperator`] | `n_c × n_c` |
//!
//! Formulas have the numbers (1) to (12) of Choi, Gallimard and Sassi, and further ones in the order of a run.
//! The algorithm is one function, `iterate` in `src/iteration.rs`, a line per step. For the admissible θ see [`Spectrum`].
//!
//! # Any number of bodies
//! Two bodies with one pair are the smallest case of the same iteration, floating bodies included, that is, bodies that only contact holds. Each
//! pair of nodes is a row. In each pair one body carries λ and is Ω₁ there, the other one is unilateral; a body may be both, in different
//! pairs. With `v_α` the traces of a body along its outward normals, `Φ_α` its flexibility in its rows, `B K⁺ f` its traces under the loads
//! alone, and `G_α P = e_α` its balance if it floats:
//! ```math
//! step 1   v_α = argmin_v ½ vᵀ S_α v − g̃_αᵀ v                 v_i = c_i if it carries λ, v_i ≤ c_i if it is unilateral
//!          P^α = argmin_P ½ Pᵀ Φ_α P + (c − B K⁺ f)ᵀ P        G_α P = e_α, P_i ≥ 0 in unilateral rows: the dual, if it floats
//!          c = λ if the body carries it                       c = g − λ if it is unilateral
//! step 2   λ ← λ + θ M (P^1 − P^2), half weights: 2 M         P^1 = −r^1 of the bodies that carry λ, P^2 = r^2 ≥ 0 of the others
//! bound    η_NNDD² = ∑_α (P̃ − P^α)ᵀ Φ_α (P̃ − P^α) + 2 P̃ᵀ o
//! ```
//! A rigid obstacle carries the λ that is imposed on it; what is free of it moves so that its load is balanced in step 1.
//! `P̃ ≥ 0` are the forces nearest to `P²` that balance all floating bodies, `o` the openings. `M` is the Neumann-Neumann
//! preconditioner with a coarse space of the rigid motions: `src/correction.rs`; step 1 of a body is in `src/response.rs`, both steps of all
//! bodies in `src/steps.rs`. [`stiffer_roles`] says who should carry λ.
//!
//! # The paper's iteration begins, Newton ends
//! With the set `A` of closed rows held both steps are linear, so conjugate gradients find λ, and Newton's method corrects `A`:
//! ```math
//! step 1   u_D = x₀ + N λ                                      one λ per cluster of traces that closed rows tie
//! step 2   w = M r,   r = Nᵀ (g̃ − S u_D)                       M = (I − Z C⁺ Zᵀ S_A) Dᵀ S⁺ D,   D = K N (Nᵀ K N)⁻¹,   K = diag S
//! bound    η_c² = ∑_α ‖û(P̃) − v‖² + 2 P̃ᵀ o(v)                  v: u_D lifted where it penetrates, P̃ ≥ 0 in balance
//! ```
//! `η_c` bounds the distance from the contact solution whether or not `A` is right. `src/newton_nn.rs` has the algorithm, a line per step.
//!
//! # Friction
//! A pair with friction ([`fem_core::interface::Friction`]) has a second row per pair of nodes, along its tangent, in space two, whose forces are in a disc. λ has both components, and
//! in step 1 `−S ≤ Q_i ≤ S` in the tangential rows of unilateral bodies, with the limit `S` of Tresca's law. The bound gains `2 Σ (S|w| − Q̃ w)`
//! with the slip `w`. The law of Coulomb is a fixed point of such problems: [`solve_coulomb`].
//!
//! # Types, in the order one meets them
//! [`NnddSettings`], a [`stopping::StoppingCriterion`], [`solve`],
//! [`NnddSolution`] with its [`NnddStatus`], [`IterationRow`]s and last [`Iterate`], whose [`Recovery`] says what its fields come from.
//!
//! `examples/blocks.rs` solves the paper's problem with its settings and with the default ones. [`fem_core`] and
//! [`contact_qp`], whose types appear in the signatures here, are re-exported.
//!
//! # Example
//! Two equal blocks pressed together: one iteration is exact.
//! ```
//! use nndd::fem_core::{body::Body, boundary::BoundaryConditions, interface::{ContactProblem, Gap},
//!     material::{Hypothesis, LinearElastic}, mesh::generate::block, prepared::PreparedProblem};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
//! let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [8, 4])?, steel.clone(),
//!     &BoundaryConditions::new().displace("top", Some(0.0.into()), Some((-0.01).into())))?;
//! let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [8, 4])?, steel, &BoundaryConditions::new().fix("bottom"))?;
//! let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
//! let problem = PreparedProblem::new(ContactProblem::between([upper, lower], interface))?;
//! let solution = nndd::solve(&problem.system(), vec![0.0; 9], &nndd::NnddSettings::paper(0.5),
//!     &mut nndd::stopping::EtaNndd::new(1e-10))?;
//! assert_eq!(solution.status, nndd::NnddStatus::StoppedByCriterion);
//! assert!(solution.last.contact_force() > 0.0);
//! # Ok(()) }
//! ```
//!
//! # What this crate does not do
//! It does not estimate the discretisation error and has no file formats. It does not print, and does not read the
//! clock or the environment.

mod acceleration;
mod active_set;
mod balance;
mod correction;
mod coulomb;
mod error;
mod exact;
mod exact_iterate;
mod friction;
mod iterate;
mod iteration;
mod monitor;
mod motions;
mod newton_nn;
mod newton_state;
mod paper;
mod response;
mod roles;
mod row_operators;
mod set_search;
mod settings;
mod solution;
mod solve;
mod spectrum;
mod steps;
pub mod stopping;
mod subdomain;
mod unresisted;

pub use active_set::ActiveSet;
pub use balance::{Support, Unbalanced, free_motions, support, unbalanced};
pub use contact_qp;
pub use coulomb::{
    CoulombSettings, CoulombSolution, CoulombStart, CoulombStatus, coulomb_coupling, solve_coulomb,
};
pub use error::NnddError;
pub use exact::{ExactSolution, flexibility_entries, solve_exactly};
pub use fem_core;
pub use friction::{NodeState, PairFriction};
pub use iterate::{Iterate, IterationRow, OwnFields, QpStats, Recovery, Tangential, UnilateralSolution};
pub use iteration::Start;
pub use roles::stiffer_roles;
pub use settings::{Acceleration, Method, NewtonSettings, NnddSettings, Weights};
pub use solution::{NnddSolution, NnddStatus};
pub use solve::{solve, solve_from};
pub use spectrum::Spectrum;
pub use unresisted::UnresistedMotion;

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

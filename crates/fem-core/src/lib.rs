//! Linear elasticity on P1 triangles and tetrahedra, its sparse factorisation, and the vocabulary of contact.
//!
//! # The problem
//! ```math
//! u = u_D on Γ_D,   ∫_Ω 𝔼 ε(u) : ε(v) = ∫_Ω b·v + ∫_Γ_N F·v   for every v that vanishes on Γ_D
//! ```
//! With the unknowns on the contact line last, one factorisation gives the solution and the operator on that line:
//! ```math
//! K = L Lᵀ,   S = L_CC L_CCᵀ
//! ```
//! | symbol | what | size | type |
//! |---|---|---|---|
//! | Ω | the meshed body | `n` nodes | [`mesh::Mesh`] |
//! | 𝔼 | the elasticity tensor | per cell | [`material::LinearElastic`] |
//! | ∇φ_k | gradients in one cell, its strain and stiffness | per cell | [`element::Element`] |
//! | u_D, F, b | conditions and loads | per side | [`boundary::BoundaryConditions`], evaluated in [`body::Body`] |
//! | K, f | stiffness and load in the unknowns | about `2n` or `3n` | [`assembly::System`] |
//! | L | the factor | | [`cholesky::Cholesky`] |
//! | S, g̃ | interface operator, its load | `n_c × n_c`, `n_c` | [`condensation::CondensedBody`] |
//!
//! # Types, in the order one meets them
//! Generate or read a [`mesh::Mesh`], evaluate conditions on it in a
//! [`body::Body`], join bodies by an [`interface::ContactInterface`] in an [`interface::ContactProblem`] (or use an empty
//! [`interface::InterfaceSide`] for one body alone), assemble a [`assembly::System`], factorise it in a
//! [`condensation::CondensedBody`], and take stresses and energies from [`field`] and [`norm`]. The crate `contact-geometry` pairs
//! the surfaces of bodies, and makes surfaces match that do not.
//!
//! All of them serve the plane and the space: they have a [`space::Space`] as parameter, [`space::Plane`] unless it is
//! named. [`mesh::generate::cuboid`] makes a mesh of tetrahedra.
//!
//! `examples/bracket.rs` solves a bracket on a mesh of its own.
//!
//! # Example
//! A block under its own weight, its side walls on rollers: `σ_yy = −ρg(1 − y)`.
//! ```
//! use fem_core::{assembly::System, body::Body, boundary::BoundaryConditions, condensation::CondensedBody,
//!     interface::InterfaceSide, material::{Hypothesis, LinearElastic}, mesh::generate::block, norm};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = block([0.0, 0.0], [2.0, 1.0], [40, 20])?;
//! let material = LinearElastic::isotropic(1.0e3, 0.0, Hypothesis::PlaneStrain)?;
//! let conditions = BoundaryConditions::new()
//!     .fix("bottom").roller("left", 0.0).roller("right", 0.0).body_force([0.0, -9.81]);
//! let body = Body::new(mesh, material, &conditions)?;
//! let solver = CondensedBody::factorise(System::assemble(&body, &InterfaceSide::default())?, body.mesh().points())?;
//! let u = solver.displacement_from_force(&[]);
//! // Energy norm² of the exact solution: ∫ σ²/E = 2 (ρg)² / (3 E).
//! let exact = 2.0 * 9.81f64.powi(2) / 3.0e3;
//! assert!((norm::energy_norm_squared(&body, &u) / exact - 1.0).abs() < 1e-3);
//! # Ok(()) }
//! ```
//!
//! # What this crate does not do
//! It has no contact law, no iteration and no estimator. It does not print, and does not read the clock or the
//! environment.

pub mod assembly;
pub mod body;
pub mod boundary;
pub mod cholesky;
pub mod condensation;
pub mod contact_system;
pub mod dense;
pub mod directions;
pub mod dof;
pub mod double_double;
pub mod element;
pub mod field;
pub mod geometry;
pub mod interface;
pub mod linear_field;
pub mod material;
pub mod memory;
pub mod mesh;
pub mod mesh_field;
mod motions;
pub mod norm;
pub mod ordering;
pub mod parallel;
mod partition;
pub mod prepared;
pub mod quadrature;
pub mod residual;
mod rigid_line;
pub mod smooth;
pub mod space;
pub mod sparse;
pub mod subdomains;
pub mod tensor;

pub use parallel::{each_body, try_each_body};

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

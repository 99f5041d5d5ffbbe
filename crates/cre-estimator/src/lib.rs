//! Guaranteed bounds of the error of a contact solution by the constitutive relation error.
//!
//! # The bound
//! For displacements `v` that satisfy the contact condition, and stresses `τ` in exact equilibrium with one
//! common pressure `p ≥ 0`, with the opening `o = g − (v¹−v²)·n ≥ 0`:
//! ```math
//! e_CRE²  = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫_Γ_C p o                                      (15)
//!         = ‖u − v‖² + ‖σ − τ‖² + 2 ∫ p o_ex + 2 ∫ p_ex o ≥ ‖u − v‖² + ‖σ − τ‖²    (16)
//! ```
//! The bound contains no unknown constant and needs no assumption on the mesh. It splits without a cross term into the
//! part of the mesh and the part of the iteration:
//! ```math
//! e_CRE² = ∑ ‖τ − σ̂‖² + [∑ ‖σ̂ − σ(v)‖² + 2 ∫ p o]     (17)
//! ```
//! Formulas have the numbers (1) to (12) of Choi, Gallimard and Sassi, and further ones in the order of a run.
//!
//! | symbol | what | size |
//! |---|---|---|
//! | v, σ(v) | given displacements, m; their stress, Pa | per node; per triangle |
//! | p, o | pressure, Pa; opening, m | per pair of contact nodes |
//! | σ̂ | FE stress in equilibrium with `p`, Pa | per triangle |
//! | τ | stress in exact equilibrium, Pa | nine tensors per triangle |
//!
//! # Modules and types, in the order one meets them
//!
//! | step | module |
//! |---|---|
//! | pressure `p_i = r²_i/ℓ_i` and the contact term | [`pressure`] |
//! | the term of friction | [`friction`] |
//! | Neumann problems `σ̂`, the admissible pair | [`admissible`] |
//! | edge tractions in equilibrium with `σ̂` | [`eet`] |
//! | local stresses with these tractions | [`johnson_mercier`] |
//! | the stress as a whole | [`equilibrated`] |
//! | edge tractions closer to the optimal ones | [`star_relaxation`] |
//! | residuals of admissibility, as numbers | [`check()`] |
//! | `e_CRE` and the split | [`cre`] |
//! | `η_dis` | [`indicators`] |
//! | a continuous stress for pictures and peaks | [`RecoveredStress`] |
//! | where to refine | [`marking`] |
//!
//! Stresses in equilibrium exist in space, too ([`Recovery`]): on tetrahedra by graph Laplacians around the vertices, four parts in a cell, and
//! bars and wrenches instead of Airy functions. `examples/solid.rs` certifies a solid body, `examples/solids.rs` of `certified-contact` the contact of
//! two.
//!
//! [`estimate_with()`] does all of it for a [`fem_core::interface::ContactState`] and returns an [`Estimate`];
//! [`Estimator`] serves several states of one problem, [`estimate()`] omits the relaxation. `examples/certify.rs` certifies a displacement field read from a file.
//! [`fem_core`], whose types appear in the signatures here, is re-exported.
//!
//! # Example
//! Two equal blocks at rest against each other: the certificate of a zero field is zero.
//! ```
//! use cre_estimator::fem_core::{body::Body, boundary::BoundaryConditions, geometry::Vector,
//!     interface::{ContactProblem, ContactState, Gap}, material::{Hypothesis, LinearElastic},
//!     mesh::generate::block, prepared::PreparedProblem};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
//! let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [4, 2])?, steel.clone(), &BoundaryConditions::new().fix("top"))?;
//! let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [4, 2])?, steel, &BoundaryConditions::new().fix("bottom"))?;
//! let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
//! let problem = PreparedProblem::new(ContactProblem::between([upper, lower], interface))?;
//! let rest = vec![Vector::zeros(); 15];
//! let state = ContactState::between([&rest, &rest], &[0.0; 5], &[0.0; 5]);
//! let estimate = cre_estimator::estimate(&problem, &state)?;
//! assert_eq!(estimate.certificate().map(|bound| bound.e_cre), Some(0.0));
//! # Ok(()) }
//! ```
//!
//! # What this crate does not do
//! It does not depend on how the state was computed. It does not print, and does not read the clock or the environment.

pub mod admissible;
mod atomic_slots;
mod balance;
mod cells;
mod certify;
pub mod check;
mod columns;
pub mod cre;
pub mod eet;
pub mod equilibrated;
mod error;
mod estimate;
mod fixed;
pub mod friction;
mod imposed_slip;
pub mod indicators;
mod inverse;
pub mod johnson_mercier;
mod lanes;
pub mod lift;
pub mod marking;
mod measures;
mod node_lines;
mod openings;
pub mod parts;
mod parts_of_bonds;
mod plane;
pub mod pressure;
#[cfg(test)]
mod random;
mod recovered;
mod recovery;
mod relaxation;
mod relaxed;
mod round_off;
mod side;
mod size;
mod solid;
mod springs;
mod star;
pub mod star_relaxation;

pub use admissible::{AdmissibleBody, AdmissibleContact, AdmissiblePair};
pub use certify::{FieldCertificate, MissedSupport, certify};
pub use check::{Admissibility, check, check_stress};
pub use columns::relax;
pub use cre::{Cre, constitutive_relation_error};
pub use equilibrated::{EquilibratedStress, FacetMoments};
pub use error::EstimatorError;
pub use estimate::{Estimate, Estimator, Indicators, ROUND_OFF_SHARE, estimate, estimate_with};
pub use fem_core;
pub use lift::Lift;
pub use parts::Parts;
pub use recovered::RecoveredStress;
pub use recovery::{Recovery, StarMemory};
pub use relaxation::{Relaxation, RelaxationReport};
pub use relaxed::admissible_pair;
pub use springs::released;
pub use star_relaxation::StarRelaxation;

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

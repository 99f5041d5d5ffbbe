//! Finds where bodies touch: pairs of facing nodes, their normals and gaps, from two meshes.
//!
//! # The problem
//! Nodes of two contact surfaces are to face each other along a frozen normal field, so that pressures and gaps are functions on both:
//! ```math
//! n(s) = Σ_i φ_i(s) n_i,   y_i = x_i + (g_i/|n_i|²) n_i,   ℓ_i = ∫ φ_i ds
//! ```
//! | symbol | name | size | type |
//! |---|---|---|---|
//! | Γ | two groups of facets | | their names, or [`Contact`] |
//! | x_i, y_i | facing nodes | one pair each | [`NodePair`](fem_core::interface::NodePair) |
//! | n_i | contact normal, out of the first body | per pair | chosen by [`ContactNormal`] |
//! | g_i | initial gap, m | per pair | from [`Gap`](fem_core::interface::Gap) |
//! | ℓ_i | tributary length or area, m or m² | per pair | `weight` of the pair |
//!
//! # Functions, in the order one meets them
//! [`pair()`] takes two surfaces whose nodes match, [`against`] a surface and an obstacle, [`pair_solids`] and [`solid_against`] those of solids. The
//! result is a [`ContactInterface`], which goes into a
//! [`ContactProblem`](fem_core::interface::ContactProblem). Surfaces that do not match are made to match by [`common_refinement`] and paired by
//! [`pair_refined`]. [`paired`] does all of this for the sides of any number of bodies, [`paired_solids`] for those of solids. [`refined`] makes the same problem on finer
//! meshes, without pairing again.
//!
//! `examples/rings.rs` pairs a pin with a hole.
//!
//! # Example
//! Two blocks with 4 and 3 cells along their common side.
//! ```
//! use contact_geometry::{ContactNormal, common_refinement::common_refinement, pair, pair_refined};
//! use fem_core::{body::Body, boundary::BoundaryConditions, interface::{ContactProblem, Gap},
//!     material::{Hypothesis, LinearElastic}, mesh::generate::block};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let steel = || LinearElastic::isotropic(210e9, 0.3, Hypothesis::PlaneStrain);
//! let upper = Body::new(block([0.0, 1.0], [1.2, 1.0], [4, 2])?, steel()?, &BoundaryConditions::new())?;
//! let lower = Body::new(block([0.0, 0.0], [1.2, 1.0], [3, 2])?, steel()?, &BoundaryConditions::new().fix("bottom"))?;
//! let surfaces = ["bottom", "top"];
//! assert!(pair(&upper, &lower, surfaces, &Gap::Touching).is_err());
//! let common = common_refinement([upper, lower], surfaces, ContactNormal::Averaged)?;
//! let interface = pair_refined(&common, surfaces, &Gap::Touching, ContactNormal::Averaged)?;
//! assert_eq!(interface.pairs().len(), 7);
//! assert!((interface.measure() - 1.2).abs() < 1e-12);
//! let problem = ContactProblem::between(common.bodies, interface);
//! # assert_eq!(problem.node_pairs(), 7);
//! # Ok(()) }
//! ```
//!
//! # What this crate does not do
//! It assembles and solves nothing, and has no contact law. It does not print, and does not read the clock or the environment.

pub mod common_refinement;
mod contacts;
mod depth;
mod facing;
mod facing_sides;
mod geometric_gap;
mod matching;
mod normals;
mod obstacle;
mod outline;
mod overlay;
mod pairing;
mod profile;
mod refinable;
mod refinement;
mod solid_contacts;
mod solid_pairs;
mod solid_refinement;

use fem_core::body::Body;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactFacet, ContactInterface};
use fem_core::space::{Plane, Space};

pub use contacts::{Contact, Paired, PairingError, Refined, Sides, paired};
pub use facing_sides::{FacingSides, facing_sides};
pub use obstacle::against;
pub use overlay::{OverlayChanges, OverlayError};
pub use pairing::{pair, pair_along, pair_refined};
pub use refinable::{FinerProblem, Refinable};
pub use refinement::{RefineError, RefinedPair, RefinedProblem, close, refined};
pub use solid_contacts::paired_solids;
pub use solid_pairs::{pair_solids, solid_against};
pub use solid_refinement::{RefinedSolids, count_halved, edge_order, halved};

/// How the contact normal is chosen. In each case it is a datum, frozen on the undeformed meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactNormal<S: Space = Plane> {
    /// At each node the mean of the first body's edge normals, weighted by length; linear between the nodes. On declared curves, and straight stretches
    /// beside them, the normals are their own. Where two of these meet at more than 1 degree, the contact line ends, and another one begins: the node
    /// is in two pairs, each with the normal of one side. If the other body's side is smooth there, its normal is used.
    #[default]
    Averaged,
    /// One direction for the whole line, out of the first body; of any length except zero.
    Fixed(S::Vector),
}

/// Finds the corner of the first body's contact surface that turns most: its point, and the angle in degrees. Corners that end a stretch do not count.
///
/// * `first`: the first body of the interface.
pub fn sharpest_corner(interface: &ContactInterface, first: &Body) -> Option<(Vector, f64)> {
    let corner = normals::sharpest_turn(first, interface.pairs(), interface.facets());
    corner.map(|(point, cosine)| (point, cosine.acos().to_degrees()))
}

/// Cosine of the smallest angle between the outward normals of two facing facets: 120 degrees.
const FACING: f64 = -0.5;

/// Returns the size of a facet, m: the length of an edge, the root of an area.
fn facet_size<S: Space>(measure: f64) -> f64 {
    measure.powf(1.0 / (S::DIM - 1) as f64)
}

/// Computes the arc lengths at pairs from the lengths of their edges, m: nodes on curves make edges longer than their parts were.
fn measure_arc(pairs: usize, edges: &[ContactFacet]) -> Vec<f64> {
    let mut after = vec![0.0; pairs];
    edges.iter().for_each(|edge| after[edge.pairs[0] as usize] = edge.measure);
    let mut arc_length = 0.0;
    for after in &mut after {
        arc_length += std::mem::replace(after, arc_length);
    }
    after
}

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

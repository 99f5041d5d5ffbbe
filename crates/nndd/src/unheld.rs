//! What nothing holds.

use fem_core::body::RigidMotion;

/// A rigid motion of the assembly that nothing resists, while the loads do work on it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnheldMotion {
    /// The bodies that move, each with its motion; the largest displacement is 1.
    pub bodies: Vec<(usize, RigidMotion)>,
    /// The load along it: its work over its largest displacement, N/m.
    pub load: f64,
}

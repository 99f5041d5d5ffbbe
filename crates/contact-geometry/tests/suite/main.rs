//! Pairs of nodes on the meshes of whole problems.
// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

mod clamped_ends;
mod curves;
mod friction;
mod interpolation;
mod solid_pairs;
mod solid_refinement;

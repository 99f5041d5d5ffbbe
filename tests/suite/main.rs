//! Tests that run across the crates: reference problems, the example cases, the binary as a process.

mod paper;
mod certificate;

//! Tests of the public interface.
// The helpers stand outside the test functions, where the workspace lints would forbid these.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod brute_force;
mod input;
mod obstacle;
mod paths;
mod scaling;
mod singular;
mod support;

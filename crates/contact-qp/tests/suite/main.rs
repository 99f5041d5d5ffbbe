//! Tests of the public interface.
// The helpers are outside the test functions, and the workspace lints forbid these there.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod boxes;
mod brute_force;
mod discs;
mod input;
mod obstacle;
mod paths;
mod rows;
mod scaling;
mod singular;
mod support;
mod ways;

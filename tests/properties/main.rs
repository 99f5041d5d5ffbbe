//! Properties of every solution and every certificate, on random problems. Each prints how many cases it tried.
// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod bound;
mod equilibrium;
mod invariance;
mod model;
mod refinement;

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngSeed, TestCaseResult, TestRunner};

/// Tries a property on this many random values, the same ones in every run, and prints their number.
fn check<S: Strategy>(name: &str, cases: u32, values: &S, property: impl Fn(S::Value) -> TestCaseResult) {
    let config =
        Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(2026), ..Config::default() };
    if let Err(error) = TestRunner::new(config).run(values, property) {
        panic!("{name}: {error}");
    }
    println!("property {name}: {cases} cases");
}

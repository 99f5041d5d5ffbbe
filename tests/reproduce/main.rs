//! Studies whose tables stand in bench-results; run by `cargo xtask reproduce`.
#![allow(clippy::print_stdout)] // It writes tables.

mod iterations;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    iterations::table()
}

//! Peaks of this machine, and the phases of a solve with what they compute and move, by count.
//!
//! `cargo xtask bench --limits` runs it and writes the page, which states every formula. It is a plain program, since criterion
//! records times only. Each line is a JSON object.
//!
//! ```text
//! cargo bench -p tests --bench limits -- peaks THREADS
//! cargo bench -p tests --bench limits -- phases THREADS ROUNDS KEY=VALUE…
//! ```
//! The keys are settings of the paper's case, such as `body.0.generator.cells=[80,36]`.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)] // The data are fixed and valid; the lines are for a reader.

mod counts;
mod peaks;
mod phases;
mod record;

use rayon::ThreadPoolBuilder;

fn main() {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let number = |k: usize| -> usize { arguments.get(k).and_then(|a| a.parse().ok()).unwrap() };
    let pool = |threads: usize| ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    match arguments.first().map(String::as_str) {
        Some("peaks") => peaks::measure(&pool(number(1))),
        Some("phases") => pool(number(1)).install(|| phases::measure(number(2), &arguments[3..])),
        _ => panic!("found {arguments:?}, expected `peaks THREADS` or `phases THREADS ROUNDS KEY=VALUE…`"),
    }
}

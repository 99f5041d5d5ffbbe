//! Steps of a task, one after the other, and the table of how they ended.

use crate::workspace::Outcome;
use std::time::Instant;

/// The steps that were run: name, whether it passed, seconds.
#[derive(Default)]
pub(crate) struct Steps(Vec<(&'static str, bool, f64)>);

impl Steps {
    /// Runs a step; one that ends with an error has failed.
    pub(crate) fn run(&mut self, name: &'static str, step: impl FnOnce() -> Outcome<bool>) {
        println!("== {name}");
        let start = Instant::now();
        let passed = step().unwrap_or_else(|error| {
            eprintln!("{name}: {error}");
            false
        });
        self.0.push((name, passed, start.elapsed().as_secs_f64()));
    }

    /// Prints the table and returns whether all passed.
    pub(crate) fn finish(self, task: &str) -> bool {
        println!("\n{:<10}{:<8}{:>9}", "step", "result", "seconds");
        for (name, passed, seconds) in &self.0 {
            println!("{name:<10}{:<8}{seconds:>9.1}", if *passed { "ok" } else { "FAILED" });
        }
        let failed = self.0.iter().filter(|row| !row.1).count();
        println!("{task}: {} passed, {failed} failed", self.0.len() - failed);
        failed == 0
    }
}

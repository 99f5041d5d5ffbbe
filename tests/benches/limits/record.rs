//! Times of phases, printed with their counts.

use serde_json::json;
use std::time::Instant;

/// A phase whose first round takes longer than this, in seconds, is not repeated.
const LONG: f64 = 10.0;

/// The work of a phase: operations and bytes, by count. Zero operations: they are not counted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Count {
    /// Additions and multiplications.
    pub(crate) flops: f64,
    /// Bytes that cross memory if the cache keeps nothing from one pass to the next, and everything within a pass.
    pub(crate) bytes: f64,
}

impl Count {
    /// Adds the counts of several bodies.
    pub(crate) fn sum(counts: impl IntoIterator<Item = Self>) -> Self {
        let add = |a: Self, b: Self| Self { flops: a.flops + b.flops, bytes: a.bytes + b.bytes };
        counts.into_iter().fold(Self::default(), add)
    }
}

/// Measures phases of one problem.
pub(crate) struct Recorder {
    pub(crate) rounds: usize,
    pub(crate) unknowns: usize,
}

impl Recorder {
    /// Runs a phase several times and returns its last result and its seconds.
    ///
    /// * `prepare`: makes what a round takes, outside its time.
    pub(crate) fn time<I, T>(
        &self,
        mut prepare: impl FnMut() -> I,
        mut run: impl FnMut(I) -> T,
    ) -> (T, Vec<f64>) {
        let mut seconds = vec![];
        loop {
            let input = prepare();
            let start = Instant::now();
            let made = run(input);
            seconds.push(start.elapsed().as_secs_f64());
            if seconds.len() == self.rounds || seconds[0] > LONG {
                return (made, seconds);
            }
        }
    }

    /// Prints a phase.
    pub(crate) fn print(&self, phase: &str, seconds: &[f64], Count { flops, bytes }: Count) {
        let (threads, unknowns) = (rayon::current_num_threads(), self.unknowns);
        println!(
            "{}",
            json!({ "kind": "phase", "threads": threads, "unknowns": unknowns, "phase": phase, "seconds": seconds,
                "flops": flops, "bytes": bytes })
        );
    }
}

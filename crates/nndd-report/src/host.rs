//! The interface between a run and the program around it.

use crate::failure::Failure;
use case_io::case_file::Sweep;
use case_io::report::{Status, StepSummary};
use certified_contact::{IterationRecord, Phase, Step};

/// The program around a run: its clock, its wish to end the run, its memory, and what it does when something happens.
pub trait Host {
    /// Returns the seconds since some moment before the run.
    fn elapsed(&self) -> f64;

    /// Returns the exit status of a request to end the run with the result at hand, such as 130 after Ctrl-C.
    fn interrupted(&self) -> Option<u8> {
        None
    }

    /// Returns the memory that the run may take, if it is known.
    fn memory_limit(&self) -> Option<MemoryLimit> {
        None
    }

    /// Is told that a step begins that has no result to keep, and may end the run in it if the time limit passes, see [`Deadline`].
    ///
    /// * `limit`: of the run, in seconds.
    ///
    /// [`Deadline`]: crate::Deadline
    fn begins(&self, step: &'static str, limit: Option<f64>) {
        let _ = (step, limit);
    }

    /// Is told what happens.
    ///
    /// # Errors
    /// That it cannot be shown: a sweep ends with this failure. A solve continues, for the sake of its result.
    fn event(&mut self, event: Event<'_>) -> Result<(), Failure> {
        let _ = event;
        Ok(())
    }
}

/// Memory that a run may take, with what the process has already, and the words for it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MemoryLimit {
    /// Bytes; 0 if nothing is left.
    pub bytes: f64,
    /// The limit in words: `this machine has 3.2 GiB free`.
    pub words: String,
    /// The fix, if it is not a smaller problem.
    pub fix: Option<&'static str>,
}

impl MemoryLimit {
    /// Makes one from bytes, words and the fix.
    pub fn new(bytes: f64, words: String, fix: Option<&'static str>) -> Self {
        Self { bytes, words, fix }
    }
}

/// Something that happens in a run.
#[non_exhaustive]
pub enum Event<'a> {
    /// A phase begins.
    Phase(Phase),
    /// An iteration on the present mesh has ended.
    Iteration(&'a IterationRecord),
    /// A mesh of an adaptive run had been solved before the run was resumed, at this many seconds after the start.
    EarlierStep(&'a Step, f64),
    /// A mesh of an adaptive run has been solved.
    Step(&'a Step),
    /// A load step has been solved.
    LoadStep {
        /// Its entry in the report.
        step: &'a StepSummary,
        /// The number of load steps.
        of: usize,
    },
    /// A panel of a sweep begins.
    Panel {
        /// Its name.
        name: &'a str,
        /// The key that is varied, and its values.
        sweep: &'a Sweep,
    },
    /// A value of a sweep has been run.
    Value {
        /// The value, as it was written.
        value: &'a str,
        /// The last iteration of its run, without the bounds unless its certificate is valid.
        row: Option<&'a IterationRecord>,
        /// How its run ended.
        status: &'a Status,
        /// The choices that were made, see [`crate::verdict::choices`].
        choices: &'a str,
    },
}

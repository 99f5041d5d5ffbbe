//! The time limit of work without a result that could be kept: a thread ends the program, whatever loop it is in.

use crate::console;
use case_io::Case;
use nndd_report::Failure;
use std::process;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The limit may be exceeded by this: steps that look at the clock themselves end the work before.
const GRACE: f64 = 1.0;

/// The first step.
const MESHES: &str = "making the bodies and their contact lines";

/// Ends the program at a time limit, until it is dropped.
pub(crate) struct Deadline {
    step: Arc<Mutex<&'static str>>,
    /// The thread ends when the other end of its channel goes.
    watched: Option<Sender<()>>,
}

impl Deadline {
    /// Begins to watch the time limit of a case whose bodies are made next; without a limit nothing is watched.
    ///
    /// * `started`: the time from which it counts; `for_programs`: whether a failure is also an object on stdout.
    pub(crate) fn watch(case: &Case, started: Instant, for_programs: bool) -> Self {
        let limit = case.limits.time.as_ref().map(|limit| limit.value);
        let step = Arc::new(Mutex::new(MESHES));
        // A limit beyond the clock is not watched.
        let end = limit.and_then(|limit| {
            Some((limit, started.checked_add(Duration::try_from_secs_f64(limit + GRACE).ok()?)?))
        });
        let watched = end.and_then(|(limit, end)| {
            let (sender, receiver) = mpsc::channel::<()>();
            let step = Arc::clone(&step);
            let watch = move || {
                let left = end.saturating_duration_since(Instant::now());
                if receiver.recv_timeout(left) == Err(RecvTimeoutError::Timeout) {
                    let step = *step.lock().unwrap_or_else(PoisonError::into_inner);
                    let seconds = started.elapsed().as_secs_f64();
                    let failure = exceeded(limit, seconds, step);
                    console::end(&failure, for_programs);
                    process::exit(i32::from(failure.code));
                }
            };
            thread::Builder::new().spawn(watch).ok().map(|_| sender)
        });
        Self { step, watched }
    }

    /// Names the next step.
    pub(crate) fn next(&self, step: &'static str) {
        *self.step.lock().unwrap_or_else(PoisonError::into_inner) = step;
    }

    /// Ends the watch: there is a result.
    pub(crate) fn end(&mut self) {
        self.watched = None;
    }
}

/// Says that the time was over before there was a result.
fn exceeded(limit: f64, seconds: f64, step: &str) -> Failure {
    Failure::limit(format!(
        "limits.time = {limit} s reached before there was a result: {seconds:.1} s had passed, the last of them in {step}\n  \
         expected: a problem that is checked and solved in time\n  fix: raise limits.time, or take fewer cells, bodies or pairs"
    ))
}

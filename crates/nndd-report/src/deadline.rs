//! The time limit of work that has no result to keep yet, in whatever loop it is.

use crate::failure::Failure;
use crate::host::Event;
use certified_contact::Phase;
use std::sync::{Mutex, PoisonError};

/// The limit may be exceeded by this, in seconds: steps that look at the clock themselves end the work before.
const GRACE: f64 = 1.0;

/// Knows the step of a run and its time limit until there is a result to keep. A host asks it from another thread.
#[derive(Debug, Default)]
pub struct Deadline(Mutex<State>);

#[derive(Clone, Copy, Debug, Default)]
enum State {
    #[default]
    Unlimited,
    /// The step, and the limit in seconds.
    Pending(&'static str, f64),
    /// There is something to keep.
    Over,
}

impl Deadline {
    /// Notes that a step begins, and the limit of the run in seconds; nothing once there is a result.
    pub fn begin(&self, step: &'static str, limit: Option<f64>) {
        self.change(|state| match (state, limit) {
            (State::Over, _) => State::Over,
            (_, Some(limit)) => State::Pending(step, limit),
            (_, None) => State::Unlimited,
        });
    }

    /// Notes what an event of the run says: the name of the phase, or a result.
    pub fn follow(&self, event: &Event<'_>) {
        match event {
            Event::Phase(phase) => self.change(|state| match state {
                State::Pending(_, limit) => State::Pending(step_name(*phase), limit),
                other => other,
            }),
            Event::Panel { .. } => {}
            _ => self.end(),
        }
    }

    /// Notes that there is a result.
    pub fn end(&self) {
        self.change(|_| State::Over);
    }

    /// Returns why a run without a result must end at this time.
    ///
    /// * `seconds`: since its start.
    pub fn exceeded(&self, seconds: f64) -> Option<Failure> {
        let state = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let State::Pending(step, limit) = state else { return None };
        (seconds > limit + GRACE).then(|| {
            Failure::limit(format!(
                "limits.time = {limit} s reached before there was a result: {seconds:.1} s had passed, the last of them in {step}\n  \
                 expected: a problem that is checked and solved in time\n  fix: raise limits.time, or take fewer cells, bodies or pairs"
            ))
        })
    }

    fn change(&self, change: impl FnOnce(State) -> State) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *state = change(*state);
    }
}

/// Names the step between two checks of the clock.
pub(crate) fn step_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Assembly => "assembly",
        Phase::Factorisation => "factorisation",
        Phase::Iterations => "an iteration",
        Phase::Estimate => "the estimate of the error",
        Phase::Refinement => "refinement",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_a_result_ends_in_the_step_it_is_in() {
        let deadline = Deadline::default();
        deadline.begin("meshes", None);
        assert!(deadline.exceeded(1e9).is_none());
        deadline.begin("meshes", Some(2.0));
        assert!(deadline.exceeded(2.5).is_none());
        deadline.follow(&Event::Phase(Phase::Assembly));
        let said = deadline.exceeded(3.5).and_then(|failure| failure.message).unwrap();
        assert!(said.contains("limits.time = 2 s reached") && said.contains("in assembly"), "{said}");
        deadline.end();
        // A result stays one: the next value of a sweep does not put it at risk.
        deadline.begin("meshes", Some(2.0));
        assert!(deadline.exceeded(1e9).is_none());
    }
}

//! Follows a solve: times its phases, and ends it on request or at the time limit.

use crate::deadline::step_name;
use crate::failure::Failure;
use crate::host::{Event, Host};
use crate::outcome::Ended;
use crate::stopwatch::{Activity, Stopwatch};
use case_io::Case;
use case_io::case::Dimension;
use case_io::output::{OutputError, Presence};
use certified_contact::{IterationRecord, Observer, Phase, SolveError};
use fem_core::space::Space;

/// A run may exceed its time limit by this, in seconds, and still start on a certificate.
const GRACE: f64 = 0.1;

/// Times the phases, and ends the run on request or at the time limit.
pub(crate) struct RunObserver<'a> {
    watch: &'a mut Stopwatch,
    pub(crate) host: &'a mut dyn Host,
    output: Presence,
    limit: Option<f64>,
    /// The present phase, and the time at which the clock was last checked, in seconds.
    step: (Phase, f64),
    /// The longest step between two checks of the clock: its name and its seconds.
    pub(crate) longest: Option<(&'static str, f64)>,
    /// Why the run was ended.
    pub(crate) ended: Option<Ended>,
}

impl<'a> RunObserver<'a> {
    /// Begins to follow.
    ///
    /// * `output`: the directory that must stay until the end.
    pub(crate) fn new<S: Dimension>(
        case: &Case<S>,
        watch: &'a mut Stopwatch,
        host: &'a mut dyn Host,
        output: Presence,
    ) -> Self {
        let limit = case.limits.time.as_ref().map(|limit| limit.value);
        let step = (Phase::Assembly, watch.elapsed(host.elapsed()));
        Self { watch, host, output, limit, step, longest: None, ended: None }
    }

    /// Returns the seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.watch.elapsed(self.host.elapsed())
    }

    /// Attributes the time from now on.
    pub(crate) fn switch(&mut self, activity: Activity) {
        self.watch.switch(activity, self.host.elapsed());
    }

    /// Tells the program around what happens.
    pub(crate) fn tell(&mut self, event: Event<'_>) {
        // An event that cannot be shown must not cost the run its result.
        let _ = self.host.event(event);
    }

    /// Looks at the clock: returns the seconds since the start, and measures the step that ends here.
    fn look(&mut self, next: Option<Phase>) -> f64 {
        let now = self.elapsed();
        let (phase, since) = self.step;
        if self.longest.is_none_or(|(_, longest)| now - since > longest) {
            self.longest = Some((step_name(phase), now - since));
        }
        self.step = (next.unwrap_or(phase), now);
        now
    }

    /// Finds a reason to end.
    ///
    /// * `grace`: seconds that the time limit may be exceeded by.
    fn end(&mut self, signal: Option<Ended>, grace: f64) -> bool {
        let now = self.look(None);
        let step = self.longest.map_or("none", |(step, _)| step);
        let time = self.limit.filter(|limit| now > limit + grace).map(|limit| Ended::TimeLimit(limit, step));
        let gone = (!self.output.lasts()).then_some(Ended::OutputGone);
        let ended = gone.or(signal).or(time);
        self.ended = ended.or(self.ended);
        ended.is_some()
    }

    /// Says why a solve failed.
    pub(crate) fn failure<S: Dimension>(&self, case: &Case<S>, error: &SolveError<S>) -> Failure {
        match (error, self.ended) {
            (SolveError::Stopped, Some(Ended::OutputGone)) => {
                OutputError::Vanished { path: self.output.path().to_owned() }.into()
            }
            (SolveError::Stopped, Some(Ended::TimeLimit(limit, _))) => {
                let (step, seconds) = self.longest.unwrap_or(("none", 0.0));
                Failure::limit(format!(
                    "limits.time = {limit} s reached before the first iteration, so there is no result; the longest \
                     step between two checks of the clock was {step}, {seconds:.1} s\n  \
                     expected: a problem that is solved in time\n  fix: raise limits.time, or take fewer cells"
                ))
            }
            _ => Failure::solve(case, error),
        }
    }
}

impl<S: Space> Observer<S> for RunObserver<'_> {
    fn phase(&mut self, phase: Phase) {
        self.look(Some(phase));
        self.switch(Activity::Solve(phase));
        self.tell(Event::Phase(phase));
    }

    fn iteration(&mut self, row: &IterationRecord) {
        self.tell(Event::Iteration(row));
    }

    /// Tells if the run should end at its next certificate.
    fn should_stop(&mut self) -> bool {
        let signal = self.host.interrupted().map(Ended::Signal);
        self.end(signal, 0.0)
    }

    /// Tells if the run must end now, with or without a certificate.
    fn must_stop(&mut self) -> bool {
        self.end(None, GRACE)
    }
}

//! Wall times of the phases of a run: disjoint, and all of the time.

use case_io::report::Timings;
use certified_contact::Phase;

/// An activity to which time is attributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    /// Reading the case, making meshes, pairing.
    Mesh,
    /// A phase of the solve.
    Solve(Phase),
    /// Writing files.
    Write,
}

/// Attributes every moment from its start to exactly one activity. It has no clock: all times come from
/// [`Host::elapsed`](crate::Host::elapsed).
#[derive(Clone, Debug)]
pub struct Stopwatch {
    started: f64,
    since: f64,
    activity: Activity,
    timings: Timings,
}

impl Stopwatch {
    /// Starts, with the reading of the case.
    pub fn start(now: f64) -> Self {
        Self { started: now, since: now, activity: Activity::Mesh, timings: Timings::default() }
    }

    /// Ends the present activity and begins another.
    pub(crate) fn switch(&mut self, activity: Activity, now: f64) {
        let elapsed = (now - self.since).max(0.0);
        let slot = match self.activity {
            Activity::Mesh | Activity::Solve(Phase::Refinement) => &mut self.timings.mesh,
            Activity::Solve(Phase::Assembly) => &mut self.timings.assembly,
            Activity::Solve(Phase::Factorisation) => &mut self.timings.factorisation,
            Activity::Solve(Phase::Iterations) => &mut self.timings.iterations,
            Activity::Solve(Phase::Estimate) => &mut self.timings.estimate,
            Activity::Write => &mut self.timings.write,
        };
        *slot += elapsed;
        self.since = now;
        self.activity = activity;
    }

    /// Returns the seconds since the start.
    pub(crate) fn elapsed(&self, now: f64) -> f64 {
        now - self.started
    }

    /// Returns the times so far.
    pub fn read(&mut self, now: f64) -> Timings {
        self.switch(self.activity, now);
        let mut timings = self.timings.clone();
        timings.total = timings.mesh
            + timings.assembly
            + timings.factorisation
            + timings.iterations
            + timings.estimate
            + timings.write;
        timings
    }
}

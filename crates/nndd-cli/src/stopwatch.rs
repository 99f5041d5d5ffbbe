//! Wall times of the phases of a run: disjoint, and all of the time.

use case_io::report::Timings;
use certified_contact::Phase;
use std::time::Instant;

/// What the time goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    /// Reading the case, making meshes, pairing.
    Mesh,
    /// A phase of the solve.
    Solve(Phase),
    /// Writing files.
    Write,
}

/// Attributes every moment from its start to exactly one activity.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    started: Instant,
    since: Instant,
    activity: Activity,
    timings: Timings,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        let now = Instant::now();
        Self { started: now, since: now, activity: Activity::Mesh, timings: Timings::default() }
    }

    /// Ends the present activity and begins another.
    pub(crate) fn switch(&mut self, activity: Activity) {
        let now = Instant::now();
        let elapsed = now.saturating_duration_since(self.since).as_secs_f64();
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

    /// Returns when it was started.
    pub(crate) fn started(&self) -> Instant {
        self.started
    }

    /// Returns the seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Returns the times so far.
    pub(crate) fn read(&mut self) -> Timings {
        self.switch(self.activity);
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

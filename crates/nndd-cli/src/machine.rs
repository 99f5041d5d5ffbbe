//! The host of a run in this process: its clock, its time limit, its signals, and the memory it may take.

use crate::console;
use crate::signals::Signals;
use nndd_report::memory_limit;
use nndd_report::{Deadline, Event, Failure, Host, MemoryLimit};
use std::io;
use std::process;
use std::sync::{Arc, Once};
use std::thread;
use std::time::{Duration, Instant};

/// How often the time limit is looked at.
const POLL: Duration = Duration::from_millis(50);

/// The process and the machine it runs on.
pub(crate) struct Machine {
    /// When the program began.
    pub(crate) started: Instant,
    signals: Option<Signals>,
    deadline: Arc<Deadline>,
    /// Whether the thread that ends the program at the time limit has begun.
    watched: Once,
    /// Whether a failure is also an object on stdout.
    for_programs: bool,
}

impl Machine {
    /// Begins, without listening for signals: they end the program.
    ///
    /// * `for_programs`: whether a failure is also an object on stdout.
    pub(crate) fn start(for_programs: bool) -> Self {
        let (started, deadline) = (Instant::now(), Arc::default());
        Self { started, signals: None, deadline, watched: Once::new(), for_programs }
    }

    /// Begins as [`Machine::start`] does, and listens for signals.
    pub(crate) fn listen(for_programs: bool) -> io::Result<Self> {
        let machine = Self::start(for_programs);
        Ok(Self { signals: Some(Signals::listen()?), ..machine })
    }

    /// Ends the watch of the time limit: there is a result.
    pub(crate) fn has_result(&self) {
        self.deadline.end();
    }

    /// Ends the program at the time limit, whatever loop it is in.
    fn watch(&self) {
        let (started, deadline, for_programs) = (self.started, Arc::clone(&self.deadline), self.for_programs);
        let watch = move || loop {
            thread::sleep(POLL);
            if let Some(failure) = deadline.exceeded(started.elapsed().as_secs_f64()) {
                console::end(&failure, for_programs);
                process::exit(i32::from(failure.code));
            }
        };
        // Without another thread the steps that look at the clock themselves still end in time.
        let _ = thread::Builder::new().spawn(watch);
    }
}

impl Host for Machine {
    fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    fn interrupted(&self) -> Option<u8> {
        self.signals.as_ref().and_then(Signals::status)
    }

    fn memory_limit(&self) -> Option<MemoryLimit> {
        memory_limit::smallest(rayon::current_num_threads())
    }

    fn begins(&self, step: &'static str, limit: Option<f64>) {
        self.deadline.begin(step, limit);
        if limit.is_some() {
            self.watched.call_once(|| self.watch());
        }
    }
}

/// The machine, with what shows the events of a run.
pub(crate) struct Showing<F> {
    pub(crate) machine: Machine,
    pub(crate) show: F,
}

impl<F: FnMut(Event<'_>) -> Result<(), Failure>> Host for Showing<F> {
    fn elapsed(&self) -> f64 {
        self.machine.elapsed()
    }

    fn interrupted(&self) -> Option<u8> {
        self.machine.interrupted()
    }

    fn memory_limit(&self) -> Option<MemoryLimit> {
        self.machine.memory_limit()
    }

    fn begins(&self, step: &'static str, limit: Option<f64>) {
        self.machine.begins(step, limit);
    }

    fn event(&mut self, event: Event<'_>) -> Result<(), Failure> {
        self.machine.deadline.follow(&event);
        (self.show)(event)
    }
}

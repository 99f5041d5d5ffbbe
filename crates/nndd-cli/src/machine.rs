//! The host of a run in this process: its clock, its signals, and the memory it may take.

use crate::signals::Signals;
use nndd_report::memory_limit;
use nndd_report::{Event, Failure, Host, MemoryLimit};
use std::io;
use std::time::Instant;

/// The process and the machine it runs on.
pub(crate) struct Machine {
    /// When the program began.
    pub(crate) started: Instant,
    signals: Option<Signals>,
}

impl Machine {
    /// Begins, without listening for signals: they end the program.
    pub(crate) fn start() -> Self {
        Self { started: Instant::now(), signals: None }
    }

    /// Begins to listen for signals.
    pub(crate) fn listen() -> io::Result<Self> {
        let started = Instant::now();
        Ok(Self { started, signals: Some(Signals::listen()?) })
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

    fn event(&mut self, event: Event<'_>) -> Result<(), Failure> {
        (self.show)(event)
    }
}

//! Interruption: the first Ctrl-C or SIGTERM lets the iteration finish, the second ends the program.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Which signal has come, if one has.
#[derive(Clone, Debug)]
pub(crate) struct Signals {
    status: Arc<AtomicUsize>,
}

impl Signals {
    /// Begins to listen.
    pub(crate) fn listen() -> io::Result<Self> {
        let status = Arc::new(AtomicUsize::new(0));
        let pending = Arc::new(AtomicBool::new(false));
        for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
            let code = 128 + signal;
            // In this order: a second signal finds `pending` set and ends the program.
            signal_hook::flag::register_conditional_shutdown(signal, code, Arc::clone(&pending))?;
            signal_hook::flag::register(signal, Arc::clone(&pending))?;
            signal_hook::flag::register_usize(signal, Arc::clone(&status), code as usize)?;
        }
        Ok(Self { status })
    }

    /// Returns the exit status of the signal that came: 130 or 143.
    pub(crate) fn status(&self) -> Option<u8> {
        match self.status.load(Ordering::Relaxed) {
            0 => None,
            code => Some(code as u8),
        }
    }
}

//! Interruption: the first Ctrl-C, SIGTERM or SIGHUP lets the iteration finish, the second ends the program.

use signal_hook::consts::{SIGINT, SIGTERM};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The signal that has come, if one has.
#[derive(Clone, Debug)]
pub(crate) struct Signals {
    status: Arc<AtomicUsize>,
}

impl Signals {
    /// Begins to listen.
    pub(crate) fn listen() -> io::Result<Self> {
        let status = Arc::new(AtomicUsize::new(0));
        let pending = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM].into_iter().chain(hangup()) {
            let code = 128 + signal;
            // In this order: a second signal finds `pending` set and ends the program.
            signal_hook::flag::register_conditional_shutdown(signal, code, Arc::clone(&pending))?;
            signal_hook::flag::register(signal, Arc::clone(&pending))?;
            signal_hook::flag::register_usize(signal, Arc::clone(&status), code as usize)?;
        }
        Ok(Self { status })
    }

    /// Returns the exit status of the signal that came: 129, 130 or 143.
    pub(crate) fn status(&self) -> Option<u8> {
        match self.status.load(Ordering::Relaxed) {
            0 => None,
            code => Some(code as u8),
        }
    }
}

/// Lets a write beyond the limit of the file size fail like one on a full disk; the signal would end the program in the
/// middle of a file.
pub(crate) fn outlive_file_size_limit() -> io::Result<()> {
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    Ok(())
}

/// SIGHUP, unless it is ignored, as it is under `nohup`. If the system does not tell, it is left as it is.
#[cfg(unix)]
fn hangup() -> Option<i32> {
    use signal_hook::consts::SIGHUP;
    let table = std::fs::read_to_string("/proc/self/status").ok()?;
    (!is_ignored(SIGHUP, &table)?).then_some(SIGHUP)
}

#[cfg(not(unix))]
fn hangup() -> Option<i32> {
    None
}

/// Reads from the kernel's table whether a signal is ignored: bit `signal − 1` of the mask `SigIgn`.
#[cfg(unix)]
fn is_ignored(signal: i32, table: &str) -> Option<bool> {
    let mask = table.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    Some(u64::from_str_radix(mask.trim(), 16).ok()? >> (signal - 1) & 1 == 1)
}

#[cfg(all(test, unix))]
mod tests {
    use super::is_ignored;

    #[test]
    fn the_mask_of_ignored_signals_is_read() {
        let table = "Name:\tnndd\nSigBlk:\t0000000000000001\nSigIgn:\t0000000000001002\n";
        assert_eq!([1, 2, 13].map(|signal| is_ignored(signal, table)), [Some(false), Some(true), Some(true)]);
        assert_eq!(is_ignored(1, "Name:\tnndd\n"), None);
    }
}

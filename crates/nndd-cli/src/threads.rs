//! The threads that compute.

use nndd_report::{Failure, failure, memory_limit};

/// Most threads: to start tens of thousands takes minutes.
pub(crate) const MOST: usize = 1024;

/// From this variable rayon takes the number of threads if the command line does not say it.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// The stack of each thread, bytes: as large as the main thread's.
const STACK: usize = 8 << 20;

/// Starts the threads and does the work of a command on one of them, so that the main thread reserves no memory to compute.
///
/// * `threads`: 0 for one per core, or as many as the environment says.
pub(crate) fn run(threads: usize, work: impl FnOnce() -> Result<u8, Failure> + Send) -> Result<u8, Failure> {
    if threads == 0
        && let Some(count) = std::env::var(VARIABLE).ok().filter(|count| is_too_large(count))
    {
        let shown: String = count.chars().take(20).collect();
        return Err(Failure::command_line(format!(
            "{VARIABLE} is {shown}\n  expected: a whole number from 0 to {MOST}, as for --threads\n  fix: lower or unset it"
        )));
    }
    let count = number(threads);
    if let Some(reason) = memory_limit::no_room_for_threads(count, STACK) {
        return Err(Failure::limit(format!(
            "cannot start {count} threads: {reason}\n  fix: ask for fewer with --threads, or raise that limit"
        )));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK);
    // Threads that the system does not give: a matter of the machine, as files are.
    let failed = |e| format!("cannot start {count} threads: {e}; ask for fewer with --threads");
    pool.build_global().map_err(|e| Failure::plain(failure::FILES, failed(e)))?;
    rayon::scope(|_| work())
}

/// Returns how many threads rayon will start.
fn number(threads: usize) -> usize {
    let asked = std::env::var(VARIABLE).ok().and_then(|count| count.parse().ok());
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    Some(threads).filter(|&count| count > 0).or(asked.filter(|&count| count > 0)).unwrap_or_else(cores)
}

/// Says whether a text is a number above [`MOST`]. Rayon ignores what is not a number.
fn is_too_large(text: &str) -> bool {
    let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    digits && !text.parse().is_ok_and(|count: usize| count <= MOST)
}

#[cfg(test)]
mod tests {
    use super::is_too_large;

    #[test]
    fn only_numbers_can_be_too_large() {
        let found = ["1024", "1025", "99999999999999999999999", "0", "", "two", "-1"].map(is_too_large);
        assert_eq!(found, [false, true, true, false, false, false, false]);
    }
}

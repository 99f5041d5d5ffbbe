//! How much memory a solve needs, before it starts, and how much it took.

use fem_core::interface::ContactProblem;

/// Estimates the memory of a solve from the number of nodes, bytes.
///
/// Per body with n unknowns: the factor of a nested dissection grows as n log₂ n; the mesh with its topology, the fields
/// of the estimator and its stars as n; then three dense interface matrices, and the program itself. The two numbers are
/// fitted to what was measured from 2·10⁵ to 3.3·10⁶ unknowns: within 8 %, rather too much than too little.
pub(crate) fn estimate(problem: &ContactProblem) -> f64 {
    const PROGRAM: f64 = 20e6;
    let pairs = problem.interface.pairs().len() as f64;
    problem
        .bodies
        .iter()
        .map(|body| {
            let n = 2.0 * body.mesh().points().len() as f64;
            56.0 * n * n.log2() + 450.0 * n + 3.0 * 8.0 * pairs * pairs
        })
        .sum::<f64>()
        + PROGRAM
}

/// Returns the largest amount of memory that this process has had, bytes, where the system tells it.
pub(crate) fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// Writes a size in MiB or GiB.
pub(crate) fn mebibytes(bytes: f64) -> String {
    let mib = bytes / f64::from(1 << 20);
    if mib < 1024.0 { format!("{mib:.1} MiB") } else { format!("{:.2} GiB", mib / 1024.0) }
}

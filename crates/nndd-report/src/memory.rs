//! How much memory a solve needs, before it starts, and whether there is enough.

use crate::failure::Failure;
use crate::host::{Host, MemoryLimit};
use crate::space::ReportSpace;
use case_io::Case;
use certified_contact::prefers_exact;
use fem_core::body::Body;
use fem_core::interface::ContactProblem;
use nndd::flexibility_entries;

/// Memory that must be available, over the estimate, which is right within 8 % in the plane, and within 10 % for large solids.
const MARGIN: f64 = 1.1;

/// Memory of a solved mesh with its fields and stresses, kept while the next one is solved, bytes per node.
const KEPT_PER_NODE: f64 = 950.0;

/// Bytes of the program itself.
const PROGRAM: f64 = 20e6;
/// Bytes of three dense matrices per square of the pairs.
pub(crate) const INTERFACE: f64 = 3.0 * 8.0;

/// Bytes of a body whatever its size, measured on walls of 500 and 2,000 blocks.
pub(crate) const BODY: f64 = 6e4;

/// A contact line is named if it makes the need this many times as large.
const LONG_LINE: f64 = 2.0;

/// Estimates the memory of a solve from the number of nodes, bytes.
///
/// See [`ReportSpace::memory`] of each body; and the program itself.
pub fn estimate<S: ReportSpace>(problem: &ContactProblem<S>) -> f64 {
    of_sizes::<S>(&sizes(problem))
}

/// Estimates the memory of a solve on a finer mesh, while the solution on the mesh before is kept, bytes.
///
/// * `before`: nodes of that mesh.
pub(crate) fn estimate_finer<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    before: usize,
) -> f64 {
    let steps = case.increments().len().max(1);
    // Of each mesh the solutions of all load steps are kept.
    let kept = steps * before + (steps - 1) * problem.nodes();
    estimate(problem) + KEPT_PER_NODE * kept as f64
}

/// The sizes of a body that determine its memory.
struct Size {
    nodes: u64,
    /// Contact nodes.
    pairs: usize,
}

fn of_sizes<S: ReportSpace>(bodies: &[Size]) -> f64 {
    bodies.iter().map(|body| S::memory(body.nodes, body.pairs)).sum::<f64>() + PROGRAM
}

fn sizes<S: ReportSpace>(problem: &ContactProblem<S>) -> Vec<Size> {
    let of_body = |(body, sides): (&Body<S>, Vec<(usize, usize)>)| {
        let pairs = sides.into_iter().map(|(k, _)| problem.contacts[k].interface.pairs().len()).sum();
        Size { nodes: body.mesh().points().len() as u64, pairs }
    };
    let mut sizes: Vec<Size> = problem.bodies.iter().zip(problem.sides()).map(of_body).collect();
    if prefers_exact(problem) {
        // The flexibility of all pairs together, with its factor.
        sizes.push(Size { nodes: 0, pairs: flexibility_entries(&problem.contact_rows()).isqrt() });
    }
    sizes
}

/// Refuses, before any mesh is made, a case whose nodes alone need more memory than there may be.
pub(crate) fn check_counts<S: ReportSpace>(case: &Case<S>, host: &dyn Host) -> Result<(), Failure> {
    let sizes: Vec<Size> = case.node_counts().into_iter().map(|nodes| Size { nodes, pairs: 0 }).collect();
    check(case, host, &sizes, None)
}

/// Refuses a problem that needs more memory than there may be.
pub(crate) fn check_problem<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    host: &dyn Host,
) -> Result<(), Failure> {
    check(case, host, &sizes(problem), Some(problem.node_pairs()))
}

/// * `pairs`: of all contact lines, if they are known.
fn check<S: ReportSpace>(
    case: &Case<S>,
    host: &dyn Host,
    sizes: &[Size],
    pairs: Option<usize>,
) -> Result<(), Failure> {
    let needed = of_sizes::<S>(sizes);
    let without: Vec<Size> = sizes.iter().map(|size| Size { pairs: 0, ..*size }).collect();
    let line = pairs.filter(|_| needed > LONG_LINE * of_sizes::<S>(&without));
    let Some((needed, MemoryLimit { bytes: limit, words, fix: other })) = shortage(case, needed, host) else {
        return Ok(());
    };
    let nodes = sizes.iter().fold(0u64, |sum, size| sum.saturating_add(size.nodes));
    let least = if pairs.is_none() { "at least " } else { "" };
    // The need grows a little faster than the number of nodes, and as the square of the pairs.
    let (what, fits, fix) = match line {
        None => (
            format!("{nodes} nodes"),
            format!("{} nodes", two_digits(nodes as f64 * (limit / needed).powf(1.0 / S::MEMORY_POWER))),
            S::FEWER_NODES,
        ),
        Some(pairs) => (
            format!("{pairs} pairs of contact nodes, and {nodes} nodes"),
            format!("{} pairs", two_digits(pairs as f64 * (limit / needed).sqrt())),
            S::FEWER_PAIRS,
        ),
    };
    Err(Failure::limit(format!(
        "{least}about {} are needed for {what}; {words}, enough for about {fits}.\n  expected: a problem that fits \
         into memory\n  fix: {}",
        mebibytes(needed),
        other.map_or(fix.to_owned(), |other| format!("{other}; or {fix}"))
    )))
}

/// Rounds down to two digits.
fn two_digits(count: f64) -> u64 {
    let unit = 10f64.powf((count.max(10.0).log10() - 1.0).floor());
    ((count / unit).floor() * unit) as u64
}

/// Says why there is not enough memory; `None` if there is.
pub(crate) fn no_room<S: ReportSpace>(case: &Case<S>, needed: f64, host: &dyn Host) -> Option<String> {
    shortage(case, needed, host)
        .map(|(needed, room)| format!("about {} and {}", mebibytes(needed), room.words))
}

/// Returns the room that is too small, the case's limit first, and what there must be room for.
fn shortage<S: ReportSpace>(case: &Case<S>, needed: f64, host: &dyn Host) -> Option<(f64, MemoryLimit)> {
    let allowed = case.limits.memory.as_ref().map(|limit| MemoryLimit {
        bytes: limit.value as f64,
        words: format!("limits.memory is {}", limit.written),
        fix: None,
    });
    let system = || host.memory_limit().map(|room| (MARGIN * needed, room));
    let is_short = |(needed, room): &(f64, MemoryLimit)| *needed > room.bytes;
    allowed.map(|room| (needed, room)).filter(is_short).or_else(|| system().filter(is_short))
}

/// Writes a size in MiB, GiB or TiB.
pub fn mebibytes(bytes: f64) -> String {
    let mib = bytes / f64::from(1 << 20);
    let (gib, tib) = (mib / 1024.0, mib / f64::from(1 << 20));
    match mib {
        _ if mib < 1024.0 => format!("{mib:.1} MiB"),
        _ if gib < 1024.0 => format!("{gib:.2} GiB"),
        _ if tib < 1e4 => format!("{tib:.2} TiB"),
        _ => format!("{tib:.1e} TiB"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Nowhere;

    impl Host for Nowhere {
        fn elapsed(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn a_long_contact_line_is_named_where_it_takes_the_memory() {
        let limit = [("limits.memory".to_owned(), "1MiB".to_owned())];
        let case = Case::parse(case_io::template::PAPER, "paper.toml", &limit).unwrap();
        let said = |nodes: [u64; 2], pairs: Option<usize>| {
            let sizes = nodes.map(|nodes| Size { nodes, pairs: pairs.unwrap_or(0) });
            check(&case, &Nowhere, &sizes, pairs).unwrap_err().message.unwrap()
        };
        let of_nodes = said([1000, 1000], Some(40));
        assert!(of_nodes.contains("for 2000 nodes; limits.memory is 1MiB, enough for about"), "{of_nodes}");
        let of_line = said([20_000, 20_000], Some(20_000));
        assert!(
            of_line.contains("for 20000 pairs of contact nodes") && of_line.contains("fewer edges"),
            "{of_line}"
        );
        // Before there is a mesh the contact line is not known.
        assert!(said([1000, 1000], None).starts_with("at least about"));
    }

    #[test]
    fn sizes_stay_short() {
        let sizes = [4.5e6, 8.0 * f64::from(1 << 30), 7.5e12, 1e40].map(mebibytes);
        assert_eq!(sizes, ["4.3 MiB", "8.00 GiB", "6.82 TiB", "9.1e27 TiB"]);
    }
}

//! The targets of this program against its peers, and if it meets them.

use super::super::criterion::Estimate;
use super::super::numbers::{spread_of, time};
use super::roster::{Answer, Task};
use super::{OnMesh, Own, Series};
use std::fmt::Write as _;

/// By cells along the interface: the largest solve, and solve with certificate, over PARDISO's analysis, factorisation and one solve.
const TIMES: [(usize, [f64; 2]); 4] =
    [(80, [0.8, 1.5]), (320, [0.5, 0.9]), (640, [0.4, 0.75]), (1280, [0.4, 0.7])];
/// Smallest ratio of the active set's time to the time of an equally converged solve, on [`ACTIVE_SET_MESH`].
const ACTIVE_SET: f64 = 30.0;
const ACTIVE_SET_MESH: usize = 320;
/// Coarsest mesh of the targets of memory, cells along the interface: before, programs are larger than their data.
const COARSEST: usize = 320;
/// Largest time of one iteration with 1281 pairs, nanoseconds.
const ITERATION: f64 = 10e6;
/// Largest peak memory on the mesh of 3.3 million unknowns, bytes.
const MEMORY: f64 = 6.0 * 1024.0 * 1024.0 * 1024.0;
const MEMORY_MESH: usize = 1280;

/// Says if a value keeps to a limit, or by how much it misses it.
///
/// * `at_most`: true for an upper limit.
pub(crate) fn verdict(value: f64, limit: f64, at_most: bool) -> String {
    let kept = if at_most { value <= limit } else { value >= limit };
    if kept { "met".to_owned() } else { format!("missed by {:.0} %", 100.0 * (value / limit - 1.0).abs()) }
}

/// Computes ratios of paired runs: the ratio of the medians, the smallest and the largest ratio of a pair.
pub(in crate::bench) fn ratio(pairs: &[[f64; 2]]) -> Option<[f64; 3]> {
    let [above, below] =
        [0, 1].map(|k| spread_of(pairs.iter().map(|p| p[k]).collect()).map(|[median, ..]| median));
    let [_, least, most] = spread_of(pairs.iter().map(|p| p[0] / p[1]).collect())?;
    Some([above? / below?, least, most])
}

/// This program's runs and a peer's, round by round; the one run of a slow peer is paired with every own run.
pub(super) fn paired(
    mesh: &OnMesh,
    series: &Series,
    own: impl Fn(&Own) -> Option<f64>,
    peer: impl Fn(&Answer) -> Option<f64>,
) -> Vec<[f64; 2]> {
    let answers = series.answers.iter().cycle();
    mesh.own.iter().zip(answers).filter_map(|(o, a)| Some([own(o)?, peer(a)?])).collect()
}

/// The peer of a kind that does best on a mesh.
fn best(
    mesh: &OnMesh,
    kind: impl Fn(Task) -> bool,
    value: impl Fn(&Answer) -> Option<f64>,
) -> Option<&Series> {
    let middle = |s: &Series| spread_of(s.answers.iter().filter_map(&value).collect()).map(|[m, ..]| m);
    let able = mesh.series.iter().filter(|s| kind(s.peer.task)).filter_map(|s| Some((middle(s)?, s)));
    able.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, s)| s)
}

/// One line of the table of targets.
///
/// * `limit`: with whether it is an upper one.
fn line(
    what: &str,
    mesh: Option<&OnMesh>,
    peer: Option<&Series>,
    found: Option<[f64; 3]>,
    limit: (f64, bool),
) -> String {
    let cells = mesh.map_or("-".to_owned(), |m| format!("{}x{}", m.cells[0], m.cells[1]));
    let peer = peer.map_or("-", |s| s.peer.name);
    let rest = found.map_or("- | - | not measured".to_owned(), |[middle, least, most]| {
        format!("{middle:.2} | {least:.2} to {most:.2} | {}", verdict(middle, limit.0, limit.1))
    });
    format!("| {what} | {cells} | {peer} | {rest} |\n")
}

/// The table of targets: one line each, `not measured` if a peer or a mesh is missing.
pub(super) fn table(meshes: &[OnMesh], iteration: Option<&Estimate>) -> String {
    let mut text = String::from(
        "| target | cells per body | against | found | of single rounds | verdict |\n|---|---|---|---|---|---|\n",
    );
    let pardiso = |task: Task| matches!(task, Task::Linear(name) if name.starts_with("pardiso"));
    let cholmod = |task: Task| task == Task::ActiveSet("cholmod");
    let seconds = |a: &Answer| Some(a.seconds);
    let limits = |m: &OnMesh| TIMES.iter().find(|(cells, _)| *cells == m.cells[0]).map(|(_, limits)| *limits);
    for (mesh, [solve, certified]) in meshes.iter().filter_map(|m| Some((m, limits(m)?))) {
        for peer in mesh.series.iter().filter(|s| pardiso(s.peer.task)) {
            let over = |own: fn(&Own) -> Option<f64>| ratio(&paired(mesh, peer, own, seconds));
            let what = format!("solve <= {solve} x PARDISO");
            text += &line(&what, Some(mesh), Some(peer), over(|o| Some(o.solve)), (solve, true));
            let what = format!("solve and certificate <= {certified} x PARDISO");
            text += &line(&what, Some(mesh), Some(peer), over(|o| Some(o.certified)), (certified, true));
            if mesh.cells[0] < COARSEST {
                continue;
            }
            let whole = ratio(&paired(mesh, peer, |o| o.memory, |a| a.process_memory));
            text += &line(
                "peak memory <= 1 x that of PARDISO's process",
                Some(mesh),
                Some(peer),
                whole,
                (1.0, true),
            );
            let alone = ratio(&paired(mesh, peer, |o| o.memory, |a| a.memory));
            let what = "peak memory <= 1 x PARDISO's less Python's";
            text += &line(what, Some(mesh), Some(peer), alone, (1.0, true));
        }
    }
    let mesh = meshes.iter().find(|m| m.cells[0] == ACTIVE_SET_MESH);
    let fastest = mesh.and_then(|m| best(m, cholmod, seconds));
    let times = mesh.zip(fastest).map(|(m, s)| paired(m, s, |o| Some(o.converged), seconds));
    let found = times.and_then(|t| ratio(&t.iter().map(|[own, peer]| [*peer, *own]).collect::<Vec<_>>()));
    let what = format!("active set >= {ACTIVE_SET} x solve to 1e-8");
    text += &line(&what, mesh, fastest, found, (ACTIVE_SET, false));

    let _ = match iteration {
        Some(e) => writeln!(
            text,
            "| one iteration, 1281 pairs, <= {} | - | - | {} | {} to {} | {} |",
            time(ITERATION),
            time(e.median),
            time(e.lower),
            time(e.upper),
            verdict(e.median, ITERATION, true)
        ),
        None => writeln!(text, "| one iteration, 1281 pairs | - | - | - | - | not measured |"),
    };
    let mesh = meshes.iter().find(|m| m.cells[0] == MEMORY_MESH);
    let found = mesh.and_then(|m| spread_of(m.own.iter().filter_map(|o| o.memory).collect()));
    let gib = |bytes: f64| bytes / (1024.0 * 1024.0 * 1024.0);
    let what = format!("3.3 million unknowns solved and certified in {} GiB", gib(MEMORY));
    text += &line(&what, mesh, None, found.map(|s| s.map(gib)), (gib(MEMORY), true));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_say_by_how_much() {
        assert_eq!(verdict(0.5, 0.5, true), "met");
        assert_eq!(verdict(0.6, 0.5, true), "missed by 20 %");
        assert_eq!(verdict(24.0, 30.0, false), "missed by 20 %");
        assert_eq!(verdict(31.0, 30.0, false), "met");
        assert!(verdict(f64::NAN, 1.0, true).starts_with("missed"));
    }

    #[test]
    fn ratios_are_of_medians_and_of_rounds() {
        assert_eq!(ratio(&[[1.0, 2.0], [3.0, 2.0], [2.0, 4.0]]), Some([1.0, 0.5, 1.5]));
        assert_eq!(ratio(&[]), None);
    }

    #[test]
    fn what_is_missing_is_not_measured() {
        let text = table(&[], None);
        assert_eq!(text.matches("not measured").count(), 3, "{text}");
    }
}

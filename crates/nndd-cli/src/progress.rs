//! One line on a terminal that says what a long run is at, and about how long it will still take.

use certified_contact::{IterationRecord, Phase, Step};
use std::io::{self, IsTerminal, Write};
use std::time::Instant;

/// Runs shorter than this, in seconds, show nothing.
const SHORT: f64 = 1.0;
/// A new mesh of an adaptive run is at most about this many times as large as the one before; all meshes up to the last
/// then have about half as many nodes again as that one.
const ALL_MESHES: f64 = 1.5;

/// The values from which the time left is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    /// `eta_nndd / eta_dis` at which the iteration ends, if that is the criterion.
    pub(crate) ratio: Option<f64>,
    /// The certified relative error, or the residual, at which an adaptive run ends.
    pub(crate) relative: Option<f64>,
}

/// The line, and what it is made from.
pub(crate) struct Progress {
    goal: Goal,
    on: bool,
    shown: bool,
    started: Instant,
    mesh: Instant,
    /// When the iterations of this mesh began.
    iterations: Option<Instant>,
    rows: usize,
    last: Option<(f64, Option<f64>)>,
    /// Fraction by which an iteration lowers eta_nndd.
    rate: Option<f64>,
    /// When the run should be done.
    end: Option<(Instant, f64)>,
}

impl Progress {
    /// Begins; nothing is shown unless `wanted` and stderr is a terminal.
    pub(crate) fn start(goal: Goal, wanted: bool) -> Self {
        let now = Instant::now();
        Self {
            goal,
            on: wanted && io::stderr().is_terminal(),
            shown: false,
            started: now,
            mesh: now,
            iterations: None,
            rows: 0,
            last: None,
            rate: None,
            end: None,
        }
    }

    /// A phase begins.
    pub(crate) fn phase(&mut self, phase: Phase) {
        if phase == Phase::Iterations && self.iterations.is_none() {
            self.iterations = Some(Instant::now());
        }
        let what = match phase {
            Phase::Assembly => "assembling",
            Phase::Factorisation => "factorising",
            Phase::Iterations => "iterating",
            Phase::Estimate => "estimating",
            Phase::Refinement => "refining",
        };
        self.show(what);
    }

    /// An iteration has ended.
    pub(crate) fn iteration(&mut self, row: &IterationRecord) {
        let eta = row.iteration.eta_nndd;
        if let Some((before, dis)) = self.last {
            self.rate = Some(eta / before).filter(|rate| *rate > 0.0 && *rate < 1.0);
            self.last = Some((eta, row.eta_dis.or(dis)));
        } else {
            self.last = Some((eta, row.eta_dis));
        }
        self.rows += 1;
        if self.goal.relative.is_none() {
            let now = Instant::now();
            let each = self.iterations.map_or(0.0, |t| (now - t).as_secs_f64()) / self.rows as f64;
            let more = iterations_left(self.goal.ratio, self.rate, self.last);
            // A certificate takes about as long as the factorisation before it.
            let before = self.iterations.map_or(0.0, |t| (t - self.mesh).as_secs_f64());
            self.end = more.map(|more| (now, more * each + before));
        }
    }

    /// A mesh of an adaptive run has been solved.
    pub(crate) fn step(&mut self, step: &Step) {
        let now = Instant::now();
        let took = (now - self.mesh).as_secs_f64();
        self.end = self
            .goal
            .relative
            .zip(step.relative.or(step.relative_residual))
            .map(|(goal, found)| (now, took * work_left(goal, found)));
        self.mesh = now;
        (self.iterations, self.rows, self.last, self.rate) = (None, 0, None, None);
    }

    /// Removes the line, so that something else can be printed.
    pub(crate) fn clear(&mut self) {
        if self.shown {
            let _ = io::stderr().write_all(b"\r\x1b[K");
            self.shown = false;
        }
    }

    fn show(&mut self, what: &str) {
        let elapsed = self.started.elapsed().as_secs_f64();
        if !self.on || elapsed < SHORT {
            return;
        }
        let left = self.end.map(|(at, seconds)| seconds - at.elapsed().as_secs_f64());
        let width =
            terminal_size::terminal_size_of(io::stderr()).map_or(80, |(width, _)| usize::from(width.0));
        let text = format!("\r\x1b[K{}", line(what, elapsed, left, width));
        let _ = io::stderr().write_all(text.as_bytes());
        let _ = io::stderr().flush();
        self.shown = true;
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

/// How many iterations it takes until `eta_nndd` is small enough beside `eta_dis`.
fn iterations_left(ratio: Option<f64>, rate: Option<f64>, last: Option<(f64, Option<f64>)>) -> Option<f64> {
    let (eta, dis) = last?;
    let over = eta / (ratio? * dis?);
    if over <= 1.0 {
        return Some(0.0);
    }
    Some((over.ln() / -rate?.ln()).ceil()).filter(|n| n.is_finite())
}

/// Estimates the work left over the work of the last mesh, from the error wanted and the present one: linear triangles
/// need `(found / goal)²` times the nodes.
fn work_left(goal: f64, found: f64) -> f64 {
    if found <= goal { 0.0 } else { ALL_MESHES * (found / goal).powi(2) }
}

/// The line itself, not longer than the terminal is wide.
fn line(what: &str, elapsed: f64, left: Option<f64>, width: usize) -> String {
    let mut text = format!("{what}, {} so far", duration(elapsed));
    match left {
        Some(left) if left >= 1.0 => text += &format!(", about {} left", duration(left)),
        Some(_) => text += ", nearly done",
        None => {}
    }
    text.chars().take(width.saturating_sub(1)).collect()
}

/// Seconds as people say them.
fn duration(seconds: f64) -> String {
    let whole = seconds.clamp(0.0, 1e9).round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s:02} s"),
        (h, m, _) => format!("{h} h {m:02} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_fits_the_terminal() {
        assert_eq!(line("certifying", 65.2, Some(3.4), 80), "certifying, 1 min 05 s so far, about 3 s left");
        assert_eq!(line("iterating", 2.0, Some(-4.0), 80), "iterating, 2 s so far, nearly done");
        assert_eq!(line("iterating", 7300.0, None, 80), "iterating, 2 h 01 min so far");
        assert_eq!(line("iterating", 2.0, None, 10), "iterating");
        assert_eq!(line("iterating", 2.0, None, 0), "");
    }

    #[test]
    fn iterations_follow_from_the_rate() {
        // From 1 to 0.1 of 1 by halves: four more.
        assert_eq!(iterations_left(Some(0.1), Some(0.5), Some((1.0, Some(1.0)))), Some(4.0));
        assert_eq!(iterations_left(Some(0.1), None, Some((0.05, Some(1.0)))), Some(0.0));
        assert_eq!(iterations_left(Some(0.1), None, Some((1.0, Some(1.0)))), None);
        assert_eq!(iterations_left(None, Some(0.5), Some((1.0, Some(1.0)))), None);
        assert_eq!(work_left(0.1, 0.2), 6.0);
        assert_eq!(work_left(0.1, 0.05), 0.0);
    }
}

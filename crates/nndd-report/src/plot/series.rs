//! A series of a line plot: its points, and how they are drawn.

use super::PlotError;
use super::axis::Axis;
use super::look::{Look, mark, stroke};
use super::sheet::{self, Area, Chart, Frame, Labels};

/// Points kept of a series: beyond this, the smallest and largest of each run of neighbours.
const MOST_POINTS: usize = 800;
/// Markers drawn on a series.
const MOST_MARKERS: usize = 45;

/// A series: where it goes, point by point; `None` breaks the line.
pub(super) struct Series {
    pub(super) look: Look,
    pub(super) points: Vec<Option<(f64, f64)>>,
}

impl Series {
    /// The points that exist.
    pub(super) fn present(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.points.iter().flatten().copied()
    }
    /// Whether there is nothing to draw.
    pub(super) fn is_empty(&self) -> bool {
        self.present().next().is_none()
    }
}

/// Draws a panel with some series in it, or the words `no data`.
pub(super) fn line_panel(
    area: &Area<'_>,
    frame: Frame,
    axes: (Axis, Axis),
    labels: &Labels<'_>,
    all: &[Series],
) -> Result<(), PlotError> {
    let chart = sheet::panel(area, frame, axes, labels)?;
    if all.iter().all(Series::is_empty) {
        return sheet::no_data(area, frame);
    }
    all.iter().try_for_each(|s| draw(area, &chart, s))
}

/// Draws a series in a panel.
pub(super) fn draw(area: &Area<'_>, chart: &Chart<'_, '_>, series: &Series) -> Result<(), PlotError> {
    let thinned = thinned(&series.points);
    let runs: Vec<Vec<(i32, i32)>> = thinned
        .split(Option::is_none)
        .filter(|run| !run.is_empty())
        .map(|run| run.iter().flatten().map(|p| chart.backend_coord(p)).collect())
        .collect();
    for run in &runs {
        stroke(area, &series.look, run)?;
    }
    let total: usize = runs.iter().map(Vec::len).sum();
    let stride = total.div_ceil(MOST_MARKERS).max(1);
    for run in &runs {
        let last = run.len().saturating_sub(1);
        for (_, p) in run.iter().enumerate().filter(|(i, _)| i % stride == 0 || *i == last) {
            mark(area, &series.look, *p)?;
        }
    }
    Ok(())
}

/// The horizontal and the vertical extent of some series.
pub(super) fn extents<'a>(series: impl Iterator<Item = &'a Series> + Clone) -> Option<[(f64, f64); 2]> {
    let x = super::axis::extent(series.clone().flat_map(|s| s.present().map(|p| p.0)))?;
    let y = super::axis::extent(series.flat_map(|s| s.present().map(|p| p.1)))?;
    Some([x, y])
}

/// A logarithmic axis over the values, or a default if there are no values.
pub(super) fn log_axis(range: Option<(f64, f64)>) -> Axis {
    match range {
        Some((lo, hi)) => Axis::log_padded(lo, hi, 8),
        None => Axis::log(0.1, 10.0, 8),
    }
}

/// The points, or of each run of neighbours the first, the smallest and the largest.
fn thinned(points: &[Option<(f64, f64)>]) -> Vec<Option<(f64, f64)>> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let length = points.len().div_ceil(MOST_POINTS / 3);
    let mut kept = vec![];
    for chunk in points.chunks(length) {
        let by_value = |i: &usize, j: &usize| {
            let y = |k: usize| chunk[k].map_or(0.0, |p| p.1);
            y(*i).total_cmp(&y(*j))
        };
        let present: Vec<usize> = (0..chunk.len()).filter(|i| chunk[*i].is_some()).collect();
        let least = present.iter().copied().min_by(by_value);
        let most = present.iter().copied().max_by(by_value);
        let mut chosen: Vec<usize> = [present.first().copied(), least, most].into_iter().flatten().collect();
        chosen.sort_unstable();
        chosen.dedup();
        kept.extend(chosen.into_iter().map(|i| chunk[i]));
        if present.len() < chunk.len() {
            kept.push(None);
        }
    }
    // The last point shows where the series ends.
    match points.last() {
        Some(Some(p)) if kept.last() != Some(&Some(*p)) => kept.push(Some(*p)),
        _ => {}
    }
    kept
}

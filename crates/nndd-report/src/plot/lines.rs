//! Figures of lines: panels with series, one below the other, under one legend.

use super::axis::{Axis, extent};
use super::colour::INK;
use super::legend;
use super::look::{Look, Marker};
use super::sheet::{self, Frame, MARGIN, PIXEL, Panel, SMALL, Sheet, WIDTH, Words};
use fem_core::geometry::Vector;

/// Points kept of a series: beyond this, the smallest and largest of each run of neighbours.
const MOST_POINTS: usize = 800;
/// Markers drawn on a series.
const MOST_MARKERS: usize = 45;
/// Thickness of lines with data and of auxiliary ones.
pub(super) const THICK: f64 = 2.0 * PIXEL;
pub(super) const THIN: f64 = 1.5 * PIXEL;
/// Ticks of an axis, if there is room.
pub(super) const TICKS: usize = 8;
/// Room above a panel with a heading and without one.
const HEADING: f64 = 30.0 * PIXEL;
const NO_HEADING: f64 = 14.0 * PIXEL;
/// Intervals of the horizontal axis that are shaded, as the legend calls them.
pub(super) struct Band {
    pub(super) look: Look,
    pub(super) intervals: Vec<[f64; 2]>,
}

impl Band {
    pub(super) fn new(name: &'static str, colour: &'static str, intervals: Vec<[f64; 2]>) -> Self {
        Self { look: Look::new(name, colour, 12.0 * PIXEL, Marker::None), intervals }
    }
}

/// A series: its points in order; `None` breaks the line.
pub(super) struct Series {
    pub(super) look: Look,
    pub(super) points: Vec<Option<Vector>>,
}

impl Series {
    /// The points that exist.
    pub(super) fn present(&self) -> impl Iterator<Item = Vector> + '_ {
        self.points.iter().flatten().copied()
    }
    /// Tells if there is nothing to draw.
    pub(super) fn is_empty(&self) -> bool {
        self.present().next().is_none()
    }
}

/// A panel with its series.
pub(super) struct LinePanel<'a> {
    pub(super) heading: Option<&'a str>,
    pub(super) labels: [&'a str; 2],
    pub(super) axes: [&'a Axis; 2],
    pub(super) series: &'a [Series],
    pub(super) bands: &'a [Band],
    /// A remark about the data.
    pub(super) remark: Option<String>,
    /// A place of the horizontal axis at which the values go beyond the vertical one, and what is written there.
    pub(super) peak: Option<(f64, String)>,
}

impl<'a> LinePanel<'a> {
    /// A panel with series alone.
    pub(super) fn new(labels: [&'a str; 2], axes: [&'a Axis; 2], series: &'a [Series]) -> Self {
        Self { heading: None, labels, axes, series, bands: &[], remark: None, peak: None }
    }
}

/// Pixels beside the arrow of a peak within which its words keep off what is drawn.
const NEAR_PEAK: f64 = 60.0;

/// Draws a figure of panels of a height.
pub(super) fn figure(title: &str, description: &str, height: f64, panels: &[LinePanel<'_>]) -> String {
    let mut looks: Vec<Look> = vec![];
    for s in panels.iter().flat_map(|p| p.series).filter(|s| !s.is_empty()) {
        if looks.iter().all(|look| look.name != s.look.name) {
            looks.push(s.look);
        }
    }
    for band in panels.iter().flat_map(|p| p.bands).filter(|band| !band.intervals.is_empty()) {
        if looks.iter().all(|look| look.name != band.look.name) {
            looks.push(band.look);
        }
    }
    let above = |p: &LinePanel<'_>| if p.heading.is_some() { HEADING } else { NO_HEADING };
    let mut top = legend::end(&looks);
    let whole = top + panels.iter().map(|p| above(p) + height + sheet::BELOW).sum::<f64>() + MARGIN;
    let mut sheet = Sheet::new(whole, title, description);
    legend::draw(&mut sheet, &looks);
    for p in panels {
        top += above(p);
        if let Some(heading) = p.heading {
            let size = sheet::fitting(heading, SMALL, WIDTH - 2.0 * MARGIN);
            Words::new(size).bold().write(&mut sheet, heading, [0.5 * WIDTH, top - 13.0 * PIXEL]);
        }
        p.draw(&mut sheet, Frame::wide(top, height));
        top += height + sheet::BELOW;
    }
    sheet.finished()
}

impl LinePanel<'_> {
    fn draw(&self, sheet: &mut Sheet, frame: Frame) {
        let panel = Panel { frame, axes: self.axes };
        self.shade(sheet, &panel);
        panel.grid(sheet);
        panel.draw(sheet, self.labels);
        self.series.iter().for_each(|s| draw(sheet, &panel, s));
        if self.series.iter().all(Series::is_empty) {
            frame.remark(sheet, "no data");
        } else if let Some(remark) = &self.remark {
            frame.remark(sheet, remark);
        }
        if let Some((x, text)) = &self.peak {
            let at = Vector::new(panel.place([*x, 0.0])[0], frame.top);
            let [l, r] = [-1.0, 1.0].map(|side| at + PIXEL * Vector::new(5.0 * side, 8.0));
            sheet.fill(&sheet::path(&[at, l, r]), INK);
            // Beside the arrow, on the side where there is room.
            let words = Words::new(SMALL).with_halo();
            let (words, side) = match at[0] < 0.5 * WIDTH {
                true => (words.flush_left(), 1.0),
                false => (words.flush_right(), -1.0),
            };
            // Beyond what is drawn at the top there.
            let places = self.series.iter().flat_map(Series::present).map(|p| panel.place(p));
            let high = places.filter(|p| p[1] < at[1] + PIXEL * 16.0).map(|p| side * (p[0] - at[0]));
            let high = high.filter(|away| (0.0..PIXEL * NEAR_PEAK).contains(away));
            let away = high.fold(PIXEL * 9.0, |most, away| f64::max(most, away + PIXEL * 7.0));
            words.write(sheet, text, at + Vector::new(away * side, PIXEL * 7.0));
        }
    }

    fn shade(&self, sheet: &mut Sheet, panel: &Panel<'_>) {
        for band in self.bands {
            let (mut drawn, mut end) = (String::new(), f64::NEG_INFINITY);
            for interval in &band.intervals {
                let [a, b] = interval.map(|x| panel.place([x, 0.0])[0]);
                let b = b.max(a + 1.0);
                // A great many intervals narrower than a unit are drawn once.
                if b > end {
                    drawn += &sheet::rectangle([a, b], [panel.frame.top, panel.frame.bottom()]);
                    end = b;
                }
            }
            sheet.fill(&drawn, band.look.colour);
        }
    }
}

/// Draws a series in a panel.
fn draw(sheet: &mut Sheet, panel: &Panel<'_>, series: &Series) {
    let thinned = thinned(&series.points);
    let runs: Vec<Vec<Vector>> = thinned
        .split(Option::is_none)
        .filter(|run| !run.is_empty())
        .map(|run| run.iter().flatten().map(|p| panel.place(*p)).collect())
        .collect();
    runs.iter().for_each(|run| sheet.line(&series.look, run));
    let stride = runs.iter().map(Vec::len).sum::<usize>().div_ceil(MOST_MARKERS).max(1);
    for run in &runs {
        for (i, p) in run.iter().enumerate() {
            if i % stride == 0 || i + 1 == run.len() {
                sheet.mark(&series.look, *p);
            }
        }
    }
}

/// The horizontal and the vertical extent of some series.
pub(super) fn extents<'a>(series: impl Iterator<Item = &'a Series>) -> [Option<(f64, f64)>; 2] {
    let all: Vec<Vector> = series.flat_map(Series::present).collect();
    [0, 1].map(|c| extent(all.iter().map(|p| p[c])))
}

/// A logarithmic axis over the values, or a default if there are no values.
pub(super) fn log_axis(range: Option<(f64, f64)>) -> Axis {
    range.map_or_else(|| Axis::log(0.1, 10.0, TICKS), |(lo, hi)| Axis::log_padded(lo, hi, TICKS))
}

/// A linear axis over the values, or a default if there are no values.
pub(super) fn linear_axis(range: Option<(f64, f64)>) -> Axis {
    range.map_or_else(|| Axis::linear(0.0, 1.0, TICKS), |(lo, hi)| Axis::padded(lo, hi, TICKS))
}

/// The points, or of each run of neighbours the first, the smallest and the largest.
fn thinned(points: &[Option<Vector>]) -> Vec<Option<Vector>> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let mut kept = vec![];
    for chunk in points.chunks(points.len().div_ceil(MOST_POINTS / 3)) {
        let present: Vec<(usize, Vector)> =
            chunk.iter().enumerate().filter_map(|(i, p)| Some((i, (*p)?))).collect();
        let by_value = |a: &&(usize, Vector), b: &&(usize, Vector)| a.1[1].total_cmp(&b.1[1]);
        let (least, most) = (present.iter().min_by(by_value), present.iter().max_by(by_value));
        let mut chosen: Vec<_> = [present.first(), least, most].into_iter().flatten().collect();
        chosen.sort_unstable_by_key(|p| p.0);
        chosen.dedup_by_key(|p| p.0);
        kept.extend(chosen.into_iter().map(|p| Some(p.1)));
        if present.len() < chunk.len() {
            kept.push(None);
        }
    }
    // The last point shows where the series ends.
    kept.extend(points.last().filter(|p| p.is_some()));
    kept
}

//! The deformed bodies, cells coloured by error density.

mod names;

use super::PlotError;
use super::axis::{Axis, drawable, drawable_log, extent, short};
use super::cells::{self, Cell};
use super::colour::{GREY, INK, viridis};
use super::legend;
use super::look::{self, Look, Marker};
use super::outline::outline;
use super::sheet::{self, Area, Chart, Frame, LEFT, Labels, TITLE, UNITS, WIDTH, Words};
use plotters::element::{PathElement, Rectangle};
use plotters::style::Color;

/// One body of [`deformed`].
pub(crate) struct BodyPicture<'a> {
    /// Its name.
    pub(crate) name: &'a str,
    /// Its points.
    pub(crate) points: &'a [[f64; 2]],
    /// Its triangles, by point number.
    pub(crate) triangles: &'a [[u32; 3]],
    /// The displacement of each point.
    pub(crate) displacement: &'a [[f64; 2]],
    /// Error density of each triangle (squared error over area), ≥ 0.
    pub(crate) density: &'a [f64],
}

/// Two contact nodes that face each other, for [`deformed`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closing {
    /// Their distance in the drawing at rest, along the contact normal.
    pub(crate) gap: f64,
    /// By how much the displacements bring them together.
    pub(crate) approach: f64,
}

/// Room between the panel and the sheet's right edge for the bodies' names.
const BESIDE: i32 = 84;
/// Height of the colour bar.
const BAR: i32 = 14;
/// How far, as a part of the bodies' size, the bodies may overlap in the picture: less than its lines are thick.
const HAIR: f64 = 1e-3;
/// Room above the panel for names of bodies side by side.
const ABOVE: i32 = 24;
/// Decades of density shown below the largest.
const DECADES: f64 = 1e-4;

const UNDEFORMED: Look =
    Look { name: "undeformed", colour: GREY, dash: None, marker: Marker::None, thickness: 4 };
const DEFORMED: Look = Look { name: "deformed", colour: INK, dash: None, marker: Marker::None, thickness: 6 };

/// Draws the bodies deformed, on axes of equal scale, with cells coloured by error density on one common
/// logarithmic scale and undeformed outlines in grey.
///
/// Displacements are multiplied by 1, 2 or 5 times a power of ten such that the largest is at most 8 % of the
/// size of the bodies, and no pair of contact nodes passes each other: a gap is drawn as it is, so displacements that
/// close it must not be magnified. The title says the factor. Densities smaller than 1e-4 of the largest, zero among them, have
/// the colour of the lower end. Points with a coordinate or displacement that is not finite are left out with
/// their triangles. Many small cells are drawn as squares with the mean of the cells in them.
///
/// # Errors
/// [`PlotError::Length`] if displacements and points, or densities and triangles, differ in number, and
/// [`PlotError::Index`] if a triangle names a point that is not there.
pub(crate) fn deformed(
    title: &str,
    bodies: &[BodyPicture<'_>],
    closing: &[Closing],
) -> Result<String, PlotError> {
    bodies.iter().try_for_each(checked)?;
    let [x, y] = [0, 1].map(|c| extent(coordinates(bodies, 0.0).map(|p| p[c])));
    let size = x.map_or(0.0, |x| x.1 - x.0).max(y.map_or(0.0, |y| y.1 - y.0));
    let largest = bodies.iter().map(largest_displacement).fold(0.0, f64::max);
    let factor = nice_factor((0.08 * size / largest).min(most_without_overlap(closing, size)));
    let [x, y] =
        [0, 1].map(|c| extent([0.0, factor].into_iter().flat_map(|f| coordinates(bodies, f)).map(|p| p[c])));
    let x_known = x;
    let (x, y) = (x.unwrap_or((0.0, 1.0)), y.unwrap_or((0.0, 1.0)));

    let width = WIDTH - LEFT - BESIDE;
    let ratio = ((y.1 - y.0) / (x.1 - x.0).max(f64::MIN_POSITIVE)).clamp(0.3, 1.2);
    let frame = Frame {
        left: LEFT,
        top: TITLE + legend::height(&[DEFORMED, UNDEFORMED]) + ABOVE,
        width,
        height: (f64::from(width) * if ratio.is_finite() { ratio } else { 1.0 }) as i32,
    };
    let (x_axis, y_axis) = equal_scale(x, y, frame);
    let scale = scale(bodies);
    let heading = match x_known {
        None => title.to_owned(),
        Some(_) if largest > 0.0 => format!("{title} (displacements × {})", short(factor)),
        Some(_) => format!("{title} (no displacement)"),
    };
    let description = description(bodies, factor, &scale);

    let height = frame.top + frame.height + 2 * sheet::BELOW + BAR + 20;
    sheet::figure(height, &heading, &description, |area| {
        let labels = Labels { x: "x (length units)", y: "y (length units)", grid: false };
        legend::draw(area, TITLE, &[DEFORMED, UNDEFORMED])?;
        let chart = sheet::panel(area, frame, (x_axis, y_axis), &labels)?;
        let mut drawn: Vec<Cell> = vec![];
        for body in bodies {
            cells_of(body, factor, &chart, &mut drawn);
            outlines(area, &chart, body, factor)?;
        }
        names::names(area, &chart, bodies, factor, frame)?;
        if drawn.is_empty() {
            sheet::no_data(area, frame)?;
        } else {
            colour_bar(area, &scale, frame)?;
        }
        Ok(cells::elements(&drawn, |density| scale.position(density)))
    })
}

fn checked(body: &BodyPicture<'_>) -> Result<(), PlotError> {
    let points = body.points.len();
    super::same_length("displacements of a body", points, body.displacement.len())?;
    super::same_length("densities of a body", body.triangles.len(), body.density.len())?;
    for (triangle, t) in body.triangles.iter().enumerate() {
        if let Some(point) = t.iter().copied().find(|v| *v as usize >= points) {
            return Err(PlotError::Index { triangle, point, points });
        }
    }
    Ok(())
}

/// Where a point goes, `None` if it cannot be drawn.
fn moved(body: &BodyPicture<'_>, point: usize, factor: f64) -> Option<[f64; 2]> {
    let (p, u) = (body.points[point], body.displacement[point]);
    let usable = p.iter().chain(&u).all(|v| drawable(*v));
    usable.then(|| [p[0] + factor * u[0], p[1] + factor * u[1]]).filter(|q| q.iter().all(|v| drawable(*v)))
}

fn coordinates<'a>(bodies: &'a [BodyPicture<'a>], factor: f64) -> impl Iterator<Item = [f64; 2]> + 'a {
    bodies.iter().flat_map(move |b| (0..b.points.len()).filter_map(move |i| moved(b, i, factor)))
}

fn largest_displacement(body: &BodyPicture<'_>) -> f64 {
    (0..body.points.len())
        .filter(|i| moved(body, *i, 0.0).is_some())
        .map(|i| body.displacement[i][0].hypot(body.displacement[i][1]))
        .fold(0.0, f64::max)
}

/// The largest factor at which no pair of contact nodes passes each other by more than a hair's breadth.
fn most_without_overlap(closing: &[Closing], size: f64) -> f64 {
    let meeting = closing.iter().filter(|pair| pair.approach > 0.0);
    meeting.map(|pair| (pair.gap.max(0.0) + HAIR * size) / pair.approach).fold(f64::INFINITY, f64::min)
}

/// The largest of 1, 2, 5 times a power of ten that is at most `raw`; 1 if `raw` cannot be used.
fn nice_factor(raw: f64) -> f64 {
    if !drawable_log(raw) {
        return 1.0;
    }
    let exponent = raw.log10().floor() as i32;
    let power = if exponent < 0 { 1.0 / 10f64.powi(-exponent) } else { 10f64.powi(exponent) };
    [5.0, 2.0].into_iter().map(|m| m * power).find(|f| *f <= raw * (1.0 + 1e-9)).unwrap_or(power)
}

/// Axes on which a unit of length has the same size in both directions.
pub(super) fn equal_scale(x: (f64, f64), y: (f64, f64), frame: Frame) -> (Axis, Axis) {
    let (w, h) = (f64::from(frame.width), f64::from(frame.height));
    let unit = ((x.1 - x.0) / w).max((y.1 - y.0) / h) * 1.06;
    let reach = x.0.abs().max(x.1.abs()).max(y.0.abs()).max(y.1.abs());
    let unit = if unit > 1e-12 * reach && unit > 0.0 { unit } else { reach.max(1.0) / w };
    let around = |(lo, hi): (f64, f64), pixels: f64| {
        let (middle, half) = (0.5 * lo + 0.5 * hi, 0.5 * unit * pixels);
        Axis::linear(middle - half, middle + half, (pixels / 75.0).max(2.0) as usize)
    };
    (around(x, w), around(y, h))
}

/// The colour scale, and what is special about it.
struct Scale {
    axis: Axis,
    /// Some cells are below the lower end.
    cut: bool,
    /// No cell has a density above zero.
    empty: bool,
}

impl Scale {
    fn position(&self, density: f64) -> f64 {
        if self.empty || !drawable_log(density) { 0.0 } else { self.axis.position(density) }
    }
}

fn scale(bodies: &[BodyPicture<'_>]) -> Scale {
    let all = || bodies.iter().flat_map(|b| b.density.iter().copied());
    match extent(all().filter(|d| drawable_log(*d))) {
        None => Scale { axis: Axis::log(0.1, 10.0, 5), cut: false, empty: true },
        Some((lo, hi)) => {
            // Below the usual range only if much of the picture lies there: near singularities cells are tiny.
            let from = lo.max((hi * DECADES).min(low_density(bodies)).max(hi * DECADES * DECADES));
            let from = if hi / from < 10.0 { hi / 10.0 } else { from };
            Scale { axis: Axis::log(from, hi, 6), cut: all().any(|d| d < from), empty: false }
        }
    }
}

/// Finds the density that one twentieth of the bodies' area lies below.
fn low_density(bodies: &[BodyPicture<'_>]) -> f64 {
    let mut cells: Vec<(f64, f64)> = Vec::new();
    for body in bodies {
        for (t, density) in body.triangles.iter().zip(body.density).filter(|(_, d)| drawable_log(**d)) {
            let corners = t.map(|v| body.points.get(v as usize).copied().unwrap_or([f64::NAN; 2]));
            let area = fem_core::geometry::signed_area(corners).abs();
            if drawable(area) {
                cells.push((*density, area));
            }
        }
    }
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let twentieth = 0.05 * cells.iter().map(|c| c.1).sum::<f64>();
    let mut below = 0.0;
    let found = cells.iter().find(|c| {
        below += c.1;
        below > twentieth
    });
    found.map_or(f64::INFINITY, |c| c.0)
}

fn cells_of(body: &BodyPicture<'_>, factor: f64, chart: &Chart<'_, '_>, out: &mut Vec<Cell>) {
    let places: Vec<Option<(i32, i32)>> = (0..body.points.len())
        .map(|i| moved(body, i, factor).map(|p| chart.backend_coord(&(p[0], p[1]))))
        .collect();
    for (t, density) in body.triangles.iter().zip(body.density) {
        if let [Some(a), Some(b), Some(c)] = t.map(|v| places[v as usize]) {
            out.push(Cell { corners: [a, b, c], density: *density });
        }
    }
}

fn outlines(
    area: &Area<'_>,
    chart: &Chart<'_, '_>,
    body: &BodyPicture<'_>,
    factor: f64,
) -> Result<(), PlotError> {
    let still: Vec<[f64; 2]> =
        (0..body.points.len()).map(|i| moved(body, i, 0.0).unwrap_or([f64::NAN; 2])).collect();
    let twice_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| still[v as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let lines = outline(body.points.len(), body.triangles, twice_area);
    for (look, at_rest) in [(UNDEFORMED, true), (DEFORMED, false)] {
        for line in &lines {
            let mut path: Vec<(i32, i32)> = line
                .iter()
                .filter_map(|v| {
                    let p = moved(body, *v as usize, factor)?;
                    let [x, y] = if at_rest { moved(body, *v as usize, 0.0)? } else { p };
                    Some(chart.backend_coord(&(x, y)))
                })
                .collect();
            straightened(&mut path);
            area.draw(&PathElement::new(path, look.colour.stroke_width(look.thickness)))?;
        }
    }
    Ok(())
}

/// Drops points that repeat the one before or lie on the line between their neighbours.
fn straightened(path: &mut Vec<(i32, i32)>) {
    let mut kept: Vec<(i32, i32)> = Vec::with_capacity(path.len());
    for p in path.drain(..) {
        if kept.last() == Some(&p) {
            continue;
        }
        if let [.., a, b] = kept[..] {
            let (u, v) =
                ((i64::from(b.0 - a.0), i64::from(b.1 - a.1)), (i64::from(p.0 - b.0), i64::from(p.1 - b.1)));
            if u.0 * v.1 == u.1 * v.0 && u.0 * v.0 + u.1 * v.1 > 0 {
                kept.pop();
            }
        }
        kept.push(p);
    }
    *path = kept;
}

fn colour_bar(area: &Area<'_>, scale: &Scale, panel: Frame) -> Result<(), PlotError> {
    let top = panel.top + panel.height + sheet::BELOW + 10;
    let frame = Frame { left: panel.left, top, width: panel.width, height: BAR };
    if scale.empty {
        let at = (frame.left + frame.width / 2, frame.top + BAR / 2);
        return Words::new(14.0).grey().write(area, "error density zero everywhere", at);
    }
    let bottom = if scale.cut { "; left end: or less" } else { "" };
    let label = format!("error density (energy / area{bottom})");
    let (left, right) = (frame.left * UNITS, (frame.left + frame.width) * UNITS);
    let (top, low) = (frame.top * UNITS, (frame.top + frame.height) * UNITS);
    for k in 0..cells::SHADES {
        // Each shade covers the bar from its left edge to the right; the next covers the rest: no seams.
        let t = k as f64 / cells::SHADES as f64;
        let x = left + (t * f64::from(right - left)).round() as i32;
        let colour = viridis(k as f64 / (cells::SHADES - 1) as f64);
        area.draw(&Rectangle::new([(x, top), (right, low)], colour.filled()))?;
    }
    sheet::bar(area, frame, scale.axis.clone(), &label)?;
    let edge = [(left, low), (left, top), (right, top), (right, low), (left, low)];
    look::stroke(area, &Look { thickness: 3, ..DEFORMED }, &edge)
}

fn description(bodies: &[BodyPicture<'_>], factor: f64, scale: &Scale) -> String {
    let mut text = format!("Deformed bodies, displacements multiplied by {}.", short(factor));
    for b in bodies {
        text.push_str(&format!(
            " {}: {} triangles, largest displacement {}.",
            b.name,
            b.triangles.len(),
            short(largest_displacement(b))
        ));
    }
    let (lo, hi) = scale.axis.ends();
    if scale.empty {
        text.push_str(" The error density is zero everywhere.");
    } else {
        text.push_str(&format!(
            " Cells coloured by error density, energy per area, on a logarithmic scale from {}{} to {}.",
            short(lo),
            if scale.cut { " or less" } else { "" },
            short(hi)
        ));
    }
    text
}

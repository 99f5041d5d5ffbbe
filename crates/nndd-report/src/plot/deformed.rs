//! The deformed bodies, cells coloured by error density.

use super::axis::{Axis, drawable, drawable_log, extent, power_of_ten, short};
use super::cells::{self, Cell};
use super::colour::{GREY, INK};
use super::legend;
use super::look::{Look, Marker};
use super::names::{self, ABOVE, BESIDE};
use super::obstacle::{self, OBSTACLE, ObstaclePicture};
use super::outline::outline;
use super::sheet::{self, FINE, Frame, LEFT, PIXEL, Panel, Sheet, WIDTH, rectangle};
use fem_core::geometry::{Vector, cross, norm};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;

/// One body of [`deformed`].
pub(crate) struct BodyPicture<'a> {
    /// Its name.
    pub(crate) name: &'a str,
    /// Its mesh.
    pub(crate) mesh: &'a TriMesh,
    /// The displacement of each point.
    pub(crate) displacement: &'a [Vector],
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

/// Height of the colour bar.
const BAR: f64 = 14.0 * PIXEL;
/// The largest displacement in the picture, as a part of the bodies' size.
const LARGEST: f64 = 0.08;
/// How far, as a part of the bodies' size, the bodies may overlap in the picture: less than its lines are thick.
const HAIR: f64 = 1e-3;
/// Room for the hatches of obstacles, as a part of the bodies' size.
const ROOM: f64 = 0.04;
/// Decades of density shown below the largest.
const DECADES: f64 = 1e-4;
/// The part of the area that may have a density below the scale.
const BELOW_SCALE: f64 = 0.05;
/// Height of a panel over its width.
const RATIOS: [f64; 2] = [0.3, 1.2];
/// Ticks of the colour bar.
const TICKS: usize = 6;
/// The least distance of ticks on axes on which bodies are drawn.
const TICK_DISTANCE: f64 = 75.0 * PIXEL;
/// Labels of axes on which bodies are drawn.
pub(super) const PLANE: [&str; 2] = ["x (length units)", "y (length units)"];

const UNDEFORMED: Look = Look::new("undeformed", GREY, PIXEL, Marker::None);
const DEFORMED: Look = Look::new("deformed", INK, 1.5 * PIXEL, Marker::None);

/// Draws the bodies deformed, on axes of equal scale, with cells coloured by error density on one common
/// logarithmic scale and undeformed outlines in grey.
///
/// Displacements are multiplied by 1, 2 or 5 times a power of ten such that the largest is at most 8 % of the
/// size of the bodies, and no pair of contact nodes passes each other: a gap is drawn as it is, so displacements that
/// close it must not be magnified. The title says the factor. Densities smaller than 1e-4 of the largest, zero among them, have
/// the colour of the lower end. Points with a displacement that is not finite are left out with
/// their triangles. Many small cells are drawn as squares with the mean of the cells in them.
///
/// Obstacles are drawn where their motion, multiplied by the same factor, takes them.
pub(crate) fn deformed(
    title: &str,
    bodies: &[BodyPicture<'_>],
    obstacles: &[ObstaclePicture<'_>],
    closing: &[Closing],
) -> String {
    let points = |factors: &[f64]| {
        factors.iter().flat_map(|f| bodies.iter().flat_map(|b| places(b, *f))).flatten().collect()
    };
    let rest: Vec<Vector> = points(&[0.0]);
    let size = extents(rest.into_iter()).into_iter().flatten().fold(0.0, |m, (lo, hi)| f64::max(m, hi - lo));
    let largest = bodies.iter().map(largest_displacement).fold(0.0, f64::max);
    let factor = nice_factor((LARGEST * size / largest).min(most_without_overlap(closing, size)));
    let moved = |o: &ObstaclePicture<'_>| -> Vec<[Vector; 2]> {
        let line = o.near(size).into_iter().map(|[p, n]| [p + factor * o.motion.at(p), n]);
        line.filter(|[p, _]| p.iter().all(|v| drawable(*v))).collect()
    };
    let lines: Vec<Vec<[Vector; 2]>> = obstacles.iter().map(moved).collect();
    let drawn: Vec<Vector> = points(&[0.0, factor]);
    let known = extents(drawn.into_iter().chain(lines.iter().flatten().map(|[p, n]| p + ROOM * size * n)));
    let looks = [DEFORMED, UNDEFORMED, OBSTACLE];
    let looks = if lines.iter().all(Vec::is_empty) { &looks[..2] } else { &looks[..] };
    let (frame, axes) = equal_scale(known, legend::end(looks) + ABOVE, WIDTH - LEFT - BESIDE, RATIOS);
    let scale = density_scale(bodies);
    let heading = match known {
        None => title.to_owned(),
        Some(_) if largest > 0.0 => format!("{title} (displacements × {})", short(factor)),
        Some(_) => format!("{title} (no displacement)"),
    };
    let height = frame.bottom() + 2.0 * sheet::BELOW + BAR + 2.0 * sheet::MARGIN;
    let mut sheet = Sheet::new(height, &heading, &description(bodies, factor, &scale));
    legend::draw(&mut sheet, looks);
    let panel = Panel { frame, axes: axes.each_ref() };
    panel.draw(&mut sheet, PLANE);
    let drawn: Vec<_> = bodies.iter().map(|b| (b.name, cells_of(b, factor, &panel))).collect();
    if drawn.iter().all(|(_, cells)| cells.is_empty()) {
        frame.remark(&mut sheet, "no data");
    } else {
        colour_bar(&mut sheet, &scale, frame);
    }
    let cells: Vec<&Cell> = drawn.iter().flat_map(|(_, cells)| cells).collect();
    sheet.add(&cells::elements(&cells, |density| scale.position(density)));
    bodies.iter().for_each(|b| outlines(&mut sheet, &panel, b, factor));
    lines.iter().for_each(|line| obstacle::hatched(&mut sheet, &panel, line));
    names::names(&mut sheet, frame, &drawn);
    sheet.finished()
}

/// Where the points of a body go, `None` for those that cannot be drawn.
fn places(body: &BodyPicture<'_>, factor: f64) -> impl Iterator<Item = Option<Vector>> {
    body.mesh.points().iter().zip(body.displacement).map(move |(p, u)| {
        let q = *p + factor * *u;
        p.iter().chain(u).chain(&q).all(|v| drawable(*v)).then_some(q)
    })
}

/// The extents of some points in both directions.
pub(super) fn extents(points: impl Iterator<Item = Vector>) -> Option<[(f64, f64); 2]> {
    let points: Vec<Vector> = points.collect();
    let [x, y] = [0, 1].map(|c| extent(points.iter().map(|p| p[c])));
    Some([x?, y?])
}

fn largest_displacement(body: &BodyPicture<'_>) -> f64 {
    let known = places(body, 0.0).zip(body.displacement).filter(|(p, _)| p.is_some());
    known.map(|(_, u)| norm(*u)).fold(0.0, f64::max)
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
    let power = power_of_ten(raw.log10().floor() as i32);
    [5.0, 2.0].into_iter().map(|m| m * power).find(|f| *f <= raw * (1.0 + 1e-9)).unwrap_or(power)
}

/// A frame for points of some extents, with axes on which a unit of length has the same size in both directions.
///
/// * `ratios`: the least and the greatest height of the frame over its width.
pub(super) fn equal_scale(
    extents: Option<[(f64, f64); 2]>,
    top: f64,
    width: f64,
    ratios: [f64; 2],
) -> (Frame, [Axis; 2]) {
    let extents = extents.unwrap_or([(0.0, 1.0); 2]);
    let [w, h] = extents.map(|(lo, hi)| hi - lo);
    let ratio = (h / w.max(f64::MIN_POSITIVE)).clamp(ratios[0], ratios[1]);
    let frame = Frame { left: LEFT, top, width, height: (width * ratio).round() };
    let unit = (w / frame.width).max(h / frame.height) * 1.06;
    let reach = extents.iter().flat_map(|e| [e.0.abs(), e.1.abs()]).fold(0.0, f64::max);
    let unit = if unit > 1e-12 * reach && unit > 0.0 { unit } else { reach.max(1.0) / frame.width };
    let around = |(lo, hi): (f64, f64), length: f64| {
        let (middle, half) = (0.5 * lo + 0.5 * hi, 0.5 * unit * length);
        Axis::linear(middle - half, middle + half, (length / TICK_DISTANCE).max(2.0) as usize)
    };
    (frame, [around(extents[0], frame.width), around(extents[1], frame.height)])
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

fn density_scale(bodies: &[BodyPicture<'_>]) -> Scale {
    let all = || bodies.iter().flat_map(|b| b.density.iter().copied());
    match extent(all().filter(|d| drawable_log(*d))) {
        None => Scale { axis: Axis::log(0.1, 10.0, TICKS), cut: false, empty: true },
        Some((lo, hi)) => {
            // Below the usual range only if much of the picture lies there: near singularities cells are tiny.
            let from = lo.max((hi * DECADES).min(low_density(bodies)).max(hi * DECADES * DECADES));
            let from = if hi / from < 10.0 { hi / 10.0 } else { from };
            Scale { axis: Axis::log(from, hi, TICKS), cut: all().any(|d| d < from), empty: false }
        }
    }
}

/// Finds the density that a small part of the bodies' area lies below.
fn low_density(bodies: &[BodyPicture<'_>]) -> f64 {
    let of = |b: &BodyPicture<'_>| -> Vec<(f64, f64)> {
        b.density.iter().enumerate().map(|(t, d)| (*d, b.mesh.area(t))).collect()
    };
    let mut cells: Vec<(f64, f64)> = bodies.iter().flat_map(of).collect();
    cells.retain(|(density, area)| drawable_log(*density) && drawable(*area));
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = BELOW_SCALE * cells.iter().map(|c| c.1).sum::<f64>();
    let found = cells.iter().find(|c| {
        left -= c.1;
        left < 0.0
    });
    found.map_or(f64::INFINITY, |c| c.0)
}

fn cells_of(body: &BodyPicture<'_>, factor: f64, panel: &Panel<'_>) -> Vec<Cell> {
    let places: Vec<Option<Vector>> = places(body, factor).map(|p| Some(panel.place(p?))).collect();
    let cell = |(t, density): (&[NodeId; 3], &f64)| {
        let [a, b, c] = t.map(|v| places.get(v.index()).copied().flatten());
        Some(Cell { corners: [a?, b?, c?], density: *density })
    };
    body.mesh.triangles().iter().zip(body.density).filter_map(cell).collect()
}

fn outlines(sheet: &mut Sheet, panel: &Panel<'_>, body: &BodyPicture<'_>, factor: f64) {
    let lines = outline(body.mesh);
    let moved: Vec<Option<Vector>> = places(body, factor).collect();
    for (look, factor) in [(UNDEFORMED, 0.0), (DEFORMED, factor)] {
        let places: Vec<_> = places(body, factor).zip(&moved).map(|(p, q)| q.and(p)).collect();
        for line in &lines {
            let known = line.iter().filter_map(|v| places.get(v.index()).copied().flatten());
            sheet.line(&look, &straightened(known.map(|p| panel.place(p))));
        }
    }
}

/// Drops points that repeat the one before or lie on the line between their neighbours.
fn straightened(path: impl Iterator<Item = Vector>) -> Vec<Vector> {
    let mut kept: Vec<Vector> = vec![];
    for p in path {
        if kept.last() == Some(&p) {
            continue;
        }
        if let [.., a, b] = kept[..] {
            let (u, v) = (b - a, p - b);
            if cross(u, v) == 0.0 && u.dot(&v) > 0.0 {
                kept.pop();
            }
        }
        kept.push(p);
    }
    kept
}

fn colour_bar(sheet: &mut Sheet, scale: &Scale, panel: Frame) {
    let frame = Frame { top: panel.bottom() + sheet::BELOW + sheet::MARGIN, height: BAR, ..panel };
    if scale.empty {
        return frame.remark(sheet, "error density zero everywhere");
    }
    let (left, right, bottom) = (frame.left, frame.right(), frame.bottom());
    for k in 0..cells::SHADES {
        // Each shade covers the bar from its left edge to the right; the next covers the rest: no seams.
        let x = left + k as f64 / cells::SHADES as f64 * frame.width;
        sheet.fill(&rectangle([x, right], [frame.top, bottom]), &cells::colour_of(k));
    }
    let cut = if scale.cut { "; left end: or less" } else { "" };
    let label = format!("error density (energy / area{cut})");
    sheet.axis(&scale.axis, [left, bottom], [right, bottom], &label);
    sheet.stroke(&rectangle([left, right], [frame.top, bottom]), INK, FINE);
}

fn description(bodies: &[BodyPicture<'_>], factor: f64, scale: &Scale) -> String {
    let mut text = format!("Deformed bodies, displacements multiplied by {}.", short(factor));
    for b in bodies {
        text.push_str(&format!(
            " {}: {} triangles, largest displacement {}.",
            b.name,
            b.mesh.triangles().len(),
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

//! The deformed bodies, coloured by a field: constant in the cells, or linear between the nodes.

use super::axis::{Axis, Kind, drawable, drawable_log, extent, power_of_ten, short};
use super::bands;
use super::cells::{self, Cell};
use super::colour::{GREY, INK};
use super::labels::Labels;
use super::legend;
use super::look::{Look, Marker};
use super::names;
use super::obstacle::{self, OBSTACLE, ObstaclePicture};
use super::outline::outline;
use super::scale::{BAR, BodyPicture, Field, Quantity, Scale, three};
use super::sheet::{self, FINE, Frame, LEFT, PIXEL, Panel, RIGHT, Sheet, WIDTH};
use crate::nodal::{self, NodalPatch};
use fem_core::geometry::{Vector, cross, norm};
use fem_core::mesh::id::NodeId;

/// Two contact nodes that face each other, for [`deformed`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closing {
    /// Their distance in the drawing at rest, along the contact normal.
    pub(crate) gap: f64,
    /// By how much the displacements bring them together.
    pub(crate) approach: f64,
}

/// Height of the line below the bar.
const REMARK: f64 = 16.0 * PIXEL;
/// The largest displacement in the picture, as a part of the bodies' size.
const LARGEST: f64 = 0.08;
/// How far, as a part of the bodies' size, the bodies may overlap in the picture: less than its lines are thick.
const HAIR: f64 = 1e-3;
/// Room for the hatches of obstacles, as a part of the bodies' size.
const ROOM: f64 = 0.04;
/// The radius of the ring around a largest value that the scale does not reach.
const RING: f64 = 6.0 * PIXEL;
/// Height of a panel over its width.
const RATIOS: [f64; 2] = [0.3, 1.2];
/// The least distance of ticks on axes on which bodies are drawn.
const TICK_DISTANCE: f64 = 75.0 * PIXEL;
const UNDEFORMED: Look = Look::new("undeformed", GREY, PIXEL, Marker::None);
const DEFORMED: Look = Look::new("deformed", INK, 1.5 * PIXEL, Marker::None);

/// The labels of axes on which bodies are drawn.
pub(super) fn plane(labels: &Labels) -> [String; 2] {
    ["x", "y"].map(|what| labels.length(what))
}

/// Draws the bodies deformed, on axes of equal scale, coloured by a field on one common scale, with undeformed outlines in grey.
///
/// Displacements are multiplied by 1, 2 or 5 times a power of ten such that the largest is at most 8 % of the
/// size of the bodies, and no pair of contact nodes passes each other: a gap is drawn as it is, so displacements that
/// close it must not be magnified. The title says the factor. If the largest value is `infinite` (it grows with every refinement), the
/// scale ends below a peak that few points have; the bar then says the largest value, and a ring shows its place. Points with a displacement that is not finite are left out with
/// their triangles. Values of many small cells are averaged at the nodes.
///
/// Obstacles are drawn where their motion, multiplied by the same factor, takes them.
pub(crate) fn deformed(
    title: &str,
    quantity: Quantity,
    bodies: &[BodyPicture<'_>],
    obstacles: &[ObstaclePicture<'_>],
    closing: &[Closing],
    infinite: bool,
    labels: &Labels,
) -> String {
    let points = |factors: &[f64]| {
        factors.iter().flat_map(|f| bodies.iter().flat_map(|b| places(b, *f))).flatten().collect()
    };
    let rest: Vec<Vector> = points(&[0.0]);
    let size = extents(rest.into_iter()).into_iter().flatten().fold(0.0, |m, (lo, hi)| f64::max(m, hi - lo));
    let largest = bodies.iter().map(largest_displacement).fold(0.0, f64::max);
    let factor = magnified(size, largest, closing);
    let moved = |o: &ObstaclePicture<'_>| -> Vec<[Vector; 2]> {
        let line = o.near(size).into_iter().map(|[p, n]| [p + factor * o.motion.at(p), n]);
        line.filter(|[p, _]| p.iter().all(|v| drawable(*v))).collect()
    };
    let lines: Vec<Vec<[Vector; 2]>> = obstacles.iter().map(moved).collect();
    let drawn: Vec<Vector> = points(&[0.0, factor]);
    let known = extents(drawn.into_iter().chain(lines.iter().flatten().map(|[p, n]| p + ROOM * size * n)));
    let looks = [DEFORMED, UNDEFORMED, OBSTACLE];
    let looks = if lines.iter().all(Vec::is_empty) { &looks[..2] } else { &looks[..] };
    let top = legend::end(looks) + 8.0 * PIXEL;
    let (frame, axes) = equal_scale(known, top, WIDTH - LEFT - 1.5 * RIGHT, RATIOS);
    let scale = Scale::of(quantity, bodies, infinite);
    let heading = match known {
        None => title.to_owned(),
        Some(_) if largest > 0.0 && quantity == Quantity::Displacement => {
            format!("{title} (drawn × {})", short(factor))
        }
        Some(_) if largest > 0.0 => format!("{title} (displacements × {})", short(factor)),
        Some(_) => format!("{title} (no displacement)"),
    };
    let remark = if scale.remark().is_some() { REMARK } else { 0.0 };
    let height = frame.bottom() + 2.0 * sheet::BELOW + BAR + remark + 2.0 * sheet::MARGIN;
    let mut sheet = Sheet::new(height, &heading, &description(bodies, factor, quantity, &scale));
    legend::draw(&mut sheet, looks);
    let panel = Panel { frame, axes: axes.each_ref() };
    panel.draw(&mut sheet, plane(labels).each_ref().map(String::as_str));
    let on_sheet =
        |b: &BodyPicture<'_>| places(b, factor).map(|p| p.map(|p| panel.place(p))).collect::<Vec<_>>();
    let drawn: Vec<Vec<Option<Vector>>> = bodies.iter().map(on_sheet).collect();
    if drawn.iter().flatten().all(Option::is_none) {
        frame.remark(&mut sheet, "no data");
    } else {
        scale.bar(&mut sheet, frame, quantity, labels);
    }
    fill(&mut sheet, bodies, &drawn, &scale);
    bodies.iter().for_each(|b| outlines(&mut sheet, &panel, b, factor));
    lines.iter().for_each(|line| obstacle::hatched(&mut sheet, &panel, line));
    if let Some((body, node)) = scale.peak {
        let at = drawn.get(body).and_then(|places| places.get(node).copied().flatten());
        at.iter().for_each(|at| sheet.ring(*at, RING, INK, FINE));
    }
    for (body, places) in bodies.iter().zip(&drawn) {
        names::write(&mut sheet, body.name, body.mesh, places);
    }
    sheet.finished()
}

/// Fills the bodies with their colours, and draws the edges of the cells if there are few.
fn fill(sheet: &mut Sheet, bodies: &[BodyPicture<'_>], places: &[Vec<Option<Vector>>], scale: &Scale) {
    let count: usize = bodies.iter().map(|b| b.mesh.cells().len()).sum();
    let cells: Vec<Cell> = match count <= cells::MOST_CELLS {
        true => bodies.iter().zip(places).flat_map(|(b, places)| cells_of(b, places)).collect(),
        false => vec![],
    };
    let means: Vec<Vec<NodalPatch>> = bodies.iter().map(means).collect();
    let mut patches: Vec<(&NodalPatch, &[Option<Vector>])> = vec![];
    for ((body, places), means) in bodies.iter().zip(places).zip(&means) {
        match body.field {
            Field::Nodes(of) => patches.extend(of.iter().map(|patch| (patch, places.as_slice()))),
            Field::Cells(_) if count > cells::MOST_CELLS => {
                patches.extend(means.iter().map(|patch| (patch, places.as_slice())));
            }
            Field::Cells(_) => {}
        }
    }
    match patches.is_empty() {
        true => sheet.add(&cells::elements(&cells, |value| scale.position(value))),
        false => sheet.add(&bands::elements(&patches, |value| scale.position(value))),
    }
    sheet.add(&cells::edges(&cells));
}

/// The field of a body's cells as means at the nodes.
fn means(body: &BodyPicture<'_>) -> Vec<NodalPatch> {
    let Field::Cells(values) = body.field else { return vec![] };
    let known = (0..values.len()).filter(|t| values[*t].is_finite());
    let values = nodal::averaged(body.mesh, known, |t| values[t]);
    vec![NodalPatch { triangles: body.mesh.cells().to_vec(), values }]
}

/// Returns the displaced points of a body, `None` for a point that cannot be drawn.
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

/// Chooses the factor by which displacements are multiplied in a picture, see [`deformed`].
///
/// * `size`: of the bodies; `largest`: displacement.
pub(crate) fn magnified(size: f64, largest: f64, closing: &[Closing]) -> f64 {
    nice_factor((LARGEST * size / largest).min(most_without_overlap(closing, size)))
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

fn cells_of(body: &BodyPicture<'_>, places: &[Option<Vector>]) -> Vec<Cell> {
    let values: &[f64] = match body.field {
        Field::Cells(values) => values,
        Field::Nodes(_) => &[],
    };
    let cell = |(t, nodes): (usize, &[NodeId; 3])| {
        let [a, b, c] = nodes.map(|v| places.get(v.index()).copied().flatten());
        Some(Cell { corners: [a?, b?, c?], value: values.get(t).copied().unwrap_or(0.0) })
    };
    body.mesh.cells().iter().enumerate().filter_map(cell).collect()
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

fn description(bodies: &[BodyPicture<'_>], factor: f64, quantity: Quantity, scale: &Scale) -> String {
    let mut text = format!("Deformed bodies, displacements multiplied by {}.", short(factor));
    for b in bodies {
        text.push_str(&format!(
            " {}: {} triangles, largest displacement {}.",
            b.name,
            b.mesh.cells().len(),
            short(largest_displacement(b))
        ));
    }
    let ((lo, hi), name) = (scale.axis.ends(), quantity.name());
    if scale.empty {
        text.push_str(&format!(" The {name} is zero everywhere."));
        return text;
    }
    let kind = match scale.axis.kind() {
        Kind::Log => "logarithmic",
        Kind::Linear => "linear",
        Kind::Root => "square-root",
    };
    let less = if scale.cut { " or less" } else { "" };
    let more = scale.largest.map_or_else(String::new, |v| format!(" or more, at most {}", three(v)));
    text + &format!(" Coloured by {name}, on a {kind} scale from {}{less} to {}{more}.", short(lo), short(hi))
}

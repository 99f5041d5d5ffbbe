//! The problem as it is given: bodies, supports, loads and the contact line.

use super::PlotError;
use super::axis::{drawable, extent};
use super::colour::{BLUE, GREEN, GREY, INK, ORANGE, VERMILLION};
use super::deformed::equal_scale;
use super::legend;
use super::look::{self, Look, Marker};
use super::outline::outline;
use super::sheet::{self, Area, Chart, Frame, LEFT, Labels, RIGHT, TITLE, UNITS, WIDTH, Words};
use fem_core::geometry::signed_area;
use plotters::element::{Circle, PathElement, Polygon};
use plotters::style::Color;
use std::fmt::Write as _;

/// One body of [`sketch`].
pub(crate) struct SketchBody<'a> {
    /// Its name.
    pub(crate) name: &'a str,
    /// Its points.
    pub(crate) points: &'a [[f64; 2]],
    /// Its triangles, by point number.
    pub(crate) triangles: &'a [[u32; 3]],
    /// What is imposed on its boundary edges.
    pub(crate) edges: Vec<SketchEdge>,
    /// The body force on it; zero if there is no such force.
    pub(crate) body_force: [f64; 2],
}

/// What is imposed on a boundary edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SketchEdge {
    /// Its two ends.
    pub(crate) ends: [[f64; 2]; 2],
    /// Its outward unit normal.
    pub(crate) normal: [f64; 2],
    /// How it is held.
    pub(crate) held: Held,
    /// The displacement imposed on it, zero if it is only held.
    pub(crate) displacement: [f64; 2],
    /// The load on it, force per length and thickness.
    pub(crate) traction: [f64; 2],
}

/// How an edge is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Held {
    /// Not at all.
    Free,
    /// In one direction.
    Roller,
    /// In both directions.
    Fixed,
}

const FIXED: Look = Look { name: "held", colour: INK, dash: None, marker: Marker::None, thickness: 16 };
const ROLLER: Look =
    Look { name: "held in one direction", colour: GREY, dash: None, marker: Marker::Disc, thickness: 4 };
const MOVED: Look = Look {
    name: "imposed displacement",
    colour: VERMILLION,
    dash: None,
    marker: Marker::Triangle,
    thickness: 7,
};
const LOAD: Look = Look { name: "load", colour: BLUE, dash: None, marker: Marker::Triangle, thickness: 7 };
const CONTACT: Look =
    Look { name: "possible contact", colour: GREEN, dash: None, marker: Marker::None, thickness: 16 };
/// Distance of two marks of a kind, in pixels.
const APART: f64 = 17.0;
/// Length of the longest arrow, in pixels.
const ARROW: f64 = 30.0;
/// Triangles and points of the boundary tried in search of a place for a name.
const MOST_TRIED: usize = 300;
/// Below this many cells, their edges are drawn.
const WITH_EDGES: usize = 4_000;

/// Draws the bodies at rest with how they are held, what is imposed, and where they may touch.
///
/// Arrows of loads are as long as these are large, those of imposed displacements all alike.
pub(crate) fn sketch(
    title: &str,
    bodies: &[SketchBody<'_>],
    contact: &[[[f64; 2]; 2]],
) -> Result<String, PlotError> {
    let points = || bodies.iter().flat_map(|b| b.points).filter(|p| p.iter().all(|v| drawable(*v)));
    let x = extent(points().map(|p| p[0])).unwrap_or((0.0, 1.0));
    let y = extent(points().map(|p| p[1])).unwrap_or((0.0, 1.0));
    let edges = || bodies.iter().flat_map(|b| &b.edges);
    let length = |v: [f64; 2]| v[0].hypot(v[1]);
    let largest = edges().map(|e| length(e.traction)).filter(|l| l.is_finite()).fold(0.0, f64::max);
    let there = [
        (CONTACT, !contact.is_empty()),
        (FIXED, edges().any(|e| e.held == Held::Fixed)),
        (ROLLER, edges().any(|e| e.held == Held::Roller)),
        (MOVED, edges().any(|e| length(e.displacement) > 0.0)),
        (LOAD, largest > 0.0),
    ];
    let shown: Vec<Look> = there.into_iter().filter(|(_, there)| *there).map(|(look, _)| look).collect();
    let width = WIDTH - LEFT - RIGHT;
    let ratio = ((y.1 - y.0) / (x.1 - x.0).max(f64::MIN_POSITIVE)).clamp(0.4, 1.2);
    let ratio = if ratio.is_finite() { ratio } else { 1.0 };
    let top = TITLE + legend::height(&shown) + 8;
    let frame = Frame { left: LEFT, top, width, height: (f64::from(width) * ratio) as i32 };
    // Room for the marks outside the bodies.
    let margin = 0.12 * (x.1 - x.0).max(y.1 - y.0);
    let (x, y) = ((x.0 - margin, x.1 + margin), (y.0 - margin, y.1 + margin));
    let axes = equal_scale(x, y, frame);
    sheet::figure(top + frame.height + sheet::BELOW + 10, title, &description(bodies), |area| {
        legend::draw(area, TITLE, &shown)?;
        let labels = Labels { x: "x (length units)", y: "y (length units)", grid: false };
        let chart = sheet::panel(area, frame, axes, &labels)?;
        let mut below = String::new();
        for body in bodies {
            below += &filled(&chart, body);
        }
        for edge in contact {
            look::stroke(area, &CONTACT, &edge.map(|p| chart.backend_coord(&(p[0], p[1]))))?;
        }
        for body in bodies {
            marks(area, &chart, body, largest)?;
            name(area, &chart, body)?;
        }
        if bodies.iter().all(|b| b.triangles.is_empty()) {
            sheet::no_data(area, frame)?;
        }
        Ok(below)
    })
}

/// The body as one pale shape, with its cells if there are few.
fn filled(chart: &Chart<'_, '_>, body: &SketchBody<'_>) -> String {
    let corners = |t: &[u32; 3]| t.map(|v| body.points.get(v as usize).copied().unwrap_or([f64::NAN; 2]));
    let place = |p: [f64; 2]| chart.backend_coord(&(p[0], p[1]));
    let mut shape = String::new();
    for line in outline(body.points.len(), body.triangles, |t| 2.0 * signed_area(corners(t))) {
        for (k, v) in line.iter().enumerate() {
            let (x, y) = place(body.points[*v as usize]);
            let _ = write!(shape, "{}{x} {y}", if k == 0 { "M" } else { "L" });
        }
        shape.push('z');
    }
    let mut out = format!("<path d=\"{shape}\" fill=\"#DCE6EE\" fill-rule=\"evenodd\"/>\n");
    if body.triangles.len() <= WITH_EDGES {
        let mut cells = String::new();
        for t in body.triangles {
            let [a, b, c] = corners(t).map(place);
            let _ = write!(cells, "M{} {}L{} {}L{} {}z", a.0, a.1, b.0, b.1, c.0, c.1);
        }
        let _ = writeln!(out, "<path d=\"{cells}\" fill=\"none\" stroke=\"#FFFFFF\" stroke-width=\"2\"/>");
    }
    let _ = writeln!(out, "<path d=\"{shape}\" fill=\"none\" stroke=\"#191919\" stroke-width=\"5\"/>");
    out
}

fn marks(
    area: &Area<'_>,
    chart: &Chart<'_, '_>,
    body: &SketchBody<'_>,
    largest: f64,
) -> Result<(), PlotError> {
    let (mut supports, mut moves, mut loads) = (Spaced::default(), Spaced::default(), Spaced::default());
    for edge in &body.edges {
        let [a, b] = edge.ends.map(|p| chart.backend_coord(&(p[0], p[1])));
        // Downwards is positive on the sheet.
        let flipped = |v: [f64; 2]| [v[0], -v[1]];
        let out = flipped(edge.normal);
        let at = (f64::from(a.0 + b.0) / 2.0, f64::from(a.1 + b.1) / 2.0);
        match edge.held {
            Held::Free => {}
            Held::Fixed => {
                area.draw(&PathElement::new(vec![a, b], INK.stroke_width(14)))?;
                if supports.has_room(at) {
                    // A hatch: at 45 degrees to the side, outwards.
                    let (s, length) = (std::f64::consts::FRAC_1_SQRT_2, 11.0);
                    let way = [s * (out[0] - out[1]), s * (out[0] + out[1])];
                    let path = vec![moved(at, way, 0.0), moved(at, way, length)];
                    area.draw(&PathElement::new(path, INK.stroke_width(5)))?;
                }
            }
            Held::Roller if supports.has_room(at) => {
                area.draw(&Circle::new(moved(at, out, 5.5), 4 * UNITS, GREY.filled()))?;
            }
            Held::Roller => {}
        }
        if let Some(way) = unit(flipped(edge.displacement)).filter(|_| moves.has_room(at)) {
            arrow(area, at, way, out, 0.7 * ARROW, if edge.held == Held::Free { 0.0 } else { 12.0 }, &MOVED)?;
        }
        let size = edge.traction[0].hypot(edge.traction[1]);
        if let Some(way) =
            unit(flipped(edge.traction)).filter(|_| size >= 0.05 * largest && loads.has_room(at))
        {
            arrow(area, at, way, out, (ARROW * size / largest).max(9.0), 0.0, &LOAD)?;
        }
    }
    Ok(())
}

/// Draws an arrow that ends at a place if it points into the body, and begins there if it points out of it.
fn arrow(
    area: &Area<'_>,
    at: (f64, f64),
    way: [f64; 2],
    out: [f64; 2],
    length: f64,
    off: f64,
    look: &Look,
) -> Result<(), PlotError> {
    let inwards = way[0] * out[0] + way[1] * out[1] < -1e-9;
    let (from, to) = if inwards { (-off - length, -off - 2.0) } else { (off, off + length) };
    let (tail, neck, tip) = (moved(at, way, from), moved(at, way, to - 6.0), moved(at, way, to));
    area.draw(&PathElement::new(vec![tail, neck], look.colour.stroke_width(look.thickness)))?;
    let side = |s: f64| moved((f64::from(neck.0), f64::from(neck.1)), [-way[1], way[0]], s);
    area.draw(&Polygon::new(vec![side(-3.5), tip, side(3.5)], look.colour.filled()))?;
    Ok(())
}

/// A place in units, some pixels from another.
fn moved(at: (f64, f64), way: [f64; 2], pixels: f64) -> (i32, i32) {
    let step = pixels * f64::from(UNITS);
    ((at.0 + step * way[0]).round() as i32, (at.1 + step * way[1]).round() as i32)
}

fn unit(v: [f64; 2]) -> Option<[f64; 2]> {
    let length = v[0].hypot(v[1]);
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}

/// Places of marks that keep their distance.
#[derive(Default)]
struct Spaced(Vec<(f64, f64)>);

impl Spaced {
    /// Whether a mark has room here; if so, it takes it.
    fn has_room(&mut self, at: (f64, f64)) -> bool {
        let apart = APART * f64::from(UNITS);
        let free = self.0.iter().all(|p| (p.0 - at.0).hypot(p.1 - at.1) >= apart);
        if free {
            self.0.push(at);
        }
        free
    }
}

/// Writes the name of a body within it, near its middle.
fn name(area: &Area<'_>, chart: &Chart<'_, '_>, body: &SketchBody<'_>) -> Result<(), PlotError> {
    let corners = |t: &[u32; 3]| t.map(|v| body.points.get(v as usize).copied().unwrap_or([f64::NAN; 2]));
    let middle = |t: &[u32; 3]| {
        let c = corners(t);
        [0, 1].map(|k| (c[0][k] + c[1][k] + c[2][k]) / 3.0)
    };
    // Of some triangles the one farthest from the boundary, and of those alike the one nearest to the middle.
    let sample = |n: usize| (n / MOST_TRIED).max(1);
    let edge: Vec<[f64; 2]> = outline(body.points.len(), body.triangles, |t| 2.0 * signed_area(corners(t)))
        .concat()
        .iter()
        .map(|v| body.points[*v as usize])
        .collect();
    let tried: Vec<[f64; 2]> =
        body.triangles.iter().step_by(sample(body.triangles.len())).map(middle).collect();
    let centre = [0, 1].map(|c| tried.iter().map(|m| m[c]).sum::<f64>() / tried.len().max(1) as f64);
    // Words are wider than high: what is beside them is nearer than it looks.
    let aspect = (sheet::width_of(body.name, 15.0) / 15.0).max(1.0);
    let distance = |a: &[f64; 2], b: &[f64; 2]| ((a[0] - b[0]) / aspect).hypot(a[1] - b[1]);
    let worth = |m: &[f64; 2]| {
        let near =
            edge.iter().step_by(sample(edge.len())).map(|p| distance(p, m)).fold(f64::INFINITY, f64::min);
        near - 0.2 * (centre[0] - m[0]).hypot(centre[1] - m[1])
    };
    let best = tried.iter().copied().max_by(|a, b| worth(a).total_cmp(&worth(b)));
    let Some([x, y]) = best.filter(|m| m.iter().all(|v| drawable(*v))) else { return Ok(()) };
    let (x, y) = chart.backend_coord(&(x, y));
    let room = 2.0 * f64::from((x / UNITS).min(WIDTH - x / UNITS)) - 10.0;
    let pull = unit(body.body_force);
    let at = (x / UNITS, y / UNITS);
    Words::new(sheet::fitting(body.name, 15.0, room)).bold().write(area, body.name, at)?;
    if let Some(way) = pull {
        let way = [way[0], -way[1]];
        let from = (f64::from(x), f64::from(y) + 14.0 * f64::from(UNITS));
        let look = Look { colour: ORANGE, ..LOAD };
        arrow(area, from, way, way, ARROW, 0.0, &look)?;
    }
    Ok(())
}

fn description(bodies: &[SketchBody<'_>]) -> String {
    let mut text = "The bodies at rest.".to_owned();
    for body in bodies {
        let count = |held: Held| body.edges.iter().filter(|e| e.held == held).count();
        let loaded = body.edges.iter().filter(|e| e.traction != [0.0; 2]).count();
        let moved = body.edges.iter().filter(|e| e.displacement != [0.0; 2]).count();
        let parts = [
            (count(Held::Fixed), "held"),
            (count(Held::Roller), "held in one direction"),
            (moved, "with an imposed displacement"),
            (loaded, "loaded"),
        ];
        let parts: Vec<String> = parts
            .into_iter()
            .filter(|(n, _)| *n > 0)
            .map(|(n, what)| format!("{n} boundary edges {what}"))
            .collect();
        let parts = if parts.is_empty() { "nothing imposed".to_owned() } else { parts.join(", ") };
        let _ = write!(text, " {}: {} triangles; {parts}.", body.name, body.triangles.len());
        if body.body_force != [0.0; 2] {
            let _ = write!(text, " A body force acts on it (orange arrow).");
        }
    }
    text
}

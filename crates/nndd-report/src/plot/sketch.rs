//! The problem as it is given: bodies, supports, loads, obstacles and the contact line.

use super::axis::drawable;
use super::cells::{Cell, WITH_EDGES};
use super::colour::{BLUE, GREEN, GREY, INK, ORANGE, PALE_BLUE, VERMILLION};
use super::deformed::{equal_scale, extents, plane};
use super::labels::Labels;
use super::legend;
use super::look::{Look, Marker};
use super::names;
use super::obstacle::{self, OBSTACLE, ObstaclePicture};
use super::outline::outline;
use super::sheet::{self, FIRM, LEFT, MARGIN, PIXEL, Panel, RIGHT, SMALL, Sheet, WIDTH, path};
use fem_core::geometry::{Vector, norm, perpendicular};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// One body of [`sketch`].
pub(crate) struct SketchBody<'a> {
    /// Its name.
    pub(crate) name: &'a str,
    /// Its mesh.
    pub(crate) mesh: &'a TriMesh,
    /// The edges between two materials.
    pub(crate) materials: Vec<[Vector; 2]>,
    /// The edges of its cuts.
    pub(crate) cuts: Vec<[Vector; 2]>,
    /// The conditions on its boundary edges.
    pub(crate) edges: Vec<SketchEdge>,
    /// The body force on it; zero if there is no such force.
    pub(crate) body_force: Vector,
    /// The loads of its rigid sides.
    pub(crate) rigid: Vec<SketchLoad>,
}

/// The load of something rigid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SketchLoad {
    /// The place of the rigid side that is nearest to the point to which the load belongs.
    pub(crate) at: Vector,
    /// The outward unit normal there.
    pub(crate) normal: Vector,
    /// The force; zero: no force.
    pub(crate) force: Vector,
    /// The moment, counter-clockwise; zero: no moment.
    pub(crate) moment: f64,
}

/// The conditions on a boundary edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SketchEdge {
    /// Its two ends.
    pub(crate) ends: [Vector; 2],
    /// Its outward unit normal.
    pub(crate) normal: Vector,
    /// How it is held.
    pub(crate) held: Held,
    /// The displacement imposed on it, zero if it is only held.
    pub(crate) displacement: Vector,
    /// The load on it, force per length and thickness.
    pub(crate) traction: Vector,
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
    /// By a rigid side that is free to move.
    Rigid,
    /// By springs alone.
    Springs,
}

const FIXED: Look = Look::new("held", INK, 4.0 * PIXEL, Marker::None);
const ROLLER: Look = Look::new("held in one direction", GREY, PIXEL, Marker::Disc);
const RIGID: Look = Look::new("rigid side", INK, 7.0 * PIXEL, Marker::None);
const SPRINGS: Look = Look::new("springs", GREY, 2.0 * PIXEL, Marker::None);
const MOVED: Look = Look::new("imposed displacement", VERMILLION, 7.0, Marker::Triangle);
const LOAD: Look = Look::new("load", BLUE, 7.0, Marker::Triangle);
const BODY_FORCE: Look = Look::new("body force", ORANGE, 7.0, Marker::Triangle);
const MATERIALS: Look = Look::new("between materials", GREY, 1.5 * PIXEL, Marker::None).dashed("20 12");
const CUT: Look = Look::new("cut", VERMILLION, 3.0 * PIXEL, Marker::None).dashed("12 8");
const CONTACT: Look = Look::new("possible contact", GREEN, 4.0 * PIXEL, Marker::None);
/// Distance of two marks of a kind.
const APART: f64 = 17.0 * PIXEL;
/// Length of the longest arrow of a load, and of the shortest.
const ARROW: f64 = 30.0 * PIXEL;
const SHORT_ARROW: f64 = 9.0 * PIXEL;
/// Length of the arrow of an imposed displacement.
const MOVED_ARROW: f64 = 0.7 * ARROW;
/// Radius of the arrow of a moment.
const TURN: f64 = 9.0 * PIXEL;
/// Length and half the width of an arrow's head.
const HEAD: [f64; 2] = [6.0 * PIXEL, 3.5 * PIXEL];
/// Length of the hatches of a held side, and radius of the rollers.
const HATCH: f64 = 11.0 * PIXEL;
const ROLLER_RADIUS: f64 = 4.0 * PIXEL;
/// Room between a held side and an arrow.
const OFF: f64 = 12.0 * PIXEL;
/// Loads smaller than this part of the largest have no arrow.
const LEAST_LOAD: f64 = 0.05;
/// Room for the marks outside the bodies, as a part of their size.
const AROUND: f64 = 0.12;
/// Height of a panel over its width.
const RATIOS: [f64; 2] = [0.4, 1.2];

/// Draws the bodies at rest with how they are held, what is imposed, what is rigid, and where they may touch.
///
/// Arrows of tractions have a length in proportion to the traction. Arrows of imposed displacements all have the same
/// length, and so do the loads of rigid sides and obstacles.
pub(crate) fn sketch(
    title: &str,
    bodies: &[SketchBody<'_>],
    obstacles: &[ObstaclePicture<'_>],
    contact: &[[Vector; 2]],
    labels: &Labels,
) -> String {
    let points = || bodies.iter().flat_map(|b| b.mesh.points()).copied();
    let size = largest_extent(extents(points().filter(|p| p.iter().all(|v| drawable(*v)))));
    let lines: Vec<Vec<[Vector; 2]>> = obstacles.iter().map(|obstacle| obstacle.near(size)).collect();
    let points = points().chain(lines.iter().flatten().map(|[p, _]| *p));
    let known = extents(points.filter(|p| p.iter().all(|v| drawable(*v))));
    let edges = || bodies.iter().flat_map(|b| &b.edges);
    let largest = edges().map(|e| norm(e.traction)).filter(|l| l.is_finite()).fold(0.0, f64::max);
    let of_rigid = bodies.iter().flat_map(|b| &b.rigid).map(|load| (load.force, load.moment));
    let loads = || of_rigid.clone().chain(obstacles.iter().map(|o| o.load));
    let there = [
        (CONTACT, !contact.is_empty()),
        (MATERIALS, bodies.iter().any(|body| !body.materials.is_empty())),
        (CUT, bodies.iter().any(|body| !body.cuts.is_empty())),
        (FIXED, edges().any(|e| e.held == Held::Fixed)),
        (ROLLER, edges().any(|e| e.held == Held::Roller)),
        (SPRINGS, edges().any(|e| e.held == Held::Springs)),
        (RIGID, edges().any(|e| e.held == Held::Rigid)),
        (OBSTACLE, lines.iter().any(|line| !line.is_empty())),
        (
            MOVED,
            edges().any(|e| norm(e.displacement) > 0.0) || obstacles.iter().any(|o| norm(o.imposed) > 0.0),
        ),
        (BODY_FORCE, bodies.iter().any(|body| norm(body.body_force) > 0.0)),
        (LOAD, largest > 0.0 || loads().any(|(force, moment)| norm(force) > 0.0 || moment != 0.0)),
    ];
    let looks: Vec<Look> = there.into_iter().filter(|(_, there)| *there).map(|(look, _)| look).collect();
    let padded = known.map(|e| {
        let around = AROUND * largest_extent(Some(e));
        e.map(|(lo, hi)| (lo - around, hi + around))
    });
    let top = legend::end(&looks) + 8.0 * PIXEL;
    let (frame, axes) = equal_scale(padded, top, WIDTH - LEFT - RIGHT, RATIOS);
    let height = frame.bottom() + sheet::BELOW + MARGIN;
    let mut sheet = Sheet::new(height, title, &description(bodies, obstacles));
    legend::draw(&mut sheet, &looks);
    let panel = Panel { frame, axes: axes.each_ref() };
    panel.draw(&mut sheet, plane(labels).each_ref().map(String::as_str));
    bodies.iter().for_each(|body| shape(&mut sheet, &panel, body));
    lines.iter().for_each(|line| obstacle::hatched(&mut sheet, &panel, line));
    let contact: Vec<[Vector; 2]> = contact.iter().map(|edge| edge.map(|p| panel.place(p))).collect();
    sheet.stroke(&joined(&contact), CONTACT.colour, CONTACT.thickness);
    for body in bodies {
        marks(&mut sheet, &panel, body, largest);
        name(&mut sheet, &panel, body);
    }
    obstacles.iter().for_each(|obstacle| drive(&mut sheet, &panel, obstacle));
    if bodies.is_empty() {
        frame.remark(&mut sheet, "no data");
    }
    sheet.finished()
}

/// The larger of two extents.
fn largest_extent(extents: Option<[(f64, f64); 2]>) -> f64 {
    extents.into_iter().flatten().fold(0.0, |m, (lo, hi)| f64::max(m, hi - lo))
}

/// The body as one pale shape, with its cells if there are few.
fn shape(sheet: &mut Sheet, panel: &Panel<'_>, body: &SketchBody<'_>) {
    let mesh = body.mesh;
    let closed = |line: Vec<NodeId>| {
        let places: Vec<Vector> = line.iter().map(|v| panel.place(mesh.points()[*v])).collect();
        path(&places) + "z"
    };
    let lines: String = outline(mesh).into_iter().map(closed).collect();
    sheet.fill(&lines, PALE_BLUE);
    if mesh.cells().len() <= WITH_EDGES {
        let cell = |t| Cell { corners: mesh.corners(t).map(|p| panel.place(p)), value: 0.0 }.path();
        let cells: String = (0..mesh.cells().len()).map(cell).collect();
        sheet.stroke(&cells, "#FFFFFF", 2.0);
    }
    for (edges, look) in [(&body.materials, &MATERIALS), (&body.cuts, &CUT)] {
        let placed: Vec<[Vector; 2]> = edges.iter().map(|edge| edge.map(|p| panel.place(p))).collect();
        sheet.dashed(&joined(&placed), look.colour, look.thickness, look.dash);
    }
    sheet.stroke(&lines, INK, FIRM);
}

/// Joins edges that share an end to lines, for the attribute `d`: the corners of thick lines are then closed.
fn joined(edges: &[[Vector; 2]]) -> String {
    let key = |p: &Vector| [p[0] as i64, p[1] as i64];
    let mut around: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    let seen: Vec<usize> = (0..edges.len()).filter(|k| edges[*k][0] != edges[*k][1]).collect();
    for k in &seen {
        edges[*k].iter().for_each(|p| around.entry(key(p)).or_default().push(*k));
    }
    let mut used = vec![false; edges.len()];
    // The ends of open lines first.
    let (ends, others): (Vec<usize>, Vec<usize>) =
        seen.iter().partition(|k| edges[**k].iter().any(|p| around[&key(p)].len() == 1));
    let mut d = String::new();
    for first in ends.into_iter().chain(others) {
        if std::mem::replace(&mut used[first], true) {
            continue;
        }
        let [a, b] = edges[first];
        let mut line = if around[&key(&b)].len() == 1 { vec![b, a] } else { vec![a, b] };
        while let Some(last) = line.last().copied()
            && let Some(next) = around[&key(&last)].iter().copied().find(|k| !used[*k])
        {
            used[next] = true;
            line.push(if edges[next][0] == last { edges[next][1] } else { edges[next][0] });
        }
        d += &path(&line);
        if line.first() == line.last() {
            d.push('z');
        }
    }
    d
}

/// A direction of the plane on the sheet, on which downwards is positive.
fn flipped(v: Vector) -> Vector {
    Vector::new(v[0], -v[1])
}

fn marks(sheet: &mut Sheet, panel: &Panel<'_>, body: &SketchBody<'_>, largest: f64) {
    let (mut supports, mut moves, mut loads) = (Spaced::default(), Spaced::default(), Spaced::default());
    for (held, thickness) in [(Held::Fixed, 3.5 * PIXEL), (Held::Rigid, RIGID.thickness)] {
        let edges = body.edges.iter().filter(|edge| edge.held == held);
        let edges: Vec<[Vector; 2]> = edges.map(|edge| edge.ends.map(|p| panel.place(p))).collect();
        sheet.stroke(&joined(&edges), INK, thickness);
    }
    for edge in &body.edges {
        let [a, b] = edge.ends.map(|p| panel.place(p));
        let Some(out) = unit(flipped(edge.normal)) else { continue };
        let at = 0.5 * (a + b);
        if matches!(edge.held, Held::Fixed | Held::Roller) && supports.has_room(at) {
            if edge.ends[0] == edge.ends[1] && edge.held == Held::Fixed {
                // A single node: a triangle. Edges of fine meshes are no longer than a point on the sheet, too.
                let [base, half] = [at + HATCH * out, 0.5 * HATCH * perpendicular(out)];
                sheet.fill(&path(&[at, base + half, base - half]), INK);
            } else if edge.held == Held::Fixed {
                // A hatch: at 45 degrees to the side, outwards.
                let way = std::f64::consts::FRAC_1_SQRT_2 * (out + perpendicular(out));
                sheet.stroke(&path(&[at, at + HATCH * way]), INK, FIRM);
            } else {
                sheet.disc(at + (ROLLER_RADIUS + 1.5 * PIXEL) * out, ROLLER_RADIUS, GREY);
            }
        }
        if edge.held == Held::Springs && supports.has_room(at) {
            // A zigzag outwards.
            let [step, half] = [0.25 * HATCH * out, 0.25 * HATCH * perpendicular(out)];
            let zigzag =
                [at, at + step + half, at + 2.0 * step - half, at + 3.0 * step + half, at + 4.0 * step];
            sheet.stroke(&path(&zigzag), SPRINGS.colour, SPRINGS.thickness);
        }
        let off = if edge.held == Held::Free { 0.0 } else { OFF };
        if let Some(way) = unit(flipped(edge.displacement)).filter(|_| moves.has_room(at)) {
            arrow(sheet, at, way, out, MOVED_ARROW, off, &MOVED);
        }
        let size = norm(edge.traction);
        let way = unit(flipped(edge.traction)).filter(|_| size >= LEAST_LOAD * largest);
        if let Some(way) = way.filter(|_| loads.has_room(at)) {
            arrow(sheet, at, way, out, (ARROW * size / largest).max(SHORT_ARROW), off, &LOAD);
        }
    }
    for load in &body.rigid {
        push(sheet, panel.place(load.at), flipped(load.normal), (load.force, load.moment), RIGID.thickness);
    }
}

/// Draws what moves an obstacle.
fn drive(sheet: &mut Sheet, panel: &Panel<'_>, obstacle: &ObstaclePicture<'_>) {
    let [at, into] = obstacle.middle();
    if !at.iter().chain(&into).all(|v| drawable(*v)) {
        return;
    }
    let (at, out) = (panel.place(at), flipped(into));
    if let Some(way) = unit(flipped(obstacle.imposed)) {
        arrow(sheet, at, way, out, MOVED_ARROW, obstacle::HATCH, &MOVED);
    }
    push(sheet, at, out, obstacle.load, obstacle::HATCH);
}

/// Draws a force and a moment on something rigid; `off` is the room that it takes.
fn push(sheet: &mut Sheet, at: Vector, out: Vector, (force, moment): (Vector, f64), off: f64) {
    if let Some(way) = unit(flipped(force)) {
        arrow(sheet, at, way, out, ARROW, off, &LOAD);
    }
    if moment != 0.0 && moment.is_finite() {
        let [line, head] = obstacle::turning(at, TURN, moment > 0.0, HEAD);
        sheet.stroke(&path(&line), LOAD.colour, LOAD.thickness);
        sheet.fill(&path(&head), LOAD.colour);
    }
}

/// Draws an arrow that ends at a place if it points into the body, and begins there if it points out of it.
fn arrow(sheet: &mut Sheet, at: Vector, way: Vector, out: Vector, length: f64, off: f64, look: &Look) {
    let inwards = way.dot(&out) < -1e-9;
    let (from, to) = if inwards { (-off - length, -off - 2.0 * PIXEL) } else { (off, off + length) };
    let [tail, neck, tip] = [from, to - HEAD[0], to].map(|s| at + s * way);
    let half = HEAD[1] * perpendicular(way);
    sheet.stroke(&path(&[tail, neck]), look.colour, look.thickness);
    sheet.fill(&path(&[neck + half, tip, neck - half]), look.colour);
}

fn unit(v: Vector) -> Option<Vector> {
    let length = norm(v);
    (length > 0.0 && length.is_finite()).then(|| v / length)
}

/// Places of marks that keep their distance.
#[derive(Default)]
struct Spaced(Vec<Vector>);

impl Spaced {
    /// Takes the place of a mark if it is free, and tells if it was.
    fn has_room(&mut self, at: Vector) -> bool {
        let free = self.0.iter().all(|p| norm(*p - at) >= APART);
        if free {
            self.0.push(at);
        }
        free
    }
}

/// Writes the name of a body within it, with the arrow of its body force below it.
fn name(sheet: &mut Sheet, panel: &Panel<'_>, body: &SketchBody<'_>) {
    let places = body.mesh.points().iter();
    let places: Vec<_> = places.map(|p| p.iter().all(|v| drawable(*v)).then(|| panel.place(*p))).collect();
    let at = names::write(sheet, body.name, body.mesh, &places);
    if let Some((at, way)) = at.zip(unit(flipped(body.body_force))) {
        arrow(sheet, at + SMALL * Vector::y(), way, way, ARROW, 0.0, &BODY_FORCE);
    }
}

fn description(bodies: &[SketchBody<'_>], obstacles: &[ObstaclePicture<'_>]) -> String {
    let mut text = "The bodies at rest.".to_owned();
    for body in bodies {
        let count = |held: Held| body.edges.iter().filter(|e| e.held == held).count();
        let loaded = body.edges.iter().filter(|e| e.traction != Vector::zeros()).count();
        let moved = body.edges.iter().filter(|e| e.displacement != Vector::zeros()).count();
        let parts = [
            (count(Held::Fixed), "held"),
            (count(Held::Roller), "held in one direction"),
            (count(Held::Springs), "on springs"),
            (count(Held::Rigid), "of rigid sides that are free to move"),
            (moved, "with an imposed displacement"),
            (loaded, "loaded"),
        ];
        let parts: Vec<String> = parts
            .into_iter()
            .filter(|(n, _)| *n > 0)
            .map(|(n, what)| format!("{n} boundary edges {what}"))
            .collect();
        let parts = if parts.is_empty() { "nothing imposed".to_owned() } else { parts.join(", ") };
        let _ = write!(text, " {}: {} triangles; {parts}.", body.name, body.mesh.cells().len());
        if body.body_force != Vector::zeros() {
            let _ = write!(text, " A body force acts on it (orange arrow).");
        }
        if !body.cuts.is_empty() {
            let _ = write!(text, " A cut pulls it together (dashed red line).");
        }
    }
    match obstacles.len() {
        0 => {}
        1 => text.push_str(" A rigid obstacle (hatched line)."),
        n => _ = write!(text, " {n} rigid obstacles (hatched lines)."),
    }
    text
}

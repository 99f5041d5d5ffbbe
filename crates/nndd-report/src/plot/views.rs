//! Figures of solids: shaded views, drawn by [`crate::render`], on a sheet with title, legend, names, axes and colour bar.

use super::bands::{self, BANDS};
use super::colour::{self, BLUE, GREEN, GREY, INK, ORANGE, PALE_BLUE, VERMILLION};
use super::labels::Labels;
use super::legend;
use super::look::{Look, Marker};
use super::scale::{BAR, Quantity, Scale};
use super::sheet::{self, FIRM, Frame, MARGIN, PIXEL, SMALL, Sheet, TITLE, WIDTH, Words, path};
use crate::render::{self, Colour, Drawing, Scene, Vector, View, Window};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fem_core::geometry::Vector as Place;
use fem_core::parallel::each_task;

/// Room above a panel for its heading, and below it for its axes, in pixels.
const HEADING: f64 = 20.0;
const BELOW: f64 = 44.0;
/// Room between two panels, in pixels.
const BETWEEN: f64 = 10.0;
/// The greatest heights of a panel, in pixels: of one above another, and of one beside another.
const HIGHEST: [f64; 2] = [330.0, 400.0];
/// Panels that are higher than this part of their width are beside each other.
const HIGH: f64 = 0.8;
/// Room around what a panel shows, as a part of its size.
const ROOM: f64 = 1.05;
/// Length of an axis, and place of its letter, in pixels.
const AXIS: f64 = 20.0;
const LETTER: f64 = 28.0;
/// An axis that is seen shorter than this part of its length has no letter.
const SEEN: f64 = 0.15;
/// Size of names, in units of the sheet.
const NAME: f64 = 14.0 * PIXEL;
/// Radius of a mark.
const MARK: f64 = 6.0 * PIXEL;
/// Height of the line below the bar.
const REMARK: f64 = 16.0 * PIXEL;
/// Colours of bodies, which are few and pale, so that everything on them can be seen.
const BODIES: [&str; 6] = [PALE_BLUE, "#E9DDD0", "#DDE8D5", "#E4DAE8", "#D2E4E4", "#EAE6C8"];
/// A light line on dark colours.
const LIGHT: &str = "#FFFFFF";

/// Something that a legend explains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entry {
    /// A side in contact.
    Contact,
    /// A side that supports hold in all directions.
    Fixed,
    /// A side that supports hold in some directions.
    Held,
    /// A side that stays rigid.
    Rigid,
    /// A side on springs alone.
    Springs,
    /// A load.
    Load,
    /// An imposed displacement.
    Imposed,
    /// A rigid obstacle.
    Obstacle,
    /// A face without contact pressure.
    Open,
    /// The border of the faces that are closed at every node.
    Certain,
    /// The border of the faces that are closed at one node at least.
    Possible,
}

impl Entry {
    fn look(self) -> Look {
        const SWATCH: f64 = 10.0 * PIXEL;
        let swatch = |name, colour| Look::new(name, colour, SWATCH, Marker::None);
        let line = |name, colour| Look::new(name, colour, 2.0 * PIXEL, Marker::None);
        match self {
            Self::Contact => swatch("in contact", ORANGE),
            Self::Fixed => swatch("fixed", GREEN).dashed("12 8"),
            Self::Held => swatch("held in part", GREEN).dashed("4 12"),
            Self::Rigid => swatch("rigid", BLUE).dashed("12 8"),
            Self::Springs => swatch("springs", GREY).dashed("4 12"),
            Self::Load => line("load", VERMILLION),
            Self::Imposed => line("imposed displacement", BLUE),
            Self::Obstacle => line("obstacle", GREY),
            Self::Open => swatch("no pressure", PALE_BLUE),
            Self::Certain => line("closed at every node", INK),
            Self::Possible => line("at one at least", VERMILLION),
        }
    }

    /// Returns its colour.
    pub(crate) fn colour(self) -> Colour {
        colour::parts(self.look().colour)
    }

    /// Returns its two stripes.
    pub(crate) fn stripes(self) -> [Colour; 2] {
        let pale = match self {
            Self::Fixed => "#B5E3D3",
            Self::Rigid => "#C5DDEC",
            Self::Springs => "#E8E8E8",
            _ => "#E6F4EF",
        };
        [self.colour(), colour::parts(pale)]
    }
}

/// Lists the colours of the scale as style sheets write them.
pub(crate) fn scale_colours() -> Vec<String> {
    (0..BANDS).map(bands::colour_of).collect()
}

/// Returns the colour of a body, by its number.
pub(crate) fn of_body(body: usize) -> Colour {
    colour::parts(BODIES[body % BODIES.len()])
}

/// The colour of edges.
pub(crate) fn of_edges() -> Colour {
    colour::parts(INK)
}

/// One view of a figure.
pub(crate) struct Panel<'a> {
    pub(crate) heading: String,
    pub(crate) scene: &'a Scene,
    pub(crate) view: View,
    /// The points that must be in the picture; if the list is empty, all of the scene.
    pub(crate) focus: &'a [Vector],
    /// Points that a ring with a cross marks.
    pub(crate) marks: Vec<Vector>,
}

/// A figure of one or two views with a common scale.
pub(crate) struct Views<'a> {
    pub(crate) title: String,
    /// The alternative text.
    pub(crate) description: String,
    pub(crate) legend: &'a [Entry],
    pub(crate) panels: &'a [Panel<'a>],
    pub(crate) scale: Option<(&'a Scale, Quantity)>,
    /// The names of the bodies; the views show no names if the list is empty.
    pub(crate) names: &'a [&'a str],
}

/// Draws a figure of solids.
pub(crate) fn views(figure: &Views<'_>, labels: &Labels) -> String {
    let looks: Vec<Look> = figure.legend.iter().map(|entry| entry.look()).collect();
    let top = if looks.is_empty() { TITLE } else { legend::end(&looks) };
    let (windows, corners, bottom) = placed(figure.panels, top);
    let colours: Vec<Colour> = (0..BANDS).map(bands::parts_of).collect();
    let drawings: Vec<Drawing> = each_task(windows.len(), |k| {
        render::draw(figure.panels[k].scene, &windows[k], &colours, figure.names.len())
    });
    let remark = figure.scale.and_then(|(scale, _)| scale.remark()).map_or(0.0, |_| REMARK);
    let bar = if figure.scale.is_some() { sheet::BELOW + BAR + MARGIN + remark } else { 0.0 };
    let mut sheet = Sheet::new(bottom + bar + MARGIN, &figure.title, &figure.description);
    if !looks.is_empty() {
        legend::draw(&mut sheet, &looks);
    }
    for (k, (panel, window)) in figure.panels.iter().zip(&windows).enumerate() {
        let [left, top] = corners[k];
        let [width, height] = window.size.map(|n| n as f64 * PIXEL);
        Words::new(SMALL).grey().write(
            &mut sheet,
            &panel.heading,
            [left + 0.5 * width, top - 0.5 * HEADING * PIXEL],
        );
        sheet.add(&format!(
            "<image x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{}\"/>",
            STANDARD.encode(&drawings[k].png)
        ));
        axes(&mut sheet, &panel.view, [left + 30.0 * PIXEL, top + height + (BELOW - 12.0) * PIXEL]);
        let on_sheet = |at: [f64; 2]| Place::new(left + PIXEL * at[0], top + PIXEL * at[1]);
        for mark in &panel.marks {
            let [x, y, _] = window.place(*mark);
            cross(&mut sheet, on_sheet([x, y]));
        }
        if k == 0 || figure.panels.iter().all(|panel| panel.marks.is_empty()) {
            names(&mut sheet, figure.names, &drawings[k].places, on_sheet);
        }
    }
    if let Some((scale, quantity)) = figure.scale {
        let frame = Frame { height: bottom - sheet::BELOW - top, ..Frame::wide(top, 0.0) };
        scale.bar(&mut sheet, frame, quantity, labels);
    }
    sheet.finished()
}

/// Chooses the windows of panels, their upper left corners on the sheet, and the height at which they end.
fn placed(panels: &[Panel<'_>], top: f64) -> (Vec<Window>, Vec<[f64; 2]>, f64) {
    let extents: Vec<[[f64; 2]; 2]> = panels
        .iter()
        .map(|panel| {
            let found = match panel.focus {
                [] => panel.view.extents(panel.scene.points()),
                focus => panel.view.extents(focus.iter().copied()),
            };
            found.unwrap_or([[0.0, 1.0]; 2])
        })
        .collect();
    let largest = |c: usize| extents.iter().map(|e| e[c][1] - e[c][0]).fold(0.0, f64::max);
    let [wide, high] = [0, 1].map(|c| ROOM * largest(c));
    let are_beside = panels.len() > 1 && high > HIGH * wide;
    let room = WIDTH / PIXEL - 2.0 * MARGIN / PIXEL;
    let width = if are_beside { (0.5 * (room - BETWEEN)).floor() } else { room };
    let pixel = (wide / width).max(high / HIGHEST[usize::from(are_beside)]);
    let pixel = if pixel.is_normal() { pixel } else { 1.0 };
    let height = (high / pixel).ceil().max(60.0);
    let (mut windows, mut corners, mut end) = (Vec::new(), Vec::new(), top);
    for (k, (panel, extents)) in panels.iter().zip(&extents).enumerate() {
        let middle = extents.map(|[low, high]| 0.5 * (low + high));
        let size = [width as usize, height as usize];
        windows.push(Window { view: panel.view, middle, pixel, size });
        let place = if are_beside { [k, 0] } else { [0, k] };
        let left = MARGIN + place[0] as f64 * (width + BETWEEN) * PIXEL;
        let upper = top + (HEADING + place[1] as f64 * (HEADING + height + BELOW)) * PIXEL;
        corners.push([left, upper]);
        end = upper + (height + BELOW) * PIXEL;
    }
    (windows, corners, end)
}

/// Draws the directions of the axes.
fn axes(sheet: &mut Sheet, view: &View, at: [f64; 2]) {
    let from = Place::from(at);
    for (axis, letter) in [Vector::x(), Vector::y(), Vector::z()].into_iter().zip(["x", "y", "z"]) {
        let [right, up, _] = view.seen(axis);
        let seen = Place::new(right, -up);
        if seen.norm() < SEEN {
            continue;
        }
        sheet.stroke(&path(&[from, from + AXIS * PIXEL * seen]), GREY, FIRM);
        let beyond = LETTER * PIXEL * seen.norm().max(0.5) / seen.norm();
        Words::new(0.85 * SMALL).grey().write(sheet, letter, from + beyond * seen);
    }
}

/// Marks a point by a ring with a cross, dark on a light ground.
fn cross(sheet: &mut Sheet, at: Place) {
    let arm = 1.6 * MARK;
    let arms = [Place::x(), Place::y()].map(|axis| path(&[at - arm * axis, at + arm * axis])).concat();
    for (colour, width) in [(LIGHT, 3.0 * FIRM), (INK, FIRM)] {
        sheet.stroke(&arms, colour, width);
        sheet.ring(at, MARK, colour, width);
    }
}

/// Writes the names of bodies; one that another would cover moves down.
fn names(
    sheet: &mut Sheet,
    names: &[&str],
    places: &[Option<[f64; 2]>],
    on_sheet: impl Fn([f64; 2]) -> Place,
) {
    let mut written: Vec<(Place, f64)> = Vec::new();
    for (name, place) in names.iter().zip(places) {
        let Some(mut at) = place.map(&on_sheet) else { continue };
        let half = 0.5 * sheet::width_of(name, NAME);
        at[0] = at[0].clamp((MARGIN + half).min(0.5 * WIDTH), (WIDTH - MARGIN - half).max(0.5 * WIDTH));
        let covers = |at: &Place, (other, width): &(Place, f64)| {
            (at[1] - other[1]).abs() < 1.1 * NAME && (at[0] - other[0]).abs() < half + width
        };
        for _ in 0..names.len() {
            if written.iter().any(|other| covers(&at, other)) {
                at[1] += 1.1 * NAME;
            }
        }
        Words::new(NAME).bold().with_halo().write(sheet, name, at);
        written.push((at, half));
    }
}

/// The thickness of edges, in pixels.
pub(crate) const OUTLINE: f64 = 1.25;

//! The sheet a figure is drawn on, as SVG text: size, alternative text, shapes, words, panels with axes.
//!
//! Lengths are in units of a quarter of a pixel, so that coordinates are whole numbers in the file.

use super::axis::Axis;
use super::colour::{GREY, INK};
use crate::words::{escaped, one_line};
use fem_core::geometry::{Vector, norm};
use std::fmt::Write as _;

/// Units of a pixel.
pub(super) const PIXEL: f64 = 4.0;
/// Width of every figure: narrow, so that its words can still be read on a telephone.
pub(super) const WIDTH: f64 = 480.0 * PIXEL;
/// Room at the edges of the sheet that stays free.
pub(super) const MARGIN: f64 = 10.0 * PIXEL;
/// Room left of a panel for the labels of its vertical axis.
pub(super) const LEFT: f64 = 76.0 * PIXEL;
/// Room below a panel for the labels of its horizontal axis.
pub(super) const BELOW: f64 = 52.0 * PIXEL;
/// Room right of the panels.
pub(super) const RIGHT: f64 = 18.0 * PIXEL;
/// Room above everything for the title, of two lines at most.
pub(super) const TITLE: f64 = 50.0 * PIXEL;
/// Size of the words beside axes and in legends.
pub(super) const SMALL: f64 = 14.0 * PIXEL;
/// Thickness of axes and outlines, and of finer lines.
pub(super) const FIRM: f64 = 1.25 * PIXEL;
pub(super) const FINE: f64 = 0.75 * PIXEL;
/// Opacity of a grid's lines, without and with a label.
const OPACITIES: [(bool, f64); 2] = [(false, 0.06), (true, 0.16)];
/// Size of the title, and the distance of its lines.
const LARGE: f64 = 16.0 * PIXEL;
const LINE: f64 = 18.0 * PIXEL;
/// The smallest size of words that are made to fit.
const SMALLEST: f64 = 9.0 * PIXEL;
/// Width of a letter, on average, as a part of its size.
const LETTER: f64 = 0.54;
/// Length of a tick, and the distances of its label and of the axis label from a vertical and a horizontal axis.
const TICK: f64 = 5.0 * PIXEL;
const TICK_LABEL: [f64; 2] = [8.0 * PIXEL, 16.0 * PIXEL];
const AXIS_LABEL: [f64; 2] = [LEFT - 12.0 * PIXEL, 40.0 * PIXEL];

/// A figure that is being drawn.
pub(super) struct Sheet(String);

impl Sheet {
    /// An empty sheet; `title` and `description` become the alternative text, and the title is written at the top.
    pub(super) fn new(height: f64, title: &str, description: &str) -> Sheet {
        let (height, pixels) = (height.round(), (height / PIXEL).round());
        let (name, text) = (escaped(&one_line(title)), escaped(&one_line(description)));
        let mut sheet = Sheet(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{pixels}\" viewBox=\"0 0 {WIDTH} {height}\" \
             font-family=\"sans-serif\" stroke-linejoin=\"round\" role=\"img\" aria-label=\"{name}\">\n<title>{name}</title>\n<desc>{text}</desc>\n\
             <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#FFFFFF\"/>\n",
            WIDTH / PIXEL
        ));
        let lines = two_lines(title, ((WIDTH - 2.0 * MARGIN) / (LETTER * LARGE)) as usize);
        for (k, line) in lines.iter().enumerate() {
            let size = fitting(line, LARGE, WIDTH - 2.0 * MARGIN);
            let y = 0.5 * TITLE + LINE * (k as f64 - 0.5 * (lines.len() - 1) as f64);
            Words::new(size).bold().write(&mut sheet, line, [0.5 * WIDTH, y]);
        }
        sheet
    }

    /// The whole SVG document.
    pub(super) fn finished(self) -> String {
        self.0 + "</svg>\n"
    }

    /// Adds SVG elements.
    pub(super) fn add(&mut self, elements: &str) {
        self.0.push_str(elements);
        self.0.push('\n');
    }

    /// Fills a path.
    pub(super) fn fill(&mut self, d: &str, colour: &str) {
        self.add(&format!("<path d=\"{d}\" fill=\"{colour}\" fill-rule=\"evenodd\"/>"));
    }

    /// Draws the line of a path.
    pub(super) fn stroke(&mut self, d: &str, colour: &str, thickness: f64) {
        self.dashed(d, colour, thickness, "");
    }

    /// Draws the line of a path in dashes.
    pub(super) fn dashed(&mut self, d: &str, colour: &str, thickness: f64, dash: &str) {
        if d.is_empty() {
            return;
        }
        let dash = if dash.is_empty() { "".into() } else { format!(" stroke-dasharray=\"{dash}\"") };
        self.add(&format!(
            "<path d=\"{d}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{thickness}\"{dash}/>"
        ));
    }

    /// Draws a filled disc.
    pub(super) fn disc(&mut self, at: Vector, radius: f64, colour: &str) {
        let [x, y] = at.into();
        self.add(&format!("<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{radius}\" fill=\"{colour}\"/>"));
    }

    /// Draws a ring.
    pub(super) fn ring(&mut self, at: Vector, radius: f64, colour: &str, thickness: f64) {
        let [x, y] = at.into();
        self.add(&format!(
            "<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{radius}\" fill=\"none\" stroke=\"{colour}\" \
             stroke-width=\"{thickness}\"/>"
        ));
    }

    /// Draws an axis from one place to another, with its labels left of it if it is vertical, and below it otherwise.
    pub(super) fn axis(&mut self, axis: &Axis, from: impl Into<Vector>, to: impl Into<Vector>, label: &str) {
        let (from, to): (Vector, Vector) = (from.into(), to.into());
        let vertical = from[0] == to[0];
        let (out, k) = if vertical { (-Vector::x(), 0) } else { (Vector::y(), 1) };
        let mut lines = path(&[from, to]);
        let words = Words::new(SMALL);
        let beside = if vertical { words.flush_right() } else { words };
        for (value, text) in axis.major() {
            let at = from + axis.position(*value) * (to - from);
            lines += &path(&[at, at + TICK * out]);
            beside.write(self, text, at + TICK_LABEL[k] * out);
        }
        self.stroke(&lines, INK, FIRM);
        let at = 0.5 * (from + to) + AXIS_LABEL[k] * out;
        let room = if vertical { norm(to - from) } else { 2.0 * (at[0].min(WIDTH - at[0]) - MARGIN) };
        let words = Words::new(fitting(label, SMALL, room));
        (if vertical { words.upright() } else { words }).write(self, label, at);
    }
}

/// A line through some points, for the attribute `d`.
pub(super) fn path<P: Into<Vector> + Copy>(points: &[P]) -> String {
    let mut d = String::new();
    for (k, point) in points.iter().enumerate() {
        let [x, y] = (*point).into().into();
        let _ = write!(d, "{}{x:.0} {y:.0}", ["M", "L", " "][k.min(2)]);
    }
    d
}

/// A rectangle, for the attribute `d`.
pub(super) fn rectangle(x: [f64; 2], y: [f64; 2]) -> String {
    format!("M{:.0} {:.0}H{:.0}V{:.0}H{:.0}z", x[0], y[0], x[1], y[1], x[0])
}

/// An estimate of the width of a text.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    LETTER * size * text.chars().count() as f64
}

/// The size, not above `size` and not below the smallest, at which a text fits the width.
pub(super) fn fitting(text: &str, size: f64, width: f64) -> f64 {
    let estimate = width_of(text, size);
    if estimate <= width { size } else { (size * width / estimate).max(SMALLEST).floor() }
}

/// A text cut to the letters that fit the width.
pub(super) fn cut(text: &str, size: f64, width: f64) -> String {
    let letters = (width / (LETTER * size)).max(1.0) as usize;
    if text.chars().count() <= letters {
        return text.to_owned();
    }
    text.chars().take(letters - 1).chain(['…']).collect()
}

/// How to write a text.
#[derive(Clone, Copy)]
pub(super) struct Words {
    size: f64,
    bold: bool,
    upright: bool,
    halo: bool,
    colour: &'static str,
    anchor: &'static str,
}

impl Words {
    /// Centred dark text of this size.
    pub(super) fn new(size: f64) -> Words {
        Words { size, bold: false, upright: false, halo: false, colour: INK, anchor: "middle" }
    }
    /// The same in bold.
    pub(super) fn bold(self) -> Words {
        Words { bold: true, ..self }
    }
    /// The same with a light line around the letters, to be read on any colour.
    pub(super) fn with_halo(self) -> Words {
        Words { halo: true, ..self }
    }
    /// The same starting at the given place.
    pub(super) fn flush_left(self) -> Words {
        Words { anchor: "start", ..self }
    }
    /// The same ending at the given place.
    pub(super) fn flush_right(self) -> Words {
        Words { anchor: "end", ..self }
    }
    /// The same upwards.
    fn upright(self) -> Words {
        Words { upright: true, ..self }
    }
    /// The same in grey.
    pub(super) fn grey(self) -> Words {
        Words { colour: GREY, ..self }
    }

    /// Writes a text whose vertical middle is at `at`; what does not fit the sheet is cut.
    pub(super) fn write(self, sheet: &mut Sheet, text: &str, at: impl Into<Vector>) {
        let Words { size, colour, anchor, .. } = self;
        let [x, y] = at.into().into();
        let room = match anchor {
            _ if self.upright => f64::INFINITY,
            "middle" => 2.0 * x.min(WIDTH - x),
            "end" => x,
            _ => WIDTH - x,
        };
        let text = escaped(&cut(&one_line(text), size, room));
        let halo = match self.halo {
            true => format!(" stroke=\"#FFFFFF\" stroke-width=\"{}\" paint-order=\"stroke\"", 0.28 * size),
            false => String::new(),
        };
        let bold = if self.bold { " font-weight=\"bold\"" } else { "" };
        let turn =
            if self.upright { format!(" transform=\"rotate(-90 {x:.0} {y:.0})\"") } else { String::new() };
        sheet.add(&format!(
            "<text x=\"{x:.0}\" y=\"{y:.0}\" dy=\".35em\" text-anchor=\"{anchor}\" font-size=\"{size}\" \
             fill=\"{colour}\"{halo}{bold}{turn}>{text}</text>"
        ));
    }
}

/// The rectangle of a panel in which its data are drawn; labels are outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Frame {
    /// A frame of the full width.
    pub(super) fn wide(top: f64, height: f64) -> Frame {
        Frame { left: LEFT, top, width: WIDTH - LEFT - RIGHT, height }
    }
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }
    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }
    /// Writes a remark in its middle.
    pub(super) fn remark(&self, sheet: &mut Sheet, text: &str) {
        let middle = [self.left + 0.5 * self.width, self.top + 0.5 * self.height];
        Words::new(SMALL).grey().write(sheet, text, middle);
    }
}

/// A frame with its two axes.
pub(super) struct Panel<'a> {
    pub(super) frame: Frame,
    pub(super) axes: [&'a Axis; 2],
}

impl Panel<'_> {
    /// Maps a point to the sheet, rounded to whole units.
    pub(super) fn place(&self, p: impl Into<Vector>) -> Vector {
        let p = p.into();
        let (f, [x, y]) = (self.frame, self.axes);
        Vector::new(f.left + f.width * x.position(p[0]), f.bottom() - f.height * y.position(p[1]))
            .map(f64::round)
    }

    /// Draws the axes with their labels.
    pub(super) fn draw(&self, sheet: &mut Sheet, labels: [&str; 2]) {
        let (f, [x, y]) = (self.frame, self.axes);
        let corner = [f.left, f.bottom()];
        sheet.axis(x, corner, [f.right(), f.bottom()], labels[0]);
        sheet.axis(y, corner, [f.left, f.top], labels[1]);
    }

    /// Draws a grid behind the data.
    pub(super) fn grid(&self, sheet: &mut Sheet) {
        let (f, [x, y]) = (self.frame, self.axes);
        for (major, opacity) in OPACITIES {
            let upright = x.positions(major).into_iter().map(|t| f.left + t * f.width);
            let level = y.positions(major).into_iter().map(|t| f.bottom() - t * f.height);
            let upright = upright.map(|x| path(&[[x, f.top], [x, f.bottom()]]));
            let level = level.map(|y| path(&[[f.left, y], [f.right(), y]]));
            let lines: String = upright.chain(level).collect();
            sheet.add(&format!(
                "<path d=\"{lines}\" stroke=\"{INK}\" stroke-opacity=\"{opacity}\" stroke-width=\"{FINE}\"/>"
            ));
        }
    }
}

/// Breaks a text at a space into two lines if it has more letters than fit.
fn two_lines(text: &str, letters: usize) -> Vec<&str> {
    if text.chars().count() <= letters {
        return vec![text];
    }
    let uneven = |at: usize| text[..at].chars().count().abs_diff(text[at..].chars().count());
    // After a colon, which is between the name and what is shown, or else near the middle.
    let at = text
        .find(": ")
        .map(|at| at + 1)
        .or_else(|| text.match_indices(' ').map(|(at, _)| at).min_by_key(|at| uneven(*at)));
    match at {
        Some(at) => vec![&text[..at], text[at..].trim_start()],
        None => vec![text],
    }
}

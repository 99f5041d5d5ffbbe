//! The sheet a figure is drawn on: size, alternative text, words, panels with axes.

use super::PlotError;
use super::axis::Axis;
use super::colour::{GREY, INK};
use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::prelude::SVGBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBColor, TextStyle};

/// Drawing units per pixel: the drawing library rounds coordinates to whole units.
pub(super) const UNITS: i32 = 4;
/// Width of every figure in pixels: narrow, so that its words can still be read on a telephone.
pub(super) const WIDTH: i32 = 480;
/// Room left of a panel for the labels of its vertical axis.
pub(super) const LEFT: i32 = 76;
/// Room below a panel for the labels of its horizontal axis.
pub(super) const BELOW: i32 = 52;
/// Room right of the panels.
pub(super) const RIGHT: i32 = 18;
/// Room above everything for the title, of two lines at most.
pub(super) const TITLE: i32 = 50;
/// Size of the words beside axes and in legends.
pub(super) const SMALL: f64 = 14.0;

/// What everything is drawn on.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// A panel with its two axes.
pub(super) type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

/// Draws a figure of `WIDTH` by `height` pixels.
///
/// `paint` draws on the area, in units, and returns SVG elements to lie below everything it drew. `title`
/// and `description` become the alternative text; the title is also written at the top.
pub(super) fn figure(
    height: i32,
    title: &str,
    description: &str,
    paint: impl FnOnce(&Area<'_>) -> Result<String, PlotError>,
) -> Result<String, PlotError> {
    let (w, h) = (WIDTH * UNITS, height * UNITS);
    let mut drawn = String::new();
    let below = {
        let root = SVGBackend::with_string(&mut drawn, (w as u32, h as u32)).into_drawing_area();
        let lines = two_lines(title, f64::from(WIDTH - 20) / (0.54 * 16.0));
        for (k, line) in lines.iter().enumerate() {
            let size = fitting(line, 16.0, f64::from(WIDTH - 20));
            let y = TITLE / 2 - 9 * (lines.len() as i32 - 1) + 18 * k as i32;
            Words::new(size).bold().write(&root, line, (WIDTH / 2, y))?;
        }
        let below = paint(&root)?;
        root.present()?;
        below
    };
    let inner = drawn.split_once(">\n").map_or("", |(_, rest)| rest);
    let (title, description) = (escaped(title), escaped(description));
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {w} {h}\" \
         role=\"img\" aria-label=\"{title}\">\n<title>{title}</title>\n<desc>{description}</desc>\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#FFFFFF\"/>\n{below}{inner}"
    ))
}

/// Text with XML's special characters replaced and those XML forbids turned into spaces.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in clean(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            other => out.push(other),
        }
    }
    out
}

fn clean(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() || matches!(c, '\u{FFFE}' | '\u{FFFF}') { ' ' } else { c })
        .collect()
}

/// An estimate of the width of a text, in pixels.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    0.54 * size * text.chars().count() as f64
}

/// The size, not above `size` and not below 9, at which a text fits the width.
pub(super) fn fitting(text: &str, size: f64, width: f64) -> f64 {
    let estimate = width_of(text, size);
    if estimate <= width { size } else { (size * width / estimate).max(9.0) }
}

/// How to write a text.
#[derive(Clone, Copy)]
pub(super) struct Words {
    size: f64,
    bold: bool,
    colour: RGBColor,
    anchor: HPos,
}

impl Words {
    /// Centred dark text of this size in pixels.
    pub(super) fn new(size: f64) -> Words {
        Words { size, bold: false, colour: INK, anchor: HPos::Center }
    }
    /// The same in bold.
    pub(super) fn bold(self) -> Words {
        Words { bold: true, ..self }
    }
    /// The same starting at the given place.
    pub(super) fn flush_left(self) -> Words {
        Words { anchor: HPos::Left, ..self }
    }
    /// The same in grey.
    pub(super) fn grey(self) -> Words {
        Words { colour: GREY, ..self }
    }

    fn style(self) -> TextStyle<'static> {
        // The library divides the size by 1.24 before it writes it.
        let style = if self.bold { FontStyle::Bold } else { FontStyle::Normal };
        let font = ("sans-serif", self.size * 1.24 * f64::from(UNITS), style).into_font();
        let mut style = TextStyle::from(font).pos(Pos::new(self.anchor, VPos::Center));
        style.color = self.colour.to_backend_color();
        style
    }

    /// Writes a text whose vertical middle is at `at`, in pixels; what does not fit the sheet is cut.
    pub(super) fn write(self, area: &Area<'_>, text: &str, at: (i32, i32)) -> Result<(), PlotError> {
        let text = clean(text);
        let room = match self.anchor {
            HPos::Center => 2 * at.0.min(WIDTH - at.0),
            _ => WIDTH - at.0,
        };
        let letters = (f64::from(room) / (0.54 * self.size)).max(1.0) as usize;
        let text = if text.chars().count() <= letters {
            text
        } else {
            text.chars().take(letters.saturating_sub(1)).chain(['…']).collect()
        };
        Ok(area.draw_text(&text, &self.style(), (at.0 * UNITS, at.1 * UNITS))?)
    }
}

/// A rectangle of the sheet, in pixels: where the data of a panel go, labels outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) width: i32,
    pub(super) height: i32,
}

impl Frame {
    /// A frame of the full width.
    pub(super) fn wide(top: i32, height: i32) -> Frame {
        Frame { left: LEFT, top, width: WIDTH - LEFT - RIGHT, height }
    }
}

/// The labels of the axes of a panel.
pub(super) struct Labels<'a> {
    pub(super) x: &'a str,
    pub(super) y: &'a str,
    pub(super) grid: bool,
}

/// Draws the axes of a panel, with labels on the left and below.
pub(super) fn panel<'b>(
    area: &Area<'b>,
    frame: Frame,
    (x, y): (Axis, Axis),
    labels: &Labels<'_>,
) -> Result<Chart<'b, 'b>, PlotError> {
    let outer = area.clone().shrink(
        ((frame.left - LEFT) * UNITS, frame.top * UNITS),
        ((frame.width + LEFT) * UNITS, (frame.height + BELOW) * UNITS),
    );
    let mut chart = ChartBuilder::on(&outer)
        .set_label_area_size(LabelAreaPosition::Left, LEFT * UNITS)
        .set_label_area_size(LabelAreaPosition::Bottom, BELOW * UNITS)
        .build_cartesian_2d(x, y)?;
    let words = Words::new(SMALL);
    let mut mesh = chart.configure_mesh();
    mesh.label_style(words.style())
        .axis_style(INK.stroke_width(5))
        .bold_line_style(INK.mix(0.16).stroke_width(3))
        .light_line_style(INK.mix(0.06).stroke_width(3))
        .set_all_tick_mark_size(5 * UNITS);
    if !labels.grid {
        mesh.disable_mesh();
    }
    mesh.draw()?;
    let (middle, below) = (frame.left + frame.width / 2, frame.top + frame.height + 40);
    Words::new(fitting(labels.x, SMALL, f64::from(frame.width))).write(area, labels.x, (middle, below))?;
    upright(area, labels.y, (frame.left - LEFT + 15, frame.top + frame.height / 2), frame.height)?;
    Ok(chart)
}

/// Writes a text upwards, its middle at `at`, within a height.
fn upright(area: &Area<'_>, text: &str, at: (i32, i32), height: i32) -> Result<(), PlotError> {
    let style =
        Words::new(fitting(text, SMALL, f64::from(height))).style().transform(FontTransform::Rotate270);
    Ok(area.draw_text(&clean(text), &style, (at.0 * UNITS, at.1 * UNITS))?)
}

/// Draws the axis of a lying colour bar, labels below.
pub(super) fn bar<'b>(
    area: &Area<'b>,
    frame: Frame,
    axis: Axis,
    label: &str,
) -> Result<Chart<'b, 'b>, PlotError> {
    let outer = area.clone().shrink(
        (frame.left * UNITS, frame.top * UNITS),
        (frame.width * UNITS, (frame.height + BELOW) * UNITS),
    );
    let mut chart = ChartBuilder::on(&outer)
        .set_label_area_size(LabelAreaPosition::Bottom, BELOW * UNITS)
        .build_cartesian_2d(axis, Axis::linear(0.0, 1.0, 1))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_y_axis()
        .label_style(Words::new(SMALL).style())
        .axis_style(INK.stroke_width(4))
        .set_all_tick_mark_size(4 * UNITS)
        .draw()?;
    let middle = (frame.left + frame.width / 2, frame.top + frame.height + 40);
    Words::new(fitting(label, SMALL, f64::from(WIDTH - 20))).write(area, label, middle)?;
    Ok(chart)
}

/// Says in the middle of a panel that there is nothing to draw.
pub(super) fn no_data(area: &Area<'_>, frame: Frame) -> Result<(), PlotError> {
    let middle = (frame.left + frame.width / 2, frame.top + frame.height / 2);
    Words::new(18.0).grey().write(area, "no data", middle)
}

/// Breaks a text at a space into two lines if it has more letters than fit.
fn two_lines(text: &str, letters: f64) -> Vec<&str> {
    if text.chars().count() as f64 <= letters {
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

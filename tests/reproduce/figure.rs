//! Lines on two logarithmic axes, as SVG.

use plotters::prelude::*;
use std::error::Error;

/// A line: its name and its points.
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 0, 0), RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// Width and height in pixels: narrow, so that the words can be read on a telephone.
const SIZE: (u32, u32) = (520, 460);

/// Draws lines with markers, and through the last point of each a thin one of the given slope.
pub(crate) fn log_log(
    title: &str,
    labels: [&str; 2],
    lines: &[(Line, f64)],
) -> Result<String, Box<dyn Error>> {
    let all = || lines.iter().flat_map(|(l, _)| l.points.iter().copied());
    let range =
        |v: &mut dyn Iterator<Item = f64>| v.fold((f64::MAX, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
    let (x0, x1) = range(&mut all().map(|p| p.0));
    let (y0, y1) = range(&mut all().map(|p| p.1));
    if !(x0 > 0.0 && y0 > 0.0 && x1.is_finite() && y1.is_finite()) {
        return Err(format!("{title}: points that cannot be drawn on logarithmic axes").into());
    }
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            // The part of the title after a colon is in the alternative text only.
            .caption(title.split(": ").next().unwrap_or(title), ("sans-serif", 20))
            .margin(10)
            .x_label_area_size(56)
            .y_label_area_size(72)
            .build_cartesian_2d((0.8 * x0..1.25 * x1).log_scale(), (0.8 * y0..1.25 * y1).log_scale())?;
        chart
            .configure_mesh()
            .label_style(("sans-serif", 17))
            .axis_desc_style(("sans-serif", 17))
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_label_formatter(&|x| grouped(*x))
            .y_label_formatter(&|y| per_cent(*y))
            .x_desc(labels[0])
            .y_desc(labels[1])
            .draw()?;
        for (k, (line, slope)) in lines.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let points = || line.points.iter().copied();
            // Series differ by their markers as well as by colour.
            chart
                .draw_series(LineSeries::new(points(), colour.stroke_width(2)))?
                .label(line.name.as_str())
                .legend(move |(x, y)| {
                    EmptyElement::at((x, y))
                        + PathElement::new([(0, 0), (22, 0)], colour.stroke_width(2))
                        + Circle::new((11, 0), if k % 2 == 0 { 5 } else { 0 }, colour.filled())
                        + TriangleMarker::new((11, 0), if k % 2 == 0 { 0 } else { 7 }, colour.filled())
                });
            match k % 2 {
                0 => chart.draw_series(points().map(|p| Circle::new(p, 5, colour.filled())))?,
                _ => chart.draw_series(points().map(|p| TriangleMarker::new(p, 7, colour.filled())))?,
            };
            if let (Some(first), Some(last)) = (line.points.first(), line.points.last()) {
                let start = (first.0, last.1 * (first.0 / last.0).powf(*slope));
                chart.draw_series(LineSeries::new([start, *last], colour.mix(0.35)))?;
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .label_font(("sans-serif", 17))
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        area.present()?;
    }
    let names: Vec<&str> = lines.iter().map(|(line, _)| line.name.as_str()).collect();
    let description = format!(
        "{} against {}, both logarithmic: {}; thin lines have the best slope.",
        labels[1],
        labels[0],
        names.join(", ")
    );
    let Some((head, body)) = svg.split_once(">\n") else { return Err("the drawing is no SVG".into()) };
    Ok(format!(
        "{head} role=\"img\" aria-label=\"{title}\">\n<title>{title}</title>\n<desc>{description}</desc>\n{body}"
    ))
}

/// Writes a count with its thousands apart.
fn grouped(x: f64) -> String {
    let digits = format!("{x:.0}");
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|c| std::str::from_utf8(c).ok()).collect();
    groups.join(",")
}

/// Writes a share in per cent, if it is 1, 2 or 5 times a power of ten: more would not fit beside each other.
fn per_cent(share: f64) -> String {
    let written = format!("{:.0e}", 100.0 * share);
    match written.as_bytes().first() {
        Some(b'1' | b'2' | b'5') => written.parse().map_or_else(|_| String::new(), |x: f64| format!("{x} %")),
        _ => String::new(),
    }
}

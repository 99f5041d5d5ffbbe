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
        return Err(format!("{title}: points that cannot stand on logarithmic axes").into());
    }
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (760, 520)).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d((0.8 * x0..1.25 * x1).log_scale(), (0.8 * y0..1.25 * y1).log_scale())?;
        chart.configure_mesh().x_desc(labels[0]).y_desc(labels[1]).draw()?;
        for (k, (line, slope)) in lines.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let points = || line.points.iter().copied();
            chart
                .draw_series(LineSeries::new(points(), colour.stroke_width(2)))?
                .label(line.name.as_str())
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
            chart.draw_series(points().map(|p| Circle::new(p, 3, colour.filled())))?;
            if let (Some(first), Some(last)) = (line.points.first(), line.points.last()) {
                let start = (first.0, last.1 * (first.0 / last.0).powf(*slope));
                chart.draw_series(LineSeries::new([start, *last], colour.mix(0.35)))?;
            }
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        area.present()?;
    }
    Ok(svg)
}

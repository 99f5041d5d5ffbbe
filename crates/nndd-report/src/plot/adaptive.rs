//! The certified relative error against the number of nodes, with the best rate of linear triangles.

use super::PlotError;
use super::axis::{drawable_log, short};
use super::colour::{GREY, INK, VERMILLION};
use super::legend;
use super::look::{Look, Marker};
use super::series::{self, Series};
use super::sheet::{self, Frame, Labels, TITLE};

const ERROR: Look =
    Look { name: "certified relative error", colour: INK, dash: None, marker: Marker::Disc, thickness: 8 };
const RATE: Look =
    Look { name: "N^(-1/2)", colour: GREY, dash: Some((9, 6)), marker: Marker::None, thickness: 6 };
const TARGET: Look =
    Look { name: "target", colour: VERMILLION, dash: Some((3, 4)), marker: Marker::None, thickness: 6 };
const PANEL: i32 = 280;

/// Draws the steps (nodes, relative error) on logarithmic scales, a line of the slope −½ through the last one, and the
/// target.
///
/// Steps without a relative error, or with one that cannot be drawn on a logarithmic axis, are left out.
pub(crate) fn adaptive(
    title: &str,
    steps: &[(usize, Option<f64>)],
    target: f64,
) -> Result<String, PlotError> {
    let points = steps.iter().filter_map(|(n, e)| Some((*n as f64, (*e)?)));
    let points: Vec<(f64, f64)> = points.filter(|(n, e)| drawable_log(*n) && drawable_log(*e)).collect();
    let ends = points.first().zip(points.last());
    let line = |look, ends: Option<[(f64, f64); 2]>| Series {
        look,
        points: ends.into_iter().flatten().map(Some).collect(),
    };
    let rate = ends.map(|(a, b)| [(a.0, b.1 * (b.0 / a.0).sqrt()), *b]);
    let wanted = ends.filter(|_| drawable_log(target)).map(|(a, b)| [(a.0, target), (b.0, target)]);
    let all = [
        line(TARGET, wanted),
        line(RATE, rate.filter(|_| points.len() > 1)),
        Series { look: ERROR, points: points.iter().copied().map(Some).collect() },
    ];
    let shown: Vec<Look> = all.iter().filter(|s| !s.is_empty()).map(|s| s.look).collect();
    let extents = series::extents(all.iter());
    let x_axis = series::log_axis(extents.map(|[x, _]| x));
    let y_axis = series::log_axis(extents.map(|[_, y]| y));
    let description = ends.map_or_else(
        || "No step has a relative error.".to_owned(),
        |(a, b)| {
            format!(
                "Logarithmic scales. {} at {} nodes, {} at {} nodes.{}",
                short(a.1),
                short(a.0),
                short(b.1),
                short(b.0),
                if wanted.is_some() { format!(" Target {}.", short(target)) } else { String::new() }
            )
        },
    );
    let top = TITLE + legend::height(&shown) + 12;
    sheet::figure(top + PANEL + sheet::BELOW + 10, title, &description, |area| {
        legend::draw(area, TITLE, &shown)?;
        let labels = Labels { x: "nodes of both bodies", y: "bound of the error / energy norm", grid: true };
        series::line_panel(area, Frame::wide(top, PANEL), (x_axis, y_axis), &labels, &all)?;
        Ok(String::new())
    })
}

//! The certified relative error against the number of nodes, with the best rate of linear triangles.

use super::axis::{drawable_log, short};
use super::colour::{GREY, INK, VERMILLION};
use super::lines::{self, LinePanel, Series, THICK, THIN};
use super::look::{Look, Marker};
use super::sheet::PIXEL;

const ERROR: Look = Look::new("certified relative error", INK, THICK, Marker::Disc);
const RESIDUAL: Look = Look::new("relative residual, no bound", INK, THICK, Marker::Disc);
const RATE: Look = Look::new("N^(-1/2)", GREY, THIN, Marker::None).dashed("36 24");
const RATE_OF_SOLIDS: Look = Look { name: "N^(-1/3)", ..RATE };
const TARGET: Look = Look::new("target", VERMILLION, THIN, Marker::None).dashed("12 16");
const HEIGHT: f64 = 280.0 * PIXEL;

/// The quantity that an adaptive run measures.
#[derive(Clone, Copy)]
pub(crate) enum Measure {
    /// A certified relative error.
    CertifiedError,
    /// With Coulomb friction a relative residual.
    Residual,
}

/// Draws the steps (nodes, relative error) on logarithmic scales, a line of the best slope through the last one, −½ in the plane and −⅓ of
/// solids, and the target.
///
/// Steps without a relative error, or with one that cannot be drawn on a logarithmic axis, are left out.
pub(crate) fn adaptive(
    measure: Measure,
    steps: &[(usize, Option<f64>)],
    target: f64,
    of_solids: bool,
) -> String {
    let (rate_look, growth): (Look, fn(f64) -> f64) =
        if of_solids { (RATE_OF_SOLIDS, f64::cbrt) } else { (RATE, f64::sqrt) };
    let points = steps.iter().filter_map(|(n, e)| Some([*n as f64, (*e)?]));
    let points: Vec<[f64; 2]> = points.filter(|p| p.iter().all(|v| drawable_log(*v))).collect();
    let ends = points.first().zip(points.last()).map(|(a, b)| [*a, *b]);
    let rate = ends.filter(|_| points.len() > 1).map(|[a, b]| [[a[0], b[1] * growth(b[0] / a[0])], b]);
    let wanted = ends.filter(|_| drawable_log(target)).map(|e| e.map(|p| [p[0], target]));
    let line = |look, points: &[[f64; 2]]| Series {
        look,
        points: points.iter().map(|p| Some((*p).into())).collect(),
    };
    let (look, title, label) = match measure {
        Measure::CertifiedError => {
            (ERROR, "Certified error against the nodes", "bound of the error / energy norm")
        }
        Measure::Residual => (RESIDUAL, "Residual against the nodes", "residual / energy norm"),
    };
    let all = [
        line(TARGET, wanted.as_ref().map_or(&[], |e| &e[..])),
        line(rate_look, rate.as_ref().map_or(&[], |e| &e[..])),
        line(look, &points),
    ];
    let [x_axis, y_axis] = lines::extents(all.iter()).map(lines::log_axis);
    let description = match ends {
        None => "No step has a relative error.".to_owned(),
        Some(ends) => {
            let [a, b] = ends.map(|[n, e]| format!("{} at {} nodes", short(e), short(n)));
            let target = wanted.map_or_else(String::new, |_| format!(" Target {}.", short(target)));
            format!("Logarithmic scales. {a}, {b}.{target}")
        }
    };
    let labels = ["nodes of all bodies", label];
    let panel = LinePanel::new(labels, [&x_axis, &y_axis], &all);
    lines::figure(title, &description, HEIGHT, &[panel])
}

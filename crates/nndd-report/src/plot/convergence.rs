//! Indicators and precision against the iteration.

use super::PlotError;
use super::axis::{Axis, drawable_log, short};
use super::colour::GREEN;
use super::legend;
use super::look::{Look, Marker};
use super::series::{self, Series};
use super::sheet::{self, Frame, Labels, TITLE};
use super::sweep::{E_CRE, ETA_DIS, ETA_NNDD};

/// One iteration in [`convergence`].
pub(crate) struct ConvergenceRow {
    /// Number of the iteration.
    pub(crate) iteration: usize,
    /// η_NNDD, absolute.
    pub(crate) eta_nndd: f64,
    /// The precision ε_t.
    pub(crate) precision: f64,
    /// η_dis if it was computed.
    pub(crate) eta_dis: Option<f64>,
    /// e_CRE if it was computed.
    pub(crate) e_cre: Option<f64>,
}

const PRECISION: Look = Look {
    name: "precision (no unit)",
    colour: GREEN,
    dash: Some((4, 4)),
    marker: Marker::Triangle,
    thickness: 8,
};
const PANEL: i32 = 280;

/// Draws η_NNDD and the precision against the iteration on a logarithmic scale, with η_dis and e_CRE if
/// there are any.
///
/// Values that are missing, not finite or not positive are left out; the line continues to the next.
pub(crate) fn convergence(title: &str, rows: &[ConvergenceRow]) -> Result<String, PlotError> {
    let of = |look: Look, value: &dyn Fn(&ConvergenceRow) -> Option<f64>| Series {
        look,
        points: rows
            .iter()
            .filter_map(|r| value(r).filter(|v| drawable_log(*v)).map(|v| Some((r.iteration as f64, v))))
            .collect(),
    };
    let all = [
        of(ETA_NNDD, &|r| Some(r.eta_nndd)),
        of(PRECISION, &|r| Some(r.precision)),
        of(ETA_DIS, &|r| r.eta_dis),
        of(E_CRE, &|r| r.e_cre),
    ];
    let shown: Vec<Look> = all.iter().filter(|s| !s.is_empty()).map(|s| s.look).collect();
    let iterations = || rows.iter().map(|r| r.iteration);
    let x_axis = match (iterations().min(), iterations().max()) {
        (Some(lo), Some(hi)) => Axis::whole(lo, hi, 10),
        _ => Axis::whole(0, 10, 10),
    };
    let extents = series::extents(all.iter());
    let y_axis = series::log_axis(extents.map(|[_, y]| y));

    let top = TITLE + legend::height(&shown) + 12;
    sheet::figure(top + PANEL + sheet::BELOW + 10, title, &description(&all), |area| {
        legend::draw(area, TITLE, &shown)?;
        let labels = Labels { x: "iteration", y: "indicators (energy^1/2), precision", grid: true };
        series::line_panel(area, Frame::wide(top, PANEL), (x_axis, y_axis), &labels, &all)?;
        Ok(String::new())
    })
}

fn description(all: &[Series]) -> String {
    let mut text = "Logarithmic scale against the iteration.".to_owned();
    for s in all {
        if let (Some(first), Some(last)) = (s.present().next(), s.present().last()) {
            text.push_str(&format!(
                " {}: {} at iteration {}, {} at iteration {}.",
                s.look.name,
                short(first.1),
                first.0,
                short(last.1),
                last.0
            ));
        }
    }
    text
}

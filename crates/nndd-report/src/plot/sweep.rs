//! Indicators against a swept setting, one panel per mesh.

use super::PlotError;
use super::axis::{Axis, drawable, drawable_log, short};
use super::colour::{BLUE, INK, VERMILLION};
use super::legend;
use super::look::{Look, Marker};
use super::series::{self, Series};
use super::sheet::{self, Frame, Labels, TITLE, WIDTH, Words};

/// One panel of [`sweep`]: the indicators of one mesh against the swept value.
pub(crate) struct SweepSeries {
    /// Heading of the panel.
    pub(crate) name: String,
    /// The swept values.
    pub(crate) theta: Vec<f64>,
    /// η_NNDD at each value; `None` if the run diverged.
    pub(crate) eta_nndd: Vec<Option<f64>>,
    /// η_dis at each value.
    pub(crate) eta_dis: Vec<Option<f64>>,
    /// e_CRE at each value.
    pub(crate) e_cre: Vec<Option<f64>>,
}

/// The look of η_NNDD in every figure.
pub(super) const ETA_NNDD: Look =
    Look { name: "eta_nndd (algorithm)", colour: BLUE, dash: None, marker: Marker::Disc, thickness: 8 };
/// The look of η_dis in every figure.
pub(super) const ETA_DIS: Look = Look {
    name: "eta_dis (discretisation)",
    colour: VERMILLION,
    dash: None,
    marker: Marker::Square,
    thickness: 8,
};
/// The look of e_CRE in every figure: drawn last and dashed, for it often lies on η_dis.
pub(super) const E_CRE: Look = Look {
    name: "e_cre (total bound)",
    colour: INK,
    dash: Some((9, 6)),
    marker: Marker::Cross,
    thickness: 6,
};

const PANEL: i32 = 230;
const CAPTION: i32 = 30;

/// Draws the indicators against a swept setting, one panel below the other, on a common logarithmic scale.
///
/// Values that are missing, not finite or not positive are left out and break the line; the heading of a
/// panel says how many values of the setting have no η_NNDD, and where η_NNDD is smallest.
///
/// # Errors
/// [`PlotError::Length`] if an indicator has not one entry per swept value.
pub(crate) fn sweep(title: &str, x_label: &str, panels: &[SweepSeries]) -> Result<String, PlotError> {
    for p in panels {
        super::same_length("eta_nndd of a sweep", p.theta.len(), p.eta_nndd.len())?;
        super::same_length("eta_dis of a sweep", p.theta.len(), p.eta_dis.len())?;
        super::same_length("e_cre of a sweep", p.theta.len(), p.e_cre.len())?;
    }
    let drawn: Vec<[Series; 3]> = panels.iter().map(series_of).collect();
    let extents = series::extents(drawn.iter().flatten());
    let x_axis = extents.map_or_else(|| Axis::linear(0.0, 1.0, 8), |[x, _]| Axis::padded(x.0, x.1, 8));
    let y_axis = series::log_axis(extents.map(|[_, y]| y));
    let shown: Vec<Look> = [ETA_NNDD, ETA_DIS, E_CRE]
        .into_iter()
        .enumerate()
        .filter(|(k, _)| drawn.iter().any(|d| !d[*k].is_empty()))
        .map(|(_, look)| look)
        .collect();

    let count = panels.len().max(1) as i32;
    let each = CAPTION + PANEL + sheet::BELOW;
    let captions: Vec<String> = panels.iter().zip(&drawn).map(|(p, d)| caption(x_label, p, &d[0])).collect();
    let description = format!(
        "Indicators, in the square root of an energy, on a logarithmic scale against {x_label}. {}",
        captions.join(". ")
    );
    let head = TITLE + legend::height(&shown);
    sheet::figure(head + count * each + 10, title, &description, |area| {
        legend::draw(area, TITLE, &shown)?;
        for k in 0..count {
            let top = head + k * each + CAPTION;
            let frame = Frame::wide(top, PANEL);
            let labels = Labels { x: x_label, y: "indicator (energy^1/2)", grid: true };
            if let Some(text) = captions.get(k as usize) {
                let size = sheet::fitting(text, 14.0, f64::from(WIDTH - 20));
                Words::new(size).bold().write(area, text, (WIDTH / 2, top - 13))?;
            }
            let all = drawn.get(k as usize).map_or(&[][..], |all| &all[..]);
            series::line_panel(area, frame, (x_axis.clone(), y_axis.clone()), &labels, all)?;
        }
        Ok(String::new())
    })
}

fn series_of(panel: &SweepSeries) -> [Series; 3] {
    let mut order: Vec<usize> = (0..panel.theta.len()).filter(|i| drawable(panel.theta[*i])).collect();
    order.sort_by(|i, j| panel.theta[*i].total_cmp(&panel.theta[*j]));
    let of = |look: Look, values: &[Option<f64>]| Series {
        look,
        points: order
            .iter()
            .map(|i| values[*i].filter(|v| drawable_log(*v)).map(|v| (panel.theta[*i], v)))
            .collect(),
    };
    [of(ETA_NNDD, &panel.eta_nndd), of(ETA_DIS, &panel.eta_dis), of(E_CRE, &panel.e_cre)]
}

fn caption(x_label: &str, panel: &SweepSeries, eta_nndd: &Series) -> String {
    let mut text = panel.name.clone();
    if let Some((x, _)) = eta_nndd.present().min_by(|a, b| a.1.total_cmp(&b.1)) {
        text.push_str(&format!(": smallest eta_nndd at {x_label} = {}", short(x)));
    }
    let lost = panel.eta_nndd.iter().filter(|v| !v.is_some_and(f64::is_finite)).count();
    if lost > 0 {
        text.push_str(&format!("; {lost} of {} diverged, left out", panel.theta.len()));
    }
    text
}

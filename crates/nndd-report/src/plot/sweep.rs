//! Indicators against a swept setting, one panel per mesh.

use super::axis::{drawable, drawable_log, short};
use super::colour::{BLUE, INK, VERMILLION};
use super::lines::{self, LinePanel, Series, THICK, THIN};
use super::look::{Look, Marker};
use super::sheet::PIXEL;
use case_io::report::{IterationRow, SweepPanel, SweepRow};
use fem_core::geometry::Vector;

/// The look of η_NNDD in every figure.
pub(super) const ETA_NNDD: Look = Look::new("eta_nndd (algorithm)", BLUE, THICK, Marker::Disc);
/// The look of η_dis in every figure.
pub(super) const ETA_DIS: Look = Look::new("eta_dis (discretisation)", VERMILLION, THICK, Marker::Square);
/// The look of e_CRE in every figure: drawn last and dashed, for it often lies on η_dis.
pub(super) const E_CRE: Look = Look::new("e_cre (total bound)", INK, THIN, Marker::Cross).dashed("36 24");

const HEIGHT: f64 = 230.0 * PIXEL;

/// Draws the indicators against a swept setting, one panel below the other, on a common logarithmic scale.
///
/// `values`: of the setting; an interrupted sweep has no row for the last ones. Values that are missing, not
/// finite or not positive are left out and break the line, and so are runs that diverged or whose certificate is not valid; the
/// heading of a panel says how many values are left out, and where η_NNDD is smallest.
pub(crate) fn sweep(title: &str, key: &str, values: &[f64], panels: &[SweepPanel]) -> String {
    let drawn: Vec<[Series; 3]> = panels.iter().map(|p| series_of(p, values)).collect();
    let [x, y] = lines::extents(drawn.iter().flatten());
    let (x_axis, y_axis) = (lines::linear_axis(x), lines::log_axis(y));
    let headings: Vec<String> = panels.iter().zip(&drawn).map(|(p, all)| heading(key, p, &all[0])).collect();
    let description = format!(
        "Indicators, in the square root of an energy, on a logarithmic scale against {key}. {}",
        headings.join(". ")
    );
    let panel = |heading, series| LinePanel {
        heading,
        ..LinePanel::new([key, "indicator (energy^1/2)"], [&x_axis, &y_axis], series)
    };
    let mut all: Vec<_> = headings.iter().zip(&drawn).map(|(h, s)| panel(Some(h), &s[..])).collect();
    if all.is_empty() {
        all.push(panel(None, &[]));
    }
    lines::figure(title, &description, HEIGHT, &all)
}

/// An indicator of a run, unless it diverged or its certificate is not valid.
fn value(row: &SweepRow, of: fn(&IterationRow) -> Option<f64>) -> Option<f64> {
    of(&row.iteration).filter(|v| v.is_finite() && row.valid && row.status != "diverged")
}

fn series_of(panel: &SweepPanel, values: &[f64]) -> [Series; 3] {
    let mut rows: Vec<(f64, &SweepRow)> =
        values.iter().copied().zip(&panel.rows).filter(|(x, _)| drawable(*x)).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let of = |look: Look, indicator: fn(&IterationRow) -> Option<f64>| {
        let point = |(x, row): &(f64, &SweepRow)| {
            value(row, indicator).filter(|v| drawable_log(*v)).map(|v| Vector::new(*x, v))
        };
        Series { look, points: rows.iter().map(point).collect() }
    };
    [of(ETA_NNDD, |r| r.eta_nndd), of(ETA_DIS, |r| r.eta_dis), of(E_CRE, |r| r.e_cre)]
}

fn heading(key: &str, panel: &SweepPanel, eta_nndd: &Series) -> String {
    let mut text = panel.name.clone();
    if let Some(least) = eta_nndd.present().min_by(|a, b| a[1].total_cmp(&b[1])) {
        text += &format!(": smallest eta_nndd at {key} = {}", short(least[0]));
    }
    let lost = panel.rows.iter().filter(|row| value(row, |r| r.eta_nndd).is_none()).count();
    if lost > 0 {
        text += &format!("; {lost} of {} left out: diverged or not valid", panel.rows.len());
    }
    text
}

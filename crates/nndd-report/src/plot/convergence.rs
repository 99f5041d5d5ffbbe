//! Indicators and precision against the iteration.

use super::axis::{Axis, drawable_log, short};
use super::colour::GREEN;
use super::labels::Labels;
use super::lines::{self, LinePanel, Series, THICK};
use super::look::{Look, Marker};
use super::sheet::PIXEL;
use super::sweep::{E_CRE, ETA_DIS, ETA_NNDD};
use case_io::report::IterationRow;

const PRECISION: Look = Look::new("precision (no unit)", GREEN, THICK, Marker::Triangle).dashed("16 16");
const HEIGHT: f64 = 280.0 * PIXEL;
const TICKS: usize = 10;

/// Draws η_NNDD and the precision against the iteration on a logarithmic scale, with η_dis and e_CRE if
/// there are any.
///
/// Values that are missing, not finite or not positive are left out; the line continues to the next.
pub(crate) fn convergence(title: &str, rows: &[IterationRow], labels: &Labels) -> String {
    let of = |look: Look, value: fn(&IterationRow) -> Option<f64>| {
        let drawn = |r: &IterationRow| value(r).filter(|v| drawable_log(*v)).map(|v| [r.iteration as f64, v]);
        Series { look, points: rows.iter().filter_map(drawn).map(|p| Some(p.into())).collect() }
    };
    let all = [
        of(ETA_NNDD, |r| r.eta_nndd),
        of(PRECISION, |r| r.precision),
        of(ETA_DIS, |r| r.eta_dis),
        of(E_CRE, |r| r.e_cre),
    ];
    let iterations = || rows.iter().map(|r| r.iteration);
    let x_axis = Axis::whole(iterations().min().unwrap_or(0), iterations().max().unwrap_or(TICKS), TICKS);
    let [_, y] = lines::extents(all.iter());
    let y_axis = lines::log_axis(y);
    let mut description = "Logarithmic scale against the iteration.".to_owned();
    for s in all.iter().filter(|s| !s.is_empty()) {
        let ends = [s.present().next(), s.present().last()];
        let ends = ends.iter().flatten().map(|end| format!("{} at iteration {}", short(end[1]), end[0]));
        description += &format!(" {}: {}.", s.look.name, ends.collect::<Vec<_>>().join(", "));
    }
    let indicators = labels.energy_norm("indicators") + ", precision";
    let panel = LinePanel::new(["iteration", &indicators], [&x_axis, &y_axis], &all);
    lines::figure(title, &description, HEIGHT, &[panel])
}

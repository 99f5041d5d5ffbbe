//! The results of solids that are looked at first: peaks, and the contact of each pair.

use super::{certified, number, table, with_unit};
use crate::space::ReportSpace;
use crate::words::{self, with_digits};
use case_io::Case;
use case_io::case::Units;
use case_io::report::{ContactSummary, Report};
use std::fmt::Write as _;

/// Writes peaks and contact of solids; nothing in the plane, whose figures of contact lines say it.
pub(super) fn glance<S: ReportSpace>(page: &mut String, case: &Case<S>, report: &Report) {
    let digits = words::certified_digits(certified(report));
    let shown = |x: Option<f64>| x.map_or_else(|| number(None), |x| with_digits(x, digits));
    let place = |at: &[f64]| words::place(at, at.iter().fold(0.0, |most, x| x.abs().max(most)));
    let surfaces = || report.contact.iter().filter_map(|pair| Some((pair, pair.surface.as_ref()?)));
    if let Some(peak) = &report.results.peak_stress
        && let Some(z) = peak.z
    {
        let of = |what: &str, unit: fn(&Units) -> String| with_unit(case, what, unit);
        let rows = [
            vec![
                of("largest recovered von Mises stress", Units::stress),
                shown(Some(peak.von_mises)),
                format!("{} at {}", peak.body, place(&[peak.x, peak.y, z])),
            ],
            vec![
                of("largest displacement", |u| u.length.clone()),
                shown(report.results.max_displacement),
                String::new(),
            ],
        ];
        table(page, "At a glance", &["quantity", "value", "where"], rows);
    }
    let row = |(pair, surface): (&ContactSummary, &case_io::report::ContactSurface)| {
        let area = &surface.area;
        let mut cells = vec![pair.name.clone(), shown(pair.contact_force), shown(pair.max_pressure)];
        cells.extend([area.certain, area.possible, Some(area.total)].map(shown));
        cells.push(pair.centre.as_ref().map_or_else(|| number(None), |centre| place(centre)));
        cells
    };
    if surfaces().next().is_none() {
        return;
    }
    let area = |what: &str| with_unit(case, what, Units::area);
    let heads = [
        "pair".to_owned(),
        with_unit(case, S::PRESSURE_INTEGRAL, S::force_unit),
        with_unit(case, "largest pressure", Units::stress),
        area("area closed at every node"),
        area("at one node at least"),
        area("of all"),
        with_unit(case, "centre of pressure", |u| u.length.clone()),
    ];
    table(page, "Area in contact", &heads.each_ref().map(String::as_str), surfaces().map(row));
    let _ = writeln!(
        page,
        "<p>Faces closed at every node are in contact on this mesh, and those closed at one node at least may be; the border of the contact is \
         between them. These are results of the mesh, not bounds.</p>"
    );
}

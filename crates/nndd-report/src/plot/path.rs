//! Stress and displacement along a path.

use super::colour::{BLUE, GREEN, INK, VERMILLION};
use super::labels::Labels;
use super::lines::{self, LinePanel, Series, THICK, THIN};
use super::look::{Look, Marker};
use super::sheet::PIXEL;
use case_io::table::{PathRow, PathValues};
use fem_core::geometry::Vector;

const VON_MISES: Look = Look::new("von Mises stress", INK, THICK, Marker::None);
const LARGEST: Look = Look::new("largest principal stress", VERMILLION, THIN, Marker::None);
const SMALLEST: Look = Look::new("smallest principal stress", BLUE, THIN, Marker::None).dashed("16 16");
const DISPLACEMENT: Look = Look::new("displacement", GREEN, THICK, Marker::None);
const HEIGHT: f64 = 190.0 * PIXEL;

/// Draws the stresses above and the size of the displacement below, a line for each stretch in a body.
///
/// * `count`: the number of points of the path, at least 2.
pub(crate) fn path(name: &str, rows: &[PathRow], count: usize, labels: &Labels) -> String {
    let mut bodies: Vec<&str> = Vec::new();
    for found in rows.iter().filter_map(|row| row.found.as_ref()) {
        if !bodies.contains(&found.body.as_str()) {
            bodies.push(&found.body);
        }
    }
    let step = rows.last().map_or(0.0, |row| row.s) / (count - 1) as f64;
    let series = |look: Look, value: &dyn Fn(&PathValues) -> Option<f64>| {
        let mut points = Vec::with_capacity(rows.len());
        for body in &bodies {
            let mut last = f64::NEG_INFINITY;
            let of_body = rows.iter().filter_map(|row| Some((row.s, row.found.as_ref()?)));
            for (s, found) in of_body.filter(|(_, found)| found.body == *body) {
                // A point between is in another body, or in none.
                if s - last > 1.5 * step {
                    points.push(None);
                }
                last = s;
                points.push(value(found).filter(|v| v.is_finite()).map(|v| Vector::new(s, v)));
            }
        }
        Series { look, points }
    };
    let stresses = [
        series(LARGEST, &|found| Some(found.principal[1])),
        series(SMALLEST, &|found| Some(found.principal[0])),
        series(VON_MISES, &|found| found.von_mises),
    ];
    let size = |found: &PathValues| found.displacement.iter().map(|u| u * u).sum::<f64>().sqrt();
    let displacement = [series(DISPLACEMENT, &|found| Some(size(found)))];
    let ends = lines::extents(stresses.iter());
    let [x_axis, stress_axis] = ends.map(lines::linear_axis);
    // From zero on, so that round-off and a mesh of chords are not drawn as steep lines.
    let [_, range] = lines::extents(displacement.iter());
    let displacement_axis = lines::linear_axis(range.map(|(_, most)| (0.0, most)));
    let [s, stress] = [labels.length("s along the path"), labels.stress("stress", "stress units")];
    let size = labels.length("displacement");
    let panels = [
        LinePanel::new(["", &stress], [&x_axis, &stress_axis], &stresses),
        LinePanel::new([&s, &size], [&x_axis, &displacement_axis], &displacement),
    ];
    let description = match bodies.is_empty() {
        true => "No point of the path is in a body.".to_owned(),
        false => format!("Through {}.", bodies.join(", ")),
    };
    lines::figure(&format!("Along the path {name}"), &description, HEIGHT, &panels)
}

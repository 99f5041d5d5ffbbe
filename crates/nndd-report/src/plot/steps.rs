//! Forces of the contact lines against the load step.

use super::axis::{Axis, drawable, short};
use super::colour::{GREEN, INK};
use super::labels::Labels;
use super::lines::{self, LinePanel, Series, THICK};
use super::look::{Look, Marker};
use super::sheet::PIXEL;

const NORMAL: Look = Look::new("contact force", INK, THICK, Marker::Disc);
const TANGENTIAL: Look = Look::new("tangential force", GREEN, THICK, Marker::Triangle).dashed("16 16");
const HEIGHT: f64 = 220.0 * PIXEL;
const TICKS: usize = 10;

/// The forces of a contact line: its name, and in each step the contact force and, with friction, the tangential one, N/m.
pub(crate) type Forces<'a> = (&'a str, Vec<[Option<f64>; 2]>);

/// Draws the forces of each pair in a panel of its own, from step 1.
pub(crate) fn steps(title: &str, pairs: &[Forces<'_>], labels: &Labels) -> String {
    let of = |look: Look, values: &[[Option<f64>; 2]], which: usize| {
        let point = |(k, v): (usize, &[Option<f64>; 2])| {
            v[which].filter(|v| drawable(*v)).map(|v| [(k + 1) as f64, v].into())
        };
        Series { look, points: values.iter().enumerate().map(point).collect() }
    };
    let series: Vec<[Series; 2]> =
        pairs.iter().map(|(_, values)| [of(NORMAL, values, 0), of(TANGENTIAL, values, 1)]).collect();
    let most = pairs.iter().map(|(_, values)| values.len()).max().unwrap_or(1);
    let x_axis = Axis::whole(1, most.max(2), TICKS);
    let y_axes: Vec<Axis> = series
        .iter()
        .map(|both| {
            let [_, range] = lines::extents(both.iter());
            // With zero, which is what a force is compared to.
            lines::linear_axis(range.map(|(lo, hi)| (lo.min(0.0), hi.max(0.0))))
        })
        .collect();
    let label = labels.line_force("force");
    let mut description = "Against the load step.".to_owned();
    for ((name, values), both) in pairs.iter().zip(&series) {
        let last =
            both.iter().filter_map(|s| Some(format!("{} {}", s.look.name, short(s.present().last()?[1]))));
        description += &format!(" {name}: {} at step {}.", last.collect::<Vec<_>>().join(", "), values.len());
    }
    let panels = pairs.iter().zip(&series).zip(&y_axes).map(|(((name, _), both), y_axis)| LinePanel {
        heading: (pairs.len() > 1).then_some(*name),
        ..LinePanel::new(["load step", &label], [&x_axis, y_axis], both)
    });
    lines::figure(title, &description, HEIGHT, &panels.collect::<Vec<_>>())
}

//! Forces of the contact lines against the load step, or against the factor of a load.

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

/// The quantity of the horizontal axis.
pub(crate) enum Along<'a> {
    /// The number of the step, from 1.
    Step,
    /// The factor of a condition: its name, and its value in each step.
    Factor(&'a str, &'a [f64]),
}

/// Draws the forces of each pair in a panel of its own, in the order of the steps.
pub(crate) fn steps(along: &Along<'_>, pairs: &[Forces<'_>], labels: &Labels) -> String {
    let what = match along {
        Along::Step => "load step".to_owned(),
        Along::Factor(name, _) => format!("factor of {name}"),
    };
    let place = |k: usize| match along {
        Along::Step => Some((k + 1) as f64),
        Along::Factor(_, values) => values.get(k).copied().filter(|x| drawable(*x)),
    };
    let of = |look: Look, values: &[[Option<f64>; 2]], which: usize| {
        let point =
            |(k, v): (usize, &[Option<f64>; 2])| Some([place(k)?, v[which].filter(|v| drawable(*v))?].into());
        Series { look, points: values.iter().enumerate().map(point).collect() }
    };
    let series: Vec<[Series; 2]> =
        pairs.iter().map(|(_, values)| [of(NORMAL, values, 0), of(TANGENTIAL, values, 1)]).collect();
    let most = pairs.iter().map(|(_, values)| values.len()).max().unwrap_or(1);
    let x_axis = match along {
        Along::Step => Axis::whole(1, most.max(2), TICKS),
        Along::Factor(..) => lines::linear_axis(lines::extents(series.iter().flatten())[0]),
    };
    let y_axes: Vec<Axis> = series
        .iter()
        .map(|both| {
            let [_, range] = lines::extents(both.iter());
            // With zero, which is what a force is compared to.
            lines::linear_axis(range.map(|(lo, hi)| (lo.min(0.0), hi.max(0.0))))
        })
        .collect();
    let label = labels.force("force");
    let mut description = format!("Against the {what}.");
    for ((name, values), both) in pairs.iter().zip(&series) {
        let last =
            both.iter().filter_map(|s| Some(format!("{} {}", s.look.name, short(s.present().last()?[1]))));
        description += &format!(" {name}: {} at step {}.", last.collect::<Vec<_>>().join(", "), values.len());
    }
    let panels = pairs.iter().zip(&series).zip(&y_axes).map(|(((name, _), both), y_axis)| LinePanel {
        heading: (pairs.len() > 1).then_some(*name),
        ..LinePanel::new([&what, &label], [&x_axis, y_axis], both)
    });
    lines::figure(&format!("Forces against the {what}"), &description, HEIGHT, &panels.collect::<Vec<_>>())
}

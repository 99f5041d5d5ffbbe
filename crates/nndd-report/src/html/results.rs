//! The tables of forces, pressures, displacements and stresses.

use super::{certified, number, table, unit, with_unit};
use crate::verdict::contact_force;
use crate::words::{self, with_digits};
use case_io::Case;
use case_io::case::Units;
use case_io::report::{ContactStretch, ContactSummary, Report};
use std::cmp::Ordering;
use std::collections::HashMap;
use std::fmt::Write as _;

/// Digits of a place, at least.
const PLACE_DIGITS: usize = 4;

/// Writes the table of results, and the sums of forces below it.
pub(super) fn results(page: &mut String, case: &Case, report: &Report) {
    let r = &report.results;
    let t = case.model.thickness;
    // Without a solution nothing of it is known.
    let Some(energies) = &r.energy_norm_squared else { return };
    let digits = words::certified_digits(certified(report));
    let unit = |of: fn(&Units) -> String| unit(case, of);
    let [length, stress, line_force] =
        [unit(|u| u.length.clone()), unit(Units::stress), unit(Units::line_force)];
    let (force, moment) = (unit(|u| u.force.clone()), unit(Units::moment));
    let mut found: Vec<(String, Option<f64>, Kind)> = vec![];
    let mut row = |name: &str, value: Option<f64>, kind: Kind| found.push((name.to_owned(), value, kind));
    for (body, a) in report.bodies.iter().zip(energies) {
        row(&format!("energy norm² of {}", body.name), Some(*a), Kind::Energy);
    }
    for (contact, stretches) in report
        .contact
        .iter()
        .zip(stretches(&report.contact, r.contact_stretches.as_deref().unwrap_or_default()))
    {
        let of = if report.contact.len() > 1 { format!(" of {}", contact.name) } else { String::new() };
        let [x, y] = contact.resultant.map_or([None; 2], |force| force.map(Some));
        row(&format!("resultant x of the contact{of}, on the first body"), x, Kind::Force);
        row(&format!("resultant y of the contact{of}, on the first body"), y, Kind::Force);
        if contact.moment.is_some() {
            row(&format!("moment{of} about the origin"), contact.moment, Kind::Moment);
        }
        if let Some([x, y]) = contact.centre {
            row(&format!("centre of pressure{of}, x"), Some(x), Kind::Length);
            row(&format!("centre of pressure{of}, y"), Some(y), Kind::Length);
        }
        // One stretch is the whole pair.
        for stretch in stretches.iter().filter(|_| stretches.len() > 1) {
            let [from, to] = stretch.s.map(|s| number(Some(s)));
            let of = format!("of the stretch s = {from} to {to} {length}").trim_end().to_owned() + &of;
            let [x, y] = stretch.resultant.map(Some);
            row(&format!("resultant x {of}"), x, Kind::Force);
            row(&format!("resultant y {of}"), y, Kind::Force);
            row(&format!("∫ p ds {of}"), Some(stretch.contact_force), Kind::Force);
        }
        if let Some(friction) = &contact.friction {
            let force = Some(friction.tangential_force);
            row(&format!("friction force{of}, on the second body along the tangent"), force, Kind::Force);
            let when = if report.steps.is_empty() { "" } else { " in the last step" };
            row(&format!("largest slip{of}{when}"), Some(friction.max_slip), Kind::Length);
        }
    }
    if !report.contact.is_empty() {
        let sum = contact_force(report.contact.len(), "integral of the pressure");
        row(&format!("{sum}, ∫ p ds"), r.contact_force, Kind::Force);
        row("largest nodal pressure", r.max_pressure, Kind::Stress);
        let most = report.contact.iter().filter(|contact| contact.max_pressure.is_some());
        let most = most.max_by(|a, b| a.max_pressure.partial_cmp(&b.max_pressure).unwrap_or(Ordering::Equal));
        if let Some([x, y]) = most.and_then(|contact| contact.max_pressure_at) {
            row("its place, x", Some(x), Kind::Place);
            row("its place, y", Some(y), Kind::Place);
        }
        if r.max_pressure_recovered.is_some() {
            row(
                "largest pressure, recovered over the coarser side's cells",
                r.max_pressure_recovered,
                Kind::Stress,
            );
        }
        row("largest mean pressure of an edge", r.max_edge_pressure, Kind::Stress);
        row("smallest opening", r.min_opening, Kind::Length);
    }
    row("largest displacement", r.max_displacement, Kind::Length);
    if r.max_von_mises.is_some() {
        row("largest von Mises stress of a cell", r.max_von_mises, Kind::Stress);
    }
    if let Some(peak) = &r.peak_stress {
        row(
            &format!("largest recovered von Mises stress, in {}", peak.body),
            Some(peak.von_mises),
            Kind::Stress,
        );
        row("its place, x", Some(peak.x), Kind::Length);
        row("its place, y", Some(peak.y), Kind::Length);
        if peak.change.is_some() {
            row("its relative change from the mesh before", peak.change, Kind::Number);
        }
    }
    // Two supports of a side hold it together.
    let mut reactions: Vec<(String, [f64; 2])> = vec![];
    let mut places: HashMap<String, usize> = HashMap::new();
    for reaction in r.reactions.iter().flatten() {
        let of = format!("{} on {}", reaction.on, reaction.body);
        let place = *places.entry(of.clone()).or_insert(reactions.len());
        match reactions.get_mut(place) {
            Some((_, [x, y])) => (*x, *y) = (*x + reaction.fx, *y + reaction.fy),
            None => reactions.push((of, [reaction.fx, reaction.fy])),
        }
    }
    for (of, [x, y]) in reactions {
        row(&format!("reaction x of {of}"), Some(x), Kind::Force);
        row(&format!("reaction y of {of}"), Some(y), Kind::Force);
    }
    for body in &report.bodies {
        for side in &body.rigid_sides {
            let of = format!("of the rigid side {} of {}", side.on, body.name);
            let motion = [("ux", Kind::Length), ("uy", Kind::Length), ("rotation", Kind::Number)];
            for ((what, kind), value) in motion.into_iter().zip(side.motion) {
                row(&format!("{what} {of}"), Some(value), kind);
            }
            let [fx, fy] = side.force;
            row(&format!("force x {of}"), Some(fx), Kind::Force);
            row(&format!("force y {of}"), Some(fy), Kind::Force);
            row(&format!("moment {of}"), Some(side.moment), Kind::Moment);
        }
    }
    let mut sizes = [0f64; KINDS];
    for (_, value, kind) in &found {
        let size = &mut sizes[*kind as usize];
        *size = size.max(value.unwrap_or_default().abs());
    }
    let size = |kind: Kind| sizes[kind as usize];
    // Per unit thickness, and times the thickness for what is a force or an energy, each with its unit.
    let rows = found.iter().map(|(name, value, kind)| {
        let (unit, whole) = match kind {
            Kind::Force => (&line_force, Some(&force)),
            // An energy per unit thickness has the unit of a force; so has a moment per unit thickness.
            Kind::Energy | Kind::Moment => (&force, Some(&moment)),
            Kind::Length | Kind::Place => (&length, None),
            Kind::Stress => (&stress, None),
            Kind::Number => (&String::new(), None),
        };
        // A moment is rounding beside the forces with their arms.
        let whole_size = match kind {
            Kind::Moment => f64::max(size(Kind::Moment), size(Kind::Force) * size(Kind::Length)),
            kind => size(*kind),
        };
        let rounding = words::ROUNDING * whole_size;
        let value = value.map(|x| if x.abs() <= rounding { 0.0 } else { x });
        // A place is a node of the mesh, whatever the error.
        let digits = if *kind == Kind::Place { digits.max(PLACE_DIGITS) } else { digits };
        let shown = |value: Option<f64>, unit: &str| match value {
            Some(value) => format!("{} {unit}", with_digits(value, digits)).trim_end().to_owned(),
            None => number(None),
        };
        let times = whole.map_or_else(|| number(None), |unit| shown(value.map(|x| x * t), unit));
        vec![name.clone(), shown(value, unit), times]
    });
    let whole = format!("for the thickness {}", words::short(t));
    table(page, "Results", &["quantity", "per unit thickness", &whole], rows);
    let _ = match certified(report) {
        Some(_) => writeln!(
            page,
            "<p>{digits} digits, chosen from the certified error in the energy norm. That error does not bound single forces, pressures, \
             stresses or displacements. <a href=\"report.json\">report.json</a> has all digits.</p>"
        ),
        None => writeln!(page, "<p>All digits are in <a href=\"report.json\">report.json</a>.</p>"),
    };
    balance(page, case, report);
}

/// Splits the stretches of all pairs, which follow each other, into the stretches of each pair of bodies, by the number
/// of node pairs.
fn stretches<'a>(contacts: &[ContactSummary], all: &'a [ContactStretch]) -> Vec<&'a [ContactStretch]> {
    let mut left = all;
    let of_pair = |contact: &ContactSummary| {
        let mut nodes = 0;
        let is_inside = |stretch: &&ContactStretch| {
            nodes += stretch.pairs;
            nodes <= contact.pairs
        };
        let (own, others) = left.split_at(left.iter().take_while(is_inside).count());
        left = others;
        own
    };
    contacts.iter().map(of_pair).collect()
}

/// The forces on each body added up, which are round-off.
fn balance(page: &mut String, case: &Case, report: &Report) {
    let balances = report.bodies.iter().zip(report.results.balance.iter().flatten());
    let rows = balances.map(|(body, sums)| {
        std::iter::once(body.name.clone()).chain(sums.iter().map(|sum| with_digits(*sum, 2))).collect()
    });
    let forces = ["force x", "force y"].map(|what| with_unit(case, what, Units::line_force));
    let moment = with_unit(case, "moment about the centroid", |u| u.force.clone());
    table(page, "Sum of all forces on each body", &["body", &forces[0], &forces[1], &moment], rows);
}

/// Number of kinds.
const KINDS: usize = Kind::Moment as usize + 1;

/// The quantity of a value in the table of results, which determines its unit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Length,
    /// A coordinate of a node.
    Place,
    /// Without a unit.
    Number,
    Stress,
    Force,
    Energy,
    Moment,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stretch_belongs_to_its_pair() {
        let contacts = [3, 7, 2].map(|pairs| ContactSummary { pairs, ..ContactSummary::default() });
        let all = [3, 4, 1, 2, 2].map(|pairs| ContactStretch { pairs, ..ContactStretch::default() });
        assert_eq!(stretches(&contacts, &all), [&all[..1], &all[1..4], &all[4..]]);
        assert_eq!(stretches(&contacts, &[]), [&[]; 3]);
    }
}

//! The tables of forces, pressures, displacements and stresses.

use super::{certified, number, table, unit, with_unit};
use crate::space::ReportSpace;
use crate::verdict::contact_force;
use crate::words::{self, with_digits};
use case_io::Case;
use case_io::case::Units;
use case_io::report::{ContactStretch, ContactSummary, ContactSurface, Report, Spin};
use fem_core::body::Body;
use fem_core::geometry::Coordinates;
use fem_core::interface::ContactProblem;
use fem_core::space::Words;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::fmt::Write as _;

/// Digits of a place, at least.
const PLACE_DIGITS: usize = 4;
/// Digits of loads and of the reactions to them, which agree but for the contact.
const LOAD_DIGITS: usize = 4;

/// Writes the table of results, and the sums of forces below it.
pub(super) fn results<S: ReportSpace>(
    page: &mut String,
    case: &Case<S>,
    problem: &ContactProblem<S>,
    report: &Report,
) {
    let r = &report.results;
    let thickness = S::thickness(&case.model);
    // Without a solution nothing of it is known.
    let Some(energies) = &r.energy_norm_squared else { return };
    let digits = words::certified_digits(certified(report));
    let unit = |of: fn(&Units) -> String| unit(case, of);
    let [length, stress, area] = [unit(|u| u.length.clone()), unit(Units::stress), unit(Units::area)];
    // In the plane per unit thickness; then for the whole thickness.
    let [force, moment] = [unit(S::force_unit), unit(S::moment_unit)];
    let [whole_force, whole_moment] = [unit(|u| u.force.clone()), unit(Units::moment)];
    let none = String::new();
    let mut found: Vec<(String, Option<f64>, Kind)> = vec![];
    let mut row = |name: &str, value: Option<f64>, kind: Kind| found.push((name.to_owned(), value, kind));
    for (body, a) in report.bodies.iter().zip(energies) {
        row(&format!("energy norm² of {}", body.name), Some(*a), Kind::Energy);
    }
    let all_stretches = r.lines.as_ref().and_then(|lines| lines.contact_stretches.as_deref());
    for (contact, stretches) in
        report.contact.iter().zip(stretches(&report.contact, all_stretches.unwrap_or_default()))
    {
        let of = if report.contact.len() > 1 { format!(" of {}", contact.name) } else { String::new() };
        for (c, axis) in S::COORDINATES.iter().enumerate() {
            let force = contact.resultant.as_ref().map(|force| force[c]);
            let what = if contact.max_tension.is_some() { "bond" } else { "contact" };
            row(&format!("resultant {axis} of the {what}{of}, on the first body"), force, Kind::Force);
        }
        for (axis, moment) in about::<S>(contact.moment.as_ref()) {
            row(&format!("moment{axis}{of} about the origin"), Some(moment), Kind::Moment);
        }
        if let Some(tension) = contact.max_tension {
            row(
                &format!("largest tension{of}, the mean of a {}", S::WORDS.facet),
                Some(tension),
                Kind::Stress,
            );
            continue;
        }
        for (axis, x) in S::COORDINATES.iter().zip(contact.centre.iter().flatten()) {
            row(&format!("centre of pressure{of}, {axis}"), Some(*x), Kind::Length);
        }
        if let Some(ContactSurface { area, patches }) = &contact.surface {
            row(&format!("area in contact{of}, at least"), area.certain, Kind::Area);
            row(&format!("area in contact{of}, at most"), area.possible, Kind::Area);
            // One patch is the whole pair.
            let patches = patches.as_deref().filter(|patches| patches.len() > 1).unwrap_or_default();
            for (k, patch) in patches.iter().enumerate() {
                let of = format!("of patch {}{of}", k + 1);
                for (axis, force) in S::COORDINATES.iter().zip(&patch.force) {
                    row(&format!("resultant {axis} {of}"), Some(*force), Kind::Force);
                }
                row(&format!("area {of}, at least"), Some(patch.area), Kind::Area);
            }
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
            let force = Some(friction.tangential_force.size());
            row(&format!("friction force{of}, on the second body along the tangent"), force, Kind::Force);
            let when = if report.steps.is_empty() { "" } else { " in the last step" };
            row(&format!("largest slip{of}{when}"), Some(friction.max_slip), Kind::Length);
        }
    }
    if !report.contact.is_empty() {
        let sum = contact_force(report.contact.len(), "integral of the pressure");
        row(&format!("{sum}, {}", S::PRESSURE_INTEGRAL), r.contact_force, Kind::Force);
        row("largest nodal pressure", r.max_pressure, Kind::Stress);
        let most = report.contact.iter().filter(|contact| contact.max_pressure.is_some());
        let most = most.max_by(|a, b| a.max_pressure.partial_cmp(&b.max_pressure).unwrap_or(Ordering::Equal));
        let place = most.and_then(|contact| contact.max_pressure_at.as_ref());
        for (axis, x) in S::COORDINATES.iter().zip(place.into_iter().flatten()) {
            row(&format!("its place, {axis}"), Some(*x), Kind::Place);
        }
        if r.max_pressure_recovered.is_some() {
            let all = report.contact.iter().all(|pair| pair.max_pressure_recovered.is_some());
            let which = if all { "" } else { " of pairs that do not match" };
            let name = format!("largest pressure, recovered over the coarser side's cells{which}");
            row(&name, r.max_pressure_recovered, Kind::Stress);
        }
        let Words { article, facet, .. } = S::WORDS;
        row(&format!("largest mean pressure of {article} {facet}"), r.max_edge_pressure, Kind::Stress);
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
        for (axis, x) in S::COORDINATES.iter().zip([Some(peak.x), Some(peak.y), peak.z]) {
            row(&format!("its place, {axis}"), x, Kind::Length);
        }
        if peak.change.is_some() {
            row("its relative change from the mesh before", peak.change, Kind::Number);
        }
    }
    let principal = r
        .principal_stress
        .iter()
        .flat_map(|found| [("largest", &found.largest), ("smallest", &found.smallest)]);
    for (which, found) in principal {
        row(
            &format!("{which} recovered principal stress, in {}", found.body),
            Some(found.value),
            Kind::Stress,
        );
        for (axis, x) in S::COORDINATES.iter().zip([Some(found.x), Some(found.y), found.z]) {
            row(&format!("its place, {axis}"), x, Kind::Length);
        }
    }
    // Two supports of a side hold it together.
    let mut reactions: Vec<(String, [f64; 3])> = vec![];
    let mut places: HashMap<String, usize> = HashMap::new();
    for reaction in r.reactions.iter().flatten() {
        let of = format!("{} on {}", reaction.on, reaction.body);
        let place = *places.entry(of.clone()).or_insert(reactions.len());
        let force = [reaction.fx, reaction.fy, reaction.fz.unwrap_or_default()];
        match reactions.get_mut(place) {
            Some((_, sum)) => (0..3).for_each(|c| sum[c] += force[c]),
            None => reactions.push((of, force)),
        }
    }
    for (of, force) in reactions {
        for (axis, x) in S::COORDINATES.iter().zip(force) {
            row(&format!("reaction {axis} of {of}"), Some(x), Kind::Force);
        }
    }
    for spring in r.springs.iter().flatten() {
        let force = [spring.fx, spring.fy, spring.fz.unwrap_or_default()];
        for (axis, x) in S::COORDINATES.iter().zip(force) {
            let of = format!("force {axis} of the springs at {} of {}", spring.on, spring.body);
            row(&of, Some(x), Kind::Force);
        }
    }
    for cut in r.cuts.iter().flatten() {
        row(&format!("force in the cut {}", cut.name), Some(cut.force), Kind::Force);
        row(&format!("shortening of the cut {}", cut.name), Some(cut.shortening), Kind::Length);
    }
    for body in &report.bodies {
        for side in &body.rigid_sides {
            let of = format!("of the rigid side {} of {}", side.on, body.name);
            for (k, (what, value)) in S::MOTIONS.iter().zip(&side.motion).enumerate() {
                let kind = if k < S::DIM { Kind::Length } else { Kind::Number };
                row(&format!("{what} {of}"), Some(*value), kind);
            }
            for (axis, force) in S::COORDINATES.iter().zip(&side.force) {
                row(&format!("force {axis} {of}"), Some(*force), Kind::Force);
            }
            for (axis, moment) in about::<S>(Some(&side.moment)) {
                row(&format!("moment{axis} {of}"), Some(moment), Kind::Moment);
            }
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
            Kind::Force => (&force, Some(&whole_force)),
            // An energy per unit thickness has the unit of a force; so has a moment per unit thickness.
            Kind::Energy | Kind::Moment => (&moment, Some(&whole_moment)),
            Kind::Length | Kind::Place => (&length, None),
            Kind::Area => (&area, None),
            Kind::Stress => (&stress, None),
            Kind::Number => (&none, None),
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
        let mut cells = vec![name.clone(), shown(value, unit)];
        cells.extend(
            thickness.map(|t| whole.map_or_else(|| number(None), |unit| shown(value.map(|x| x * t), unit))),
        );
        cells
    });
    match thickness {
        Some(t) => {
            let whole = format!("for the thickness {}", words::short(t));
            table(page, "Results", &["quantity", "per unit thickness", &whole], rows);
        }
        None => table(page, "Results", &["quantity", "value"], rows),
    }
    let _ = match certified(report) {
        Some(_) => writeln!(
            page,
            "<p>{digits} digits, chosen from the certified error in the energy norm. That error does not bound single forces, pressures, \
             stresses or displacements. <a href=\"report.json\">report.json</a> has all digits.</p>"
        ),
        None => writeln!(page, "<p>All digits are in <a href=\"report.json\">report.json</a>.</p>"),
    };
    loads(page, case, problem, report);
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

/// The resultant of the loads on each body beside those of its supports.
fn loads<S: ReportSpace>(page: &mut String, case: &Case<S>, problem: &ContactProblem<S>, report: &Report) {
    let reactions = report.results.reactions.iter().chain(&report.results.springs).flatten();
    let rows = report.bodies.iter().zip(&problem.bodies).flat_map(|(summary, body)| {
        let load = resultant(body);
        let mut sums = [0.0; 3];
        for reaction in reactions.clone().filter(|reaction| reaction.body == summary.name) {
            let force = [reaction.fx, reaction.fy, reaction.fz.unwrap_or_default()];
            (0..3).for_each(|c| sums[c] += force[c]);
        }
        let sides = summary.rigid_sides.iter().map(|side| &side.force);
        sides.for_each(|force| force.iter().zip(&mut sums).for_each(|(force, sum)| *sum += force));
        let size = load.largest().max(sums.iter().fold(0.0, |most, x| x.abs().max(most)));
        let shown =
            |x: f64| with_digits(if x.abs() <= words::ROUNDING * size { 0.0 } else { x }, LOAD_DIGITS);
        let row = |what: &str, force: &[f64]| {
            let mut cells = vec![summary.name.clone(), what.to_owned()];
            cells.extend(force.iter().take(S::COORDINATES.len()).map(|x| shown(*x)));
            cells
        };
        [row("loads", load.entries()), row("supports, springs and rigid sides", &sums)]
    });
    let mut heads = vec!["body".to_owned(), "resultant of".to_owned()];
    heads.extend(S::COORDINATES.iter().map(|axis| with_unit(case, &format!("force {axis}"), S::force_unit)));
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    table(page, "Loads and reactions", &heads, rows);
}

/// Computes the resultant of the tractions and of the body force; the forces on rigid sides are among those of the sides.
fn resultant<S: ReportSpace>(body: &Body<S>) -> S::Vector {
    let mesh = body.mesh();
    let conditions = mesh.topology().boundary_facets().iter().filter_map(|facet| {
        let traction = body.facet_condition(*facet)?.traction;
        let nodes = traction.as_ref();
        Some(nodes.iter().copied().sum::<S::Vector>() * (mesh.facet_measure(*facet) / nodes.len() as f64))
    });
    conditions.sum::<S::Vector>() + body.resultant_inside()
}

/// The forces on each body added up, which are round-off.
fn balance<S: ReportSpace>(page: &mut String, case: &Case<S>, report: &Report) {
    let balances = report.bodies.iter().zip(report.results.balance.iter().flatten());
    let rows = balances.map(|(body, sums)| {
        std::iter::once(body.name.clone()).chain(sums.iter().map(|sum| with_digits(*sum, 2))).collect()
    });
    let mut heads = vec!["body".to_owned()];
    heads.extend(S::COORDINATES.iter().map(|axis| with_unit(case, &format!("force {axis}"), S::force_unit)));
    let moment = S::spin_written(S::Spin::default());
    let moments = about::<S>(Some(&moment));
    heads.extend(
        moments.map(|(axis, _)| with_unit(case, &format!("moment{axis} about the centroid"), S::moment_unit)),
    );
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    table(page, "Sum of all forces on each body", &heads, rows);
}

/// Lists the components of a moment, each with its axis behind a blank; the only one of the plane has none.
fn about<'a, S: ReportSpace>(moment: Option<&'a Spin>) -> impl Iterator<Item = (String, f64)> + use<'a, S> {
    let components = moment.map_or(&[][..], Spin::components);
    let axis =
        |k: usize| if components.len() > 1 { format!(" {}", S::COORDINATES[k]) } else { String::new() };
    components.iter().enumerate().map(move |(k, moment)| (axis(k), *moment))
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
    Area,
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

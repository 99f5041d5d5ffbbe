//! The rows of a comparison: of the runs, of each body, of each cut, of each pair.

use super::{Row, Values};
use crate::words::ROUNDING;
use case_io::report::{Bounds, Certificate, ContactSummary, Coulomb, CutResult, Reaction, Report, Spin};

/// Makes all rows: of the runs, of each body, and of each cut and each pair of either run.
pub(super) fn rows(both: [&Report; 2]) -> Vec<Row> {
    let mut rows = of_runs(both);
    for (k, body) in both[0].bodies.iter().enumerate() {
        let of = format!("body \"{}\"", body.name);
        let nodes = |report: &Report| report.bodies.get(k).map(|body| body.nodes as f64);
        rows.push(Row { of: of.clone(), name: "nodes", values: Values::Numbers(both.map(nodes)) });
        rows.extend(forces(both, &of, &body.name));
    }
    let cuts = both.map(|report| report.results.cuts.iter().flatten().map(|cut| cut.name.as_str()).collect());
    names(cuts).into_iter().for_each(|name| rows.extend(of_cut(both, name)));
    let pairs = both.map(|report| report.contact.iter().map(|pair| pair.name.as_str()).collect());
    names(pairs).into_iter().for_each(|name| rows.extend(of_pair(both, name)));
    rows
}

/// Joins the names of both runs, each once.
fn names([mut names, others]: [Vec<&str>; 2]) -> Vec<&str> {
    let new: Vec<&str> = others.into_iter().filter(|name| !names.contains(name)).collect();
    names.extend(new);
    names
}

/// Makes the rows of a cut.
fn of_cut(both: [&Report; 2], cut: &str) -> [Row; 2] {
    let row = |name, value: fn(&CutResult) -> f64| {
        let of = |report: &Report| {
            let cuts = report.results.cuts.as_ref()?;
            cuts.iter().find(|of| of.name == cut).map(value)
        };
        Row { of: format!("cut \"{cut}\""), name, values: Values::Numbers(both.map(of)) }
    };
    [row("force", |of| of.force), row("shortening", |of| of.shortening)]
}

/// Makes the rows of the whole runs.
fn of_runs(both: [&Report; 2]) -> Vec<Row> {
    let row = |name, values| Row { of: String::new(), name, values };
    let number = |name, value: fn(&Report) -> Option<f64>| row(name, Values::Numbers(both.map(value)));
    let bound = |name, value: fn(&Certificate) -> Option<f64>| {
        row(name, Values::Bounds(both.map(|report| value(report.valid_certificate()?))))
    };
    let mut rows = vec![
        row("status", Values::Words(both.map(|report| report.status.word.clone()))),
        bound("bound e_CRE", |of| of.e_cre),
        bound("bound e_CRE, relative", |of| of.relative),
    ];
    if both.iter().any(|report| report.coulomb.is_some()) {
        let residual = |report: &Report, of: fn(&Coulomb) -> Option<f64>| of(report.coulomb.as_ref()?);
        let [e_b, relative] = [|of: &Coulomb| of.e_b, |of: &Coulomb| of.relative]
            .map(|of| Values::Numbers(both.map(|report| residual(report, of))));
        rows.extend([row("residual e_b", e_b), row("residual e_b, relative", relative)]);
    }
    let interval = |name, value: fn(&Bounds) -> Option<[f64; 2]>| {
        row(name, Values::Intervals(both.map(|report| value(&report.valid_certificate()?.bounds))))
    };
    let norm =
        |report: &Report| Some(report.results.energy_norm_squared.as_ref()?.iter().sum::<f64>().sqrt());
    rows.extend([
        number("energy norm", norm),
        interval("bounds of energy norm", |bounds| bounds.energy_norm),
        interval("bounds of potential energy", |bounds| bounds.potential_energy),
        interval("bounds of contact force", |bounds| bounds.contact_force),
        number("largest displacement", |report| report.results.max_displacement),
        number("largest von Mises stress", |report| report.results.max_von_mises),
        number("the same, recovered", |report| Some(report.results.peak_stress.as_ref()?.von_mises)),
    ]);
    rows
}

/// Makes the rows of the reactions and the springs of a body, each summed over its sides.
fn forces(both: [&Report; 2], of: &str, body: &str) -> Vec<Row> {
    let components = |force: &Reaction| [Some(force.fx), Some(force.fy), force.fz];
    let all = both.iter().flat_map(|report| [&report.results.reactions, &report.results.springs]).flatten();
    let sizes = all.flatten().flat_map(components).flatten();
    let contact = both.iter().filter_map(|report| report.results.contact_force);
    let size = sizes.chain(contact).map(f64::abs).fold(0.0, f64::max);
    let sum = |of: &Option<Vec<Reaction>>, axis: usize| {
        let own = of.iter().flatten().filter(|force| force.body == body);
        let sum = own.map(|force| components(force)[axis]).reduce(|a, b| Some(a? + b?))??;
        // Beside the largest force it is rounding.
        Some(if sum.abs() <= ROUNDING * size { 0.0 } else { sum })
    };
    let reactions = ["reaction x", "reaction y", "reaction z"].into_iter().enumerate();
    let reactions = reactions.map(|(axis, name)| (name, both.map(|of| sum(&of.results.reactions, axis))));
    let springs = ["force of springs x", "force of springs y", "force of springs z"].into_iter().enumerate();
    let springs = springs.map(|(axis, name)| (name, both.map(|of| sum(&of.results.springs, axis))));
    let known = reactions.chain(springs).filter(|(_, values)| values.iter().any(Option::is_some));
    known.map(|(name, values)| Row { of: of.to_owned(), name, values: Values::Numbers(values) }).collect()
}

/// Makes the rows of a pair: those that either run knows.
fn of_pair(both: [&Report; 2], pair: &str) -> Vec<Row> {
    type Quantity = (&'static str, fn(&ContactSummary) -> Option<f64>);
    let quantities: [Quantity; 8] = [
        ("contact force", |of| of.contact_force),
        ("largest pressure", |of| of.max_pressure_recovered.or(of.max_pressure)),
        ("largest tension of the bond", |of| of.max_tension),
        ("width in contact", |of| of.line.as_ref()?.width),
        ("area in contact, certain", |of| of.surface.as_ref()?.area.certain),
        ("area in contact, possible", |of| of.surface.as_ref()?.area.possible),
        ("force of friction", |of| Some(signed(of.friction.as_ref()?.tangential_force))),
        ("largest slip", |of| Some(of.friction.as_ref()?.max_slip)),
    ];
    let of = |report: &Report, value: fn(&ContactSummary) -> Option<f64>| {
        value(report.contact.iter().find(|of| of.name == pair)?)
    };
    let rows = quantities.into_iter().map(|(name, value)| (name, both.map(|report| of(report, value))));
    let known = rows.filter(|(name, values)| *name == "contact force" || values.iter().any(Option::is_some));
    let made = |(name, values)| Row { of: format!("pair \"{pair}\""), name, values: Values::Numbers(values) };
    known.map(made).collect()
}

/// Returns a number of the plane with its sign, or the length of a vector.
fn signed(force: Spin) -> f64 {
    match force {
        Spin::Plane(force) => force,
        vector @ Spin::Solid(_) => vector.size(),
    }
}

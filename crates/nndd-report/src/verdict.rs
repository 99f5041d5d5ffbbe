//! The sentence about a run, and the one about its certificate.

use crate::solved::{RunResult, Solved};
use crate::words;
use case_io::Case;
use case_io::case::{Dimension, Units};
use case_io::report::{Certificate, Coulomb, Parts, ProjectedLoad, Report, Status};
use certified_contact::RoleReason;
use fem_core::interface::Partner;
use std::fmt::Write as _;

/// A part of the bound is shown if its share is at least this.
const NOTICEABLE: f64 = 0.1;

/// Tells whether a bound is round-off: more than half of it is the allowance for that.
pub(crate) fn is_round_off(allowance: f64, bound: f64) -> bool {
    allowance > 0.5 * bound
}

/// Says that a bound is round-off, behind the sentence that tells the bound; nothing if it is not.
pub(crate) fn mostly_round_off(allowance: f64, bound: f64) -> String {
    if !is_round_off(allowance, bound) {
        return String::new();
    }
    format!("; the bound is round-off: the allowance for it is {}", words::rounded_up(allowance))
}

/// Writes the status line and the certificate line, behind an empty line.
pub fn verdict(report: &Report) -> String {
    let Status { word, reason, .. } = &report.status;
    let mut text = format!("\n{word}: {reason}\n");
    if let Some(coulomb) = &report.coulomb {
        return text + &without_bound(coulomb);
    }
    let none = Certificate::default();
    let certificate = report.certificate.as_ref().unwrap_or(&none);
    let parts = &certificate.parts;
    match (certificate.e_cre, parts.mesh, parts.iteration) {
        (Some(e_cre), Some(mesh), Some(iteration)) if certificate.valid => {
            let of = if report.steps.is_empty() { "" } else { " of the last increment" };
            let mostly = parts.round_off.map_or_else(String::new, |part| mostly_round_off(part, e_cre));
            text += &match certificate.relative {
                Some(relative) if e_cre > 0.0 => {
                    let percent = |x: f64| words::rounded_up(100.0 * relative * x / e_cre);
                    format!(
                        "certified error{of} <= {} % of the energy norm (discretisation {} %, iteration {} %{}){mostly}\n",
                        words::rounded_up(100.0 * relative),
                        percent(mesh),
                        percent(iteration),
                        other_parts(parts, e_cre, percent)
                    )
                }
                _ => format!(
                    "certified error{of} <= {} in the energy norm; the bodies hold no strain energy, so there is no percentage{mostly}\n",
                    words::rounded_up(e_cre)
                ),
            };
        }
        (Some(_), ..) => {
            text += "NOT certified, the bound is not valid:";
            for (name, value) in certificate.checks.named() {
                let _ = write!(text, " {name} {:.1e}", value.unwrap_or(f64::NAN));
            }
            text.push('\n');
        }
        _ => text += "no certificate: the numbers are too large or too small for one\n",
    }
    text + &without_loads(&certificate.projected_load)
}

/// Says which loads were left out, a line each.
pub(crate) fn without_loads(loads: &[ProjectedLoad]) -> String {
    let mut text = String::new();
    for ProjectedLoad { body, motion, load, share } in loads {
        let _ = writeln!(
            text,
            "for the load without {load:.3e} (a share of {share:.1e}) along a motion that contact resists only by the error of the polygon: body \
             \"{body}\" {motion}"
        );
    }
    text
}

/// Writes the lines of a solution with Coulomb friction, for which no bound exists.
fn without_bound(coulomb: &Coulomb) -> String {
    const NONE: &str = "no bound exists for Coulomb friction";
    let Some(e_b) = coulomb.e_b else {
        let mut text = format!("{NONE}; there is no residual either, since its checks fail:");
        for (name, value) in coulomb.checks.named() {
            let _ = write!(text, " {name} {:.1e}", value.unwrap_or(f64::NAN));
        }
        return text + "\n";
    };
    let shown = |absolute: f64, relative: Option<f64>| match relative {
        Some(relative) => format!("{} %", words::rounded_up(100.0 * relative)),
        None => words::rounded_up(absolute),
    };
    let size = shown(e_b, coulomb.relative);
    let of = if coulomb.relative.is_some() { "of the energy norm" } else { "in the energy norm" };
    let mut text =
        format!("{NONE}; residual e_b = {size} {of} (an indicator, zero only for an exact solution)\n");
    if coulomb.frozen_bound.is_some() {
        let _ = writeln!(text, "bound if the friction limit were the given one of contact.csv: {size}");
    }
    if let Some(estimate) = coulomb.estimate {
        let size = shown(estimate, coulomb.relative_estimate);
        let _ = writeln!(text, "estimate, if the exact slip has the same sign: {size}");
    }
    text
}

/// Writes the line about the largest von Mises stress of an adaptive run, and how far it still moves; empty for one mesh.
pub fn peak(report: &Report) -> String {
    let Some(peak) = &report.results.peak_stress else { return String::new() };
    let Some(change) = peak.change else { return String::new() };
    let certified = report.valid_certificate().and_then(|certificate| certificate.relative);
    let place: Vec<String> =
        [Some(peak.x), Some(peak.y), peak.z].into_iter().flatten().map(words::seven).collect();
    format!(
        "largest recovered von Mises stress {} in \"{}\" at ({}), {}{} % against the mesh before; no bound\n",
        words::with_digits(peak.von_mises, words::certified_digits(certified)),
        words::one_line(&peak.body),
        place.join(", "),
        if change < 0.0 { "" } else { "+" },
        words::short((1e4 * change).round() / 100.0)
    )
}

/// A quantity of the console: its name, its value and its unit.
type Quantity<'a> = (&'a str, Option<f64>, fn(&Units) -> String);

/// Writes the line about the contact and the largest stress of a run without refinement; empty without a valid certificate.
pub fn key_results<S: Dimension>(case: &Case<S>, report: &Report) -> String {
    let Some(certificate) = report.valid_certificate().filter(|_| case.adapt.is_none()) else {
        return String::new();
    };
    let digits = words::certified_digits(certificate.relative);
    let r = &report.results;
    let of_contact = |value: Option<f64>| value.filter(|_| !report.contact.is_empty());
    let stress = r.peak_stress.as_ref().map(|peak| peak.von_mises);
    let integral = contact_force(report.contact.len(), "integral of the pressure");
    // Single nodal pressures oscillate if surfaces do not match.
    let (name, pressure) = match r.max_pressure_recovered {
        None => ("largest nodal pressure", r.max_pressure),
        recovered if report.contact.iter().all(|pair| pair.max_pressure_recovered.is_some()) => {
            ("largest recovered pressure", recovered)
        }
        recovered => ("largest pressure (recovered on pairs that do not match)", recovered),
    };
    let quantities: [Quantity<'_>; 3] = [
        (&integral, of_contact(r.contact_force), S::force_unit),
        (name, of_contact(pressure), Units::stress),
        ("largest recovered von Mises stress", stress, Units::stress),
    ];
    let shown = quantities.into_iter().filter_map(|(name, value, unit)| {
        let unit = case.units.as_ref().map_or_else(String::new, |units| format!(" {}", unit(units)));
        Some(format!("{name} {}{unit}", words::with_digits(value?, digits)))
    });
    let shown: Vec<String> = shown.collect();
    let when = if report.steps.is_empty() { "" } else { "last step: " };
    if shown.is_empty() {
        String::new()
    } else {
        format!("{when}{}; these are not bounds\n", shown.join(", "))
    }
}

/// Names `results.contact_force`. Forces on several lines have no common direction: it is the sum of their sizes.
///
/// * `alone`: its name if there is one pair.
pub fn contact_force(pairs: usize, alone: &str) -> String {
    match pairs {
        0 | 1 => alone.to_owned(),
        pairs => format!("sum of the contact forces of {pairs} pairs"),
    }
}

/// The other parts of the bound, as far as they are a noticeable share of it.
fn other_parts(parts: &Parts, e_cre: f64, percent: impl Fn(f64) -> String) -> String {
    let others = [
        ("contact law between the nodes", parts.contact),
        ("bent contact", parts.lift),
        ("gap", parts.gap_data),
        ("friction", parts.friction),
        ("round-off", parts.round_off),
    ];
    let mut text = String::new();
    for (name, part) in others {
        if let Some(part) = part.filter(|part| *part >= NOTICEABLE * e_cre) {
            let _ = write!(text, ", {name} {} %", percent(part));
        }
    }
    text
}

/// Lists the choices that were made and why, for `--verbose`.
pub fn choices<S: Dimension>(case: &Case<S>, solved: &Solved<S>) -> String {
    let mut text = String::new();
    let solution = match &solved.answer {
        RunResult::Certified(solution) => solution,
        RunResult::Coulomb(result) => {
            let found = &result.solution;
            let changes: Vec<String> = found.changes.iter().map(|change| format!("{change:.1e}")).collect();
            let _ = writeln!(
                text,
                "  {} of the fixed point, {} restarts; changes of the friction limit: {}",
                words::counted(found.steps, "step"),
                found.restarts,
                changes.join(" ")
            );
            return text;
        }
    };
    let Some(pair) = solution.problem.contacts.iter().find(|pair| !pair.is_bonded()) else { return text };
    let name = |of: Partner| of.body().map_or("the obstacle", |body| case.bodies[body].name.as_str());
    let names = pair.partners().map(name);
    let carrier = name(pair.imposed());
    let _ = match solution.role_reason {
        RoleReason::Given if solution.problem.only_pair().is_none() => Ok(()),
        RoleReason::Given => writeln!(text, "  lambda is carried by \"{carrier}\", as given"),
        RoleReason::Stiffer { compliance } => writeln!(
            text,
            "  lambda is carried by \"{carrier}\", the stiffer body: compliance {:.3e} of \"{}\" against {:.3e} of \"{}\"",
            compliance[0], names[0], compliance[1], names[1]
        ),
    };
    if let Some(s) = solution.nndd.spectrum {
        let _ = writeln!(
            text,
            "  theta {:.4}: spectrum of the interface operator [{:.4}, {:.4}] from {} Lanczos steps, limit {:.4}",
            solution.nndd.theta,
            s.smallest,
            s.largest,
            s.steps,
            s.theta_limit()
        );
    }
    let kkt = solution.rows.iter().map(|r| r.iteration.qp_kkt).fold(0.0, f64::max);
    let _ = writeln!(
        text,
        "  contact problems: Clarabel called {} times, largest KKT residual {kkt:.1e}",
        solution.nndd.clarabel_calls
    );
    text
}

//! `nndd certify`: the error of displacements that another code computed.

use crate::args::{Certify, Format};
use crate::console;
use crate::machine::Machine;
use fem_core::geometry::shown;
use nndd_report::failure::NOT_CERTIFIED;
use nndd_report::words::{rounded_up, with_digits};
use nndd_report::{Failure, certify, run};
use std::fmt::Write as _;

/// Digits of what is printed for people.
const DIGITS: usize = 4;

pub(crate) fn command(options: &Certify) -> Result<u8, Failure> {
    let mut case = run::read_case(&options.case.case, &run::overrides(&options.case.set)?)?;
    let problem = run::build(&mut case, &Machine::start())?;
    let found = certify::certify(&case, problem, &options.displacement)?;
    let failed: Vec<(&str, f64)> = found.estimate.admissibility.failed().collect();
    if options.format == Format::Json {
        console::print_json(&certify::summary(&case, &found))?;
        return Ok(if found.bound().is_some() { 0 } else { NOT_CERTIFIED });
    }
    let mut text = String::new();
    if found.change > 0.0 {
        let _ = writeln!(
            text,
            "changed to be admissible: penetration up to {} removed, supports met by up to {}; energy norm of the change {}",
            rounded_up(found.penetration),
            rounded_up(found.support_change),
            rounded_up(found.change)
        );
    }
    let code = match (found.bound(), found.relative()) {
        (Some(bound), Some(relative)) => {
            let percent = rounded_up(100.0 * relative);
            let _ = writeln!(
                text,
                "certified error <= {percent} % of the energy norm: {} of {}",
                rounded_up(bound),
                with_digits(found.estimate.energy_norm(), DIGITS)
            );
            0
        }
        (Some(bound), None) => {
            let _ = writeln!(text, "certified error <= {} in the energy norm", rounded_up(bound));
            0
        }
        (None, _) => {
            let checks: Vec<String> =
                failed.iter().map(|(name, value)| format!("{name} {value:.1e}")).collect();
            let reason = match found.missed_support {
                Some(missed) => format!(
                    "body \"{}\" misses its support at ({}, {}) by {}",
                    case.bodies[missed.body].name,
                    shown(missed.point[0]),
                    shown(missed.point[1]),
                    with_digits(missed.distance, DIGITS)
                ),
                None => {
                    "the field violates supports, contact or balance by more than can be mended".to_owned()
                }
            };
            let _ = writeln!(text, "NOT certified, the bound is not valid: {}; {reason}", checks.join(", "));
            NOT_CERTIFIED
        }
    };
    console::print(&text)?;
    Ok(code)
}

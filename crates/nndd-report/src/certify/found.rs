//! What a certificate of another code's field says, for people and as JSON.

use crate::report::projected;
use crate::space::ReportSpace;
use crate::verdict::{mostly_round_off, without_loads};
use crate::words::{rounded_up, with_digits};
use case_io::Case;
use cre_estimator::FieldCertificate;
use fem_core::geometry::{Coordinates, Point};
use serde_json::{Map, Value, json};

/// Digits of what is printed for people.
const DIGITS: usize = 4;

/// Says in a line or two what was found.
pub fn verdict<S: ReportSpace>(case: &Case<S>, found: &FieldCertificate<S>) -> String {
    let mut text = String::new();
    if found.change > 0.0 {
        text += &format!(
            "changed to be admissible: penetration up to {} removed, supports met by up to {}; energy norm of the change {}\n",
            rounded_up(found.penetration),
            rounded_up(found.support_change),
            rounded_up(found.change)
        );
    }
    let round_off = found.estimate.unchecked().parts.round_off;
    let mostly = found.bound().map_or_else(String::new, |bound| mostly_round_off(round_off, bound));
    text + &match (found.bound(), found.relative()) {
        (Some(bound), Some(relative)) => format!(
            "certified error <= {} % of the energy norm: {} of {}{mostly}\n",
            rounded_up(100.0 * relative),
            rounded_up(bound),
            with_digits(found.estimate.energy_norm(), DIGITS)
        ),
        (Some(bound), None) => {
            format!("certified error <= {} in the energy norm{mostly}\n", rounded_up(bound))
        }
        (None, _) => {
            let failed = found.estimate.admissibility.failed();
            let checks: Vec<String> = failed.map(|(name, value)| format!("{name} {value:.1e}")).collect();
            let reason = match found.missed_support {
                Some(missed) => format!(
                    "body \"{}\" misses its support at {} by {}",
                    case.bodies[missed.body].name,
                    Point::from(missed.point),
                    with_digits(missed.distance, DIGITS)
                ),
                None => {
                    "the field violates supports, contact or balance by more than can be mended".to_owned()
                }
            };
            format!("NOT certified, the bound is not valid: {}; {reason}\n", checks.join(", "))
        }
    } + &without_loads(&projected(case, &found.left_out))
}

/// Makes one object of what was found.
pub fn summary<S: ReportSpace>(case: &Case<S>, found: &FieldCertificate<S>) -> Value {
    let failed = found.estimate.admissibility.failed();
    let checks: Map<String, Value> = failed.map(|(name, value)| (name.to_owned(), json!(value))).collect();
    json!({
        "valid": found.bound().is_some(),
        "bound": found.bound(),
        "relative": found.relative(),
        "e_cre": found.estimate.unchecked().e_cre,
        "change": found.change,
        "penetration": found.penetration,
        "support_change": found.support_change,
        "round_off": found.estimate.unchecked().parts.round_off,
        "energy_norm": found.estimate.energy_norm(),
        "projected_load": projected(case, &found.left_out),
        "failed_checks": checks,
        "missed_support": found.missed_support.map(|missed| json!({
            "body": case.bodies[missed.body].name,
            "point": missed.point.entries(),
            "distance": missed.distance,
        })),
    })
}

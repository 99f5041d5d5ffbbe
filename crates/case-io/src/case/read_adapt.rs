//! `[adapt]`, and how far the estimator relaxes: from the document to values, with defaults and checks.

use super::{Adapt, Contact, Dimension, Friction, RelaxUntil, Target};
use crate::case_file::Reader;
use crate::diagnostic::excerpt;

const FRACTION: &str = "a number > 0 and < 1";

fn proper(value: f64) -> bool {
    value > 0.0 && value < 1.0
}

/// Reads `[adapt]`, if it is there.
///
/// * `contacts`: the pairs, which say what there is to reach: with Coulomb friction there is no certificate.
pub(super) fn adapt<S: Dimension>(root: &mut Reader<'_>, contacts: &[Contact<S>]) -> Option<Adapt> {
    let mut r = root.table("adapt")?;
    let coulomb = contacts.iter().find(|contact| matches!(contact.friction, Some(Friction::Coulomb { .. })));
    let [error, residual] = ["target_relative_error", "target_coulomb_residual"];
    match coulomb {
        Some(pair) if r.has(error) => {
            let message = format!(
                "no certificate exists with Coulomb friction, which the pair {} has, so that `adapt.{error}` cannot be reached",
                excerpt(&pair.name)
            );
            r.refuse(error, message, "`target_coulomb_residual`", "use target_coulomb_residual");
        }
        Some(_) => r.require(&[residual]),
        None if r.has(residual) => {
            let message = format!("`adapt.{residual}` is for Coulomb friction, and no pair has it");
            r.refuse(
                residual,
                message,
                "`target_relative_error`",
                "use target_relative_error, which is certified",
            );
        }
        None => r.require(&[error]),
    }
    let [error, residual] =
        [r.number_where(error, proper, FRACTION), r.number_where(residual, proper, FRACTION)];
    let adapt = Adapt {
        target: match coulomb {
            None => Target::RelativeError(error.unwrap_or_default()),
            Some(_) => Target::CoulombResidual(residual.unwrap_or_default()),
        },
        max_steps: r.count("max_steps", 1).unwrap_or(30),
        max_nodes: r.count("max_nodes", 1).unwrap_or(2_000_000),
        fraction: r.number_where("fraction", |f| f > 0.0 && f <= 1.0, "a number > 0 and <= 1").unwrap_or(0.5),
    };
    r.finish();
    Some(adapt)
}

/// Reads `tolerance` and `max_steps` of `[estimator]`, which replace `relaxation`.
pub(super) fn relax_until<S: Dimension>(r: &mut Reader<'_>) -> Option<RelaxUntil> {
    let tolerance = r.number_where("tolerance", proper, FRACTION);
    let max_steps = r.count("max_steps", 1);
    for key in ["tolerance", "max_steps"] {
        if r.has(key) && r.has("relaxation") {
            let message = format!("`estimator.relaxation` and `estimator.{key}` both say how far to relax");
            let fix = "leave `relaxation` out to relax until little is left to gain";
            r.refuse(key, message, "one of the two", fix);
        }
    }
    let default = S::RELAX_UNTIL;
    Some(RelaxUntil {
        tolerance: tolerance.unwrap_or(default.tolerance),
        max_steps: max_steps.unwrap_or(default.max_steps),
    })
}

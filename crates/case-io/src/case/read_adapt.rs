//! `[adapt]`, and how far the estimator relaxes: from the document to values, with defaults and checks.

use super::{Adapt, RelaxUntil};
use crate::case_file::Reader;

const FRACTION: &str = "a number > 0 and < 1";

fn proper(value: f64) -> bool {
    value > 0.0 && value < 1.0
}

/// Reads `[adapt]`, if it is there.
pub(super) fn adapt(root: &mut Reader<'_>) -> Option<Adapt> {
    let mut r = root.table("adapt")?;
    r.require(&["target_relative_error"]);
    let adapt = Adapt {
        target_relative_error: r.number_where("target_relative_error", proper, FRACTION).unwrap_or_default(),
        max_steps: r.count("max_steps", 1).unwrap_or(30),
        max_nodes: r.count("max_nodes", 1).unwrap_or(2_000_000),
        fraction: r.number_where("fraction", |f| f > 0.0 && f <= 1.0, "a number > 0 and <= 1").unwrap_or(0.5),
    };
    r.finish();
    Some(adapt)
}

/// Reads `tolerance` and `max_steps` of `[estimator]`, which replace `relaxation`.
pub(super) fn relax_until(r: &mut Reader<'_>) -> Option<RelaxUntil> {
    let tolerance = r.number_where("tolerance", proper, FRACTION);
    let max_steps = r.count("max_steps", 1);
    for key in ["tolerance", "max_steps"] {
        if r.has(key) && r.has("relaxation") {
            let message = format!("`estimator.relaxation` and `estimator.{key}` both say how far to relax");
            let fix = "leave `relaxation` out to relax until little is left to gain";
            r.refuse(key, message, "one of the two", fix);
        }
    }
    let default = RelaxUntil::default();
    Some(RelaxUntil {
        tolerance: tolerance.unwrap_or(default.tolerance),
        max_steps: max_steps.unwrap_or(default.max_steps),
    })
}

//! `[adapt]`, and how far the estimator relaxes: from the document to values, with defaults and checks.

use super::{Adapt, RelaxUntil};
use crate::case_file::Reader;

const FRACTION: &str = "a number > 0 and < 1";

fn proper(value: f64) -> bool {
    value > 0.0 && value < 1.0
}

/// Reads `[adapt]`, where it stands.
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

/// Reads `tolerance` and `max_steps` of `[estimator]`, which stand instead of `relaxation`.
pub(super) fn relax_until(r: &mut Reader<'_>) -> Option<RelaxUntil> {
    let tolerance = r.number_where("tolerance", proper, FRACTION);
    let max_steps = r.count("max_steps", 1);
    if r.has("tolerance") && r.has("relaxation") {
        let message = "`estimator.relaxation` and `estimator.tolerance` both say how far to relax";
        r.refuse(
            "tolerance",
            message,
            "one of the two",
            "leave `relaxation` out to relax until the gain is small",
        );
    }
    if max_steps.is_some() && !r.has("tolerance") {
        let message =
            "`estimator.max_steps` limits a relaxation by `estimator.tolerance`, which is not given";
        let expected = "`tolerance` beside it, or `relaxation` instead of it";
        r.refuse("max_steps", message, expected, "write `tolerance = 0.01` beside it");
    }
    Some(RelaxUntil { tolerance: tolerance?, max_steps: max_steps.unwrap_or(30) })
}

//! The canonical problems of solids as case files, `cases/solid`: what is read and built has the figures of an independent code.
//!
//! `tests/suite/solids.rs` checks the cases of weight, stack and corner.

use tests::formulation::{PRINTED, compared};

#[test]
fn cases_have_the_figures_of_another_code() {
    for (problem, case) in
        [("cube", "gradient.toml"), ("circle", "hertz.toml"), ("half-open", "half_open.toml")]
    {
        for row in PRINTED.iter().filter(|row| row.1 == problem && row.0 != "4" && row.2 <= 12) {
            for of in compared(row, Some(case)).unwrap() {
                let near = of.reason().is_some_and(|(_, most)| of.difference().abs() <= most);
                assert!(of.agrees() || near, "{case}: {of:?}");
            }
        }
    }
}

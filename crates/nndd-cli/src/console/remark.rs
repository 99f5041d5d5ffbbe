//! A remark if the interface residual and the error of the iteration differ greatly.

use case_io::Case;
use case_io::case::Criterion;
use case_io::case::Dimension;
use case_io::diagnostic::significant;
use case_io::report::{IterationRow, Report};

/// Above this ratio of the error to the residual, stopping on the residual would stop too early.
const SMALLER: f64 = 2.0;
/// Above this ratio of the residual to the error, waiting for the residual would waste iterations.
const LARGER: f64 = 100.0;
/// Relative errors below this are round-off, and no residual says anything about them.
const ROUND_OFF: f64 = 1e-12;

/// Compares the residual with the error at the end of a run that was not interrupted.
pub(crate) fn remark<S: Dimension>(case: &Case<S>, report: &Report) -> Option<String> {
    let norm = report.results.energy_norm_squared.as_ref()?.iter().sum::<f64>().sqrt();
    let stop = &case.solver.stop;
    let last = report.iterations.last()?;
    let comparable = report.status.code == 0 && report.valid_certificate().is_some() && norm > 0.0;
    let level = (stop.criterion == Criterion::Estimator).then_some(stop.ratio);
    let level = level.zip(last.eta_dis).map(|(ratio, eta_dis)| ratio * eta_dis / norm);
    comparable.then(|| compare(&report.iterations, norm, level)).flatten()
}

/// * `level`: the iteration's relative error that the run asked for.
fn compare(rows: &[IterationRow], norm: f64, level: Option<f64>) -> Option<String> {
    let last = rows.last()?;
    let (residual, error) = (last.precision?, last.eta_nndd? / norm);
    if error < ROUND_OFF || residual <= 0.0 {
        return None;
    }
    let story = |times: f64, word: &str| {
        format!(
            "the interface residual (precision {residual:.2e}) is {} times {word} than eta_nndd ({error:.2e} of the energy \
             norm), the distance to this mesh's own solution",
            significant(times)
        )
    };
    // The first iteration at which the residual alone would have stopped the iteration.
    let content = level.map(|level| rows.iter().find(|row| row.precision.is_some_and(|p| p <= level)));
    let asked = level.unwrap_or_default();
    if error > SMALLER * residual {
        let early = content.flatten().filter(|row| row.iteration < last.iteration);
        let early = early.map(|row| {
            let iteration = row.iteration;
            format!(
                ": waiting until it reaches {asked:.1e} as well would have stopped at iteration {iteration}"
            )
        });
        return Some(story(error / residual, "smaller") + &early.unwrap_or_default());
    }
    if residual > LARGER * error {
        let late = matches!(content, Some(None)).then(|| {
            format!(": waiting until it reaches {asked:.1e} as well would have taken more iterations")
        });
        return Some(story(residual / error, "larger") + &late.unwrap_or_default());
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(values: &[(f64, f64)]) -> Vec<IterationRow> {
        let row = |(k, (precision, eta)): (usize, &(f64, f64))| IterationRow {
            iteration: k + 1,
            precision: Some(*precision),
            eta_nndd: Some(*eta),
            ..IterationRow::default()
        };
        values.iter().enumerate().map(row).collect()
    }

    #[test]
    fn a_residual_that_is_too_small_would_have_stopped_too_early() {
        let text = compare(&rows(&[(0.1, 2.0), (0.01, 0.4), (0.001, 0.1)]), 2.0, Some(0.05)).unwrap();
        assert!(
            text.contains("precision 1.00e-3) is 50.0 times smaller") && text.contains("(5.00e-2 of"),
            "{text}"
        );
        assert!(text.ends_with("would have stopped at iteration 2"), "{text}");
        // Without a level there is nothing to say about when.
        let text = compare(&rows(&[(0.01, 0.4), (0.001, 0.1)]), 2.0, None).unwrap();
        assert!(text.ends_with("of the energy norm), the distance to this mesh's own solution"), "{text}");
    }

    #[test]
    fn a_residual_that_is_too_large_would_have_gone_on() {
        let text = compare(&rows(&[(2.0, 1.0), (0.2, 0.001)]), 1.0, Some(0.02)).unwrap();
        assert!(text.contains("200 times larger") && text.ends_with("more iterations"), "{text}");
    }

    #[test]
    fn nothing_is_said_where_both_tell_the_same() {
        assert_eq!(compare(&rows(&[(1.0, 1.0), (0.03, 0.02)]), 1.0, Some(0.02)), None);
        // Twenty times is what a residual often is.
        assert_eq!(compare(&rows(&[(2.0, 1.0), (0.2, 0.01)]), 1.0, Some(0.02)), None);
        // Round-off says nothing.
        assert_eq!(compare(&rows(&[(1e-9, 1e-14)]), 1.0, Some(0.02)), None);
        assert_eq!(compare(&[], 1.0, None), None);
    }
}

//! The bound over the true error: never below 1, and as sharp as promised, on small members of every family.

use cre_estimator::Relaxation;
use fem_core::interface::ContactProblem;
use tests::blocks::Blocks;
use tests::columns::Columns;
use tests::effectivity::{CONTRASTS, Course, RELAXATIONS, Truth, Which, course};
use tests::{heavy, paper, signorini};

/// Measures every iteration and asserts that no bound is below the error, and none refused.
fn measured(problem: ContactProblem, truth: &Truth<'_>) -> Course {
    let found = course(problem, truth, &RELAXATIONS, Which::Every).unwrap();
    assert!(found.stop().is_some());
    for s in &found.samples {
        // An enclosure that says something: within half of the error.
        assert!(s.error[0] > 0.5 * s.error[1], "{s:?}");
        for bound in &s.bounds {
            assert!(bound.unwrap() >= s.error[0], "{s:?}");
        }
        // More steps never raise the bound by more than round-off of single precision.
        let bounds: Vec<f64> = s.bounds.iter().flatten().copied().collect();
        assert!(bounds.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-6)), "{s:?}");
    }
    found
}

/// The upper end of the effectivity where the default criterion stops: two steps, and tolerance-driven.
fn at_stop(found: &Course) -> [f64; 2] {
    [1, 2].map(|k| found.stop().unwrap().effectivity(k).unwrap()[1])
}

#[test]
fn no_bound_is_below_the_exact_error_whatever_the_contrast() {
    for c in CONTRASTS {
        for k in [0.0, 0.7] {
            let materials = [(c, 0.2), (1.0, 0.4)];
            let problem = signorini::problem(materials, k, [17, 8]).unwrap();
            measured(problem, &Truth::signorini(materials, k));
        }
        let columns = Columns::contrast(c);
        measured(columns.problem(5).unwrap(), &Truth::columns(columns));
    }
}

#[test]
fn no_bound_is_below_the_error_enclosed_by_a_finer_solution() {
    for c in CONTRASTS {
        measured(Blocks::contrast(c).cells(10).problem().unwrap(), &Truth::Overkill(4.0));
        measured(Blocks::half_open(c).cells(10).problem().unwrap(), &Truth::Overkill(4.0));
    }
    measured(heavy::problem(0.3, 6).unwrap(), &Truth::Overkill(4.0));
}

#[test]
fn the_enclosure_holds_the_exact_error() {
    // The data of Signorini's exact problem are interpolated, of the columns they are not: there both ways must agree.
    for c in [0.05, 1.0, 20.0] {
        let columns = Columns::contrast(c);
        let one =
            course(columns.problem(4).unwrap(), &Truth::columns(columns), &[Relaxation::NONE], Which::Every);
        let other =
            course(columns.problem(4).unwrap(), &Truth::Overkill(5.0), &[Relaxation::NONE], Which::Every);
        let (one, other) = (one.unwrap(), other.unwrap());
        assert_eq!(one.samples.len(), other.samples.len());
        for (a, b) in one.samples.iter().zip(&other.samples) {
            assert!(b.error[0] <= a.error[0] && a.error[0] <= b.error[1], "{a:?} {b:?}");
            assert!(b.error[1] < 1.3 * b.error[0], "{b:?}");
        }
    }
}

#[test]
fn the_effectivity_is_as_promised() {
    for (materials, two, tolerance) in
        [([(1.0, 0.3), (1.0, 0.3)], 1.05, 1.02), ([(1.0, 0.2), (20.0, 0.4)], 1.05, 1.02)]
    {
        let found = measured(
            signorini::problem(materials, 0.0, [32, 16]).unwrap(),
            &Truth::signorini(materials, 0.0),
        );
        let worst = at_stop(&found);
        assert!(worst[0] <= two && worst[1] <= tolerance, "{materials:?}: {worst:?}");
    }
    let worst = at_stop(&measured(paper::problem(paper::COARSE).unwrap(), &Truth::Overkill(10.0)));
    assert!(worst[0] <= 1.2, "{worst:?}");
    let worst = at_stop(&measured(Blocks::half_open(1.0).problem().unwrap(), &Truth::Overkill(10.0)));
    assert!(worst[0] <= 1.5 && worst[1] <= 1.3, "{worst:?}");
}

//! A sample of the matrix of promises, `cargo xtask reproduce adversarial`, and certificates at the limit of round-off.

use certified_contact::Settings;
use rayon::prelude::*;
use std::collections::BTreeSet;
use tests::matrix::{FEATURES, Problem, Promise, Trial};
use tests::random::Random;
use tests::stacks::{Layer, Measured, Stack, random_settings};

/// Problems of the sample.
const SAMPLE: u64 = 400;

/// Problems that showed faults of runs which are interrupted on a mesh without a certificate.
const RESUMED: [u64; 3] = [1015, 4328, 16_481];

/// Problems whose reactions were out of balance along a motion that the pairs hardly resist, if newton-nn had not converged.
const HARDLY_RESISTED: [u64; 7] = [758, 3809, 6017, 8250, 10_512, 17_622, 17_845];

#[test]
fn every_promise_is_kept_in_a_sample_of_every_feature() {
    let trials: Vec<Trial> = (1_000_000..1_000_000 + SAMPLE)
        .chain(RESUMED)
        .chain(HARDLY_RESISTED)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|n| Trial::new(n).unwrap())
        .collect();
    let violated: Vec<String> = (trials.iter())
        .flat_map(|t| t.violations().map(|v| format!("{}: {:?} {}", t.number, v.promise, v.said)))
        .collect();
    assert!(violated.is_empty(), "{violated:#?}");
    let drawn: BTreeSet<&str> = trials.iter().flat_map(|t| t.features.iter().copied()).collect();
    assert_eq!(FEATURES.iter().filter(|f| !drawn.contains(*f)).collect::<Vec<_>>(), Vec::<&&str>::new());
    assert_eq!(drawn.iter().filter(|f| !FEATURES.contains(f)).collect::<Vec<_>>(), Vec::<&&str>::new());
    for (promise, name) in Promise::ALL {
        let judged = trials.iter().flat_map(|t| &t.verdicts).filter(|v| v.promise == promise).count();
        assert!(judged >= 5, "{name} was judged {judged} times");
    }
    // Most problems are solved, and their bounds are sharp enough for a bound that is too small by a half to be seen.
    let solved = trials.iter().filter(|t| t.code == 0).count();
    assert!(4 * solved > 3 * trials.len(), "{solved} of {}", trials.len());
    let sharp = trials.iter().filter_map(|t| t.measured).filter(|of| of.bound < 2.0 * of.distance).count();
    assert!(5 * sharp > trials.len(), "{sharp} of {} bounds are below twice the error", trials.len());
}

#[test]
fn the_default_relaxation_leaves_little_to_gain() {
    let left = |number: u64| -> Option<f64> {
        let problem = Problem::new(number).unwrap();
        if ["[estimator]", "[adapt]", "[[step]]"].iter().any(|table| problem.text.contains(table)) {
            return None;
        }
        let [default, best] =
            ["", "[estimator]\nrelaxation = 100\n"].map(|more| problem.bound_with(more).unwrap());
        Some(default? / best? - 1.0)
    };
    let all: Vec<(u64, f64)> =
        (2_000_000..2_000_100u64).into_par_iter().filter_map(|n| Some((n, left(n)?))).collect();
    assert!(all.len() >= 25, "{} bounds", all.len());
    let much: Vec<_> = all.iter().filter(|(_, left)| *left > 0.02).collect();
    assert!(much.is_empty(), "{much:?}");
}

#[test]
fn bonded_bodies_keep_every_promise() {
    let trials: Vec<Trial> = (0..16).into_par_iter().map(|k| Trial::new(30 * k + 27).unwrap()).collect();
    for trial in &trials {
        let violations: Vec<_> = trial.violations().collect();
        assert!(violations.is_empty(), "{}: {violations:?}", trial.number);
    }
    let refused: Vec<_> =
        trials.iter().filter(|t| t.code != 0).map(|t| (t.number, t.code, &t.reason)).collect();
    assert!(2 * refused.len() < trials.len(), "{refused:#?}");
}

#[test]
fn the_table_of_keys_names_the_features_that_draw_them() {
    let table: toml::Table = tests::matrix::KEYS.parse().unwrap();
    let problems: Vec<Problem> = (0..600).map(|n| Problem::new(n).unwrap()).collect();
    let words = |text: &str| -> BTreeSet<String> {
        let split = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-'));
        split.map(str::to_owned).collect()
    };
    let drawn: Vec<BTreeSet<String>> = problems.iter().map(|p| words(&(p.text.clone() + &p.other))).collect();
    for (section, entries) in &table {
        for (word, feature) in entries.as_table().unwrap() {
            let feature = feature.as_str().unwrap();
            if feature == "example" || feature == "every problem" || feature.starts_with("not drawn: ") {
                continue;
            }
            assert!(FEATURES.contains(&feature), "{section}.{word}: no feature is named {feature:?}");
            let with = problems.iter().zip(&drawn).filter(|(p, _)| p.features.contains(feature));
            assert!(
                with.clone().any(|(_, words)| words.contains(word)),
                "{section}.{word}: not drawn by {feature:?}"
            );
        }
    }
}

/// Layers of one body by modulus and height from the contact line outwards, with this many rows of cells each.
fn layers(list: &[(f64, f64)], rows: usize) -> Vec<Layer> {
    list.iter().map(|&(young, height)| Layer { young, height, rows }).collect()
}

/// A stiff layer between soft ones, on a soft body: the stiff one hangs on what is soft.
fn sandwich(contrast: f64, columns: usize, rows: usize) -> Stack {
    Stack {
        layers: [layers(&[(1.0, 1.0), (contrast, 1.0), (1.0, 1.0)], rows), layers(&[(1.0, 1.0)], rows)],
        width: 2.0,
        columns,
        poisson: 0.0,
        push: 0.001,
        lying: false,
        shake: (0.0, 0),
    }
}

/// Two bars of one material, pressed against each other lengthwise.
fn bars(ratio: f64) -> Stack {
    let rows = 8 * ratio as usize;
    Stack {
        layers: [layers(&[(1.0, ratio)], rows), layers(&[(1.0, ratio)], rows)],
        width: 1.0,
        columns: 8,
        poisson: 0.0,
        push: 0.001 * ratio,
        lying: true,
        shake: (0.0, 0),
    }
}

/// Holds a certificate against the exact solution in double-double arithmetic.
fn holds(stack: &Stack, settings: &Settings) {
    let Some(found) = Measured::new(stack, settings).unwrap() else { return };
    let words = ["e_CRE", "eta_NNDD", "energy norm", "potential energy", "contact force"];
    let violated: Vec<_> = words.iter().zip(found.violations()).filter(|(_, v)| *v).map(|(w, _)| w).collect();
    assert!(violated.is_empty(), "{violated:?} of {stack:?}: {found:?}");
}

#[test]
fn certificates_of_layers_hold_to_round_off() {
    let default = Settings::default();
    for (contrast, columns, rows) in [(1e8, 12, 8), (1e13, 24, 16)] {
        let stack = sandwich(contrast, columns, rows);
        assert!(Measured::new(&stack, &default).unwrap().is_some(), "{contrast:e} has no certificate");
        holds(&stack, &default);
    }
    for decade in 0..=13 {
        for number in 0..4 {
            let mut random = Random::new(1000 + 100 * decade + number);
            let stack = Stack::layered(10f64.powi(decade as i32), &mut random);
            holds(&stack, &random_settings(&mut random));
        }
    }
}

#[test]
fn certificates_of_slender_bodies_hold_to_round_off() {
    let default = Settings::default();
    let stack = bars(300.0);
    assert!(Measured::new(&stack, &default).unwrap().is_some(), "no certificate");
    holds(&stack, &default);
    for ratio in [10.0, 30.0, 100.0, 300.0, 1000.0] {
        for number in 0..2 {
            let mut random = Random::new(ratio as u64 + 7 * number);
            let stack = Stack::slender(ratio, &mut random);
            holds(&stack, &random_settings(&mut random));
        }
    }
}

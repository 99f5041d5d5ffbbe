//! Attempts to prove bounds wrong: a sample of `cargo xtask reproduce adversarial`.

use certified_contact::Settings;
use tests::adversarial::Family;
use tests::random::Random;
use tests::run::{certify_with, newton, prepare};
use tests::signorini;
use tests::stacks::{Layer, Measured, Stack, random_settings};
use tests::trial::Trial;
use tests::witness::{Ladder, Law};

/// Random problems of each family.
const SAMPLE: u64 = 3;

fn trials() -> impl Iterator<Item = (Family, Trial)> {
    let members = Family::ALL.into_iter().flat_map(|family| (1000..1000 + SAMPLE).map(move |n| (family, n)));
    members.filter_map(|(family, n)| Trial::new(family, n).unwrap().map(|trial| (family, trial)))
}

#[test]
fn a_bound_below_the_error_is_refuted() {
    // The witness must see a tenth: four times finer meshes leave a sixteenth of the squared error.
    let problem = signorini::problem([(1.0, 0.3), (2.0, 0.2)], 0.0, [8, 4]).unwrap();
    let prepared = prepare(&problem);
    let iterate = newton(&prepared).unwrap();
    let e = certify_with(&prepared, &iterate, cre_estimator::Relaxation::Steps(30)).unwrap();
    let ladder = Ladder::new(&problem, 2).unwrap();
    let finer = prepare(ladder.finest());
    let w = tests::displacements(&finer, &newton(&finer).unwrap());
    let v = e.pair.displacements();
    let witness = ladder.witness([v[0], v[1]], [&w[0], &w[1]], Law::Everywhere).unwrap();
    assert!(!witness.refutes(e.unchecked().e_cre), "{} against {}", e.unchecked().e_cre, witness.error());
    assert!(
        witness.refutes(0.9 * e.unchecked().e_cre),
        "{} against {}",
        e.unchecked().e_cre,
        witness.error()
    );
    assert!(witness.refutes(f64::NAN));
}

#[test]
fn no_finer_field_refutes_a_bound_of_a_random_problem() {
    let mut count = 0;
    for (family, trial) in trials() {
        let [two, default, _, norm, energy, force] = trial.violations;
        assert!(!(two || default || norm || energy || force), "{}: {trial:?}", family.name());
        count += usize::from(trial.error.is_some());
    }
    assert!(count as u64 > 11 * SAMPLE, "only {count} problems were tried");
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

#[test]
fn eta_nndd_of_random_problems_holds_to_round_off() {
    for (family, trial) in trials() {
        assert!(!trial.violations[2], "{}: {trial:?}", family.name());
    }
}

//! The answer does not depend on where a problem lies, in which units it is written, how things are numbered, and which
//! body comes first.

use crate::check;
use crate::model::{Answer, Model, Motion, answer, models};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use tests::run::exchanged;

/// Numbers agree to this, relative to the whole.
const TOLERANCE: f64 = 1e-8;

/// Compares an answer with the one that is expected.
fn same(found: Answer, expected: Answer) -> TestCaseResult {
    let energy: f64 = expected.energy.iter().sum();
    for b in 0..2 {
        let difference = (found.energy[b] - expected.energy[b]).abs();
        prop_assert!(difference <= TOLERANCE * energy, "energy {b}: {:?} against {:?}", found, expected);
    }
    for (what, a, b, scale) in [
        ("contact force", found.contact_force, expected.contact_force, expected.contact_force),
        ("e_cre", found.e_cre, expected.e_cre, energy.sqrt()),
        ("eta_dis", found.eta_dis, expected.eta_dis, energy.sqrt()),
    ] {
        prop_assert!((a - b).abs() <= TOLERANCE * scale, "{what}: {:?} against {:?}", found, expected);
    }
    Ok(())
}

/// Solves a problem as it is and after a motion that leaves lengths, moduli and strains alone.
fn unchanged(model: &Model, motion: &Motion) -> TestCaseResult {
    let expected = answer(&model.problem(&Motion::NONE)).0;
    same(answer(&model.problem(motion)).0, expected)
}

#[test]
fn a_rigid_motion_changes_nothing() {
    let motions = (-3.2..3.2f64, [-5.0..5.0f64, -5.0..5.0]);
    check("rigid motion", 600, &(models(), motions), |(model, (angle, shift))| {
        unchanged(&model, &Motion { angle, shift: shift.into(), ..Motion::NONE })
    });
}

#[test]
fn a_mirror_changes_nothing() {
    check("mirror", 600, &(models(), -3.2..3.2f64), |(model, angle)| {
        unchanged(&model, &Motion { mirror: true, angle, ..Motion::NONE })
    });
}

#[test]
fn other_numbers_of_nodes_and_cells_change_nothing() {
    check("renumbering", 600, &(models(), any::<u64>()), |(model, seed)| {
        unchanged(&model, &Motion { renumber: Some(seed), ..Motion::NONE })
    });
}

#[test]
fn other_units_change_the_units_of_the_answer() {
    let factors = [-6.0..6.0f64, -3.0..3.0, -4.0..3.0];
    check("scaling", 600, &(models(), factors), |(model, exponents)| {
        let [stiffness, length, strain] = exponents.map(|e| 10f64.powf(e));
        let expected = answer(&model.problem(&Motion::NONE)).0;
        let found = answer(&model.problem(&Motion { stiffness, length, strain, ..Motion::NONE })).0;
        let energy = stiffness * (strain * length).powi(2);
        let back = Answer {
            energy: found.energy.map(|e| e / energy),
            contact_force: found.contact_force / (stiffness * strain * length),
            e_cre: found.e_cre / energy.sqrt(),
            eta_dis: found.eta_dis / energy.sqrt(),
        };
        same(back, expected)
    });
}

#[test]
fn the_order_of_the_bodies_changes_nothing() {
    check("swapping the bodies", 600, &models(), |model| {
        let problem = model.problem(&Motion::NONE);
        let (expected, first) = answer(&problem);
        let (found, second) = answer(&exchanged(problem));
        // The frozen λ differs, so η_dis differs.
        let found = Answer { energy: [found.energy[1], found.energy[0]], eta_dis: expected.eta_dis, ..found };
        let largest = first.opening.iter().fold(0.0f64, |m, o| m.max(*o)).max(1e-6);
        for (a, b) in first.opening.iter().zip(&second.opening) {
            prop_assert!((a - b).abs() <= TOLERANCE * largest, "{a} against {b}");
        }
        same(found, expected)
    });
}

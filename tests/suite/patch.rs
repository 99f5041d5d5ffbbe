//! The contact patch is solved exactly: uniform pressure, exact energies, and a certificate of zero.

use cre_estimator::Estimate;
use fem_core::material::Hypothesis;
use nndd::{NnddSettings, NnddStatus};
use std::f64::consts::FRAC_PI_2;
use tests::{certify, condense_both, iterates, patch};

#[test]
fn the_patch_is_exact_and_certified_as_exact() {
    let pairs = [
        [(1000.0, 0.3), (1000.0, 0.3)],
        [(2000.0, 0.0), (1000.0, 0.45)],
        [(1.0, 0.2), (50.0, 0.4)],
        [(300.0, -0.3), (2.0, 0.3)],
    ];
    for materials in pairs {
        for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
            for angle in [0.0, 0.3, FRAC_PI_2, 2.0, -2.8] {
                let problem = patch::problem(materials, hypothesis, angle).unwrap();
                let bodies = condense_both(&problem);
                let (solution, _) = iterates(&problem, &bodies, &NnddSettings::default(), 1e-12).unwrap();
                let case = format!("{materials:?} {hypothesis:?} {angle}");
                let ended = matches!(
                    solution.status,
                    NnddStatus::StoppedByCriterion | NnddStatus::Stalled { at_round_off: true, .. }
                );
                assert!(ended, "{case}: {:?}", solution.status);
                let estimate = certify(&problem, &bodies, &solution.last).unwrap();
                let norm = assert_exact(&estimate, materials, hypothesis, &case);
                let [_, delta] = patch::compressions(materials, hypothesis);
                for l in &solution.last.lambda {
                    assert!((l - delta).abs() < 1e-10 * delta, "{case}: {l} against {delta}");
                }
                assert!(estimate.eta_dis < 1e-10 * norm, "{case}");
                // With the allowance for round-off in the opening, a square root of it where normals are oblique.
                assert!(estimate.e_cre < 1e-7 * norm, "{case}: {:e}", estimate.e_cre / norm);
            }
        }
    }
}

/// Asserts exact energies, uniform pressure and a valid certificate of zero; returns the energy norm.
pub(crate) fn assert_exact(
    estimate: &Estimate,
    materials: [(f64, f64); 2],
    hypothesis: Hypothesis,
    case: &str,
) -> f64 {
    assert!(estimate.admissibility.is_valid(), "{case}: {:?}", estimate.admissibility);
    let exact = patch::energies(materials, hypothesis);
    let norm = exact.iter().sum::<f64>().sqrt();
    for b in 0..2 {
        let energy = estimate.energy_norm_squared[b];
        assert!((energy - exact[b]).abs() < 1e-10 * exact[b], "{case}: {energy}");
    }
    for p in &estimate.pair.pressure {
        assert!((p - patch::PRESSURE).abs() < 1e-10 * patch::PRESSURE, "{case}: {p}");
    }
    assert!(estimate.cre.e_cre() < 1e-10 * norm, "{case}: {:e}", estimate.cre.e_cre() / norm);
    norm
}

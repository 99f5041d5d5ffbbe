//! Bodies whose surfaces do not match: the patch stays exact, the bound a bound, and the answer the same.

use cre_estimator::{Estimate, Relaxation, estimate_with};
use fem_core::body::Body;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, ContactState};
use fem_core::material::Hypothesis;
use fem_core::norm::energy_error_squared;
use nndd::NnddSettings;
use tests::run::{newton, refined_in_common};
use tests::{certify, condense_both, displacements, iterates, patch, signorini};

type Materials = [(f64, f64); 2];

const EQUAL: Materials = [(1.0, 0.3), (1.0, 0.3)];
const CONTRAST: Materials = [(1.0, 0.2), (20.0, 0.4)];

#[test]
fn the_patch_is_exact_for_any_ratio_and_angle() {
    let materials = [(2000.0, 0.3), (1000.0, 0.2)];
    for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
        for [m, n] in [[2, 3], [6, 7], [17, 40], [40, 17], [3, 100]] {
            for angle in [0.0, 0.3, -2.0] {
                let case = format!("{hypothesis:?} {m}:{n} at {angle}");
                let bodies = patch::bodies(materials, hypothesis, angle, [[m, 3], [n, 5]]).unwrap();
                let (problem, changes) = refined_in_common(bodies).unwrap();
                assert!(changes.is_some_and(|c| c.free == [0.0; 2]), "{case}: {changes:?}");
                let bodies = condense_both(&problem);
                let (solution, _) = iterates(&problem, &bodies, &NnddSettings::default(), 1e-12).unwrap();
                let estimate = certify(&problem, &bodies, &solution.last).unwrap();
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
            }
        }
    }
}

/// The exact error and the bound, relaxed by `steps`, of one iterate.
fn measure(
    problem: &ContactProblem,
    materials: Materials,
    bodies: &[fem_core::condensation::CondensedBody; 2],
    iterate: &nndd::Iterate,
    steps: usize,
) -> [f64; 2] {
    let u = displacements(bodies, iterate);
    let state = ContactState {
        displacement: [&u[0], &u[1]],
        contact_force: &iterate.contact.normal_reaction,
        opening: &iterate.opening,
    };
    let e: Estimate = estimate_with(problem, bodies, &state, Relaxation::Steps(steps)).unwrap();
    assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
    assert!(e.cre.split_defect() < 1e-12, "{:e}", e.cre.split_defect());
    let exact = signorini::exact(materials, 0.0);
    let field = |b: usize| &e.pair.displacement[b];
    let error = |b: usize| energy_error_squared(&problem.bodies[b], field(b), |x| exact[b].stress(x));
    [(error(0) + error(1)).sqrt(), e.e_cre]
}

/// Asserts the bound at every iteration and returns the effectivity of the discrete solution.
fn effectivity(materials: Materials, bodies: [Body; 2], steps: usize) -> f64 {
    let (problem, changes) = refined_in_common(bodies).unwrap();
    let condensed = condense_both(&problem);
    let (_, all) = iterates(&problem, &condensed, &NnddSettings::default(), 1e-9).unwrap();
    for iterate in &all {
        let [error, bound] = measure(&problem, materials, &condensed, iterate, steps);
        assert!(bound >= error, "{changes:?}: {bound} < {error}");
    }
    let [error, bound] = measure(&problem, materials, &condensed, &newton(&problem, &condensed).unwrap(), steps);
    assert!(bound >= error, "{changes:?}: {bound} < {error}");
    eprintln!("{steps} {} {error} {changes:?}", bound / error);
    bound / error
}

fn same(x: Vector) -> Vector {
    x
}

#[test]
fn the_bound_stays_sharp_on_meshes_that_do_not_match() {
    for materials in [EQUAL, CONTRAST] {
        for cells in [[[16, 8], [23, 11]], [[8, 4], [31, 15]], [[23, 11], [16, 8]]] {
            let bodies = signorini::bodies(materials, 0.0, cells, same).unwrap();
            let e = effectivity(materials, bodies, 2);
            assert!(e <= 1.1, "{materials:?} {cells:?}: {e}");
        }
    }
}

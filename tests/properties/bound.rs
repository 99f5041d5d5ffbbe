//! The bound against exact errors: at every iteration, converging or not, and for pairs that are not iterates.

use crate::check;
use cre_estimator::{Estimate, Relaxation};
use fem_core::interface::ContactProblem;
use fem_core::norm::energy_error_squared;
use nndd::{Acceleration, NnddSettings};
use proptest::prelude::*;
use std::cell::Cell;
use tests::random::Random;
use tests::run::{certify_with, pair_of};
use tests::{iterates, prepare, signorini};

type Materials = [(f64, f64); 2];

/// Two materials, a bending, cells: an exact solution and a mesh.
fn problems() -> impl Strategy<Value = (Materials, f64, [usize; 2])> {
    let material = || (-1.5..1.5f64, 0.0..0.45f64).prop_map(|(e, nu)| (10f64.powf(e), nu));
    ([material(), material()], -0.5..0.5f64, [10usize..22, 5usize..11])
}

/// The exact error of the pair that an estimate is about.
fn error(problem: &ContactProblem, materials: Materials, k: f64, e: &Estimate) -> f64 {
    let exact = signorini::exact(materials, k);
    let squared = |b: usize| {
        energy_error_squared(&problem.bodies[b], &e.pair.bodies[b].displacement, |x| exact[b].stress(x))
    };
    (squared(0) + squared(1)).sqrt()
}

/// Counts a check of the bound, and keeps the smallest ratio.
fn count(checks: &Cell<(u32, f64)>, effectivity: f64) {
    let (number, smallest) = checks.get();
    checks.set((number + 1, smallest.min(effectivity)));
}

#[test]
fn the_bound_holds_at_every_iteration_for_any_theta() {
    let checks = Cell::new((0u32, f64::INFINITY));
    let settings = (0.02..4.0f64, any::<bool>(), 0usize..3);
    check("bound at every iteration", 600, &(problems(), settings), |((materials, k, cells), setting)| {
        let (theta, accelerated, steps) = setting;
        let problem = signorini::problem(materials, k, cells).unwrap();
        let prepared = prepare(&problem);
        let mut settings = NnddSettings::paper(theta);
        if accelerated {
            settings = NnddSettings::default();
            settings.theta = Some(theta);
            settings.acceleration = Acceleration::None;
        }
        settings.max_iterations = 12;
        let (_, all) = iterates(&prepared, &settings, 1e-9).unwrap();
        for iterate in &all {
            let e = certify_with(&prepared, iterate, Relaxation::Steps(steps)).unwrap();
            prop_assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
            prop_assert!(e.cre.split_defect() < 1e-12, "{:e}", e.cre.split_defect());
            let error = error(&problem, materials, k, &e);
            prop_assert!(
                e.unchecked().e_cre >= error,
                "iteration {}: {} < {error}",
                iterate.iteration,
                e.unchecked().e_cre
            );
            count(&checks, e.unchecked().e_cre / error);
        }
        Ok(())
    });
    let (number, smallest) = checks.get();
    println!("bound checks at iterations: {number}, smallest e_CRE/error 1 + {:.1e}", smallest - 1.0);
    assert!(number > 4000);
}

#[test]
fn the_bound_holds_for_any_admissible_pair() {
    let checks = Cell::new((0u32, f64::INFINITY));
    let pairs = (-3.0..1.5f64, 0.0..1.0f64, any::<u64>(), 0usize..3);
    check("bound of any pair", 1000, &(problems(), pairs), |((materials, k, cells), pair)| {
        let (size, roughness, seed, steps) = pair;
        let problem = signorini::problem(materials, k, cells).unwrap();
        let prepared = prepare(&problem);
        let exact = signorini::exact(materials, k);
        let mut random = Random::new(seed);
        let (shift, wave) = (random.signed(), 6.0 * random.unit());
        let points = problem.bodies[0].mesh().points();
        // The exact trace, disturbed smoothly and roughly, by up to thirty times itself.
        let lambda = (problem.contacts[0].interface.pairs().iter().enumerate())
            .map(|(i, p)| {
                let smooth = shift + (wave * i as f64 / cells[0] as f64).cos();
                let rough = random.signed();
                let u = exact[0].displacement(points[p.nodes[0]]);
                u[0] * p.normal[0]
                    + u[1] * p.normal[1]
                    + 10f64.powf(size) * ((1.0 - roughness) * smooth + roughness * rough)
            })
            .collect();
        let iterate = pair_of(&prepared, lambda).unwrap();
        let e = certify_with(&prepared, &iterate, Relaxation::Steps(steps)).unwrap();
        prop_assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
        let error = error(&problem, materials, k, &e);
        prop_assert!(e.unchecked().e_cre >= error, "{} < {error}", e.unchecked().e_cre);
        count(&checks, e.unchecked().e_cre / error);
        Ok(())
    });
    let (number, smallest) = checks.get();
    println!("bound checks of pairs: {number}, smallest e_CRE/error 1 + {:.1e}", smallest - 1.0);
    assert_eq!(number, 1000);
}

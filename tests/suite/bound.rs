//! e_CRE against exact errors: on every iteration, on three meshes, and for admissible pairs that are not iterates.

use cre_estimator::{Estimate, Relaxation, estimate};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, ContactState};
use fem_core::norm::{energy_error_squared, energy_norm_squared, integrate};
use fem_core::quadrature::GAUSS5;
use nndd::{NnddSettings, NnddStatus};
use tests::random::Random;
use tests::run::{newton, pair_of, rate, stress_error_squared};
use tests::{certify, displacements, hertz_box, iterates, paper, prepare, signorini};

type Materials = [(f64, f64); 2];

const EQUAL: Materials = [(1.0, 0.3), (1.0, 0.3)];
const STIFF_BELOW: Materials = [(1.0, 0.2), (20.0, 0.4)];
const STIFF_ABOVE: Materials = [(30.0, 0.1), (1.0, 0.45)];

/// The exact `‖u − v‖` of a pair of displacement fields.
fn error(problem: &ContactProblem, materials: Materials, k: f64, u: [&[Vector]; 2]) -> f64 {
    let exact = signorini::exact(materials, k);
    (0..2).map(|b| energy_error_squared(&problem.bodies[b], u[b], |x| exact[b].stress(x))).sum::<f64>().sqrt()
}

fn error_of(problem: &ContactProblem, materials: Materials, k: f64, e: &Estimate) -> f64 {
    error(problem, materials, k, [&e.pair.bodies[0].displacement, &e.pair.bodies[1].displacement])
}

/// Asserts the bound at every iteration on one mesh and at the discrete solution, and returns the latter's error and
/// bound.
fn run(materials: Materials, k: f64, cells: [usize; 2], settings: &NnddSettings) -> [f64; 2] {
    let problem = signorini::problem(materials, k, cells).unwrap();
    let prepared = prepare(&problem);
    let (_, mut all) = iterates(&prepared, settings, 1e-9).unwrap();
    assert!(all.len() > 5);
    all.push(newton(&prepared).unwrap());
    let mut last = [0.0; 2];
    for iterate in &all {
        let e = certify(&prepared, iterate).unwrap();
        assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
        assert!(e.cre.split_defect() < 1e-12, "{:e}", e.cre.split_defect());
        let error = error_of(&problem, materials, k, &e);
        assert!(
            e.unchecked().e_cre >= error,
            "{materials:?} {k} {cells:?}, {}: {} < {error}",
            iterate.iteration,
            e.unchecked().e_cre
        );
        last = [error, e.unchecked().e_cre];
    }
    last
}

#[test]
fn the_exact_field_has_the_reference_energy() {
    let materials = [(1.0, 0.3), (8.0, 0.3)];
    let problem = signorini::problem(materials, 0.0, [64, 32]).unwrap();
    let exact = signorini::exact(materials, 0.0);
    for b in 0..2 {
        let body = &problem.bodies[b];
        let energy = integrate(body.mesh(), |t, x| {
            let s = exact[b].stress(x);
            body.material(t).complementary(s, s)
        });
        let expected = signorini::ENERGY / materials[b].0;
        assert!((energy / expected - 1.0).abs() < 1e-7, "{energy} against {expected}");
    }
}

#[test]
fn the_discrete_energy_tends_to_the_reference_energy() {
    let defect = |n: usize| {
        let problem = signorini::problem(EQUAL, 0.0, [2 * n, n]).unwrap();
        let prepared = prepare(&problem);
        let (solution, _) = iterates(&prepared, &NnddSettings::default(), 1e-10).unwrap();
        let u = displacements(&prepared, &solution.last);
        let energy: f64 = (0..2).map(|b| energy_norm_squared(&problem.bodies[b], &u[b])).sum();
        (energy / (2.0 * signorini::ENERGY) - 1.0).abs()
    };
    let defects = [8, 16, 32].map(defect);
    assert!(defects[2] < 2e-3, "{defects:?}");
    assert!(rate(defects[1], defects[2]) > 1.6, "{defects:?}");
}

#[test]
fn the_bound_holds_at_every_iteration_and_converges_with_rate_one() {
    for (materials, k) in
        [(EQUAL, 0.0), (EQUAL, 0.7), (STIFF_BELOW, 0.0), (STIFF_BELOW, -0.4), (STIFF_ABOVE, 0.3)]
    {
        // With an odd number of cells along the interface the contact ends inside an edge.
        for odd in [0, 1] {
            let meshes = [8, 16, 32].map(|n| run(materials, k, [2 * n + odd, n], &NnddSettings::default()));
            let [_, middle, fine] = meshes;
            let rates = [0, 1].map(|i| rate(middle[i], fine[i]));
            assert!(rates.iter().all(|r| (r - 1.0).abs() < 0.05), "{materials:?} {k} {odd}: {rates:?}");
        }
    }
}

#[test]
fn the_bound_holds_at_every_iteration_of_the_papers_method() {
    for (materials, theta) in [(EQUAL, 0.5), ([(2.0, 0.3), (1.0, 0.2)], 0.4)] {
        for cells in [[16, 8], [33, 16], [64, 32]] {
            run(materials, 0.5, cells, &NnddSettings::paper(theta));
        }
    }
}

#[test]
fn the_effectivity_without_relaxation_is_the_prototypes() {
    // Prototype's table: e_CRE/error, converged, to the digits given.
    for (materials, cells, expected) in [
        (EQUAL, [16, 8], 4.18),
        (EQUAL, [32, 16], 4.26),
        (EQUAL, [64, 32], 4.29),
        (STIFF_BELOW, [32, 16], 3.59),
    ] {
        let [error, bound] = run(materials, 0.0, cells, &NnddSettings::default());
        assert!((bound / error - expected).abs() < 5.1e-3, "{} against {expected}", bound / error);
    }
}

/// `2∫ p o_ex + 2∫ p_ex o` over the interface, by Gauss's rule on each eighth of an edge.
fn mixed_contact_terms(problem: &ContactProblem, materials: Materials, e: &Estimate) -> f64 {
    let points = problem.bodies[0].mesh().points();
    let mut sum = 0.0;
    for edge in problem.contacts[0].interface.facets() {
        let [i, j] = edge.pairs.map(|k| k as usize);
        let at = |k: usize| points[problem.contacts[0].interface.pairs()[k].nodes[0]][0];
        for part in 0..8 {
            for (s, w) in GAUSS5 {
                let s = (f64::from(part) + s) / 8.0;
                let linear = |v: &[f64]| (1.0 - s) * v[i] + s * v[j];
                let x = (1.0 - s) * at(i) + s * at(j);
                let density = linear(&e.pair.contacts[0].pressure) * signorini::opening(materials, x)
                    + signorini::pressure(x) * linear(&e.pair.contacts[0].opening);
                sum += 2.0 * w * edge.measure / 8.0 * density;
            }
        }
    }
    sum
}

/// `‖u−v‖² + ‖σ−τ‖² + 2∫p o_ex + 2∫p_ex o`, which e² is but for the interpolation of the exact displacements on top
/// and bottom: that leaves a difference of order h².
fn four_terms(problem: &ContactProblem, materials: Materials, k: f64, e: &Estimate) -> f64 {
    let exact = signorini::exact(materials, k);
    let stress: f64 = (0..2)
        .map(|b| {
            stress_error_squared(&problem.bodies[b], &e.pair.bodies[b].equilibrated, |x| exact[b].stress(x))
        })
        .sum();
    error_of(problem, materials, k, e).powi(2) + stress + mixed_contact_terms(problem, materials, e)
}

#[test]
fn the_bound_is_an_identity_with_four_terms() {
    let defect = |materials: Materials, n: usize, amplitude: f64| {
        let problem = signorini::problem(materials, 0.0, [2 * n, n]).unwrap();
        let prepared = prepare(&problem);
        let discrete = newton(&prepared).unwrap();
        let wave = |i: usize| amplitude * (3.0 * i as f64 / n as f64).cos();
        let lambda = discrete.lambda.iter().enumerate().map(|(i, l)| l + wave(i)).collect();
        let e = certify(&prepared, &pair_of(&prepared, lambda).unwrap()).unwrap();
        let sum = four_terms(&problem, materials, 0.0, &e);
        let defect = (e.cre.e_cre_squared - sum).abs();
        assert!(defect < 1e-3 * sum, "{defect:e} of {sum:e}");
        defect
    };
    for (materials, amplitude) in [(EQUAL, 0.0), (STIFF_BELOW, 0.0), (EQUAL, 0.05), (STIFF_BELOW, 0.05)] {
        let (coarse, fine) = (defect(materials, 8, amplitude), defect(materials, 32, amplitude));
        assert!(fine < coarse / 10.0, "{coarse:e} {fine:e}");
    }
}

#[test]
fn the_bound_holds_for_any_lambda() {
    for (materials, k) in [(EQUAL, 0.0), (STIFF_BELOW, 0.3), (STIFF_ABOVE, 0.0)] {
        let problem = signorini::problem(materials, k, [17, 8]).unwrap();
        let prepared = prepare(&problem);
        let (solution, _) = iterates(&prepared, &NnddSettings::default(), 1e-9).unwrap();
        let size = solution.last.lambda.iter().fold(0.0f64, |m, l| m.max(l.abs())).max(0.1);
        let mut random = Random::new(2026);
        for trial in 0..60 {
            // From round-off to ten times the solution, rough and smooth.
            let amplitude = size * 10f64.powf(3.0 * random.unit() - 2.0);
            let (shift, wave) = (random.signed(), 6.0 * random.unit());
            let lambda: Vec<f64> = (solution.last.lambda.iter().enumerate())
                .map(|(i, l)| {
                    let smooth = (wave * i as f64 / 17.0).cos();
                    l + amplitude * (shift + if trial % 2 == 0 { smooth } else { random.signed() })
                })
                .collect();
            let iterate = pair_of(&prepared, lambda).unwrap();
            let e = certify(&prepared, &iterate).unwrap();
            assert!(e.admissibility.is_valid(), "{trial}: {:?}", e.admissibility);
            assert!(e.cre.split_defect() < 1e-12, "{trial}: {:e}", e.cre.split_defect());
            let error = error_of(&problem, materials, k, &e);
            assert!(e.unchecked().e_cre >= error, "{trial}: {} < {error}", e.unchecked().e_cre);
        }
    }
}

#[test]
fn the_bound_holds_for_any_opening_and_any_pressure() {
    let (materials, k) = (STIFF_BELOW, 0.2);
    let problem = signorini::problem(materials, k, [16, 8]).unwrap();
    let prepared = prepare(&problem);
    let trace = newton(&prepared).unwrap().contact.normal_trace;
    let mut random = Random::new(7);
    for trial in 0..40 {
        // Openings and forces that are independent and overlap; half of either are zero. Ω₁, the softer
        // body, gives way. An opening of a cell's size under a pressure of E makes the contact term largest.
        let size = 10f64.powf(3.0 * random.unit() - 1.0);
        let mut sparse =
            |size: f64| (0..trace.len()).map(|_| size * random.signed().max(0.0)).collect::<Vec<f64>>();
        let (opening, force) = (sparse(0.1 * size), sparse(0.1 * size));
        let lambda: Vec<f64> = trace.iter().zip(&opening).map(|(v, o)| v - o).collect();
        let u = [&lambda, &trace].map(|v| v.as_slice());
        let u = [0, 1].map(|role| prepared.bodies()[role].whole().unwrap().displacement_from_trace(u[role]));
        let state = ContactState::between([&u[0], &u[1]], &force, &opening);
        let e = estimate(&prepared, &state).unwrap();
        assert!(e.admissibility.is_valid(), "{trial}: {:?}", e.admissibility);
        assert!(e.cre.split_defect() < 1e-12, "{trial}: {:e}", e.cre.split_defect());
        let error = error(&problem, materials, k, [&u[0], &u[1]]);
        assert!(e.unchecked().e_cre >= error, "{trial}: {} < {error}", e.unchecked().e_cre);
        // Here pressure and opening overlap everywhere, so that the contact term counts.
        let sum = four_terms(&problem, materials, k, &e);
        assert!((e.cre.e_cre_squared - sum).abs() < 1e-3 * sum, "{trial}: {} {sum}", e.cre.e_cre_squared);
    }
}

#[test]
fn the_bound_holds_while_the_iteration_diverges() {
    let problem = signorini::problem(EQUAL, 0.4, [16, 8]).unwrap();
    let prepared = prepare(&problem);
    for theta in [1.3, 2.5, 6.0] {
        let (solution, all) = iterates(&prepared, &NnddSettings::paper(theta), 1e-9).unwrap();
        assert!(matches!(solution.status, NnddStatus::Diverged { .. }), "{theta}: {:?}", solution.status);
        for iterate in &all {
            let e = certify(&prepared, iterate).unwrap();
            let error = error_of(&problem, EQUAL, 0.4, &e);
            assert!(
                e.unchecked().e_cre >= error,
                "{theta}, {}: {} < {error}",
                iterate.iteration,
                e.unchecked().e_cre
            );
        }
    }
}

#[test]
fn the_bound_holds_on_the_papers_problem_against_a_much_finer_mesh() {
    // The exact solution is not known; ‖u_fine − u_p‖ is smaller than ‖u − u_p‖ by the fine mesh's own error only.
    let fine = paper::problem([144, 72]).unwrap();
    let fine_prepared = prepare(&fine);
    let reference = displacements(&fine_prepared, &newton(&fine_prepared).unwrap());
    let coarse = paper::problem(paper::COARSE).unwrap();
    let prepared = prepare(&coarse);
    let (_, all) = iterates(&prepared, &NnddSettings::paper(0.4), 1e-6).unwrap();
    for iterate in &all {
        let u = displacements(&prepared, iterate);
        let interpolated = [0, 1].map(|b| tests::shapes::interpolate_block(&u[b], paper::COARSE, 8));
        let [_, error] = tests::run::norm_and_distance(&fine, &reference, &interpolated);
        let e = certify(&prepared, iterate).unwrap();
        assert!(e.unchecked().e_cre >= error, "{}: {} < {error}", iterate.iteration, e.unchecked().e_cre);
    }
}

#[test]
fn the_bound_holds_on_the_exact_hertz_problem() {
    // λ on the stiffer body, as `imposed = "auto"` chooses it.
    for materials in [EQUAL, [(20.0, 0.2), (1.0, 0.3)]] {
        let exact = hertz_box::exact(materials);
        let mut found: Vec<[f64; 2]> = Vec::new();
        for n in [4, 8, 16] {
            let problem = hertz_box::problem(materials, n).unwrap();
            let prepared = prepare(&problem);
            let (solution, all) = iterates(&prepared, &NnddSettings::default(), 1e-9).unwrap();
            assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
            let mut last = [0.0; 2];
            for iterate in &all {
                let e = tests::run::certify_with(&prepared, iterate, Relaxation::Steps(2)).unwrap();
                assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
                let error = |b: usize| {
                    energy_error_squared(&problem.bodies[b], &e.pair.bodies[b].displacement, |x| {
                        exact[b].stress(x)
                    })
                };
                last = [(error(0) + error(1)).sqrt(), e.unchecked().e_cre];
                assert!(last[1] >= last[0], "{n}, {}: {last:?}", iterate.iteration);
                let energy = e.energy_norm_squared[0] * materials[0].0;
                let is_coarse = n < 16 || materials != EQUAL || iterate.iteration < all.len();
                assert!(is_coarse || (energy / hertz_box::ENERGY - 1.0).abs() < 0.02, "{energy}");
            }
            found.push(last);
        }
        println!("exact-box Hertz {materials:?}: error, bound {found:?}");
        for w in found.windows(2) {
            let [error, bound] = [0, 1].map(|c| rate(w[0][c], w[1][c]));
            assert!(error > 0.9 && bound > 0.9, "{found:?}");
        }
        assert!(found[2][1] < 1.1 * found[2][0], "{found:?}");
    }
}

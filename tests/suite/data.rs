//! Data of real problems: expressions, several materials in a body, materials with directions.

use case_io::Case;
use cre_estimator::{Relaxation, estimate_with};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, ContactState};
use fem_core::material::{Hypothesis, LinearElastic, Orthotropic};
use fem_core::norm::energy_error_squared;
use nndd::{NnddSettings, NnddStatus};
use std::path::PathBuf;
use tests::run::{newton, norm_and_distance, rate};
use tests::{certify, displacements, iterates, layers, prepare, signorini};

fn case(name: &str, overrides: &[(&str, String)]) -> Case {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("cases").join(name);
    let text = std::fs::read_to_string(path).unwrap();
    let overrides: Vec<_> = overrides.iter().map(|(k, v)| ((*k).to_owned(), v.clone())).collect();
    Case::parse(&text, name, &overrides).unwrap()
}

fn build(case: &Case) -> ContactProblem {
    case.build().unwrap().0
}

/// The example of expressions on `2n × n` cells per body.
fn expressions(n: usize) -> (Case, ContactProblem) {
    let cells = format!("[{}, {n}]", 2 * n);
    let case = case(
        "expressions.toml",
        &[("body.0.generator.cells", cells.clone()), ("body.1.generator.cells", cells)],
    );
    let problem = build(&case);
    (case, problem)
}

#[test]
fn layers_of_anisotropic_materials_are_exact_and_certified_as_exact() {
    let wood = |angle: f64, hypothesis| {
        let constants = Orthotropic::in_plane([11000.0, 900.0], 0.37, 750.0, angle);
        LinearElastic::orthotropic(&constants, hypothesis).unwrap()
    };
    let full = |hypothesis| {
        let rows = [[6000.0, 1800.0, 900.0], [1800.0, 3500.0, -500.0], [900.0, -500.0, 2000.0]];
        LinearElastic::from_stiffness(rows, hypothesis).unwrap()
    };
    for h in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
        let plain = |young| LinearElastic::isotropic(young, 0.3, h).unwrap();
        let stacks: [[Vec<LinearElastic>; 2]; 4] = [
            [vec![wood(0.0, h)], vec![wood(1.0, h)]],
            [vec![wood(0.5, h)], vec![full(h)]],
            [vec![plain(1000.0), plain(50.0)], vec![plain(400.0), plain(9000.0)]],
            [vec![wood(-0.7, h), full(h), plain(300.0)], vec![full(h), wood(1.2, h)]],
        ];
        for (k, stack) in stacks.iter().enumerate() {
            let problem = layers::problem([&stack[0], &stack[1]]).unwrap();
            let prepared = prepare(&problem);
            let (solution, _) = iterates(&prepared, &NnddSettings::default(), 1e-12).unwrap();
            let ended = matches!(
                solution.status,
                NnddStatus::StoppedByCriterion | NnddStatus::Stalled { at_round_off: true, .. }
            );
            assert!(ended, "{h:?} {k}: {:?}", solution.status);
            let estimate = certify(&prepared, &solution.last).unwrap();
            assert!(estimate.admissibility.is_valid(), "{h:?} {k}: {:?}", estimate.admissibility);
            let exact = [0, 1].map(|b| layers::energy(&stack[b]));
            let norm = exact.iter().sum::<f64>().sqrt();
            for b in 0..2 {
                let energy = estimate.energy_norm_squared[b];
                assert!((energy - exact[b]).abs() < 1e-9 * exact[b], "{h:?} {k}: {energy} {exact:?}");
                let points = problem.bodies[b].mesh().points();
                for (x, u) in points.iter().zip(&estimate.pair.bodies[b].displacement) {
                    let expected = layers::displacement(&stack[b], *x);
                    for c in 0..2 {
                        assert!((u[c] - expected[c]).abs() < 1e-11, "{h:?} {k} {x:?}: {u:?} {expected:?}");
                    }
                }
                // The data are linear: nothing was lost.
                assert_eq!(problem.bodies[b].interpolated_data(), []);
            }
            for p in &estimate.pair.contacts[0].pressure {
                assert!((p - layers::PRESSURE).abs() < 1e-9 * layers::PRESSURE, "{h:?} {k}: {p}");
            }
            assert!(estimate.cre.e_cre() < 1e-9 * norm, "{h:?} {k}: {:e}", estimate.cre.e_cre() / norm);
        }
    }
}

#[test]
fn expressions_give_the_problem_that_closures_give() {
    let (_, told) = expressions(16);
    let materials = [(1.0, 0.3); 2];
    let built = signorini::problem(materials, 0.0, [32, 16]).unwrap();
    let solved = |problem: &ContactProblem| {
        let prepared = prepare(problem);
        let iterate = newton(&prepared).unwrap();
        (displacements(&prepared, &iterate), certify(&prepared, &iterate).unwrap())
    };
    let ((u, a), (v, b)) = (solved(&told), solved(&built));
    let [norm, distance] = norm_and_distance(&built, &v, &u);
    assert!(distance < 1e-12 * norm, "{distance:e}");
    assert!(
        (a.unchecked().e_cre / b.unchecked().e_cre - 1.0).abs() < 1e-9,
        "{} {}",
        a.unchecked().e_cre,
        b.unchecked().e_cre
    );
    for body in 0..2 {
        for (x, y) in told.bodies[body].facet_conditions().iter().zip(built.bodies[body].facet_conditions()) {
            assert_eq!(x.reaction, y.reaction);
            for (s, t) in x.traction.iter().flatten().zip(y.traction.iter().flatten()) {
                assert!((s - t).abs() < 1e-14, "{s} {t}");
            }
        }
    }
}

#[test]
fn the_bound_by_expressions_holds_and_converges_with_rate_one() {
    let exact = signorini::exact([(1.0, 0.3); 2], 0.0);
    let run = |n: usize| {
        let (case, problem) = expressions(n);
        let prepared = prepare(&problem);
        let iterate = newton(&prepared).unwrap();
        let estimate = certify(&prepared, &iterate).unwrap();
        assert!(estimate.admissibility.is_valid());
        let u = displacements(&prepared, &iterate);
        let squared = |b: usize| energy_error_squared(&problem.bodies[b], &u[b], |x| exact[b].stress(x));
        let error = (squared(0) + squared(1)).sqrt();
        assert!(estimate.unchecked().e_cre >= error, "{n}: {} < {error}", estimate.unchecked().e_cre);
        let notes = case.data_notes(&problem);
        let [note] = &notes[..] else { panic!("{notes:#?}") };
        assert!(note.contains("11 other data"), "{note}");
        let worst = problem.bodies.iter().flat_map(|b| b.interpolated_data());
        let worst = worst.map(|d| d.difference.mean).fold(0.0, f64::max);
        let force: f64 = iterate.contact.normal_reaction.iter().sum();
        ([error, estimate.unchecked().e_cre, worst], force)
    };
    let ([coarse, middle, fine], forces) = {
        let all = [8, 16, 32].map(run);
        (all.map(|a| a.0), all.map(|a| a.1))
    };
    for k in 0..2 {
        let observed = [rate(coarse[k], middle[k]), rate(middle[k], fine[k])];
        assert!((observed[1] - 1.0).abs() < 0.05, "{k}: {observed:?}");
    }
    // The difference between the data and their interpolation is of second order.
    assert!(rate(middle[2], fine[2]) > 1.7, "{} {} {}", coarse[2], middle[2], fine[2]);
    assert!((forces[2] - 2.0 / 3.0).abs() < 2e-3, "{forces:?}");
}

/// Halves every edge of both bodies a number of times, and takes fields of the first mesh along.
fn refined(
    problem: &ContactProblem,
    times: usize,
    mut u: Vec<Vec<Vector>>,
) -> (ContactProblem, Vec<Vec<Vector>>) {
    let mut problem = problem.clone();
    for _ in 0..times {
        let finer = tests::finer::halve(&problem).unwrap();
        u = finer.refinements.iter().zip(&u).map(|(r, u)| r.prolong(u)).collect();
        problem = finer.problem;
    }
    (problem, u)
}

#[test]
fn the_bound_holds_for_inclusions_and_orthotropic_bodies() {
    let case = case("materials.toml", &[]);
    let problem = build(&case);
    assert_eq!(problem.bodies[1].materials().list().len(), 3);
    assert!(case.data_notes(&problem).is_empty());
    let prepared = prepare(&problem);
    let (_, all) = iterates(&prepared, &NnddSettings::default(), 1e-9).unwrap();
    let (fine, _) = refined(&problem, 2, displacements(&prepared, &all[0]));
    let fine_prepared = prepare(&fine);
    let exact = displacements(&fine_prepared, &newton(&fine_prepared).unwrap());
    for iterate in &all {
        let estimate = certify(&prepared, iterate).unwrap();
        assert!(estimate.admissibility.is_valid(), "{:?}", estimate.admissibility);
        // The distance to the solution on a mesh with a quarter of the width, a little below the true error.
        let (_, u) = refined(&problem, 2, displacements(&prepared, iterate));
        let [norm, distance] = norm_and_distance(&fine, &exact, &u);
        assert!(distance > 1e-3 * norm);
        assert!(
            estimate.unchecked().e_cre >= distance,
            "{}: {} < {distance}",
            iterate.iteration,
            estimate.unchecked().e_cre
        );
    }
    // Plain means of tractions are poor next to inclusions: relaxation corrects that (4.4 without it, 1.5 with it; part
    // of what is left is that the finer solution is not exact).
    let last = newton(&prepared).unwrap();
    let u = displacements(&prepared, &last);
    let (_, on_fine) = refined(&problem, 2, u.clone());
    let [_, distance] = norm_and_distance(&fine, &exact, &on_fine);
    let state = ContactState::between([&u[0], &u[1]], &last.contact.normal_reaction, &last.opening);
    let relaxed = estimate_with(&prepared, &state, Relaxation::Steps(10)).unwrap();
    assert!(relaxed.admissibility.is_valid(), "{:?}", relaxed.admissibility);
    let effectivity = relaxed.unchecked().e_cre / distance;
    assert!((1.0..1.6).contains(&effectivity), "{effectivity}");
}

#[test]
fn adaptive_refinement_keeps_materials_and_evaluates_expressions_anew() {
    let mut overrides = vec![("body.1.traction.0.pressure", "'5 * sin(y / 13)'".to_owned())];
    overrides.push(("body.0.generator.cells", "[10, 3]".to_owned()));
    overrides.push(("body.1.generator.cells", "[10, 4]".to_owned()));
    let case = case("materials.toml", &overrides);
    let problem = build(&case);
    let zero = problem.bodies.iter().map(|b| vec![Vector::zeros(); b.mesh().points().len()]).collect();
    let (fine, _) = refined(&problem, 2, zero);
    let area = |problem: &ContactProblem, k: usize| -> f64 {
        let body = &problem.bodies[1];
        let material = &body.materials().list()[k];
        let cells = 0..body.mesh().cells().len();
        cells.filter(|t| body.material(*t) == material).map(|t| body.mesh().measure(t)).sum()
    };
    for k in 0..3 {
        let (coarse, fine) = (area(&problem, k), area(&fine, k));
        assert!(coarse > 100.0 && (coarse - fine).abs() < 1e-9 * coarse, "{k}: {coarse} {fine}");
    }
    let mean = |problem: &ContactProblem| problem.bodies[1].interpolated_data()[0].difference.mean;
    assert!((mean(&problem) / mean(&fine)).log2() > 3.5, "{} {}", mean(&problem), mean(&fine));
}

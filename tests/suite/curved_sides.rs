//! Declared curves: peak stresses that do not depend on the first mesh, and a bound that holds on every polygon.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, Settings, Silent, solve, solve_adaptively,
};
use fem_core::body::CurveKind;
use fem_core::geometry::{Vector, norm};
use fem_core::interface::ContactProblem;
use tests::finer::halve;
use tests::{kirsch, pin};

fn run(problem: ContactProblem, target: f64) -> AdaptiveSolution {
    let answer = solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(target), &mut Silent);
    let answer = answer.unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    answer
}

/// The largest von Mises stresses: of the cells, and of the recovered stress with its place.
fn peaks(answer: &AdaptiveSolution) -> (f64, f64, Vector) {
    let results = answer.solution.results.as_ref().unwrap();
    let peak = results.peak_stress.unwrap();
    (results.max_von_mises.unwrap(), peak.von_mises, peak.point)
}

#[test]
fn the_hole_of_a_plate_triples_the_stress_from_every_first_mesh() {
    for kind in [CurveKind::Arc, CurveKind::Smooth] {
        for cells in [[4, 4], [8, 8], [16, 16]] {
            let plate = kirsch::plate(cells, Some(kind)).unwrap();
            let answer = run(ContactProblem::new(vec![plate]), 0.01);
            let (cell, recovered, place) = peaks(&answer);
            assert!((cell / kirsch::FACTOR - 1.0).abs() < 0.01, "{kind:?} {cells:?}: {cell}");
            assert!((recovered / kirsch::FACTOR - 1.0).abs() < 0.02, "{kind:?} {cells:?}: {recovered}");
            assert!(norm(place - Vector::y()) < 0.1, "{kind:?} {cells:?}: {place}");
            assert!(answer.peak_change().unwrap().abs() < 0.02, "{:?}", answer.peak_change());
        }
    }
    // The corners of a polygon raise it, the more the finer the mesh is.
    let polygon = run(ContactProblem::new(vec![kirsch::plate([8, 8], None).unwrap()]), 0.01);
    assert!(peaks(&polygon).0 > 1.1 * kirsch::FACTOR, "{:?}", peaks(&polygon));
}

#[test]
fn the_bound_holds_on_the_polygon_of_every_mesh() {
    let problem = ContactProblem::new(vec![kirsch::plate([4, 3], Some(CurveKind::Arc)).unwrap()]);
    for target in [0.2, 0.1, 0.05] {
        let answer = run(problem.clone(), target);
        let solution = &answer.solution;
        let energy = |s: &certified_contact::CertifiedSolution| -> f64 {
            s.results.as_ref().unwrap().energy_norm_squared.iter().sum()
        };
        // The same polygon on a finer mesh: its curves are not declared any more.
        let polygon = solution.problem.bodies[0].clone().with_curves(&[]).unwrap();
        let polygon = ContactProblem::new(vec![polygon]);
        let finer = halve(&halve(&polygon).unwrap().problem).unwrap();
        let reference = solve(finer.problem, &Settings::default(), &mut Silent).unwrap();
        // Loads are the same up to their interpolation, far below the error; supports are at rest.
        let error = (energy(&reference) - energy(solution)).sqrt();
        let bound = solution.estimate.as_ref().unwrap().certificate().unwrap().e_cre;
        assert!(error > 0.3 * bound && error < bound, "{target}: {error:e} {bound:e}");
    }
}

#[test]
fn the_peak_stress_of_a_pin_in_its_hole_does_not_depend_on_the_first_mesh() {
    let mut found = Vec::new();
    for (around, across) in [(40, [10, 6]), (80, [20, 12])] {
        let answer = run(pin::problem(around, across, Some(CurveKind::Arc)).unwrap(), 0.02);
        let results = answer.solution.results.as_ref().unwrap();
        let relative = answer.solution.relative().unwrap();
        let resultant = results.contacts[0].resultant;
        for (on, sign) in [("inner", 1.0), ("end", -1.0)] {
            let reaction = results.reactions.iter().find(|r| r.on == on).unwrap().force;
            let off = norm(reaction + sign * resultant);
            assert!(off < relative * norm(resultant), "{on}: {reaction} {resultant}");
        }
        let nodes_off: usize = answer.solution.problem.bodies.iter().map(|b| b.nodes_on_chords().len()).sum();
        assert_eq!(nodes_off, 0);
        found.push(peaks(&answer));
    }
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 0.02;
    assert!(close(found[0].1, found[1].1), "{found:?}");
    assert!(close(found[0].0, found[1].0), "{found:?}");
}

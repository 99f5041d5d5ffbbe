//! Arcs that continue a straight contact side: gaps are the arc's own on every mesh, and so is the pressure.

use certified_contact::{AdaptSettings, AdaptiveEnd, Settings, Silent, solve_adaptively};
use fem_core::interface::ContactProblem;
use tests::rounded_punch::{FLAT, HALF_WIDTH, PEAK, RADIUS, outline, problem};

/// The largest difference between a gap along the vertical and the arc's own, over the radius.
fn worst_gap(problem: &ContactProblem) -> f64 {
    let mesh = problem.bodies[0].mesh();
    let of_pair = |pair: &fem_core::interface::NodePair| {
        let point = mesh.points()[pair.nodes[0]];
        // From a point of the outline along the normal to the block.
        let along = pair.normal / pair.normal_length();
        let exact = outline(point[0]) / -along[1];
        (pair.gap / pair.normal_length() - exact).abs() / RADIUS
    };
    problem.contacts[0].interface.pairs().iter().map(of_pair).fold(0.0, f64::max)
}

#[test]
fn the_kink_of_the_first_mesh_does_not_stay() {
    for edge in [0.7, 0.35, 0.15] {
        let first = problem(edge).unwrap();
        assert!(worst_gap(&first) < 1e-9, "{edge}: {:e}", worst_gap(&first));
        let answer =
            solve_adaptively(first, &Settings::default(), &AdaptSettings::new(0.03), &mut Silent).unwrap();
        assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{edge}: {:?}", answer.end);
        let solution = &answer.solution;
        assert!(worst_gap(&solution.problem) < 1e-9, "{edge}: {:e}", worst_gap(&solution.problem));
        let results = solution.results.as_ref().unwrap();
        // Single nodal pressures are up to 7 % above it.
        let recovered = results.contacts[0].max_recovered_pressure.unwrap();
        for peak in [results.max_facet_pressure / PEAK, recovered / PEAK] {
            assert!((peak - 1.0).abs() < 0.03, "{edge}: {peak}");
        }
        let pairs = solution.problem.contacts[0].interface.pairs();
        let closed =
            pairs.iter().zip(&solution.last().contact.normal_reaction).filter(|(_, force)| **force > 0.0);
        let reach =
            closed.map(|(pair, _)| solution.problem.bodies[0].mesh().points()[pair.nodes[0]][0].abs());
        let reach = reach.fold(0.0, f64::max);
        // To an edge of the last mesh.
        assert!(((reach - FLAT) / (HALF_WIDTH - FLAT) - 1.0).abs() < 0.15, "{edge}: {reach}");
    }
}

//! Bent and closed contact lines whose meshes do not match: Lamé's rings, sliding arcs, Hertz.

use crate::curved::{TWO, relaxed};
use contact_geometry::ContactNormal;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::norm::energy_error_squared;
use tests::finer::finer;
use tests::rings::{self, Lame};
use tests::run::{newton, norm_and_distance, paired_in_common, rate};
use tests::{displacements, hertz, prepare};

const SIDES: [&str; 2] = ["outer", "inner"];

/// The error against Lamé's solution, the bound, and the largest relative error of the pressure.
fn measure(problem: &ContactProblem, exact: [Lame; 2], pressure: f64) -> [f64; 3] {
    let prepared = prepare(problem);
    let iterate = newton(&prepared).unwrap();
    let e = relaxed(&prepared, &iterate);
    let u = displacements(&prepared, &iterate);
    let error: f64 =
        (0..2).map(|b| energy_error_squared(&problem.bodies[b], &u[b], |x| exact[b].stress(x))).sum();
    let worst = e.pair.contacts[0].pressure.iter().map(|q| (q / pressure - 1.0).abs()).fold(0.0, f64::max);
    [error.sqrt(), e.unchecked().e_cre, worst]
}

/// Asserts a bound that holds and is sharp, and the rate 1, over three meshes, each twice as fine.
fn assert_rings(found: &[[f64; 3]; 3]) {
    println!("rings cut differently: error, bound, error of the pressure {found:?}");
    for [error, bound, _] in found {
        assert!(bound >= error && *bound < 1.4 * error, "{found:?}");
    }
    for w in found.windows(2) {
        let [error, bound] = [0, 1].map(|c| rate(w[0][c], w[1][c]));
        assert!(error > 0.9 && bound > 0.9, "{error} {bound}: {found:?}");
    }
}

#[test]
fn quarter_rings_with_unequal_counts_converge_to_lames_solution() {
    let (hole, outer) = (0.0, 7.0);
    let p = rings::pressure(TWO, hole, outer);
    for gap in [Gap::Given(0.0.into()), Gap::Geometric] {
        for counts in [[16, 23], [23, 16], [9, 31]] {
            let found = [1, 2, 4].map(|k| {
                let cells = counts.map(|n| [n * k, 6 * k]);
                let bodies = rings::quarter_bodies(TWO, hole, outer, cells).unwrap();
                let (problem, _) = paired_in_common(bodies, SIDES, &gap, ContactNormal::Averaged).unwrap();
                measure(&problem, rings::exact(p, hole, outer), p)
            });
            assert_rings(&found);
        }
    }
}

#[test]
fn whole_rings_with_unequal_counts_converge_to_lames_solution() {
    let d = 0.01;
    let p = rings::whole_pressure(TWO, d);
    // The inward motion of the outside alone makes the exact stress: nothing rubs.
    for (counts, turned) in [([24, 35], 0.0), ([35, 24], 1.0), ([30, 30], 6.0), ([30, 30], 1.2)] {
        let found = [1, 2, 4].map(|k| {
            let cells = counts.map(|n| [n * k, 3 * k]);
            let bodies = rings::whole_bodies(TWO, [d, 0.0], cells, turned).unwrap();
            let (problem, _) =
                paired_in_common(bodies, SIDES, &Gap::Given(0.0.into()), ContactNormal::Averaged).unwrap();
            let interface = &problem.contacts[0].interface;
            assert_eq!(interface.pairs().len(), interface.facets().len());
            for pair in interface.pairs() {
                let x = problem.bodies[0].mesh().points()[pair.nodes[0]];
                let r = x[0].hypot(x[1]);
                // Shorter than one between the nodes of the reference.
                let along = pair.normal[0] / pair.normal.norm();
                assert!((along - x[0] / r).abs() < 5e-3, "{pair:?} at {x:?}");
            }
            measure(&problem, rings::whole_exact(TWO, d), p)
        });
        assert_rings(&found);
    }
}

#[test]
fn the_bound_holds_where_arcs_overlap_in_part_and_slide() {
    for (sectors, cells) in [
        ([[40.0, 140.0], [60.0, 120.0]], [[12, 4], [10, 4]]),
        ([[55.0, 125.0], [30.0, 100.0]], [[8, 4], [13, 4]]),
        ([[0.0, 360.0], [40.0, 140.0]], [[40, 4], [17, 4]]),
    ] {
        let bodies = rings::sliding_bodies(TWO, [0.02, -0.03], sectors, cells).unwrap();
        let gap = Gap::Given(0.0.into());
        let (problem, changes) = paired_in_common(bodies, SIDES, &gap, ContactNormal::Averaged).unwrap();
        let changes = changes.unwrap();
        let common = sectors[0][1].min(sectors[1][1]) - sectors[0][0].max(sectors[1][0]);
        let length = common.to_radians() * rings::B;
        assert!(
            (problem.contacts[0].interface.measure() / length - 1.0).abs() < 0.01,
            "{sectors:?} {changes:?}"
        );
        let whole = sectors.map(|s| (s[1] - s[0]).to_radians() * rings::B);
        for b in 0..2 {
            assert!((changes.free[b] - (whole[b] - length)).abs() < 0.02 * whole[b], "{changes:?}");
        }
        let prepared = prepare(&problem);
        let e = relaxed(&prepared, &newton(&prepared).unwrap());
        let (fine, u) =
            finer(problem.clone(), e.pair.bodies.iter().map(|b| b.displacement.clone()).collect(), 3)
                .unwrap();
        let fine_prepared = prepare(&fine);
        let reference = displacements(&fine_prepared, &newton(&fine_prepared).unwrap());
        let [norm, error] = norm_and_distance(&fine, &reference, &u);
        assert!(
            e.unchecked().e_cre >= error && e.unchecked().e_cre < 1.6 * error && error > 0.01 * norm,
            "{} {error} {norm}",
            e.unchecked().e_cre
        );
    }
}

/// Pressed cylinders whose contact sides have different steps: the force of the manual to the accuracy of matching ones.
#[test]
fn hertz_contact_between_meshes_of_different_steps() {
    let normal = ContactNormal::Fixed(Vector::new(0.0, -1.0));
    let bodies = hertz::bodies(1.5, [30, 41], 0.4).unwrap();
    let (problem, _) = paired_in_common(bodies, ["contact"; 2], &Gap::Geometric, normal).unwrap();
    for pair in problem.contacts[0].interface.pairs() {
        let x = problem.bodies[0].mesh().points()[pair.nodes[0]][0];
        let exact = 10.0 - (100.0 - x * x).sqrt() + 13.0 - (169.0 - x * x).sqrt();
        assert!((pair.gap - exact).abs() < 1e-6, "{} {exact}", pair.gap);
    }
    let prepared = prepare(&problem);
    let iterate = newton(&prepared).unwrap();
    let e = relaxed(&prepared, &iterate);
    let matching = hertz::problem(1.5, 41, 0.4).unwrap();
    let prepared = prepare(&matching);
    let other = newton(&prepared).unwrap().contact_force();
    let force = iterate.contact_force();
    assert!((force / other - 1.0).abs() < 2e-3, "{force} {other}");
    let [_, p0] = hertz::closed_form(force);
    let largest = e.pair.contacts[0].pressure.iter().copied().fold(0.0, f64::max);
    assert!((largest / p0 - 1.0).abs() < 0.05, "{largest} {p0}");
}

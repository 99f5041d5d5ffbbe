//! Pairs face each other: the answer does not depend on how the nodes of the two surfaces are offset.

use certified_contact::{Settings, Silent, solve};
use contact_geometry::ContactNormal;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use tests::run::paired_in_common;
use tests::shapes::moved;

const SIDES: [&str; 2] = ["bottom", "top"];
const DOWN: ContactNormal = ContactNormal::Fixed(Vector::new(0.0, -1.0));

/// A block over a block, each 1 wide and 0.7 high. The lower side of the upper one is the parabola `0.3 x²`. Inner nodes are
/// shifted along the line by a part of an edge: the upper body's by `offset`, the lower body's by `−offset`.
fn bodies(cells: usize, offset: f64) -> [Body; 2] {
    let body = |y: f64, bend: f64, offset: f64, conditions: BoundaryConditions| {
        let shift = |x: f64| if x > 1e-9 && x < 1.0 - 1e-9 { offset / cells as f64 } else { 0.0 };
        let place = |p: Vector| {
            let x = p[0] + shift(p[0]);
            Vector::new(x, p[1] + bend * x * x * (0.7 - p[1]) / 0.7)
        };
        let mesh = moved(&block([0.0, y], [1.0, 0.7], [cells, cells * 2 / 3]).unwrap(), place).unwrap();
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(mesh, steel, &conditions).unwrap()
    };
    let left = || BoundaryConditions::new().displace("left", Some(0.0.into()), None);
    let pressed = left().displace("top", None, Some((-0.05).into()));
    let held = left().displace("bottom", None, Some(0.0.into()));
    [body(0.0, 0.3, offset, pressed), body(-0.7, 0.0, -offset, held)]
}

/// The contact force of the problem and the interval in which the exact one lies.
fn force(problem: ContactProblem) -> (f64, [f64; 2]) {
    let answer = solve(problem, &Settings::default(), &mut Silent).unwrap();
    assert!(answer.is_certified());
    let interval = answer.bounds.as_ref().unwrap().contact_force.unwrap();
    (answer.last().contact.normal_reaction.iter().sum(), interval)
}

#[test]
fn the_contact_force_does_not_depend_on_the_offset_of_the_nodes() {
    let [upper, lower] = bodies(24, 0.0);
    let interface = contact_geometry::pair_along(&upper, &lower, SIDES, &Gap::Geometric, DOWN).unwrap();
    let (exact, interval) = force(ContactProblem::between([upper, lower], interface));
    assert!(interval[0] < exact && exact < interval[1]);
    for offset in [0.025, 0.05, 0.12, 0.245, -0.025, -0.05, -0.12, -0.24] {
        let (problem, changes) = paired_in_common(bodies(24, offset), SIDES, &Gap::Geometric, DOWN).unwrap();
        assert!(changes.is_some());
        let (found, other) = force(problem);
        println!("offset {offset}: {found:.6} in {other:.6?}, without {exact:.6} in {interval:.6?}");
        // Paired as they are, at 0.24 the force is 1.6 % off.
        assert!((found / exact - 1.0).abs() < 2e-3, "offset {offset}: {found} and {exact}");
        assert!(interval[0] < other[1] && other[0] < interval[1], "offset {offset}: {interval:?} {other:?}");
    }
}

#[test]
fn contact_nodes_clamped_at_the_end_of_the_line_give_a_bound() {
    // Two cantilevers, one on the other, clamped at x = 0. The reference is the same mesh, refined three times.
    let body = |y: f64, cells: usize, conditions: BoundaryConditions| {
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let mesh = block([0.0, y], [2.0, 0.5], [4 * cells, cells]).unwrap();
        Body::new(mesh, steel, &conditions.fix("left")).unwrap()
    };
    let problem = |cells: usize| {
        let upper = body(0.5, cells, BoundaryConditions::new().pressure("top", 0.01));
        let lower = body(0.0, cells, BoundaryConditions::new());
        let gap = Gap::Given(0.0.into());
        let interface = contact_geometry::pair(&upper, &lower, SIDES, &gap).unwrap();
        ContactProblem::between([upper, lower], interface)
    };
    let solved = |cells: usize| {
        let answer = solve(problem(cells), &Settings::default(), &mut Silent).unwrap();
        assert!(answer.is_certified(), "{:?}", answer.estimate.map(|e| e.admissibility));
        answer.bounds.unwrap()
    };
    let fine = solved(32);
    for cells in [2, 4, 8] {
        let found = solved(cells);
        // No displacement of one body moves the clamped end.
        assert!(found.contact_force.is_err());
        for (what, coarse, fine) in [
            ("norm", found.energy_norm, fine.energy_norm),
            ("energy", found.potential_energy, fine.potential_energy),
        ] {
            println!("{cells} cells, {what}: {coarse:?} {fine:?}");
            // Both hold the exact value.
            assert!(coarse[0] <= fine[1] && fine[0] <= coarse[1], "{cells} {what}: {coarse:?} {fine:?}");
        }
    }
}

//! Contact nodes that both bodies clamp.

use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::ContactProblem;
use fem_core::interface::{ContactInterface, Gap, InterfaceError};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::{block, ring};
use fem_core::mesh::refine::RefinementEdges;

fn body(y: f64, conditions: BoundaryConditions) -> Body {
    let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    Body::new(block([0.0, y], [2.0, 1.0], [4, 2]).unwrap(), material, &conditions).unwrap()
}

fn pair(upper: &Body, lower: &Body) -> Result<ContactInterface, InterfaceError> {
    contact_geometry::pair(upper, lower, ["bottom", "top"], &Gap::Given(0.0.into()))
}

#[test]
fn contact_nodes_clamped_in_both_bodies_at_the_ends_of_the_line_have_no_unknown() {
    let clamped = || BoundaryConditions::new().fix("left").fix("right");
    let bodies = [body(1.0, clamped()), body(0.0, clamped())];
    let interface = pair(&bodies[0], &bodies[1]).unwrap();
    assert_eq!((interface.pairs().len(), interface.facets().len(), interface.measure()), (3, 4, 2.0));
    let lengths: Vec<f64> = interface.pairs().iter().map(|p| p.weight).collect();
    assert_eq!(lengths, [0.5; 3]);
    // A constant pressure reaches the clamped ends, whose forces the supports take.
    assert_eq!(interface.mass(&[3.0; 3]), [1.5; 3]);
    let first = interface.facets()[0];
    assert_eq!((first.pairs, first.openings(&[0.2, 0.0, 0.0])), ([0; 2], [0.0, 0.2]));
    // Halved: the new nodes of the removed edges are free and belong to the contact problem.
    let mut problem = ContactProblem::between(bodies, interface);
    for count in [7, 15] {
        let edges = |p: &ContactProblem| -> Vec<_> {
            p.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect()
        };
        let marked = |p: &ContactProblem, only: usize| {
            [0, 1].map(|b| vec![b == only; p.bodies[b].mesh().topology().facets().len()])
        };
        let labels = edges(&problem);
        // Marked in one body only: contact edges are halved in both.
        let finer = contact_geometry::refined(&problem, &labels, &marked(&problem, 0)).unwrap();
        assert_eq!(finer.problem.contacts[0].interface.pairs().len(), count);
        let constant = vec![3.0; problem.contacts[0].interface.pairs().len()];
        assert_eq!(finer.pairs[0].prolong(&constant), vec![3.0; count]);
        problem = finer.problem;
        let [a, b] = problem.bodies.as_slice() else { unreachable!() };
        assert_eq!(pair(a, b).unwrap().pairs().len(), count);
    }
}

#[test]
fn clamped_contact_nodes_that_cannot_drop_out_are_refused() {
    let left = || BoundaryConditions::new().fix("left");
    // In one body only, the other one has the unknown.
    let one = pair(&body(1.0, left()), &body(0.0, BoundaryConditions::new().fix("bottom")));
    assert_eq!(one.unwrap().pairs().len(), 5);
    // Pressed into each other: the opening along the edge would be negative.
    let pressed = BoundaryConditions::new().displace("left", Some(0.0.into()), Some((-0.1).into()));
    let overlap = pair(&body(1.0, pressed), &body(0.0, left()));
    assert!(
        matches!(overlap, Err(InterfaceError::ClampedOverlap { depth, .. }) if (depth - 0.1).abs() < 1e-15)
    );
    let parted = BoundaryConditions::new().displace("left", Some(0.0.into()), Some(ScalarData::from(0.1)));
    assert_eq!(pair(&body(1.0, parted), &body(0.0, left())).unwrap().pairs().len(), 4);
    // A curved line, on which the opening between two openings >= 0 may be negative.
    let steel = || LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let arc = |radii| {
        let mesh = ring([0.0; 2], radii, [0.0, 90.0], [6, 1]).unwrap();
        Body::new(mesh, steel(), &BoundaryConditions::new().fix("start")).unwrap()
    };
    let [inner, outer] = [arc([1.0, 2.0]), arc([2.0, 3.0])];
    let bent = contact_geometry::pair(&inner, &outer, ["outer", "inner"], &Gap::Given(0.0.into()));
    assert!(matches!(bent, Err(InterfaceError::SupportedNode { .. })), "{bent:?}");
}

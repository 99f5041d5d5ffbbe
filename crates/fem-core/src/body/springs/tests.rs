use super::*;
use crate::assembly::System;
use crate::body::Body;
use crate::body::tractions;
use crate::boundary::ScalarData;
use crate::boundary::{BoundaryConditions, SpringDirection, SpringRest};
use crate::field::nodal_residual;
use crate::geometry::Vector;
use crate::interface::InterfaceSide;
use crate::material::{Hypothesis, LinearElastic};
use crate::mesh::generate::block;
use crate::mesh::id::NodeId;
use crate::norm::{energy_norm_squared, spring_energy};
use crate::residual;

/// A block on springs at an angle to each other, with displacements at rest.
fn body() -> Body {
    let slanted = SpringDirection::Vector(Vector::new(3.0, 4.0));
    let mut conditions = BoundaryConditions::new()
        .fix("left")
        .pressure("top", 3.0)
        .spring("bottom", 40.0, slanted)
        .spring("bottom", ScalarData::function(|x| 10.0 + x[0]), SpringDirection::Normal)
        .spring("right", 7.0, SpringDirection::All);
    conditions.springs[0].rest = SpringRest::Component(ScalarData::function(|x| 0.1 * x[0]));
    conditions.springs[2].rest = SpringRest::Vector([0.3.into(), ScalarData::function(|x| x[1])]);
    let material = LinearElastic::isotropic(100.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    Body::new(block([0.3, 0.1], [2.0, 1.0], [5, 3]).unwrap(), material, &conditions).unwrap()
}

fn field(body: &Body) -> Vec<Vector> {
    let held = body.node_constraints().iter().zip(body.mesh().points());
    let free = |x: &Vector| Vector::new(x[0] * x[1], x[0] - x[1] * x[1]);
    held.map(|(node, x)| if node.held.is_none() { free(x) } else { Vector::zeros() }).collect()
}

#[test]
fn stiffness_and_load_of_springs_agree_with_their_forces() {
    let body = body();
    let u = field(&body);
    let expected = nodal_residual(&body, &u);
    let scale = expected.iter().fold(0.0f64, |most, r| most.max(r.norm()));
    for (found, expected) in residual::of_displacement(&body, &u).iter().zip(&expected) {
        assert!((0..2).all(|c| (found[c] + -expected[c]).rounded().abs() < 1e-14 * scale));
    }
    let System { dofs, stiffness, load } = System::assemble(&body, &InterfaceSide::default()).unwrap();
    let unknown = |j: usize| {
        let (node, c) = dofs.unknown(j);
        (node, dofs.axis(node, c))
    };
    let x: Vec<f64> = (0..dofs.len()).map(unknown).map(|(n, axis)| u[n].dot(&axis)).collect();
    for (j, product) in stiffness.multiply(&x).into_iter().enumerate() {
        let (node, axis) = unknown(j);
        assert!((product - load[j] - expected[node].dot(&axis)).abs() < 1e-13 * scale);
    }
}

#[test]
fn the_force_of_springs_is_that_of_each_condition() {
    let body = body();
    let u = field(&body);
    let mut forces = vec![Vector::zeros(); u.len()];
    for of in body.springs().iter().flat_map(|side| &side.facets) {
        let nodes = body.mesh().topology().facets()[of.facet];
        let traction = of.traction(&nodes.map(|n| u[n]));
        for (n, force) in
            nodes.into_iter().zip(moments::<Plane>(&traction, body.mesh().facet_measure(of.facet)))
        {
            forces[n] += force;
        }
    }
    for (node, force) in crate::assembly::spring_forces(&body, &u) {
        forces[node] -= force;
    }
    assert!(forces.iter().all(|rest| rest.norm() < 1e-13));
    // On the bottom both springs act in all directions; the inverse undoes the stiffness, and moments give the traction back.
    let (facet, springs) = body.facet_springs().next().unwrap();
    assert!(springs.directions.is_all());
    let (traction, measure) = (springs.traction(), body.mesh().facet_measure(facet));
    for (own, strained) in springs.stretch.iter().zip(springs.strained(&traction)) {
        assert!((own + strained).norm() < 1e-14);
    }
    for (own, again) in
        traction.iter().zip(tractions::<Plane>(&moments::<Plane>(&traction, measure), measure))
    {
        assert!((own - again).norm() < 1e-13);
    }
    let squared = springs.energy(&springs.stretch, measure);
    assert!((squared - springs.complementary(&traction, measure)).abs() < 1e-13 * squared);
}

#[test]
fn springs_are_in_the_energy_norm() {
    let body = body();
    let mut u = vec![Vector::zeros(); body.mesh().points().len()];
    // One corner of the right side: ∫ k φ² on its two edges.
    let corner = body.mesh().points().iter().position(|x| x[0] > 2.2 && x[1] < 0.2).unwrap();
    u[NodeId::new(corner)] = Vector::new(2.0, 0.0);
    let slanted = 0.4 / 3.0 * 40.0 * (0.6f64 * 2.0).powi(2);
    let expected = slanted + 1.0 / 9.0 * 7.0 * 4.0;
    assert!((spring_energy(&body, &u) - expected).abs() < 1e-13 * expected, "{expected}");
    assert!(energy_norm_squared(&body, &u) > spring_energy(&body, &u));
}

//! Pairs with friction, also on finer meshes.

use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::boundary::ScalarData;
use fem_core::geometry::Vector;
use fem_core::interface::Friction;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::mesh::refine::RefinementEdges;
use fem_core::prepared::PreparedProblem;

fn problem() -> ContactProblem {
    let material = LinearElastic::isotropic(10.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let body = |y: f64, fixed: &str| {
        let mesh = block([0.0, y], [2.0, 1.0], [4, 2]).unwrap();
        Body::new(mesh, material.clone(), &BoundaryConditions::new().fix(fixed)).unwrap()
    };
    let (upper, lower) = (body(1.0, "top"), body(0.0, "bottom"));
    let gap = Gap::Given(0.0.into());
    let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &gap).unwrap();
    ContactProblem::between([upper, lower], interface)
}

#[test]
fn friction_retains_a_second_direction_and_none_changes_nothing() {
    let none = problem().with_friction(0, Friction::None).unwrap();
    assert_eq!((none.side(0), none.rows()), (problem().side(0), 5));
    let with = problem().with_friction(0, Friction::Coulomb { mu: 0.0 }).unwrap();
    let side = with.side(1);
    assert_eq!((side.retained().len(), side.blocks(), with.rows()), (10, 1, 10));
    let prepared = PreparedProblem::new(with).unwrap();
    let body = prepared.bodies()[1].whole().unwrap();
    // Unknowns: a normal and a tangential one at each node, in the order of the nodes.
    let x: Vec<f64> = (0..10).map(|k| 0.01 * f64::from(k)).collect();
    let (u, traces) = (body.displacement_from_trace(&x), body.dofs().traces(&x));
    for (row, trace) in prepared.problem().contacts[0].rows().zip(&traces[0]) {
        assert!((u[row.nodes[1].index()].dot(&row.direction) - trace).abs() < 1e-16);
    }
    let tangent = prepared.problem().contacts[0].rows().nth(5).unwrap().direction;
    // n = (0, −1), t = (−n_y, n_x).
    assert!((tangent - Vector::x()).norm() < 1e-15, "{tangent:?}");
}

#[test]
fn finer_meshes_have_the_same_law_and_a_limit_that_is_wrong_there_is_refused() {
    let limit = |x: Vector| if (x[0] - 0.25).abs() < 1e-9 { f64::NAN } else { x[0] };
    let with = problem().with_friction(0, Friction::tresca(ScalarData::function(limit))).unwrap();
    let refined = |problem: &ContactProblem| {
        let edges: Vec<RefinementEdges> =
            problem.bodies.iter().map(|b| RefinementEdges::longest(b.mesh())).collect();
        let all = |body: &Body| vec![true; body.mesh().topology().facets().len()];
        contact_geometry::refined(problem, &edges, &problem.bodies.iter().map(all).collect::<Vec<_>>())
    };
    let error = refined(&with).unwrap_err().to_string();
    assert!(error.contains("the friction limit at (0.25, 1) is NaN"), "{error}");
    let linear = problem().with_friction(0, Friction::tresca(ScalarData::function(|x| x[0]))).unwrap();
    let finer = refined(&linear).unwrap().problem;
    let limits = finer.contacts[0].friction_limit(&finer.bodies[0]).unwrap();
    let points = finer.bodies[0].mesh().points();
    assert_eq!(limits.len(), 9);
    for (pair, s) in finer.contacts[0].interface.pairs().iter().zip(limits) {
        assert_eq!(s, points[pair.nodes[0]][0]);
    }
}

//! Public problems with Coulomb friction whose exact answers are known: MOOSE's patch tests of two blocks in the plane (`plane_1` to
//! `plane_4`, friction 0.2), and the shoe on a rigid plane of code_aster (SSNV503, manual V6.04.503).

use certified_contact::nndd::{CoulombSettings, CoulombStatus};
use certified_contact::{CoulombResult, Silent, SolveError, solve_coulomb};
use cre_estimator::Relaxation;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, FacetSelection};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Friction, Obstacle, RigidLine};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;

fn solved(problem: ContactProblem) -> Result<CoulombResult, SolveError> {
    solve_coulomb(problem, &CoulombSettings::default(), Relaxation::Steps(2), &mut Silent)
}

fn force(result: &CoulombResult) -> [f64; 2] {
    let normal: f64 = result.solution.exact.contact_force[0].iter().sum();
    [normal, result.solution.exact.friction[0].force.iter().sum()]
}

#[test]
fn the_blocks_of_moose_have_their_exact_displacements() {
    const PRESSURE: f64 = 109.89;
    let steel = LinearElastic::isotropic(1e6, 0.3, Hypothesis::PlaneStrain).unwrap();
    // Cells along the contact: matching, and two against one.
    for cells in [[1, 1], [2, 1], [3, 2]] {
        let held = || BoundaryConditions::new().displace("left", Some(0.0.into()), None);
        let top = held().pressure("top", PRESSURE);
        let upper = Body::new(block([0.0, 0.5], [1.0, 0.5], [cells[1]; 2]).unwrap(), steel.clone(), &top);
        let bottom = held().displace("bottom", None, Some(0.0.into()));
        let lower = Body::new(block([0.0, 0.0], [1.0, 0.5], [cells[0]; 2]).unwrap(), steel.clone(), &bottom);
        let (upper, lower) = (upper.unwrap(), lower.unwrap());
        let (problem, _) = tests::run::refined_in_common([upper, lower]).unwrap();
        let problem = problem.with_friction(0, Friction::Coulomb { mu: 0.2 }).unwrap();
        let result = solved(problem).unwrap();
        assert_eq!(result.solution.status, CoulombStatus::Converged);
        let exact = |x: Vector| PRESSURE / 1e6 * Vector::new(0.3 * 1.3 * x[0], -0.91 * x[1]);
        for (body, field) in result.problem.bodies.iter().zip(result.displacement()) {
            for (x, u) in body.mesh().points().iter().zip(field) {
                assert!((u - exact(*x)).amax() < 1e-15, "{x:?}: {u:?}");
            }
        }
        let [p, q] = force(&result);
        assert!((p - PRESSURE).abs() < 1e-9 && q.abs() < 1e-9, "{p} {q}");
    }
}

/// The shoe of 40 × 20 mm under a pressure of 300 MPa, pushed on its right side; the coefficient of friction is 0.3. MPa and mm.
fn shoe(push: f64, moved: Option<f64>) -> ContactProblem {
    let mut conditions =
        BoundaryConditions::new().pressure("top", 300.0).traction("left", [push.into(), 0.0.into()]);
    if let Some(moved) = moved {
        // Not down to the contact: there the support would take what friction does.
        let above = FacetSelection::group("right").within([[39.0, 41.0], [2.4, 21.0]]);
        conditions = conditions.displace(above, Some(moved.into()), None);
    }
    let steel = LinearElastic::isotropic(210e3, 0.3, Hypothesis::PlaneStrain).unwrap();
    let body = Body::new(block([0.0, 0.0], [40.0, 20.0], [16, 8]).unwrap(), steel, &conditions).unwrap();
    let plane = Obstacle::fixed(RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() });
    let interface = contact_geometry::against(&body, "bottom", &plane, None).unwrap();
    let problem = ContactProblem::new(vec![body]).obstacle(0, interface, plane);
    problem.with_friction(0, Friction::Coulomb { mu: 0.3 }).unwrap()
}

#[test]
fn the_shoe_of_code_aster_sticks_and_slides() {
    // First load: the pressure arrives at the contact.
    let [p, q] = force(&solved(shoe(0.0, None)).unwrap());
    assert!((p - 12000.0).abs() < 1e-7 && q.abs() < 1e-7, "{p} {q}");
    // Second load, 1 % below the capacity: friction holds the shoe.
    let held = solved(shoe(178.2, None)).unwrap();
    assert_eq!(held.solution.status, CoulombStatus::Converged);
    let [p, q] = force(&held);
    assert!((p - 12000.0).abs() < 1e-7 && (q - 3564.0).abs() < 1e-7, "{p} {q}");
    assert!(!held.results.contacts[0].friction.as_ref().unwrap().stick_intervals.is_empty());
    // Third load, 1 % above it: nothing holds the shoe.
    let refused = solved(shoe(181.8, None));
    assert!(matches!(refused, Err(SolveError::OutsideCones { .. })));
    // With the right side 9 mm ahead all of it slides, and that side takes the 36 N/mm of the manual's spring.
    let sliding = solved(shoe(181.8, Some(9.0))).unwrap();
    assert_eq!(sliding.solution.status, CoulombStatus::Converged);
    let [p, q] = force(&sliding);
    assert!((p - 12000.0).abs() < 1e-7 && (q - 3600.0).abs() < 1e-3, "{p} {q}");
    assert!(sliding.results.contacts[0].friction.as_ref().unwrap().stick_intervals.is_empty());
    let spring = sliding.results.reactions[0].force[0];
    assert!((spring + 36.0).abs() < 1e-3, "{spring}");
}

//! Solids against rigid spheres and cylinders.
//!
//! The figures of the sphere are those of an independent code, see `tests/support/formulation.rs`: it had the gap as a scalar between the nodes, on which
//! displacements and nodal forces do not depend.

use certified_contact::{Settings, Silent, solve};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Obstacle, RigidLine};
use fem_core::material::LinearElastic;
use fem_core::mesh::Mesh;
use fem_core::mesh::generate::cuboid;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nalgebra::Vector3;
use tests::formulation::printed;
use tests::solids::on_sphere;

/// Tells whether two numbers agree to a printed digit.
fn assert_near(found: f64, expected: f64, digit: f64) {
    assert!((found - expected).abs() <= digit, "{found:.12} is not {expected}");
}

#[test]
fn a_cube_on_a_sphere_has_the_forces_of_another_code() {
    for n in [2, 4] {
        let [force, peak] = ["force, pair 1", "largest P/ℓ, pair 1"].map(|name| printed("sphere", n, name));
        let solved = solve(on_sphere(n).unwrap(), &Settings::<Solid>::default(), &mut Silent).unwrap();
        assert!(solved.is_certified());
        let results = solved.results.unwrap();
        assert_near(results.contact_force, force, 1e-7);
        // Normals are not unit vectors.
        for of_body in solved.rows.last().unwrap().contact_forces {
            assert_near(of_body, results.contact_force, 1e-9);
        }
        assert_near(results.max_pressure, peak, 1e-6);
        // The sphere carries the load and what the planes of symmetry do not.
        assert_near(results.contacts[0].resultant[2], 20.0, 1e-10);
        assert!(results.balance[0].force.norm() < 1e-10, "{:?}", results.balance);
    }
}

/// A plate is bent into a part of a ball of radius 1 around the origin, or of a round bar along y, which lies in a hollow of the same radius: its outer side
/// touches at every node.
fn in_a_hollow(bar: bool, load: [f64; 3]) -> ContactProblem<Solid> {
    let flat = cuboid([-0.5, -0.5, 0.0], [1.0, 1.0, 0.4], [4, 4, 2]).unwrap();
    let bent = |x: &Vector3<f64>| {
        let out = Vector3::new(x[0], if bar { 0.0 } else { x[1] }, -1.0).normalize() * (1.0 - x[2]);
        if bar { Vector3::new(out[0], x[1], out[2]) } else { out }
    };
    let facets = |ids: &[_]| ids.iter().map(|f| flat.topology().facets()[*f]).collect();
    let groups = flat.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
    let mesh = Mesh::new(flat.points().iter().map(bent).collect(), flat.cells().to_vec(), groups).unwrap();
    let conditions = BoundaryConditions::<Solid>::default().traction("top", load.map(Into::into));
    let body = Body::new(mesh, LinearElastic::isotropic_solid(100.0, 0.3).unwrap(), &conditions).unwrap();
    let line = match bar {
        false => RigidLine::Circle { centre: Vector3::zeros(), radius: 1.0, inside: true },
        true => {
            RigidLine::Cylinder { point: Vector3::zeros(), axis: Vector3::y(), radius: 1.0, inside: true }
        }
    };
    let hollow = Obstacle::fixed(line);
    let interface = contact_geometry::solid_against(&body, "bottom", &hollow, None).unwrap();
    ContactProblem::new(vec![body]).obstacle(0, interface, hollow)
}

#[test]
fn rotations_in_a_hollow_are_free_and_a_torque_is_not_held() {
    for bar in [false, true] {
        let prepared = PreparedProblem::new(in_a_hollow(bar, [0.0, 0.0, -1.0])).unwrap();
        let free = prepared.problem().contacts[0].interface.pairs().iter();
        assert!(free.clone().all(|pair| pair.gap < 1e-15 && pair.normal_length() == 1.0));
        let solved =
            solve(in_a_hollow(bar, [0.0, 0.0, -1.0]), &Settings::<Solid>::default(), &mut Silent).unwrap();
        assert!(solved.is_certified(), "{:?}", solved.estimate.map(|e| e.admissibility));
        let results = solved.results.unwrap();
        assert!(results.max_displacement < 0.1, "{}", results.max_displacement);
        // A force along x turns the body about the centre or the axis, a force along y as well, or it pulls the bar out.
        for load in [[0.2, 0.0, -1.0], [0.0, 0.2, -1.0]] {
            let refused = solve(in_a_hollow(bar, load), &Settings::<Solid>::default(), &mut Silent);
            assert!(refused.is_err(), "{bar} {load:?}");
        }
    }
}

//! Supports along contact sides, as of a symmetry in the plane of contact: the traction along the side is a reaction, that across it the pressure.

use certified_contact::{CertifiedSolution, Settings, Silent, solve};
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Friction, Gap, InterfaceError, Obstacle, RigidLine};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::{block, cuboid, ring};
use fem_core::mesh_field::MeshField;
use fem_core::norm::energy_distance_squared;
use fem_core::space::Solid;
use nalgebra::Vector3;
use nndd::{Method, NewtonSettings, NnddSettings};
use std::sync::Arc;

fn body(y: f64, cells: [usize; 2], young: f64, conditions: &BoundaryConditions) -> Body {
    let material = LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap();
    Body::new(block([0.0, y], [2.0, 1.0], cells).unwrap(), material, conditions).unwrap()
}

/// Presses a block onto another one: its top is moved, its right side loaded.
fn pressed() -> BoundaryConditions {
    BoundaryConditions::new()
        .displace("top", None, Some((-0.02).into()))
        .traction("right", [5.0.into(), 30.0.into()])
}

fn between(upper: Body, lower: Body) -> ContactProblem {
    let gap = Gap::Given(0.0.into());
    let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &gap).unwrap();
    ContactProblem::between([upper, lower], interface)
}

/// The blocks of the paper, whose contact sides are held along themselves by these displacements; `None`: free.
fn blocks(n: usize, held: [Option<ScalarData>; 2]) -> ContactProblem {
    let [first, second] = held;
    let mut upper = pressed().displace("left", Some(0.0.into()), None);
    if let Some(u) = first {
        upper = upper.displace("bottom", Some(u), None);
    }
    let mut lower = BoundaryConditions::new().fix("bottom");
    if let Some(u) = second {
        lower = lower.displace("top", Some(u), None);
    }
    let cells = [18 * n, 9 * n];
    between(body(1.0, cells, 2000.0, &upper), body(0.0, cells, 1000.0, &lower))
}

fn solved<S: certified_contact::ContactSpace>(problem: &ContactProblem<S>) -> CertifiedSolution<S> {
    let solution = solve(problem.clone(), &Settings::default(), &mut Silent).unwrap();
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(solution.is_certified(), "{:?}", estimate.admissibility);
    for balance in &solution.results.as_ref().unwrap().balance {
        assert!(fem_core::geometry::norm(balance.force) < 1e-10, "{balance:?}");
    }
    solution
}

/// The bound of a mesh over the error against a finer, nested one.
fn effectivity<S: certified_contact::ContactSpace>(
    coarse: &ContactProblem<S>,
    fine: &ContactProblem<S>,
) -> f64 {
    let [a, b] = [coarse, fine].map(|of| solved(of));
    let [u, v] = [&a, &b].map(|of| &of.estimate.as_ref().unwrap().pair.bodies);
    let of_body = |k: usize| {
        let field = MeshField::new(coarse.bodies[k].mesh(), &u[k].displacement);
        energy_distance_squared(&fine.bodies[k], &field.on(fine.bodies[k].mesh()), &v[k].displacement)
    };
    let error = (0..coarse.bodies.len()).map(of_body).sum::<f64>().sqrt();
    let meet = |of: fn(&certified_contact::Bounds) -> [f64; 2]| {
        let [a, b] = [&a, &b].map(|of_mesh| of(of_mesh.bounds.as_ref().unwrap()));
        assert!(a[0] <= b[1] && b[0] <= a[1], "{a:?} {b:?}");
    };
    meet(|bounds| bounds.potential_energy);
    meet(|bounds| bounds.energy_norm);
    meet(|bounds| bounds.contact_force.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]));
    a.estimate.unwrap().unchecked().e_cre / error
}

#[test]
fn the_bound_holds_with_sides_that_are_held_along_themselves() {
    let along = |u: f64| Some(ScalarData::function(move |x: Vector| u * x[0]));
    for (k, held) in [
        [Some(0.0.into()), None],
        [along(0.001), None],
        [along(-0.002), along(0.001)],
        [None, Some(0.0.into())],
    ]
    .into_iter()
    .enumerate()
    {
        let [coarse, fine] = [1, 4].map(|n| blocks(n, held.clone()));
        let found = effectivity(&coarse, &fine);
        println!("{k}: {found:.4}");
        assert!((1.0..1.3).contains(&found), "{k}: {found}");
    }
}

#[test]
fn a_uniform_state_between_held_sides_is_exact() {
    let held = |conditions: BoundaryConditions, side: &str| {
        ["left", "right", side]
            .into_iter()
            .fold(conditions, |c, side| c.displace(side, Some(0.0.into()), None))
    };
    let upper = held(BoundaryConditions::new().pressure("top", 7.0), "bottom");
    let lower = held(BoundaryConditions::new().displace("bottom", None, Some(0.0.into())), "top");
    let problem = between(body(1.0, [4, 3], 2000.0, &upper), body(0.0, [4, 3], 1000.0, &lower));
    let solution = solved(&problem);
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(estimate.unchecked().e_cre < 1e-12, "{:e}", estimate.unchecked().e_cre);
    let results = solution.results.as_ref().unwrap();
    assert!((results.contacts[0].max_pressure - 7.0).abs() < 1e-11);
}

#[test]
fn every_method_finds_the_same() {
    let problem = blocks(1, [Some(0.0.into()), None]);
    let exact = Settings::default().with_method(NewtonSettings::default());
    let iterated = Settings::default().with_method(NnddSettings::default());
    let newton = Settings::default().with_method(Method::NewtonNn(NewtonSettings::default()));
    let bounds = [exact, iterated, newton].map(|settings| {
        let solution = solve(problem.clone(), &settings, &mut Silent).unwrap();
        assert!(solution.is_certified(), "{:?}", solution.estimate.as_ref().map(|e| e.admissibility));
        solution.estimate.unwrap().unchecked().e_cre
    });
    for bound in &bounds[1..] {
        assert!((bound / bounds[0] - 1.0).abs() < 2e-3, "{bounds:?}");
    }
}

#[test]
fn an_obstacle_under_a_held_side() {
    let floor = || Obstacle::fixed(RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() });
    let of = |n: usize| {
        let conditions = BoundaryConditions::new()
            .displace("bottom", Some(0.0.into()), None)
            .traction("top", [1.0.into(), (-10.0).into()])
            .traction("right", [0.0.into(), 9.0.into()]);
        let body = body(0.0, [12 * n, 6 * n], 1000.0, &conditions);
        let gap = Gap::Given(0.0.into());
        let interface = contact_geometry::against(&body, "bottom", &floor(), Some(&gap)).unwrap();
        ContactProblem::new(vec![body]).obstacle(0, interface, floor())
    };
    let found = effectivity(&of(1), &of(4));
    assert!((1.0..1.3).contains(&found), "{found}");
}

#[test]
fn solids_with_a_held_contact_face() {
    let data = |u: f64| ScalarData::Function(Arc::new(move |x: Vector3<f64>| u * (x[0] + x[1])));
    let of = |n: usize, held: [Option<f64>; 2]| {
        let conditions = BoundaryConditions::<Solid>::default();
        let upper = conditions
            .clone()
            .components("top", [Some(0.0.into()), Some(0.0.into()), Some((-0.02).into())])
            .traction("right", [3.0.into(), 0.0.into(), 20.0.into()])
            .components("bottom", [held[0].map(data), held[1].map(data), None]);
        let lower = conditions.fix("bottom");
        let make = |z: f64, young: f64, conditions: &BoundaryConditions<Solid>| {
            let mesh = cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [4 * n, 2 * n, 2 * n]).unwrap();
            Body::new(mesh, LinearElastic::isotropic_solid(young, 0.3).unwrap(), conditions).unwrap()
        };
        let (upper, lower) = (make(1.0, 2000.0, &upper), make(0.0, 1000.0, &lower));
        let interface =
            contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching).unwrap();
        ContactProblem::between([upper, lower], interface)
    };
    for held in [[Some(0.0), Some(0.0)], [Some(0.001), None], [Some(1e-3), Some(-1e-3)]] {
        let found = effectivity(&of(1, held), &of(3, held));
        println!("{held:?}: {found:.4}");
        assert!((1.0..1.6).contains(&found), "{found}");
    }
}

#[test]
fn supports_across_a_contact_side_and_beside_friction_are_refused() {
    let pair = |upper: &Body| {
        let lower = body(0.0, [4, 2], 1000.0, &BoundaryConditions::new().fix("bottom"));
        contact_geometry::pair(upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))
    };
    let made = |conditions: BoundaryConditions| body(1.0, [4, 2], 2000.0, &conditions);
    for across in [
        BoundaryConditions::new().displace("bottom", None, Some(0.0.into())),
        BoundaryConditions::new().fix("bottom"),
        BoundaryConditions::new().roller("bottom", 0.0),
    ] {
        let error = pair(&made(across)).unwrap_err();
        assert!(matches!(error, InterfaceError::Occupied { what: "an imposed displacement across it", .. }));
    }
    let loaded = pair(&made(BoundaryConditions::new().pressure("bottom", 1.0))).unwrap_err();
    assert!(matches!(loaded, InterfaceError::Occupied { what: "a load", .. }), "{loaded}");
    // A round side is not along an axis.
    let quarter = ring([0.0, 0.0], [1.0, 2.0], [0.0, 90.0], [6, 3]).unwrap();
    let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let held = BoundaryConditions::new().displace("outer", Some(0.0.into()), None);
    let round = Body::new(quarter, steel, &held).unwrap();
    let wall = Obstacle::fixed(RigidLine::Circle { centre: Vector::zeros(), radius: 2.0, inside: true });
    let error = contact_geometry::against(&round, "outer", &wall, None).unwrap_err();
    assert!(matches!(error, InterfaceError::Occupied { .. }), "{error}");
    // Friction would have nothing to say where nothing slips.
    let problem = blocks(1, [Some(0.0.into()), None]);
    let error = problem.clone().with_friction(0, Friction::tresca(1.0)).unwrap_err();
    assert!(matches!(error, InterfaceError::HeldAgainstSlip { body: 0, .. }), "{error}");
    assert!(problem.with_friction(0, Friction::None).is_ok());
}

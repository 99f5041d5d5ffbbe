//! Assemblies: the exact solution of the discrete problem, with floating bodies.

use contact_geometry::ContactNormal;
use contact_qp::QpSettings;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::geometry::{Vector, cross};
use fem_core::interface::{ContactProblem, Gap, Obstacle, Partner, RigidLine, Roles};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::{block, disc, ring};
use fem_core::mesh::id::FacetId;
use fem_core::norm::energy_norm_squared;
use nndd::stopping::Never;
use nndd::{ExactSolution, NewtonSettings, NnddError, NnddSettings, NnddStatus, Recovery, solve_exactly};
use tests::assemblies::{
    FOUR, FOUR_FORCES, STACK, STACK_FORCE, THREE, THREE_FORCES, four, pressed, stack, three, tower,
};
use tests::finer::halve;
use tests::prepare;
use tests::run::{paired_in_common, unresisted};
use tests::shapes::{turn, turned};

fn energies(problem: &ContactProblem, solution: &ExactSolution) -> Vec<f64> {
    let displacement = prepare(problem).displacements(&solution.fields);
    problem.bodies.iter().zip(&displacement).map(|(body, u)| energy_norm_squared(body, u)).collect()
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
}

fn small_tower() -> ContactProblem {
    tower(3, [18, 9]).unwrap()
}

/// Solves exactly and compares energies, contact forces and the numbers of pairs of nodes with a force.
fn has_figures(problem: &ContactProblem, expected: &[f64], forces: &[f64], active: &[usize]) {
    let solution = solve_exactly(&prepare(problem).system(), &QpSettings::default()).unwrap();
    assert!(solution.status.is_solved() && solution.clarabel_calls == 0, "{:?}", solution.status);
    assert!(solution.kkt.max() < 1e-12, "{:?}", solution.kkt);
    for (found, expected) in energies(problem, &solution).iter().zip(expected) {
        near(*found, *expected, 1e-11);
    }
    for ((force, expected), active) in solution.contact_force.iter().zip(forces).zip(active) {
        near(force.iter().sum(), *expected, 1e-11);
        assert_eq!(force.iter().filter(|p| **p > 0.0).count(), *active);
    }
    for (forces, openings) in solution.contact_force.iter().zip(&solution.opening) {
        assert!(forces.iter().zip(openings).all(|(p, o)| *p >= 0.0 && *o >= 0.0 && p * o == 0.0));
    }
}

#[test]
fn stacks_and_cycles_have_the_figures_of_an_independent_code() {
    has_figures(&small_tower(), &STACK, &[STACK_FORCE; 2], &[19, 16]);
    has_figures(&three(true).unwrap(), &THREE, &THREE_FORCES, &[10, 10, 11]);
    has_figures(&four().unwrap(), &FOUR, &FOUR_FORCES, &[9, 11, 11, 11, 11]);
}

#[test]
fn a_turned_block_that_slides_along_a_plane_is_not_held_by_round_off() {
    // On a roller above and a plane below that are parallel: nothing resists a push along both.
    for k in 1..29 {
        let angle = 0.107 * f64::from(k);
        let along = turn(angle, [1.0, 0.0]);
        let mesh = turned(&block([0.0, 0.0], [2.0, 1.0], [6, 3]).unwrap(), angle).unwrap();
        let push = 3.0 * along;
        let conditions = BoundaryConditions::new()
            .roller("top", 0.0)
            .traction("right", [ScalarData::from(push.x), ScalarData::from(push.y)]);
        let body = Body::new(
            mesh,
            LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap(),
            &conditions,
        )
        .unwrap();
        let plane = RigidLine::Plane { point: Vector::zeros(), normal: turn(angle, [0.0, 1.0]) };
        let plane = Obstacle::fixed(plane);
        let interface = contact_geometry::against(&body, "bottom", &plane, None).unwrap();
        let problem = ContactProblem::new(vec![body]).obstacle(0, interface, plane);
        let motion = unresisted(&problem);
        let [(Partner::Body(0), moved)] = motion.bodies[..] else { panic!("{motion:?}") };
        assert!((moved.translation - along).norm() < 1e-9 && moved.spin.abs() < 1e-9, "{angle}: {motion:?}");
        near(motion.load, 3.0, 1e-9);
    }
}

#[test]
fn a_node_in_two_pairs_with_the_same_normal_is_left_to_the_exact_solution() {
    let prepared = prepare(&three(true).unwrap());
    let lambda = vec![0.0; prepared.node_pairs()];
    let refused = nndd::solve(&prepared.system(), lambda.clone(), NnddSettings::default(), &mut Never);
    assert!(matches!(refused, Err(NnddError::DependentRows { body: 2 })), "{refused:?}");
    let solved = nndd::solve(&prepared.system(), lambda, NewtonSettings::default(), &mut Never).unwrap();
    near(solved.last.contact_force(), THREE_FORCES.iter().sum(), 1e-10);
}

#[test]
fn the_exact_solution_is_the_only_iterate_of_the_newton_method() {
    for roles in [Roles::FIRST, Roles::SECOND] {
        let prepared = prepare(&small_tower().with_roles(roles));
        let exact = solve_exactly(&prepared.system(), &QpSettings::default()).unwrap();
        let lambda = vec![0.0; prepared.node_pairs()];
        let solution =
            nndd::solve(&prepared.system(), lambda, NewtonSettings::default(), &mut Never).unwrap();
        assert_eq!((solution.status, solution.history.len()), (NnddStatus::StoppedByCriterion, 1));
        let last = &solution.last;
        assert_eq!(last.fields(&prepared.system()), exact.fields);
        assert_eq!((last.recovery, last.amounts.len()), (Recovery::Forces, 3));
        assert_eq!(last.contact.normal_reaction, exact.contact_force.concat());
        assert_eq!(last.contact.active.count(), 19 + 16);
        assert!(last.eta_nndd < 1e-12, "{}", last.eta_nndd);
        for block in prepared.problem().blocks() {
            let [first, second] = last.contact_forces_of(block);
            assert_eq!(first, second);
        }
        for i in 0..last.lambda.len() {
            let opening = last.contact.normal_trace[i] - last.lambda[i];
            assert!((opening - last.opening[i]).abs() < 1e-14, "{i}: {opening} {}", last.opening[i]);
        }
    }
}

#[test]
fn what_nothing_holds_is_named_with_its_motion() {
    let motion = |top: BoundaryConditions, middle: BoundaryConditions| {
        unresisted(&stack(&[1000.0, 1500.0, 2000.0], [18, 9], &middle, &top).unwrap())
    };
    // Pushed sideways between flat blocks.
    let pushed = motion(pressed(), BoundaryConditions::new().traction("left", [2.0.into(), 0.0.into()]));
    assert_eq!(pushed.bodies.len(), 1);
    let (body, moved) = &pushed.bodies[0];
    assert_eq!(*body, Partner::Body(1));
    assert!((moved.translation[0] - 1.0).abs() < 1e-9 && moved.translation[1].abs() < 1e-9, "{moved:?}");
    near(pushed.load, 2.0, 1e-9);
    // The top block pulled up by a force, without any other support.
    let up = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .traction("top", [0.0.into(), 5.0.into()]);
    let lifted = motion(up, BoundaryConditions::new());
    assert_eq!(lifted.bodies.iter().map(|(b, _)| *b).collect::<Vec<_>>(), [Partner::Body(2)]);
    assert!((lifted.bodies[0].1.translation[1] - 1.0).abs() < 1e-9, "{lifted:?}");
}

#[test]
fn forces_that_balanced_other_loads_hold_nothing() {
    let weight = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .traction("top", [0.0.into(), (-5.0).into()]);
    let pile =
        |middle: &BoundaryConditions| stack(&[1000.0, 1500.0, 2000.0], [4, 2], middle, &weight).unwrap();
    let mut held = pile(&BoundaryConditions::new());
    let found = certified_contact::support(&held).unwrap();
    assert!(found.unresisted.is_none() && found.forces.len() == held.rows());
    // Other forces that balance the same loads are as good an answer: they come back as they are.
    held.balancing = found.forces.iter().map(|force| force * (1.0 + 1e-13)).collect();
    let again = certified_contact::support(&held).unwrap();
    assert!(again.unresisted.is_none() && again.forces == held.balancing && again.forces != found.forces);
    let mut pushed = pile(&BoundaryConditions::new().traction("left", [2.0.into(), 0.0.into()]));
    let tensile: Vec<f64> = found.forces.iter().map(|force| -force).collect();
    for forces in [found.forces, tensile, vec![f64::NAN; pushed.rows()]] {
        pushed.balancing = forces;
        assert!(certified_contact::support(&pushed).unwrap().unresisted.is_some());
        let solved = solve_exactly(&prepare(&pushed).system(), &QpSettings::default());
        assert!(matches!(solved, Err(NnddError::NotHeld { .. })), "{solved:?}");
    }
}

/// A roller of radius 1 about (0, 1), a disc of 24 edges, whose lowest and highest edge are contact sides, on a block and under
/// one; both blocks are as wide as these edges. A torque acts on the rest of its rim.
fn twisted_roller() -> ContactProblem {
    let centre = Vector::new(0.0, 1.0);
    let mesh = disc(centre, 1.0, 4, -97.5).unwrap();
    let rim = |edge: &FacetId| mesh.topology().facets()[*edge];
    let middle = |edge: &FacetId| mesh.facet_middle(*edge) - centre;
    let side = |wanted: &dyn Fn(Vector) -> bool| -> Vec<_> {
        mesh.group("rim").unwrap().iter().filter(|edge| wanted(middle(edge))).map(rim).collect()
    };
    let groups = vec![
        ("low".to_owned(), side(&|x| x[1] < -0.99)),
        ("high".to_owned(), side(&|x| x[1] > 0.99)),
        ("rest".to_owned(), side(&|x| x[1].abs() < 0.99)),
    ];
    assert_eq!(groups.iter().map(|(_, edges)| edges.len()).collect::<Vec<_>>(), [1, 1, 22]);
    let (height, half) = (7.5f64.to_radians().cos(), 7.5f64.to_radians().sin());
    let roller = TriMesh::new(mesh.points().to_vec(), mesh.cells().to_vec(), groups).unwrap();
    let torque = |c: usize| ScalarData::function(move |x: Vector| [1.0 - x[1], x[0]][c]);
    let steel = || LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let twisted = BoundaryConditions::new().traction("rest", [torque(0), torque(1)]);
    let plate = |y: f64, held: &str| {
        let mesh = block([-half, y], [2.0 * half, 0.2], [1, 1]).unwrap();
        Body::new(mesh, steel(), &BoundaryConditions::new().fix(held)).unwrap()
    };
    let bodies = [
        Body::new(roller, steel(), &twisted).unwrap(),
        plate(0.8 - height, "bottom"),
        plate(1.0 + height, "top"),
    ];
    let gap = Gap::Given(0.0.into());
    let below = contact_geometry::pair(&bodies[0], &bodies[1], ["low", "top"], &gap).unwrap();
    let above = contact_geometry::pair(&bodies[0], &bodies[2], ["high", "bottom"], &gap).unwrap();
    ContactProblem::new(bodies.into()).contact([0, 1], below).contact([0, 2], above)
}

#[test]
fn a_torque_on_a_roller_is_not_held_by_the_ends_of_its_contact_lines() {
    let problem = twisted_roller();
    for contact in &problem.contacts {
        for pair in contact.interface.pairs() {
            let arm = problem.bodies[0].mesh().points()[pair.nodes[0]] - Vector::new(0.0, 1.0);
            assert!(cross(arm, pair.normal).abs() < 1e-14, "{pair:?}");
        }
    }
    let motion = unresisted(&problem);
    let (body, moved) = &motion.bodies[0];
    assert!(*body == Partner::Body(0) && moved.spin > 0.0, "{moved:?}");
}

#[test]
fn a_roller_in_a_bore_turns_freely_on_every_mesh() {
    let centre = Vector::new(0.3, -0.2);
    let steel = || LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let held = BoundaryConditions::new().fix("outer");
    // Nodes that coincide, and nodes that are carried over and snapped.
    for count in [24, 31] {
        let roller =
            Body::new(disc(centre, 1.0, 4, 0.0).unwrap(), steel(), &BoundaryConditions::new()).unwrap();
        let bore =
            Body::new(ring(centre, [1.0, 1.5], [0.0, 360.0], [count, 2]).unwrap(), steel(), &held).unwrap();
        let gap = Gap::Geometric;
        let mut problem = if count == 24 {
            let interface = contact_geometry::pair(&roller, &bore, ["rim", "inner"], &gap).unwrap();
            ContactProblem::between([roller, bore], interface)
        } else {
            paired_in_common([roller, bore], ["rim", "inner"], &gap, ContactNormal::Averaged).unwrap().0
        };
        for mesh in 0..3 {
            let interface = &problem.contacts[0].interface;
            let points = problem.bodies[0].mesh().points();
            let arm = |k: usize| points[interface.pairs()[k].nodes[0]] - centre;
            for (k, pair) in interface.pairs().iter().enumerate() {
                // The normal is the arm over the radius.
                assert!((pair.normal - arm(k)).norm() < 1e-12, "{count} {mesh}: {pair:?} {}", arm(k));
            }
            // So no pressure on any edge has a moment.
            let pressure: Vec<[f64; 2]> =
                (0..interface.facets().len()).map(|k| [1.0 + (k % 3) as f64; 2]).collect();
            let forces = interface.pressure_forces(&pressure);
            let moment: f64 = forces.iter().enumerate().map(|(k, force)| cross(arm(k), *force)).sum();
            assert!(moment.abs() < 1e-12, "{count} {mesh}: {moment}");
            problem = halve(&problem).unwrap().problem;
        }
    }
}

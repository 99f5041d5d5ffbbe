//! Assemblies: the exact solution of the discrete problem, with floating bodies.

use contact_qp::QpSettings;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactInterface, ContactProblem, Gap, Roles};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::norm::energy_norm_squared;
use nndd::stopping::Never;
use nndd::{ExactSolution, NewtonSettings, NnddError, NnddStatus, Recovery, solve_exactly};
use tests::prepare;

fn material(young: f64) -> LinearElastic {
    LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap()
}

/// Three blocks on top of each other, the middle one held by contact only.
fn stack(conditions_of_top: BoundaryConditions, middle: BoundaryConditions) -> ContactProblem {
    let body = |k: usize, young: f64, conditions: &BoundaryConditions| {
        Body::new(block([0.0, k as f64], [2.0, 1.0], [18, 9]).unwrap(), material(young), conditions).unwrap()
    };
    let bottom = body(0, 1000.0, &BoundaryConditions::new().fix("bottom"));
    let middle = body(1, 1500.0, &middle);
    let top = body(2, 2000.0, &conditions_of_top);
    let gap = Gap::Given(0.0.into());
    let lower = ContactInterface::pair(&middle, &bottom, ["bottom", "top"], &gap).unwrap();
    let upper = ContactInterface::pair(&top, &middle, ["bottom", "top"], &gap).unwrap();
    ContactProblem::new(vec![bottom, middle, top]).contact([1, 0], lower).contact([2, 1], upper)
}

fn pressed() -> BoundaryConditions {
    BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("top", None, Some((-0.02).into()))
        .traction("right", [0.0.into(), 30.0.into()])
}

fn energies(problem: &ContactProblem, solution: &ExactSolution) -> Vec<f64> {
    problem.bodies.iter().zip(&solution.displacement).map(|(body, u)| energy_norm_squared(body, u)).collect()
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
}

#[test]
fn a_floating_block_in_a_stack_has_the_figures_of_an_independent_code() {
    let problem = stack(pressed(), BoundaryConditions::new());
    let solution = solve_exactly(&prepare(&problem), &QpSettings::default()).unwrap();
    assert!(solution.status.is_solved() && solution.clarabel_calls == 0, "{:?}", solution.status);
    assert!(solution.kkt.max() < 1e-12, "{:?}", solution.kkt);
    for (found, expected) in
        energies(&problem, &solution).iter().zip([0.151396775117, 0.117486400467, 0.646165093628])
    {
        near(*found, expected, 1e-11);
    }
    let active = [19, 16];
    for (force, active) in solution.contact_force.iter().zip(active) {
        near(force.iter().sum(), 18.1350164279, 1e-11);
        assert_eq!(force.iter().filter(|p| **p > 0.0).count(), active);
    }
    for (forces, openings) in solution.contact_force.iter().zip(&solution.opening) {
        assert!(forces.iter().zip(openings).all(|(p, o)| *p >= 0.0 && *o >= 0.0 && p * o == 0.0));
    }
}

#[test]
fn the_exact_solution_is_the_only_iterate_of_the_newton_method() {
    for roles in [Roles::FIRST, Roles::SECOND] {
        let prepared = prepare(&stack(pressed(), BoundaryConditions::new()).with_roles(roles));
        let exact = solve_exactly(&prepared, &QpSettings::default()).unwrap();
        let lambda = vec![0.0; prepared.node_pairs()];
        let solution = nndd::solve(&prepared, lambda, NewtonSettings::default(), &mut Never).unwrap();
        assert_eq!((solution.status, solution.history.len()), (NnddStatus::StoppedByCriterion, 1));
        let last = &solution.last;
        assert_eq!(last.displacements(&prepared), exact.displacement);
        assert_eq!((last.recovery, last.motions.len()), (Recovery::Forces, 3));
        assert_eq!(last.contact.normal_reaction, exact.contact_force.concat());
        assert_eq!(last.contact.active.count(), 19 + 16);
        assert!(last.eta_nndd < 1e-12, "{}", last.eta_nndd);
        for block in last.blocks(prepared.problem()) {
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
    let motion = |top: BoundaryConditions, middle: BoundaryConditions| match solve_exactly(
        &prepare(&stack(top, middle)),
        &QpSettings::default(),
    ) {
        Err(NnddError::NotHeld { motion }) => motion,
        other => panic!("{other:?}"),
    };
    // Pushed sideways between flat blocks.
    let pushed = motion(pressed(), BoundaryConditions::new().traction("left", [2.0.into(), 0.0.into()]));
    assert_eq!(pushed.bodies.len(), 1);
    let (body, moved) = &pushed.bodies[0];
    assert_eq!(*body, 1);
    assert!((moved.translation[0] - 1.0).abs() < 1e-9 && moved.translation[1].abs() < 1e-9, "{moved:?}");
    near(pushed.load, 2.0, 1e-9);
    // The top block pulled up by a force, without any other support.
    let up = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .traction("top", [0.0.into(), 5.0.into()]);
    let lifted = motion(up, BoundaryConditions::new());
    assert_eq!(lifted.bodies.iter().map(|(b, _)| *b).collect::<Vec<_>>(), [2]);
    assert!((lifted.bodies[0].1.translation[1] - 1.0).abs() < 1e-9, "{lifted:?}");
}

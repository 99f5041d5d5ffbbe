//! Assemblies: the exact solution of the discrete problem, with floating bodies.

use contact_qp::QpSettings;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Roles};
use fem_core::norm::energy_norm_squared;
use nndd::stopping::Never;
use nndd::{ExactSolution, NewtonSettings, NnddError, NnddSettings, NnddStatus, Recovery, solve_exactly};
use tests::assemblies::{
    FOUR, FOUR_FORCES, STACK, STACK_FORCE, THREE, THREE_FORCES, four, pressed, stack, three, tower,
};
use tests::prepare;

fn energies(problem: &ContactProblem, solution: &ExactSolution) -> Vec<f64> {
    problem.bodies.iter().zip(&solution.displacement).map(|(body, u)| energy_norm_squared(body, u)).collect()
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
}

fn small_tower() -> ContactProblem {
    tower(3, [18, 9]).unwrap()
}

/// Solves exactly and compares energies, contact forces and the numbers of pairs of nodes with a force.
fn has_figures(problem: &ContactProblem, expected: &[f64], forces: &[f64], active: &[usize]) {
    let solution = solve_exactly(&prepare(problem), &QpSettings::default()).unwrap();
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
fn a_node_in_two_pairs_with_the_same_normal_is_left_to_the_exact_solution() {
    let prepared = prepare(&three(true).unwrap());
    let lambda = vec![0.0; prepared.node_pairs()];
    let refused = nndd::solve(&prepared, lambda.clone(), NnddSettings::default(), &mut Never);
    assert!(matches!(refused, Err(NnddError::DependentRows { body: 2 })), "{refused:?}");
    let solved = nndd::solve(&prepared, lambda, NewtonSettings::default(), &mut Never).unwrap();
    near(solved.last.contact_force(), THREE_FORCES.iter().sum(), 1e-10);
}

#[test]
fn the_exact_solution_is_the_only_iterate_of_the_newton_method() {
    for roles in [Roles::FIRST, Roles::SECOND] {
        let prepared = prepare(&small_tower().with_roles(roles));
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
        &prepare(&stack(&[1000.0, 1500.0, 2000.0], [18, 9], &middle, &top).unwrap()),
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

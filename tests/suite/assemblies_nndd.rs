//! Assemblies: the Neumann-Neumann iteration, with floating bodies and any orientation of the pairs.

use contact_qp::{QpPath, QpSettings};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Partner, Roles};
use fem_core::mesh::generate::block;
use fem_core::norm::energy_norm_squared;
use fem_core::prepared::PreparedProblem;
use nndd::stopping::{EtaNndd, Never};
use nndd::{
    Acceleration, NewtonSettings, NnddError, NnddSettings, NnddStatus, Start, Weights, solve_exactly,
    stiffer_roles,
};
use tests::assemblies::{four, pressed, stack, stamped, three, tower};
use tests::paper;
use tests::run::pair_of;
use tests::run::unresisted;
use tests::{iterates, prepare};

/// Prepares a problem and lets the stiffer body carry λ.
fn carried_by_the_stiffer(problem: &ContactProblem) -> PreparedProblem {
    let mut prepared = prepare(problem);
    for (k, roles) in stiffer_roles(&prepared.system()).into_iter().enumerate() {
        prepared.set_roles(k, roles);
    }
    prepared
}

/// Iterates to `η/η₁ ≤ 1e-10`, checks that η is never below the true distance and that the limit is the exact solution, and returns
/// the number of iterations.
fn reaches_the_exact_solution(prepared: &PreparedProblem, settings: &NnddSettings) -> usize {
    let exact = solve_exactly(&prepared.system(), &QpSettings::default()).unwrap();
    let bodies = &prepared.problem().bodies;
    let energies = |u: &[Vec<Vector>]| -> Vec<f64> {
        bodies.iter().zip(u).map(|(body, u)| energy_norm_squared(body, u)).collect()
    };
    let displacement = prepared.displacements(&exact.fields);
    let expected = energies(&displacement);
    let size: f64 = expected.iter().sum();
    let (solution, all) = iterates(prepared, settings, 1e-10).unwrap();
    for iterate in &all {
        let mut u = prepared.displacements(&iterate.fields(&prepared.system()));
        u.iter_mut().zip(&displacement).for_each(|(u, v)| u.iter_mut().zip(v).for_each(|(u, v)| *u -= v));
        let distance = energies(&u).iter().sum::<f64>().sqrt();
        let eta = iterate.eta_nndd;
        assert!(
            eta >= (1.0 - 1e-9) * distance - 1e-12 * size.sqrt(),
            "{}: {eta:e} {distance:e}",
            iterate.iteration
        );
    }
    assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
    let found = energies(&prepared.displacements(&solution.last.fields(&prepared.system())));
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() <= 1e-9 * size, "{found} {expected}");
    }
    solution.history.len()
}

#[test]
fn the_first_bounds_are_those_of_an_independent_code() {
    for (second, expected) in [(Roles::FIRST, 1.2270569444), (Roles::SECOND, 1.2636113077)] {
        let mut prepared = prepare(&tower(3, [18, 9]).unwrap());
        prepared.set_roles(1, second);
        let first = pair_of(&prepared, vec![0.0; 38]).unwrap();
        assert!((first.eta_nndd - expected).abs() <= 1e-9, "{} {expected}", first.eta_nndd);
    }
}

/// The most iterations: the independent code's counts depend on its variant of Anderson's method by 30 %.
fn at_most(reference: usize) -> usize {
    reference + 3 * reference / 10
}

#[test]
fn the_number_of_iterations_does_not_grow_with_that_of_floating_bodies() {
    let cases = [
        ("stack", tower(3, [18, 9]), [20, 15]),
        ("5-stack", tower(5, [18, 9]), [22, 21]),
        ("9-stack", tower(9, [18, 9]), [25, 26]),
        ("4-cycle", four(), [16, 16]),
        // The second count of each is the same as on the coarse mesh.
        ("stack, 36x18", tower(3, [36, 18]), [17, 15]),
        ("9-stack, 36x18", tower(9, [36, 18]), [24, 26]),
    ];
    for (name, problem, reference) in cases {
        let prepared = carried_by_the_stiffer(&problem.unwrap());
        for (weights, reference) in [Weights::Stiffness, Weights::Half].into_iter().zip(reference) {
            let mut settings = NnddSettings::default();
            settings.weights = weights;
            let count = reaches_the_exact_solution(&prepared, &settings);
            println!("{name}, {weights:?}: {count} iterations, {reference} in the reference");
            assert!(count <= at_most(reference));
        }
    }
}

#[test]
fn without_the_coarse_space_the_iterations_are_many() {
    let prepared = carried_by_the_stiffer(&tower(5, [18, 9]).unwrap());
    let mut settings = NnddSettings::default();
    settings.coarse = false;
    settings.max_iterations = 100;
    let count = reaches_the_exact_solution(&prepared, &settings);
    assert!((40..=at_most(53)).contains(&count), "{count}");
}

#[test]
fn the_plain_iteration_takes_as_long_as_the_independent_one() {
    for (count, reference) in [(3, 31), (5, 114)] {
        let prepared = carried_by_the_stiffer(&tower(count, [18, 9]).unwrap());
        let mut settings = NnddSettings::default();
        (settings.theta, settings.acceleration) = (Some(1.0), Acceleration::None);
        settings.max_iterations = 200;
        let found = reaches_the_exact_solution(&prepared, &settings);
        assert!(found.abs_diff(reference) * 20 <= reference, "{found} {reference}");
    }
}

#[test]
fn an_odd_cycle_converges_in_every_orientation() {
    let problem = three(false).unwrap();
    for orientation in 0..8 {
        let mut prepared = prepare(&problem);
        for pair in 0..3 {
            prepared.set_roles(pair, if orientation >> pair & 1 == 0 { Roles::FIRST } else { Roles::SECOND });
        }
        let count = reaches_the_exact_solution(&prepared, &NnddSettings::default());
        println!("3-cycle, orientation {orientation}: {count} iterations, 12 in the reference");
        assert!(count <= at_most(12));
    }
}

#[test]
fn with_the_softer_body_as_carrier_fifty_iterations_are_too_few() {
    let loads = (BoundaryConditions::new(), pressed());
    let problem = stack(&[1000.0, 10.0, 1000.0], [18, 9], &loads.0, &loads.1).unwrap();
    let mut prepared = carried_by_the_stiffer(&problem);
    assert_eq!(prepared.problem().roles(), [Roles::SECOND, Roles::FIRST]);
    let settings = NnddSettings::default();
    assert!(reaches_the_exact_solution(&prepared, &settings) <= at_most(7));
    prepared.set_roles(0, Roles::FIRST);
    prepared.set_roles(1, Roles::SECOND);
    let lambda = vec![0.0; prepared.node_pairs()];
    let solution = nndd::solve(&prepared.system(), lambda, &settings, &mut EtaNndd::new(1e-6)).unwrap();
    assert_eq!((solution.status, solution.history.len()), (NnddStatus::MaxIterations, 50));
}

#[test]
fn a_stamp_moves_under_its_force() {
    let prepared = carried_by_the_stiffer(&stamped().unwrap());
    assert_eq!(prepared.problem().roles()[2], Roles::SECOND);
    let settings = NnddSettings::default();
    assert!(reaches_the_exact_solution(&prepared, &settings) < 25);
    let (solution, all) = iterates(&prepared, &settings, 1e-10).unwrap();
    // The force is right from the first iteration, and λ is the line of the stamp.
    let on_stamp = 38..57;
    for iterate in &all {
        assert!((iterate.contact_forces_of(on_stamp.clone())[1] - 20.0).abs() < 1e-11);
        let line = &iterate.lambda[on_stamp.clone()];
        assert!(line.windows(3).all(|l| (l[0] - 2.0 * l[1] + l[2]).abs() < 1e-14), "{line:?}");
    }
    let exact =
        nndd::solve(&prepared.system(), vec![0.0; 57], NewtonSettings::default(), &mut Never).unwrap().last;
    for (a, b) in solution.last.lambda.iter().zip(&exact.lambda) {
        assert!((a - b).abs() < 1e-9 * exact.lambda[38].abs(), "{a} {b}");
    }
}

#[test]
fn a_solved_problem_is_solved_in_one_iteration() {
    let prepared = carried_by_the_stiffer(&tower(5, [18, 9]).unwrap());
    let lambda = vec![0.0; prepared.node_pairs()];
    let exact = nndd::solve(&prepared.system(), lambda, NewtonSettings::default(), &mut Never).unwrap().last;
    let start = Start { lambda: exact.lambda, active: Some(exact.contact.active) };
    let mut settings = NnddSettings::default();
    settings.max_iterations = 1;
    let again = nndd::solve_from(&prepared.system(), start, &settings.into(), &mut Never).unwrap();
    assert!(again.last.eta_nndd < 1e-10, "{}", again.last.eta_nndd);
    assert_eq!(again.last.programme.path, QpPath::WarmStart);
}

#[test]
fn a_pair_with_a_floating_body_and_one_body_alone_are_an_assembly() {
    let conditions = BoundaryConditions::new().displace("left", Some(0.0.into()), None).pressure("top", 2.0);
    let problem = stack(&[1000.0, 2000.0], [8, 4], &BoundaryConditions::new(), &conditions).unwrap();
    let settings = NnddSettings::default();
    let mut prepared = carried_by_the_stiffer(&problem);
    assert!(reaches_the_exact_solution(&prepared, &settings) < 20);
    prepared.set_roles(0, Roles::SECOND);
    assert!(reaches_the_exact_solution(&prepared, &settings) < 30);
    // A third body, which touches nothing.
    let mut bodies = problem.bodies.clone();
    bodies.push(problem.bodies[0].clone());
    let mut apart = ContactProblem::new(bodies);
    apart.contacts = problem.contacts.clone();
    assert!(reaches_the_exact_solution(&carried_by_the_stiffer(&apart), &settings) < 20);
}

#[test]
fn what_the_iteration_cannot_do_is_said() {
    let pushed = BoundaryConditions::new().traction("left", [2.0.into(), 0.0.into()]);
    let slides = stack(&[1000.0, 1500.0, 2000.0], [18, 9], &pushed, &pressed()).unwrap();
    let prepared = prepare(&slides);
    let lambda = vec![0.0; prepared.node_pairs()];
    let refused = nndd::solve(&prepared.system(), lambda, NnddSettings::default(), &mut Never);
    assert!(matches!(&refused, Err(NnddError::NotHeld { .. })), "{refused:?}");
    assert_eq!(unresisted(&slides).bodies[0].0, Partner::Body(1));
}

#[test]
fn the_iteration_is_the_same_on_1_2_and_7_threads() {
    let [one, two, seven] = [1, 2, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let prepared = carried_by_the_stiffer(&tower(5, [18, 9]).unwrap());
            let (solution, _) = iterates(&prepared, &NnddSettings::default(), 1e-10).unwrap();
            let last = &solution.last;
            let mut numbers: Vec<f64> = solution.history.iter().map(|row| row.eta_nndd).collect();
            numbers.extend([&last.lambda, &last.reaction, &last.opening].into_iter().flatten());
            numbers.extend(&last.amounts);
            numbers
                .extend(prepared.displacements(&last.fields(&prepared.system())).iter().flatten().flatten());
            numbers.into_iter().map(f64::to_bits).collect::<Vec<u64>>()
        })
    });
    assert!(one.len() > 1000);
    assert_eq!(one, two);
    assert_eq!(one, seven);
}

/// The paper's problem with a third body that touches nothing, held or free.
fn with_an_idle_body(held: bool) -> ContactProblem {
    let mut problem = paper::problem(paper::COARSE).unwrap();
    let mesh = block([10.0, 0.0], [1.0, 1.0], [2, 2]).unwrap();
    let conditions = BoundaryConditions::new();
    let conditions = if held { conditions.fix("bottom") } else { conditions };
    let steel = problem.bodies[0].material(0).clone();
    problem.bodies.push(Body::new(mesh, steel, &conditions).unwrap());
    problem
}

#[test]
fn a_body_that_touches_nothing_does_not_change_what_theta_means() {
    let alone = paper::problem(paper::COARSE).unwrap();
    for weights in [Weights::Half, Weights::Stiffness] {
        for theta in [Some(0.4), None] {
            let mut settings = NnddSettings::paper(0.4);
            (settings.weights, settings.theta, settings.max_iterations) = (weights, theta, 8);
            let (expected, _) = iterates(&prepare(&alone), &settings, 0.0).unwrap();
            for held in [true, false] {
                let (found, _) = iterates(&prepare(&with_an_idle_body(held)), &settings, 0.0).unwrap();
                assert!((found.theta - expected.theta).abs() <= 1e-9 * expected.theta, "{}", found.theta);
                assert_eq!(found.history.len(), 8);
                for (found, expected) in found.history.iter().zip(&expected.history) {
                    let differ = (found.eta_nndd - expected.eta_nndd).abs();
                    assert!(differ <= 1e-10 * expected.eta_nndd, "{found:?} {expected:?}");
                    assert_eq!(found.contact_nodes, expected.contact_nodes);
                }
            }
        }
    }
}

//! The paper's problem: the prototype's figures, the iteration against one with whole bodies, Clarabel called.

use contact_qp::{QpMethod, QpSettings};
use fem_core::norm::energy_norm_squared;
use nndd::{NnddSettings, NnddSolution, NnddStatus};
use tests::full_size;
use tests::run::relative_difference;
use tests::{displacements, iterates, paper, prepare};

fn settings(method: QpMethod) -> NnddSettings {
    let mut settings = NnddSettings::paper(0.4);
    settings.qp.method = method;
    settings
}

/// Compares a row with the prototype's: ε_t, η_NNDD, nodes in contact, contact force.
fn is_the_prototypes(number: usize, [precision, eta, force]: [f64; 3], nodes: usize) {
    let (expected_precision, expected_eta, expected_nodes, expected_force) = paper::ITERATIONS[number];
    let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-8 * expected;
    assert!(close(precision, expected_precision), "{number}: {precision}");
    assert!(close(eta, expected_eta), "{number}: {eta}");
    assert_eq!(nodes, expected_nodes, "{number}");
    assert!(close(force, expected_force), "{number}: {force}");
}

fn table(settings: &NnddSettings) -> NnddSolution {
    let problem = paper::problem(paper::COARSE).unwrap();
    let mut settings = settings.clone();
    settings.max_iterations = 5;
    let (solution, _) = iterates(&prepare(&problem), &settings, 0.0).unwrap();
    assert_eq!(solution.status, NnddStatus::MaxIterations);
    assert_eq!(solution.history.len(), 5);
    for (k, row) in solution.history.iter().enumerate() {
        is_the_prototypes(k, [row.precision, row.eta_nndd, row.contact_force], row.contact_nodes);
    }
    solution
}

#[test]
fn the_iteration_reproduces_the_prototype_and_calls_clarabel() {
    assert!(table(&settings(QpMethod::Auto)).clarabel_calls >= 1);
    // In every iteration.
    assert!(table(&settings(QpMethod::Clarabel)).clarabel_calls >= 5);
}

#[test]
fn whole_bodies_reproduce_the_prototype() {
    let problem = paper::problem(paper::COARSE).unwrap();
    for method in [QpMethod::Auto, QpMethod::Clarabel] {
        let qp = QpSettings::default().with_method(method);
        for (k, it) in full_size::iterate(&problem, 0.4, 5, &qp).unwrap().iter().enumerate() {
            let nodes = it.contact_force.iter().filter(|r| **r > 0.0).count();
            is_the_prototypes(k, [it.precision, it.eta_nndd, it.contact_force.iter().sum()], nodes);
        }
    }
}

#[test]
fn the_active_set_method_needs_no_clarabel_for_the_same_table() {
    let solution = table(&settings(QpMethod::ActiveSet));
    assert_eq!(solution.clarabel_calls, 0);
}

#[test]
fn converged_values_are_the_prototypes() {
    let problem = paper::problem(paper::COARSE).unwrap();
    let prepared = prepare(&problem);
    let (solution, _) = iterates(&prepared, &settings(QpMethod::Auto), 1e-10).unwrap();
    assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
    let u = displacements(&prepared, &solution.last);
    for b in 0..2 {
        let energy = energy_norm_squared(&problem.bodies[b], &u[b]);
        let exact = paper::ENERGIES[b];
        assert!((energy - exact).abs() <= 1e-8 * exact, "body {b}: {energy}");
    }
    let force = solution.last.contact_force();
    assert!((force - paper::FORCE).abs() <= 1e-8 * paper::FORCE, "{force}");
    let forces = &solution.last.contact.normal_reaction;
    for (s, r) in problem.contacts[0].interface.arc_lengths().iter().zip(forces) {
        let touches = *s < paper::CONTACT_END + 1e-9;
        assert_eq!(*r > 0.0, touches, "at {s}: {r}");
    }
}

/// Iterates in the interface unknowns and with whole bodies, and returns the largest relative difference of any interface vector of any
/// iteration, of the indicators, and of the energies of the displacements.
fn difference_from_whole_bodies(cells: [usize; 2], iterations: usize) -> [f64; 3] {
    let problem = paper::problem(cells).unwrap();
    let prepared = prepare(&problem);
    let mut settings = settings(QpMethod::Auto);
    settings.max_iterations = iterations;
    let (_, condensed) = iterates(&prepared, &settings, 0.0).unwrap();
    let whole = full_size::iterate(&problem, 0.4, iterations, &QpSettings::default()).unwrap();
    assert_eq!((condensed.len(), whole.len()), (iterations, iterations));
    let mut worst = [0.0f64; 3];
    for (a, b) in condensed.iter().zip(&whole) {
        assert_eq!(a.contact.active.as_slice(), b.active, "iteration {}", a.iteration);
        let vectors = [
            (&a.lambda, &b.lambda),
            (&a.reaction, &b.reaction),
            (&a.contact.normal_reaction, &b.contact_force),
            (&a.contact.normal_trace, &b.trace),
        ];
        for (x, y) in vectors {
            worst[0] = worst[0].max(relative_difference(x, y));
        }
        let indicators = relative_difference(&[a.eta_nndd], &[b.eta_nndd])
            .max(relative_difference(&[a.precision], &[b.precision]));
        worst[1] = worst[1].max(indicators);
        let u = displacements(&prepared, a);
        let energies = |u: &[Vec<_>]| [0, 1].map(|b| energy_norm_squared(&problem.bodies[b], &u[b]));
        worst[2] = worst[2].max(relative_difference(&energies(&u), &energies(&b.displacement)));
    }
    worst
}

#[test]
fn the_iteration_is_the_one_with_whole_bodies_on_380_nodes() {
    let worst = difference_from_whole_bodies(paper::COARSE, 12);
    assert!(worst.iter().all(|d| *d < 1e-11), "{worst:?}");
}

#[test]
fn the_iteration_is_the_one_with_whole_bodies_on_5994_nodes() {
    let worst = difference_from_whole_bodies(paper::FINE, 4);
    assert!(worst.iter().all(|d| *d < 1e-10), "{worst:?}");
}

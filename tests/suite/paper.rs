//! The paper's problem: the prototype's figures on every path, the paths against each other, Clarabel called.

use contact_qp::QpMethod;
use fem_core::norm::energy_norm_squared;
use nndd::{NnddSettings, NnddSolution, NnddStatus, Path};
use tests::run::relative_difference;
use tests::{displacements, iterates, paper, prepare};

fn settings(path: Path, method: QpMethod) -> NnddSettings {
    let mut settings = NnddSettings::paper(0.4);
    settings.path = path;
    settings.qp.method = method;
    settings
}

fn table(settings: &NnddSettings) -> NnddSolution {
    let problem = paper::problem(paper::COARSE).unwrap();
    let mut settings = settings.clone();
    settings.max_iterations = 5;
    let (solution, _) = iterates(&prepare(&problem), &settings, 0.0).unwrap();
    assert_eq!(solution.status, NnddStatus::MaxIterations);
    assert_eq!(solution.history.len(), 5);
    for (row, (precision, eta, nodes, force)) in solution.history.iter().zip(paper::ITERATIONS) {
        let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-8 * expected;
        assert!(close(row.precision, precision), "{row:?}");
        assert!(close(row.eta_nndd, eta), "{row:?}");
        assert_eq!(row.contact_nodes, nodes, "{row:?}");
        assert!(close(row.contact_force, force), "{row:?}");
    }
    solution
}

#[test]
fn both_paths_reproduce_the_prototype_and_call_clarabel() {
    for path in [Path::Condensed, Path::Literal] {
        let solution = table(&settings(path, QpMethod::Auto));
        assert!(solution.clarabel_calls >= 1, "{path:?}");
    }
}

#[test]
fn clarabel_in_every_iteration_reproduces_the_prototype() {
    for path in [Path::Condensed, Path::Literal] {
        let solution = table(&settings(path, QpMethod::Clarabel));
        assert!(solution.clarabel_calls >= 5, "{path:?}");
    }
}

#[test]
fn the_active_set_method_needs_no_clarabel_for_the_same_table() {
    let solution = table(&settings(Path::Condensed, QpMethod::ActiveSet));
    assert_eq!(solution.clarabel_calls, 0);
}

#[test]
fn converged_values_are_the_prototypes() {
    let problem = paper::problem(paper::COARSE).unwrap();
    let prepared = prepare(&problem);
    for path in [Path::Condensed, Path::Literal] {
        let settings = settings(path, QpMethod::Auto);
        let (solution, _) = iterates(&prepared, &settings, 1e-10).unwrap();
        assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
        let u = displacements(&prepared, &solution.last);
        for b in 0..2 {
            let energy = energy_norm_squared(&problem.bodies[b], &u[b]);
            let exact = paper::ENERGIES[b];
            assert!((energy - exact).abs() <= 1e-8 * exact, "{path:?} body {b}: {energy}");
        }
        let force = solution.last.contact_force();
        assert!((force - paper::FORCE).abs() <= 1e-8 * paper::FORCE, "{path:?}: {force}");
        for (pair, r) in
            problem.contacts[0].interface.pairs().iter().zip(&solution.last.contact.normal_reaction)
        {
            let touches = pair.arc_length < paper::CONTACT_END + 1e-9;
            assert_eq!(*r > 0.0, touches, "{path:?} at {}: {r}", pair.arc_length);
        }
    }
}

/// Runs both paths and returns the largest relative difference of any interface vector of any iteration, that of
/// the indicators, and that of the final energies.
fn difference_of_paths(cells: [usize; 2], iterations: usize) -> [f64; 3] {
    let problem = paper::problem(cells).unwrap();
    let prepared = prepare(&problem);
    let run = |path| {
        let mut settings = settings(path, QpMethod::Auto);
        settings.max_iterations = iterations;
        iterates(&prepared, &settings, 0.0).unwrap().1
    };
    let (condensed, literal) = (run(Path::Condensed), run(Path::Literal));
    assert_eq!(condensed.len(), iterations);
    assert_eq!(literal.len(), iterations);
    let mut worst = [0.0f64; 3];
    for (a, b) in condensed.iter().zip(&literal) {
        assert_eq!(a.contact.active, b.contact.active, "iteration {}", a.iteration);
        let vectors = [
            (&a.lambda, &b.lambda),
            (&a.reaction, &b.reaction),
            (&a.contact.normal_reaction, &b.contact.normal_reaction),
            (&a.contact.normal_trace, &b.contact.normal_trace),
        ];
        for (x, y) in vectors {
            worst[0] = worst[0].max(relative_difference(x, y));
        }
        let indicators = relative_difference(&[a.eta_nndd], &[b.eta_nndd])
            .max(relative_difference(&[a.precision], &[b.precision]));
        worst[1] = worst[1].max(indicators);
    }
    let last = |x: &[nndd::Iterate]| {
        let u = displacements(&prepared, x.last().unwrap());
        [0, 1].map(|b| energy_norm_squared(&problem.bodies[b], &u[b]))
    };
    worst[2] = relative_difference(&last(&condensed), &last(&literal));
    worst
}

#[test]
fn the_condensed_path_is_the_literal_path_on_380_nodes() {
    let worst = difference_of_paths(paper::COARSE, 12);
    assert!(worst.iter().all(|d| *d < 1e-11), "{worst:?}");
}

#[test]
fn the_condensed_path_is_the_literal_path_on_5994_nodes() {
    let worst = difference_of_paths(paper::FINE, 4);
    assert!(worst.iter().all(|d| *d < 1e-10), "{worst:?}");
}

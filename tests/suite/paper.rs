//! The paper's problem against the independent prototype's figures, and its paths against each other.

use nndd::stopping::{EtaNndd, Never};
use nndd::{NnddSettings, NnddStatus, Path};
use tests::{condense_both, paper};

fn close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1e-300), "{what}: {a} against {b}");
}

fn run(path: Path, cells: [usize; 2], iterations: usize) -> nndd::NnddSolution {
    let problem = paper::problem(cells).unwrap();
    let bodies = condense_both(&problem);
    let mut settings = NnddSettings::paper(0.4);
    settings.path = path;
    settings.max_iterations = iterations;
    let lambda = vec![0.0; problem.interface.pairs().len()];
    nndd::solve(&problem, &bodies, lambda, &settings, &mut Never).unwrap()
}

#[test]
fn both_paths_reproduce_the_prototype() {
    for path in [Path::Condensed, Path::Literal] {
        let solution = run(path, paper::COARSE, 5);
        assert_eq!(solution.status, NnddStatus::MaxIterations);
        for (row, (precision, eta, nodes, force)) in solution.history.iter().zip(paper::ITERATIONS) {
            close(row.precision, precision, 1e-8, "precision");
            close(row.eta_nndd, eta, 1e-8, "eta_nndd");
            assert_eq!(row.contact_nodes, nodes);
            assert!((row.contact_force - force).abs() <= 1e-8 * paper::FORCE);
        }
        assert!(solution.clarabel_calls >= 1);
    }
}
#[test]
fn converged() {
    let problem = paper::problem(paper::COARSE).unwrap();
    let bodies = condense_both(&problem);
    let lambda = vec![0.0; problem.interface.pairs().len()];
    let s = nndd::solve(&problem, &bodies, lambda, &NnddSettings::paper(0.4), &mut EtaNndd::new(1e-11)).unwrap();
    let u = bodies[0].displacement_from_trace(&s.last.lambda);
    let v = bodies[1].displacement_from_trace(&s.last.contact.normal_trace);
    println!("{:?} {} {}", s.status, s.history.len(), s.last.contact_force());
    println!("{} {}", fem_core::norm::energy_norm_squared(&problem.bodies[0], &u), fem_core::norm::energy_norm_squared(&problem.bodies[1], &v));
}

//! A body that touches nothing changes nothing but its own entries.

use case_io::Case;
use certified_contact::{CertifiedSolution, Criterion, Settings, Silent, solve};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Partner};
use fem_core::mesh::generate::block;
use nndd::{Method, NnddSettings};
use tests::{paper, receding};

/// Adds a body that touches nothing, held or free.
fn with_an_idle_body(mut problem: ContactProblem, held: bool) -> ContactProblem {
    let mesh = block([10.0, 0.0], [1.0, 1.0], [2, 2]).unwrap();
    let conditions = BoundaryConditions::new();
    let conditions = if held { conditions.fix("bottom") } else { conditions };
    let material = problem.bodies[0].material(0).clone();
    problem.bodies.push(Body::new(mesh, material, &conditions).unwrap());
    problem
}

/// Solves a problem alone and with an idle body, and compares all but the entries of that body.
fn is_left_alone(problem: &ContactProblem, settings: &Settings) -> CertifiedSolution {
    let alone = solve(problem.clone(), settings, &mut Silent).unwrap();
    assert!(alone.is_certified());
    let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-11 * expected.abs();
    for held in [true, false] {
        let beside = solve(with_an_idle_body(problem.clone(), held), settings, &mut Silent).unwrap();
        let iterates = |answer: &CertifiedSolution| !matches!(answer.method, Method::Newton(_));
        assert_eq!(iterates(&beside), iterates(&alone), "another method");
        assert_eq!(beside.nndd.status, alone.nndd.status);
        assert_eq!(beside.role_reason, alone.role_reason);
        assert!(close(beside.nndd.theta, alone.nndd.theta), "{} {}", beside.nndd.theta, alone.nndd.theta);
        assert_eq!(beside.nndd.history.len(), alone.nndd.history.len());
        for (found, expected) in beside.nndd.history.iter().zip(&alone.nndd.history) {
            assert!(close(found.contact_force, expected.contact_force), "{found:?} {expected:?}");
            assert_eq!(found.contact_nodes, expected.contact_nodes);
            assert_eq!(found.qp_path, expected.qp_path);
            assert!((found.eta_nndd - expected.eta_nndd).abs() <= 1e-9 * expected.eta_nndd + 1e-14);
        }
        let [found, expected] = [&beside, &alone].map(|answer| answer.estimate.as_ref().unwrap());
        for b in 0..problem.bodies.len() {
            assert!(close(found.energy_norm_squared[b], expected.energy_norm_squared[b]));
            let [found, expected] = [found, expected].map(|e| e.cre.by_cell[b].iter().sum::<f64>());
            assert!((found - expected).abs() <= 1e-9 * expected + 1e-24, "{found:e} {expected:e}");
        }
        let [found, expected] = [&beside, &alone].map(|answer| answer.bounds.unwrap().contact_force);
        let ([a, b], [c, d]) = (found.unwrap(), expected.unwrap());
        assert!((a - c).abs().max((b - d).abs()) <= 1e-6 * (d - c) + 1e-11 * d, "{a} {b}, {c} {d}");
    }
    alone
}

#[test]
fn method_theta_history_and_bounds_are_those_of_the_bodies_in_contact() {
    let problem = paper::problem(paper::COARSE).unwrap();
    assert!(matches!(is_left_alone(&problem, &Settings::default()).method, Method::NewtonNn(_)));
    let mut papers = Settings::default().with_method(NnddSettings::paper(0.4));
    is_left_alone(&problem, &papers);
    papers.criterion = Criterion::Iterations;
    papers.method = papers.method.with_max_iterations(3);
    is_left_alone(&problem, &papers);
    is_left_alone(&receding::problem(1.0, 4).unwrap(), &Settings::default());
}

/// A layer that is 1e8 times as stiff as the ones about it, and the contact force; the solution is linear in each layer.
fn layers() -> (ContactProblem, f64) {
    let text = include_str!("../../crates/nndd-cli/tests/parts/layers_1e8.toml");
    let problem = Case::parse(text, "layers.toml", &[]).unwrap().build().unwrap().0;
    (problem, 1e-3 * 2.0 / (3.0 + 1e-8))
}

#[test]
fn digits_that_rounding_takes_are_recovered_beside_an_idle_body() {
    let (problem, exact) = layers();
    for held in [true, false] {
        let problem = with_an_idle_body(problem.clone(), held);
        let answer = solve(problem, &Settings::default(), &mut Silent).unwrap();
        let force = answer.last().contact_force();
        assert!((force / exact - 1.0).abs() < 1e-12, "{held}: {force:e} {exact:e}");
    }
}

#[test]
fn digits_that_rounding_takes_are_recovered_in_every_pair() {
    let (mut problem, exact) = layers();
    let mut second = problem.contacts[0].clone();
    second.body += 2;
    second.partner = Partner::Body(3);
    problem.contacts.push(second);
    problem.bodies.extend(problem.bodies.clone());
    for settings in [Settings::default(), Settings::default().with_method(NnddSettings::default())] {
        let answer = solve(problem.clone(), &settings, &mut Silent).unwrap();
        assert!(answer.is_certified());
        for block in answer.problem.blocks() {
            for force in answer.last().contact_forces_of(block) {
                assert!((force / exact - 1.0).abs() < 1e-12, "{force:e} {exact:e}");
            }
        }
    }
}

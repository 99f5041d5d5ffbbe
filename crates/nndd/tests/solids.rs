//! Contact of solids of tetrahedra on flat matching surfaces.
//!
//! The figures are those of an independent code (Python, with another solver), which a second one reproduced.
// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use fem_core::assembly::external_forces;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, FacetSelection};
use fem_core::interface::{ContactInterface, ContactProblem, Gap};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::norm::energy_norm_squared;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nalgebra::Vector3;
use nndd::stopping::EtaNndd;
use nndd::{NewtonSettings, NnddSettings, NnddSolution, NnddStatus, solve};

type Conditions = BoundaryConditions<Solid>;

const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Two blocks of which the upper one is pressed down on its left half and pulled up on its right half, with `n` cells per unit of length.
fn half_open(n: usize) -> ContactProblem<Solid> {
    let material = LinearElastic::isotropic_solid(1000.0, 0.3).unwrap();
    let body = |z: f64, conditions: Conditions| {
        let mesh = cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [2 * n, n, n]).unwrap();
        Body::new(mesh, material.clone(), &conditions.roller("front", 0.0)).unwrap()
    };
    let half = |x: [f64; 2]| FacetSelection::from("top").within([x, ALL, ALL]);
    let pressed = Conditions::default()
        .roller("left", 0.0)
        .components(half([0.0, 1.0]), [None, None, Some((-0.02).into())])
        .traction(half([1.0, 2.0]), [0.0.into(), 0.0.into(), 5.0.into()]);
    let (upper, lower) = (body(1.0, pressed), body(0.0, Conditions::default().fix("bottom")));
    let interface = ContactInterface::pair_flat(&upper, &lower, ["bottom", "top"], &Gap::Touching).unwrap();
    ContactProblem::between([upper, lower], interface)
}

/// The numbers of a solution.
struct Found {
    /// `½ a(u, u) − f·u`, J.
    energy: f64,
    /// `a(u, u)` of each body, J.
    bodies: Vec<f64>,
    /// The sum of the contact forces, N.
    force: f64,
    /// Pairs of nodes with a force.
    closed: usize,
}

fn found(prepared: &PreparedProblem<Solid>, solution: &NnddSolution) -> Found {
    let fields = prepared.displacements(&solution.last.fields(&prepared.system()));
    let bodies = &prepared.problem().bodies;
    let energies: Vec<f64> =
        bodies.iter().zip(&fields).map(|(body, u)| energy_norm_squared(body, u)).collect();
    let work = |(body, u): (&Body<Solid>, &Vec<Vector3<f64>>)| -> f64 {
        external_forces(body).iter().zip(u).map(|(f, u)| f.dot(u)).sum()
    };
    let work: f64 = bodies.iter().zip(&fields).map(work).sum();
    let force = &solution.last.contact.normal_reaction;
    Found {
        energy: 0.5 * energies.iter().sum::<f64>() - work,
        bodies: energies,
        force: force.iter().sum(),
        closed: force.iter().filter(|force| **force > 0.0).count(),
    }
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found:.13} is not {expected}");
}

#[test]
fn half_open_blocks_have_the_forces_of_another_code() {
    let known =
        [(2, 15, 12, 13.311_005_296_1, 0.193_219_090_71), (4, 45, 30, 11.792_162_388_6, 0.162_120_223_154)];
    for (n, pairs, closed, force, energy) in known {
        let prepared = PreparedProblem::new(half_open(n)).unwrap();
        let start = vec![0.0; prepared.rows()];
        let mut stop = EtaNndd::new(1e-12);
        let solution = solve(&prepared.system(), start, NewtonSettings::default(), &mut stop).unwrap();
        let found = found(&prepared, &solution);
        assert_eq!((prepared.node_pairs(), found.closed), (pairs, closed));
        assert_near(found.force, force, 1e-11);
        assert_near(found.energy, energy, 1e-10);
        if n == 2 {
            assert_near(found.bodies[0], 0.224_504_065_268, 1e-11);
            assert_near(found.bodies[1], 0.121_497_965_157, 1e-11);
        }
        // The opening is the gap less the difference of the fields.
        let fields = prepared.displacements(&solution.last.fields(&prepared.system()));
        let interface = &prepared.problem().contacts[0].interface;
        for (pair, opening) in interface.pairs().iter().zip(&solution.last.opening) {
            let [u, v] = [0, 1].map(|b: usize| fields[b][pair.nodes[b].index()]);
            assert!((pair.gap - (u - v).dot(&pair.normal) - opening).abs() < 1e-15);
        }
    }
}

#[test]
fn the_iteration_of_half_open_blocks_has_the_history_of_another_code() {
    let mut settings = NnddSettings::paper(0.4);
    settings.max_iterations = 100;
    for (n, iterations) in [(2, 58), (4, 65)] {
        let prepared = PreparedProblem::new(half_open(n)).unwrap();
        let start = vec![0.0; prepared.rows()];
        let mut stop = EtaNndd::new(1e-10);
        let solution = solve(&prepared.system(), start, settings.clone(), &mut stop).unwrap();
        assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
        let history: Vec<f64> = solution.history.iter().map(|row| row.eta_nndd).collect();
        eprintln!("{n}: {} {:?}", history.len(), &history[..4]);
        assert_eq!(history.len(), iterations);
        if n == 4 {
            for (found, known) in history.iter().zip([0.671308, 0.168909, 0.0828234, 0.0560132]) {
                assert_near(*found, known, 1e-5);
            }
        }
    }
}

//! Friction under Hertz' pressure against the closed form of Cattaneo and Mindlin.

use certified_contact::nndd::{CoulombSettings, CoulombStatus};
use certified_contact::{Silent, solve_coulomb};
use cre_estimator::Relaxation;
use fem_core::interface::Friction;
use tests::cattaneo::{MU, STICK, friction, problem};

#[test]
fn friction_and_stick_under_the_pressure_of_hertz_are_those_of_cattaneo_and_mindlin() {
    let problem = problem(160, Friction::Coulomb { mu: MU }).unwrap();
    let settings = CoulombSettings::default();
    let found = solve_coulomb(problem, &settings, Relaxation::Steps(2), &mut Silent).unwrap();
    assert_eq!(found.solution.status, CoulombStatus::Converged);
    let pairs = found.problem.contacts[0].interface.pairs();
    let forces = &found.solution.exact.friction[0].force;
    let places = pairs.iter().map(|pair| found.problem.bodies[0].mesh().points()[pair.nodes[0]][0]);
    let nodes: Vec<(f64, f64, f64)> =
        places.zip(pairs).zip(forces).map(|((x, pair), q)| (x, pair.weight, q / pair.weight)).collect();
    let (mut difference, mut size) = (0.0, 0.0);
    for (x, length, q) in &nodes {
        difference += length * (q - friction(*x)).powi(2);
        size += length * friction(*x).powi(2);
    }
    let of_friction = (difference / size).sqrt();
    let worst = nodes.iter().map(|(x, _, q)| (q - friction(*x)).abs()).fold(0.0, f64::max) / MU;
    // The whole friction force is μ P (1 − c²), with P = π/2.
    let whole: f64 = forces.iter().sum();
    let force = whole / (MU * 0.5 * std::f64::consts::PI * (1.0 - STICK * STICK));
    let stick = &found.results.contacts[0].friction.as_ref().unwrap().stick_intervals;
    println!(
        "friction {of_friction:.4}, worst {worst:.4} mu p0, force {force:.5}, stick {stick:?}, e_b {:?}",
        found.relative_residual()
    );
    // It sticks for |x| < c a with a = 1: both ends to an edge.
    let stuck: f64 = stick.iter().map(|[start, end]| end - start).sum();
    let edge = nodes.iter().filter(|(x, ..)| x.abs() < 1.0).map(|(_, length, _)| *length).fold(0.0, f64::max);
    assert!((stuck - 2.0 * STICK).abs() <= 2.0 * edge, "{stuck} instead of {}, edges of {edge}", 2.0 * STICK);
    assert!(of_friction < 0.02 && (force - 1.0).abs() < 0.02, "{of_friction} {force}");
}

//! Three blocks on a rigid floor, held by contact and driven by a force: the error and the contact forces, certified.
//!
//! The pressure on the top grows to the right, and no support holds a block in y.
#![allow(clippy::print_stdout)]

use certified_contact::fem_core::boundary::{BoundaryConditions, ScalarData};
use certified_contact::fem_core::interface::{ContactProblem, Gap, Obstacle, RigidLine};
use certified_contact::fem_core::material::{Hypothesis, LinearElastic};
use certified_contact::fem_core::{body::Body, geometry::Vector, mesh::generate::block};
use certified_contact::{AdaptSettings, AdaptiveSolution, Settings, Silent, solve_adaptively};
use std::error::Error;

fn certified() -> Result<AdaptiveSolution, Box<dyn Error>> {
    let mut bodies = Vec::new();
    for (k, young) in [2000.0, 500.0, 3000.0].into_iter().enumerate() {
        let mut conditions = BoundaryConditions::new().displace("left", Some(0.0.into()), None);
        if k == 2 {
            // 10 x on a length of 2: a force of 20.
            let pressure = ScalarData::function(|at| 10.0 * at[0]);
            conditions = conditions.pressure("top", pressure);
        }
        let material = LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain)?;
        bodies.push(Body::new(block([0.0, k as f64], [2.0, 1.0], [12, 6])?, material, &conditions)?);
    }
    let touch = |a: usize, b: usize| {
        contact_geometry::pair(&bodies[a], &bodies[b], ["top", "bottom"], &Gap::Touching)
    };
    let (lower, upper) = (touch(0, 1)?, touch(1, 2)?);
    let floor = RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() };
    let on_floor = contact_geometry::against(&bodies[0], "bottom", &Obstacle::fixed(floor), None)?;
    let problem = ContactProblem::new(bodies).contact([0, 1], lower).contact([1, 2], upper).obstacle(
        0,
        on_floor,
        Obstacle::fixed(floor),
    );
    Ok(solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(0.05), &mut Silent)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let answer = certified()?;
    for step in &answer.history {
        let percent = (1e4 * step.relative.unwrap_or(f64::NAN)).ceil() / 100.0;
        println!("mesh {}: {:6} nodes, certified error <= {percent:.2} %", step.step, step.nodes);
    }
    let pairs = ["lower and middle", "middle and upper", "lower and floor"];
    let results = answer.solution.results.as_ref().ok_or("no results")?;
    for (pair, found) in pairs.iter().zip(&results.contacts) {
        println!(
            "{pair}: contact force {:.6}, smallest opening {:.2e}",
            found.contact_force, found.min_opening
        );
    }
    Ok(())
}

#[test]
fn every_contact_carries_the_whole_force() {
    use certified_contact::AdaptiveEnd;
    let answer = certified().unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet));
    let solution = &answer.solution;
    assert!(solution.is_certified() && solution.relative().unwrap() <= 0.05);
    let results = solution.results.as_ref().unwrap();
    assert_eq!(results.contacts.len(), 3);
    for found in &results.contacts {
        assert!((found.contact_force - 20.0).abs() < 1e-8, "{found:?}");
        assert!(found.min_opening > -1e-12, "{found:?}");
    }
}

//! From two blocks to a contact force with a certified error of at most 2 %.
//!
//! The upper block is pressed down and pulled up at its right side, so that contact opens there.
#![allow(clippy::print_stdout)]

use certified_contact::fem_core::interface::{ContactProblem, Gap};
use certified_contact::fem_core::material::{Hypothesis, LinearElastic};
use certified_contact::fem_core::{body::Body, boundary::BoundaryConditions, mesh::generate::block};
use certified_contact::{AdaptSettings, AdaptiveSolution, Settings, Silent, solve_adaptively};
use std::error::Error;

fn certified() -> Result<AdaptiveSolution, Box<dyn Error>> {
    let material = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
    let pressed = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("top", None, Some((-0.02).into()))
        .traction("right", [0.0.into(), 30.0.into()]);
    let held = BoundaryConditions::new().fix("bottom");
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [16, 8])?, material.clone(), &pressed)?;
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [16, 8])?, material, &held)?;
    let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
    let problem = ContactProblem::between([upper, lower], interface);
    Ok(solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(0.02), &mut Silent)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let answer = certified()?;
    for step in &answer.history {
        // A bound is rounded up.
        let percent = (1e4 * step.relative.unwrap_or(f64::NAN)).ceil() / 100.0;
        println!("mesh {}: {:6} nodes, certified error <= {percent:.2} %", step.step, step.nodes);
    }
    if let Some([low, high]) = answer.solution.bounds.and_then(|b| b.contact_force.ok()) {
        println!("contact force between {low:.4} and {high:.4}, whatever the mesh");
    }
    Ok(())
}

#[test]
fn two_percent_are_certified_and_the_bounds_nest() {
    use certified_contact::AdaptiveEnd;
    let answer = certified().unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet));
    let solution = &answer.solution;
    assert!(solution.is_certified() && solution.relative().unwrap() <= 0.02);
    let [low, high] = solution.bounds.unwrap().contact_force.unwrap();
    let force = solution.results.as_ref().unwrap().contact_force;
    assert!(low < force && force < high && high - low < 0.05 * force, "{low} {force} {high}");
    assert!(answer.history.windows(2).all(|s| s[1].e_cre < s[0].e_cre));
}

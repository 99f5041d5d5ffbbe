//! Certifies a displacement field that another code computed: nodes and displacements are read from a file.
//!
//! ```text
//! cargo run --release -p cre-estimator --example certify -- [FILE.csv]     default: the file beside this one
//! ```
//! `displacement.csv` (body,x,y,ux,uy) was written with seven digits by a primal-dual active set in Python, assembled by
//! scikit-fem, on 18×9 cells per body of this problem:
//! ```text
//!        u_y = −0.02                 Ω₁ = (0,2)×(1,2), E₁ = 2000
//!      ┌─────────────┐               Ω₂ = (0,2)×(0,1), E₂ = 1000
//! u_x=0│     Ω₁      │→ (0, 30)      ν = 0.3, plane strain
//!      ├─────────────┤
//!      │     Ω₂      │ clamped
//!      └─────────────┘
//! ```
//! No other data are used: forces and openings follow from the displacements. A field with few digits, or a wrong one,
//! gets a larger bound, never a false one. A field that violates the supports gets no bound.
#![allow(clippy::print_stdout)]

use cre_estimator::{FieldCertificate, Relaxation};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::{Vector, norm};
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::mesh_field::MeshField;
use fem_core::prepared::PreparedProblem;
use std::error::Error;
use std::path::PathBuf;

const CELLS: [usize; 2] = [18, 9];
const PUSH: f64 = -0.02;

fn problem() -> Result<ContactProblem, Box<dyn Error>> {
    let material = |young| LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain);
    let pressed = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("top", None, Some(PUSH.into()))
        .traction("right", [0.0.into(), 30.0.into()]);
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], CELLS)?, material(2000.0)?, &pressed)?;
    let clamped = BoundaryConditions::new().fix("bottom");
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], CELLS)?, material(1000.0)?, &clamped)?;
    let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
    Ok(ContactProblem::between([upper, lower], interface))
}

/// Reads `body,x,y,ux,uy` and gives each node of the problem the displacement at its position.
fn read(text: &str, problem: &ContactProblem) -> Result<[Vec<Vector>; 2], Box<dyn Error>> {
    let mut rows = vec![];
    for (k, line) in text.lines().enumerate().skip(1) {
        let fault = |e| format!("line {}: found `{line}`, expected body,x,y,ux,uy: {e}", k + 1);
        let numbers = line.split(',').map(|v| v.trim().parse::<f64>()).collect::<Result<Vec<_>, _>>();
        let numbers = numbers.map_err(|e| fault(e.to_string()))?;
        let row: [f64; 5] = numbers.try_into().map_err(|_| fault("not five numbers".to_owned()))?;
        rows.push(row);
    }
    let field = |b: usize| {
        let at = |p: &Vector| {
            let here = |r: &&[f64; 5]| r[0] == (b + 1) as f64 && norm(Vector::new(r[1], r[2]) - p) < 1e-6;
            let row = rows.iter().find(here).map(|r| Vector::new(r[3], r[4]));
            row.ok_or_else(|| format!("no row for the node of body {} at ({}, {})", b + 1, p[0], p[1]))
        };
        problem.bodies[b].mesh().points().iter().map(at).collect::<Result<Vec<Vector>, String>>()
    };
    Ok([field(0)?, field(1)?])
}

/// Refuses a field of other supports: the file has seven digits of the imposed displacements.
fn check_supports(body: &Body, displacement: &[Vector]) -> Result<(), String> {
    for (node, (u, constraint)) in displacement.iter().zip(body.node_constraints()).enumerate() {
        if constraint.violation(*u) > 1e-6 * PUSH.abs() {
            let held = constraint.displacement();
            return Err(format!("node {node} is held at {held:?}, and the file moves it by {u:?}"));
        }
    }
    Ok(())
}

/// Certifies a pair of displacement fields.
fn certify(
    prepared: &PreparedProblem,
    displacement: &[Vec<Vector>],
    relaxation: Relaxation,
) -> Result<FieldCertificate, Box<dyn Error>> {
    for (body, displacement) in prepared.problem().bodies.iter().zip(displacement) {
        check_supports(body, displacement)?;
    }
    let given = prepared.problem().bodies.iter().zip(displacement);
    let given: Vec<_> = given.map(|(body, u)| MeshField::new(body.mesh(), u)).collect();
    Ok(cre_estimator::certify(prepared, &given, None, relaxation)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/displacement.csv");
    let file = std::env::args_os().nth(1).map_or_else(beside, PathBuf::from);
    let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    let problem = PreparedProblem::new(problem()?)?;
    let displacement = read(&text, problem.problem())?;
    for steps in [0, 2, 8] {
        let found = certify(&problem, &displacement, Relaxation::Steps(steps))?;
        match (found.bound(), found.relative()) {
            (Some(bound), Some(relative)) => {
                let percent = (1e4 * relative).ceil() / 100.0; // A bound is rounded up.
                println!(
                    "{steps} steps of relaxation: error <= {bound:.6} in the energy norm, {percent:.2} %"
                );
            }
            _ => println!("{steps} steps of relaxation: no bound, {:?}", found.estimate.admissibility),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::norm::energy_distance_squared;

    const FIELD: &str = include_str!("displacement.csv");

    #[test]
    fn foreign_field_is_certified_as_sharply_as_our_own() {
        let prepared = PreparedProblem::new(problem().unwrap()).unwrap();
        let problem = prepared.problem();
        let field = read(FIELD, problem).unwrap();
        let bound = |steps| {
            let found = certify(&prepared, &field, Relaxation::Steps(steps)).unwrap();
            assert!(found.estimate.admissibility.is_valid(), "{:?}", found.estimate.admissibility);
            (found.bound().unwrap(), 100.0 * found.relative().unwrap())
        };
        let bounds = [0, 2, 8].map(bound);
        assert!(bounds.windows(2).all(|b| b[1].0 < b[0].0), "{bounds:?}");
        // The command `nndd`, iterated to the end on the same mesh with two steps, certifies 18.76 % (own earlier value).
        assert!((bounds[1].1 - 18.76).abs() < 0.1, "{bounds:?}");
    }

    #[test]
    fn spoilt_field_gets_a_bound_that_covers_what_was_spoilt() {
        let prepared = PreparedProblem::new(problem().unwrap()).unwrap();
        let problem = prepared.problem();
        let good = read(FIELD, problem).unwrap();
        let mut spoilt = good.clone();
        // A bump inside the lower body, away from supports and contact.
        for (u, p) in spoilt[1].iter_mut().zip(problem.bodies[1].mesh().points()) {
            u[0] += 0.05 * p[1] * (1.0 - p[1]);
        }
        let distance = energy_distance_squared(&problem.bodies[1], &good[1], &spoilt[1]).sqrt();
        let [sound, bad] =
            [good, spoilt].map(|u| certify(&prepared, &u, Relaxation::Steps(2)).unwrap().bound().unwrap());
        assert!(bad >= distance - sound && bad > 2.0 * sound, "{bad} {distance} {sound}");
    }

    #[test]
    fn field_of_other_supports_gets_no_bound() {
        let prepared = PreparedProblem::new(problem().unwrap()).unwrap();
        let problem = prepared.problem();
        let good = read(FIELD, problem).unwrap();
        // Half of the force everywhere: in balance with its own forces, but not a solution of the problem.
        let half = good.each_ref().map(|u| u.iter().map(|u| 0.5 * *u).collect::<Vec<Vector>>());
        let error = certify(&prepared, &half, Relaxation::NONE).unwrap_err().to_string();
        assert!(error.contains("is held at"), "{error}");
        let given = [0, 1].map(|b| MeshField::new(problem.bodies[b].mesh(), &half[b]));
        let found = cre_estimator::certify(&prepared, &given, None, Relaxation::NONE).unwrap();
        let checks = found.estimate.admissibility;
        assert!(checks.imposed_displacement > 0.4 && found.bound().is_none(), "{checks:?}");
    }

    #[test]
    fn faults_of_the_file_are_named() {
        let prepared = PreparedProblem::new(problem().unwrap()).unwrap();
        let problem = prepared.problem();
        let error = read("body,x,y,ux,uy\n1,0,0,0\n", problem).unwrap_err().to_string();
        assert!(error.starts_with("line 2:"), "{error}");
        let error = read("body,x,y,ux,uy\n", problem).unwrap_err().to_string();
        assert!(error.contains("no row for the node"), "{error}");
    }
}

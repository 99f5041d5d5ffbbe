//! Certifies the contact of two solid bodies: half of the upper block is pressed down, half is pulled up.
//!
//! `cargo run --release -p certified-contact --example solids`

#![allow(clippy::print_stdout)]

use certified_contact::{cre_estimator, fem_core, nndd};
use cre_estimator::Relaxation;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, FacetSelection};
use fem_core::interface::{ContactInterface, ContactProblem, Gap};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nndd::NewtonSettings;
use nndd::stopping::EtaNndd;
use std::error::Error;

/// Makes the blocks, with `n` cubes of six tetrahedra along their heights.
fn blocks(n: usize) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let material = LinearElastic::isotropic_solid(1000.0, 0.3)?;
    let body = |z: f64, conditions: BoundaryConditions<Solid>| -> Result<Body<Solid>, Box<dyn Error>> {
        let mesh = cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [2 * n, n, n])?;
        Ok(Body::new(mesh, material.clone(), &conditions.roller("front", 0.0))?)
    };
    let half = |x: [f64; 2]| FacetSelection::from("top").within([x, [0.0, 1.0], [2.0, 2.0]]);
    let pressed = BoundaryConditions::default()
        .roller("left", 0.0)
        .components(half([0.0, 1.0]), [None, None, Some((-0.02).into())])
        .traction(half([1.0, 2.0]), [0.0.into(), 0.0.into(), 5.0.into()]);
    let (upper, lower) = (body(1.0, pressed)?, body(0.0, BoundaryConditions::default().fix("bottom"))?);
    let interface = ContactInterface::pair_flat(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
    Ok(ContactProblem::between([upper, lower], interface))
}

/// The numbers of one mesh.
#[derive(Debug)]
struct Certified {
    nodes: usize,
    /// `J = ∑ ½ ‖u_h‖² − f·u_h`.
    potential: f64,
    /// `e_CRE` of the recovered and of the relaxed stress.
    bounds: [f64; 2],
}

/// Solves, and bounds the error.
fn certified(n: usize) -> Result<Certified, Box<dyn Error>> {
    let prepared = PreparedProblem::new(blocks(n)?)?;
    let start = vec![0.0; prepared.rows()];
    let found =
        nndd::solve(&prepared.system(), start, NewtonSettings::default(), &mut EtaNndd::new(1e-12))?.last;
    let relaxed = [Relaxation::NONE, Relaxation::default()].map(|relaxation| {
        let estimate = certified_contact::estimate(&prepared, &found, relaxation)?;
        let bound = estimate.certificate().ok_or("a check of the estimate fails")?.e_cre;
        Ok::<_, Box<dyn Error>>((estimate, bound))
    });
    let [recovered, relaxed] = relaxed;
    let ((estimate, first), (_, second)) = (recovered?, relaxed?);
    let bodies = prepared.external_forces().iter().zip(&estimate.pair.bodies);
    let work: f64 =
        bodies.flat_map(|(f, body)| f.iter().zip(&body.displacement)).map(|(f, u)| f.dot(u)).sum();
    Ok(Certified {
        nodes: prepared.problem().nodes(),
        potential: 0.5 * estimate.energy_norm().powi(2) - work,
        bounds: [first, second],
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:>8}  {:>10}  {:>10}  {:>10}", "nodes", "potential", "recovered", "relaxed");
    for n in [2, 4, 8] {
        let Certified { nodes, potential, bounds: [recovered, relaxed] } = certified(n)?;
        println!("{nodes:>8}  {potential:>10.6}  {recovered:>10.6}  {relaxed:>10.6}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::certified;

    #[test]
    fn the_bounds_are_those_of_another_code() {
        for (n, nodes, recovered, digit) in [(2, 90, 2.20182561, 1e-8), (4, 450, 1.669669, 1e-6)] {
            let found = certified(n).unwrap();
            assert_eq!(found.nodes, nodes);
            assert!((found.bounds[0] - recovered).abs() < digit, "{found:?}");
            assert!(found.bounds[1] < 0.4 * found.bounds[0], "{found:?}");
        }
    }

    #[test]
    fn the_bound_is_not_below_the_distance_to_a_finer_mesh() {
        let found = [2, 4].map(|n| certified(n).unwrap());
        // The meshes are nested: J falls, by at most half of the square of the bound.
        let [coarse, fine] = found;
        let fall = coarse.potential - fine.potential;
        assert!(fall > 0.0 && 2.0 * fall < coarse.bounds[1].powi(2), "{coarse:?} {fine:?}");
    }
}

//! Certifies the contact of two solid bodies: half of the upper block is pressed down, half is pulled up.
//!
//! `cargo run --release -p certified-contact --example solids`

#![allow(clippy::print_stdout)]

use certified_contact::{Settings, Silent, cre_estimator, fem_core, solve};
use cre_estimator::Relaxation;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, FacetSelection};
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::space::Solid;
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
    let interface = contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
    Ok(ContactProblem::between([upper, lower], interface))
}

/// The numbers of one mesh.
#[derive(Debug)]
struct Certified {
    nodes: usize,
    /// The interval in which the potential energy of the exact solution is, J.
    potential: [f64; 2],
    /// The area in contact, m²: facets closed at every node, and at one node at least.
    area: [f64; 2],
    /// `e_CRE`, square root of J.
    bound: f64,
}

/// Solves, and bounds the error.
fn certified(n: usize, relaxation: Relaxation) -> Result<Certified, Box<dyn Error>> {
    let mut settings = Settings::<Solid>::default();
    settings.relaxation = relaxation;
    let found = solve(blocks(n)?, &settings, &mut Silent)?;
    let estimate = found.estimate.as_ref().ok_or("there is no estimate")?;
    let bound = estimate.certificate().ok_or("a check of the estimate fails")?.e_cre;
    let (bounds, results) = (found.bounds.ok_or("no bounds")?, found.results.ok_or("no results")?);
    let area = &results.contacts[0].area;
    Ok(Certified {
        nodes: found.problem.nodes(),
        potential: bounds.potential_energy,
        area: [area.inner, area.outer],
        bound,
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:>8}  {:>23}  {:>15}  {:>10}", "nodes", "potential", "area", "bound");
    for n in [2, 4, 8] {
        let Certified { nodes, potential: [low, high], area: [inner, outer], bound } =
            certified(n, Relaxation::default())?;
        println!("{nodes:>8}  {low:>10.6} … {high:>10.6}  {inner:>6.3} … {outer:>6.3}  {bound:>10.6}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::certified;
    use certified_contact::cre_estimator::Relaxation;

    #[test]
    fn the_bounds_are_those_of_another_code() {
        for (n, nodes, recovered) in [(2, 90, 2.20182561), (4, 450, 1.669669)] {
            let [first, relaxed] =
                [Relaxation::NONE, Relaxation::default()].map(|relaxation| certified(n, relaxation).unwrap());
            assert_eq!(first.nodes, nodes);
            // The iteration stops at one percent of the error of the mesh.
            assert!((first.bound - recovered).abs() < 1e-4, "{first:?}");
            assert!(relaxed.bound < 0.4 * first.bound, "{relaxed:?}");
        }
    }

    #[test]
    fn the_intervals_of_nested_meshes_meet() {
        let [coarse, fine] = [2, 4].map(|n| certified(n, Relaxation::default()).unwrap());
        let ([a, b], [c, d]) = (coarse.potential, fine.potential);
        assert!(a <= d && c <= b && d < b, "{coarse:?} {fine:?}");
    }
}

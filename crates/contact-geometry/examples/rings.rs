//! A pin in a hole whose meshes do not match: the common refinement, and the gap between the circles on finer and finer meshes.
//!
//! ```text
//!   ╭───────╮
//!   │ ╭───╮ │    The pin has radius 0.99 and 20 edges, the hole radius 1 and 33 edges, both around the origin; all circles are declared.
//!   │ ╰───╯ │
//!   ╰───────╯
//! ```
//! Polygons are apart by more or less than circles, by the square of their edges. The gaps here are those of the circles on every mesh.
#![allow(clippy::print_stdout)]

use contact_geometry::{ContactNormal, common_refinement::common_refinement, pair_refined, refined};
use fem_core::body::{Body, CurveKind, CurvedSide};
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::ring;
use fem_core::mesh::refine::RefinementEdges;
use std::error::Error;

const RADII: [f64; 2] = [0.99, 1.0];

fn body(radii: [f64; 2], cells: usize) -> Result<Body, Box<dyn Error>> {
    let steel = LinearElastic::isotropic(210e9, 0.3, Hypothesis::PlaneStrain)?;
    let mesh = ring([0.0; 2], radii, [0.0, 360.0], [cells, 2])?;
    let arc = |on: &str| CurvedSide { on: on.to_owned(), kind: CurveKind::Arc };
    Ok(Body::new(mesh, steel, &BoundaryConditions::new())?.with_curves(&[arc("inner"), arc("outer")])?)
}

/// The numbers of pairs and the largest error of a gap, on the first mesh and several finer ones, m.
fn gaps(finer: usize) -> Result<Vec<(usize, f64)>, Box<dyn Error>> {
    let bodies = [body([0.5, RADII[0]], 20)?, body([RADII[1], 2.0], 33)?];
    let (sides, normal) = (["outer", "inner"], ContactNormal::Averaged);
    let common = common_refinement(bodies, sides, normal)?;
    let interface = pair_refined(&common, sides, &Gap::Geometric, normal)?;
    let mut problem = ContactProblem::between(common.bodies, interface);
    let mut edges: Vec<_> = problem.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect();
    let mut found = Vec::new();
    for mesh in 0..=finer {
        if mesh > 0 {
            let all = |body: &Body| vec![true; body.mesh().topology().facets().len()];
            let next = refined(&problem, &edges, &problem.bodies.iter().map(all).collect::<Vec<_>>())?;
            edges = next.refinements.into_iter().map(|refinement| refinement.refinement_edges).collect();
            problem = next.problem;
        }
        let pairs = problem.contacts[0].interface.pairs();
        let error = |gap: f64| (gap - (RADII[1] - RADII[0])).abs();
        found.push((pairs.len(), pairs.iter().map(|pair| error(pair.gap)).fold(0.0, f64::max)));
    }
    Ok(found)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("pairs  largest error of a gap [m]");
    for (pairs, error) in gaps(3)? {
        println!("{pairs:5}  {error:.1e}");
    }
    Ok(())
}

#[test]
fn gaps_are_those_of_the_circles_on_every_mesh() {
    let found = gaps(3).unwrap();
    assert!(found.iter().all(|(_, error)| *error < 1e-12), "{found:?}");
    assert!(found.windows(2).all(|meshes| meshes[1].0 == 2 * meshes[0].0), "{found:?}");
}

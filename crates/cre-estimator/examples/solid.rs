//! Certifies a solid body: a block on a rough floor under its weight and a pressure on a part of its top. No code but this one bounds the error on
//! tetrahedra without an unknown constant.
//!
//! `cargo run --release -p cre-estimator --example solid`

#![allow(clippy::print_stdout)]

use cre_estimator::fem_core::assembly::System;
use cre_estimator::fem_core::body::Body;
use cre_estimator::fem_core::boundary::{BoundaryConditions, FacetSelection};
use cre_estimator::fem_core::condensation::CondensedBody;
use cre_estimator::fem_core::interface::InterfaceSide;
use cre_estimator::fem_core::material::LinearElastic;
use cre_estimator::fem_core::mesh::generate::cuboid;
use cre_estimator::fem_core::norm::energy_norm_squared;
use cre_estimator::fem_core::space::Solid;
use cre_estimator::fem_core::{self, field};
use cre_estimator::{EquilibratedStress, Relaxation, relax};
use std::error::Error;

/// Solves on `n³` cubes of six tetrahedra. Returns the number of nodes, `‖u_h‖` and the bound of `‖u − u_h‖`.
fn certified(n: usize) -> Result<(usize, f64, f64), Box<dyn Error>> {
    let loaded = FacetSelection::group("top").within([[0.0, 0.5], [0.0, 1.0], [1.0, 1.0]]);
    let conditions = BoundaryConditions::<Solid>::default()
        .fix("bottom")
        .pressure(loaded, 1.0)
        .body_force([0.0, 0.0, -0.2]);
    let material = LinearElastic::isotropic_solid(100.0, 0.3)?;
    let body = Body::new(cuboid([0.0; 3], [1.0; 3], [n; 3])?, material, &conditions)?;
    let system = System::assemble(&body, &InterfaceSide::default())?;
    let displacement = CondensedBody::factorise(system, body.mesh().points())?.displacement_from_force(&[]);

    // A stress in exact equilibrium with the loads, then closer to the FE stress: Prager and Synge's bound.
    let stress = field::stresses(&body, &displacement);
    let mut equilibrated = EquilibratedStress::recover(&body, stress, body.facet_conditions().to_vec());
    relax(&body, &mut equilibrated, Relaxation::default());
    let bound = fem_core::norm::from_squared(equilibrated.distance_squared(&body));
    Ok((body.mesh().points().len(), energy_norm_squared(&body, &displacement).sqrt(), bound))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:>8}  {:>10}  {:>10}  {:>9}", "nodes", "energy", "bound", "relative");
    for n in [2, 4, 8] {
        let (nodes, energy, bound) = certified(n)?;
        println!("{nodes:>8}  {energy:>10.6}  {bound:>10.6}  {:>7.2} %", 100.0 * bound / energy.hypot(bound));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::certified;

    #[test]
    fn intervals_of_the_energy_norm_meet() {
        // Nothing is imposed, so that ‖u_h‖ ≤ ‖u‖ ≤ √(‖u_h‖² + bound²).
        let found = [2, 4].map(|n| certified(n).unwrap());
        let [(_, coarse, bound), (_, fine, smaller)] = found;
        assert!(coarse < fine && fine < coarse.hypot(bound) && smaller < bound, "{found:?}");
    }
}

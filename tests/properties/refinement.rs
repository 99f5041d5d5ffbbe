//! A finer mesh, made from a coarser one, is never worse: the potential energy of its discrete solution is not larger, and
//! stays above what the coarse certificate says of the exact one.

use crate::check;
use crate::model::{Motion, models};
use certified_contact::{Bounds, Imposed, Settings, Silent, solve};
use fem_core::interface::ContactProblem;
use fem_core::mesh::refine::RefinementEdges;
use nndd::NewtonSettings;
use proptest::prelude::*;
use tests::random::Random;

/// The discrete solution's bounds; the upper one of the potential energy is its own.
fn bounds(problem: &ContactProblem) -> (Bounds, f64) {
    let mut settings = Settings::default();
    settings.imposed = Imposed::First;
    settings.method = NewtonSettings::default().into();
    let solution = solve(problem.clone(), &settings, &mut Silent).unwrap();
    assert!(solution.is_certified());
    let energy = solution.results.as_ref().unwrap().energy_norm_squared.iter().sum();
    (solution.bounds.unwrap(), energy)
}

#[test]
fn refinement_never_raises_the_energy_error() {
    check("refinement", 300, &(models(), any::<u64>(), 0.02..0.7f64), |(model, seed, share)| {
        let mut problem = model.problem(&Motion::NONE);
        let mut edges: Vec<_> = problem.bodies.iter().map(|b| RefinementEdges::longest(b.mesh())).collect();
        let mut random = Random::new(seed);
        let (mut coarse, energy) = bounds(&problem);
        for _ in 0..3 {
            let marked = [0, 1].map(|b| {
                let count = problem.bodies[b].mesh().topology().facets().len();
                (0..count).map(|_| random.unit() < share).collect::<Vec<bool>>()
            });
            let finer = contact_geometry::refined(&problem, &edges, &marked).unwrap();
            edges = finer.refinements.into_iter().map(|r| r.refinement_edges).collect();
            problem = finer.problem;
            let (fine, _) = bounds(&problem);
            let [low, high] = coarse.potential_energy;
            prop_assert!(fine.potential_energy[1] <= high + 1e-11 * energy, "{fine:?} after {coarse:?}");
            prop_assert!(fine.potential_energy[1] >= low, "{fine:?} after {coarse:?}");
            // The exact energy norm lies in both.
            prop_assert!(fine.energy_norm[0] <= coarse.energy_norm[1], "{fine:?} after {coarse:?}");
            prop_assert!(fine.energy_norm[1] >= coarse.energy_norm[0], "{fine:?} after {coarse:?}");
            coarse = fine;
        }
        Ok(())
    });
}

//! The forces and openings of a pair, in the plane and in space.

use fem_core::interface::{ContactFacet, ContactInterface, ContactProblem};
use fem_core::space::{Plane, Space};
use nndd::Iterate;

/// One pair with its forces and openings.
#[derive(Clone, Copy)]
pub struct PairForces<'a, S: Space = Plane> {
    pub(crate) problem: &'a ContactProblem<S>,
    /// The number of the pair.
    pub(crate) pair: usize,
    pub(crate) interface: &'a ContactInterface<S>,
    /// `r²_i`, N/m.
    pub(crate) force: &'a [f64],
    /// Of the iteration, m.
    pub(crate) opening: &'a [f64],
    /// Friction forces, N/m, and slips, m, in the rows along tangents; empty without friction.
    pub(crate) friction: &'a [f64],
    pub(crate) slip: &'a [f64],
    /// The nodes of the first body, m.
    pub(crate) points: &'a [S::Vector],
}

/// Lists the forces and openings of all pairs.
pub(crate) fn pair_forces<'a, S: Space>(
    problem: &'a ContactProblem<S>,
    iterate: &'a Iterate,
) -> impl Iterator<Item = PairForces<'a, S>> {
    let blocks = problem.blocks().zip(problem.tangential_blocks());
    problem.contacts.iter().zip(blocks).enumerate().map(|(pair, (of, (block, tangents)))| PairForces {
        problem,
        pair,
        interface: &of.interface,
        force: &iterate.contact.normal_reaction[block.clone()],
        opening: &iterate.opening[block],
        friction: &iterate.tangential.force[tangents.clone()],
        slip: &iterate.tangential.slip[tangents],
        points: problem.bodies[of.body].mesh().points(),
    })
}

impl<'a, S: Space> PairForces<'a, S> {
    /// Returns the pressure `|n_i| r²_i/ℓ_i` at each pair, Pa.
    pub(crate) fn pressures(&self) -> impl Iterator<Item = f64> + '_ {
        self.pressed().zip(self.interface.pairs()).map(|(r, pair)| r / pair.weight)
    }

    /// Returns the sizes `|n_i| r²_i` of the normal forces, N/m.
    pub(crate) fn pressed(&self) -> impl Iterator<Item = f64> + '_ {
        self.interface.pairs().iter().zip(self.force).map(|(pair, r)| r * pair.normal_length())
    }

    /// Returns distances along the normals and tangents, from numbers over their lengths, m.
    pub(crate) fn distances(&self, by_pair: &'a [f64]) -> impl Iterator<Item = f64> + '_ {
        self.interface.pairs().iter().zip(by_pair).map(|(pair, o)| o / pair.normal_length())
    }

    /// Returns the force of pair `k` on the first body, N/m.
    pub(crate) fn on_first(&self, k: usize) -> S::Vector {
        let normal = self.interface.pairs()[k].normal;
        let pressed = normal * -self.force[k];
        if self.friction.is_empty() { pressed } else { pressed - self.friction_force(k) }
    }

    /// Returns the friction force of pair `k` on the second body, N/m.
    pub(crate) fn friction_force(&self, k: usize) -> S::Vector {
        self.problem.contacts[self.pair].along_tangents(k, self.friction)
    }

    /// Returns the size of the slip of pair `k`, m.
    pub(crate) fn slip_size(&self, k: usize) -> f64 {
        let parts = self.slip[k..].iter().step_by(self.interface.pairs().len());
        parts.map(|w| w * w).sum::<f64>().sqrt() / self.interface.pairs()[k].normal_length()
    }

    /// Tells whether pair `k` carries a force.
    pub(crate) fn is_pressed(&self, k: usize) -> bool {
        self.force[k] > 0.0
    }
}

/// Computes the mean pressure of a facet, Pa.
///
/// * `pressures`: at the pairs, Pa.
pub(crate) fn mean<S: Space>(
    interface: &ContactInterface<S>,
    pressures: &[f64],
    facet: &ContactFacet<S>,
) -> f64 {
    interface.corners(facet, pressures).as_ref().iter().sum::<f64>() / S::DIM as f64
}

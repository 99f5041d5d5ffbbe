//! One factorisation per body serves every step: the body condensed on its interface normals.
//!
//! With the interface last,
//! ```math
//! K = L Lᵀ,   L = [L_II, 0; L_CI, L_CC],   S = L_CC L_CCᵀ,   g̃ = L_CC (L⁻¹ f)_C     (13)
//! ```
//! is the Steklov-Poincaré operator with its load. [`InterfaceOperator::reaction`] gives the
//! reaction `r = S v − g̃` to an imposed normal trace `v`, [`InterfaceOperator::trace_from_force`] the trace `w = S⁻¹ r` of a
//! correction, and both fields are recovered on demand.

mod operator;
mod refinement;

pub use operator::InterfaceOperator;
pub use refinement::InterfaceLoad;

use crate::assembly::System;
use crate::cholesky::{Cholesky, CholeskyError};
use crate::dof::{DofMap, IMPOSED};
use crate::geometry::{Coordinates, Point};
use crate::memory::fits_in_memory;
use crate::mesh::id::NodeId;
use crate::space::{Plane, Space};
use std::sync::Arc;
use thiserror::Error;

/// A pivot below this fraction of its diagonal entry has lost all its digits.
const PIVOT_FLOOR: f64 = 64.0 * f64::EPSILON;

/// Why a body could not be factorised.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CondensationError {
    /// The factorisation failed.
    #[error("{source}, at the node {point}")]
    Cholesky {
        /// Position of the node of the failing pivot.
        point: Point,
        /// The cause.
        source: CholeskyError,
    },
    /// The dense matrices of the interface do not fit in memory.
    #[error("the dense matrices of {pairs} contact nodes do not fit in memory")]
    OutOfMemory {
        /// Unknowns on the interface.
        pairs: usize,
    },
    /// A pivot is so small relative to its diagonal entry that the solution would be noise.
    #[error(
        "the body is almost unconstrained or almost incompressible near {point}: the stiffness is singular to working \
         precision (pivot ratio {ratio:.1e})"
    )]
    NearlySingular {
        /// Position of the node of the smallest pivot.
        point: Point,
        /// Pivot over diagonal entry.
        ratio: f64,
    },
}

/// A body factorised once and condensed on its interface.
///
/// Traces and forces are along the pairs' normals and in the order of the pairs.
#[derive(Clone, Debug)]
pub struct CondensedBody<S: Space = Plane> {
    dofs: DofMap<S>,
    factor: Arc<Cholesky>,
    /// `L⁻¹ f`: the forward half of every solve, done once.
    forward_load: Vec<f64>,
    interface: InterfaceOperator,
}

impl<S: Space> CondensedBody<S> {
    /// Factorises an assembled body.
    ///
    /// * `points`: the nodes of the body, to report where a factorisation failed.
    ///
    /// # Errors
    /// A stiffness that is not positive definite, or only to round-off.
    pub fn factorise(system: System<S>, points: &[S::Vector]) -> Result<Self, CondensationError> {
        let System { dofs, stiffness, load } = system;
        let place =
            |unknown: usize| Point::from(points.get(dofs.unknown(unknown).0).copied().unwrap_or_default());
        let factor = Cholesky::new(&stiffness, dofs.fronts()).map_err(|source| {
            let pivot = match source {
                CholeskyError::NotPositiveDefinite { pivot, .. } => pivot,
                _ => 0,
            };
            CondensationError::Cholesky { point: place(pivot), source }
        })?;
        let (pivot, ratio) = factor.smallest_pivot();
        if !(ratio > PIVOT_FLOOR) {
            return Err(CondensationError::NearlySingular { point: place(pivot), ratio });
        }
        let (n_c, factor) = (dofs.interface_len(), Arc::new(factor));
        if !fits_in_memory((2 * size_of::<f64>()).saturating_mul(n_c).saturating_mul(n_c)) {
            return Err(CondensationError::OutOfMemory { pairs: n_c });
        }
        let interface = InterfaceOperator::new(factor.clone(), n_c);
        Ok(Self { dofs, factor, forward_load: Vec::new(), interface }.under(load))
    }

    /// Replaces what supports impose and what the body carries; its stiffness is the same. No factorisation.
    ///
    /// * `system`: in the same unknowns, see [`DofMap::with_imposed`].
    ///
    /// # Panics
    /// If the system has other unknowns.
    pub(crate) fn with_loads(self, system: System<S>) -> Self {
        let System { dofs, load, .. } = system;
        let (found, expected) = (dofs.len(), self.dofs.len());
        assert!(found == expected, "a load of {found} unknowns, and a factor of {expected}");
        Self { dofs, ..self }.under(load)
    }

    /// Condenses a load.
    fn under(mut self, load: Vec<f64>) -> Self {
        self.forward_load = load;
        self.factor.forward(&mut self.forward_load);
        let n_c = self.dofs.interface_len();
        self.interface.take_load(&self.forward_load[self.dofs.len() - n_c..]);
        self
    }

    /// Returns its operator on the interface.
    pub fn interface(&self) -> &InterfaceOperator {
        &self.interface
    }

    /// Returns the unknowns of the body.
    pub fn dofs(&self) -> &DofMap<S> {
        &self.dofs
    }

    /// Returns the number of values the factor stores.
    pub fn stored_values(&self) -> usize {
        self.factor.stored_values()
    }

    /// Recovers the displacement (Cartesian, m) with an imposed normal trace `v` and the body's loads: the
    /// back-substitution that the condensed steps omit.
    ///
    /// # Panics
    /// If `v` has not `n_c` entries.
    pub fn displacement_from_trace(&self, v: &[f64]) -> Vec<S::Vector> {
        self.recovered(self.forward_load.clone(), v, true)
    }

    /// Computes the displacement (Cartesian, m) under the body's loads and the normal forces `r` (N/m) on
    /// a free interface: the Neumann problem.
    ///
    /// # Panics
    /// If `r` has not `n_c` entries.
    pub fn displacement_from_force(&self, r: &[f64]) -> Vec<S::Vector> {
        self.interface.check("the force", r);
        let mut x = self.forward_load.clone();
        let start = x.len() - self.interface.len();
        let mut y = r.to_vec();
        self.interface.forward(&mut y);
        for (x, y) in x[start..].iter_mut().zip(&y) {
            *x += y;
        }
        self.factor.backward(&mut x, 0);
        self.dofs.displacement(&x)
    }

    /// Computes the displacement (Cartesian, m) under the body's loads and further nodal forces: the Neumann problem with
    /// forces in any direction.
    ///
    /// * `forces`: node and Cartesian force, N/m; reversing the normals does not change them.
    pub fn displacement_from_nodal_forces(&self, forces: &[(NodeId, S::Vector)]) -> Vec<S::Vector> {
        let mut x = vec![0.0; self.forward_load.len()];
        for &(node, force) in forces {
            for c in 0..S::DIM {
                let number = self.dofs.number(node.index(), c);
                if number != IMPOSED {
                    x[number as usize] += force.times(&self.dofs.axis(node.index(), c));
                }
            }
            for (unknown, per_unit) in self.dofs.followed(node.index()) {
                x[unknown] += force.times(&per_unit);
            }
        }
        self.factor.forward(&mut x);
        for (x, f) in x.iter_mut().zip(&self.forward_load) {
            *x += f;
        }
        self.factor.backward(&mut x, 0);
        self.dofs.displacement(&x)
    }

    /// Computes `L⁻¹ f`, the forward half of a solve.
    ///
    /// * `forces`: along the unknowns, N/m; `loads`: whether the body's own are added.
    ///
    /// # Panics
    /// If there is not one force per unknown.
    pub fn forward(&self, mut forces: Vec<f64>, loads: bool) -> Vec<f64> {
        let (found, expected) = (forces.len(), self.dofs.len());
        assert!(found == expected, "{found} forces on {expected} unknowns");
        self.factor.forward(&mut forces);
        if loads {
            forces.iter_mut().zip(&self.forward_load).for_each(|(y, f)| *y += f);
        }
        forces
    }

    /// Returns the condensed load of a forward half, `g̃`, N/m.
    ///
    /// # Panics
    /// If there is not one number per unknown.
    pub fn condensed_part(&self, forward: &[f64]) -> Vec<f64> {
        self.interface.condensed(&forward[self.dofs.len() - self.interface.len()..])
    }

    /// Recovers a displacement (Cartesian, m) from the forward half of its solve and its interface unknowns.
    ///
    /// * `imposed`: whether what supports impose is part of it.
    ///
    /// # Panics
    /// If there is not one number per unknown, or not one trace per interface unknown.
    pub fn recovered(&self, mut forward: Vec<f64>, traces: &[f64], imposed: bool) -> Vec<S::Vector> {
        self.interface.check("the trace", traces);
        let start = forward.len() - traces.len();
        forward[start..].copy_from_slice(traces);
        self.factor.backward(&mut forward, traces.len());
        if imposed { self.dofs.displacement(&forward) } else { self.dofs.correction(&forward) }
    }

    /// Returns the factor, for solves with other right-hand sides.
    pub fn factor(&self) -> &Cholesky {
        &self.factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use crate::boundary::BoundaryConditions;
    use crate::geometry::Vector;
    use crate::interface::{InterfaceSide, Retained};
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::block;

    pub(super) fn condensed() -> (CondensedBody, System) {
        let material = LinearElastic::isotropic(10.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let conditions = BoundaryConditions::new().fix("bottom").body_force([0.1, -0.3]);
        let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [6, 4]).unwrap(), material, &conditions).unwrap();
        let top = |node: &NodeId| lower.mesh().points()[*node][1] == 1.0;
        let nodes = (0..lower.mesh().points().len()).map(NodeId::new).filter(top);
        let along = nodes.map(|node| Retained { node, direction: Vector::new(0.0, 1.0) });
        let system = System::assemble(&lower, &InterfaceSide::default().with_block(along)).unwrap();
        (CondensedBody::factorise(system.clone(), lower.mesh().points()).unwrap(), system)
    }

    #[test]
    fn recovered_fields_satisfy_the_full_system() {
        let (body, system) = condensed();
        let n_c = body.interface().len();
        let v: Vec<f64> = (0..n_c).map(|i| 0.01 * (i as f64).cos()).collect();
        let mut r = vec![0.0; n_c];
        body.interface().reaction(&v, &mut r);
        let u = body.displacement_from_trace(&v);
        let x: Vec<f64> = (0..system.dofs.len())
            .map(|j| {
                let (node, c) = system.dofs.unknown(j);
                u[node].dot(&system.dofs.axis(node, c))
            })
            .collect();
        let residual = system.stiffness.multiply(&x);
        let start = x.len() - n_c;
        for j in 0..x.len() {
            let expected = if j < start { 0.0 } else { r[j - start] };
            assert!((residual[j] - system.load[j] - expected).abs() < 1e-13);
        }
        // The reaction, applied as a force, gives the same displacement.
        for (a, b) in body.displacement_from_force(&r).iter().zip(&u) {
            assert!((a[0] - b[0]).abs() < 1e-14 && (a[1] - b[1]).abs() < 1e-14);
        }
        // So it does as forces on the nodes.
        let nodes = (start..x.len()).map(|j| {
            let (node, c) = system.dofs.unknown(j);
            (NodeId::new(node), r[j - start] * system.dofs.axis(node, c))
        });
        for (a, b) in body.displacement_from_nodal_forces(&nodes.collect::<Vec<_>>()).iter().zip(&u) {
            assert!((a[0] - b[0]).abs() < 1e-13 && (a[1] - b[1]).abs() < 1e-13);
        }
        for (k, entry) in body.interface().diagonal().iter().enumerate() {
            assert!((entry - body.interface().schur()[k * (n_c + 1)]).abs() < 1e-13);
        }
        let mut w = vec![0.0; n_c];
        let mut back = vec![0.0; n_c];
        body.interface().trace_from_force(&r, &mut w);
        body.interface().apply_schur(&w, &mut back);
        for (a, b) in back.iter().zip(&r) {
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    #[should_panic(expected = "the trace has 6 entries, the interface 7 unknowns")]
    fn a_trace_that_is_too_short_is_refused() {
        condensed().0.displacement_from_trace(&[0.0; 6]);
    }

    #[test]
    fn a_body_may_have_several_sides_and_a_node_several_directions() {
        let material = LinearElastic::isotropic(10.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        // The top right corner is on a roller, the bottom right one is clamped.
        let right = crate::boundary::FacetSelection::group("right");
        let low = right.clone().within([[f64::NEG_INFINITY, f64::INFINITY], [-0.1, 0.3]]);
        let held = BoundaryConditions::new()
            .fix("left")
            .displace(right, Some(0.02.into()), None)
            .displace(low, Some(0.02.into()), Some(0.01.into()))
            .body_force([0.1, -0.3]);
        let body = Body::new(block([0.0, 0.0], [2.0, 1.0], [6, 4]).unwrap(), material, &held).unwrap();
        let mesh = body.mesh();
        let nodes = |group: &str| {
            let edges = mesh.group(group).unwrap().iter();
            let mut nodes: Vec<NodeId> = edges.flat_map(|e| mesh.topology().facets()[*e]).collect();
            nodes.sort_unstable();
            nodes.dedup();
            // The left end is clamped.
            nodes.retain(|n| mesh.points()[*n][0] > 0.1);
            nodes
        };
        let along = |nodes: &[NodeId], direction: Vector| -> Vec<Retained> {
            nodes.iter().map(|node| Retained { node: *node, direction }).collect()
        };
        let (top, bottom) = (nodes("top"), nodes("bottom"));
        let (one, other) = (Vector::new(0.6, 0.8), Vector::new(-0.28, 0.96));
        let side = InterfaceSide::default()
            .with_block(along(&top, Vector::new(0.0, 1.0)))
            .with_block(along(&bottom, Vector::new(0.0, -1.0)))
            // A second direction at some nodes, and the first one again, reversed.
            .with_block([along(&top[2..], one), along(&bottom[1..3], Vector::new(0.0, 1.0))].concat())
            .with_block(along(&top[1..4], other));
        let system = System::assemble(&body, &side).unwrap();
        let condensed = CondensedBody::factorise(system, mesh.points()).unwrap();
        let dofs = condensed.dofs();
        // Top: 6 nodes, of which 4 have a second unknown; its last is on the roller and has one. Bottom: 5 free nodes.
        assert_eq!(dofs.interface_len(), 6 + 4 + 5);
        let random = |k: usize| 0.01 * (7.3 * k as f64).sin();
        let v: Vec<f64> = (0..dofs.interface_len()).map(random).collect();
        let u = condensed.displacement_from_trace(&v);
        let expected = |r: &Retained| u[r.node].dot(&r.direction);
        for (block, traces) in dofs.traces(&v).iter().enumerate() {
            for (r, trace) in side.retained()[side.block(block)].iter().zip(traces) {
                assert!((expected(r) - trace).abs() < 1e-15, "block {block}, node {}", r.node);
            }
        }
        // Forces along the rows are the same forces on the nodes, except where supports take them.
        let forces: Vec<Vec<f64>> =
            (0..side.blocks()).map(|b| side.block(b).map(|k| 10.0 * random(k + 5)).collect()).collect();
        let on_nodes = side.retained().iter().zip(forces.iter().flatten());
        let on_nodes: Vec<(NodeId, Vector)> = on_nodes.map(|(r, f)| (r.node, *f * r.direction)).collect();
        let found = condensed.displacement_from_force(&dofs.interface_forces(&forces));
        for (a, b) in found.iter().zip(condensed.displacement_from_nodal_forces(&on_nodes)) {
            assert!((a[0] - b[0]).abs() < 1e-13 && (a[1] - b[1]).abs() < 1e-13);
        }
    }
}

//! Residuals of a condensed body in the energy norm, and what removes them.

use super::CondensedBody;
use crate::body::Body;
use crate::double_double::{DoubleDouble, PreciseVector};
use crate::geometry::Coordinates;
use crate::mesh::id::NodeId;
use crate::residual::{self, SplitField};
use crate::space::Space;

/// A load on the interface: `g̃` and `L_CC⁻¹ g̃`, N/m.
#[derive(Clone, Debug)]
pub struct InterfaceLoad {
    condensed: Vec<f64>,
    forward: Vec<f64>,
}

impl<S: Space> CondensedBody<S> {
    /// Computes `Rᵀ K⁻¹ R`, J/m, of some residuals by one forward solve, which reads the factor once: the energy of the displacement under
    /// these forces, in two parts. The first one is the energy with fixed interface normals, the second the contribution of
    /// the interface.
    ///
    /// * `residuals`: along the unknowns, see [`Self::along_unknowns`], N/m.
    ///
    /// # Panics
    /// If a residual has not one entry per unknown.
    pub fn residual_energies(&self, mut residuals: Vec<Vec<f64>>) -> Vec<[f64; 2]> {
        let (unknowns, lengths) = (self.dofs.len(), residuals.iter().map(Vec::len));
        lengths.for_each(|found| {
            assert!(found == unknowns, "a residual of {found} entries on {unknowns} unknowns")
        });
        let mut columns: Vec<&mut [f64]> = residuals.iter_mut().map(Vec::as_mut_slice).collect();
        self.factor.forward_all(&mut columns);
        let energies = |y: Vec<f64>| {
            let (interior, interface) = y.split_at(y.len() - self.interface.len());
            [interior, interface].map(|y| y.iter().map(|y| y * y).sum())
        };
        residuals.into_iter().map(energies).collect()
    }

    /// [`Self::along_unknowns`] of forces in double precision.
    pub fn rough_along_unknowns(&self, residual: &[S::Vector]) -> Vec<f64> {
        let along = |j: usize| {
            if self.dofs.is_rigid(j) {
                return self.dofs.moved(j).map(|(node, per_unit)| residual[node].times(&per_unit)).sum();
            }
            let (node, c) = self.dofs.unknown(j);
            residual[node].times(&self.dofs.axis(node, c))
        };
        (0..self.dofs.len()).map(along).collect()
    }

    /// Corrects a displacement by the residual of its equilibrium until the residual stops falling: iterative
    /// refinement (Higham 2002, chapter 12), with the residual in double-double numbers.
    ///
    /// * `loads`: nodal forces in addition to the body's own, Cartesian, N/m.
    /// * `field`: on entry an approximation. With `held` its normal traces on the interface do not change.
    ///
    /// Returns the remaining `√(Rᵀ K⁻¹ R)`, square root of J/m.
    pub fn refine(
        &self,
        body: &Body<S>,
        loads: &[(NodeId, S::Vector)],
        held: bool,
        field: &mut SplitField<S>,
    ) -> f64 {
        let given = if held { self.interface.len() } else { 0 };
        let forward = |residual: &[PreciseVector<S>]| {
            let mut x = self.along_unknowns(residual);
            self.factor.forward(&mut x);
            let end = x.len() - given;
            let squared: f64 = x[..end].iter().map(|y| y * y).sum();
            x[end..].fill(0.0);
            (squared.sqrt(), x)
        };
        residual::refine(body, loads, field, forward, |mut x| {
            self.factor.backward(&mut x, given);
            x.iter_mut().for_each(|x| *x = -*x);
            self.dofs.correction(&x)
        })
    }

    /// Computes the displacement (Cartesian, m) that an increment of the normal trace adds: no loads, nothing imposed
    /// elsewhere.
    ///
    /// # Panics
    /// If `increment` has not `n_c` entries.
    pub fn correction_from_trace(&self, increment: &[f64]) -> Vec<S::Vector> {
        self.recovered(vec![0.0; self.dofs.len()], increment, false)
    }

    /// Extracts the normal forces from a residual `K u − f`, in the order of the pairs, N/m.
    pub fn interface_forces(&self, residual: &[PreciseVector<S>]) -> Vec<f64> {
        let start = self.dofs.len() - self.interface.len();
        (start..self.dofs.len()).map(|j| self.along_unknown(residual, j)).collect()
    }

    /// Replaces `g̃` by another one, N/m, and returns the old load for [`Self::restore_load`]: an operator about another state. Traces
    /// are those under the new load; displacements inside are not.
    ///
    /// # Panics
    /// If `load` has not `n_c` entries.
    pub fn replace_condensed_load(&mut self, load: Vec<f64>) -> InterfaceLoad {
        self.interface.check("the load", &load);
        let mut forward = load.clone();
        self.interface.forward(&mut forward);
        self.swap_load(InterfaceLoad { condensed: load, forward })
    }

    /// Returns to an earlier load.
    ///
    /// # Panics
    /// If it is the load of a body with another interface.
    pub fn restore_load(&mut self, load: InterfaceLoad) {
        self.interface.check("the load", &load.condensed);
        self.swap_load(load);
    }

    fn swap_load(&mut self, InterfaceLoad { condensed, mut forward }: InterfaceLoad) -> InterfaceLoad {
        let start = self.forward_load.len() - forward.len();
        self.forward_load[start..].swap_with_slice(&mut forward);
        InterfaceLoad { condensed: self.interface.replace_load(condensed), forward }
    }

    /// Computes the parts of nodal forces along the unknowns, N/m.
    ///
    /// * `residual`: by node, Cartesian, N/m.
    pub fn along_unknowns(&self, residual: &[PreciseVector<S>]) -> Vec<f64> {
        (0..self.dofs.len()).map(|j| self.along_unknown(residual, j)).collect()
    }

    fn along_unknown(&self, residual: &[PreciseVector<S>], j: usize) -> f64 {
        let product = |r: &PreciseVector<S>, axis: &S::Vector| {
            (1..S::DIM).fold(r[0] * axis[0], |sum, c| sum + r[c] * axis[c])
        };
        if self.dofs.is_rigid(j) {
            let mut sum = DoubleDouble::ZERO;
            for (node, per_unit) in self.dofs.moved(j) {
                sum += product(&residual[node], &per_unit);
            }
            return sum.rounded();
        }
        let (node, c) = self.dofs.unknown(j);
        let (r, axis) = (residual[node], self.dofs.axis(node, c));
        if self.dofs.is_cartesian(node) {
            return r[c].rounded();
        }
        product(&r, &axis).rounded()
    }
}

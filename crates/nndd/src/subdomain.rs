//! A body in the rows of its pairs: traces along its outward normals, forces that press on it.

use crate::error::NnddError;
use crate::motions::Motions;
use crate::row_operators::RowOperators;
use fem_core::contact_system::{BodyRow, ContactSystem};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// Who carries λ in a row of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LambdaOwner {
    /// The body.
    Itself,
    /// Another body.
    Other,
    /// An obstacle.
    Obstacle,
}

/// A body with `n` independent rows. With `S_s` of the body on its springs, which it has if it floats (see
/// [`fem_core::assembly::System::stabilised`]), the body alone has `S = S_s − S_s Q (Qᵀ S_s Q)⁻¹ Qᵀ S_s`.
pub(crate) struct Subdomain<'a> {
    /// Numbers of its rows among those of the assembly.
    pub(crate) rows: Vec<usize>,
    /// Who carries λ, by row.
    pub(crate) carriers: Vec<LambdaOwner>,
    /// Its rows in which another body or an obstacle carries λ, in their order.
    pub(crate) unilateral: Vec<usize>,
    /// Traces under the loads without contact forces, `B K⁺ f` and what supports impose, m.
    pub(crate) free: DVector<f64>,
    /// What supports impose of the traces, m.
    imposed: DVector<f64>,
    /// The condensed load `g̃ = S_s B K⁺ f`, which presses as contact forces do, N/m.
    load: DVector<f64>,
    /// `S` in the unilateral rows, column-major, N/m²; `None` if the body or an obstacle that it touches may move rigidly.
    pub(crate) held_stiffness: Option<Cow<'a, [f64]>>,
    /// The rigid motions of the body; none if it is held.
    pub(crate) rigid: Motions,
    /// The rigid motions that its forces balance: also those of the obstacles that it touches.
    pub(crate) balanced: Motions,
    operators: RowOperators<'a>,
    /// `S_s Q`, n × r.
    moved: DMatrix<f64>,
    /// `(Qᵀ S_s Q)⁻¹`, r × r.
    inverse: DMatrix<f64>,
}

impl<'a> Subdomain<'a> {
    /// Takes a body of an assembly.
    ///
    /// # Errors
    /// [`NnddError::DependentRows`].
    pub(crate) fn new(system: &ContactSystem<'a>, body: usize) -> Result<Self, NnddError> {
        let dependent = || NnddError::DependentRows { body };
        let (condensed, of_body) = (system.bodies[body], &system.of_body[body]);
        let operators = RowOperators::new(condensed, of_body).ok_or_else(dependent)?;
        let n = of_body.len();
        let mut free = vec![0.0; condensed.len()];
        condensed.trace_from_force(condensed.condensed_load(), &mut free);
        let imposed = DVector::from_iterator(n, of_body.iter().map(|row| row.imposed));
        let free = DVector::from_iterator(n, of_body.iter().map(|row| row.of(&free))) + &imposed;
        let rigid = Motions::new(system, body, false);
        let columns = rigid.basis.column_iter().map(|q| operators.stiffness(&q.into_owned()));
        let columns: Vec<DVector<f64>> = columns.collect();
        let moved = DMatrix::from_fn(n, columns.len(), |i, k| columns[k][i]);
        let inverse = rigid.basis.tr_mul(&moved).try_inverse().ok_or_else(dependent)?;
        let carrier = |row: &BodyRow| {
            let pair = &system.rows.pairs[system.rows.rows[row.row].pair];
            match pair.roles.imposed() == row.side {
                _ if pair.partner.is_obstacle() => LambdaOwner::Obstacle,
                true => LambdaOwner::Itself,
                false => LambdaOwner::Other,
            }
        };
        let carriers: Vec<LambdaOwner> = of_body.iter().map(carrier).collect();
        let unilateral: Vec<usize> = (0..n).filter(|i| carriers[*i] != LambdaOwner::Itself).collect();
        let balanced = Motions::new(system, body, true);
        let held_stiffness = balanced.is_empty().then(|| operators.stiffness_matrix(&unilateral));
        Ok(Self {
            rows: of_body.iter().map(|row| row.row).collect(),
            carriers,
            unilateral,
            free,
            imposed,
            load: operators.load(),
            held_stiffness,
            rigid,
            balanced,
            operators,
            moved,
            inverse,
        })
    }

    /// Returns the number of rows.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Tells whether the body has rigid motions with a trace.
    pub(crate) fn floats(&self) -> bool {
        self.rigid.basis.ncols() > 0
    }

    /// Returns `σ`, by row: the trace is `λ` in the rows where the body carries it, and at most `g − λ` if another body does. 0
    /// against an obstacle, whose λ is not updated.
    pub(crate) fn signs(&self) -> DVector<f64> {
        let sign = |carrier: &LambdaOwner| match carrier {
            LambdaOwner::Itself => 1.0,
            LambdaOwner::Other => -1.0,
            LambdaOwner::Obstacle => 0.0,
        };
        DVector::from_iterator(self.len(), self.carriers.iter().map(sign))
    }

    /// Takes the body's part of one value per row of the assembly.
    pub(crate) fn gather(&self, all: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.len(), self.rows.iter().map(|row| all[*row]))
    }

    /// Adds values of the body's rows to those of the assembly.
    pub(crate) fn scatter(&self, values: &DVector<f64>, all: &mut [f64]) {
        self.rows.iter().zip(values).for_each(|(row, value)| all[*row] += value);
    }

    /// Computes `S v`, N/m.
    pub(crate) fn stiffness(&self, v: &DVector<f64>) -> DVector<f64> {
        let forces = self.operators.stiffness(v);
        let held = &self.inverse * self.rigid.basis.tr_mul(&forces);
        forces - &self.moved * held
    }

    /// Computes the diagonal of `S`, N/m².
    pub(crate) fn diagonal(&self) -> DVector<f64> {
        let springs = (&self.moved * &self.inverse).component_mul(&self.moved);
        self.operators.diagonal() - springs.column_sum()
    }

    /// Computes the traces under forces, `Φ P` with `Φ = B K⁺ Bᵀ`, m; if the body floats, for forces in balance.
    pub(crate) fn flexibility(&self, force: &DVector<f64>) -> DVector<f64> {
        self.operators.flexibility(force)
    }

    /// Computes `Φ`, column-major, m²/N.
    pub(crate) fn flexibility_matrix(&self) -> Vec<f64> {
        self.operators.flexibility_matrix()
    }

    /// Computes the forces that press on the body if its traces are given, `P = g̃ + S_s (Q a − v)` in balance, N/m, and the
    /// coefficients `a` of its rigid motions.
    pub(crate) fn forces_of_traces(&self, v: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let forces = &self.load - self.operators.stiffness(&(v - &self.imposed));
        let loads = DVector::from_column_slice(self.rigid.loads());
        let motion = &self.inverse * (loads - self.rigid.basis.tr_mul(&forces));
        (forces + &self.moved * &motion, motion)
    }
}

//! A body in the rows of its pairs: traces along its outward normals, forces that press on it.

use super::motions::Motions;
use super::sprung::Sprung;
use crate::error::NnddError;
use crate::rows::Rows;
use fem_core::prepared::PreparedProblem;
use nalgebra::{DMatrix, DVector};
use std::iter::repeat_n;

/// Who carries λ in a row of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Carrier {
    /// The body.
    Itself,
    /// Another body.
    Other,
    /// An obstacle.
    Obstacle,
}

/// A body with `n` independent rows. With `S_s` of the body on its springs, which it has if it floats (see
/// [`fem_core::assembly::System::with_springs`]), the body alone has `S = S_s − S_s Q (Qᵀ S_s Q)⁻¹ Qᵀ S_s`.
pub(super) struct Subdomain<'a> {
    /// Numbers of its rows among those of the assembly.
    pub(super) rows: Vec<usize>,
    /// Who carries λ, by row.
    pub(super) carriers: Vec<Carrier>,
    /// Traces under the loads without contact forces, `B K⁺ f` and what supports impose, m.
    pub(super) free: DVector<f64>,
    /// The rigid motions of the body; none if it is held.
    pub(super) rigid: Motions,
    /// The rigid motions that its forces balance: also those of the obstacles that it touches.
    pub(super) balanced: Motions,
    operators: Sprung<'a>,
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
    pub(super) fn new(problem: &'a PreparedProblem, rows: &Rows, body: usize) -> Result<Self, NnddError> {
        let dependent = || NnddError::DependentRows { body };
        let condensed = &problem.bodies()[body];
        let of_body = rows.of_body(problem, body);
        let operators = Sprung::new(condensed, &of_body).ok_or_else(dependent)?;
        let n = of_body.len();
        let mut free = vec![0.0; condensed.len()];
        condensed.trace_from_force(condensed.condensed_load(), &mut free);
        let free = DVector::from_iterator(n, of_body.iter().map(|row| row.of(&free) + row.imposed));
        let rigid = Motions::new(problem, body, false);
        let columns = rigid.basis.column_iter().map(|q| operators.stiffness(&q.into_owned()));
        let columns: Vec<DVector<f64>> = columns.collect();
        let moved = DMatrix::from_fn(n, columns.len(), |i, k| columns[k][i]);
        let inverse = rigid.basis.tr_mul(&moved).try_inverse().ok_or_else(dependent)?;
        let carriers = problem.problem().sides_of(body).flat_map(|(k, side)| {
            let pair = &problem.problem().contacts[k];
            let carrier = if problem.problem().obstacle_of(pair).is_some() {
                Carrier::Obstacle
            } else if pair.roles.imposed() == side {
                Carrier::Itself
            } else {
                Carrier::Other
            };
            repeat_n(carrier, pair.row_count())
        });
        Ok(Self {
            rows: of_body.iter().map(|row| row.row).collect(),
            carriers: carriers.collect(),
            free,
            rigid,
            balanced: Motions::new(problem, body, true),
            operators,
            moved,
            inverse,
        })
    }

    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Tells whether the body has rigid motions with a trace.
    pub(super) fn floats(&self) -> bool {
        self.rigid.basis.ncols() > 0
    }

    /// Returns `σ`, by row: the trace is `λ` in the rows where the body carries it, and at most `g − λ` if another body does. 0
    /// against an obstacle, whose λ is not updated.
    pub(super) fn signs(&self) -> DVector<f64> {
        let sign = |carrier: &Carrier| match carrier {
            Carrier::Itself => 1.0,
            Carrier::Other => -1.0,
            Carrier::Obstacle => 0.0,
        };
        DVector::from_iterator(self.len(), self.carriers.iter().map(sign))
    }

    /// Takes the body's part of one value per row of the assembly.
    pub(super) fn gather(&self, all: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.len(), self.rows.iter().map(|row| all[*row]))
    }

    /// Adds values of the body's rows to those of the assembly.
    pub(super) fn scatter(&self, values: &DVector<f64>, all: &mut [f64]) {
        self.rows.iter().zip(values).for_each(|(row, value)| all[*row] += value);
    }

    /// Computes `S v`, N/m.
    pub(super) fn stiffness(&self, v: &DVector<f64>) -> DVector<f64> {
        let forces = self.operators.stiffness(v);
        let held = &self.inverse * self.rigid.basis.tr_mul(&forces);
        forces - &self.moved * held
    }

    /// Computes the diagonal of `S`, N/m².
    pub(super) fn diagonal(&self) -> DVector<f64> {
        let springs = (&self.moved * &self.inverse).component_mul(&self.moved);
        self.operators.diagonal() - springs.column_sum()
    }

    /// Computes the traces under forces, `Φ P` with `Φ = B K⁺ Bᵀ`, m; if the body floats, for forces in balance.
    pub(super) fn flexibility(&self, force: &DVector<f64>) -> DVector<f64> {
        self.operators.flexibility(force)
    }

    /// Computes `Φ`, column-major, m²/N.
    pub(super) fn flexibility_matrix(&self) -> Vec<f64> {
        self.operators.flexibility_matrix()
    }

    /// Computes the forces that press on the body if its traces are given, `P = S_s (B K⁺ f + Q a − v)` in balance, N/m, and the
    /// coefficients `a` of its rigid motions.
    pub(super) fn forces_of_traces(&self, v: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let forces = self.operators.stiffness(&(&self.free - v));
        let loads = DVector::from_column_slice(self.rigid.loads());
        let motion = &self.inverse * (loads - self.rigid.basis.tr_mul(&forces));
        (forces + &self.moved * &motion, motion)
    }
}

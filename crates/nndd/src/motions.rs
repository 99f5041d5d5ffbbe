//! Rigid motions as the rows of one body see them.

use crate::rows::sign;
use contact_qp::IndependentRows;
use fem_core::prepared::PreparedProblem;
use nalgebra::DMatrix;

/// Some rigid motions in the rows of a body.
pub(crate) struct Motions {
    /// Their numbers among [`PreparedProblem::rigid_motions`].
    numbers: Vec<usize>,
    /// An orthonormal basis `Q` of their traces, with the forces `Qᵀ P` that balance the loads.
    rows: IndependentRows,
    /// `Q`, n × r.
    pub(crate) basis: DMatrix<f64>,
}

impl Motions {
    /// Takes the motions of a body and, if asked for, of the obstacles that it touches.
    pub(crate) fn new(problem: &PreparedProblem, body: usize, with_obstacles: bool) -> Self {
        let contact = problem.problem();
        let touches = |other: usize| {
            contact.sides_of(body).any(|(k, side)| contact.contacts[k].bodies[1 - side] == other)
        };
        let is_obstacle = |other: usize| other >= contact.bodies.len();
        let (mut numbers, mut matrix, mut loads) = (Vec::new(), Vec::new(), Vec::new());
        for (number, of) in problem.rigid_motions().iter().enumerate() {
            if of.body != body && !(with_obstacles && is_obstacle(of.body) && touches(of.body)) {
                continue;
            }
            let moved = problem.moved_by(of);
            for (k, _) in contact.sides_of(body) {
                let pair = &contact.contacts[k];
                match pair.side_of(of.body) {
                    None => matrix.extend(pair.rows().map(|_| 0.0)),
                    Some(side) => matrix.extend(
                        pair.rows().map(|row| sign(side) * moved[row.nodes[side]].dot(&row.direction)),
                    ),
                }
            }
            numbers.push(number);
            loads.push(of.load);
        }
        let rows = IndependentRows::new(&matrix, &loads);
        let count = contact.sides_of(body).map(|(k, _)| contact.contacts[k].row_count()).sum();
        let basis = DMatrix::from_column_slice(count, rows.right_side.len(), &rows.rows);
        Self { numbers, rows, basis }
    }

    /// Tells whether there are no motions, not even some without a trace.
    pub(crate) fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Returns `Qᵀ P` of all forces in balance, r entries, N/m.
    pub(crate) fn loads(&self) -> &[f64] {
        &self.rows.right_side
    }

    /// Computes the amounts of the motions, with their numbers, from the coefficients of the basis.
    pub(crate) fn amounts(&self, coefficients: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        self.numbers.iter().copied().zip(self.rows.expanded(coefficients))
    }
}

//! Rigid motions as the rows of one body see them.

use contact_qp::IndependentRows;
use fem_core::contact_system::{ContactSystem, Partner};
use nalgebra::DMatrix;
use std::collections::HashMap;

/// Some rigid motions in the rows of a body.
pub(crate) struct Motions {
    /// Their numbers among [`fem_core::contact_system::ContactRows::motions`].
    numbers: Vec<usize>,
    /// An orthonormal basis `Q` of their traces, with the forces `Qᵀ P` that balance the loads.
    rows: IndependentRows,
    /// `Q`, n × r.
    pub(crate) basis: DMatrix<f64>,
}

impl Motions {
    /// Takes the motions of a body and, if asked for, of the obstacles that it touches.
    pub(crate) fn new(system: &ContactSystem<'_>, body: usize, with_obstacles: bool) -> Self {
        let of_body = &system.of_body[body];
        let touches = |other: Partner| {
            of_body.iter().any(|row| system.rows.pairs[system.rows.rows[row.row].pair].partner == other)
        };
        let place: HashMap<usize, usize> = of_body.iter().enumerate().map(|(i, row)| (row.row, i)).collect();
        let (mut numbers, mut matrix, mut loads) = (Vec::new(), Vec::new(), Vec::new());
        for (number, of) in system.rows.motions.iter().enumerate() {
            let counts = match of.partner {
                Partner::Body(b) => b == body,
                Partner::Obstacle(_) => with_obstacles && touches(of.partner),
            };
            if !counts {
                continue;
            }
            let mut traces = vec![0.0; of_body.len()];
            for (row, trace) in &of.traces {
                if let Some(i) = place.get(row) {
                    traces[*i] = *trace;
                }
            }
            matrix.extend(traces);
            numbers.push(number);
            loads.push(of.load);
        }
        let rows = IndependentRows::new(&matrix, &loads);
        let basis = DMatrix::from_column_slice(of_body.len(), rows.right_side.len(), &rows.rows);
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

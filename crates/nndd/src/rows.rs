//! The rows of an assembly, pair after pair: one per pair of nodes along the normal, then, with friction, one along the tangent.

use fem_core::interface::{ContactPair, ContactProblem};
use fem_core::prepared::PreparedProblem;
use std::ops::Range;

/// The sign of a side in the rows: the normal points out of the first body. So a row is the trace of each body along its own
/// outward normal, and along the tangent that goes with it.
pub(crate) fn sign(side: usize) -> f64 {
    if side == 0 { 1.0 } else { -1.0 }
}

/// The rows of all pairs.
pub(crate) struct Rows {
    /// Where the rows of each pair begin, and its pairs of nodes.
    pairs: Vec<(usize, usize)>,
    /// The limit of the force in each row, N/m: infinite along normals, whose forces are not negative, and for the law of Coulomb, whose
    /// limit is not known.
    limits: Vec<f64>,
    tangential: Vec<bool>,
}

/// A row of one body: the trace `Σ a_k x_k + c` along its outward normal or the tangent, in its interface unknowns `x`.
pub(crate) struct BodyRow {
    /// Number of the row among those of the assembly.
    pub(crate) row: usize,
    /// Interface unknowns with their factors, none of which is 0.
    pub(crate) terms: Vec<(usize, f64)>,
    /// The constant, which supports impose, m.
    pub(crate) imposed: f64,
}

impl BodyRow {
    /// Computes the trace without the constant.
    pub(crate) fn of(&self, unknowns: &[f64]) -> f64 {
        self.terms.iter().map(|(k, a)| a * unknowns[*k]).sum()
    }
}

impl Rows {
    pub(crate) fn new(problem: &ContactProblem) -> Self {
        let mut rows = Self { pairs: Vec::new(), limits: Vec::new(), tangential: Vec::new() };
        for pair in &problem.contacts {
            let nodes = pair.interface.pairs();
            rows.pairs.push((rows.limits.len(), nodes.len()));
            rows.limits.extend(nodes.iter().map(|_| f64::INFINITY));
            if let Some(mu) = pair.friction.coulomb() {
                let limit = if mu > 0.0 { f64::INFINITY } else { 0.0 };
                rows.limits.extend(nodes.iter().map(|_| limit));
            } else if let Some(body) = problem.bodies.get(pair.bodies[0])
                && let Some(limits) = pair.friction_limit(body)
            {
                rows.limits.extend(nodes.iter().zip(limits).map(|(node, s)| node.tributary_length * s));
            }
            rows.tangential.resize(rows.pairs.last().map_or(0, |(start, count)| start + count), false);
            rows.tangential.resize(rows.limits.len(), true);
        }
        rows
    }

    /// Returns the number of rows.
    pub(crate) fn len(&self) -> usize {
        self.limits.len()
    }

    /// Returns the number of a row of a pair.
    pub(crate) fn at(&self, pair: usize, row: usize) -> usize {
        self.pairs[pair].0 + row
    }

    /// Tells whether a row is along a tangent.
    pub(crate) fn is_tangential(&self, row: usize) -> bool {
        self.tangential[row]
    }

    /// Returns the limits of the forces by row, N/m, see [`Self::bounds`].
    pub(crate) fn limits(&self) -> &[f64] {
        &self.limits
    }

    /// Returns the lower and upper bounds of the forces: `0 ≤ P`, `−S ≤ Q ≤ S`.
    ///
    /// * `limits`: `S` by row, infinite along normals, N/m.
    pub(crate) fn bounds(&self, limits: &[f64]) -> [Vec<f64>; 2] {
        let lower = limits
            .iter()
            .zip(&self.tangential)
            .map(|(s, tangential)| if *tangential { 0.0 - s } else { 0.0 });
        [lower.collect(), limits.to_vec()]
    }

    /// Returns the rows of a pair along its normals.
    pub(crate) fn normal(&self, pair: usize) -> Range<usize> {
        let (start, count) = self.pairs[pair];
        start..start + count
    }

    /// Returns the rows of a pair along its tangents; none without friction.
    pub(crate) fn tangential(&self, pair: usize) -> Range<usize> {
        let (start, count) = self.pairs[pair];
        let end = self.pairs.get(pair + 1).map_or(self.len(), |next| next.0);
        start + count..end
    }

    /// Takes the values of all rows along normals.
    pub(crate) fn normals<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.select(values, false)
    }

    /// Takes the values of all rows along tangents.
    pub(crate) fn tangentials<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.select(values, true)
    }

    fn select<T: Copy>(&self, values: &[T], tangential: bool) -> Vec<T> {
        let of = values.iter().zip(&self.tangential).filter(|(_, is)| **is == tangential);
        of.map(|(value, _)| *value).collect()
    }

    /// Joins values along normals and tangents to those of all rows.
    pub(crate) fn joined<T: Copy>(&self, normals: &[T], tangentials: &[T]) -> Vec<T> {
        let (mut normals, mut tangentials) = (normals.iter(), tangentials.iter());
        let next = |is: &bool| if *is { tangentials.next() } else { normals.next() };
        self.tangential.iter().filter_map(next).copied().collect()
    }

    /// Returns the initial gaps, m; along tangents the slip before this load step, 0 from rest.
    pub(crate) fn gaps(&self, problem: &PreparedProblem) -> Vec<f64> {
        let mut gaps = vec![0.0; self.len()];
        for (k, pair) in problem.problem().contacts.iter().enumerate() {
            let nodes = pair.interface.pairs().iter();
            gaps[self.normal(k)].iter_mut().zip(nodes).for_each(|(gap, node)| *gap = node.gap);
            if let Some(before) = &pair.slip_before {
                gaps[self.tangential(k)].iter_mut().zip(&before.nodes).for_each(|(gap, w)| *gap = *w);
            }
        }
        gaps
    }

    /// Returns the tributary length of each row, m.
    pub(crate) fn lengths(&self, problem: &PreparedProblem) -> Vec<f64> {
        let of_pair = |pair: &ContactPair| -> Vec<f64> {
            pair.rows().map(|row| pair.interface.pairs()[row.pair].tributary_length).collect()
        };
        problem.problem().contacts.iter().flat_map(of_pair).collect()
    }

    /// Returns the imposed trace of the obstacle of each row along its outward normal or tangent, m; `None` in rows of two bodies.
    pub(crate) fn obstacles(&self, problem: &PreparedProblem) -> Vec<Option<f64>> {
        let of_pair = |pair: &ContactPair| -> Vec<Option<f64>> {
            match problem.problem().obstacle_of(pair) {
                None => vec![None; pair.row_count()],
                Some(obstacle) => {
                    let imposed = obstacle.imposed();
                    pair.rows().map(|row| Some(sign(1) * imposed[row.pair].dot(&row.direction))).collect()
                }
            }
        };
        problem.problem().contacts.iter().flat_map(of_pair).collect()
    }

    /// Sorts one value per row by pair, those along the normals.
    pub(crate) fn by_pair<T: Copy>(&self, values: &[T]) -> Vec<Vec<T>> {
        (0..self.pairs.len()).map(|k| values[self.normal(k)].to_vec()).collect()
    }

    /// Lists the rows of a body, side after side.
    pub(crate) fn of_body(&self, problem: &PreparedProblem, body: usize) -> Vec<BodyRow> {
        let dofs = problem.bodies()[body].dofs();
        let of_side = |(block, (pair, side)): (usize, (usize, usize))| {
            let rows = dofs.rows(block).iter().enumerate();
            rows.map(move |(i, row)| {
                let terms = row.terms.iter().filter(|term| term.1 != 0.0);
                BodyRow {
                    row: self.at(pair, i),
                    terms: terms.map(|(k, a)| (*k as usize, sign(side) * a)).collect(),
                    imposed: sign(side) * row.imposed,
                }
            })
        };
        problem.problem().sides_of(body).enumerate().flat_map(of_side).collect()
    }
}

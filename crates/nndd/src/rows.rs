//! The rows of an assembly: one per pair of nodes, pair after pair.

use fem_core::interface::ContactPair;
use fem_core::prepared::PreparedProblem;

/// The sign of a side in the rows: the normal points out of the first body. So a row is the trace of each body along its own
/// outward normal.
pub(crate) fn sign(side: usize) -> f64 {
    if side == 0 { 1.0 } else { -1.0 }
}

/// The rows of all pairs.
pub(crate) struct Rows {
    /// Where the rows of each pair begin.
    starts: Vec<usize>,
    count: usize,
}

/// A row of one body: the trace `Σ a_k x_k + c` along its outward normal, in its interface unknowns `x`.
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
    pub(crate) fn new(problem: &PreparedProblem) -> Self {
        let (mut starts, mut count) = (Vec::new(), 0);
        for pair in &problem.problem().contacts {
            starts.push(count);
            count += pair.interface.pairs().len();
        }
        Self { starts, count }
    }

    /// Returns the number of rows.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Returns the number of the row of a pair of nodes.
    pub(crate) fn at(&self, pair: usize, nodes: usize) -> usize {
        self.starts[pair] + nodes
    }

    /// Returns the initial gaps, m.
    pub(crate) fn gaps(&self, problem: &PreparedProblem) -> Vec<f64> {
        let pairs = problem.problem().contacts.iter().flat_map(|pair| pair.interface.pairs());
        pairs.map(|pair| pair.gap).collect()
    }

    /// Returns the imposed trace of the obstacle of each row along its outward normal, m; `None` in rows of two bodies.
    pub(crate) fn obstacles(&self, problem: &PreparedProblem) -> Vec<Option<f64>> {
        let of_pair = |pair: &ContactPair| -> Vec<Option<f64>> {
            let pairs = pair.interface.pairs();
            match problem.problem().obstacle_of(pair) {
                None => vec![None; pairs.len()],
                Some(obstacle) => pairs
                    .iter()
                    .zip(obstacle.imposed())
                    .map(|(p, u)| Some(sign(1) * u.dot(&p.normal)))
                    .collect(),
            }
        };
        problem.problem().contacts.iter().flat_map(of_pair).collect()
    }

    /// Sorts one value per row by pair.
    pub(crate) fn by_pair(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let ends = self.starts.iter().skip(1).chain([&self.count]);
        self.starts.iter().zip(ends).map(|(start, end)| values[*start..*end].to_vec()).collect()
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

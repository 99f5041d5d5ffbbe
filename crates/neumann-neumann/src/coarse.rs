//! The coarse space of all rigid motions of all bodies.

use crate::broken::{Broken, Sparse, Traces};
use crate::error::BalancingError;
use crate::skeleton::{Skeleton, sum};
use contact_qp::SparseFactor;
use fem_core::cholesky::{Cholesky, Front, SymbolicCholesky};
use fem_core::each_body;
use fem_core::ordering::ROOT;
use fem_core::sparse::SymmetricCsc;
use std::collections::HashMap;
use std::sync::Arc;

/// A column of the coarse space that keeps less than this fraction of its energy beside the others depends on them.
const RANK: f64 = 1e-10;

/// A motion with less than this fraction of the energy of its traces, each alone, is not resisted.
const RESISTED: f64 = 1e-13;

/// From this many columns on, dense fronts are faster than a sparse factor.
const MANY: usize = 500;

/// A factor with more than this many values per entry of `C` has a bad order: bodies are not numbered as they lie.
const FILL: usize = 30;

/// Columns that are not cut further.
const FRONT: usize = 96;

/// The coarse space, see [`crate::Balancing`].
pub(crate) struct CoarseSpace {
    /// Columns of `Z`, each with energy 1.
    columns: Vec<Sparse>,
    factor: Factor,
}

impl CoarseSpace {
    /// Lists the columns of `Z`, and factorises `C`, the sum of the parts of all bodies.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn new(broken: &Broken<'_>, skeleton: &Skeleton) -> Result<Self, BalancingError> {
        let motions = broken.motions();
        let columns = each_body(motions.len(), |k| match motions[k][..] {
            // An obstacle has no stiffness to weigh it by.
            [(unknown, _)] if broken.is_obstacle(unknown) => skeleton.gather_sparse(&motions[k]),
            _ => skeleton.mean_sparse(&motions[k]),
        });
        let pinned = pinned(&motions, &broken.left_free(&skeleton.held(broken.rows.len()))?);
        let mut by_lambda = vec![Vec::new(); skeleton.len()];
        for (i, z) in columns.iter().enumerate() {
            z.iter().for_each(|(k, z)| by_lambda[*k].push((i, *z)));
        }
        let parts = each_body(broken.system().bodies.len(), |b| Part::new(broken, skeleton, b, &by_lambda));
        let mut by_column = vec![Vec::new(); columns.len()];
        for (b, part) in parts.iter().enumerate() {
            part.columns.iter().enumerate().for_each(|(place, i)| by_column[*i].push((b, place)));
        }
        // The entries of each column down to the diagonal.
        let entries = each_body(columns.len(), |j| {
            let mut entries: Sparse = Vec::new();
            for (b, place) in &by_column[j] {
                let Part { columns, energies } = &parts[*b];
                let energies = &energies[place * (place + 1) / 2..];
                entries.extend(columns[..=*place].iter().zip(energies).map(|(i, entry)| (*i, *entry)));
            }
            sum(entries)
        });
        // Each column gets energy 1. A motion that nothing resists has rounding alone, and is left out.
        let scale = |j: usize| {
            let size: f64 = columns[j].iter().map(|(k, z)| z * z * skeleton.stiffness_of(*k)).sum();
            let energy = entries[j].last().map_or(0.0, |(_, energy)| *energy);
            if energy > RESISTED * size { 1.0 / energy.sqrt() } else { 0.0 }
        };
        let mut scales: Vec<f64> = (0..columns.len()).map(scale).collect();
        pinned.into_iter().for_each(|j| scales[j] = 0.0);
        let kept: Vec<usize> = (0..columns.len()).filter(|j| scales[*j] > 0.0).collect();
        let mut numbers = vec![0; columns.len()];
        kept.iter().enumerate().for_each(|(number, j)| numbers[*j] = number);
        let of_column = |j: &usize| {
            let own = entries[*j].iter().filter(|(i, _)| scales[*i] > 0.0);
            own.map(|(i, entry)| (numbers[*i], numbers[*j], scales[*i] * scales[*j] * entry))
                .collect::<Vec<_>>()
        };
        let factor = Factor::new(kept.len(), kept.iter().flat_map(of_column).collect())?;
        let scaled = |j: &usize| columns[*j].iter().map(|(k, z)| (*k, scales[*j] * z)).collect();
        Ok(Self { columns: kept.iter().map(scaled).collect(), factor })
    }

    /// Computes `Z C⁺ Zᵀ r`.
    pub(crate) fn apply(&self, forces: &[f64]) -> Vec<f64> {
        let along = |z: &Sparse| z.iter().map(|(k, value)| value * forces[*k]).sum();
        let mut f: Vec<f64> = self.columns.iter().map(along).collect();
        self.factor.solve(&mut f);
        let mut lambda = vec![0.0; forces.len()];
        for (z, amount) in self.columns.iter().zip(f) {
            z.iter().for_each(|(k, value)| lambda[*k] += amount * value);
        }
        lambda
    }
}

/// Chooses one column for each motion that nothing resists, in which bodies in subdomains have dependent ones: without it nothing is lost.
///
/// * `motions`: of all columns, before they are shared; `free`: see [`Broken::left_free`].
fn pinned(motions: &[Sparse], free: &[Sparse]) -> Vec<usize> {
    let mut chosen: Vec<(usize, Sparse)> = Vec::with_capacity(free.len());
    for moved in free {
        let moved: HashMap<usize, f64> = moved.iter().copied().collect();
        let part = |column: &Sparse| column.iter().filter_map(|(k, q)| Some(q * moved.get(k)?)).sum::<f64>();
        // Its amounts in the columns, less what the motions before it take.
        let mut amounts: Vec<f64> = motions.iter().map(part).collect();
        for (column, known) in &chosen {
            let amount = amounts[*column];
            known.iter().for_each(|(k, of)| amounts[*k] -= amount * of);
        }
        let largest = amounts.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((column, &pivot)) = largest.filter(|(_, amount)| **amount != 0.0) else { continue };
        let scaled = amounts.iter().enumerate().filter(|(_, amount)| **amount != 0.0);
        chosen.push((column, scaled.map(|(k, amount)| (k, amount / pivot)).collect()));
    }
    chosen.into_iter().map(|(column, _)| column).collect()
}

/// The part of a body in `C`.
struct Part {
    /// The columns that move it, ascending.
    columns: Vec<usize>,
    /// Their energies: the upper triangle, column after column.
    energies: Arc<[f64]>,
}

impl Part {
    /// * `by_lambda`: `Z` by rows.
    fn new(broken: &Broken<'_>, skeleton: &Skeleton, body: usize, by_lambda: &[Sparse]) -> Self {
        let own = broken.of_body(body);
        let mut traces: Traces = Vec::new();
        for (row, k) in own.enumerate() {
            let terms = skeleton.terms(k).iter();
            traces.extend(
                terms.flat_map(|(j, n)| {
                    by_lambda[*j].iter().map(move |(i, z)| (row as u32, *i as u32, n * z))
                }),
            );
        }
        let mut columns: Vec<usize> = traces.iter().map(|(_, i, _)| *i as usize).collect();
        columns.sort_unstable();
        columns.dedup();
        for (_, i, _) in &mut traces {
            *i = columns.partition_point(|of| *of < *i as usize) as u32;
        }
        // They are kept.
        traces.shrink_to_fit();
        let energies = broken.energies(body, traces, columns.len());
        Self { columns, energies }
    }
}

/// The factor of `C`.
enum Factor {
    /// Without dependent columns: the column of each unknown, and the factor.
    Definite(Vec<u32>, Cholesky),
    /// Dependent columns are left out.
    SemiDefinite(Box<SparseFactor>),
}

impl Factor {
    /// * `entries`: of the upper triangle, with row and column.
    fn new(size: usize, entries: Vec<(usize, usize, f64)>) -> Result<Self, BalancingError> {
        if size >= MANY {
            let (order, fronts) = dissection(size, &entries);
            let matrix = reordered(&order, &entries);
            let structure = SymbolicCholesky::analyse(&matrix, &fronts).ok();
            let structure = structure.filter(|found| found.stored_values() <= FILL * entries.len());
            let factor = structure.and_then(|found| Cholesky::factorise(Arc::new(found), &matrix).ok());
            if let Some(factor) = factor.filter(|factor| factor.smallest_pivot().1 > RANK) {
                return Ok(Self::Definite(order, factor));
            }
        }
        Ok(Self::SemiDefinite(Box::new(SparseFactor::semi_definite(size, entries, RANK)?)))
    }

    fn solve(&self, f: &mut [f64]) {
        match self {
            Self::SemiDefinite(factor) => factor.solve(f),
            Self::Definite(order, factor) => {
                let mut x: Vec<f64> = order.iter().map(|column| f[*column as usize]).collect();
                factor.solve(&mut x);
                order.iter().zip(x).for_each(|(column, x)| f[*column as usize] = x);
            }
        }
    }
}

/// Orders the columns of `C` by nested dissection. Subdomains are numbered as their body was halved, so that columns are halved by their numbers.
fn dissection(size: usize, entries: &[(usize, usize, f64)]) -> (Vec<u32>, Vec<Front>) {
    let mut neighbours = vec![Vec::new(); size];
    for (i, j, _) in entries.iter().filter(|(i, j, _)| i != j) {
        neighbours[*i].push(*j as u32);
        neighbours[*j].push(*i as u32);
    }
    let mut found =
        Dissection { neighbours, side: vec![0; size], cuts: 0, order: Vec::new(), fronts: Vec::new() };
    found.cut(&(0..size as u32).collect::<Vec<_>>());
    (found.order, found.fronts)
}

/// A dissection under way.
struct Dissection {
    neighbours: Vec<Vec<u32>>,
    /// The last cut with each column in its second half.
    side: Vec<u32>,
    cuts: u32,
    order: Vec<u32>,
    fronts: Vec<Front>,
}

impl Dissection {
    /// Orders some columns; returns the fronts without a parent.
    fn cut(&mut self, columns: &[u32]) -> Vec<u32> {
        let (first, second) = columns.split_at(columns.len() / 2);
        self.cuts += 1;
        second.iter().for_each(|column| self.side[*column as usize] = self.cuts);
        let meets = |column: &u32| {
            self.neighbours[*column as usize].iter().any(|other| self.side[*other as usize] == self.cuts)
        };
        let (separator, rest): (Vec<u32>, Vec<u32>) = first.iter().partition(|column| meets(column));
        if columns.len() <= FRONT || rest.is_empty() {
            return self.front(columns, Vec::new());
        }
        let mut below = self.cut(&rest);
        below.extend(self.cut(second));
        if separator.is_empty() { below } else { self.front(&separator, below) }
    }

    /// Adds a front above others.
    fn front(&mut self, columns: &[u32], below: Vec<u32>) -> Vec<u32> {
        let (start, number) = (self.order.len() as u32, self.fronts.len() as u32);
        self.order.extend_from_slice(columns);
        self.fronts.push(Front { columns: start..self.order.len() as u32, parent: ROOT });
        below.into_iter().for_each(|front| self.fronts[front as usize].parent = number);
        vec![number]
    }
}

/// Writes a matrix in another order.
///
/// * `entries`: of one triangle, each place once.
fn reordered(order: &[u32], entries: &[(usize, usize, f64)]) -> SymmetricCsc {
    let mut places = vec![0u32; order.len()];
    (0..).zip(order).for_each(|(place, column)| places[*column as usize] = place);
    let mut lower: Vec<(u32, u32, f64)> = entries
        .iter()
        .map(|(i, j, entry)| {
            let [a, b] = [places[*i], places[*j]];
            (a.min(b), a.max(b), *entry)
        })
        .collect();
    lower.sort_unstable_by_key(|(column, row, _)| (*column, *row));
    let mut starts = vec![0u32; order.len() + 1];
    lower.iter().for_each(|(column, ..)| starts[*column as usize + 1] += 1);
    (0..order.len()).for_each(|column| starts[column + 1] += starts[column]);
    let (rows, values) = lower.into_iter().map(|(_, row, entry)| (row, entry)).unzip();
    SymmetricCsc { starts, rows, values }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of blocks that meet, with 3 columns each.
    fn matrix(n: usize) -> (usize, Vec<(usize, usize, f64)>) {
        let size = 3 * n * n;
        let block = |k: usize| [k / 3 / n, k / 3 % n];
        let mut entries = Vec::new();
        for j in 0..size {
            for i in 0..=j {
                let [a, b] = [block(i), block(j)];
                if (0..2).all(|c| a[c].abs_diff(b[c]) <= 1) {
                    entries.push((i, j, if i == j { 30.0 } else { ((i * 7 + j) as f64).sin() }));
                }
            }
        }
        (size, entries)
    }

    #[test]
    fn dense_fronts_solve_as_the_sparse_factor() {
        let (size, entries) = matrix(17);
        let dense = Factor::new(size, entries.clone()).unwrap();
        assert!(matches!(&dense, Factor::Definite(..)));
        let sparse =
            Factor::SemiDefinite(Box::new(SparseFactor::semi_definite(size, entries, RANK).unwrap()));
        let right: Vec<f64> = (0..size).map(|k| (k as f64).cos()).collect();
        let [mut a, mut b] = [right.clone(), right];
        dense.solve(&mut a);
        sparse.solve(&mut b);
        a.iter().zip(&b).for_each(|(a, b)| assert!((a - b).abs() < 1e-13, "{a} {b}"));
    }

    #[test]
    fn dependent_columns_are_left_out() {
        let (size, mut entries) = matrix(17);
        // The last column twice.
        let twin: Vec<_> = entries.iter().filter(|(_, j, _)| *j + 1 == size).copied().collect();
        entries.extend(twin.iter().map(|(i, _, entry)| (*i, size, *entry)));
        entries.push((size, size, 30.0));
        let factor = Factor::new(size + 1, entries).unwrap();
        assert!(matches!(factor, Factor::SemiDefinite(_)));
    }
}

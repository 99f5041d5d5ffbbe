//! The coarse space of all rigid motions of all bodies.

use crate::broken::{Broken, Sparse, Traces};
use crate::error::BalancingError;
use crate::skeleton::{Skeleton, sum};
use crate::structure::Structure;
use contact_qp::SparseFactor;
use fem_core::cholesky::Cholesky;
use fem_core::each_body;
use std::collections::HashMap;
use std::sync::{Arc, PoisonError};

/// A column of the coarse space that keeps less than this fraction of its energy beside the others depends on them.
const RANK: f64 = 1e-10;

/// A motion with less than this fraction of the energy of its traces, each alone, is not resisted.
const RESISTED: f64 = 1e-13;

/// From this many columns on, dense fronts are faster than a sparse factor.
const MANY: usize = 500;

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
        let entries = kept.iter().flat_map(of_column).collect();
        let mut known = broken.structure.lock().unwrap_or_else(PoisonError::into_inner);
        let factor = Factor::new(kept.len(), entries, &mut known)?;
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
    /// Without dependent columns: its structure, and the factor.
    Definite(Arc<Structure>, Cholesky),
    /// Dependent columns are left out.
    SemiDefinite(Box<SparseFactor>),
}

impl Factor {
    /// * `entries`: of the upper triangle, with row and column; `known`: the last structure. The set of all rows has the entries of all others.
    fn new(
        size: usize,
        entries: Vec<(usize, usize, f64)>,
        known: &mut Option<Arc<Structure>>,
    ) -> Result<Self, BalancingError> {
        if size >= MANY {
            let of_known = |known: &Arc<Structure>| Some((known.clone(), known.matrix(size, &entries)?));
            let found = known.as_ref().and_then(of_known).or_else(|| Structure::new(size, &entries));
            *known = found.as_ref().map(|(structure, _)| structure.clone());
            let factorised = found.and_then(|(structure, matrix)| {
                let factor = Cholesky::factorise(structure.symbolic.clone(), &matrix).ok()?;
                Some((structure, factor))
            });
            if let Some((structure, factor)) =
                factorised.filter(|(_, factor)| factor.smallest_pivot().1 > RANK)
            {
                return Ok(Self::Definite(structure, factor));
            }
        }
        Ok(Self::SemiDefinite(Box::new(SparseFactor::semi_definite(size, entries, RANK)?)))
    }

    fn solve(&self, f: &mut [f64]) {
        match self {
            Self::SemiDefinite(factor) => factor.solve(f),
            Self::Definite(structure, factor) => {
                let order = &structure.order;
                let mut x: Vec<f64> = order.iter().map(|column| f[*column as usize]).collect();
                factor.solve(&mut x);
                order.iter().zip(x).for_each(|(column, x)| f[*column as usize] = x);
            }
        }
    }
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
        let mut known = None;
        let dense = Factor::new(size, entries.clone(), &mut known).unwrap();
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
    fn a_matrix_with_fewer_entries_has_the_same_structure() {
        let (size, entries) = matrix(17);
        let mut known = None;
        Factor::new(size, entries.clone(), &mut known).unwrap();
        let first = known.clone().unwrap();
        let fewer: Vec<_> = entries.iter().copied().filter(|(i, j, _)| i == j || (i + j) % 3 != 0).collect();
        let again = Factor::new(size, fewer.clone(), &mut known).unwrap();
        assert!(Arc::ptr_eq(&first, known.as_ref().unwrap()));
        let afresh = Factor::new(size, fewer.clone(), &mut None).unwrap();
        let right: Vec<f64> = (0..size).map(|k| (k as f64).cos()).collect();
        let [mut a, mut b] = [right.clone(), right];
        again.solve(&mut a);
        afresh.solve(&mut b);
        a.iter().zip(&b).for_each(|(a, b)| assert!((a - b).abs() < 1e-13, "{a} {b}"));
        // One with more has another.
        let mut more = entries;
        more.push((0, size - 1, 0.5));
        Factor::new(size, more, &mut known).unwrap();
        assert!(!Arc::ptr_eq(&first, known.as_ref().unwrap()));
    }

    #[test]
    fn dependent_columns_are_left_out() {
        let (size, mut entries) = matrix(17);
        // The last column twice.
        let twin: Vec<_> = entries.iter().filter(|(_, j, _)| *j + 1 == size).copied().collect();
        entries.extend(twin.iter().map(|(i, _, entry)| (*i, size, *entry)));
        entries.push((size, size, 30.0));
        let factor = Factor::new(size + 1, entries, &mut None).unwrap();
        assert!(matches!(factor, Factor::SemiDefinite(_)));
    }
}

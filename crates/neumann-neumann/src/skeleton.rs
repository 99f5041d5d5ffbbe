//! The unknowns that a set of closed rows leaves: one λ per cluster of interface unknowns that closed rows tie.
//!
//! ```math
//! x = x₀ + N λ,   B_A x = c_A                D = K N (Nᵀ K N)⁻¹,   K = diag S
//! ```
//! Unknowns of subdomains that are one displacement are in one cluster whatever is closed. Between two bodies `λ` is the common trace and `D_α = k_α / (k_1 + k_2)`, the weights by stiffness; a row against a support or an obstacle fixes its unknown,
//! and an open one has two unknowns with weight 1. Rows that depend on those before them leave the set.

use crate::broken::{Broken, Sparse};
use crate::lists::Lists;
use fem_core::dense::pseudo_inverse;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// A row that keeps less than this fraction of its largest term depends on those before it.
const DEPENDENT: f64 = 1e-9;

/// Eigenvalues below this fraction of the largest one are zero.
const ZERO: f64 = 1e-10;

/// A closed row, solved for one of its unknowns.
struct Step {
    row: usize,
    pivot: usize,
    factor: f64,
    others: Vec<(usize, f64)>,
    right: f64,
    /// What the earlier steps took from the row: `row = Σ m_s step_s + step`.
    multipliers: Vec<(usize, f64)>,
}

/// The unknowns of a set of closed rows.
pub struct Skeleton {
    steps: Vec<Step>,
    /// `x₀`, m.
    constant: Vec<f64>,
    /// `N`, by unknown.
    terms: Lists,
    /// `Nᵀ`, by λ.
    columns: Lists,
    /// `K`, N/m².
    stiffness: Vec<f64>,
    /// `(Nᵀ K N)⁻¹`: of unknowns that no other one meets, and of groups.
    inverse: Vec<f64>,
    groups: Vec<(Vec<usize>, DMatrix<f64>)>,
    /// The group of each λ, and its place there.
    place: Vec<Option<(u32, u32)>>,
}

impl Skeleton {
    /// * `closed`: by row; `openings`: of the last traces, m: of rows that depend on each other the tightest hold.
    pub fn new(broken: &Broken<'_>, closed: &[bool], openings: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..closed.len()).filter(|row| closed[*row]).collect();
        order.sort_by(|a, b| openings[*a].total_cmp(&openings[*b]));
        let mut found = Self {
            steps: Vec::with_capacity(order.len()),
            constant: vec![0.0; broken.len()],
            terms: Lists::default(),
            columns: Lists::default(),
            stiffness: broken.diagonal.clone(),
            inverse: Vec::new(),
            groups: Vec::new(),
            place: Vec::new(),
        };
        let mut solved: Vec<Option<usize>> = vec![None; broken.len()];
        for row in order {
            found.close(broken, row, &mut solved);
        }
        let (mut terms, mut count): (Vec<Sparse>, _) = (vec![Vec::new(); broken.len()], 0);
        for (unknown, terms) in terms.iter_mut().enumerate() {
            if solved[unknown].is_none() && broken.leader(unknown) == unknown {
                terms.push((count, 1.0));
                count += 1;
            }
        }
        // A step has unknowns of later steps only.
        for Step { pivot, factor, others, right, .. } in found.steps.iter().rev() {
            let (mut constant, mut sum) = (*right, BTreeMap::new());
            for (unknown, a) in others {
                constant -= a * found.constant[*unknown];
                terms[*unknown].iter().for_each(|(j, n)| *sum.entry(*j).or_insert(0.0) -= a * n / factor);
            }
            found.constant[*pivot] = constant / factor;
            terms[*pivot] = sum.into_iter().filter(|(_, n)| *n != 0.0).collect();
        }
        for unknown in (0..terms.len()).filter(|k| broken.leader(*k) != *k) {
            found.constant[unknown] = found.constant[broken.leader(unknown)];
        }
        found.terms = (0..terms.len()).map(|unknown| &*terms[broken.leader(unknown)]).collect();
        found.columns = found.terms.transposed(count);
        found.weigh();
        found
    }

    /// Takes a row into the set, unless it depends on the others.
    fn close(&mut self, broken: &Broken<'_>, row: usize, solved: &mut [Option<usize>]) {
        let mut terms: BTreeMap<usize, f64> = BTreeMap::new();
        broken.rows[row].iter().for_each(|(k, a)| *terms.entry(*k).or_default() += a);
        let (mut right, mut multipliers) = (broken.gaps[row], Vec::new());
        let size = terms.values().fold(0.0f64, |most, a| most.max(a.abs()));
        let earliest =
            |terms: &BTreeMap<usize, f64>| terms.keys().filter_map(|k| Some((solved[*k]?, *k))).min();
        while let Some((s, unknown)) = earliest(&terms) {
            let step = &self.steps[s];
            let part = terms.remove(&unknown).unwrap_or(0.0) / step.factor;
            step.others.iter().for_each(|(k, a)| *terms.entry(*k).or_default() -= part * a);
            right -= part * step.right;
            multipliers.push((s, part));
        }
        terms.retain(|_, a| a.abs() > DEPENDENT * size);
        let of_body = |(k, a): (&usize, &f64)| (!broken.is_obstacle(*k), a.abs());
        let pivot = terms.iter().max_by(|a, b| {
            let (a, b) = (of_body(*a), of_body(*b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let Some((&pivot, &factor)) = pivot else { return };
        terms.remove(&pivot);
        solved[pivot] = Some(self.steps.len());
        let others = terms.into_iter().collect();
        self.steps.push(Step { row, pivot, factor, others, right, multipliers });
    }

    /// Computes `(Nᵀ K N)⁻¹`, group by group.
    fn weigh(&mut self) {
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (k, leader) in leaders(self.len(), self.terms.iter()).into_iter().enumerate() {
            members.entry(leader).or_default().push(k);
        }
        let groups: Vec<Vec<usize>> = members.into_values().filter(|members| members.len() > 1).collect();
        let mut place: Vec<Option<(u32, u32)>> = vec![None; self.len()];
        for (g, members) in groups.iter().enumerate() {
            members.iter().enumerate().for_each(|(i, k)| place[*k] = Some((g as u32, i as u32)));
        }
        let mut sums = vec![0.0; self.len()];
        let mut matrices: Vec<DMatrix<f64>> =
            groups.iter().map(|members| DMatrix::zeros(members.len(), members.len())).collect();
        for (terms, k) in self.terms.iter().zip(&self.stiffness) {
            for (p, a) in terms {
                match place[*p] {
                    None => sums[*p] += k * a * a,
                    Some((g, i)) => terms.iter().for_each(|(q, b)| {
                        let j = place[*q].map_or(i, |(_, j)| j);
                        matrices[g as usize][(i as usize, j as usize)] += k * a * b;
                    }),
                }
            }
        }
        self.inverse = sums.iter().map(|sum| if *sum > 0.0 { 1.0 / sum } else { 0.0 }).collect();
        let inverse = |matrix: DMatrix<f64>| {
            let (zero, n) = (ZERO * matrix.amax(), matrix.nrows());
            pseudo_inverse(matrix, zero).unwrap_or_else(|| DMatrix::zeros(n, n))
        };
        self.place = place;
        self.groups = groups.into_iter().zip(matrices.into_iter().map(inverse)).collect();
    }

    /// Counts the λ.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Tells whether there is no λ.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Computes the diagonal entry of `Nᵀ K N` of a λ, N/m².
    pub fn stiffness_of(&self, lambda: usize) -> f64 {
        self.columns.get(lambda).iter().map(|(k, n)| n * n * self.stiffness[*k]).sum()
    }

    /// Computes `N λ`, m.
    pub fn expand(&self, lambda: &[f64]) -> Vec<f64> {
        self.terms.iter().map(|terms| terms.iter().map(|(j, n)| n * lambda[*j]).sum()).collect()
    }

    /// Returns the row of `N` of an unknown.
    pub fn terms(&self, unknown: usize) -> &[(usize, f64)] {
        self.terms.get(unknown)
    }

    /// Tells whether the closed rows fix an unknown: no λ moves it.
    pub fn is_fixed(&self, unknown: usize) -> bool {
        self.terms.get(unknown).is_empty()
    }

    /// Returns `x₀`, m.
    pub fn constant(&self) -> &[f64] {
        &self.constant
    }

    /// Sums up forces on the unknowns by cluster, `Nᵀ f`, N/m.
    pub fn gather(&self, forces: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.len()];
        for (terms, force) in self.terms.iter().zip(forces) {
            terms.iter().for_each(|(j, n)| sums[*j] += n * force);
        }
        sums
    }

    /// Computes the mean traces of the clusters, `Dᵀ x`, m.
    pub fn mean(&self, x: &[f64]) -> Vec<f64> {
        let weighted: Vec<f64> = x.iter().zip(&self.stiffness).map(|(x, k)| k * x).collect();
        self.weighted(self.gather(&weighted))
    }

    /// Shares forces on the clusters among the unknowns, `D r`, N/m.
    pub fn share(&self, forces: &[f64]) -> Vec<f64> {
        let shares = self.expand(&self.weighted(forces.to_vec()));
        shares.iter().zip(&self.stiffness).map(|(share, k)| k * share).collect()
    }

    /// Sums up few forces by cluster, N/m.
    pub fn gather_sparse(&self, forces: &Sparse) -> Sparse {
        sum(forces.iter().flat_map(|(k, value)| self.terms.get(*k).iter().map(move |(j, n)| (*j, n * value))))
    }

    /// Computes the mean traces of the clusters if few unknowns move, m.
    pub fn mean_sparse(&self, x: &Sparse) -> Sparse {
        let weighted = x.iter().map(|(k, value)| (*k, self.stiffness[*k] * value)).collect();
        let of_lambda = |(j, f): (usize, f64)| match self.place[j] {
            None => vec![(j, self.inverse[j] * f)],
            Some((group, column)) => {
                let (members, inverse) = &self.groups[group as usize];
                members
                    .iter()
                    .zip(inverse.column(column as usize).iter())
                    .map(|(k, value)| (*k, f * value))
                    .collect()
            }
        };
        sum(self.gather_sparse(&weighted).into_iter().flat_map(of_lambda))
    }

    /// Computes `(Nᵀ K N)⁻¹ f`.
    fn weighted(&self, mut f: Vec<f64>) -> Vec<f64> {
        let of_groups: Vec<DVector<f64>> = self
            .groups
            .iter()
            .map(|(members, inverse)| {
                inverse * DVector::from_iterator(members.len(), members.iter().map(|k| f[*k]))
            })
            .collect();
        f.iter_mut().zip(&self.inverse).for_each(|(f, inverse)| *f *= inverse);
        for ((members, _), values) in self.groups.iter().zip(&of_groups) {
            members.iter().zip(values).for_each(|(k, value)| f[*k] = *value);
        }
        f
    }

    /// Lists the rows that hold.
    pub fn held(&self, rows: usize) -> Vec<bool> {
        let mut held = vec![false; rows];
        self.steps.iter().for_each(|step| held[step.row] = true);
        held
    }

    /// Computes the forces `P` of the closed rows from balanced forces on the unknowns, `B_Aᵀ P = f`, N/m.
    pub fn forces(&self, balanced: &[f64], rows: usize) -> Vec<f64> {
        // Of the steps, in their order: a step has no pivot of an earlier one.
        let mut rest: Vec<f64> = balanced.to_vec();
        let mut own: Vec<f64> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let force = rest[step.pivot] / step.factor;
            step.others.iter().for_each(|(k, a)| rest[*k] -= a * force);
            own.push(force);
        }
        // Of the rows, last first.
        let mut forces = vec![0.0; rows];
        for (t, step) in self.steps.iter().enumerate().rev() {
            forces[step.row] = own[t];
            step.multipliers.iter().for_each(|(s, part)| own[*s] -= part * own[t]);
        }
        forces
    }
}

/// Finds the groups of numbers that lists of terms tie: of each number the smallest one of its group.
pub fn leaders<'a>(count: usize, terms: impl IntoIterator<Item = &'a [(usize, f64)]>) -> Vec<usize> {
    let mut leader: Vec<usize> = (0..count).collect();
    let find = |leader: &mut [usize], mut k: usize| {
        while leader[k] != k {
            leader[k] = leader[leader[k]];
            k = leader[k];
        }
        k
    };
    for pair in terms.into_iter().flat_map(|terms| terms.windows(2)) {
        let [a, b] = [pair[0].0, pair[1].0].map(|k| find(&mut leader, k));
        leader[a.max(b)] = a.min(b);
    }
    (0..count).map(|k| find(&mut leader, k)).collect()
}

/// Adds up what has the same number.
pub(crate) fn sum(entries: impl IntoIterator<Item = (usize, f64)>) -> Sparse {
    let mut entries: Sparse = entries.into_iter().collect();
    // Equal numbers in the order in which they came.
    entries.sort_by_key(|(k, _)| *k);
    entries.dedup_by(|next, sum| {
        let same = next.0 == sum.0;
        sum.1 += if same { next.1 } else { 0.0 };
        same
    });
    entries
}

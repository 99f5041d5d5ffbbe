//! Random problems, a sparse copy of a dense one, exhaustive search, and the exactness that every solution must have.

use contact_qp::{BoundQp, MatrixView, QpSolution};

/// Numbers that look random and are the same on every machine.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2).wrapping_add(0x9E37_79B9_7F4A_7C15))
    }

    /// Uniform in [-1, 1).
    pub(crate) fn number(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.number() < 2.0 * probability - 1.0
    }
}

/// A problem that owns its data.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(crate) n: usize,
    pub(crate) matrix: Vec<f64>,
    pub(crate) linear: Vec<f64>,
    pub(crate) bounded: Vec<usize>,
    pub(crate) lower: Vec<f64>,
}

impl Problem {
    /// `P = B Bᵀ + 0.05 I` with entries of `B` left out at random, three unknowns in four bounded.
    pub(crate) fn random(n: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let factor: Vec<f64> =
            (0..n * n).map(|_| if random.chance(0.6) { random.number() } else { 0.0 }).collect();
        let mut matrix = vec![0.0; n * n];
        for j in 0..n {
            for i in 0..n {
                let product: f64 = (0..n).map(|k| factor[i * n + k] * factor[j * n + k]).sum();
                matrix[j * n + i] = product + if i == j { 0.05 } else { 0.0 };
            }
        }
        let bounded: Vec<usize> = (0..n).filter(|_| random.chance(0.75)).collect();
        let lower = bounded.iter().map(|_| random.number()).collect();
        Self { n, matrix, linear: (0..n).map(|_| random.number()).collect(), bounded, lower }
    }

    pub(crate) fn dense(&self) -> BoundQp<'_> {
        self.with(MatrixView::Dense { n: self.n, values: &self.matrix })
    }

    pub(crate) fn with<'a>(&'a self, matrix: MatrixView<'a>) -> BoundQp<'a> {
        BoundQp { matrix, linear: &self.linear, bounded: &self.bounded, lower: &self.lower }
    }
}

/// The upper triangle of a full matrix without its zeros.
pub(crate) struct Sparse {
    n: usize,
    column_starts: Vec<usize>,
    row_indices: Vec<usize>,
    values: Vec<f64>,
}

impl Sparse {
    pub(crate) fn new(n: usize, full: &[f64]) -> Self {
        let mut sparse = Self { n, column_starts: vec![0], row_indices: vec![], values: vec![] };
        for j in 0..n {
            for i in (0..=j).filter(|&i| full[j * n + i] != 0.0) {
                sparse.row_indices.push(i);
                sparse.values.push(full[j * n + i]);
            }
            sparse.column_starts.push(sparse.values.len());
        }
        sparse
    }

    pub(crate) fn view(&self) -> MatrixView<'_> {
        MatrixView::SparseUpper {
            n: self.n,
            column_starts: &self.column_starts,
            row_indices: &self.row_indices,
            values: &self.values,
        }
    }
}

/// Solves a small full system by elimination with row exchanges.
fn eliminate(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for j in 0..n {
        let pivot = (j..n).max_by(|&a, &b| rows[a][j].abs().total_cmp(&rows[b][j].abs())).unwrap();
        rows.swap(j, pivot);
        let pivot_row = rows[j].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|&(i, _)| i != j) {
            let factor = row[j] / pivot_row[j];
            row.iter_mut().zip(&pivot_row).for_each(|(a, b)| *a -= factor * b);
        }
    }
    (0..n).map(|i| rows[i][n] / rows[i][i]).collect()
}

/// Tries every active set; returns `x` and the multipliers of the one with correct signs.
pub(crate) fn brute_force(problem: &Problem) -> (Vec<f64>, Vec<f64>) {
    let Problem { n, matrix, linear, bounded, lower } = problem;
    for mask in 0..1usize << bounded.len() {
        let mut x = vec![0.0; *n];
        let mut free = vec![true; *n];
        for (k, &i) in bounded.iter().enumerate().filter(|&(k, _)| mask >> k & 1 == 1) {
            x[i] = lower[k];
            free[i] = false;
        }
        let gradient =
            |x: &[f64], i: usize| linear[i] + (0..*n).map(|j| matrix[j * n + i] * x[j]).sum::<f64>();
        let inside: Vec<usize> = (0..*n).filter(|&i| free[i]).collect();
        let rows = inside
            .iter()
            .map(|&i| {
                let mut row: Vec<f64> = inside.iter().map(|&j| matrix[j * n + i]).collect();
                row.push(-gradient(&x, i));
                row
            })
            .collect();
        for (&i, value) in inside.iter().zip(eliminate(rows)) {
            x[i] = value;
        }
        let multipliers: Vec<f64> =
            bounded.iter().map(|&i| if free[i] { 0.0 } else { gradient(&x, i) }).collect();
        let signs = bounded
            .iter()
            .enumerate()
            .all(|(k, &i)| if free[i] { x[i] >= lower[k] } else { multipliers[k] >= 0.0 });
        if signs {
            return (x, multipliers);
        }
    }
    panic!("no active set has the right signs: {problem:?}");
}

/// Asserts the properties of every solution, bit for bit.
pub(crate) fn assert_exact(qp: &BoundQp<'_>, solution: &QpSolution) {
    assert_eq!(solution.x.len(), qp.linear.len());
    assert_eq!(solution.multipliers.len(), qp.bounded.len());
    assert_eq!(solution.active.len(), qp.bounded.len());
    for (k, (&i, &lower)) in qp.bounded.iter().zip(qp.lower).enumerate() {
        let (x, r) = (solution.x[i], solution.multipliers[k]);
        assert!(x >= lower && r >= 0.0 && r.is_sign_positive(), "bound {k}: x = {x}, l = {lower}, r = {r}");
        if solution.active.is_active(k) {
            assert_eq!(x.to_bits(), lower.to_bits(), "bound {k} is active");
        } else {
            assert_eq!(r.to_bits(), 0.0f64.to_bits(), "bound {k} is inactive");
        }
    }
    assert_eq!((solution.kkt.primal, solution.kkt.dual, solution.kkt.complementarity), (0.0, 0.0, 0.0));
}

/// Asserts that two vectors agree to `tolerance` times the largest entry of the second.
pub(crate) fn assert_close(found: &[f64], wanted: &[f64], tolerance: f64) {
    assert_eq!(found.len(), wanted.len());
    let scale = wanted.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    for (i, (a, b)) in found.iter().zip(wanted).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "entry {i}: {a:e} instead of {b:e}");
    }
}

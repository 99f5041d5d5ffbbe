//! Random problems, a sparse copy of a dense one, exhaustive search, and the exactness that every solution must have.

use contact_qp::{BoundState, BoxQp, BoxSolution, MatrixView, SparseRows};

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
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) rows: SparseRows,
    pub(crate) right_side: Vec<f64>,
}

impl Problem {
    /// A problem without rows and upper bounds.
    pub(crate) fn below(matrix: Vec<f64>, linear: Vec<f64>, lower: Vec<f64>) -> Self {
        let n = linear.len();
        let (upper, rows) = (vec![f64::INFINITY; n], SparseRows::new(n));
        Self { n, matrix, linear, lower, upper, rows, right_side: Vec::new() }
    }

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
        let mut lower = vec![f64::NEG_INFINITY; n];
        bounded.iter().for_each(|i| lower[*i] = random.number());
        Self::below(matrix, (0..n).map(|_| random.number()).collect(), lower)
    }

    /// A problem with bounds on both sides and rows that has a solution: `e = G x` of some `x` within the bounds.
    ///
    /// * `rank`: of the matrix; with fewer than `n` the rows must hold it.
    pub(crate) fn boxed(random: &mut Random, n: usize, m: usize, rank: usize) -> Self {
        let factor: Vec<f64> = (0..n * rank).map(|_| random.number()).collect();
        let entry = |i: usize, j: usize| -> f64 {
            (0..rank).map(|k| factor[k * n + i] * factor[k * n + j]).sum::<f64>()
        };
        let matrix = (0..n * n).map(|k| entry(k % n, k / n)).collect();
        let mut rows: Vec<f64> = (0..n * m).map(|_| random.number()).collect();
        if m > 2 {
            // Dependent rows.
            for i in 0..n {
                rows[2 * n + i] = rows[i] - 2.0 * rows[n + i];
            }
        }
        let inside: Vec<f64> = (0..n).map(|_| 0.5 + (0.5 * (1.0 + random.number()))).collect();
        let right_side = (0..m).map(|k| (0..n).map(|i| rows[k * n + i] * inside[i]).sum()).collect();
        let upper =
            (0..n).map(|_| if (0.5 * (1.0 + random.number())) < 0.5 { 2.0 } else { f64::INFINITY }).collect();
        let linear = (0..n).map(|_| 3.0 * random.number()).collect();
        let rows = SparseRows::from_dense(n, &rows);
        Self { n, matrix, linear, lower: vec![0.0; n], upper, rows, right_side }
    }

    /// Computes `½ xᵀP x + qᵀx`.
    pub(crate) fn objective(&self, x: &[f64]) -> f64 {
        let n = x.len();
        let product = |i: usize| (0..n).map(|j| self.matrix[j * n + i] * x[j]).sum::<f64>();
        (0..n).map(|i| x[i] * (0.5 * product(i) + self.linear[i])).sum()
    }

    /// Lists the unknowns that have a bound.
    pub(crate) fn bounded(&self) -> Vec<usize> {
        (0..self.n).filter(|i| self.lower[*i].is_finite() || self.upper[*i].is_finite()).collect()
    }

    pub(crate) fn dense(&self) -> BoxQp<'_> {
        self.with(MatrixView::Dense { n: self.n, values: &self.matrix })
    }

    pub(crate) fn with<'a>(&'a self, matrix: MatrixView<'a>) -> BoxQp<'a> {
        BoxQp {
            matrix,
            linear: &self.linear,
            lower: &self.lower,
            upper: &self.upper,
            rows: &self.rows,
            right_side: &self.right_side,
        }
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

/// A wall of `courses` of `width` blocks, each on two of the course below: the forces on it along two directions and about its middle,
/// from two joints at each end of each face.
pub(crate) fn wall(courses: usize, width: usize) -> SparseRows {
    let mut columns: Vec<Vec<(usize, f64)>> = Vec::new();
    let block = |course: usize, k: usize| course * width + k;
    for course in 0..courses {
        for k in 0..width {
            for (below, at) in [(k, -0.5), (k, -0.1), (k + 1, 0.1), (k + 1, 0.5)] {
                let upper = 3 * block(course, k);
                let mut column = vec![(upper + 1, -1.0), (upper + 2, -at)];
                if course > 0 && below < width {
                    let lower = 3 * block(course - 1, below);
                    column.extend([(lower + 1, 1.0), (lower + 2, at + if below == k { 0.5 } else { -0.5 })]);
                }
                columns.push(column);
            }
            // The heads of neighbours.
            if k + 1 < width {
                columns.push(vec![(3 * block(course, k), 1.0), (3 * block(course, k + 1), -1.0)]);
            }
        }
    }
    let mut entries = SparseRows::new(3 * courses * width);
    columns.iter_mut().for_each(|column| {
        column.sort_by_key(|(row, _)| *row);
        entries.push(column.iter().copied());
    });
    entries.transposed()
}

/// Tries every active set of lower bounds; returns `x` and the multipliers of the one with correct signs.
pub(crate) fn brute_force(problem: &Problem) -> (Vec<f64>, Vec<f64>) {
    let Problem { n, matrix, linear, lower, .. } = problem;
    let bounded = problem.bounded();
    for mask in 0..1usize << bounded.len() {
        let mut x = vec![0.0; *n];
        let mut free = vec![true; *n];
        for (_, &i) in bounded.iter().enumerate().filter(|&(k, _)| mask >> k & 1 == 1) {
            x[i] = lower[i];
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
        let multipliers: Vec<f64> = (0..*n).map(|i| if free[i] { 0.0 } else { gradient(&x, i) }).collect();
        if (0..*n).all(|i| if free[i] { x[i] >= lower[i] } else { multipliers[i] >= 0.0 }) {
            return (x, multipliers);
        }
    }
    panic!("no active set has the right signs: {problem:?}");
}

/// Counts the unknowns at their bounds.
pub(crate) fn at_bounds(solution: &BoxSolution) -> usize {
    solution.states.iter().filter(|place| **place != BoundState::Free).count()
}

/// Asserts the properties of every solution, bit for bit.
pub(crate) fn assert_exact(qp: &BoxQp<'_>, solution: &BoxSolution) {
    let n = qp.linear.len();
    assert_eq!([solution.x.len(), solution.multipliers.len(), solution.states.len()], [n; 3]);
    for i in 0..n {
        let (x, y) = (solution.x[i], solution.multipliers[i]);
        assert!((qp.lower[i]..=qp.upper[i]).contains(&x), "{i}: {x} outside its bounds");
        let (bound, right) = match solution.states[i] {
            BoundState::Lower => (qp.lower[i], y >= 0.0 && y.is_sign_positive()),
            BoundState::Upper => (qp.upper[i], y <= 0.0),
            BoundState::Free => (x, y.to_bits() == 0),
        };
        assert!(x.to_bits() == bound.to_bits() && right, "{i}: {:?}, x = {x}, y = {y}", solution.states[i]);
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

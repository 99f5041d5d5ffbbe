//! Measures the time of the three methods on dense problems like those of condensed contact.
// The macros of criterion make public functions without documentation.
#![allow(missing_docs)]

use contact_qp::{BoundState, BoxQp, MatrixView, QpMethod, QpSettings, SparseRows, solve_box};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::f64::consts::PI;
use std::hint::black_box;

/// Stiffness of the surface of a half-plane, nodal force against displacement: `2 h² Σ_k kπ s_k s_kᵀ` on the sine
/// modes `s_k`, with the spacing `h = 1 / (n + 1)`.
fn half_plane(n: usize) -> Vec<f64> {
    let spacing = 1.0 / (n + 1) as f64;
    let sine: Vec<f64> = (0..2 * (n + 1)).map(|k| (k as f64 * PI * spacing).sin()).collect();
    let mode = |i: usize, k: usize| sine[(i + 1) * (k + 1) % (2 * (n + 1))];
    let mut matrix = vec![0.0; n * n];
    for j in 0..n {
        for i in 0..=j {
            let sum: f64 = (0..n).map(|k| (k + 1) as f64 * PI * mode(i, k) * mode(j, k)).sum();
            matrix[j * n + i] = 2.0 * spacing * spacing * sum;
            matrix[i * n + j] = matrix[j * n + i];
        }
    }
    matrix
}

/// Nodal forces of a uniform pressure, and a parabolic punch that two nodes in five touch.
fn loads_and_bounds(n: usize, pressure: f64) -> (Vec<f64>, Vec<f64>) {
    let spacing = 1.0 / (n + 1) as f64;
    let height = |i: usize| -0.1 - 0.5 * ((i + 1) as f64 * spacing - 0.45).powi(2);
    (vec![pressure * spacing; n], (0..n).map(height).collect())
}

fn roads(criterion: &mut Criterion) {
    for n in [81, 321, 641] {
        let matrix = half_plane(n);
        let (upper, rows) = (vec![f64::INFINITY; n], SparseRows::new(n));
        let (linear, lower) = loads_and_bounds(n, 1.0);
        let (heavier, _) = loads_and_bounds(n, 1.02);
        let matrix = MatrixView::Dense { n, values: &matrix };
        let qp =
            BoxQp { matrix, linear: &linear, lower: &lower, upper: &upper, rows: &rows, right_side: &[] };
        let changed = BoxQp { linear: &heavier, ..qp };
        let answer = solve_box(&qp, None, &QpSettings::default().with_method(QpMethod::ActiveSet));
        let right = answer.map(|solution| solution.states).unwrap_or_default();
        let touching = right.iter().filter(|place| **place == BoundState::Lower).count();
        assert!(touching > n / 4, "{touching} of {n} nodes touch");

        let mut group = criterion.benchmark_group("dense");
        let mut time = |name: &str, qp: &BoxQp<'_>, start: Option<&[BoundState]>, method: QpMethod| {
            let settings = QpSettings::default().with_method(method);
            group.bench_function(BenchmarkId::new(name, n), |bencher| {
                bencher.iter(|| solve_box(black_box(qp), start, &settings));
            });
        };
        time("clarabel", &qp, None, QpMethod::Clarabel);
        time("active set, cold", &qp, None, QpMethod::ActiveSet);
        time("warm start, right", &qp, Some(&right), QpMethod::Auto);
        time("warm start, load 2 % up", &changed, Some(&right), QpMethod::Auto);
        group.finish();
    }
}

criterion_group!(benches, roads);
criterion_main!(benches);

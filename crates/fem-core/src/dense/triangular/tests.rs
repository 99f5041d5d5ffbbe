use super::*;

/// Sizes around those of faer's blocks.
const SIZES: [usize; 12] = [1, 2, 3, 5, 8, 16, 17, 31, 64, 65, 97, 200];

fn value(i: usize, j: usize) -> f64 {
    ((i * 31 + j * 17) as f64).sin()
}

/// A lower triangle with a dominant diagonal, and NaN above it, which must not be read.
fn lower(n: usize) -> Vec<f64> {
    let entry = |i: usize, j: usize| match i.cmp(&j) {
        std::cmp::Ordering::Less => f64::NAN,
        std::cmp::Ordering::Equal => 2.0 + value(i, j),
        std::cmp::Ordering::Greater => value(i, j) / n as f64,
    };
    (0..n * n).map(|k| entry(k % n, k / n)).collect()
}

/// The lower triangle of `L Lᵀ`, one sum at a time, and NaN above it.
fn sums(l: &[f64], n: usize) -> Vec<f64> {
    let entry = |i: usize, j: usize| {
        if i < j { f64::NAN } else { (0..=j).map(|k| l[k * n + i] * l[k * n + j]).sum() }
    };
    (0..n * n).map(|k| entry(k % n, k / n)).collect()
}

fn below(n: usize) -> impl Iterator<Item = usize> {
    (0..n).flat_map(move |j| (j..n).map(move |i| j * n + i))
}

#[test]
fn a_front_and_its_update_are_parts_of_the_whole() {
    let fronts = SIZES.map(|n| (n, n)).into_iter();
    for (n, width) in fronts.chain([(5, 2), (40, 17), (130, 33), (300, 100), (7, 0)]) {
        let l = lower(n);
        let a = sums(&l, n);
        let mut panel = a[..width * n].to_vec();
        eliminate(&mut panel, [n, width]).unwrap();
        for k in below(n).filter(|k| *k < width * n) {
            assert!((panel[k] - l[k]).abs() < 1e-13, "n = {n}, entry {k}: {} against {}", panel[k], l[k]);
        }
        let b = n - width;
        let mut rest = vec![f64::NAN; b * b];
        update(&panel, [n, width], &mut rest);
        (0..b * b).for_each(|k| rest[k] += a[(width + k / b) * n + width + k % b]);
        eliminate(&mut rest, [b, b]).unwrap();
        for k in below(b) {
            let expected = l[(width + k / b) * n + width + k % b];
            assert!((rest[k] - expected).abs() < 1e-12, "n = {n}, width {width}");
        }
    }
}

#[test]
fn the_first_pivot_that_is_not_positive_is_named() {
    for n in [1, 4, 16, 37, 120] {
        for bad in [0, n / 2, n - 1] {
            for pivot in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
                let mut a = sums(&lower(n), n);
                a[bad * n + bad] = pivot;
                assert_eq!(eliminate(&mut a, [n, n]), Err(bad), "n = {n}, {pivot}");
            }
        }
    }
    assert_eq!(eliminate(&mut [], [0, 0]), Ok(()));
}

#[test]
fn an_inverse_times_its_matrix_is_the_identity() {
    for n in SIZES {
        let l = lower(n);
        let (a, inverse, expected) = (square(&l, n), invert(&l, n), sums(&l, n));
        for k in below(n) {
            let (i, j) = (k % n, k / n);
            assert!((a[k] - expected[k]).abs() < 1e-13 && a[i * n + j] == a[k], "n = {n}");
            let entry: f64 = (0..n).map(|k| a[k * n + i] * inverse[j * n + k]).sum();
            let of_identity = if i == j { 1.0 } else { 0.0 };
            assert!((entry - of_identity).abs() < 1e-12 && inverse[i * n + j] == inverse[k], "n = {n}");
        }
    }
    assert!(square(&[], 0).is_empty() && invert(&[], 0).is_empty());
}

#[test]
fn energies_are_products_with_the_square() {
    for (n, count) in [(1, 1), (5, 0), (17, 3), (65, 40), (200, 7)] {
        let l = lower(n);
        let a = nalgebra::DMatrix::from_vec(n, n, square(&l, n));
        let columns: Vec<f64> = (0..n * count).map(|k| value(k, 5)).collect();
        let v = nalgebra::DMatrix::from_vec(n, count, columns.clone());
        let expected = v.transpose() * a * v;
        let found = nalgebra::DMatrix::from_vec(count, count, energies(&l, n, &columns));
        assert!((found - &expected).amax() <= 1e-12 * expected.amax(), "{n}, {count}");
    }
}

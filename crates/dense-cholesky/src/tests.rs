use super::*;

/// Sizes around those of groups, pieces and blocks, and one that is shared out to threads.
const SIZES: [usize; 13] = [1, 2, 3, 5, 8, 16, 17, 31, 48, 49, 97, 200, 700];

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
fn square(l: &[f64], n: usize) -> Vec<f64> {
    let entry = |i: usize, j: usize| {
        if i < j { f64::NAN } else { (0..=j).map(|k| l[k * n + i] * l[k * n + j]).sum() }
    };
    (0..n * n).map(|k| entry(k % n, k / n)).collect()
}

fn below(n: usize) -> impl Iterator<Item = usize> {
    (0..n).flat_map(move |j| (j..n).map(move |i| j * n + i))
}

#[test]
fn a_factor_is_found_again_from_its_square() {
    for n in SIZES {
        let l = lower(n);
        let mut a = square(&l, n);
        factorise(&mut a, n).unwrap();
        for k in below(n) {
            assert!((a[k] - l[k]).abs() < 1e-13, "n = {n}, entry {k}: {} against {}", a[k], l[k]);
        }
    }
}

#[test]
fn a_front_and_what_it_passes_on_are_parts_of_the_whole() {
    for (n, width) in [(5, 2), (40, 17), (130, 33), (300, 100), (900, 300)] {
        let a = square(&lower(n), n);
        let mut whole = a.clone();
        factorise(&mut whole, n).unwrap();
        let mut panel = a[..width * n].to_vec();
        factorise(&mut panel, n).unwrap();
        for k in below(n).filter(|k| *k < width * n) {
            assert!((panel[k] - whole[k]).abs() < 1e-13, "n = {n}, width {width}");
        }
        let b = n - width;
        let mut update = vec![f64::NAN; b * b];
        add_square(-1.0, (&panel[width..], n), [b, width], 0.0, (&mut update, b), b);
        let mut rest: Vec<f64> =
            (0..b * b).map(|k| update[k] + a[(width + k / b) * n + width + k % b]).collect();
        factorise(&mut rest, b).unwrap();
        for k in below(b) {
            let expected = whole[(width + k / b) * n + width + k % b];
            assert!((rest[k] - expected).abs() < 1e-12, "n = {n}, width {width}");
        }
    }
}

#[test]
fn the_first_pivot_that_is_not_positive_is_named() {
    for n in [1, 4, 16, 37, 120] {
        for bad in [0, n / 2, n - 1] {
            for pivot in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
                let mut a = square(&lower(n), n);
                a[bad * n + bad] = pivot;
                assert_eq!(
                    factorise(&mut a, n),
                    Err(NotPositiveDefinite { column: bad }),
                    "n = {n}, {pivot}"
                );
            }
        }
    }
    assert_eq!(factorise(&mut [], 0), Ok(()));
}

#[test]
fn solutions_satisfy_their_systems() {
    for n in SIZES {
        let l = lower(n);
        for count in [1, 3, 4, 19, 52] {
            let x: Vec<f64> = (0..n * count).map(|k| value(k, 3)).collect();
            let mut forwards = x.clone();
            forward(&l, n, &mut forwards);
            let mut backwards = x.clone();
            backward(&l, n, &mut backwards);
            for c in 0..count {
                let column = c * n..(c + 1) * n;
                let (y, z, x) = (&forwards[column.clone()], &backwards[column.clone()], &x[column]);
                for i in 0..n {
                    let of_l: f64 = (0..=i).map(|k| l[k * n + i] * y[k]).sum();
                    let of_transpose: f64 = (i..n).map(|k| l[i * n + k] * z[k]).sum();
                    assert!((of_l - x[i]).abs() < 1e-13 && (of_transpose - x[i]).abs() < 1e-13, "n = {n}");
                }
            }
        }
    }
}

#[test]
fn an_inverse_times_its_matrix_is_the_identity() {
    for n in SIZES {
        let mut l = lower(n);
        let inverse = invert(&l, n);
        (0..n).for_each(|j| l[j * n..j * n + j].fill(0.0));
        let a = square_of_triangle(&l, n, Triangle::Lower);
        let expected = square(&l, n);
        for k in below(n) {
            let (i, j) = (k % n, k / n);
            assert!((a[k] - expected[k]).abs() < 1e-13 && a[i * n + j] == a[k], "n = {n}");
            let entry: f64 = (0..n).map(|m| a[m * n + i] * inverse[j * n + m]).sum();
            let of_identity = if i == j { 1.0 } else { 0.0 };
            assert!(
                (entry - of_identity).abs() < 1e-12 && inverse[i * n + j] == inverse[k],
                "n = {n}: {entry}"
            );
        }
    }
}

#[test]
fn products_with_vectors_are_sums_of_columns() {
    for (n, m) in [(0, 3), (3, 0), (1, 1), (7, 5), (64, 33)] {
        let a: Vec<f64> = (0..n * m).map(|k| value(k, 1)).collect();
        let x: Vec<f64> = (0..m).map(|k| value(k, 2)).collect();
        let mut y = vec![f64::NAN; n];
        multiply(&a, &x, &mut y);
        for i in 0..n {
            let sum: f64 = (0..m).map(|j| a[j * n + i] * x[j]).sum();
            assert!((y[i] - sum).abs() < 1e-13);
        }
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let n = 1500;
    let a = square(&lower(n), n);
    let factors = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut factor = a.clone();
        pool.install(|| factorise(&mut factor, n)).unwrap();
        let mut x = a[..100 * n].to_vec();
        x.iter_mut().filter(|x| x.is_nan()).for_each(|x| *x = 1.0);
        pool.install(|| backward(&factor, n, &mut x));
        let inverse = pool.install(|| invert(&factor, n));
        below(n).map(|k| factor[k]).chain(x).chain(inverse).map(f64::to_bits).collect::<Vec<_>>()
    });
    assert!(factors[0] == factors[1]);
}

#[test]
fn products_without_columns_are_zero() {
    let n = 300;
    let mut c = vec![1.0; n * n];
    add_square(1.0, (&[], n), [n, 0], 0.0, (&mut c, n), n);
    assert!((0..n).all(|j| c[j * n + j..(j + 1) * n].iter().all(|x| *x == 0.0)));
}

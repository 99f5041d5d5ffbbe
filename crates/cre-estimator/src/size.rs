//! The size of fields, and what is round-off compared with it.

use fem_core::geometry::{Coordinates, norm};
use fem_core::parallel::each_task;

/// Penetration, negative pressure and displaced supports up to this, relative, are round-off.
pub const SIGN_TOLERANCE: f64 = 1e-12;

/// The larger number, or NaN if one of them is NaN, so that it is not lost.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// Computes the largest displacement, m: by squares, which are cheap, unless they underflow or overflow.
pub(crate) fn largest_displacement<V: Coordinates>(displacement: &[V]) -> f64 {
    let square = largest_of(displacement.len(), |n| displacement[n].times(&displacement[n]));
    if square.is_normal() { square.sqrt() } else { largest_of(displacement.len(), |n| norm(displacement[n])) }
}

/// Computes the square of the length of a vector.
pub(crate) fn square<V: Coordinates>(a: V) -> f64 {
    a.times(&a)
}

/// Computes the length of a vector by its square: the guard of `hypot` against overflow costs more than what it is used for.
pub(crate) fn length<V: Coordinates>(a: V) -> f64 {
    square(a).sqrt()
}

/// Indices of [`largest_of`] in one task.
const CHUNK: usize = 4096;

/// Finds the largest of some numbers that are not negative, in parallel; NaN if one of them is.
pub(crate) fn largest_of(count: usize, number: impl Fn(usize) -> f64 + Sync) -> f64 {
    let of_chunk = |k: usize| (k * CHUNK..count.min((k + 1) * CHUNK)).map(&number).fold(0.0, larger);
    each_task(count.div_ceil(CHUNK), of_chunk).into_iter().fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::geometry::Vector;

    #[test]
    fn the_largest_displacement_is_found_at_any_size() {
        for size in [1e-200, 1e-160, 1.0, 1e160, 1e200] {
            let field = [Vector::zeros(), size * Vector::new(3.0, -4.0), size * Vector::new(1.0, 2.0)];
            assert!((largest_displacement(&field) / size - 5.0).abs() < 1e-14, "{size}");
        }
        assert_eq!(largest_displacement(&[Vector::zeros()]), 0.0);
        assert!(largest_displacement(&[Vector::x(), Vector::new(0.0, f64::NAN), Vector::y()]).is_nan());
    }
}

//! All bodies at the same time.

use rayon::prelude::*;

/// Computes something of each body, in parallel. The result does not depend on the number of threads if `of_body` does
/// not.
///
/// * `bodies`: how many there are.
pub fn each_body<T: Send>(bodies: usize, of_body: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..bodies).into_par_iter().with_max_len(1).map(of_body).collect()
}

/// [`each_body`] for something that can fail: the error of the first body that has one.
///
/// # Errors
/// Those of `of_body`.
pub fn try_each_body<T: Send, E: Send>(
    bodies: usize,
    of_body: impl Fn(usize) -> Result<T, E> + Sync + Send,
) -> Result<Vec<T>, E> {
    each_body(bodies, of_body).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::{each_body, try_each_body};

    #[test]
    fn results_are_in_the_order_of_the_bodies() {
        assert_eq!(each_body(3, |b| 10 * b), [0, 10, 20]);
        assert_eq!(try_each_body(2, Err::<(), usize>), Err(0));
        assert_eq!(try_each_body(2, |b| if b == 1 { Err(b) } else { Ok(b) }), Err(1));
    }
}

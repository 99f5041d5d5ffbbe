//! The two bodies at the same time.

/// Computes something of each body, in parallel. The result does not depend on the number of threads if `of_body` does
/// not.
pub fn each_body<T: Send>(of_body: impl Fn(usize) -> T + Sync) -> [T; 2] {
    let (first, second) = rayon::join(|| of_body(0), || of_body(1));
    [first, second]
}

/// [`each_body`] for something that can fail: the error of the first body that has one.
///
/// # Errors
/// Those of `of_body`.
pub fn try_each_body<T: Send, E: Send>(of_body: impl Fn(usize) -> Result<T, E> + Sync) -> Result<[T; 2], E> {
    let [first, second] = each_body(of_body);
    Ok([first?, second?])
}

#[cfg(test)]
mod tests {
    use super::{each_body, try_each_body};

    #[test]
    fn results_are_in_the_order_of_the_bodies() {
        assert_eq!(each_body(|b| 10 * b), [0, 10]);
        assert_eq!(try_each_body(Err::<(), usize>), Err(0));
        assert_eq!(try_each_body(|b| if b == 1 { Err(b) } else { Ok(b) }), Err(1));
    }
}

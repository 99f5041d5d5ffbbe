//! Tasks in parallel. The loops of rayon are compiled here once, not again for every closure in the crates above.

use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Runs `task(k)` for every `k` below `tasks`, in parallel.
pub fn for_each_task(tasks: usize, task: &(dyn Fn(usize) + Sync)) {
    (0..tasks).into_par_iter().with_max_len(1).for_each(task);
}

/// Computes something in each task, in parallel. The result does not depend on the number of threads if `of_task` does
/// not.
///
/// * `tasks`: how many there are; each should have much to do.
pub fn each_task<T: Send>(tasks: usize, of_task: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let results: Vec<Mutex<Option<T>>> = (0..tasks).map(|_| Mutex::new(None)).collect();
    for_each_task(tasks, &|k| {
        let result = of_task(k);
        *results[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    results
        .into_iter()
        .filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner))
        .collect()
}

/// Computes something of each body, in parallel: see [`each_task`].
///
/// * `bodies`: how many there are.
pub fn each_body<T: Send>(bodies: usize, of_body: impl Fn(usize) -> T + Sync) -> Vec<T> {
    each_task(bodies, of_body)
}

/// [`each_body`] for something that can fail: the error of the first body that has one.
///
/// # Errors
/// Those of `of_body`.
pub fn try_each_body<T: Send, E: Send>(
    bodies: usize,
    of_body: impl Fn(usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    each_task(bodies, of_body).into_iter().collect()
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

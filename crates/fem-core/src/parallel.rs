//! Tasks in parallel. Their loop is compiled once, here, and not again for every closure.

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
    let result = |(k, result): (usize, Mutex<Option<T>>)| match result.into_inner() {
        Ok(Some(result)) => result,
        // A task that panics has ended the loop above.
        _ => unreachable!("task {k} has no result"),
    };
    results.into_iter().enumerate().map(result).collect()
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
    use super::{each_body, each_task, try_each_body};

    #[test]
    fn any_number_of_tasks_may_run() {
        assert_eq!(each_task(0, |k| k), []);
        assert!(each_task(1000, |k| 2 * k).into_iter().enumerate().all(|(k, twice)| twice == 2 * k));
    }

    #[test]
    fn results_are_in_the_order_of_the_bodies() {
        assert_eq!(each_body(3, |b| 10 * b), [0, 10, 20]);
        assert_eq!(try_each_body(2, Err::<(), usize>), Err(0));
        assert_eq!(try_each_body(2, |b| if b == 1 { Err(b) } else { Ok(b) }), Err(1));
    }
}

//! The peaks of the machine: products of dense matrices, passes over memory, and files.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::ThreadPool;
use rayon::prelude::*;
use serde_json::json;
use std::hint::black_box;
use std::time::Instant;

/// Rows and columns of the matrices.
const SIZE: usize = 1000;
/// Entries of each of the three arrays: 512 MiB, more than a cache holds.
const ENTRIES: usize = 64 << 20;
/// Bytes of a file.
const FILE: usize = 256 << 20;
/// The fastest of this many repetitions is the peak.
const REPETITIONS: usize = 12;

/// Prints the peaks with all threads of a pool at work.
pub(crate) fn measure(pool: &ThreadPool) {
    let threads = pool.current_num_threads();
    let (flops, bytes) = (multiplication(pool), streaming(pool));
    println!(
        "{}",
        json!({ "kind": "peak", "threads": threads, "flops": flops, "bytes": bytes, "written": writing() })
    );
}

fn fastest(mut run: impl FnMut()) -> f64 {
    let times = (0..REPETITIONS).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Measures operations per second of `C ← A B + C`, each thread with matrices of its own.
fn multiplication(pool: &ThreadPool) -> f64 {
    let threads = pool.current_num_threads();
    let matrix = |seed: f64| Mat::from_fn(SIZE, SIZE, |i, j| (seed + i as f64 + 0.7 * j as f64).sin());
    let mut all: Vec<[Mat<f64>; 3]> =
        (0..threads).map(|k| [0.0, 1.0, 2.0].map(|s| matrix(s + k as f64))).collect();
    let seconds = fastest(|| {
        pool.broadcast(|_| ());
        pool.install(|| {
            let multiply =
                |[a, b, c]: &mut [Mat<f64>; 3]| matmul(black_box(c), Accum::Add, &*a, &*b, 1.0, Par::Seq);
            all.par_iter_mut().with_max_len(1).for_each(multiply);
        });
    });
    threads as f64 * 2.0 * (SIZE as f64).powi(3) / seconds
}

/// Measures bytes per second of `a = b + s c`, 24 per entry: what is read to make room for what is written is not counted.
fn streaming(pool: &ThreadPool) -> f64 {
    let [mut a, b, c] = [0.0, 1.0, 2.0].map(|value| vec![value; ENTRIES]);
    let piece = ENTRIES / pool.current_num_threads();
    let seconds = fastest(|| {
        pool.install(|| {
            let pieces = a.par_chunks_mut(piece).zip(b.par_chunks(piece)).zip(c.par_chunks(piece));
            pieces.for_each(|((a, b), c)| {
                for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                    *a = b + 0.5 * c;
                }
            });
        });
        black_box(&mut a);
    });
    24.0 * ENTRIES as f64 / seconds
}

/// Measures bytes per second of a file that is written again each time, by one thread, without waiting for the disk.
fn writing() -> f64 {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let (path, content) = (folder.path().join("file"), vec![1u8; FILE]);
    let seconds = fastest(|| std::fs::write(&path, &content).unwrap());
    FILE as f64 / seconds
}

//! A vector whose entries several threads write at the same time, each its own.

use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Entries handled by one task.
const CHUNK: usize = 4096;

/// Sums of a scalar product that are added up side by side.
const SUMS: usize = 8;

/// A vector of numbers that can be written through a shared reference.
///
/// The stars of one colour write scattered entries, and no two write the same one. Relaxed atomic loads and stores are
/// plain loads and stores on the machine and make that safe without a copy.
pub(crate) struct AtomicSlots(Vec<AtomicU64>);

impl AtomicSlots {
    /// Creates a vector of zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        Self((0..len).into_par_iter().with_min_len(CHUNK).map(|_| AtomicU64::new(0)).collect())
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    pub(crate) fn get(&self, i: usize) -> f64 {
        f64::from_bits(self.0[i].load(Relaxed))
    }

    /// Returns three entries from `first` on.
    #[inline(always)]
    pub(crate) fn three(&self, first: usize) -> [f64; 3] {
        let [a, b, c] = &self.0[first..][..3] else { return [f64::NAN; 3] };
        [a, b, c].map(|x| f64::from_bits(x.load(Relaxed)))
    }

    /// Overwrites three entries from `first` on.
    #[inline(always)]
    pub(crate) fn set_three(&self, first: usize, values: [f64; 3]) {
        self.0[first..][..3].iter().zip(values).for_each(|(x, value)| x.store(value.to_bits(), Relaxed));
    }

    pub(crate) fn set(&self, i: usize, value: f64) {
        self.0[i].store(value.to_bits(), Relaxed);
    }

    /// Replaces every entry `x` by `f(i, x)`.
    pub(crate) fn update(&self, f: impl Fn(usize, f64) -> f64 + Sync) {
        self.0.par_iter().enumerate().with_min_len(CHUNK).for_each(|(i, x)| {
            x.store(f(i, f64::from_bits(x.load(Relaxed))).to_bits(), Relaxed);
        });
    }

    /// Replaces every entry `x` by `f(x, y)`, with the entry `y` of another vector. Plain memory, unlike [`Self::update`], so that
    /// several entries are computed at once.
    pub(crate) fn combine(&mut self, other: &mut Self, f: impl Fn(f64, f64) -> f64 + Sync) {
        let chunks = self.0.par_chunks_mut(CHUNK).zip(other.0.par_chunks_mut(CHUNK));
        chunks.for_each(|(own, other)| {
            for (x, y) in own.iter_mut().zip(other) {
                let value = f(f64::from_bits(*x.get_mut()), f64::from_bits(*y.get_mut()));
                *x.get_mut() = value.to_bits();
            }
        });
    }

    /// Computes the scalar product, in an order that does not depend on the number of threads.
    pub(crate) fn dot(&mut self, other: &mut Self) -> f64 {
        let chunks = self.0.par_chunks_mut(CHUNK).zip(other.0.par_chunks_mut(CHUNK));
        let product = |(x, y): (&mut AtomicU64, &mut AtomicU64)| {
            f64::from_bits(*x.get_mut()) * f64::from_bits(*y.get_mut())
        };
        let of_chunk = |(own, other): (&mut [AtomicU64], &mut [AtomicU64])| -> f64 {
            let mut sums = [0.0; SUMS];
            let pairs = own.chunks_exact_mut(SUMS).zip(other.chunks_exact_mut(SUMS));
            for (own, other) in pairs {
                for (sum, pair) in sums.iter_mut().zip(own.iter_mut().zip(other)) {
                    *sum += product(pair);
                }
            }
            let rest = own.chunks_exact_mut(SUMS).into_remainder().iter_mut();
            let others = other.chunks_exact_mut(SUMS).into_remainder();
            sums.iter().sum::<f64>() + rest.zip(others).map(product).sum::<f64>()
        };
        let sums: Vec<f64> = chunks.map(of_chunk).collect();
        sums.iter().sum()
    }
}

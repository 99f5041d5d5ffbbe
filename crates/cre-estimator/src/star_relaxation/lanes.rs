//! Several numbers side by side: what is done to one triangle or star is done to a few at a time, in the processor's
//! vectors.

/// How many.
pub(super) const LANES: usize = 8;

/// One number of each.
pub(super) type Lanes = [f64; LANES];

pub(super) const ZERO: Lanes = [0.0; LANES];

/// Computes `a − b c`.
#[inline(always)]
pub(super) fn minus(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    std::array::from_fn(|l| a[l] - b[l] * c[l])
}

/// Computes `a b`.
#[inline(always)]
pub(super) fn times(a: Lanes, b: Lanes) -> Lanes {
    std::array::from_fn(|l| a[l] * b[l])
}

//! Several numbers side by side: a few triangles or stars are processed at a time in the processor's vectors.

/// Number of lanes.
pub(super) const LANES: usize = 8;

/// One number per lane.
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

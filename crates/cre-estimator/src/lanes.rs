//! Several triangles side by side, one in each lane of the processor's vectors.

use pulp::Simd;
use std::ops::{Add, AddAssign, Mul, Sub};

/// No processor has more lanes.
pub(crate) const MOST_LANES: usize = 8;

/// One number per triangle, as it is gathered from a mesh; only the lanes that the processor has are used.
pub(crate) type LaneRow = [f64; MOST_LANES];

/// One number per lane. Every lane computes what it would alone, so results do not depend on the number of lanes; a processor that cannot
/// fuse products and sums rounds differently.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    numbers: S::f64s,
}

/// A vector per lane.
pub(crate) type Pair<S> = [Lanes<S>; 2];

/// A symmetric tensor per lane: xx, yy, xy.
pub(crate) type Tensor<S> = [Lanes<S>; 3];

impl<S: Simd> Lanes<S> {
    /// Puts the same number into every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, x: f64) -> Self {
        Self { simd, numbers: simd.splat_f64s(x) }
    }

    #[inline(always)]
    pub(crate) fn load(simd: S, row: &LaneRow) -> Self {
        Self::load_part(simd, row, 0)
    }

    #[inline(always)]
    pub(crate) fn store(self, row: &mut LaneRow) {
        self.store_part(row, 0);
    }

    /// Loads the numbers of the group `part` of lanes.
    #[inline(always)]
    pub(crate) fn load_part(simd: S, row: &LaneRow, part: usize) -> Self {
        const { assert!(MOST_LANES.is_multiple_of(S::F64_LANES)) }
        Self { simd, numbers: S::as_simd_f64s(row).0[part] }
    }

    /// Loads numbers in single precision.
    #[inline(always)]
    pub(crate) fn load_single(simd: S, row: &[f32; MOST_LANES], part: usize) -> Self {
        let mut numbers = LaneRow::default();
        for (x, single) in numbers.iter_mut().zip(&row[part * S::F64_LANES..][..S::F64_LANES]) {
            *x = f64::from(*single);
        }
        Self::load(simd, &numbers)
    }

    #[inline(always)]
    pub(crate) fn store_part(self, row: &mut LaneRow, part: usize) {
        S::as_mut_simd_f64s(row).0[part] = self.numbers;
    }

    /// Returns the larger one of two numbers, either one if one of them is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self { simd: self.simd, numbers: self.simd.max_f64s(self.numbers, other.numbers) }
    }

    /// Computes `self + a b`, with one rounding if the processor can.
    #[inline(always)]
    pub(crate) fn plus(self, a: Self, b: Self) -> Self {
        Self { simd: self.simd, numbers: self.simd.mul_add_e_f64s(a.numbers, b.numbers, self.numbers) }
    }

    /// Computes `self + a b` for the same `a` in every lane.
    #[inline(always)]
    pub(crate) fn plus_times(self, a: f64, b: Self) -> Self {
        self.plus(Self::splat(self.simd, a), b)
    }

    /// Divides.
    #[inline(always)]
    pub(crate) fn over(self, other: Self) -> Self {
        Self { simd: self.simd, numbers: self.simd.div_f64s(self.numbers, other.numbers) }
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { simd: self.simd, numbers: self.simd.add_f64s(self.numbers, other.numbers) }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { simd: self.simd, numbers: self.simd.sub_f64s(self.numbers, other.numbers) }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { simd: self.simd, numbers: self.simd.mul_f64s(self.numbers, other.numbers) }
    }
}

impl<S: Simd> Mul<Lanes<S>> for f64 {
    type Output = Lanes<S>;

    #[inline(always)]
    fn mul(self, other: Lanes<S>) -> Lanes<S> {
        Lanes::splat(other.simd, self) * other
    }
}

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Loads a vector.
#[inline(always)]
pub(crate) fn load_pair<S: Simd>(simd: S, rows: &[LaneRow; 2]) -> Pair<S> {
    [Lanes::load(simd, &rows[0]), Lanes::load(simd, &rows[1])]
}

/// Computes `a · b`.
#[inline(always)]
pub(crate) fn dot<S: Simd>(a: Pair<S>, b: Pair<S>) -> Lanes<S> {
    (a[0] * b[0]).plus(a[1], b[1])
}

/// Computes `a − b`.
#[inline(always)]
pub(crate) fn less<S: Simd>(a: Pair<S>, b: Pair<S>) -> Pair<S> {
    [a[0] - b[0], a[1] - b[1]]
}

/// Computes `a × b`.
#[inline(always)]
pub(crate) fn cross<S: Simd>(a: Pair<S>, b: Pair<S>) -> Lanes<S> {
    a[0] * b[1] - a[1] * b[0]
}

/// Applies a symmetric tensor to a vector.
#[inline(always)]
pub(crate) fn apply<S: Simd>(t: Tensor<S>, n: Pair<S>) -> Pair<S> {
    [(t[0] * n[0]).plus(t[2], n[1]), (t[2] * n[0]).plus(t[1], n[1])]
}

/// Computes `s : t`.
#[inline(always)]
pub(crate) fn contract<S: Simd>(s: Tensor<S>, t: Tensor<S>) -> Lanes<S> {
    (s[0] * t[0]).plus(s[1], t[1]).plus(2.0 * s[2], t[2])
}

/// Turns by −90 degrees: the outward normal of a side, times its length, from its direction.
#[inline(always)]
pub(crate) fn turned<S: Simd>(simd: S, a: Pair<S>) -> Pair<S> {
    [a[1], Lanes::splat(simd, 0.0) - a[0]]
}

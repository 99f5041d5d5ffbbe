//! Double-double numbers: unevaluated sums of two `f64`, about 32 digits.
//!
//! A residual is a small difference of large terms. In double precision it is as large as its own rounding; here it has
//! correct digits. Error-free sums and products after Knuth and Dekker (Muller et al. 2018).

use crate::space::{Plane, Space};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// The unevaluated sum `high + low`, with `|low| ≤ ½ ulp(high)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    /// The number rounded to double precision.
    pub high: f64,
    /// The rounding error of `high`.
    pub low: f64,
}

/// A vector in double-double numbers.
pub type PreciseVector<S = Plane> = <S as Space>::Axes<DoubleDouble>;

impl DoubleDouble {
    /// Zero.
    pub const ZERO: Self = Self { high: 0.0, low: 0.0 };

    /// Computes `a + b` without error.
    #[inline(always)]
    pub fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let share = high - a;
        Self { high, low: (a - (high - share)) + (b - share) }
    }

    /// Computes `a − b` without error.
    #[inline(always)]
    pub fn difference(a: f64, b: f64) -> Self {
        Self::sum(a, -b)
    }

    /// Computes `a b` without error, unless it underflows.
    #[inline(always)]
    pub fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self { high, low: a.mul_add(b, -high) }
    }

    /// Joins two parts of which the first is the larger one.
    #[inline(always)]
    fn joined(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }

    /// Computes the square root; zero for a number that is not positive.
    pub fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        if !(root > 0.0) {
            return Self::ZERO;
        }
        let rest = self - Self::product(root, root);
        Self::joined(root, rest.high / (2.0 * root))
    }

    /// Rounds to double precision.
    #[inline(always)]
    pub fn rounded(self) -> f64 {
        self.high + self.low
    }
}

impl From<f64> for DoubleDouble {
    #[inline(always)]
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // Both parts are added without error: terms of opposite sign may cancel.
        let (high, low) = (Self::sum(self.high, other.high), Self::sum(self.low, other.low));
        let part = Self::joined(high.high, high.low + low.high);
        Self::joined(part.high, part.low + low.low)
    }
}

impl AddAssign for DoubleDouble {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Add<f64> for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        let sum = Self::sum(self.high, other);
        Self::joined(sum.high, sum.low + self.low)
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let p = Self::product(self.high, other.high);
        Self::joined(p.high, p.low + (self.high * other.low + self.low * other.high))
    }
}

impl Mul<f64> for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        let p = Self::product(self.high, other);
        Self::joined(p.high, p.low + self.low * other)
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let quotient = self.high / other.high;
        let rest = self - other * quotient;
        Self::joined(quotient, rest.high / other.high)
    }
}

#[cfg(test)]
mod tests {
    use super::DoubleDouble as D;

    #[test]
    fn sums_and_products_keep_what_rounding_loses() {
        let tiny = 2f64.powi(-70);
        let sum = D::sum(1.0, tiny);
        assert_eq!((sum.high, sum.low), (1.0, tiny));
        assert_eq!((sum - D::from(1.0)).rounded(), tiny);
        let a = 1.0 + 2f64.powi(-40);
        // (1 + ε)² = 1 + 2ε + ε²
        let square = D::product(a, a) - D::from(1.0) - D::from(2f64.powi(-39));
        assert_eq!(square.rounded(), 2f64.powi(-80));
        // Opposite parts cancel except for their difference.
        assert_eq!((D::sum(1e30, 3.0) - D::sum(1e30, 1.0)).rounded(), 2.0);
    }

    #[test]
    fn quotients_and_roots_have_thirty_digits() {
        let third = D::from(1.0) / D::from(3.0);
        assert!((third * 3.0 - D::from(1.0)).rounded().abs() < 1e-31);
        let root = D::from(2.0).sqrt();
        assert!((root * root - D::from(2.0)).rounded().abs() < 1e-31);
        assert_eq!(D::from(0.0).sqrt(), D::ZERO);
    }
}

//! Points and vectors of any space.

use nalgebra::{Vector2, Vector3};
use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

/// A vector: Cartesian components, sums, multiples.
pub trait Coordinates:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Default
    + Index<usize, Output = f64>
    + IndexMut<usize>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign<f64>
    + Sum
{
    /// The vector zero.
    const ZERO: Self;

    /// Makes a vector of its components.
    fn of(component: impl FnMut(usize) -> f64) -> Self;
    /// Returns the components.
    fn entries(&self) -> &[f64];
    /// Computes the product `a·b`.
    fn times(&self, other: &Self) -> f64;
    /// Computes the length without undue overflow.
    fn length(&self) -> f64;

    /// Returns the largest component in magnitude.
    fn largest(&self) -> f64 {
        self.entries().iter().fold(0.0, |most, x| x.abs().max(most))
    }

    /// Tells whether all components are finite.
    fn is_finite(&self) -> bool {
        self.entries().iter().all(|x| x.is_finite())
    }
}

impl Coordinates for Vector2<f64> {
    const ZERO: Self = Self::new(0.0, 0.0);

    #[inline(always)]
    fn of(mut component: impl FnMut(usize) -> f64) -> Self {
        let x = component(0);
        Self::new(x, component(1))
    }

    #[inline(always)]
    fn entries(&self) -> &[f64] {
        self.as_slice()
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> f64 {
        self.dot(other)
    }

    #[inline(always)]
    fn length(&self) -> f64 {
        self[0].hypot(self[1])
    }
}

impl Coordinates for Vector3<f64> {
    const ZERO: Self = Self::new(0.0, 0.0, 0.0);

    #[inline(always)]
    fn of(mut component: impl FnMut(usize) -> f64) -> Self {
        let (x, y) = (component(0), component(1));
        Self::new(x, y, component(2))
    }

    #[inline(always)]
    fn entries(&self) -> &[f64] {
        self.as_slice()
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> f64 {
        self.dot(other)
    }

    #[inline(always)]
    fn length(&self) -> f64 {
        self[0].hypot(self[1]).hypot(self[2])
    }
}

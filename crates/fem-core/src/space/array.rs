//! Arrays whose length is a matter of the space.

use std::fmt::Debug;
use std::ops::{Add, Index, IndexMut, Mul, Neg, Sub};

/// A value that is copied.
pub trait Item: Copy + Debug + PartialEq + Send + Sync + 'static {}

impl<T: Copy + Debug + PartialEq + Send + Sync + 'static> Item for T {}

/// A value with which one computes: an `f64`, or one with more digits.
pub trait Number:
    Item + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
}

impl<T: Item + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Neg<Output = T>> Number for T {}

/// An array `[T; N]`.
pub trait Array<T>:
    Clone
    + Debug
    + Send
    + Sync
    + AsRef<[T]>
    + AsMut<[T]>
    + Index<usize, Output = T>
    + IndexMut<usize>
    + IntoIterator<Item = T>
{
}

impl<T: Clone + Debug + Send + Sync, const N: usize> Array<T> for [T; N] {}

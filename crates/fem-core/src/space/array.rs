//! Arrays whose length is a matter of the space.

use std::fmt::Debug;
use std::ops::{Index, IndexMut};

/// A value that is copied.
pub trait Item: Copy + Debug + PartialEq + Send + Sync + 'static {}

impl<T: Copy + Debug + PartialEq + Send + Sync + 'static> Item for T {}

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

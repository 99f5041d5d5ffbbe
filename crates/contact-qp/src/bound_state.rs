//! The state of an unknown with two bounds.

/// The state of an unknown with two bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BoundState {
    /// At its lower bound.
    Lower,
    /// Between its bounds.
    Free,
    /// At its upper bound.
    Upper,
}

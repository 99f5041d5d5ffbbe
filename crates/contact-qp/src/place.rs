//! Where an unknown with two bounds is.

/// Where an unknown is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// At its lower bound.
    Lower,
    /// Between its bounds.
    Free,
    /// At its upper bound.
    Upper,
}

//! The set of bounds that hold with equality.

/// The bounds that hold with equality: one flag per bounded index, in the order of `bounded`.
///
/// In contact mechanics: the pairs in contact.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct ActiveSet {
    flags: Vec<bool>,
}

impl ActiveSet {
    /// Wraps one flag per bounded index (`true`: the bound holds with equality).
    #[must_use]
    pub fn new(flags: Vec<bool>) -> Self {
        Self { flags }
    }

    /// Creates the set of `len` inactive bounds.
    #[must_use]
    pub fn none(len: usize) -> Self {
        Self::new(vec![false; len])
    }

    /// Creates the set of `len` active bounds.
    #[must_use]
    pub fn all(len: usize) -> Self {
        Self::new(vec![true; len])
    }

    /// Tells whether the bound at place `k` of `bounded` is active; `false` beyond the end.
    #[must_use]
    pub fn is_active(&self, k: usize) -> bool {
        self.flags.get(k).copied().unwrap_or(false)
    }

    /// Counts the active bounds.
    #[must_use]
    pub fn count(&self) -> usize {
        self.flags.iter().filter(|&&flag| flag).count()
    }

    /// Returns the number of bounds, active or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.flags.len()
    }

    /// Tells whether there are no bounds.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.flags.is_empty()
    }

    /// Returns the flags.
    #[must_use]
    pub fn as_slice(&self) -> &[bool] {
        &self.flags
    }

    /// Moves the bound at place `k` into the set, or out of it.
    pub(crate) fn flip(&mut self, k: usize) {
        self.flags[k] = !self.flags[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_flips() {
        let mut set = ActiveSet::new(vec![true, false, true]);
        assert_eq!((set.count(), set.len(), set.is_empty()), (2, 3, false));
        set.flip(0);
        assert_eq!(set.as_slice(), [false, false, true]);
        assert!(set.is_active(2) && !set.is_active(0) && !set.is_active(3));
        assert_eq!(ActiveSet::none(2).count(), 0);
        assert_eq!(ActiveSet::all(2).count(), 2);
        assert!(ActiveSet::default().is_empty());
    }
}

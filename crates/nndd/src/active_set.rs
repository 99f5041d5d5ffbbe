//! The pairs of nodes in contact.

/// The pairs of nodes in contact: one flag per pair of nodes, pair after pair.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct ActiveSet {
    flags: Vec<bool>,
}

impl ActiveSet {
    /// Wraps one flag per pair of nodes (`true`: in contact).
    #[must_use]
    pub fn new(flags: Vec<bool>) -> Self {
        Self { flags }
    }

    /// Tells whether the pair of nodes `k` is in contact; `false` beyond the end.
    #[must_use]
    pub fn is_active(&self, k: usize) -> bool {
        self.flags.get(k).copied().unwrap_or(false)
    }

    /// Counts the pairs of nodes in contact.
    #[must_use]
    pub fn count(&self) -> usize {
        self.flags.iter().filter(|&&flag| flag).count()
    }

    /// Returns the number of pairs of nodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.flags.len()
    }

    /// Tells whether there is no pair of nodes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.flags.is_empty()
    }

    /// Returns the flags.
    #[must_use]
    pub fn as_slice(&self) -> &[bool] {
        &self.flags
    }
}

//! Names of pairs and paths.

use super::body::file_stem;
use crate::case_file::Reader;
use crate::diagnostic::excerpt;
use std::collections::{HashMap, HashSet};

/// Bytes of a name that names files too, at most.
pub(super) const LONGEST_NAME: usize = 100;

/// Names that name files too, as their stems.
#[derive(Default)]
pub(super) struct Names {
    stems: HashSet<String>,
    /// The number that is tried next for a name without one.
    next: HashMap<String, usize>,
}

impl Names {
    fn stem(name: &str) -> String {
        file_stem(name).to_lowercase()
    }

    fn has(&self, name: &str) -> bool {
        self.stems.contains(&Self::stem(name))
    }

    pub(super) fn take(&mut self, name: &str) {
        self.stems.insert(Self::stem(name));
    }

    /// Refuses a name that is empty, long, or that another has.
    ///
    /// * `what`: the word for what it names.
    pub(super) fn check(&self, r: &Reader<'_>, name: &str, what: &str, fix: &str) {
        if name.trim().is_empty() || name.len() > LONGEST_NAME || self.has(name) {
            let message = format!("{} cannot name this {what}", excerpt(name));
            let expected = format!(
                "a name of at most 100 bytes that no other {what} has, not only in case, blanks or signs"
            );
            r.refuse("name", message, &expected, fix);
        }
    }

    /// Adds the first number to a name that makes it free.
    pub(super) fn free(&mut self, name: String) -> String {
        if !self.has(&name) {
            return name;
        }
        let mut number = self.next.get(&name).copied().unwrap_or(2);
        while self.has(&format!("{name}-{number}")) {
            number += 1;
        }
        let free = format!("{name}-{number}");
        self.next.insert(name, number + 1);
        free
    }
}

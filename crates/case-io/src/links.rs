//! Symbolic links whose target is missing: the system's own words for them mislead.

use std::fmt;
use std::path::{Path, PathBuf};

/// A symbolic link that leads nowhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokenLink {
    /// The link: a path, or one of the directories above it.
    pub link: PathBuf,
    /// What it points to, as the link has it.
    pub target: PathBuf,
}

impl BrokenLink {
    /// What helps.
    pub const FIX: &'static str = "create what the link points to, or remove the link";

    /// Finds the link in a path, the path itself included, whose target is missing; `None` if there is none.
    pub fn find(path: &Path) -> Option<Self> {
        let broken = path.ancestors().find(|p| p.is_symlink() && !p.exists())?;
        Some(Self { link: broken.to_owned(), target: broken.read_link().ok()? })
    }
}

impl fmt::Display for BrokenLink {
    /// Writes `is a link to X, which does not exist`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "is a link to {}, which does not exist", self.target.display())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn dangling_links_are_found_anywhere_in_a_path() {
        let root = tempfile::tempdir().unwrap();
        let link = root.path().join("link");
        symlink("nowhere", &link).unwrap();
        let found = BrokenLink::find(&link.join("below/it")).unwrap();
        assert_eq!((&found.link, found.to_string().as_str()), (&link, "is a link to nowhere, which does not exist"));
        std::fs::create_dir(root.path().join("nowhere")).unwrap();
        assert_eq!(BrokenLink::find(&link), None);
        assert_eq!(BrokenLink::find(&root.path().join("none")), None);
    }
}

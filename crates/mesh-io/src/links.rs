//! Symbolic links whose target is missing: the system's own words for them mislead.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A broken symbolic link.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct BrokenLink {
    /// The link: a path, or one of the directories above it.
    pub link: PathBuf,
    /// The missing path at the end of the chain of links that begins there.
    pub target: PathBuf,
}

/// Systems follow no more links than this.
const LONGEST_CHAIN: usize = 40;

impl BrokenLink {
    /// One fix.
    pub const FIX: &'static str = "create what the link points to, or remove the link";

    /// Finds the link in a path, the path itself included, whose target is missing; `None` if all targets exist.
    pub fn find(path: &Path) -> Option<Self> {
        let is_missing = |p: &Path| p.metadata().is_err_and(|e| e.kind() == io::ErrorKind::NotFound);
        let link = path.ancestors().find(|p| p.is_symlink() && is_missing(p))?;
        let mut target = link.to_owned();
        for _ in 0..LONGEST_CHAIN {
            let Ok(next) = target.read_link() else { break };
            target = target.parent().unwrap_or(Path::new("")).join(next);
        }
        Some(Self { link: link.to_owned(), target })
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
        symlink("link", root.path().join("chain")).unwrap();
        for (path, first) in [("link", "link"), ("link/below/it", "link"), ("chain", "chain")] {
            let found = BrokenLink::find(&root.path().join(path)).unwrap();
            let target = root.path().join("nowhere");
            assert_eq!((&found.link, &found.target), (&root.path().join(first), &target));
            assert_eq!(found.to_string(), format!("is a link to {}, which does not exist", target.display()));
        }
        // A circle has no end that could be missing: the system's words are right.
        symlink("circle", root.path().join("circle")).unwrap();
        assert_eq!(BrokenLink::find(&root.path().join("circle")), None);
        std::fs::create_dir(root.path().join("nowhere")).unwrap();
        assert_eq!(BrokenLink::find(&link), None);
        assert_eq!(BrokenLink::find(&root.path().join("none")), None);
    }
}

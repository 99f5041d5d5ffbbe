//! What is probably not meant in a mesh that can be read all the same, and what helps.

use super::MeshFileError;
use std::fmt;

/// What helps against a [`Problem`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remedy {
    /// To join the nodes, [`RegionOptions::merge`](super::RegionOptions::merge).
    Merge,
    /// To give each body its own nodes.
    OwnNodes,
}

/// Something that is allowed, but probably not meant.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Problem {
    /// What was found.
    pub what: String,
    /// What helps, if there is something.
    pub remedy: Option<Remedy>,
}

impl Problem {
    pub(super) fn new(what: String, remedy: Remedy) -> Self {
        Self { what, remedy: Some(remedy) }
    }
}

impl From<String> for Problem {
    fn from(what: String) -> Self {
        Self { what, remedy: None }
    }
}

/// What prevents the use of a file.
impl From<MeshFileError> for Problem {
    fn from(error: MeshFileError) -> Self {
        let help = error.help.map_or_else(String::new, |help| format!(": {help}"));
        (error.found + &help).into()
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let help = match self.remedy {
            None => "",
            Some(Remedy::Merge) => "; `RegionOptions::merge` joins them",
            Some(Remedy::OwnNodes) => ": as two bodies they cannot part, unless each has its own nodes",
        };
        write!(f, "{}{help}", self.what)
    }
}

//! Faults of a mesh that can be read all the same, but that are probably not meant, with their remedies.

use super::MeshFileError;
use std::fmt;

/// A remedy for a [`Problem`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remedy {
    /// To join the nodes, [`RegionOptions::merge`](super::RegionOptions::merge).
    Merge,
    /// To give each body its own nodes.
    OwnNodes,
    /// To make each body of one connected part, [`Region::connected_to`](super::Region::connected_to).
    Part,
}

/// Something that is allowed, but probably not meant.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Problem {
    /// The problem in words.
    pub what: String,
    /// Its remedy, if there is one.
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

/// Makes a problem of an error that prevents the use of a file.
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
            Some(Remedy::Part) => "; `Region::connected_to` takes one of them",
        };
        write!(f, "{}{help}", self.what)
    }
}

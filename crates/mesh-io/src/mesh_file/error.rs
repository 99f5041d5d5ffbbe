//! The faults of a mesh file, with their places in it.

use crate::words::did_you_mean;
use std::fmt;
use thiserror::Error;

/// The kinds of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFault {
    /// The file cannot be read at all.
    Unreadable,
    /// It is not a mesh file, or one of a format or version that is not read.
    Format,
    /// Its text or bytes are not what the format asks for, or end too early.
    Syntax,
    /// Numbers, nodes or elements contradict each other or make no mesh.
    Content,
    /// A region or group that the file does not have, or that cannot be a body.
    Region,
}

impl MeshFault {
    /// Returns the code that diagnostics of this kind carry.
    pub fn code(self) -> &'static str {
        match self {
            Self::Unreadable => "mesh::unreadable",
            Self::Format => "mesh::format",
            Self::Syntax => "mesh::syntax",
            Self::Content => "mesh::content",
            Self::Region => "mesh::region",
        }
    }

    /// Returns what is expected and what helps, for errors that do not say it.
    pub fn cure(self) -> (&'static str, &'static str) {
        match self {
            Self::Unreadable => (
                "a file that can be read",
                "check the name: a file that another one includes is looked for beside that one",
            ),
            Self::Format => (
                "a mesh of a format that is read",
                "convert the file: meshio convert FILE mesh.msh --output-format gmsh22",
            ),
            Self::Syntax => {
                ("what the format asks for", "export the mesh again, or correct this place by hand")
            }
            Self::Content => {
                ("a sound mesh", "correct the mesh in the program that made it, and export it again")
            }
            Self::Region => ("a region of the file", "`MeshFile::summary` lists the groups of the file"),
        }
    }
}

/// A place in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshPlace {
    /// The file as a whole.
    File,
    /// A line, from 1.
    Line(u64),
    /// A byte of a binary file, from 0.
    Byte(u64),
}

/// A fault of a mesh file: its place, what was found, what was expected, one fix.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub struct MeshFileError {
    /// Which kind of fault.
    pub fault: MeshFault,
    /// The file.
    pub file: String,
    /// The place in it.
    pub place: MeshPlace,
    /// The fault, with nodes and elements by the file's own numbers.
    pub found: String,
    /// The content that was expected, if `found` does not say it.
    pub expected: Option<String>,
    /// One fix.
    pub help: Option<String>,
}

impl MeshFileError {
    pub(crate) fn new(fault: MeshFault, file: &str, place: MeshPlace, found: impl Into<String>) -> Self {
        Self { fault, file: file.to_owned(), place, found: found.into(), expected: None, help: None }
    }

    pub(crate) fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the help "did you mean …?" if one of some names is near a wrong one.
    pub(crate) fn or_similar<'a>(mut self, wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Self {
        self.help = did_you_mean(wrong, names, '"').or(self.help);
        self
    }

    /// Returns file, place and what was found.
    pub fn located(&self) -> String {
        match self.place {
            MeshPlace::File => format!("{}: {}", self.file, self.found),
            MeshPlace::Line(line) => format!("{}:{line}: {}", self.file, self.found),
            MeshPlace::Byte(byte) => format!("{}, byte {byte}: {}", self.file, self.found),
        }
    }
}

impl fmt::Display for MeshFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (expected, help) = self.fault.cure();
        let expected = self.expected.as_deref().unwrap_or(expected);
        write!(f, "{}; expected {expected}; help: {}", self.located(), self.help.as_deref().unwrap_or(help))
    }
}

/// Shows the first bytes of a file of an unknown format.
pub(crate) fn first_bytes(bytes: &[u8]) -> String {
    let shown = bytes.get(..bytes.len().min(32)).unwrap_or_default();
    match std::str::from_utf8(shown) {
        Ok(text) => format!("\"{}\"", text.escape_debug()),
        Err(_) => {
            let hex: Vec<String> = shown.iter().take(16).map(|b| format!("{b:02X}")).collect();
            format!("the bytes {}", hex.join(" "))
        }
    }
}

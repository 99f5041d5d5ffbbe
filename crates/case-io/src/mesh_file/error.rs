//! What is wrong with a mesh file, and where in it.

use crate::diagnostic::{Diagnostic, Place, code};
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
            Self::Unreadable => code::UNREADABLE,
            Self::Format => "mesh::format",
            Self::Syntax => "mesh::syntax",
            Self::Content => "mesh::content",
            Self::Region => "mesh::region",
        }
    }

    /// Returns what is expected and what helps if nothing more specific is known.
    fn cure(self) -> (&'static str, &'static str) {
        match self {
            Self::Unreadable => (
                "a file that can be read",
                "check the name: it is relative to the case file, or to the including file",
            ),
            Self::Format => {
                ("a plane mesh", "convert the file: meshio convert FILE mesh.msh --output-format gmsh")
            }
            Self::Syntax => {
                ("what the format asks for", "export the mesh again, or correct this place by hand")
            }
            Self::Content => {
                ("a sound mesh", "correct the mesh in the program that made it, and export it again")
            }
            Self::Region => ("a region of the file", "see what the file holds with `nndd mesh FILE`"),
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

/// What is wrong with a mesh file: where, what was found, what was expected, one fix.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub struct MeshFileError {
    /// Which kind of fault.
    pub fault: MeshFault,
    /// The file.
    pub file: String,
    /// Where in it.
    pub place: MeshPlace,
    /// What was found; nodes and elements by the file's own numbers.
    pub found: String,
    /// What was expected, if the first sentence does not say it.
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

    /// Makes a diagnostic of it, at the place of the key that names the file.
    pub fn into_diagnostic(self, place: Option<Place>) -> Diagnostic {
        let message = self.located();
        let (expected, fix) = self.fault.cure();
        let expected = self.expected.unwrap_or_else(|| expected.to_owned());
        Diagnostic::new(self.fault.code(), place, message).expected(expected).help(self.help).fix(fix)
    }

    /// Returns file, place and what was found.
    fn located(&self) -> String {
        match self.place {
            MeshPlace::File => format!("{}: {}", self.file, self.found),
            MeshPlace::Line(line) => format!("{}:{line}: {}", self.file, self.found),
            MeshPlace::Byte(byte) => format!("{}, byte {byte}: {}", self.file, self.found),
        }
    }
}

impl fmt::Display for MeshFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The same words everywhere.
        write!(f, "{}", self.clone().into_diagnostic(None))
    }
}

/// Counts things in words: `1 node`, `3 nodes`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
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

/// Lists names for a message, the first twenty.
pub(crate) fn listed(names: &[&str]) -> String {
    let mut words: Vec<String> = names.iter().take(20).map(|n| format!("\"{n}\"")).collect();
    if names.len() > words.len() {
        words.push(format!("… ({} altogether)", names.len()));
    }
    words.join(", ")
}

//! The diagnostics of a case: sources, places, faults with their fixes, and the error that collects them.
//!
//! Every diagnostic says what was found, what was expected and, if there is one, a fix. The binary
//! renders them; this crate only provides the words and the places.

pub use mesh_io::words::nearest;

pub(crate) use mesh_io::words::did_you_mean;

use mesh_io::{MeshFault, MeshFileError, Problem, Remedy};
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// The most diagnostics that one [`CaseError`] lists; the others are counted.
pub const MOST_DIAGNOSTICS: usize = 20;

/// The codes that diagnostics carry.
pub mod code {
    /// The bytes are not UTF-8.
    pub const ENCODING: &str = "case::encoding";
    /// The text is not TOML, or a key is given twice.
    pub const SYNTAX: &str = "case::syntax";
    /// A key that no version knows.
    pub const UNKNOWN_KEY: &str = "case::unknown_key";
    /// A required key is missing.
    pub const MISSING: &str = "case::missing";
    /// A value of the wrong type.
    pub const TYPE: &str = "case::type";
    /// A value outside its range, or keys that exclude each other.
    pub const VALUE: &str = "case::value";
    /// A name that refers to nothing.
    pub const REFERENCE: &str = "case::reference";
    /// A duplicate name.
    pub const DUPLICATE: &str = "case::duplicate";
    /// An expression that cannot be read.
    pub const EXPRESSION: &str = "case::expression";
    /// An override or a sweep on the command line.
    pub const OVERRIDE: &str = "case::override";
    /// A mesh that cannot be made.
    pub const MESH: &str = "case::mesh";
    /// Boundary conditions that make no sense on their mesh.
    pub const CONDITION: &str = "case::condition";
    /// A mesh file that cannot be read.
    pub const UNREADABLE: &str = "mesh::unreadable";
    /// Contact surfaces that cannot be paired.
    pub const CONTACT: &str = "case::contact";
}

/// A text that places refer to: the case file, one override of the command line, or one value of a program.
pub struct Source {
    name: String,
    text: String,
    origin: Origin,
    line_starts: Vec<usize>,
}

/// The way a text came in.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Origin {
    File,
    CommandLine,
    Program,
}

impl Source {
    pub(crate) fn new(name: &str, text: &str, command_line: bool) -> Arc<Self> {
        Self::from(name, text, if command_line { Origin::CommandLine } else { Origin::File })
    }

    /// Makes the source of a value that a program gives; its place is the key.
    pub(crate) fn of_key(key: &str, text: &str) -> Arc<Self> {
        Self::from(key, text, Origin::Program)
    }

    fn from(name: &str, text: &str, origin: Origin) -> Arc<Self> {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(k, _)| k + 1);
        let line_starts = std::iter::once(0).chain(ends).collect();
        Arc::new(Self { name: name.to_owned(), text: text.to_owned(), origin, line_starts })
    }

    /// Returns the name of the file, `--set KEY=VALUE`, or the key of a program's value.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the text that the spans of places count in (without a byte order mark).
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Says whether this is an argument of the command line rather than a file.
    pub fn is_command_line(&self) -> bool {
        self.origin == Origin::CommandLine
    }

    /// Says whether this is a value that a program gives.
    pub(crate) fn is_program(&self) -> bool {
        self.origin == Origin::Program
    }
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Source({:?}, {} bytes)", self.name, self.text.len())
    }
}

/// A place in a case file or in an override.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SourcePosition {
    /// The text.
    pub source: Arc<Source>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The bytes of the text.
    pub span: Range<usize>,
}

impl SourcePosition {
    pub(crate) fn new(source: &Arc<Source>, span: Range<usize>) -> Self {
        let start = span.start.min(source.text.len());
        let span = start..span.end.clamp(start, source.text.len());
        let line = source.line_starts.partition_point(|&s| s <= start).max(1);
        let line_start = source.line_starts.get(line - 1).copied().unwrap_or(0);
        let column = source.text.get(line_start..start).map_or(start - line_start, |s| s.chars().count()) + 1;
        Self { source: Arc::clone(source), line, column, span }
    }

    /// Returns the name of the file, or `--set KEY=VALUE`.
    pub fn file(&self) -> &str {
        &self.source.name
    }
}

impl fmt::Display for SourcePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.source.origin {
            Origin::File => write!(f, "{}:{}:{}", self.source.name, self.line, self.column),
            Origin::CommandLine | Origin::Program => write!(f, "{}", self.source.name),
        }
    }
}

/// One error or warning.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Diagnostic {
    /// One of [`code`].
    pub code: &'static str,
    /// The fault, with the text or value that was found.
    pub message: String,
    /// Its place in the case file or on the command line, if it has one.
    pub place: Option<SourcePosition>,
    /// The input that was expected there.
    pub expected: Option<String>,
    /// One fix.
    pub help: Option<String>,
}

impl Diagnostic {
    pub(crate) fn new(code: &'static str, place: Option<SourcePosition>, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), place, expected: None, help: None }
    }

    /// Makes a diagnostic of an error of a mesh file, at the place of the key that names the file.
    pub fn of_mesh_file(error: MeshFileError, place: Option<SourcePosition>) -> Self {
        let message = error.located();
        let (expected, fix) = match error.fault {
            MeshFault::Unreadable => (
                "a file that can be read",
                "check the name: it is relative to the case file, or to the including file",
            ),
            MeshFault::Region => ("a region of the file", "see what the file holds with `nndd mesh FILE`"),
            fault => fault.cure(),
        };
        let expected = error.expected.unwrap_or_else(|| expected.to_owned());
        Self::new(error.fault.code(), place, message).expected(expected).help(error.help).fix(fix)
    }

    /// Says what is probably not meant in a mesh file, and which key of the case helps.
    pub fn told(problem: &Problem) -> String {
        let help = match problem.remedy {
            Some(Remedy::Merge) => "; `merge = true` joins them",
            Some(Remedy::OwnNodes) => ": as two bodies they need `duplicate_interface = true`",
            Some(Remedy::Part) => "; `connected_to = \"SIDE\"` in `mesh` takes the part at a side",
            _ => "",
        };
        format!("{}{help}", problem.what)
    }

    /// Names the option of the command line that a value came with, if it is another than `--set`.
    ///
    /// * `option`: such as `--over`.
    pub fn given_by(&mut self, option: &str, key: &str, value: &str) {
        let Some(place) = self.place.as_mut() else { return };
        if place.source.is_command_line() && place.source.name == format!("--set {key}={value}") {
            let name = format!("{option} {key}={value}");
            place.source = Source::new(&name, &place.source.text, true);
        }
    }

    pub(crate) fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    pub(crate) fn help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }

    /// Gives the fix, unless there is a better one already.
    pub(crate) fn fix(mut self, fix: impl Into<String>) -> Self {
        self.help.get_or_insert_with(|| fix.into());
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        write!(f, "{}", self.message)?;
        if let Some(expected) = &self.expected {
            write!(f, "; expected {expected}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "; help: {help}")?;
        }
        Ok(())
    }
}

/// Everything that is wrong with a case: at least one diagnostic, at most [`MOST_DIAGNOSTICS`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CaseError {
    /// The faults, in the order of their places.
    pub diagnostics: Vec<Diagnostic>,
    /// How many more there are.
    pub omitted: usize,
}

impl CaseError {
    /// Collects diagnostics by place: first the case file's, then the command line's, then the ones without a place.
    pub(crate) fn new(mut diagnostics: Vec<Diagnostic>) -> Self {
        let rank = |d: &Diagnostic| match &d.place {
            Some(place) => (place.source.is_command_line(), place.span.start),
            None => (true, usize::MAX),
        };
        diagnostics.sort_by_key(rank);
        let omitted = diagnostics.len().saturating_sub(MOST_DIAGNOSTICS);
        diagnostics.truncate(MOST_DIAGNOSTICS);
        Self { diagnostics, omitted }
    }

    /// Counts faults that are not in the list.
    pub(crate) fn and_more(mut self, omitted: usize) -> Self {
        self.omitted += omitted;
        self
    }
}

impl From<Diagnostic> for CaseError {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { diagnostics: vec![diagnostic], omitted: 0 }
    }
}

impl fmt::Display for CaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, diagnostic) in self.diagnostics.iter().enumerate() {
            if k > 0 {
                writeln!(f)?;
            }
            write!(f, "{diagnostic}")?;
        }
        if self.omitted > 0 {
            write!(f, "\nand {} more", self.omitted)?;
        }
        Ok(())
    }
}

impl std::error::Error for CaseError {}

/// Writes three significant digits, without an exponent if that is readable.
///
/// ```
/// let written = [1.8349, 42.04, 3.2e-9, 0.9999, 0.0].map(case_io::diagnostic::significant);
/// assert_eq!(written, ["1.83", "42.0", "3.20e-9", "1.00", "0"]);
/// ```
pub fn significant(x: f64) -> String {
    let rounded = format!("{x:.2e}");
    if x != 0.0 && !(1e-3..1e4).contains(&x.abs()) {
        return rounded;
    }
    let x: f64 = rounded.parse().unwrap_or(x);
    let digits = if x == 0.0 { 0 } else { (2.0 - x.abs().log10().floor()).max(0.0) as usize };
    format!("{x:.digits$}")
}

/// Shortens a text from a file for a message.
pub(crate) fn excerpt(text: &str) -> String {
    const MOST: usize = 40;
    let short: String = text.chars().take(MOST).collect();
    let dots = if short.len() < text.len() { "…" } else { "" };
    format!("\"{}{dots}\"", short.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters() {
        let source = Source::new("c.toml", "a = 1\r\nβ = \"γ\"\nlast", false);
        let place = SourcePosition::new(&source, 12..16);
        assert_eq!((place.line, place.column), (2, 5));
        assert_eq!(&source.text()[place.span.clone()], "\"γ\"");
        assert_eq!(place.to_string(), "c.toml:2:5");
        let end = SourcePosition::new(&source, 99..120);
        assert_eq!((end.line, end.column), (3, 5));
    }

    #[test]
    fn long_lists_are_cut_and_counted() {
        let many = (0..25).map(|k| Diagnostic::new(code::VALUE, None, format!("fault {k}"))).collect();
        let error = CaseError::new(many);
        assert_eq!((error.diagnostics.len(), error.omitted), (20, 5));
        assert!(error.to_string().ends_with("and 5 more"));
    }
}

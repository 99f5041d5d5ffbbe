//! The case file as a document: bytes to a tree of values with places, with the overrides applied.
//!
//! The meaning of the keys is in [`crate::case`]. This module handles TOML, places, and `--set` and `--over` of the command line.

mod examples;
mod other_words;
mod overrides;
mod quantity;
mod reader;
mod sweep;
mod tree;
mod value_hints;

pub use overrides::split_override;
pub use sweep::{MOST_SWEEP_VALUES, Sweep};
pub use tree::{At, Node, NodeValue, Table};

pub(crate) use quantity::{memory, time};
pub(crate) use reader::{Findings, MatrixWords, Reader};

use crate::diagnostic::{CaseError, Diagnostic, Source, SourcePosition, code, excerpt};
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml::de::DeTable;

/// The largest case file that is read, in bytes.
pub const LARGEST_CASE_FILE: u64 = 16 << 20;

/// Lines, brackets, commas, points, quotes and equals signs of a case file, at most.
const MOST_SIGNS: usize = 2_000_000;

/// Faults of syntax are looked for as many bytes behind the first one.
const NEAR: usize = 1 << 16;

/// At most this many syntax errors are reported: each takes a pass over the whole text.
const MOST_SYNTAX_FAULTS: usize = 8;

/// Reads the bytes of a case file from disk.
///
/// # Errors
/// A file that cannot be read, that is not a regular file (a pipe would wait for ever), or that has more than
/// [`LARGEST_CASE_FILE`] bytes.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let found = std::fs::metadata(path)?;
    let refuse = |what: String| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    if found.is_dir() {
        return refuse("a directory, not a case file".to_owned());
    }
    if !found.is_file() {
        return refuse("not a regular file".to_owned());
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(LARGEST_CASE_FILE + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST_CASE_FILE {
        return refuse(format!("more than {LARGEST_CASE_FILE} bytes: this is not a case file"));
    }
    Ok(bytes)
}

/// A parsed case file with its overrides.
pub(crate) struct Document {
    pub(crate) root: Table,
    pub(crate) at: At,
}

/// Decodes bytes as UTF-8 without a byte order mark.
pub(crate) fn decode<'a>(bytes: &'a [u8], file_name: &str) -> Result<&'a str, CaseError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    // Files of Gmsh begin with `$`, decks of Abaqus with `*`; no line of TOML does.
    if let Some(b'$' | b'*') = bytes.trim_ascii_start().first() {
        let source = Source::new(file_name, &String::from_utf8_lossy(bytes), false);
        let place = SourcePosition::new(&source, 0..1);
        return Err(Diagnostic::new(code::SYNTAX, Some(place), "this looks like a mesh file")
            .expected("a case file in TOML, which names the mesh")
            .help(Some(format!(
                "look into the mesh with `nndd mesh {file_name}`, and begin a case with `nndd new gmsh`"
            )))
            .into());
    }
    std::str::from_utf8(bytes).map_err(|error| {
        // Up to the fault the replaced text has the same bytes, so the span fits.
        let source = Source::new(file_name, &String::from_utf8_lossy(bytes), false);
        let start = error.valid_up_to();
        let byte = bytes.get(start).copied().unwrap_or(0);
        let place = SourcePosition::new(&source, start..start + 3);
        let wide = bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF");
        let advice = if wide { "this looks like UTF-16; save it as UTF-8" } else { "save the file as UTF-8" };
        Diagnostic::new(code::ENCODING, Some(place), format!("the byte 0x{byte:02X} is not UTF-8 text"))
            .expected("UTF-8")
            .help(Some(advice.to_owned()))
            .into()
    })
}

/// Parses a text and applies the overrides in their order.
pub(crate) fn parse(
    text: &str,
    file_name: &str,
    overrides: &[(String, String)],
) -> Result<Document, CaseError> {
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    let source = Source::new(file_name, text, false);
    Document::new(document(text, &source)?, At::new(&source, 0..0), overrides)
}

impl Document {
    /// Applies the overrides in their order.
    pub(crate) fn new(mut root: Table, at: At, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        let faults: Vec<Diagnostic> = overrides
            .iter()
            .filter_map(|(key, value)| overrides::apply(&mut root, key, value).err())
            .flat_map(|error| error.diagnostics)
            .collect();
        if !faults.is_empty() {
            return Err(CaseError::new(faults));
        }
        if root.entries.is_empty() {
            let help = "write a case file to start from with `nndd new paper`";
            let empty = at.source.text().is_empty();
            let message = if empty { "the case file is empty" } else { "the case file sets nothing" };
            return Err(Diagnostic::new(code::MISSING, Some(at.place()), message)
                .expected("the tables of a case")
                .help(Some(help.to_owned()))
                .into());
        }
        Ok(Document { root, at })
    }
}

fn document(text: &str, source: &Arc<Source>) -> Result<Table, CaseError> {
    refuse_controls(text, source)?;
    let first = match DeTable::parse(text) {
        Ok(table) => return Ok(tree::table(table.into_inner(), source, 0)),
        Err(error) => error.span().map_or(0, |span| span.start),
    };
    // Every byte behind a fault can be one more: those far behind the first one are not looked for.
    let near = line_at(text, first.saturating_add(NEAR).min(text.len())).end;
    let near = text.get(..near).unwrap_or(text);
    Err(CaseError::new(syntax_faults(near, DeTable::parse_recoverable(near).1, source)))
}

/// Refuses what no case has: a control character, which TOML does not allow anywhere, and more signs than a case of this size needs. Each of
/// them would be an object of its own, and a fault.
fn refuse_controls(text: &str, source: &Arc<Source>) -> Result<(), CaseError> {
    let bytes = text.as_bytes();
    let is_control = |k: &usize| match bytes[*k] {
        b'\t' | b'\n' => false,
        b'\r' => bytes.get(k + 1) != Some(&b'\n'),
        byte => byte.is_ascii_control(),
    };
    let fault = |at: usize, message: String| {
        Diagnostic::new(code::SYNTAX, Some(SourcePosition::new(source, at..at + 1)), message)
    };
    if let Some(at) = (0..bytes.len()).find(is_control) {
        let found = match bytes[at] {
            b'\r' => "a carriage return without a line feed".to_owned(),
            byte => format!("the control character 0x{byte:02X}"),
        };
        let fix = "save the file with the line ends of Unix or Windows";
        return Err(fault(at, found)
            .expected("text, with a line feed at the end of each line")
            .fix(fix)
            .into());
    }
    let is_sign = |byte: &u8| b"\n[]{}=,.\"'".contains(byte);
    let signs = bytes.iter().enumerate().filter(|(_, byte)| is_sign(byte));
    match signs.map(|(at, _)| at).nth(MOST_SIGNS) {
        None => Ok(()),
        Some(at) => Err(fault(at, format!("more than {MOST_SIGNS} lines, brackets and commas"))
            .expected("a case")
            .fix("keep meshes and tables of values in files of their own")
            .into()),
    }
}

/// Lists the faults of a text that is not TOML, without those that follow from others: a bracket that is never closed
/// makes every line below it wrong. So a faulty line is blanked before the lines below it are checked.
fn syntax_faults(text: &str, mut errors: Vec<toml::de::Error>, source: &Arc<Source>) -> Vec<Diagnostic> {
    let mut text = text.to_owned();
    let mut faults = Vec::new();
    let mut from = 0;
    while faults.len() < MOST_SYNTAX_FAULTS {
        let span = |error: &toml::de::Error| error.span().unwrap_or(0..0);
        let below = errors.iter().filter(|error| span(error).start >= from);
        let Some(first) = below.min_by_key(|error| span(error).start) else { break };
        let span = span(first);
        faults.push(syntax_fault(&text, first, span.clone(), source));
        let at = span.start.min(text.len());
        let Range { start, end } = line_at(&text, at);
        from = end + 1;
        let header = is_header(&text[start..end]);
        if is_duplicate(first) {
            // The text is TOML up to its meaning: the other faults are independent, but for the keys of a table that is
            // there twice.
            if header {
                from = headers(&text).find(|at| *at > start).unwrap_or(text.len());
            }
            continue;
        }
        if header || text[start..at].trim().is_empty() {
            // To which table the keys below belong is not known, or the fault began further up, as an array that is
            // never closed: the lines below cannot be checked.
            break;
        }
        text.replace_range(start..end, &" ".repeat(end - start));
        errors = DeTable::parse_recoverable(&text).1;
    }
    faults
}

/// Finds the line of a byte, without its end.
fn line_at(text: &str, at: usize) -> Range<usize> {
    let at = at.min(text.len());
    let is_end = |byte: &u8| *byte == b'\n';
    let start = text.as_bytes()[..at].iter().rposition(is_end).map_or(0, |end| end + 1);
    let end = text.as_bytes()[at..].iter().position(is_end).map_or(text.len(), |length| at + length);
    start..end
}

fn is_duplicate(error: &toml::de::Error) -> bool {
    error.message().starts_with("duplicate key")
}

fn is_header(line: &str) -> bool {
    line.trim_start().starts_with('[')
}

/// The lines of a text with the bytes where they begin.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_inclusive('\n').scan(0, |at, line| {
        let start = *at;
        *at += line.len();
        Some((start, line))
    })
}

/// Returns the bytes at which the headers of tables begin.
fn headers(text: &str) -> impl Iterator<Item = usize> {
    lines(text).filter(|(_, line)| is_header(line)).map(|(start, _)| start)
}

/// Describes a fault of syntax; of a duplicate key, with the place of the first.
fn syntax_fault(text: &str, error: &toml::de::Error, span: Range<usize>, source: &Arc<Source>) -> Diagnostic {
    let fault = |message: String| {
        Diagnostic::new(code::SYNTAX, Some(SourcePosition::new(source, span.clone())), message)
    };
    if !is_duplicate(error) {
        if let Some(hint) = value_hints::in_line(text, line_at(text, span.start), source, 0) {
            return hint;
        }
        let toml = "TOML: `key = value`, texts in quotes, arrays in brackets";
        let said = error.message();
        let (found, expected) = said.split_once(", expected ").unwrap_or((said, toml));
        return fault(found.to_owned()).expected(expected).fix("write this line as valid TOML");
    }
    let key = text.get(span.clone()).unwrap_or_default();
    let first = first_of(text, key, span.start)
        .map(|at| format!(", first defined in line {}", SourcePosition::new(source, at..at).line))
        .unwrap_or_default();
    fault(format!("duplicate key {}{first}", excerpt(key)))
        .expected("every key and every table once")
        .fix("take one of the two out, or rename it")
}

/// Finds where a key or the header of a table, repeated at `at`, appears first.
fn first_of(text: &str, key: &str, at: usize) -> Option<usize> {
    let (start, line) = lines(text).take_while(|(start, _)| *start <= at).last()?;
    let before = lines(text).take_while(|(other, _)| *other < start);
    if is_header(line) {
        return before.filter(|(_, other)| other.trim() == line.trim()).map(|(other, _)| other).next();
    }
    let table = headers(text).take_while(|other| *other < start).last().unwrap_or(0);
    let sets = |(_, other): &(usize, &str)| {
        other.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with(['=', '.']))
    };
    let in_table = before.filter(|(other, _)| *other >= table).find(sets).map(|(other, _)| other);
    // Within an inline table both are on one line.
    in_table.or_else(|| text.get(start..at)?.contains(key).then_some(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_file_is_told_from_a_case() {
        for bytes in [&b"$MeshFormat\n4.1 1 8\n\xFF"[..], b"\n*Heading\n"] {
            let said = decode(bytes, "a.msh").unwrap_err().to_string();
            assert!(said.contains("looks like a mesh file") && said.contains("`nndd mesh a.msh`"), "{said}");
        }
    }

    #[test]
    fn the_words_of_a_fault_stand_once() {
        let said = parse("a = [1 2]", "c.toml", &[]).err().unwrap().to_string();
        assert_eq!(said.matches("expected").count(), 1, "{said}");
    }

    #[test]
    fn only_regular_files_of_a_sane_size_are_read() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("case.toml");
        std::fs::write(&file, "schema = 1").unwrap();
        assert_eq!(read(&file).unwrap(), b"schema = 1");
        assert!(read(root.path()).unwrap_err().to_string().contains("a directory"));
        assert_eq!(read(&root.path().join("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
        // A sparse file of more than the limit is refused before it is read whole.
        std::fs::File::options().write(true).open(&file).unwrap().set_len(LARGEST_CASE_FILE + 1).unwrap();
        assert!(read(&file).unwrap_err().to_string().contains("not a case file"));
        if cfg!(unix) {
            assert!(read(Path::new("/dev/zero")).unwrap_err().to_string().contains("not a regular file"));
        }
    }
}

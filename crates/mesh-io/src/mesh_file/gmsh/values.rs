//! The numbers of a MSH file one after the other, written as text or in binary.

use crate::mesh_file::{MeshFault, MeshFileError, MeshPlace, Spot};
use crate::numeral;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Ascii,
    BinaryLittle,
    BinaryBig,
}

/// A cursor over the bytes of a file.
pub(super) struct Values<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    /// Line of the cursor, from 1; only text is counted.
    line: u64,
    /// Line of the token read last.
    token_line: u64,
    pub(super) mode: Mode,
    /// The section being read, such as `$Nodes`, and the progress in it, such as 12 of 140 nodes: reported if the file ends there.
    section: &'static str,
    progress: Option<(u64, u64, &'static str)>,
}

impl<'a> Values<'a> {
    pub(super) fn new(bytes: &'a [u8], file: &'a str) -> Self {
        let at = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
        Self { file, bytes, at, line: 1, token_line: 0, mode: Mode::Ascii, section: "", progress: None }
    }

    /// Says what is being read.
    pub(super) fn enter(&mut self, section: &'static str) {
        (self.section, self.progress) = (section, None);
    }

    /// Says how far reading has come.
    pub(super) fn progress(&mut self, done: u64, of: u64, what: &'static str) {
        self.progress = Some((done, of, what));
    }

    pub(super) fn is_binary(&self) -> bool {
        self.mode != Mode::Ascii
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Returns the number of bytes that are left.
    pub(super) fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// Returns the present place for a node or element.
    pub(super) fn spot(&self) -> Spot {
        let line = if self.is_binary() { 0 } else { u32::try_from(self.token_line).unwrap_or(0) };
        Spot { file: 0, line }
    }

    fn error_at(&self, fault: MeshFault, line: u64, found: impl Into<String>) -> MeshFileError {
        let place =
            if self.is_binary() { MeshPlace::Byte(self.at as u64) } else { MeshPlace::Line(line.max(1)) };
        MeshFileError::new(fault, self.file, place, found)
    }

    /// Makes an error at the token read last.
    pub(super) fn fault(&self, found: impl Into<String>) -> MeshFileError {
        self.error_at(MeshFault::Syntax, self.token_line, found)
    }

    /// Makes an error about the format at the token read last.
    pub(super) fn unsupported(&self, found: impl Into<String>) -> MeshFileError {
        self.error_at(MeshFault::Format, self.token_line, found)
    }

    /// Makes the error of a file that ends too early.
    pub(super) fn ended(&self) -> MeshFileError {
        let after = match self.progress {
            Some((done, of, what)) => format!(" after {done} of {of} {what}"),
            None => String::new(),
        };
        let inside = if self.section.is_empty() { "its header" } else { self.section };
        self.error_at(MeshFault::Syntax, self.line, format!("the file ended inside {inside}{after}"))
            .expected("a complete file; it may have been cut while it was copied")
    }

    /// Skips blanks, also over line ends; returns whether something is left.
    pub(super) fn skip_blank(&mut self) -> bool {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte == b'\n' {
                self.line += 1;
            } else if !byte.is_ascii_whitespace() && byte != 0x0B {
                return true;
            }
            self.at += 1;
        }
        false
    }

    /// Tells whether the next byte of the line, after blanks, is this one.
    pub(super) fn next_is(&self, byte: u8) -> bool {
        self.rest().iter().find(|b| !matches!(b, b' ' | b'\t')) == Some(&byte)
    }

    /// Reads up to the next blank, or to a quote that follows without one.
    pub(super) fn token(&mut self) -> Result<&'a [u8], MeshFileError> {
        if !self.skip_blank() {
            return Err(self.ended());
        }
        let rest = self.rest();
        let ends = |b: &u8| b.is_ascii_whitespace() || *b == b'"';
        let len = rest.iter().skip(1).position(ends).map_or(rest.len(), |k| k + 1);
        self.at += len;
        self.token_line = self.line;
        Ok(&rest[..len])
    }

    /// Reads the rest of the line, without its end.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let len = rest.iter().position(|b| *b == b'\n');
        self.at += len.map_or(rest.len(), |k| k + 1);
        self.token_line = self.line;
        self.line += u64::from(len.is_some());
        rest[..len.unwrap_or(rest.len())].trim_ascii()
    }

    /// Skips to just behind the next occurrence of a word; returns whether there is one.
    pub(super) fn skip_past(&mut self, word: &[u8]) -> bool {
        let rest = self.rest();
        // The words sought begin with `$`, which is rare: this looks at each byte about once.
        let mut from = 0;
        while let Some(k) = rest[from..].iter().position(|b| *b == b'$') {
            if rest[from + k..].starts_with(word) {
                let len = from + k + word.len();
                self.line += rest[..len].iter().filter(|b| **b == b'\n').count() as u64;
                self.at += len;
                return true;
            }
            from += k + 1;
        }
        self.at = self.bytes.len();
        false
    }

    /// Reads the line that ends a section.
    pub(super) fn end(&mut self, word: &'static str) -> Result<(), MeshFileError> {
        let token = self.token()?;
        if token == word.as_bytes() {
            return Ok(());
        }
        let found = format!("found {} after the last entry of {}", shown(token), self.section);
        let help =
            "the count at the head of the section is smaller than the section, or an entry is too long";
        Err(self.fault(found).expected(format!("`{word}`")).help(help))
    }

    /// Begins a record that is on a line of its own; returns what [`Values::record_end`] needs.
    pub(super) fn record_begin(&mut self) -> Result<u64, MeshFileError> {
        if self.is_binary() {
            return Ok(0);
        }
        let previous = self.token_line;
        if !self.skip_blank() {
            return Err(self.ended());
        }
        if self.line == previous {
            let found = format!("this line of {} has more numbers than expected", self.section);
            return Err(self.error_at(MeshFault::Syntax, self.line, found));
        }
        Ok(self.line)
    }

    /// Checks that a record did not run into the next line.
    pub(super) fn record_end(&self, line: u64) -> Result<(), MeshFileError> {
        if self.is_binary() || self.token_line == line {
            return Ok(());
        }
        let found = format!("this line of {} has fewer numbers than expected", self.section);
        Err(self.error_at(MeshFault::Syntax, line, found))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], MeshFileError> {
        let Some(bytes) = self.rest().first_chunk::<N>() else { return Err(self.ended()) };
        self.at += N;
        Ok(*bytes)
    }

    fn not_a(&self, token: &[u8], what: &str) -> MeshFileError {
        let after = match self.progress {
            Some((done, of, items)) if token.starts_with(b"$") => {
                format!(": {} ended after {done} of {of} {items}", self.section)
            }
            _ => format!(" in {}", self.section),
        };
        self.fault(format!("found {}{after}", shown(token))).expected(what.to_owned())
    }

    /// Reads an `int`.
    pub(super) fn int(&mut self, what: &str) -> Result<i32, MeshFileError> {
        match self.mode {
            Mode::BinaryLittle => Ok(i32::from_le_bytes(self.take()?)),
            Mode::BinaryBig => Ok(i32::from_be_bytes(self.take()?)),
            Mode::Ascii => {
                let token = self.token()?;
                let (negative, digits) = match token.strip_prefix(b"-") {
                    Some(digits) => (true, digits),
                    None => (false, token),
                };
                let magnitude = unsigned(digits).and_then(|v| i32::try_from(v).ok());
                let value = magnitude.map(|v| if negative { -v } else { v });
                value.ok_or_else(|| self.not_a(token, what))
            }
        }
    }

    /// Reads a `size_t`.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, MeshFileError> {
        match self.mode {
            Mode::BinaryLittle => Ok(u64::from_le_bytes(self.take()?)),
            Mode::BinaryBig => Ok(u64::from_be_bytes(self.take()?)),
            Mode::Ascii => {
                let token = self.token()?;
                unsigned(token).ok_or_else(|| self.not_a(token, what))
            }
        }
    }

    /// Reads a `double`.
    pub(super) fn real(&mut self, what: &str) -> Result<f64, MeshFileError> {
        match self.mode {
            Mode::BinaryLittle => Ok(f64::from_le_bytes(self.take()?)),
            Mode::BinaryBig => Ok(f64::from_be_bytes(self.take()?)),
            Mode::Ascii => {
                let token = self.token()?;
                let text = std::str::from_utf8(token).unwrap_or_default();
                text.parse().map_err(|_| match numeral::advice(text) {
                    Some(advice) => self.not_a(token, what).help(advice),
                    None => self.not_a(token, what),
                })
            }
        }
    }

    /// Reads a count that is text also in binary files of version 2.
    pub(super) fn text_count(&mut self, what: &'static str) -> Result<u64, MeshFileError> {
        let mode = std::mem::replace(&mut self.mode, Mode::Ascii);
        let count = self.size(what);
        self.mode = mode;
        count
    }

    /// Returns how many items may be allocated: at most as many as the rest of the file can hold.
    pub(super) fn capacity(
        &mut self,
        count: u64,
        bytes_each: [usize; 2],
        what: &'static str,
    ) -> Result<usize, MeshFileError> {
        let most = self.remaining() / bytes_each[usize::from(self.is_binary())] + 1;
        let capacity = usize::try_from(count).map_or(most, |count| count.min(most));
        if self.is_binary() && count > most as u64 {
            // Reading on would only take other data for numbers.
            self.progress(most as u64 - 1, count, what);
            return Err(self.ended());
        }
        Ok(capacity)
    }
}

/// Shows a token in a message.
pub(super) fn shown(token: &[u8]) -> String {
    let text = String::from_utf8_lossy(&token[..token.len().min(40)]);
    format!("`{}`", text.escape_debug())
}

/// Reads digits.
fn unsigned(digits: &[u8]) -> Option<u64> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0u64, |value, byte| {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 { None } else { value.checked_mul(10)?.checked_add(u64::from(digit)) }
    })
}

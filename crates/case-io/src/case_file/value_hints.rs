//! Values that TOML does not know but people write: numbers with units, curly quotes, words without quotes.

use super::examples::example;
use crate::diagnostic::{Diagnostic, Source, SourcePosition, code};
use crate::expression::Expression;
use mesh_io::numeral;
use std::ops::Range;
use std::sync::Arc;
use toml::de::DeValue;

/// Keys whose values are texts: what begins like a number there needs quotes.
const TEXTS: [&str; 21] = [
    "title",
    "name",
    "material",
    "on",
    "file",
    "region",
    "group",
    "kind",
    "facing",
    "hypothesis",
    "surfaces",
    "along",
    "method",
    "imposed",
    "path",
    "qp",
    "weights",
    "acceleration",
    "directory",
    "memory",
    "time",
];

/// Keys whose values may be expressions.
const EXPRESSIONS: [&str; 9] =
    ["ux", "uy", "normal", "vector", "pressure", "stiffness", "rest", "gap", "lambda"];

/// A value of a line that is not TOML.
struct Piece<'a> {
    /// The key in front of it on the same line.
    key: Option<&'a str>,
    /// Its bytes in the text.
    span: Range<usize>,
    /// True if a value is expected there: behind a key, or in an array.
    is_value: bool,
    /// True if it is outside brackets and braces.
    alone: bool,
}

/// Finds the first value of a line that is not TOML although its meaning is clear, and makes a fault of it.
///
/// * `line`: the bytes of the line in the text.
/// * `offset`: where the text begins in the source.
pub(super) fn in_line(
    text: &str,
    line: Range<usize>,
    source: &Arc<Source>,
    offset: usize,
) -> Option<Diagnostic> {
    pieces(text, line).iter().find_map(|piece| {
        let value = &text[piece.span.clone()];
        let (found, expected, fix) = meaning(value, piece)?;
        let place = SourcePosition::new(source, piece.span.start + offset..piece.span.end + offset);
        Some(Diagnostic::new(code::SYNTAX, Some(place), found).expected(expected).fix(fix))
    })
}

/// The fault, the expected value, and a fix.
type Meaning = (String, &'static str, String);

fn meaning(value: &str, piece: &Piece<'_>) -> Option<Meaning> {
    let key = piece.key.unwrap_or_default();
    let key = key.rsplit('.').next().unwrap_or(key).trim();
    if value.is_empty() && piece.alone && piece.key.is_some() {
        let fix = example(key).unwrap_or("KEY = VALUE");
        return Some((
            format!("`{}` has no value", piece.key?),
            "a value behind `=`",
            format!("write it as in `{fix}`"),
        ));
    }
    if value.is_empty() || DeValue::parse(value).is_ok() {
        return None;
    }
    let is_text = TEXTS.contains(&key);
    let shown = shown(value);
    if let Some(advice) = numeral::advice(value).filter(|_| !is_text) {
        return Some((format!("{shown} is not a number"), "a number", advice));
    }
    let in_quotes = || format!("write \"{}\"", numeral::without_quotes(value).escape_debug());
    let ends_curly = value.starts_with('"') && value.ends_with(numeral::is_curly);
    if value.starts_with(numeral::is_curly) || ends_curly {
        return Some((format!("{shown} has curly quotes"), "straight quotes, `\"…\"`", in_quotes()));
    }
    if !piece.is_value || value.starts_with(['"', '\'']) {
        return None;
    }
    if numeral::is_number(value) && !is_text {
        let expected = "digits on both sides of the point, and no zeros in front";
        let fix = format!("write {}", numeral::spelled(value));
        return Some((format!("{shown} is not a number of TOML"), expected, fix));
    }
    let lower = value.to_lowercase();
    let truth = ["true", "yes", "on"].contains(&&*lower);
    if truth || ["false", "no", "off"].contains(&&*lower) {
        return Some((format!("{shown} is not a value of TOML"), "true or false", format!("write {truth}")));
    }
    if ["nan", "inf", "infinity"].contains(&lower.trim_start_matches(['+', '-'])) {
        let fix = "write the number itself".to_owned();
        return Some((format!("{shown} is not a number"), "a finite number", fix));
    }
    if Expression::parse(value).is_ok() && !is_text {
        let (expected, fix) = match EXPRESSIONS.contains(&key) || piece.key.is_none() {
            true => ("a number, or an expression in quotes", in_quotes()),
            false => ("a number", "write the number itself".to_owned()),
        };
        return Some((format!("{shown} is not a number"), expected, fix));
    }
    let of_word = |c: char| c.is_alphanumeric() || " _-./".contains(c);
    let is_word = value.starts_with(|c: char| c.is_alphabetic() || is_text) && value.chars().all(of_word);
    if is_word {
        return Some((format!("{shown} has no quotes"), "a text in quotes", in_quotes()));
    }
    let digits = value.trim_start_matches(['+', '-', '.']).starts_with(|c: char| c.is_ascii_digit());
    let fix = "write the number itself, such as 0.5 or 1e-3".to_owned();
    digits.then(|| (format!("{shown} is not a number"), "a number", fix))
}

/// Shows a value as it is written, cut if it is long.
fn shown(value: &str) -> String {
    const MOST: usize = 40;
    let short: String = value.chars().take(MOST).collect();
    let dots = if short.len() < value.len() { "…" } else { "" };
    format!("`{}{dots}`", short.replace(char::is_control, "\u{FFFD}"))
}

/// The state of the scan: the pieces found so far, the key and start of the next one, open brackets and quotes.
#[derive(Default)]
struct Scan<'a> {
    found: Vec<Piece<'a>>,
    key: Option<&'a str>,
    start: usize,
    open: Vec<char>,
    quote: Option<char>,
    /// A line that begins with a bracket and has no comma is the header of a table.
    header: bool,
    /// A line that continues an array: it has no key.
    continued: bool,
}

impl<'a> Scan<'a> {
    /// Ends a value at a byte of the text.
    fn end_value(&mut self, text: &'a str, at: usize) {
        let value = &text[self.start..at];
        let from = self.start + (value.len() - value.trim_start().len());
        let span = from..from + value.trim().len();
        let within = self.open.last().copied();
        match self.found.last_mut() {
            // Within braces a key follows a comma. Without one, as in `{ x = 0,5 }`, it is a decimal comma.
            Some(last) if within == Some('{') && self.key.is_none() && !span.is_empty() => {
                last.span.end = span.end
            }
            _ => {
                let is_value = self.key.is_some() || self.continued || within.is_some() && !self.header;
                self.found.push(Piece { key: self.key, span, is_value, alone: within.is_none() });
            }
        }
        self.start = at;
    }

    /// Takes a character outside quotes.
    fn take(&mut self, text: &'a str, at: usize, c: char) {
        let blank = text[self.start..at].trim().is_empty();
        match c {
            '"' | '\'' if blank => self.quote = Some(c),
            _ if blank && numeral::is_curly(c) => self.quote = Some(c),
            '=' => (self.key, self.start) = (Some(text[self.start..at].trim()), at + 1),
            '[' | '{' if blank => {
                self.open.push(c);
                if c == '{' {
                    self.key = None;
                }
                self.start = at + 1;
            }
            // Part of the value, such as a unit in brackets.
            '[' | '(' => self.quote = Some(if c == '[' { ']' } else { ')' }),
            ']' | '}' => {
                self.end_value(text, at);
                self.open.pop();
                (self.key, self.start) = (None, at + 1);
            }
            ',' if !self.open.is_empty() || self.key.is_none() => {
                self.end_value(text, at);
                if self.open.last() != Some(&'[') {
                    self.key = None;
                }
                self.start = at + 1;
            }
            _ => {}
        }
    }
}

/// Splits a line into its values; a line that continues an array begins without a key.
fn pieces(text: &str, line: Range<usize>) -> Vec<Piece<'_>> {
    let content = &text[line.clone()];
    let header = content.trim_start().starts_with('[') && !content.contains(',');
    let continued =
        !header && !content.contains('=') && (content.contains(',') || content.trim_end().ends_with(']'));
    let mut scan = Scan { start: line.start, header, continued, ..Scan::default() };
    let mut end = line.end;
    let mut escaped = false;
    for (k, c) in content.char_indices() {
        match scan.quote {
            _ if escaped => escaped = false,
            Some('"') if c == '\\' => escaped = true,
            Some(quote) => {
                let closes = c == quote || numeral::is_curly(c) || numeral::is_curly(quote) && c == '"';
                if closes {
                    scan.quote = None;
                }
            }
            None if c == '#' => {
                end = line.start + k;
                break;
            }
            None => scan.take(text, line.start + k, c),
        }
    }
    scan.end_value(text, end);
    scan.found
}

//! A fault shown in its lines of the source, underlined.

use case_io::diagnostic::SourcePosition;
use nndd_report::words::blanked;
use std::fmt::Write as _;

/// Lines shown before and after the one at fault.
const CONTEXT: usize = 1;

/// Draws the lines around a place, and underlines its bytes in the first of them.
///
/// * `source`: the text of the place, without control characters, its bytes where they were.
pub(super) fn excerpt(place: &SourcePosition, source: &str, colour: bool) -> String {
    let [strong, end] = if colour { ["\x1b[1;31m", "\x1b[0m"] } else { [""; 2] };
    let first = place.line.saturating_sub(CONTEXT).max(1);
    let digits = (place.line + CONTEXT).to_string().len();
    let mut text = String::new();
    for (line, content) in source.lines().enumerate().skip(first - 1).take(place.line + CONTEXT + 1 - first) {
        let number = line + 1;
        let _ = writeln!(text, "{}", format!(" {number:>digits$} | {}", blanked(content)).trim_end());
        if number == place.line {
            let before = place.column - 1;
            let marked = source.get(place.span.clone()).and_then(|s| s.lines().next()).unwrap_or_default();
            let marks = "^".repeat(marked.chars().count().max(1));
            let _ = writeln!(text, " {:digits$} | {:before$}{strong}{marks}{end}", "", "");
        }
    }
    text
}

//! Numbers and texts as people read them.

use std::borrow::Cow;

/// Writes a number exactly, with an exponent where it would be a long row of digits.
pub(crate) fn short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e6).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// Counts things: `1 iteration`, `2 iterations`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Says whether a character would command a terminal.
fn commands(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
}

/// Writes characters that would command a terminal by their codes.
pub(crate) fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(commands) {
        return text.into();
    }
    let shown = |c: char| if commands(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect::<String>().into()
}

/// Replaces such characters by blanks, each byte by one, so that places in the text stay where they are.
pub(crate) fn blanked(text: &str) -> String {
    let mut blanked = String::with_capacity(text.len());
    for c in text.chars() {
        if commands(c) { blanked.extend(std::iter::repeat_n(' ', c.len_utf8())) } else { blanked.push(c) }
    }
    blanked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_rows_of_digits_get_an_exponent() {
        let written = [0.0, 0.1, -2.5, 1e-30, -1e300].map(short);
        assert_eq!(written, ["0", "0.1", "-2.5", "1e-30", "-1e300"]);
        assert_eq!([1, 2].map(|n| counted(n, "mesh node")), ["1 mesh node", "2 mesh nodes"]);
    }

    #[test]
    fn nothing_commands_the_terminal() {
        assert_eq!(plain("a\u{1b}[31mb\nü\t\u{9b}"), "a\\u{1b}[31mb\nü\t\\u{9b}");
        assert!(matches!(plain("Größe\n"), Cow::Borrowed(_)));
        let text = "a\u{1b}ü\u{9b}\r\n";
        assert_eq!((blanked(text).as_str(), blanked(text).len()), ("a ü   \n", text.len()));
    }
}

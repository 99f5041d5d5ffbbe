//! Words of messages that this crate and those on top of it share.

/// Counts things in words: `1 node`, `3 nodes`.
pub fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// Writes a text as the content of an element of XML or HTML. Characters that XML 1.0 cannot hold at all, such as U+0001 and
/// U+FFFE, are written by their codes: `\u{fffe}`.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            // A reader of XML makes a line feed of it.
            '\r' => out += "&#13;",
            '\n' | '\t' => out.push(c),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => out.extend(c.escape_unicode()),
            _ => out.push(c),
        }
    }
    out
}

/// Writes a text as the value of an attribute of XML or HTML, see [`escaped`]: a reader of XML makes a blank of a line feed
/// that is not a reference.
pub(crate) fn attribute(text: &str) -> String {
    escaped(text).replace('\n', "&#10;").replace('\t', "&#9;")
}

/// Names that a message lists.
const MOST_LISTED: usize = 20;
/// Nobody misspells a name this long; distances are quadratic in the length.
const LONGEST_NAME: usize = 200;

/// Lists names for a message, the first twenty.
pub fn listed(names: &[&str]) -> String {
    let mut words: Vec<String> = names.iter().take(MOST_LISTED).map(|n| format!("\"{n}\"")).collect();
    if names.len() > words.len() {
        words.push(format!("… ({} altogether)", names.len()));
    }
    words.join(", ")
}

/// Finds the name nearest to a misspelt one, if one is near enough to be meant.
///
/// ```
/// assert_eq!(mesh_io::words::nearest("uper", ["upper", "lower"]), Some("upper"));
/// ```
pub fn nearest<'a>(found: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    nearest_of(found, &mut names.into_iter())
}

fn nearest_of<'a>(found: &str, names: &mut dyn Iterator<Item = &'a str>) -> Option<&'a str> {
    if found.len() > LONGEST_NAME {
        return None;
    }
    let distance = |name: &&str| strsim::damerau_levenshtein(&found.to_lowercase(), &name.to_lowercase());
    let best = names.min_by_key(distance)?;
    let limit = 1 + found.chars().count().max(best.chars().count()) / 4;
    (distance(&best) <= limit).then_some(best)
}

/// Makes the help "did you mean …?" if a name is near enough, with quotes of the caller's choice.
pub fn did_you_mean<'a>(
    found: &str,
    names: impl IntoIterator<Item = &'a str>,
    quote: char,
) -> Option<String> {
    nearest(found, names).map(|name| format!("did you mean {quote}{name}{quote}?"))
}

#[cfg(test)]
mod tests {
    use super::{attribute, escaped, nearest};

    #[test]
    fn xml_holds_any_text() {
        assert_eq!(escaped("a&b<c>\"d\"\n\r"), "a&amp;b&lt;c&gt;&quot;d&quot;\n&#13;");
        assert_eq!(escaped("\0\u{1}\u{1f}\u{fffe}\u{ffff}"), "\\u{0}\\u{1}\\u{1f}\\u{fffe}\\u{ffff}");
        assert_eq!(attribute("a\tb\nc'\u{202e}Ü\u{7f}"), "a&#9;b&#10;c'\u{202e}Ü\u{7f}");
    }

    #[test]
    fn only_near_names_are_offered() {
        assert_eq!(nearest("theata", ["theta", "path"]), Some("theta"));
        assert_eq!(nearest("Stiff", ["soft", "stiff"]), Some("stiff"));
        assert_eq!(nearest("zzz", ["theta", "path"]), None);
    }
}

//! Phrases that make prose hard to read: most are refused, three words and two turns of comments are only counted.

use super::finding::Finding;
use std::fmt;

/// This file, which holds the list and is not checked.
const LIST: &str = "xtask/src/tidy/words.rs";

/// Phrases that are refused, in lower case, and what to write instead.
const REFUSED: [(&str, &str); 11] = [
    ("so many", "the number, `this many` or `at most n`"),
    ("go on", "`continue` or `resume`"),
    ("goes on", "`continues` or `resumes`"),
    ("going on", "`continuing` or `resuming`"),
    ("anew", "`again` or `from scratch`"),
    ("is none", "what is missing"),
    ("are none", "what is missing"),
    ("worth the while", "`useful` or `worthwhile`"),
    ("nothing stands against", "`no problem found`"),
    ("is no number", "`is NaN` or `is not a number`"),
    ("by which road", "`by which method`"),
];

/// Counts of three words and of two turns of comments that are seldom the best ones.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// `where`, often written for `if` or `when`.
    place: usize,
    /// `stand` and `stands`, often written for `is`.
    stand: usize,
    /// `none`, often written for what is missing.
    none: usize,
    /// Comments of Rust files that begin with `What`, `Where` or `Whether` instead of a noun or a verb.
    begin: usize,
    /// Lines of such comments with `that of` or `those of` instead of the noun.
    that_of: usize,
}

impl Counts {
    /// Adds the words of a file: of a page, or of the comments and strings of a Rust file.
    pub(super) fn add(&mut self, file: &str, text: &str) {
        if file == LIST {
            return;
        }
        let is_rust = file.ends_with(".rs");
        for line in text.lines() {
            if let Some(comment) = comment(line).filter(|_| is_rust) {
                let lower = comment.to_lowercase();
                let has = |turn| occurrences(&lower, turn) > 0;
                self.begin += usize::from(begins_late(comment));
                self.that_of += usize::from(has("that of") || has("those of"));
            }
            let prose = if is_rust { rust_prose(line) } else { line.to_owned() };
            let lower = prose.to_lowercase();
            self.place += occurrences(&lower, "where");
            self.stand += occurrences(&lower, "stand") + occurrences(&lower, "stands");
            self.none += occurrences(&prose, "none");
        }
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Counts { place, stand, none, begin, that_of } = self;
        write!(
            f,
            "note: words to use sparingly: where {place}, stand(s) {stand}, none {none}; \
             comments that begin with What, Where or Whether: {begin}; with 'that of' or 'those of': {that_of}"
        )
    }
}

/// Finds the refused phrases in the lines of a file.
pub(super) fn findings(file: &str, text: &str) -> Vec<Finding> {
    let mut findings = vec![];
    if file == LIST {
        return findings;
    }
    for (i, line) in text.lines().enumerate() {
        let lower = line.to_lowercase();
        for (phrase, instead) in REFUSED {
            if occurrences(&lower, phrase) > 0 {
                findings.push(Finding::new(file, i + 1, format!("found \"{phrase}\", expected {instead}")));
            }
        }
    }
    findings
}

/// Counts a phrase in a line, as whole words.
fn occurrences(line: &str, phrase: &str) -> usize {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let whole = |at: usize| {
        let before = line[..at].chars().next_back();
        let after = line[at + phrase.len()..].chars().next();
        !before.is_some_and(part) && !after.is_some_and(part)
    };
    line.match_indices(phrase).filter(|(at, _)| whole(*at)).count()
}

/// Returns the text of the comment on a Rust line. Two slashes in a string count as well.
fn comment(line: &str) -> Option<&str> {
    line.split_once("//").map(|(_, text)| text.trim_start_matches(['/', '!']).trim_start())
}

/// Tells if a comment begins with one of the words that put off its noun.
fn begins_late(comment: &str) -> bool {
    let first = comment.split(|c: char| !c.is_alphanumeric()).next();
    matches!(first, Some("What" | "Where" | "Whether"))
}

/// The comment of a Rust line and what it has within quotes. A string that continues from the line before is not seen.
fn rust_prose(line: &str) -> String {
    let mut prose = String::new();
    let (mut quoted, mut escaped) = (false, false);
    let mut previous = ' ';
    for (at, c) in line.char_indices() {
        if !quoted && line[at..].starts_with("//") {
            prose.push_str(&line[at..]);
            break;
        }
        // A quote within single quotes is a character.
        if c == '"' && !escaped && (quoted || previous != '\'') {
            quoted = !quoted;
            prose.push(' ');
        } else if quoted {
            prose.push(c);
        }
        escaped = quoted && c == '\\' && !escaped;
        previous = c;
    }
    prose
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phrases_are_refused_as_whole_words() {
        let text = "a line\n/// So many cells, and it goes on.\nlet anew_ = 1; // renewed\n";
        let found = findings("a.rs", text);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|f| f.file == "a.rs" && f.line == 2));
        assert!(found[0].what.contains("\"so many\"") && found[0].what.contains("this many"));
        assert!(found[1].what.contains("continues"));
    }

    #[test]
    fn every_refused_phrase_is_found_in_lower_case() {
        for (phrase, instead) in REFUSED {
            assert_eq!(phrase, phrase.to_lowercase());
            let found = findings("a.md", &format!("It {}.", phrase.to_uppercase()));
            assert!(found.iter().any(|f| f.what.contains(phrase) && f.what.contains(instead)), "{phrase}");
        }
    }

    #[test]
    fn a_phrase_over_two_lines_is_not_found() {
        assert!(findings("a.md", "so\nmany").is_empty());
    }

    #[test]
    fn the_list_does_not_find_itself() {
        assert!(findings(LIST, "so many").is_empty());
        let mut counts = Counts::default();
        counts.add(LIST, "// where");
        assert_eq!(counts, Counts::default());
    }

    #[test]
    fn words_are_counted_in_comments_and_strings_only() {
        let mut counts = Counts::default();
        counts.add("a.rs", "fn f<T>() where T: Copy {\n    // Where it stands: none.\n");
        counts.add("a.rs", "let none = ('\"', \"where \\\" none\"); // None, nonetheless\n");
        assert_eq!(counts, Counts { place: 2, stand: 1, none: 2, begin: 1, that_of: 0 });
        counts.add("a.md", "Where they stand.\n");
        assert_eq!(counts, Counts { place: 3, stand: 2, none: 2, begin: 1, that_of: 0 });
        let shown = counts.to_string();
        assert!(shown.starts_with("note: words to use sparingly: where 3, stand(s) 2, none 2; "), "{shown}");
    }

    #[test]
    fn comments_that_name_the_thing_late_are_counted() {
        let mut counts = Counts::default();
        counts.add(
            "a.rs",
            "/// What it has: that of `b`, and those of `c`.\nlet a = 1; // Whether. Those of d\n",
        );
        assert_eq!(counts, Counts { begin: 2, that_of: 2, ..Counts::default() });
        counts.add("a.rs", "//! Whatever it has\n// of that; what if\nlet a = \"What, that of\";\n");
        counts.add("a.md", "What is that of?\n");
        assert_eq!(counts, Counts { begin: 2, that_of: 2, ..Counts::default() });
        assert!(counts.to_string().ends_with("Whether: 2; with 'that of' or 'those of': 2"), "{counts}");
    }
}

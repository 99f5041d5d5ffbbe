//! Sources cited as `Prager and Synge 1947`: each cited in a comment must be in REFERENCES.bib, and each entry there
//! must be cited, in a comment or on a page (.md).

use super::finding::Finding;
use std::collections::BTreeSet;

/// The file of the sources.
pub(crate) const BIBLIOGRAPHY: &str = "REFERENCES.bib";

/// One entry of the bibliography: where it begins, its name, the last word of each author's surname in plain letters, and
/// its year.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    line: usize,
    key: String,
    surnames: Vec<String>,
    year: String,
}

/// Reads a bibliography whose entries begin with `@` in the first column, with `author` and `year` on one line each.
pub(crate) fn entries(bibliography: &str) -> Vec<Entry> {
    let field = |entry: &str, name: &str| -> String {
        let Some((_, after)) = entry.split_once(&format!("{name} = {{")) else { return String::new() };
        let mut depth = 1;
        let inside = after.chars().take_while(|c| {
            depth += i32::from(*c == '{') - i32::from(*c == '}');
            depth > 0
        });
        inside.collect()
    };
    let mut line = 1;
    let entry = |text: &str| {
        let authors = field(text, "author").replace("\\v ", "");
        let authors = authors.chars().filter(|c| c.is_alphanumeric() || c.is_whitespace() || *c == ',');
        let authors: String = authors.collect();
        let surname =
            |author: &str| author.split(',').next().and_then(|s| s.split(' ').next_back()).map(plain);
        let surnames = authors.split(" and ").filter_map(surname).collect();
        let key = text.split(['{', ',']).nth(1).unwrap_or_default().to_owned();
        let entry = Entry { line, key, surnames, year: field(text, "year") };
        line += text.matches('\n').count() + 1;
        entry
    };
    bibliography.split("\n@").map(entry).collect()
}

/// A possible citation: its line, the word before the year as it is written, and the year.
struct Citation {
    line: usize,
    surname: String,
    year: String,
}

impl Citation {
    fn is_of(&self, entry: &Entry) -> bool {
        entry.year == self.year && entry.surnames.contains(&plain(&self.surname))
    }
}

/// The prose of a file, line by line: the comments of a Rust file, a page as a whole.
fn prose<'a>(file: &str, text: &'a str) -> Vec<Option<&'a str>> {
    let comment =
        |line: &'a str| line.split_once("//").map(|(_, after)| after.trim_start_matches(['/', '!']));
    if file.ends_with(".md") { text.lines().map(Some).collect() } else { text.lines().map(comment).collect() }
}

/// Finds possible citations in the prose of a file: a word, then a year.
fn citations(file: &str, text: &str) -> Vec<Citation> {
    let mut citations = vec![];
    // The word before, for a citation broken between two lines.
    let mut before = String::new();
    for (i, line) in prose(file, text).into_iter().enumerate() {
        let Some(line) = line else {
            before.clear();
            continue;
        };
        for word in line.split_whitespace() {
            let year = word.trim_matches(|c: char| !c.is_alphanumeric());
            let digits = year.len() == 4 && year.bytes().all(|b| b.is_ascii_digit());
            let is_year = digits && (year.starts_with("19") || year.starts_with("20"));
            if is_year && !before.is_empty() {
                citations.push(Citation { line: i + 1, surname: before, year: year.to_owned() });
            }
            before = word.to_owned();
        }
    }
    citations
}

/// Finds the citations in the comments of a file that no entry answers.
pub(crate) fn findings(file: &str, text: &str, entries: &[Entry]) -> Vec<Finding> {
    let unknown = |c: &Citation| is_surname(&c.surname) && !entries.iter().any(|e| c.is_of(e));
    let finding = |Citation { line, surname, year }: Citation| {
        Finding::new(file, line, format!("found {surname} {year}, expected an entry in {BIBLIOGRAPHY}"))
    };
    citations(file, text).into_iter().filter(unknown).map(finding).collect()
}

/// Names the entries that a file cites. One without a year is cited by all its authors' surnames in one line.
pub(crate) fn cited(file: &str, text: &str, entries: &[Entry]) -> BTreeSet<String> {
    let citations = citations(file, text);
    let named: Vec<Vec<String>> =
        prose(file, text).into_iter().flatten().map(|l| l.split_whitespace().map(plain).collect()).collect();
    let is_cited = |e: &&Entry| match e.year.as_str() {
        "" => named.iter().any(|words| e.surnames.iter().all(|name| words.contains(name))),
        _ => citations.iter().any(|c| c.is_of(e)),
    };
    entries.iter().filter(is_cited).map(|e| e.key.clone()).collect()
}

/// Finds the entries that are in no file's list of cited ones.
pub(crate) fn uncited(entries: &[Entry], cited: &BTreeSet<String>) -> Vec<Finding> {
    let what = |key| format!("found {key}, which nothing cites; expected a comment that does, or no entry");
    let missing = entries.iter().filter(|e| !cited.contains(&e.key));
    missing.map(|e| Finding::new(BIBLIOGRAPHY, e.line, what(&e.key))).collect()
}

/// Tells if a word begins with a capital and continues in small letters, without a mark behind it.
fn is_surname(word: &str) -> bool {
    let word = word.trim_start_matches(['(', '[']);
    let mut letters = word.chars();
    letters.next().is_some_and(char::is_uppercase)
        && word.chars().count() > 2
        && letters.all(|c| c.is_lowercase() || c == '-')
}

/// A name in ASCII letters: accents are left out, as the marks of TeX are.
fn plain(name: &str) -> String {
    let letter = |c: char| match c {
        'á' | 'à' | 'ä' => 'a',
        'é' | 'è' | 'ë' => 'e',
        'í' => 'i',
        'ó' | 'ö' => 'o',
        'ú' | 'ü' => 'u',
        'č' => 'c',
        other => other,
    };
    name.chars().map(letter).filter(char::is_ascii_alphanumeric).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BIB: &str = "@article{A1996,\n  author = {D{\\\"o}rfler, Willy}, year = {1996}\n}\n\
        @article{B,\n  author = {Haslinger, Jaroslav and Ku{\\v c}era, Radek}, year = {2009}\n}\n\n\
        @book{C,\n  author = {Choi, Daniel and Gallimard, Laurent and Sassi, Taoufik}\n}\n\
        @article{D,\n  author = {Walker, Homer F. and Ni, Peng},\n  year = {2011}\n}\n";

    #[test]
    fn accents_of_tex_and_of_text_agree() {
        let entries = entries(BIB);
        assert_eq!(entries.len(), 4);
        for known in ["//! Source: Dörfler 1996.", "// (Haslinger and\n// Kučera 2009)", "/// Dörfler (1996)"]
        {
            assert_eq!(findings("a.rs", known, &entries), [], "{known}");
        }
    }

    #[test]
    fn unknown_source_and_wrong_year_are_found() {
        let entries = entries(BIB);
        for unknown in ["// Dörfler 1997", "/// after Prager and\n/// Synge 1947."] {
            assert_eq!(findings("a.rs", unknown, &entries).len(), 1, "{unknown}");
        }
        for none in ["let x = 1996; // of 2000 cells", "// E 2000, 1998", "// Größe w·n", "let Young = 1999;"]
        {
            assert_eq!(findings("a.rs", none, &entries), [], "{none}");
        }
    }

    #[test]
    fn an_entry_that_nothing_cites_is_found_with_its_line() {
        let found = |file, text| uncited(&entries(BIB), &cited(file, text, &entries(BIB)));
        let lines = |file, text| found(file, text).iter().map(|f| f.line).collect::<Vec<_>>();
        assert_eq!(lines("a.rs", "let none = 0;"), [1, 4, 8, 11]);
        assert_eq!(lines("a.rs", "// Dörfler 1996, after Kučera\n// 2009."), [8, 11]);
        assert_eq!(lines("page.md", "by Dörfler 1996"), [4, 8, 11]);
        assert_eq!(lines("a.rs", "// after Walker and Ni 2011"), [1, 4, 8]);
        // Code does not cite, a wrong year does not, and an entry without a year needs all its authors.
        assert_eq!(lines("a.rs", "let text = \"Dörfler 1996\";"), [1, 4, 8, 11]);
        assert_eq!(lines("a.rs", "// Dörfler 1997"), [1, 4, 8, 11]);
        assert_eq!(lines("a.rs", "// Choi and Sassi"), [1, 4, 8, 11]);
        assert_eq!(lines("a.rs", "// of Choi, Gallimard and Sassi."), [1, 4, 11]);
        assert_eq!(
            found("a.rs", "")[2].what,
            "found C, which nothing cites; expected a comment that does, or no entry"
        );
    }
}

//! Sources cited in comments, such as `Prager and Synge 1947`: each must stand in REFERENCES.bib.

use super::finding::Finding;

/// The file of the sources.
pub(crate) const BIBLIOGRAPHY: &str = "REFERENCES.bib";

/// One entry of the bibliography: its authors in plain letters, and its year.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    authors: Vec<String>,
    year: String,
}

/// Reads authors and years of a bibliography whose fields `author` and `year` stand on one line each.
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
    let entry = |text: &str| {
        let authors = field(text, "author").replace("\\v ", "");
        let authors = authors.chars().filter(|c| c.is_alphanumeric() || c.is_whitespace() || *c == ',');
        let authors: String = authors.collect();
        Entry { authors: authors.split([' ', ',']).map(plain).collect(), year: field(text, "year") }
    };
    bibliography.split("\n@").map(entry).collect()
}

/// Finds the citations in the comments of a file, surname and year, that no entry answers.
pub(crate) fn findings(file: &str, text: &str, entries: &[Entry]) -> Vec<Finding> {
    let mut findings = vec![];
    // The word before, for a citation broken between two lines.
    let mut before = String::new();
    for (i, line) in text.lines().enumerate() {
        let Some((_, comment)) = line.split_once("//") else {
            before.clear();
            continue;
        };
        for word in comment.trim_start_matches(['/', '!']).split_whitespace() {
            let year = word.trim_matches(|c: char| !c.is_alphanumeric());
            let digits = year.len() == 4 && year.bytes().all(|b| b.is_ascii_digit());
            let is_year = digits && (year.starts_with("19") || year.starts_with("20"));
            if is_year && is_surname(&before) {
                let surname = plain(&before);
                let known = entries.iter().any(|e| e.year == year && e.authors.contains(&surname));
                if !known {
                    let what = format!("found {before} {year}, expected an entry in {BIBLIOGRAPHY}");
                    findings.push(Finding::new(file, i + 1, what));
                }
            }
            before = word.to_owned();
        }
    }
    findings
}

/// Whether a word begins with a capital and goes on in small letters, without a mark behind it.
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
        @article{B,\n  author = {Haslinger, Jaroslav and Ku{\\v c}era, Radek}, year = {2009}\n}\n";

    #[test]
    fn accents_of_tex_and_of_text_agree() {
        let entries = entries(BIB);
        assert_eq!(entries.len(), 2);
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
}

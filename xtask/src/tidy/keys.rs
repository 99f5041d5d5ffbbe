//! The keys and values of a case file: each has its place in the matrix of promises.

use super::finding::Finding;
use std::collections::BTreeSet;

/// The page of the keys.
pub(super) const PAGE: &str = "tests/cases/README.md";
/// The table of the matrix of promises.
pub(super) const TABLE: &str = "tests/support/matrix/keys.toml";

/// Lists the words in code of the page's tables by section, with their lines.
fn words(page: &str) -> BTreeSet<(String, String, usize)> {
    let mut found = BTreeSet::new();
    let mut section = "file".to_owned();
    let rows = (1..).zip(page.lines()).take_while(|(_, row)| !row.starts_with("`bad/`"));
    for (line, row) in rows.filter(|(_, row)| row.starts_with('|')) {
        let codes: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
        if let Some(name) = codes.first().filter(|_| row.starts_with("| **`[")) {
            section = name.trim_matches(['[', ']']).to_owned();
        } else if codes.first() == Some(&"generator") && row.starts_with("| `generator` | keys") {
            section = "generator".to_owned();
        }
        // A name in brackets is a table, whose section has its own rows.
        for code in codes.iter().filter(|code| !code.starts_with('[')) {
            let all = code.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-'));
            for word in all.filter(|w| w.len() > 1 && w.starts_with(|c: char| c.is_ascii_alphabetic())) {
                found.insert((section.clone(), word.to_owned(), line));
            }
        }
    }
    found
}

/// Compares the page with the table: every word has an entry, every entry a word.
pub(super) fn findings(page: &str, table: &str) -> Vec<Finding> {
    let table: toml::Table = match table.parse() {
        Ok(table) => table,
        Err(error) => return vec![Finding::new(TABLE, 1, format!("found {error}, expected TOML"))],
    };
    let words = words(page);
    let entry = |section: &str, word: &str| table.get(section)?.get(word)?.as_str();
    let missing = words.iter().filter(|(section, word, _)| entry(section, word).is_none());
    let mut findings: Vec<Finding> = missing
        .map(|(section, word, line)| {
            Finding::new(PAGE, *line, format!("found `{word}` of [{section}] without an entry in {TABLE}"))
        })
        .collect();
    let on_page: BTreeSet<(&str, &str)> = words.iter().map(|(s, w, _)| (s.as_str(), w.as_str())).collect();
    for (section, entries) in &table {
        let entries = entries.as_table().into_iter().flat_map(toml::Table::keys);
        for word in entries.filter(|word| !on_page.contains(&(section, word))) {
            findings.push(Finding::new(
                TABLE,
                1,
                format!("found `{word}` of [{section}], which {PAGE} does not name"),
            ));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE_TEXT: &str = "| `schema` | | required | 1 |\n| **`[solver]`** | | | |\n| `method` | | `auto` | or `nndd`; see `[adapt]` |\n";

    #[test]
    fn every_word_needs_an_entry_and_every_entry_a_word() {
        let table = "[file]\nschema = \"a\"\n[solver]\nmethod = \"a\"\nauto = \"a\"\nnndd = \"a\"\n";
        assert_eq!(findings(PAGE_TEXT, table), []);
        let found = findings(PAGE_TEXT, &table.replace("nndd", "newton"));
        let said: Vec<&str> = found.iter().map(|f| f.what.as_str()).collect();
        assert!(said.len() == 2 && said[0].contains("`nndd`") && said[1].contains("`newton`"), "{said:?}");
    }
}

//! A keyword line: its name and parameters.

use super::data;

/// A keyword with its parameters; names in upper case with single blanks.
pub(super) struct Keyword {
    pub(super) name: String,
    parameters: Vec<(String, Option<String>)>,
}

impl Keyword {
    /// Parses `*NAME, KEY=VALUE, FLAG`, without the star.
    pub(super) fn parse(line: &str) -> Self {
        let mut parts = data::split_quoted(line).into_iter();
        let name = upper(parts.next().unwrap_or_default());
        let parameters = parts
            .filter(|part| !part.trim().is_empty())
            .map(|part| match part.split_once('=') {
                Some((key, value)) => (upper(key), Some(data::unquoted(value).to_owned())),
                None => (upper(part), None),
            })
            .collect();
        Self { name, parameters }
    }

    /// Returns the value of a parameter; an empty one counts as missing.
    pub(super) fn value(&self, key: &str) -> Option<&str> {
        let found = self.parameters.iter().find(|(k, _)| k == key)?;
        found.1.as_deref().filter(|value| !value.is_empty())
    }

    /// Says whether a parameter is there, with or without a value.
    pub(super) fn has(&self, key: &str) -> bool {
        self.parameters.iter().any(|(k, _)| k == key)
    }
}

/// Writes a word in upper case, blanks between its parts made single.
pub(super) fn upper(text: &str) -> String {
    let words: Vec<String> = text.split_whitespace().map(str::to_uppercase).collect();
    words.join(" ")
}

//! The settings of a run as a case file in TOML.

use crate::words::json;
use serde_json::{Map, Value};
use std::fmt::Write as _;

/// Writes settings in the structure of the case file as TOML that a case file may hold. Keys without a value are left out.
pub(crate) fn toml(settings: &Value) -> String {
    let mut text = String::new();
    if let Value::Object(root) = settings {
        table(&mut text, root, &mut Vec::new());
    }
    text.trim_start().to_owned()
}

/// Writes the values of a table, then the tables in it.
fn table(text: &mut String, object: &Map<String, Value>, path: &mut Vec<String>) {
    for (key, value) in object.iter().filter(|(_, value)| !below(value)) {
        if let Some(value) = inline(value) {
            let _ = writeln!(text, "{} = {value}", bare(key));
        }
    }
    for (key, value) in object.iter().filter(|(_, value)| below(value)) {
        path.push(bare(key));
        let (tables, marks) = match value {
            Value::Array(items) => (items.iter().collect(), ["[[", "]]"]),
            one => (vec![one], ["[", "]"]),
        };
        for one in tables.into_iter().filter_map(Value::as_object) {
            let own = one.values().any(|v| !below(v) && !v.is_null()) || one.is_empty();
            if own || marks[0] == "[[" {
                let _ = writeln!(text, "\n{}{}{}", marks[0], path.join("."), marks[1]);
            }
            table(text, one, path);
        }
        path.pop();
    }
}

/// Says whether a value gets a table of its own: larger objects, and lists of objects.
fn below(value: &Value) -> bool {
    match value {
        Value::Object(object) => !object.contains_key("kind") && !object.contains_key("file"),
        Value::Array(items) => !items.is_empty() && items.iter().all(Value::is_object),
        _ => false,
    }
}

/// Writes a value on one line; `None` for null.
fn inline(value: &Value) -> Option<String> {
    Some(match value {
        Value::Null => return None,
        Value::Array(items) => {
            let items: Vec<String> = items.iter().filter_map(inline).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Object(object) => {
            let entry = |(key, value): (&String, &Value)| Some(format!("{} = {}", bare(key), inline(value)?));
            let entries: Vec<String> = object.iter().filter_map(entry).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        // Strings of JSON are strings of TOML: the escapes of the one are escapes of the other.
        other => json(other),
    })
}

/// A key, in quotes if it must be.
fn bare(key: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    if !key.is_empty() && key.chars().all(plain) { key.to_owned() } else { json(&Value::from(key)) }
}

#[cfg(test)]
mod tests {
    use super::toml;
    use case_io::Case;

    #[test]
    fn the_settings_of_every_example_are_a_case_with_the_same_settings() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let files: Vec<_> = files.filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
        assert!(files.len() > 15);
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let settings = Case::parse(&text, "case.toml", &[]).unwrap().settings_json();
            let written = toml(&settings);
            let again = Case::parse(&written, "case.toml", &[]);
            let again = again.unwrap_or_else(|e| panic!("{}: {e}\n{written}", file.display()));
            assert_eq!(again.settings_json(), settings, "{}\n{written}", file.display());
        }
    }
}

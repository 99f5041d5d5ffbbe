//! The page of the case file's keys, `cases/README.md`, lists every key.

use case_io::Case;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Adds the keys of all settings, less the names that users give.
fn collect(settings: &Value, keys: &mut BTreeSet<String>) {
    match settings {
        Value::Object(object) => {
            for (key, value) in object {
                keys.insert(key.clone());
                match (key.as_str(), value) {
                    // Names that users give.
                    ("factors", _) => {}
                    ("materials", Value::Object(materials)) => {
                        materials.values().for_each(|m| collect(m, keys))
                    }
                    _ => collect(value, keys),
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| collect(value, keys)),
        _ => {}
    }
}

#[test]
fn every_key_of_every_example_stands_on_the_page() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let page = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let mut keys = BTreeSet::new();
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let text = std::fs::read_to_string(&path).unwrap();
            collect(&Case::parse(&text, "case.toml", &[]).unwrap().settings_json(), &mut keys);
        }
    }
    assert!(keys.len() > 40, "{keys:?}");
    // A key is alone between backticks, or a word in a line of code.
    let words: BTreeSet<&str> = page
        .split('`')
        .skip(1)
        .step_by(2)
        .flat_map(|c| c.split(|c: char| !c.is_alphanumeric() && c != '_'))
        .collect();
    let missing: Vec<&String> = keys.iter().filter(|key| !words.contains(key.as_str())).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

//! `report.json` of every case satisfies its schema, and the page of its keys says what the schema says.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::JSON_SCHEMA;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Keys that no short run has: it was resumed or ended by its time limit, its bound rose with the mesh, a load was left out, or it has Coulomb
/// friction with `[adapt]` or `[[step]]`.
const RARE: [&str; 12] = [
    "certificate.projected_load[].body",
    "certificate.projected_load[].motion",
    "certificate.projected_load[].load",
    "certificate.projected_load[].share",
    "certificate.smallest_mesh",
    "run.resumed_on_mesh",
    "run.longest_step",
    "run.longest_step.step",
    "run.longest_step.seconds",
    "adaptive[].e_b",
    "adaptive[].relative_residual",
    "steps[].coulomb",
];

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases")
}

fn schema() -> Value {
    serde_json::from_str(JSON_SCHEMA).unwrap()
}

/// One key of the schema.
struct Key {
    path: String,
    /// In the plane, and of solids.
    units: [String; 2],
    meaning: String,
}

/// Lists the keys below a schema in their order; a list adds `[]` to its path.
fn keys(schema: &Value, path: &str, found: &mut Vec<Key>) {
    if let Some(items) = schema.get("items") {
        keys(items, &format!("{path}[]"), found);
    }
    for (name, property) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        let text = |key: &str| property.get(key).and_then(Value::as_str).map(str::to_owned);
        let unit = text("x-unit").unwrap_or_default();
        let units = [unit.clone(), text("x-unit-solid").unwrap_or(unit)];
        found.push(Key { path: path.clone(), units, meaning: text("description").unwrap_or_default() });
        keys(property, &path, found);
    }
}

fn all_keys() -> Vec<Key> {
    let mut found = Vec::new();
    keys(&schema(), "", &mut found);
    found
}

/// Collects the paths of the keys of a report, without the keys of the settings.
fn collect(value: &Value, path: &str, seen: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) if path != "case" => {
            for (name, value) in object {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                seen.insert(path.clone());
                collect(value, &path, seen);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| collect(value, &format!("{path}[]"), seen)),
        _ => {}
    }
}

/// Lists where a value does not satisfy a schema, for the keywords that our schema has: another one is a failed test, so that none
/// is passed over.
fn complaints(schema: &Value, value: &Value, path: &str, found: &mut Vec<String>) {
    let mut complain = |what: String| found.push(format!("{path}: {what}"));
    for (keyword, wanted) in schema.as_object().unwrap() {
        let size = |length: Option<usize>| length.map(|length| length as u64);
        match keyword.as_str() {
            "$schema" | "title" | "description" | "x-unit" | "x-unit-solid" | "properties" | "items" => {}
            "type" => {
                let names = wanted.as_array().map_or_else(|| std::slice::from_ref(wanted), Vec::as_slice);
                if !names.iter().any(|name| is_of_type(value, name.as_str().unwrap())) {
                    complain(format!("{value} is not of type {wanted}"));
                }
            }
            "const" if value != wanted => complain(format!("{value} is not {wanted}")),
            "enum" if !wanted.as_array().unwrap().contains(value) => {
                complain(format!("{value} is not in {wanted}"))
            }
            "minimum" if value.as_f64().is_some_and(|x| x < wanted.as_f64().unwrap()) => {
                complain(format!("{value} is below {wanted}"));
            }
            "maximum" if value.as_f64().is_some_and(|x| x > wanted.as_f64().unwrap()) => {
                complain(format!("{value} is above {wanted}"));
            }
            "minItems" if size(value.as_array().map(Vec::len)) < wanted.as_u64() && value.is_array() => {
                complain(format!("{value} has fewer entries than {wanted}"));
            }
            "maxItems" if size(value.as_array().map(Vec::len)) > wanted.as_u64() => {
                complain(format!("{value} has more entries than {wanted}"));
            }
            "required" => {
                let keys = wanted.as_array().unwrap().iter().map(|key| key.as_str().unwrap());
                let missing =
                    keys.filter(|key| value.as_object().is_some_and(|object| !object.contains_key(*key)));
                missing.for_each(|key| complain(format!("the key {key} is missing")));
            }
            "additionalProperties" => {
                assert_eq!(*wanted, Value::Bool(false));
                let keys = value.as_object().into_iter().flat_map(|object| object.keys());
                let unknown = keys.filter(|key| schema["properties"].get(key.as_str()).is_none());
                unknown.for_each(|key| complain(format!("the key {key} is not in the schema")));
            }
            "const" | "enum" | "minimum" | "maximum" | "minItems" | "maxItems" => {}
            other => panic!("{path}: this test does not know the keyword {other}"),
        }
    }
    for (name, property) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
        if let Some(value) = value.get(name) {
            complaints(property, value, &format!("{path}/{name}"), found);
        }
    }
    if let (Some(items), Some(values)) = (schema.get("items"), value.as_array()) {
        for (k, value) in values.iter().enumerate() {
            complaints(items, value, &format!("{path}/{k}"), found);
        }
    }
}

fn is_of_type(value: &Value, name: &str) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        other => panic!("{other} is no type of JSON Schema"),
    }
}

fn all_complaints(report: &Value) -> Vec<String> {
    let mut found = Vec::new();
    complaints(&schema(), report, "", &mut found);
    found
}

/// Tells whether a case of `bad/` leaves a report: it is not refused, and no memory limit ends it.
fn leaves_a_report(path: &Path) -> bool {
    let text = std::fs::read(path).unwrap();
    [&b"# expect: exit 5\n"[..], b"# expect: exit 6\n"].iter().any(|line| text.starts_with(line))
}

#[test]
fn the_report_of_every_case_satisfies_the_schema() {
    let temp = tempfile::tempdir().unwrap();
    let files = |folder: &Path| -> Vec<PathBuf> {
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
    };
    let mut all = [files(&cases()), files(&cases().join("solid"))].concat();
    all.extend(
        files(&cases().join("bad")).into_iter().filter(|path| path.is_file() && leaves_a_report(path)),
    );
    all.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    all.sort();
    let (mut seen, mut reports) = (BTreeSet::new(), 0);
    for (k, case) in all.into_iter().enumerate() {
        // Cases of the plane and of solids may have the same name.
        let out = temp.path().join(k.to_string());
        let run = Command::new(env!("CARGO_BIN_EXE_nndd"))
            .args(["solve", "--quiet", "--set", "output.vtu=false"])
            .arg(&case)
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap();
        let text = std::fs::read_to_string(out.join("report.json"))
            .unwrap_or_else(|e| panic!("{}: {e}: {}", case.display(), String::from_utf8_lossy(&run.stderr)));
        let report: Value = serde_json::from_str(&text).unwrap();
        let found = all_complaints(&report);
        assert!(found.is_empty(), "{}: {found:#?}", case.display());
        collect(&report, "", &mut seen);
        reports += 1;
    }
    assert!(reports > 40, "{reports}");
    // The schema has no key that no report has.
    let unused: Vec<String> =
        all_keys().into_iter().map(|key| key.path).filter(|path| !seen.contains(path)).collect();
    let unused: Vec<&str> = unused.iter().map(String::as_str).filter(|path| !RARE.contains(path)).collect();
    assert!(unused.is_empty(), "{unused:?}");
}

#[test]
fn a_report_with_another_key_or_type_does_not_satisfy_the_schema() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let case = cases().join("patch.toml");
    let status = Command::new(env!("CARGO_BIN_EXE_nndd"))
        .args(["solve", "--quiet"])
        .arg(case)
        .arg("--out")
        .arg(&out)
        .status()
        .unwrap();
    assert!(status.success());
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(all_complaints(&report), Vec::<String>::new());
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut report = report.clone();
        change(&mut report);
        all_complaints(&report).join("; ")
    };
    for part in ["", "/status", "/bodies/0", "/certificate/parts", "/results", "/timings", "/run"] {
        let more = changed(&|report| report.pointer_mut(part).unwrap()["added"] = 1.into());
        assert!(more.contains("added"), "{part}: {more}");
    }
    assert!(!changed(&|report| report["certificate"]["e_cre"] = "0.1".into()).is_empty());
    assert!(!changed(&|report| report["results"]["balance"][0] = Value::Array(vec![])).is_empty());
    let fewer = changed(&|report| drop(report["status"].as_object_mut().unwrap().remove("word")));
    assert!(fewer.contains("word"), "{fewer}");
}

#[test]
fn the_page_of_the_keys_has_every_key_of_the_schema_with_its_unit_and_meaning() {
    let page = std::fs::read_to_string(cases().join("REPORT.md")).unwrap();
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    let row = |key: &Key| format!("| `{}` | {} | {} |", key.path, key.units.join(" | "), key.meaning);
    let expected: Vec<String> = all_keys().iter().map(row).collect();
    assert!(
        expected.len() > 100 && !expected.iter().any(|row| row.ends_with("|  |")),
        "a key without meaning"
    );
    for (row, expected) in rows.iter().zip(&expected) {
        assert_eq!(row, expected, "tests/cases/REPORT.md differs from crates/case-io/report.schema.json");
    }
    assert_eq!(rows.len(), expected.len());
}

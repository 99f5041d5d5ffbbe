//! The settings of two runs: those that differ, and the problems they make.

use case_io::checkpoint::differences;
use case_io::report::Report;
use serde_json::Value;

/// The relation of the problems of two runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problems {
    /// Both runs are of one problem.
    Same,
    /// The case is the same, and its meshes may make it another problem.
    OtherMeshes,
    /// Both runs have load steps: a bound is of the last increment.
    Increments,
    /// The problems differ.
    Other,
}

/// Settings that no number depends on.
const LABELS: [&str; 3] = ["title", "output", "limits"];
/// Settings of the method, which leave the problem as it is.
const METHOD: [&str; 2] = ["solver", "estimator"];
/// Keys of sides, parts and curves that depend on the mesh.
const ON_THE_MESH: [&str; 6] = ["curve", "surface", "side", "region", "part", "radius"];

/// Lists the settings that differ, with both values.
pub(super) fn settings(both: [&Report; 2]) -> Vec<String> {
    let [a, b] = both.map(|report| without(&report.case, &LABELS));
    differences(&a, &b)
}

/// Finds the relation of the problems of two runs.
pub(super) fn relation(both: [&Report; 2]) -> Problems {
    let differ = |of: fn(&Report) -> Value| {
        let [a, b] = both.map(of);
        a != b
    };
    if differ(|report| without_meshes(&meshed(report))) {
        return Problems::Other;
    }
    if both.iter().any(|report| !report.steps.is_empty()) {
        return Problems::Increments;
    }
    let sizes = |report: &Report| -> Vec<_> {
        report.bodies.iter().map(|body| (body.nodes, body.cells, body.unknowns)).collect()
    };
    // A mesh file may have changed, and only the hash of the case tells it.
    let [hash, other] = both.map(Report::case_hash);
    let same_files = hash.is_some() && hash == other || !names(&both[0].case, &["mesh"]);
    let same_meshes = !differ(meshed) && sizes(both[0]) == sizes(both[1]) && same_files;
    if same_meshes || both.iter().all(|report| is_straight(report)) {
        Problems::Same
    } else {
        Problems::OtherMeshes
    }
}

/// The settings that make the problem and its meshes.
fn meshed(report: &Report) -> Value {
    without(&without(&report.case, &LABELS), &METHOD)
}

/// The same without the settings that only make the meshes.
fn without_meshes(case: &Value) -> Value {
    let mut case = without(case, &["adapt"]);
    for body in case.get_mut("body").and_then(Value::as_array_mut).into_iter().flatten() {
        for (table, key) in [("generator", "cells"), ("mesh", "file")] {
            if let Some(table) = body.get_mut(table) {
                *table = without(table, &[key]);
            }
        }
    }
    case
}

/// A table without some of its keys.
fn without(table: &Value, keys: &[&str]) -> Value {
    let mut table = table.clone();
    if let Some(table) = table.as_object_mut() {
        table.retain(|key, _| !keys.contains(&key.as_str()));
    }
    table
}

/// Says if the problem is the same on every mesh: blocks with whole sides, and no data that are interpolated.
fn is_straight(report: &Report) -> bool {
    let bodies = report.case.get("body").and_then(Value::as_array);
    let is_block = |body: &Value| {
        let kind = body.pointer("/generator/kind").and_then(Value::as_str);
        kind.is_some_and(|kind| ["block", "box"].contains(&kind))
    };
    let interpolated = report.notes.iter().any(|note| note.contains("the bound is for"));
    bodies.is_some_and(|bodies| bodies.iter().all(is_block))
        && !names(&report.case, &ON_THE_MESH)
        && !interpolated
}

/// Says if a table or a table in it has one of the keys.
fn names(value: &Value, keys: &[&str]) -> bool {
    match value {
        Value::Object(table) => {
            table.iter().any(|(key, value)| keys.contains(&key.as_str()) || names(value, keys))
        }
        Value::Array(all) => all.iter().any(|value| names(value, keys)),
        _ => false,
    }
}

//! `nndd mesh`: what a mesh file holds.

use crate::args::{Format, Mesh};
use crate::console;
use case_io::diagnostic::Diagnostic;
use mesh_io::{GroupSummary, MeshFile, Summary};
use nndd_report::Failure;
use nndd_report::words::{components, seven, short};
use serde_json::{Value, json};
use std::fmt::Write as _;

pub(crate) fn command(options: &Mesh) -> Result<u8, Failure> {
    let file = mesh_io::read(&options.file)?;
    let summary = file.summary();
    match options.format {
        Format::Human => console::print(&human(&file, &summary))?,
        Format::Json => console::print_json(&object(&file, &summary))?,
    }
    Ok(0)
}

/// Names the members of a group, and their size, by its dimension.
fn members(group: &GroupSummary) -> [&'static str; 2] {
    match group.dimension {
        0 => ["nodes", ""],
        1 => ["edges", "length"],
        2 => ["cells", "area"],
        _ => ["volumes", "volume"],
    }
}

fn problems(summary: &Summary) -> Vec<String> {
    summary.problems.iter().map(Diagnostic::told).collect()
}

fn human(file: &MeshFile, summary: &Summary) -> String {
    let mut text = format!("{}   {}\n", file.name(), summary.format);
    let _ = writeln!(text, "  nodes           {}", summary.nodes);
    let cells: Vec<String> =
        summary.cells.iter().map(|(kind, count)| format!("{count} x {}", kind.name())).collect();
    let _ = writeln!(
        text,
        "  cells           {}",
        if cells.is_empty() { "none".into() } else { cells.join(", ") }
    );
    let _ = writeln!(text, "  edges           {}", summary.edges);
    let [low, high] = summary.bounding_box;
    let range = |c: usize| format!("[{}, {}]", short(low[c]), short(high[c]));
    let axes = if file.has_volumes() { 3 } else { 2 };
    let ranges: Vec<String> = (0..axes).map(range).collect();
    let _ = writeln!(text, "  bounding box    {}", ranges.join(" x "));
    if let Some(q) = &summary.quality {
        let (angle, cell, at) = (q.smallest_angle, q.cell, components(&q.at, seven));
        let _ = writeln!(text, "  smallest angle  {angle:.3} degrees, in element {cell} at {at}");
    }
    if !summary.groups.is_empty() {
        let width = summary.groups.iter().map(|g| g.name.chars().count()).max().unwrap_or(0).clamp(4, 40);
        let _ = writeln!(text, "\n  dim  {:<width$}  {:>9}", "name", "size");
        for group in &summary.groups {
            let [what, measure] = members(group);
            let size = group.measure.map(|m| format!("   {measure} {}", seven(m))).unwrap_or_default();
            let _ = writeln!(
                text,
                "  {:>3}  {:<width$}  {:>9} {what}{size}",
                group.dimension, group.name, group.members
            );
        }
    }
    for (head, lines) in [("note", &summary.notes), ("problem", &problems(summary))] {
        if !lines.is_empty() {
            text.push('\n');
        }
        for line in lines {
            let _ = writeln!(text, "  {head}: {line}");
        }
    }
    text
}

fn object(file: &MeshFile, summary: &Summary) -> Value {
    let cells: serde_json::Map<String, Value> =
        summary.cells.iter().map(|(kind, count)| (kind.name().to_owned(), json!(count))).collect();
    let groups: Vec<Value> = summary
        .groups
        .iter()
        .map(|g| {
            let mut group = json!({ "dimension": g.dimension, "name": g.name });
            let [what, measure] = members(g);
            group[what] = json!(g.members);
            if let Some(value) = g.measure {
                group[measure] = json!(value);
            }
            group
        })
        .collect();
    json!({
        "file": file.name(),
        "format": summary.format,
        "digest": file.digest(),
        "nodes": summary.nodes,
        "edges": summary.edges,
        "cells": cells,
        "groups": groups,
        "bounding_box": summary.bounding_box,
        "quality": summary.quality.as_ref().map(|q| json!({
            "smallest_angle": q.smallest_angle, "cell": q.cell, "at": q.at,
        })),
        "notes": summary.notes,
        "problems": problems(summary),
    })
}

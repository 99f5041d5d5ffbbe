//! `nndd mesh`: what a mesh file holds.

use crate::args::{Format, Mesh};
use crate::console;
use case_io::diagnostic::Diagnostic;
use mesh_io::{GroupSummary, MeshFile, Summary};
use nndd_report::Failure;
use nndd_report::mesh_file::{self, MeshContact, MeshSide};
use nndd_report::words::{components, seven, short};
use serde_json::{Value, json};
use std::fmt::Write as _;

pub(crate) fn command(options: &Mesh) -> Result<u8, Failure> {
    let file = mesh_io::read(&options.file)?;
    let summary = file.summary();
    let (sides, contacts) = mesh_file::sides(&file);
    match options.format {
        Format::Human => {
            let all = [human(&file, &summary), sides_in_words(&sides), contacts_in_words(&contacts)];
            console::print(&(all.concat() + &remarks(&summary)))?;
        }
        Format::Json => {
            let mut found = object(&file, &summary);
            found["sides"] = sides.iter().map(side_object).collect();
            found["facing"] = contacts.iter().map(contact_object).collect();
            console::print_json(&found)?;
        }
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
        let _ = writeln!(text, "  flattest cell   height / longest edge = {:.3}", q.height_ratio);
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
    text
}

/// Lists the sides of the bodies that the regions make.
fn sides_in_words(sides: &[MeshSide]) -> String {
    let mut text = String::new();
    if sides.is_empty() {
        return text;
    }
    let width = |name: fn(&MeshSide) -> &str| {
        sides.iter().map(|side| name(side).chars().count()).max().unwrap_or(0).clamp(6, 40)
    };
    let (regions, names) = (width(|side| &side.region), width(|side| &side.side));
    let _ = writeln!(
        text,
        "\n  {:<regions$}  {:<names$}  {:>9}  {:>13}  mean outward normal",
        "region", "side", "facets", "size"
    );
    for side in sides {
        // A zero of round-off says nothing.
        let normal: Vec<f64> = side.normal.iter().map(|x| (x * 1e3).round() / 1e3 + 0.0).collect();
        let _ = writeln!(
            text,
            "  {:<regions$}  {:<names$}  {:>9}  {:>13}  {}",
            side.region,
            side.side,
            side.facets,
            seven(side.measure),
            components(&normal, short)
        );
    }
    text
}

/// Contacts that are written out.
const MOST_CONTACTS: usize = 20;

/// Writes a table of a case file for each pair of sides that face each other.
fn contacts_in_words(contacts: &[MeshContact]) -> String {
    let mut text = String::new();
    if !contacts.is_empty() {
        text += "\n  surfaces that face each other within a tenth of a facet, for bodies with the names of their regions:\n";
    }
    for MeshContact { regions, sides, apart, .. } in contacts.iter().take(MOST_CONTACTS) {
        let _ = writeln!(text, "\n[[contact]]\nbodies   = {}\nsurfaces = {}", json!(regions), json!(sides));
        if let Some(distance) = apart {
            let _ = writeln!(text, "gap      = \"geometric\"   # up to {} apart", seven(*distance));
        }
    }
    if let Some(more) = contacts.len().checked_sub(MOST_CONTACTS).filter(|more| *more > 0) {
        let _ = writeln!(text, "\n  and {more} more");
    }
    text
}

fn side_object(side: &MeshSide) -> Value {
    json!({ "region": side.region, "side": side.side, "facets": side.facets, "size": side.measure, "normal": side.normal })
}

fn contact_object(contact: &MeshContact) -> Value {
    json!({ "regions": contact.regions, "sides": contact.sides, "apart": contact.apart })
}

/// Writes notes and problems.
fn remarks(summary: &Summary) -> String {
    let mut text = String::new();
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
            "smallest_angle": q.smallest_angle, "cell": q.cell, "at": q.at, "height_ratio": q.height_ratio,
        })),
        "notes": summary.notes,
        "problems": problems(summary),
    })
}

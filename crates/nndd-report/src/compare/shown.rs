//! A comparison as a table for people, and as JSON.

use super::{Comparison, Problems, Row, Values};
use crate::words::{at_most, lowered, one_line, raised, seven, short, with_digits};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// The width of the names.
const NAME: usize = 28;
/// The width of a difference.
const DIFFERENCE: usize = 13;
/// The width of a difference in per cent.
const PERCENT: usize = 9;
/// No line is wider.
const WIDTH: usize = 110;
/// The settings that are listed.
const MOST: usize = 12;
/// The digits of an interval, which is rounded outwards.
const DIGITS: usize = 5;

/// Writes the table, the settings that differ, and a sentence about the intervals.
pub fn table(found: &Comparison) -> String {
    let mut text = String::new();
    for (name, folder) in ["A", "B"].iter().zip(&found.folders) {
        let _ = writeln!(text, "{name}  {}", one_line(&folder.display().to_string()));
    }
    let shown: Vec<[String; 2]> = found.rows.iter().map(|row| values(&row.values)).collect();
    let width = |k: usize| shown.iter().map(|row| row[k].chars().count()).max().unwrap_or(1);
    let [a, b] = [width(0), width(1)];
    let _ = writeln!(
        text,
        "\n{:NAME$}  {:>a$}  {:>b$}  {:>DIFFERENCE$}  {:>PERCENT$}",
        "", "A", "B", "B - A", "%"
    );
    let mut of = "";
    for (row, [first, second]) in found.rows.iter().zip(&shown) {
        if row.of != of {
            of = &row.of;
            let _ = writeln!(text, "{}", cut(&one_line(of)));
        }
        let indent = if of.is_empty() { "" } else { "  " };
        let name = format!("{indent}{}", row.name);
        let line = format!("{name:NAME$}  {first:>a$}  {second:>b$}  {}", last_columns(row));
        let _ = writeln!(text, "{}", line.trim_end());
    }
    if !found.settings.is_empty() {
        text += "\nsettings of A and of B\n";
        for setting in found.settings.iter().take(MOST) {
            let _ = writeln!(text, "{}", cut(&format!("  {}", one_line(setting))));
        }
        if let Some(more) = found.settings.len().checked_sub(MOST).filter(|more| *more > 0) {
            let _ = writeln!(text, "  and {more} more");
        }
    }
    if let Some(said) = verdict(found) {
        let _ = writeln!(text, "\n{said}");
    }
    text
}

/// The difference, absolute and in per cent, or if two intervals meet.
fn last_columns(row: &Row) -> String {
    let meets = row.meet().map(|meet| if meet { "meet" } else { "do not meet" });
    match (&row.values, meets) {
        (Values::Words([a, b]), _) => format!("{:>DIFFERENCE$}", if a == b { "" } else { "other" }),
        (Values::Intervals(_), meets) => format!("{:>DIFFERENCE$}", meets.unwrap_or("-")),
        _ => {
            let difference = row.difference().map_or_else(|| "-".to_owned(), seven);
            let percent = row.percent().map_or_else(|| "-".to_owned(), |percent| with_digits(percent, 3));
            format!("{difference:>DIFFERENCE$}  {percent:>PERCENT$}")
        }
    }
}

/// Says what intervals that meet or do not meet mean; `None` without intervals of both runs.
fn verdict(found: &Comparison) -> Option<&'static str> {
    let meet: Vec<bool> = found.rows.iter().filter_map(Row::meet).collect();
    let all = meet.iter().all(|meet| *meet);
    (!meet.is_empty()).then_some(match found.problems {
        Problems::Same if all => "Both runs are of one problem, and their intervals meet, as they must.",
        Problems::Same => "Both runs are of one problem: of two intervals that do not meet, one is false.",
        Problems::OtherMeshes if all => "Both runs are of one case on other meshes, and their intervals meet.",
        Problems::OtherMeshes => {
            "Both runs are of one case on other meshes. Curves, mesh files, parts of sides and interpolated data follow\n\
             the mesh: if they are the same on both, one of two intervals that do not meet is false."
        }
        Problems::Increments => {
            "The intervals are of the last load increments, which begin from computed states: they need not meet."
        }
        Problems::Other => "The cases differ: the intervals are of different problems and need not meet.",
    })
}

/// Both values of a row as words.
fn values(values: &Values) -> [String; 2] {
    let dash = || "-".to_owned();
    match values {
        Values::Words(words) => words.each_ref().map(|word| one_line(word).into_owned()),
        Values::Numbers(numbers) => numbers.map(|number| number.map_or_else(dash, seven)),
        Values::Bounds(bounds) => bounds.map(|bound| bound.map_or_else(dash, at_most)),
        Values::Intervals(all) => all.map(|of| of.map_or_else(dash, interval)),
    }
}

/// Writes an interval, rounded outwards.
fn interval([low, high]: [f64; 2]) -> String {
    format!("[{}, {}]", short(lowered(low, DIGITS)), short(raised(high, DIGITS)))
}

/// Cuts a line that is too wide.
fn cut(line: &str) -> String {
    match line.char_indices().nth(WIDTH) {
        Some(_) => line.chars().take(WIDTH - 2).chain(" …".chars()).collect(),
        None => line.to_owned(),
    }
}

/// Makes one object of the comparison.
pub fn summary(found: &Comparison) -> Value {
    let rows = found.rows.iter().map(|row| {
        let mut object = json!({ "of": row.of, "name": row.name });
        let [a, b] = match &row.values {
            Values::Words(words) => words.each_ref().map(|word| json!(word)),
            Values::Numbers(numbers) | Values::Bounds(numbers) => numbers.map(|number| json!(number)),
            Values::Intervals(intervals) => intervals.map(|interval| json!(interval)),
        };
        (object["a"], object["b"]) = (a, b);
        match row.values {
            Values::Words(_) => {}
            Values::Numbers(_) | Values::Bounds(_) => {
                (object["difference"], object["percent"]) = (json!(row.difference()), json!(row.percent()));
            }
            Values::Intervals(_) => object["meet"] = json!(row.meet()),
        }
        object
    });
    let problems = match found.problems {
        Problems::Same => "same",
        Problems::OtherMeshes => "other_meshes",
        Problems::Increments => "increments",
        Problems::Other => "other",
    };
    json!({
        "rows": rows.collect::<Vec<Value>>(),
        "settings": found.settings,
        "problems": problems,
        "verdict": verdict(found),
    })
}

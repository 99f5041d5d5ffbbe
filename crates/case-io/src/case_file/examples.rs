//! Words for messages: how keys are written, and what a value is.

use super::tree::NodeValue;
use crate::diagnostic::excerpt;

/// How keys are written: a word that the path of the key must hold, or `*`, and the line. The first that fits counts.
const EXAMPLES: &str = include_str!("examples.txt");

/// Shows how a key is written, if every case writes it alike.
///
/// * `path`: the key with the tables above it.
pub(super) fn example(path: &str) -> Option<&'static str> {
    let key = path.rsplit('.').next()?;
    let rows = EXAMPLES.lines().filter_map(|row| row.split_once(" | "));
    let is_of_key = |line: &str| line.trim_start_matches('[').split([' ', '.', ']']).next() == Some(key);
    let fits = |(table, line): &(&str, &str)| is_of_key(line) && (*table == "*" || path.contains(table));
    rows.filter(fits).map(|(_, line)| line).next()
}

/// Describes a value by its type and, if it is short, its text.
pub(super) fn described(value: &NodeValue) -> String {
    match value {
        NodeValue::String(text) => format!("the string {}", excerpt(text)),
        NodeValue::Integer(number) => format!("the integer {number}"),
        NodeValue::Float(number) => format!("the number {number:?}"),
        NodeValue::Boolean(truth) => format!("the boolean {truth}"),
        other => other.type_name().to_owned(),
    }
}

//! `--set KEY=VALUE`: values of the command line, put into the document before its keys are read.

use super::tree::{self, At, Entry, Node, NodeValue, Table};
use super::value_hints;
use crate::diagnostic::{CaseError, Diagnostic, Source, code};
use mesh_io::numeral;
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// Splits the argument of `--set` at its first `=`.
///
/// ```
/// let (key, value) = case_io::case_file::split_override("solver.theta=0.3")?;
/// assert_eq!((key.as_str(), value.as_str()), ("solver.theta", "0.3"));
/// # Ok::<(), case_io::CaseError>(())
/// ```
///
/// # Errors
/// An argument without `=`, or with nothing before it.
pub fn split_override(argument: &str) -> Result<(String, String), CaseError> {
    match argument.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().to_owned(), value.trim().to_owned())),
        _ => {
            let source = Source::new(&format!("--set {argument}"), argument, true);
            let place = At::new(&source, 0..argument.len()).place();
            Err(Diagnostic::new(code::OVERRIDE, Some(place), "an override without a key and a value")
                .expected("KEY=VALUE, such as solver.theta=0.3")
                .fix("write the key, `=` and the value without blanks, or all of it in quotes")
                .into())
        }
    }
}

/// Sets one key of the document.
pub(super) fn apply(root: &mut Table, key: &str, value: &str) -> Result<(), CaseError> {
    let text = format!("{key}={value}");
    let source = Source::new(&format!("--set {text}"), &text, true);
    let key_at = At::new(&source, 0..key.len());
    let fault = |message: String| Diagnostic::new(code::OVERRIDE, Some(key_at.place()), message);
    let path = key_path(key).ok_or_else(|| {
        fault(format!("`{key}` is not a key"))
            .expected("names joined by dots, array entries by number: body.0.material")
            .fix("write the key as the case file has it")
    })?;
    let node = parse_value(value, &source, key.len() + 1)?;
    set_in_table(root, &path, node, &key_at, "").map_err(|message| {
        fault(message).expected("a key of the case").fix("write the key as the case file has it").into()
    })
}

/// Reads a dotted key with TOML's own rules, so that quoted parts work too.
pub(super) fn key_path(key: &str) -> Option<Vec<String>> {
    if key.contains(['\n', '\r', '=', '#']) {
        return None;
    }
    let text = format!("{key} = 0");
    let document = DeTable::parse(&text).ok()?;
    let mut path = Vec::new();
    let mut table = document.get_ref();
    loop {
        let (part, value) = table.iter().next()?;
        path.push(part.get_ref().clone().into_owned());
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            DeValue::Integer(_) => return Some(path),
            _ => return None,
        }
    }
}

/// Reads a value; what is not TOML and does not begin like a compound value is a string.
fn parse_value(value: &str, source: &Arc<Source>, offset: usize) -> Result<Node, CaseError> {
    match DeValue::parse(value) {
        Ok(parsed) => Ok(tree::node(parsed, source, offset)),
        Err(error) => {
            let at = At::new(source, offset..offset + value.len());
            let compound = |c: char| ['[', '{', '"', '\''].contains(&c) || numeral::is_curly(c);
            if value.is_empty() || value.starts_with(compound) {
                if let Some(hint) = value_hints::in_line(value, 0..value.len(), source, offset) {
                    return Err(hint.into());
                }
                let message = format!("the value is not TOML: {}", error.message());
                return Err(Diagnostic::new(code::OVERRIDE, Some(at.place()), message)
                    .expected("a value as in a case file")
                    .fix("put quotes around the argument, so that the shell leaves it as it is")
                    .into());
            }
            Ok(Node { value: NodeValue::String(value.to_owned()), at })
        }
    }
}

fn set_in_table(
    table: &mut Table,
    path: &[String],
    value: Node,
    key_at: &At,
    above: &str,
) -> Result<(), String> {
    let Some((first, rest)) = path.split_first() else { return Ok(()) };
    let here = join(above, first);
    if let Some(entry) = table.get_mut(first) {
        return set_in_node(&mut entry.node, rest, value, key_at, &here);
    }
    let mut node = Node { value: NodeValue::Table(Table::default()), at: key_at.clone() };
    set_in_node(&mut node, rest, value, key_at, &here)?;
    table.entries.push(Entry { key: first.clone(), key_at: key_at.clone(), node });
    Ok(())
}

fn set_in_node(node: &mut Node, path: &[String], value: Node, key_at: &At, here: &str) -> Result<(), String> {
    let Some((first, rest)) = path.split_first() else {
        *node = value;
        return Ok(());
    };
    match &mut node.value {
        NodeValue::Table(table) => set_in_table(table, path, value, key_at, here),
        NodeValue::Array(items) => {
            let count = items.len();
            match first.parse::<usize>().ok().and_then(|k| items.get_mut(k)) {
                Some(item) => set_in_node(item, rest, value, key_at, &join(here, first)),
                None if count == 0 => Err(format!("`{here}` has no entries, so there is no `{first}`")),
                None => Err(format!("`{here}` has the entries 0 to {}, so there is no `{first}`", count - 1)),
            }
        }
        other => Err(format!("`{here}` is {}, so it has no `{first}`", other.type_name())),
    }
}

fn join(above: &str, part: &str) -> String {
    if above.is_empty() { part.to_owned() } else { format!("{above}.{part}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_follow_toml() {
        assert_eq!(key_path("body.0.generator.cells").unwrap(), ["body", "0", "generator", "cells"]);
        assert_eq!(key_path("materials.\"a b\".young").unwrap(), ["materials", "a b", "young"]);
        for wrong in ["", ".", "a..b", "a b", "a=1", "a\nb", "[a]", "a#"] {
            assert_eq!(key_path(wrong), None, "{wrong:?}");
        }
    }

    #[test]
    fn words_are_strings_and_broken_compounds_are_errors() {
        let source = Source::new("--set", "", true);
        let read = |text: &str| parse_value(text, &source, 0).map(|n| n.value);
        assert!(matches!(read("newton"), Ok(NodeValue::String(s)) if s == "newton"));
        assert!(matches!(read("4GiB"), Ok(NodeValue::String(_))));
        assert!(matches!(read("0.3"), Ok(NodeValue::Float(v)) if v == 0.3));
        assert!(matches!(read("[36,18]"), Ok(NodeValue::Array(a)) if a.len() == 2));
        for wrong in ["[1,", "", "\"a", "{a=}"] {
            assert!(read(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn an_argument_needs_a_key_and_a_value() {
        for wrong in ["solver.theta", "=1", " =1"] {
            assert!(split_override(wrong).is_err());
        }
    }
}

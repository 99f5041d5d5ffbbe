//! Arrays: limits, points, cells and matrices.

use super::Reader;
use crate::case_file::examples::example;
use crate::case_file::tree::{Node, NodeValue};
use crate::diagnostic::{Diagnostic, code};
use crate::expression::Value;
use fem_core::space::{Item, Space};

/// The words of messages about a matrix.
pub(crate) struct MatrixWords {
    /// The number of its rows and columns.
    pub(crate) size: usize,
    /// What is expected.
    pub(crate) expected: &'static str,
    /// The fix for this many rows.
    pub(crate) rows: fn(usize) -> &'static str,
    /// The fix for this many entries of a row.
    pub(crate) entries: fn(usize) -> &'static str,
}

/// The words for small numbers of entries.
const COUNTS: [&str; 4] = ["no", "one", "two", "three"];

/// Turns the rows of a program's array with as many numbers in each as there are axes into columns.
fn columns(node: &Node, axes: usize) -> Option<Vec<Node>> {
    let NodeValue::Array(rows) = &node.value else { return None };
    let entries = |row: &Node| match &row.value {
        NodeValue::Array(entries) => Some(entries.clone()).filter(|entries| entries.len() == axes),
        _ => None,
    };
    let entries = rows.iter().map(entries).collect::<Option<Vec<_>>>();
    let rows = entries.filter(|rows| rows.len() != axes && node.at.source.is_program())?;
    let column = |k: usize| NodeValue::Array(rows.iter().map(|row| row[k].clone()).collect());
    Some((0..axes).map(|k| Node { value: column(k), at: node.at.clone() }).collect())
}

impl Reader<'_> {
    /// Reads a number or an expression for each axis, or from a program a row of them for each node.
    pub(crate) fn values<S: Space>(&mut self, key: &'static str) -> Option<S::Data<Value>> {
        let (path, node) = self.given(key)?;
        let found: Vec<Value> = match columns(node, S::DIM) {
            Some(columns) => {
                let value = |(k, column): (usize, &Node)| {
                    let path = format!("{path}.{k}");
                    self.findings.note(&path, &node.at);
                    self.value_of(&path, column)
                };
                let all: Vec<Option<Value>> = columns.iter().enumerate().map(value).collect();
                all.into_iter().collect::<Option<Vec<_>>>()?
            }
            None => self.several(key, S::DIM, "numbers", Self::value_of)?,
        };
        Some(S::data(|k| found[k].clone()))
    }

    /// Reads two finite numbers.
    pub(crate) fn pair(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let found = self.several(key, 2, "numbers", Self::finite)?;
        <[f64; 2]>::try_from(found).ok()
    }

    /// Reads a finite number for each axis.
    pub(crate) fn axes<S: Space>(&mut self, key: &'static str) -> Option<S::Axes<f64>> {
        self.of_axes::<S, f64>(key, "numbers", Self::finite)
    }

    /// Reads a whole number ≥ 1 for each axis.
    pub(crate) fn counts<S: Space>(&mut self, key: &'static str) -> Option<S::Axes<usize>> {
        self.of_axes::<S, usize>(key, "whole numbers", |r, path, node| r.whole(path, node, 1))
    }

    fn of_axes<S: Space, T: Item>(
        &mut self,
        key: &'static str,
        what: &str,
        read: impl Fn(&Self, &str, &Node) -> Option<T>,
    ) -> Option<S::Axes<T>> {
        let found = self.several(key, S::DIM, what, read)?;
        Some(S::axes(|k| found[k]))
    }

    /// Reads one string or a list of them.
    pub(crate) fn names(&mut self, key: &'static str) -> Option<Vec<String>> {
        match self.table.get(key).map(|entry| &entry.node.value) {
            Some(NodeValue::Array(_)) => {
                let found = self.strings(key)?;
                if found.is_empty() {
                    let message = format!("`{}` is an empty list", self.path_of(key));
                    self.refuse(key, message, "one name or more", "write the name alone, without brackets");
                }
                Some(found)
            }
            _ => Some(vec![self.string(key)?]),
        }
    }

    /// Reads any number of strings, or lists of them.
    pub(crate) fn lists_of_strings(&mut self, key: &'static str) -> Option<Vec<Vec<String>>> {
        let (path, node) = self.given(key)?;
        let items = self.items(&path, node, "an array of strings")?;
        let one = |path: String, item: &Node| {
            self.findings.note(&path, &item.at);
            self.text(&path, item)
        };
        let read = |(k, item): (usize, &Node)| match &item.value {
            NodeValue::Array(names) => {
                self.findings.note(&format!("{path}.{k}"), &item.at);
                let names = names.iter().enumerate();
                names.map(|(i, name)| one(format!("{path}.{k}.{i}"), name)).collect()
            }
            _ => Some(vec![one(format!("{path}.{k}"), item)?]),
        };
        let all: Vec<Option<Vec<String>>> = items.iter().enumerate().map(read).collect();
        all.into_iter().collect()
    }

    /// Reads any number of strings.
    pub(crate) fn strings(&mut self, key: &'static str) -> Option<Vec<String>> {
        let (path, node) = self.given(key)?;
        let items = self.items(&path, node, "an array of strings")?;
        let read_one = |(k, item): (usize, &Node)| {
            let path = format!("{path}.{k}");
            self.findings.note(&path, &item.at);
            self.text(&path, item)
        };
        // All are read before any is given up, so that all faults are found.
        let all: Vec<Option<String>> = items.iter().enumerate().map(read_one).collect();
        all.into_iter().collect()
    }

    /// Reads a square matrix by its rows.
    pub(crate) fn matrix(&mut self, key: &'static str, words: &MatrixWords) -> Option<Vec<Vec<f64>>> {
        let (path, node) = self.given(key)?;
        let mut matrix = Vec::with_capacity(words.size);
        for (i, row) in self.counted(&path, node, words.size, words.expected, words.rows)?.iter().enumerate()
        {
            let path = format!("{path}.{i}");
            let mut entries = Vec::with_capacity(words.size);
            let row = self.counted(&path, row, words.size, words.expected, words.entries)?;
            for (j, entry) in row.iter().enumerate() {
                entries.push(self.finite(&format!("{path}.{j}"), entry)?);
            }
            matrix.push(entries);
        }
        Some(matrix)
    }

    /// Reads two vectors.
    pub(crate) fn two_vectors<S: Space>(&mut self, key: &'static str) -> Option<[S::Axes<f64>; 2]> {
        let found = self.several(key, 2, "vectors", |r, path, node| {
            let of = |_| "write two vectors, as in `axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]`";
            let entries = r.counted(path, node, S::DIM, "two vectors", of)?;
            let found = entries.iter().map(|entry| r.finite(path, entry)).collect::<Option<Vec<_>>>()?;
            Some(S::axes(|k| found[k]))
        })?;
        <[S::Axes<f64>; 2]>::try_from(found).ok()
    }

    /// Returns the entries of an array of a given length.
    ///
    /// * `fix`: what helps if there are this many entries instead.
    fn counted<'b>(
        &self,
        path: &str,
        node: &'b Node,
        count: usize,
        expected: &str,
        fix: fn(usize) -> &'static str,
    ) -> Option<&'b [Node]> {
        let items = self.items(path, node, expected)?;
        if items.len() == count {
            return Some(items);
        }
        let message = format!("`{path}` has {} entries", items.len());
        let diagnostic = Diagnostic::new(code::VALUE, Some(node.at.place()), message);
        self.findings.push(diagnostic.expected(expected).fix(fix(items.len())));
        None
    }

    /// Reads an array of a given length.
    ///
    /// * `what`: its entries in words.
    fn several<T>(
        &mut self,
        key: &'static str,
        count: usize,
        what: &str,
        read: impl Fn(&Self, &str, &Node) -> Option<T>,
    ) -> Option<Vec<T>> {
        let (path, node) = self.given(key)?;
        let expected = format!("an array of {} {what}", COUNTS.get(count).copied().unwrap_or("some"));
        let items = self.items(&path, node, &expected)?;
        if items.len() != count {
            let whole = |node: &Node| matches!(node.value, NodeValue::Integer(_));
            let commas = what.ends_with("numbers") && items.len() == 2 * count && items.iter().all(whole);
            let line = example(&path).filter(|line| line.matches(',').count() + 1 == count);
            let fix = match line {
                _ if commas => "decimals have a point: [0.5, 1.5], not [0,5, 1,5]".to_owned(),
                Some(line) => format!("write it as in `{line}`"),
                None => format!("write `{key} = [{}]`", ["a", "b", "c"][..count.min(3)].join(", ")),
            };
            self.refuse(key, format!("`{path}` has {} entries", items.len()), &expected, &fix);
            return None;
        }
        let read_one = |(k, item): (usize, &Node)| {
            let path = format!("{path}.{k}");
            self.findings.note(&path, &item.at);
            read(self, &path, item)
        };
        // All are read before any is given up, so that all faults are found.
        let all: Vec<Option<T>> = items.iter().enumerate().map(read_one).collect();
        all.into_iter().collect()
    }
}

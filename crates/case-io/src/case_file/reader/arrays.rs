//! Arrays: pairs and matrices.

use super::Reader;
use crate::case_file::examples::example;
use crate::case_file::tree::{Node, NodeValue};
use crate::diagnostic::{Diagnostic, code};
use crate::expression::Value;

/// Returns the fix for a stiffness with this many rows.
fn of_rows(count: usize) -> &'static str {
    match count {
        2 => "give three rows; the last holds the shear modulus: `[0, 0, G]` if shear does not couple",
        6 => "give three rows, for xx, yy and xy of the plane problem",
        9 => "put the numbers of each row into brackets",
        _ => "give three rows, for xx, yy and xy",
    }
}

/// Returns the fix for a row of a stiffness with this many entries.
fn of_entries(count: usize) -> &'static str {
    match count {
        2 => "give three numbers in each row; the last couples with shear, 0 if it does not",
        6 => "give the three of xx, yy and xy; decimals have a point, not a comma",
        _ => "give three numbers in each row, for xx, yy and xy",
    }
}

/// Turns the rows of a program's array with two numbers in each into two columns.
fn columns(node: &Node) -> Option<[Node; 2]> {
    let NodeValue::Array(rows) = &node.value else { return None };
    let pair = |row: &Node| match &row.value {
        NodeValue::Array(pair) => <[Node; 2]>::try_from(pair.clone()).ok(),
        _ => None,
    };
    let pairs = rows.iter().map(pair).collect::<Option<Vec<_>>>();
    let pairs = pairs.filter(|pairs| pairs.len() != 2 && node.at.source.is_program())?;
    let (x, y) = pairs.into_iter().map(|[x, y]| (x, y)).unzip();
    Some([x, y].map(|column| Node { value: NodeValue::Array(column), at: node.at.clone() }))
}

impl Reader<'_> {
    /// Reads two numbers or expressions, or from a program a pair for each node.
    pub(crate) fn value_pair(&mut self, key: &'static str) -> Option<[Value; 2]> {
        let (path, node) = self.given(key)?;
        match columns(node) {
            Some(columns) => {
                let [x, y] = [0, 1].map(|k| {
                    let path = format!("{path}.{k}");
                    self.findings.note(&path, &node.at);
                    self.value_of(&path, &columns[k])
                });
                Some([x?, y?])
            }
            None => self.two(key, "an array of two numbers", Self::value_of),
        }
    }

    /// Reads two finite numbers.
    pub(crate) fn pair(&mut self, key: &'static str) -> Option<[f64; 2]> {
        self.two(key, "an array of two numbers", Self::finite)
    }

    /// Reads two whole numbers ≥ 1.
    pub(crate) fn count_pair(&mut self, key: &'static str) -> Option<[usize; 2]> {
        self.two(key, "an array of two whole numbers", |r, path, node| r.whole(path, node, 1))
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

    /// Reads three rows of three finite numbers.
    pub(crate) fn matrix(&mut self, key: &'static str) -> Option<[[f64; 3]; 3]> {
        let (path, node) = self.given(key)?;
        let mut matrix = [[0.0; 3]; 3];
        for (i, row) in self.three(&path, node, of_rows)?.iter().enumerate() {
            let path = format!("{path}.{i}");
            for (j, entry) in self.three(&path, row, of_entries)?.iter().enumerate() {
                matrix[i][j] = self.finite(&format!("{path}.{j}"), entry)?;
            }
        }
        Some(matrix)
    }

    /// * `fix`: what helps if there are this many entries instead of three.
    fn three<'b>(&self, path: &str, node: &'b Node, fix: fn(usize) -> &'static str) -> Option<&'b [Node; 3]> {
        let expected = "three rows of three numbers, `[[a, b, c], [b, d, e], [c, e, f]]`";
        let items = self.items(path, node, expected)?;
        let three = <&[Node; 3]>::try_from(items).ok();
        if three.is_none() {
            let message = format!("`{path}` has {} entries", items.len());
            let diagnostic = Diagnostic::new(code::VALUE, Some(node.at.place()), message);
            self.findings.push(diagnostic.expected(expected).fix(fix(items.len())));
        }
        three
    }

    fn two<T>(
        &mut self,
        key: &'static str,
        expected: &str,
        read: impl Fn(&Self, &str, &Node) -> Option<T>,
    ) -> Option<[T; 2]> {
        let (path, node) = self.given(key)?;
        let items = self.items(&path, node, expected)?;
        let [a, b] = items else {
            let whole = |node: &Node| matches!(node.value, NodeValue::Integer(_));
            let commas = expected.ends_with("numbers") && items.len() == 4 && items.iter().all(whole);
            let fix = match example(&path) {
                _ if commas => "decimals have a point: [0.5, 1.5], not [0,5, 1,5]".to_owned(),
                Some(line) => format!("write it as in `{line}`"),
                None => format!("write `{key} = [a, b]`"),
            };
            self.refuse(key, format!("`{path}` has {} entries", items.len()), expected, &fix);
            return None;
        };
        let read_one = |k: usize, item: &Node| {
            let path = format!("{path}.{k}");
            self.findings.note(&path, &item.at);
            read(self, &path, item)
        };
        // Both are read before either is given up, so that both faults are found.
        let (a, b) = (read_one(0, a), read_one(1, b));
        Some([a?, b?])
    }
}

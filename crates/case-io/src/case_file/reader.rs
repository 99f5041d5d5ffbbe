//! A typed reader of one table: it collects what is wrong instead of stopping at the first fault.
//!
//! Reading a key makes it known; [`Reader::finish`] reports the keys that were not read.

mod arrays;

pub(crate) use arrays::MatrixWords;

use super::examples::{described, example};
use super::other_words;
use super::tree::{At, Entry, Node, NodeValue, Table};
use crate::diagnostic::{
    CaseError, Diagnostic, MOST_DIAGNOSTICS, SourcePosition, code, did_you_mean, excerpt, nearest,
};
use crate::expression::{AtNodes, Expression, Given, Value, joined, quoted};
use fem_core::geometry::shown;
use mesh_io::numeral;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::sync::Arc;

/// This many faults are kept until only the first ones are.
const MOST_LISTED: usize = 1000;

/// The faults that were found in a document, and the place of every key that was read.
pub(crate) struct Findings {
    /// The names of the coordinates in expressions.
    coordinates: &'static [&'static str],
    diagnostics: RefCell<Vec<Diagnostic>>,
    /// Faults that are no longer listed, since many come before them.
    omitted: Cell<usize>,
    places: RefCell<BTreeMap<String, At>>,
}

impl Findings {
    /// Begins to read a document.
    ///
    /// * `coordinates`: their names in its expressions.
    pub(crate) fn new(coordinates: &'static [&'static str]) -> Self {
        Self {
            coordinates,
            diagnostics: RefCell::default(),
            omitted: Cell::default(),
            places: RefCell::default(),
        }
    }

    /// Says what a number that may differ from point to point is.
    pub(crate) fn expression(&self) -> String {
        format!("a number, or an expression in {}", joined(self.coordinates))
    }

    pub(crate) fn push(&self, diagnostic: Diagnostic) {
        let mut listed = self.diagnostics.borrow_mut();
        listed.push(diagnostic);
        if listed.len() >= MOST_LISTED {
            let CaseError { diagnostics, omitted } = CaseError::new(std::mem::take(&mut *listed));
            *listed = diagnostics;
            self.omitted.set(self.omitted.get() + omitted);
        }
    }

    /// Tells whether more faults than are listed were found: searches for what was meant are no longer worthwhile.
    pub(crate) fn are_many(&self) -> bool {
        self.omitted.get() > 0 || self.diagnostics.borrow().len() >= MOST_DIAGNOSTICS
    }

    /// Keeps the place of a key, unless faults already fill the list.
    fn note(&self, path: &str, at: &At) {
        if self.omitted.get() == 0 {
            self.places.borrow_mut().insert(path.to_owned(), at.clone());
        }
    }

    /// Names what a word was meant to be, unless more faults are found than are listed.
    pub(crate) fn meant<'a>(
        &self,
        word: &str,
        all: impl IntoIterator<Item = &'a str>,
        quote: char,
    ) -> Option<String> {
        if self.are_many() { None } else { did_you_mean(word, all, quote) }
    }

    /// Finds the place of a key that was read.
    pub(crate) fn place(&self, path: &str) -> Option<SourcePosition> {
        self.places.borrow().get(path).map(At::place)
    }

    /// Returns the faults, how many more there are, and the places of the keys.
    pub(crate) fn into_parts(self) -> (Vec<Diagnostic>, usize, BTreeMap<String, At>) {
        (self.diagnostics.into_inner(), self.omitted.get(), self.places.into_inner())
    }
}

/// Reads the keys of one table.
pub(crate) struct Reader<'a> {
    findings: &'a Findings,
    table: &'a Table,
    /// Dotted path of the table, empty for the document.
    path: String,
    at: At,
    known: Vec<&'static str>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(findings: &'a Findings, table: &'a Table, path: String, at: &At) -> Self {
        findings.note(&path, at);
        Self { findings, table, path, at: at.clone(), known: Vec::new() }
    }

    /// Returns the dotted path of a key of this table.
    pub(crate) fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    /// Returns the text of a key, without making it known.
    pub(crate) fn word(&self, key: &str) -> Option<&'a str> {
        self.table.get(key)?.node.word()
    }

    /// Tells whether the value of a key is an array, without making it known.
    pub(crate) fn is_array(&self, key: &str) -> bool {
        matches!(self.table.get(key).map(|entry| &entry.node.value), Some(NodeValue::Array(_)))
    }

    /// Returns the entries, for tables whose keys are the user's own names.
    pub(crate) fn entries(&self) -> &'a [Entry] {
        &self.table.entries
    }

    pub(crate) fn findings(&self) -> &'a Findings {
        self.findings
    }

    /// Looks a key up and makes it known.
    pub(crate) fn node(&mut self, key: &'static str) -> Option<&'a Node> {
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        let entry = self.table.get(key)?;
        self.findings.note(&self.path_of(key), &entry.node.at);
        Some(&entry.node)
    }

    /// Returns the path of a key and what is there.
    fn given(&mut self, key: &'static str) -> Option<(String, &'a Node)> {
        let node = self.node(key)?;
        Some((self.path_of(key), node))
    }

    /// Returns the entries of an array.
    fn items<'b>(&self, path: &str, node: &'b Node, expected: &str) -> Option<&'b [Node]> {
        let NodeValue::Array(items) = &node.value else {
            self.wrong_type(path, node, expected);
            return None;
        };
        Some(items)
    }

    /// Reports required keys that are missing.
    pub(crate) fn require(&self, keys: &[&str]) {
        for key in keys.iter().filter(|key| !self.has(key)) {
            let path = self.path_of(key);
            let found = format!("the key `{path}` is missing");
            let expected = format!("`{key}`, which has no default");
            let fix = match (
                self.example(&path),
                nearest(key, self.table.entries.iter().map(|e| e.key.as_str())),
            ) {
                (_, Some(other)) => format!("is `{}` meant to be `{key}`?", excerpt(other).trim_matches('"')),
                (Some(line), None) if path == "contact" => {
                    format!(
                        "write `{line}`, or `contact = []` above the first table for one body without contact"
                    )
                }
                (Some(line), None) if self.path.is_empty() => format!("write `{line}`"),
                (Some(line), None) => format!("write `{line}` into `{}`", self.path),
                (None, None) => "see `nndd new paper` for a case that has it".to_owned(),
            };
            let diagnostic = Diagnostic::new(code::MISSING, Some(self.at.place()), found);
            self.findings.push(diagnostic.expected(expected).fix(fix));
        }
    }

    /// Reports a value that has the right type but cannot be used.
    pub(crate) fn refuse(&self, key: &str, message: impl Into<String>, expected: &str, fix: &str) {
        let diagnostic = Diagnostic::new(code::VALUE, self.place_of(key), message);
        self.findings.push(diagnostic.expected(expected).fix(fix));
    }

    /// Finds the place of a key's value, or of the table if the key is not there.
    pub(crate) fn place_of(&self, key: &str) -> Option<SourcePosition> {
        Some(self.table.get(key).map_or(&self.at, |e| &e.node.at).place())
    }

    fn wrong_type(&self, path: &str, node: &Node, expected: &str) {
        let mut message = format!("`{path}` is {}", described(&node.value));
        let number = |text: &str| text.trim().parse::<f64>().is_ok_and(f64::is_finite);
        let key = path.rsplit('.').next().unwrap_or(path);
        let advice = match &node.value {
            NodeValue::String(text) if expected.contains("number") => numeral::advice(text),
            _ => None,
        };
        if advice.is_some() {
            message += ", which is not a number";
        }
        let fix = match (&node.value, self.example(path)) {
            (NodeValue::Float(number), _)
                if expected.contains("whole") && number.fract() == 0.0 && (1.0..1e15).contains(number) =>
            {
                format!("write {number}, without point or exponent")
            }
            (NodeValue::String(text), _)
                if expected == "true or false" && ["true", "false"].contains(&text.trim()) =>
            {
                format!("write {} without quotes", text.trim())
            }
            (NodeValue::String(text), _) if expected.contains("number") && number(text) => {
                format!("write {} without quotes", text.trim())
            }
            (NodeValue::Array(_), _) if expected == "a number" || expected.starts_with("a whole number") => {
                "write one number, without brackets".to_owned()
            }
            (NodeValue::Array(_) | NodeValue::Table(_), _) if expected == "a string" => {
                "write one name in quotes".to_owned()
            }
            (_, Some(line)) => format!("write it as in `{line}`"),
            (_, None) if expected == "a string" => format!("put quotes around it: `{key} = \"…\"`"),
            (_, None) => format!("write {expected} there, or leave `{key}` out if it has a default"),
        };
        let diagnostic = Diagnostic::new(code::TYPE, Some(node.at.place()), message).expected(expected);
        self.findings.push(diagnostic.fix(advice.unwrap_or(fix)));
    }

    fn finite(&self, path: &str, node: &Node) -> Option<f64> {
        let value = match node.value {
            NodeValue::Float(value) => value,
            NodeValue::Integer(value) => value as f64,
            _ => {
                self.wrong_type(path, node, "a number");
                return None;
            }
        };
        if value.is_finite() {
            return Some(value);
        }
        let message = format!("`{path}` is {value}");
        let diagnostic = Diagnostic::new(code::VALUE, Some(node.at.place()), message);
        let fix = example(path).filter(|line| line.contains(|c: char| c.is_ascii_digit())).map_or_else(
            || "write the number itself".to_owned(),
            |line| format!("write the number itself, as in `{line}`"),
        );
        self.findings.push(diagnostic.expected("a finite number").fix(fix));
        None
    }

    /// Shows how a key of this table is written: round generators take one number of cells.
    fn example(&self, path: &str) -> Option<&'static str> {
        let round = ["disc", "half_disc", "ball"];
        let one =
            |kind: &Entry| matches!(&kind.node.value, NodeValue::String(s) if round.contains(&s.as_str()));
        match self.table.get("kind") {
            Some(kind) if one(kind) && path.ends_with(".cells") => Some("cells = 8"),
            _ => example(path),
        }
    }

    /// Reads a finite number.
    pub(crate) fn number(&mut self, key: &'static str) -> Option<f64> {
        let node = self.node(key)?;
        self.finite(&self.path_of(key), node)
    }

    /// Reads a finite number that satisfies a condition.
    pub(crate) fn number_where(
        &mut self,
        key: &'static str,
        condition: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Option<f64> {
        let value = self.number(key)?;
        if !condition(value) {
            self.refuse_number(key, value, expected);
        }
        Some(value)
    }

    fn refuse_number(&mut self, key: &'static str, value: f64, expected: &str) {
        let fix = example(&self.path_of(key)).map_or_else(
            || format!("change `{key}`, or leave it out if it has a default"),
            |line| format!("write it as in `{line}`"),
        );
        self.refuse(key, format!("`{}` is {}", self.path_of(key), shown(value)), expected, &fix);
    }

    fn value_of(&self, path: &str, node: &Node) -> Option<Value> {
        let given = |data| Some(Value::Given(Given { key: path.to_owned(), data }));
        match &node.value {
            NodeValue::String(text) => self.expression(path, node, text, None),
            NodeValue::Function(function) => given(AtNodes::Function(function.clone())),
            NodeValue::Array(items) if node.at.source.is_program() => {
                given(AtNodes::Values(self.at_nodes(path, node, items)?))
            }
            _ => self.finite(path, node).map(Value::Number),
        }
    }

    /// Reads one number for each node. A number that is not finite does no harm away from the side.
    fn at_nodes(&self, path: &str, node: &Node, items: &[Node]) -> Option<Arc<[f64]>> {
        let number = |(k, item): (usize, &Node)| match item.value {
            NodeValue::Float(number) => Ok(number),
            NodeValue::Integer(number) => Ok(number as f64),
            ref other => Err((k, described(other))),
        };
        let numbers = items.iter().enumerate().map(number).collect::<Result<Arc<[f64]>, _>>();
        let refuse = |(k, found)| {
            let message =
                format!("`{path}` is an array of {} entries, and entry {k} is {found}", items.len());
            let diagnostic = Diagnostic::new(code::TYPE, Some(node.at.place()), message);
            let expected = "one number for each node of the body's mesh";
            self.findings
                .push(diagnostic.expected(expected).fix("give as many numbers, or a function f(x, y)"));
        };
        numbers.map_err(refuse).ok()
    }

    /// * `word`: what is allowed there besides an expression.
    fn expression(&self, path: &str, node: &Node, text: &str, word: Option<&str>) -> Option<Value> {
        let error = match Expression::parse_in(text, self.findings.coordinates) {
            Ok(expression) => return Some(Value::Expression(expression)),
            Err(error) => error,
        };
        let diagnostic = match numeral::advice(text) {
            Some(advice) => {
                let message = format!("`{path}` is {}, which is not a number", described(&node.value));
                Diagnostic::new(code::EXPRESSION, Some(node.at.place()), message).help(Some(advice))
            }
            None => {
                let place = node.at.within(text, error.span);
                Diagnostic::new(code::EXPRESSION, Some(place), format!("`{path}`: {}", error.message))
            }
        };
        let mut expected = match diagnostic.help {
            Some(_) => self.findings.expression(),
            None => error.expected.unwrap_or_else(|| {
                let names = quoted(self.findings.coordinates);
                format!("numbers, {names}`pi`, + - * / ^ and known functions")
            }),
        };
        expected += &word.map_or_else(String::new, |word| format!("; or the word \"{word}\" alone"));
        let help = diagnostic.help.clone().or_else(|| did_you_mean(text, word, '"')).or(error.help);
        let fix = "rewrite it here; `nndd check` evaluates it without solving";
        self.findings.push(diagnostic.expected(expected).help(help).fix(fix));
        None
    }

    /// Reads a number or an expression.
    pub(crate) fn value(&mut self, key: &'static str) -> Option<Value> {
        let node = self.node(key)?;
        self.value_of(&self.path_of(key), node)
    }

    /// Reads a number or an expression; the caller has already looked for the one word that is allowed too.
    pub(crate) fn value_beside(&mut self, key: &'static str, word: &'static str) -> Option<Value> {
        let (path, node) = self.given(key)?;
        match &node.value {
            NodeValue::String(text) => self.expression(&path, node, text, Some(word)),
            _ => self.value_of(&path, node),
        }
    }

    fn whole(&self, path: &str, node: &Node, least: usize) -> Option<usize> {
        let expected = format!("a whole number, at least {least}");
        let NodeValue::Integer(value) = node.value else {
            self.wrong_type(path, node, &expected);
            return None;
        };
        let found = usize::try_from(value).ok().filter(|v| *v >= least && i64::try_from(*v).is_ok());
        if found.is_none() {
            let message = format!("`{path}` is {value}");
            let diagnostic = Diagnostic::new(code::VALUE, Some(node.at.place()), message);
            self.findings.push(diagnostic.expected(expected).fix(format!("write {least} or more")));
        }
        found
    }

    /// Reads a whole number that is at least `least`.
    pub(crate) fn count(&mut self, key: &'static str, least: usize) -> Option<usize> {
        let node = self.node(key)?;
        self.whole(&self.path_of(key), node, least)
    }

    /// Reads a boolean.
    pub(crate) fn boolean(&mut self, key: &'static str) -> Option<bool> {
        let node = self.node(key)?;
        let NodeValue::Boolean(truth) = node.value else {
            self.wrong_type(&self.path_of(key), node, "true or false");
            return None;
        };
        Some(truth)
    }

    fn text(&self, path: &str, node: &Node) -> Option<String> {
        let NodeValue::String(text) = &node.value else {
            self.wrong_type(path, node, "a string");
            return None;
        };
        Some(text.clone())
    }

    /// Reads a string.
    pub(crate) fn string(&mut self, key: &'static str) -> Option<String> {
        let node = self.node(key)?;
        self.text(&self.path_of(key), node)
    }

    /// Reads one of a few words.
    pub(crate) fn choice<T: Copy>(&mut self, key: &'static str, names: &[(&'static str, T)]) -> Option<T> {
        let first = names.first().map_or("", |(name, _)| *name);
        self.choice_or(key, names, |_| format!("write `{key} = \"{first}\"`"))
    }

    /// Reads one of a few words.
    ///
    /// * `fix`: what helps if none of the words is near the one found.
    pub(crate) fn choice_or<T: Copy, S: Into<String>>(
        &mut self,
        key: &'static str,
        names: &[(&'static str, T)],
        fix: impl Fn(&str) -> S,
    ) -> Option<T> {
        let text = self.string(key)?;
        let found = names.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice);
        if found.is_none() {
            let names: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
            self.unknown_word(key, &text, &names, fix(&text).into());
        }
        found
    }

    fn unknown_word(&mut self, key: &'static str, text: &str, names: &[&str], fix: String) {
        let words: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
        let message = format!("`{}` is {}", self.path_of(key), excerpt(text));
        let help = other_words::sentence(text).or_else(|| did_you_mean(text, names.iter().copied(), '"'));
        let diagnostic = Diagnostic::new(code::VALUE, self.place_of(key), message).help(help);
        self.findings.push(diagnostic.expected(words.join(" or ")).fix(fix));
    }

    /// Opens a table.
    pub(crate) fn table(&mut self, key: &'static str) -> Option<Reader<'a>> {
        let (path, node) = self.given(key)?;
        let NodeValue::Table(table) = &node.value else {
            self.wrong_type(&path, node, "a table");
            return None;
        };
        Some(Reader::new(self.findings, table, path, &node.at))
    }

    /// Opens the tables of an array; nothing if the key is missing or is not an array.
    pub(crate) fn tables(&mut self, key: &'static str) -> Option<Vec<Reader<'a>>> {
        let (path, node) = self.given(key)?;
        let expected = format!("an array of tables, each under [[{key}]]");
        let items = self.items(&path, node, &expected)?;
        let mut readers = Vec::with_capacity(items.len());
        for (k, item) in items.iter().enumerate() {
            let path = format!("{path}.{k}");
            match &item.value {
                NodeValue::Table(table) => readers.push(Reader::new(self.findings, table, path, &item.at)),
                _ => self.wrong_type(&path, item, "a table"),
            }
        }
        Some(readers)
    }

    /// Reports the keys that were not read.
    pub(crate) fn finish(self) {
        for entry in self.table.entries.iter().filter(|e| !self.known.contains(&e.key.as_str())) {
            let place = match self.path.as_str() {
                "" => "at the top level".to_owned(),
                path => format!("in `{path}`"),
            };
            let message = format!("unknown key `{}` {place}", entry.key.escape_debug());
            let keys: Vec<String> = self.known.iter().map(|k| format!("`{k}`")).collect();
            let diagnostic = Diagnostic::new(code::UNKNOWN_KEY, Some(entry.key_at.place()), message)
                .expected(format!("only the keys {}", keys.join(", ")))
                .help(
                    other_words::sentence(&entry.key)
                        .or_else(|| self.findings.meant(&entry.key, self.known.iter().copied(), '`')),
                )
                .fix("take it out, or write it into the table it belongs to");
            self.findings.push(diagnostic);
        }
    }
}

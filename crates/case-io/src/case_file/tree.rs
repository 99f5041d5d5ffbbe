//! An owned tree of TOML values in which every key and value knows its place. A program makes one without a text.

use crate::diagnostic::{Source, SourcePosition};
use crate::expression::NodalFunction;
use std::ops::Range;
use std::sync::Arc;
use toml::de::{DeInteger, DeTable, DeValue};

/// The place of a key or a value; its line is only counted on demand.
#[derive(Clone, Debug)]
pub struct At {
    pub(crate) source: Arc<Source>,
    /// Begin and end: a case file has at most [`super::LARGEST_CASE_FILE`] bytes, and a value on the command line not many more.
    span: [u32; 2],
}

impl At {
    /// Makes the place of a value that a program gives.
    ///
    /// * `key`: its dotted key; `text`: an expression as a case file has it, in quotes, or nothing.
    pub fn of_key(key: &str, text: &str) -> Self {
        Self::new(&Source::of_key(key, text), 0..text.len())
    }

    pub(crate) fn new(source: &Arc<Source>, span: Range<usize>) -> Self {
        let span = [span.start, span.end].map(|byte| u32::try_from(byte).unwrap_or(u32::MAX));
        Self { source: Arc::clone(source), span }
    }

    /// Returns the bytes of the text.
    pub(crate) fn span(&self) -> Range<usize> {
        self.span[0] as usize..self.span[1] as usize
    }

    pub(crate) fn place(&self) -> SourcePosition {
        SourcePosition::new(&self.source, self.span())
    }

    /// Returns the place of some bytes of the string here; the place of the string if escapes make the two
    /// differ.
    pub(crate) fn within(&self, text: &str, bytes: Range<usize>) -> SourcePosition {
        let written = self.source.text().get(self.span()).unwrap_or_default();
        match written.find(text).filter(|_| !text.is_empty()) {
            Some(start) => {
                let start = self.span().start + start;
                SourcePosition::new(&self.source, start + bytes.start..start + bytes.end)
            }
            None => self.place(),
        }
    }
}

/// A value and its place.
#[derive(Clone, Debug)]
pub struct Node {
    /// The value.
    pub value: NodeValue,
    /// Its place.
    pub at: At,
}

/// A value of TOML, or a function of a program.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the types of TOML")]
pub enum NodeValue {
    String(String),
    Integer(i128),
    Float(f64),
    Boolean(bool),
    Datetime,
    Array(Vec<Node>),
    Table(Table),
    /// A function of the coordinates of nodes; no text of a case file makes it.
    Function(NodalFunction),
}

impl Node {
    /// Returns the text, if it is one.
    pub(crate) fn word(&self) -> Option<&str> {
        match &self.value {
            NodeValue::String(text) => Some(text),
            _ => None,
        }
    }
}

impl NodeValue {
    /// Names the type for a message.
    pub(crate) fn type_name(&self) -> &'static str {
        match self {
            Self::String(_) => "a string",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a number",
            Self::Boolean(_) => "a boolean",
            Self::Datetime => "a date",
            Self::Array(_) => "an array",
            Self::Table(_) => "a table",
            Self::Function(_) => "a function",
        }
    }
}

/// Keys and their values, in order.
#[derive(Clone, Debug, Default)]
pub struct Table {
    pub(crate) entries: Vec<Entry>,
}

impl Table {
    /// Adds a key of a program, which is not there yet.
    pub fn put(&mut self, key: String, node: Node) {
        self.entries.push(Entry { key, key_at: node.at.clone(), node });
    }

    /// Lists keys and values.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Node)> {
        self.entries.iter().map(|entry| (entry.key.as_str(), &entry.node))
    }

    pub(crate) fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.key == key)
    }

    pub(crate) fn get_mut(&mut self, key: &str) -> Option<&mut Entry> {
        self.entries.iter_mut().find(|e| e.key == key)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) key_at: At,
    pub(crate) node: Node,
}

/// Takes a table apart, so that no value is there twice; its spans are shifted by `offset`, the start of its text in the source.
pub(crate) fn table(table: DeTable<'_>, source: &Arc<Source>, offset: usize) -> Table {
    let entries = table.into_iter().map(|(key, value)| Entry {
        key_at: at(source, key.span(), offset),
        key: key.into_inner().into_owned(),
        node: node(value, source, offset),
    });
    Table { entries: entries.collect() }
}

/// Takes a value, see [`table`].
pub(crate) fn node(value: toml::Spanned<DeValue<'_>>, source: &Arc<Source>, offset: usize) -> Node {
    let at = at(source, value.span(), offset);
    let value = match value.into_inner() {
        DeValue::String(text) => NodeValue::String(text.into_owned()),
        DeValue::Integer(number) => integer(&number),
        // TOML's floats are Rust's, `nan` and `inf` included; one too large becomes infinite and is refused later.
        DeValue::Float(number) => NodeValue::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(truth) => NodeValue::Boolean(truth),
        DeValue::Datetime(_) => NodeValue::Datetime,
        DeValue::Array(items) => {
            NodeValue::Array(items.into_iter().map(|item| node(item, source, offset)).collect())
        }
        DeValue::Table(inner) => NodeValue::Table(table(inner, source, offset)),
    };
    Node { value, at }
}

fn integer(number: &DeInteger<'_>) -> NodeValue {
    match i128::from_str_radix(number.as_str(), number.radix()) {
        Ok(value) => NodeValue::Integer(value),
        Err(_) => NodeValue::Float(number.as_str().parse().unwrap_or(f64::INFINITY)),
    }
}

fn at(source: &Arc<Source>, span: Range<usize>, offset: usize) -> At {
    At::new(source, span.start + offset..span.end + offset)
}

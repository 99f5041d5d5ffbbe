//! Dicts of Python as the tree of a case file: every value at the place of its key.

use crate::arrays::GivenMesh;
use crate::errors::wrong;
use crate::job;
use case_io::case_file::{At, Node, NodeValue, Table};
use case_io::expression::NodalFunction;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyFloat, PyMapping, PySequence, PyString};
use serde_json::Value;
use std::sync::Arc;

/// Dicts and lists in each other, at most: one that holds itself ends here.
const DEEPEST: usize = 60;

/// A reader of dicts, with the meshes that it met.
#[derive(Default)]
pub(crate) struct Reading {
    /// The meshes with their names in the tree, and the objects that they are.
    meshes: Vec<(String, GivenMesh, Py<PyAny>)>,
}

impl Reading {
    /// Returns the meshes with their names.
    pub(crate) fn into_meshes(self) -> Vec<(String, GivenMesh)> {
        self.meshes.into_iter().map(|(name, mesh, _)| (name, mesh)).collect()
    }

    /// Reads a dict. A value of `None` is the same as no key.
    pub(crate) fn table(&mut self, dict: &Bound<'_, PyMapping>, path: &str) -> PyResult<Table> {
        let (py, mut table) = (dict.py(), Table::default());
        for item in dict.items()? {
            let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let Ok(name) = key.cast::<PyString>() else {
                let (place, found) = ((!path.is_empty()).then_some(path), format!("the key {}", key.repr()?));
                return Err(wrong(py, place, &found, "keys that are strings", "write it in quotes"));
            };
            if !value.is_none() {
                let name: String = name.extract()?;
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                let node = match self.mesh_name(&value)? {
                    // `mesh` itself may be a mesh instead of a table.
                    Some(mesh) if name != "file" => {
                        let mut table = Table::default();
                        let file = format!("{path}.file");
                        table.put("file".to_owned(), Node { value: mesh, at: At::of_key(&file, "") });
                        Node { value: NodeValue::Table(table), at: At::of_key(&path, "") }
                    }
                    Some(mesh) => Node { value: mesh, at: At::of_key(&path, "") },
                    None => self.node(&value, &path, None)?,
                };
                table.put(name, node);
            }
        }
        Ok(table)
    }

    /// Names a mesh, if it is one; the same object has the same name.
    fn mesh_name(&mut self, value: &Bound<'_, PyAny>) -> PyResult<Option<NodeValue>> {
        if !value.is_instance(&value.py().import("nndd._mesh")?.getattr("Mesh")?)? {
            return Ok(None);
        }
        let known = self.meshes.iter().position(|(_, _, other)| other.is(value));
        if known.is_none() {
            let name = format!("<mesh {}>", self.meshes.len() + 1);
            self.meshes.push((name, value.extract()?, value.clone().unbind()));
        }
        let mesh = known.unwrap_or(self.meshes.len() - 1);
        Ok(Some(NodeValue::String(self.meshes[mesh].0.clone())))
    }

    /// Reads a value.
    ///
    /// * `at`: the place of the list that it is in, which its numbers and texts share.
    pub(crate) fn node(&mut self, value: &Bound<'_, PyAny>, path: &str, at: Option<&At>) -> PyResult<Node> {
        let here = |text: &str| at.cloned().unwrap_or_else(|| At::of_key(path, text));
        let py = value.py();
        let refuse = |found: &str, expected: &str, fix: &str| wrong(py, Some(path), found, expected, fix);
        let made = if let Ok(truth) = value.cast::<PyBool>() {
            NodeValue::Boolean(truth.is_true())
        } else if let Ok(text) = value.cast::<PyString>() {
            let text: String = text.extract()?;
            return Ok(Node { at: here(&format!("\"{text}\"")), value: NodeValue::String(text) });
        } else if value.is_callable() {
            NodeValue::Function(function(value, path))
        } else if let Some(listed) = listed(value)? {
            if value.is_instance(&py.import("numpy.ma")?.getattr("MaskedArray")?)? {
                let fix = "fill it with numbers first, such as by filled(0.0)";
                return Err(refuse("a masked array", "numbers", fix));
            }
            return self.node(&listed, path, at);
        } else if let Ok(number) = value.extract::<i128>() {
            NodeValue::Integer(number)
        } else if value.hasattr("__float__")? {
            NodeValue::Float(match value.extract::<f64>() {
                Err(error) if error.is_instance_of::<PyOverflowError>(py) => f64::INFINITY,
                number => number?,
            })
        } else if let Ok(path) = value.call_method0("__fspath__") {
            NodeValue::String(path.extract()?)
        } else if path.split('.').count() > DEEPEST {
            return Err(refuse(
                "dicts and lists too deep in each other",
                "the keys of a case",
                "check this dict",
            ));
        } else if let Ok(dict) = value.cast::<PyMapping>() {
            NodeValue::Table(self.table(dict, path)?)
        } else if let Ok(list) = value.cast::<PySequence>()
            && !value.is_instance_of::<PyBytes>()
            && !value.is_instance_of::<PyByteArray>()
        {
            let at = here("");
            let items = list.try_iter()?.enumerate();
            let read = |(k, item): (usize, PyResult<Bound<'_, PyAny>>)| {
                let item = item?;
                // Arrays at nodes are long.
                if let Ok(number) = item.cast::<PyFloat>() {
                    return Ok(Node { value: NodeValue::Float(number.value()), at: at.clone() });
                }
                let is_table = item.cast::<PyMapping>().is_ok();
                self.node(&item, &format!("{path}.{k}"), (!is_table).then_some(&at))
            };
            NodeValue::Array(items.map(read).collect::<PyResult<_>>()?)
        } else {
            let found = format!("a value of type {}", value.get_type().name()?);
            let expected = "a number, a text, a list or a dict";
            return Err(refuse(&found, expected, "see the keys of the case file"));
        };
        Ok(Node { value: made, at: here("") })
    }
}

/// Returns the plain Python objects of an array or a number of NumPy.
fn listed<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyAny>>> {
    if !value.hasattr("tolist")? {
        return Ok(None);
    }
    // A long double is its own object.
    let listed = value.call_method0("tolist")?;
    Ok((!listed.get_type().is(value.get_type())).then_some(listed))
}

/// Takes a function of two arrays of coordinates, which is called on the thread that called the package.
fn function(value: &Bound<'_, PyAny>, path: &str) -> NodalFunction {
    let (function, key) = (Arc::new(value.clone().unbind()), path.to_owned());
    NodalFunction::new(move |points| {
        let (function, key, points) = (Arc::clone(&function), key.clone(), points.to_vec());
        job::ask(move |py| {
            let [x, y] = [0, 1].map(|c| PyArray1::from_iter(py, points.iter().map(|p| p[c])));
            let made = py.import("nndd._data")?.getattr("evaluated")?.call1((key, &*function, x, y))?;
            Ok(made.cast::<PyArray1<f64>>()?.to_vec()?)
        })
    })
}

/// Settings as the command has them, `KEY=VALUE`, of keywords with two underscores for a dot.
pub(crate) struct Settings(pub(crate) Vec<String>);

impl FromPyObject<'_, '_> for Settings {
    type Error = PyErr;

    fn extract(keywords: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let setting = |item: Bound<'_, PyAny>| {
            let (key, value): (String, Bound<'_, PyAny>) = item.extract()?;
            let node = Reading::default().node(&value, &key, None)?;
            let found = "a function";
            let text = text(&node.value).ok_or_else(|| {
                wrong(
                    keywords.py(),
                    Some(&key),
                    found,
                    "a number, a text, a list or a dict",
                    "see the keys of the case file",
                )
            })?;
            Ok(format!("{}={text}", key.replace("__", ".")))
        };
        let items = keywords.cast::<PyMapping>()?.items()?;
        Ok(Self(items.iter().map(setting).collect::<PyResult<_>>()?))
    }
}

/// Writes a value on one line, as a case file has it; `None` if it holds a function.
fn text(value: &NodeValue) -> Option<String> {
    let quoted = |text: &str| Value::from(text).to_string().replace('\x7f', "\\u007f");
    let joined = |parts: Option<Vec<String>>| parts.map(|parts| parts.join(", "));
    Some(match value {
        NodeValue::String(text) => quoted(text),
        NodeValue::Integer(number) => number.to_string(),
        NodeValue::Float(number) => format!("{number:?}").to_lowercase(),
        NodeValue::Boolean(truth) => truth.to_string(),
        NodeValue::Array(items) => {
            format!("[{}]", joined(items.iter().map(|item| text(&item.value)).collect())?)
        }
        NodeValue::Table(table) => {
            let entry =
                |(key, node): (&str, &Node)| Some(format!("{} = {}", quoted(key), text(&node.value)?));
            format!("{{ {} }}", joined(table.iter().map(entry).collect())?)
        }
        NodeValue::Datetime | NodeValue::Function(_) => return None,
    })
}

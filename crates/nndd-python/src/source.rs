//! Cases that a Python program keeps in memory.

use crate::arrays::GivenMesh;
use crate::errors::wrong;
use crate::job;
use case_io::Case;
use case_io::case::{DataNodes, MeshSource};
use mesh_io::MeshFile;
use nndd_report::Failure;
use nndd_report::failure::{COMMAND_LINE, INVALID_INPUT};
use nndd_report::run::Source;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Data of a key, instead of a number.
pub(crate) enum Given {
    /// At the nodes of the body's mesh.
    Values(Vec<f64>),
    /// A function of two arrays of coordinates.
    Function(Arc<Py<PyAny>>),
}

/// The text of a case with the meshes and data that it names.
pub(crate) struct Text {
    pub(crate) text: String,
    pub(crate) name: String,
    pub(crate) folder: PathBuf,
    pub(crate) meshes: Arc<Vec<(String, GivenMesh)>>,
    /// The number of points of each mesh.
    pub(crate) node_counts: Vec<usize>,
    /// By dotted keys.
    pub(crate) data: Vec<(String, Given)>,
}

impl Source for Text {
    fn parse(&self, overrides: &[(String, String)]) -> Result<Case, Failure> {
        Ok(Case::parse(&self.text, &self.name, overrides)?)
    }

    fn read(&self, overrides: &[(String, String)]) -> Result<Case, Failure> {
        let mut case = self.parse(overrides)?;
        // Arrays of Python are read with the lock on the interpreter, which the thread that called can take.
        let meshes = Arc::clone(&self.meshes);
        let arrays =
            job::ask(move |py| meshes.iter().map(|(_, mesh)| mesh.read(py)).collect::<PyResult<Vec<_>>>());
        let arrays = arrays.ok_or_else(|| Failure::plain(COMMAND_LINE, "a mesh cannot be read"))?;
        let name = |k: usize| self.meshes[k].0.as_str();
        let made = fem_core::try_each_body(arrays.len(), |k| MeshFile::of_arrays(name(k), &arrays[k]))?;
        made.into_iter().enumerate().for_each(|(k, mesh)| case.give_mesh(name(k), mesh));
        drop(arrays);
        case.read_mesh_files(&self.folder)?;
        for (key, given) in &self.data {
            let nodes = case.data_nodes(key)?;
            let values = match given {
                _ if nodes.points.is_empty() => continue,
                Given::Values(values) => self.at_nodes(&case, key, &nodes, values)?,
                Given::Function(function) => self.evaluated(key, &nodes, function)?,
            };
            case.set_data(key, &nodes, &values)?;
        }
        Ok(case)
    }
}

impl Text {
    /// Counts the nodes of the mesh that a body was given, nodes without cells included; `None` if they are not known.
    fn node_count(&self, case: &Case, body: usize) -> Option<usize> {
        match &case.bodies[body].mesh {
            MeshSource::File { file, .. } => {
                let given = self.meshes.iter().position(|(name, _)| name == file)?;
                self.node_counts.get(given).copied()
            }
            _ => case.node_counts().get(body).map(|count| *count as usize),
        }
    }

    /// Reduces values at all given nodes to the nodes of a body's mesh. Another number of values is refused later.
    ///
    /// * `absent`: at nodes that are not there.
    pub(crate) fn to_mesh<T: Copy>(&self, case: &Case, body: usize, values: &mut Vec<T>, absent: T) {
        let is_body = body < case.bodies.len();
        let given = is_body && self.node_count(case, body) == Some(values.len());
        if let Some(numbers) = case.node_numbers(body).filter(|_| given) {
            *values = numbers.iter().map(|n| values.get(*n as usize).copied().unwrap_or(absent)).collect();
        }
    }

    /// Selects the values of some nodes from the values of all nodes of a mesh.
    fn at_nodes(
        &self,
        case: &Case,
        key: &str,
        nodes: &DataNodes,
        values: &[f64],
    ) -> Result<Vec<f64>, Failure> {
        let refused = |found: String, expected: &'static str, fix: &'static str| {
            let (key, said) = (key.to_owned(), found.clone());
            let _ = job::ask(move |py| Err::<(), _>(wrong(py, Some(&key), &found, expected, fix)));
            Failure::plain(INVALID_INPUT, said)
        };
        let body = &case.bodies[nodes.body].name;
        match self.node_count(case, nodes.body) {
            Some(count) if count == values.len() => {
                Ok(nodes.numbers.iter().filter_map(|number| values.get(*number as usize)).copied().collect())
            }
            Some(count) => Err(refused(
                format!(
                    "an array of {} values, and the mesh of body \"{body}\" has {count} nodes",
                    values.len()
                ),
                "one value for each node of the body's mesh",
                "give as many values as the mesh has points, or a function f(x, y)",
            )),
            None => Err(refused(
                format!("an array of values, and the mesh of body \"{body}\" is a file"),
                "a mesh in memory",
                "read it with Mesh.read, or give a function f(x, y)",
            )),
        }
    }

    /// Calls a function with the coordinates of the nodes, once, on the thread that called the package.
    fn evaluated(
        &self,
        key: &str,
        nodes: &DataNodes,
        function: &Arc<Py<PyAny>>,
    ) -> Result<Vec<f64>, Failure> {
        let (name, points, function) = (key.to_owned(), nodes.points.clone(), Arc::clone(function));
        let values = job::ask(move |py| {
            let [x, y] = [0, 1].map(|c| PyArray1::from_iter(py, points.iter().map(|p| p[c])));
            let made = py.import("nndd._data")?.getattr("evaluated")?.call1((name, &*function, x, y))?;
            Ok(made.cast::<PyArray1<f64>>()?.to_vec()?)
        });
        values.ok_or_else(|| Failure::plain(COMMAND_LINE, format!("{key}: the function raised an exception")))
    }
}

/// A case file, read with all that lies beside it.
pub(crate) struct File(pub(crate) PathBuf);

impl Source for File {
    fn parse(&self, overrides: &[(String, String)]) -> Result<Case, Failure> {
        nndd_report::run::CaseFile::open(&self.0)?.parse(overrides)
    }

    fn read(&self, overrides: &[(String, String)]) -> Result<Case, Failure> {
        nndd_report::run::CaseFile::open(&self.0)?.read(overrides)
    }
}

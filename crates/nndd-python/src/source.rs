//! Cases that a Python program keeps in memory.

use crate::arrays::GivenMesh;
use crate::job;
use case_io::Case;
use case_io::case::AnyCase;
use case_io::case_file::Table;
use mesh_io::MeshFile;
use nndd_report::Failure;
use nndd_report::ReportSpace;
use nndd_report::failure::COMMAND_LINE;
use nndd_report::run::Source;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// The keys of a case with the meshes that they name.
pub(crate) struct Keys {
    pub(crate) table: Table,
    pub(crate) meshes: Arc<Vec<(String, GivenMesh)>>,
}

impl Source for Keys {
    fn parse(&self, overrides: &[(String, String)], volumes: bool) -> Result<AnyCase, Failure> {
        Ok(AnyCase::of_table(self.table.clone(), "problem", overrides, volumes)?)
    }

    fn read(&self, overrides: &[(String, String)]) -> Result<AnyCase, Failure> {
        // Arrays of Python are read with the lock on the interpreter, which the thread that called can take.
        let meshes = Arc::clone(&self.meshes);
        let arrays =
            job::ask(move |py| meshes.iter().map(|(_, mesh)| mesh.read(py)).collect::<PyResult<Vec<_>>>());
        let arrays = arrays.ok_or_else(|| Failure::plain(COMMAND_LINE, "a mesh cannot be read"))?;
        let name = |k: usize| self.meshes[k].0.clone();
        let made = fem_core::try_each_body(arrays.len(), |k| MeshFile::of_arrays(&name(k), &arrays[k]))?;
        drop(arrays);
        let made = made.into_iter().enumerate().map(|(k, mesh)| (name(k), mesh)).collect();
        Ok(AnyCase::read_table(self.table.clone(), "problem", overrides, made)?)
    }
}

/// Reduces values at all given nodes to the nodes of a body's mesh. Another number of values is refused later.
///
/// * `absent`: at nodes that are not there.
pub(crate) fn to_mesh<T: Copy, S: ReportSpace>(case: &Case<S>, body: usize, values: &mut Vec<T>, absent: T) {
    let is_given = body < case.bodies.len() && case.given_node_count(body) == Some(values.len() as u64);
    if let Some(numbers) = case.node_numbers(body).filter(|_| is_given) {
        *values = numbers.iter().map(|n| values.get(*n as usize).copied().unwrap_or(absent)).collect();
    }
}

/// A case file, read with all that lies beside it.
pub(crate) struct File(pub(crate) PathBuf);

impl Source for File {
    fn parse(&self, overrides: &[(String, String)], volumes: bool) -> Result<AnyCase, Failure> {
        nndd_report::run::CaseFile::open(&self.0)?.parse(overrides, volumes)
    }

    fn read(&self, overrides: &[(String, String)]) -> Result<AnyCase, Failure> {
        nndd_report::run::CaseFile::open(&self.0)?.read(overrides)
    }
}

//! A case of the plane or of solids: which of the two follows from its bodies.

use super::dimension::Keys;
use super::{Case, Dimension, read};
use crate::case_file::{self, At, Document, NodeValue, Table};
use crate::diagnostic::{CaseError, code};
use fem_core::space::{Plane, Solid};
use mesh_io::MeshFile;
use std::path::Path;

/// A case of the plane or of solids. Nothing else asks which of the two it is.
#[derive(Clone, Debug)]
pub enum AnyCase {
    /// Bodies of triangles.
    Plane(Box<Case<Plane>>),
    /// Bodies of tetrahedra.
    Solid(Box<Case<Solid>>),
}

impl AnyCase {
    /// Reads a case file with the overrides of the command line, applied in their order.
    ///
    /// * `text`: the case file; a byte order mark and CRLF are accepted.
    /// * `file_name`: what messages call it.
    /// * `overrides`: dotted keys and TOML values, see [`case_file::split_override`].
    ///
    /// # Errors
    /// All independent faults together, each with its place.
    pub fn parse(text: &str, file_name: &str, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        Self::of_document(&case_file::parse(text, file_name, overrides)?, file_name, false)
    }

    /// Takes the keys of a program instead of those of a case file, see [`Self::parse`].
    ///
    /// * `name`: the name that a case file would have; `volumes`: see [`Self::parse_as`].
    ///
    /// # Errors
    /// All independent faults together, each with the key as its place.
    pub fn of_table(
        root: Table,
        name: &str,
        overrides: &[(String, String)],
        volumes: bool,
    ) -> Result<Self, CaseError> {
        Self::of_document(&Document::new(root, At::of_key("", ""), overrides)?, name, volumes)
    }

    /// Takes the keys of a program as [`Self::of_table`] does, and the mesh files that its bodies name, see [`Self::read`].
    ///
    /// * `meshes`: names and meshes that take the place of files.
    ///
    /// # Errors
    /// See [`Self::of_table`] and [`Case::read_mesh_files`].
    pub fn read_table(
        root: Table,
        name: &str,
        overrides: &[(String, String)],
        meshes: Vec<(String, MeshFile)>,
    ) -> Result<Self, CaseError> {
        let document = Document::new(root, At::of_key("", ""), overrides)?;
        Self::read_document(&document, name, meshes, Path::new(""))
    }

    /// Reads a case file from its bytes, see [`Self::parse`].
    ///
    /// # Errors
    /// Bytes that are not UTF-8, and what [`Self::parse`] refuses.
    pub fn parse_bytes(
        bytes: &[u8],
        file_name: &str,
        overrides: &[(String, String)],
    ) -> Result<Self, CaseError> {
        Self::parse(case_file::decode(bytes, file_name)?, file_name, overrides)
    }

    fn of_document(document: &Document, file_name: &str, volumes: bool) -> Result<Self, CaseError> {
        Ok(match volumes || is_solid(&document.root) {
            true => Self::Solid(Box::new(read::case(document, file_name)?)),
            false => Self::Plane(Box::new(read::case(document, file_name)?)),
        })
    }

    /// Reads a case file from its bytes as [`Self::parse_bytes`] does.
    ///
    /// * `volumes`: whether it is one of solids if its keys do not tell, since its mesh files hold tetrahedra.
    ///
    /// # Errors
    /// See [`Self::parse_bytes`].
    pub fn parse_as(
        bytes: &[u8],
        file_name: &str,
        overrides: &[(String, String)],
        volumes: bool,
    ) -> Result<Self, CaseError> {
        let document = case_file::parse(case_file::decode(bytes, file_name)?, file_name, overrides)?;
        Self::of_document(&document, file_name, volumes)
    }

    /// Reads a case file from its bytes as [`Self::parse_bytes`] does, and the mesh files that its bodies name. If the keys do not tell
    /// whether it is a case of solids, the cells of the first mesh file do.
    ///
    /// * `folder`: what the names of mesh files are relative to: the folder of the case file.
    ///
    /// # Errors
    /// See [`Self::parse`] and [`Case::read_mesh_files`].
    pub fn read(
        bytes: &[u8],
        file_name: &str,
        overrides: &[(String, String)],
        folder: &Path,
    ) -> Result<Self, CaseError> {
        let document = case_file::parse(case_file::decode(bytes, file_name)?, file_name, overrides)?;
        Self::read_document(&document, file_name, Vec::new(), folder)
    }

    fn read_document(
        document: &Document,
        name: &str,
        meshes: Vec<(String, MeshFile)>,
        folder: &Path,
    ) -> Result<Self, CaseError> {
        let given = meshes.iter().any(|(_, mesh)| mesh.has_volumes());
        let is_file = |file: &String| !given && meshes.iter().all(|(other, _)| other != file);
        let first = first_mesh_file(&document.root).filter(|file| is_file(file) && !is_solid(&document.root));
        // A file that cannot be read is reported with all others.
        let mesh = first.and_then(|file| Some((mesh_io::read(&folder.join(&file)).ok()?, file)));
        let volumes = given || mesh.as_ref().is_some_and(|(mesh, _)| mesh.has_volumes());
        match Self::of_document(document, name, volumes)? {
            Self::Plane(case) => Ok(Self::Plane(Box::new(case.with_meshes(meshes, mesh, folder)?))),
            Self::Solid(case) => Ok(Self::Solid(Box::new(case.with_meshes(meshes, mesh, folder)?))),
        }
    }

    /// Reads the mesh files that the bodies name, see [`Case::read_mesh_files`].
    ///
    /// * `folder`: what the names of mesh files are relative to: the folder of the case file.
    ///
    /// # Errors
    /// See [`Case::read_mesh_files`].
    pub fn read_mesh_files(&mut self, folder: &Path) -> Result<(), CaseError> {
        match self {
            Self::Plane(case) => case.read_mesh_files(folder),
            Self::Solid(case) => case.read_mesh_files(folder),
        }
    }

    /// Returns the case of the plane.
    ///
    /// # Errors
    /// A case of solids.
    pub fn into_plane(self) -> Result<Case<Plane>, CaseError> {
        match self {
            Self::Plane(case) => Ok(*case),
            Self::Solid(case) => {
                let place = if case.is_given("model.hypothesis") { "model.hypothesis" } else { "body" };
                let fault = case.diagnostic(
                    code::VALUE,
                    place,
                    "this case has solid bodies, and this works in the plane only",
                );
                let fault = fault.expected("bodies of the plane");
                Err(fault
                    .fix("solve it with `nndd solve`, or read it with `AnyCase`, which takes both")
                    .into())
            }
        }
    }
}

impl<S: Dimension> Case<S> {
    /// Reads the mesh files that the bodies name.
    ///
    /// * `given`: take the place of files; `kept`: was read already.
    fn with_meshes(
        mut self,
        given: Vec<(String, MeshFile)>,
        kept: Option<(MeshFile, String)>,
        folder: &Path,
    ) -> Result<Self, CaseError> {
        given.into_iter().for_each(|(name, mesh)| self.give_mesh(&name, mesh));
        kept.into_iter().for_each(|(mesh, name)| self.meshes.keep(&name, mesh));
        self.read_mesh_files(folder)?;
        Ok(self)
    }
}

/// Finds the first mesh file that a body names.
fn first_mesh_file(root: &Table) -> Option<String> {
    let NodeValue::Array(bodies) = &root.get("body")?.node.value else { return None };
    let text = |node: &NodeValue| match node {
        NodeValue::String(text) => Some(text.clone()),
        _ => None,
    };
    bodies.iter().find_map(|body| {
        let NodeValue::Table(body) = &body.value else { return None };
        let NodeValue::Table(mesh) = &body.get("mesh")?.node.value else { return None };
        text(&mesh.get("file")?.node.value)
    })
}

/// Tells whether a case is one of solids: it says so, or one of its bodies is.
fn is_solid(root: &Table) -> bool {
    let table = |node: &NodeValue, key: &str| match node {
        NodeValue::Table(table) => table.get(key).map(|entry| entry.node.value.clone()),
        _ => None,
    };
    let is = |node: Option<NodeValue>, words: &[&str]| match node {
        Some(NodeValue::String(word)) => words.contains(&word.as_str()),
        _ => false,
    };
    let model = root.get("model").and_then(|entry| table(&entry.node.value, "hypothesis"));
    let solids: Vec<&str> = Solid::GENERATORS.iter().map(|(kind, _)| *kind).collect();
    let bodies = match root.get("body").map(|entry| &entry.node.value) {
        Some(NodeValue::Array(bodies)) => &bodies[..],
        _ => &[],
    };
    let kind = |body: &case_file::Node| table(&table(&body.value, "generator")?, "kind");
    is(model, &["solid"]) || bodies.iter().any(|body| is(kind(body), &solids))
}

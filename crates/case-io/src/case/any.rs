//! A case of the plane or of solids: which of the two follows from its bodies.

use super::dimension::Keys;
use super::{Case, read};
use crate::case_file::{self, At, Document, NodeValue, Table};
use crate::diagnostic::{CaseError, code};
use fem_core::space::{Plane, Solid};
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
        Self::of_document(&case_file::parse(text, file_name, overrides)?, file_name)
    }

    /// Takes the keys of a program instead of those of a case file, see [`Self::parse`].
    ///
    /// * `name`: the name that a case file would have.
    ///
    /// # Errors
    /// All independent faults together, each with the key as its place.
    pub fn of_table(root: Table, name: &str, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        Self::of_document(&Document::new(root, At::of_key("", ""), overrides)?, name)
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

    fn of_document(document: &Document, file_name: &str) -> Result<Self, CaseError> {
        Ok(match is_solid(&document.root) {
            true => Self::Solid(Box::new(read::case(document, file_name)?)),
            false => Self::Plane(Box::new(read::case(document, file_name)?)),
        })
    }

    /// Reads the mesh files that the bodies name, see [`Case::read_mesh_files`]; solids have none.
    ///
    /// * `folder`: what the names of mesh files are relative to: the folder of the case file.
    ///
    /// # Errors
    /// See [`Case::read_mesh_files`].
    pub fn read_mesh_files(&mut self, folder: &Path) -> Result<(), CaseError> {
        match self {
            Self::Plane(case) => case.read_mesh_files(folder),
            Self::Solid(_) => Ok(()),
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
                let fault = case.diagnostic(code::VALUE, place, "this case has solid bodies");
                let fault = fault.expected("bodies of the plane");
                Err(fault.fix("read it with `AnyCase`, which takes both").into())
            }
        }
    }
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

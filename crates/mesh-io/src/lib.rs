//! Meshes from files, and fields to ParaView: the mesh formats of the contact solver, without its case files.
//!
//! ```text
//! .msh ─ gmsh ──┐
//!               ├─► MeshFile ─ region(), solid_regions() ─► Region ─ mesh() ─► fem_core::{TriMesh, TetMesh}
//! .inp ─ abaqus ┤       └─ summary() ─► Summary
//! .e ─── exodus ┤
//! .vtu ─ vtk ───┘
//! VtuMesh, VtuData ─ vtu ─► .vtu, .pvd, .vtu.series
//! ```
//! | to | use |
//! |---|---|
//! | read a mesh file, whatever its format | [`read`], or [`parse`] its bytes |
//! | take arrays of a program instead | [`MeshFile::of_arrays`] |
//! | look at what it holds | [`MeshFile::summary`] |
//! | take the mesh of one body from it | [`MeshFile::region`], of tetrahedra [`MeshFile::solid_regions`], then [`Region::mesh`] |
//! | say what is wrong with it, and where | [`MeshFileError`] |
//! | read a field of another program | [`read_point_vectors`] |
//! | write meshes and fields for ParaView | [`vtu`] |
//!
//! A [`MeshFile`] keeps the file's own numbers of nodes and elements, so that every message can use them. Its
//! groups are sets of nodes, edges, cells or volumes; a group of cells is a region that can become a body, a group of edges
//! becomes a named side of the bodies it borders. In a mesh of volumes groups of volumes become bodies, and groups of cells their sides. Files are taken to be hostile: memory is bounded by the size of
//! the file, never by a count in it, and every fault is an error with its place.
//!
//! # Example
//! ```
//! use mesh_io::RegionOptions;
//! let text = b"*NODE\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n*ELEMENT, TYPE=CPS4, ELSET=plate\n1, 1, 2, 3, 4\n\
//!     *SURFACE, NAME=base\n1, S1\n";
//! let file = mesh_io::parse(text, "plate.inp")?;
//! let region = file.region(Some("plate"), RegionOptions::default())?;
//! assert_eq!(region.notes(), ["1 quadrilateral of region \"plate\" was split into two triangles along the shorter diagonal"]);
//! let mesh = region.mesh()?;
//! assert_eq!((mesh.cells().len(), mesh.group("base").map(|edges| edges.len())), (2, Some(1)));
//! # Ok::<(), mesh_io::MeshFileError>(())
//! ```

mod field_file;
mod links;
mod mesh_file;
pub mod numeral;
pub mod vtu;
pub mod words;

pub use field_file::{FIELD_COLUMNS, read_point_vectors};
pub use links::BrokenLink;
pub use mesh_file::{
    ElementKind, GroupSummary, LARGEST_MESH_FILE, MeshArrays, MeshFault, MeshFile, MeshFileError, MeshPlace,
    Problem, Quality, Region, RegionOptions, Remedy, Summary, abaqus, exodus, glued_nodes, gmsh, parse, read,
    vtk,
};

//! Mesh files: what one holds, and the bodies that can be taken from it.
//!
//! `gmsh`, `abaqus`, `exodus` and `vtk` fill a `Collector`, whose checked contents are the [`MeshFile`]; `arrays` makes one of a program's arrays.
//! `region`, `sides` and `flat`, for volumes `solid` and `shape`, take a [`Region`] from it, `faults` makes fem-core's mesh of one, `summary` looks at all of it.

pub mod abaqus;
mod arrays;
mod collect;
mod connected;
mod error;
pub mod exodus;
mod faults;
mod flat;
pub mod gmsh;
mod index;
mod kind;
mod problem;
mod read;
mod region;
mod shape;
mod sides;
mod solid;
mod summary;
pub mod vtk;

#[cfg(test)]
mod tests;

pub use arrays::MeshArrays;
pub use error::{MeshFault, MeshFileError, MeshPlace};
pub use kind::ElementKind;
pub use problem::{Problem, Remedy};
pub use read::{LARGEST_MESH_FILE, parse, read};
pub use region::{Region, RegionOptions, glued_nodes};
pub use summary::{GroupSummary, Quality, Summary};

pub(crate) use collect::{Collected, Collector, Spot};
pub(crate) use error::first_bytes;
pub(crate) use index::NumberIndex;
pub(crate) use read::{Unreadable, regular_file};

use std::path::{Path, PathBuf};

/// How a deck reads the files it includes: their contents, and where they were found.
pub(crate) type Includes<'a> = &'a mut dyn FnMut(&Path, &str) -> Result<(PathBuf, Vec<u8>), Unreadable>;

/// The content of a mesh file: nodes, edges, cells, volumes and named groups of them, by the file's own numbers.
#[derive(Clone, Debug, Default)]
pub struct MeshFile {
    name: String,
    format: String,
    /// Ascending, different.
    node_numbers: Vec<u64>,
    /// As many as numbers.
    points: Vec<[f64; 3]>,
    /// True for a node that an edge or a cell uses.
    used: Vec<bool>,
    /// By ascending number.
    edges: Vec<Edge>,
    /// By ascending number.
    cells: Vec<MeshCell>,
    /// Tetrahedra, pyramids, prisms and hexahedra, by ascending number; the cells are then their faces.
    volumes: Vec<MeshCell>,
    groups: Vec<Group>,
    /// True if the groups are what the mesh was drawn of, and not what a user named.
    elementary: bool,
    notes: Vec<String>,
    digest: String,
}

/// An edge that the file gives; its nodes are places in the list of nodes.
#[derive(Clone, Copy, Debug)]
struct Edge {
    number: u64,
    nodes: [u32; 2],
}

/// A cell or volume that the file gives; its corners are places in the list of nodes, the last one repeated.
#[derive(Clone, Copy, Debug)]
struct MeshCell {
    number: u64,
    kind: ElementKind,
    corners: [u32; ElementKind::MOST_CORNERS],
}

impl MeshCell {
    /// Makes a cell; there is at least one corner, and at most as many as its kind has.
    fn new(number: u64, kind: ElementKind, given: &[u32]) -> Self {
        let last = given.last().copied().unwrap_or_default();
        Self { number, kind, corners: std::array::from_fn(|k| given.get(k).copied().unwrap_or(last)) }
    }

    /// Returns the first four corners: all of a surface or of a tetrahedron.
    fn first_four(&self) -> [u32; 4] {
        let [a, b, c, d, ..] = self.corners;
        [a, b, c, d]
    }
}

/// A named set of nodes (dimension 0), edges (1), cells (2) or volumes (3).
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub(crate) dimension: u8,
    pub(crate) name: String,
    /// Places in the list of nodes, edges, cells or volumes; ascending.
    pub(crate) members: Vec<u32>,
}

impl MeshFile {
    /// Counts the nodes, those without cells included.
    pub fn node_count(&self) -> u64 {
        self.points.len() as u64
    }

    /// Returns what messages call the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns format and version in words, such as `Gmsh MSH 4.1, binary`.
    pub fn format(&self) -> &str {
        &self.format
    }

    /// Returns what is worth knowing about how the file was read.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the SHA-256 of the file and of all files it includes, in hexadecimal.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Tells whether there are volumes, of which solid bodies are made.
    pub fn has_volumes(&self) -> bool {
        !self.volumes.is_empty()
    }

    /// Lists the names of the groups of one dimension: 1 for edges, 2 for cells, 3 for volumes.
    pub fn group_names(&self, dimension: u8) -> impl Iterator<Item = &str> {
        self.groups.iter().filter(move |g| g.dimension == dimension).map(|g| g.name.as_str())
    }

    pub(crate) fn push_group(&mut self, mut group: Group) {
        // Names are shown on terminals, which take control characters for orders.
        group.name = group.name.replace(char::is_control, "\u{FFFD}");
        self.groups.push(group);
    }

    /// Notes that elementary entities take the place of groups.
    pub(crate) fn note_elementary_groups(&mut self) {
        self.elementary = true;
        self.push_note(
            "no physical groups: elementary entities take their place, called by number".to_owned(),
        );
    }

    pub(crate) fn push_note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// Adds an edge that the file describes by other means than an element; returns its place.
    pub(crate) fn push_edge(&mut self, cell: u32, side: usize) -> Option<u32> {
        let cell = self.cells.get(cell as usize)?;
        let corners = cell.kind.corners();
        if side >= corners {
            return None;
        }
        let nodes = [cell.corners[side], cell.corners[(side + 1) % corners]];
        self.edges.push(Edge { number: cell.number, nodes });
        Some(self.edges.len() as u32 - 1)
    }

    /// Adds a face of a volume, counted as Abaqus counts; returns its place.
    pub(crate) fn push_face(&mut self, volume: u32, side: usize) -> Option<u32> {
        let face = self.volumes.get(volume as usize)?.face(side)?;
        self.push_corners(volume, face)
    }

    /// Adds a face of a volume, counted from 1 as Exodus counts; returns its place.
    pub(crate) fn push_exodus_face(&mut self, volume: u32, side: u64) -> Option<u32> {
        let face = self.volumes.get(volume as usize)?.exodus_face(side)?;
        self.push_corners(volume, face)
    }

    fn push_corners(&mut self, volume: u32, face: [u32; 4]) -> Option<u32> {
        let volume = self.volumes.get(volume as usize)?;
        let kind = if face[2] == face[3] { ElementKind::Triangle3 } else { ElementKind::Quad4 };
        self.cells.push(MeshCell::new(volume.number, kind, &face));
        Some(self.cells.len() as u32 - 1)
    }

    pub(crate) fn node_numbers(&self) -> &[u64] {
        &self.node_numbers
    }

    pub(crate) fn edge_numbers(&self) -> Vec<u64> {
        self.edges.iter().map(|e| e.number).collect()
    }

    pub(crate) fn cell_numbers(&self) -> Vec<u64> {
        self.cells.iter().map(|c| c.number).collect()
    }

    pub(crate) fn volume_numbers(&self) -> Vec<u64> {
        self.volumes.iter().map(|v| v.number).collect()
    }

    fn fault(&self, fault: MeshFault, found: impl Into<String>) -> MeshFileError {
        MeshFileError::new(fault, &self.name, MeshPlace::File, found)
    }
}

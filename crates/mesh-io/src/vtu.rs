//! ParaView files: one unstructured grid per file (`.vtu`, VTK XML, appended raw data, little endian, 64-bit
//! headers) and collections of them (`.pvd`, `.vtu.series`).
//!
//! Vectors have three components and symmetric tensors six, in VTK's order XX, YY, ZZ, XY, YZ, XZ.

mod collection;
mod document;
mod fields;

pub use collection::{PvdEntry, pvd, series};
pub(crate) use document::{Document, VTK_AXES};
pub(crate) use fields::point_vectors;
pub use fields::{FieldError, PointVectors};

use crate::words::attribute;
use fem_core::geometry::Coordinates;
use fem_core::mesh::Mesh;
use fem_core::space::Space;
use std::fmt::Write as _;
use std::io::{self, Write};
use thiserror::Error;

/// The cells of a grid, all of one kind.
#[derive(Clone, Debug, PartialEq)]
pub enum VtuCells {
    /// VTK type 3.
    Lines(Vec<[u32; 2]>),
    /// VTK type 5.
    Triangles(Vec<[u32; 3]>),
    /// VTK type 10.
    Tetrahedra(Vec<[u32; 4]>),
}

impl VtuCells {
    /// Makes cells of the numbers of their corners: two lines, three triangles, four tetrahedra; other numbers of corners make none.
    ///
    /// * `nodes`: cell after cell.
    pub(crate) fn of_corners(corners: usize, nodes: &[u32]) -> Self {
        match corners {
            2 => Self::Lines(nodes.as_chunks().0.to_vec()),
            3 => Self::Triangles(nodes.as_chunks().0.to_vec()),
            4 => Self::Tetrahedra(nodes.as_chunks().0.to_vec()),
            _ => Self::Lines(Vec::new()),
        }
    }

    fn nodes(&self) -> &[u32] {
        match self {
            Self::Lines(cells) => cells.as_flattened(),
            Self::Triangles(cells) => cells.as_flattened(),
            Self::Tetrahedra(cells) => cells.as_flattened(),
        }
    }

    fn corners_and_type(&self) -> (usize, u8) {
        match self {
            Self::Lines(_) => (2, 3),
            Self::Triangles(_) => (3, 5),
            Self::Tetrahedra(_) => (4, 10),
        }
    }

    fn len(&self) -> usize {
        self.nodes().len() / self.corners_and_type().0
    }
}

/// Points and cells.
#[derive(Clone, Debug, PartialEq)]
pub struct VtuMesh {
    /// Positions, in the plane with z = 0, see [`three`].
    pub points: Vec<[f64; 3]>,
    /// Cells by the numbers of their points.
    pub cells: VtuCells,
}

impl<S: Space> From<&Mesh<S>> for VtuMesh {
    fn from(mesh: &Mesh<S>) -> Self {
        let nodes: Vec<u32> = mesh.cells().iter().flat_map(|corners| *corners).map(u32::from).collect();
        let points = mesh.points().iter().map(three).collect();
        Self { points, cells: VtuCells::of_corners(1 + S::DIM, &nodes) }
    }
}

/// Returns three components of a vector: of a plane one the third is 0.
pub fn three<V: Coordinates>(vector: &V) -> [f64; 3] {
    let entries = vector.entries();
    std::array::from_fn(|c| entries.get(c).copied().unwrap_or(0.0))
}

/// A named field: one entry of `components` numbers per point, per cell, or any number of them as field data.
#[derive(Clone, Debug, PartialEq)]
pub struct VtuArray {
    /// Its name in ParaView.
    pub name: String,
    /// 1, 3 or 6.
    pub components: usize,
    /// Entry after entry.
    pub values: Vec<f64>,
    /// True if the values are whole numbers, such as numbers of materials; they are then written as `Int64`.
    pub whole: bool,
}

impl VtuArray {
    /// Makes a field of numbers.
    pub fn scalars(name: &str, values: Vec<f64>) -> Self {
        Self { name: name.to_owned(), components: 1, values, whole: false }
    }

    /// Makes a field of whole numbers, exact up to 2⁵³.
    pub fn integers(name: &str, values: Vec<usize>) -> Self {
        let values = values.into_iter().map(|v| v as f64).collect();
        Self { whole: true, ..Self::scalars(name, values) }
    }

    /// Makes a field of vectors of three components, so that ParaView can warp by it; of plane vectors the third is 0.
    pub fn vectors<V: Coordinates>(name: &str, values: &[V]) -> Self {
        let values = values.iter().map(three).collect::<Vec<_>>().into_flattened();
        Self { name: name.to_owned(), components: 3, values, whole: false }
    }

    /// Makes a field of symmetric tensors, each as XX, YY, ZZ, XY, YZ, XZ.
    pub fn tensors(name: &str, values: Vec<[f64; 6]>) -> Self {
        Self { name: name.to_owned(), components: 6, values: values.into_flattened(), whole: false }
    }
}

/// The fields of a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VtuData {
    /// One entry per point.
    pub point: Vec<VtuArray>,
    /// One entry per cell.
    pub cell: Vec<VtuArray>,
    /// Of the whole grid, such as the number of the iteration.
    pub field: Vec<VtuArray>,
}

/// Why a grid cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum VtuError {
    /// A field whose size does not fit.
    #[error(
        "the array \"{name}\" has {values} numbers; {entries} entries of {components} components are needed (1, 3 or 6)"
    )]
    Size {
        /// Its name.
        name: String,
        /// Numbers found.
        values: usize,
        /// Entries needed.
        entries: usize,
        /// Components.
        components: usize,
    },
    /// A cell with a point that does not exist.
    #[error("a cell names the point {point}, but there are {points} points")]
    NoSuchPoint {
        /// The point.
        point: u32,
        /// How many there are.
        points: usize,
    },
    /// A number that is infinite or NaN.
    #[error("the array \"{name}\" has {value} in entry {entry}; only finite numbers are written")]
    NotFinite {
        /// Its name.
        name: String,
        /// Entry, from 0.
        entry: usize,
        /// The number.
        value: f64,
    },
    /// An error of the writer.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Writes a grid.
///
/// ```
/// use fem_core::geometry::Vector;
/// use mesh_io::vtu::{VtuArray, VtuCells, VtuData, VtuMesh, write};
/// let mesh = VtuMesh {
///     points: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
///     cells: VtuCells::Triangles(vec![[0, 1, 2]]),
/// };
/// let values = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.2]].map(Vector::from);
/// let displacement = VtuArray::vectors("displacement", &values);
/// let mut file = Vec::new();
/// write(&mut file, &mesh, &VtuData { point: vec![displacement], ..VtuData::default() })?;
/// assert!(file.starts_with(b"<?xml"));
/// # Ok::<(), mesh_io::vtu::VtuError>(())
/// ```
///
/// # Errors
/// Fields that do not fit the mesh or are not finite, and what the writer reports.
pub fn write(out: &mut dyn Write, mesh: &VtuMesh, data: &VtuData) -> Result<(), VtuError> {
    check(mesh, data)?;
    let mut layout = Layout { end: total(mesh, data) };
    let xml = header(&mut layout, mesh, data);
    out.write_all(xml.as_bytes())?;
    let fields = |out: &mut dyn Write, arrays: &[VtuArray]| -> io::Result<()> {
        let mut arrays = arrays.iter().rev();
        arrays.try_for_each(|a| {
            let bytes = |v: &f64| if a.whole { (*v as i64).to_le_bytes() } else { v.to_le_bytes() };
            block(out, a.values.len(), a.values.iter().map(bytes))
        })
    };
    // Against the order of the header.
    let (corners, kind) = mesh.cells.corners_and_type();
    let count = mesh.cells.len();
    block(out, count, (0..count).map(|_| [kind]))?;
    block(out, count, (1..=count).map(|k| ((k * corners) as i64).to_le_bytes()))?;
    let nodes = mesh.cells.nodes();
    block(out, nodes.len(), nodes.iter().map(|&n| i64::from(n).to_le_bytes()))?;
    let coordinates = mesh.points.as_flattened().iter();
    block(out, 3 * mesh.points.len(), coordinates.map(|x| x.to_le_bytes()))?;
    fields(out, &data.cell)?;
    fields(out, &data.point)?;
    fields(out, &data.field)?;
    out.write_all(b"\n  </AppendedData>\n</VTKFile>\n")?;
    Ok(())
}

fn check(mesh: &VtuMesh, data: &VtuData) -> Result<(), VtuError> {
    let points = mesh.points.len();
    if let Some(&point) = mesh.cells.nodes().iter().find(|&&n| n as usize >= points) {
        return Err(VtuError::NoSuchPoint { point, points });
    }
    let finite = |name: &str, components: usize, values: &mut dyn Iterator<Item = &f64>| {
        let bad = values.enumerate().find(|(_, v)| !v.is_finite());
        bad.map_or(Ok(()), |(k, value)| {
            Err(VtuError::NotFinite { name: name.to_owned(), entry: k / components, value: *value })
        })
    };
    finite("points", 3, &mut mesh.points.as_flattened().iter())?;
    let sizes = [(&data.point, Some(points)), (&data.cell, Some(mesh.cells.len())), (&data.field, None)];
    for (arrays, entries) in sizes {
        for array in arrays {
            let (values, components) = (array.values.len(), array.components);
            let entries = entries.unwrap_or(values / components.max(1));
            if ![1, 3, 6].contains(&components) || values != entries * components {
                return Err(VtuError::Size { name: array.name.clone(), values, entries, components });
            }
            finite(&array.name, components, &mut array.values.iter())?;
        }
    }
    Ok(())
}

/// Computes the length of all appended blocks.
fn total(mesh: &VtuMesh, data: &VtuData) -> usize {
    let fields: usize =
        [&data.field, &data.point, &data.cell].into_iter().flatten().map(|a| 8 + 8 * a.values.len()).sum();
    let cells = mesh.cells.len();
    fields + (8 + 24 * mesh.points.len()) + (8 + 8 * mesh.cells.nodes().len()) + (8 + 8 * cells) + (8 + cells)
}

/// Hands out the places of the appended blocks, from the last to the first: each is its length in eight bytes and its
/// data.
///
/// meshio 5 gives the arrays new offsets as it reads, and looks for the next old one among old and new. In this order it
/// finds the right one first; in the order of the header it may take one array for another.
struct Layout {
    /// The byte at which the block before ends.
    end: usize,
}

impl Layout {
    fn array(&mut self, xml: &mut String, attributes: &str, bytes: usize) {
        self.end = self.end.saturating_sub(8 + bytes);
        let offset = self.end;
        // Writing to a string cannot fail.
        let _ = writeln!(xml, "        <DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>");
    }

    fn section(&mut self, xml: &mut String, tag: &str, arrays: &[VtuArray]) {
        let _ = writeln!(xml, "      <{tag}>");
        for array in arrays {
            let tuples = match tag {
                "FieldData" => format!(" NumberOfTuples=\"{}\"", array.values.len() / array.components),
                _ => String::new(),
            };
            // One component is the default; written out, meshio makes columns of the numbers.
            let components = match array.components {
                1 => String::new(),
                n => format!(" NumberOfComponents=\"{n}\""),
            };
            let kind = if array.whole { "Int64" } else { "Float64" };
            let attributes =
                format!("type=\"{kind}\" Name=\"{}\"{components}{tuples}", attribute(&array.name));
            self.array(xml, &attributes, 8 * array.values.len());
        }
        let _ = writeln!(xml, "      </{tag}>");
    }
}

fn header(layout: &mut Layout, mesh: &VtuMesh, data: &VtuData) -> String {
    let (points, cells) = (mesh.points.len(), mesh.cells.len());
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n  <UnstructuredGrid>\n",
    );
    if !data.field.is_empty() {
        layout.section(&mut xml, "FieldData", &data.field);
    }
    let _ = writeln!(xml, "    <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
    layout.section(&mut xml, "PointData", &data.point);
    layout.section(&mut xml, "CellData", &data.cell);
    xml.push_str("      <Points>\n");
    layout.array(&mut xml, "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", 24 * points);
    xml.push_str("      </Points>\n      <Cells>\n");
    layout.array(&mut xml, "type=\"Int64\" Name=\"connectivity\"", 8 * mesh.cells.nodes().len());
    layout.array(&mut xml, "type=\"Int64\" Name=\"offsets\"", 8 * cells);
    layout.array(&mut xml, "type=\"UInt8\" Name=\"types\"", cells);
    xml.push_str(
        "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _",
    );
    xml
}

/// Writes one appended block, gathered in pieces so that the writer need not be buffered.
fn block<const N: usize>(
    out: &mut dyn Write,
    count: usize,
    items: impl Iterator<Item = [u8; N]>,
) -> io::Result<()> {
    const PIECE: usize = 1 << 16;
    let mut buffer = Vec::with_capacity((8 + count * N).min(PIECE + 64));
    buffer.extend_from_slice(&((count * N) as u64).to_le_bytes());
    for item in items {
        buffer.extend_from_slice(&item);
        if buffer.len() >= PIECE {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    out.write_all(&buffer)
}

#[cfg(test)]
mod tests;

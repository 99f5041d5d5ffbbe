//! Unstructured grids of VTK XML (`.vtu`), as ParaView and many programs write them.
//!
//! The types of cells and the order of their nodes are those of VTK's file formats, <https://docs.vtk.org>. Regions are the values of whole-number
//! arrays at cells: the cells with the value 3 in the array `material` are the region `material_3`, and surfaces with it the side of this
//! name. Nodes and elements of messages are counted from 0, as ParaView shows them. Fields at points are not read here.

#[cfg(test)]
mod tests;

use super::{Collected, Collector, ElementKind, Group, MeshFault, MeshFile, MeshFileError, MeshPlace, Spot};
use crate::vtu::{Document, FieldError, VTK_AXES};
use std::collections::BTreeMap;

/// Arrays that may give regions, and values of one of them: those with more are numbers of cells.
const MOST_ARRAYS: usize = 8;
const MOST_VALUES: usize = 1000;

/// Reads a mesh from the bytes of a `.vtu` file.
///
/// * `name`: what messages call it.
///
/// # Errors
/// Other files of VTK, types of cells that are not read, and everything that makes it no mesh.
pub fn parse(bytes: &[u8], name: &str) -> Result<MeshFile, MeshFileError> {
    let fault =
        |why: FieldError| MeshFileError::new(MeshFault::Syntax, name, MeshPlace::File, why.to_string());
    let file = Document::new(bytes).map_err(fault)?;
    let mut collector = Collector::new(name);
    let mut values: BTreeMap<String, Vec<(usize, i64)>> = BTreeMap::new();
    let mut nodes = 0;
    for piece in &file.pieces {
        let points = file
            .reals(piece.points().map_err(fault)?, piece.count.saturating_mul(VTK_AXES))
            .map_err(fault)?;
        if points.len() != piece.count.saturating_mul(VTK_AXES) {
            let found = format!("it has {} coordinates for {} points", points.len(), piece.count);
            return Err(MeshFileError::new(MeshFault::Syntax, name, MeshPlace::File, found));
        }
        let first = (nodes, collector.element_count());
        for point in points.as_chunks::<VTK_AXES>().0 {
            collector.node(nodes, *point, Spot::default())?;
            nodes += 1;
        }
        let whole = |name: &str, most: usize| {
            piece.cells(name).and_then(|array| file.integers(array, most)).map_err(fault)
        };
        let types = whole("types", piece.cell_count)?;
        let offsets = whole("offsets", piece.cell_count)?;
        let most = piece.cell_count.saturating_mul(ElementKind::MOST_NODES);
        let cells = Cells { types, offsets, nodes: whole("connectivity", most)? };
        cells.collect(name, first, &mut collector)?;
        let arrays = piece.cell_arrays.iter().filter(|array| array.components == 1 && array.is_whole());
        for array in arrays.take(MOST_ARRAYS) {
            let numbers = file.integers(array, piece.cell_count).map_err(fault)?;
            let of_array = values.entry(array.name.clone()).or_default();
            of_array.extend(
                numbers
                    .into_iter()
                    .take(cells.types.len())
                    .enumerate()
                    .map(|(k, value)| (first.1 + k, value)),
            );
        }
    }
    let mut collected = collector.finish("VTK XML".to_owned())?;
    for (array, values) in values {
        add_regions(&mut collected, &array, values);
    }
    Ok(collected.mesh)
}

/// The cells of a piece.
struct Cells {
    types: Vec<i64>,
    /// Where the nodes of each cell end.
    offsets: Vec<i64>,
    nodes: Vec<i64>,
}

impl Cells {
    /// Adds the cells; each is a set of its own, so that its place is found by its number.
    ///
    /// * `first`: numbers of the first node and the first cell.
    fn collect(
        &self,
        file: &str,
        first: (u64, usize),
        collector: &mut Collector,
    ) -> Result<(), MeshFileError> {
        let fault = |kind: MeshFault, found: String| MeshFileError::new(kind, file, MeshPlace::File, found);
        if self.types.len() != self.offsets.len() {
            let found = format!(
                "the grid has {} types and {} offsets of cells",
                self.types.len(),
                self.offsets.len()
            );
            return Err(fault(MeshFault::Syntax, found).expected("one of both for each cell"));
        }
        let mut begin = 0;
        for (k, (code, end)) in self.types.iter().zip(&self.offsets).enumerate() {
            let number = first.1 + k;
            let nodes = usize::try_from(*end)
                .ok()
                .and_then(|end| self.nodes.get(std::mem::replace(&mut begin, end)..end));
            let Some((kind, order)) = kind(*code) else {
                let error = fault(MeshFault::Format, format!("cell {number} has the VTK type {code}"));
                let error = error.expected("lines, triangles, quadrilaterals, tetrahedra, pyramids, wedges and hexahedra, linear or quadratic");
                return Err(
                    error.help("in ParaView: Extract Cells by Type, or Tetrahedralize, then save as .vtu")
                );
            };
            let nodes: Option<Vec<u64>> = nodes.filter(|nodes| nodes.len() == kind.nodes()).map(|nodes| {
                // A negative number becomes one that no node has.
                nodes
                    .iter()
                    .map(|node| u64::try_from(*node).map_or(u64::MAX, |node| first.0.saturating_add(node)))
                    .collect()
            });
            let Some(mut nodes) = nodes else {
                let found = format!("cell {number} ({}) has other nodes than its type", kind.name());
                return Err(fault(MeshFault::Syntax, found).expected(format!("{} nodes", kind.nodes())));
            };
            for [a, b] in order {
                nodes.swap(*a, *b);
            }
            collector.element(number as u64, kind, &nodes, number as u32, Spot::default());
        }
        Ok(())
    }
}

/// Finds the kind of a VTK type, and the pairs of nodes that it has in another order.
fn kind(code: i64) -> Option<(ElementKind, &'static [[usize; 2]])> {
    Some(match code {
        1 => (ElementKind::Point, &[]),
        3 => (ElementKind::Edge2, &[]),
        5 => (ElementKind::Triangle3, &[]),
        // A pixel.
        8 => (ElementKind::Quad4, &[[2, 3]]),
        9 => (ElementKind::Quad4, &[]),
        10 => (ElementKind::Tetra4, &[]),
        // A voxel.
        11 => (ElementKind::Hexa8, &[[2, 3], [6, 7]]),
        12 => (ElementKind::Hexa8, &[]),
        13 => (ElementKind::Prism6, &[]),
        14 => (ElementKind::Pyramid5, &[]),
        21 => (ElementKind::Edge3, &[]),
        22 => (ElementKind::Triangle6, &[]),
        23 => (ElementKind::Quad8, &[]),
        24 => (ElementKind::Tetra10, &[]),
        25 => (ElementKind::Hexa20, &[]),
        26 => (ElementKind::Prism15, &[]),
        27 => (ElementKind::Pyramid13, &[]),
        28 => (ElementKind::Quad9, &[]),
        29 => (ElementKind::Hexa27, &[]),
        32 => (ElementKind::Prism18, &[]),
        _ => return None,
    })
}

/// Makes a group of each value of an array, for each dimension of cells.
fn add_regions(collected: &mut Collected, array: &str, values: Vec<(usize, i64)>) {
    let of_cell: BTreeMap<usize, i64> = values.into_iter().collect();
    let mut members: BTreeMap<(i64, u8), Vec<u32>> = BTreeMap::new();
    let all = [(3, &collected.volume_sets), (2, &collected.cell_sets), (1, &collected.edge_sets)];
    for (dimension, cells) in all {
        for (place, cell) in (0u32..).zip(cells) {
            if let Some(value) = of_cell.get(&(*cell as usize)) {
                members.entry((*value, dimension)).or_default().push(place);
            }
        }
    }
    if members.len() > MOST_VALUES {
        let note =
            format!("the array \"{array}\" of the cells has more than {MOST_VALUES} values: no regions");
        return collected.mesh.push_note(note);
    }
    for ((value, dimension), members) in members {
        let name = format!("{array}_{value}");
        collected.mesh.push_group(Group { dimension, name, members });
    }
}

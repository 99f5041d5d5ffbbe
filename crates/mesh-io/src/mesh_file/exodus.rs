//! Exodus II files (`.e`, `.exo`, `.g`), as Cubit, SEACAS and MOOSE write them: classic netCDF, read without a library.
//!
//! The names of variables and the numbering of faces are those of the EXODUS II manual (Sandia report SAND92-2137). Element blocks are
//! regions, side sets are sides, and so are node sets whose name no side set has. A part without a name is called by its number as SEACAS
//! does: `block_1`, `surface_1`, `nodelist_1`. Nodes and elements of messages are counted from 1 in the order of the file, as sets count
//! them. Results in the file are not read. Shells are surfaces of a mesh of volumes.
//!
//! netCDF-4 files are HDF5 files, which are not read: `nccopy -k classic old.e new.e` converts one.

mod netcdf;

#[cfg(test)]
mod tests;

use super::{
    Collected, Collector, ElementKind, Group, MeshFault, MeshFile, MeshFileError, NumberIndex, Spot,
};
use crate::words::counted;
use netcdf::{NetCdf, Variable, until_zero};
use std::collections::HashSet;

/// The first bytes of a classic netCDF file, and of an HDF5 file.
pub(super) const CLASSIC: &[u8] = b"CDF";
pub(super) const HDF5: &[u8] = b"\x89HDF";

/// Words with which the types of elements begin, in upper case, and their kinds from few nodes to many.
const KINDS: [(&str, &[ElementKind]); 13] = [
    ("TET", &[ElementKind::Tetra4, ElementKind::Tetra10]),
    ("PYR", &[ElementKind::Pyramid5, ElementKind::Pyramid13, ElementKind::Pyramid14]),
    ("WED", &[ElementKind::Prism6, ElementKind::Prism15, ElementKind::Prism18]),
    ("HEX", &[ElementKind::Hexa8, ElementKind::Hexa20, ElementKind::Hexa27]),
    ("TRI", &[ElementKind::Triangle3, ElementKind::Triangle6]),
    ("QUA", &[ElementKind::Quad4, ElementKind::Quad8, ElementKind::Quad9]),
    (
        "SHE",
        &[
            ElementKind::Triangle3,
            ElementKind::Quad4,
            ElementKind::Triangle6,
            ElementKind::Quad8,
            ElementKind::Quad9,
        ],
    ),
    ("BAR", &[ElementKind::Edge2, ElementKind::Edge3]),
    ("BEA", &[ElementKind::Edge2, ElementKind::Edge3]),
    ("TRU", &[ElementKind::Edge2, ElementKind::Edge3]),
    ("EDG", &[ElementKind::Edge2, ElementKind::Edge3]),
    ("SPH", &[ElementKind::Point]),
    ("CIR", &[ElementKind::Point]),
];

/// Reads a mesh from the bytes of an Exodus file.
///
/// * `name`: what messages call it.
///
/// # Errors
/// Other netCDF files, types of elements that are not read, and everything that makes it no mesh, with its place.
pub fn parse(bytes: &[u8], name: &str) -> Result<MeshFile, MeshFileError> {
    let data = NetCdf::parse(bytes, name)?;
    let mut collector = Collector::new(name);
    let axes = nodes(&data, &mut collector)?;
    let blocks = Parts::read(&data, "eb", "block")?;
    for (set, (number, _)) in (1u32..).zip(&blocks.0) {
        block(&data, *number, set, &mut collector)?;
    }
    let encoding = match data.version {
        1 => "netCDF classic",
        2 => "netCDF with 64-bit offsets",
        _ => "netCDF CDF-5",
    };
    let mut collected = collector.finish(format!("Exodus II, {encoding}"))?;
    let mut taken = HashSet::new();
    add_blocks(&mut collected, &blocks, &mut taken);
    let mut mesh = collected.mesh;
    add_side_sets(&data, &mut mesh, axes, &mut taken)?;
    add_node_sets(&data, &mut mesh, &taken)?;
    Ok(mesh)
}

/// The numbers, from 1, and names of blocks or sets.
struct Parts(Vec<(usize, String)>);

impl Parts {
    /// Reads names and identifiers.
    ///
    /// * `prefix`: with which the names of the variables begin; `word`: for parts without a name.
    fn read(data: &NetCdf<'_>, prefix: &str, word: &str) -> Result<Self, MeshFileError> {
        let Some(ids) = data.variable(&format!("{prefix}_prop1")) else { return Ok(Self(Vec::new())) };
        let names = data.variable(&format!("{prefix}_names")).map(|names| data.texts(names)).transpose()?;
        let names = names.unwrap_or_default();
        let mut taken = HashSet::new();
        let named = data.integers(ids)?.into_iter().enumerate().map(|(k, id)| {
            let given = names.get(k).filter(|name| !name.is_empty() && !taken.contains(*name));
            let name = given.cloned().unwrap_or_else(|| format!("{word}_{id}"));
            taken.insert(name.clone());
            (k + 1, name)
        });
        Ok(Self(named.collect()))
    }
}

/// Reads the nodes; returns the number of axes.
fn nodes(data: &NetCdf<'_>, collector: &mut Collector) -> Result<usize, MeshFileError> {
    let axes = match data.length("num_dim") {
        Some(2) => 2,
        Some(3) => 3,
        Some(axes) => {
            let error = data.fault(MeshFault::Format, format!("the mesh has {axes} axes"));
            return Err(error.expected("2 or 3"));
        }
        None => {
            let error = data.fault(MeshFault::Format, "a netCDF file without the dimension num_dim");
            return Err(error.expected("an Exodus II file, which has it"));
        }
    };
    let mut coordinates: Vec<Vec<f64>> = Vec::new();
    if let Some(all) = data.variable("coord") {
        let values = data.reals(all)?;
        let count = values.len() / axes;
        coordinates.extend(values.chunks(count.max(1)).map(<[f64]>::to_vec));
    } else {
        for name in &["coordx", "coordy", "coordz"][..axes] {
            let Some(variable) = data.variable(name) else {
                let error = data.fault(MeshFault::Content, format!("the file has no coordinates {name}"));
                return Err(error.expected("coordinates of the nodes"));
            };
            coordinates.push(data.reals(variable)?);
        }
    }
    let count = coordinates.first().map_or(0, Vec::len);
    if coordinates.len() != axes || coordinates.iter().any(|axis| axis.len() != count) {
        let error = data.fault(MeshFault::Content, "the axes have different numbers of coordinates");
        return Err(error.expected("one coordinate for each node and axis"));
    }
    collector.reserve_nodes(count);
    for k in 0..count {
        let point = [0, 1, 2].map(|c| coordinates.get(c).map_or(0.0, |axis| axis[k]));
        collector.node(k as u64 + 1, point, Spot::default())?;
    }
    Ok(axes)
}

/// Reads the elements of a block.
fn block(data: &NetCdf<'_>, number: usize, set: u32, collector: &mut Collector) -> Result<(), MeshFileError> {
    let Some(variable) = data.variable(&format!("connect{number}")) else {
        // A block without elements has no variable; one of polyhedra has others.
        let Some(faces) =
            data.variable(&format!("ebconn{number}")).or(data.variable(&format!("facconn{number}")))
        else {
            return Ok(());
        };
        let error = data.fault_in(faces, format!("element block {number} consists of polyhedra"));
        return Err(error.expected("tetrahedra, pyramids, wedges or hexahedra"));
    };
    let numbers = data.numbers(variable)?;
    let Some(each) = variable.lengths.get(1).and_then(|each| usize::try_from(*each).ok()).filter(|n| *n > 0)
    else {
        return Err(data.fault_in(variable, format!("element block {number} has no nodes for its elements")));
    };
    let kind = kind(data, number, variable, each)?;
    collector.reserve_elements(numbers.len() / each);
    for nodes in numbers.chunks_exact(each) {
        let element = collector.element_count() as u64 + 1;
        collector.element(element, kind, &nodes[..kind.nodes()], set, Spot::default());
    }
    Ok(())
}

/// Finds the kind of the elements of a block. Nodes beyond those of the largest kind that fits lie inside of faces or cells.
fn kind(
    data: &NetCdf<'_>,
    number: usize,
    variable: &Variable<'_>,
    nodes: usize,
) -> Result<ElementKind, MeshFileError> {
    let word = String::from_utf8_lossy(until_zero(variable.element_type)).trim().to_uppercase();
    let found = KINDS.iter().find(|(begin, _)| word.starts_with(begin));
    let fits = |kinds: &&[ElementKind]| kinds.iter().rev().find(|kind| kind.nodes() <= nodes).copied();
    found.and_then(|(_, kinds)| fits(kinds)).ok_or_else(|| {
        let found = format!("element block {number} has {word:?} elements of {}", counted(nodes, "node"));
        let mut error = data.fault_in(variable, found);
        error.fault = MeshFault::Format;
        let error = error
            .expected("TETRA, PYRAMID, WEDGE, HEX, TRI, QUAD, SHELL, BAR or SPHERE with all their corners");
        error.help("export the mesh with linear or quadratic elements")
    })
}

/// Makes groups of the blocks.
fn add_blocks(collected: &mut Collected, blocks: &Parts, taken: &mut HashSet<(u8, String)>) {
    for dimension in [3, 2, 1] {
        let sets = match dimension {
            3 => &collected.volume_sets,
            2 => &collected.cell_sets,
            _ => &collected.edge_sets,
        };
        let mut members = vec![Vec::new(); blocks.0.len()];
        for (place, set) in (0u32..).zip(sets) {
            members[*set as usize - 1].push(place);
        }
        for ((_, name), members) in blocks.0.iter().zip(members).filter(|(_, members)| !members.is_empty()) {
            taken.insert((dimension, name.clone()));
            collected.mesh.push_group(Group { dimension, name: name.clone(), members });
        }
    }
}

/// Makes groups of the side sets: faces of volumes and shells, edges of surfaces.
fn add_side_sets(
    data: &NetCdf<'_>,
    mesh: &mut MeshFile,
    axes: usize,
    taken: &mut HashSet<(u8, String)>,
) -> Result<(), MeshFileError> {
    let [cells, volumes] =
        [mesh.cell_numbers(), mesh.volume_numbers()].map(|numbers| NumberIndex::new(&numbers));
    for (number, name) in Parts::read(data, "ss", "surface")?.0 {
        let of = |word: &str| data.variable(&format!("{word}_ss{number}"));
        let (Some(elements), Some(sides)) = (of("elem"), of("side")) else { continue };
        let [numbers, places] = [data.numbers(elements)?, data.numbers(sides)?];
        if numbers.len() != places.len() {
            let found =
                format!("side set \"{name}\" has {} elements and {} sides", numbers.len(), places.len());
            return Err(data.fault_in(sides, found).expected("a side for each element"));
        }
        let mut members = [Vec::new(), Vec::new()];
        for (element, side) in numbers.iter().zip(places) {
            let found = if let Some(volume) = volumes.find(*element) {
                mesh.push_exodus_face(volume, side).map(|face| (1, face))
            } else {
                // Of shells in space the sides 1 and 2 are their two faces.
                let faces = if axes == 3 { 2 } else { 0 };
                cells.find(*element).and_then(|cell| match side.checked_sub(faces + 1) {
                    None => Some((1, cell)),
                    Some(edge) => Some((0, mesh.push_edge(cell, usize::try_from(edge).ok()?)?)),
                })
            };
            let Some((list, member)) = found else {
                let found = format!("side set \"{name}\" takes the side {side} of element {element}");
                return Err(data
                    .fault_in(sides, found)
                    .expected("an element of the file that has this side"));
            };
            members[list].push(member);
        }
        for (dimension, members) in (1u8..).zip(members).filter(|(_, members)| !members.is_empty()) {
            if taken.insert((dimension, name.clone())) {
                mesh.push_group(Group { dimension, name: name.clone(), members });
            } else {
                mesh.push_note(format!("side set \"{name}\" has the name of a block of shells: left out"));
            }
        }
    }
    Ok(())
}

/// Makes groups of the node sets whose names no side has.
fn add_node_sets(
    data: &NetCdf<'_>,
    mesh: &mut MeshFile,
    taken: &HashSet<(u8, String)>,
) -> Result<(), MeshFileError> {
    let facets = if mesh.has_volumes() { 2 } else { 1 };
    let mut left_out = 0;
    for (number, name) in Parts::read(data, "ns", "nodelist")?.0 {
        if taken.contains(&(facets, name.clone())) {
            left_out += 1;
            continue;
        }
        let Some(variable) = data.variable(&format!("node_ns{number}")) else { continue };
        let numbers = data.numbers(variable)?;
        let most = mesh.node_count();
        if let Some(beyond) = numbers.iter().find(|number| **number > most) {
            let found = format!("node set \"{name}\" holds node {beyond}");
            return Err(data.fault_in(variable, found).expected(format!("numbers up to {most}")));
        }
        let mut members: Vec<u32> = numbers.into_iter().map(|number| number as u32 - 1).collect();
        members.sort_unstable();
        members.dedup();
        mesh.push_group(Group { dimension: 0, name, members });
    }
    if left_out > 0 {
        mesh.push_note(format!("{} with the name of a side set: left out", counted(left_out, "node set")));
    }
    Ok(())
}

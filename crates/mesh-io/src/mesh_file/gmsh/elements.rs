//! Gmsh's numbers for the types of elements.

use super::values::Values;
use crate::mesh_file::{ElementKind, MeshFileError};
use crate::words::counted;

/// Finds the kind of an element type, or refuses it by name.
///
/// * `count`: how many there are at this place; `number`: the first of them, if it is known.
pub(super) fn kind(
    v: &Values<'_>,
    code: i32,
    count: u64,
    number: Option<u64>,
) -> Result<ElementKind, MeshFileError> {
    Ok(match code {
        1 => ElementKind::Edge2,
        2 => ElementKind::Triangle3,
        3 => ElementKind::Quad4,
        4 => ElementKind::Tetra4,
        5 => ElementKind::Hexa8,
        6 => ElementKind::Prism6,
        7 => ElementKind::Pyramid5,
        8 => ElementKind::Edge3,
        9 => ElementKind::Triangle6,
        10 => ElementKind::Quad9,
        11 => ElementKind::Tetra10,
        12 => ElementKind::Hexa27,
        13 => ElementKind::Prism18,
        14 => ElementKind::Pyramid14,
        15 => ElementKind::Point,
        16 => ElementKind::Quad8,
        17 => ElementKind::Hexa20,
        18 => ElementKind::Prism15,
        19 => ElementKind::Pyramid13,
        _ => return Err(refusal(v, code, count, number)),
    })
}

fn refusal(v: &Values<'_>, code: i32, count: u64, number: Option<u64>) -> MeshFileError {
    let first = number.map(|n| format!(" (element {n})")).unwrap_or_default();
    let many = usize::try_from(count).unwrap_or(usize::MAX);
    let expected = "edges, triangles, quadrilaterals, tetrahedra, pyramids, prisms and hexahedra of first or second order";
    match name(code) {
        Some(what) => v
            .unsupported(format!("the file has {}{first}", counted(many, what)))
            .expected(expected)
            .help("mesh again with Mesh.ElementOrder = 1, or convert the file: gmsh old.msh -order 1 -save -o new.msh"),
        None => v.fault(format!("there is no element type {code}{first}")).expected(expected),
    }
}

/// Names a type that is not read.
fn name(code: i32) -> Option<&'static str> {
    Some(match code {
        20..=25 => "higher-order triangle",
        26..=28 => "higher-order edge",
        36..=41 => "higher-order quadrilateral",
        29..=31 | 90..=93 | 106 | 118 | 119 => "higher-order volume element",
        _ => return None,
    })
}

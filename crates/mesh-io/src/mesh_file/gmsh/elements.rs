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
        8 => ElementKind::Edge3,
        9 => ElementKind::Triangle6,
        10 => ElementKind::Quad9,
        11 => ElementKind::Tetra10,
        15 => ElementKind::Point,
        16 => ElementKind::Quad8,
        _ => return Err(refusal(v, code, count, number)),
    })
}

fn refusal(v: &Values<'_>, code: i32, count: u64, number: Option<u64>) -> MeshFileError {
    let first = number.map(|n| format!(" (element {n})")).unwrap_or_default();
    let many = usize::try_from(count).unwrap_or(usize::MAX);
    let expected = "edges, triangles, quadrilaterals and tetrahedra of first or second order";
    match name(code) {
        Some((what, volume)) => {
            let help = if volume {
                "mesh the volume with tetrahedra of first order; for a plane body give the physical groups to surfaces only, or mesh in 2D (gmsh -2)"
            } else {
                "mesh again with Mesh.ElementOrder = 1 in Gmsh (gmsh -2 -order 1 mine.geo)"
            };
            v.unsupported(format!("the file has {}{first}", counted(many, what)))
                .expected(expected)
                .help(help)
        }
        None => v.fault(format!("there is no element type {code}{first}")).expected(expected),
    }
}

/// Names a type that is not read, and says whether it fills a volume.
fn name(code: i32) -> Option<(&'static str, bool)> {
    Some(match code {
        29..=31 => ("higher-order tetrahedron", true),
        5 | 12 | 17 | 92 | 93 => ("hexahedron", true),
        6 | 13 | 18 => ("prism", true),
        7 | 14 | 19 => ("pyramid", true),
        20..=25 => ("higher-order triangle", false),
        26..=28 => ("higher-order edge", false),
        36..=41 => ("higher-order quadrilateral", false),
        _ => return None,
    })
}

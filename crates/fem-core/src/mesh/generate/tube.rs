//! Tubes and cylinders of tetrahedra, and sectors of them.

use super::ring::direction;
use super::{cuboid, too_many};
use crate::mesh::id::NodeId;
use crate::mesh::{Mesh, MeshError, TetMesh};
use nalgebra::Vector3;

/// The sides of the box that is bent: along the radius, around and along the axis.
const SIDES: [(&str, &str); 6] = [
    ("left", "inner"),
    ("right", "outer"),
    ("front", "start"),
    ("back", "end"),
    ("bottom", "bottom"),
    ("top", "top"),
];

/// Meshes the part of a tube around an axis along z between two radii and two angles, with `cells` around, across and along the axis.
///
/// ```math
/// origin + (r cos a, r sin a, z),   radii[0] ≤ r ≤ radii[1],   angles[0] ≤ a ≤ angles[1] degrees,   0 ≤ z ≤ length
/// ```
/// An inner radius of zero makes a cylinder. The sides are named `inner` and `outer` (the radii; a cylinder has no `inner`), `start` and `end` (the angles; 360
/// degrees have none), `bottom` and `top`. Nodes at multiples of 90 degrees lie exactly on the axes through the origin. The outer side of a
/// cylinder or tube and the inner one of another match if radius, length, angles, and cells around and along agree.
///
/// # Errors
/// Radii that are not increasing from zero or more, a length that is not positive, angles that are not increasing or more than 360 degrees
/// apart, cells that turn by more than 60 degrees, too many cells.
pub fn tube(
    origin: impl Into<Vector3<f64>>,
    radii: [f64; 2],
    length: f64,
    angles: [f64; 2],
    [around, across, along]: [usize; 3],
) -> Result<TetMesh, MeshError> {
    let kind = if radii[0] == 0.0 { "cylinder" } else { "tube" };
    let fault = |reason| Err(MeshError::Generator { kind, reason });
    let origin = origin.into();
    if !origin.iter().chain(&radii).chain(&angles).chain([&length]).all(|x| x.is_finite()) {
        return fault("origin, radii, length and angles must be finite numbers");
    }
    if !(radii[0] >= 0.0 && radii[1] > radii[0]) {
        return fault("the radii must be [inner, outer] with 0 <= inner < outer");
    }
    let sweep = angles[1] - angles[0];
    if !(sweep > 0.0 && sweep <= 360.0) {
        return fault("the angles must be [start, end] in degrees, start below end, at most 360 apart");
    }
    if !(length > 0.0) {
        return fault("the length must be positive");
    }
    if [around, across, along].contains(&0) || too_many(&[around, across, along]) {
        return fault("at least one cell is needed in each direction, and at most 2^28 - 1 of them");
    }
    if sweep / around as f64 > 60.0 {
        return fault("a cell would turn by more than 60 degrees: more cells are needed around");
    }
    let straight = cuboid([0.0; 3], [1.0; 3], [across, around, along])?;
    let (solid, closed) = (radii[0] == 0.0, sweep == 360.0);
    let place = |node: usize| {
        [node % (across + 1), node / (across + 1) % (around + 1), node / (across + 1) / (around + 1)]
    };
    // The number of the node with which a node of the box is one.
    let mut number = vec![0u32; straight.points().len()];
    let mut points = Vec::new();
    for node in 0..number.len() {
        let [i, j, k] = place(node);
        let first = if solid && i == 0 || closed && j == around { 0 } else { j };
        let same = i + (across + 1) * (first + (around + 1) * k);
        if same < node {
            number[node] = number[same];
            continue;
        }
        number[node] = points.len() as u32;
        let at = |k: usize, n: usize, [low, high]: [f64; 2]| {
            if k == n { high } else { low + (high - low) * k as f64 / n as f64 }
        };
        let [x, y] = direction(at(j, around, angles)).into();
        let radius = at(i, across, radii);
        points.push(origin + Vector3::new(radius * x, radius * y, at(k, along, [0.0, length])));
    }
    let of = |node: NodeId| number[node.index()];
    // Cells and faces with an edge on the axis of a cylinder have no size.
    let cells = straight.cells().iter().map(|cell| cell.map(of)).filter(|cell| is_simplex(cell)).collect();
    let mut groups = Vec::new();
    for (old, new) in SIDES {
        if closed && ["start", "end"].contains(&new) || solid && new == "inner" {
            continue;
        }
        let faces = straight.group(old).unwrap_or_default().iter();
        let faces = faces.map(|face| straight.topology().facets()[*face].map(of));
        groups.push((new.to_owned(), faces.filter(|face| is_simplex(face)).collect()));
    }
    Mesh::new(points, cells, groups)
}

/// Tells whether all corners are different.
fn is_simplex(corners: &[u32]) -> bool {
    corners.iter().enumerate().all(|(k, node)| !corners[..k].contains(node))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Solid, Space};

    #[test]
    fn tubes_and_cylinders_have_the_volume_of_their_prisms_and_sides_that_match() {
        let origin = [0.3, -1.0, 2.0];
        for (angles, around) in [([0.0, 360.0], 8), ([0.0, 90.0], 2), ([30.0, 200.0], 5)] {
            let pin = tube(origin, [0.0, 1.0], 2.0, angles, [around, 2, 3]).unwrap();
            let bore = tube(origin, [1.0, 1.5], 2.0, angles, [around, 1, 3]).unwrap();
            let step = (angles[1] - angles[0]).to_radians() / around as f64;
            for (mesh, squares) in [(&pin, 1.0), (&bore, 1.5 * 1.5 - 1.0)] {
                let volume: f64 = (0..mesh.cells().len()).map(|t| mesh.measure(t)).sum();
                let exact = 2.0 * squares * 0.5 * step.sin() * around as f64;
                assert!((volume - exact).abs() < 1e-13 && mesh.turned() == 0, "{volume} {exact}");
                // Every face of the boundary has one name.
                let named: usize = mesh.groups().values().map(|faces| faces.len()).sum();
                assert_eq!(named, mesh.topology().boundary_facets().len());
            }
            assert_eq!(pin.group("inner"), None);
            assert_eq!(pin.group("start").is_some(), angles[1] != 360.0);
            let corners = |mesh: &TetMesh, side: &str| {
                let bits = |face: &crate::mesh::id::FacetId| {
                    let mut corners = mesh
                        .facet_corners(*face)
                        .map(|x| [x[0], x[1], x[2]].map(|x| (x * 1e9).round() as i64));
                    corners.sort_unstable();
                    corners
                };
                let mut all: Vec<_> = mesh.group(side).unwrap().iter().map(bits).collect();
                all.sort_unstable();
                all
            };
            assert_eq!(corners(&pin, "outer"), corners(&bore, "inner"));
            // Normals point out of the body.
            let face = pin.group("top").unwrap()[0];
            let out = Solid::facet_normal(
                &pin.topology().oriented_facet(face, pin.cells()).map(|n| pin.points()[n]),
            );
            assert!((out[2] - 1.0).abs() < 1e-14);
        }
        let refused = |radii, length, angles, cells| {
            tube(origin, radii, length, angles, cells).unwrap_err().to_string()
        };
        assert!(refused([1.0, 0.5], 1.0, [0.0, 90.0], [2, 1, 1]).contains("0 <= inner < outer"));
        assert!(refused([0.0, 0.5], 0.0, [0.0, 90.0], [2, 1, 1]).contains("length"));
        assert!(refused([0.0, 0.5], 1.0, [0.0, 361.0], [9, 1, 1]).contains("at most 360"));
        assert!(refused([0.0, 0.5], 1.0, [0.0, 360.0], [5, 1, 1]).contains("60 degrees"));
        assert!(refused([0.0, 0.5], 1.0, [0.0, 360.0], [9, 0, 1]).contains("one cell"));
    }
}

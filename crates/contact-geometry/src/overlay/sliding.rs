//! The nodes of a body that may slide along its surface: then the body and its conditions stay the same.

use super::{Vector, arrangement::Flat};
use fem_core::body::Body;
use fem_core::geometry::{FLAT_SIDE, norm};
use fem_core::mesh::TetMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Solid, Space};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A cell that loses more than this part of its volume over the cube of its longest edge keeps its corners.
const LEAST_SHAPE: f64 = 0.5;

/// The nodes of a surface that slide.
#[derive(Debug)]
pub(super) struct Sliding<'a> {
    body: &'a Body<Solid>,
    /// The normal of the plane in which a node may slide.
    normals: HashMap<NodeId, Vector>,
    /// The nodes that slid, and their places now, m.
    pub(super) moved: BTreeMap<NodeId, Vector>,
}

impl<'a> Sliding<'a> {
    /// Finds the nodes that may slide: all faces around them are on the surface, in one plane and in the same groups, all cells around them have one
    /// material, and no support holds them.
    ///
    /// * `surface`: its faces, ascending; `nodes`: those on it.
    pub(super) fn new(body: &'a Body<Solid>, surface: &[FacetId], nodes: &[NodeId]) -> Self {
        let (mesh, topology) = (body.mesh(), body.mesh().topology());
        let mut around: HashMap<NodeId, Vec<FacetId>> =
            nodes.iter().map(|node| (*node, Vec::new())).collect();
        for facet in topology.boundary_facets() {
            for node in topology.facets()[*facet] {
                around.entry(node).and_modify(|all| all.push(*facet));
            }
        }
        let groups: Vec<HashSet<FacetId>> =
            mesh.groups().values().map(|all| all.iter().copied().collect()).collect();
        let normal = |node: &NodeId| {
            let faces = &around[node];
            let normal = mesh.facet_normal(*faces.first()?);
            let is_flat = |face: &FacetId| norm(mesh.facet_normal(*face) - normal) <= FLAT_SIDE;
            let is_one_side = |group: &HashSet<FacetId>| {
                let count = faces.iter().filter(|face| group.contains(face)).count();
                count == 0 || count == faces.len()
            };
            let constraint = &body.node_constraints()[*node];
            let cells = topology.cells_around(*node);
            let material = |cell: &u32| body.materials().index(*cell as usize);
            let is_free = faces.iter().all(|face| surface.binary_search(face).is_ok() && is_flat(face))
                && groups.iter().all(is_one_side)
                && cells.windows(2).all(|two| material(&two[0]) == material(&two[1]))
                && constraint.held.is_none()
                && constraint.rigid_side.is_none();
            is_free.then_some((*node, normal))
        };
        let normals = nodes.iter().filter_map(normal).collect();
        Self { body, normals, moved: BTreeMap::new() }
    }

    /// Returns the place of a node, m.
    pub(super) fn place(&self, node: NodeId) -> Vector {
        self.moved.get(&node).copied().unwrap_or_else(|| self.body.mesh().points()[node])
    }

    /// Slides a node to where it is seen at a place, unless it or the shape of a cell does not allow it.
    ///
    /// * `axes`: the direction of sight, and the two axes of the place.
    pub(super) fn slide(&mut self, node: NodeId, to: Flat, axes: &[Vector; 3]) -> bool {
        let Some(normal) = self.normals.get(&node) else { return false };
        let from = self.place(node);
        let [along, side, up] = axes;
        let across = (to[0] - side.dot(&from)) * side + (to[1] - up.dot(&from)) * up;
        let place = from + across - across.dot(normal) / along.dot(normal) * along;
        let mesh = self.body.mesh();
        let now = |corner: NodeId| if corner == node { place } else { self.place(corner) };
        let is_sound = |cell: &u32| {
            let corners = mesh.cells()[*cell as usize];
            shape(&corners.map(now)) >= LEAST_SHAPE * shape(&corners.map(|corner| mesh.points()[corner]))
        };
        let sound = mesh.topology().cells_around(node).iter().all(is_sound);
        if sound {
            self.moved.insert(node, place);
        }
        sound
    }

    /// Returns the largest distance by which a node slid, m.
    pub(super) fn farthest(&self) -> f64 {
        let points = self.body.mesh().points();
        self.moved.iter().map(|(node, place)| norm(place - points[*node])).fold(0.0, f64::max)
    }

    /// Counts the nodes that may slide.
    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.normals.len()
    }

    /// Returns the mesh.
    pub(super) fn mesh(&self) -> &TetMesh {
        self.body.mesh()
    }
}

/// Computes the volume of a tetrahedron over the cube of its longest edge.
fn shape(corners: &[Vector; 4]) -> f64 {
    let pairs = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
    let longest = pairs.map(|(i, j)| norm(corners[i] - corners[j])).fold(0.0, f64::max);
    Solid::measure(corners) / longest.powi(3)
}

//! Inserts nodes into the surface of a mesh of tetrahedra. Only cells that touch the surface are cut.
//!
//! The surface is cut first: some of its edges into chains, some of its faces into triangles. A cell then becomes
//! * **cones** from its opposite corner over the triangles of its face, if no other edge of it is cut;
//! * **slices** along its cut edges, one edge after the other, if none of its faces is on the surface: faces of two cells are cut alike, since edges
//!   have one order;
//! * otherwise four parts, one for each face, that meet at its middle, each of them cut as above.

use super::bisect::{BodyTets, TetRefinement, edges};
use crate::mesh::id::{FacetId, NodeId};
use crate::mesh::{Cell, MeshError, TetMesh};
use crate::space::{Solid, Space};
use std::collections::{BTreeMap, BTreeSet, HashMap};

type Vector = <Solid as Space>::Vector;

/// The nodes that are inserted into the surface of a mesh, and how they cut it.
#[derive(Clone, Debug, Default)]
pub struct SurfaceCut {
    /// The places of the new nodes, m; new node `k` has the number `old nodes + k`.
    pub points: Vec<Vector>,
    /// The new places of old nodes that slide along the surface, m.
    pub moved: BTreeMap<NodeId, Vector>,
    /// The new nodes on each cut edge, from its end with the smaller number, which comes first in the key.
    pub edges: BTreeMap<[NodeId; 2], Vec<NodeId>>,
    /// The triangles of each cut face. Cut edges of the face are cut in them.
    pub faces: BTreeMap<FacetId, Vec<[NodeId; 3]>>,
}

/// Cuts the cells at a surface. Old nodes keep their numbers, and their places but for those that slide.
///
/// # Errors
/// More nodes or cells than a mesh can have, cells with a volume of round-off or less.
pub fn with_cut_surface(old: &TetMesh, cut: &SurfaceCut) -> Result<TetRefinement, MeshError> {
    let mut points = old.points().to_vec();
    cut.moved.iter().for_each(|(node, place)| points[*node] = *place);
    points.extend_from_slice(&cut.points);
    let (count, room) = (old.cells().len(), 4 * cut.points.len());
    let mut cutter = Cutter { old, cut, points, tets: BodyTets::default() };
    cutter.tets.reserve(count + room);
    let touched = touched(old, cut);
    for cell in 0..count {
        match touched.contains(&(cell as u32)) {
            true => cutter.cut(cell),
            false => cutter.tets.push(old.cells()[cell], old.topology().cell_facets()[cell], cell as u32),
        }
    }
    TetRefinement::new(old, cutter.tets, cutter.points)
}

/// Lists the cells with a cut edge or face.
fn touched(mesh: &TetMesh, cut: &SurfaceCut) -> BTreeSet<u32> {
    let topology = mesh.topology();
    let of_faces = cut.faces.keys().flat_map(|face| topology.facet_cells()[*face]);
    let of_edge = |[a, b]: &[NodeId; 2]| {
        let b = *b;
        topology
            .cells_around(*a)
            .iter()
            .copied()
            .filter(move |cell| mesh.cells()[*cell as usize].contains(&b))
    };
    let count = mesh.cells().len();
    of_faces.filter(|cell| (*cell as usize) < count).chain(cut.edges.keys().flat_map(of_edge)).collect()
}

/// Corners of a cell, one bit each.
type Corners = u8;

/// Cuts cells one by one.
struct Cutter<'a> {
    old: &'a TetMesh,
    cut: &'a SurfaceCut,
    points: Vec<Vector>,
    tets: BodyTets,
}

/// A cut edge of a cell: its ends, and the nodes between them.
type CutEdge<'a> = ([NodeId; 2], &'a [NodeId]);

impl Cutter<'_> {
    /// Adds the parts of a cell.
    fn cut(&mut self, cell: usize) {
        let (corners, facets) = (self.old.cells()[cell], self.old.topology().cell_facets()[cell]);
        let cut = self.cut;
        let keys = edges(&corners).map(|[a, b]| [a.min(b), a.max(b)]);
        let cut_edge = |key: [NodeId; 2]| Some((key, cut.edges.get(&key)?.as_slice()));
        let mut edges: Vec<CutEdge<'_>> = keys.into_iter().filter_map(cut_edge).collect();
        edges.sort_unstable_by_key(|(ends, _)| *ends);
        // The corners that each node lies between.
        let bit = |node: NodeId| corners.iter().position(|corner| *corner == node).map_or(0, |k| 1u8 << k);
        let mut between: HashMap<NodeId, Corners> = corners.iter().map(|node| (*node, bit(*node))).collect();
        for (ends, nodes) in &edges {
            between.extend(nodes.iter().map(|node| (*node, bit(ends[0]) | bit(ends[1]))));
        }
        let face_corners = |k: usize| Solid::facet(k).map(|corner| corners[corner]);
        let whole = |k: usize| Solid::facet(k).iter().fold(0, |bits, corner| bits | 1u8 << corner);
        let cut_faces: Vec<(usize, &[[NodeId; 3]])> =
            (0..4).filter_map(|k| Some((k, cut.faces.get(&facets[k])?.as_slice()))).collect();
        for (k, triangles) in &cut_faces {
            for node in triangles.iter().flatten() {
                between.entry(*node).or_insert(whole(*k));
            }
        }
        let is_in = |face: &[NodeId; 3], ends: &[NodeId; 2]| ends.iter().all(|end| face.contains(end));
        let cone = |apex: NodeId, triangles: &[[NodeId; 3]]| -> Vec<Cell<Solid>> {
            triangles.iter().map(|[a, b, c]| [*a, *b, *c, apex]).collect()
        };
        let parts = match cut_faces[..] {
            [] => sliced(corners, &edges),
            [(k, triangles)] if edges.iter().all(|(ends, _)| is_in(&face_corners(k), ends)) => {
                let apex = (0..4).find(|corner| !Solid::facet(k).contains(corner)).unwrap_or(0);
                cone(corners[apex], triangles)
            }
            _ => {
                let middle = NodeId::new(self.points.len());
                self.points.push(corners.iter().map(|node| self.points[*node]).sum::<Vector>() / 4.0);
                between.insert(middle, 0b1111);
                let part = |k: usize| match cut_faces.iter().find(|(cut, _)| *cut == k) {
                    Some((_, triangles)) => cone(middle, triangles),
                    None => {
                        let [a, b, c] = face_corners(k);
                        let own: Vec<CutEdge<'_>> =
                            edges.iter().filter(|(ends, _)| is_in(&[a, b, c], ends)).copied().collect();
                        sliced([a, b, c, middle], &own)
                    }
                };
                (0..4).flat_map(part).collect()
            }
        };
        for mut part in parts {
            if Solid::measure(&part.map(|node| self.points[node])) < 0.0 {
                part.swap(1, 2);
            }
            // A face of a part lies on the face of the cell that has the corners around its nodes.
            let faces = std::array::from_fn(|k| {
                let bits = Solid::facet(k).iter().fold(0, |bits, corner| bits | between[&part[*corner]]);
                (0..4).find(|face| whole(*face) == bits).map_or(FacetId::NONE, |face| facets[face])
            });
            self.tets.push(part, faces, cell as u32);
        }
    }
}

/// Cuts a cell at the nodes of its edges, one edge after the other.
fn sliced(cell: Cell<Solid>, edges: &[CutEdge<'_>]) -> Vec<Cell<Solid>> {
    let mut parts = vec![cell];
    for ([first, last], nodes) in edges {
        let slice = |part: Cell<Solid>| {
            let place = |node: &NodeId| part.iter().position(|corner| corner == node);
            let (Some(i), Some(j)) = (place(first), place(last)) else { return vec![part] };
            let chain: Vec<NodeId> =
                std::iter::once(*first).chain(nodes.iter().copied()).chain(std::iter::once(*last)).collect();
            let of = |ends: &[NodeId]| {
                let mut slice = part;
                (slice[i], slice[j]) = (ends[0], ends[1]);
                slice
            };
            chain.windows(2).map(of).collect()
        };
        parts = parts.into_iter().flat_map(slice).collect();
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::cuboid;

    /// Cuts the face of a box at the middle of each of its edges and faces, as a star would.
    fn all_cut(mesh: &TetMesh, groups: &[&str]) -> SurfaceCut {
        let mut cut = SurfaceCut::default();
        let mut next = mesh.points().len();
        let mut new = |points: &mut Vec<Vector>, at: Vector| {
            points.push(at);
            next += 1;
            NodeId::new(next - 1)
        };
        for face in groups.iter().flat_map(|group| mesh.group(group).unwrap()) {
            let nodes = mesh.topology().facets()[*face];
            let middle = new(&mut cut.points, mesh.facet_middle(*face));
            let mut around = Vec::new();
            for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(a, b): (usize, usize)| (nodes[a], nodes[b])) {
                let key = [a.min(b), a.max(b)];
                let [p, q] = key.map(|node| mesh.points()[node]);
                if !cut.edges.contains_key(&key) {
                    let two = [0.3, 0.8].map(|t| new(&mut cut.points, p + t * (q - p))).to_vec();
                    cut.edges.insert(key, two);
                }
                let own = cut.edges[&key].clone();
                around.push(a);
                around.extend(if a == key[0] { own } else { own.into_iter().rev().collect() });
            }
            let triangles = (0..around.len()).map(|k| [around[k], around[(k + 1) % around.len()], middle]);
            cut.faces.insert(*face, triangles.collect());
        }
        cut
    }

    #[test]
    fn cells_at_a_cut_surface_are_cut_alike_from_both_sides() {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 1.5], [2, 3, 2]).unwrap();
        for groups in [&["bottom"][..], &["bottom", "top"], &["bottom", "left"], &["bottom", "left", "front"]]
        {
            let cut = all_cut(&mesh, groups);
            let finer = with_cut_surface(&mesh, &cut).unwrap();
            // Conforming: what the faces of one cell alone enclose is the box.
            let area: f64 =
                finer.mesh.topology().boundary_facets().iter().map(|f| finer.mesh.facet_measure(*f)).sum();
            assert!((area - 13.0).abs() < 1e-12, "{groups:?}: {area}");
            let volume: f64 = (0..finer.mesh.cells().len()).map(|cell| finer.mesh.measure(cell)).sum();
            assert!((volume - 3.0).abs() < 1e-12, "{groups:?}: {volume}");
            for (name, faces) in mesh.groups() {
                let area = |mesh: &TetMesh, faces: &[FacetId]| -> f64 {
                    faces.iter().map(|f| mesh.facet_measure(*f)).sum()
                };
                let now = finer.mesh.group(name).unwrap();
                assert!((area(&finer.mesh, now) - area(&mesh, faces)).abs() < 1e-12, "{name}");
                assert!(now.len() > faces.len() || !groups.contains(&name.as_str()), "{name} is cut");
            }
            for (cell, parent) in finer.parent_cell.iter().enumerate() {
                let inside = mesh.corners(*parent as usize);
                let middle: Vector = finer.mesh.corners(cell).iter().sum::<Vector>() / 4.0;
                let outside = (0..4).any(|k| {
                    let mut with = inside;
                    with[k] = middle;
                    Solid::measure(&with) <= 0.0
                });
                assert!(!outside, "cell {cell} is in its parent");
            }
        }
    }
}

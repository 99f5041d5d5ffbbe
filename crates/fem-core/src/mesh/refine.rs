//! Newest-vertex bisection: from a conforming mesh and a set of marked edges to a finer conforming mesh.
//!
//! Every triangle has one *refinement edge*. A triangle is cut from the middle of that edge to the opposite corner;
//! the middle is the newest vertex of both halves, and their refinement edges are the ones opposite to it. Edges are
//! marked, never triangles: if any edge of a triangle is marked, its refinement edge must be marked too. Adding these
//! until no edge changes ([`close`]) makes the finer mesh conforming. A triangle with one, two or three marked edges is
//! cut into two, three or four.
//!
//! * **Start.** The refinement edge of a triangle of the first mesh is its longest one; equal lengths are
//!   distinguished by node numbers ([`RefinementEdges::longest`]).
//! * **Shapes.** The descendants of one triangle fall into four classes of similar triangles, and no angle is smaller
//!   than half the smallest angle of the first mesh.
//! * **Size.** Closure adds in total at most a constant times the number of marked cells, over any number of
//!   refinements.
//!
//! Sources: Mitchell 1989; Binev, Dahmen and DeVore 2004 and Karkulik, Pavlicek and Praetorius 2013 (closure); Rosenberg
//! and Stenger 1975 (angles).

use super::topology::NONE;
use super::{MeshError, TriMesh};
use crate::geometry::{Vector, signed_area};
use crate::mesh::id::{FacetId, NodeId};
use std::collections::{BTreeMap, BTreeSet};

/// The refinement edge of every triangle, by its place 0, 1 or 2 in the triangle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefinementEdges(Vec<u8>);

impl RefinementEdges {
    /// Chooses the longest edge of every triangle of a first mesh; among edges of equal length the one with the
    /// smallest nodes.
    ///
    /// Lengths that differ by less than 1e-9 of themselves count as equal, so that round-off does not decide.
    pub fn longest(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let longest = |edges: &[FacetId; 3]| {
            let length = edges.map(|e| mesh.facet_measure(e));
            let limit = length.into_iter().fold(0.0, f64::max) * (1.0 - 1e-9);
            let candidates = (0..3).filter(|&k| length[k] >= limit);
            candidates.min_by_key(|&k| topology.facets()[edges[k]]).unwrap_or(0) as u8
        };
        Self(topology.cell_facets().iter().map(longest).collect())
    }

    /// Chooses a preferred edge of every triangle that has one, otherwise the one of [`RefinementEdges::longest`]. If
    /// only preferred edges are marked, closure adds no edges.
    ///
    /// * `preferred`: one entry per edge.
    pub fn preferring(mesh: &TriMesh, preferred: &[bool]) -> Self {
        let mut edges = Self::longest(mesh);
        for (choice, own) in edges.0.iter_mut().zip(mesh.topology().cell_facets()) {
            if let Some(k) = own.iter().position(|&e| preferred[e]) {
                *choice = k as u8;
            }
        }
        edges
    }

    /// Returns the number of the refinement edge of a triangle.
    pub fn of(&self, mesh: &TriMesh, triangle: usize) -> FacetId {
        mesh.topology().cell_facets()[triangle][usize::from(self.0[triangle])]
    }

    /// Returns the number of triangles.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Tells whether there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// A refined mesh and the origin of its nodes and triangles.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// The finer mesh. Old nodes keep their numbers, the halves inherit edge groups.
    pub mesh: TriMesh,
    /// The refinement edges of its triangles.
    pub refinement_edges: RefinementEdges,
    /// The triangle of the old mesh that each new one lies in.
    pub parent_cell: Vec<u32>,
    /// The two ends of the edge that each new node halves; new node `k` has the number `old nodes + k`.
    pub parent_nodes: Vec<[NodeId; 2]>,
    /// The new node on each old edge, [`NodeId::NONE`] if the edge is not cut.
    pub middle: Vec<NodeId>,
    /// New nodes that `refine_onto` left on the chord.
    pub on_chord: Vec<NodeId>,
}

impl Refinement {
    /// Transfers a P1 field: exactly, unless nodes were moved onto curves.
    ///
    /// # Panics
    /// If the field does not have one entry per old node.
    pub fn prolong(&self, field: &[Vector]) -> Vec<Vector> {
        let (found, expected) = (field.len(), self.mesh.points().len() - self.parent_nodes.len());
        assert!(found == expected, "the field has {found} entries, the old mesh {expected} nodes");
        let middle = |ends: &[NodeId; 2]| {
            let [a, b] = ends.map(|n| field[n]);
            0.5 * (a + b)
        };
        field.iter().copied().chain(self.parent_nodes.iter().map(middle)).collect()
    }

    /// Returns the parts of an old edge in the new mesh: itself or its two halves.
    pub fn parts(&self, old: &TriMesh, edge: FacetId) -> Vec<FacetId> {
        let [a, b] = old.topology().facets()[edge];
        let find = |a, b| self.mesh.topology().find_edge(a, b);
        match self.middle[edge] {
            NodeId::NONE => find(a, b).into_iter().collect(),
            m => find(a, m).into_iter().chain(find(m, b)).collect(),
        }
    }
}

/// Marks further edges until the refinement is conforming: if any edge of a triangle is marked, its refinement edge
/// is marked too. Returns whether any was added.
///
/// * `marked`: one entry per edge.
///
/// # Panics
/// If `marked` does not have one entry per edge, or the refinement edges belong to another mesh.
pub fn close(mesh: &TriMesh, refinement_edges: &RefinementEdges, marked: &mut [bool]) -> bool {
    let topology = mesh.topology();
    let (found, expected) = (marked.len(), topology.facets().len());
    assert!(found == expected, "`marked` has {found} entries, the mesh {expected} edges");
    let (found, expected) = (refinement_edges.len(), mesh.cells().len());
    assert!(found == expected, "there are {found} refinement edges for {expected} triangles");
    let given: Vec<FacetId> = (0..marked.len()).map(FacetId::new).filter(|&e| marked[e]).collect();
    let needed = given.into_iter().flat_map(|edge| needed_with(mesh, refinement_edges, edge));
    mark(mesh, refinement_edges, marked, needed.collect()) > 0
}

/// Marks edges, and further ones until the refinement is conforming if it was before. Returns how many were not marked yet.
pub fn mark(
    mesh: &TriMesh,
    refinement_edges: &RefinementEdges,
    marked: &mut [bool],
    mut edges: Vec<FacetId>,
) -> usize {
    let mut added = 0;
    while let Some(edge) = edges.pop() {
        if !marked[edge] {
            marked[edge] = true;
            added += 1;
            edges.extend(needed_with(mesh, refinement_edges, edge));
        }
    }
    added
}

/// Lists the refinement edges of the triangles of an edge.
fn needed_with<'a>(
    mesh: &'a TriMesh,
    refinement_edges: &'a RefinementEdges,
    edge: FacetId,
) -> impl Iterator<Item = FacetId> + use<'a> {
    let triangles = mesh.topology().facet_cells()[edge].into_iter().filter(|&t| t != NONE);
    triangles.map(|t| refinement_edges.of(mesh, t as usize))
}

/// Halves the marked edges and cuts the triangles accordingly, after [`close`].
///
/// * `marked`: one entry per edge; it is closed here if necessary.
///
/// # Errors
/// More nodes or triangles than a mesh can have, triangles with an area of round-off.
///
/// # Panics
/// See [`close`].
pub fn refine(
    mesh: &TriMesh,
    refinement_edges: &RefinementEdges,
    marked: &[bool],
) -> Result<Refinement, MeshError> {
    refine_onto(mesh, refinement_edges, marked, |_| None, |_| None)
}

/// Cuts like [`refine`], but at the point that `place` gives for an edge, if any, and then moves the new nodes to the points that
/// `curve` gives for their edges. With points of `place` [`Refinement::prolong`] is not valid. A node stays where it is if a triangle
/// would keep less than 30 % of its area: [`Refinement::on_chord`] lists it.
///
/// # Errors
/// See [`refine`]; a point that turns a triangle over.
///
/// # Panics
/// See [`close`].
pub fn refine_onto(
    mesh: &TriMesh,
    refinement_edges: &RefinementEdges,
    marked: &[bool],
    place: impl Fn(FacetId) -> Option<Vector>,
    curve: impl Fn(FacetId) -> Option<Vector>,
) -> Result<Refinement, MeshError> {
    let mut marked = marked.to_vec();
    close(mesh, refinement_edges, &mut marked);
    let topology = mesh.topology();
    let mut points = mesh.points().to_vec();
    let mut middle = vec![NodeId::NONE; marked.len()];
    let mut parent_nodes = Vec::new();
    let mut moves = BTreeMap::new();
    for (edge, _) in marked.iter().enumerate().filter(|(_, m)| **m) {
        let ends = topology.facets()[edge];
        let [a, b] = ends.map(|n| points[n]);
        let new = NodeId::new(points.len());
        middle[edge] = new;
        points.push(place(FacetId::new(edge)).unwrap_or_else(|| 0.5 * (a + b)));
        moves.extend(curve(FacetId::new(edge)).map(|to| (new, to)));
        parent_nodes.push(ends);
    }
    let mut children = Children::default();
    for (triangle, corners) in mesh.cells().iter().enumerate() {
        children.parent = triangle as u32;
        let edges = topology.cell_facets()[triangle].map(|e| middle[e]);
        children.cut(*corners, edges, usize::from(refinement_edges.0[triangle]));
    }
    let on_chord = stay(&points, &children.triangles, &mut moves);
    for (node, to) in moves {
        points[node] = to;
    }
    let groups = mesh.groups().iter().map(|(name, edges)| {
        let halves = edges.iter().flat_map(|&e| {
            let [a, b] = topology.facets()[e];
            match middle[e] {
                NodeId::NONE => vec![[a, b]],
                m => vec![[a, m], [m, b]],
            }
        });
        (name.clone(), halves.collect())
    });
    let finer = TriMesh::oriented(points, children.triangles, groups.collect())?;
    Ok(Refinement {
        mesh: finer,
        refinement_edges: RefinementEdges(children.refinement_edges),
        parent_cell: children.parents,
        parent_nodes,
        middle,
        on_chord,
    })
}

/// A triangle keeps at least this part of its area if nodes move.
const LEAST_AREA: f64 = 0.3;

/// Takes out the moves with which a triangle would turn over or keep less than 30 % of its area, and returns their nodes.
fn stay(points: &[Vector], triangles: &[[NodeId; 3]], moves: &mut BTreeMap<NodeId, Vector>) -> Vec<NodeId> {
    let mut on_chord = Vec::new();
    let mut waiting: Vec<[NodeId; 3]> =
        triangles.iter().filter(|t| t.iter().any(|n| moves.contains_key(n))).copied().collect();
    loop {
        let area = |corners: &[NodeId; 3], moves: &BTreeMap<NodeId, Vector>| {
            signed_area(corners.map(|n| moves.get(&n).copied().unwrap_or(points[n])))
        };
        let none = BTreeMap::new();
        let bad = |t: &&[NodeId; 3]| !(area(t, moves) >= LEAST_AREA * area(t, &none));
        let nodes: BTreeSet<NodeId> =
            waiting.iter().filter(bad).flatten().filter(|n| moves.contains_key(n)).copied().collect();
        if nodes.is_empty() {
            return on_chord;
        }
        for node in nodes {
            moves.remove(&node);
            on_chord.push(node);
        }
        // The others may have gained by the moves of these.
        waiting.retain(|t| t.iter().any(|n| moves.contains_key(n)));
    }
}

/// The triangles of the finer mesh in the order of their creation.
#[derive(Default)]
struct Children {
    parent: u32,
    triangles: Vec<[NodeId; 3]>,
    refinement_edges: Vec<u8>,
    parents: Vec<u32>,
}

impl Children {
    /// Cuts a triangle at the middle of its refinement edge `k`, if that is marked, and its halves likewise.
    ///
    /// * `middle`: the node on each of its edges, or [`NONE`].
    fn cut(&mut self, corners: [NodeId; 3], middle: [NodeId; 3], k: usize) {
        let m = middle[k];
        if m == NodeId::NONE {
            self.triangles.push(corners);
            self.refinement_edges.push(k as u8);
            self.parents.push(self.parent);
            return;
        }
        let [a, b, c] = [0, 1, 2].map(|j| corners[(k + j) % 3]);
        let [to_c, to_a] = [1, 2].map(|j| middle[(k + j) % 3]);
        // The edge opposite to the newest vertex m is the next to be cut: c-a in the first half, b-c in the second.
        self.cut([c, a, m], [to_a, NodeId::NONE, NodeId::NONE], 0);
        self.cut([b, c, m], [to_c, NodeId::NONE, NodeId::NONE], 0);
    }
}

#[cfg(test)]
mod tests;

//! Triangle meshes: immutable, checked on creation, with named sets of edges.

pub mod cell_tree;
pub mod generate;
pub mod id;
mod overlap;
pub mod refine;
pub mod topology;

use crate::geometry::{self, Vector, shown};
use crate::mesh::id::{FacetId, NodeId};
use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap, HashSet};
use thiserror::Error;
use topology::Topology;

pub use overlap::CellOverlap;

/// Why a set of points and triangles is not a valid mesh.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// The mesh is empty.
    #[error("the mesh has {points} nodes and {triangles} triangles; at least one triangle is needed")]
    Empty {
        /// Number of nodes.
        points: usize,
        /// Number of triangles.
        triangles: usize,
    },
    /// More nodes or triangles than 32-bit numbers can address.
    #[error("the mesh has {found} {what}; at most {limit} are supported")]
    TooLarge {
        /// The counted items.
        what: &'static str,
        /// The number found.
        found: usize,
        /// The largest supported number.
        limit: usize,
    },
    /// A coordinate is infinite or NaN.
    #[error("node {node} has the coordinates ({}, {}); finite numbers are needed", shown(*x), shown(*y))]
    NotFinite {
        /// Node number, from 0.
        node: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// A coordinate or an edge is so large or small that areas and moments would overflow or underflow.
    #[error(
        "node {node} has the coordinates ({}, {}){}; coordinates of at most {LARGEST_COORDINATE:e} and edges of at least \
         {SHORTEST_EDGE:e} are needed",
        shown(*x), shown(*y), if *edge > 0.0 { format!(" and an edge of length {}", shown(*edge)) } else { String::new() }
    )]
    Scale {
        /// Node number, from 0.
        node: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// Largest component of an edge of the node that is too short, m; 0 if a coordinate is too large.
        edge: f64,
    },
    /// A triangle names a node that does not exist.
    #[error("triangle {triangle} uses node {node}, but the mesh has {nodes} nodes")]
    NoSuchNode {
        /// Triangle number, from 0.
        triangle: usize,
        /// The node it names.
        node: usize,
        /// Number of nodes of the mesh.
        nodes: usize,
    },
    /// A triangle has no area, or a cut or a motion of nodes turned it over.
    #[error(
        "triangle {triangle} at ({}, {}) has the signed area {area:e}; a positive one is needed \
         (corners not on one line, and counter-clockwise)",
        shown(*x), shown(*y)
    )]
    Area {
        /// Triangle number, from 0.
        triangle: usize,
        /// Signed area found.
        area: f64,
        /// Centroid, first coordinate.
        x: f64,
        /// Centroid, second coordinate.
        y: f64,
    },
    /// A node belongs to no triangle: it would make the stiffness singular.
    #[error("node {node} at ({}, {}) belongs to no triangle; remove it", shown(*x), shown(*y))]
    LooseNode {
        /// Node number, from 0.
        node: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// More than two triangles meet in an edge, or two of them lie on the same side of it.
    #[error(
        "the edge between nodes {a} and {b} belongs to more than two triangles, or to two on the same side"
    )]
    NonManifoldEdge {
        /// First node.
        a: usize,
        /// Second node.
        b: usize,
    },
    /// Two parts of the body touch only in a single node.
    #[error(
        "at node {node} ({}, {}) two parts of the body touch only in that node; separate them or join them by an edge",
        shown(*x), shown(*y)
    )]
    BowTie {
        /// Node number, from 0.
        node: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// A group names an edge that no triangle has.
    #[error("group \"{group}\" contains the edge between nodes {a} and {b}, which no triangle has")]
    NoSuchEdge {
        /// Group name.
        group: String,
        /// First node.
        a: usize,
        /// Second node.
        b: usize,
    },
    /// Two groups of edges have the same name.
    #[error("two groups of edges are called \"{group}\"")]
    DuplicateGroup {
        /// Group name.
        group: String,
    },
    /// A block generator was given invalid sizes.
    #[error("a block of {cells:?} cells and size {size:?} at {origin:?} cannot be meshed: {reason}")]
    Block {
        /// Lower left corner.
        origin: [f64; 2],
        /// Width and height.
        size: [f64; 2],
        /// Number of cells in each direction.
        cells: [usize; 2],
        /// The requirement that is violated.
        reason: &'static str,
    },
    /// Another generator was given invalid input.
    #[error("the {kind} cannot be meshed: {reason}")]
    Generator {
        /// "ring" and so on.
        kind: &'static str,
        /// The requirement that is violated.
        reason: &'static str,
    },
}

/// A conforming triangle mesh of the plane with named sets of edges.
///
/// Corners of every triangle run counter-clockwise. Edge `k` of a triangle joins its corners `k` and
/// `(k+1) mod 3`.
#[derive(Clone, Debug)]
pub struct TriMesh {
    points: Vec<Vector>,
    triangles: Vec<[NodeId; 3]>,
    topology: Topology,
    groups: BTreeMap<String, Vec<FacetId>>,
    turned: usize,
    /// See [`TriMesh::bounding_box`].
    bounds: [Vector; 2],
}

impl TriMesh {
    /// Checks points, triangles and named edges and creates a mesh from them. Clockwise triangles are reversed: their
    /// second and third corners are swapped, and [`TriMesh::turned`] returns their number.
    ///
    /// Cells that overlap without sharing nodes are not detected here, see [`TriMesh::overlapping_cells`].
    ///
    /// * `groups`: name and edges, each edge by its two nodes in either order; edges may lie in several groups.
    ///
    /// # Errors
    /// Anything that would make a computation on this mesh meaningless, see [`MeshError`].
    pub fn new<N: Into<NodeId>>(
        points: Vec<impl Into<Vector>>,
        triangles: Vec<[N; 3]>,
        groups: Vec<(String, Vec<[N; 2]>)>,
    ) -> Result<Self, MeshError> {
        let points: Vec<Vector> = points.into_iter().map(Into::into).collect();
        let mut triangles: Vec<[NodeId; 3]> =
            triangles.into_iter().map(|corners| corners.map(Into::into)).collect();
        let numbered = |edges: Vec<[N; 2]>| edges.into_iter().map(|ends| ends.map(Into::into)).collect();
        let groups = groups.into_iter().map(|(name, edges)| (name, numbered(edges))).collect();
        let mut turned = 0;
        let clockwise = |corners: &[NodeId; 3]| {
            let places = corners.map(|n| points.get(n.index()).copied());
            matches!(places, [Some(a), Some(b), Some(c)] if geometry::signed_area([a, b, c]) < 0.0)
        };
        for corners in &mut triangles {
            if clockwise(corners) {
                corners.swap(1, 2);
                turned += 1;
            }
        }
        Ok(Self { turned, ..Self::counter_clockwise(points, triangles, groups)? })
    }

    /// Creates a mesh like [`TriMesh::new`] from counter-clockwise triangles: a clockwise one was turned over by a
    /// motion of its nodes.
    ///
    /// # Errors
    /// See [`TriMesh::new`]; a clockwise triangle.
    pub(crate) fn counter_clockwise(
        points: Vec<Vector>,
        triangles: Vec<[NodeId; 3]>,
        groups: Vec<(String, Vec<[NodeId; 2]>)>,
    ) -> Result<Self, MeshError> {
        check_sizes(&points, &triangles)?;
        check_triangles(&points, &triangles)?;
        let topology = Topology::build(points.len(), &triangles)?;
        check_nodes(&points, &topology)?;
        let mut named = BTreeMap::new();
        for (name, edges) in groups {
            let mut ids = Vec::with_capacity(edges.len());
            for [a, b] in edges {
                let id = topology.find_edge(a, b).ok_or_else(|| MeshError::NoSuchEdge {
                    group: name.clone(),
                    a: a.index(),
                    b: b.index(),
                })?;
                ids.push(id);
            }
            ids.sort_unstable();
            ids.dedup();
            if named.insert(name.clone(), ids).is_some() {
                return Err(MeshError::DuplicateGroup { group: name });
            }
        }
        let bounds = geometry::bounding_box(&points);
        Ok(Self { points, triangles, topology, groups: named, turned: 0, bounds })
    }

    /// Returns the coordinates of the nodes.
    #[inline]
    pub fn points(&self) -> &[Vector] {
        &self.points
    }

    /// Returns the lower left and the upper right corner of the box around all nodes, m.
    pub fn bounding_box(&self) -> [Vector; 2] {
        self.bounds
    }

    /// Returns the diagonal of [`TriMesh::bounding_box`], m.
    pub fn diagonal(&self) -> f64 {
        geometry::norm(self.bounds[1] - self.bounds[0])
    }

    /// Returns the corners of the triangles, counter-clockwise.
    #[inline]
    pub fn cells(&self) -> &[[NodeId; 3]] {
        &self.triangles
    }

    /// Returns the number of clockwise triangles that [`TriMesh::new`] reversed.
    pub fn turned(&self) -> usize {
        self.turned
    }

    /// Returns edges and neighbourhoods.
    #[inline]
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Returns the named sets of edges: edge numbers, ascending.
    pub fn groups(&self) -> &BTreeMap<String, Vec<FacetId>> {
        &self.groups
    }

    /// Returns the edges of one group, if there is a group of that name.
    pub fn group(&self, name: &str) -> Option<&[FacetId]> {
        self.groups.get(name).map(Vec::as_slice)
    }

    /// Returns the three corner points of a triangle.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.triangles[triangle].map(|n| self.points[n])
    }

    /// Computes the area of a triangle, m².
    #[inline]
    pub fn area(&self, triangle: usize) -> f64 {
        geometry::signed_area(self.corners(triangle))
    }

    /// Computes the length of an edge, m.
    #[inline]
    pub fn facet_measure(&self, edge: FacetId) -> f64 {
        let [a, b] = self.facet_corners(edge);
        geometry::norm(b - a)
    }

    /// Returns the positions of an edge's two nodes, the one with the smaller number first, m.
    pub fn facet_corners(&self, edge: FacetId) -> [Vector; 2] {
        self.topology.facets()[edge].map(|n| self.points[n])
    }

    /// Adds a group of edges, sorted by their numbers.
    pub fn add_group(&mut self, name: &str, mut edges: Vec<FacetId>) {
        edges.sort_unstable();
        self.groups.insert(name.to_owned(), edges);
    }

    /// Computes the middle of an edge, m.
    pub fn facet_middle(&self, edge: FacetId) -> Vector {
        let [a, b] = self.facet_corners(edge);
        0.5 * (a + b)
    }

    /// Computes the unit normal of an edge that points out of the edge's first triangle: the outward
    /// normal of the body on a boundary edge.
    pub fn facet_normal(&self, edge: FacetId) -> Vector {
        let [a, b] = self.topology.oriented_facet(edge, &self.triangles);
        geometry::right_normal(self.points[a], self.points[b])
    }

    /// Collects the connected parts of a side, each from end to end with the body on its left; a closed one ends with its first node.
    ///
    /// * `edges`: on the boundary; `order`: of nodes, decides which part comes first and where a closed one begins.
    pub(crate) fn walks(
        &self,
        edges: &[FacetId],
        order: impl Fn(NodeId, NodeId) -> Ordering,
    ) -> Vec<Vec<NodeId>> {
        let oriented = || edges.iter().map(|edge| self.topology.oriented_facet(*edge, &self.triangles));
        let mut next: HashMap<NodeId, NodeId> = oriented().map(|[a, b]| (a, b)).collect();
        let entered: HashSet<NodeId> = oriented().map(|[_, b]| b).collect();
        let mut starts: Vec<NodeId> = next.keys().copied().collect();
        starts.sort_unstable_by(|&a, &b| order(a, b));
        // Open parts begin at an end; what remains is closed.
        starts.sort_by_key(|node| entered.contains(node));
        let mut found = Vec::new();
        for start in starts {
            let mut nodes = vec![start];
            let mut node = start;
            while let Some(to) = next.remove(&node) {
                nodes.push(to);
                node = to;
            }
            if nodes.len() > 1 {
                found.push(nodes);
            }
        }
        found
    }

    /// Computes the smallest angle of all triangles, in degrees.
    pub fn smallest_angle(&self) -> f64 {
        let angle = |t: usize| geometry::smallest_angle(self.corners(t));
        (0..self.triangles.len()).map(angle).fold(180.0, f64::min)
    }
}

/// Largest coordinate, m: its cube, the size of a moment of an area, is finite.
const LARGEST_COORDINATE: f64 = 1e100;

/// Shortest edge, m: the inverse of its square, the size of a stiffness over a modulus, and its cube are finite and not zero.
const SHORTEST_EDGE: f64 = 1e-100;

fn check_sizes(points: &[Vector], triangles: &[[NodeId; 3]]) -> Result<(), MeshError> {
    if points.is_empty() || triangles.is_empty() {
        return Err(MeshError::Empty { points: points.len(), triangles: triangles.len() });
    }
    // Two unknowns per node and three edges per triangle must stay below 2³².
    let limit = (u32::MAX / 8) as usize;
    for (what, found) in [("nodes", points.len()), ("triangles", triangles.len())] {
        if found > limit {
            return Err(MeshError::TooLarge { what, found, limit });
        }
    }
    if let Some(node) = points.iter().position(|p| !(p[0].is_finite() && p[1].is_finite())) {
        return Err(MeshError::NotFinite { node, x: points[node][0], y: points[node][1] });
    }
    match points.iter().position(|p| p.amax() > LARGEST_COORDINATE) {
        Some(node) => Err(MeshError::Scale { node, x: points[node][0], y: points[node][1], edge: 0.0 }),
        None => Ok(()),
    }
}

fn check_triangles(points: &[Vector], triangles: &[[NodeId; 3]]) -> Result<(), MeshError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&node) = corners.iter().find(|&&n| n.index() >= points.len()) {
            return Err(MeshError::NoSuchNode { triangle, node: node.index(), nodes: points.len() });
        }
        let p = corners.map(|n| points[n]);
        for k in 0..3 {
            let edge = (p[(k + 1) % 3] - p[k]).amax();
            if edge > 0.0 && edge < SHORTEST_EDGE {
                return Err(MeshError::Scale { node: corners[k].index(), x: p[k][0], y: p[k][1], edge });
            }
        }
        if geometry::sure_area(p).is_none_or(|area| area < 0.0) {
            let area = geometry::signed_area(p);
            let x = (p[0][0] + p[1][0] + p[2][0]) / 3.0;
            let y = (p[0][1] + p[1][1] + p[2][1]) / 3.0;
            return Err(MeshError::Area { triangle, area, x, y });
        }
    }
    Ok(())
}

fn check_nodes(points: &[Vector], topology: &Topology) -> Result<(), MeshError> {
    let mut boundary_facets = vec![0u8; points.len()];
    for &e in topology.boundary_facets() {
        for n in topology.facets()[e] {
            boundary_facets[n] = boundary_facets[n].saturating_add(1);
        }
    }
    for (node, p) in points.iter().enumerate() {
        if topology.cells_around(NodeId::new(node)).is_empty() {
            return Err(MeshError::LooseNode { node, x: p[0], y: p[1] });
        }
        if boundary_facets[node] > 2 {
            return Err(MeshError::BowTie { node, x: p[0], y: p[1] });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> (Vec<Vector>, Vec<[u32; 3]>) {
        (vec![Vector::zeros(), Vector::x(), Vector::new(1.0, 1.0), Vector::y()], vec![[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn named_edges_are_found_in_either_order() {
        let (p, t) = square();
        let m = TriMesh::new(p, t, vec![("bottom".into(), vec![[1, 0]])]).unwrap();
        let e = m.group("bottom").unwrap()[0];
        assert_eq!(m.facet_normal(e), Vector::new(0.0, -1.0));
        assert_eq!(m.topology().boundary_facets().len(), 4);
        assert!((m.smallest_angle() - 45.0).abs() < 1e-12);
    }

    #[test]
    fn faults_are_named() {
        let (p, t) = square();
        let mut bad = p.clone();
        bad[2][1] = f64::NAN;
        assert!(matches!(TriMesh::new(bad, t.clone(), vec![]), Err(MeshError::NotFinite { node: 2, .. })));
        let flat = vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
        assert!(matches!(
            TriMesh::new(flat, vec![[0, 1, 2]], vec![]),
            Err(MeshError::Area { triangle: 0, .. })
        ));
        let mut loose = p.clone();
        loose.push(Vector::new(5.0, 5.0));
        assert!(matches!(TriMesh::new(loose, t.clone(), vec![]), Err(MeshError::LooseNode { node: 4, .. })));
        let three = vec![[0, 1, 2], [0, 2, 3], [0, 1, 3]];
        assert!(matches!(TriMesh::new(p.clone(), three, vec![]), Err(MeshError::NonManifoldEdge { .. })));
        let diagonal = vec![("d".to_string(), vec![[1, 3]])];
        assert!(matches!(TriMesh::new(p.clone(), t.clone(), diagonal), Err(MeshError::NoSuchEdge { .. })));
        assert!(matches!(
            TriMesh::new(p, vec![[0, 1, 9]], vec![]),
            Err(MeshError::NoSuchNode { node: 9, .. })
        ));
    }

    #[test]
    fn coordinates_of_300_digits_are_shown_with_an_exponent() {
        let (node, [x, y]) = (7, [1e300, -1e-300]);
        for error in [
            MeshError::NotFinite { node, x, y },
            MeshError::Area { triangle: 7, area: 0.0, x, y },
            MeshError::LooseNode { node, x, y },
            MeshError::BowTie { node, x, y },
        ] {
            let said = error.to_string();
            assert!(said.contains("(1e300, -1e-300)") && said.len() < 200, "{said}");
        }
    }

    #[test]
    fn clockwise_triangles_are_turned_round_and_counted() {
        let (p, t) = square();
        let clockwise = vec![[0, 2, 1], [0, 2, 3]];
        let turned = TriMesh::new(p.clone(), clockwise.clone(), vec![]).unwrap();
        let corners = t.iter().map(|corners| corners.map(NodeId::from)).collect::<Vec<_>>();
        assert_eq!((turned.turned(), turned.cells()), (1, &corners[..]));
        assert_eq!(TriMesh::new(p.clone(), t, vec![]).unwrap().turned(), 0);
        // A triangle that a motion of nodes turned over is not silently reversed.
        let clockwise = clockwise.into_iter().map(|corners| corners.map(NodeId::from)).collect();
        let over = TriMesh::counter_clockwise(p, clockwise, vec![]);
        assert!(matches!(over, Err(MeshError::Area { triangle: 0, .. })));
    }

    #[test]
    fn two_triangles_touching_in_a_node_are_refused() {
        let p = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0]];
        let t = vec![[0, 1, 2], [0, 3, 4]];
        assert!(matches!(TriMesh::new(p, t, vec![]), Err(MeshError::BowTie { node: 0, .. })));
    }
}

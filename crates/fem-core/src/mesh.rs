//! Meshes of triangles or tetrahedra: immutable, checked on creation, with named sets of facets.

pub mod bisect;
pub mod cell_tree;
mod error;
pub mod generate;
pub mod id;
pub mod insertion;
mod overlap;
pub mod refine;
mod subdomains;
pub mod topology;

use crate::geometry::{self, Coordinates, Point};
use crate::mesh::id::{FacetId, NodeId};
use crate::space::{Item, Plane, Solid, Space};
use error::{LARGEST_COORDINATE, SHORTEST_EDGE};
use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap, HashSet};
use topology::Topology;

pub use error::MeshError;
pub use overlap::CellOverlap;

/// The corners of a cell: a triangle or a tetrahedron.
pub type Cell<S> = <S as Space>::Corners<NodeId>;

/// The corners of a facet, which has as many as there are axes: an edge or a triangle.
pub(crate) type Facet<S> = <S as Space>::Axes<NodeId>;

/// A conforming mesh with named sets of facets.
///
/// Corners of every triangle run counter-clockwise, and tetrahedra have a positive volume. Facet `k` of a cell has the corners
/// [`Space::facet`]: edge `k` of a triangle joins its corners `k` and `(k+1) mod 3`.
#[derive(Clone, Debug)]
pub struct Mesh<S: Space = Plane> {
    points: Vec<S::Vector>,
    cells: Vec<Cell<S>>,
    topology: Topology<S>,
    groups: BTreeMap<String, Vec<FacetId>>,
    turned: usize,
    /// See [`Mesh::bounding_box`].
    bounds: [S::Vector; 2],
}

/// A mesh of triangles.
pub type TriMesh = Mesh<Plane>;

/// A mesh of tetrahedra.
pub type TetMesh = Mesh<Solid>;

impl<S: Space> Mesh<S> {
    /// Checks points, cells and named facets and creates a mesh from them. Cells of negative measure, such as clockwise triangles, are
    /// reversed: their second and third corners are swapped, and [`Mesh::turned`] returns their number.
    ///
    /// Cells that overlap without sharing nodes are not detected here, see [`Mesh::overlapping_cells`].
    ///
    /// * `groups`: name and facets, each by its nodes in any order; facets may lie in several groups.
    ///
    /// # Errors
    /// Anything that would make a computation on this mesh meaningless, see [`MeshError`].
    pub fn new<N: Into<NodeId> + Item>(
        points: Vec<impl Into<S::Vector>>,
        cells: Vec<S::Corners<N>>,
        groups: Vec<(String, Vec<S::Axes<N>>)>,
    ) -> Result<Self, MeshError> {
        let points: Vec<S::Vector> = points.into_iter().map(Into::into).collect();
        let numbered =
            |facets: Vec<S::Axes<N>>| facets.into_iter().map(|nodes| S::axes(|k| nodes[k].into())).collect();
        let groups = groups.into_iter().map(|(name, facets)| (name, numbered(facets))).collect();
        let mut cells: Vec<Cell<S>> = cells.into_iter().map(|cell| S::corners(|k| cell[k].into())).collect();
        let mut turned = 0;
        for cell in &mut cells {
            let known = cell.as_ref().iter().all(|n| n.index() < points.len());
            if known && S::measure(&S::corners(|k| points[cell[k]])) < 0.0 {
                cell.as_mut().swap(1, 2);
                turned += 1;
            }
        }
        Ok(Self { turned, ..Self::oriented(points, cells, groups)? })
    }

    /// Creates a mesh like [`Mesh::new`] from cells of positive measure: a negative one was turned over by a
    /// motion of its nodes.
    ///
    /// # Errors
    /// See [`Mesh::new`]; a cell of negative measure.
    pub fn oriented(
        points: Vec<S::Vector>,
        cells: Vec<Cell<S>>,
        groups: Vec<(String, Vec<Facet<S>>)>,
    ) -> Result<Self, MeshError> {
        check_sizes::<S>(&points, &cells)?;
        check_cells::<S>(&points, &cells)?;
        let topology = Topology::build(points.len(), &cells)?;
        check_nodes(&points, &topology)?;
        let words = S::WORDS;
        let mut named = BTreeMap::new();
        for (name, facets) in groups {
            let mut ids = Vec::with_capacity(facets.len());
            for nodes in facets {
                let id = topology.find_facet(nodes).ok_or_else(|| MeshError::NoSuchFacet {
                    group: name.clone(),
                    nodes: nodes.into_iter().map(NodeId::index).collect(),
                    words,
                })?;
                ids.push(id);
            }
            ids.sort_unstable();
            ids.dedup();
            if named.insert(name.clone(), ids).is_some() {
                return Err(MeshError::DuplicateGroup { group: name, words });
            }
        }
        let bounds = geometry::bounding_box(&points);
        Ok(Self { points, cells, topology, groups: named, turned: 0, bounds })
    }

    /// Creates a mesh of some cells of a mesh, without names. Its cells may touch each other at a node alone: they are joined elsewhere.
    ///
    /// # Errors
    /// See [`Mesh::new`].
    pub(crate) fn of_cells(points: Vec<S::Vector>, cells: Vec<Cell<S>>) -> Result<Self, MeshError> {
        let topology = Topology::build(points.len(), &cells)?;
        let bounds = geometry::bounding_box(&points);
        Ok(Self { points, cells, topology, groups: BTreeMap::new(), turned: 0, bounds })
    }

    /// Returns the coordinates of the nodes.
    #[inline]
    pub fn points(&self) -> &[S::Vector] {
        &self.points
    }

    /// Returns the corners of the box around all nodes with the smallest and the largest coordinates, m.
    pub fn bounding_box(&self) -> [S::Vector; 2] {
        self.bounds
    }

    /// Returns the diagonal of [`Mesh::bounding_box`], m.
    pub fn diagonal(&self) -> f64 {
        geometry::norm(self.bounds[1] - self.bounds[0])
    }

    /// Returns the nodes of the cells; those of triangles run counter-clockwise.
    #[inline]
    pub fn cells(&self) -> &[Cell<S>] {
        &self.cells
    }

    /// Returns the number of cells that [`Mesh::new`] reversed.
    pub fn turned(&self) -> usize {
        self.turned
    }

    /// Returns facets and neighbourhoods.
    #[inline]
    pub fn topology(&self) -> &Topology<S> {
        &self.topology
    }

    /// Returns the named sets of facets: their numbers, ascending.
    pub fn groups(&self) -> &BTreeMap<String, Vec<FacetId>> {
        &self.groups
    }

    /// Returns the facets of one group, if there is a group of that name.
    pub fn group(&self, name: &str) -> Option<&[FacetId]> {
        self.groups.get(name).map(Vec::as_slice)
    }

    /// Returns the corner points of a cell.
    #[inline]
    pub fn corners(&self, cell: usize) -> S::Corners<S::Vector> {
        let nodes = &self.cells[cell];
        S::corners(|k| self.points[nodes[k]])
    }

    /// Computes the area, m², or the volume, m³, of a cell.
    #[inline]
    pub fn measure(&self, cell: usize) -> f64 {
        S::measure(&self.corners(cell))
    }

    /// Computes the length, m, or the area, m², of a facet.
    #[inline]
    pub fn facet_measure(&self, facet: FacetId) -> f64 {
        S::facet_measure(&self.facet_corners(facet))
    }

    /// Returns the positions of a facet's nodes, by ascending number, m.
    pub fn facet_corners(&self, facet: FacetId) -> S::Axes<S::Vector> {
        let nodes = &self.topology.facets()[facet];
        S::axes(|k| self.points[nodes[k]])
    }

    /// Adds a group of facets, sorted by their numbers.
    pub fn add_group(&mut self, name: &str, mut facets: Vec<FacetId>) {
        facets.sort_unstable();
        self.groups.insert(name.to_owned(), facets);
    }

    /// Computes the centroid of a facet, m.
    pub fn facet_middle(&self, facet: FacetId) -> S::Vector {
        self.facet_corners(facet).into_iter().sum::<S::Vector>() * (1.0 / S::DIM as f64)
    }

    /// Computes the unit normal of a facet that points out of the facet's first cell: the outward
    /// normal of the body on a boundary facet.
    pub fn facet_normal(&self, facet: FacetId) -> S::Vector {
        let nodes = self.topology.oriented_facet(facet, &self.cells);
        S::facet_normal(&S::axes(|k| self.points[nodes[k]]))
    }

    /// Computes the smallest angle of all cells, see [`Space::smallest_angle`], in degrees.
    pub fn smallest_angle(&self) -> f64 {
        (0..self.cells.len()).map(|cell| S::smallest_angle(&self.corners(cell))).fold(180.0, f64::min)
    }
}

impl TriMesh {
    /// Collects the connected parts of a side, each from end to end with the body on its left; a closed one ends with its first node.
    ///
    /// * `edges`: on the boundary; `order`: of nodes, decides which part comes first and where a closed one begins.
    pub fn walks(&self, edges: &[FacetId], order: impl Fn(NodeId, NodeId) -> Ordering) -> Vec<Vec<NodeId>> {
        let oriented = || edges.iter().map(|edge| self.topology.oriented_facet(*edge, &self.cells));
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
}

fn check_sizes<S: Space>(points: &[S::Vector], cells: &[Cell<S>]) -> Result<(), MeshError> {
    if points.is_empty() || cells.is_empty() {
        return Err(MeshError::Empty { points: points.len(), cells: cells.len(), words: S::WORDS });
    }
    // The unknowns of a node and the facets of a cell must stay below 2³².
    let limit = (u32::MAX / 8) as usize;
    for (what, found) in [("nodes", points.len()), (S::WORDS.cells, cells.len())] {
        if found > limit {
            return Err(MeshError::TooLarge { what, found, limit });
        }
    }
    if let Some(node) = points.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite { node, point: points[node].into() });
    }
    match points.iter().position(|p| p.largest() > LARGEST_COORDINATE) {
        Some(node) => Err(MeshError::Scale { node, point: points[node].into(), edge: 0.0 }),
        None => Ok(()),
    }
}

fn check_cells<S: Space>(points: &[S::Vector], cells: &[Cell<S>]) -> Result<(), MeshError> {
    let words = S::WORDS;
    for (number, cell) in cells.iter().enumerate() {
        if let Some(node) = cell.into_iter().find(|n| n.index() >= points.len()) {
            return Err(MeshError::NoSuchNode {
                cell: number,
                node: node.index(),
                nodes: points.len(),
                words,
            });
        }
        let p = S::corners(|k| points[cell[k]]);
        for k in 0..=S::DIM {
            for j in 0..k {
                let edge = (p[k] - p[j]).largest();
                if edge > 0.0 && edge < SHORTEST_EDGE {
                    return Err(MeshError::Scale { node: cell[k].index(), point: p[k].into(), edge });
                }
            }
        }
        if S::sure_measure(&p).is_none_or(|measure| measure < 0.0) {
            let point: Point = (p.into_iter().sum::<S::Vector>() / (S::DIM + 1) as f64).into();
            return Err(MeshError::Measure { cell: number, measure: S::measure(&p), point, words });
        }
    }
    Ok(())
}

fn check_nodes<S: Space>(points: &[S::Vector], topology: &Topology<S>) -> Result<(), MeshError> {
    let words = S::WORDS;
    let mut on_boundary = vec![false; points.len()];
    for &facet in topology.boundary_facets() {
        for n in topology.facets()[facet] {
            on_boundary[n] = true;
        }
    }
    for (node, point) in points.iter().enumerate() {
        let number = NodeId::new(node);
        if topology.cells_around(number).is_empty() {
            return Err(MeshError::LooseNode { node, point: (*point).into(), words });
        }
        if on_boundary[node] && !topology.is_joined_around(number) {
            return Err(MeshError::BowTie { node, point: (*point).into(), words });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

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
            Err(MeshError::Measure { cell: 0, .. })
        ));
        let mut loose = p.clone();
        loose.push(Vector::new(5.0, 5.0));
        assert!(matches!(TriMesh::new(loose, t.clone(), vec![]), Err(MeshError::LooseNode { node: 4, .. })));
        let three = vec![[0, 1, 2], [0, 2, 3], [0, 1, 3]];
        assert!(matches!(TriMesh::new(p.clone(), three, vec![]), Err(MeshError::NonManifold { .. })));
        let diagonal = vec![("d".to_string(), vec![[1, 3]])];
        assert!(matches!(TriMesh::new(p.clone(), t.clone(), diagonal), Err(MeshError::NoSuchFacet { .. })));
        assert!(matches!(
            TriMesh::new(p, vec![[0, 1, 9]], vec![]),
            Err(MeshError::NoSuchNode { node: 9, .. })
        ));
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
        let over = TriMesh::oriented(p, clockwise, vec![]);
        assert!(matches!(over, Err(MeshError::Measure { cell: 0, .. })));
    }

    #[test]
    fn two_triangles_touching_in_a_node_are_refused() {
        let p = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0]];
        let t = vec![[0, 1, 2], [0, 3, 4]];
        assert!(matches!(TriMesh::new(p, t, vec![]), Err(MeshError::BowTie { node: 0, .. })));
    }
}

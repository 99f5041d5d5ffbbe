//! Edges of a triangle mesh and the neighbourhoods of its nodes.

use super::MeshError;
use crate::mesh::id::{FacetId, NodeId};
use std::sync::OnceLock;

/// Means 'no triangle' on the outer side of a boundary edge.
pub const NONE: u32 = u32::MAX;

/// Edges, their triangles, and the triangles around each node.
///
/// Edges are numbered by their nodes (smaller first), so the numbering does not depend on the order of
/// the triangles.
#[derive(Clone, Debug)]
pub struct Topology {
    edges: Vec<[NodeId; 2]>,
    facet_cells: Vec<[u32; 2]>,
    cell_facets: Vec<[FacetId; 3]>,
    boundary_facets: Vec<FacetId>,
    /// Edges whose smaller node is i: first_edge[i]..first_edge[i+1].
    first_edge: Vec<u32>,
    node_starts: Vec<u32>,
    node_triangles: Vec<u32>,
    /// The part of every node and the number of parts, once they are asked for.
    pieces: OnceLock<(Vec<u32>, usize)>,
}

/// A half-edge in the bucket of its smaller node: the larger one, the triangle, its place there, and whether it runs from
/// the smaller to the larger.
type HalfEdge = (NodeId, u32, u8, bool);

/// Sorts the 3T half-edges into buckets by their smaller node, and returns the starts of the buckets; each holds only
/// a few, so sorting it is cheap.
fn half_edges(nodes: usize, triangles: &[[NodeId; 3]]) -> (Vec<u32>, Vec<HalfEdge>) {
    let mut starts = vec![0u32; nodes + 1];
    for t in triangles {
        for k in 0..3 {
            starts[t[k].min(t[(k + 1) % 3]).index() + 1] += 1;
        }
    }
    for i in 0..nodes {
        starts[i + 1] += starts[i];
    }
    let mut cursor = starts.clone();
    let mut half = vec![(NodeId::default(), 0u32, 0u8, false); 3 * triangles.len()];
    for (number, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let slot = &mut cursor[a.min(b)];
            half[*slot as usize] = (a.max(b), number as u32, k as u8, a < b);
            *slot += 1;
        }
    }
    (starts, half)
}

impl Topology {
    /// Builds the topology in time proportional to the number of triangles.
    pub(super) fn build(nodes: usize, triangles: &[[NodeId; 3]]) -> Result<Self, MeshError> {
        let (node_starts, node_triangles) = triangles_by_node(nodes, triangles);
        let (starts, mut half) = half_edges(nodes, triangles);
        let mut edges = Vec::with_capacity(triangles.len() * 3 / 2 + 16);
        let mut facet_cells: Vec<[u32; 2]> = Vec::with_capacity(edges.capacity());
        let mut cell_facets = vec![[FacetId::NONE; 3]; triangles.len()];
        let mut first_edge = Vec::with_capacity(nodes + 1);
        for a in 0..nodes {
            first_edge.push(edges.len() as u32);
            let bucket = &mut half[starts[a] as usize..starts[a + 1] as usize];
            bucket.sort_unstable();
            let mut previous = None;
            for &(b, triangle, k, forward) in bucket.iter() {
                let fault = MeshError::NonManifoldEdge { a, b: b.index() };
                let edge = match previous {
                    Some((other, other_forward)) if other == b => {
                        let e = edges.len() - 1;
                        if facet_cells[e][1] != NONE || other_forward == forward {
                            return Err(fault);
                        }
                        facet_cells[e][1] = triangle;
                        e
                    }
                    _ => {
                        edges.push([NodeId::new(a), b]);
                        facet_cells.push([triangle, NONE]);
                        edges.len() - 1
                    }
                };
                previous = Some((b, forward));
                cell_facets[triangle as usize][k as usize] = FacetId::new(edge);
            }
        }
        first_edge.push(edges.len() as u32);
        let boundary_facets =
            (0..edges.len()).map(FacetId::new).filter(|&e| facet_cells[e][1] == NONE).collect();
        Ok(Self {
            edges,
            facet_cells,
            cell_facets,
            boundary_facets,
            first_edge,
            node_starts,
            node_triangles,
            pieces: OnceLock::new(),
        })
    }

    /// Returns the two nodes of every edge, the smaller first.
    #[inline]
    pub fn facets(&self) -> &[[NodeId; 2]] {
        &self.edges
    }

    /// Returns the triangles of every edge; the second is [`NONE`] on the boundary.
    #[inline]
    pub fn facet_cells(&self) -> &[[u32; 2]] {
        &self.facet_cells
    }

    /// Returns the edges of every triangle: edge `k` joins its corners `k` and `(k+1) mod 3`.
    #[inline]
    pub fn cell_facets(&self) -> &[[FacetId; 3]] {
        &self.cell_facets
    }

    /// Returns the edges that have only one triangle, ascending.
    #[inline]
    pub fn boundary_facets(&self) -> &[FacetId] {
        &self.boundary_facets
    }

    /// Tells whether an edge has only one triangle.
    #[inline]
    pub fn is_boundary(&self, edge: FacetId) -> bool {
        self.facet_cells[edge][1] == NONE
    }

    /// Finds the edge with which the boundary continues at a node of a boundary edge; `None` if the boundary crosses itself there.
    pub fn boundary_beyond(&self, edge: FacetId, node: NodeId) -> Option<FacetId> {
        let around = self.cells_around(node).iter().flat_map(|t| self.cell_facets[*t as usize]);
        let beyond = |e: &FacetId| *e != edge && self.edges[*e].contains(&node) && self.is_boundary(*e);
        let mut found = around.filter(beyond);
        found.next().filter(|_| found.next().is_none())
    }

    /// Returns the triangles that have `node` as a corner, ascending.
    #[inline]
    pub fn cells_around(&self, node: NodeId) -> &[u32] {
        let [start, end] = [node.index(), node.index() + 1].map(|n| self.node_starts[n] as usize);
        &self.node_triangles[start..end]
    }

    /// Finds the edge between two nodes.
    pub fn find_edge(&self, a: impl Into<NodeId>, b: impl Into<NodeId>) -> Option<FacetId> {
        let [a, b] = [a.into(), b.into()];
        let (low, high) = (a.min(b).index(), a.max(b));
        let range = *self.first_edge.get(low)?..*self.first_edge.get(low + 1)?;
        range.map(FacetId::from).find(|&e| self.edges[e][1] == high)
    }

    /// Returns the nodes of an edge in the counter-clockwise sense of its first triangle.
    #[inline]
    pub fn oriented_facet(&self, edge: FacetId, triangles: &[[NodeId; 3]]) -> [NodeId; 2] {
        let triangle = self.facet_cells[edge][0] as usize;
        let corners = triangles[triangle];
        let k = self.facet_in(triangle, edge);
        [corners[k], corners[(k + 1) % 3]]
    }

    /// Finds which of the three edges of a triangle an edge is.
    ///
    /// # Panics
    /// If the triangle has no such edge: that is an error of the caller, whatever the mesh.
    #[inline]
    pub fn facet_in(&self, triangle: usize, edge: FacetId) -> usize {
        let edges = &self.cell_facets[triangle];
        match edges.iter().position(|e| *e == edge) {
            Some(k) => k,
            None => unreachable!("edge {edge} is not one of the edges {edges:?} of triangle {triangle}"),
        }
    }

    /// Finds the place of a boundary edge among [`Topology::boundary_facets`].
    ///
    /// # Panics
    /// If the edge is not on the boundary: that is an error of the caller, whatever the mesh.
    #[inline]
    pub fn boundary_place(&self, edge: FacetId) -> usize {
        match self.boundary_facets.binary_search(&edge) {
            Ok(place) => place,
            Err(_) => unreachable!(
                "edge {edge} between triangles {:?} is not on the boundary",
                self.facet_cells[edge]
            ),
        }
    }

    /// Returns, for every node, the other ends of its edges, ascending, in compressed form
    /// `(starts, neighbours)`.
    pub fn node_neighbours(&self) -> (Vec<u32>, Vec<NodeId>) {
        let nodes = self.node_starts.len() - 1;
        let mut starts = vec![0u32; nodes + 1];
        for e in &self.edges {
            starts[e[0].index() + 1] += 1;
            starts[e[1].index() + 1] += 1;
        }
        for i in 0..nodes {
            starts[i + 1] += starts[i];
        }
        let mut cursor = starts.clone();
        let mut neighbours = vec![NodeId::default(); 2 * self.edges.len()];
        // Edges are sorted by smaller node: adding first all larger-to-smaller links keeps each list ascending.
        for (from, to) in [(1, 0), (0, 1)] {
            for e in &self.edges {
                let slot = &mut cursor[e[from]];
                neighbours[*slot as usize] = e[to];
                *slot += 1;
            }
        }
        (starts, neighbours)
    }

    /// Numbers the connected parts of the mesh: the part of every node, and the number of parts.
    pub fn pieces(&self) -> (&[u32], usize) {
        let (piece_of, count) = self.pieces.get_or_init(|| self.number_pieces());
        (piece_of, *count)
    }

    fn number_pieces(&self) -> (Vec<u32>, usize) {
        let (starts, neighbours) = self.node_neighbours();
        let nodes = starts.len() - 1;
        let mut piece = vec![NONE; nodes];
        let mut count = 0;
        let mut stack = Vec::new();
        for seed in 0..nodes {
            if piece[seed] != NONE {
                continue;
            }
            piece[seed] = count;
            stack.push(seed);
            while let Some(i) = stack.pop() {
                for &j in &neighbours[starts[i] as usize..starts[i + 1] as usize] {
                    if piece[j] == NONE {
                        piece[j] = count;
                        stack.push(j.index());
                    }
                }
            }
            count += 1;
        }
        (piece, count as usize)
    }
}

fn triangles_by_node(nodes: usize, triangles: &[[NodeId; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; nodes + 1];
    for n in triangles.iter().flatten() {
        starts[n.index() + 1] += 1;
    }
    for i in 0..nodes {
        starts[i + 1] += starts[i];
    }
    let mut cursor = starts.clone();
    let mut list = vec![0u32; 3 * triangles.len()];
    for (number, t) in triangles.iter().enumerate() {
        for n in t {
            let slot = &mut cursor[*n];
            list[*slot as usize] = number as u32;
            *slot += 1;
        }
    }
    (starts, list)
}

//! Facets of a mesh and the neighbourhoods of its nodes.

use super::{Cell, Facet, MeshError};
use crate::mesh::id::{FacetId, NodeId};
use crate::space::{Plane, Space};
use std::sync::OnceLock;

/// Means 'no cell' on the outer side of a boundary facet.
pub const NONE: u32 = u32::MAX;

/// Facets, their cells, and the cells around each node.
///
/// Facets are numbered by their nodes (smaller first), so the numbering does not depend on the order of
/// the cells.
#[derive(Clone, Debug)]
pub struct Topology<S: Space = Plane> {
    facets: Vec<Facet<S>>,
    facet_cells: Vec<[u32; 2]>,
    cell_facets: Vec<S::Corners<FacetId>>,
    boundary_facets: Vec<FacetId>,
    /// Facets whose smallest node is i: first_facet[i]..first_facet[i+1].
    first_facet: Vec<u32>,
    node_starts: Vec<u32>,
    node_cells: Vec<u32>,
    /// The part of every node and the number of parts, once they are asked for.
    pieces: OnceLock<(Vec<u32>, usize)>,
}

/// One side of a facet: its nodes, ascending, the cell, the place there, and whether the cell sees them in an even order.
type HalfFacet<S> = (Facet<S>, u32, u8, bool);

/// Sorts nodes; returns whether an even number of exchanges did it.
fn sorted<S: Space>(mut nodes: Facet<S>) -> (Facet<S>, bool) {
    let (list, mut even) = (nodes.as_mut(), true);
    for last in (1..list.len()).rev() {
        for k in 0..last {
            if list[k] > list[k + 1] {
                list.swap(k, k + 1);
                even = !even;
            }
        }
    }
    (nodes, even)
}

/// Sorts the sides of all facets into buckets by their smallest node, and returns the starts of the buckets; each holds only
/// a few, so sorting it is cheap.
fn half_facets<S: Space>(nodes: usize, cells: &[Cell<S>]) -> (Vec<u32>, Vec<HalfFacet<S>>) {
    let halves = |cell: &Cell<S>| {
        let cell = *cell;
        (0..=S::DIM).map(move |k| {
            let places = S::facet(k);
            (k as u8, sorted::<S>(S::axes(|i| cell[places[i]])))
        })
    };
    let mut starts = vec![0u32; nodes + 1];
    for (_, (facet, _)) in cells.iter().flat_map(halves) {
        starts[facet[0].index() + 1] += 1;
    }
    for i in 0..nodes {
        starts[i + 1] += starts[i];
    }
    let mut cursor = starts.clone();
    let mut half = vec![(S::axes(|_| NodeId::default()), 0u32, 0u8, false); (S::DIM + 1) * cells.len()];
    for (number, cell) in cells.iter().enumerate() {
        for (k, (facet, even)) in halves(cell) {
            let slot = &mut cursor[facet[0]];
            half[*slot as usize] = (facet, number as u32, k, even);
            *slot += 1;
        }
    }
    (starts, half)
}

impl<S: Space> Topology<S> {
    /// Builds the topology in time proportional to the number of cells.
    pub(super) fn build(nodes: usize, cells: &[Cell<S>]) -> Result<Self, MeshError> {
        let (node_starts, node_cells) = cells_by_node::<S>(nodes, cells);
        let (starts, mut half) = half_facets::<S>(nodes, cells);
        let mut facets: Vec<Facet<S>> = Vec::with_capacity(half.len() / 2 + 16);
        let mut facet_cells: Vec<[u32; 2]> = Vec::with_capacity(facets.capacity());
        let mut cell_facets = vec![S::corners(|_| FacetId::NONE); cells.len()];
        let mut first_facet = Vec::with_capacity(nodes + 1);
        for a in 0..nodes {
            first_facet.push(facets.len() as u32);
            let bucket = &mut half[starts[a] as usize..starts[a + 1] as usize];
            bucket.sort_unstable_by(|x, y| x.0.as_ref().cmp(y.0.as_ref()).then(x.1.cmp(&y.1)));
            let mut previous = None;
            for &(nodes, cell, k, even) in bucket.iter() {
                let facet = match previous {
                    Some((other, other_even)) if other == nodes => {
                        let facet = facets.len() - 1;
                        if facet_cells[facet][1] != NONE || other_even == even {
                            let nodes = nodes.into_iter().map(NodeId::index).collect();
                            return Err(MeshError::NonManifold { nodes, words: S::WORDS });
                        }
                        facet_cells[facet][1] = cell;
                        facet
                    }
                    _ => {
                        facets.push(nodes);
                        facet_cells.push([cell, NONE]);
                        facets.len() - 1
                    }
                };
                previous = Some((nodes, even));
                cell_facets[cell as usize][k as usize] = FacetId::new(facet);
            }
        }
        first_facet.push(facets.len() as u32);
        let boundary_facets =
            (0..facets.len()).map(FacetId::new).filter(|&f| facet_cells[f][1] == NONE).collect();
        Ok(Self {
            facets,
            facet_cells,
            cell_facets,
            boundary_facets,
            first_facet,
            node_starts,
            node_cells,
            pieces: OnceLock::new(),
        })
    }

    /// Returns the nodes of every facet, ascending.
    #[inline]
    pub fn facets(&self) -> &[Facet<S>] {
        &self.facets
    }

    /// Returns the cells of every facet; the second is [`NONE`] on the boundary.
    #[inline]
    pub fn facet_cells(&self) -> &[[u32; 2]] {
        &self.facet_cells
    }

    /// Returns the facets of every cell, in the order of [`Space::facet`].
    #[inline]
    pub fn cell_facets(&self) -> &[S::Corners<FacetId>] {
        &self.cell_facets
    }

    /// Returns the facets that have only one cell, ascending.
    #[inline]
    pub fn boundary_facets(&self) -> &[FacetId] {
        &self.boundary_facets
    }

    /// Tells whether a facet has only one cell.
    #[inline]
    pub fn is_boundary(&self, facet: FacetId) -> bool {
        self.facet_cells[facet][1] == NONE
    }

    /// Returns the cells that have `node` as a corner, ascending.
    #[inline]
    pub fn cells_around(&self, node: NodeId) -> &[u32] {
        let [start, end] = [node.index(), node.index() + 1].map(|n| self.node_starts[n] as usize);
        &self.node_cells[start..end]
    }

    /// Tells whether one can pass between all cells around a node through facets that have the node.
    pub(super) fn is_joined_around(&self, node: NodeId) -> bool {
        let around = self.cells_around(node);
        let mut reached = vec![false; around.len()];
        reached[0] = true;
        let (mut stack, mut count) = (vec![around[0]], 1);
        while let Some(cell) = stack.pop() {
            let facets = self.cell_facets[cell as usize].into_iter();
            for facet in facets.filter(|facet| self.facets[*facet].as_ref().contains(&node)) {
                for beyond in self.facet_cells[facet] {
                    if let Ok(place) = around.binary_search(&beyond)
                        && !std::mem::replace(&mut reached[place], true)
                    {
                        count += 1;
                        stack.push(beyond);
                    }
                }
            }
        }
        count == around.len()
    }

    /// Finds the facet that has the given nodes, in any order.
    pub fn find_facet(&self, nodes: Facet<S>) -> Option<FacetId> {
        let (nodes, _) = sorted::<S>(nodes);
        let low = nodes[0].index();
        let range = *self.first_facet.get(low)?..*self.first_facet.get(low + 1)?;
        range.map(FacetId::from).find(|&f| self.facets[f] == nodes)
    }

    /// Returns the nodes of a facet as its first cell has them, see [`Space::facet`]: those of an edge in the counter-clockwise sense.
    #[inline]
    pub fn oriented_facet(&self, facet: FacetId, cells: &[Cell<S>]) -> Facet<S> {
        let cell = self.facet_cells[facet][0] as usize;
        let (corners, places) = (&cells[cell], S::facet(self.facet_in(cell, facet)));
        S::axes(|i| corners[places[i]])
    }

    /// Finds which of the facets of a cell a facet is.
    ///
    /// # Panics
    /// If the cell has no such facet: that is an error of the caller, whatever the mesh.
    #[inline]
    pub fn facet_in(&self, cell: usize, facet: FacetId) -> usize {
        let facets = &self.cell_facets[cell];
        match facets.as_ref().iter().position(|f| *f == facet) {
            Some(k) => k,
            None => unreachable!("facet {facet} is not one of the facets {facets:?} of cell {cell}"),
        }
    }

    /// Finds the place of a boundary facet among [`Topology::boundary_facets`].
    ///
    /// # Panics
    /// If the facet is not on the boundary: that is an error of the caller, whatever the mesh.
    #[inline]
    pub fn boundary_place(&self, facet: FacetId) -> usize {
        match self.boundary_facets.binary_search(&facet) {
            Ok(place) => place,
            Err(_) => {
                unreachable!(
                    "facet {facet} between cells {:?} is not on the boundary",
                    self.facet_cells[facet]
                )
            }
        }
    }

    /// Returns, for every node, the nodes that share a cell with it, ascending, in compressed form
    /// `(starts, neighbours)`.
    pub(crate) fn node_neighbours(&self) -> (Vec<u32>, Vec<NodeId>) {
        let nodes = self.node_starts.len() - 1;
        let mut starts = vec![0u32; nodes + 1];
        for n in self.facets.iter().flat_map(|facet| *facet) {
            starts[n.index() + 1] += S::DIM as u32 - 1;
        }
        for i in 0..nodes {
            starts[i + 1] += starts[i];
        }
        let mut cursor = starts.clone();
        let mut neighbours = vec![NodeId::default(); starts[nodes] as usize];
        // Facets are sorted by smallest node: adding first all larger-to-smaller links keeps the lists of edges ascending.
        for larger in [true, false] {
            for facet in &self.facets {
                for (k, j) in (0..S::DIM).flat_map(|k| (0..k).map(move |j| (k, j))) {
                    let (from, to) = if larger { (facet[k], facet[j]) } else { (facet[j], facet[k]) };
                    let slot = &mut cursor[from];
                    neighbours[*slot as usize] = to;
                    *slot += 1;
                }
            }
        }
        // Faces share edges.
        let (mut kept, mut start) = (0, 0);
        for node in 0..nodes {
            let (first, end) = (kept, starts[node + 1] as usize);
            neighbours[start..end].sort_unstable();
            for k in start..end {
                if kept == first || neighbours[kept - 1] != neighbours[k] {
                    neighbours[kept] = neighbours[k];
                    kept += 1;
                }
            }
            (starts[node + 1], start) = (kept as u32, end);
        }
        neighbours.truncate(kept);
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

impl Topology<Plane> {
    /// Finds the edge with which the boundary continues at a node of a boundary edge; `None` if the boundary crosses itself there.
    pub fn boundary_beyond(&self, edge: FacetId, node: NodeId) -> Option<FacetId> {
        let around = self.cells_around(node).iter().flat_map(|t| self.cell_facets[*t as usize]);
        let beyond = |e: &FacetId| *e != edge && self.facets[*e].contains(&node) && self.is_boundary(*e);
        let mut found = around.filter(beyond);
        found.next().filter(|_| found.next().is_none())
    }

    /// Finds the edge between two nodes.
    pub fn find_edge(&self, a: impl Into<NodeId>, b: impl Into<NodeId>) -> Option<FacetId> {
        self.find_facet([a.into(), b.into()])
    }
}

fn cells_by_node<S: Space>(nodes: usize, cells: &[Cell<S>]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; nodes + 1];
    for n in cells.iter().flat_map(|cell| *cell) {
        starts[n.index() + 1] += 1;
    }
    for i in 0..nodes {
        starts[i + 1] += starts[i];
    }
    let mut cursor = starts.clone();
    let mut list = vec![0u32; starts[nodes] as usize];
    for (number, cell) in cells.iter().enumerate() {
        for n in *cell {
            let slot = &mut cursor[n];
            list[*slot as usize] = number as u32;
            *slot += 1;
        }
    }
    (starts, list)
}

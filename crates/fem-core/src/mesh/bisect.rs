//! Longest-edge bisection of tetrahedra: several bodies together, so that contact surfaces match node by node.
//!
//! All edges of all bodies have one strict order, see [`EdgeOrder`]. A tetrahedron is cut from the middle of its largest edge to the two
//! corners opposite to it:
//! ```text
//! halve each marked tetrahedron; while a tetrahedron has a halved edge: halve it
//! ```
//! * **Conforming.** A face is only ever cut at its own largest edge, which is the same one from both sides. It ends, because each step of the
//!   closure goes up the order.
//! * **Matching.** Nodes that contact pairs join have one *representative*. Edges are compared and halved by the representatives of their ends,
//!   so both surfaces of a pair are cut alike.
//! * **Shapes.** There is no proof that they stay good. On meshes of boxes, all cut in six along one diagonal, this is Maubach's bisection.
//!
//! Sources: Rivara 1984; Maubach 1995.

mod order;

use crate::mesh::id::{FacetId, NodeId};
use crate::mesh::{Cell, MeshError, TetMesh};
use crate::space::{Solid, Space};
use order::starts;
use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};

pub use order::{BodyNode, EdgeOrder, JoinedNodes};

type Vector = <Solid as Space>::Vector;

/// Means 'none' in linked lists.
const NONE: u32 = u32::MAX;
/// Bits of a squared length that are rounded away: about 10 digits remain, so that round-off does not decide between equal edges.
const ROUNDED: u32 = 19;

/// Lists the edges of a tetrahedron.
pub(super) fn edges<T: Copy>(cell: &[T; 4]) -> [[T; 2]; 6] {
    EDGES.map(|ends| ends.map(|k| cell[k]))
}

const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The tetrahedra of a body, and their origin in the mesh that is refined.
#[derive(Clone, Debug, Default)]
pub struct BodyTets {
    /// Corners.
    cells: Vec<Cell<Solid>>,
    /// The old face that each face of a cell lies on; [`FacetId::NONE`] inside an old cell.
    faces: Vec<[FacetId; 4]>,
    /// The old cell that each one lies in.
    parents: Vec<u32>,
    /// The ends of the edge that each new node halves, in the order of creation.
    new_nodes: Vec<[NodeId; 2]>,
}

impl BodyTets {
    /// Makes room for cells.
    pub(super) fn reserve(&mut self, cells: usize) {
        self.cells.reserve(cells);
        self.faces.reserve(cells);
        self.parents.reserve(cells);
    }

    /// Adds a cell.
    ///
    /// * `faces`: the old face that each face lies on; `parent`: the old cell.
    pub(super) fn push(&mut self, cell: Cell<Solid>, faces: [FacetId; 4], parent: u32) {
        self.cells.push(cell);
        self.faces.push(faces);
        self.parents.push(parent);
    }

    /// Returns the corners of the cells.
    pub fn cells(&self) -> &[Cell<Solid>] {
        &self.cells
    }

    /// Returns the ends of the edge that each new node halves. An end may be a new node with a smaller number.
    pub fn new_nodes(&self) -> &[[NodeId; 2]] {
        &self.new_nodes
    }

    /// Returns the positions of old and new nodes, m.
    pub fn points(&self, old: &TetMesh) -> Vec<Vector> {
        let mut points = old.points().to_vec();
        points.extend_from_slice(&vec![Vector::zeros(); self.new_nodes.len()]);
        for (k, ends) in self.new_nodes.iter().enumerate() {
            let [a, b] = ends.map(|node| points[node]);
            points[old.points().len() + k] = 0.5 * (a + b);
        }
        points
    }

    /// Lists the cells, each with the number of a face, that have a face on an old one.
    ///
    /// * `wanted`: of an old face.
    pub fn faces_on<'a>(
        &'a self,
        wanted: impl Fn(FacetId) -> bool + 'a,
    ) -> impl Iterator<Item = ([NodeId; 3], FacetId)> + 'a {
        self.cells.iter().zip(&self.faces).flat_map(move |(cell, faces)| {
            let on = (0..4).filter(|k| faces[*k] != FacetId::NONE && wanted(faces[*k]));
            on.map(|k| (Solid::facet(k).map(|corner| cell[corner]), faces[k])).collect::<Vec<_>>()
        })
    }
}

/// A refined mesh of tetrahedra and the origin of its cells, faces and nodes.
#[derive(Clone, Debug)]
pub struct TetRefinement {
    /// The finer mesh. Old nodes keep their numbers, parts of faces inherit groups.
    pub mesh: TetMesh,
    /// The cell of the old mesh that each new one lies in.
    pub parent_cell: Vec<u32>,
    /// The face of the old mesh that each new one lies on; [`FacetId::NONE`] inside an old cell.
    pub parent_facet: Vec<FacetId>,
    /// The two ends of the edge that each new node halves; new node `k` has the number `old nodes + k`. None if
    /// nodes were inserted into a surface, see [`with_cut_surface`](super::insertion::with_cut_surface).
    pub parent_nodes: Vec<[NodeId; 2]>,
}

impl TetRefinement {
    /// Makes the finer mesh.
    ///
    /// * `old`: the mesh that is refined; `points`: [`BodyTets::points`], moved or not, m.
    ///
    /// # Errors
    /// More nodes or cells than a mesh can have, cells with a volume of round-off or less.
    pub fn new(old: &TetMesh, tets: BodyTets, points: Vec<Vector>) -> Result<Self, MeshError> {
        let mut groups_of: HashMap<FacetId, Vec<usize>> = HashMap::new();
        for (group, facets) in old.groups().values().enumerate() {
            facets.iter().for_each(|facet| groups_of.entry(*facet).or_default().push(group));
        }
        let mut groups: Vec<(String, Vec<[NodeId; 3]>)> =
            old.groups().keys().map(|name| (name.clone(), Vec::new())).collect();
        for (nodes, parent) in tets.faces_on(|parent| groups_of.contains_key(&parent)) {
            groups_of[&parent].iter().for_each(|group| groups[*group].1.push(nodes));
        }
        let BodyTets { cells, faces, parents, new_nodes } = tets;
        let mesh = TetMesh::oriented(points, cells, groups)?;
        let mut parent_facet = vec![FacetId::NONE; mesh.topology().facets().len()];
        for (own, parents) in mesh.topology().cell_facets().iter().zip(faces) {
            own.iter().zip(parents).for_each(|(facet, parent)| parent_facet[*facet] = parent);
        }
        Ok(Self { mesh, parent_cell: parents, parent_facet, parent_nodes: new_nodes })
    }
}

/// The tetrahedra of several bodies, before and after they are halved.
#[derive(Clone, Debug)]
pub struct Tets {
    /// The tetrahedra of each body.
    pub bodies: Vec<BodyTets>,
    /// The order of their edges.
    pub order: EdgeOrder,
}

impl Tets {
    /// Takes meshes that are to be refined.
    ///
    /// * `order`: of their edges.
    pub fn of(meshes: &[&TetMesh], order: &EdgeOrder) -> Self {
        let of_mesh = |mesh: &&TetMesh| BodyTets {
            cells: mesh.cells().to_vec(),
            faces: mesh.topology().cell_facets().to_vec(),
            parents: (0..mesh.cells().len() as u32).collect(),
            new_nodes: Vec::new(),
        };
        Self { bodies: meshes.iter().map(of_mesh).collect(), order: order.clone() }
    }

    /// Counts the nodes of all bodies.
    pub fn nodes(&self) -> usize {
        self.order.representatives.iter().map(Vec::len).sum()
    }

    /// Lists the cells of each body that lie in given ones of the mesh that is refined.
    pub fn descendants(&self, cells: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let of_body = |(tets, cells): (&BodyTets, &Vec<u32>)| descendants(&tets.parents, cells);
        self.bodies.iter().zip(cells).map(of_body).collect()
    }

    /// Halves the marked cells of each body, and then all that have a halved edge.
    ///
    /// * `marked`: cells of each body.
    #[must_use]
    pub fn halved(&self, marked: &[Vec<u32>]) -> Self {
        let mut all = AllTets::of(self);
        let cells = starts(&self.bodies.iter().map(|tets| tets.cells.len()).collect::<Vec<_>>());
        for (body, of) in marked.iter().enumerate() {
            for cell in of {
                all.halve((cells[body] + *cell as usize) as u32);
            }
        }
        all.close();
        all.by_body(self)
    }
}

/// Lists the cells that lie in given ones.
///
/// * `parents`: the old cell that each one lies in.
pub fn descendants(parents: &[u32], cells: &[u32]) -> Vec<u32> {
    let wanted: HashSet<u32> = cells.iter().copied().collect();
    let numbered = (0..).zip(parents).filter(|(_, parent)| wanted.contains(*parent));
    numbered.map(|(cell, _)| cell).collect()
}

/// One tetrahedron of any body.
#[derive(Clone, Copy)]
struct Tet {
    body: u32,
    corners: [u32; 4],
    faces: [FacetId; 4],
    parent: u32,
    is_cut: bool,
}

/// The tetrahedra of all bodies in one array, and their nodes likewise.
struct AllTets {
    tets: Vec<Tet>,
    /// The representative of each node.
    of: Vec<u32>,
    places: Vec<Vector>,
    /// A list of the nodes of each representative: its first, and the one after each.
    first_node: Vec<u32>,
    next_node: Vec<u32>,
    /// A list of the tetrahedra around each node: its last entry, and for each entry the tetrahedron and the entry before it.
    around: Vec<u32>,
    entries: Vec<[u32; 2]>,
    /// The representative in the middle of each halved edge, by those of its ends.
    halved: HashMap<[u32; 2], u32>,
    /// The node in the middle, by the nodes at the ends.
    middle: HashMap<[u32; 2], u32>,
    /// The body and the ends of each new node.
    new_nodes: Vec<(u32, [u32; 2])>,
    waiting: Vec<u32>,
}

/// Sorts two numbers.
fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl AllTets {
    fn of(tets: &Tets) -> Self {
        let order = &tets.order;
        let of = order.representatives.concat();
        let nodes = starts(&order.representatives.iter().map(Vec::len).collect::<Vec<_>>());
        let mut all = Self {
            tets: Vec::new(),
            first_node: vec![NONE; order.places.len()],
            next_node: vec![NONE; of.len()],
            around: vec![NONE; of.len()],
            of,
            places: order.places.clone(),
            entries: Vec::new(),
            halved: HashMap::new(),
            middle: HashMap::new(),
            new_nodes: Vec::new(),
            waiting: Vec::new(),
        };
        for node in 0..all.of.len() {
            let first = &mut all.first_node[all.of[node] as usize];
            all.next_node[node] = std::mem::replace(first, node as u32);
        }
        for (body, tets) in tets.bodies.iter().enumerate() {
            for ((cell, faces), parent) in tets.cells.iter().zip(&tets.faces).zip(&tets.parents) {
                let corners = cell.map(|node| (nodes[body] + node.index()) as u32);
                all.add(Tet { body: body as u32, corners, faces: *faces, parent: *parent, is_cut: false });
            }
        }
        all
    }

    /// Adds a tetrahedron.
    fn add(&mut self, tet: Tet) -> u32 {
        let number = self.tets.len() as u32;
        self.tets.push(tet);
        for node in tet.corners {
            let last = &mut self.around[node as usize];
            self.entries.push([number, std::mem::replace(last, self.entries.len() as u32)]);
        }
        number
    }

    /// Returns the representatives of the ends of an edge, ascending.
    fn key(&self, ends: [u32; 2]) -> [u32; 2] {
        ascending(ends.map(|node| self.of[node as usize]))
    }

    /// Finds the largest edge of a tetrahedron, by its corners.
    fn largest(&self, corners: &[u32; 4]) -> [usize; 2] {
        let rank = |ends: &[usize; 2]| {
            let [r, s] = self.key(ends.map(|k| corners[k]));
            let squared = (self.places[r as usize] - self.places[s as usize]).norm_squared();
            (rounded(squared), r, s)
        };
        let larger = |a: &[usize; 2], b: &[usize; 2]| -> Ordering { rank(a).cmp(&rank(b)) };
        EDGES.into_iter().max_by(larger).unwrap_or(EDGES[0])
    }

    /// Cuts a tetrahedron in two at its largest edge.
    fn halve(&mut self, number: u32) {
        let tet = self.tets[number as usize];
        if tet.is_cut {
            return;
        }
        let [i, j] = self.largest(&tet.corners);
        let ends = [i, j].map(|k| tet.corners[k]);
        let middle = self.middle(tet.body, ends);
        self.tets[number as usize].is_cut = true;
        for (replaced, kept) in [(j, i), (i, j)] {
            let mut half = tet;
            half.corners[replaced] = middle;
            // The face between the halves is opposite to the corner that is kept.
            half.faces[opposite(kept)] = FacetId::NONE;
            let half = self.add(half);
            self.waiting.push(half);
        }
    }

    /// Returns the node in the middle of an edge of a body, and creates it if necessary.
    fn middle(&mut self, body: u32, ends: [u32; 2]) -> u32 {
        let ends = ascending(ends);
        if let Some(node) = self.middle.get(&ends) {
            return *node;
        }
        let key = self.key(ends);
        let representative = match self.halved.get(&key) {
            Some(found) => *found,
            None => {
                let [x, y] = key.map(|r| self.places[r as usize]);
                let new = self.places.len() as u32;
                self.places.push(0.5 * (x + y));
                self.first_node.push(NONE);
                self.halved.insert(key, new);
                self.wake(key);
                new
            }
        };
        let node = self.of.len() as u32;
        self.of.push(representative);
        let first = &mut self.first_node[representative as usize];
        self.next_node.push(std::mem::replace(first, node));
        self.around.push(NONE);
        self.new_nodes.push((body, ends));
        self.middle.insert(ends, node);
        node
    }

    /// Lists all tetrahedra of an edge of any body as waiting.
    fn wake(&mut self, [r, s]: [u32; 2]) {
        let mut node = self.first_node[r as usize];
        while node != NONE {
            let mut entry = self.around[node as usize];
            while entry != NONE {
                let [tet, before] = self.entries[entry as usize];
                let Tet { corners, is_cut, .. } = self.tets[tet as usize];
                if !is_cut && corners.iter().any(|corner| self.of[*corner as usize] == s) {
                    self.waiting.push(tet);
                }
                entry = before;
            }
            node = self.next_node[node as usize];
        }
    }

    /// Cuts until no tetrahedron has a halved edge.
    fn close(&mut self) {
        while let Some(number) = self.waiting.pop() {
            let tet = &self.tets[number as usize];
            if !tet.is_cut
                && edges(&tet.corners).iter().any(|ends| self.halved.contains_key(&self.key(*ends)))
            {
                self.halve(number);
            }
        }
    }

    /// Sorts nodes and tetrahedra by bodies.
    fn by_body(self, before: &Tets) -> Tets {
        let mut order = EdgeOrder { places: self.places, ..before.order.clone() };
        let counts: Vec<usize> = order.representatives.iter().map(Vec::len).collect();
        let mut number: Vec<NodeId> = counts.iter().flat_map(|count| (0..*count).map(NodeId::new)).collect();
        let old = number.len();
        let mut bodies: Vec<BodyTets> = before
            .bodies
            .iter()
            .map(|tets| BodyTets {
                cells: Vec::new(),
                faces: Vec::new(),
                parents: Vec::new(),
                new_nodes: tets.new_nodes.clone(),
            })
            .collect();
        for ((body, ends), of) in self.new_nodes.iter().zip(&self.of[old..]) {
            let body = *body as usize;
            number.push(NodeId::new(order.representatives[body].len()));
            order.representatives[body].push(*of);
            bodies[body].new_nodes.push(ends.map(|node| number[node as usize]));
        }
        for tet in self.tets.iter().filter(|tet| !tet.is_cut) {
            let body = &mut bodies[tet.body as usize];
            body.cells.push(tet.corners.map(|node| number[node as usize]));
            body.faces.push(tet.faces);
            body.parents.push(tet.parent);
        }
        Tets { bodies, order }
    }
}

/// Returns the face of a tetrahedron opposite to a corner.
fn opposite(corner: usize) -> usize {
    (0..4).find(|k| !Solid::facet(*k).contains(&corner)).unwrap_or(corner)
}

/// Rounds a positive number to about 10 digits, such that the results have the order of the numbers.
fn rounded(positive: f64) -> u64 {
    (positive.to_bits() + (1 << (ROUNDED - 1))) >> ROUNDED
}

/// Computes `12 (3V)^(2/3) / Σ l²`, with the volume and the lengths of the edges: 1 for a regular tetrahedron, 0 for a flat one.
#[cfg(test)]
pub(crate) fn quality(corners: &[Vector; 4]) -> f64 {
    let squared: f64 = edges(corners).iter().map(|[a, b]| (b - a).norm_squared()).sum();
    let volume = Solid::measure(corners);
    12.0 * (3.0 * volume).cbrt().powi(2).copysign(volume) / squared
}

#[cfg(test)]
mod tests;

//! Numbers on the edges of a mesh that count how often a path runs through its holes.
//!
//! A *cocycle* gives each edge from `a` to `b` a number with `c(ab) + c(bc) = c(ac)` on every triangle, and `c(ba) = −c(ab)`. Its sum along a
//! closed path depends only on the holes that the path runs around. Differences `f(b) − f(a)` of a function of the nodes are cocycles that count
//! nothing; the others have as many dimensions as there are holes, in space those that go through the body.

use fem_core::mesh::Mesh;
use fem_core::mesh::id::NodeId;
use fem_core::space::Space;
use nalgebra::{DMatrix, DVector};

/// More free edges than this are not followed: the mesh is not understood.
const MOST_FREE: usize = 64;

/// An eigenvalue of sums of squares of whole numbers below this fraction of the largest one is zero.
const ZERO: f64 = 1e-9;

/// Sets of numbers that are joined step by step.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    /// Creates `count` sets of one number each.
    pub(super) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Finds the number that names the set of a number.
    pub(super) fn name(&mut self, mut number: usize) -> usize {
        while self.0[number] as usize != number {
            self.0[number] = self.0[self.0[number] as usize];
            number = self.0[number] as usize;
        }
        number
    }

    /// Joins the sets of two numbers; returns false if they were one before.
    pub(super) fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.name(a), self.name(b));
        self.0[a.max(b)] = a.min(b) as u32;
        a != b
    }
}

/// A basis of the cocycles of a mesh, apart from differences of functions of the nodes.
#[derive(Clone, Debug)]
pub(super) struct Cocycles {
    /// Edges from the smaller to the larger node, ascending.
    edges: Vec<[NodeId; 2]>,
    /// The values of each cocycle on the edges.
    values: Vec<Vec<f64>>,
}

impl Cocycles {
    /// Creates the cocycles of a mesh without holes: none.
    pub(super) fn none() -> Self {
        Self { edges: Vec::new(), values: Vec::new() }
    }

    /// Finds a basis: zero on a tree of edges; the triangles determine other edges, and each edge that they leave free starts another unknown.
    /// Triangles of which all edges are known are the equations of the unknowns. `None` if there are too many unknowns.
    pub(super) fn new<S: Space>(mesh: &Mesh<S>) -> Option<Self> {
        let net = Net::new(mesh);
        let (free, values) = net.follow(mesh.points().len())?;
        let mut equations = DMatrix::<f64>::zeros(free, free);
        let is_free = |edge: &u32| !values[*edge as usize].is_empty();
        for triangle in net.triangles.iter().filter(|triangle| triangle.iter().any(is_free)) {
            let mut row = DVector::<f64>::zeros(free);
            for (edge, sign) in triangle.iter().zip(SIGNS) {
                values[*edge as usize]
                    .iter()
                    .zip(row.iter_mut())
                    .for_each(|(value, sum)| *sum += sign * value);
            }
            if row.amax() > 0.0 {
                equations += &row * row.transpose();
            }
        }
        let eigen = equations.symmetric_eigen();
        let largest = eigen.eigenvalues.iter().fold(1.0, |most: f64, value| most.max(*value));
        let basis = (0..free).filter(|k| eigen.eigenvalues[*k] <= ZERO * largest);
        let on_edge = |value: &Vec<f64>, k: usize| -> f64 {
            value.iter().zip(eigen.eigenvectors.column(k).iter()).map(|(value, factor)| value * factor).sum()
        };
        let values = basis.map(|k| values.iter().map(|value| on_edge(value, k)).collect()).collect();
        Some(Self { edges: net.edges, values })
    }

    /// Returns how many there are.
    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns the number that cocycle `k` gives the edge from `a` to `b`.
    pub(super) fn along(&self, k: usize, a: NodeId, b: NodeId) -> f64 {
        match self.edges.binary_search(&[a.min(b), a.max(b)]) {
            Ok(edge) if a < b => self.values[k][edge],
            Ok(edge) => -self.values[k][edge],
            Err(_) => 0.0,
        }
    }
}

/// The signs of the edges `ab`, `bc`, `ac` of a triangle in its equation.
const SIGNS: [f64; 3] = [1.0, 1.0, -1.0];

/// The edges and the triangles of a mesh.
struct Net {
    edges: Vec<[NodeId; 2]>,
    /// The edges `ab`, `bc`, `ac` of each triangle, `a < b < c`.
    triangles: Vec<[u32; 3]>,
    /// The triangles of edge `e` are `around[starts[e]..starts[e + 1]]`.
    starts: Vec<u32>,
    around: Vec<u32>,
}

impl Net {
    fn new<S: Space>(mesh: &Mesh<S>) -> Self {
        let (mut edges, mut corners) = (Vec::new(), Vec::new());
        for cell in mesh.cells() {
            let mut nodes: Vec<NodeId> = cell.into_iter().collect();
            nodes.sort_unstable();
            for (k, c) in nodes.iter().enumerate() {
                for (j, b) in nodes[..k].iter().enumerate() {
                    edges.push([*b, *c]);
                    corners.extend(nodes[..j].iter().map(|a| [*a, *b, *c]));
                }
            }
        }
        edges.sort_unstable();
        edges.dedup();
        corners.sort_unstable();
        corners.dedup();
        let place = |a: NodeId, b: NodeId| edges.binary_search(&[a, b]).unwrap_or_default() as u32;
        let triangles: Vec<[u32; 3]> =
            corners.into_iter().map(|[a, b, c]| [place(a, b), place(b, c), place(a, c)]).collect();
        let mut starts = vec![0u32; edges.len() + 1];
        triangles.iter().flatten().for_each(|edge| starts[*edge as usize + 1] += 1);
        (0..edges.len()).for_each(|e| starts[e + 1] += starts[e]);
        let mut next = starts.clone();
        let mut around = vec![0; 3 * triangles.len()];
        for (t, edge) in triangles.iter().enumerate().flat_map(|(t, edges)| edges.map(|edge| (t, edge))) {
            around[next[edge as usize] as usize] = t as u32;
            next[edge as usize] += 1;
        }
        Self { edges, triangles, starts, around }
    }

    /// Finds the value of each edge in terms of the free edges, and the number of these; trailing zeros are left out.
    fn follow(&self, nodes: usize) -> Option<(usize, Vec<Vec<f64>>)> {
        let mut values: Vec<Vec<f64>> = vec![Vec::new(); self.edges.len()];
        let mut known = self.tree(nodes);
        let mut waiting: Vec<u32> = (0..self.edges.len() as u32).filter(|e| known[*e as usize]).collect();
        let (mut free, mut next) = (0, 0);
        loop {
            while let Some(edge) = waiting.pop() {
                let around = self.starts[edge as usize] as usize..self.starts[edge as usize + 1] as usize;
                for triangle in self.around[around].iter().map(|t| self.triangles[*t as usize]) {
                    let mut unknown = (0..3).filter(|k| !known[triangle[*k] as usize]);
                    if let (Some(k), None) = (unknown.next(), unknown.next()) {
                        let value = |j: usize| (&values[triangle[j] as usize], -SIGNS[j] * SIGNS[k]);
                        let sum = sum(value((k + 1) % 3), value((k + 2) % 3));
                        values[triangle[k] as usize] = sum;
                        known[triangle[k] as usize] = true;
                        waiting.push(triangle[k]);
                    }
                }
            }
            let Some(edge) = (next..known.len()).find(|e| !known[*e]) else { return Some((free, values)) };
            if free == MOST_FREE {
                return None;
            }
            next = edge;
            values[edge] = vec![0.0; free + 1];
            values[edge][free] = 1.0;
            free += 1;
            known[edge] = true;
            waiting.push(edge as u32);
        }
    }

    /// Marks the edges of a tree in each connected part, grown in breadth from its smallest node.
    fn tree(&self, nodes: usize) -> Vec<bool> {
        let mut beside = vec![Vec::new(); nodes];
        for (e, [a, b]) in self.edges.iter().enumerate() {
            beside[a.index()].push((e, b.index()));
            beside[b.index()].push((e, a.index()));
        }
        let (mut reached, mut marked) = (vec![false; nodes], vec![false; self.edges.len()]);
        for root in 0..nodes {
            let mut row = if std::mem::replace(&mut reached[root], true) { Vec::new() } else { vec![root] };
            while !row.is_empty() {
                let mut further = Vec::new();
                for (edge, node) in row.into_iter().flat_map(|node: usize| &beside[node]) {
                    if !std::mem::replace(&mut reached[*node], true) {
                        marked[*edge] = true;
                        further.push(*node);
                    }
                }
                row = further;
            }
        }
        marked
    }
}

/// Adds multiples of two rows of different lengths; without trailing zeros.
fn sum((a, first): (&Vec<f64>, f64), (b, second): (&Vec<f64>, f64)) -> Vec<f64> {
    let at = |row: &Vec<f64>, k: usize| row.get(k).copied().unwrap_or(0.0);
    let mut sum: Vec<f64> = (0..a.len().max(b.len())).map(|k| first * at(a, k) + second * at(b, k)).collect();
    while sum.last() == Some(&0.0) {
        sum.pop();
    }
    sum
}

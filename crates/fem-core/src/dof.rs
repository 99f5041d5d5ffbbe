//! The unknowns of a body: node frames, imposed values, and their number in the order of elimination.

use crate::body::{Body, NodeConstraint};
use crate::cholesky::Front;
use crate::geometry::{PARALLEL, Vector, add, dot, perpendicular, scale};
use crate::interface::InterfaceSide;
use crate::ordering::{self, ROOT};

/// Number of an imposed component in [`DofMap::number`].
pub const IMPOSED: u32 = u32::MAX;

/// Maps displacement components to unknowns.
///
/// Each node has an orthonormal frame `(a, a⊥)`: Cartesian, or rotated into the direction of a roller or
/// of the contact normal. A contact node with normal `n` that is fixed along `d`, not perpendicular to `n`, has the
/// frame dual to the two: `e₀·n = e₁·d = 1`, `e₀·d = e₁·n = 0`. Its unknown is also the normal trace `u·n`, and its
/// force is that of a pressure along `n`. Unknowns are numbered in the order of elimination, the interface's normal
/// unknowns last, in the order of the pairs.
#[derive(Clone, Debug)]
pub struct DofMap {
    axes: Vec<Vector>,
    /// The second axes of the nodes whose frame is not orthogonal, by node.
    oblique: Vec<(u32, Vector)>,
    numbers: Vec<[u32; 2]>,
    imposed: Vec<[f64; 2]>,
    /// 2·node + component of every unknown.
    unknowns: Vec<u32>,
    interface: usize,
    fronts: Vec<Front>,
}

impl DofMap {
    /// Numbers the unknowns of a body whose interface is `side` (empty for a body alone).
    pub fn new(body: &Body, side: &InterfaceSide) -> Self {
        let nodes = body.mesh().points().len();
        let Frames { axes, oblique, fixed, imposed, contact } = Frames::new(body, side);
        let mut numbers = vec![[IMPOSED; 2]; nodes];
        let mut unknowns = Vec::with_capacity(2 * nodes);
        let mut give = |node: usize, c: usize, unknowns: &mut Vec<u32>| {
            if !fixed[node][c] {
                numbers[node][c] = unknowns.len() as u32;
                unknowns.push((2 * node + c) as u32);
            }
        };
        let dissection = ordering::dissect(body.mesh());
        let mut fronts = Fronts::default();
        for part in &dissection.parts {
            for &node in &dissection.order[part.nodes.clone()] {
                let node = node as usize;
                if !contact[node] {
                    give(node, 0, &mut unknowns);
                }
                give(node, 1, &mut unknowns);
            }
            fronts.part(part.parent, unknowns.len());
        }
        let interior = unknowns.len();
        for &node in &side.nodes {
            give(node as usize, 0, &mut unknowns);
        }
        let interface = unknowns.len() - interior;
        let fronts = fronts.finish(interior, interface);
        Self { axes, oblique, numbers, imposed, unknowns, interface, fronts }
    }

    /// Returns the number of unknowns.
    pub fn len(&self) -> usize {
        self.unknowns.len()
    }

    /// Tells whether all displacements are imposed.
    pub fn is_empty(&self) -> bool {
        self.unknowns.is_empty()
    }

    /// Returns the fronts of the factorisation, the interface last.
    pub fn fronts(&self) -> &[Front] {
        &self.fronts
    }

    /// Returns the number of interface unknowns, the last ones.
    pub fn interface_len(&self) -> usize {
        self.interface
    }

    /// Returns the unknown of component `c` in the node's frame, or [`IMPOSED`].
    pub fn number(&self, node: usize, c: usize) -> u32 {
        self.numbers[node][c]
    }

    /// Returns the imposed value of component `c` in the node's frame; 0 for an unknown.
    pub fn imposed(&self, node: usize, c: usize) -> f64 {
        self.imposed[node][c]
    }

    /// Returns node and component of an unknown.
    pub fn unknown(&self, number: usize) -> (usize, usize) {
        let code = self.unknowns[number] as usize;
        (code / 2, code % 2)
    }

    /// Returns axis `c` of a node's frame: displacements are sums of them, forces act along them.
    pub fn axis(&self, node: usize, c: usize) -> Vector {
        if c == 0 {
            return self.axes[node];
        }
        if !self.oblique.is_empty()
            && let Ok(place) = self.oblique.binary_search_by_key(&(node as u32), |o| o.0)
        {
            return self.oblique[place].1;
        }
        perpendicular(self.axes[node])
    }

    /// Tells whether a node's frame is the Cartesian one.
    pub fn is_cartesian(&self, node: usize) -> bool {
        self.axes[node] == [1.0, 0.0]
    }

    /// Expands unknowns into nodal displacements in Cartesian components, imposed values included.
    pub fn displacement(&self, x: &[f64]) -> Vec<Vector> {
        self.expand(x, 1.0)
    }

    /// Expands unknowns into a nodal correction, which vanishes where displacements are imposed.
    pub fn correction(&self, x: &[f64]) -> Vec<Vector> {
        self.expand(x, 0.0)
    }

    fn expand(&self, x: &[f64], imposed_factor: f64) -> Vec<Vector> {
        let value = |node: usize, c: usize| match self.numbers[node][c] {
            IMPOSED => imposed_factor * self.imposed[node][c],
            number => x[number as usize],
        };
        (0..self.numbers.len())
            .map(|node| {
                let local = [value(node, 0), value(node, 1)];
                if self.is_cartesian(node) {
                    return local;
                }
                add(scale(local[0], self.axis(node, 0)), scale(local[1], self.axis(node, 1)))
            })
            .collect()
    }
}

/// The frames of all nodes, and the values imposed along their axes.
struct Frames {
    axes: Vec<Vector>,
    oblique: Vec<(u32, Vector)>,
    fixed: Vec<[bool; 2]>,
    imposed: Vec<[f64; 2]>,
    /// Whether the node is one of the interface.
    contact: Vec<bool>,
}

impl Frames {
    fn new(body: &Body, side: &InterfaceSide) -> Self {
        let nodes = body.mesh().points().len();
        let mut axes = vec![[1.0, 0.0]; nodes];
        let mut fixed = vec![[false; 2]; nodes];
        let mut imposed = vec![[0.0; 2]; nodes];
        let mut contact = vec![false; nodes];
        let mut oblique = Vec::new();
        for (&node, &normal) in side.nodes.iter().zip(&side.normals) {
            axes[node as usize] = normal;
            contact[node as usize] = true;
        }
        for (node, constraint) in body.node_constraints().iter().enumerate() {
            match *constraint {
                NodeConstraint::Free => {}
                NodeConstraint::Along { direction, value } if contact[node] => {
                    fixed[node][1] = true;
                    let tangent = perpendicular(axes[node]);
                    let along = dot(direction, tangent);
                    if dot(direction, axes[node]).abs() <= PARALLEL {
                        imposed[node][1] = value * along.signum();
                        continue;
                    }
                    // The pairing has checked that the support is far enough from the normal.
                    let free = perpendicular(direction);
                    axes[node] = scale(1.0 / dot(free, axes[node]), free);
                    oblique.push((node as u32, scale(1.0 / along, tangent)));
                    imposed[node][1] = value;
                }
                NodeConstraint::Along { direction, value } => {
                    axes[node] = direction;
                    fixed[node][0] = true;
                    imposed[node][0] = value;
                }
                NodeConstraint::Fixed { value } => {
                    axes[node] = [1.0, 0.0];
                    fixed[node] = [true; 2];
                    imposed[node] = value;
                }
            }
        }
        Self { axes, oblique, fixed, imposed, contact }
    }
}

/// Turns the tree of parts into fronts: parts without unknowns disappear.
#[derive(Default)]
struct Fronts {
    fronts: Vec<Front>,
    /// The front of each part; for an empty one that of the parent is used.
    front_of: Vec<Option<u32>>,
    parents: Vec<u32>,
    end: usize,
}

impl Fronts {
    /// Takes the next part, whose unknowns end at `end`.
    fn part(&mut self, parent: u32, end: usize) {
        let number = (end > self.end).then_some(self.fronts.len() as u32);
        if number.is_some() {
            self.fronts.push(Front { columns: self.end as u32..end as u32, parent: ROOT });
        }
        self.front_of.push(number);
        self.parents.push(parent);
        self.end = end;
    }

    /// Adds the front of the interface and joins the fronts to a tree.
    fn finish(mut self, interior: usize, interface: usize) -> Vec<Front> {
        let root = if interface > 0 { self.fronts.len() as u32 } else { ROOT };
        for (part, front) in self.front_of.iter().enumerate() {
            let Some(front) = front else { continue };
            // Climb over parts without unknowns.
            let mut above = self.parents[part];
            while above != ROOT && self.front_of[above as usize].is_none() {
                above = self.parents[above as usize];
            }
            let parent = if above == ROOT { None } else { self.front_of[above as usize] };
            self.fronts[*front as usize].parent = parent.unwrap_or(root);
        }
        if interface > 0 {
            let columns = interior as u32..(interior + interface) as u32;
            self.fronts.push(Front { columns, parent: ROOT });
        }
        self.fronts
    }
}

//! A fill-reducing order of elimination: nested dissection by coordinates (George 1973).
//!
//! The mesh is cut recursively at the median of its longer direction; the nodes on a cut are eliminated
//! after both halves. The tree of cuts is the tree of fronts of the factorisation.

use crate::geometry::Vector;
use crate::mesh::TriMesh;
use crate::mesh::id::NodeId;
use std::ops::Range;

/// Parts of at most this many nodes are not cut further: one dense front costs less than more, smaller ones.
const LEAF: usize = 12;

/// Means 'no parent'.
pub const ROOT: u32 = u32::MAX;

/// A set of nodes eliminated together: the nodes of a cut, or of a part too small to cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its nodes, as a range of [`Dissection::order`].
    pub nodes: Range<usize>,
    /// The part that the next cut above belongs to, or [`ROOT`]; always later in the list.
    pub parent: u32,
}

/// An order of elimination and its tree, children before parents and each subtree contiguous.
#[derive(Clone, Debug, Default)]
pub struct Dissection {
    /// The nodes in the order of elimination.
    pub order: Vec<NodeId>,
    /// The parts, consecutive in `order`.
    pub parts: Vec<Part>,
}

/// Orders the nodes of a mesh for elimination.
pub fn dissect(mesh: &TriMesh) -> Dissection {
    let (starts, neighbours) = mesh.topology().node_neighbours();
    let points = mesh.points();
    let extents = mesh.topology().facets().iter().map(|[a, b]| (points[*a] - points[*b]).abs());
    let reach = extents.fold(Vector::zeros(), |most, extent| most.sup(&extent));
    let mut nodes: Vec<NodeId> = (0..mesh.points().len()).map(NodeId::new).collect();
    let mut work = Work {
        points,
        reach,
        starts: &starts,
        neighbours: &neighbours,
        side: vec![Side::Outside; nodes.len()],
        result: Dissection { order: Vec::with_capacity(nodes.len()), parts: Vec::new() },
    };
    work.cut(&mut nodes);
    work.result
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outside,
    Left,
    Right,
    Separator,
}

struct Work<'a> {
    points: &'a [Vector],
    /// The largest extent of an edge along each axis.
    reach: Vector,
    starts: &'a [u32],
    neighbours: &'a [NodeId],
    side: Vec<Side>,
    result: Dissection,
}

impl Work<'_> {
    fn touches(&self, node: NodeId, side: Side) -> bool {
        let around = self.starts[node] as usize..self.starts[node.index() + 1] as usize;
        self.neighbours[around].iter().any(|&m| self.side[m] == side)
    }

    /// Cuts a part and everything in it; returns the roots of its subtrees.
    fn cut(&mut self, part: &mut [NodeId]) -> Vec<u32> {
        if part.len() <= LEAF {
            return vec![self.finish(part, &[])];
        }
        let [low, high] = part.iter().fold([self.points[part[0]]; 2], |[low, high], &n| {
            let point = &self.points[n];
            [low.inf(point), high.sup(point)]
        });
        let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
        let points = self.points;
        let coordinate = |n: NodeId| points[n][axis];
        let middle = part.len() / 2;
        let (_, &mut median, _) = part
            .select_nth_unstable_by(middle, |a, b| coordinate(*a).total_cmp(&coordinate(*b)).then(a.cmp(b)));
        // Nodes on the median line all go to one side, which makes a grid line a clean cut.
        let line = coordinate(median);
        let is_left = |n: NodeId| if line > low[axis] { coordinate(n) < line } else { coordinate(n) <= line };
        for &n in part.iter() {
            self.side[n] = if is_left(n) { Side::Left } else { Side::Right };
        }
        let border = |from: Side, to: Side| -> Vec<NodeId> {
            let is_near = |n: NodeId| (coordinate(n) - line).abs() <= self.reach[axis];
            let on = |n: &NodeId| self.side[*n] == from && is_near(*n) && self.touches(*n, to);
            part.iter().copied().filter(on).collect()
        };
        let (on_left, on_right) = (border(Side::Left, Side::Right), border(Side::Right, Side::Left));
        let mut separator = if on_left.len() < on_right.len() { on_left } else { on_right };
        separator
            .sort_unstable_by(|a, b| points[*a][1 - axis].total_cmp(&points[*b][1 - axis]).then(a.cmp(b)));
        for &n in &separator {
            self.side[n] = Side::Separator;
        }
        let of = |side: Side| part.iter().copied().filter(|n| self.side[*n] == side).collect();
        let (mut left, mut right): (Vec<NodeId>, Vec<NodeId>) = (of(Side::Left), of(Side::Right));
        for &n in part.iter() {
            self.side[n] = Side::Outside;
        }
        if separator.is_empty() && (left.is_empty() || right.is_empty()) {
            // All nodes lie on one line without being joined across it: a cut gains nothing.
            return vec![self.finish(part, &[])];
        }
        let mut roots = Vec::new();
        for half in [&mut left, &mut right] {
            if !half.is_empty() {
                roots.extend(self.cut(half));
            }
        }
        if separator.is_empty() { roots } else { vec![self.finish(&separator, &roots)] }
    }

    /// Appends a part above its children.
    fn finish(&mut self, nodes: &[NodeId], children: &[u32]) -> u32 {
        let number = self.result.parts.len() as u32;
        for &child in children {
            self.result.parts[child as usize].parent = number;
        }
        let start = self.result.order.len();
        self.result.order.extend_from_slice(nodes);
        self.result.parts.push(Part { nodes: start..self.result.order.len(), parent: ROOT });
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::block;

    #[test]
    fn order_is_a_permutation_and_parts_are_separated() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [40, 20]).unwrap();
        let d = dissect(&mesh);
        let mut sorted = d.order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..mesh.points().len()).map(NodeId::new).collect::<Vec<_>>());
        // Joined nodes lie in one part, or one lies in a part above the other's.
        let mut part_of = vec![0u32; d.order.len()];
        for (k, part) in d.parts.iter().enumerate() {
            assert!(part.parent == ROOT || part.parent as usize > k);
            for &n in &d.order[part.nodes.clone()] {
                part_of[n] = k as u32;
            }
        }
        for [a, b] in mesh.topology().facets() {
            let (low, high) = (part_of[*a], part_of[*b]);
            let (mut k, top) = (low.min(high), low.max(high));
            while k < top {
                k = d.parts[k as usize].parent;
            }
            assert_eq!(k, top);
        }
    }

    #[test]
    fn tiny_and_degenerate_meshes_are_ordered() {
        for cells in [[1, 1], [1, 400], [400, 1]] {
            let mesh = block([0.0, 0.0], [1.0, 1.0], cells).unwrap();
            assert_eq!(dissect(&mesh).order.len(), mesh.points().len());
        }
    }
}

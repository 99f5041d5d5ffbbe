//! A fill-reducing order of elimination: nested dissection by coordinates (George 1973).
//!
//! The mesh is cut recursively at the median of its longest direction; the nodes on a cut are eliminated
//! after both halves. The tree of cuts is the tree of fronts of the factorisation.

use crate::mesh::Mesh;
use crate::mesh::id::NodeId;
use crate::space::Space;
use std::cmp::Ordering;
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
pub fn dissect<S: Space>(mesh: &Mesh<S>) -> Dissection {
    let (starts, neighbours) = mesh.topology().node_neighbours();
    let points = mesh.points();
    let mut reach = S::Vector::default();
    for facet in mesh.topology().facets() {
        for (k, j) in (0..S::DIM).flat_map(|k| (0..k).map(move |j| (k, j))) {
            let along = points[facet[k]] - points[facet[j]];
            for c in 0..S::DIM {
                reach[c] = reach[c].max(along[c].abs());
            }
        }
    }
    let mut nodes: Vec<NodeId> = (0..mesh.points().len()).map(NodeId::new).collect();
    let mut work = Work::<S> {
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

struct Work<'a, S: Space> {
    points: &'a [S::Vector],
    /// The largest extent of an edge along each axis.
    reach: S::Vector,
    starts: &'a [u32],
    neighbours: &'a [NodeId],
    side: Vec<Side>,
    result: Dissection,
}

impl<S: Space> Work<'_, S> {
    fn touches(&self, node: NodeId, side: Side) -> bool {
        let around = self.starts[node] as usize..self.starts[node.index() + 1] as usize;
        self.neighbours[around].iter().any(|&m| self.side[m] == side)
    }

    /// Cuts a part and everything in it; returns the roots of its subtrees.
    fn cut(&mut self, part: &mut [NodeId]) -> Vec<u32> {
        if part.len() <= LEAF {
            return vec![self.finish(part, &[])];
        }
        let points = self.points;
        let (mut low, mut high) = (points[part[0]], points[part[0]]);
        for n in part.iter() {
            for c in 0..S::DIM {
                low[c] = low[c].min(points[*n][c]);
                high[c] = high[c].max(points[*n][c]);
            }
        }
        let longest =
            |axis: usize, c: usize| if high[c] - low[c] > high[axis] - low[axis] { c } else { axis };
        let axis = (1..S::DIM).fold(0, longest);
        let coordinate = |n: NodeId| points[n][axis];
        let middle = part.len() / 2;
        let (_, &mut median, _) = part
            .select_nth_unstable_by(middle, |a, b| coordinate(*a).total_cmp(&coordinate(*b)).then(a.cmp(b)));
        // Nodes on the median line or plane all go to one side, which makes a line of a grid a clean cut.
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
        separator.sort_unstable_by(|a, b| {
            let others = (0..S::DIM).filter(|c| *c != axis);
            others
                .fold(Ordering::Equal, |order, c| order.then(points[*a][c].total_cmp(&points[*b][c])))
                .then(a.cmp(b))
        });
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
    use crate::mesh::generate::{block, cuboid};

    fn check<S: Space>(mesh: &Mesh<S>) {
        let d = dissect(mesh);
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
        let (starts, neighbours) = mesh.topology().node_neighbours();
        for a in 0..mesh.points().len() {
            for b in &neighbours[starts[a] as usize..starts[a + 1] as usize] {
                let (low, high) = (part_of[a], part_of[*b]);
                let (mut k, top) = (low.min(high), low.max(high));
                while k < top {
                    k = d.parts[k as usize].parent;
                }
                assert_eq!(k, top);
            }
        }
    }

    #[test]
    fn order_is_a_permutation_and_parts_are_separated() {
        check(&block([0.0, 0.0], [2.0, 1.0], [40, 20]).unwrap());
        check(&cuboid([0.0; 3], [2.0, 1.0, 0.7], [9, 8, 7]).unwrap());
    }

    #[test]
    fn a_box_is_cut_across_its_longest_side_first() {
        let mesh = cuboid([0.0; 3], [1.0, 4.0, 1.0], [4, 16, 4]).unwrap();
        let d = dissect(&mesh);
        let top = d.parts.last().unwrap();
        assert_eq!((top.nodes.len(), top.parent), (25, ROOT));
        assert!(d.order[top.nodes.clone()].iter().all(|n| mesh.points()[*n][1] == 2.0));
    }

    #[test]
    fn tiny_and_degenerate_meshes_are_ordered() {
        for cells in [[1, 1], [1, 400], [400, 1]] {
            let mesh = block([0.0, 0.0], [1.0, 1.0], cells).unwrap();
            assert_eq!(dissect(&mesh).order.len(), mesh.points().len());
        }
    }
}

//! Moves nodes of two patches onto close nodes and edges of each other: laid over each other as they are, they would leave flat triangles.
//!
//! The *clearance* of a node is the least distance between the node or its edges and what is close to them in the other patch but not on them, over the
//! lengths of the edges there. A node moves if that makes its clearance larger.

use super::arrangement::{Flat, Patch, TOGETHER, cross, length, minus, mix};
use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};

/// Nodes with this clearance stay.
const CLEAR: f64 = 0.15;
/// A node moves by at most this part of the shortest edge at it and at the node it meets.
const FARTHEST: f64 = 0.2;
/// Nodes are looked at this often.
const SWEEPS: usize = 4;

/// Moves nodes onto nodes and edges of the other patch.
///
/// * `slide`: moves a node of a patch, given by both numbers, in its body, or returns false if it has to stay.
pub(super) fn snap(patches: &mut [Patch; 2], mut slide: impl FnMut([usize; 2], Flat) -> bool) {
    let both = Both::new(patches);
    for _ in 0..SWEEPS {
        let mut moved = false;
        for (b, k) in (0..2).flat_map(|b| (0..both.spacing[b].len()).map(move |k| (b, k))) {
            let now = both.clearance([b, k], both.patches[b].points[k]);
            if now >= CLEAR {
                continue;
            }
            let better = |(apart, to): (f64, Flat)| {
                let then = both.clearance([b, k], to).min(CLEAR);
                (then > now).then_some((then, apart, to))
            };
            let mut targets: Vec<(f64, f64, Flat)> =
                both.targets([b, k]).into_iter().filter_map(better).collect();
            targets.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.total_cmp(&y.1)));
            if let Some((.., to)) = targets.into_iter().find(|(.., to)| slide([b, k], *to)) {
                both.patches[b].points[k] = to;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
}

/// Two patches while their nodes move.
struct Both<'a> {
    patches: &'a mut [Patch; 2],
    /// The shortest edge at each node before nodes moved.
    spacing: [Vec<f64>; 2],
    /// The nodes at the other ends of the edges of each node.
    around: [Vec<Vec<usize>>; 2],
    /// Nodes and edges at their first places.
    nodes: [RTree<GeomWithData<Flat, usize>>; 2],
    edges: [RTree<GeomWithData<Line<Flat>, [usize; 2]>>; 2],
}

impl<'a> Both<'a> {
    fn new(patches: &'a mut [Patch; 2]) -> Self {
        let around = patches.each_ref().map(|patch| {
            let mut around = vec![Vec::new(); patch.points.len()];
            for [a, b] in patch.edges() {
                around[a].push(b);
                around[b].push(a);
            }
            around
        });
        let nodes = patches.each_ref().map(|patch| {
            let node = |(k, at): (usize, &Flat)| GeomWithData::new(*at, k);
            RTree::bulk_load(patch.points.iter().enumerate().map(node).collect())
        });
        let edges = patches.each_ref().map(|patch| {
            let edge = |ends: [usize; 2]| {
                let [p, q] = ends.map(|node| patch.points[node]);
                GeomWithData::new(Line::new(p, q), ends)
            };
            RTree::bulk_load(patch.edges().into_iter().map(edge).collect())
        });
        Self { spacing: patches.each_ref().map(Patch::spacing), patches, around, nodes, edges }
    }

    /// Lists the nodes of the other patch in a box, with their places.
    fn nodes_near(&self, other: usize, low: Flat, high: Flat) -> impl Iterator<Item = (usize, Flat)> + '_ {
        let near = self.nodes[other].locate_in_envelope(&AABB::from_corners(low, high));
        near.map(move |node| (node.data, self.patches[other].points[node.data]))
    }

    /// Lists the edges of the other patch near a node, each with its ends, the distance of the node from it, and the nearest point of it.
    fn edges_near(&self, [b, k]: [usize; 2], at: Flat) -> impl Iterator<Item = ([usize; 2], f64, Flat)> + '_ {
        let (other, reach) = (1 - b, 2.0 * self.spacing[b][k]);
        let around = AABB::from_corners(at.map(|x| x - reach), at.map(|x| x + reach));
        self.edges[other].locate_in_envelope_intersecting(&around).map(move |near| {
            let (apart, foot) = nearest(near.data.map(|node| self.patches[other].points[node]), at);
            (near.data, apart, foot)
        })
    }

    /// Computes the clearance of a node at a place.
    fn clearance(&self, [b, k]: [usize; 2], at: Flat) -> f64 {
        let (other, own) = (1 - b, self.spacing[b][k]);
        let mut least = f64::INFINITY;
        let mut add = |apart: f64, size: f64| {
            if apart > TOGETHER * size {
                least = least.min(apart / size);
            }
        };
        for (ends, apart, _) in self.edges_near([b, k], at) {
            let [p, q] = ends.map(|node| self.patches[other].points[node]);
            add(apart, own.min(length(minus(q, p))));
        }
        for end in &self.around[b][k] {
            let far = self.patches[b].points[*end];
            let margin = 2.0 * FARTHEST * own;
            let low = [at[0].min(far[0]) - margin, at[1].min(far[1]) - margin];
            let high = [at[0].max(far[0]) + margin, at[1].max(far[1]) + margin];
            for (n, place) in self.nodes_near(other, low, high) {
                add(nearest([at, far], place).0, own.min(self.spacing[other][n]));
            }
        }
        least
    }

    /// Lists the places to which a node could move, with the distances: the nodes of the other patch, and the nearest points of its edges.
    fn targets(&self, [b, k]: [usize; 2]) -> Vec<(f64, Flat)> {
        let (at, own, other) = (self.patches[b].points[k], self.spacing[b][k], 1 - b);
        let reach = FARTHEST * own;
        let nodes = self.nodes_near(other, at.map(|x| x - 2.0 * reach), at.map(|x| x + 2.0 * reach));
        let onto_node = nodes.filter_map(|(n, to)| {
            let apart = length(minus(to, at));
            (apart <= FARTHEST * own.min(self.spacing[other][n])).then_some((apart, to))
        });
        let onto_edge = self
            .edges_near([b, k], at)
            .filter_map(|(_, apart, foot)| (apart <= reach.min(CLEAR * own)).then_some((apart, foot)));
        onto_node.chain(onto_edge).filter(|(apart, _)| *apart > TOGETHER * own).collect()
    }
}

/// Returns the distance of a point from a segment, and the nearest point of the segment.
fn nearest([p, q]: [Flat; 2], at: Flat) -> (f64, Flat) {
    let (edge, arm) = (minus(q, p), minus(at, p));
    let size = length(edge);
    let t = (edge[0] * arm[0] + edge[1] * arm[1]) / (size * size);
    match t {
        t if !(t > 0.0) => (length(arm), p),
        t if t >= 1.0 => (length(minus(at, q)), q),
        t => ((cross(edge, arm) / size).abs(), mix(p, q, t)),
    }
}

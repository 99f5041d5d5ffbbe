//! Finds, for each node of the first body's contact surface, the second body's node that faces it.

use super::InterfaceError;
use super::common_refinement::Facing;
use crate::body::Body;
use crate::geometry::{self, Vector, norm};
use std::collections::HashMap;

/// Paired nodes may be this fraction of the local edge length apart if the gap is given.
pub(super) const TOLERANCE: f64 = 0.05;

/// One stretch of the contact line: nodes in order, and the edges between them.
pub(super) struct Stretch {
    pub(super) nodes: Vec<u32>,
    pub(super) edges: Vec<u32>,
}

impl Stretch {
    /// Tells whether the stretch is closed.
    pub(super) fn is_closed(&self) -> bool {
        self.edges.len() == self.nodes.len()
    }
}

/// Collects the stretches of the first body's surface, each from its end with the smaller (x, y).
pub(super) fn walk(body: &Body, surface: &[u32]) -> Vec<Stretch> {
    let mesh = body.mesh();
    let mut around: HashMap<u32, Vec<u32>> = HashMap::new();
    for &edge in surface {
        for node in mesh.topology().edges()[edge as usize] {
            around.entry(node).or_default().push(edge);
        }
    }
    let place = |n: u32| mesh.points()[n as usize];
    let before = |a: &u32, b: &u32| {
        let (p, q) = (place(*a), place(*b));
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(a.cmp(b))
    };
    let mut starts: Vec<u32> = around.keys().copied().collect();
    starts.sort_unstable_by(before);
    // Open stretches begin at an end; the remaining edges form closed ones.
    starts.sort_by_key(|n| around[n].len() > 1);
    let mut used = std::collections::HashSet::new();
    let mut stretches = Vec::new();
    for start in starts {
        let mut stretch = Stretch { nodes: vec![start], edges: Vec::new() };
        let mut node = start;
        while let Some(&edge) = around[&node].iter().find(|e| !used.contains(*e)) {
            used.insert(edge);
            let [a, b] = mesh.topology().edges()[edge as usize];
            node = if a == node { b } else { a };
            stretch.edges.push(edge);
            if node == start {
                break;
            }
            stretch.nodes.push(node);
        }
        if !stretch.edges.is_empty() {
            stretches.push(stretch);
        }
    }
    stretches.sort_by(|a, b| before(&a.nodes[0], &b.nodes[0]));
    stretches
}

/// Finds the second body's node for each node of the first body's surface.
pub(super) fn nearest(
    bodies: [&Body; 2],
    edges: [&[u32]; 2],
    chain: &[Stretch],
) -> Result<HashMap<u32, u32>, InterfaceError> {
    let spacing = [spacings(bodies[0], edges[0]), spacings(bodies[1], edges[1])];
    let first: Vec<u32> = chain.iter().flat_map(|s| s.nodes.iter().copied()).collect();
    let mut second: Vec<u32> = spacing[1].keys().copied().collect();
    second.sort_unstable();
    let mut partner = HashMap::new();
    let mut taken = HashMap::new();
    let grid = Grid::new(bodies[1], &second);
    for node in first {
        let point = bodies[0].mesh().points()[node as usize];
        let local = spacing[0][&node];
        let (other, distance) = grid.nearest(point);
        if distance > TOLERANCE * local.min(spacing[1][&other]) || taken.insert(other, node).is_some() {
            return Err(InterfaceError::NotMatching { body: 0, point, distance, spacing: local });
        }
        partner.insert(node, other);
    }
    if let Some(&node) = second.iter().find(|n| !taken.contains_key(n)) {
        let point = bodies[1].mesh().points()[node as usize];
        let nodes: Vec<u32> = partner.keys().copied().collect();
        let distance = Grid::new(bodies[0], &nodes).nearest(point).1;
        return Err(InterfaceError::NotMatching { body: 1, point, distance, spacing: spacing[1][&node] });
    }
    Ok(partner)
}

/// Uses the partners from a common refinement.
pub(super) fn refined(
    body: &Body,
    chain: &[Stretch],
    facing: &HashMap<u32, &Facing>,
) -> Result<HashMap<u32, u32>, InterfaceError> {
    let mut partner = HashMap::new();
    for stretch in chain {
        for (k, node) in stretch.nodes.iter().enumerate() {
            let Some(found) = facing.get(node) else {
                let edge = stretch.edges[k.min(stretch.edges.len() - 1)];
                return Err(InterfaceError::EdgeWithoutPartner {
                    body: 0,
                    point: body.mesh().edge_middle(edge),
                });
            };
            partner.insert(*node, found.nodes[1]);
        }
    }
    Ok(partner)
}

/// Computes the shortest contact edge at each contact node.
fn spacings(body: &Body, surface: &[u32]) -> HashMap<u32, f64> {
    let mut spacing: HashMap<u32, f64> = HashMap::new();
    for &edge in surface {
        let length = body.mesh().edge_length(edge);
        for node in body.mesh().topology().edges()[edge as usize] {
            let s = spacing.entry(node).or_insert(length);
            *s = s.min(length);
        }
    }
    spacing
}

/// Nodes sorted along the longer direction of their bounding box, for nearest-node queries.
struct Grid {
    axis: usize,
    sorted: Vec<(f64, Vector, u32)>,
}

impl Grid {
    fn new(body: &Body, nodes: &[u32]) -> Self {
        let points: Vec<Vector> = nodes.iter().map(|&n| body.mesh().points()[n as usize]).collect();
        let [low, high] = geometry::bounding_box(&points);
        let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
        let mut sorted: Vec<_> = points.iter().zip(nodes).map(|(p, &n)| (p[axis], *p, n)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        Self { axis, sorted }
    }

    /// Finds the nearest node and its distance; the search widens from the point's own coordinate.
    fn nearest(&self, point: Vector) -> (u32, f64) {
        let start = self.sorted.partition_point(|s| s.0 < point[self.axis]);
        let mut best = (u32::MAX, f64::INFINITY);
        let mut look = |entry: &(f64, Vector, u32)| {
            if (entry.0 - point[self.axis]).abs() > best.1 {
                return false;
            }
            let d = norm(entry.1 - point);
            if d < best.1 {
                best = (entry.2, d);
            }
            true
        };
        for entry in &self.sorted[start..] {
            if !look(entry) {
                break;
            }
        }
        for entry in self.sorted[..start].iter().rev() {
            if !look(entry) {
                break;
            }
        }
        best
    }
}

/// Pairs the surfaces node by node along their length, each stretch with the nearest one, whatever their distance.
pub(super) fn along(
    bodies: [&Body; 2],
    edges: [&[u32]; 2],
    chain: &[Stretch],
) -> Result<HashMap<u32, u32>, InterfaceError> {
    let others = walk(bodies[1], edges[1]);
    let place = |b: usize, node: u32| bodies[b].mesh().points()[node as usize];
    let counts = |point, what, counts| Err(InterfaceError::Counts { point, what, counts });
    if chain.len() != others.len() {
        return counts(place(0, chain[0].nodes[0]), "stretches", [chain.len(), others.len()]);
    }
    let mut free: Vec<Vec<u32>> = Vec::new();
    let mut closed = Vec::new();
    for other in &others {
        let mut nodes = other.nodes.clone();
        // Opposite to the orientation of the first body: the outward normals of the two face each other.
        if is_outward_right(bodies[1], other) {
            nodes.reverse();
        }
        free.push(nodes);
        closed.push(other.is_closed());
    }
    let mut partner = HashMap::new();
    for stretch in chain {
        let mut nodes = stretch.nodes.clone();
        if !is_outward_right(bodies[0], stretch) {
            nodes.reverse();
        }
        let [first, last] = [place(0, nodes[0]), place(0, nodes[nodes.len() - 1])];
        // The fit of each remaining stretch, and its first node.
        let mut best: Option<(f64, usize, usize)> = None;
        for (k, other) in free.iter().enumerate().filter(|(_, other)| !other.is_empty()) {
            let (fit, start) = fit(bodies[1], [first, last], other, closed[k]);
            if best.is_none_or(|b| fit < b.0) {
                best = Some((fit, k, start));
            }
        }
        let Some((_, k, start)) = best else {
            return counts(first, "stretches", [chain.len(), others.len()]);
        };
        let mut other = std::mem::take(&mut free[k]);
        if closed[k] != stretch.is_closed() {
            return counts(first, "closed lines", [stretch.is_closed(), closed[k]].map(usize::from));
        }
        if other.len() != nodes.len() {
            return counts(first, "nodes", [nodes.len(), other.len()]);
        }
        other.rotate_left(start);
        partner.extend(nodes.into_iter().zip(other));
    }
    Ok(partner)
}

/// Measures the distance of a stretch of the other body from one between two points, and finds its first node: for a
/// closed one the node nearest to the first point.
fn fit(body: &Body, [first, last]: [Vector; 2], nodes: &[u32], closed: bool) -> (f64, usize) {
    let distance = |a: Vector, node: u32| norm(body.mesh().points()[node as usize] - a);
    if !closed {
        return (distance(first, nodes[0]) + distance(last, nodes[nodes.len() - 1]), 0);
    }
    let nearest = |best: (f64, usize), (start, &node): (usize, &u32)| {
        let d = distance(first, node);
        if d < best.0 { (d, start) } else { best }
    };
    nodes.iter().enumerate().fold((f64::INFINITY, 0), nearest)
}

/// Tells whether the body's outward normal is on the right of the stretch, that is, the body on its left.
fn is_outward_right(body: &Body, stretch: &Stretch) -> bool {
    let topology = body.mesh().topology();
    let [a, b] = topology.oriented_edge(stretch.edges[0], body.mesh().triangles());
    [a, b] == [stretch.nodes[0], stretch.nodes[1 % stretch.nodes.len()]]
}

//! Finds, for each node of the first body's contact surface, the second body's node that faces it.

use super::common_refinement::{Facing, Measured};
use super::{facet_size, outline};
use fem_core::body::Body;
use fem_core::geometry::{self, Vector, angle_between, norm};
use fem_core::interface::InterfaceError;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Plane, Space};
use std::collections::HashMap;

/// Paired nodes may be this fraction of the local edge length apart if the gap is given.
pub(super) const TOLERANCE: f64 = 0.05;

/// One stretch of the contact line: nodes in order, and the edges between them.
#[derive(Clone, Default)]
pub(super) struct Stretch {
    pub(super) nodes: Vec<NodeId>,
    pub(super) edges: Vec<FacetId>,
    /// For its first and its last node: true at a corner at which another stretch continues.
    pub(super) corners: [bool; 2],
    /// Normals that smooth pieces of the second body give to corners of the first, out of the first.
    pub(super) faced: Vec<(NodeId, Vector)>,
}

impl Stretch {
    /// Tells whether the stretch is closed.
    pub(super) fn is_closed(&self) -> bool {
        self.edges.len() == self.nodes.len()
    }

    /// Tells whether it is a part of a longer stretch, between corners.
    pub(super) fn is_cut(&self) -> bool {
        self.corners != [false; 2]
    }

    /// Returns the two nodes of an edge.
    pub(super) fn ends(&self, edge: usize) -> [NodeId; 2] {
        [edge, edge + 1].map(|k| self.nodes[k % self.nodes.len()])
    }

    /// Divides it at corners, see [`outline::divided`].
    fn divided(self, corners: &[usize]) -> Vec<Self> {
        if corners.is_empty() {
            return vec![self];
        }
        let around = self.nodes.len();
        let part = |([from, to], corners): ([usize; 2], [bool; 2])| Self {
            nodes: (from..=to).map(|k| self.nodes[k % around]).collect(),
            edges: (from..to).map(|k| self.edges[k % self.edges.len()]).collect(),
            corners,
            faced: self.faced.clone(),
        };
        outline::divided(self.edges.len(), self.is_closed(), corners).into_iter().map(part).collect()
    }

    /// Lists the points of its nodes on one body; a closed stretch ends with its first.
    ///
    /// * `nodes`: of that body.
    pub(super) fn points(&self, body: &Body, nodes: &[NodeId]) -> Vec<Vector> {
        let closing = self.is_closed().then(|| nodes[0]);
        nodes.iter().copied().chain(closing).map(|n| body.mesh().points()[n]).collect()
    }
}

/// Ends the stretches at the corners between known pieces of the first body's side, if the second body's side has one there as well, or is not
/// known there. A smooth piece of the second body gives the normal instead.
pub(super) fn ended_at_corners(
    bodies: [&Body; 2],
    chain: Vec<Stretch>,
    partner: &HashMap<NodeId, NodeId>,
) -> Vec<Stretch> {
    if !bodies[0].has_curves() {
        return chain;
    }
    chain.into_iter().flat_map(|stretch| ended(bodies, stretch, partner)).collect()
}

fn ended(bodies: [&Body; 2], mut stretch: Stretch, partner: &HashMap<NodeId, NodeId>) -> Vec<Stretch> {
    let others: Vec<NodeId> = stretch.nodes.iter().map(|n| partner[n]).collect();
    let facing = |k: usize| {
        bodies[1].mesh().topology().find_edge(partner[&stretch.ends(k)[0]], partner[&stretch.ends(k)[1]])
    };
    // Edges without a partner are refused later.
    let Some(facing) = (0..stretch.edges.len()).map(facing).collect::<Option<Vec<FacetId>>>() else {
        return vec![stretch];
    };
    let beside = |b: usize, nodes: &[NodeId], edges: &[FacetId]| {
        let points = stretch.points(bodies[b], nodes);
        let pieces = outline::pieces(bodies[b], edges, &points, false);
        outline::beside(&pieces, &points, |k| bodies[b].mesh().facet_normal(edges[k]), stretch.is_closed())
    };
    let own = beside(0, &stretch.nodes, &stretch.edges);
    let corners: Vec<usize> = (0..stretch.nodes.len()).filter(|k| own[*k].is_corner()).collect();
    if corners.is_empty() {
        return vec![stretch];
    }
    let other = beside(1, &others, &facing);
    let (smooth, corners): (Vec<usize>, Vec<usize>) =
        corners.into_iter().partition(|k| other[*k].is_smooth());
    stretch.faced =
        smooth.into_iter().filter_map(|k| Some((stretch.nodes[k], -other[k].normal()?))).collect();
    stretch.divided(&corners)
}

/// Collects the stretches of the first body's surface, each from its end with the smaller (x, y).
pub(super) fn walk(body: &Body, surface: &[FacetId]) -> Vec<Stretch> {
    let mesh = body.mesh();
    let mut around: HashMap<NodeId, Vec<FacetId>> = HashMap::new();
    for &edge in surface {
        for node in mesh.topology().facets()[edge] {
            around.entry(node).or_default().push(edge);
        }
    }
    let place = |n: NodeId| mesh.points()[n];
    let before = |a: &NodeId, b: &NodeId| {
        let (p, q) = (place(*a), place(*b));
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(a.cmp(b))
    };
    let mut starts: Vec<NodeId> = around.keys().copied().collect();
    starts.sort_unstable_by(before);
    // Open stretches begin at an end; the remaining edges form closed ones.
    starts.sort_by_key(|n| around[n].len() > 1);
    let mut used = std::collections::HashSet::new();
    let mut stretches = Vec::new();
    for start in starts {
        let mut stretch = Stretch { nodes: vec![start], ..Stretch::default() };
        let mut node = start;
        while let Some(&edge) = around[&node].iter().find(|e| !used.contains(*e)) {
            used.insert(edge);
            let [a, b] = mesh.topology().facets()[edge];
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
///
/// * `first`: these nodes; `seen`: the place of a point as it is compared, such as its projection.
pub(super) fn nearest<S: Space>(
    bodies: [&Body<S>; 2],
    facets: [&[FacetId]; 2],
    first: impl Iterator<Item = NodeId>,
    seen: impl Fn(S::Vector) -> S::Vector,
) -> Result<HashMap<NodeId, NodeId>, InterfaceError> {
    let spacing = [spacings(bodies[0], facets[0]), spacings(bodies[1], facets[1])];
    let place = |b: usize, node: NodeId| seen(bodies[b].mesh().points()[node]);
    let mut second: Vec<NodeId> = spacing[1].keys().copied().collect();
    second.sort_unstable();
    let mut partner = HashMap::new();
    let mut taken = HashMap::new();
    let grid = Grid::<S>::new(second.iter().map(|n| (place(1, *n), *n)));
    for node in first {
        let point = bodies[0].mesh().points()[node];
        let local = spacing[0][&node];
        let (other, distance) = grid.nearest(seen(point));
        if distance > TOLERANCE * local.min(spacing[1][&other]) || taken.insert(other, node).is_some() {
            return Err(InterfaceError::NotMatching {
                body: 0,
                point: point.into(),
                distance,
                spacing: local,
            });
        }
        partner.insert(node, other);
    }
    if let Some(&node) = second.iter().find(|n| !taken.contains_key(n)) {
        let point = bodies[1].mesh().points()[node];
        let distance = Grid::<S>::new(partner.keys().map(|n| (place(0, *n), *n))).nearest(seen(point)).1;
        return Err(InterfaceError::NotMatching {
            body: 1,
            point: point.into(),
            distance,
            spacing: spacing[1][&node],
        });
    }
    Ok(partner)
}

/// Uses the partners from a common refinement: for each stretch, which ends where two lines of the refinement meet at an angle, the second body's
/// nodes that face its own, stretch by stretch.
pub(super) fn refined<'a>(
    body: &Body,
    chain: Vec<Stretch>,
    common: &'a Measured,
) -> Result<(Vec<Stretch>, Vec<&'a Facing>), InterfaceError> {
    let mut along: HashMap<[NodeId; 2], [&Facing; 2]> = HashMap::new();
    for w in common.facing.iter().flat_map(|line| line.windows(2)) {
        let [a, b] = [&w[0], &w[1]];
        along.insert([a.nodes[0], b.nodes[0]], [a, b]);
        along.insert([b.nodes[0], a.nodes[0]], [b, a]);
    }
    let mut stretches = Vec::new();
    let mut facing = Vec::new();
    for stretch in chain {
        let of_edge = |k: usize| {
            let fault = || {
                let point = body.mesh().facet_middle(stretch.edges[k]);
                InterfaceError::FacetWithoutPartner { body: 0, point: point.into(), words: Plane::WORDS }
            };
            along.get(&stretch.ends(k)).copied().ok_or_else(fault)
        };
        let found = (0..stretch.edges.len()).map(of_edge).collect::<Result<Vec<_>, _>>()?;
        let (count, closed) = (found.len(), stretch.is_closed());
        let is_corner = |k: &usize| {
            let [a, b] = [found[(k + count - 1) % count][1], found[*k][0]];
            angle_between(a.normal, b.normal) > 0.5 * outline::CORNER
        };
        let corners: Vec<usize> = (usize::from(!closed)..count).filter(is_corner).collect();
        for part in outline::divided(count, closed, &corners) {
            let ([from, to], _) = part;
            facing.extend((from..to).map(|k| found[k % count][0]));
            if !(closed && corners.is_empty()) {
                facing.push(found[(to - 1) % count][1]);
            }
        }
        stretches.extend(stretch.divided(&corners));
    }
    Ok((stretches, facing))
}

/// Computes the size of the smallest contact facet at each contact node.
fn spacings<S: Space>(body: &Body<S>, surface: &[FacetId]) -> HashMap<NodeId, f64> {
    let mut spacing: HashMap<NodeId, f64> = HashMap::new();
    for &facet in surface {
        let length = facet_size::<S>(body.mesh().facet_measure(facet));
        for node in body.mesh().topology().facets()[facet] {
            let s = spacing.entry(node).or_insert(length);
            *s = s.min(length);
        }
    }
    spacing
}

/// Nodes sorted along the longest direction of their bounding box, for nearest-node queries.
struct Grid<S: Space> {
    axis: usize,
    sorted: Vec<(f64, S::Vector, NodeId)>,
}

impl<S: Space> Grid<S> {
    fn new(nodes: impl Iterator<Item = (S::Vector, NodeId)>) -> Self {
        let (points, nodes): (Vec<S::Vector>, Vec<NodeId>) = nodes.unzip();
        let [low, high] = geometry::bounding_box(&points);
        let extent = high - low;
        let axis = (1..S::DIM).fold(0, |axis, c| if extent[c] > extent[axis] { c } else { axis });
        let mut sorted: Vec<_> = points.iter().zip(nodes).map(|(p, n)| (p[axis], *p, n)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        Self { axis, sorted }
    }

    /// Finds the nearest node and its distance; the search widens from the point's own coordinate.
    fn nearest(&self, point: S::Vector) -> (NodeId, f64) {
        let start = self.sorted.partition_point(|s| s.0 < point[self.axis]);
        let mut best = (NodeId::NONE, f64::INFINITY);
        let mut look = |entry: &(f64, S::Vector, NodeId)| {
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
    edges: [&[FacetId]; 2],
    chain: &[Stretch],
) -> Result<HashMap<NodeId, NodeId>, InterfaceError> {
    let others = walk(bodies[1], edges[1]);
    let place = |b: usize, node: NodeId| bodies[b].mesh().points()[node];
    let counts =
        |point: Vector, what, counts| Err(InterfaceError::Counts { point: point.into(), what, counts });
    if chain.len() != others.len() {
        return counts(place(0, chain[0].nodes[0]), "stretches", [chain.len(), others.len()]);
    }
    let mut free: Vec<Vec<NodeId>> = Vec::new();
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
fn fit(body: &Body, [first, last]: [Vector; 2], nodes: &[NodeId], closed: bool) -> (f64, usize) {
    let distance = |a: Vector, node: NodeId| norm(body.mesh().points()[node] - a);
    if !closed {
        return (distance(first, nodes[0]) + distance(last, nodes[nodes.len() - 1]), 0);
    }
    let nearest = |best: (f64, usize), (start, &node): (usize, &NodeId)| {
        let d = distance(first, node);
        if d < best.0 { (d, start) } else { best }
    };
    nodes.iter().enumerate().fold((f64::INFINITY, 0), nearest)
}

/// Tells whether the body's outward normal is on the right of the stretch, that is, the body on its left.
fn is_outward_right(body: &Body, stretch: &Stretch) -> bool {
    let topology = body.mesh().topology();
    let [a, b] = topology.oriented_facet(stretch.edges[0], body.mesh().cells());
    [a, b] == [stretch.nodes[0], stretch.nodes[1 % stretch.nodes.len()]]
}

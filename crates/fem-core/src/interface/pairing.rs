//! Pairs two matching contact surfaces.

use super::{ContactEdge, ContactInterface, Gap, InterfaceError, InterfaceSide, Pair};
use crate::body::{Body, EdgeReaction, NodeConstraint};
use crate::geometry::{self, Vector, cross, dot, norm, sub};
use std::collections::HashMap;

/// Paired nodes may stand this fraction of the local edge length apart.
const TOLERANCE: f64 = 0.05;
/// Sine of the angle below which directions count as parallel.
const PARALLEL: f64 = 1e-9;

pub(super) fn pair(
    bodies: [&Body; 2],
    surfaces: [&str; 2],
    gap: &Gap,
) -> Result<ContactInterface, InterfaceError> {
    let edges = [surface(bodies[0], 0, surfaces[0])?, surface(bodies[1], 1, surfaces[1])?];
    let chain = walk(bodies[0], edges[0]);
    let partner = match_nodes(bodies, edges, &chain)?;
    let mut pairs = make_pairs(bodies, &chain, &partner, gap)?;
    let number: HashMap<u32, u32> = pairs.iter().enumerate().map(|(k, p)| (p.nodes[0], k as u32)).collect();
    let edges = make_edges(bodies, edges, &chain, &partner, &number)?;
    normals_and_lengths(bodies, &mut pairs, &edges)?;
    check_supports(bodies, &pairs)?;
    let sides = sides(&pairs);
    Ok(ContactInterface { pairs, edges, sides, gap: gap.clone(), measured_on: 0 })
}

/// Lists what each body keeps of the pairs.
pub(super) fn sides(pairs: &[Pair]) -> [InterfaceSide; 2] {
    [0, 1].map(|b| InterfaceSide {
        nodes: pairs.iter().map(|p| p.nodes[b]).collect(),
        normals: pairs.iter().map(|p| p.normal).collect(),
    })
}

fn surface<'a>(body: &'a Body, number: usize, group: &str) -> Result<&'a [u32], InterfaceError> {
    let mesh = body.mesh();
    let Some(edges) = mesh.group(group) else {
        let known = mesh.groups().keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        return Err(InterfaceError::UnknownSurface { body: number, group: group.to_string(), known });
    };
    let fault = |reason| InterfaceError::NoSurface { body: number, group: group.to_string(), reason };
    if edges.is_empty() {
        return Err(fault("has no edge"));
    }
    for &edge in edges {
        let condition = body.edge_condition(edge).ok_or_else(|| fault("has an edge inside the body"))?;
        let point = middle(body, edge);
        if condition.reaction != EdgeReaction::None {
            return Err(InterfaceError::Occupied { body: number, point, what: "an imposed displacement" });
        }
        if condition.traction != [[0.0; 2]; 2] {
            return Err(InterfaceError::Occupied { body: number, point, what: "a load" });
        }
    }
    Ok(edges)
}

fn ends(body: &Body, edge: u32) -> [Vector; 2] {
    body.mesh().topology().edges()[edge as usize].map(|n| body.mesh().points()[n as usize])
}

fn middle(body: &Body, edge: u32) -> Vector {
    let [a, b] = ends(body, edge);
    geometry::scale(0.5, geometry::add(a, b))
}

/// One stretch of the contact line: nodes in order, and the edges between them.
struct Stretch {
    nodes: Vec<u32>,
    edges: Vec<u32>,
}

/// Walks the first body's surface stretch by stretch, each from its end with the smaller (x, y).
fn walk(body: &Body, surface: &[u32]) -> Vec<Stretch> {
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
    // Open stretches begin at an end; what is left after them is closed.
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
fn match_nodes(
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
            let d = norm(sub(entry.1, point));
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

fn make_pairs(
    bodies: [&Body; 2],
    chain: &[Stretch],
    partner: &HashMap<u32, u32>,
    gap: &Gap,
) -> Result<Vec<Pair>, InterfaceError> {
    let points = bodies[0].mesh().points();
    let mut pairs = Vec::new();
    let mut arc_length = 0.0;
    for stretch in chain {
        for (k, &node) in stretch.nodes.iter().enumerate() {
            if k > 0 {
                arc_length += bodies[0].mesh().edge_length(stretch.edges[k - 1]);
            }
            let point = points[node as usize];
            let Gap::Given(data) = gap;
            let value = data.at(point);
            if !(value >= 0.0 && value.is_finite()) {
                return Err(InterfaceError::BadGap { point, value });
            }
            pairs.push(Pair {
                nodes: [node, partner[&node]],
                normal: [0.0; 2],
                gap: value,
                tributary_length: 0.0,
                arc_length,
            });
        }
    }
    Ok(pairs)
}

fn make_edges(
    bodies: [&Body; 2],
    surfaces: [&[u32]; 2],
    chain: &[Stretch],
    partner: &HashMap<u32, u32>,
    number: &HashMap<u32, u32>,
) -> Result<Vec<ContactEdge>, InterfaceError> {
    let mut edges = Vec::new();
    let mut seen = std::collections::HashSet::new();
    for stretch in chain {
        for (k, &edge) in stretch.edges.iter().enumerate() {
            let nodes = [stretch.nodes[k], stretch.nodes[(k + 1) % stretch.nodes.len()]];
            let found = bodies[1].mesh().topology().find_edge(partner[&nodes[0]], partner[&nodes[1]]);
            let Some(other) = found.filter(|e| surfaces[1].binary_search(e).is_ok()) else {
                return Err(InterfaceError::EdgeWithoutPartner { body: 0, point: middle(bodies[0], edge) });
            };
            if dot(bodies[0].mesh().edge_normal(edge), bodies[1].mesh().edge_normal(other)) >= -0.5 {
                return Err(InterfaceError::NotFacing { point: middle(bodies[0], edge) });
            }
            seen.insert(other);
            let length = bodies[0].mesh().edge_length(edge);
            edges.push(ContactEdge { pairs: nodes.map(|n| number[&n]), edges: [edge, other], length });
        }
    }
    match surfaces[1].iter().find(|e| !seen.contains(*e)) {
        Some(&edge) => Err(InterfaceError::EdgeWithoutPartner { body: 1, point: middle(bodies[1], edge) }),
        None => Ok(edges),
    }
}

fn normals_and_lengths(
    bodies: [&Body; 2],
    pairs: &mut [Pair],
    edges: &[ContactEdge],
) -> Result<(), InterfaceError> {
    let common = bodies[0].mesh().edge_normal(edges[0].edges[0]);
    for edge in edges {
        for (b, sign) in [(0, 1.0), (1, -1.0)] {
            let normal = geometry::scale(sign, bodies[b].mesh().edge_normal(edge.edges[b]));
            // Paired nodes may differ by TOLERANCE, so the second surface may be that rough.
            let allowed = if b == 0 { 1e-6 } else { 4.0 * TOLERANCE };
            let sine = cross(common, normal);
            if sine.abs() > allowed || dot(common, normal) < 0.0 {
                let degrees = sine.atan2(dot(common, normal)).abs().to_degrees();
                return Err(InterfaceError::Curved { point: middle(bodies[b], edge.edges[b]), degrees });
            }
        }
        for pair in edge.pairs {
            pairs[pair as usize].tributary_length += 0.5 * edge.length;
        }
    }
    for pair in pairs {
        pair.normal = common;
    }
    Ok(())
}

/// Refuses contact nodes whose normal displacement a support imposes; a tangential support is fine.
fn check_supports(bodies: [&Body; 2], pairs: &[Pair]) -> Result<(), InterfaceError> {
    for pair in pairs {
        for b in 0..2 {
            let node = pair.nodes[b] as usize;
            let free = match bodies[b].node_constraints()[node] {
                NodeConstraint::Free => true,
                NodeConstraint::Along { direction, .. } => dot(direction, pair.normal).abs() <= PARALLEL,
                NodeConstraint::Fixed { .. } => false,
            };
            if !free {
                return Err(InterfaceError::SupportedNode {
                    body: b,
                    point: bodies[b].mesh().points()[node],
                });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::BoundaryConditions;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::block;

    fn body(y: f64, cells: [usize; 2], conditions: BoundaryConditions) -> Body {
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(block([0.0, y], [2.0, 1.0], cells).unwrap(), material, &conditions).unwrap()
    }

    fn no_gap() -> Gap {
        Gap::Given(0.0.into())
    }

    #[test]
    fn stacked_blocks_match() {
        let upper = body(1.0, [4, 2], BoundaryConditions::new().displace("left", Some(0.0.into()), None));
        let lower = body(0.0, [4, 3], BoundaryConditions::new().fix("bottom"));
        let interface = ContactInterface::pair(&upper, &lower, ["bottom", "top"], &no_gap()).unwrap();
        assert_eq!(interface.pairs().len(), 5);
        assert_eq!(interface.length(), 2.0);
        assert!(interface.pairs().iter().all(|p| p.normal == [0.0, -1.0]));
        assert_eq!(interface.pairs()[4].arc_length, 2.0);
        // Lumped and consistent mass agree on constants.
        let lengths: Vec<f64> = interface.pairs().iter().map(|p| p.tributary_length).collect();
        assert_eq!(interface.mass(&[1.0; 5]), lengths);
        let turned = interface.clone().swapped();
        assert!(turned.pairs().iter().all(|p| p.normal == [0.0, 1.0]));
        assert_eq!(
            turned.sides()[0],
            InterfaceSide { normals: vec![[0.0, 1.0]; 5], ..interface.sides()[1].clone() }
        );
    }

    #[test]
    fn what_cannot_be_paired_is_refused() {
        let fixed = || BoundaryConditions::new().fix("bottom");
        let upper = body(1.0, [4, 2], BoundaryConditions::new());
        let pair = |a: &Body, b: &Body, s| ContactInterface::pair(a, b, s, &no_gap()).unwrap_err();
        let finer = body(0.0, [5, 2], fixed());
        assert!(matches!(pair(&upper, &finer, ["bottom", "top"]), InterfaceError::NotMatching { .. }));
        let lower = body(0.0, [4, 2], fixed());
        assert!(matches!(
            pair(&upper, &lower, ["bottm", "top"]),
            InterfaceError::UnknownSurface { body: 0, .. }
        ));
        let far = body(-0.2, [4, 2], fixed());
        assert!(matches!(pair(&upper, &far, ["bottom", "top"]), InterfaceError::NotMatching { .. }));
        let loaded = body(0.0, [4, 2], fixed().pressure("top", 1.0));
        assert!(matches!(pair(&upper, &loaded, ["bottom", "top"]), InterfaceError::Occupied { body: 1, .. }));
        let clamped = body(0.0, [4, 2], fixed().fix("left"));
        assert!(matches!(pair(&upper, &clamped, ["bottom", "top"]), InterfaceError::SupportedNode { .. }));
        let same = body(1.0, [4, 2], fixed());
        assert!(matches!(
            pair(&upper, &same, ["left", "left"]),
            InterfaceError::Occupied { .. } | InterfaceError::NotFacing { .. }
        ));
        let gap = Gap::Given((-0.1).into());
        let e = ContactInterface::pair(&upper, &lower, ["bottom", "top"], &gap).unwrap_err();
        assert!(matches!(e, InterfaceError::BadGap { .. }));
    }
}

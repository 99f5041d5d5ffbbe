//! The stretches of both surfaces, prepared once for all stretches that they may face.

use super::chain::Chain;
use super::curve::Curve;
use crate::{ContactNormal, outline};
use fem_core::body::{Body, Piece};
use fem_core::geometry::{Vector, bounding_box, norm, right_normal};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::smooth::STRAIGHT;

/// A surface as it was before it was cut: its polygon, and the place of each node on the common line.
#[derive(Clone, Debug)]
pub(super) struct Uncut {
    pub(super) curve: Curve,
    pub(super) s: Vec<f64>,
}

impl Uncut {
    /// Finds the edge at a place on the common line.
    pub(super) fn edge(&self, s: f64) -> usize {
        // A closed line may have been opened before its first node. An open one begins at its first node, to round-off.
        let wraps = self.curve.is_closed() && s < self.s[0];
        let s = if wraps { s + self.curve.length() } else { s };
        self.s.partition_point(|x| *x <= s).saturating_sub(1).min(self.s.len() - 2)
    }
}

/// A stretch of the reference, prepared as the common line of the stretches that it faces.
pub(super) struct Line<'a> {
    pub(super) own: &'a Chain,
    pub(super) curve: Curve,
    pub(super) uncut: Uncut,
}

impl<'a> Line<'a> {
    /// * `body`: the one on whose surface the line is, number `reference`; `normal`: the direction of projection.
    pub(super) fn new(body: &Body, own: &'a Chain, reference: usize, normal: ContactNormal) -> Self {
        let points = points_of(body, &own.nodes);
        let inner = points.len() - 1;
        let pieces = pieces_of(body, (&own.nodes, own.corners), &points);
        let outward = |k: usize| right_normal(points[k], points[k + 1]);
        let mut known = outline::normals(&pieces, &points, outward, [own.is_closed(), own.is_cut()]);
        for (node, normal) in &own.faced {
            own.nodes
                .iter()
                .zip(&mut known)
                .filter(|(n, _)| *n == node)
                .for_each(|(_, n)| *n = Some(*normal));
        }
        // A node inserted to open the line changes neither its normals nor its shape.
        let uncut = match own.inserted {
            true => Curve::new([&points[1..inner], &points[1..2]].concat()).with_pieces(pieces[1..].to_vec()),
            false => Curve::continued(points.clone(), beyond(body, &own.nodes, own.corners))
                .kept_open(!own.is_closed())
                .with_pieces(pieces),
        };
        let curve = if own.inserted { uncut.begun_at(points[0]) } else { uncut.clone() };
        // On declared curves the normals are the curves' own.
        let mut curve = curve.with_normals(|k| known[k]);
        let offset = if own.inserted { curve.arc()[1] } else { 0.0 };
        let uncut = Uncut { s: uncut.arc().iter().map(|s| s + offset).collect(), curve: uncut };
        if let ContactNormal::Fixed(direction) = normal {
            curve = curve.along(if reference == 0 { direction } else { -direction });
        } else if !own.is_closed() {
            // As in pairing: at a support the normal is the direction left free.
            for (last, node) in [(false, own.nodes[0]), (true, own.nodes[own.nodes.len() - 1])] {
                if let [free] = body.node_constraints()[node].held.complement().basis() {
                    curve.turn_end(last, *free);
                }
            }
        }
        Self { own, curve, uncut }
    }
}

/// A stretch of the other body in the orientation of the reference: surfaces of facing bodies have opposite
/// orientations.
pub(super) struct Opposite {
    pub(super) nodes: Vec<NodeId>,
    pub(super) points: Vec<Vector>,
    pub(super) pieces: Vec<Option<Piece>>,
    pub(super) closed: bool,
}

impl Opposite {
    pub(super) fn new(body: &Body, chain: &Chain) -> Self {
        let nodes: Vec<NodeId> = chain.nodes.iter().rev().copied().collect();
        let points = points_of(body, &nodes);
        let [begin, end] = chain.corners;
        let pieces = pieces_of(body, (&nodes, [end, begin]), &points);
        Self { pieces, points, nodes, closed: chain.is_closed() }
    }
}

/// Returns the points of the outline before and after an open stretch; it does not continue beyond corners.
fn beyond(body: &Body, nodes: &[NodeId], corners: [bool; 2]) -> [Option<Vector>; 2] {
    let (mesh, last) = (body.mesh(), nodes.len() - 1);
    [(nodes[0], nodes[1], corners[0]), (nodes[last], nodes[last - 1], corners[1])].map(
        |(end, inner, corner)| {
            if corner {
                return None;
            }
            let edge = mesh.topology().find_edge(end, inner)?;
            let ends = mesh.topology().facets()[mesh.topology().boundary_beyond(edge, end)?];
            Some(mesh.points()[if ends[0] == end { ends[1] } else { ends[0] }])
        },
    )
}

/// Finds the pieces over the edges of a stretch. A single edge whose outline continues smoothly may be part of an undeclared curve.
///
/// * `stretch`: its nodes, and its ends at corners.
pub(super) fn pieces_of(
    body: &Body,
    (nodes, corners): (&[NodeId], [bool; 2]),
    points: &[Vector],
) -> Vec<Option<Piece>> {
    let mesh = body.mesh();
    let find = |w: &[NodeId]| mesh.topology().find_edge(w[0], w[1]);
    let edges: Vec<FacetId> = nodes.windows(2).filter_map(find).collect();
    let pieces = outline::pieces(body, &edges, points, corners != [false; 2]);
    let bent = || {
        Curve::continued(points.to_vec(), beyond(body, nodes, corners)).sagitta(0)
            > STRAIGHT * norm(points[1] - points[0])
    };
    match pieces.as_slice() {
        [Some(Piece::Line { .. })] if bent() => vec![None],
        _ => pieces,
    }
}

pub(super) fn points_of(body: &Body, nodes: &[NodeId]) -> Vec<Vector> {
    nodes.iter().map(|&n| body.mesh().points()[n]).collect()
}

/// Lists for each line the stretches of the other body, ascending, that reach into the region swept by its normals:
/// as intervals on one axis, along the surface as a whole.
pub(super) fn candidates(lines: &[Line<'_>], others: &[Opposite]) -> Vec<Vec<usize>> {
    let along = lines.iter().fold(Vector::zeros(), |sum, l| sum + l.curve.chord());
    // A closed line as a whole has no direction.
    let axis = if norm(along) > 0.0 { 1.0 / norm(along) * along } else { Vector::x() };
    let all: Vec<Vector> = others.iter().flat_map(|o| o.points.iter().copied()).collect();
    let [low, high] = bounding_box(&all);
    let corners = [low, Vector::new(high[0], low[1]), high, Vector::new(low[0], high[1])];
    let margin = 1e-9 * norm(high - low);
    let interval = |o: &Opposite| {
        let places = o.points.iter().map(|p| p.dot(&axis));
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
    };
    let mut sorted: Vec<([f64; 2], usize)> = others.iter().map(interval).zip(0..).collect();
    sorted.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let widest = sorted.iter().fold(0.0f64, |w, ([a, b], _)| w.max(b - a));
    let near = |line: &Line<'_>| {
        let [from, to] = line.curve.reach(axis, corners);
        let (from, to) = (from - margin, to + margin);
        let first = sorted.partition_point(|s| s.0[0] < from - widest);
        let found = sorted[first..].iter().take_while(|s| s.0[0] <= to).filter(|s| s.0[1] >= from);
        let mut found: Vec<usize> = found.map(|s| s.1).collect();
        found.sort_unstable();
        found
    };
    lines.iter().map(near).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common_refinement::{chain, overlap};
    use fem_core::boundary::BoundaryConditions;
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::TriMesh;

    /// Separate cells along a line that rises by an angle, each above or below its own edge: every other edge of the line.
    fn dashes(count: usize, angle: f64, shift: f64, side: f64) -> (Body, Vec<Chain>) {
        let (sine, cosine) = angle.sin_cos();
        let place = |t: f64, h: f64| [t * cosine - h * sine, t * sine + h * cosine];
        let (mut points, mut cells, mut groups) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..count {
            let (t, n) = (2.0 * k as f64 + shift, points.len() as u32);
            points.extend([place(t, 0.0), place(t + 1.0, 0.0), place(t + 0.5, side)]);
            cells.push(if side > 0.0 { [n, n + 1, n + 2] } else { [n, n + 2, n + 1] });
            groups.push([n, n + 1]);
        }
        let mesh = TriMesh::new(points, cells, vec![("line".into(), groups)]).unwrap();
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let chains = chain::chains(&mesh, mesh.group("line").unwrap()).unwrap();
        (Body::new(mesh, steel, &BoundaryConditions::new()).unwrap(), chains)
    }

    #[test]
    fn a_stretch_is_compared_with_its_neighbours_only() {
        for angle in [0.0, 0.7, 1.6] {
            let count = 200;
            let (upper, above) = dashes(count, angle, 0.0, 1.0);
            let (lower, below) = dashes(count, angle, 0.3, -1.0);
            let lines: Vec<Line<'_>> =
                above.iter().map(|c| Line::new(&upper, c, 0, ContactNormal::Averaged)).collect();
            let others: Vec<Opposite> = below.iter().map(|c| Opposite::new(&lower, c)).collect();
            let near = candidates(&lines, &others);
            for (i, near) in near.iter().enumerate() {
                assert!(near.contains(&i) && near.len() <= 2, "{angle} {i}: {near:?}");
            }
            let bodies = [&upper, &lower];
            let fixed = bodies.map(chain::Fixed::new);
            let overlaps = overlap::find(
                bodies,
                fixed.each_ref(),
                &[above.clone(), below.clone()],
                0,
                ContactNormal::Averaged,
            )
            .unwrap();
            assert_eq!(overlaps.len(), count);
        }
    }
}

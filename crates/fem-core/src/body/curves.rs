//! Curved sides: the places of the new nodes of a finer mesh.
//!
//! A side is declared as an arc or as a smooth curve, and every edge of it gets a piece of that curve, which the parts of the edge
//! inherit. A new node lies on the piece, so finer meshes approach the curve; nodes of the first mesh do not move.

use super::{Body, BodyError, ConditionList, ConditionPlace, group};
use crate::geometry::{Vector, cross, norm, perpendicular};
use crate::mesh::TriMesh;
use crate::mesh::id::{FacetId, NodeId};
use crate::mesh::refine::Refinement;
use crate::smooth::{Arch, smooth_normals};
use crate::space::{Plane, Space};
use std::collections::{BTreeMap, HashMap};

/// Nodes of an arc may be this fraction of its radius off its circle.
const ON_ARC: f64 = 1e-6;
/// A node may be this fraction of the chord off a smooth curve by round-off.
const ON_CHORD: f64 = 1e-12;
/// Three nodes whose triangle has less than this fraction of its squared size lie on a straight line.
const STRAIGHT: f64 = 1e-9;
/// A smooth curve ends at a node at which a side turns by more: cosine of 30 degrees.
const CORNER: f64 = 0.866;
/// A polygon may be a curve if it turns at a node by at least this: sine of 0.1 degrees.
const BENT: f64 = 1.7e-3;
/// Steps to the point of a smooth curve on a ray.
const ROUNDS: usize = 40;
/// A point on a ray may be this part of the edge away from the middle of the curve.
const CENTRAL: f64 = 0.25;

/// The kind of a curved side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// A circle through its nodes, each connected part with its own.
    Arc,
    /// A smooth curve through its nodes: a circle if they lie on one, nearly cubic from node to node otherwise. Corners of more
    /// than 30 degrees stay.
    Smooth,
}

/// A side whose new nodes lie on a curve.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CurvedSide {
    /// The edge group.
    pub on: String,
    /// The kind of the curve.
    pub kind: CurveKind,
}

/// The part of a curve over an edge, or the straight line on which it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A part of a circle.
    Arc {
        /// The centre, m.
        centre: Vector,
        /// The radius, m.
        radius: f64,
    },
    /// A smooth curve through the nodes.
    Smooth(Arch),
    /// A straight line.
    Line {
        /// A point of it, m.
        point: Vector,
        /// Its direction, of length one.
        direction: Vector,
    },
}

impl Piece {
    /// Computes the point of the curve nearest to a point near it: for a smooth one the point over the same place of the chord.
    fn project(&self, point: Vector) -> Vector {
        match *self {
            Self::Arc { centre, radius } => {
                let arm = point - centre;
                let length = norm(arm);
                if length > 0.0 { centre + radius / length * arm } else { point }
            }
            Self::Smooth(arch) => arch.at(arch.fraction(point)),
            Self::Line { point: on, direction } => on + (point - on).dot(&direction) * direction,
        }
    }

    /// Computes the unit normal of the curve at a point of it, on the side of a given direction.
    pub fn normal(&self, point: Vector, side: Vector) -> Vector {
        let across = match *self {
            Self::Arc { centre, .. } => point - centre,
            Self::Smooth(arch) => perpendicular(arch.tangent(arch.fraction(point))),
            Self::Line { direction, .. } => perpendicular(direction),
        };
        across.dot(&side).signum() / norm(across) * across
    }

    /// Tells whether a piece is the continuation of another in one smooth curve, at a node of both.
    pub fn continues(&self, other: &Self, node: Vector) -> bool {
        let (Self::Smooth(one), Self::Smooth(two)) = (self, other) else { return self == other };
        let normals = one.end_normal(node).zip(two.end_normal(node));
        normals.is_some_and(|(a, b)| norm(a - b) <= ON_CHORD.sqrt())
    }

    /// Estimates the largest distance of the curve from the chord between two of its points, m.
    pub fn sagitta(&self, length: f64) -> f64 {
        match self {
            Self::Arc { radius, .. } => length * length / (8.0 * radius),
            Self::Smooth(arch) => {
                let [a, b] = arch.slopes();
                length / 8.0 * (a.abs() + b.abs())
            }
            Self::Line { .. } => 0.0,
        }
    }

    /// Computes by how much a node is off the curve, m: zero within the tolerance of an arc, and within round-off of a smooth curve.
    fn offset(&self, node: Vector) -> Vector {
        let off = node - self.project(node);
        let allowed = match self {
            Self::Arc { radius, .. } => ON_ARC * radius,
            Self::Smooth(arch) => ON_CHORD * norm(arch.chord()),
            Self::Line { .. } => f64::INFINITY,
        };
        if norm(off) <= allowed { Vector::zeros() } else { off }
    }

    /// Computes the point that halves the curve between two nodes. Nodes that stayed off the curve draw it with them.
    fn middle(&self, ends: [Vector; 2]) -> Vector {
        self.project(0.5 * (ends[0] + ends[1])) + 0.5 * (self.offset(ends[0]) + self.offset(ends[1]))
    }

    /// Finds the point of the curve between two nodes on a line through a point; `None` if it is not near the middle.
    pub fn crossing(&self, ends: [Vector; 2], point: Vector, direction: Vector) -> Option<Vector> {
        let found = self.meet(point, direction)?;
        let allowed = CENTRAL * norm(ends[1] - ends[0]);
        let off = ends.map(|end| norm(self.offset(end)));
        // A curve that is drawn off by a node has another place.
        let is_near = off == [0.0; 2] && norm(found - self.middle(ends)) <= allowed;
        is_near.then_some(found)
    }

    /// Finds the point of the curve on a line through a point: of two the nearer one.
    pub fn meet(&self, point: Vector, direction: Vector) -> Option<Vector> {
        match *self {
            Self::Arc { centre, radius } => {
                let arm = point - centre;
                let (b, c) = (arm.dot(&direction), (norm(arm) - radius) * (norm(arm) + radius));
                let squared = direction.dot(&direction);
                let root = (b * b - squared * c).sqrt();
                // The smaller of the two distances, without a difference of nearly equal numbers.
                let distance = -c / (b + b.signum() * root);
                distance.is_finite().then(|| point + distance * direction)
            }
            Self::Smooth(arch) => {
                let span = cross(arch.chord(), direction);
                let (mut t, mut step) = (0.5, f64::INFINITY);
                for _ in 0..ROUNDS {
                    step = cross(point - arch.at(t), direction) / span;
                    t += step;
                    if !(step.abs() > f64::EPSILON) {
                        break;
                    }
                }
                let found = step.abs() <= ON_CHORD && (-0.5..=1.5).contains(&t);
                found.then(|| arch.at(t))
            }
            Self::Line { point: on, direction: along } => {
                let distance = cross(on - point, along) / cross(direction, along);
                distance.is_finite().then(|| point + distance * direction)
            }
        }
    }
}

/// The curves of a body's sides.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    pieces: BTreeMap<FacetId, Piece>,
    /// New nodes that were left on the chord, since a cell would have turned over.
    on_chord: Vec<NodeId>,
}

impl Curves {
    fn declare(mesh: &TriMesh, sides: &[CurvedSide]) -> Result<Self, BodyError> {
        let mut pieces = BTreeMap::new();
        for (index, side) in sides.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Curve, index };
            let edges = group(mesh, &side.on, place)?;
            for nodes in mesh.walks(edges, |a, b| a.cmp(&b)) {
                let found = match side.kind {
                    CurveKind::Arc => arc(mesh, &nodes, place)?,
                    CurveKind::Smooth => smooth(mesh, &nodes),
                };
                for (edge, piece) in found {
                    if pieces.insert(edge, piece).is_some() {
                        let (point, words) = (mesh.facet_middle(edge).into(), Plane::WORDS);
                        return Err(BodyError::CurvedTwice { place, point, words });
                    }
                }
            }
        }
        Ok(Self { pieces, on_chord: Vec::new() })
    }

    /// Creates the curves of the finer mesh.
    pub(super) fn refined(&self, old: &TriMesh, refinement: &Refinement) -> Self {
        let parts = |(&edge, &piece): (&FacetId, &Piece)| {
            refinement.parts(old, edge).into_iter().map(move |part| (part, piece))
        };
        let pieces = self.pieces.iter().flat_map(parts).collect();
        let on_chord = self.on_chord.iter().chain(&refinement.on_chord).copied().collect();
        Self { pieces, on_chord }
    }
}

impl Body {
    /// Declares sides as curves: the new nodes of finer meshes lie on them.
    ///
    /// # Errors
    /// Groups without edges or with edges inside the body, nodes that are not on one arc, edges of two curves.
    pub fn with_curves(mut self, sides: &[CurvedSide]) -> Result<Self, BodyError> {
        self.curves = Curves::declare(&self.mesh, sides)?;
        Ok(self)
    }

    /// Tells whether any side is a curve.
    pub fn has_curves(&self) -> bool {
        !self.curves.pieces.is_empty()
    }

    /// Lists the nodes of refinements that are not on the declared curve but on the chord, since a cell would have turned over.
    pub fn nodes_on_chords(&self) -> &[NodeId] {
        &self.curves.on_chord
    }

    /// Returns the curve over an edge.
    pub fn curve(&self, edge: FacetId) -> Option<&Piece> {
        self.curves.pieces.get(&edge)
    }

    /// Computes the point that halves the declared curve over an edge; `None` if the edge is not on a curve.
    pub fn curve_middle(&self, edge: FacetId) -> Option<Vector> {
        self.curve(edge).map(|piece| piece.middle(self.mesh.facet_corners(edge)))
    }

    /// Lists the ends of the boundary edges that seem to approximate a curve and are not declared as one: at both ends the
    /// boundary turns the same way, by 0.1 to 30 degrees.
    pub fn undeclared_curves(&self) -> Vec<[NodeId; 2]> {
        let (mesh, topology) = (&self.mesh, self.mesh.topology());
        let mut turn: HashMap<NodeId, f64> = HashMap::new();
        let mut normal: HashMap<NodeId, Vector> = HashMap::new();
        for &edge in topology.boundary_facets() {
            let own = mesh.facet_normal(edge);
            let [from, to] = topology.oriented_facet(edge, mesh.cells());
            // A node has two boundary edges: the sine of the turn from the one that ends there to the one that begins.
            for (node, begins) in [(from, true), (to, false)] {
                let Some(other) = normal.insert(node, own) else { continue };
                let sine = if begins { cross(other, own) } else { cross(own, other) };
                let bends = own.dot(&other) >= CORNER && sine.abs() >= BENT;
                turn.insert(node, if bends { sine.signum() } else { 0.0 });
            }
        }
        let at = |n: NodeId| turn.get(&n).copied().unwrap_or(0.0);
        let bent = |edge: &&FacetId| {
            let [a, b] = topology.facets()[**edge];
            at(a) * at(b) > 0.0 && self.curve(**edge).is_none()
        };
        topology.boundary_facets().iter().filter(bent).map(|e| topology.facets()[*e]).collect()
    }
}

/// Lists the edges between consecutive nodes.
fn edges_of<'a>(mesh: &'a TriMesh, nodes: &'a [NodeId]) -> impl Iterator<Item = FacetId> + 'a {
    nodes.windows(2).filter_map(|w| mesh.topology().find_edge(w[0], w[1]))
}

/// Finds the circle through the first, the middle and the last node of a part, and checks that all others lie on it.
fn arc(mesh: &TriMesh, nodes: &[NodeId], place: ConditionPlace) -> Result<Vec<(FacetId, Piece)>, BodyError> {
    let points: Vec<Vector> = nodes.iter().map(|n| mesh.points()[*n]).collect();
    let last = points.len() - 1;
    let closed = nodes[0] == nodes[last];
    let three = if closed { [0, last / 3, 2 * last / 3] } else { [0, last / 2, last] };
    let [a, b, c] = three.map(|k| points[k]);
    // The centre relative to the first node.
    let (b, c) = (b - a, c - a);
    let (area, size) = (cross(b, c), norm(b).max(norm(c)));
    if last < 2 || !(area.abs() > STRAIGHT * size * size) {
        return Err(BodyError::NoArc { place, point: a.into(), edges: last });
    }
    let (bb, cc) = (b.dot(&b), c.dot(&c));
    let arm = 0.5 / area * Vector::new(c[1] * bb - b[1] * cc, b[0] * cc - c[0] * bb);
    let (centre, radius) = (a + arm, norm(arm));
    let off = |p: &Vector| (norm(p - centre) - radius).abs();
    if let Some(&point) = points.iter().max_by(|p, q| off(p).total_cmp(&off(q)))
        && !(off(&point) <= ON_ARC * radius)
    {
        let distance = off(&point);
        return Err(BodyError::OffArc {
            place,
            point: point.into(),
            distance,
            centre: centre.into(),
            radius,
        });
    }
    Ok(edges_of(mesh, nodes).map(|edge| (edge, Piece::Arc { centre, radius })).collect())
}

/// Creates the smooth curve through the nodes of a part, with its corners.
fn smooth(mesh: &TriMesh, nodes: &[NodeId]) -> Vec<(FacetId, Piece)> {
    let mut found = Vec::new();
    let (runs, closed) = between_corners(mesh, nodes);
    for run in runs {
        let points: Vec<Vector> = run.iter().map(|n| mesh.points()[*n]).collect();
        let normals = smooth_normals(&points, closed);
        let pieces = (0..points.len() - 1)
            .map(|k| Arch::new([points[k], points[k + 1]], [normals[k], normals[k + 1]]))
            .map(Piece::Smooth);
        found.extend(edges_of(mesh, &run).zip(pieces));
    }
    found
}

/// Cuts a part at its corners, and tells whether it is closed and has none.
fn between_corners(mesh: &TriMesh, nodes: &[NodeId]) -> (Vec<Vec<NodeId>>, bool) {
    let edges: Vec<FacetId> = edges_of(mesh, nodes).collect();
    let is_corner =
        |a: usize, b: usize| mesh.facet_normal(edges[a]).dot(&mesh.facet_normal(edges[b])) < CORNER;
    let last = nodes.len() - 1;
    let mut nodes = nodes.to_vec();
    let mut corners: Vec<usize> = (1..last).filter(|k| is_corner(k - 1, *k)).collect();
    let ends_meet = nodes[0] == nodes[last];
    let has_corners = !corners.is_empty() || (ends_meet && is_corner(last - 1, 0));
    if ends_meet && has_corners {
        // A closed part with corners begins at one of them.
        let first = if is_corner(last - 1, 0) { 0 } else { corners[0] };
        nodes.pop();
        nodes.rotate_left(first);
        nodes.push(nodes[0]);
        corners = corners.into_iter().map(|k| k - first).filter(|k| *k > 0).collect();
    }
    let bounds = [vec![0], corners, vec![last]].concat();
    let runs = bounds.windows(2).map(|w| nodes[w[0]..=w[1]].to_vec()).collect();
    (runs, ends_meet && !has_corners)
}

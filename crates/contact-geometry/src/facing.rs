//! The edges of two sides that face each other.

use fem_core::body::Body;
use fem_core::geometry::{self, Vector, norm};
use fem_core::mesh::id::{FacetId, NodeId};
use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, PointDistance, RTree};
use std::collections::HashMap;

/// The largest angle between the normals of two facing edges, and between a normal and the way to the other side, radians: a little less
/// than the 60 degrees that pairing allows, so that rounding does not decide.
const FACING: f64 = 59.9 / 180.0 * std::f64::consts::PI;
/// Cosine of the largest turn of a contact line at a node, 60 degrees.
const TURN: f64 = 0.5;
/// Two points closer than this fraction of the smaller body's diagonal are the same.
const TOUCHING: f64 = 1e-6;
/// Relative round-off of a distance.
const ROUND_OFF: f64 = 1e-9;
/// Points of an edge that are looked at, both ends among them.
const SAMPLES: usize = 9;

/// Selects the edges of two sides that face each other: somewhere on the edge the nearest point of the other side lies within an angle
/// of the edge's normal, and the normals are opposite within this angle. So a roller's rim takes part in a contact only near the other
/// body, and a long side only near what lies on it.
///
/// The angle is 60 degrees, which pairing allows, less half of the largest turn of the two sides: so far the normals at the ends of an
/// edge are from its own. So coarse rims are not refused for their ends.
pub(crate) fn facing_edges(sides: [&FacingSide; 2]) -> [Vec<FacetId>; 2] {
    let size = sides[0].size.min(sides[1].size);
    let turn = sides.iter().map(|side| side.turn).fold(0.0, f64::max);
    let facing = (FACING - 0.5 * turn).cos();
    [0, 1].map(|b| {
        let (own, other) = (sides[b], sides[1 - b]);
        let faces = |place: &usize| {
            let ([p, q], normal) = own.edges[*place];
            (0..SAMPLES).any(|k| {
                let s = k as f64 / (SAMPLES - 1) as f64;
                other.is_faced_from((1.0 - s) * p + s * q, normal, (size, facing))
            })
        };
        own.near(other, size).into_iter().filter(faces).map(|place| own.numbers[place]).collect()
    })
}

/// An edge in a tree, with its place.
type Edge = GeomWithData<Line<[f64; 2]>, usize>;

/// A side as a polygon, sorted once for all sides that it may face.
pub(crate) struct FacingSide {
    numbers: Vec<FacetId>,
    /// The ends of each edge, and its outward normal.
    edges: Vec<([Vector; 2], Vector)>,
    tree: RTree<Edge>,
    /// The longest edge, m.
    longest: f64,
    /// The largest angle between neighbouring edges, without corners at which a contact line would end, radians.
    turn: f64,
    /// Diagonal of the body, m.
    size: f64,
}

impl FacingSide {
    /// Takes a group of edges of a body; a missing one has no edges.
    pub(crate) fn new(body: &Body, group: &str) -> Self {
        let mesh = body.mesh();
        let numbers = mesh.group(group).unwrap_or(&[]).to_vec();
        let edges: Vec<_> = numbers.iter().map(|e| (mesh.facet_corners(*e), mesh.facet_normal(*e))).collect();
        let (mut before, mut turn): (HashMap<NodeId, Vector>, f64) = (HashMap::new(), 0.0);
        for edge in &numbers {
            let normal = mesh.facet_normal(*edge);
            for node in mesh.topology().facets()[*edge] {
                if let Some(other) = before.insert(node, normal).filter(|other| other.dot(&normal) >= TURN) {
                    turn = turn.max(geometry::angle_between(other, normal));
                }
            }
        }
        let line = |(place, ([p, q], _)): (usize, &([Vector; 2], Vector))| {
            Edge::new(Line::new([p[0], p[1]], [q[0], q[1]]), place)
        };
        let tree = RTree::bulk_load(edges.iter().enumerate().map(line).collect());
        let longest = edges.iter().map(|([p, q], _)| norm(q - p)).fold(0.0, f64::max);
        Self { numbers, edges, tree, longest, turn, size: mesh.diagonal() }
    }

    /// Lists the places of the edges whose boxes are within a distance of the box around another side, ascending.
    fn near(&self, other: &Self, distance: f64) -> Vec<usize> {
        let margin = (1.0 + ROUND_OFF) * distance;
        let [low, high] = [other.tree.root().envelope().lower(), other.tree.root().envelope().upper()];
        let around = AABB::from_corners(low.map(|x| x - margin), high.map(|x| x + margin));
        sorted(self.tree.locate_in_envelope_intersecting(&around))
    }

    /// Lists the places of the edges within a distance of a point, ascending.
    fn around(&self, point: Vector, distance: f64) -> Vec<usize> {
        let squared = (1.0 + ROUND_OFF) * distance * distance;
        sorted(self.tree.locate_within_distance([point[0], point[1]], squared))
    }

    /// Tells whether the nearest point of the side faces a point with an outward normal.
    ///
    /// * `size`: of the smaller body, m; `facing`: the cosine of the largest angle.
    fn is_faced_from(&self, point: Vector, normal: Vector, (size, facing): (f64, f64)) -> bool {
        let place = [point[0], point[1]];
        let Some(distance) = self.tree.nearest_neighbor(&place).map(|edge| edge.distance_2(&place).sqrt())
        else {
            return false;
        };
        let mut best = (f64::INFINITY, Vector::zeros());
        // To round-off several edges may be nearest: the first of them counts.
        for k in self.around(point, distance + ROUND_OFF * size) {
            let [p, q] = self.edges[k].0;
            let along = q - p;
            let s = ((point - p).dot(&along) / along.dot(&along)).clamp(0.0, 1.0);
            let way = p + s * along - point;
            let squared = way.dot(&way);
            if squared < best.0 {
                best = (squared, way);
            }
        }
        let (squared, way) = best;
        let distance = squared.sqrt();
        if !(distance <= size) {
            return false;
        }
        let ahead = distance <= TOUCHING * size || way.dot(&normal) >= facing * norm(way);
        // At a corner of the other side one of its edges faces.
        let corner = |k: &usize| {
            let ([p, q], other) = self.edges[*k];
            let near = TOUCHING * size + norm(q - p);
            other.dot(&normal) <= -facing && [p, q].into_iter().any(|x| norm(x - point - way) <= near)
        };
        ahead && self.around(point + way, TOUCHING * size + self.longest).iter().any(corner)
    }
}

fn sorted<'a>(edges: impl Iterator<Item = &'a Edge>) -> Vec<usize> {
    let mut places: Vec<usize> = edges.map(|edge| edge.data).collect();
    places.sort_unstable();
    places
}

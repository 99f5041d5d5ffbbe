//! The edges of two sides that face each other.

use crate::body::Body;
use crate::geometry::{self, Vector, norm};
use crate::mesh::TriMesh;
use crate::mesh::id::{EdgeId, NodeId};
use std::collections::HashMap;

/// The largest angle between the normals of two facing edges, and between a normal and the way to the other side, radians: a little less
/// than the 60 degrees that pairing allows, so that rounding does not decide.
const FACING: f64 = 59.9 / 180.0 * std::f64::consts::PI;
/// Cosine of the largest turn of a contact line at a node, 60 degrees.
const TURN: f64 = 0.5;
/// Two points closer than this fraction of the smaller body's diagonal are the same.
const TOUCHING: f64 = 1e-6;
/// Points of an edge that are looked at, both ends among them.
const SAMPLES: usize = 9;

/// Selects the edges of two sides that face each other: somewhere on the edge the nearest point of the other side lies within an angle
/// of the edge's normal, and the normals are opposite within this angle. So a roller's rim takes part in a contact only near the other
/// body, and a long side only near what lies on it.
///
/// The angle is 60 degrees, which pairing allows, less half of the largest turn of the two sides: so far the normals at the ends of an
/// edge are from its own. So coarse rims are not refused for their ends.
///
/// * `surfaces`: the edge group of the first and of the second body; a missing one has no edges.
pub fn facing_edges(bodies: [&Body; 2], surfaces: [&str; 2]) -> [Vec<EdgeId>; 2] {
    let sides = [0, 1].map(|b| Side::new(bodies[b].mesh(), surfaces[b]));
    let size =
        bodies.map(|body| geometry::diagonal(body.mesh().points())).into_iter().fold(f64::INFINITY, f64::min);
    let turn = sides.iter().map(|side| side.turn).fold(0.0, f64::max);
    let facing = (FACING - 0.5 * turn).cos();
    [0, 1].map(|b| {
        let (own, other) = (&sides[b], &sides[1 - b]);
        let faces = |place: &usize| {
            let ([p, q], normal) = own.edges[*place];
            (0..SAMPLES).any(|k| {
                let s = k as f64 / (SAMPLES - 1) as f64;
                other.is_faced_from((1.0 - s) * p + s * q, normal, (size, facing))
            })
        };
        (0..own.edges.len()).filter(faces).map(|place| own.numbers[place]).collect()
    })
}

/// A side as a polygon.
struct Side {
    numbers: Vec<EdgeId>,
    /// The ends of each edge, and its outward normal.
    edges: Vec<([Vector; 2], Vector)>,
    /// The largest angle between neighbouring edges, without corners at which a contact line would end, radians.
    turn: f64,
}

impl Side {
    fn new(mesh: &TriMesh, group: &str) -> Self {
        let numbers = mesh.group(group).unwrap_or(&[]).to_vec();
        let edges = numbers.iter().map(|e| (mesh.edge_ends(*e), mesh.edge_normal(*e))).collect();
        let (mut before, mut turn): (HashMap<NodeId, Vector>, f64) = (HashMap::new(), 0.0);
        for edge in &numbers {
            let normal = mesh.edge_normal(*edge);
            for node in mesh.topology().edges()[*edge] {
                if let Some(other) = before.insert(node, normal).filter(|other| other.dot(&normal) >= TURN) {
                    turn = turn.max(geometry::angle_between(other, normal));
                }
            }
        }
        Self { numbers, edges, turn }
    }

    /// Tells whether the nearest point of the side faces a point with an outward normal.
    ///
    /// * `size`: of the smaller body, m; `facing`: the cosine of the largest angle.
    fn is_faced_from(&self, point: Vector, normal: Vector, (size, facing): (f64, f64)) -> bool {
        let mut best = (f64::INFINITY, Vector::zeros());
        for ([p, q], _) in &self.edges {
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
        ahead
            && self.edges.iter().any(|([p, q], other)| {
                let near = TOUCHING * size + norm(q - p);
                other.dot(&normal) <= -facing && [p, q].into_iter().any(|x| norm(x - point - way) <= near)
            })
    }
}

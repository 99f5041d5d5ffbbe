//! An arc from which all normals of a contact line come.

use crate::body::Body;
use crate::geometry::Vector;
use crate::mesh::id::NodeId;

/// The arc that makes up one side of a contact line, as a source of normals `n = (x − c)/R`, with one `R`. They are not normalised, so that a
/// rotation of the side's body about the centre is free for any places of its nodes: `n_i·(ω × x_j) + n_j·(ω × x_i) = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radial {
    /// 0 for the first body, 1 for the second.
    pub side: usize,
    /// The centre of the arc, m.
    pub centre: Vector,
    /// The radius, m; negative if the normal points to the centre.
    pub radius: f64,
}

impl Radial {
    /// Computes the normal at two facing nodes.
    pub fn normal(&self, bodies: [&Body; 2], nodes: [NodeId; 2]) -> Vector {
        self.at(bodies[self.side].mesh().points()[nodes[self.side]])
    }

    /// Computes the normal at a point of the side.
    pub fn at(&self, point: Vector) -> Vector {
        1.0 / self.radius * (point - self.centre)
    }
}

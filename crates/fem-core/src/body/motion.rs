//! Finds the rigid motions that the supports of a body leave free.

use super::Body;
use crate::geometry::{Vector, norm, perpendicular, shown};
use nalgebra::Matrix3;
use std::fmt;

/// A rigid motion that no support prevents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeMotion {
    /// Every translation and rotation: the connected part has no support.
    Everything {
        /// A node of the piece.
        near: Vector,
    },
    /// A translation along a unit vector.
    Translation {
        /// Unit vector.
        direction: Vector,
        /// A node of the piece.
        near: Vector,
    },
    /// A rotation about a point.
    Rotation {
        /// Centre of rotation.
        centre: Vector,
        /// A node of the piece.
        near: Vector,
    },
}

impl FreeMotion {
    /// Returns a node of the piece that can move.
    pub fn near(&self) -> Vector {
        match *self {
            Self::Everything { near } | Self::Translation { near, .. } | Self::Rotation { near, .. } => near,
        }
    }
}

impl fmt::Display for FreeMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Round-off must not be shown as "-0.0000".
        let r = |x: f64| match x.abs() < 1e10 {
            true => shown((x * 1e4).round() / 1e4 + 0.0),
            false => format!("{x:.4e}"),
        };
        match *self {
            Self::Everything { .. } => write!(f, "can translate and rotate freely: it has no support"),
            Self::Translation { direction: d, .. } => {
                write!(f, "can translate along ({}, {})", r(d[0]), r(d[1]))
            }
            Self::Rotation { centre: c, .. } => write!(f, "can rotate about ({}, {})", r(c[0]), r(c[1])),
        }
    }
}

/// A rigid motion of one connected piece that its supports leave free: `u(x) = t + ω e_z × (x − c)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigidMotion {
    /// The piece, see [`crate::mesh::topology::Topology::pieces`].
    pub piece: u32,
    /// `t`.
    pub translation: Vector,
    /// `ω`, 1/m, positive counter-clockwise.
    pub spin: f64,
    /// `c`, m: the middle of the body, or the point about which a rigid side rotates.
    pub centre: Vector,
}

impl RigidMotion {
    /// Computes the displacement of a point of the piece.
    pub fn at(&self, point: Vector) -> Vector {
        self.translation + self.spin * perpendicular(point - self.centre)
    }

    /// Multiplies the motion by a factor.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { translation: factor * self.translation, spin: factor * self.spin, ..self }
    }

    /// Computes the displacement of every node of the body: zero at the nodes of its other pieces.
    ///
    /// * `body`: the one whose motion it is.
    pub fn displacements(&self, body: &Body) -> Vec<Vector> {
        let (piece_of, _) = body.mesh().topology().pieces();
        let points = body.mesh().points().iter().zip(piece_of);
        points
            .map(|(point, piece)| if *piece == self.piece { self.at(*point) } else { Vector::zeros() })
            .collect()
    }
}

pub(super) fn find(body: &Body) -> Option<FreeMotion> {
    let (grams, near) = grams(body);
    let (middle, size) = middle_and_size(body);
    for (gram, near) in grams.into_iter().zip(near) {
        if gram == Matrix3::zeros() {
            return Some(FreeMotion::Everything { near });
        }
        let eigen = gram.symmetric_eigen();
        let (k, smallest) = (0..3)
            .map(|k| (k, eigen.eigenvalues[k]))
            .fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
        if smallest <= HELD * eigen.eigenvalues.amax() {
            let m = eigen.eigenvectors.column(k);
            let (t, w) = (Vector::new(m[0], m[1]), m[2]);
            if w.abs() <= 1e-6 * norm(t) {
                return Some(FreeMotion::Translation { direction: 1.0 / norm(t) * t, near });
            }
            // t + w e_z × (x − middle)/size = 0 at the centre.
            let centre = Vector::new(middle[0] - t[1] / w * size, middle[1] + t[0] / w * size);
            return Some(FreeMotion::Rotation { centre, near });
        }
    }
    None
}

/// Lists a basis of the rigid motions that the supports leave free, orthonormal in `t` and `ω` times the body's size.
pub(super) fn basis(body: &Body) -> Vec<RigidMotion> {
    let (grams, _) = grams(body);
    let (centre, size) = middle_and_size(body);
    let mut found = Vec::new();
    for (piece, gram) in grams.into_iter().enumerate() {
        let eigen = gram.symmetric_eigen();
        let largest = eigen.eigenvalues.amax();
        for k in (0..3).filter(|k| eigen.eigenvalues[*k] <= HELD * largest) {
            let m = eigen.eigenvectors.column(k);
            let (translation, spin) = (Vector::new(m[0], m[1]), m[2] / size);
            found.push(RigidMotion { piece: piece as u32, translation, spin, centre });
        }
    }
    found
}

/// A motion is held if the supports prevent it by more than this fraction of the motion that they prevent best.
const HELD: f64 = 1e-12;

/// The middle of a body, and its size: rotations are about the one and scaled by the other, so that they are comparable
/// with translations.
fn middle_and_size(body: &Body) -> (Vector, f64) {
    let [low, high] = body.mesh().bounding_box();
    (0.5 * (low + high), norm(high - low))
}

/// Computes for each connected piece the Gram matrix of the rigid motions on the imposed components, and a node of it.
fn grams(body: &Body) -> (Vec<Matrix3<f64>>, Vec<Vector>) {
    let (piece_of, pieces) = body.mesh().topology().pieces();
    let points = body.mesh().points();
    let (middle, size) = middle_and_size(body);
    let mut gram = vec![Matrix3::<f64>::zeros(); pieces];
    let mut near = vec![None; pieces];
    for (node, constraint) in body.node_constraints().iter().enumerate() {
        let piece = piece_of[node] as usize;
        let x = 1.0 / size * (points[node] - middle);
        near[piece].get_or_insert(points[node]);
        // Rigid sides as a whole below.
        for d in constraint.supported().basis() {
            let row = nalgebra::RowVector3::new(d[0], d[1], -d[0] * x[1] + d[1] * x[0]);
            gram[piece] += row.transpose() * row;
        }
    }
    for side in body.rigid_sides() {
        let unit =
            |translation, spin| RigidMotion { piece: side.imposed.piece, translation, spin, centre: middle };
        let basis = [unit(Vector::x(), 0.0), unit(Vector::y(), 0.0), unit(Vector::zeros(), 1.0 / size)];
        let [x, y, turn] = basis.each_ref().map(|motion| side.prevented(motion).collect::<Vec<_>>());
        for ((x, y), turn) in x.into_iter().zip(y).zip(turn) {
            let row = nalgebra::RowVector3::new(x, y, turn);
            gram[side.imposed.piece as usize] += row.transpose() * row;
        }
    }
    (gram, near.into_iter().map(|near| near.unwrap_or(middle)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{BoundaryConditions, FacetSelection};
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::TriMesh;
    use crate::mesh::generate::block;

    fn motion(conditions: BoundaryConditions) -> Option<FreeMotion> {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(mesh, material, &conditions).unwrap().free_motion()
    }

    #[test]
    fn supports_that_hold_are_accepted() {
        assert_eq!(motion(BoundaryConditions::new().fix("bottom")), None);
        assert_eq!(motion(BoundaryConditions::new().roller("bottom", 0.0).roller("left", 0.0)), None);
    }

    #[test]
    fn a_motion_moves_the_nodes_of_its_own_piece_alone() {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [5.0, 0.0], [6.0, 0.0], [5.0, 1.0]];
        let mesh = TriMesh::new(points.into(), vec![[0u32, 1, 2], [3, 4, 5]], Vec::new()).unwrap();
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let body = Body::new(mesh, material, &BoundaryConditions::new()).unwrap();
        let motions = body.rigid_motions();
        assert_eq!(motions.len(), 6);
        for motion in motions {
            for (node, (u, point)) in motion.displacements(&body).iter().zip(body.mesh().points()).enumerate()
            {
                let moves = node / 3 == motion.piece as usize;
                assert_eq!(*u, if moves { motion.at(*point) } else { Vector::zeros() });
            }
        }
    }

    #[test]
    fn free_motions_are_named() {
        assert!(matches!(motion(BoundaryConditions::new()), Some(FreeMotion::Everything { .. })));
        match motion(BoundaryConditions::new().roller("bottom", 0.0)) {
            Some(FreeMotion::Translation { direction, .. }) => {
                assert!((direction[0].abs() - 1.0).abs() < 1e-12 && direction[1].abs() < 1e-12);
            }
            other => panic!("{other:?}"),
        }
        // One edge on the left prevents the rotation, but not the motion along it.
        let ends = [[f64::NEG_INFINITY, f64::INFINITY], [f64::NEG_INFINITY, 0.5]];
        let m = motion(BoundaryConditions::new().displace(
            FacetSelection::group("left").within(ends),
            Some(0.0.into()),
            None,
        ));
        assert!(matches!(m, Some(FreeMotion::Translation { .. })), "{m:?}");
        // The normals of a whole ring meet in its centre: the body can rotate about it.
        let mesh = crate::mesh::generate::ring([0.5, -1.0], [1.0, 2.0], [0.0, 360.0], [24, 1]).unwrap();
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let ring = Body::new(mesh, material, &BoundaryConditions::new().roller("outer", 0.0)).unwrap();
        match ring.free_motion() {
            Some(FreeMotion::Rotation { centre, .. }) => {
                assert!((centre[0] - 0.5).abs() < 1e-12 && (centre[1] + 1.0).abs() < 1e-12, "{centre:?}");
            }
            other => panic!("{other:?}"),
        }
    }
}

//! Finds the rigid motions that the supports and springs of a body leave free.

use super::Body;
use crate::geometry::{Coordinates, Point, norm, shown};
use crate::space::{Matrix, Plane, Space};
use std::fmt;

/// A rigid motion that no support prevents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeMotion {
    /// Every translation and rotation: the connected part has no support.
    Everything {
        /// A node of the piece.
        near: Point,
    },
    /// A translation along a unit vector.
    Translation {
        /// Unit vector.
        direction: Point,
        /// A node of the piece.
        near: Point,
    },
    /// A rotation about a point, in space about an axis, along which the piece may slide.
    Rotation {
        /// Centre of rotation, or a point of the axis.
        centre: Point,
        /// In space, the direction of the axis, a unit vector.
        axis: Option<Point>,
        /// A node of the piece.
        near: Point,
    },
}

impl FreeMotion {
    /// Returns a node of the piece that can move.
    pub fn near(&self) -> Point {
        match *self {
            Self::Everything { near } | Self::Translation { near, .. } | Self::Rotation { near, .. } => near,
        }
    }
}

impl fmt::Display for FreeMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Round-off must not be shown as "-0.0000".
        let number = |x: f64| match x.abs() < 1e10 {
            true => shown((x * 1e4).round() / 1e4 + 0.0),
            false => format!("{x:.4e}"),
        };
        let r = |point: &Point| point.shown_with(number);
        match self {
            Self::Everything { .. } => write!(f, "can translate and rotate freely: it has no support"),
            Self::Translation { direction, .. } => write!(f, "can translate along {}", r(direction)),
            Self::Rotation { centre, axis: None, .. } => write!(f, "can rotate about {}", r(centre)),
            Self::Rotation { centre, axis: Some(axis), .. } => {
                write!(f, "can rotate about the axis through {} along {}", r(centre), r(axis))
            }
        }
    }
}

/// A rigid motion of one connected piece that its supports leave free: `u(x) = t + ω × (x − c)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigidMotion<S: Space = Plane> {
    /// The piece, see [`crate::mesh::topology::Topology::pieces`].
    pub piece: u32,
    /// `t`.
    pub translation: S::Vector,
    /// `ω`, 1/m, positive counter-clockwise.
    pub spin: S::Spin,
    /// `c`, m: the middle of the body, or the point about which a rigid side rotates.
    pub centre: S::Vector,
}

impl<S: Space> RigidMotion<S> {
    /// Computes the displacement of a point of the piece.
    pub fn at(&self, point: S::Vector) -> S::Vector {
        self.translation + S::turned(self.spin, point - self.centre)
    }

    /// Multiplies the motion by a factor.
    #[must_use]
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { translation: self.translation * factor, spin: self.spin * factor, ..self }
    }

    /// Computes the displacement of every node of the body: zero at the nodes of its other pieces.
    ///
    /// * `body`: the one whose motion it is.
    pub fn displacements(&self, body: &Body<S>) -> Vec<S::Vector> {
        let (piece_of, _) = body.mesh().topology().pieces();
        let points = body.mesh().points().iter().zip(piece_of);
        points
            .map(|(point, piece)| if *piece == self.piece { self.at(*point) } else { S::Vector::ZERO })
            .collect()
    }
}

pub(super) fn find<S: Space>(body: &Body<S>) -> Option<FreeMotion> {
    let (grams, near) = grams(body);
    let (middle, size) = middle_and_size(body);
    for (gram, near) in grams.into_iter().zip(near) {
        let near = near.into();
        if gram == S::Matrix::default() {
            return Some(FreeMotion::Everything { near });
        }
        let eigen = gram.eigen();
        let (mut smallest, mut free) = (f64::INFINITY, &eigen[0].1);
        for (value, vector) in &eigen {
            if *value < smallest {
                (smallest, free) = (*value, vector);
            }
        }
        if smallest <= HELD * largest::<S>(&eigen) {
            let (t, spin) = S::parts(free);
            let Some((arm, axis)) = S::screw(t, spin) else {
                return Some(FreeMotion::Translation { direction: (t * (1.0 / norm(t))).into(), near });
            };
            let centre = (middle + arm * size).into();
            return Some(FreeMotion::Rotation { centre, axis: axis.map(Point::from), near });
        }
    }
    None
}

/// Returns the eigenvalue of largest magnitude.
fn largest<S: Space>(eigen: &[(f64, S::Components<f64>)]) -> f64 {
    eigen.iter().fold(0.0, |most, (value, _)| value.abs().max(most))
}

/// Lists a basis of the rigid motions that the supports leave free, orthonormal in `t` and `ω` times the body's size.
pub(super) fn basis<S: Space>(body: &Body<S>) -> Vec<RigidMotion<S>> {
    let (grams, _) = grams(body);
    let (centre, size) = middle_and_size(body);
    let mut found = Vec::new();
    for (piece, gram) in grams.into_iter().enumerate() {
        let eigen = gram.eigen();
        let largest = largest::<S>(&eigen);
        for (_, motion) in eigen.iter().filter(|(value, _)| *value <= HELD * largest) {
            let (translation, spin) = S::parts(motion);
            found.push(RigidMotion { piece: piece as u32, translation, spin: spin / size, centre });
        }
    }
    found
}

/// A motion is held if the supports prevent it by more than this fraction of the motion that they prevent best.
const HELD: f64 = 1e-12;

/// The middle of a body, and its size: rotations are about the one and scaled by the other, so that they are comparable
/// with translations.
fn middle_and_size<S: Space>(body: &Body<S>) -> (S::Vector, f64) {
    let [low, high] = body.mesh().bounding_box();
    ((low + high) * 0.5, norm(high - low))
}

/// Computes for each connected piece the Gram matrix of the rigid motions on the imposed components, and a node of it.
fn grams<S: Space>(body: &Body<S>) -> (Vec<S::Matrix>, Vec<S::Vector>) {
    let (piece_of, pieces) = body.mesh().topology().pieces();
    let points = body.mesh().points();
    let (middle, size) = middle_and_size(body);
    let mut gram = vec![S::Matrix::default(); pieces];
    let mut near = vec![None; pieces];
    for (node, constraint) in body.node_constraints().iter().enumerate() {
        let piece = piece_of[node] as usize;
        let x = (points[node] - middle) * (1.0 / size);
        near[piece].get_or_insert(points[node]);
        // Rigid sides as a whole below.
        for d in constraint.supported().basis() {
            gram[piece].add_square(&S::work(*d, x, 1.0));
        }
    }
    for (facet, springs) in body.facet_springs() {
        for node in body.mesh().topology().facets()[facet] {
            let x = (points[node] - middle) * (1.0 / size);
            for d in springs.directions.basis() {
                gram[piece_of[node] as usize].add_square(&S::work(*d, x, 1.0));
            }
        }
    }
    for side in body.rigid_sides() {
        let prevented: Vec<Vec<f64>> = (0..S::COMPONENTS)
            .map(|k| {
                let unit = S::components(|j| if j == k { 1.0 } else { 0.0 });
                let (translation, spin) = S::parts(&unit);
                let motion = RigidMotion { translation, spin: spin / size, centre: middle, ..side.imposed };
                side.prevented(&motion).collect()
            })
            .collect();
        for row in 0..prevented[0].len() {
            gram[side.imposed.piece as usize].add_square(&S::components(|k| prevented[k][row]));
        }
    }
    (gram, near.into_iter().map(|near| near.unwrap_or(middle)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{BoundaryConditions, FacetSelection};
    use crate::geometry::Vector;
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

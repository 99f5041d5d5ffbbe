//! Corrections of face moments that keep every tetrahedron in equilibrium: bars and wrenches, what Airy functions are in the plane.
//!
//! * A *bar* is a pair of opposite forces on a face, along one of its edges at the ends of this edge.
//! * A *wrench* is a force and a torque, `W = (F, M)`, that runs around an edge through all faces of its ring.
//!
//! A face has nine coordinates: the amounts of its bars, and the force `f` and the torque `t` about its centroid `x̄` that act through it. With
//! `y_j = x_j − x̄` the last six have the moments
//! ```math
//! m_j = P (f/3 + θ × y_j),   θ = I⁺ t,   I = ∑ [y_j] P [y_j]ᵀ
//! ```
//! and a wrench about the middle `x_m` of an edge gives every face of the ring `f = ±F` and `t = ±(M − (x̄ − x_m) × F)`. Torques are over the length
//! of the body. `P` projects on the directions in which a face with a condition has a reaction. There wrenches are restricted to those that such
//! moments can carry; a face without a reaction carries none, and its coordinates have no moments. None runs around the rim of a rigid side that
//! may move.

use super::cell::FACE;
use crate::springs::relaxes;
use fem_core::body::{Body, FacetCondition, FacetSprings};
use fem_core::directions::Directions;
use fem_core::geometry::norm;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Solid, Space};
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};
use std::collections::HashSet;

/// Moments on a face about its corners, N.
pub(crate) type FaceMoment = [Vector3<f64>; 3];

/// The faces of a body. Those of the boundary are kept, the spaces of the others follow from their corners.
pub(crate) struct FaceSpaces<'a> {
    pub(crate) body: &'a Body<Solid>,
    /// The length of the body, m.
    pub(crate) length: f64,
    of_boundary: Vec<FaceSpace>,
}

impl<'a> FaceSpaces<'a> {
    /// * `conditions`: of the faces of the boundary.
    pub(crate) fn new(body: &'a Body<Solid>, conditions: &[FacetCondition<Solid>]) -> Self {
        let mesh = body.mesh();
        let length = mesh.diagonal();
        let faces = mesh.topology().boundary_facets().iter().zip(conditions);
        let space = |(face, condition): (&FacetId, _)| {
            FaceSpace::new(mesh.facet_corners(*face), Some(condition), length)
        };
        Self { body, length, of_boundary: faces.map(space).collect() }
    }

    /// Takes other conditions; returns the cells at faces whose moments or springs have changed, ascending.
    pub(crate) fn restate(&mut self, conditions: &[FacetCondition<Solid>]) -> Vec<u32> {
        let (mesh, mut changed) = (self.body.mesh(), Vec::new());
        let topology = mesh.topology();
        let spaces = self.of_boundary.iter_mut().zip(conditions);
        for (face, (space, condition)) in topology.boundary_facets().iter().zip(spaces) {
            if condition.reaction != space.reaction || relaxes(condition) != space.springs.is_some() {
                *space = FaceSpace::new(mesh.facet_corners(*face), Some(condition), self.length);
                changed.push(topology.facet_cells()[*face][0]);
            }
        }
        changed.sort_unstable();
        changed.dedup();
        changed
    }

    fn on_boundary(&self, face: FacetId) -> Option<&FaceSpace> {
        let topology = self.body.mesh().topology();
        topology.is_boundary(face).then(|| &self.of_boundary[topology.boundary_place(face)])
    }

    /// Returns the directions in which a face has a reaction.
    pub(crate) fn reaction(&self, face: FacetId) -> Directions<Solid> {
        self.on_boundary(face).map_or(Directions::ALL, |space| space.reaction)
    }

    /// Returns the springs on a face, if the traction is unknown along them.
    pub(crate) fn springs(&self, face: FacetId) -> Option<&FacetSprings<Solid>> {
        self.on_boundary(face)?.springs.as_deref()
    }

    /// Computes the moments of each unit coordinate of a face.
    pub(crate) fn columns(&self, face: FacetId) -> [FaceMoment; FACE] {
        let corners = self.body.mesh().facet_corners(face);
        match self.on_boundary(face) {
            Some(space) => space.columns(&corners, self.length),
            None => FaceSpace::new(corners, None, self.length).columns(&corners, self.length),
        }
    }
}

/// A singular value below this fraction of the largest one is round-off.
const DEPENDENT: f64 = 1e-8;

/// A face on which moments may change.
struct FaceSpace {
    /// `I⁺` times the length of the body, 1/m.
    inverse: Matrix3<f64>,
    /// The directions of P.
    reaction: Directions<Solid>,
    /// The bars of a face with a condition on some directions; others have those along their edges.
    bars: Option<Vec<FaceMoment>>,
    /// The springs on the face, if the traction is unknown along them.
    springs: Option<Box<FacetSprings<Solid>>>,
}

pub(crate) fn centroid([a, b, c]: &FaceMoment) -> Vector3<f64> {
    (a + b + c) / 3.0
}

impl FaceSpace {
    /// Finds the coordinates of a face.
    ///
    /// * `condition`: of a face of the boundary.
    fn new(corners: FaceMoment, condition: Option<&FacetCondition<Solid>>, length: f64) -> Self {
        let reaction = condition.map_or(Directions::ALL, |condition| condition.reaction);
        let springs = condition.filter(|condition| relaxes(condition)).map(|of| Box::new(of.springs));
        let middle = centroid(&corners);
        let mut inertia = Matrix3::zeros();
        for corner in corners {
            for direction in reaction.basis() {
                let lever = (corner - middle).cross(direction);
                inertia += lever * lever.transpose();
            }
        }
        let inverse = if reaction.is_all() {
            inertia.try_inverse().unwrap_or_default()
        } else {
            inertia.pseudo_inverse(DEPENDENT * inertia.norm()).unwrap_or_default()
        };
        let some = !reaction.is_all() && !reaction.is_none();
        Self { inverse: inverse * length, reaction, bars: some.then(|| bars(&corners, &reaction)), springs }
    }

    /// Computes the moments of each unit coordinate.
    ///
    /// * `length`: of the body.
    fn columns(&self, corners: &FaceMoment, length: f64) -> [FaceMoment; FACE] {
        let mut columns = [[Vector3::zeros(); 3]; FACE];
        if self.reaction.is_none() {
            return columns;
        }
        let project = |v: Vector3<f64>| if self.reaction.is_all() { v } else { self.reaction.project(v) };
        match &self.bars {
            Some(bars) => columns.iter_mut().zip(bars).for_each(|(column, bar)| *column = *bar),
            None => {
                for (k, column) in columns.iter_mut().take(3).enumerate() {
                    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                    column[a] = (corners[b] - corners[a]) / length;
                    column[b] = -column[a];
                }
            }
        }
        let middle = centroid(corners);
        let levers = corners.map(|x| x - middle);
        for axis in 0..3 {
            columns[3 + axis] = [project(Solid::AXES[axis] / 3.0); 3];
            let theta: Vector3<f64> = self.inverse.column(axis).into_owned();
            columns[6 + axis] = levers.map(|y| project(theta.cross(&y)));
        }
        columns
    }
}

/// Columns: the force and the torque over `ℓ`, about `at`, of unit moments along the directions of reaction at each corner.
fn resultants(
    corners: &FaceMoment,
    reaction: &Directions<Solid>,
    (at, length): (Vector3<f64>, f64),
) -> DMatrix<f64> {
    let columns: Vec<Vector6<f64>> = corners
        .iter()
        .flat_map(|x| reaction.basis().iter().map(move |d| (d, (x - at).cross(d) / length)))
        .map(|(d, m)| Vector6::new(d[0], d[1], d[2], m[0], m[1], m[2]))
        .collect();
    DMatrix::from_fn(6, columns.len(), |i, j| columns[j][i])
}

/// Finds all moments along the directions of reaction that have no resultant.
fn bars(corners: &FaceMoment, reaction: &Directions<Solid>) -> Vec<FaceMoment> {
    let map = resultants(corners, reaction, (centroid(corners), norm(corners[1] - corners[0])));
    let eigen = (map.transpose() * &map).symmetric_eigen();
    let floor = DEPENDENT * eigen.eigenvalues.max();
    let none = (0..map.ncols()).filter(|k| eigen.eigenvalues[*k] <= floor);
    let moment = |k: usize, j: usize| -> Vector3<f64> {
        let count = reaction.count();
        reaction.basis().iter().enumerate().map(|(i, d)| d * eigen.eigenvectors[(count * j + i, k)]).sum()
    };
    none.map(|k| [0, 1, 2].map(|j| moment(k, j))).collect()
}

/// Finds the wrenches that moments along the directions of reaction of some faces can carry, as columns; the other columns are zero.
///
/// * `limits`: the corners and directions of these faces; `of_edge`: its middle and length; `length`: of the body.
pub(crate) fn carried(
    limits: &[(FaceMoment, Directions<Solid>)],
    of_edge: (Vector3<f64>, f64),
    length: f64,
) -> Matrix6<f64> {
    let mut basis = Matrix6::zeros();
    if limits.iter().any(|(_, reaction)| reaction.is_none()) {
        return basis;
    }
    // The projections on what the faces cannot carry.
    let mut lost = DMatrix::zeros(6, 6);
    for (corners, reaction) in limits {
        let map = resultants(corners, reaction, of_edge);
        let eigen = (&map * map.transpose()).symmetric_eigen();
        let floor = DEPENDENT * eigen.eigenvalues.max();
        for k in (0..6).filter(|k| eigen.eigenvalues[*k] <= floor) {
            let vector = eigen.eigenvectors.column(k);
            lost += vector * vector.transpose();
        }
    }
    let eigen = lost.symmetric_eigen();
    let kept = (0..6).filter(|k| eigen.eigenvalues[*k] <= DEPENDENT);
    for (mut column, k) in basis.column_iter_mut().zip(kept) {
        let scale = |i: usize| if i < 3 { 1.0 } else { of_edge.1 / length };
        column.iter_mut().enumerate().for_each(|(i, x)| *x = eigen.eigenvectors[(i, k)] * scale(i));
    }
    basis
}

/// Finds the edges around the rigid sides that may move, by their nodes, ascending: a wrench around them would change the resultant on the side.
pub(crate) fn rims(body: &Body<Solid>) -> HashSet<[NodeId; 2]> {
    let mut rims = HashSet::new();
    for side in body.rigid_sides().iter().filter(|side| !side.motions.is_empty()) {
        let mut rim = HashSet::new();
        for face in &side.edges {
            let [a, b, c] = body.mesh().topology().facets()[*face];
            for [i, j] in [[a, b], [b, c], [a, c]] {
                let edge = [i.min(j), i.max(j)];
                if !rim.remove(&edge) {
                    rim.insert(edge);
                }
            }
        }
        rims.extend(rim);
    }
    rims
}

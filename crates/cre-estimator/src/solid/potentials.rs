//! Corrections of face moments that keep every tetrahedron in equilibrium: bars and wrenches, what Airy functions are in the plane.
//!
//! * A *bar* is a pair of opposite forces on a face, along one of its edges at the ends of this edge.
//! * A *wrench* is a force and a moment, `W = (F, M)`, that runs around an edge through all faces of its ring. With the middle `x_m` and the length
//!   `ℓ` of the edge, the centroid `x̄` of a face and `y_j = x_j − x̄` its moments are
//! ```math
//! f_j = ± P (F/3 + θ × y_j),   θ = I⁺ (ℓ M − (x̄ − x_m) × F),   I = ∑ [y_j] P [y_j]ᵀ
//! ```
//! `P` projects on the directions in which a face with a condition has a reaction. There wrenches are restricted to those that such
//! moments can carry, and a face without a reaction carries none. None runs around the rim of a rigid side that may move.

use super::rings::Ring;
use fem_core::body::{Body, FacetCondition};
use fem_core::directions::Directions;
use fem_core::geometry::norm;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::Solid;
use nalgebra::{DMatrix, Matrix3, Vector3, Vector6};
use std::collections::HashSet;

/// Moments on a face about its corners, N.
pub(crate) type FaceMoment = [Vector3<f64>; 3];

/// A singular value below this fraction of the largest one is round-off.
const DEPENDENT: f64 = 1e-8;

/// A face on which moments may change.
pub(crate) struct FaceSpace {
    /// `I⁺`, 1/m².
    inverse: Matrix3<f64>,
    /// The directions of P.
    reaction: Directions<Solid>,
    /// The bars of a face with a condition on some directions; others have those along their edges.
    bars: Option<Vec<FaceMoment>>,
}

/// The spaces of all faces of a body under its conditions.
pub(crate) struct Potentials<'a> {
    pub(crate) body: &'a Body<Solid>,
    spaces: Vec<FaceSpace>,
    /// The edges around the rigid sides that may move, by their nodes, ascending: a wrench would change the resultant on the side.
    rims: HashSet<[NodeId; 2]>,
}

/// An edge with the wrenches and bars of its ring.
pub(crate) struct EdgeSpace {
    middle: Vector3<f64>,
    length: f64,
    /// An orthonormal basis of the wrenches; `None` for all.
    basis: Option<Vec<Vector6<f64>>>,
    /// The number of independent wrenches.
    pub(crate) wrenches: usize,
    /// The faces of the ring.
    pub(crate) faces: Vec<EdgeFace>,
}

/// A face of a ring.
pub(crate) struct EdgeFace {
    pub(crate) face: FacetId,
    /// The positions of its corners, m.
    corners: [Vector3<f64>; 3],
    /// The sense in which wrenches run through it.
    sign: f64,
    /// The number of its bars.
    pub(crate) bars: usize,
}

impl EdgeSpace {
    /// Computes the sum of the basis of wrenches times amounts.
    pub(crate) fn wrench(&self, amounts: &[f64]) -> Vector6<f64> {
        match &self.basis {
            None => Vector6::from_column_slice(&amounts[..6]),
            Some(basis) => basis.iter().zip(amounts).map(|(w, amount)| w * *amount).sum(),
        }
    }

    /// Writes the products of a wrench with the basis.
    pub(crate) fn components(&self, wrench: &Vector6<f64>, to: &mut [f64]) {
        match &self.basis {
            None => to[..6].copy_from_slice(wrench.as_slice()),
            Some(basis) => to.iter_mut().zip(basis).for_each(|(to, w)| *to = w.dot(wrench)),
        }
    }
}

fn centroid([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (a + b + c) / 3.0
}

impl FaceSpace {
    fn new(corners: [Vector3<f64>; 3], reaction: Directions<Solid>) -> Self {
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
        Self { inverse, reaction, bars: some.then(|| bars(&corners, &reaction)) }
    }

    fn bar_count(&self) -> usize {
        match &self.bars {
            Some(bars) => bars.len(),
            None if self.reaction.is_all() => 3,
            None => 0,
        }
    }
}

/// Columns: the force and the moment over `ℓ`, about `at`, of unit moments along the directions of reaction at each corner.
fn resultants(
    corners: &[Vector3<f64>; 3],
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
fn bars(corners: &[Vector3<f64>; 3], reaction: &Directions<Solid>) -> Vec<FaceMoment> {
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

/// Finds the wrenches that moments along the directions of reaction of some faces can carry.
///
/// * `limits`: the corners and directions of these faces; `of_edge`: its middle and length.
fn carried(
    limits: &[(&[Vector3<f64>; 3], &Directions<Solid>)],
    of_edge: (Vector3<f64>, f64),
) -> Vec<Vector6<f64>> {
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
    kept.map(|k| Vector6::from_fn(|i, _| eigen.eigenvectors[(i, k)])).collect()
}

/// Finds the edges of a single face of a rigid side that its supports do not hold.
fn rims(body: &Body<Solid>) -> HashSet<[NodeId; 2]> {
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

impl<'a> Potentials<'a> {
    pub(crate) fn new(body: &'a Body<Solid>, conditions: &[FacetCondition<Solid>]) -> Self {
        let topology = body.mesh().topology();
        let reaction = |face: FacetId| {
            if topology.is_boundary(face) {
                conditions[topology.boundary_place(face)].reaction
            } else {
                Directions::ALL
            }
        };
        let faces = (0..topology.facets().len()).map(FacetId::new);
        let spaces = faces.map(|f| FaceSpace::new(body.mesh().facet_corners(f), reaction(f))).collect();
        Self { body, spaces, rims: rims(body) }
    }

    /// Finds the wrenches and bars of an edge.
    pub(crate) fn edge(&self, ring: Ring<'_>) -> EdgeSpace {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let [i, j] = ring.nodes.map(|n| mesh.points()[n]);
        let (middle, length) = ((i + j) / 2.0, norm(j - i));
        let face = |&face: &FacetId| {
            let corners = mesh.facet_corners(face);
            let third = topology.facets()[face].iter().zip(corners).find(|(n, _)| !ring.nodes.contains(n));
            let across = third.map_or(Vector3::zeros(), |(_, x)| (j - i).cross(&(x - i)));
            let sign = if mesh.facet_normal(face).dot(&across) > 0.0 { 1.0 } else { -1.0 };
            EdgeFace { face, corners, sign, bars: self.spaces[face].bar_count() }
        };
        let faces: Vec<EdgeFace> = ring.faces.iter().map(face).collect();
        let limits: Vec<(&[Vector3<f64>; 3], &Directions<Solid>)> = faces
            .iter()
            .map(|f| (&f.corners, &self.spaces[f.face].reaction))
            .filter(|(_, reaction)| !reaction.is_all())
            .collect();
        let basis = if self.rims.contains(&ring.nodes) {
            Some(Vec::new())
        } else if limits.is_empty() {
            None
        } else if limits.iter().any(|(_, reaction)| reaction.is_none()) {
            Some(Vec::new())
        } else {
            Some(carried(&limits, (middle, length)))
        };
        let wrenches = basis.as_ref().map_or(6, Vec::len);
        EdgeSpace { middle, length, basis, wrenches, faces }
    }

    /// Computes the moments of a wrench on a face of its ring.
    fn of_wrench(&self, edge: &EdgeSpace, face: &EdgeFace, wrench: &Vector6<f64>) -> FaceMoment {
        let space = &self.spaces[face.face];
        let (force, moment) = (wrench.fixed_rows::<3>(0), wrench.fixed_rows::<3>(3));
        let middle = centroid(&face.corners);
        let force = face.sign * force;
        let theta = space.inverse * (face.sign * edge.length * moment - (middle - edge.middle).cross(&force));
        face.corners.map(|x| space.reaction.project(force / 3.0 + theta.cross(&(x - middle))))
    }

    /// Adds the moments of a wrench and of the bars to those of a face.
    ///
    /// * `bars`: a number for each bar of the face.
    pub(crate) fn moments(
        &self,
        edge: &EdgeSpace,
        face: &EdgeFace,
        wrench: &Vector6<f64>,
        bars: &[f64],
    ) -> FaceMoment {
        let mut sum =
            if edge.wrenches == 0 { [Vector3::zeros(); 3] } else { self.of_wrench(edge, face, wrench) };
        match &self.spaces[face.face].bars {
            Some(list) => {
                for (bar, amount) in list.iter().zip(bars) {
                    sum.iter_mut().zip(bar).for_each(|(sum, bar)| *sum += bar * *amount);
                }
            }
            None => {
                for (k, amount) in bars.iter().enumerate() {
                    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                    let bar = (face.corners[b] - face.corners[a]) * (*amount / edge.length);
                    sum[a] += bar;
                    sum[b] -= bar;
                }
            }
        }
        sum
    }

    /// Computes the products of a residual on a face with the moments of unit wrenches, which are added up, and of its bars.
    pub(crate) fn products(
        &self,
        edge: &EdgeSpace,
        face: &EdgeFace,
        residual: &FaceMoment,
        (wrench, bars): (&mut Vector6<f64>, &mut [f64]),
    ) {
        let space = &self.spaces[face.face];
        if edge.wrenches > 0 {
            let residual = residual.map(|r| space.reaction.project(r));
            let middle = centroid(&face.corners);
            let turn: Vector3<f64> =
                face.corners.iter().zip(&residual).map(|(x, r)| (x - middle).cross(r)).sum();
            let phi = space.inverse * turn;
            let force = (residual[0] + residual[1] + residual[2]) / 3.0 - phi.cross(&(middle - edge.middle));
            for axis in 0..3 {
                wrench[axis] += face.sign * force[axis];
                wrench[3 + axis] += face.sign * edge.length * phi[axis];
            }
        }
        match &space.bars {
            Some(list) => {
                for (product, bar) in bars.iter_mut().zip(list) {
                    *product = bar.iter().zip(residual).map(|(b, r)| b.dot(r)).sum();
                }
            }
            None => {
                for (k, product) in bars.iter_mut().enumerate() {
                    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                    let along = (face.corners[b] - face.corners[a]) / edge.length;
                    *product = along.dot(&(residual[a] - residual[b]));
                }
            }
        }
    }
}

//! Sides that stay rigid: their nodes follow three unknowns, each of which is imposed or free under a load.

use super::RigidMotion;
use crate::geometry::{Vector, cross, norm, perpendicular};
use crate::mesh::TriMesh;
use crate::mesh::id::{FacetId, NodeId};
use nalgebra::{Matrix3, RowVector3, Vector3};

/// A direction in which conditions hold a rigid side by less than this fraction (squared) of the best held one is free.
const FREE: f64 = 1e-12;
/// A load along a free motion below this fraction of the whole load is its rounding.
const ROUNDING: f64 = 1e-14;
/// Conditions on a rigid side that differ by less than this fraction of the largest one agree.
const SAME_VALUE: f64 = 1e-9;

/// A side that moves as a rigid body: the displacement of its points is `imposed + Σ z_k motions_k`, with the unknowns `z_k`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigidSide {
    /// The edge group.
    pub group: String,
    /// Its edges, ascending.
    pub edges: Vec<FacetId>,
    /// Its nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// The nodes at its ends, which have one of its edges only; none on a closed line.
    pub ends: Vec<NodeId>,
    /// The motion that its conditions impose.
    pub imposed: RigidMotion,
    /// The motions that they leave free, at most three; of the size of a displacement.
    pub motions: Vec<RigidMotion>,
    /// Resultant of its load, N/m.
    pub force: Vector,
    /// Moment of its load about [`Self::about`], N.
    pub moment: f64,
    /// The point about which it rotates, m.
    pub about: Vector,
    /// Nodal forces of a linear traction that does the work of the load along every free motion, in the order of the nodes,
    /// N/m. On a rigid side any other forces with the same work have the same effect.
    pub forces: Vec<Vector>,
    /// Combinations of the motions of a rigid body that are imposed, orthonormal in `(t_x, t_y, ω size)` about the same point.
    blocked: Vec<[f64; 3]>,
    size: f64,
    /// True for each of ux, uy and the rotation that its own condition imposes.
    pub imposes: [bool; 3],
}

/// One equation of a rigid side: `d·u(x) = value`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Equation {
    pub(super) point: Vector,
    pub(super) direction: Vector,
    pub(super) value: f64,
}

/// The conditions and the loads on a rigid side.
#[derive(Clone, Debug)]
pub(super) struct Given<'a> {
    pub(super) condition: &'a crate::boundary::RigidCondition,
    pub(super) edges: Vec<FacetId>,
    /// The values that other supports impose on its nodes.
    pub(super) equations: Vec<Equation>,
    /// The connected piece of the body.
    pub(super) piece: u32,
}

/// The motion of a rigid side that satisfies some equations best, in `(t_x, t_y, ω size)`.
struct Imposed {
    motion: Vector3<f64>,
    /// The motions that the equations leave free, then those that they impose, orthonormal.
    free: Vec<Vector3<f64>>,
    blocked: Vec<Vector3<f64>>,
}

impl Imposed {
    /// Solves `row·z = value`, by least squares.
    fn new(equations: impl Iterator<Item = (RowVector3<f64>, f64)>) -> Self {
        let (mut gram, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (row, value) in equations {
            gram += row.transpose() * row;
            right += value * row.transpose();
        }
        let eigen = gram.symmetric_eigen();
        let largest = eigen.eigenvalues.amax();
        let mut found = Self { motion: Vector3::zeros(), free: Vec::new(), blocked: Vec::new() };
        for k in 0..3 {
            let v: Vector3<f64> = eigen.eigenvectors.column(k).into();
            if eigen.eigenvalues[k] <= FREE * largest {
                found.free.push(v);
            } else {
                found.motion += v.dot(&right) / eigen.eigenvalues[k] * v;
                found.blocked.push(v);
            }
        }
        found
    }

    /// Tells whether the equations determine `row·z`.
    fn blocks(&self, row: &RowVector3<f64>) -> bool {
        let left = self.free.iter().map(|v| (row * v)[0].powi(2)).sum::<f64>();
        left <= FREE.sqrt() * row.norm_squared()
    }
}

impl RigidSide {
    /// Finds the imposed motion and the free ones.
    ///
    /// # Errors
    /// The equation that contradicts the others, and the value that the others impose.
    pub(super) fn new(mesh: &TriMesh, given: Given<'_>) -> Result<Self, (Equation, f64)> {
        let Given { condition, edges, equations, piece } = given;
        let mut ends_of: Vec<NodeId> = edges.iter().flat_map(|e| mesh.topology().facets()[*e]).collect();
        ends_of.sort_unstable();
        let mut nodes = ends_of.clone();
        nodes.dedup();
        let ends = ends_of.chunk_by(|a, b| a == b).filter(|of| of.len() == 1).map(|of| of[0]).collect();
        let weights = weights(mesh, &edges, &nodes);
        let points: Vec<Vector> = nodes.iter().map(|n| mesh.points()[*n]).collect();
        let length: f64 = weights.iter().sum();
        let centroid = 1.0 / length * points.iter().zip(&weights).map(|(x, w)| *w * x).sum::<Vector>();
        let about = condition.about.unwrap_or(centroid);
        let size = points.iter().map(|x| norm(x - centroid)).fold(0.0, f64::max);

        let row = |e: &Equation| {
            let arm = 1.0 / size * perpendicular(e.point - about);
            RowVector3::new(e.direction[0], e.direction[1], e.direction.dot(&arm))
        };
        let [x, y] = condition.translation;
        let own = [x, y, condition.rotation.map(|turn| turn * size)];
        let solved = |equations: &[Equation]| {
            let own = own.iter().enumerate().filter_map(|(c, value)| {
                let mut row = RowVector3::zeros();
                row[c] = 1.0;
                Some((row, (*value)?))
            });
            Imposed::new(own.chain(equations.iter().map(|e| (row(e), e.value))))
        };
        let Imposed { motion: imposed, free, blocked } = solved(&equations);
        let scale = equations.iter().map(|e| e.value.abs()).chain(own.iter().flatten().map(|v| v.abs()));
        let scale = scale.fold(0.0, f64::max);
        let found = |imposed: &Vector3<f64>, e: &Equation| (row(e) * imposed)[0];
        let contradicted = |imposed: &Vector3<f64>, e: &Equation| {
            !((found(imposed, e) - e.value).abs() <= SAME_VALUE * scale)
        };
        if let Some(last) = equations.iter().find(|e| contradicted(&imposed, e)) {
            // The least squares above contradict many equations. The error names the first one that the earlier equations contradict.
            let before = |k: &usize| solved(&equations[..*k]);
            let holds = |k: &usize, e: &Equation| before(k).blocks(&row(e));
            let first = (0..equations.len())
                .filter(|k| holds(k, &equations[*k]))
                .map(|k| (equations[k], found(&before(&k).motion, &equations[k])))
                .find(|(e, found)| !((found - e.value).abs() <= SAME_VALUE * scale));
            return Err(first.unwrap_or((*last, found(&imposed, last))));
        }
        let motion = |v: Vector3<f64>| RigidMotion {
            piece,
            translation: Vector::new(v[0], v[1]),
            spin: v[2] / size,
            centre: about,
        };
        // Only what acts along free motions: the rest goes into supports, and its rounding must not reach the body.
        let given = Vector3::new(condition.force[0], condition.force[1], condition.moment / size);
        let along =
            |v: &Vector3<f64>| Some(v.dot(&given)).filter(|load| load.abs() > ROUNDING * given.norm());
        let acting: Vector3<f64> = free.iter().filter_map(|v| Some(along(v)? * v)).sum();
        let resultant = Vector::new(acting[0], acting[1]);
        // A linear traction with these resultants about the centroid.
        let moment = acting[2] * size + cross(about - centroid, resultant);
        let inertia: f64 = points.iter().zip(&weights).map(|(x, w)| w * (x - centroid).norm_squared()).sum();
        let force = |(x, w): (&Vector, &f64)| {
            *w * (1.0 / length * resultant + moment / inertia * perpendicular(x - centroid))
        };
        Ok(Self {
            group: condition.edges.on.clone(),
            ends,
            imposed: motion(imposed),
            motions: free.into_iter().map(motion).collect(),
            force: condition.force,
            moment: condition.moment,
            about,
            forces: points.iter().zip(&weights).map(force).collect(),
            imposes: own.map(|value| value.is_some()),
            blocked: blocked.iter().map(|v| [v[0], v[1], v[2]]).collect(),
            size,
            edges,
            nodes,
        })
    }

    /// Lists the work of what is blocked against a rigid motion of the body, one number per imposed combination: all zero if
    /// the side is free to follow it.
    pub(super) fn prevented(&self, motion: &RigidMotion) -> impl Iterator<Item = f64> + '_ {
        let at = motion.at(self.about);
        let q = [at[0], at[1], motion.spin * self.size];
        self.blocked.iter().map(move |row| row.iter().zip(q).map(|(a, b)| a * b).sum())
    }

    /// Finds the rigid motion that is nearest to the displacement of the side's nodes, and the largest difference, m.
    ///
    /// * `displacement`: of all nodes of the body, m.
    pub fn motion_of(&self, points: &[Vector], displacement: &[Vector]) -> (RigidMotion, f64) {
        let count = self.nodes.len() as f64;
        let mean = |of: &[Vector]| 1.0 / count * self.nodes.iter().map(|n| of[*n]).sum::<Vector>();
        let (middle, moved) = (mean(points), mean(displacement));
        let (mut turned, mut inertia) = (0.0, 0.0);
        for &n in &self.nodes {
            let arm = points[n] - middle;
            turned += cross(arm, displacement[n] - moved);
            inertia += arm.norm_squared();
        }
        let spin = turned / inertia;
        let translation = moved + spin * perpendicular(self.about - middle);
        let motion = RigidMotion { translation, spin, centre: self.about, ..self.imposed };
        let difference = |n: &NodeId| norm(displacement[*n] - motion.at(points[*n]));
        let largest = self.nodes.iter().map(difference).fold(0.0, f64::max);
        (motion, largest)
    }

    /// Finds the motion that its conditions allow and that is nearest to a displacement.
    ///
    /// * `displacement`: of all nodes of the body, m.
    pub fn allowed_near(&self, points: &[Vector], displacement: &[Vector]) -> RigidMotion {
        let (mut motion, _) = self.motion_of(points, displacement);
        let found = self.prevented(&motion).zip(self.prevented(&self.imposed));
        let missed: Vec<f64> = found.map(|(found, imposed)| found - imposed).collect();
        for (row, missed) in self.blocked.iter().zip(missed) {
            motion.translation -= missed * Vector::new(row[0], row[1]);
            motion.spin -= missed * row[2] / self.size;
        }
        motion
    }

    /// Finds by how much a displacement violates the condition: the largest distance of a node from a rigid motion, and of that
    /// motion from what is imposed, m.
    ///
    /// * `displacement`: of all nodes of the body, m.
    pub fn violation(&self, points: &[Vector], displacement: &[Vector]) -> f64 {
        let (motion, largest) = self.motion_of(points, displacement);
        let found = self.prevented(&motion).zip(self.prevented(&self.imposed));
        found.map(|(found, imposed)| (found - imposed).abs()).fold(largest, f64::max)
    }
}

/// Computes the length of the side that belongs to each of its nodes, m.
fn weights(mesh: &TriMesh, edges: &[FacetId], nodes: &[NodeId]) -> Vec<f64> {
    let mut weights = vec![0.0; nodes.len()];
    for &edge in edges {
        for node in mesh.topology().facets()[edge] {
            if let Ok(place) = nodes.binary_search(&node) {
                weights[place] += 0.5 * mesh.facet_measure(edge);
            }
        }
    }
    weights
}

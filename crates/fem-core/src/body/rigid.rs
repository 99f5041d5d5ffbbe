//! Sides that stay rigid: their nodes follow unknowns, one for each rigid motion, each of which is imposed or free under a load.

use super::RigidMotion;
use crate::geometry::norm;
use crate::mesh::Mesh;
use crate::mesh::id::{FacetId, NodeId};
use crate::space::{Matrix, Plane, Space};
use std::collections::BTreeMap;

/// A direction in which conditions hold a rigid side by less than this fraction (squared) of the best held one is free.
const FREE: f64 = 1e-12;
/// A load along a free motion below this fraction of the whole load is its rounding.
const ROUNDING: f64 = 1e-14;
/// Conditions on a rigid side that differ by less than this fraction of the largest one agree.
const SAME_VALUE: f64 = 1e-9;

/// A side that moves as a rigid body: the displacement of its points is `imposed + Σ z_k motions_k`, with the unknowns `z_k`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigidSide<S: Space = Plane> {
    /// The group of facets.
    pub group: String,
    /// Its facets, ascending.
    pub edges: Vec<FacetId>,
    /// Its nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// The nodes at its ends, in space on its rim; none if it is closed.
    pub ends: Vec<NodeId>,
    /// The motion that its conditions impose.
    pub imposed: RigidMotion<S>,
    /// The motions that they leave free, at most one of each; of the size of a displacement.
    pub motions: Vec<RigidMotion<S>>,
    /// Resultant of its load, N/m in the plane, N in space.
    pub force: S::Vector,
    /// Moment of its load about [`Self::about`], N in the plane, N m in space.
    pub moment: S::Spin,
    /// The point about which it rotates, m.
    pub about: S::Vector,
    /// Nodal forces of a linear traction that does the work of the load along every free motion, in the order of the nodes,
    /// N/m. On a rigid side any other forces with the same work have the same effect.
    pub forces: Vec<S::Vector>,
    /// Combinations of the motions of a rigid body that are imposed, orthonormal in `(t, ω size)` about the same point.
    blocked: Vec<S::Components<f64>>,
    size: f64,
    /// True for each displacement and rotation that its own condition imposes.
    pub imposes: S::Components<bool>,
}

/// One equation of a rigid side: `d·u(x) = value`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Equation<S: Space> {
    pub(super) point: S::Vector,
    pub(super) direction: S::Vector,
    pub(super) value: f64,
}

/// The conditions and the loads on a rigid side.
#[derive(Clone, Debug)]
pub(super) struct Given<'a, S: Space> {
    pub(super) condition: &'a crate::boundary::RigidCondition<S>,
    pub(super) edges: Vec<FacetId>,
    /// The values that other supports impose on its nodes.
    pub(super) equations: Vec<Equation<S>>,
    /// The connected piece of the body.
    pub(super) piece: u32,
}

/// The motion of a rigid side that satisfies some equations best, in `(t, ω size)`.
struct Imposed<S: Space> {
    motion: S::Components<f64>,
    /// The motions that the equations leave free, then those that they impose, orthonormal.
    free: Vec<S::Components<f64>>,
    blocked: Vec<S::Components<f64>>,
}

/// Computes the sum of products.
fn dot<S: Space>(a: &S::Components<f64>, b: &S::Components<f64>) -> f64 {
    (1..S::COMPONENTS).fold(a[0] * b[0], |sum, k| sum + a[k] * b[k])
}

/// Adds a multiple of some numbers to others.
fn add<S: Space>(sum: &mut S::Components<f64>, factor: f64, numbers: &S::Components<f64>) {
    for k in 0..S::COMPONENTS {
        sum[k] += factor * numbers[k];
    }
}

impl<S: Space> Imposed<S> {
    /// Solves `row·z = value`, by least squares.
    fn new(equations: impl Iterator<Item = (S::Components<f64>, f64)>) -> Self {
        let zero = S::components(|_| 0.0);
        let (mut gram, mut right) = (S::Matrix::default(), zero);
        for (row, value) in equations {
            gram.add_square(&row);
            add::<S>(&mut right, value, &row);
        }
        let eigen = gram.eigen();
        let largest = eigen.iter().fold(0.0, |most: f64, (value, _)| value.abs().max(most));
        let mut found = Self { motion: zero, free: Vec::new(), blocked: Vec::new() };
        for (value, v) in eigen {
            if value <= FREE * largest {
                found.free.push(v);
            } else {
                add::<S>(&mut found.motion, dot::<S>(&v, &right) / value, &v);
                found.blocked.push(v);
            }
        }
        found
    }

    /// Tells whether the equations determine `row·z`.
    fn blocks(&self, row: &S::Components<f64>) -> bool {
        let left = self.free.iter().map(|v| dot::<S>(row, v).powi(2)).sum::<f64>();
        left <= FREE.sqrt() * dot::<S>(row, row)
    }
}

/// Lists the nodes on the rim of a side: what is left of a facet without one corner, and of no other one.
fn rim<S: Space>(mesh: &Mesh<S>, facets: &[FacetId]) -> Vec<NodeId> {
    let mut counts: BTreeMap<Vec<NodeId>, usize> = BTreeMap::new();
    for facet in facets {
        let nodes = mesh.topology().facets()[*facet];
        for left_out in nodes {
            let rest = nodes.into_iter().filter(|n| *n != left_out).collect();
            *counts.entry(rest).or_default() += 1;
        }
    }
    let mut nodes: Vec<NodeId> =
        counts.into_iter().filter(|(_, n)| *n == 1).flat_map(|(nodes, _)| nodes).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

impl<S: Space> RigidSide<S> {
    /// Finds the imposed motion and the free ones.
    ///
    /// # Errors
    /// The equation that contradicts the others, and the value that the others impose.
    pub(super) fn new(mesh: &Mesh<S>, given: Given<'_, S>) -> Result<Self, (Equation<S>, f64)> {
        let Given { condition, edges, equations, piece } = given;
        let mut nodes: Vec<NodeId> = edges.iter().flat_map(|e| mesh.topology().facets()[*e]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let weights = weights(mesh, &edges, &nodes);
        let points: Vec<S::Vector> = nodes.iter().map(|n| mesh.points()[*n]).collect();
        let weighted = || points.iter().copied().zip(weights.iter().copied());
        let whole: f64 = weights.iter().sum();
        let centroid = weighted().map(|(x, w)| x * w).sum::<S::Vector>() * (1.0 / whole);
        let about = condition.about.unwrap_or(centroid);
        let size = points.iter().map(|x| norm(*x - centroid)).fold(0.0, f64::max);

        let row = |e: &Equation<S>| S::work(e.direction, e.point - about, 1.0 / size);
        let scaled = |k: usize, value: f64| if k < S::DIM { value } else { value * size };
        let own = S::components(|k| condition.motion[k].map(|value| scaled(k, value)));
        let solved = |equations: &[Equation<S>]| {
            let own = own
                .into_iter()
                .enumerate()
                .filter_map(|(c, value)| Some((S::components(|k| if k == c { 1.0 } else { 0.0 }), value?)));
            Imposed::<S>::new(own.chain(equations.iter().map(|e| (row(e), e.value))))
        };
        let Imposed { motion: imposed, free, blocked } = solved(&equations);
        let scale = equations.iter().map(|e| e.value.abs()).chain(own.into_iter().flatten().map(f64::abs));
        let scale = scale.fold(0.0, f64::max);
        let found = |imposed: &S::Components<f64>, e: &Equation<S>| dot::<S>(&row(e), imposed);
        let contradicted = |imposed: &S::Components<f64>, e: &Equation<S>| {
            !((found(imposed, e) - e.value).abs() <= SAME_VALUE * scale)
        };
        if let Some(last) = equations.iter().find(|e| contradicted(&imposed, e)) {
            // The least squares above contradict many equations. The error names the first one that the earlier equations contradict.
            let before = |k: &usize| solved(&equations[..*k]);
            let holds = |k: &usize, e: &Equation<S>| before(k).blocks(&row(e));
            let first = (0..equations.len())
                .filter(|k| holds(k, &equations[*k]))
                .map(|k| (equations[k], found(&before(&k).motion, &equations[k])))
                .find(|(e, found)| !((found - e.value).abs() <= SAME_VALUE * scale));
            return Err(first.unwrap_or((*last, found(&imposed, last))));
        }
        let motion = |v: S::Components<f64>| {
            let (translation, spin) = S::parts(&v);
            RigidMotion { piece, translation, spin: spin / size, centre: about }
        };
        let acting = acting::<S>(&S::motion(condition.force, condition.moment / size), &free);
        // A linear traction with these resultants about the centroid.
        let (resultant, moment) = S::parts(&acting);
        let moment = moment * size + S::moment(about - centroid, resultant);
        let spin = S::spin_of(moment, weighted().map(|(x, w)| (w, x - centroid)));
        let force =
            |(x, w): (S::Vector, f64)| (resultant * (1.0 / whole) + S::turned(spin, x - centroid)) * w;
        Ok(Self {
            group: condition.edges.on.clone(),
            ends: rim(mesh, &edges),
            imposed: motion(imposed),
            motions: free.into_iter().map(motion).collect(),
            force: condition.force,
            moment: condition.moment,
            about,
            forces: weighted().map(force).collect(),
            imposes: S::components(|k| own[k].is_some()),
            blocked,
            size,
            edges,
            nodes,
        })
    }

    /// Lists the work of what is blocked against a rigid motion of the body, one number per imposed combination: all zero if
    /// the side is free to follow it.
    pub(super) fn prevented(&self, motion: &RigidMotion<S>) -> impl Iterator<Item = f64> + '_ {
        let q = S::motion(motion.at(self.about), motion.spin * self.size);
        self.blocked.iter().map(move |row| dot::<S>(row, &q))
    }

    /// Finds the rigid motion that is nearest to the displacement of the side's nodes, and the largest difference, m.
    ///
    /// * `displacement`: of all nodes of the body, m.
    pub fn motion_of(&self, points: &[S::Vector], displacement: &[S::Vector]) -> (RigidMotion<S>, f64) {
        let count = self.nodes.len() as f64;
        let mean = |of: &[S::Vector]| self.nodes.iter().map(|n| of[*n]).sum::<S::Vector>() * (1.0 / count);
        let (middle, moved) = (mean(points), mean(displacement));
        let mut turned = S::Spin::default();
        for &n in &self.nodes {
            turned += S::moment(points[n] - middle, displacement[n] - moved);
        }
        let spin = S::spin_of(turned, self.nodes.iter().map(|n| (1.0, points[*n] - middle)));
        let translation = moved + S::turned(spin, self.about - middle);
        let motion = RigidMotion { translation, spin, centre: self.about, ..self.imposed };
        let difference = |n: &NodeId| norm(displacement[*n] - motion.at(points[*n]));
        let largest = self.nodes.iter().map(difference).fold(0.0, f64::max);
        (motion, largest)
    }

    /// Finds the motion that its conditions allow and that is nearest to a displacement.
    ///
    /// * `displacement`: of all nodes of the body, m.
    pub fn allowed_near(&self, points: &[S::Vector], displacement: &[S::Vector]) -> RigidMotion<S> {
        let (mut motion, _) = self.motion_of(points, displacement);
        let found = self.prevented(&motion).zip(self.prevented(&self.imposed));
        let missed: Vec<f64> = found.map(|(found, imposed)| found - imposed).collect();
        for (row, missed) in self.blocked.iter().zip(missed) {
            let (translation, spin) = S::parts(row);
            motion.translation -= translation * missed;
            motion.spin -= spin * missed / self.size;
        }
        motion
    }

    /// Finds by how much a displacement violates the condition: the largest distance of a node from a rigid motion, and of that
    /// motion from what is imposed, m.
    ///
    /// * `displacement`: of all nodes of the body, m.
    pub fn violation(&self, points: &[S::Vector], displacement: &[S::Vector]) -> f64 {
        let (motion, largest) = self.motion_of(points, displacement);
        let found = self.prevented(&motion).zip(self.prevented(&self.imposed));
        found.map(|(found, imposed)| (found - imposed).abs()).fold(largest, f64::max)
    }
}

/// Computes the load that acts along free motions: the rest goes into supports, and its rounding must not reach the body.
fn acting<S: Space>(given: &S::Components<f64>, free: &[S::Components<f64>]) -> S::Components<f64> {
    let size = dot::<S>(given, given).sqrt();
    let mut acting = S::components(|_| 0.0);
    for v in free {
        let load = dot::<S>(v, given);
        if load.abs() > ROUNDING * size {
            add::<S>(&mut acting, load, v);
        }
    }
    acting
}

/// Computes the part of the side that belongs to each of its nodes, m or m².
fn weights<S: Space>(mesh: &Mesh<S>, facets: &[FacetId], nodes: &[NodeId]) -> Vec<f64> {
    let mut weights = vec![0.0; nodes.len()];
    for &facet in facets {
        for node in mesh.topology().facets()[facet] {
            if let Ok(place) = nodes.binary_search(&node) {
                weights[place] += mesh.facet_measure(facet) / S::DIM as f64;
            }
        }
    }
    weights
}

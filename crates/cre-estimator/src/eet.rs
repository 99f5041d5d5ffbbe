//! EET: edge tractions in equilibrium with an FE stress (Ladevèze and Leguillon 1983).
//!
//! For each vertex `i` the moments `b_Γ = ∫_Γ F_Γ φ_i ds` on the edges of its star satisfy, for every
//! triangle `E` of the star,
//! ```math
//! ∑_{Γ ∋ i} ± b_Γ = ∫_E σ̂ ∇φ_i − ∫_E b φ_i
//! ```
//! The chosen solution is closest to the average FE traction (least `Σ |b − b̄|²/|Γ|`).
//!
//! The triangles of a star are consecutive around the vertex, so one moment determines all others: the
//! system has one free vector. Conditions at the ends of an open star fix it completely or partly; the rest
//! is a weighted mean. This needs no matrix and no rank decision.

use crate::shared::Shared;
use crate::star::{self, Star};
use fem_core::body::{Body, EdgeCondition, EdgeReaction};
use fem_core::element::Triangle;
use fem_core::geometry::{Vector, cross, perpendicular};
use fem_core::mesh::id::{EdgeId, NodeId};
use fem_core::parallel::for_each_task;
use fem_core::tensor::SymTensor2;
use rayon::prelude::*;

/// Moments `∫_Γ F_Γ φ ds` about the two nodes of every edge, N/m. `F_Γ` acts on the edge's first triangle.
pub type EdgeMoments = Vec<[Vector; 2]>;

/// Vertices handled by one task.
const CHUNK: usize = 1024;

/// Computes edge moments in equilibrium with the FE stress `stress` (one per triangle, Pa): around every vertex `i`
/// ```math
/// ∑_{Γ ∋ i} ± b_Γ = ∫_E σ̂ ∇φ_i − ∫_E b φ_i,   b_Γ = ∫_Γ F_Γ φ_i,   ∑ |b_Γ − b̄_Γ|²/|Γ| least     (19)
/// ```
///
/// * `conditions`: the condition on each boundary edge, in the order of
///   [`fem_core::mesh::topology::Topology::boundary_edges`].
///
/// `stress` must satisfy the FE equilibrium in every direction whose traction is given; otherwise the
/// residual appears in [`crate::check()`].
pub fn edge_moments(body: &Body, stress: &[SymTensor2], conditions: &[EdgeCondition]) -> EdgeMoments {
    let mesh = body.mesh();
    let recovery = Recovery { body, stress, conditions };
    let nodes = mesh.points().len();
    let edges = mesh.topology().edges().len();
    // Each number is written from one vertex.
    let found = Shared::zeros(4 * edges);
    for_each_task(nodes.div_ceil(CHUNK), &|k| {
        let (mut star, mut relative) = (Star::default(), Vec::new());
        for node in k * CHUNK..nodes.min((k + 1) * CHUNK) {
            recovery.vertex(NodeId::new(node), &mut star, &mut relative, &found);
        }
    });
    let moments =
        |e: usize| [0, 2].map(|end| Vector::new(found.get(4 * e + end), found.get(4 * e + end + 1)));
    (0..edges).into_par_iter().with_min_len(CHUNK).map(moments).collect()
}

struct Recovery<'a> {
    body: &'a Body,
    stress: &'a [SymTensor2],
    conditions: &'a [EdgeCondition],
}

impl Recovery<'_> {
    /// Finds the moments about a vertex. `star` and `relative` are working space.
    fn vertex(&self, node: NodeId, star: &mut Star, relative: &mut Vec<Vector>, found: &Shared) {
        star.walk(self.body.mesh(), node);
        self.differences(node, star, relative);
        let mean = self.mean(node, star, relative);
        let first = if star.is_closed() { mean } else { self.fit_ends(node, star, relative, mean) };
        let topology = self.body.mesh().topology();
        for (j, &edge) in star.spokes.iter().enumerate() {
            let after = first + relative[j];
            // The moment acts on the edge's first triangle.
            let is_first =
                j < star.triangles.len() && topology.edge_triangles()[edge][0] == star.triangles[j];
            let moment = if is_first { after } else { -after };
            let place = 4 * edge.index() + 2 * usize::from(topology.edges()[edge][1] == node);
            found.set(place, moment[0]);
            found.set(place + 1, moment[1]);
        }
    }

    /// Moment `c_{j+1} = c_j − Q_j` on each spoke, acting on the triangle after it, relative to the first.
    fn differences(&self, node: NodeId, star: &Star, relative: &mut Vec<Vector>) {
        let mesh = self.body.mesh();
        relative.clear();
        let mut c = Vector::zeros();
        relative.push(c);
        for &t in &star.triangles {
            let corner = star::corner(mesh, t, node);
            let t = t as usize;
            let element = Triangle::new(mesh.corners(t));
            let internal = element.internal_forces(self.stress[t])[corner];
            let load = element.area / 3.0 * self.body.body_force();
            c -= internal - load;
            relative.push(c);
        }
        relative.truncate(star.spokes.len());
    }

    /// The first moment for which all moments are closest to the average FE tractions, without conditions at the ends.
    fn mean(&self, node: NodeId, star: &Star, relative: &[Vector]) -> Vector {
        let mesh = self.body.mesh();
        let count = star.triangles.len();
        let mut sum = Vector::zeros();
        let mut weights = 0.0;
        for (j, &edge) in star.spokes.iter().enumerate() {
            let [a, b] = mesh.topology().edges()[edge];
            assert!(a == node || b == node, "edge {edge} from {a} to {b} does not start at node {node}");
            let (from, to) = (mesh.points()[node], mesh.points()[if a == node { b } else { a }]);
            let along = to - from;
            // Outward normal of the triangle after the spoke, which lies to its left, times the length.
            let normal = Vector::new(along[1], -along[0]);
            let closed = star.is_closed();
            let after = if j < count { Some(star.triangles[j]) } else { None };
            let before = match j {
                0 if closed => Some(star.triangles[count - 1]),
                0 => None,
                _ => Some(star.triangles[j - 1]),
            };
            let sides = [after, before].into_iter().flatten();
            let mut traction = Vector::zeros();
            let mut found = 0.0;
            for t in sides {
                traction += self.stress[t as usize].apply(normal);
                found += 1.0;
            }
            // b̄ = |Γ|/2 F̄, weight 1/|Γ|
            let average = 0.5 / found * traction;
            // Without the guard of `hypot` against overflow.
            let weight = 1.0 / along.dot(&along).sqrt();
            sum += weight * (average - relative[j]);
            weights += weight;
        }
        1.0 / weights * sum
    }

    /// Changes the mean so that it satisfies the conditions on the two boundary edges of an open star.
    fn fit_ends(&self, node: NodeId, star: &Star, relative: &[Vector], mean: Vector) -> Vector {
        let last = star.spokes.len() - 1;
        let mut given: Vec<(Vector, f64)> = Vec::with_capacity(4);
        for (spoke, sign) in [(0, 1.0), (last, -1.0)] {
            let (reaction, moment) = self.boundary(node, star.spokes[spoke]);
            // On the last spoke the triangle lies before it, so that the moment on it is −c.
            let value = sign * moment - relative[spoke];
            match reaction {
                EdgeReaction::None => {
                    given.push((Vector::x(), value[0]));
                    given.push((Vector::y(), value[1]));
                }
                EdgeReaction::Along(d) => given.push((perpendicular(d), perpendicular(d).dot(&value))),
                EdgeReaction::Both => {}
            }
        }
        let Some(&(e, value)) = given.first() else { return mean };
        // Of the others the most perpendicular to the first; a parallel one is equivalent, by FE equilibrium.
        let other =
            given[1..].iter().copied().max_by(|a, b| cross(e, a.0).abs().total_cmp(&cross(e, b.0).abs()));
        match other {
            Some((d, second)) if cross(e, d).abs() > 1e-6 => {
                let sine = cross(e, d);
                Vector::new(value * d[1] - second * e[1], e[0] * second - d[0] * value) / sine
            }
            _ => mean + (value - e.dot(&mean)) * e,
        }
    }

    /// Returns the condition on a boundary edge: directions of reaction, and the moment about `node`.
    fn boundary(&self, node: NodeId, edge: EdgeId) -> (EdgeReaction, Vector) {
        let mesh = self.body.mesh();
        let place = mesh.topology().boundary_place(edge);
        let condition = &self.conditions[place];
        let [a, b] = condition.traction;
        let first = mesh.topology().edges()[edge][0] == node;
        let (near, far) = if first { (a, b) } else { (b, a) };
        let moment = mesh.edge_length(edge) / 6.0 * (2.0 * near + far);
        (condition.reaction, moment)
    }
}

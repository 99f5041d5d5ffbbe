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

use crate::atomic_slots::AtomicSlots;
use crate::equilibrated::FacetMoments;
use crate::springs::relaxes;
use crate::star::{Spoke, Star, StarList};
use fem_core::body::{Body, FacetCondition};
use fem_core::directions::with_products;
use fem_core::geometry::{Vector, cross, perpendicular};
use fem_core::mesh::id::NodeId;
use fem_core::parallel::for_each_task;
use fem_core::space::Plane;
use fem_core::tensor::SymTensor2;
use nalgebra::Matrix2;
use rayon::prelude::*;

/// Vertices handled by one task.
const CHUNK: usize = 1024;

/// Computes edge moments in equilibrium with the FE stress `stress` (one per triangle, Pa): around every vertex `i`
/// ```math
/// ∑_{Γ ∋ i} ± b_Γ = ∫_E σ̂ ∇φ_i − ∫_E b φ_i,   b_Γ = ∫_Γ F_Γ φ_i,   ∑ |b_Γ − b̄_Γ|²/|Γ| least     (19)
/// ```
///
/// * `conditions`: the condition on each boundary edge, in the order of
///   [`fem_core::mesh::topology::Topology::boundary_facets`].
///
/// `stress` must satisfy the FE equilibrium in every direction whose traction is given; otherwise the
/// residual appears in [`crate::check()`].
pub fn facet_moments(body: &Body, stress: &[SymTensor2], conditions: &[FacetCondition]) -> FacetMoments {
    let mesh = body.mesh();
    let recovery = Recovery { body, stress, conditions };
    let nodes = mesh.points().len();
    let edges = mesh.topology().facets().len();
    // Each number is written from one vertex.
    let found = AtomicSlots::zeros(4 * edges);
    for_each_task(nodes.div_ceil(CHUNK), &|k| {
        let mut work = Work::default();
        for node in k * CHUNK..nodes.min((k + 1) * CHUNK) {
            recovery.vertex(NodeId::new(node), &mut work, &found);
        }
    });
    let moments =
        |e: usize| [0, 2].map(|end| Vector::new(found.get(4 * e + end), found.get(4 * e + end + 1)));
    (0..edges).into_par_iter().with_min_len(CHUNK).map(moments).collect()
}

struct Recovery<'a> {
    body: &'a Body,
    stress: &'a [SymTensor2],
    conditions: &'a [FacetCondition],
}

/// The data from which the moments about a vertex are computed; the memory is reused for the next vertex.
#[derive(Default)]
struct Work {
    stars: StarList,
    /// The other end of each spoke, m.
    ends: Vec<Vector>,
    /// The stress of each triangle, Pa.
    stress: Vec<SymTensor2>,
    /// The moment on each spoke, acting on the triangle after it, less that on the first one, N/m.
    relative: Vec<Vector>,
}

impl Work {
    fn gather(&mut self, recovery: &Recovery<'_>, node: NodeId) {
        let Self { stars, ends, stress, .. } = self;
        let mesh = recovery.body.mesh();
        stars.clear();
        stars.walk(mesh, node);
        let star = stars.get(0);
        ends.clear();
        ends.extend(star.spokes.iter().map(|spoke| mesh.points()[spoke.ring]));
        stress.clear();
        stress.extend(star.triangles.iter().map(|sector| recovery.stress[sector.triangle as usize]));
    }
}

/// What the conditions at the ends of an open star say of its first moment.
enum Given {
    None,
    /// Its component along a unit vector.
    One(Vector, f64),
    All(Vector),
}

/// Returns the boundary edges of an open star with the sign of the moment on their triangle: on the last spoke the triangle lies before it.
fn ends(star: Star<'_>) -> [(usize, f64); 2] {
    [(0, 1.0), (star.spokes.len() - 1, -1.0)]
}

impl Recovery<'_> {
    /// Finds the moments about a vertex.
    fn vertex(&self, node: NodeId, work: &mut Work, found: &AtomicSlots) {
        work.gather(self, node);
        self.differences(work);
        let mean = self.mean(node, work);
        let (star, relative) = (work.stars.get(0), &work.relative);
        let first = match () {
            () if star.is_closed() => mean,
            () if self.is_on_springs(star) => self.fit_springs(node, work, mean),
            () => self.fit_ends(star, relative, mean),
        };
        for (spoke, relative) in star.spokes.iter().zip(relative) {
            let after = first + *relative;
            // The moment acts on the edge's first triangle.
            let moment = if spoke.leads_to_first { after } else { -after };
            // An edge begins at its smaller node.
            let place = 4 * spoke.edge.index() + 2 * usize::from(spoke.ring < node);
            found.set(place, moment[0]);
            found.set(place + 1, moment[1]);
        }
    }

    /// Moment `c_{j+1} = c_j − Q_j` on each spoke, acting on the triangle after it, relative to the first.
    fn differences(&self, work: &mut Work) {
        let Work { stars, ends, stress, relative } = work;
        let star = stars.get(0);
        relative.clear();
        let mut c = Vector::zeros();
        relative.push(c);
        for (j, (sector, stress)) in star.triangles.iter().zip(stress).enumerate() {
            let (a, b) = (ends[j], ends[if j + 1 < ends.len() { j + 1 } else { 0 }]);
            // ∫ σ̂ ∇φ: half the opposite edge, turned inwards, is area times gradient.
            c -= stress.apply(0.5 * perpendicular(b - a));
            if self.body.has_force() {
                // As in the FE load.
                c += self.body.nodal_forces_inside(sector.triangle as usize)[usize::from(sector.corner)];
            }
            relative.push(c);
        }
        relative.truncate(star.spokes.len());
    }

    /// The first moment for which all moments are closest to the average FE tractions, without conditions at the ends.
    fn mean(&self, node: NodeId, work: &Work) -> Vector {
        let Work { stars, ends, stress, relative } = work;
        let own = self.body.mesh().points()[node];
        let (mut sum, mut weights) = (Vector::zeros(), 0.0);
        let count = stress.len();
        for (j, (end, relative)) in ends.iter().zip(relative).enumerate() {
            let along = end - own;
            // The mean stress of its triangles; at its ends an open star has one.
            let mean = match j {
                0 if !stars.get(0).is_closed() => stress[0],
                0 => stress[count - 1].plus(stress[0]).scaled(0.5),
                _ if j == count => stress[count - 1],
                _ => stress[j - 1].plus(stress[j]).scaled(0.5),
            };
            // b̄ = |Γ|/2 F̄ with the outward normal of the triangle after the spoke, which lies to its left; weight 1/|Γ|
            let average = mean.apply(-0.5 * perpendicular(along));
            // Without the guard of `hypot` against overflow.
            let weight = 1.0 / along.dot(&along).sqrt();
            sum += weight * (average - relative);
            weights += weight;
        }
        1.0 / weights * sum
    }

    /// Changes the mean so that it satisfies the conditions on the two boundary edges of an open star.
    fn fit_ends(&self, star: Star<'_>, relative: &[Vector], mean: Vector) -> Vector {
        match self.given(star, relative) {
            Given::None => mean,
            Given::One(e, value) => mean + (value - e.dot(&mean)) * e,
            Given::All(moment) => moment,
        }
    }

    /// Finds the conditions that the two boundary edges of an open star put on the first moment.
    fn given(&self, star: Star<'_>, relative: &[Vector]) -> Given {
        let mut given: Vec<(Vector, f64)> = Vec::with_capacity(4);
        for (spoke, sign) in ends(star) {
            let (condition, moment) = self.boundary(star.spokes[spoke]);
            let value = sign * moment - relative[spoke];
            given.extend(condition.reaction.complement().basis().iter().map(|d| (*d, d.dot(&value))));
        }
        let Some(&(e, value)) = given.first() else { return Given::None };
        // Of the others the most perpendicular to the first; a parallel one is equivalent, by FE equilibrium.
        let other =
            given[1..].iter().copied().max_by(|a, b| cross(e, a.0).abs().total_cmp(&cross(e, b.0).abs()));
        match other {
            Some((d, second)) if cross(e, d).abs() > 1e-6 => {
                Given::All(with_products::<Plane>([e, d], [value, second]))
            }
            _ => Given::One(e, value),
        }
    }

    /// Tells whether the traction on a boundary edge of an open star is unknown along springs.
    fn is_on_springs(&self, star: Star<'_>) -> bool {
        ends(star).into_iter().any(|(spoke, _)| relaxes(self.boundary(star.spokes[spoke]).0))
    }

    /// Changes the mean so that it satisfies the conditions on the two boundary edges of an open star on springs. Along springs the moment is closest
    /// to that of the FE displacement, with the weight `(1 + E/(k |Γ|))/|Γ|`.
    fn fit_springs(&self, node: NodeId, work: &Work, mean: Vector) -> Vector {
        let mesh = self.body.mesh();
        let Work { stars, ends: points, stress, relative } = work;
        let (star, own) = (stars.get(0), mesh.points()[node]);
        let total: f64 = points.iter().map(|end| 1.0 / (end - own).norm()).sum();
        // The minimum of ½ c·A c − r·c.
        let (mut a, mut r) = (Matrix2::from_diagonal_element(total), total * mean);
        for (spoke, sign) in ends(star) {
            let (condition, moment) = self.boundary(star.spokes[spoke]);
            if !relaxes(condition) {
                continue;
            }
            let (along, triangle) = (points[spoke] - own, if spoke == 0 { 0 } else { stress.len() - 1 });
            let weight = 1.0 / along.norm();
            let modulus = self.body.material(star.triangles[triangle].triangle as usize).axial_modulus();
            let springs = &condition.springs;
            let average = stress[triangle].apply(-0.5 * perpendicular(along)) - relative[spoke];
            let target = sign * moment - relative[spoke];
            for d in springs.directions.basis() {
                let soft = weight * weight * modulus * springs.strained(&[*d; 2])[0];
                a += d * soft.transpose();
                r += d * (weight * (target - average).dot(d) + soft.dot(&target));
            }
        }
        let free = |e: Vector, value: f64| {
            let f = perpendicular(e);
            value * e + f.dot(&(r - value * (a * e))) / f.dot(&(a * f)) * f
        };
        match self.given(star, relative) {
            Given::None => a.try_inverse().map_or(mean, |inverse| inverse * r),
            Given::One(e, value) => free(e, value),
            Given::All(moment) => moment,
        }
    }

    /// Returns the condition on a boundary edge, and the moment about the vertex.
    fn boundary(&self, Spoke { edge, ring, .. }: Spoke) -> (&FacetCondition, Vector) {
        let mesh = self.body.mesh();
        let place = mesh.topology().boundary_place(edge);
        let condition = &self.conditions[place];
        let [a, b] = condition.expected_traction();
        let first = mesh.topology().facets()[edge][1] == ring;
        let (near, far) = if first { (a, b) } else { (b, a) };
        let moment = mesh.facet_measure(edge) / 6.0 * (2.0 * near + far);
        (condition, moment)
    }
}

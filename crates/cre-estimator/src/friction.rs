//! Friction in the bound: slips along the contact line, and the work that friction at its limit would do beyond the actual one.
//!
//! ```math
//! 2 ∫_Γ_C (s|w| − q w),   |q| ≤ s     (32)
//! ```
//! with the slip `w = (u^a − u^b)·t` of the load step, the friction `q` and its limit `s`. On straight edges all are linear. If the normal changes along an
//! edge, `q` is constant there, as the pressure is, so that `q t` is linear, and the slip is a quadratic.
//!
//! In space `w` and `q` are vectors. On a face along which the normal changes
//! ```math
//! q(x) = m × n(x)
//! ```
//! with a constant `m`, `|m| ≤ s`: it is linear and everywhere tangential. In the plane the same `m` is the constant above. `|w|` is convex, so that with the
//! mass matrix `M` of the face, for any number `α`,
//! ```math
//! ∫ (s|w| − q·w)  ≤  ∑_ij M_ij (s_i W_j − q_i·([u]_j − α n_j)),   W_j = |w_j| + |α_j − α| |n_j| max_i sin(n_i, n_j)
//! ```
//! where no term is negative: `[u]_j = α_j n_j + w_j` at the corners, and `α n(x)` has no tangential part. On a flat face `W_j = |w_j|`.

mod bent;

pub(crate) use bent::{least, on_bent_facet, turn_fields, turns_of};

use crate::recovery::Recovery;
use crate::side::side_sign;
use fem_core::geometry::{Coordinates, Vector, norm, perpendicular};
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair, NodePair};
use fem_core::space::{Plane, Solid, Space};

/// Friction on the facets of a contact surface; empty without friction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FacetFriction<S: Space = Plane> {
    /// The traction of friction on the second body at the corners of each contact facet, Pa: in the plane `q t`.
    pub traction: Vec<S::Axes<S::Vector>>,
    /// Its limit `s` there, Pa: `|q| ≤ s`.
    pub limit: Vec<S::Axes<f64>>,
    /// The displacement `u^a − u^b` of this load step at the corners of each contact facet, m: its tangential part is the slip.
    pub jump: Vec<S::Axes<S::Vector>>,
    /// What the lifts of the first and of the second body add, likewise; empty without a lift.
    pub lifted: [Vec<S::Axes<S::Vector>>; 2],
}

/// Friction and its limit at the corners of each facet of a contact line, Pa; empty without friction.
pub(crate) type OnFacets<S> = (Vec<<S as Space>::Axes<<S as Space>::Vector>>, Vec<<S as Space>::Axes<f64>>);

impl<S: Space> Default for FacetFriction<S> {
    fn default() -> Self {
        Self { traction: Vec::new(), limit: Vec::new(), jump: Vec::new(), lifted: [Vec::new(), Vec::new()] }
    }
}

impl<S: Recovery> FacetFriction<S> {
    /// Takes friction and slip of a pair.
    ///
    /// * `traction`, `limit`: on the facets, see [`Self::traction`]; empty without friction.
    /// * `displacement`: of the bodies of the pair, or of the points of an obstacle, m.
    /// * `moved`: the lifts of these bodies, if there are any, m.
    pub(crate) fn new(
        pair: &ContactPair<S>,
        (traction, limit): OnFacets<S>,
        displacement: [&[S::Vector]; 2],
        moved: [Option<&[S::Vector]>; 2],
    ) -> Self {
        if !pair.friction.acts() {
            return Self::default();
        }
        let lifted = [0, 1].map(|side: usize| match moved[side] {
            Some(l) => jumps(pair, |of, clamped| match clamped {
                Some(_) => S::Vector::ZERO,
                None => l[of.nodes[side].index()] * side_sign(1 - side),
            }),
            None => Vec::new(),
        });
        let mut jump = jumps(pair, |of, clamped| match clamped {
            Some(jump) => jump,
            None => displacement[0][of.nodes[0].index()] - displacement[1][of.nodes[1].index()],
        });
        if let Some(before) = &pair.slip_before {
            for (jump, before) in jump.iter_mut().zip(&before.jumps) {
                *jump = S::axes(|corner| jump[corner] - before[corner]);
            }
        }
        Self { traction, limit, jump, lifted }
    }

    /// Computes the nodal forces `∫ q t φ_i ds` at the pairs, Cartesian, N/m; zero without friction.
    pub(crate) fn nodal_forces(&self, interface: &ContactInterface<S>) -> Vec<S::Vector> {
        let mut forces = vec![S::Vector::ZERO; interface.pairs().len()];
        for (facet, traction) in interface.facets().iter().zip(&self.traction) {
            for corner in facet.free_corners() {
                forces[facet.pairs[corner] as usize] += facet.moment(traction, corner);
            }
        }
        forces
    }

    /// Computes what friction adds to the bound on every contact facet, J/m, (32) and (36); nothing without friction.
    pub(crate) fn terms(&self, pair: &ContactPair<S>) -> Vec<f64> {
        let mut terms = work(pair, &self.limit, Some(&self.traction), &self.jump);
        for lifted in &self.lifted {
            let lifted = work(pair, &self.limit, Some(&self.traction), lifted);
            terms.iter_mut().zip(lifted).for_each(|(sum, term)| *sum += term);
        }
        terms
    }
}

/// Returns the limit of friction at the corners of a facet, Pa.
///
/// * `limit`: at the pairs of nodes, `pressure`: at the corners of the facet, with Coulomb friction, Pa.
pub(crate) fn facet_limit<S: Recovery>(
    pair: &ContactPair<S>,
    facet: &ContactFacet<S>,
    limit: &[f64],
    pressure: Option<&S::Axes<f64>>,
) -> S::Axes<f64> {
    match (pair.friction.coulomb(), pressure) {
        (Some(mu), Some(p)) => S::axes(|k| mu * p[k]),
        _ => pair.interface.corners(facet, limit),
    }
}

/// Returns friction at the corners of a facet, within its limit there, Pa.
///
/// * `rows`: in the rows along tangents, Pa.
pub(crate) fn at_corners<S: Recovery>(
    pair: &ContactPair<S>,
    facet: &ContactFacet<S>,
    rows: &[f64],
    limit: &S::Axes<f64>,
) -> S::Axes<S::Vector> {
    if facet.bent {
        return on_bent_facet(pair, facet, &turns_of(pair, facet, rows), limit);
    }
    let by_tangent = rows.chunks(pair.interface.pairs().len().max(1));
    let parts: Vec<S::Axes<f64>> = by_tangent.map(|q| pair.interface.corners(facet, q)).collect();
    S::axes(|corner| {
        let tangents = pair.corner_tangents(facet, corner);
        let q: Vec<f64> = parts.iter().map(|q| q[corner]).collect();
        let along = within(&q, limit[corner]);
        tangents.as_ref().iter().zip(along).map(|(t, q)| *t * q).sum()
    })
}

/// Returns friction within its limit: shorter, if it is longer.
///
/// * `friction`: along the tangents.
pub(crate) fn within(friction: &[f64], limit: f64) -> Vec<f64> {
    let length = friction.iter().map(|q| q * q).sum::<f64>().sqrt();
    match length > limit {
        true => friction.iter().map(|q| q / length * limit).collect(),
        false => friction.to_vec(),
    }
}

/// Moves the friction at all pairs of nodes within its limits.
///
/// * `rows`: along the tangents, see [`ContactPair::rows`]; `limits`: at the pairs of nodes.
pub(crate) fn all_within(rows: &mut [f64], limits: &[f64]) {
    let nodes = limits.len();
    for (k, limit) in limits.iter().enumerate() {
        let own: Vec<f64> = rows[k..].iter().step_by(nodes).copied().collect();
        rows[k..].iter_mut().step_by(nodes).zip(within(&own, *limit)).for_each(|(q, within)| *q = within);
    }
}

/// Takes the jump at the corners of every contact facet, m.
///
/// * `jump`: `u^a − u^b` at a pair of nodes, m; at a clamped corner it is given what the supports impose.
fn jumps<S: Space>(
    pair: &ContactPair<S>,
    jump: impl Fn(&NodePair<S>, Option<S::Vector>) -> S::Vector,
) -> Vec<S::Axes<S::Vector>> {
    let of_facet = |facet: &ContactFacet<S>| {
        S::axes(|corner| {
            let clamped = facet.clamped[corner].map(|clamped| clamped.jump);
            jump(&pair.interface.pairs()[facet.pairs[corner] as usize], clamped)
        })
    };
    pair.interface.facets().iter().map(of_facet).collect()
}

/// Computes `∫ s|w| ds` along a contact surface, J/m: what friction at its limit takes of the potential energy; 0 without friction.
pub fn sliding_work<S: Recovery>(pair: &ContactPair<S>, friction: &FacetFriction<S>) -> f64 {
    0.5 * work(pair, &friction.limit, None, &friction.jump).iter().sum::<f64>()
}

/// Bounds the work that friction takes of a lift, `∫ s|w_l| ds + Σ |Q_i w_l,i|` with the slip `w_l` of the lift, J/m: the change of what
/// slides, and the work of the nodal forces. 0 without friction, and if the lift moves no node along its tangents.
///
/// * `forces`: friction forces `Q` on each body of the pair in the rows along tangents, N/m.
pub fn work_of_lift<S: Recovery>(
    pair: &ContactPair<S>,
    friction: &FacetFriction<S>,
    forces: [&[f64]; 2],
) -> f64 {
    let nodes = pair.interface.pairs().len();
    let of_side = |(lifted, forces): (&Vec<S::Axes<S::Vector>>, &[f64])| {
        let mut nodal = vec![S::Vector::ZERO; nodes];
        for (facet, jumps) in pair.interface.facets().iter().zip(lifted) {
            facet.free_corners().for_each(|corner| nodal[facet.pairs[corner] as usize] = jumps[corner]);
        }
        let of_node = |(k, jump): (usize, &S::Vector)| -> f64 {
            let forces = forces.get(k..).unwrap_or_default().iter().step_by(nodes.max(1));
            pair.tangential_parts(k, *jump).zip(forces).map(|(w, q)| (w * q).abs()).sum()
        };
        let nodal: f64 = nodal.iter().enumerate().map(of_node).sum();
        0.5 * work(pair, &friction.limit, None, lifted).iter().sum::<f64>() + nodal
    };
    friction.lifted.iter().zip(forces).map(of_side).sum()
}

/// Computes `2 ∫ (s|w| − q·w) ds` on every contact facet, J/m.
///
/// * `q`: without friction `None`.
fn work<S: Recovery>(
    pair: &ContactPair<S>,
    s: &[S::Axes<f64>],
    q: Option<&[S::Axes<S::Vector>]>,
    jumps: &[S::Axes<S::Vector>],
) -> Vec<f64> {
    let none = S::axes(|_| S::Vector::ZERO);
    let of_facet = |k: usize| {
        let facet = &pair.interface.facets()[k];
        2.0 * facet.measure * S::mean_sliding(pair, facet, &s[k], q.map_or(&none, |q| &q[k]), &jumps[k])
    };
    (0..jumps.len()).map(of_facet).collect()
}

/// Computes the mean of `s|w| − q w` along an edge, from friction and jumps at its ends.
pub(crate) fn mean_on_edge(
    interface: &ContactInterface,
    edge: &ContactFacet,
    s: [f64; 2],
    q: [Vector; 2],
    jump: [Vector; 2],
) -> f64 {
    let tangents = [0, 1].map(|end: usize| perpendicular(interface.corner_pair(edge, end).normal));
    let q = [0, 1].map(|end: usize| q[end].dot(&tangents[end]) / tangents[end].dot(&tangents[end]));
    mean(s, q, slip(tangents, jump))
}

/// Computes the Bernstein coefficients of the slip along an edge, m.
fn slip(tangents: [Vector; 2], [i, j]: [Vector; 2]) -> [f64; 3] {
    [i.dot(&tangents[0]), 0.5 * (i.dot(&tangents[1]) + j.dot(&tangents[0])), j.dot(&tangents[1])]
}

/// Bounds the mean of `s|w| − q·w` on a face by `∑_ij M_ij (s_i W_j − q_i·([u]_j − α n_j))/A`.
///
/// * `s`: over the lengths of the normals.
pub(crate) fn mean_on_face(
    normals: &[<Solid as Space>::Vector; 3],
    s: &[f64; 3],
    q: &[<Solid as Space>::Vector; 3],
    jump: &[<Solid as Space>::Vector; 3],
) -> f64 {
    let [sizes, along] = [normals.map(|n| n.dot(&n)), [0, 1, 2].map(|j: usize| jump[j].dot(&normals[j]))];
    let amounts = [0, 1, 2].map(|j: usize| along[j] / sizes[j]);
    let alpha = amounts.iter().sum::<f64>() / 3.0;
    let lengths = [0, 1, 2].map(|j: usize| {
        let sine = |n: &<Solid as Space>::Vector| norm(n.cross(&normals[j])) / norm(*n);
        let turned = normals.iter().map(sine).fold(0.0, f64::max);
        norm(jump[j] - normals[j] * amounts[j]) + (amounts[j] - alpha).abs() * turned
    });
    let mut sum = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            let share = if i == j { 2.0 } else { 1.0 };
            let moved = jump[j] - normals[j] * alpha;
            sum += share * (s[i] * sizes[i].sqrt() * lengths[j] - q[i].dot(&moved)).max(0.0);
        }
    }
    sum / 12.0
}

/// Computes the mean of `s|w| − q w` along an edge with linear `s` and `q`, by their values at the ends, and a quadratic `w`, by its Bernstein
/// coefficients: exact if `w` is linear or `q` constant, by Simpson's rule between the roots of `w`.
fn mean(s: [f64; 2], q: [f64; 2], w: [f64; 3]) -> f64 {
    let at = |ends: [f64; 2], x: f64| ends[0] + x * (ends[1] - ends[0]);
    let slip = |x: f64| at([at([w[0], w[1]], x), at([w[1], w[2]], x)], x);
    let simpson = |from: f64, to: f64| {
        let sign = if slip(0.5 * (from + to)) < 0.0 { -1.0 } else { 1.0 };
        let f = |x: f64| (at(s, x) - sign * at(q, x)).max(0.0) * (sign * slip(x)).max(0.0);
        (to - from) / 6.0 * (f(from) + 4.0 * f(0.5 * (from + to)) + f(to))
    };
    let mut ends = vec![0.0];
    ends.extend(roots(w));
    ends.push(1.0);
    ends.windows(2).map(|piece| simpson(piece[0], piece[1])).sum()
}

/// Finds the roots of a quadratic inside an edge, ascending.
fn roots(w: [f64; 3]) -> Vec<f64> {
    // w₀ (1 − x)² + 2 w₁ x (1 − x) + w₂ x² = a x² + 2 b x + c.
    let (a, b, c) = (w[0] - 2.0 * w[1] + w[2], w[1] - w[0], w[0]);
    let discriminant = b * b - a * c;
    if !(discriminant > 0.0) {
        return Vec::new();
    }
    // Without cancellation; a root that overflows is outside.
    let sum = -(b + discriminant.sqrt().copysign(b));
    let mut found: Vec<f64> = [sum / a, c / sum].into_iter().filter(|x| *x > 0.0 && *x < 1.0).collect();
    found.sort_by(f64::total_cmp);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::body::Body;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::interface::{ContactProblem, Friction, Gap};
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::generate::ring;

    /// Two rings that slide on each other on a bent line, with the limit 0.5.
    fn bent() -> ContactProblem {
        let body = |radii| {
            let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
            let mesh = ring([0.0; 2], radii, [0.0, 60.0], [4, 1]).unwrap();
            Body::new(mesh, material, &BoundaryConditions::new()).unwrap()
        };
        let bodies = [body([1.0, 1.5]), body([1.5, 2.0])];
        let gap = Gap::Geometric;
        let interface = contact_geometry::pair(&bodies[0], &bodies[1], ["outer", "inner"], &gap).unwrap();
        ContactProblem::between(bodies, interface).with_friction(0, Friction::tresca(0.5)).unwrap()
    }

    #[test]
    fn the_slip_in_the_middle_of_a_bent_edge_is_that_of_jump_and_tangent_there() {
        let problem = bent();
        let pair = &problem.contacts[0];
        let jump = |of: &NodePair| Vector::new(of.normal[0].sin(), 1.0 + of.normal[0] * of.normal[0]);
        for (edge, jumps) in pair.interface.facets().iter().zip(jumps(pair, |of, _| jump(of))) {
            let ends = edge.pairs.map(|k| &pair.interface.pairs()[k as usize]);
            let tangents = ends.map(|end| perpendicular(end.normal));
            let w = slip(tangents, jumps);
            let [jump, tangent] = [ends.map(jump), tangents].map(|[a, b]| 0.5 * (a + b));
            let middle = 0.25 * (w[0] + 2.0 * w[1] + w[2]);
            assert!((middle - jump.dot(&tangent)).abs() < 1e-14, "{w:?}");
        }
    }

    #[test]
    fn the_bound_counts_the_slip_of_a_lift() {
        let problem = bent();
        let pair = &problem.contacts[0];
        let edges = pair.interface.facets();
        let along = |edge: &ContactFacet, amount: f64| {
            edge.pairs.map(|k| amount * perpendicular(pair.interface.pairs()[k as usize].normal))
        };
        let all = |amount: f64| edges.iter().map(|edge| along(edge, amount)).collect::<Vec<_>>();
        let mut friction = FacetFriction {
            traction: all(0.1),
            limit: vec![[0.5; 2]; edges.len()],
            jump: all(0.0),
            ..FacetFriction::default()
        };
        assert_eq!(friction.terms(pair), vec![0.0; edges.len()]);
        friction.lifted = [all(0.02), all(-0.03)];
        for (edge, found) in edges.iter().zip(friction.terms(pair)) {
            // 2 ℓ (s|w| − q w) of each body; the slip in the middle has the cosine of the turn.
            let [a, b] = along(edge, 1.0);
            let slip = (2.0 + a.dot(&b)) / 3.0;
            let expected = 2.0 * edge.measure * slip * (0.4 * 0.02 + 0.6 * 0.03);
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }

    #[test]
    fn the_bound_of_the_mean_on_a_face_is_above_it_and_near_it_on_small_parts() {
        let mut random = crate::random::random(3);
        let normal = nalgebra::Vector3::new(0.0, 0.6, 0.8);
        let tangents = [nalgebra::Vector3::x(), nalgebra::Vector3::new(0.0, 0.8, -0.6)];
        for _ in 0..50 {
            let s = [0; 3].map(|_| random());
            let mut along =
                |size: f64| tangents[0] * (size * (random() - 0.5)) + tangents[1] * (size * (random() - 0.5));
            let q = s.map(|s| along(1.4 * s));
            let jump = [0; 3].map(|_| along(2.0) + normal);
            let sum = |parts: usize| {
                let h = 1.0 / parts as f64;
                let at = |i: usize, j: usize| [h * i as f64, h * j as f64, 1.0 - h * (i + j) as f64];
                let mut sum = 0.0;
                for (i, j) in (0..parts).flat_map(|i| (0..parts - i).map(move |j| (i, j))) {
                    let turned = (i + j + 1 < parts).then(|| [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
                    for corners in
                        [Some([at(i + 1, j), at(i, j + 1), at(i, j)]), turned].into_iter().flatten()
                    {
                        let vector = |of: &[nalgebra::Vector3<f64>; 3], x: [f64; 3]| {
                            of[0] * x[0] + of[1] * x[1] + of[2] * x[2]
                        };
                        let s = corners.map(|x| s[0] * x[0] + s[1] * x[1] + s[2] * x[2]);
                        let [q, jump] = [&q, &jump].map(|of| corners.map(|x| vector(of, x)));
                        sum += h * h * mean_on_face(&[normal; 3], &s, &q, &jump);
                    }
                }
                sum
            };
            let [whole, fine, finer] = [sum(1), sum(16), sum(32)];
            assert!(whole >= fine && fine >= finer && finer >= 0.0, "{whole} {fine} {finer}");
            // It falls as the square of the size of the parts.
            assert!(fine - finer <= 0.01 * (whole - fine) + 1e-14, "{whole} {fine} {finer}");
        }
    }

    #[test]
    fn the_mean_is_that_of_a_fine_sum_and_never_negative() {
        let mut random = crate::random::random(1);
        for _ in 0..200 {
            let s = [random(), random()];
            let q = s.map(|s| s * (2.0 * random() - 1.0));
            let w = [2.0 * random() - 1.0, 2.0 * random() - 1.0];
            let n = 4000;
            let sum: f64 = (0..n)
                .map(|k| {
                    let x = (f64::from(k) + 0.5) / f64::from(n);
                    let [s, q, w] = [s, q, w].map(|e| e[0] + x * (e[1] - e[0]));
                    (s * w.abs() - q * w) / f64::from(n)
                })
                .sum();
            let found = mean(s, q, [w[0], 0.5 * (w[0] + w[1]), w[1]]);
            assert!(found >= 0.0 && (found - sum).abs() < 1e-6, "{found} {sum}");
        }
        // Friction at its limit against the slip.
        assert_eq!(mean([2.0, 3.0], [2.0, 3.0], [0.0, 0.5, 1.0]), 0.0);
        assert_eq!(mean([2.0, 2.0], [0.0, 0.0], [-1.0, 0.0, 1.0]), 1.0);
    }

    #[test]
    fn the_mean_of_a_quadratic_slip_with_constant_friction_is_that_of_a_fine_sum() {
        let mut random = crate::random::random(1);
        let mut twice = 0;
        for _ in 0..200 {
            let s = [random(), random()];
            let q = [s[0].min(s[1]) * (2.0 * random() - 1.0); 2];
            let w = [2.0 * random() - 1.0, 4.0 * random() - 2.0, 2.0 * random() - 1.0];
            let n = 4000;
            let of_part = |k: i32| {
                let x = (f64::from(k) + 0.5) / f64::from(n);
                let w = w[0] * (1.0 - x) * (1.0 - x) + 2.0 * w[1] * x * (1.0 - x) + w[2] * x * x;
                ((s[0] + x * (s[1] - s[0])) * w.abs() - q[0] * w) / f64::from(n)
            };
            let (found, sum) = (mean(s, q, w), (0..n).map(of_part).sum::<f64>());
            assert!(found >= 0.0 && (found - sum).abs() < 2e-6, "{found} {sum}");
            twice += usize::from(roots(w).len() == 2);
        }
        assert!(twice > 5, "{twice}");
    }
}

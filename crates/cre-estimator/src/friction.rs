//! Friction in the bound: slips along the contact line, and the work that friction at its limit would do beyond the actual one.
//!
//! ```math
//! 2 ∫_Γ_C (s|w| − q w),   |q| ≤ s     (32)
//! ```
//! with the slip `w = (u^a − u^b)·t` of the load step, the friction `q` and its limit `s`. On straight edges all are linear. If the normal changes along an
//! edge, `q` is constant there, as the pressure is, so that `q t` is linear, and the slip is a quadratic.

use crate::side::side_sign;
use fem_core::geometry::{Vector, perpendicular};
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair, NodePair};
use fem_core::space::Space;

/// Friction on the edges of a contact line; empty without friction.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct EdgeFriction {
    /// `q` at the two ends of each contact edge, Pa.
    pub friction: Vec<[f64; 2]>,
    /// Its limit `s` there, Pa: `|q| ≤ s`.
    pub limit: Vec<[f64; 2]>,
    /// Bernstein coefficients of the slip `w` of this load step along each contact edge: at its first end, in the middle, at its
    /// second end, m.
    pub slip: Vec<[f64; 3]>,
    /// The slips that the lifts of the first and of the second body add, likewise; empty without a lift.
    pub lifted: [Vec<[f64; 3]>; 2],
}

impl EdgeFriction {
    /// Takes friction and slip of a pair.
    ///
    /// * `friction`, `limit`: at the pairs of nodes, Pa; empty without friction. `edge_pressure`: at the ends of the edges, Pa.
    /// * `displacement`: of the bodies of the pair, or of the points of an obstacle, m.
    /// * `moved`: the lifts of these bodies, if there are any, m.
    pub(crate) fn new(
        pair: &ContactPair,
        [friction, limit]: [&[f64]; 2],
        edge_pressure: &[[f64; 2]],
        displacement: [&[Vector]; 2],
        moved: [Option<&[Vector]>; 2],
    ) -> Self {
        if !pair.friction.acts() {
            return Self::default();
        }
        let edges = pair.interface.facets();
        let limit_of = |(edge, p): (&ContactFacet, &[f64; 2])| match pair.friction.coulomb() {
            Some(mu) => p.map(|p| mu * p),
            None => pair.interface.corners(edge, limit),
        };
        let limit: Vec<[f64; 2]> = edges.iter().zip(edge_pressure).map(limit_of).collect();
        let friction_of = |(edge, s): (&ContactFacet, &[f64; 2])| {
            let q = pair.interface.pressure(edge, friction);
            [0, 1].map(|end: usize| q[end].max(-s[end]).min(s[end]))
        };
        let lifted = [0, 1].map(|side: usize| match moved[side] {
            Some(l) => slips(pair, |of, clamped| match clamped {
                Some(_) => Vector::zeros(),
                None => side_sign(1 - side) * l[of.nodes[side].index()],
            }),
            None => Vec::new(),
        });
        let friction = edges.iter().zip(&limit).map(friction_of).collect();
        let mut slip = slips(pair, |of, clamped| match clamped {
            Some(jump) => jump,
            None => displacement[0][of.nodes[0].index()] - displacement[1][of.nodes[1].index()],
        });
        if let Some(before) = &pair.slip_before {
            let step = slip.as_flattened_mut().iter_mut().zip(before.edges.as_flattened());
            step.for_each(|(slip, before)| *slip -= before);
        }
        Self { friction, slip, limit, lifted }
    }

    /// Computes the nodal forces `∫ q t φ_i ds` at the pairs, Cartesian, N/m; zero without friction.
    pub(crate) fn nodal_forces(&self, interface: &ContactInterface) -> Vec<Vector> {
        // t is n turned by a right angle.
        interface.pressure_forces(&self.friction).into_iter().map(perpendicular).collect()
    }

    /// Computes what friction adds to the bound on every contact edge, J/m, (32) and (36); nothing without friction.
    pub(crate) fn terms<S: Space>(&self, interface: &ContactInterface<S>) -> Vec<f64> {
        let mut terms = work(interface, &self.limit, &self.friction, &self.slip);
        for lifted in &self.lifted {
            let lifted = work(interface, &self.limit, &self.friction, lifted);
            terms.iter_mut().zip(lifted).for_each(|(sum, term)| *sum += term);
        }
        terms
    }
}

/// Returns the tangent along which friction acts at a pair of nodes, of the length of its normal.
pub(crate) fn tangent<S: Space>(normal: S::Vector) -> S::Vector {
    S::complement(&[normal])[0]
}

/// Computes the Bernstein coefficients of the slip along every contact edge, m.
///
/// * `jump`: `u^a − u^b` at a pair of nodes, m; at a clamped end it is given what the supports impose.
fn slips(pair: &ContactPair, jump: impl Fn(&NodePair, Option<Vector>) -> Vector) -> Vec<[f64; 3]> {
    let pairs = pair.interface.pairs();
    let of_edge = |edge: &ContactFacet| {
        let tangents = edge.pairs.map(|k| perpendicular(pairs[k as usize].normal));
        let at = |end: usize| {
            jump(&pairs[edge.pairs[end] as usize], edge.clamped[end].map(|clamped| clamped.jump))
        };
        let [i, j] = [at(0), at(1)];
        [i.dot(&tangents[0]), 0.5 * (i.dot(&tangents[1]) + j.dot(&tangents[0])), j.dot(&tangents[1])]
    };
    pair.interface.facets().iter().map(of_edge).collect()
}

/// Computes `∫ s|w| ds` along a contact line, J/m: what friction at its limit takes of the potential energy; 0 without friction.
pub fn sliding_work<S: Space>(pair: &ContactPair<S>, friction: &EdgeFriction) -> f64 {
    let EdgeFriction { limit, slip, .. } = friction;
    let none = vec![[0.0; 2]; slip.len()];
    0.5 * work(&pair.interface, limit, &none, slip).iter().sum::<f64>()
}

/// Bounds the work that friction takes of a lift, `∫ s|w_l| ds + Σ |Q_i w_l,i|` with the slip `w_l` of the lift, J/m: the change of what
/// slides, and the work of the nodal forces. 0 without friction and on straight lines.
///
/// * `forces`: friction forces `Q` on each body of the pair at the pairs of nodes, N/m.
pub fn work_of_lift<S: Space>(pair: &ContactPair<S>, friction: &EdgeFriction, forces: [&[f64]; 2]) -> f64 {
    let of_side = |(lifted, forces): (&Vec<[f64; 3]>, &[f64])| {
        let none = vec![[0.0; 2]; lifted.len()];
        let mut nodal = vec![0.0; forces.len()];
        for (edge, w) in pair.interface.facets().iter().zip(lifted) {
            edge.free_corners().for_each(|end| nodal[edge.pairs[end] as usize] = w[2 * end]);
        }
        let nodal: f64 = nodal.iter().zip(forces).map(|(w, q)| (w * q).abs()).sum();
        0.5 * work(&pair.interface, &friction.limit, &none, lifted).iter().sum::<f64>() + nodal
    };
    friction.lifted.iter().zip(forces).map(of_side).sum()
}

/// Computes `2 ∫ (s|w| − q w) ds` on every contact edge, J/m.
fn work<S: Space>(
    interface: &ContactInterface<S>,
    s: &[[f64; 2]],
    q: &[[f64; 2]],
    w: &[[f64; 3]],
) -> Vec<f64> {
    let edges = interface.facets().iter().zip(s).zip(q).zip(w);
    edges.map(|(((edge, s), q), w)| 2.0 * edge.measure * mean(*s, *q, *w)).collect()
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
        let found = slips(pair, |of, _| jump(of));
        for (edge, w) in pair.interface.facets().iter().zip(found) {
            let [a, b] = edge.pairs.map(|k| &pair.interface.pairs()[k as usize]);
            let jump = 0.5 * (jump(a) + jump(b));
            let tangent = 0.5 * (perpendicular(a.normal) + perpendicular(b.normal));
            let middle = 0.25 * (w[0] + 2.0 * w[1] + w[2]);
            assert!((middle - jump.dot(&tangent)).abs() < 1e-14, "{w:?}");
        }
    }

    #[test]
    fn the_bound_counts_the_slip_of_a_lift() {
        let problem = bent();
        let pair = &problem.contacts[0];
        let edges = pair.interface.facets().len();
        let mut friction = EdgeFriction {
            friction: vec![[0.1; 2]; edges],
            limit: vec![[0.5; 2]; edges],
            slip: vec![[0.0; 3]; edges],
            ..EdgeFriction::default()
        };
        assert_eq!(friction.terms(&pair.interface), vec![0.0; edges]);
        friction.lifted = [vec![[0.02; 3]; edges], vec![[-0.03; 3]; edges]];
        // 2 ℓ (s|w| − q w) of each body.
        for (edge, found) in pair.interface.facets().iter().zip(friction.terms(&pair.interface)) {
            let expected = 2.0 * edge.measure * (0.4 * 0.02 + 0.6 * 0.03);
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
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

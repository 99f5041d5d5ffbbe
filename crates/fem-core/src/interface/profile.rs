//! The measured gap between two pairs: a cubic, where the surfaces stand for smooth curves.
//!
//! Polygons on curved surfaces are apart by the square of their edges, more than bodies are deformed. A measured gap
//! therefore goes along the smooth curves through the nodes of the first meshes, and finer meshes take it from there.

use super::common_refinement::curve::Curve;
use super::matching::Stretch;
use super::{ContactEdge, Pair};
use crate::body::Body;
use crate::geometry::{Vector, add, dot, norm, scale, sub};
use std::collections::HashMap;

/// A gap that differs from a linear one by less than this part of the edge is linear.
const LINEAR: f64 = 1e-12;

/// The gap along a contact edge: the four Bernstein coefficients of a cubic, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Profile([f64; 4]);

impl Profile {
    /// Makes the cubic that takes the values at 0, ⅓, ⅔ and 1 of the edge; `None` where it is linear to round-off.
    ///
    /// * `length`: of the edge, m.
    pub(super) fn through([a, b, c, d]: [f64; 4], length: f64) -> Option<Self> {
        let bend = [b - (2.0 * a + d) / 3.0, c - (a + 2.0 * d) / 3.0];
        let is_linear = bend.iter().all(|x| x.abs() <= LINEAR * length);
        let inner =
            [(-5.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / 6.0, (2.0 * a - 9.0 * b + 18.0 * c - 5.0 * d) / 6.0];
        (!is_linear && inner.iter().all(|x| x.is_finite())).then_some(Self([a, inner[0], inner[1], d]))
    }

    /// Evaluates the gap at a fraction of the edge; an overlap of smooth curves is none.
    pub(super) fn at(&self, t: f64) -> f64 {
        let [a, b, c, d] = self.0;
        let s = 1.0 - t;
        (s * s * s * a + 3.0 * s * t * (s * b + t * c) + t * t * t * d).max(0.0)
    }

    /// Returns the profiles of the edge's two halves.
    pub(super) fn halves(&self) -> [Self; 2] {
        let mean = |x: f64, y: f64| 0.5 * (x + y);
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
        let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
        let middle = mean(abc, bcd);
        [Self([a, ab, abc, middle]), Self([middle, bcd, cd, d])]
    }
}

/// Measures the profiles of surfaces refined in common.
///
/// * `between`: the gap at ⅓ and ⅔ of the way from one of the first body's nodes to the next.
pub(super) fn of_refined(
    pairs: &[Pair],
    edges: &[ContactEdge],
    between: &HashMap<[u32; 2], [f64; 2]>,
) -> Vec<Option<Profile>> {
    let profile = |edge: &ContactEdge| {
        let [i, j] = edge.pairs.map(|k| &pairs[k as usize]);
        let [a, b] = [i.nodes[0], j.nodes[0]];
        let back = || between.get(&[b, a]).map(|[p, q]| [*q, *p]);
        let [p, q] = between.get(&[a, b]).copied().or_else(back)?;
        Profile::through([i.gap, p, q, j.gap], edge.length)
    };
    edges.iter().map(profile).collect()
}

/// Measures the profiles of surfaces that match node by node: between the smooth curves through the nodes of each.
pub(super) fn of_matching(
    bodies: [&Body; 2],
    chain: &[Stretch],
    pairs: &[Pair],
    edges: &[ContactEdge],
) -> Vec<Option<Profile>> {
    let mut profiles = Vec::with_capacity(edges.len());
    let (mut first_pair, mut first_edge) = (0, 0);
    for stretch in chain {
        let own = &pairs[first_pair..first_pair + stretch.nodes.len()];
        let found = &edges[first_edge..first_edge + stretch.edges.len()];
        let curves = [0, 1].map(|b| {
            let points = own.iter().map(|p| bodies[b].mesh().points()[p.nodes[b] as usize]);
            let closing = stretch.is_closed().then(|| bodies[b].mesh().points()[own[0].nodes[b] as usize]);
            Curve::new(points.chain(closing).collect())
        });
        for (k, edge) in found.iter().enumerate() {
            let [i, j] = edge.pairs.map(|k| &pairs[k as usize]);
            let at = |t: f64| {
                let normal = add(scale(1.0 - t, i.normal), scale(t, j.normal));
                let apart: Vector = sub(curves[1].smooth(k, t), curves[0].smooth(k, t));
                dot(apart, normal) / norm(normal)
            };
            // What the nodes themselves are apart is known; the curves say what happens between them.
            let off = [i.gap - at(0.0), j.gap - at(1.0)];
            let inner = [1.0 / 3.0, 2.0 / 3.0].map(|t| at(t) + (1.0 - t) * off[0] + t * off[1]);
            profiles.push(Profile::through([i.gap, inner[0], inner[1], j.gap], edge.length));
        }
        (first_pair, first_edge) = (first_pair + own.len(), first_edge + found.len());
    }
    profiles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_same_cubic() {
        let cubic = |t: f64| 1.0 + 0.5 * t - 2.0 * t * t + 1.25 * t * t * t;
        let profile = Profile::through([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(cubic), 1.0).unwrap();
        let [left, right] = profile.halves();
        for k in 0..=10 {
            let t = f64::from(k) / 10.0;
            assert!((profile.at(t) - cubic(t)).abs() < 1e-14);
            assert!((left.at(t) - cubic(0.5 * t)).abs() < 1e-14);
            assert!((right.at(t) - cubic(0.5 + 0.5 * t)).abs() < 1e-14);
        }
        assert_eq!(Profile::through([0.0, 1.0, 2.0, 3.0], 1.0), None);
        // An overlap is closed.
        assert_eq!(Profile::through([0.0, -1.0, -1.0, 0.0], 1.0).unwrap().at(0.5), 0.0);
    }
}

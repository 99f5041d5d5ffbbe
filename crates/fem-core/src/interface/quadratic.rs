//! The opening on faces of solids along which the normal changes.

use super::{ContactFacet, ContactInterface, NodePair};
use crate::geometry::Coordinates;
use crate::space::{Solid, Space};

type Vector = <Solid as Space>::Vector;

impl ContactInterface<Solid> {
    /// Computes the middle Bernstein coefficients of the opening on all faces, m, one per edge in the order of [`ContactFacet::edges`]:
    /// ```math
    /// ½ (G_i·n_j + G_j·n_i) − ½ ([u]_i·n_j + [u]_j·n_i),   G_i = g_i n_i/|n_i|²
    /// ```
    /// The opening `(G − [u])·n` is quadratic if `n` changes, with a gap `G` that is a vector and linear on a face, as `[u]` and `n` are. Its other
    /// coefficients are the nodal openings. If all are ≥ 0, so is the opening.
    ///
    /// * `jump`: `[u] = u¹ − u²` of a pair, m.
    pub fn middle_openings(&self, jump: impl Fn(usize) -> Vector) -> Vec<f64> {
        let of_facet = |facet: &ContactFacet<Solid>| {
            let of = [0, 1, 2].map(|corner: usize| self.corner_pair(facet, corner));
            let moved = |corner: usize| match facet.clamped[corner] {
                None => jump(facet.pairs[corner] as usize),
                Some(clamped) => clamped.jump,
            };
            let open = [0, 1, 2].map(|corner: usize| of[corner].gap_vector() - moved(corner));
            ContactFacet::<Solid>::edges()
                .map(move |[i, j]| 0.5 * (open[i].dot(&of[j].normal) + open[j].dot(&of[i].normal)))
        };
        self.facets().iter().flat_map(of_facet).collect()
    }
}

impl ContactFacet<Solid> {
    /// Computes `∫ p o ds`, J: on a flat face with the mass matrix of [`Self::moment`]; on a bent one the pressure is constant and the opening a quadratic with
    /// Bernstein coefficients, each of which counts for a sixth of the area.
    ///
    /// * `pressure`: see [`ContactInterface::pressure`]; `opening`: at its corners, `middle`: on its edges, m, see [`ContactInterface::middle_openings`].
    pub fn work(&self, pressure: &[f64; 3], opening: &[f64; 3], middle: &[f64]) -> f64 {
        if !self.bent {
            return self.flat_work(pressure, opening);
        }
        let sum: f64 = opening.iter().chain(middle).sum();
        self.measure / 6.0 * pressure[0] * sum
    }

    /// Computes the gap at a point of the face along its normal there, m: `G·n/|n|`.
    ///
    /// * `pairs`: at its corners; `at`: the barycentric coordinates of the point.
    pub(super) fn gap(pairs: [&NodePair<Solid>; 3], at: &[f64; 3]) -> f64 {
        let sum = |of: &dyn Fn(&NodePair<Solid>) -> Vector| -> Vector {
            pairs.iter().zip(at).map(|(pair, part)| of(pair) * *part).sum()
        };
        let normal = sum(&|pair| pair.normal);
        sum(&NodePair::gap_vector).dot(&normal) / normal.length()
    }
}

//! A condensed body seen along the normals of an iteration.

use super::CondensedBody;
use crate::geometry::Vector;

/// A condensed body whose traces and forces are along the normals of the pairs or against them: along the outward
/// normal of the body that carries λ, see [`crate::interface::Roles::sign`].
#[derive(Clone, Copy, Debug)]
pub struct OrientedBody<'a> {
    pub(super) body: &'a CondensedBody,
    pub(super) sign: f64,
}

impl<'a> OrientedBody<'a> {
    /// Returns the number of interface unknowns.
    pub fn len(&self) -> usize {
        self.body.len()
    }

    /// Tells whether the body has no interface.
    pub fn is_empty(&self) -> bool {
        self.body.is_empty()
    }

    /// Returns `S`, column-major, both triangles, N/m²: the same in either orientation.
    pub fn schur(&self) -> &'a [f64] {
        self.body.schur()
    }

    /// Computes `g̃`, N/m.
    pub fn condensed_load(&self) -> Vec<f64> {
        self.body.condensed_load().iter().map(|g| self.sign * g).collect()
    }

    /// Computes the reaction to an imposed normal trace, `r = S v − g̃` (N/m), in `2 n_c²` operations.
    ///
    /// # Panics
    /// If `v` or `r` has not `n_c` entries.
    pub fn reaction(&self, v: &[f64], r: &mut [f64]) {
        self.body.apply_schur(v, r);
        for (r, g) in r.iter_mut().zip(self.body.condensed_load()) {
            *r -= self.sign * g;
        }
    }

    /// Computes `S v`, N/m.
    ///
    /// # Panics
    /// If `v` or `r` has not `n_c` entries.
    pub fn apply_schur(&self, v: &[f64], r: &mut [f64]) {
        self.body.apply_schur(v, r);
    }

    /// Computes `w = S⁻¹ r`, m.
    ///
    /// # Panics
    /// If `r` or `w` has not `n_c` entries.
    pub fn trace_from_force(&self, r: &[f64], w: &mut [f64]) {
        self.body.trace_from_force(r, w);
    }

    /// Computes `S⁻¹`, column-major, m²/N.
    pub fn flexibility(&self) -> Vec<f64> {
        self.body.flexibility()
    }

    /// Recovers the displacement (Cartesian, m) with an imposed normal trace, see
    /// [`CondensedBody::displacement_from_trace`].
    ///
    /// # Panics
    /// If `v` has not `n_c` entries.
    pub fn displacement_from_trace(&self, v: &[f64]) -> Vec<Vector> {
        self.body.displacement_from_trace(&self.along_pairs(v))
    }

    /// Computes the displacement (Cartesian, m) that an increment of the normal trace adds.
    ///
    /// # Panics
    /// If `increment` has not `n_c` entries.
    pub fn correction_from_trace(&self, increment: &[f64]) -> Vec<Vector> {
        self.body.correction_from_trace(&self.along_pairs(increment))
    }

    fn along_pairs(&self, values: &[f64]) -> Vec<f64> {
        values.iter().map(|v| self.sign * v).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::condensed;

    #[test]
    fn traces_and_forces_change_their_sign_with_the_normals() {
        let (body, _) = condensed();
        let n_c = body.len();
        let v: Vec<f64> = (0..n_c).map(|i| 0.01 * (i as f64).cos()).collect();
        let minus: Vec<f64> = v.iter().map(|v| -v).collect();
        let (mut r, mut q) = (vec![0.0; n_c], vec![0.0; n_c]);
        body.reaction(&v, &mut r);
        body.oriented(-1.0).reaction(&minus, &mut q);
        assert!(r.iter().zip(&q).all(|(r, q)| *r == -*q));
        assert_eq!(body.oriented(-1.0).displacement_from_trace(&minus), body.displacement_from_trace(&v));
        assert_eq!(body.oriented(1.0).condensed_load(), body.condensed_load());
    }
}

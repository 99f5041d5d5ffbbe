//! Energies of small differences in double-double arithmetic (`qd::Quad`, about 32 digits): what a bound near round-off is
//! measured with.
//!
//! Data are the numbers that the program sees: coordinates, stiffnesses and tractions in double precision. All that is
//! computed from them here has twice the digits.

use crate::model::{Body, LinearElastic, Vector};
use qd::Quad;

/// A vector in double-double arithmetic.
pub type Precise = [Quad; 2];

/// Takes a vector as it is.
pub fn precise(x: impl Into<Vector>) -> Precise {
    <[f64; 2]>::from(x.into()).map(Quad::from_f64)
}

/// Subtracts two vectors.
pub fn minus(a: Precise, b: Precise) -> Precise {
    [a[0] - b[0], a[1] - b[1]]
}

/// Computes the scalar product.
pub fn product(a: Precise, b: Precise) -> Quad {
    a[0] * b[0] + a[1] * b[1]
}

/// A linear triangle.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Area.
    pub area: Quad,
    gradients: [Precise; 3],
}

impl Cell {
    /// Computes area and gradients of the shape functions from the corners.
    pub fn new(corners: [Precise; 3]) -> Self {
        let [a, b] = [1, 2].map(|k| minus(corners[k], corners[0]));
        let twice = a[0] * b[1] - a[1] * b[0];
        let gradient = |p: Precise, q: Precise| [(p[1] - q[1]) / twice, (q[0] - p[0]) / twice];
        let zero = precise(Vector::zeros());
        let gradients = [gradient(a, b), gradient(b, zero), gradient(zero, a)];
        Self { area: twice * Quad::from_f64(0.5), gradients }
    }

    /// Computes the strain `[ε_xx, ε_yy, 2 ε_xy]` of nodal displacements.
    pub fn strain(&self, u: [Precise; 3]) -> [Quad; 3] {
        let mut e = [Quad::ZERO; 3];
        for (u, g) in u.iter().zip(&self.gradients) {
            e[0] += u[0] * g[0];
            e[1] += u[1] * g[1];
            e[2] += u[0] * g[1] + u[1] * g[0];
        }
        e
    }
}

/// Computes `σ(ε) : η`, Pa.
pub fn energy_product(material: &LinearElastic, strain: [Quad; 3], other: [Quad; 3]) -> Quad {
    let c = material.stiffness();
    let mut sum = Quad::ZERO;
    for (i, e) in other.iter().enumerate() {
        for (j, s) in strain.iter().enumerate() {
            sum += Quad::from_f64(c[(i, j)]) * *s * *e;
        }
    }
    sum
}

/// Computes `a(d, d)` of a displacement field on a body's mesh, J/m.
///
/// * `d`: one per node.
pub fn energy(body: &Body, d: &[Precise]) -> Quad {
    let mesh = body.mesh();
    let of_triangle = |t: usize| {
        let cell = Cell::new(mesh.corners(t).map(precise));
        let strain = cell.strain(mesh.cells()[t].map(|n| d[n]));
        cell.area * energy_product(body.material(t), strain, strain)
    };
    (0..mesh.cells().len()).map(of_triangle).fold(Quad::ZERO, |sum, e| sum + e)
}

/// Rounds to double precision.
pub fn rounded(x: Quad) -> f64 {
    x.0 + x.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_in_the_thirtieth_digit_is_seen() {
        let corners = [[0.1, 0.2], [1.3, 0.1], [0.4, 0.9]].map(precise);
        let cell = Cell::new(corners);
        // A rigid motion with a strain of 1e-28 on top.
        let tiny = Quad::from_f64(1e-28);
        let u = corners.map(|x| [Quad::ONE - x[1] + tiny * x[0], Quad::ONE + x[0]]);
        let strain = cell.strain(u).map(rounded);
        assert!((strain[0] - 1e-28).abs() < 1e-31, "{strain:?}");
        assert!(strain[1].abs() < 1e-30 && strain[2].abs() < 1e-30, "{strain:?}");
    }
}

//! The P1 triangle: gradients, strain, stiffness.

use crate::geometry::{Vector, signed_area};
use crate::material::LinearElastic;
use crate::tensor::SymTensor2;
use nalgebra::{Matrix2, Matrix3x2};

/// Area and the constant gradients of the three shape functions of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Area, m².
    pub area: f64,
    /// `∇φ_k`, 1/m.
    pub gradients: [Vector; 3],
}

impl Triangle {
    /// Computes area and gradients from the corners, counter-clockwise.
    #[inline]
    pub fn new(corners: [Vector; 3]) -> Self {
        let area = signed_area(corners);
        let half = 1.0 / (2.0 * area);
        let gradients = std::array::from_fn(|k| {
            let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            Vector::new((a[1] - b[1]) * half, (b[0] - a[0]) * half)
        });
        Self { area, gradients }
    }

    /// Computes the strain of nodal displacements, constant in the triangle: from their differences, so that a translation
    /// has zero strain.
    #[inline]
    pub fn strain(&self, displacement: [Vector; 3]) -> SymTensor2 {
        let mut e = SymTensor2::default();
        for k in 1..3 {
            let (u, g) = (displacement[k] - displacement[0], self.gradients[k]);
            e.xx += u[0] * g[0];
            e.yy += u[1] * g[1];
            e.xy += 0.5 * (u[0] * g[1] + u[1] * g[0]);
        }
        e
    }

    /// Computes the 2×2 block of `K_e = A Bᵀ D B` for the corners `a` (rows) and `b` (columns), Pa.
    #[inline]
    pub fn stiffness_block(&self, material: &LinearElastic, a: usize, b: usize) -> Matrix2<f64> {
        let strain_matrix = |k: usize| {
            let [x, y] = self.gradients[k].into();
            Matrix3x2::new(x, 0.0, 0.0, y, y, x)
        };
        (strain_matrix(a).transpose() * material.stiffness()) * strain_matrix(b) * self.area
    }

    /// Computes `∫ σ ∇φ_k`, the nodal forces of a constant stress, N/m.
    #[inline]
    pub fn internal_forces(&self, stress: SymTensor2) -> [Vector; 3] {
        self.gradients.map(|g| self.area * stress.apply(g))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::perpendicular;
    use crate::material::Hypothesis;

    #[test]
    fn stiffness_times_displacement_is_the_internal_force() {
        let material = LinearElastic::isotropic(3.0, 0.2, Hypothesis::PlaneStrain).unwrap();
        let t = Triangle::new([[0.1, 0.2], [1.3, 0.1], [0.4, 0.9]].map(Vector::from));
        let u = [[0.3, -0.1], [0.2, 0.7], [-0.5, 0.4]].map(Vector::from);
        let forces = t.internal_forces(material.stress(t.strain(u)));
        for a in 0..3 {
            let mut f = Vector::zeros();
            for b in 0..3 {
                f += t.stiffness_block(&material, a, b) * u[b];
            }
            assert!((f[0] - forces[a][0]).abs() < 1e-14 && (f[1] - forces[a][1]).abs() < 1e-14);
        }
    }

    #[test]
    fn rigid_rotation_has_no_strain() {
        let corners = [[0.1, 0.2], [1.3, 0.1], [0.4, 0.9]].map(Vector::from);
        let e = Triangle::new(corners).strain(corners.map(perpendicular));
        assert!(e.contract(e) < 1e-28);
    }
}

//! The P1 triangle: gradients, strain, stiffness.

use crate::geometry::{Vector, signed_area};
use crate::material::LinearElastic;
use crate::tensor::SymTensor2;
use nalgebra::Matrix2;

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

    /// Computes the 2×2 blocks of `K_e = A Bᵀ D B` for the three corners (rows) and the corner `b` (columns), Pa.
    #[inline]
    pub fn stiffness_column(&self, material: &LinearElastic, b: usize) -> [Matrix2<f64>; 3] {
        let d = material.stiffness();
        let [x, y] = (self.area * self.gradients[b]).into();
        // A D B: the stress, times the area, of a unit displacement of the corner along each axis.
        let stress = [0, 1, 2].map(|i| [d[(i, 0)] * x + d[(i, 2)] * y, d[(i, 1)] * y + d[(i, 2)] * x]);
        self.gradients.map(|g| {
            let force = |c: usize| {
                [g[0] * stress[0][c] + g[1] * stress[2][c], g[1] * stress[1][c] + g[0] * stress[2][c]]
            };
            let [[xx, yx], [xy, yy]] = [force(0), force(1)];
            Matrix2::new(xx, xy, yx, yy)
        })
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
        let columns = [0, 1, 2].map(|b| t.stiffness_column(&material, b));
        for a in 0..3 {
            let mut f = Vector::zeros();
            for b in 0..3 {
                f += columns[b][a] * u[b];
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

//! The P1 cell: gradients, strain, stiffness.

use crate::material::LinearElastic;
use crate::space::{Plane, Space};

/// Measure and the constant gradients of the shape functions of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Element<S: Space = Plane> {
    /// Area, m², or volume, m³.
    pub measure: f64,
    /// `∇φ_k`, 1/m.
    pub gradients: S::Corners<S::Vector>,
}

/// A triangle.
pub type Triangle = Element<Plane>;

/// The nodal forces along each axis under a unit displacement of one node along each axis: the columns of a block of the stiffness.
pub type Block<S> = <S as Space>::Axes<<S as Space>::Vector>;

impl<S: Space> Element<S> {
    /// Computes measure and gradients from the corners of a cell of positive measure.
    #[inline]
    pub fn new(corners: S::Corners<S::Vector>) -> Self {
        let measure = S::measure(&corners);
        Self { measure, gradients: S::gradients(&corners, measure) }
    }

    /// Computes the strain of nodal displacements, constant in the cell: from their differences, so that a translation
    /// has zero strain.
    #[inline]
    pub fn strain(&self, displacement: S::Corners<S::Vector>) -> S::Tensor {
        let mut e = S::components(|_| 0.0);
        for k in 1..=S::DIM {
            let (u, g) = (displacement[k] - displacement[0], self.gradients[k]);
            for i in 0..S::DIM {
                e[i] += u[i] * g[i];
                for j in 0..i {
                    e[S::component(i, j)] += 0.5 * (u[j] * g[i] + u[i] * g[j]);
                }
            }
        }
        e.into()
    }

    /// Computes the blocks of `K_e = A Bᵀ D B` for all corners (rows) and the corner `b` (columns), each by columns.
    #[inline]
    pub(crate) fn stiffness_column(&self, material: &LinearElastic<S>, b: usize) -> S::Corners<Block<S>> {
        let d = material.stiffness();
        let gradient = self.gradients[b] * self.measure;
        // A D B: the stress, times the measure, of a unit displacement of the corner along each axis.
        let stress = S::axes(|axis| {
            S::Tensor::from(S::components(|k| {
                let entry = |j: usize| d[(k, S::component(axis, j))] * gradient[j];
                (1..S::DIM).fold(entry(0), |sum, j| sum + entry(j))
            }))
        });
        S::corners(|a| S::axes(|axis| S::applied(stress[axis], self.gradients[a])))
    }

    /// Computes `∫ σ ∇φ_k`, the nodal forces of a constant stress, N/m in the plane, N in space.
    #[inline]
    pub(crate) fn internal_forces(&self, stress: S::Tensor) -> S::Corners<S::Vector> {
        S::corners(|k| S::applied(stress, self.gradients[k]) * self.measure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Coordinates;
    use crate::geometry::{Vector, perpendicular};
    use crate::material::Hypothesis;
    use crate::space::Solid;
    use nalgebra::Vector3;

    fn check<S: Space>(
        material: &LinearElastic<S>,
        corners: S::Corners<S::Vector>,
        u: S::Corners<S::Vector>,
    ) {
        let t = Element::<S>::new(corners);
        let forces = t.internal_forces(material.stress(t.strain(u)));
        for a in 0..=S::DIM {
            let mut f = S::Vector::default();
            for b in 0..=S::DIM {
                let block = t.stiffness_column(material, b)[a];
                for axis in 0..S::DIM {
                    f += block[axis] * u[b][axis];
                }
            }
            assert!((f - forces[a]).length() < 3e-14);
        }
    }

    const TETRAHEDRON: [[f64; 3]; 4] = [[0.1, 0.2, -0.3], [1.3, 0.1, 0.2], [0.4, 0.9, 0.1], [0.2, 0.3, 1.1]];

    #[test]
    fn stiffness_times_displacement_is_the_internal_force() {
        let material = LinearElastic::isotropic(3.0, 0.2, Hypothesis::PlaneStrain).unwrap();
        let u = [[0.3, -0.1], [0.2, 0.7], [-0.5, 0.4]].map(Vector::from);
        check::<Plane>(&material, [[0.1, 0.2], [1.3, 0.1], [0.4, 0.9]].map(Vector::from), u);
        // A full stiffness.
        let entry = |i: usize, j: usize| if i == j { 3.0 } else { 0.1 * ((i + 1) * (j + 1)) as f64 / 10.0 };
        let entries = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        let material = LinearElastic::from_solid_stiffness(entries).unwrap();
        let u = [[0.3, -0.1, 0.2], [0.2, 0.7, -0.3], [-0.5, 0.4, 0.1], [0.6, 0.1, 0.9]].map(Vector3::from);
        check::<Solid>(&material, TETRAHEDRON.map(Vector3::from), u);
    }

    #[test]
    fn rigid_rotation_has_no_strain() {
        let corners = [[0.1, 0.2], [1.3, 0.1], [0.4, 0.9]].map(Vector::from);
        let e = Triangle::new(corners).strain(corners.map(perpendicular));
        assert!(e.contract(e) < 1e-28);
        let corners = TETRAHEDRON.map(Vector3::from);
        let turned = corners.map(|x| Solid::turned(Vector3::new(0.3, -0.2, 0.7), x));
        let e: [f64; 6] = Element::<Solid>::new(corners).strain(turned).into();
        assert!(e.iter().all(|e| e.abs() < 1e-14), "{e:?}");
    }

    #[test]
    fn a_linear_field_has_its_strain() {
        // u = G x with a gradient that is not symmetric.
        let gradient = nalgebra::Matrix3::new(0.1, 0.4, -0.3, 0.2, -0.5, 0.7, 0.9, -0.1, 0.3);
        let corners = TETRAHEDRON.map(Vector3::from);
        let e: [f64; 6] = Element::<Solid>::new(corners).strain(corners.map(|x| gradient * x)).into();
        for (found, (i, j)) in e.into_iter().zip([(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]) {
            let expected = 0.5 * (gradient[(i, j)] + gradient[(j, i)]);
            assert!((found - expected).abs() < 1e-14, "{i} {j}");
        }
    }
}

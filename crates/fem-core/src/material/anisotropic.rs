//! Materials whose stiffness depends on the direction.

use super::{Hypothesis, LinearElastic, MaterialError};
use crate::space::{Matrix, Plane, Solid, Space};
use crate::tensor::SymTensor3;
use nalgebra::{Matrix3, Matrix6, RowVector3, Vector3};

/// No modulus or stiffness is larger than this, so that squares of stresses stay finite.
const LARGEST: f64 = 1e100;

/// A stiffness whose eigenvalues differ by more is singular to round-off.
const SINGULAR: f64 = 1e-12;

/// The constants of an orthotropic material with the axes 1 and 2 in the plane and 3 out of it. In space two vectors span that plane, and
/// two more shear moduli are needed, see [`LinearElastic::orthotropic_solid`].
///
/// `ν_ij` is the contraction along j over the extension along i, pulled along i: `ν_ij/E_i = ν_ji/E_j`. Plane stress
/// does not use the constants of axis 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthotropic {
    /// E₁ > 0, Pa.
    pub young_1: f64,
    /// E₂ > 0, Pa.
    pub young_2: f64,
    /// E₃ > 0, Pa.
    pub young_3: f64,
    /// ν₁₂, dimensionless.
    pub poisson_12: f64,
    /// ν₁₃, dimensionless.
    pub poisson_13: f64,
    /// ν₂₃, dimensionless.
    pub poisson_23: f64,
    /// Shear modulus G₁₂ > 0, Pa.
    pub shear: f64,
    /// From the x-axis to axis 1, counter-clockwise, radians.
    pub angle: f64,
}

impl Orthotropic {
    /// Creates the constants of a material whose axis 3 is like axis 2: `E₃ = E₂`, `ν₁₃ = ν₂₃ = ν₁₂`.
    pub fn in_plane(young: [f64; 2], poisson_12: f64, shear: f64, angle: f64) -> Self {
        Self {
            young_1: young[0],
            young_2: young[1],
            young_3: young[1],
            poisson_12,
            poisson_13: poisson_12,
            poisson_23: poisson_12,
            shear,
            angle,
        }
    }

    /// Computes the compliance of the normal components, `S_ii = 1/E_i`, `S_ij = −ν_ij/E_i`, 1/Pa.
    fn normal_compliance(&self) -> Matrix3<f64> {
        let [a, b, c] = [
            -self.poisson_12 / self.young_1,
            -self.poisson_13 / self.young_1,
            -self.poisson_23 / self.young_2,
        ];
        Matrix3::new(1.0 / self.young_1, a, b, a, 1.0 / self.young_2, c, b, c, 1.0 / self.young_3)
    }

    /// Checks ranges and that the energy is positive.
    fn check(&self, hypothesis: Hypothesis) -> Result<(), MaterialError> {
        let plane_strain = hypothesis == Hypothesis::PlaneStrain;
        let mut moduli = vec![("young_1", self.young_1), ("young_2", self.young_2), ("shear", self.shear)];
        // Each ratio with the moduli of its two axes.
        let mut ratios = vec![("poisson_12", self.poisson_12, self.young_1, self.young_2)];
        if plane_strain {
            moduli.push(("young_3", self.young_3));
            ratios.push(("poisson_13", self.poisson_13, self.young_1, self.young_3));
            ratios.push(("poisson_23", self.poisson_23, self.young_2, self.young_3));
        }
        for (name, found) in moduli {
            // The inverse of a smaller number is not finite.
            if !(1.0 / LARGEST..=LARGEST).contains(&found) {
                return Err(MaterialError::Modulus { name, found });
            }
        }
        if !self.angle.is_finite() {
            return Err(MaterialError::NotFinite { name: "angle", found: self.angle });
        }
        for (name, found, along, across) in ratios {
            let limit = (along / across).sqrt();
            if !(found.abs() < limit) {
                return Err(MaterialError::PoissonPair { name, found, limit });
            }
        }
        // 1 − Σ ν_ij ν_ji − 2 ν_12 ν_23 ν_31, the determinant of the compliance times E₁E₂E₃.
        let [e1, e2, e3] = [self.young_1, self.young_2, self.young_3];
        let [a, b, c] = [self.poisson_12, self.poisson_13, self.poisson_23];
        let determinant =
            1.0 - a * a * (e2 / e1) - b * b * (e3 / e1) - c * c * (e3 / e2) - 2.0 * a * b * c * (e3 / e1);
        if plane_strain && !(determinant > SINGULAR) {
            return Err(MaterialError::PoissonTriple { ratios: [a, b, c] });
        }
        Ok(())
    }
}

/// Returns the matrix that transforms a stress `(σ_xx, σ_yy, σ_xy)` to axes rotated by an angle.
fn turn(angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    Matrix3::new(c * c, s * s, 2.0 * c * s, s * s, c * c, -2.0 * c * s, -c * s, c * s, c * c - s * s)
}

fn symmetric(m: &Matrix3<f64>) -> Matrix3<f64> {
    0.5 * (m + m.transpose())
}

impl LinearElastic {
    /// Creates an orthotropic material.
    ///
    /// In its axes the compliance is `S_ij` of the plane in plane stress, `S_ij − S_i3 S_j3/S_33` in plane strain,
    /// where `σ_zz = −(S_13 σ_11 + S_23 σ_22)/S_33`; with `T` the rotation of stresses, `S = Tᵀ S' T` in x and y.
    ///
    /// # Errors
    /// Moduli that are not positive, ratios with which the material is not positive definite.
    pub fn orthotropic(constants: &Orthotropic, hypothesis: Hypothesis) -> Result<Self, MaterialError> {
        constants.check(hypothesis)?;
        let s = constants.normal_compliance();
        let (reduced, out_of_plane) = match hypothesis {
            Hypothesis::PlaneStress => (s, RowVector3::zeros()),
            Hypothesis::PlaneStrain => {
                (s - s.column(2) * s.row(2) / s.m33, RowVector3::new(-s.m13 / s.m33, -s.m23 / s.m33, 0.0))
            }
        };
        let (a, b, d) = (reduced.m11, reduced.m12, reduced.m22);
        let compliance = Matrix3::new(a, b, 0.0, b, d, 0.0, 0.0, 0.0, 1.0 / constants.shear);
        // Divided by a and d one after the other: the products of moduli need not be finite.
        let ratio = 1.0 - (b / a) * (b / d);
        let stiffness = Matrix3::new(
            1.0 / (a * ratio),
            -(b / a) / (d * ratio),
            0.0,
            -(b / a) / (d * ratio),
            1.0 / (d * ratio),
            0.0,
            0.0,
            0.0,
            constants.shear,
        );
        let (to_axes, back) = (turn(constants.angle), turn(-constants.angle));
        let zz = out_of_plane * to_axes;
        let stiffness = symmetric(&(back * stiffness * back.transpose()));
        let compliance = symmetric(&(to_axes.transpose() * compliance * to_axes));
        let axial = if hypothesis == Hypothesis::PlaneStrain { constants.young_3 } else { 0.0 };
        let out_of_plane = Some([zz[0], zz[1], zz[2]]);
        Ok(Self { out_of_plane, axial, ..Self::of(stiffness, compliance) })
    }

    /// Creates a material from its plane stiffness `D`, `(σ_xx, σ_yy, σ_xy) = D (ε_xx, ε_yy, 2 ε_xy)`.
    ///
    /// `D` belongs to the plane problem, whatever the hypothesis; in plane strain `σ_zz` is then unknown.
    ///
    /// * `stiffness`: 3×3 by rows, symmetric (to 1e-12 of its largest entry) and positive definite, Pa.
    ///
    /// # Errors
    /// Entries that are not finite, a matrix that is not symmetric, not positive definite, or singular to round-off.
    pub fn from_stiffness(stiffness: [[f64; 3]; 3], hypothesis: Hypothesis) -> Result<Self, MaterialError> {
        let (stiffness, compliance) = checked::<Plane>(stiffness)?;
        let out_of_plane = match hypothesis {
            Hypothesis::PlaneStrain => None,
            Hypothesis::PlaneStress => Some([0.0; 3]),
        };
        Ok(Self { out_of_plane, ..Self::of(stiffness, compliance) })
    }
}

impl LinearElastic<Solid> {
    /// Creates an orthotropic material of the space.
    ///
    /// * `constants`: with [`Orthotropic::angle`] measured from the first vector, towards the second.
    /// * `shear`: G₁₃ and G₂₃ > 0, Pa.
    /// * `plane`: two vectors that span the plane of axes 1 and 2; of the second one the part perpendicular to the first is used.
    ///
    /// # Errors
    /// Moduli that are not positive, ratios with which the material is not positive definite, parallel vectors.
    pub fn orthotropic_solid(
        constants: &Orthotropic,
        shear: [f64; 2],
        plane: [Vector3<f64>; 2],
    ) -> Result<Self, MaterialError> {
        constants.check(Hypothesis::PlaneStrain)?;
        for (name, found) in ["shear_13", "shear_23"].into_iter().zip(shear) {
            if !(1.0 / LARGEST..=LARGEST).contains(&found) {
                return Err(MaterialError::Modulus { name, found });
            }
        }
        let [x, y] = plane.map(|v| v / v.norm());
        let z = x.cross(&y);
        if !(z.norm() > SINGULAR) {
            return Err(MaterialError::Axes);
        }
        let z = z / z.norm();
        let (sin, cos) = constants.angle.sin_cos();
        let axes = Matrix3::from_columns(&[cos * x + sin * z.cross(&x), cos * z.cross(&x) - sin * x, z]);
        let mut compliance = Matrix6::zeros();
        compliance.fixed_view_mut::<3, 3>(0, 0).copy_from(&constants.normal_compliance());
        for (k, modulus) in [(3, shear[1]), (4, shear[0]), (5, constants.shear)] {
            compliance[(k, k)] = 1.0 / modulus;
        }
        let Some(stiffness) = compliance.inverse() else {
            return Err(MaterialError::NotPositiveDefinite { smallest: 0.0, largest: LARGEST });
        };
        let turn = turn_solid(&axes);
        let turned = turn * stiffness * turn.transpose();
        Self::from_solid_stiffness(std::array::from_fn(|i| {
            std::array::from_fn(|j| 0.5 * (turned[(i, j)] + turned[(j, i)]))
        }))
    }

    /// Creates a material from its stiffness `D`, `(σ_xx, σ_yy, σ_zz, σ_yz, σ_xz, σ_xy) = D (ε_xx, ε_yy, ε_zz, 2 ε_yz, 2 ε_xz, 2 ε_xy)`.
    ///
    /// * `stiffness`: 6×6 by rows, symmetric (to 1e-12 of its largest entry) and positive definite, Pa.
    ///
    /// # Errors
    /// Entries that are not finite, a matrix that is not symmetric, not positive definite, or singular to round-off.
    pub fn from_solid_stiffness(stiffness: [[f64; 6]; 6]) -> Result<Self, MaterialError> {
        let (stiffness, compliance) = checked::<Solid>(stiffness)?;
        Ok(Self::of(stiffness, compliance))
    }
}

/// Returns the matrix that transforms the components of a stress along axes, the columns of a rotation, to components along x, y and z.
fn turn_solid(axes: &Matrix3<f64>) -> Matrix6<f64> {
    let column = |k: usize| -> [f64; 6] {
        let unit = SymTensor3::from(std::array::from_fn(|i| f64::from(u8::from(i == k))));
        let along = [0, 1, 2].map(|i| Solid::applied(unit, Solid::AXES[i]));
        let turned = axes * Matrix3::from_columns(&along) * axes.transpose();
        [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)].map(|place| turned[place])
    };
    Matrix6::from_fn(|i, k| column(k)[i])
}

/// Checks a stiffness; returns it, exactly symmetric, and its inverse.
fn checked<S: Space>(
    given: S::Components<S::Components<f64>>,
) -> Result<(S::Matrix, S::Matrix), MaterialError> {
    let places = || (0..S::COMPONENTS).flat_map(|i| (0..S::COMPONENTS).map(move |j| (i, j)));
    let mut largest_entry = 0.0f64;
    for (i, j) in places() {
        let found = given[i][j];
        if !(found.abs() <= LARGEST) {
            return Err(MaterialError::NotFinite { name: "an entry of the stiffness", found });
        }
        largest_entry = largest_entry.max(found.abs());
    }
    for (i, j) in places().filter(|(i, j)| i < j) {
        let values = [given[i][j], given[j][i]];
        if (values[0] - values[1]).abs() > 1e-12 * largest_entry {
            return Err(MaterialError::NotSymmetric { entry: [i + 1, j + 1], values });
        }
    }
    let singular = |smallest, largest| Err(MaterialError::NotPositiveDefinite { smallest, largest });
    if !(largest_entry >= 1.0 / LARGEST) {
        return singular(0.0, largest_entry);
    }
    let [mut stiffness, mut scaled] = [S::Matrix::default(); 2];
    for (i, j) in places() {
        stiffness[(i, j)] = 0.5 * (given[i][j] + given[j][i]);
        scaled[(i, j)] = stiffness[(i, j)] / largest_entry;
    }
    let eigenvalues = || scaled.eigen().into_iter().map(|(value, _)| value);
    let smallest = eigenvalues().fold(f64::INFINITY, f64::min);
    let largest = eigenvalues().fold(f64::NEG_INFINITY, f64::max);
    let ratio = smallest / largest;
    if ratio > 0.0 && !(ratio > SINGULAR) {
        return Err(MaterialError::NearlySingular { ratio });
    }
    let Some(inverse) = scaled.inverse().filter(|_| smallest > SINGULAR * largest) else {
        return singular(smallest * largest_entry, largest * largest_entry);
    };
    let mut compliance = S::Matrix::default();
    for (i, j) in places() {
        compliance[(i, j)] = 0.5 * (inverse[(i, j)] + inverse[(j, i)]) / largest_entry;
    }
    Ok((stiffness, compliance))
}

#[cfg(test)]
mod tests;

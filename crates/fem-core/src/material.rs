//! Linear elastic materials.
//!
//! In Voigt form `σ = (σ_xx, σ_yy, σ_xy)`, `ε = (ε_xx, ε_yy, 2 ε_xy)` and `σ = D ε`, with `D` 3×3,
//! symmetric and positive definite. In space `σ = (σ_xx, σ_yy, σ_zz, σ_yz, σ_xz, σ_xy)`, and `D` is 6×6.

mod anisotropic;
mod assignment;

use crate::geometry::shown;
use crate::space::{Matrix, Plane, Solid, Space};
use crate::tensor::SymTensor2;
use nalgebra::{Matrix3, Matrix6};
use thiserror::Error;

pub use anisotropic::Orthotropic;
pub use assignment::Materials;

/// The plane hypothesis for the third direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hypothesis {
    /// `ε_zz = 0`: a long body.
    PlaneStrain,
    /// `σ_zz = 0`: a thin sheet.
    PlaneStress,
}

/// Writes six decimals of a limit, with an exponent if it is large or small.
fn six(x: f64) -> String {
    if (1e-4..1e6).contains(&x) { format!("{x:.6}") } else { format!("{x:.6e}") }
}

/// Why a material cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MaterialError {
    /// Young's modulus is not a number from 1e-100 to 1e100.
    #[error("Young's modulus is {found:?}; it must be positive, from 1e-100 to 1e100")]
    Young {
        /// The value found.
        found: f64,
    },
    /// Poisson's ratio is outside the range in which the material is positive definite.
    #[error(
        "Poisson's ratio is {}; it must lie in (-1, 0.5) for an isotropic material: 0.5 is incompressible, \
         which P1 triangles cannot represent",
        shown(*found)
    )]
    Poisson {
        /// The value found.
        found: f64,
    },
    /// A modulus of an orthotropic material is not a positive, finite number.
    #[error("{name} is {found:?}; it must be positive and finite (and at most 1e100)")]
    Modulus {
        /// The modulus, by its field of [`Orthotropic`].
        name: &'static str,
        /// The value found.
        found: f64,
    },
    /// Poisson's ratios for which the energy of an orthotropic material would be negative.
    #[error(
        "{name} is {}, with which the material is not positive definite: it must be smaller than {} in magnitude",
        shown(*found), six(*limit)
    )]
    PoissonPair {
        /// The ratio, by its field of [`Orthotropic`].
        name: &'static str,
        /// The value found.
        found: f64,
        /// `√(E_i/E_j)`.
        limit: f64,
    },
    /// Three Poisson's ratios that are incompatible.
    #[error(
        "poisson_12 = {}, poisson_13 = {} and poisson_23 = {} together make the material not positive definite; make \
         them smaller",
        shown(ratios[0]), shown(ratios[1]), shown(ratios[2])
    )]
    PoissonTriple {
        /// ν₁₂, ν₁₃, ν₂₃.
        ratios: [f64; 3],
    },
    /// Two vectors that span no plane.
    #[error("the axes of the material must be two vectors of finite length that are not parallel")]
    Axes,
    /// A coefficient of thermal expansion is larger than 1, or NaN.
    #[error("the expansion is {}; it must be a number from -1 to 1 (per unit of temperature)", shown(*found))]
    Expansion {
        /// The value found.
        found: f64,
    },
    /// A plane stiffness in plane strain does not tell how a material expands.
    #[error("a given `stiffness` does not tell how much of an expansion along z becomes strain in the plane")]
    ExpansionOfStiffness,
    /// A density is negative, too large, or NaN.
    #[error("the density is {}; it must be a number from 0 to 1e100", shown(*found))]
    Density {
        /// The value found.
        found: f64,
    },
    /// A number that is infinite, NaN, or too large.
    #[error("{name} is {found:?}; it must be a finite number (at most 1e100 in magnitude)")]
    NotFinite {
        /// Name of the number.
        name: &'static str,
        /// The value found.
        found: f64,
    },
    /// A stiffness that is not symmetric.
    #[error(
        "the stiffness is not symmetric: entry ({}, {}) is {} and entry ({}, {}) is {}",
        entry[0], entry[1], shown(values[0]), entry[1], entry[0], shown(values[1])
    )]
    NotSymmetric {
        /// Row and column, from 1, of the entry above the diagonal.
        entry: [usize; 2],
        /// That entry and its mirror image.
        values: [f64; 2],
    },
    /// A stiffness whose smallest eigenvalue is round-off compared with its largest.
    #[error(
        "the stiffness is too nearly singular: ratio {ratio:.0e} of its smallest eigenvalue to its largest; at least \
         1e-12 is needed"
    )]
    NearlySingular {
        /// Smallest eigenvalue over the largest, > 0.
        ratio: f64,
    },
    /// A stiffness that is not positive definite.
    #[error(
        "the stiffness is not positive definite: its smallest eigenvalue is {smallest:.6e}, its largest {largest:.6e}"
    )]
    NotPositiveDefinite {
        /// Smallest eigenvalue, Pa.
        smallest: f64,
        /// Largest eigenvalue, Pa.
        largest: f64,
    },
}

/// A linear elastic material, in the plane under one hypothesis.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearElastic<S: Space = Plane> {
    stiffness: S::Matrix,
    compliance: S::Matrix,
    /// Zero in space. In the plane σ_zz = out_of_plane · (σ_xx, σ_yy, σ_xy), if it is known, less the stress of the strain that is prevented.
    out_of_plane: Option<S::Components<f64>>,
    /// In plane strain Young's modulus along z, Pa; zero otherwise.
    axial: f64,
    /// α of the thermal strain `α T`, and the strain that it is in the plane problem.
    expansion: f64,
    thermal_strain: S::Tensor,
    density: f64,
}

impl<S: Space> LinearElastic<S> {
    fn of(stiffness: S::Matrix, compliance: S::Matrix) -> Self {
        let thermal_strain = S::Tensor::default();
        Self {
            stiffness,
            compliance,
            out_of_plane: Some(S::components(|_| 0.0)),
            axial: 0.0,
            expansion: 0.0,
            thermal_strain,
            density: 0.0,
        }
    }

    /// Gives the material a coefficient of thermal expansion, the same in all directions.
    ///
    /// In plane strain the strain along z is prevented: `ε₀ + ν ε₀_zz 1 = (1 + ν) α T 1` in the plane of an isotropic material.
    ///
    /// * `expansion`: α, 1/K; at most 1 in magnitude.
    ///
    /// # Errors
    /// A coefficient that is larger or NaN; a given stiffness in plane strain, which does not determine the strain.
    pub fn with_expansion(mut self, expansion: f64) -> Result<Self, MaterialError> {
        if !(expansion.abs() <= 1.0) {
            return Err(MaterialError::Expansion { found: expansion });
        }
        let Some(prevented) = self.out_of_plane else { return Err(MaterialError::ExpansionOfStiffness) };
        // From engineering shear.
        let unit = S::components(|k| if k < S::DIM { 1.0 + prevented[k] } else { 0.5 * prevented[k] });
        self.thermal_strain = S::components(|k| expansion * unit[k]).into();
        self.expansion = expansion;
        Ok(self)
    }

    /// Gives the material a density.
    ///
    /// * `density`: kg/m³, from 0 to 1e100.
    ///
    /// # Errors
    /// A density outside its range, or NaN.
    pub fn with_density(mut self, density: f64) -> Result<Self, MaterialError> {
        if !(0.0..=1e100).contains(&density) {
            return Err(MaterialError::Density { found: density });
        }
        self.density = density;
        Ok(self)
    }

    /// Returns the initial strain per unit of temperature, in the plane problem with its part that is prevented along z, 1/K.
    #[inline]
    pub fn thermal_strain(&self) -> S::Tensor {
        self.thermal_strain
    }

    /// Returns the density, kg/m³.
    #[inline]
    pub fn density(&self) -> f64 {
        self.density
    }
}

/// Checks the constants of an isotropic material.
fn check(young: f64, poisson: f64) -> Result<(), MaterialError> {
    if !(1e-100..=1e100).contains(&young) {
        return Err(MaterialError::Young { found: young });
    }
    if !(poisson > -1.0 && poisson < 0.5) {
        return Err(MaterialError::Poisson { found: poisson });
    }
    Ok(())
}

impl LinearElastic {
    /// Creates an isotropic material of the plane.
    ///
    /// Plane strain: `D = λ 1⊗1 + 2µ I` with `λ = Eν/((1+ν)(1−2ν))`, `µ = E/(2(1+ν))`; plane stress
    /// has `λ* = Eν/(1−ν²)` instead of `λ`.
    ///
    /// * `young`: E from 1e-100 to 1e100, Pa.
    /// * `poisson`: ν in (−1, ½), dimensionless.
    ///
    /// # Errors
    /// A modulus or ratio outside its range, or NaN.
    pub fn isotropic(young: f64, poisson: f64, hypothesis: Hypothesis) -> Result<Self, MaterialError> {
        check(young, poisson)?;
        let mu = young / (2.0 * (1.0 + poisson));
        // In-plane Young's modulus and Poisson's ratio: plane strain is plane stress with (E', ν').
        let (lambda, young_plane, poisson_plane) = match hypothesis {
            Hypothesis::PlaneStrain => (
                young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
                young / (1.0 - poisson * poisson),
                poisson / (1.0 - poisson),
            ),
            Hypothesis::PlaneStress => (young * poisson / (1.0 - poisson * poisson), young, poisson),
        };
        let normal = lambda + 2.0 * mu;
        let stiffness = Matrix3::new(normal, lambda, 0.0, lambda, normal, 0.0, 0.0, 0.0, mu);
        let (c, d) = (1.0 / young_plane, -poisson_plane / young_plane);
        let compliance = Matrix3::new(c, d, 0.0, d, c, 0.0, 0.0, 0.0, 1.0 / mu);
        let out_of_plane = match hypothesis {
            Hypothesis::PlaneStrain => [poisson, poisson, 0.0],
            Hypothesis::PlaneStress => [0.0; 3],
        };
        let axial = if hypothesis == Hypothesis::PlaneStrain { young } else { 0.0 };
        Ok(Self { out_of_plane: Some(out_of_plane), axial, ..Self::of(stiffness, compliance) })
    }

    /// Returns the entries of `D⁻¹`, the upper half by rows, 1/Pa.
    #[inline]
    pub fn compliance_entries(&self) -> [f64; 6] {
        let c = &self.compliance;
        [c.m11, c.m12, c.m13, c.m22, c.m23, c.m33]
    }

    /// Computes von Mises' equivalent stress with the out-of-plane stress of the hypothesis, Pa; `None` if that is
    /// unknown.
    ///
    /// * `temperature`: its change, K.
    pub fn von_mises(&self, sigma: SymTensor2, temperature: f64) -> Option<f64> {
        let zz = self.out_of_plane_stress(sigma, temperature)?;
        let pairs = (sigma.xx - sigma.yy).powi(2) + (sigma.yy - zz).powi(2) + (zz - sigma.xx).powi(2);
        Some((0.5 * pairs + 3.0 * sigma.xy * sigma.xy).sqrt())
    }

    /// Computes `σ_zz`: `ν(σ_xx + σ_yy) − E α T` in plane strain of an isotropic material, 0 in plane stress; `None` for a given
    /// plane stiffness in plane strain, which does not determine it.
    ///
    /// * `temperature`: its change T, K.
    pub fn out_of_plane_stress(&self, sigma: SymTensor2, temperature: f64) -> Option<f64> {
        let prevented = self.axial * self.expansion * temperature;
        self.out_of_plane.map(|[a, b, c]| a * sigma.xx + b * sigma.yy + c * sigma.xy - prevented)
    }
}

impl LinearElastic<Solid> {
    /// Creates an isotropic material of the space, `σ = λ tr ε 1 + 2µ ε`.
    ///
    /// * `young`: E from 1e-100 to 1e100, Pa; `poisson`: ν in (−1, ½), dimensionless.
    ///
    /// # Errors
    /// A modulus or ratio outside its range, or NaN.
    pub fn isotropic_solid(young: f64, poisson: f64) -> Result<Self, MaterialError> {
        check(young, poisson)?;
        let mu = young / (2.0 * (1.0 + poisson));
        let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let entries = |same: f64, other: f64, shear: f64| {
            Matrix6::from_fn(|i, j| match (i == j, i < 3 && j < 3) {
                (true, true) => same,
                (false, true) => other,
                (true, false) => shear,
                (false, false) => 0.0,
            })
        };
        let compliance = entries(1.0 / young, -poisson / young, 1.0 / mu);
        Ok(Self::of(entries(lambda + 2.0 * mu, lambda, mu), compliance))
    }
}

impl<S: Space> LinearElastic<S> {
    /// Returns `D` of `σ = D ε` (Voigt, engineering shear), Pa.
    pub fn stiffness(&self) -> &S::Matrix {
        &self.stiffness
    }

    /// Computes the stress of a strain, `σ = E ε`.
    #[inline]
    pub fn stress(&self, strain: S::Tensor) -> S::Tensor {
        let e: S::Components<f64> = strain.into();
        self.stiffness.times(&S::components(|k| if k < S::DIM { e[k] } else { 2.0 * e[k] })).into()
    }

    /// Computes the strain of a stress, `ε = E⁻¹ σ`.
    #[inline]
    pub fn strain(&self, stress: S::Tensor) -> S::Tensor {
        let e = self.compliance.times(&stress.into());
        S::components(|k| if k < S::DIM { e[k] } else { 0.5 * e[k] }).into()
    }

    /// Computes `1/(E⁻¹)₁₁`, Pa: Young's modulus along the first axis, in plane strain over `1 − ν²`.
    pub fn axial_modulus(&self) -> f64 {
        let tension = S::components(|k| if k == 0 { 1.0 } else { 0.0 }).into();
        1.0 / self.complementary(tension, tension)
    }

    /// Computes `σ : E⁻¹ τ`, the complementary energy product of two stresses (J/m³, no factor ½).
    #[inline]
    pub fn complementary(&self, sigma: S::Tensor, tau: S::Tensor) -> f64 {
        S::contracted(sigma, self.strain(tau))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compliance_inverts_stiffness() {
        for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
            let m = LinearElastic::isotropic(2000.0, 0.3, hypothesis).unwrap();
            let product = m.stiffness * m.compliance;
            assert!((product - Matrix3::identity()).norm() < 1e-14);
        }
    }

    #[test]
    fn uniaxial_plane_stress_has_youngs_modulus() {
        let m = LinearElastic::isotropic(200.0, 0.25, Hypothesis::PlaneStress).unwrap();
        let s = m.stress(SymTensor2::new(1.0, -0.25, 0.0));
        assert!((s.xx - 200.0).abs() < 1e-12 && s.yy.abs() < 1e-12);
        assert!((m.von_mises(s, 0.0).unwrap() - 200.0).abs() < 1e-12);
    }

    #[test]
    fn limits_of_the_range_are_refused() {
        for nu in [0.5, -1.0, f64::NAN, 0.7] {
            let e = LinearElastic::isotropic(1.0, nu, Hypothesis::PlaneStress).unwrap_err();
            assert!(matches!(e, MaterialError::Poisson { .. }));
        }
        for young in [0.0, 1e-310, -1.0, f64::NAN, f64::INFINITY, 1e308] {
            let e = LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap_err();
            assert!(matches!(e, MaterialError::Young { .. }));
        }
    }
}

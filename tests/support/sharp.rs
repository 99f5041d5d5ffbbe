//! Problems on which an equilibrated stress is hard to make sharp: nearly incompressible and strongly orthotropic
//! materials, flat cells.
//!
//! ```text
//!    u_x = 0, u_y = −0.01 (1 + x/2)        two blocks of 2 × 1 (2 × 1.14 of flat cells), 270 cells each,
//!   ┌────────┐                             without structure inside; they touch along the whole of y = 0
//!   │   Ω₁   │→ (0, 0.001 E)
//!   ├────────┤ Γ_C
//!   │   Ω₂   │
//!   └────────┘ clamped
//! ```
//! Units: any consistent set. The reference is the potential energy by quadratic triangles on the same mesh and on three finer
//! ones, extrapolated ([`crate::quadratic`]): [`Sharp::reference`] was computed so, and `cargo xtask reproduce adversarial`
//! computes it again.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Hypothesis, LinearElastic, Made, ScalarData, TriMesh, Vector,
    stacked,
};
use crate::random::Random;
use crate::shapes::unstructured;
use fem_core::assembly::external_forces;
use fem_core::material::Orthotropic;
use fem_core::norm::energy_norm_squared;

/// The difficulty of the problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sharp {
    /// Poisson's ratio of both bodies.
    Incompressible(f64),
    /// Ratio of the moduli along and across the fibres, which are inclined by 0.5 and −0.3 radians.
    Orthotropic(f64),
    /// Rows of flat cells, of 4.8 degrees at least.
    Flat,
}

impl Sharp {
    /// One problem of each family.
    pub const ALL: [Self; 5] = [
        Self::Incompressible(0.4999),
        Self::Incompressible(0.49999),
        Self::Orthotropic(100.0),
        Self::Orthotropic(1000.0),
        Self::Flat,
    ];

    /// Names the problem.
    pub fn name(self) -> String {
        match self {
            Self::Incompressible(nu) => format!("Poisson's ratio {nu}"),
            Self::Orthotropic(ratio) => format!("orthotropic {ratio}:1"),
            Self::Flat => "cells of 4.8 degrees".into(),
        }
    }

    /// Potential energy of the exact solution, J/m: by quadratic triangles on four meshes, the last three extrapolated. The
    /// extrapolation adds at most 0.6 % of what linear triangles miss.
    pub fn reference(self) -> f64 {
        match self {
            Self::Incompressible(nu) if nu < 0.499_95 => 2.170_024_41e-4,
            Self::Incompressible(_) => 2.170_679_44e-4,
            Self::Orthotropic(ratio) if ratio < 300.0 => 1.402_479_40e-4,
            Self::Orthotropic(_) => 1.408_526_76e-4,
            Self::Flat => 1.335_982_05e-4,
        }
    }

    fn material(self, b: usize) -> Made<LinearElastic> {
        let hypothesis = Hypothesis::PlaneStrain;
        Ok(match self {
            Self::Incompressible(nu) => LinearElastic::isotropic(1.0, nu, hypothesis)?,
            Self::Orthotropic(ratio) => {
                let constants = Orthotropic::in_plane([ratio, 1.0], 0.3, 0.4, [0.5, -0.3][b]);
                LinearElastic::orthotropic(&constants, hypothesis)?
            }
            Self::Flat => LinearElastic::isotropic(1.0, 0.3, hypothesis)?,
        })
    }

    fn mesh(self, b: usize) -> Made<TriMesh> {
        let (cells, height) = if self == Self::Flat { ([5, 27], 1.14) } else { ([15, 9], 1.0) };
        let mut random = Random::new(17 + b as u64);
        Ok(unstructured([0.0, -height * b as f64], [2.0, height], cells, 0.2, &mut random)?)
    }

    /// Makes the problem.
    ///
    /// # Errors
    /// None.
    pub fn problem(self) -> Made<ContactProblem> {
        let push = |x: Vector| -0.01 * (1.0 + 0.5 * x[0]);
        let push = ScalarData::function(push);
        let upper = BoundaryConditions::new()
            .displace("top", Some(0.0.into()), Some(push))
            .traction("right", [0.0.into(), 0.001.into()]);
        let upper = Body::new(self.mesh(0)?, self.material(0)?, &upper)?;
        let lower = Body::new(self.mesh(1)?, self.material(1)?, &BoundaryConditions::new().fix("bottom"))?;
        stacked([upper, lower])
    }

    /// Computes `‖v‖` and the error of `v`, `√(2 (J(v) − J(u)))`, which `e_CRE` bounds.
    ///
    /// * `v`: admissible displacements of both bodies.
    pub fn norm_and_error(self, problem: &ContactProblem, v: &[Vec<Vector>]) -> [f64; 2] {
        let (mut norm, mut potential) = (0.0, 0.0);
        for (body, v) in problem.bodies.iter().zip(v) {
            let energy = energy_norm_squared(body, v);
            norm += energy;
            potential +=
                0.5 * energy - external_forces(body).iter().zip(v).map(|(f, v)| f.dot(v)).sum::<f64>();
        }
        [norm, 2.0 * (potential - self.reference())].map(f64::sqrt)
    }
}

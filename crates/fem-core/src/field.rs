//! Fields on a body: strains and stresses of a displacement, residual forces.

use crate::assembly::external_forces;
use crate::body::Body;
use crate::element::Triangle;
use crate::geometry::Vector;
use crate::tensor::SymTensor2;
use rayon::prelude::*;

/// Computes the stress of a displacement field in every triangle, Pa.
///
/// * `displacement`: Cartesian, one per node, m.
pub fn stresses(body: &Body, displacement: &[Vector]) -> Vec<SymTensor2> {
    let mesh = body.mesh();
    (0..mesh.cells().len())
        .into_par_iter()
        .with_min_len(1024)
        .map(|t| {
            let u = mesh.cells()[t].map(|n| displacement[n]);
            body.material(t).stress(Triangle::new(mesh.corners(t)).strain(u))
        })
        .collect()
}

/// Computes `K u − f` at every node, Cartesian, N/m: zero at nodes with loads only, the support's
/// reaction where a displacement is imposed, the contact force on the interface.
pub fn nodal_residual(body: &Body, displacement: &[Vector]) -> Vec<Vector> {
    let mesh = body.mesh();
    residual(body, |t, element| {
        let strain = element.strain(mesh.cells()[t].map(|n| displacement[n]));
        body.material(t).stress(strain)
    })
}

/// Computes `∫ σ : ε(φ) − f(φ)` at every node, Cartesian, N/m, of a stress given by its mean in every triangle, Pa.
pub fn stress_residual(body: &Body, means: &[SymTensor2]) -> Vec<Vector> {
    residual(body, |t, _| means[t])
}

/// Gathers the forces of constant stresses and subtracts the loads.
fn residual(body: &Body, stress: impl Fn(usize, &Triangle) -> SymTensor2) -> Vec<Vector> {
    let mesh = body.mesh();
    let mut residual: Vec<Vector> = external_forces(body).into_iter().map(|f| -f).collect();
    for (t, corners) in mesh.cells().iter().enumerate() {
        let element = Triangle::new(mesh.corners(t));
        for (&n, f) in corners.iter().zip(element.internal_forces(stress(t, &element))) {
            residual[n] += f;
        }
    }
    residual
}

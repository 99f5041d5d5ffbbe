//! Fields on a body: strains and stresses of a displacement, residual forces.

use crate::assembly::{external_forces, spring_forces};
use crate::body::Body;
use crate::element::Element;
use crate::space::Space;
use rayon::prelude::*;

/// Computes the stress of a displacement field in every cell, Pa; its mean if the temperature changes.
///
/// * `displacement`: Cartesian, one per node, m.
pub fn stresses<S: Space>(body: &Body<S>, displacement: &[S::Vector]) -> Vec<S::Tensor> {
    let mesh = body.mesh();
    (0..mesh.cells().len())
        .into_par_iter()
        .with_min_len(1024)
        .map(|t| {
            let element = Element::<S>::new(mesh.corners(t));
            body.stress(t, strain(body, t, &element, displacement))
        })
        .collect()
}

/// Computes the strain of a displacement field in a cell.
#[inline]
pub(crate) fn strain<S: Space>(
    body: &Body<S>,
    cell: usize,
    element: &Element<S>,
    displacement: &[S::Vector],
) -> S::Tensor {
    let nodes = &body.mesh().cells()[cell];
    element.strain(S::corners(|k| displacement[nodes[k]]))
}

/// Computes `K u − f` at every node, Cartesian, N/m: zero at nodes with loads only, the support's
/// reaction where a displacement is imposed, the contact force on the interface.
pub fn nodal_residual<S: Space>(body: &Body<S>, displacement: &[S::Vector]) -> Vec<S::Vector> {
    let mut forces = residual(body, |t, element| body.stress(t, strain(body, t, element, displacement)));
    spring_forces(body, displacement).for_each(|(node, force)| forces[node] -= force);
    forces
}

/// Computes `∫ σ : ε(φ) − f(φ)` at every node, Cartesian, N/m, of a stress given by its mean in every cell, Pa: without springs.
pub fn stress_residual<S: Space>(body: &Body<S>, means: &[S::Tensor]) -> Vec<S::Vector> {
    residual(body, |t, _| means[t])
}

/// Gathers the forces of constant stresses and subtracts the loads.
fn residual<S: Space>(body: &Body<S>, stress: impl Fn(usize, &Element<S>) -> S::Tensor) -> Vec<S::Vector> {
    let mesh = body.mesh();
    let mut residual: Vec<S::Vector> = external_forces(body).into_iter().map(|f| -f).collect();
    for (t, corners) in mesh.cells().iter().copied().enumerate() {
        let element = Element::<S>::new(mesh.corners(t));
        for (n, f) in corners.into_iter().zip(element.internal_forces(stress(t, &element))) {
            residual[n] += f;
        }
    }
    residual
}

//! Layered anisotropic blocks pressed together, exact for P1 triangles.
//!
//! ```text
//!      u given, linear
//!   ┌───────────────┐  h₂       every layer has its own material, of any anisotropy; all have the same
//! s │  Ω₁, layer 2  │ s         extension e along x, so that the lateral tractions s differ by layer
//!   ├───────────────┤  h₁
//! s │  Ω₁, layer 1  │ s
//!   ├───────────────┤  Γ_C, y = 0: pressure p, no shear
//! s │  Ω₂, layers   │ s         the same downwards
//!   └───────────────┘           width 2
//!      u given, linear
//! ```
//! Units: any consistent set. Exact, by inspection: in each layer `σ = (s, −p, 0)` with `s` such that `ε_xx = e`, so
//! `u_x = e x + ∫ 2ε_xy dy` and `u_y = ∫ ε_yy dy`, both 0 at the origin and continuous; `e_CRE = 0`.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, FacetSelection, LinearElastic, Made, ScalarData, SymTensor2,
    Vector, block, stacked,
};
use fem_core::material::Materials;

/// The pressure p.
pub const PRESSURE: f64 = 3.0;
/// The extension e of all layers along x.
pub const EXTENSION: f64 = 0.002;
/// Height of each layer: the layers of a body have two rows of cells each.
pub const HEIGHT: f64 = 0.5;
/// Width of both bodies.
pub const WIDTH: f64 = 2.0;

/// Computes stress and strain of a layer.
pub fn state(material: &LinearElastic) -> (SymTensor2, SymTensor2) {
    let along = material.strain(SymTensor2::new(1.0, 0.0, 0.0)).xx;
    let across = material.strain(SymTensor2::new(0.0, -PRESSURE, 0.0)).xx;
    let stress = SymTensor2::new((EXTENSION - across) / along, -PRESSURE, 0.0);
    (stress, material.strain(stress))
}

/// Computes the exact displacement at a point, of the body with these layers from the interface outwards.
pub fn displacement(layers: &[LinearElastic], x: Vector) -> Vector {
    let (side, mut left) = (x[1].signum(), x[1].abs());
    let mut u = Vector::new(EXTENSION * x[0], 0.0);
    for layer in layers {
        let (_, strain) = state(layer);
        let part = side * left.min(HEIGHT);
        u[0] += 2.0 * strain.xy * part;
        u[1] += strain.yy * part;
        left = (left - HEIGHT).max(0.0);
    }
    u
}

/// The exact energy norm² of the body with these layers.
pub fn energy(layers: &[LinearElastic]) -> f64 {
    layers.iter().map(|m| state(m).0.contract(state(m).1) * WIDTH * HEIGHT).sum()
}

/// The problem, with the layers of each body from the interface outwards.
///
/// # Errors
/// None, for at least one layer each.
pub fn problem(layers: [&[LinearElastic]; 2]) -> Made<ContactProblem> {
    let body = |layers: &[LinearElastic], upper: bool| -> Made<Body> {
        let height = HEIGHT * layers.len() as f64;
        let low = if upper { 0.0 } else { -height };
        let mesh = block([0.0, low], [WIDTH, height], [5, 2 * layers.len()])?;
        let owned = layers.to_vec();
        let exact = move |c: usize| {
            let layers = owned.clone();
            Some(ScalarData::function(move |x| displacement(&layers, x)[c]))
        };
        let far = if upper { "top" } else { "bottom" };
        let mut conditions = BoundaryConditions::new().displace(far, exact(0), exact(1));
        for (k, layer) in layers.iter().enumerate() {
            let from = HEIGHT * k as f64;
            let limits = if upper { [from, from + HEIGHT] } else { [-from - HEIGHT, -from] };
            let s = state(layer).0.xx;
            for (side, sign) in [("left", -1.0), ("right", 1.0)] {
                let edges = FacetSelection::group(side).within([[f64::NEG_INFINITY, f64::INFINITY], limits]);
                conditions = conditions.traction(edges, [(sign * s).into(), 0.0.into()]);
            }
        }
        let of_triangle = (0..mesh.cells().len())
            .map(|t| {
                let corners = mesh.corners(t);
                let y = (corners[0][1] + corners[1][1] + corners[2][1]) / 3.0;
                (y.abs() / HEIGHT) as u32
            })
            .collect();
        Ok(Body::new(mesh, Materials::by_cell(layers.to_vec(), of_triangle), &conditions)?)
    };
    let upper = body(layers[0], true)?;
    let lower = body(layers[1], false)?;
    stacked([upper, lower])
}

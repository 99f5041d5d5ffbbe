//! A flat punch with rounded edges on a wide block: declared arcs that continue a straight side.
//!
//! ```text
//!      stays flat, P down, does not turn
//!    ┌───────────────┐
//!    │       Ω₁      │
//!     \_____________/      arcs of radius R begin at x = ±b
//!   ─────────────────────  Ω₂, held at its foot
//! ```
//! Units: mm, N, MPa. Plane strain, steel on steel. Exact for two half planes: Ciavarella, Hills and Monno, The influence of rounded edges on
//! indentation by a flat punch, Proc. Inst. Mech. Eng. C 212 (1998), 319-328. With `sin φ = b/a` and `1/E* = 1/E₁' + 1/E₂'` the half width
//! `a` of contact is a root of `4 P R/(b² E*) = (π − 2φ)/sin² φ − 2 cot φ`; with `x = a sin ψ` the pressure is
//! `2P/(πa) ((π−2φ) cos ψ + sin ψ ln|sin(ψ+φ)/sin(ψ−φ)| + sin φ ln|tan ½(ψ+φ) tan ½(ψ−φ)|)/(π − 2φ − sin 2φ)`.

use crate::model::{Body, BoundaryConditions, ContactProblem, Gap, Made, TriMesh, Vector, isotropic};
use crate::run::paired_in_common;
use fem_core::body::{CurveKind, CurvedSide};
use fem_core::boundary::RigidCondition;
use fem_core::interface::ContactNormal;

/// Half width of the flat part.
pub const FLAT: f64 = 5.0;
/// Radius of the arcs.
pub const RADIUS: f64 = 10.0;
/// Force per thickness.
pub const FORCE: f64 = 2000.0;
/// Largest pressure.
pub const PEAK: f64 = 829.487;
/// Half width of contact.
pub const HALF_WIDTH: f64 = 5.18746;

/// Half width of the punch, its height, and half width and depth of the block.
const PUNCH: [f64; 2] = [8.0, 16.0];
const BLOCK: [f64; 2] = [40.0, 50.0];

/// Computes the height of the punch's outline.
pub fn outline(x: f64) -> f64 {
    let past = (x.abs() - FLAT).max(0.0);
    // Without a difference of nearly equal numbers.
    past * past / (RADIUS + (RADIUS * RADIUS - past * past).sqrt())
}

/// The problem on a first mesh.
///
/// * `edge`: length of the punch's edges on the contact side.
///
/// # Errors
/// None, for sensible lengths.
pub fn problem(edge: f64) -> Made<ContactProblem> {
    let steel = || isotropic(210e3, 0.3);
    let top = RigidCondition {
        edges: "top".into(),
        translation: [Some(0.0), None],
        rotation: Some(0.0),
        force: Vector::new(0.0, -FORCE),
        moment: 0.0,
        about: None,
    };
    let arcs = CurvedSide { on: "round".to_owned(), kind: CurveKind::Arc };
    let punch =
        Body::new(punch(edge)?, steel()?, &BoundaryConditions::new().rigid(top))?.with_curves(&[arcs])?;
    let block = crate::model::block([-BLOCK[0], -BLOCK[1]], [2.0 * BLOCK[0], BLOCK[1]], [57, 36])?;
    let base = Body::new(block, steel()?, &BoundaryConditions::new().fix("bottom"))?;
    let made = paired_in_common([punch, base], ["tip", "top"], &Gap::Geometric, ContactNormal::Averaged)?;
    Ok(made.0)
}

/// Meshes the punch: columns between the outline and the top.
fn punch(edge: f64) -> Made<TriMesh> {
    let steps = |length: f64| (length / edge).ceil();
    let (round, flat) = (steps(PUNCH[0] - FLAT), steps(2.0 * FLAT));
    let side = |k: f64| FLAT + (PUNCH[0] - FLAT) * k / round;
    let left = (0..round as usize).rev().map(|k| -side(k as f64 + 1.0));
    let middle = (0..=flat as usize).map(|k| -FLAT + 2.0 * FLAT * k as f64 / flat);
    let right = (0..round as usize).map(|k| side(k as f64 + 1.0));
    let xs: Vec<f64> = left.chain(middle).chain(right).collect();
    let rows = 16;
    let mut points = Vec::new();
    for x in &xs {
        for j in 0..=rows {
            let t = (f64::from(j) / f64::from(rows)).powf(1.5);
            points.push(Vector::new(*x, (1.0 - t) * outline(*x) + t * PUNCH[1]));
        }
    }
    let number = |i: usize, j: u32| i as u32 * (rows + 1) + j;
    let (mut cells, mut tip, mut top, mut arcs) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for i in 0..xs.len() - 1 {
        for j in 0..rows {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            cells.extend([[a, b, c], [a, c, d]]);
        }
        let lower = [number(i, 0), number(i + 1, 0)];
        tip.push(lower);
        top.push([number(i, rows), number(i + 1, rows)]);
        if xs[i] >= FLAT || xs[i + 1] <= -FLAT {
            arcs.push(lower);
        }
    }
    let groups = [("tip", tip), ("top", top), ("round", arcs)].map(|(name, edges)| (name.to_owned(), edges));
    Ok(TriMesh::new(points, cells, groups.to_vec())?)
}

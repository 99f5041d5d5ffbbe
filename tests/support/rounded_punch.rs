//! A flat punch with rounded edges on a wide block: declared arcs that continue a straight side.
//!
//! ```text
//!   stays flat, P down, does not turn
//!   ┌───────────────────────────┐
//!   │            Ω₁             │
//!    ‾‾‾‾‾\_____________/‾‾‾‾‾     arcs of radius R begin at x = ±b, and go over into their tangents
//!   ─────────────────────────────  Ω₂, held at its foot
//! ```
//! Both bodies are nearly half planes: with a punch of half width 8 or 10 whose sides are free the peak is 5.5 % or 3 % lower.
//!
//! Units: mm, N, MPa. Plane strain, steel on steel. Exact for two half planes: Ciavarella, Hills and Monno, The influence of rounded edges on
//! indentation by a flat punch, Proc. Inst. Mech. Eng. C 212 (1998), 319-328. With `sin φ = b/a` and `1/E* = 1/E₁' + 1/E₂'` the half width
//! `a` of contact is a root of `4 P R/(b² E*) = (π − 2φ)/sin² φ − 2 cot φ`; with `x = a sin ψ` the pressure is
//! `2P/(πa) ((π−2φ) cos ψ + sin ψ ln|sin(ψ+φ)/sin(ψ−φ)| + sin φ ln|tan ½(ψ+φ) tan ½(ψ−φ)|)/(π − 2φ − sin 2φ)`.

use crate::model::{Body, BoundaryConditions, ContactProblem, Gap, Made, TriMesh, Vector, isotropic};
use crate::run::paired_in_common;
use contact_geometry::ContactNormal;
use fem_core::body::{CurveKind, CurvedSide};
use fem_core::boundary::RigidCondition;

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

/// Half width and height of the punch; the block has them as well.
const SIZE: [f64; 2] = [40.0, 50.0];
/// The arcs end this far from the flat part.
const ROUND: f64 = 1.4;
/// Half width of the punch's contact side.
const TIP: f64 = 9.0;
/// Rows of cells over the height of the punch, and their grading.
const ROWS: u32 = 20;

/// Computes the height of the punch's outline.
pub fn outline(x: f64) -> f64 {
    let past = (x.abs() - FLAT).max(0.0);
    let round = past.min(ROUND);
    let root = (RADIUS * RADIUS - round * round).sqrt();
    // Without a difference of nearly equal numbers.
    round * round / (RADIUS + root) + (past - round) * round / root
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
        motion: [Some(0.0), None, Some(0.0)],
        force: Vector::new(0.0, -FORCE),
        moment: 0.0,
        about: None,
    };
    let arcs = CurvedSide { on: "round".to_owned(), kind: CurveKind::Arc };
    let punch =
        Body::new(punch(edge)?, steel()?, &BoundaryConditions::new().rigid(top))?.with_curves(&[arcs])?;
    let block = crate::model::block([-SIZE[0], -SIZE[1]], [2.0 * SIZE[0], SIZE[1]], [57, 36])?;
    let base = Body::new(block, steel()?, &BoundaryConditions::new().fix("bottom"))?;
    let made = paired_in_common([punch, base], ["tip", "top"], &Gap::Geometric, ContactNormal::Averaged)?;
    Ok(made.0)
}

/// Lists the places of the punch's columns from its middle to its side: of one width to the end of the arc, wider by a third each beyond.
fn columns(edge: f64) -> Vec<f64> {
    let steps = |length: f64| (length / edge).ceil() as u32;
    let (flat, round) = (steps(FLAT), steps(ROUND).max(2));
    let mut xs: Vec<f64> = (0..=flat).map(|k| FLAT * f64::from(k) / f64::from(flat)).collect();
    xs.extend((1..=round).map(|k| FLAT + ROUND * f64::from(k) / f64::from(round)));
    let (arc, mut width) = (FLAT + ROUND, ROUND / f64::from(round));
    let mut beyond = vec![arc];
    while let Some(last) = beyond.last().copied().filter(|last| *last < SIZE[0]) {
        width *= 4.0 / 3.0;
        beyond.push(last + width);
    }
    let scale = (SIZE[0] - arc) / (beyond[beyond.len() - 1] - arc);
    xs.extend(beyond.iter().skip(1).map(|x| arc + scale * (x - arc)));
    xs
}

/// Meshes the punch: columns between the outline and the top.
fn punch(edge: f64) -> Made<TriMesh> {
    let right = columns(edge);
    let xs: Vec<f64> = right[1..].iter().rev().map(|x| -x).chain(right.iter().copied()).collect();
    // The first cells are as high as they are wide.
    let grading = ((edge / SIZE[1]).ln() / (1.0 / f64::from(ROWS)).ln()).max(1.0);
    let mut points = Vec::new();
    for x in &xs {
        for j in 0..=ROWS {
            let t = (f64::from(j) / f64::from(ROWS)).powf(grading);
            points.push(Vector::new(*x, (1.0 - t) * outline(*x) + t * SIZE[1]));
        }
    }
    let number = |i: usize, j: u32| i as u32 * (ROWS + 1) + j;
    let (mut cells, mut tip, mut top, mut arcs) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for i in 0..xs.len() - 1 {
        for j in 0..ROWS {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            cells.extend([[a, b, c], [a, c, d]]);
        }
        let lower = [number(i, 0), number(i + 1, 0)];
        let middle = 0.5 * (xs[i] + xs[i + 1]).abs();
        if middle < TIP {
            tip.push(lower);
        }
        top.push([number(i, ROWS), number(i + 1, ROWS)]);
        if (FLAT..FLAT + ROUND).contains(&middle) {
            arcs.push(lower);
        }
    }
    let groups = [("tip", tip), ("top", top), ("round", arcs)].map(|(name, edges)| (name.to_owned(), edges));
    Ok(TriMesh::new(points, cells, groups.to_vec())?)
}

//! A pin with clearance in the hole of a lug that is pulled: contact on two arcs of different radii.
//!
//! ```text
//!    ________________________
//!   /   __                   |
//!  |   /  \  pin: held at     |  lug: its end moves to the right by 0.2
//!  |   \__/  its bore         |
//!   \________________________|
//! ```
//! Units: mm, N, MPa. Plane stress, steel in aluminium. There is no exact solution: peak stresses from different first meshes
//! are compared.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Gap, Hypothesis, LinearElastic, Made, TriMesh, Vector, pair,
    ring,
};
use fem_core::body::{BodyError, CurveKind, CurvedSide};
use fem_core::geometry::norm;
use fem_core::mesh::MeshError;
use std::f64::consts::TAU;

/// Radius of the pin.
pub const PIN: f64 = 9.95;
/// Radius of the hole.
pub const HOLE: f64 = 10.0;
/// Largest coordinates of the lug: its end, and half its width, the radius of its round side.
const LUG: [f64; 2] = [90.0, 25.0];

/// The problem with its arcs declared as `kind`, or as polygons.
///
/// * `around`: edges of the hole and the pin; `across`: cells from the hole to the outline, and from the pin's bore to its surface.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(around: usize, across: [usize; 2], kind: Option<CurveKind>) -> Made<ContactProblem> {
    let curved = |body: Body, sides: &[&str]| -> Result<Body, BodyError> {
        let side = |kind| sides.iter().map(move |on| CurvedSide { on: (*on).to_owned(), kind });
        body.with_curves(&kind.map(side).into_iter().flatten().collect::<Vec<_>>())
    };
    let steel = LinearElastic::isotropic(210e3, 0.3, Hypothesis::PlaneStress)?;
    let aluminium = LinearElastic::isotropic(70e3, 0.33, Hypothesis::PlaneStress)?;
    let pin = ring([0.0; 2], [4.0, PIN], [0.0, 360.0], [around, across[1]])?;
    let pin = curved(Body::new(pin, steel, &BoundaryConditions::new().fix("inner"))?, &["inner", "outer"])?;
    let pulled = BoundaryConditions::new().displace("end", Some(0.2.into()), Some(0.0.into()));
    let lug = curved(Body::new(lug(around, across[0])?, aluminium, &pulled)?, &["hole", "round"])?;
    pair([pin, lug], ["outer", "hole"], &Gap::Geometric)
}

/// The lug: rays from the hole to the outline, with cells that grow outwards.
fn lug(around: usize, across: usize) -> Result<TriMesh, MeshError> {
    let ray = |k: usize| {
        let angle = TAU * k as f64 / around as f64;
        Vector::new(angle.cos(), angle.sin())
    };
    let [end, half] = LUG;
    let outline = |d: Vector| {
        let flat = if d[1] == 0.0 { f64::INFINITY } else { half / d[1].abs() };
        if d[0] > 0.0 { flat.min(end / d[0]) * d } else { half * d }
    };
    let mut outer: Vec<Vector> = (0..around).map(|k| outline(ray(k))).collect();
    for corner in [Vector::new(end, half), Vector::new(end, -half)] {
        let nearest =
            (0..around).min_by(|a, b| norm(outer[*a] - corner).total_cmp(&norm(outer[*b] - corner)));
        outer[nearest.unwrap_or(0)] = corner;
    }
    // The last cell of a ray is about three times as long as the first.
    let growth = 3.0f64.powf(1.0 / across as f64);
    let whole = growth.powi(across as i32) - 1.0;
    let mut points = Vec::new();
    for k in 0..around {
        for j in 0..=across {
            let share = (growth.powi(j as i32) - 1.0) / whole;
            points.push(HOLE * (1.0 - share) * ray(k) + share * outer[k]);
        }
    }
    let number = |k: usize, j: usize| ((k % around) * (across + 1) + j) as u32;
    let (mut cells, mut sides) = (Vec::new(), [Vec::new(), Vec::new(), Vec::new()]);
    for k in 0..around {
        for j in 0..across {
            let [a, b] = [k, k + 1].map(|k| [number(k, j), number(k, j + 1)]);
            cells.extend([[a[0], a[1], b[1]], [a[0], b[1], b[0]]]);
        }
        sides[0].push([number(k, 0), number(k + 1, 0)]);
        let ends = [outer[k], outer[(k + 1) % around]];
        let edge = [number(k, across), number(k + 1, across)];
        if ends.iter().all(|p| p[0] == end) {
            sides[1].push(edge);
        }
        if ends.iter().all(|p| p[0] < 1e-9 * end) {
            sides[2].push(edge);
        }
    }
    let [hole, at_end, round] = sides;
    TriMesh::new(
        points,
        cells,
        vec![("hole".to_owned(), hole), ("end".to_owned(), at_end), ("round".to_owned(), round)],
    )
}

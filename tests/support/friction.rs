//! Problems with friction: the two blocks of the paper with both components imposed on the top, a patch that slips, a block on a slope, and a
//! block that is pushed over a rigid plane.
//!
//! ```text
//!      u = (0.004, −0.02)               pressure 50
//!   ┌─────────────────────┐           ┌─────────────┐
//!   │       E = 2000      │ ↑      →  │             │▒
//!   ├─────────────────────┤ 30   150  │             │▒ u_x = 0
//!   │       E = 1000      │        →  │             │▒
//!   └─────────────────────┘           └─────────────┘
//!           clamped                  ▒▒▒ rigid plane ▒▒▒
//! ```
//! Figures come from an independent code, unless a test says otherwise.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Gap, Made, Obstacle, RigidLine, Vector, block, isotropic, pair,
    ring, stacked,
};
use fem_core::geometry::perpendicular;
use fem_core::interface::{ContactFacet, ContactInterface, Friction};

/// Two blocks of 2 × 1 on each other, moduli 2000 above and 1000 below, with the same cells.
///
/// # Errors
/// Conditions that do not fit.
pub fn two_blocks(
    cells: [usize; 2],
    top: &BoundaryConditions,
    bottom: &BoundaryConditions,
) -> Made<ContactProblem> {
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], cells)?, isotropic(2000.0, 0.3)?, top)?;
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], cells)?, isotropic(1000.0, 0.3)?, bottom)?;
    stacked([upper, lower])
}

/// The canonical case: the blocks of the paper, 2 × 1 each, the top moved by (0.004, −0.02), an upward traction of 30 on the right side of
/// the upper one.
///
/// # Errors
/// None.
pub fn blocks(cells: [usize; 2], friction: Friction) -> Made<ContactProblem> {
    let top = BoundaryConditions::new()
        .displace("top", Some(0.004.into()), Some((-0.02).into()))
        .traction("right", [0.0.into(), 30.0.into()]);
    Ok(two_blocks(cells, &top, &BoundaryConditions::new().fix("bottom"))?.with_friction(0, friction)?)
}

/// The slip of [`patch`].
pub const PATCH_SLIP: f64 = 0.004;
/// The pressure and the friction of it.
pub const PATCH_TRACTION: [f64; 2] = [10.0, 3.0];
/// Its energies.
pub const PATCH: [f64; 2] = [0.0976857143, 0.1953714286];

/// Blocks in a constant state of stress: pressure 10, friction 3, slip 0.004 everywhere.
///
/// # Errors
/// None.
pub fn patch(friction: Friction) -> Made<ContactProblem> {
    let [p, s] = PATCH_TRACTION;
    let sideways = -0.3 / 0.7 * p;
    // Lateral strain is zero: σ_xx = ν/(1−ν) σ_yy.
    let confined = |young: f64| young * 0.7 / (1.3 * 0.4);
    let shear = |young: f64| young / 2.6;
    let along = s / shear(2000.0) + s / shear(1000.0) + PATCH_SLIP;
    let down = -p / confined(2000.0) - p / confined(1000.0);
    let sides = |conditions: BoundaryConditions| {
        conditions
            .traction("right", [sideways.into(), s.into()])
            .traction("left", [(-sideways).into(), (-s).into()])
    };
    let top = sides(BoundaryConditions::new().displace("top", Some(along.into()), Some(down.into())));
    let bottom = sides(BoundaryConditions::new().fix("bottom"));
    Ok(two_blocks([8, 4], &top, &bottom)?.with_friction(0, friction)?)
}

/// The blocks of [`patch`] for load steps: the first condition of the upper one moves its top sideways by the slip and the shear of both
/// blocks, the second one down; of the tractions of both, the first two confine and the others shear.
///
/// * `cells`: of each block.
///
/// # Errors
/// None.
pub fn sheared(cells: [usize; 2], friction: Friction) -> Made<ContactProblem> {
    let [p, s] = PATCH_TRACTION;
    let sideways = -0.3 / 0.7 * p;
    let down = -p * (1.3 * 0.4 / 0.7) * (1.0 / 2000.0 + 1.0 / 1000.0);
    let sides = |conditions: BoundaryConditions| {
        conditions
            .traction("right", [sideways.into(), 0.0.into()])
            .traction("left", [(-sideways).into(), 0.0.into()])
            .traction("right", [0.0.into(), s.into()])
            .traction("left", [0.0.into(), (-s).into()])
    };
    let top = BoundaryConditions::new().displace("top", Some((SHEARED_BY + PATCH_SLIP).into()), None);
    let top = sides(top.displace("top", None, Some(down.into())));
    let bottom = sides(BoundaryConditions::new().fix("bottom"));
    Ok(two_blocks(cells, &top, &bottom)?.with_friction(0, friction)?)
}

/// By how much a friction of 3 shears both blocks of [`patch`] together.
pub const SHEARED_BY: f64 = 3.0 * 2.6 * (1.0 / 2000.0 + 1.0 / 1000.0);

/// A block on a rigid slope under its own weight, turned so that the slope is horizontal: the weight has a part along it.
///
/// * `slope`: the tangent of its angle.
///
/// # Errors
/// None.
pub fn slope(slope: f64, cells: [usize; 2], friction: Friction) -> Made<ContactProblem> {
    let weight = BoundaryConditions::new().body_force([10.0 * slope, -10.0]);
    let body = Body::new(block([0.0, 0.0], [2.0, 1.0], cells)?, isotropic(1000.0, 0.3)?, &weight)?;
    let line = RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() };
    let plane = Obstacle::fixed(line);
    let interface = contact_geometry::against(&body, "bottom", &plane, None)?;
    let problem = ContactProblem::new(vec![body]).obstacle(0, interface, plane);
    Ok(problem.with_friction(0, friction)?)
}

/// The half of a block of 40 × 40 mm on a rigid plane: pushed by 150 MPa on its left, pressed by 50 MPa on its top, on a line of symmetry on its
/// right; MPa and mm.
///
/// # Errors
/// None.
pub fn pushed_over_plane(cells: usize, friction: Friction) -> Made<ContactProblem> {
    let pushed = BoundaryConditions::new()
        .displace("right", Some(0.0.into()), None)
        .traction("left", [150.0.into(), 0.0.into()])
        .traction("top", [0.0.into(), (-50.0).into()]);
    let body = Body::new(block([0.0, 0.0], [40.0, 40.0], [cells; 2])?, isotropic(130e3, 0.2)?, &pushed)?;
    let line = RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() };
    let plane = Obstacle::fixed(line);
    let interface = contact_geometry::against(&body, "bottom", &plane, None)?;
    let problem = ContactProblem::new(vec![body]).obstacle(0, interface, plane);
    Ok(problem.with_friction(0, friction)?)
}

/// Three blocks on top of each other, 2 × 1 each; the middle one floats and is pushed to the right by a force; the limit of both pairs is
/// `s`, so that they resist a force of `4 s`.
///
/// # Errors
/// None.
pub fn pushed_middle(push: f64, cells: [usize; 2], friction: &Friction) -> Made<ContactProblem> {
    let middle = BoundaryConditions::new().traction("left", [push.into(), 0.0.into()]);
    let top = BoundaryConditions::new().displace("top", Some(0.0.into()), Some((-0.02).into()));
    let problem = crate::assemblies::stack(&[1000.0, 1500.0, 2000.0], cells, &middle, &top)?;
    Ok(problem.with_friction(0, friction.clone())?.with_friction(1, friction.clone())?)
}

/// Quarters of two rings: the inner one is turned and pushed against the outer one, so that it slips along a bent line.
///
/// * `turn`: the displacement of the inner side along x; `cells`: around and across.
///
/// # Errors
/// None.
pub fn rings(turn: f64, cells: [usize; 2], friction: Friction) -> Made<ContactProblem> {
    let moved = BoundaryConditions::new().displace("inner", Some(turn.into()), Some(0.004.into()));
    let quarter = |radii: [f64; 2]| ring([0.0, 0.0], radii, [20.0, 110.0], cells);
    let inside = Body::new(quarter([1.0, 1.5])?, isotropic(2000.0, 0.3)?, &moved)?;
    let outside =
        Body::new(quarter([1.5, 2.0])?, isotropic(1000.0, 0.3)?, &BoundaryConditions::new().fix("outer"))?;
    Ok(pair([inside, outside], ["outer", "inner"], &Gap::Given(0.0.into()))?.with_friction(0, friction)?)
}

/// Returns the friction along the tangents at the ends of an edge, over their lengths, Pa.
///
/// * `traction`: at its ends, Pa.
pub fn along_edge(line: &ContactInterface, edge: &ContactFacet, traction: &[Vector; 2]) -> [f64; 2] {
    [0, 1].map(|end: usize| {
        let tangent = perpendicular(line.corner_pair(edge, end).normal);
        traction[end].dot(&tangent) / tangent.dot(&tangent)
    })
}

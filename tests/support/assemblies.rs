//! Assemblies of blocks: stacks, and cycles of three and four bodies, some of which only contact holds.
//!
//! ```text
//!      top          ┌───┬───┐                ┌───────┐
//!   ┌───────┐     ▒ │ D │ C │                │   C   │
//!   │  ...  │     ▒ ├───┼───┤              ┌─┴─┐───┌─┴─┐
//!   ├───────┤       │ A │ B │              │ A │   │ B │   (A and B touch)
//!   └───────┘       └───┴───┘              └───┘   └───┘
//!    clamped         clamped                  clamped
//! ```
//! Plane strain, ν = 0.3, cells cut from lower left to upper right, no gaps. The energies `a(u,u)` of each body and the contact
//! forces come from an independent code.

use crate::model::{
    Body, BoundaryConditions, ContactInterface, ContactProblem, Gap, Made, NodeId, Obstacle, RigidLine,
    ScalarData, TriMesh, Vector, block, isotropic,
};

fn touching(upper: &Body, lower: &Body, surfaces: [&str; 2]) -> Made<ContactInterface> {
    Ok(contact_geometry::pair(upper, lower, surfaces, &Gap::Given(0.0.into()))?)
}

/// Energies of the stack of three blocks.
pub const STACK: [f64; 3] = [0.151396775117, 0.117486400467, 0.646165093628];
/// Contact force of both pairs of it.
pub const STACK_FORCE: f64 = 18.1350164279;

/// The loads of the top block: pressed down by 0.02, held sideways on its left, pulled up on its right.
pub fn pressed() -> BoundaryConditions {
    BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("top", None, Some((-0.02).into()))
        .traction("right", [0.0.into(), 30.0.into()])
}

/// Blocks of 2 × 1 on top of each other, the lowest clamped, the others above it held by contact and by the conditions of the
/// top. Pairs: each block with the one below it, from below.
///
/// * `young`: the modulus of each block, from below; `cells`: of each block.
///
/// # Errors
/// Conditions that do not fit.
pub fn stack(
    young: &[f64],
    cells: [usize; 2],
    middle: &BoundaryConditions,
    top: &BoundaryConditions,
) -> Made<ContactProblem> {
    let clamped = BoundaryConditions::new().fix("bottom");
    let last = young.len() - 1;
    let mut bodies = Vec::new();
    for (k, young) in young.iter().enumerate() {
        let conditions = if k == 0 {
            &clamped
        } else if k == last {
            top
        } else {
            middle
        };
        bodies.push(Body::new(
            block([0.0, k as f64], [2.0, 1.0], cells)?,
            isotropic(*young, 0.3)?,
            conditions,
        )?);
    }
    let mut problem = ContactProblem::new(bodies);
    for k in 1..=last {
        let interface = touching(&problem.bodies[k], &problem.bodies[k - 1], ["bottom", "top"])?;
        problem = problem.contact([k, k - 1], interface);
    }
    Ok(problem)
}

/// The stack of `count` blocks that the counts of iterations are known for: moduli 1000, 1500 for each floating one, 2000.
///
/// # Errors
/// None.
pub fn tower(count: usize, cells: [usize; 2]) -> Made<ContactProblem> {
    let mut young = vec![1500.0; count];
    (young[0], young[count - 1]) = (1000.0, 2000.0);
    stack(&young, cells, &BoundaryConditions::new(), &pressed())
}

/// A block with further names for parts of its sides: name, side, and the range of x or y that the middles of its edges are in.
fn named(
    origin: [f64; 2],
    size: [f64; 2],
    cells: [usize; 2],
    parts: &[(&str, &str, [f64; 2])],
) -> Made<TriMesh> {
    let mesh = block(origin, size, cells)?;
    let ends = |side: &str| -> Vec<[NodeId; 2]> {
        let edges = mesh.group(side).unwrap_or_default();
        edges.iter().map(|edge| mesh.topology().facets()[*edge]).collect()
    };
    let mut groups: Vec<(String, Vec<[NodeId; 2]>)> =
        ["bottom", "right", "top", "left"].map(|side| (side.to_string(), ends(side))).into();
    for (name, side, [low, high]) in parts {
        let along = usize::from(matches!(*side, "left" | "right"));
        let inside = |[a, b]: &[NodeId; 2]| {
            let middle = 0.5 * (mesh.points()[*a][along] + mesh.points()[*b][along]);
            *low < middle && middle < *high
        };
        groups.push((name.to_string(), ends(side).into_iter().filter(inside).collect()));
    }
    Ok(TriMesh::new(mesh.points().to_vec(), mesh.cells().to_vec(), groups)?)
}

/// Energies of the cycle of three.
pub const THREE: [f64; 3] = [0.162833019380, 0.271063608331, 0.104606304765];
/// Contact forces of its pairs.
pub const THREE_FORCES: [f64; 3] = [6.9725698587, 3.6175880005, 19.5824119995];

/// Three bodies that touch each other: A and B side by side, C on both. Pairs: A-B, C-A, C-B.
///
/// * `shared`: whether the pairs share the nodes at (1, 1), as in the problem whose figures are known; otherwise they end one
///   edge before.
///
/// # Errors
/// None.
pub fn three(shared: bool) -> Made<ContactProblem> {
    let (left, right) = if shared { ([0.0, 1.0], [1.0, 2.0]) } else { ([0.0, 0.9], [1.1, 2.0]) };
    let up = if shared { [0.0, 1.0] } else { [0.0, 0.9] };
    let clamped = BoundaryConditions::new().fix("bottom");
    let pushed = clamped.clone().traction("left", [15.0.into(), 0.0.into()]);
    let load = |x: Vector| -4.0 - 16.0 * ((x[0] - 1.0) / 0.1).clamp(0.0, 1.0);
    let heavy = BoundaryConditions::new().traction("top", [0.0.into(), ScalarData::function(load)]);
    let a = named([0.0, 0.0], [1.0, 1.0], [10, 10], &[("side", "right", up), ("above", "top", left)])?;
    let b = named([1.0, 0.0], [1.0, 1.0], [10, 10], &[("side", "left", up), ("above", "top", right)])?;
    let c = named([0.0, 1.0], [2.0, 0.6], [20, 6], &[("on A", "bottom", left), ("on B", "bottom", right)])?;
    let a = Body::new(a, isotropic(1000.0, 0.3)?, &pushed)?;
    let b = Body::new(b, isotropic(1500.0, 0.3)?, &clamped)?;
    let c = Body::new(c, isotropic(2000.0, 0.3)?, &heavy)?;
    let pairs = [
        ([0, 1], touching(&a, &b, ["side", "side"])?),
        ([2, 0], touching(&c, &a, ["on A", "above"])?),
        ([2, 1], touching(&c, &b, ["on B", "above"])?),
    ];
    let problem = ContactProblem::new(vec![a, b, c]);
    Ok(pairs.into_iter().fold(problem, |problem, (bodies, pair)| problem.contact(bodies, pair)))
}

/// Energies of the cycle of four.
pub const FOUR: [f64; 4] = [0.126904475649, 0.923608576017, 0.613004034270, 0.223425103263];
/// Contact forces of its pairs.
pub const FOUR_FORCES: [f64; 5] = [3.2916794160, 40.0, 14.0, 12.0, 14.0];

/// Four blocks around a point: A and B clamped, C on B, D on A, against a rigid wall on its left. Pairs: A-B, C-B, D-C, D-A, D-wall.
///
/// # Errors
/// None.
pub fn four() -> Made<ContactProblem> {
    let body = |origin: [f64; 2], young: f64, conditions: BoundaryConditions| -> Made<Body> {
        Ok(Body::new(block(origin, [1.0, 1.0], [10, 10])?, isotropic(young, 0.3)?, &conditions)?)
    };
    let loads = |side: &str, x: ScalarData, y: ScalarData| BoundaryConditions::new().traction(side, [x, y]);
    let zero = || ScalarData::from(0.0);
    let a = body([0.0, 0.0], 1000.0, BoundaryConditions::new().fix("bottom"))?;
    let b = body([1.0, 0.0], 1500.0, BoundaryConditions::new().fix("bottom"))?;
    let c = loads("right", ScalarData::function(|x| -20.0 * (x[1] - 0.8)), zero())
        .traction("top", [zero(), ScalarData::function(|x| -20.0 * (x[0] + 0.5))]);
    let c = body([1.0, 1.0], 2000.0, c)?;
    let d = body([0.0, 1.0], 800.0, loads("top", zero(), (-12.0).into()))?;
    let wall = RigidLine::Plane { point: Vector::zeros(), normal: Vector::x() };
    let against = contact_geometry::against(&d, "left", &Obstacle::fixed(wall), None)?;
    let pairs = [
        ([0, 1], touching(&a, &b, ["right", "left"])?),
        ([2, 1], touching(&c, &b, ["bottom", "top"])?),
        ([3, 2], touching(&d, &c, ["right", "left"])?),
        ([3, 0], touching(&d, &a, ["bottom", "top"])?),
    ];
    let problem = ContactProblem::new(vec![a, b, c, d]);
    let problem = pairs.into_iter().fold(problem, |problem, (bodies, pair)| problem.contact(bodies, pair));
    Ok(problem.obstacle(3, against, Obstacle::fixed(wall)))
}

/// The stack of three blocks, each 2 × 1, under a rigid stamp that a force of 20 and a moment of 3 press on the top, which is held
/// sideways. The stamp keeps its place sideways.
///
/// # Errors
/// None.
pub fn stamped() -> Made<ContactProblem> {
    let sideways = BoundaryConditions::new().displace("left", Some(0.0.into()), None);
    let problem = stack(&[1000.0, 1500.0, 2000.0], [18, 9], &BoundaryConditions::new(), &sideways)?;
    let line = RigidLine::Plane { point: Vector::new(1.0, 3.0), normal: -Vector::y() };
    let stamp = Obstacle::fixed(line).stamp([Some(0.0), None, None], ([0.0, -20.0], 3.0), [1.0, 3.0]);
    let interface = contact_geometry::against(&problem.bodies[2], "top", &stamp, None)?;
    Ok(problem.obstacle(2, interface, stamp))
}

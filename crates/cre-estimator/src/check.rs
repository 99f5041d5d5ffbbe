//! Checks of admissibility, as numbers: the basis of a certificate.

use crate::admissible::{AdmissibleBody, AdmissibleContact, AdmissiblePair};
use crate::cells::{Cells, Gathered, Residuals, load_tensor, set_tensor};
use crate::cre::CellMeasure;
use crate::equilibrated::EquilibratedStress;
use crate::johnson_mercier::CellStress;
use crate::lanes::{MOST_LANES, Row};
use crate::lift;
use crate::openings;
use crate::round_off::force_noise;
pub use crate::size::SIGN_TOLERANCE;
use crate::size::{larger, largest_displacement};
use fem_core::body::{Body, EdgeReaction, NodeConstraint, RigidMotion, RigidSide};
use fem_core::double_double::DoubleDouble;
use fem_core::each_body;
use fem_core::geometry::{Vector, perpendicular};
use fem_core::interface::{ContactInterface, ContactPair, ContactProblem};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::EdgeId;
use fem_core::parallel::each_task;
use fem_core::tensor::SymTensor2;
use pulp::Simd;
use std::borrow::Cow;
use std::ops::Range;

/// Force residuals up to this are round-off; larger ones invalidate a certificate.
pub const FORCE_TOLERANCE: f64 = 1e-10;
/// A body that turns by more, in radians, is beyond small displacements.
pub const LARGEST_ROTATION: f64 = 0.1;
/// Directions of a roller that differ by less are the same.
const SAME_DIRECTION: f64 = 1e-9;

/// Residuals of the conditions of admissibility.
///
/// The force residuals are maxima over their items, divided by the largest edge force, load or pressure
/// force of the same body, and at least by a force at which rounding of its displacements alone would just pass: the
/// bound contains an allowance for that. `penetration` is relative to the largest displacement of the interface,
/// `pressure_sign` to the largest pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Admissibility {
    /// `|div τ + b|` times area in every part, and the jump of traction inside the triangles.
    pub equilibrium: f64,
    /// Jump of the traction between triangles.
    pub traction_jump: f64,
    /// Difference from the given tractions on the boundary, including the pressure on the contact edges.
    pub boundary_traction: f64,
    /// Largest negative opening.
    pub penetration: f64,
    /// Largest negative pressure.
    pub pressure_sign: f64,
    /// The part of the friction beyond its limit, relative to the largest limit, and the difference of the given slip from that of the fields,
    /// relative to the largest displacement of the two bodies.
    pub friction_cone: f64,
    /// Sine of the largest angle between an edge on a roller and the direction in which its nodes are fixed: on curved
    /// sides the displacements violate the roller between the nodes, so `e_CRE` is not a bound.
    pub supports: f64,
    /// Largest difference from an imposed displacement, relative to the largest displacement of the body.
    pub imposed_displacement: f64,
    /// Largest resultant of the pressure and the loads on a floating body, relative to the forces on it.
    pub rigid_balance: f64,
    /// The largest mean rotation of a floating body, radians.
    pub rotation: f64,
}

impl Admissibility {
    /// Lists every residual with its name and the largest value that is round-off.
    pub fn checks(&self) -> [(&'static str, f64, f64); 10] {
        [
            ("supports", self.supports, SAME_DIRECTION),
            ("equilibrium", self.equilibrium, FORCE_TOLERANCE),
            ("traction_jump", self.traction_jump, FORCE_TOLERANCE),
            ("boundary_traction", self.boundary_traction, FORCE_TOLERANCE),
            ("penetration", self.penetration, SIGN_TOLERANCE),
            ("pressure_sign", self.pressure_sign, SIGN_TOLERANCE),
            ("friction_cone", self.friction_cone, SIGN_TOLERANCE),
            ("imposed_displacement", self.imposed_displacement, SIGN_TOLERANCE),
            ("rigid_balance", self.rigid_balance, FORCE_TOLERANCE),
            ("rotation", self.rotation, LARGEST_ROTATION),
        ]
    }

    /// Lists name and value of the residuals that are larger than round-off, or NaN.
    pub fn failed(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let fails = |(_, found, allowed): &(&str, f64, f64)| !(found <= allowed);
        self.checks().into_iter().filter(fails).map(|(name, found, _)| (name, found))
    }

    /// Takes the larger one of every two residuals.
    pub(crate) fn worst(self, other: Self) -> Self {
        Self {
            equilibrium: larger(self.equilibrium, other.equilibrium),
            traction_jump: larger(self.traction_jump, other.traction_jump),
            boundary_traction: larger(self.boundary_traction, other.boundary_traction),
            penetration: larger(self.penetration, other.penetration),
            pressure_sign: larger(self.pressure_sign, other.pressure_sign),
            friction_cone: larger(self.friction_cone, other.friction_cone),
            supports: larger(self.supports, other.supports),
            imposed_displacement: larger(self.imposed_displacement, other.imposed_displacement),
            rigid_balance: larger(self.rigid_balance, other.rigid_balance),
            rotation: larger(self.rotation, other.rotation),
        }
    }

    /// Tells whether all conditions hold to round-off, so that `e_CRE` is a bound.
    pub fn is_valid(&self) -> bool {
        self.failed().next().is_none()
    }
}

/// Squares of the force residuals of one body and of the scale they are compared with, N²/m²; one square root at the
/// end.
#[derive(Clone, Copy, Debug, Default)]
struct Forces {
    equilibrium: f64,
    jump: f64,
    boundary: f64,
    scale: f64,
}

impl Forces {
    fn max(self, other: Self) -> Self {
        Self {
            equilibrium: larger(self.equilibrium, other.equilibrium),
            jump: larger(self.jump, other.jump),
            boundary: larger(self.boundary, other.boundary),
            scale: larger(self.scale, other.scale),
        }
    }

    /// Relates the residuals to the scale, or to one at which `noise` alone just passes.
    fn residuals(self, noise: f64) -> Admissibility {
        let scale = larger(self.scale.sqrt(), noise / FORCE_TOLERANCE);
        Admissibility {
            equilibrium: relative(self.equilibrium.sqrt(), scale),
            traction_jump: relative(self.jump.sqrt(), scale),
            boundary_traction: relative(self.boundary.sqrt(), scale),
            ..Admissibility::default()
        }
    }
}

/// Tractions times length on the edges of a triangle, from its stress: edge `k` at corners `k`, `k+1`.
type CellForces = [[Vector; 2]; 3];

fn square(a: Vector) -> f64 {
    a.dot(&a)
}

/// Length of a vector by its square: the guard of `hypot` against overflow costs more than the whole check.
fn norm(a: Vector) -> f64 {
    square(a).sqrt()
}

/// Checks an admissible pair.
pub fn check(problem: &ContactProblem, pair: &AdmissiblePair) -> Admissibility {
    checked(problem, pair, false).0
}

/// [`check`], with what the bound needs of every triangle of each body: the distances of [`cell_distances`].
///
/// [`cell_distances`]: crate::cre::cell_distances
pub(crate) fn check_and_measure(
    problem: &ContactProblem,
    pair: &AdmissiblePair,
) -> (Admissibility, Vec<Vec<CellMeasure>>) {
    checked(problem, pair, true)
}

fn checked(
    problem: &ContactProblem,
    pair: &AdmissiblePair,
    measured: bool,
) -> (Admissibility, Vec<Vec<CellMeasure>>) {
    let of_body = |b: usize| {
        let (body, fields) = (&problem.bodies[b], &pair.bodies[b]);
        let against = [&fields.stress, &fields.equilibrated.finite_element];
        let against = against.map(|stress| measured.then_some(stress.as_slice()));
        // A lightly loaded body is compared with its own scale.
        check_stress_and_measure(body, &fields.displacement, &fields.equilibrated, against)
    };
    let (by_body, cells): (Vec<_>, Vec<_>) = each_body(problem.bodies.len(), of_body).into_iter().unzip();
    let mut displacement: Vec<Cow<'_, [Vector]>> = pair.displacements().into_iter().map(Cow::from).collect();
    let moved = lift::sums(problem, pair.contacts.iter().map(|contact| &contact.lift));
    for (u, l) in displacement.iter_mut().zip(&moved) {
        if let Some(l) = l {
            u.to_mut().iter_mut().zip(l).for_each(|(u, l)| *u += l);
        }
    }
    let mut found = by_body.into_iter().fold(Admissibility::default(), Admissibility::worst);
    found.rigid_balance = pair.rigid_balance;
    for (body, fields) in problem.bodies.iter().zip(&pair.bodies) {
        found.rigid_balance = larger(found.rigid_balance, rigid_sides(body, fields));
    }
    for (body, fields) in problem.bodies.iter().zip(&pair.bodies) {
        found.rotation = larger(found.rotation, rotation(body, &fields.displacement));
    }
    for (body, u) in problem.bodies.iter().zip(&displacement) {
        found.supports = larger(found.supports, body.roller_turn());
        found.imposed_displacement = larger(found.imposed_displacement, displaced_support(body, u));
    }
    for (of, contact) in problem.contacts.iter().zip(&pair.contacts) {
        let displacement = of.bodies.map(|b| &*displacement[b]);
        found.penetration = larger(found.penetration, penetration(&of.interface, contact, displacement));
        let edge_pressure = contact.edge_pressure.as_flattened();
        let largest = edge_pressure.iter().fold(0.0, |m, p| larger(m, p.abs()));
        let negative = edge_pressure.iter().fold(0.0, |m, p| larger(m, -p));
        found.pressure_sign = larger(found.pressure_sign, relative(negative, largest));
        found.friction_cone = larger(found.friction_cone, friction_cone(of, contact, displacement));
    }
    (found, cells)
}

/// Computes the largest penetration along a contact line, and the largest difference between the openings of the bound
/// and those of the fields themselves, relative to the largest displacement of the two bodies.
///
/// * `displacement`: of the first and the second body of the pair, with the lift, m.
fn penetration(
    interface: &ContactInterface,
    contact: &AdmissibleContact,
    displacement: [&[Vector]; 2],
) -> f64 {
    let mut penetration = 0.0;
    for (p, stated) in interface.pairs().iter().zip(&contact.opening) {
        let opening = openings::of_fields(p, displacement);
        penetration = larger(penetration, larger(-opening, -stated));
        penetration = larger(penetration, (opening - stated).abs());
    }
    // Between the pairs, where the normal changes.
    let middle = lift::middle_openings(interface, displacement);
    for ((edge, opening), stated) in interface.edges().iter().zip(middle).zip(&contact.middle_opening) {
        if edge.bent {
            penetration = larger(penetration, larger(-opening, -stated));
            penetration = larger(penetration, (opening - stated).abs());
        }
    }
    relative(penetration, openings::size(interface, displacement))
}

/// Computes by how much friction is beyond its limit, and the given slip differs from that of the fields, both relative.
///
/// * `displacement`: of the first and the second body of the pair, m.
fn friction_cone(pair: &ContactPair, contact: &AdmissibleContact, displacement: [&[Vector]; 2]) -> f64 {
    let edges = &contact.edge_friction;
    let friction = || edges.friction.as_flattened().iter().zip(edges.limit.as_flattened());
    let largest = friction().fold(0.0, |m, (q, s)| larger(m, larger(q.abs(), *s)));
    let beyond = friction().fold(0.0, |m, (q, s)| larger(m, q.abs() - s));
    let negative = friction().fold(0.0, |m, (_, s)| larger(m, -s));
    let trace = larger(largest_displacement(displacement[0]), largest_displacement(displacement[1]));
    let mut difference = 0.0;
    for (edge, slip) in pair.interface.edges().iter().zip(&edges.slip) {
        for end in edge.free_ends() {
            difference = larger(difference, (slip[2 * end] - contact.slip[edge.pairs[end] as usize]).abs());
        }
    }
    larger(relative(larger(beyond, negative), largest), relative(difference, trace))
}

/// Computes the mean rotation of a body that its supports leave free to move, radians; 0 for a held one.
fn rotation(body: &Body, displacement: &[Vector]) -> f64 {
    if body.free_motion().is_none() {
        return 0.0;
    }
    let mesh = body.mesh();
    let (mut turned, mut area) = (0.0, 0.0);
    for (t, nodes) in mesh.triangles().iter().enumerate() {
        // ∮ u·ds = 2 ω A, with u linear along the edges.
        let (corners, u) = (mesh.corners(t), nodes.map(|n| displacement[n]));
        let along = |k: usize| {
            let next = (k + 1) % 3;
            0.5 * (u[k] + u[next]).dot(&(corners[next] - corners[k]))
        };
        turned += 0.5 * (along(0) + along(1) + along(2));
        area += mesh.area(t);
    }
    (turned / area).abs()
}

/// Compares the tractions on the rigid sides of a body with the loads of these sides: the largest difference of the work
/// along a free motion, over the sum of the sizes of all its terms.
fn rigid_sides(body: &Body, fields: &AdmissibleBody) -> f64 {
    if body.rigid_sides().is_empty() {
        return 0.0;
    }
    let stress = &fields.equilibrated;
    let noise = force_noise(body, &fields.displacement) / FORCE_TOLERANCE;
    let mesh = body.mesh();
    let topology = mesh.topology();
    let mut largest = 0.0;
    for side in body.rigid_sides() {
        for motion in &side.motions {
            let (mut work, mut size) = (0.0, noise * motion_size(motion, side, mesh));
            let mut add = |force: Vector, moved: Vector| {
                work += force.dot(&moved);
                size += norm(force) * norm(moved);
            };
            for (&node, force) in side.nodes.iter().zip(&side.forces) {
                add(-*force, motion.at(mesh.points()[node]));
            }
            for &edge in &side.edges {
                let t = topology.edge_triangles()[edge][0] as usize;
                let k = topology.edge_in(t, edge);
                let forces = edge_tractions(body, &stress.cell(body, t), t)[k];
                let corners = mesh.corners(t);
                let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|x| motion.at(x));
                // ∫ F·u of linear functions, from the tractions times length.
                add(1.0 / 6.0 * (2.0 * forces[0] + forces[1]), a);
                add(1.0 / 6.0 * (forces[0] + 2.0 * forces[1]), b);
            }
            largest = larger(largest, relative(work.abs(), size));
        }
    }
    largest
}

/// Computes the largest displacement of a rigid side's nodes in a motion.
fn motion_size(motion: &RigidMotion, side: &RigidSide, mesh: &TriMesh) -> f64 {
    side.nodes.iter().map(|n| norm(motion.at(mesh.points()[*n]))).fold(0.0, larger)
}

/// Compares a displacement with the values that the supports impose: the largest difference over the largest
/// displacement.
fn displaced_support(body: &Body, displacement: &[Vector]) -> f64 {
    let difference = |(u, constraint): (&Vector, &NodeConstraint)| match *constraint {
        NodeConstraint::Free | NodeConstraint::Rigid { .. } => 0.0,
        NodeConstraint::Along { direction, value } => (u.dot(&direction) - value).abs(),
        NodeConstraint::Fixed { value } => norm(*u - value),
    };
    let all = displacement.iter().zip(body.node_constraints()).map(difference);
    let sides = body.rigid_sides().iter().map(|side| side.violation(body.mesh().points(), displacement));
    relative(all.chain(sides).fold(0.0, larger), largest_displacement(displacement))
}

/// Checks the equilibrium of one body's stress with its loads and given tractions; penetration and pressure
/// are zero.
pub fn check_stress(body: &Body, stress: &EquilibratedStress) -> Admissibility {
    forces(body, stress, [None; 2]).0.residuals(0.0)
}

/// [`check_stress`], with the scale of a displaced body, and what the bound needs of every triangle.
///
/// * `against`: the stresses to which the distances are measured, Pa, one per triangle.
pub(crate) fn check_stress_and_measure(
    body: &Body,
    displacement: &[Vector],
    stress: &EquilibratedStress,
    against: [Option<&[SymTensor2]>; 2],
) -> (Admissibility, Vec<CellMeasure>) {
    let (found, cells) = forces(body, stress, against);
    (found.residuals(force_noise(body, displacement)), cells)
}

fn relative(x: f64, scale: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x / scale }
}

/// Triangles per block: most edges have both sides within a block, and its edge forces stay in the cache.
const BLOCK: usize = 8192;

/// Finds the force residuals of a body, block by block, and measures its triangles if `against` has a stress.
fn forces(
    body: &Body,
    stress: &EquilibratedStress,
    against: [Option<&[SymTensor2]>; 2],
) -> (Forces, Vec<CellMeasure>) {
    let triangles = body.mesh().triangles().len();
    for given in against.into_iter().flatten() {
        assert!(given.len() == triangles, "a stress of {} triangles on {triangles}", given.len());
    }
    let blocks: Vec<(Forces, Vec<CellMeasure>)> = each_task(triangles.div_ceil(BLOCK), |k| {
        let triangles = k * BLOCK..triangles.min((k + 1) * BLOCK);
        pulp::Arch::new().dispatch(BlockForces { body, stress, triangles, against })
    });
    let worst = blocks.iter().fold(Forces::default(), |worst, (found, _)| worst.max(*found));
    (worst, blocks.into_iter().flat_map(|(_, cells)| cells).collect())
}

/// The force residuals of a block.
struct BlockForces<'a> {
    body: &'a Body,
    stress: &'a EquilibratedStress,
    triangles: Range<usize>,
    against: [Option<&'a [SymTensor2]>; 2],
}

/// The triangles that are side by side, and the stresses to which their distances are measured.
#[derive(Default)]
struct Gathering {
    cells: Gathered,
    against: [[Row; 3]; 2],
}

impl pulp::WithSimd for BlockForces<'_> {
    type Output = (Forces, Vec<CellMeasure>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Forces, Vec<CellMeasure>) {
        let Self { body, stress, triangles, against } = self;
        let load = body.body_force();
        let mut worst = Forces::default();
        let mut cells: Vec<CellForces> = Vec::with_capacity(triangles.len());
        let measured = against.iter().any(Option::is_some);
        let mut measures = Vec::with_capacity(if measured { triangles.len() } else { 0 });
        let mut gathering = Gathering::default();
        for first in triangles.clone().step_by(S::F64_LANES) {
            let group = first..triangles.end.min(first + S::F64_LANES);
            // Lanes without a triangle keep the one that they had before, whose results are not read.
            for (lane, t) in group.clone().enumerate() {
                gathering.cells.set(lane, body, stress, t);
                for (rows, given) in gathering.against.iter_mut().zip(against) {
                    if let Some(given) = given {
                        set_tensor(rows, lane, given[t]);
                    }
                }
            }
            let found = Cells::new(simd, &gathering.cells, load);
            let Residuals { equilibrium, forces } = found.residuals(load);
            let mut rows = [[0.0; MOST_LANES]; 1 + 12];
            equilibrium.store(&mut rows[0]);
            for (pair, force) in rows[1..].chunks_exact_mut(2).zip(forces.as_flattened()) {
                force[0].store(&mut pair[0]);
                force[1].store(&mut pair[1]);
            }
            for (lane, t) in group.clone().enumerate() {
                let area = body.mesh().area(t);
                worst.equilibrium = larger(worst.equilibrium, rows[0][lane]);
                worst.scale = larger(worst.scale, square(area * load));
                let mut forces = CellForces::default();
                for (force, pair) in forces.as_flattened_mut().iter_mut().zip(rows[1..].chunks_exact(2)) {
                    *force = Vector::new(pair[0][lane], pair[1][lane]);
                }
                cells.push(forces);
            }
            if measured {
                measure(simd, &found, (&gathering.against, against), group.len(), &mut measures);
            }
        }
        let block = Block { body, stress, first: triangles.start, cells };
        for t in triangles {
            for k in 0..3 {
                worst = worst.max(block.edge(t, k));
            }
        }
        (worst, measures)
    }
}

/// Measures the first `count` of some triangles.
#[inline(always)]
fn measure<S: Simd>(
    simd: S,
    cells: &Cells<S>,
    (rows, against): (&[[Row; 3]; 2], [Option<&[SymTensor2]>; 2]),
    count: usize,
    measures: &mut Vec<CellMeasure>,
) {
    let mut distances = [[0.0; MOST_LANES]; 2];
    for k in 0..2 {
        if against[k].is_some() {
            cells.distance_squared(load_tensor(simd, &rows[k])).store(&mut distances[k]);
        }
    }
    let mut sums = [[[0.0; MOST_LANES]; 3]; 2];
    for (rows, parts) in sums.as_flattened_mut().iter_mut().zip(cells.sum().as_flattened()) {
        parts.store(rows);
    }
    for lane in 0..count {
        let sum = |c: usize| DoubleDouble { high: sums[0][c][lane], low: sums[1][c][lane] };
        measures.push(CellMeasure {
            distances: [distances[0][lane], distances[1][lane]],
            sum: [sum(0), sum(1), sum(2)],
        });
    }
}

/// Computes the tractions times length on the edges of a triangle.
fn edge_tractions(body: &Body, tau: &CellStress, t: usize) -> CellForces {
    let corners = body.mesh().corners(t);
    [0, 1, 2].map(|k| {
        let along = corners[(k + 1) % 3] - corners[k];
        let normal = Vector::new(along[1], -along[0]);
        [tau[k][0].apply(normal), tau[k][1].apply(normal)]
    })
}

/// Consecutive triangles with the forces on their edges.
struct Block<'a> {
    body: &'a Body,
    stress: &'a EquilibratedStress,
    first: usize,
    cells: Vec<CellForces>,
}

impl Block<'_> {
    /// Compares the forces on edge `k` of triangle `t` from both sides, or with the given ones. Each edge is checked
    /// once, by its first triangle.
    fn edge(&self, t: usize, k: usize) -> Forces {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let edge = topology.triangle_edges()[t][k];
        let [owner, other] = topology.edge_triangles()[edge].map(|t| t as usize);
        let mut worst = Forces::default();
        if owner != t {
            return worst;
        }
        let own = self.edge_forces(t, edge);
        worst.scale = larger(square(own[0]), square(own[1]));
        if !topology.is_boundary(edge) {
            for (a, b) in own.into_iter().zip(self.edge_forces(other, edge)) {
                worst.jump = larger(worst.jump, square(a + b));
            }
            return worst;
        }
        let condition = &self.stress.conditions[topology.boundary_place(edge)];
        let length = mesh.edge_length(edge);
        for (force, traction) in own.into_iter().zip(condition.traction) {
            let given = length * traction;
            worst.scale = larger(worst.scale, square(given));
            let difference = force - given;
            let residual = match condition.reaction {
                EdgeReaction::None => square(difference),
                EdgeReaction::Along(d) => difference.dot(&perpendicular(d)).powi(2),
                EdgeReaction::Both => 0.0,
            };
            worst.boundary = larger(worst.boundary, residual);
        }
        worst
    }

    /// Tractions times length at the ends of an edge, in its own order, from triangle `t`.
    fn edge_forces(&self, t: usize, edge: EdgeId) -> [Vector; 2] {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let k = topology.edge_in(t, edge);
        let forces = match self.cells.get(t.wrapping_sub(self.first)) {
            Some(forces) => forces[k],
            None => edge_tractions(self.body, &self.stress.cell(self.body, t), t)[k],
        };
        let first = topology.edges()[edge][0] == mesh.triangles()[t][k];
        if first { forces } else { [forces[1], forces[0]] }
    }
}

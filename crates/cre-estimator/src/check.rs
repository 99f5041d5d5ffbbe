//! Checks of admissibility, as numbers: the basis of a certificate.

use crate::admissible::{AdmissibleBody, AdmissibleContact, AdmissiblePair};
use crate::equilibrated::{EquilibratedStress, cut_resultant};
use crate::lift;
use crate::measures::{Accuracy, Against, CellMeasures, Forces};
use crate::openings;
use crate::recovery::Recovery;
use crate::round_off::Noise;
pub use crate::size::SIGN_TOLERANCE;
use crate::size::{larger, largest_displacement, largest_of, length};
use fem_core::body::{Body, Cut, RigidMotion, RigidSide};
use fem_core::each_body;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactInterface, ContactPair, ContactProblem};
use fem_core::mesh::Mesh;
use std::borrow::Cow;

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
    /// The part of the friction beyond its limit, relative to the largest limit, and the difference of the given slip from the slip of the fields,
    /// relative to the largest displacement of the two bodies, or to the largest slip before the load step.
    pub friction_cone: f64,
    /// Sine of the largest angle between an edge on a roller and the direction in which its nodes are fixed: on curved
    /// sides the displacements violate the roller between the nodes, so `e_CRE` is not a bound.
    pub supports: f64,
    /// Largest difference from an imposed displacement, relative to the largest displacement of the body.
    pub imposed_displacement: f64,
    /// Largest resultant of the pressure and the loads on a floating body, relative to the forces on it; the same of the tractions and the load of a
    /// rigid side, and of the traction in a cut and the given force there.
    pub rigid_balance: f64,
    /// The largest mean rotation of a body that floats or is on springs, radians.
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

/// Checks an admissible pair.
pub fn check<S: Recovery>(problem: &ContactProblem<S>, pair: &AdmissiblePair<S>) -> Admissibility {
    checked(problem, pair, &Noise::of_bodies(problem), None).0
}

/// [`check`], with what the bound needs of every triangle of each body: the distances of [`cell_distances`], and the mean stress.
///
/// [`cell_distances`]: crate::cre::cell_distances
pub(crate) fn check_and_measure<S: Recovery>(
    problem: &ContactProblem<S>,
    pair: &AdmissiblePair<S>,
    noise: &[Noise],
    accuracy: Accuracy,
) -> (Admissibility, Vec<CellMeasures<S>>) {
    checked(problem, pair, noise, Some(accuracy))
}

fn checked<S: Recovery>(
    problem: &ContactProblem<S>,
    pair: &AdmissiblePair<S>,
    noise: &[Noise],
    measured: Option<Accuracy>,
) -> (Admissibility, Vec<CellMeasures<S>>) {
    let mut displacement: Vec<Cow<'_, [S::Vector]>> =
        pair.displacements().into_iter().map(Cow::from).collect();
    let moved = lift::joined(problem, pair.contacts.iter().map(|contact| &contact.lift));
    for (u, l) in displacement.iter_mut().zip(&moved) {
        if let Some(l) = l {
            u.to_mut().iter_mut().zip(l).for_each(|(u, l)| *u += *l);
        }
    }
    let of_body = |b: usize| {
        let (body, fields) = (&problem.bodies[b], &pair.bodies[b]);
        let against = [&fields.stress, &fields.equilibrated.finite_element];
        let against = against.map(|stress| Some(stress.as_slice()));
        // A lightly loaded body is compared with its own scale.
        let displaced = (fields.displacement.as_slice(), noise[b]);
        let (forces, cells) = check_stress_and_measure(
            body,
            displaced,
            &fields.equilibrated,
            measured.map(|accuracy| (against, accuracy)),
        );
        let found = Admissibility {
            rigid_balance: larger(rigid_sides(body, fields, noise[b]), cuts(body, fields, noise[b])),
            rotation: rotation(body, &fields.displacement),
            supports: body.roller_turn(),
            imposed_displacement: displaced_support(body, &displacement[b]),
            ..forces
        };
        (found, cells)
    };
    let (by_body, cells): (Vec<_>, Vec<_>) = each_body(problem.bodies.len(), of_body).into_iter().unzip();
    let mut found = by_body.into_iter().fold(Admissibility::default(), Admissibility::worst);
    found.rigid_balance = larger(found.rigid_balance, pair.rigid_balance);
    for (of, contact) in problem.contacts.iter().zip(&pair.contacts) {
        let displacement = problem.places_of(of).map(|b| &*displacement[b]);
        found.penetration = larger(found.penetration, penetration(&of.interface, contact, displacement));
        let pressure = || contact.edge_pressure.iter().flat_map(|p| p.as_ref());
        let largest = pressure().fold(0.0, |m, p| larger(m, p.abs()));
        let negative = pressure().fold(0.0, |m, p| larger(m, -p));
        found.pressure_sign = larger(found.pressure_sign, relative(negative, largest));
        found.friction_cone = larger(found.friction_cone, friction_cone(of, contact, displacement));
    }
    (found, cells)
}

/// Computes the larger of the largest penetration along a contact line and the largest difference between the openings of
/// the bound and of the fields themselves, relative to the largest displacement of the two bodies.
///
/// * `displacement`: of the first and the second body of the pair, with the lift, m.
fn penetration<S: Recovery>(
    interface: &ContactInterface<S>,
    contact: &AdmissibleContact<S>,
    displacement: [&[S::Vector]; 2],
) -> f64 {
    let mut penetration = 0.0;
    for (p, stated) in interface.pairs().iter().zip(&contact.opening) {
        let opening = openings::of_fields(p, displacement);
        penetration = larger(penetration, larger(-opening, -stated));
        penetration = larger(penetration, (opening - stated).abs());
    }
    // Between the pairs, where the normal changes.
    let middle = S::middle_openings(interface, displacement);
    let stated = lift::with_middles(interface, &contact.middle_opening);
    for ((facet, middle), (_, stated)) in lift::with_middles(interface, &middle).zip(stated) {
        if facet.bent {
            let corners = facet.openings(&contact.opening);
            penetration = larger(penetration, larger(S::depth(&corners, middle), S::depth(&corners, stated)));
            for (opening, stated) in middle.iter().zip(stated) {
                penetration = larger(penetration, (opening - stated).abs());
            }
        }
    }
    relative(penetration, openings::size(interface, displacement))
}

/// Computes by how much friction is beyond its limit, and the given slip differs from the slip of the fields, both relative.
///
/// * `displacement`: of the first and the second body of the pair, m.
fn friction_cone<S: Recovery>(
    pair: &ContactPair<S>,
    contact: &AdmissibleContact<S>,
    displacement: [&[S::Vector]; 2],
) -> f64 {
    let of = &contact.facet_friction;
    let facets = || pair.interface.facets().iter().zip(&of.traction).zip(&of.limit);
    let (mut largest, mut beyond, mut negative) = (0.0, 0.0, 0.0);
    for ((facet, traction), limit) in facets() {
        for corner in 0..S::DIM {
            let normal = length(pair.interface.corner_pair(facet, corner).normal);
            let (q, s) = (length(traction[corner]) / normal, limit[corner]);
            largest = larger(largest, larger(q, s));
            beyond = larger(beyond, q - s);
            negative = larger(negative, -s);
        }
    }
    let before =
        pair.slip_before.iter().flat_map(|before| before.jumps.iter().flat_map(|jumps| jumps.as_ref()));
    // A body at rest has the slip before with the opposite sign, and its rounding.
    let size = displacement.into_iter().map(largest_displacement).chain(before.map(|jump| length(*jump)));
    let size = size.fold(0.0, larger);
    let mut difference = 0.0;
    for (facet, jump) in pair.interface.facets().iter().zip(&of.jump) {
        for corner in facet.free_corners() {
            let k = facet.pairs[corner] as usize;
            let given = contact.slip[k..].iter().step_by(pair.interface.pairs().len());
            let own = pair.tangential_parts(k, jump[corner]);
            difference = own.zip(given).map(|(own, given)| (own - given).abs()).fold(difference, larger);
        }
    }
    larger(relative(larger(beyond, negative), largest), relative(difference, size))
}

/// Computes the mean rotation of a body that its supports leave free to move, or that is on springs, radians; 0 for another one.
fn rotation<S: Recovery>(body: &Body<S>, displacement: &[S::Vector]) -> f64 {
    if body.free_motion().is_none() && body.springs().is_empty() {
        return 0.0;
    }
    let mesh = body.mesh();
    let (mut turned, mut measure) = (S::Spin::default(), 0.0);
    for (t, nodes) in mesh.cells().iter().enumerate() {
        turned += S::twist(&mesh.corners(t), &S::corners(|k| displacement[nodes[k]]));
        measure += mesh.measure(t);
    }
    let motion = S::motion(S::Vector::ZERO, turned / measure);
    motion.as_ref().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Compares the tractions on the rigid sides of a body with the loads of these sides: the largest difference of the work
/// along a free motion, over the sum of the sizes of all its terms.
fn rigid_sides<S: Recovery>(body: &Body<S>, fields: &AdmissibleBody<S>, noise: Noise) -> f64 {
    if body.rigid_sides().is_empty() {
        return 0.0;
    }
    let stress = &fields.equilibrated;
    let noise = noise.force(&fields.displacement) / FORCE_TOLERANCE;
    let mesh = body.mesh();
    let topology = mesh.topology();
    let mut largest = 0.0;
    for side in body.rigid_sides() {
        for motion in &side.motions {
            let (mut work, mut size) = (0.0, noise * motion_size(motion, side, mesh));
            let mut add = |force: S::Vector, moved: S::Vector| {
                work += force.times(&moved);
                size += length(force) * length(moved);
            };
            for (&node, force) in side.nodes.iter().zip(&side.forces) {
                add(-*force, motion.at(mesh.points()[node]));
            }
            for &edge in &side.edges {
                let t = topology.facet_cells()[edge][0] as usize;
                let k = topology.facet_in(t, edge);
                let (forces, corners) = (S::facet_forces(body, stress, t, k), mesh.corners(t));
                for (force, corner) in forces.as_ref().iter().zip(S::facet(k).as_ref()) {
                    add(*force, motion.at(corners[*corner]));
                }
            }
            largest = larger(largest, relative(work.abs(), size));
        }
    }
    largest
}

/// Compares the resultants of the tractions in cuts along their axes with the given forces: the largest difference, over the sum of the sizes of
/// all its terms.
fn cuts<S: Recovery>(body: &Body<S>, fields: &AdmissibleBody<S>, noise: Noise) -> f64 {
    let noise = noise.force(&fields.displacement) / FORCE_TOLERANCE;
    let of_cut = |cut: &Cut<S>| {
        let force = cut.force?;
        let [resultant, size] = cut_resultant(body, cut, &fields.equilibrated.facet_moments);
        Some(relative((resultant - force).abs(), size + force.abs() + noise))
    };
    body.cuts().iter().filter_map(of_cut).fold(0.0, larger)
}

/// Computes the largest displacement of a rigid side's nodes in a motion.
fn motion_size<S: Recovery>(motion: &RigidMotion<S>, side: &RigidSide<S>, mesh: &Mesh<S>) -> f64 {
    side.nodes.iter().map(|n| length(motion.at(mesh.points()[*n]))).fold(0.0, larger)
}

/// Compares a displacement with the values that the supports impose: the largest difference over the largest
/// displacement.
fn displaced_support<S: Recovery>(body: &Body<S>, displacement: &[S::Vector]) -> f64 {
    let difference = |n: usize| {
        let constraint = &body.node_constraints()[n];
        if constraint.rigid_side.is_some() { 0.0 } else { constraint.violation(displacement[n]) }
    };
    let nodes = largest_of(displacement.len(), difference);
    let sides = body.rigid_sides().iter().map(|side| side.violation(body.mesh().points(), displacement));
    relative(sides.fold(nodes, larger), largest_displacement(displacement))
}

/// Checks the equilibrium of one body's stress with its loads and given tractions; penetration and pressure
/// are zero.
pub fn check_stress<S: Recovery>(body: &Body<S>, stress: &EquilibratedStress<S>) -> Admissibility {
    residuals(S::measured(body, stress, None).0, 0.0)
}

/// [`check_stress`], with the scale of a displaced body, and what the bound needs of every triangle.
///
/// * `displacement`: of the body, with the effects of its rounding.
/// * `measured`: the stresses to which the distances are measured, Pa, one per triangle, and how accurate the means are.
pub(crate) fn check_stress_and_measure<S: Recovery>(
    body: &Body<S>,
    (displacement, noise): (&[S::Vector], Noise),
    stress: &EquilibratedStress<S>,
    measured: Option<(Against<'_, S>, Accuracy)>,
) -> (Admissibility, CellMeasures<S>) {
    let (found, mut cells) = S::measured(body, stress, measured);
    for (distances, displacement) in cells.distances.iter_mut().zip([Some(displacement), None]) {
        if !distances.is_empty() {
            stress.spring_terms(body, displacement).for_each(|(cell, term)| distances[cell] += term);
        }
    }
    (residuals(found, noise.force(displacement)), cells)
}

fn relative(x: f64, scale: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x / scale }
}

/// Relates the residuals of forces to their scale, or to one at which `noise` alone just passes.
fn residuals(found: Forces, noise: f64) -> Admissibility {
    let scale = larger(found.scale.sqrt(), noise / FORCE_TOLERANCE);
    Admissibility {
        equilibrium: relative(found.equilibrium.sqrt(), scale),
        traction_jump: relative(found.jump.sqrt(), scale),
        boundary_traction: relative(found.boundary.sqrt(), scale),
        ..Admissibility::default()
    }
}

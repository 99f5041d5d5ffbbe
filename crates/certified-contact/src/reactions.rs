//! Reactions of supports and rigid sides, and the balance of each body.

use fem_core::body::{Body, RigidMotion, RigidSide, SupportSet};
use fem_core::dense::pseudo_inverse;
use fem_core::directions::Directions;
use fem_core::double_double::DoubleDouble;
use fem_core::field;
use fem_core::geometry::{Vector, cross, norm};
use fem_core::interface::Partner;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};
use nalgebra::{DMatrix, Matrix3, Vector3};
use nndd::Iterate;

/// The reaction of one support.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// The body, in the order of [`crate::Results`].
    pub body: usize,
    /// The supported edge group.
    pub on: String,
    /// Force of the support on the body, N/m; a roller's is along its normal. If supports share a node and a direction, it counts for
    /// the first; two rollers with different normals take the components along their normals.
    pub force: Vector,
}

/// The motion of a rigid side, and the force that moves it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigidSideResults {
    /// The body, in the order of [`crate::Results`].
    pub body: usize,
    /// The edge group.
    pub on: String,
    /// Its motion, about the point of its condition.
    pub motion: RigidMotion,
    /// Resultant on the body, N/m: the given one along the components that its condition leaves free. Supports at its nodes have their
    /// own reaction.
    pub force: Vector,
    /// Moment about that point, N.
    pub moment: f64,
}

/// Sum of all forces on one body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Their sum, N/m.
    pub force: Vector,
    /// Their moment about the body's centroid, N, positive counter-clockwise.
    pub moment: f64,
}

impl Balance {
    /// Adds a force at a point; `arm` is the vector from the centroid to it.
    fn add(&mut self, arm: Vector, force: Vector) {
        self.force += force;
        self.moment += cross(arm, force);
    }
}

/// Computes the centroid of a mesh.
fn centroid(mesh: &TriMesh) -> Vector {
    let mut sum = Vector::zeros();
    let mut area = 0.0;
    // Relative to a point of the mesh, to avoid cancellation far from the origin.
    let origin = mesh.points()[0];
    for (t, corners) in mesh.cells().iter().enumerate() {
        let middle: Vector = corners.iter().map(|&v| mesh.points()[v] - origin).sum();
        sum += mesh.measure(t) / 3.0 * middle;
        area += mesh.measure(t);
    }
    origin + 1.0 / area * sum
}

/// Computes `K u − f` at every node, N/m: without rounding if the displacement was corrected; `low` are then the
/// low-order parts of the displacement.
pub(crate) fn nodal_forces(body: &Body, displacement: &[Vector], low: Option<&Vec<Vector>>) -> Vec<Vector> {
    let Some(low) = low else { return field::nodal_residual(body, displacement) };
    let split = SplitField { high: displacement.to_vec(), low: low.clone() };
    residual::of_field(body, &split).iter().map(|r| r.map(DoubleDouble::rounded).into()).collect()
}

/// Computes the motion of a rigid side and the force that moves it. The share of the supports at its nodes is left in `forces` there.
///
/// The condition of the side takes what it imposes. Supports take the rest, as the smallest forces along the directions that they hold.
///
/// * `displacement`: of all nodes, m; `forces`: `K u − f` without contact, N/m.
/// * `holders`: the supports of each node.
fn rigid_side(
    (body, b): (&Body, usize),
    side: &RigidSide,
    displacement: &[Vector],
    forces: &mut [Vector],
    holders: &[Vec<Holder>],
) -> RigidSideResults {
    let points = body.mesh().points();
    let mut force = Vector::zeros();
    let mut moment = 0.0;
    for (node, load) in side.nodes.iter().zip(&side.forces) {
        let on_side = std::mem::take(&mut forces[*node]) + load;
        force += on_side;
        moment += cross(points[*node] - side.about, on_side);
    }
    let (motion, _) = side.motion_of(points, displacement);
    let size = side.nodes.iter().map(|n| norm(points[*n] - side.about)).fold(f64::MIN_POSITIVE, f64::max);
    // The equations that the side's own condition leaves to supports: two forces, and the moment over the side's size.
    let left: Vector3<f64> = Vector3::from_fn(|c, _| f64::from(u8::from(!side.imposes[c])));
    let rest =
        Vector3::new(force[0] - side.force[0], force[1] - side.force[1], (moment - side.moment) / size);
    let columns: Vec<(NodeId, Vector, Vector3<f64>)> = side
        .nodes
        .iter()
        .flat_map(|&node| {
            held_by(&holders[node.index()]).basis().iter().map(|d| (node, *d)).collect::<Vec<_>>()
        })
        .map(|(node, d)| {
            let turns = cross(points[node] - side.about, d) / size;
            (node, d, Vector3::new(d[0], d[1], turns).component_mul(&left))
        })
        .collect();
    let normal: Matrix3<f64> = columns.iter().map(|(_, _, a)| a * a.transpose()).sum();
    let zero = DEPENDENT * normal.trace();
    let inverse = pseudo_inverse(DMatrix::from_column_slice(3, 3, normal.as_slice()), zero);
    let inverse = inverse.map_or_else(Matrix3::zeros, |found| Matrix3::from_column_slice(found.as_slice()));
    let factors = inverse * rest.component_mul(&left);
    for (node, direction, equation) in columns {
        let taken = equation.dot(&factors) * direction;
        forces[node] += taken;
        force -= taken;
        moment -= cross(points[node] - side.about, taken);
    }
    RigidSideResults { body: b, on: side.group.clone(), motion, force, moment }
}

/// Directions with a smaller sine, or a smaller relative pivot, are dependent.
const DEPENDENT: f64 = 1e-9;

/// A support, and the directions in which it holds a node.
#[derive(Clone, Copy)]
struct Holder {
    /// Place of the support in the body.
    support: usize,
    holds: Directions,
}

/// Computes the directions in which the supports of a node hold it.
fn held_by(holders: &[Holder]) -> Directions {
    let all = holders.iter().flat_map(|holder| holder.holds.basis());
    all.fold(Directions::NONE, |span, d| span.with(*d, DEPENDENT))
}

/// Splits the force on a node between its supports: along the directions of the first, then of the next that holds another direction.
///
/// Two rollers with different normals take the components along their normals. Without a second support the part across the first is no
/// reaction; the balance shows it.
fn shares(force: Vector, holders: &[Holder]) -> impl Iterator<Item = (usize, Vector)> + use<> {
    let mut held = holders.iter().filter(|holder| !holder.holds.is_none());
    let first = held.next();
    let other = first.and_then(|first| held.find(|other| held_by(&[*first, **other]) != first.holds));
    let beside = other.map_or(Directions::NONE, |other| other.holds);
    let part = first.map(|first| (first.support, first.holds.part_beside(&beside, force)));
    let rest = part.zip(other).map(|((_, part), other)| (other.support, force - part));
    part.into_iter().chain(rest)
}

/// Adds the reactions of a body's supports and of its rigid sides, and returns its balance.
pub(crate) fn support_reactions(
    prepared: &PreparedProblem,
    iterate: &Iterate,
    (b, displacement): (usize, &[Vector]),
    mut residual: Vec<Vector>,
    (reactions, rigid_sides): (&mut Vec<Reaction>, &mut Vec<RigidSideResults>),
) -> Balance {
    let problem = prepared.problem();
    let body: &Body = &problem.bodies[b];
    let centroid = centroid(body.mesh());
    let arm = |node: usize| body.mesh().points()[node] - centroid;
    let mut balance = Balance::default();
    let blocks = problem.blocks().zip(problem.tangential_blocks());
    for (pair, (block, tangents)) in problem.contacts.iter().zip(blocks) {
        let Some(side) = pair.side_of(Partner::Body(b)) else { continue };
        let role = pair.roles.of_side(side);
        let along_tangents = &[&iterate.tangential.reaction, &iterate.tangential.force][role][tangents];
        let forces = iterate.reactions()[role][block].iter().chain(along_tangents);
        for (row, r) in pair.rows().zip(forces) {
            let force = pair.roles.sign() * r * row.direction;
            let node = row.nodes[side].index();
            residual[node] -= force;
            balance.add(arm(node), force);
        }
    }
    for (node, force) in prepared.external_forces()[b].iter().enumerate() {
        balance.add(arm(node), *force);
    }
    let mut holders: Vec<Vec<Holder>> = vec![Vec::new(); residual.len()];
    for (support, set) in body.supports().iter().enumerate() {
        for (node, &holds) in set.nodes.iter().zip(&set.reactions) {
            holders[node.index()].push(Holder { support, holds });
        }
    }
    let mut rigid = vec![false; residual.len()];
    for side in body.rigid_sides() {
        for node in side.nodes.iter().map(|n| n.index()) {
            balance.add(arm(node), residual[node]);
            rigid[node] = true;
        }
        rigid_sides.push(rigid_side((body, b), side, displacement, &mut residual, &holders));
    }
    let begin = reactions.len();
    let unloaded = |set: &SupportSet| Reaction { body: b, on: set.group.clone(), force: Vector::zeros() };
    reactions.extend(body.supports().iter().map(unloaded));
    for (node, holders) in holders.iter().enumerate() {
        for (support, part) in shares(residual[node], holders) {
            reactions[begin + support].force += part;
            if !rigid[node] {
                balance.add(arm(node), part);
            }
        }
    }
    balance
}

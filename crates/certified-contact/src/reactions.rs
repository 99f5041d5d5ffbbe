//! Reactions of supports and rigid sides, forces of springs, and the balance of each body.

use cre_estimator::{Estimate, Recovery};
use fem_core::assembly::spring_forces;
use fem_core::body::{Body, RigidMotion, RigidSide, SpringFacet, SupportSet};
use fem_core::dense::pseudo_inverse;
use fem_core::directions::Directions;
use fem_core::field;
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{ContactProblem, PairRow, Partner};
use fem_core::mesh::Mesh;
use fem_core::mesh::id::NodeId;
use fem_core::residual::{self, SplitField};
use fem_core::space::{Plane, Space};
use nalgebra::DMatrix;
use nndd::Iterate;

/// The reaction of one support.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction<S: Space = Plane> {
    /// The body, in the order of [`crate::Results`].
    pub body: usize,
    /// The supported side.
    pub on: String,
    /// Force of the support on the body, N/m; a roller's is along its normal. If supports share a node and a direction, it counts for
    /// the first; rollers with different normals take the components along their normals. Of a body in subdomains that of the equilibrated stress: the
    /// sum over all supports is the same, the parts of supports with a common edge are not.
    pub force: S::Vector,
}

/// The motion of a rigid side, and the force that moves it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigidSideResults<S: Space = Plane> {
    /// The body, in the order of [`crate::Results`].
    pub body: usize,
    /// The side.
    pub on: String,
    /// Its motion, about the point of its condition.
    pub motion: RigidMotion<S>,
    /// Resultant on the body, N/m: the given one along the components that its condition leaves free. Supports at its nodes have their
    /// own reaction.
    pub force: S::Vector,
    /// Moment about that point, N.
    pub moment: S::Spin,
}

/// The force of the springs of one side.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringForce<S: Space = Plane> {
    /// The body, in the order of [`crate::Results`].
    pub body: usize,
    /// The side.
    pub on: String,
    /// `−∫ k (u − u₀)`: force of the springs on the body, N/m.
    pub force: S::Vector,
}

/// Computes the forces of the springs of a body, in the order of its conditions.
pub(crate) fn spring_sides<S: Space>(
    (body, b): (&Body<S>, usize),
    displacement: &[S::Vector],
) -> impl Iterator<Item = SpringForce<S>> {
    let mesh = body.mesh();
    body.springs().iter().map(move |side| {
        let of_facet = |of: &SpringFacet<S>| -> S::Vector {
            let nodes = mesh.topology().facets()[of.facet];
            let traction = of.traction(&S::axes(|k| displacement[nodes[k]]));
            let mean = traction.into_iter().sum::<S::Vector>() / S::DIM as f64;
            mean * mesh.facet_measure(of.facet)
        };
        SpringForce { body: b, on: side.group.clone(), force: side.facets.iter().map(of_facet).sum() }
    })
}

/// Sum of all forces on one body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance<S: Space = Plane> {
    /// Their sum, N/m.
    pub force: S::Vector,
    /// Their moment about the body's centroid, N, positive counter-clockwise.
    pub moment: S::Spin,
}

impl<S: Space> Balance<S> {
    /// Adds a force at a point; `arm` is the vector from the centroid to it.
    fn add(&mut self, arm: S::Vector, force: S::Vector) {
        self.force += force;
        self.moment += S::moment(arm, force);
    }
}

/// Computes the centroid of a mesh.
fn centroid<S: Space>(mesh: &Mesh<S>) -> S::Vector {
    let mut sum = S::Vector::ZERO;
    let mut whole = 0.0;
    // Relative to a point of the mesh, to avoid cancellation far from the origin.
    let origin = mesh.points()[0];
    for (t, corners) in mesh.cells().iter().enumerate() {
        let corners = corners.as_ref();
        let middle: S::Vector = corners.iter().map(|&v| mesh.points()[v] - origin).sum();
        sum += middle * (mesh.measure(t) / corners.len() as f64);
        whole += mesh.measure(t);
    }
    origin + sum * (1.0 / whole)
}

/// Computes `K u − f` at every node, N/m: without rounding if the displacement was corrected; `low` are then the
/// low-order parts of the displacement.
fn nodal_forces<S: Space>(
    body: &Body<S>,
    displacement: &[S::Vector],
    low: Option<&Vec<S::Vector>>,
) -> Vec<S::Vector> {
    let Some(low) = low else { return field::nodal_residual(body, displacement) };
    let split = SplitField { high: displacement.to_vec(), low: low.clone() };
    residual::of_field(body, &split).iter().map(|r| S::Vector::of(|c| r[c].rounded())).collect()
}

/// Computes the motion of a rigid side and the force that moves it. The share of the supports at its nodes is left in `forces` there.
///
/// The condition of the side takes what it imposes. Supports take the rest, as the smallest forces along the directions that they hold.
///
/// * `displacement`: of all nodes, m; `forces`: `K u − f` without contact, N/m.
/// * `holders`: the supports of each node.
fn rigid_side<S: Space>(
    (body, b): (&Body<S>, usize),
    side: &RigidSide<S>,
    displacement: &[S::Vector],
    forces: &mut [S::Vector],
    holders: &[Vec<Holder<S>>],
) -> RigidSideResults<S> {
    let points = body.mesh().points();
    let mut force = S::Vector::ZERO;
    let mut moment = S::Spin::default();
    for (node, load) in side.nodes.iter().zip(&side.forces) {
        let on_side = std::mem::take(&mut forces[*node]) + *load;
        force += on_side;
        moment += S::moment(points[*node] - side.about, on_side);
    }
    let (motion, _) = side.motion_of(points, displacement);
    let size = side.nodes.iter().map(|n| norm(points[*n] - side.about)).fold(f64::MIN_POSITIVE, f64::max);
    // The equations that the side's own condition leaves to supports: the forces, and the moments over the side's size.
    let equation = |force: S::Vector, moment: S::Spin| {
        let all = S::motion(force, moment / size);
        S::components(|c| if side.imposes[c] { 0.0 } else { all[c] })
    };
    let rest = equation(force - side.force, moment - side.moment);
    let held = |node: &NodeId| held_by(&holders[node.index()]).basis().iter().map(|d| (*node, *d)).collect();
    let columns: Vec<(NodeId, S::Vector)> = side.nodes.iter().flat_map::<Vec<_>, _>(held).collect();
    let columns: Vec<(NodeId, S::Vector, S::Components<f64>)> = columns
        .into_iter()
        .map(|(node, d)| (node, d, equation(d, S::moment(points[node] - side.about, d))))
        .collect();
    let mut normal = DMatrix::<f64>::zeros(S::COMPONENTS, S::COMPONENTS);
    for (i, j) in (0..S::COMPONENTS).flat_map(|j| (0..S::COMPONENTS).map(move |i| (i, j))) {
        normal[(i, j)] = columns.iter().fold(0.0, |sum, (_, _, a)| sum + a[i] * a[j]);
    }
    let zero = DEPENDENT * normal.trace();
    let inverse = pseudo_inverse(normal, zero);
    let factors = S::components(|i| {
        inverse
            .as_ref()
            .map_or(0.0, |inverse| (0..S::COMPONENTS).fold(0.0, |sum, j| sum + inverse[(i, j)] * rest[j]))
    });
    for (node, direction, equation) in columns {
        let factor = (0..S::COMPONENTS).fold(0.0, |sum, k| sum + equation[k] * factors[k]);
        let taken = direction * factor;
        forces[node] += taken;
        force -= taken;
        moment -= S::moment(points[node] - side.about, taken);
    }
    RigidSideResults { body: b, on: side.group.clone(), motion, force, moment }
}

/// Directions with a smaller sine, or a smaller relative pivot, are dependent.
const DEPENDENT: f64 = 1e-9;

/// A support, and the directions in which it holds a node.
#[derive(Clone, Copy)]
struct Holder<S: Space> {
    /// Place of the support in the body.
    support: usize,
    holds: Directions<S>,
}

/// Computes the directions in which the supports of a node hold it.
fn held_by<S: Space>(holders: &[Holder<S>]) -> Directions<S> {
    let all = holders.iter().flat_map(|holder| holder.holds.basis());
    all.fold(Directions::NONE, |span, d| span.with(*d, DEPENDENT))
}

/// Splits the force on a node between its supports: each that holds a direction that those before it do not takes a part along its own directions.
///
/// Rollers with different normals take the components along their normals. The part across all supports is no reaction; the balance shows it.
fn shares<S: Space>(force: S::Vector, holders: &[Holder<S>]) -> Vec<(usize, S::Vector)> {
    let (mut span, mut taking) = (Directions::<S>::NONE, Vec::new());
    for holder in holders {
        let wider = holder.holds.basis().iter().fold(span, |span, d| span.with(*d, DEPENDENT));
        if wider.count() > span.count() {
            taking.push(*holder);
        }
        span = wider;
    }
    let mut left = force;
    let mut shares = Vec::with_capacity(taking.len());
    for (k, holder) in taking.iter().enumerate() {
        let others = held_by(&taking[k + 1..]);
        let part = match () {
            () if others.is_none() && k > 0 && span.is_all() => left,
            () if others.is_none() => holder.holds.project(left),
            () => {
                let across = held_by(&taking[k..]).complement();
                let beside = across.basis().iter().fold(others, |beside, d| beside.with(*d, DEPENDENT));
                holder.holds.part_beside(&beside, left)
            }
        };
        left -= part;
        shares.push((holder.support, part));
    }
    shares
}

/// Nodes with the forces on them, Cartesian, N/m.
type NodalForces<S> = Vec<(NodeId, <S as Space>::Vector)>;

/// What acts on the nodes of a body, N/m.
pub(crate) struct Acting<S: Space> {
    /// `∫ σ : ε(φ) − f(φ)` with springs, without contact, by node.
    pub(crate) residual: Vec<S::Vector>,
    /// The forces of contact.
    contact: NodalForces<S>,
    /// The forces of springs.
    springs: NodalForces<S>,
}

impl<S: Recovery> Acting<S> {
    /// Of the displacement of a body and the forces that hold it.
    ///
    /// * `low`: the low-order parts of the displacement, if it was corrected.
    pub(crate) fn of_displacement(
        problem: &ContactProblem<S>,
        iterate: &Iterate,
        (b, displacement): (usize, &[S::Vector]),
        low: Option<&Vec<S::Vector>>,
    ) -> Self {
        let body = &problem.bodies[b];
        let blocks: Vec<_> = problem.blocks().zip(problem.tangential_blocks()).collect();
        let mut contact = Vec::new();
        // Bonded bodies are one body, on both sides of a pair within them.
        for (k, side) in problem.sides_of(Partner::Body(b)) {
            let (pair, (block, tangents)) = (&problem.contacts[k], blocks[k].clone());
            let role = pair.roles.of_side(side);
            let along_tangents = &[&iterate.tangential.reaction, &iterate.tangential.force][role][tangents];
            let forces = iterate.reactions()[role][block].iter().chain(along_tangents);
            let force =
                |(row, r): (PairRow<S>, &f64)| (row.nodes[side], row.direction * (pair.roles.sign() * r));
            contact.extend(pair.rows().zip(forces).map(force));
        }
        let springs = spring_forces(body, displacement).collect();
        Self { residual: nodal_forces(body, displacement, low), contact, springs }
    }

    /// Of the equilibrated stress of a body: of a body in subdomains, whose displacement is in equilibrium only when the iteration has ended.
    pub(crate) fn of_stress(problem: &ContactProblem<S>, estimate: &Estimate<S>, b: usize) -> Self {
        let body = &problem.bodies[b];
        let springs = estimate.pair.bodies[b].equilibrated.spring_forces(body);
        let mut residual = field::stress_residual(body, &estimate.mean_stress[b]);
        springs.iter().for_each(|(node, force)| residual[*node] -= *force);
        let mut contact = Vec::new();
        for (k, side) in problem.sides_of(Partner::Body(b)) {
            let nodes = problem.contacts[k].interface.pairs().iter().map(|of| of.nodes[side]);
            let forces = &estimate.pair.contacts[k].pressure_force;
            // They are those on the second body.
            contact.extend(
                nodes.zip(forces).map(|(node, force)| (node, if side == 0 { -*force } else { *force })),
            );
        }
        Self { residual, contact, springs }
    }
}

/// Adds the reactions of a body's supports and of its rigid sides, and returns its balance. At nodes of bonds they have no reactions: those of the joined
/// bodies know them.
pub(crate) fn support_reactions<S: Space>(
    (problem, external_forces): (&ContactProblem<S>, &[Vec<S::Vector>]),
    (b, displacement): (usize, &[S::Vector]),
    Acting { mut residual, contact, springs }: Acting<S>,
    (reactions, rigid_sides): (&mut Vec<Reaction<S>>, &mut Vec<RigidSideResults<S>>),
) -> Balance<S> {
    let body = &problem.bodies[b];
    let centroid = centroid(body.mesh());
    let arm = |node: usize| body.mesh().points()[node] - centroid;
    let mut balance = Balance::default();
    for (node, force) in contact {
        residual[node] -= force;
        balance.add(arm(node.index()), force);
    }
    for (node, force) in external_forces[b].iter().enumerate() {
        balance.add(arm(node), *force);
    }
    springs.into_iter().for_each(|(node, force)| balance.add(arm(node.index()), force));
    for pair in problem.contacts.iter().filter(|pair| pair.is_bonded()) {
        // What is left at a node of a bond is the force of the bond and of supports there.
        let Some(side) = pair.side_of(Partner::Body(b)) else { continue };
        for of in pair.interface.pairs() {
            let node = of.nodes[side].index();
            balance.add(arm(node), std::mem::take(&mut residual[node]));
        }
    }
    let mut holders: Vec<Vec<Holder<S>>> = vec![Vec::new(); residual.len()];
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
    let unloaded = |set: &SupportSet<S>| Reaction { body: b, on: set.group.clone(), force: S::Vector::ZERO };
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

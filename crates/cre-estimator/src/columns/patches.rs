//! The supported parts of the boundary of a body, and the wrenches that they can take up.

use super::cocycles::Sets;
use crate::springs::reaction;
use fem_core::body::{Body, RigidMotion};
use fem_core::directions::Directions;
use fem_core::geometry::norm;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Matrix, Space};
use std::collections::BTreeMap;

/// Directions of reaction that differ by less (sine of the angle) are the same.
const SAME_DIRECTION: f64 = 1e-9;

/// An eigenvalue below this fraction of the largest one is round-off: wrenches are squared.
const ZERO: f64 = 1e-12;

/// A rigid motion or a wrench: components, and rotations or moments about the middle of the body, over its size.
pub(super) type Wrench<S> = <S as Space>::Components<f64>;

/// The unit of rigid motions and wrenches: the middle of a body, m, and its size, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<S: Space> {
    middle: S::Vector,
    size: f64,
}

impl<S: Space> Frame<S> {
    pub(super) fn new(body: &Body<S>) -> Self {
        let [low, high] = body.mesh().bounding_box();
        Self { middle: (low + high) * 0.5, size: norm(high - low) }
    }

    /// Computes the displacement of a point in a rigid motion.
    pub(super) fn moved(&self, motion: &Wrench<S>, point: S::Vector) -> S::Vector {
        let (translation, spin) = S::parts(motion);
        translation + S::turned(spin / self.size, point - self.middle)
    }

    /// Computes the wrench of a force at a point.
    fn wrench(&self, force: S::Vector, point: S::Vector) -> Wrench<S> {
        S::work(force, (point - self.middle) * (1.0 / self.size), 1.0)
    }

    fn components(&self, motion: &RigidMotion<S>) -> Wrench<S> {
        S::motion(motion.at(self.middle), motion.spin * self.size)
    }
}

/// Facets of one support that are joined to each other and have reactions in the same directions.
#[derive(Clone, Debug)]
pub(super) struct Patch<S: Space> {
    pub(super) facets: Vec<FacetId>,
    pub(super) reaction: Directions<S>,
    /// The connected piece of the body.
    pub(super) piece: u32,
    /// Orthonormal: the wrenches that each of its facets can pass on to the next.
    pub(super) carried: Vec<Wrench<S>>,
    /// Orthonormal: the resultants that it may have.
    pub(super) resultants: Vec<Wrench<S>>,
}

/// The supports of a body.
#[derive(Clone, Debug)]
pub(super) struct Patches<S: Space> {
    pub(super) list: Vec<Patch<S>>,
    /// Neighbours with other directions, and a node that is common to them; wrenches pass from one to the other there.
    pub(super) ridges: Vec<([usize; 2], NodeId)>,
}

/// A facet with unknown tractions: supported, or on springs.
struct Supported<S: Space> {
    facet: FacetId,
    reaction: Directions<S>,
    /// The rigid side that may move to which it belongs.
    side: Option<usize>,
}

impl<S: Space> Patches<S> {
    /// Finds them in time proportional to the boundary.
    pub(super) fn new(body: &Body<S>, frame: &Frame<S>) -> Self {
        let topology = body.mesh().topology();
        let moving = body.rigid_sides().iter().enumerate().filter(|(_, side)| !side.motions.is_empty());
        let side_of: BTreeMap<FacetId, usize> =
            moving.flat_map(|(k, side)| side.edges.iter().map(move |facet| (*facet, k))).collect();
        let conditions = topology.boundary_facets().iter().zip(body.facet_conditions());
        let supported: Vec<Supported<S>> = conditions
            .map(|(facet, condition)| Supported {
                facet: *facet,
                reaction: reaction(body, *facet, condition),
                side: side_of.get(facet).copied(),
            })
            .filter(|facet| !facet.reaction.is_none())
            .collect();
        let mut sets = Sets::new(supported.len());
        let mut borders = Vec::new();
        for (pair, node) in neighbours(body, &supported) {
            let [a, b] = pair.map(|k| &supported[k]);
            if a.side == b.side && same(&a.reaction, &b.reaction) {
                sets.join(pair[0], pair[1]);
            } else if a.side.is_none() && b.side.is_none() {
                borders.push((pair, node));
            }
        }
        let mut place = BTreeMap::new();
        let mut members: Vec<Vec<&Supported<S>>> = Vec::new();
        for (k, facet) in supported.iter().enumerate() {
            let patch = *place.entry(sets.name(k)).or_insert(members.len());
            if patch == members.len() {
                members.push(Vec::new());
            }
            members[patch].push(facet);
        }
        let patch_of = |k: usize, sets: &mut Sets| place.get(&sets.name(k)).copied().unwrap_or_default();
        let ridges = borders.into_iter().map(|(pair, node)| (pair.map(|k| patch_of(k, &mut sets)), node));
        let ridges = ridges.filter(|([a, b], _)| a != b).collect();
        Self { list: members.iter().map(|facets| patch(body, frame, facets)).collect(), ridges }
    }
}

/// Lists the pairs of supported facets that share a node, in space an edge, with a node of it.
fn neighbours<S: Space>(body: &Body<S>, supported: &[Supported<S>]) -> Vec<([usize; 2], NodeId)> {
    let mut rims = Vec::new();
    for (k, facet) in supported.iter().enumerate() {
        let nodes = body.mesh().topology().facets()[facet.facet];
        for left_out in nodes {
            // A node twice in the plane, two nodes in space: facets list their nodes in ascending order.
            let mut others = nodes.into_iter().filter(|node| *node != left_out);
            if let Some(first) = others.next() {
                rims.push(([first, others.next().unwrap_or(first)], k));
            }
        }
    }
    rims.sort_unstable();
    let pairs = rims.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 2);
    pairs.map(|group| ([group[0].1, group[1].1], group[0].0[0])).collect()
}

fn same<S: Space>(a: &Directions<S>, b: &Directions<S>) -> bool {
    a.count() == b.count() && (a.is_all() || a.basis().iter().all(|d| b.contains(*d, SAME_DIRECTION)))
}

fn patch<S: Space>(body: &Body<S>, frame: &Frame<S>, facets: &[&Supported<S>]) -> Patch<S> {
    let (mesh, topology) = (body.mesh(), body.mesh().topology());
    let Supported { facet, reaction, side } = *facets[0];
    let every: Vec<Wrench<S>> =
        (0..S::COMPONENTS).map(|k| S::components(|j| if j == k { 1.0 } else { 0.0 })).collect();
    let carried = if reaction.is_all() {
        every
    } else {
        let points = facets.iter().flat_map(|of| mesh.facet_corners(of.facet));
        let forces = points.flat_map(|x| reaction.basis().iter().map(move |d| frame.wrench(*d, x)));
        split::<S>(forces)[0].clone()
    };
    let resultants = match side {
        // What does no work along the motions that are free.
        Some(k) => split::<S>(body.rigid_sides()[k].motions.iter().map(|m| frame.components(m)))[1].clone(),
        None => carried.clone(),
    };
    Patch {
        facets: facets.iter().map(|of| of.facet).collect(),
        reaction,
        piece: topology.pieces().0[topology.facets()[facet][0]],
        carried,
        resultants,
    }
}

/// Finds orthonormal bases of the span of some vectors, and of all that is perpendicular to it.
pub(super) fn split<S: Space>(vectors: impl Iterator<Item = Wrench<S>>) -> [Vec<Wrench<S>>; 2] {
    let mut gram = S::Matrix::default();
    vectors.for_each(|vector| gram.add_square(&vector));
    let eigen = gram.eigen();
    let largest = eigen.iter().fold(0.0, |most: f64, (value, _)| most.max(*value));
    let (span, rest): (Vec<_>, Vec<_>) = eigen.into_iter().partition(|(value, _)| *value > ZERO * largest);
    [span, rest].map(|half| half.into_iter().map(|(_, vector)| vector).collect())
}

//! Common refinement: makes two bodies with non-matching contact surfaces into two with matching nodes.
//!
//! The theory of the bound needs matching nodes. So the nodes of each surface are projected onto the other along the
//! contact normal:
//!
//! 1. **Project.** Both surfaces are measured by the arc length `s` of the one with fewer edges, with its averaged normals
//!    `n(s)`: a point `q` has the `s` for which `q − r(s)` is along `n(s)`.
//!    Closed lines are first opened at a common node; if there is no common node, one is inserted.
//! 2. **Snap.** Nodes closer than 0.2 of the smaller edge next to them become one: the one with the longer edges slides
//!    along its own surface, onto the other's normal. Ends, corners, supported nodes and nodes at which a group of edges or a
//!    material begins move by 0.01 of that edge at most; no triangle loses more than 70 % of its area. Nodes that
//!    then remain close stay apart, so all paired nodes face each other to round-off.
//! 3. **Bisect.** If the remaining nodes would cut a contact cell into a fan with an angle below 8 degrees, the cells
//!    are bisected inwards first ([`fem_core::mesh::refine`]).
//! 4. **Insert.** The remaining nodes are inserted and their cells cut from there to the opposite corner.
//!
//! If only a part of the surfaces faces each other, it becomes the contact surface: the group of edges keeps that part,
//! and the rest is free. The parts of an edge inherit its conditions ([`Body::refined`]), so the problem is the same.
//! The result does not depend on the order of the two bodies.
//!
//! At a corner between declared curves or straight stretches beside them both surfaces end, and others begin: its node is projected once along the
//! normal of each.
//!
//! On curved surfaces the normals belong to the line on which both are measured, before the cuts (the cut polygon has
//! edges in a row, whose averaged normals would be edge normals and lock), and gaps are measured between smooth curves
//! through the nodes: two polygons on one circle are apart by the square of their edge length, more than the
//! deformation of the bodies. A node slides along the smooth curve of its surface. On a side that is declared as a curve
//! ([`Body::with_curves`]) the inserted nodes lie on that curve, and on an arc the normals are the arc's own.
//!
//! Source: the common refinement of Jiao and Heath 2004, here by insertion into the meshes themselves, so that the pairs
//! match and the constitutive relation error remains a bound.

mod batch;
mod chain;
mod corners;
pub(super) mod curve;
mod cut;
mod error;
mod line;
mod moved;
mod overlap;
mod seam;

use super::{ContactNormal, outline};
use chain::Chain;
use curve::Between;
use fem_core::body::Body;
use fem_core::geometry::Vector;
use fem_core::mesh::id::{FacetId, NodeId};
use overlap::Overlap;
use std::collections::HashMap;

pub use error::CommonRefinementError;

/// The changes of the two meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Changes {
    /// Nodes added to each body: inserted in its surface, or by the bisection of cells inwards.
    pub added: [usize; 2],
    /// Nodes of each body that were moved along its surface onto a node of the other.
    pub snapped: [usize; 2],
    /// Largest motion of a node of each body, m.
    pub largest_move: [f64; 2],
    /// Smallest angle of the cells at each body's contact surface before, degrees.
    pub angle_before: [f64; 2],
    /// Smallest angle of the cells at each body's contact surface afterwards, degrees.
    pub smallest_angle: [f64; 2],
    /// Length of each surface that does not face the other one and is free, m.
    pub free: [f64; 2],
}

/// Two nodes that face each other, one of each body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Facing {
    /// Node of the first and of the second body.
    pub nodes: [NodeId; 2],
    /// Normal out of the first body, taken from the surface on which both are measured: linear between the unit averages at
    /// its nodes before the cuts, so at most of length one.
    pub normal: Vector,
    /// Distance along the normal, m, negative where the surfaces overlap: of smooth curves through the nodes that each surface
    /// had before the cuts. Between polygons it would be wrong by the square of their edges.
    pub gap: f64,
    /// Sum of the largest distances of the two polygons from such curves, m.
    pub sagitta: f64,
    /// Sum of the largest uncertainties of such curves, m: zero if the surfaces are straight or circles.
    pub uncertainty: f64,
    /// The shorter of the two edges before the cuts, m.
    pub spacing: f64,
}

/// Nodes, normals and gaps that were measured between two surfaces before they were cut.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Measured {
    /// The nodes of the contact surfaces that face each other, in order along each stretch.
    pub facing: Vec<Vec<Facing>>,
    /// The gap from one of the first body's nodes to the next, measured as [`Facing::gap`].
    pub(super) between: HashMap<[NodeId; 2], Between>,
}

/// Two bodies whose contact surfaces match.
#[derive(Clone, Debug)]
pub struct CommonRefinement {
    /// The bodies, in the order given.
    pub bodies: [Body; 2],
    /// Nodes, normals and gaps that were measured between them before the cuts.
    pub measured: Measured,
    /// The changes; `None` if there are no changes.
    pub changes: Option<Changes>,
}

/// Two surfaces whose nodes are to match.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    /// The numbers of their two bodies.
    pub bodies: [usize; 2],
    /// The edge group of the first and of the second body.
    pub groups: [&'a str; 2],
    /// The direction of projection.
    pub normal: ContactNormal,
}

/// The measured nodes of two surfaces that were made to match, and the changes; `None` if there are no changes.
pub type Matched = (Measured, Option<Changes>);

/// The number of a pair that was looked at, and what was found.
pub(crate) type Looked = (usize, Result<Matched, CommonRefinementError>);

/// Makes the contact surfaces of two bodies match.
///
/// * `surfaces`: the edge group of the first and of the second body.
/// * `normal`: the direction of projection.
///
/// # Errors
/// Surfaces that do not face each other anywhere, or fold, see
/// [`CommonRefinementError`].
pub fn common_refinement(
    mut bodies: [Body; 2],
    surfaces: [&str; 2],
    normal: ContactNormal,
) -> Result<CommonRefinement, CommonRefinementError> {
    let mut found = common_refinements(&mut bodies, &[Surfaces { bodies: [0, 1], groups: surfaces, normal }]);
    let (_, found) = found.remove(0);
    found.map(|(measured, changes)| CommonRefinement { bodies, measured, changes })
}

/// Makes the contact surfaces of several pairs match, each body is cut once for all of them: the first pair, and those of the others whose
/// surroundings have no node in common. Surfaces that cannot match change nothing.
///
/// Returns the numbers of the pairs that were looked at, ascending, each with what was found.
pub(crate) fn common_refinements(bodies: &mut [Body], pairs: &[Surfaces<'_>]) -> Vec<Looked> {
    let together = batch::independent(bodies, pairs);
    batch::match_all(bodies, pairs, &together).unwrap_or_else(|fault| match together[..] {
        // The fault of one of several: the first is cut alone.
        [first, _, ..] => match batch::match_all(bodies, pairs, &[first]) {
            Ok(found) => found,
            Err(fault) => vec![(first, Err(fault))],
        },
        _ => vec![(0, Err(fault))],
    })
}

fn chains(body: &Body, number: usize, group: &str) -> Result<Vec<Chain>, CommonRefinementError> {
    let fault = || CommonRefinementError::NoSurface { body: number, group: group.to_string() };
    let edges = body.mesh().group(group).filter(|edges| !edges.is_empty()).ok_or_else(fault)?;
    chain::chains(body.mesh(), edges).ok_or_else(fault)
}

/// Chooses the surface on which both are measured: one that is a declared arc of a body that may spin, whose own normals leave it free;
/// otherwise the one with fewer edges; for equal numbers the one that comes first in space, so that the order of the bodies does not matter.
fn reference(bodies: [&Body; 2], surfaces: [&str; 2], chains: &[Vec<Chain>; 2]) -> usize {
    let spins = [0, 1].map(|b| {
        let edges = bodies[b].mesh().group(surfaces[b]).unwrap_or(&[]);
        outline::is_one_arc(bodies[b], edges.iter().copied()) && bodies[b].free_motion().is_some()
    });
    if spins[0] != spins[1] {
        return usize::from(spins[1]);
    }
    let edges = |b: usize| chains[b].iter().map(|c| c.nodes.len() - 1).sum::<usize>();
    let places =
        |b: usize| chain::sorted_points(bodies[b].mesh(), &chains[b]).into_iter().flat_map(<[f64; 2]>::from);
    let earlier = || places(1).zip(places(0)).map(|(q, p)| q.total_cmp(&p)).find(|o| o.is_ne());
    let order = edges(1).cmp(&edges(0)).then_with(|| earlier().unwrap_or(std::cmp::Ordering::Equal));
    usize::from(order.is_lt())
}

fn centre(body: &Body, chains: &[Chain]) -> Vector {
    let mut sum = Vector::zeros();
    let nodes: Vec<NodeId> = chains.iter().flat_map(|c| c.nodes.iter().copied()).collect();
    for &n in &nodes {
        sum += body.mesh().points()[n];
    }
    1.0 / nodes.len() as f64 * sum
}

fn surface_angle(body: &Body, group: &str) -> f64 {
    let mesh = body.mesh();
    let edges = mesh.group(group).unwrap_or(&[]);
    chain::smallest_angle(mesh, edges.iter().flat_map(|&e| mesh.topology().facets()[e]))
}

/// Finds the edges of the overlaps in the group of the contact surface, and the length of the others; `None` if there are no others.
fn restricted(body: &Body, number: usize, group: &str, overlaps: &[Overlap]) -> Option<(Vec<FacetId>, f64)> {
    let mesh = body.mesh();
    let find = |ends: [NodeId; 2]| mesh.topology().find_edge(ends[0], ends[1]);
    let mut kept: Vec<FacetId> = overlaps.iter().flat_map(|o| o.common(number)).filter_map(find).collect();
    kept.sort_unstable();
    kept.dedup();
    let all = mesh.group(group).unwrap_or(&[]);
    if kept == all {
        return None;
    }
    let free = all.iter().filter(|e| kept.binary_search(e).is_err()).map(|&e| mesh.facet_measure(e)).sum();
    Some((kept, free))
}

#[cfg(test)]
mod tests;

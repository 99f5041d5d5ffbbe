//! Pairs of solids that both bodies clamp: they have no unknown, and are removed.

use super::Vector;
use fem_core::body::Body;
use fem_core::geometry::norm;
use fem_core::interface::{
    ClampedCorner, ClampedPair, ContactFacet, ContactInterface, InterfaceError, NodePair,
};
use fem_core::space::Solid;

/// An overlap of clamped nodes up to this fraction of the data that it is computed from is round-off.
const ROUND_OFF: f64 = 1e-12;

/// What supports impose on a pair that both bodies clamp.
#[derive(Clone, Copy)]
struct Known {
    /// The displacement of the first body less the one of the second, m.
    jump: Vector,
    /// The opening, m.
    opening: f64,
    /// The size of its terms, m.
    size: f64,
}

impl Known {
    /// `None` unless both bodies clamp the pair.
    fn of(bodies: [&Body<Solid>; 2], pair: &NodePair<Solid>) -> Option<Self> {
        let constraints = [0, 1].map(|b: usize| &bodies[b].node_constraints()[pair.nodes[b]]);
        if !constraints.iter().all(|constraint| constraint.is_clamped()) {
            return None;
        }
        let imposed = constraints.map(|constraint| constraint.displacement());
        let jump = imposed[0] - imposed[1];
        let size = pair.gap.abs() + (norm(imposed[0]) + norm(imposed[1])) * norm(pair.normal);
        Some(Self { jump, opening: pair.gap - jump.dot(&pair.normal), size })
    }
}

/// Removes the pairs that both bodies clamp.
///
/// # Errors
/// Supports that press the bodies into each other at a node, or along an edge both of whose nodes are clamped; no other pairs.
pub(crate) fn without_clamped(
    bodies: [&Body<Solid>; 2],
    whole: ContactInterface<Solid>,
) -> Result<ContactInterface<Solid>, InterfaceError> {
    if whole.gap().is_bonded() {
        return Ok(whole);
    }
    let known: Vec<Option<Known>> = whole.pairs().iter().map(|pair| Known::of(bodies, pair)).collect();
    if known.iter().all(Option::is_none) {
        return Ok(whole);
    }
    check(bodies, &whole, &known)?;
    // Numbers among the pairs that remain, or among those that are removed.
    let (mut pairs, mut removed, mut number) = (Vec::new(), Vec::new(), Vec::new());
    for (pair, known) in whole.pairs().iter().zip(&known) {
        match known {
            None => {
                number.push(pairs.len() as u32);
                pairs.push(*pair);
            }
            Some(_) => {
                number.push(removed.len() as u32);
                removed.push(ClampedPair { pair: *pair, around: Vec::new() });
            }
        }
    }
    if pairs.is_empty() {
        let point = bodies[0].mesh().points()[whole.pairs()[0].nodes[0]];
        return Err(InterfaceError::HeldNode { body: 0, point: point.into() });
    }
    let mut facets = Vec::with_capacity(whole.facets().len());
    for facet in whole.facets() {
        let corners = facet.pairs.map(|k| (number[k as usize], known[k as usize]));
        let free: Vec<u32> = corners.iter().filter(|(_, known)| known.is_none()).map(|(k, _)| *k).collect();
        let clamped = corners.map(|(number, known)| {
            let Known { jump, opening, .. } = known?;
            removed[number as usize].around.extend(&free);
            Some(ClampedCorner { number, opening: opening.max(0.0), jump })
        });
        let substitute = free.first().copied().unwrap_or(0);
        let pairs = corners.map(|(k, known)| if known.is_none() { k } else { substitute });
        facets.push(ContactFacet { pairs, clamped, ..*facet });
    }
    for of in &mut removed {
        of.around.sort_unstable();
        of.around.dedup();
    }
    Ok(ContactInterface::new(pairs, facets, whole.gap().clone()).with_clamped(removed))
}

/// Checks that the openings that supports impose are not negative, at nodes and along edges.
fn check(
    bodies: [&Body<Solid>; 2],
    whole: &ContactInterface<Solid>,
    known: &[Option<Known>],
) -> Result<(), InterfaceError> {
    let points = bodies[0].mesh().points();
    let at = |k: usize| points[whole.pairs()[k].nodes[0]];
    for (k, of) in known.iter().enumerate() {
        if let Some(of) = of.filter(|of| of.opening < -ROUND_OFF * of.size) {
            return Err(InterfaceError::ClampedOverlap { point: at(k).into(), depth: -of.opening });
        }
    }
    let middle = whole.middle_openings(|k| known[k].map_or_else(Vector::zeros, |of| of.jump));
    let edges = whole.facets().iter().flat_map(|facet| {
        ContactFacet::<Solid>::edges().map(|ends| ends.map(|corner| facet.pairs[corner] as usize))
    });
    for ([i, j], middle) in edges.zip(middle) {
        let [Some(a), Some(b)] = [known[i], known[j]] else { continue };
        let depth = -middle - (a.opening.max(0.0) * b.opening.max(0.0)).sqrt();
        if depth > ROUND_OFF * a.size.max(b.size) {
            return Err(InterfaceError::ClampedOverlap { point: (0.5 * (at(i) + at(j))).into(), depth });
        }
    }
    Ok(())
}

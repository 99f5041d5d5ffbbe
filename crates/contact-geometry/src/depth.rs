//! Interference deeper than a body is thick is refused: the gap would be that of another side.

use fem_core::body::Body;
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{ContactFacet, InterfaceError, NodePair};
use fem_core::mesh::cell_tree::CellTree;
use fem_core::space::Space;

/// Points at this many depths, down to the whole, are to be in the body.
const SAMPLES: usize = 4;
/// A point may be outside of a body by this fraction of its diagonal.
const ROUND_OFF: f64 = 1e-9;

/// Refuses pairs that interfere by more than the thickness of one of their bodies, measured along the normal at the middles of facets.
///
/// * `bodies`: the second is `None` for an obstacle.
///
/// # Errors
/// [`InterfaceError::TooDeep`] with the first such facet.
pub(super) fn check<S: Space>(
    bodies: [Option<&Body<S>>; 2],
    pairs: &[NodePair<S>],
    facets: &[ContactFacet<S>],
) -> Result<(), InterfaceError> {
    if pairs.iter().all(|pair| pair.gap >= 0.0) {
        return Ok(());
    }
    for (b, body) in bodies.into_iter().enumerate() {
        let Some(mesh) = body.map(Body::mesh) else { continue };
        let (tree, width) = (CellTree::new(mesh), ROUND_OFF * mesh.diagonal());
        for facet in facets {
            let corners = || facet.pairs.into_iter().map(|k| &pairs[k as usize]);
            let gap = corners().map(NodePair::gap_vector).sum::<S::Vector>() * (1.0 / S::DIM as f64);
            let normal: S::Vector = corners().map(|pair| pair.normal).sum();
            // A negative gap points into the first body, and out of the second.
            if gap.times(&normal) >= 0.0 {
                continue;
            }
            let (point, inward) = (mesh.facet_middle(facet.facets[b]), if b == 0 { gap } else { -gap });
            let is_inside = |k: usize| {
                let at = point + inward * (k as f64 / SAMPLES as f64);
                !tree.around(at, width).is_empty()
            };
            if !(1..=SAMPLES).all(is_inside) {
                let point = point.into();
                return Err(InterfaceError::TooDeep { body: b, point, depth: norm(gap) });
            }
        }
    }
    Ok(())
}

//! The gap between the surfaces as drawn in the meshes, and its checks.

use super::common_refinement::Facing;
use super::common_refinement::curve::Between;
use super::{facet_size, matching};
use fem_core::body::Body;
use fem_core::geometry::{Coordinates, Vector, norm};
use fem_core::interface::{ContactFacet, Gap, GapChange, InterfaceError, NodePair};
use fem_core::smooth::STRAIGHT;
use fem_core::space::{Plane, Space};

/// Paired nodes face each other along the contact normal to this fraction of the edges there.
const FACING: f64 = 1e-9;
/// Coordinates are rounded by at most this fraction of the largest one.
const COORDINATES: f64 = 16.0 * f64::EPSILON;
/// A distance up to this fraction of the smaller body's diagonal is rounding of the meshes: the surfaces touch.
const TOUCHING: f64 = 1e-6;
/// A change of the gap up to this fraction of the smaller body's diagonal is round-off.
const ROUND_OFF: f64 = 1e-9;

/// The distance of the surfaces at every pair, along the contact normal.
pub(super) struct GeometricGap {
    gaps: Vec<f64>,
    /// Uncertainty of each distance, m.
    uncertainty: Vec<f64>,
    /// The size of the smallest facet at each pair, m.
    spacing: Vec<f64>,
    /// Diagonal of the smaller body, m.
    size: f64,
}

impl GeometricGap {
    /// Measures the distances.
    ///
    /// * `facing`: the distances from a common refinement, between smooth curves, at every pair.
    ///
    /// # Errors
    /// Paired nodes that do not face each other along the contact normal to round-off.
    pub(super) fn measure<S: Space>(
        bodies: [&Body<S>; 2],
        pairs: &[NodePair<S>],
        facets: &[ContactFacet<S>],
        facing: Option<&[&Facing]>,
    ) -> Result<Self, InterfaceError> {
        let Self { spacing, size, .. } = Self::between(bodies, pairs, facets);
        let (mut gaps, mut uncertainty) = (Vec::with_capacity(pairs.len()), Vec::with_capacity(pairs.len()));
        for (k, (pair, &spacing)) in pairs.iter().zip(&spacing).enumerate() {
            let [point, other] = [0, 1].map(|b| bodies[b].mesh().points()[pair.nodes[b]]);
            let distance = other - point;
            let found = facing.map(|all| all[k]);
            let across = S::complement(&[pair.normal]);
            let offset = norm(S::Vector::of(|c| across[c].times(&distance)));
            // On a straight line every node has the normal of the first edge.
            let turn = if found.is_some() { STRAIGHT * norm(distance) } else { 0.0 };
            let rounded = COORDINATES * point.largest().max(other.largest());
            if !(offset <= FACING * spacing + rounded + turn) {
                return Err(InterfaceError::Offset { point: point.into(), offset, spacing });
            }
            let along = || distance.times(&pair.normal) / norm(pair.normal);
            gaps.push(found.map_or_else(along, |f| f.gap));
            uncertainty.push(found.map_or(0.0, |f| f.uncertainty));
        }
        Ok(Self { gaps, uncertainty, spacing, size })
    }

    /// Measures the distances of nodes that need not face each other along the normal.
    pub(super) fn between<S: Space>(
        bodies: [&Body<S>; 2],
        pairs: &[NodePair<S>],
        facets: &[ContactFacet<S>],
    ) -> Self {
        let mut spacing = vec![f64::INFINITY; pairs.len()];
        for facet in facets {
            for k in facet.pairs {
                spacing[k as usize] = spacing[k as usize].min(facet_size::<S>(facet.measure));
            }
        }
        let gap = |pair: &NodePair<S>| {
            let [point, other] = [0, 1].map(|b| bodies[b].mesh().points()[pair.nodes[b]]);
            (other - point).times(&pair.normal) / norm(pair.normal)
        };
        let size = bodies[0].mesh().diagonal().min(bodies[1].mesh().diagonal());
        Self { gaps: pairs.iter().map(gap).collect(), uncertainty: vec![0.0; pairs.len()], spacing, size }
    }

    /// Returns the distances, m, negative if the surfaces overlap.
    pub(super) fn gaps(&self) -> &[f64] {
        &self.gaps
    }

    /// Finds the pair whose gap differs most from the drawn one; `None` if all are equal to round-off.
    pub(super) fn change<S: Space>(
        &self,
        points: &[S::Vector],
        pairs: &[NodePair<S>],
    ) -> Option<GapChange<S>> {
        let change = |(pair, drawn): (&NodePair<S>, &f64)| GapChange {
            point: points[pair.nodes[0]],
            drawn: *drawn,
            used: pair.gap / norm(pair.normal),
        };
        let size = |c: &GapChange<S>| (c.used - c.drawn).abs();
        let largest = pairs.iter().zip(&self.gaps).map(change).max_by(|a, b| size(a).total_cmp(&size(b)));
        largest.filter(|c| size(c) > ROUND_OFF * self.size)
    }
}

/// A distance of the surfaces at one point.
#[derive(Clone, Copy)]
struct Measured<S: Space> {
    point: S::Vector,
    gap: f64,
    spacing: f64,
    uncertainty: f64,
}

/// The surfaces as drawn, at the pairs and between them.
pub(super) struct Surfaces<'a, S: Space = Plane> {
    pub(super) drawn: &'a GeometricGap,
    pub(super) facets: &'a [ContactFacet<S>],
    /// None in space.
    pub(super) between: &'a [Option<Between>],
}

impl<S: Space> Surfaces<'_, S> {
    fn measured(&self, points: &[S::Vector], pairs: &[NodePair<S>]) -> Vec<Measured<S>> {
        let drawn = self.drawn;
        let place = |k: usize| points[pairs[k].nodes[0]];
        let at_pair = |k: usize| Measured {
            point: place(k),
            gap: drawn.gaps[k],
            spacing: drawn.spacing[k],
            uncertainty: drawn.uncertainty[k],
        };
        let mut all: Vec<Measured<S>> = (0..pairs.len()).map(at_pair).collect();
        for (edge, between) in self.facets.iter().zip(self.between) {
            let Some(between) = between else { continue };
            let [i, j] = [0, 1].map(|end: usize| place(edge.pairs[end] as usize));
            for (t, gap) in [1.0 / 3.0, 2.0 / 3.0].into_iter().zip(between.gaps) {
                let point = i * (1.0 - t) + j * t;
                all.push(Measured { point, gap, spacing: edge.measure, uncertainty: between.uncertainty });
            }
        }
        all
    }

    /// Rejects surfaces that are apart or overlap, and reports the largest distance.
    pub(super) fn check_touching(
        &self,
        points: &[S::Vector],
        pairs: &[NodePair<S>],
    ) -> Result<(), InterfaceError> {
        let excess = |m: &Measured<S>| m.gap.abs() - m.uncertainty;
        let all = self.measured(points, pairs);
        match all.iter().max_by(|a, b| excess(a).total_cmp(&excess(b))) {
            Some(m) if !(excess(m) <= TOUCHING * self.drawn.size) => {
                Err(InterfaceError::NotTouching { point: m.point.into(), gap: m.gap })
            }
            _ => Ok(()),
        }
    }

    /// Assigns the drawn gaps to the pairs, and rejects overlaps that are not to be kept, reporting the deepest.
    pub(super) fn take_gaps(
        &self,
        points: &[S::Vector],
        pairs: &mut [NodePair<S>],
        gap: &Gap<S>,
    ) -> Result<(), InterfaceError> {
        let size = self.drawn.size;
        let all = self.measured(points, pairs);
        if let Some(far) = all.iter().find(|m| m.gap > size) {
            return Err(InterfaceError::TooFar { point: far.point.into(), distance: far.gap, size });
        }
        let depth = |m: &Measured<S>| -m.gap - m.uncertainty;
        match all.iter().max_by(|a, b| depth(a).total_cmp(&depth(b))) {
            Some(m) if !matches!(gap, Gap::Interference) && !(depth(m) <= TOUCHING * size) => {
                return Err(InterfaceError::Overlap {
                    point: m.point.into(),
                    depth: -m.gap,
                    spacing: m.spacing,
                });
            }
            _ => {}
        }
        for (pair, drawn) in pairs.iter_mut().zip(&self.drawn.gaps) {
            pair.gap = gap.kept(*drawn) * norm(pair.normal);
        }
        Ok(())
    }
}

/// Rejects surfaces with a common refinement that are too far apart, or overlap too much, for a given gap.
pub(super) fn check_distances(points: &[Vector], facing: &[&Facing]) -> Result<(), InterfaceError> {
    let excess = |f: &Facing| f.gap.abs() - matching::TOLERANCE * f.spacing - f.sagitta;
    let worst =
        facing.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)).then(a.nodes[0].cmp(&b.nodes[0])));
    match worst.filter(|f| !(excess(f) <= 0.0)) {
        Some(f) => {
            Err(InterfaceError::Distance { point: points[f.nodes[0]].into(), gap: f.gap, spacing: f.spacing })
        }
        None => Ok(()),
    }
}

//! The vocabulary of contact: bodies, obstacles, pairs of nodes, normals, gaps, lengths and areas. Another crate finds them, from meshes.
//!
//! Its types have a [`Space`] as parameter. Arc lengths, clamped ends and friction are those of the plane.

mod area;
mod bonds;
mod clamped_ends;
mod clamped_pairs;
mod error;
mod friction;
mod interpolation;
mod obstacle;
mod partner;
mod problem;
mod profile;
mod quadratic;
mod radial;
mod roles;
mod side;

use crate::body::Body;
use crate::boundary::ScalarData;
use crate::geometry::{Coordinates, Vector, norm};
use crate::mesh::id::{FacetId, NodeId};
use crate::space::{Item, Plane, Space};
use clamped_ends::UntrimmedLine;
use std::ops::{Add, Mul};

pub use crate::rigid_line::RigidLine;
pub use area::{ContactArea, ContactPatch};
pub use bonds::{BondError, Bonds, Part};
pub use clamped_ends::Line;
pub use clamped_pairs::{ClampedCorner, ClampedPair};
pub use error::InterfaceError;
pub use friction::{Friction, PairRow, SlipBefore};
pub use obstacle::Obstacle;
pub use partner::Partner;
pub use problem::{ContactPair, ContactProblem, ContactState, LeftOut, LoadFactorError, PairState};
pub use profile::Profile;
pub use radial::Radial;
pub use roles::Roles;
pub use side::{InterfaceSide, Retained};

/// Normals whose difference is shorter are the same, to round-off.
pub const SAME_NORMAL: f64 = 1e-12;

/// Two facing nodes, one of each body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodePair<S: Space = Plane> {
    /// Node of the first and of the second body; against an obstacle the number of the pair instead of the second. A node at a corner at which one
    /// stretch ends and another begins is in two pairs.
    pub nodes: [NodeId; 2],
    /// Normal `n` out of the first body, into the second. Its length is one at the nodes of the first meshes. Between these the
    /// normal is linear, so it is shorter if the line is bent. If one side is a declared arc, or a solid touches a sphere or a cylinder, it is the arm
    /// from the centre over the radius.
    pub normal: S::Vector,
    /// Initial gap `g`, m: the distance along the normal times `|n|`; negative if the bodies are to interfere (a press fit).
    pub gap: f64,
    /// Tributary length or area `ℓ = ∫ φ ds`, m or m².
    pub weight: f64,
}

impl<S: Space> NodePair<S> {
    /// Returns the length of the normal. Distances along it are gaps, openings and slips over that length; tractions are pressures and
    /// friction times that length.
    pub fn normal_length(&self) -> f64 {
        let length = norm(self.normal);
        // Exactly one, but for round-off, at the nodes of the first meshes.
        if (length - 1.0).abs() <= SAME_NORMAL { 1.0 } else { length }
    }

    /// Returns the gap as a vector along the normal, `G = g n/|n|²`, m. Between pairs it is linear, and the gap is `G·n`.
    ///
    /// A gap that is linear itself would be wider than that between two pairs if the normal turns: surfaces that are pressed together all along
    /// would overlap on every facet by as much as they deform.
    pub fn gap_vector(&self) -> S::Vector {
        self.normal * (self.gap / self.normal.times(&self.normal))
    }
}

/// Two facing facets, one of each body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactFacet<S: Space = Plane> {
    /// The pairs at its corners, in the plane in the sense of increasing arc length. A clamped corner has the number of another pair: of another corner,
    /// unless all corners are clamped.
    pub pairs: S::Axes<u32>,
    /// The facet of each body's mesh; against an obstacle the body's facet twice.
    pub facets: [FacetId; 2],
    /// Length or area on the body that was the first when the surfaces were paired, m or m².
    pub measure: f64,
    /// True if the normal changes along it by more than round-off.
    pub bent: bool,
    /// Its corners at which both bodies are clamped, or the body against an obstacle.
    pub clamped: S::Axes<Option<ClampedCorner<S>>>,
}

impl<S: Space> ContactFacet<S> {
    /// Returns the openings at its corners, m.
    ///
    /// * `by_pair`: opening of each pair, m.
    pub fn openings(&self, by_pair: &[f64]) -> S::Axes<f64> {
        S::axes(|k| self.clamped[k].map_or(by_pair[self.pairs[k] as usize], |clamped| clamped.opening))
    }

    /// The number of edges of a facet: one in the plane, three of a triangle.
    pub const EDGES: usize = S::DIM * (S::DIM - 1) / 2;

    /// Lists the edges by the corners at their ends: in the plane the edge itself, and 01, 02, 12 of a triangle.
    pub fn edges() -> impl Iterator<Item = [usize; 2]> {
        (0..S::DIM).flat_map(|i| (i + 1..S::DIM).map(move |j| [i, j]))
    }

    /// Lists the means of the openings at the ends of each edge, m: the middle coefficients of a linear opening.
    ///
    /// * `by_pair`: opening of each pair, m.
    pub fn mean_openings(&self, by_pair: &[f64]) -> impl Iterator<Item = f64> + use<S> {
        let openings = self.openings(by_pair);
        Self::edges().map(move |[i, j]| 0.5 * (openings[i] + openings[j]))
    }

    /// Lists the corners that are pairs, by number: all, or those that are not clamped.
    pub fn free_corners(&self) -> impl Iterator<Item = usize> + use<S> {
        let clamped = self.clamped;
        (0..S::DIM).filter(move |corner| clamped[*corner].is_none())
    }

    /// Computes `∫ a φ ds` with a linear `a` and the shape function of a corner: by the mass matrix `ℓ/6 (1 + δ)` of an edge, `A/12 (1 + δ)` of a
    /// triangle.
    ///
    /// * `values`: of `a` at the corners.
    pub fn moment<T: Item + Add<Output = T> + Mul<f64, Output = T>>(
        &self,
        values: &S::Axes<T>,
        corner: usize,
    ) -> T {
        let others = (0..S::DIM).filter(|other| *other != corner);
        let sum = others.fold(values[corner] * 2.0, |sum, other| sum + values[other]);
        sum * (self.measure / (S::DIM * (S::DIM + 1)) as f64)
    }

    /// Computes `∫ p o ds` of a linear pressure and a linear opening, J/m in the plane, J in space: with the mass matrix of [`Self::moment`].
    ///
    /// * `pressure`, `opening`: at the corners, Pa and m.
    pub(crate) fn flat_work(&self, pressure: &S::Axes<f64>, opening: &S::Axes<f64>) -> f64 {
        let at = |corner: usize| {
            let others = (0..S::DIM).filter(|other| *other != corner);
            pressure[corner] * others.fold(2.0 * opening[corner], |sum, other| sum + opening[other])
        };
        self.measure / (S::DIM * (S::DIM + 1)) as f64
            * (1..S::DIM).fold(at(0), |sum, corner| sum + at(corner))
    }
}

impl ContactFacet {
    /// Computes `∫ p o ds`, J/m.
    ///
    /// If the edge is straight, both factors are linear: `ℓ/6 (2 p_i o_i + p_i o_j + p_j o_i + 2 p_j o_j)`. If it is bent, the
    /// pressure is constant and the opening a quadratic with the Bernstein coefficients `o_i, o_m, o_j`: `ℓ p (o_i + o_m + o_j)/3`.
    ///
    /// * `pressure`: see [`ContactInterface::pressure`]; `opening`: at its ends, m; `middle`: see [`ContactInterface::middle_opening`].
    pub fn work(&self, pressure: [f64; 2], opening: [f64; 2], middle: f64) -> f64 {
        if self.bent {
            let ([p, _], [o, r]) = (pressure, opening);
            return self.measure / 3.0 * p * (o + middle + r);
        }
        self.flat_work(&pressure, &opening)
    }
}

/// How the initial gap is defined.
#[derive(Clone, Debug)]
pub enum Gap<S: Space = Plane> {
    /// Zero, because the surfaces touch: surfaces that are apart or overlap by more than 1e-6 of the smaller body's
    /// diagonal are rejected. On curved lines smooth curves through the nodes are compared, as for [`Gap::Geometric`].
    Touching,
    /// Given: it overrides the gap of the meshes, whose surfaces must coincide to 5 % of the edges. A negative one is an interference.
    Given(ScalarData<S>),
    /// Measured between the paired nodes along the contact normal, ≥ 0: the surfaces are paired along their length,
    /// node by node, whatever their distance. An overlap of more than 1e-6 of the smaller body's diagonal is rejected.
    /// Finer meshes measure the gap at new nodes between smooth curves through the nodes of the first meshes.
    Geometric,
    /// Measured like [`Self::Geometric`], but an overlap that is drawn is kept: a negative gap, the interference of a press fit.
    Interference,
    /// None: the surfaces touch as for [`Gap::Touching`] and are bonded, see [`Bonds`].
    Bonded {
        /// The displacement of the first body less that of the second, m.
        offset: S::Vector,
    },
}

impl<S: Space> Gap<S> {
    /// Tells whether the gap is the distance of the drawn surfaces.
    pub fn is_measured(&self) -> bool {
        matches!(self, Self::Geometric | Self::Interference)
    }

    /// Tells whether the surfaces are bonded.
    pub fn is_bonded(&self) -> bool {
        matches!(self, Self::Bonded { .. })
    }

    /// Returns the gap for a measured distance, m: an overlap is closed, unless it is to be kept.
    pub fn kept(&self, distance: f64) -> f64 {
        if matches!(self, Self::Interference) { distance } else { distance.max(0.0) }
    }
}

/// The largest difference between the gap in use and the drawn one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapChange<S: Space = Plane> {
    /// The first body's node.
    pub point: S::Vector,
    /// Distance of the surfaces along the normal, m, negative if they overlap; on curved lines measured between smooth curves.
    pub drawn: f64,
    /// The gap used instead, m.
    pub used: f64,
}

/// A matching contact interface: pairs of nodes, in the plane ordered by arc length, and the facets between them.
#[derive(Clone, Debug)]
pub struct ContactInterface<S: Space = Plane> {
    pairs: Vec<NodePair<S>>,
    facets: Vec<ContactFacet<S>>,
    /// Pairs that have no unknown.
    clamped: Vec<ClampedPair<S>>,
    /// True if the normal changes along any facet.
    bent: bool,
    /// The source of the gap, and the body on whose surface gap, arc lengths and lengths are measured.
    gap: Gap<S>,
    /// The gaps of the pairs are this part of the gap.
    gap_factor: f64,
    measured_on: usize,
    /// The arc length at each pair, m. Empty in space.
    arc_lengths: Vec<f64>,
    /// The measured gap along each edge, if it is not linear there. Empty in space.
    profiles: Vec<Option<Profile>>,
    gap_change: Option<GapChange<S>>,
    /// The source of the normals, if it is an arc. `None` in space.
    radial: Option<Radial>,
    /// The line with the pairs and edges that were removed at its ends, if any. `None` in space.
    whole: Option<Box<UntrimmedLine>>,
}

impl<S: Space> ContactInterface<S> {
    /// Takes pairs and the facets between them, without arc lengths; a line of the plane is a [`Line`].
    pub fn new(pairs: Vec<NodePair<S>>, facets: Vec<ContactFacet<S>>, gap: Gap<S>) -> Self {
        Self {
            bent: facets.iter().any(|facet| facet.bent),
            pairs,
            facets,
            clamped: Vec::new(),
            gap,
            gap_factor: 1.0,
            measured_on: 0,
            arc_lengths: Vec::new(),
            profiles: Vec::new(),
            gap_change: None,
            radial: None,
            whole: None,
        }
    }

    /// Notes the difference between the gap and the distance of the paired meshes, see [`Self::gap_change`].
    #[must_use]
    pub fn with_gap_change(self, gap_change: Option<GapChange<S>>) -> Self {
        Self { gap_change, ..self }
    }

    /// Returns the source of the gap.
    pub fn gap(&self) -> &Gap<S> {
        &self.gap
    }

    /// Returns the part of the gap that the pairs have: the factor of a load step, else 1.
    pub fn gap_factor(&self) -> f64 {
        self.gap_factor
    }

    /// Notes the part of the gap that the pairs have, see [`Self::gap_factor`].
    #[must_use]
    pub fn with_gap_factor(self, gap_factor: f64) -> Self {
        Self { gap_factor, ..self }
    }

    /// Multiplies the gaps of all pairs.
    #[must_use]
    pub(crate) fn scaled_gap(mut self, factor: f64) -> Self {
        let clamped = self.clamped.iter_mut().map(|of| &mut of.pair);
        self.pairs.iter_mut().chain(clamped).for_each(|pair| pair.gap *= factor);
        let line = self.whole.iter_mut().flat_map(|whole| &mut whole.line.pairs);
        line.for_each(|pair| pair.gap *= factor);
        self.gap_factor *= factor;
        self
    }

    /// Returns the pairs, in the plane by increasing arc length.
    pub fn pairs(&self) -> &[NodePair<S>] {
        &self.pairs
    }

    /// Returns the facets between pairs.
    pub fn facets(&self) -> &[ContactFacet<S>] {
        &self.facets
    }

    /// Lists the normals that a body retains as interface unknowns: one per contact node, in the order of the pairs.
    ///
    /// * `side`: 0 for the first body, 1 for the second.
    pub fn side(&self, side: usize) -> InterfaceSide<S> {
        InterfaceSide::default().with_block(self.retained(side))
    }

    /// Lists the directions of [`Self::side`].
    fn retained(&self, side: usize) -> impl Iterator<Item = Retained<S>> + '_ {
        self.pairs.iter().map(move |pair| Retained { node: pair.nodes[side], direction: pair.normal })
    }

    /// Returns the largest difference between the gap and the distance of the paired meshes; `None` if it is
    /// round-off, and on refined meshes.
    pub fn gap_change(&self) -> Option<GapChange<S>> {
        self.gap_change
    }

    /// Computes the length or area of contact, m or m².
    pub fn measure(&self) -> f64 {
        self.facets.iter().map(|e| e.measure).sum()
    }

    /// Applies the consistent interface mass matrix, `(M p)_i = ∫ p φ_i ds`; P1 `p` in Pa gives N/m.
    ///
    /// # Panics
    /// If `p` does not have one entry per pair.
    pub fn mass(&self, p: &[f64]) -> Vec<f64> {
        let (found, expected) = (p.len(), self.pairs.len());
        assert!(found == expected, "the pressure has {found} entries, the interface {expected} pairs");
        let mut forces = vec![0.0; self.pairs.len()];
        for facet in &self.facets {
            let corners = self.corners(facet, p);
            for corner in facet.free_corners() {
                forces[facet.pairs[corner] as usize] += facet.moment(&corners, corner);
            }
        }
        forces
    }

    /// Tells whether no pair was removed because both bodies clamp it.
    pub fn is_whole(&self) -> bool {
        self.whole.is_none() && self.clamped.is_empty()
    }

    /// Tells whether the normal changes along any facet.
    pub fn has_bent_facets(&self) -> bool {
        self.bent
    }

    /// Computes the nodal forces `∫ p n φ_i ds` of a pressure given at the corners of every facet, Cartesian, N/m: exact
    /// if `p n` is linear along the facet, that is, if `p` or `n` is constant.
    ///
    /// # Panics
    /// If `facet_pressure` does not have one entry per contact facet.
    pub fn pressure_forces(&self, facet_pressure: &[S::Axes<f64>]) -> Vec<S::Vector> {
        let (found, expected) = (facet_pressure.len(), self.facets.len());
        assert!(found == expected, "the pressure has {found} entries, the interface {expected} facets");
        let mut forces = vec![S::Vector::ZERO; self.pairs.len()];
        for (facet, p) in self.facets.iter().zip(facet_pressure) {
            let corners = S::axes(|k| self.corner_pair(facet, k).normal * p[k]);
            for corner in facet.free_corners() {
                forces[facet.pairs[corner] as usize] += facet.moment(&corners, corner);
            }
        }
        forces
    }

    /// Replaces the gaps of the pairs, m, and returns the old ones: the problem for increments about a state.
    ///
    /// # Panics
    /// If there is not one gap per pair.
    pub fn replace_gaps(&mut self, gaps: &[f64]) -> Vec<f64> {
        let (found, expected) = (gaps.len(), self.pairs.len());
        assert!(found == expected, "{found} gaps are given, the interface has {expected} pairs");
        self.pairs.iter_mut().zip(gaps).map(|(pair, gap)| std::mem::replace(&mut pair.gap, *gap)).collect()
    }
}

impl ContactInterface {
    /// Returns the arc length at each pair along the surface of the body that was the first when they were paired, m; stretches are consecutive.
    pub fn arc_lengths(&self) -> &[f64] {
        &self.arc_lengths
    }

    /// Notes the arc from which all normals come.
    #[must_use]
    pub fn with_radial(self, radial: Option<Radial>) -> Self {
        Self { radial, ..self }
    }

    /// Returns the declared arc from which all normals come; `None` if they do not come from one.
    pub fn radial(&self) -> Option<Radial> {
        self.radial
    }

    /// Returns the side on whose surface gap, arc lengths and lengths are measured, 0 or 1.
    pub fn measured_on(&self) -> usize {
        self.measured_on
    }

    /// Returns the centre of the declared arc from which all normals come; `None` if they do not come from one.
    pub fn centre(&self) -> Option<Vector> {
        self.radial.map(|radial| radial.centre)
    }

    /// Computes the normals of the polygon of one side at the pairs: means of its edge normals, weighted by length, out of the first body,
    /// of length one.
    ///
    /// * `body`: the one of this side, 0 or 1.
    pub(crate) fn polygon_normals(&self, body: &Body, side: usize) -> Vec<Vector> {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let mut sums = vec![Vector::zeros(); self.pairs.len()];
        for edge in &self.facets {
            let weighted = sign
                * body.mesh().facet_measure(edge.facets[side])
                * body.mesh().facet_normal(edge.facets[side]);
            edge.free_corners().for_each(|end| sums[edge.pairs[end] as usize] += weighted);
        }
        sums.into_iter().map(|sum| 1.0 / norm(sum) * sum).collect()
    }

    /// Computes the middle Bernstein coefficient of the opening along an edge, m:
    /// `½(G_i·n_j + G_j·n_i) − ½([u]_i·n_j + [u]_j·n_i)`, see [`NodePair::gap_vector`]. The opening `(G − [u])·n` is quadratic if `n`
    /// changes; its other two coefficients are the nodal openings. If all three are ≥ 0, so is the opening.
    ///
    /// * `jump`: `[u] = u¹ − u²` of a pair, m.
    pub fn middle_opening(&self, edge: &ContactFacet, jump: impl Fn(usize) -> Vector) -> f64 {
        let [i, j] = edge.pairs.map(|k| k as usize);
        let (a, b) = (&self.pairs[i], &self.pairs[j]);
        let open = [a.gap_vector() - jump(i), b.gap_vector() - jump(j)];
        0.5 * (open[0].dot(&b.normal) + open[1].dot(&a.normal))
    }
}

//! Laws of friction along a pair: data alone.

use super::{ContactFacet, ContactPair, InterfaceError, NodePair};
use crate::body::{Body, Difference, DifferenceSum};
use crate::boundary::ScalarData;
use crate::geometry::{Coordinates, norm};
use crate::mesh::id::NodeId;
use crate::space::{Plane, Space};

/// The law of friction of a pair: what the friction `q` (Pa) can resist. In the plane it acts along the tangent `t = (−n_y, n_x)` against the slip
/// `w = (u^a − u^b)·t`, with traction `−q t` on the first body and `+q t` on the second. In space `q` and `w` are vectors in the tangential plane,
/// `|q|` is a length, and `q w` a product of vectors.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Friction<S: Space = Plane> {
    /// None: the surfaces slide freely.
    #[default]
    None,
    /// Tresca: `|q| ≤ s` and `q w = s|w|`, with a given limit. It acts on open contact as well.
    Tresca {
        /// `s ≥ 0`, Pa, evaluated at the nodes of the first body.
        limit: ScalarData<S>,
    },
    /// Coulomb: `|q| ≤ μ p` and `q w = μ p|w|`, with the contact pressure `p`.
    Coulomb {
        /// `μ ≥ 0`, dimensionless.
        mu: f64,
    },
}

impl<S: Space> Friction<S> {
    /// Creates the law of Tresca with a limit in Pa, a number or a function of the position.
    pub fn tresca(limit: impl Into<ScalarData<S>>) -> Self {
        Self::Tresca { limit: limit.into() }
    }

    /// Tells whether there is a law of friction, even one that allows none.
    pub fn acts(&self) -> bool {
        !matches!(self, Self::None)
    }

    /// Returns the coefficient of Coulomb's law, if it is that.
    pub fn coulomb(&self) -> Option<f64> {
        match self {
            Self::Coulomb { mu } => Some(*mu),
            Self::None | Self::Tresca { .. } => None,
        }
    }
}

/// The slip `w₀` that earlier load steps left on a contact surface: the next step has the law of friction for `w − w₀`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SlipBefore<S: Space = Plane> {
    /// In each row along a tangent, m, in the order of [`ContactPair::rows`].
    pub rows: Vec<f64>,
    /// The displacement of the first side less that of the second at the corners of each contact facet, m: its tangential part counts.
    pub jumps: Vec<S::Axes<S::Vector>>,
}

impl<S: Space> SlipBefore<S> {
    /// Takes slips in the rows, and jumps at the corners of the contact facets, m.
    pub fn new(rows: Vec<f64>, jumps: Vec<S::Axes<S::Vector>>) -> Self {
        Self { rows, jumps }
    }

    pub(super) fn check(&self, pair: &ContactPair<S>) -> Result<(), InterfaceError> {
        let interface = &pair.interface;
        let rows = self.rows.iter().filter(|w| w.is_finite()).count();
        let is_finite = |jumps: &&S::Axes<S::Vector>| {
            jumps.as_ref().iter().flat_map(Coordinates::entries).all(|w| w.is_finite())
        };
        let facets = self.jumps.iter().filter(is_finite).count();
        let both = [
            ("rows along tangents", rows, self.rows.len(), pair.row_count() - interface.pairs().len()),
            (S::WORDS.facets, facets, self.jumps.len(), interface.facets().len()),
        ];
        match both.into_iter().find(|(_, finite, all, expected)| finite != expected || all != expected) {
            Some((of, found, _, expected)) => Err(InterfaceError::BadSlip { of, found, expected }),
            None => Ok(()),
        }
    }
}

/// A row of a pair: one direction at one pair of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PairRow<S: Space = Plane> {
    /// Number of the pair of nodes.
    pub pair: usize,
    /// Its nodes, see [`super::NodePair::nodes`].
    pub nodes: [NodeId; 2],
    /// Normal or tangent, of the length of the pair's normal.
    pub direction: S::Vector,
}

impl<S: Space> ContactPair<S> {
    /// Counts the rows, see [`Self::rows`].
    pub fn row_count(&self) -> usize {
        let nodes = self.interface.pairs().len();
        if self.friction.acts() { S::DIM * nodes } else { nodes }
    }

    /// Lists the rows: the normals of all pairs of nodes and then, with friction, the first tangents of all, in space then the second ones.
    pub fn rows(&self) -> impl Iterator<Item = PairRow<S>> + '_ {
        let directions = if self.friction.acts() { S::DIM } else { 1 };
        (0..directions).flat_map(move |k| {
            let pairs = self.interface.pairs().iter().enumerate();
            pairs.map(move |(pair, of)| {
                let direction = if k == 0 { of.normal } else { self.tangents(pair).as_ref()[k - 1] };
                PairRow { pair, nodes: of.nodes, direction }
            })
        })
    }

    /// Returns the directions of friction at a pair of nodes, of the length of its normal and perpendicular to each other: in the plane `(−n_y, n_x)`, in
    /// space two, then zeros. On flat surfaces they are the same at all pairs.
    pub fn tangents(&self, pair: usize) -> S::Axes<S::Vector> {
        let pairs = self.interface.pairs();
        self.tangents_across(pairs[if self.has_own_tangents() { pair } else { 0 }].normal)
    }

    /// Tells whether each pair of nodes has tangents of its own: normals that differ by rounding may have others.
    fn has_own_tangents(&self) -> bool {
        S::ONE_TANGENT || self.interface.has_bent_facets()
    }

    /// Returns the tangents across a normal, of its length.
    fn tangents_across(&self, normal: S::Vector) -> S::Axes<S::Vector> {
        let found = S::complement(&[normal]);
        let size = norm(normal);
        let scaled = |k: usize| {
            let own = norm(found.as_ref()[k]);
            if own > 0.0 { found.as_ref()[k] * (size / own) } else { found.as_ref()[k] }
        };
        S::axes(scaled)
    }

    /// Returns [`Self::tangents`] at a corner of a facet, clamped or not.
    pub fn corner_tangents(&self, facet: &ContactFacet<S>, corner: usize) -> S::Axes<S::Vector> {
        let pairs = self.interface.pairs();
        match facet.clamped[corner] {
            None => self.tangents(facet.pairs[corner] as usize),
            Some(_) if !self.has_own_tangents() && !pairs.is_empty() => self.tangents(0),
            Some(_) => self.tangents_across(self.interface.corner_pair(facet, corner).normal),
        }
    }

    /// Returns the vector of values along the tangents of a pair of nodes.
    ///
    /// * `rows`: one value per row along a tangent.
    pub fn along_tangents(&self, pair: usize, rows: &[f64]) -> S::Vector {
        let values = rows[pair..].iter().step_by(self.interface.pairs().len().max(1));
        self.tangents(pair).as_ref().iter().zip(values).map(|(tangent, value)| *tangent * *value).sum()
    }

    /// Lists the parts of a vector along the tangents of a pair of nodes, times their length.
    pub fn tangential_parts(&self, pair: usize, vector: S::Vector) -> impl Iterator<Item = f64> + use<S> {
        let tangents = self.tangents(pair);
        (0..S::DIM - 1).map(move |k| tangents.as_ref()[k].times(&vector))
    }

    /// Evaluates the limit of Tresca's law at each pair of nodes, Pa, for friction along `t`: over the length of the normal. `None` for
    /// other laws.
    ///
    /// * `first`: the first body of the pair.
    pub fn friction_limit(&self, first: &Body<S>) -> Option<Vec<f64>> {
        let Friction::Tresca { limit } = &self.friction else { return None };
        let points = first.mesh().points();
        let at = |pair: &NodePair<S>| limit.at(points[pair.nodes[0]]) / pair.normal_length();
        Some(self.interface.pairs().iter().map(at).collect())
    }
}

impl<S: Space> ContactPair<S> {
    /// Measures the difference between the limit of Tresca's law and its interpolant between the nodes, relative to its
    /// largest value; `None` for other laws, or if the two are equal to round-off.
    ///
    /// * `first`: the first body of the pair.
    pub fn interpolated_limit(&self, first: &Body<S>) -> Option<Difference> {
        let Friction::Tresca { limit } = &self.friction else { return None };
        let points = first.mesh().points();
        let samples = S::facet_samples();
        let sum = DifferenceSum::of(self.interface.facets(), |sum, facet| {
            let corners = S::axes(|k| points[self.interface.pairs()[facet.pairs[k] as usize].nodes[0]]);
            let values = S::axes(|k| limit.at(corners[k]));
            sum.facet::<S>(&samples, (&corners, &values), |point| limit.at(point));
        });
        sum.difference()
    }
}

impl<S: Space> ContactPair<S> {
    /// Checks the data of the law of friction, and whether its surfaces can have one.
    pub(super) fn check_friction(&self, first: &Body<S>) -> Result<(), InterfaceError> {
        if let Some(value) = self.friction.coulomb().filter(|mu| !(*mu >= 0.0 && mu.is_finite())) {
            return Err(InterfaceError::BadFrictionCoefficient { value });
        }
        let limits = self.friction_limit(first).unwrap_or_default();
        match self.interface.pairs().iter().zip(limits).find(|(_, s)| !(*s >= 0.0 && s.is_finite())) {
            Some((pair, value)) => {
                let point = first.mesh().points()[pair.nodes[0]];
                Err(InterfaceError::BadFrictionLimit {
                    point: point.into(),
                    value: value * pair.normal_length(),
                })
            }
            None => Ok(()),
        }
    }
}

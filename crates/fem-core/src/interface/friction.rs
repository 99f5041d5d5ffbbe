//! Laws of friction along a pair: data alone.

use super::{ContactInterface, ContactPair, InterfaceError, NodePair};
use crate::body::{Body, Difference, DifferenceSum};
use crate::boundary::ScalarData;
use crate::mesh::id::NodeId;
use crate::space::{Plane, Space};

/// The law of friction of a pair: what the friction `q` (Pa) can resist. Friction acts along the tangent `t = (−n_y, n_x)` against the slip
/// `w = (u^a − u^b)·t`, with traction `−q t` on the first body and `+q t` on the second.
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

/// The slip `w₀` that earlier load steps left on a contact line: the next step has the law of friction for `w − w₀`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SlipBefore {
    /// At each pair of nodes, m.
    pub nodes: Vec<f64>,
    /// Bernstein coefficients along each contact edge: at its first end, in the middle, at its second end, m.
    pub edges: Vec<[f64; 3]>,
}

impl SlipBefore {
    /// Takes slips at the pairs of nodes and along the contact edges, m.
    pub fn new(nodes: Vec<f64>, edges: Vec<[f64; 3]>) -> Self {
        Self { nodes, edges }
    }

    pub(super) fn check(&self, interface: &ContactInterface) -> Result<(), InterfaceError> {
        let nodes = self.nodes.iter().filter(|w| w.is_finite()).count();
        let edges = self.edges.iter().filter(|w| w.iter().all(|w| w.is_finite())).count();
        let both = [
            ("pairs of nodes", nodes, self.nodes.len(), interface.pairs().len()),
            ("edges", edges, self.edges.len(), interface.facets().len()),
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

    /// Lists the rows: the normals of all pairs of nodes and then, with friction, their tangents, in the plane `t = (−n_y, n_x)`.
    pub fn rows(&self) -> impl Iterator<Item = PairRow<S>> + '_ {
        let directions = if self.friction.acts() { S::DIM } else { 1 };
        (0..directions).flat_map(move |k| {
            let along = move |normal| if k == 0 { normal } else { S::complement(&[normal])[k - 1] };
            let pairs = self.interface.pairs().iter().enumerate();
            pairs.map(move |(pair, of)| PairRow { pair, nodes: of.nodes, direction: along(of.normal) })
        })
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

impl ContactPair {
    /// Checks the data of the law of friction.
    pub(super) fn check_friction(&self, first: &Body) -> Result<(), InterfaceError> {
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

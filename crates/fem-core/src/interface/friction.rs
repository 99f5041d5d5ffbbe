//! Laws of friction along a pair: data alone.

use super::{ContactPair, InterfaceError};
use crate::body::Body;
use crate::boundary::ScalarData;
use crate::geometry::{Vector, perpendicular};
use crate::mesh::id::NodeId;

/// The law of friction of a pair: what the friction `q` (Pa) can resist. Friction acts along the tangent `t = (−n_y, n_x)` against the slip
/// `w = (u^a − u^b)·t`, with traction `−q t` on the first body and `+q t` on the second.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Friction {
    /// None: the surfaces slide freely.
    #[default]
    None,
    /// Tresca: `|q| ≤ s` and `q w = s|w|`, with a given limit. It acts where the contact is open as well.
    Tresca {
        /// `s ≥ 0`, Pa, evaluated at the nodes of the first body.
        limit: ScalarData,
    },
    /// Coulomb: `|q| ≤ μ p` and `q w = μ p|w|`, with the contact pressure `p`.
    Coulomb {
        /// `μ ≥ 0`, dimensionless.
        mu: f64,
    },
}

impl Friction {
    /// Creates the law of Tresca with a limit in Pa, a number or a function of the position.
    pub fn tresca(limit: impl Into<ScalarData>) -> Self {
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

/// A row of a pair: one direction at one pair of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactRow {
    /// Number of the pair of nodes.
    pub pair: usize,
    /// Its nodes, see [`super::NodePair::nodes`].
    pub nodes: [NodeId; 2],
    /// Normal or tangent, of length one.
    pub direction: Vector,
}

impl ContactPair {
    /// Counts the rows, see [`Self::rows`].
    pub fn row_count(&self) -> usize {
        let nodes = self.interface.pairs().len();
        if self.friction.acts() { 2 * nodes } else { nodes }
    }

    /// Lists the rows: the normals of all pairs of nodes and then, with friction, their tangents `t = (−n_y, n_x)`.
    pub fn rows(&self) -> impl Iterator<Item = ContactRow> + '_ {
        let along = move |direction: fn(Vector) -> Vector| {
            let pairs = self.interface.pairs().iter().enumerate();
            pairs.map(move |(pair, of)| ContactRow { pair, nodes: of.nodes, direction: direction(of.normal) })
        };
        let tangents = self.friction.acts().then(|| along(perpendicular));
        along(|normal| normal).chain(tangents.into_iter().flatten())
    }

    /// Evaluates the limit of Tresca's law at each pair of nodes, Pa; `None` for other laws.
    ///
    /// * `first`: the first body of the pair.
    pub fn friction_limit(&self, first: &Body) -> Option<Vec<f64>> {
        let Friction::Tresca { limit } = &self.friction else { return None };
        let points = first.mesh().points();
        Some(self.interface.pairs().iter().map(|pair| limit.at(points[pair.nodes[0]])).collect())
    }

    /// Checks the data of the law of friction.
    pub(super) fn check_friction(&self, first: &Body) -> Result<(), InterfaceError> {
        if let Some(value) = self.friction.coulomb().filter(|mu| !(*mu >= 0.0 && mu.is_finite())) {
            return Err(InterfaceError::BadFrictionCoefficient { value });
        }
        let limits = self.friction_limit(first).unwrap_or_default();
        match self.interface.pairs().iter().zip(limits).find(|(_, s)| !(*s >= 0.0 && s.is_finite())) {
            Some((pair, value)) => {
                let point = first.mesh().points()[pair.nodes[0]];
                Err(InterfaceError::BadFrictionLimit { point, value })
            }
            None => Ok(()),
        }
    }
}

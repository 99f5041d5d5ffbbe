//! A datum of a case: a number, an expression, or values at nodes.

use super::{Expression, NodalData, NodalFunction};
use fem_core::boundary::ScalarData;
use fem_core::space::Space;
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// A number, an expression in the coordinates, or values at nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// The same everywhere.
    Number(f64),
    /// To be evaluated at points.
    Expression(Expression),
    /// Given by a program, before the nodes are known; no text of a case file makes it.
    Given(Given),
    /// Given by a program, at the nodes of a side.
    Nodal(NodalData),
}

/// Data that a program gives for a key, see [`crate::Case::read_mesh_files`].
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    pub(crate) key: String,
    pub(crate) data: AtNodes,
}

/// Data at nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum AtNodes {
    /// One value for each node of the body's mesh.
    Values(Arc<[f64]>),
    /// A function of their coordinates.
    Function(NodalFunction),
}

impl Value {
    /// Makes fem-core's datum of a value. An expression without coordinates is a number.
    pub fn scalar<S: Space>(&self) -> ScalarData<S> {
        match self {
            Self::Number(number) => (*number).into(),
            Self::Expression(expression) if expression.is_constant() => expression.at([0.0; 3]).into(),
            Self::Expression(expression) => {
                let expression = expression.clone();
                ScalarData::Function(Arc::new(move |point| expression.at(point)))
            }
            Self::Given(_) => ScalarData::Function(Arc::new(|_| f64::NAN)),
            Self::Nodal(data) => {
                let data = data.clone();
                // Only the plane has such data.
                ScalarData::Function(Arc::new(move |point: S::Vector| data.at([point[0], point[1]])))
            }
        }
    }

    /// Returns the number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Expression(_) | Self::Given(_) | Self::Nodal(_) => None,
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            // Zero has one sign here, so that `-0.0` is the same case.
            Self::Number(number) => serializer.serialize_f64(number + 0.0),
            Self::Expression(expression) => serializer.serialize_str(expression.text()),
            Self::Given(given) => serializer.collect_map([("given", &given.key)]),
            // By its contents, which name the case.
            Self::Nodal(data) => serializer.collect_map([("nodal", data.digest())]),
        }
    }
}

impl Default for Value {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

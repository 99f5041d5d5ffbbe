//! A datum of a case: a number, an expression, or values at nodes.

use super::{Expression, NodalData};
use fem_core::boundary::ScalarData;
use serde::{Serialize, Serializer};

/// A number, an expression in `x` and `y`, or values at nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// The same everywhere.
    Number(f64),
    /// To be evaluated at points.
    Expression(Expression),
    /// Given by a program, see [`crate::Case::set_data`]; no text of a case file makes it.
    Nodal(NodalData),
}

impl Value {
    /// Makes fem-core's datum of a value. An expression without `x` and `y` is a number.
    pub fn scalar(&self) -> ScalarData {
        match self {
            Self::Number(number) => (*number).into(),
            Self::Expression(expression) if expression.is_constant() => expression.at([0.0; 2]).into(),
            Self::Expression(expression) => {
                let expression = expression.clone();
                ScalarData::function(move |point| expression.at(point))
            }
            Self::Nodal(data) => {
                let data = data.clone();
                ScalarData::function(move |point| data.at(point))
            }
        }
    }

    /// Returns the number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Expression(_) | Self::Nodal(_) => None,
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            // Zero has one sign here, so that `-0.0` is the same case.
            Self::Number(number) => serializer.serialize_f64(number + 0.0),
            Self::Expression(expression) => serializer.serialize_str(expression.text()),
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

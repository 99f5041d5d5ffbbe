//! A datum of a case: a number, or an expression.

use super::Expression;
use fem_core::boundary::ScalarData;
use serde::{Serialize, Serializer};

/// A number, or an expression in `x` and `y`.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// The same everywhere.
    Number(f64),
    /// To be evaluated at points.
    Expression(Expression),
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
        }
    }

    /// Returns the number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Expression(_) => None,
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            // Zero has one sign here, so that `-0.0` is the same case.
            Self::Number(number) => serializer.serialize_f64(number + 0.0),
            Self::Expression(expression) => serializer.serialize_str(expression.text()),
        }
    }
}

impl Default for Value {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

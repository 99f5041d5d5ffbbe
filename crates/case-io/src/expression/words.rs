//! The names and operators that expressions know.

use exmex::{BinOp, MakeOperators, Operator};

/// The functions that expressions know, with the number of their arguments. Angles are in radians.
pub const FUNCTIONS: [(&str, usize); 17] = [
    ("abs", 1),
    ("acos", 1),
    ("asin", 1),
    ("atan", 1),
    ("atan2", 2),
    ("cos", 1),
    ("cosh", 1),
    ("exp", 1),
    ("ln", 1),
    ("log10", 1),
    ("max", 2),
    ("min", 2),
    ("sin", 1),
    ("sinh", 1),
    ("sqrt", 1),
    ("tan", 1),
    ("tanh", 1),
];

/// Names of numbers.
pub(super) const NAMES: [&str; 3] = ["x", "y", "pi"];

/// The smaller of two numbers; NaN if one of them is.
fn min(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }
}

/// The larger of two numbers; NaN if one of them is.
fn max(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// What exmex is given to work with.
#[derive(Clone, Debug)]
pub(super) struct Words;

impl MakeOperators<f64> for Words {
    fn make<'a>() -> Vec<Operator<'a, f64>> {
        // Called commutative, operators of numbers would be drawn forward past their neighbours of the same priority.
        let binary =
            |name, prio, apply| Operator::make_bin(name, BinOp { apply, prio, is_commutative: false });
        let minus = BinOp { apply: |a, b| a - b, prio: 0, is_commutative: false };
        vec![
            binary("+", 0, |a, b| a + b),
            Operator::make_bin_unary("-", minus, |a: f64| -a),
            binary("*", 1, |a, b| a * b),
            binary("/", 1, |a, b| a / b),
            binary("^", 2, f64::powf),
            binary("min", 3, min),
            binary("max", 3, max),
            binary("atan2", 3, f64::atan2),
            Operator::make_unary("abs", f64::abs),
            Operator::make_unary("acos", f64::acos),
            Operator::make_unary("asin", f64::asin),
            Operator::make_unary("atan", f64::atan),
            Operator::make_unary("cos", f64::cos),
            Operator::make_unary("cosh", f64::cosh),
            Operator::make_unary("exp", f64::exp),
            Operator::make_unary("ln", f64::ln),
            Operator::make_unary("log10", f64::log10),
            Operator::make_unary("sin", f64::sin),
            Operator::make_unary("sinh", f64::sinh),
            Operator::make_unary("sqrt", f64::sqrt),
            Operator::make_unary("tan", f64::tan),
            Operator::make_unary("tanh", f64::tanh),
            Operator::make_constant("pi", std::f64::consts::PI),
        ]
    }
}

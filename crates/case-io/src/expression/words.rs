//! The names that expressions know.

/// A function, by the number of its arguments.
#[derive(Clone, Copy)]
pub(super) enum Function {
    One(fn(f64) -> f64),
    Two(fn(f64, f64) -> f64),
}

impl Function {
    /// Number of arguments.
    pub(super) const fn arity(self) -> usize {
        match self {
            Self::One(_) => 1,
            Self::Two(_) => 2,
        }
    }
}

/// Functions by name.
const TABLE: [(&str, Function); 17] = [
    ("abs", Function::One(f64::abs)),
    ("acos", Function::One(f64::acos)),
    ("asin", Function::One(f64::asin)),
    ("atan", Function::One(f64::atan)),
    ("atan2", Function::Two(f64::atan2)),
    ("cos", Function::One(f64::cos)),
    ("cosh", Function::One(f64::cosh)),
    ("exp", Function::One(f64::exp)),
    ("ln", Function::One(f64::ln)),
    ("log10", Function::One(f64::log10)),
    ("max", Function::Two(max)),
    ("min", Function::Two(min)),
    ("sin", Function::One(f64::sin)),
    ("sinh", Function::One(f64::sinh)),
    ("sqrt", Function::One(f64::sqrt)),
    ("tan", Function::One(f64::tan)),
    ("tanh", Function::One(f64::tanh)),
];

/// The functions that expressions know, with the number of their arguments. Angles are in radians.
pub const FUNCTIONS: [(&str, usize); TABLE.len()] = {
    let mut functions = [("", 0); TABLE.len()];
    let mut k = 0;
    while k < TABLE.len() {
        functions[k] = (TABLE[k].0, TABLE[k].1.arity());
        k += 1;
    }
    functions
};

/// The names of the coordinates; the plane has the first two.
pub const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// The name of a number.
pub(super) const PI: &str = "pi";

/// Joins names to a list for messages: `x and y`, `x, y and z`.
pub(crate) fn joined(names: &[&str]) -> String {
    match names {
        [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
        _ => names.concat(),
    }
}

/// Joins names in code quotes, each with a comma behind it: `` `x`, `y`, ``.
pub(crate) fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`, ")).collect()
}

/// Finds a function.
pub(super) fn function(name: &str) -> Option<Function> {
    TABLE.iter().find(|(known, _)| *known == name).map(|&(_, function)| function)
}

/// The smaller of two numbers; NaN if one of them is.
fn min(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }
}

/// The larger of two numbers; NaN if one of them is.
fn max(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

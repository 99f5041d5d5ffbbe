//! Words for messages: how keys are written, and what a value is.

use super::tree::NodeValue;
use crate::diagnostic::excerpt;

/// What an expression may hold.
pub(super) const EXPRESSION: &str = "numbers, `x`, `y`, `pi`, + - * / ^ and known functions";

/// Shows how a key is written, if every case writes it alike.
///
/// * `path`: the key with the tables above it.
pub(super) fn example(path: &str) -> Option<&'static str> {
    Some(match path.rsplit('.').next()? {
        "schema" => "schema = 1",
        "body" => "[[body]]",
        "contact" => "[contact]",
        "materials" => "[materials.steel]",
        "name" => "name = \"upper\"",
        "material" => "material = \"steel\"",
        "young" => "young = 210e9",
        "poisson" => "poisson = 0.3",
        "length" => "length = \"mm\"",
        "force" if path.starts_with("units") => "force = \"N\"",
        "thickness" => "thickness = 1.0",
        "surfaces" => "surfaces = [\"bottom\", \"top\"]",
        "bodies" => "bodies = [\"upper\", \"lower\"]",
        "friction" => "friction = { law = \"tresca\", limit = 4.0 }",
        "law" => "law = \"tresca\"",
        "limit" => "limit = 4.0",
        "mu" => "mu = 0.3",
        "normal" if path.contains("obstacle") => "normal = [0.0, 1.0]",
        "normal" if path.starts_with("contact") => "normal = [0.0, -1.0]",
        "normal" => "normal = 0.0",
        "on" => "on = \"top\"",
        "file" => "file = \"blocks.msh\"",
        "kind" if path.contains("obstacle") => "kind = \"plane\"",
        "point" => "point = [0.0, 0.0]",
        "centre" => "centre = [0.0, 0.0]",
        "radius" => "radius = 1.0",
        "obstacle" => "obstacle = { kind = \"plane\", point = [0.0, 0.0], normal = [0.0, 1.0] }",
        "kind" => "kind = \"block\"",
        "origin" => "origin = [0.0, 0.0]",
        "size" => "size = [2.0, 1.0]",
        "cells" => "cells = [18, 9]",
        "radii" => "radii = [1.0, 2.0]",
        "facing" if path.contains("side") => "facing = [0.0, 1.0]",
        "facing" => "facing = \"down\"",
        "vector" => "vector = [0.0, 30.0]",
        "theta" => "theta = 0.4",
        "ux" => "ux = 0.0",
        "uy" => "uy = -0.01",
        "pressure" => "pressure = 5.0",
        "gap" => "gap = 0.0",
        "lambda" => "lambda = 0.0",
        "ratio" => "ratio = 0.01",
        "force_balance" => "force_balance = 1e-3",
        "tolerance" => "tolerance = 1e-8",
        "friction_tolerance" => "friction_tolerance = 1e-6",
        "target_relative_error" => "target_relative_error = 0.02",
        "target_coulomb_residual" => "target_coulomb_residual = 0.1",
        "fraction" => "fraction = 0.5",
        "memory" => "memory = \"4GiB\"",
        "time" => "time = \"10min\"",
        _ => return None,
    })
}

/// Describes a value by its type and, if it is short, its text.
pub(super) fn described(value: &NodeValue) -> String {
    match value {
        NodeValue::String(text) => format!("the string {}", excerpt(text)),
        NodeValue::Integer(number) => format!("the integer {number}"),
        NodeValue::Float(number) => format!("the number {number:?}"),
        NodeValue::Boolean(truth) => format!("the boolean {truth}"),
        other => other.type_name().to_owned(),
    }
}

//! Temperatures and body forces that are linear in the position.

use super::draw::Draw;
use crate::random::Random;
use std::fmt::Write as _;

/// One of this many problems has them.
const SELDOM: usize = 8;

/// Puts temperatures and forces into the bodies of some problems. They have random numbers of their own, so that the other problems keep theirs. Returns whether
/// there are any.
pub(super) fn put(d: &mut Draw, number: u64) -> bool {
    let mut random = Random::new(1_000_003 * number + 73);
    if random.integer(1, SELDOM) > 1 {
        return false;
    }
    let kinds = [random.unit() < 0.6, random.unit() < 0.5, random.unit() < 0.4];
    let [heat, force, mass] = if kinds.contains(&true) { kinds } else { [true; 3] };
    let weight = d.stress * d.strain / d.length;
    if heat {
        d.mark("heat");
        // A given stiffness says nothing of what a material does along z.
        d.replace_in_head("]\nyoung =", "]\nexpansion = 1.5e-5\nyoung =");
    }
    if mass {
        d.mark("rotation or acceleration");
        let [x, y] = [0; 2].map(|_| weight * random.signed());
        let point = d.point([random.signed(), random.signed()]);
        let speed = (weight / d.length * random.unit()).sqrt();
        let model = match random.unit() < 0.5 {
            true => format!("acceleration = [{x:?}, {y:?}]\n"),
            false => format!("rotation = {{ speed = {speed:?}, point = {point} }}\n"),
        };
        d.replace_in_head("[model]\n", &format!("[model]\n{model}"));
        d.replace_in_head("]\nyoung", "]\ndensity = 1.0\nyoung");
        d.replace_in_head("]\nstiffness", "]\ndensity = 1.0\nstiffness");
        d.replace_in_head("]\nexpansion", "]\ndensity = 1.0\nexpansion");
    }
    let mut made = String::new();
    for body in d.bodies().to_owned().split_inclusive("[[body]]\n") {
        let end =
            body.find("[[body.").unwrap_or(body.len() - if body.ends_with("[[body]]\n") { 9 } else { 0 });
        let (head, rest) = body.split_at(end);
        made += head;
        // Before the first body there is nothing.
        if !head.trim().is_empty() {
            let mut linear = |amount: f64| {
                let slopes = [random.signed(), random.signed()];
                d.linear(amount, slopes, 0.0)
            };
            if force && !head.contains("body_force") {
                let _ = writeln!(made, "body_force = [\"{}\", \"{}\"]", linear(weight), linear(weight));
            }
            if heat {
                let _ = writeln!(made, "[[body.temperature]]\nvalue = \"{}\"", linear(d.strain / 1.5e-5));
            }
        }
        made += rest;
    }
    if force {
        d.mark("linear body force");
    }
    d.replace_bodies(made);
    true
}

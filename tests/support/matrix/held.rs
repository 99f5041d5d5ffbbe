//! Contact sides of blocks that a support holds along themselves.

use super::draw::Draw;
use crate::random::Random;
use std::fmt::Write as _;

/// The feature.
pub(super) const FEATURE: &str = "contact side held along itself";

/// One of this many problems has such sides.
const SELDOM: usize = 10;

/// Holds contact sides of blocks along `x`. The problems have random numbers of their own, so that the other problems keep theirs. Returns whether
/// there is such a side.
pub(super) fn put(d: &mut Draw, number: u64) -> bool {
    let mut random = Random::new(1_000_003 * number + 101);
    if random.integer(1, SELDOM) > 1 {
        return false;
    }
    let names = |table: &str, key: &str| -> Vec<String> {
        let list =
            table.split_once(&format!("{key} = [")).and_then(|(_, rest)| Some(rest.split_once(']')?.0));
        list.map_or_else(Vec::new, |list| {
            list.split(',').map(|name| name.trim().trim_matches('"').to_owned()).collect()
        })
    };
    let mut held: Vec<(String, String)> = Vec::new();
    for table in d.contacts().split("[[contact]]").skip(1) {
        let sides: Vec<_> = names(table, "bodies").into_iter().zip(names(table, "surfaces")).collect();
        // Both sides, or one of them.
        let skip = random.integer(0, sides.len().max(1));
        held.extend(sides.into_iter().enumerate().filter(|(k, _)| *k != skip).map(|(_, side)| side));
    }
    held.sort();
    held.dedup();
    let mut made = String::new();
    for body in d.bodies().to_owned().split_inclusive("[[body]]\n") {
        let (own, next) = body.strip_suffix("[[body]]\n").map_or((body, ""), |own| (own, "[[body]]\n"));
        made += own;
        for (name, side) in &held {
            if !own.contains("kind = \"block\"") || !own.starts_with(&format!("name = \"{name}\"\n")) {
                continue;
            }
            let amount = if random.unit() < 0.8 { 0.0 } else { d.strain * d.length };
            let ux = d.linear(amount, [random.signed(), random.signed()], 0.0);
            let _ = writeln!(made, "[[body.displacement]]\non = \"{side}\"\nux = \"{ux}\"");
            d.mark(FEATURE);
        }
        made += next;
    }
    d.replace_bodies(made);
    d.features.contains(FEATURE)
}

//! Springs in place of clamps, and beside loads and contacts.

use super::draw::Draw;
use crate::random::Random;
use std::fmt::Write as _;

/// The feature.
pub(super) const FEATURE: &str = "springs";

/// One of this many problems has springs.
const SELDOM: usize = 10;

/// Features that a clamp gives, and springs in its place do not.
const OF_CLAMPS: [&str; 2] = ["clamped end of a contact line", "held node of a contact line"];

/// Puts bodies of some problems on springs. They have random numbers of their own, so that the other problems keep theirs. Returns whether there are
/// any.
pub(super) fn put(d: &mut Draw, number: u64) -> bool {
    let mut random = Random::new(1_000_003 * number + 71);
    if random.integer(1, SELDOM) > 1 {
        return false;
    }
    let text = d.bodies().to_owned();
    let mut made = String::new();
    for body in text.split_inclusive("[[body]]\n") {
        let mut tables = body.split("[[body.");
        let head = tables.next().unwrap_or_default();
        made += head;
        let mut free: Vec<String> = Vec::new();
        for table in tables {
            let clamp = table.starts_with("displacement]]") && table.contains("fixed = true");
            if clamp && random.unit() < 0.7 {
                let springs = table.replace("displacement]]", "spring]]");
                let _ =
                    write!(made, "[[body.{}", springs.replace("fixed = true", &keys(d, &mut random, 0.8)));
                OF_CLAMPS.iter().for_each(|feature| d.unmark(feature));
                d.mark(FEATURE);
                continue;
            }
            let _ = write!(made, "[[body.{table}");
            if table.starts_with("traction]]") {
                free.extend(side(table));
            }
        }
        for on in free {
            if random.unit() < 0.5 {
                let table = format!("[[body.spring]]\n{on}\n{}\n", keys(d, &mut random, 0.4));
                // Behind the last table of the body, before the head of the next one.
                match made.ends_with("[[body]]\n") {
                    true => made.insert_str(made.len() - "[[body]]\n".len(), &table),
                    false => made += &table,
                }
                d.mark(FEATURE);
            }
        }
    }
    d.replace_bodies(made);
    d.features.contains(FEATURE)
}

/// Finds the line that names the side of a table.
fn side(table: &str) -> Option<String> {
    table.lines().find(|line| line.starts_with("on = ")).map(str::to_owned)
}

/// Draws the keys of springs.
///
/// * `all`: probability of springs in all directions.
fn keys(d: &Draw, random: &mut Random, all: f64) -> String {
    let stiffness = d.stress / d.length * 10f64.powf(3.0 * random.signed());
    let moved = d.strain * d.length;
    let rest = |random: &mut Random| {
        let [a, b] = [random.signed(), random.signed()];
        d.linear(moved, [a, b], 0.0)
    };
    let mut text = format!("stiffness = {stiffness:?}\n");
    if random.unit() < all {
        text += "along = \"all\"\n";
        if random.unit() < 0.4 {
            let _ = writeln!(text, "rest = [\"{}\", \"{}\"]", rest(random), rest(random));
        }
    } else if random.unit() < 0.5 {
        text += "along = \"normal\"\n";
        if random.unit() < 0.4 {
            let _ = writeln!(text, "rest = {:?}", moved * random.signed());
        }
    } else {
        let _ = writeln!(text, "along = [{:?}, {:?}]", random.signed(), 0.1 + random.unit());
    }
    text.trim_end().to_owned()
}

//! Random problems with friction of Tresca, as case files: limits from zero to stick, moduli up to 1e4 apart, meshes that do not match, bent
//! and closed lines, bodies that only contact and friction hold.
//!
//! There are no reference values: the bound is compared with the distance to the solution of a finer mesh. The limit is linear in x, so that
//! every mesh has the same one.

use crate::distance::{Outcome, outcome_of_text};
use crate::model::Made;
use crate::random_assemblies::{CLAMPED, Text, traction};

/// Kinds of problems.
pub const KINDS: [&str; 7] = [
    "blocks",
    "blocks, meshes that do not match",
    "arcs",
    "arcs, meshes that do not match",
    "circles",
    "floating blocks",
    "block on a rigid plane",
];

/// The sizes of a problem's numbers.
struct Scale {
    young: [f64; 2],
    /// Of the imposed displacements over the sizes of the bodies.
    strain: f64,
    /// The traction that this strain causes in the softer body.
    stress: f64,
}

impl Scale {
    fn new(text: &mut Text) -> Self {
        let ratio = 10f64.powf(text.between(-4.0, 4.0));
        let young = [1000.0 * ratio.sqrt(), 1000.0 / ratio.sqrt()];
        let strain = 10f64.powf(text.between(-4.0, -2.0));
        Self { young, strain, stress: young[0].min(young[1]) * strain }
    }

    /// A limit at the ends of the contact, from zero to stick.
    fn limit(&self, text: &mut Text) -> [f64; 2] {
        let size = match text.integer(0, 11) {
            0 => 0.0,
            1 => 1e6 * self.stress,
            _ => self.stress * 10f64.powf(text.between(-3.0, 1.0)),
        };
        if text.random.unit() < 0.4 {
            return [size; 2];
        }
        [0, 1].map(|_| size * text.random.unit())
    }
}

/// The key of a limit that is linear between two places on the x axis.
fn friction([a, b]: [f64; 2], [from, to]: [f64; 2]) -> String {
    let slope = (b - a) / (to - from);
    // Nowhere negative by rounding.
    format!("friction = {{ law = \"tresca\", limit = \"max(0, {a:?}+({slope:?})*(x-({from:?})))\" }}\n")
}

fn displaced(side: &str, [x, y]: [&str; 2]) -> String {
    format!("[[body.displacement]]\non = \"{side}\"\nux = \"{x}\"\nuy = \"{y}\"\n")
}

/// Writes the case with a number, and names its kind.
pub fn case(number: u64) -> (&'static str, String) {
    let mut text = Text::new(400_000 + number);
    let kind = (number % KINDS.len() as u64) as usize;
    let scale = Scale::new(&mut text);
    match kind {
        0 | 1 => blocks(&mut text, &scale, kind == 0),
        2 | 3 => arcs(&mut text, &scale, kind == 2),
        4 => circles(&mut text, &scale),
        5 => floating(&mut text, &scale),
        _ => on_a_plane(&mut text, &scale),
    }
    (KINDS[kind], text.done())
}

/// Solves the problem with a number, and compares its bound with a mesh that is refined `times` times.
///
/// # Errors
/// A finer problem that cannot be solved.
pub fn trial(number: u64, times: usize) -> Made<Outcome> {
    outcome_of_text(&case(number).1, times)
}

fn block(
    text: &mut Text,
    young: f64,
    origin: [f64; 2],
    size: [f64; 2],
    columns: usize,
    more: &str,
) -> String {
    let cells = [columns, text.integer(2, 6)];
    let generator = format!("kind = \"block\", origin = {origin:?}, size = {size:?}, cells = {cells:?}");
    text.body_of(young, &generator, more)
}

/// Two blocks; the upper one is moved and tilted, and pulled on its right side.
fn blocks(text: &mut Text, scale: &Scale, matching: bool) {
    let columns = text.integer(3, 12);
    let [height, depth] = [text.between(0.5, 1.5), text.between(0.5, 1.5)];
    let (left, right) = if matching { (0.0, 2.0) } else { (text.between(-0.3, 0.6), text.between(1.3, 2.3)) };
    let other = if matching { columns } else { text.integer(3, 14) };
    let d = scale.strain;
    let along = d * text.between(-1.0, 1.0);
    let tilt = d * text.between(-0.4, 0.4);
    let mut more = displaced("top", [&format!("{along:?}"), &format!("{:?}+({tilt:?})*(x-1)", -d)]);
    if text.random.unit() < 0.6 {
        let [x, y] = [0, 1].map(|_| format!("{:?}", scale.stress * text.between(-1.5, 1.5)));
        more += &traction("right", &x, &y);
    }
    let upper = block(text, scale.young[0], [left, 0.0], [right - left, height], columns, &more);
    let lower = block(text, scale.young[1], [0.0, -depth], [2.0, depth], other, CLAMPED);
    let key = friction(scale.limit(text), [-0.4, 2.4]);
    text.pair_with([&upper, &lower], ["bottom", "top"], &key);
}

/// Parts of two rings; the inner side of the inner one is moved.
fn arcs(text: &mut Text, scale: &Scale, matching: bool) {
    let middle = text.between(60.0, 120.0);
    let half = text.between(20.0, 60.0);
    let columns = text.integer(5, 14);
    let other = if matching { columns } else { text.integer(5, 18) };
    let beyond = if matching { 0.0 } else { text.between(0.0, 15.0) };
    let ring = |text: &mut Text, young: f64, radii: [f64; 2], columns: usize, half: f64, more: &str| {
        let cells = [columns, text.integer(2, 4)];
        let angles = [middle - half, middle + half];
        text.body_of(
            young,
            &format!("kind = \"ring\", radii = {radii:?}, angles = {angles:?}, cells = {cells:?}"),
            more,
        )
    };
    let d = scale.strain;
    let [along, away] = [d * text.between(-1.0, 1.0), d * text.between(0.2, 1.0)];
    let moved = displaced("inner", [&format!("{along:?}"), &format!("{away:?}")]);
    let inner = ring(text, scale.young[0], [1.0, 1.5], columns, half, &moved);
    let held = "[[body.displacement]]\non = \"outer\"\nfixed = true\n";
    let outer = ring(text, scale.young[1], [1.5, 2.0], other, half + beyond, held);
    let key = friction(scale.limit(text), [-2.0, 2.0]);
    text.pair_with([&inner, &outer], ["outer", "inner"], &key);
}

/// A ring in a ring; the outer side of the outer one is drawn together, turned and moved.
fn circles(text: &mut Text, scale: &Scale) {
    let columns = text.integer(12, 24);
    let other = if text.random.unit() < 0.5 { columns } else { text.integer(12, 30) };
    let held = "[[body.displacement]]\non = \"inner\"\nfixed = true\n";
    let d = scale.strain;
    let [x, y] = [0, 1].map(|_| 0.3 * d * text.between(-1.0, 1.0));
    let turn = d * text.between(-1.0, 1.0);
    let shrink = d * text.between(0.1, 1.0);
    let moved = displaced(
        "outer",
        [&format!("({x:?})-{shrink:?}*x-({turn:?})*y"), &format!("({y:?})-{shrink:?}*y+({turn:?})*x")],
    );
    let ring = |text: &mut Text, young: f64, radii: [f64; 2], columns: usize, more: &str| {
        let cells = [columns, text.integer(2, 3)];
        text.body_of(young, &format!("kind = \"ring\", radii = {radii:?}, cells = {cells:?}"), more)
    };
    let inner = ring(text, scale.young[0], [1.0, 1.5], columns, held);
    let outer = ring(text, scale.young[1], [1.5, 2.0], other, &moved);
    let key = friction(scale.limit(text), [-2.0, 2.0]);
    text.pair_with([&inner, &outer], ["outer", "inner"], &key);
}

/// Blocks on top of each other between a clamped one and one that is pressed down; those between are pushed by less than friction holds.
fn floating(text: &mut Text, scale: &Scale) {
    let count = text.integer(1, 2);
    let matching = text.random.unit() < 0.5;
    let columns = text.integer(3, 10);
    let mut limits: Vec<[f64; 2]> = (0..=count).map(|_| scale.limit(text)).collect();
    // Friction of the limit alone holds, however small.
    let least = 1e-3 * scale.stress;
    limits.iter_mut().flatten().for_each(|s| *s = s.max(least));
    let mut names = Vec::new();
    for k in 0..count + 2 {
        let own = if matching { columns } else { text.integer(3, 12) };
        let more = if k == 0 {
            CLAMPED.to_owned()
        } else if k == count + 1 {
            let down = scale.strain * text.between(0.2, 1.0);
            let along = scale.strain * text.between(-1.0, 1.0);
            displaced("top", [&format!("{along:?}"), &format!("{:?}", -down)])
        } else {
            // The force that friction of the line below holds: its limit is linear over the width of two. The traction has a height of one.
            let holds = limits[k - 1][0] + limits[k - 1][1];
            let push = 0.9 * holds.min(3.0 * scale.stress) * text.between(-1.0, 1.0) / count as f64;
            traction("left", &format!("{push:?}"), "0")
        };
        let young = scale.young[k % 2];
        names.push(block(text, young, [0.0, k as f64], [2.0, 1.0], own, &more));
    }
    for (k, limit) in limits.iter().enumerate() {
        let key = friction(*limit, [0.0, 2.0]);
        text.pair_with([&names[k + 1], &names[k]], ["bottom", "top"], &key);
    }
}

/// A block on a rigid plane that nothing but friction holds sideways, under a pressure and a push.
fn on_a_plane(text: &mut Text, scale: &Scale) {
    let columns = text.integer(4, 12);
    let mut limit = scale.limit(text);
    limit.iter_mut().for_each(|s| *s = s.max(1e-3 * scale.stress));
    let held = text.random.unit() < 0.3;
    let push = 0.9 * (limit[0] + limit[1]).min(scale.stress) * text.between(-1.0, 1.0);
    let slope = text.between(-0.5, 0.5);
    let mut more = traction("top", "0", &format!("-{:?}*(1+({slope:?})*(x-1))", scale.stress));
    more += &if held {
        format!(
            "[[body.displacement]]\non = \"right\"\nux = 0.0\n{}",
            traction("left", &format!("{push:?}"), "0")
        )
    } else {
        traction("left", &format!("{push:?}"), "0")
    };
    let name = block(text, scale.young[0], [0.0, 0.0], [2.0, 1.0], columns, &more);
    let key = friction(limit, [0.0, 2.0]);
    text.obstacle_with(&name, "bottom", "kind = \"plane\", point = [0.0, 0.0], normal = [0.0, 1.0]", &key);
}

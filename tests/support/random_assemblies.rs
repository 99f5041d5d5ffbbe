//! Random assemblies of two to five bodies, as case files: piles, cycles, beams on rollers, blocks in a corner of obstacles, pins in holes.
//! Most meshes do not match, sides face each other in part, moduli differ by up to 1000, some sides are rigid, some obstacles move under a force.
//!
//! There are no reference values: [`crate::distance::outcome`] holds the bound against a finer mesh. Some of the assemblies are not held, and
//! are refused for it.

use crate::distance::{Outcome, outcome_of_text};
use crate::model::Made;
use crate::random::Random;
use std::fmt::Write as _;

/// Kinds of assemblies.
pub const KINDS: [&str; 6] = ["pile", "cycle of three", "cycle of four", "beam on rollers", "corner", "pin"];

/// A case file under construction.
pub(crate) struct Text {
    head: String,
    bodies: String,
    contacts: String,
    pub(crate) random: Random,
    count: usize,
}

impl Text {
    pub(crate) fn new(seed: u64) -> Self {
        let random = Random::new(seed);
        let head = "schema = 1\n".to_owned();
        Self { head, bodies: String::new(), contacts: String::new(), random, count: 0 }
    }

    pub(crate) fn integer(&mut self, low: usize, high: usize) -> usize {
        self.random.integer(low, high)
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.unit()
    }

    /// Adds a body with a random material of its own; returns its name.
    fn body(&mut self, generator: &str, more: &str) -> String {
        let young = 10f64.powf(self.between(2.0, 5.0));
        self.body_of(young, generator, more)
    }

    /// Adds a body with a modulus; returns its name.
    pub(crate) fn body_of(&mut self, young: f64, generator: &str, more: &str) -> String {
        let name = format!("b{}", self.count);
        self.count += 1;
        let poisson = self.between(0.0, 0.45);
        let _ = writeln!(self.head, "[materials.{name}]\nyoung = {young:?}\npoisson = {poisson:?}");
        let _ = writeln!(
            self.bodies,
            "[[body]]\nname = \"{name}\"\nmaterial = \"{name}\"\ngenerator = {{ {generator} }}\n{more}"
        );
        name
    }

    fn block(&mut self, origin: [f64; 2], size: [f64; 2], more: &str) -> String {
        let cells = [self.integer(2, 9), self.integer(2, 6)];
        let generator = format!("kind = \"block\", origin = {origin:?}, size = {size:?}, cells = {cells:?}");
        self.body(&generator, more)
    }

    fn disc(&mut self, centre: [f64; 2], radius: f64, more: &str) -> String {
        let (cells, start) = (self.integer(3, 6), self.between(0.0, 360.0));
        let generator = format!(
            "kind = \"disc\", centre = {centre:?}, radius = {radius:?}, cells = {cells}, start = {start:?}"
        );
        self.body(&generator, more)
    }

    fn pair(&mut self, bodies: [&str; 2], surfaces: [&str; 2]) {
        self.pair_with(bodies, surfaces, "gap = \"geometric\"");
    }

    /// Adds a pair with further keys.
    pub(crate) fn pair_with(&mut self, bodies: [&str; 2], surfaces: [&str; 2], more: &str) {
        let _ = writeln!(self.contacts, "[[contact]]\nbodies = {bodies:?}\nsurfaces = {surfaces:?}\n{more}");
    }

    fn obstacle(&mut self, body: &str, surface: &str, obstacle: &str) {
        self.obstacle_with(body, surface, obstacle, "");
    }

    /// Adds a pair with an obstacle and further keys.
    pub(crate) fn obstacle_with(&mut self, body: &str, surface: &str, obstacle: &str, more: &str) {
        let _ = writeln!(
            self.contacts,
            "[[contact]]\nbodies = [\"{body}\"]\nsurfaces = [\"{surface}\"]\nobstacle = {{ {obstacle} }}\n{more}"
        );
    }

    fn plane(&mut self, body: &str, surface: &str, point: [f64; 2], normal: [f64; 2]) {
        self.obstacle(body, surface, &format!("kind = \"plane\", point = {point:?}, normal = {normal:?}"));
    }

    pub(crate) fn done(self) -> String {
        self.head + &self.bodies + &self.contacts
    }
}

pub(crate) const CLAMPED: &str = "[[body.displacement]]\non = \"bottom\"\nfixed = true\n";

pub(crate) fn traction(side: &str, x: &str, y: &str) -> String {
    format!("[[body.traction]]\non = \"{side}\"\nvector = [\"{x}\", \"{y}\"]\n")
}

/// Solves the assembly with a number, and compares its bound with a mesh that is refined `times` times.
///
/// # Errors
/// A finer problem that cannot be solved.
pub fn trial(number: u64, times: usize) -> Made<Outcome> {
    outcome_of_text(&case(number).1, times)
}

/// Writes the case with a number, and names its kind.
pub fn case(number: u64) -> (&'static str, String) {
    let mut text = Text::new(90_000 + number);
    let kind = (number % KINDS.len() as u64) as usize;
    match kind {
        0 => pile(&mut text),
        1 => three(&mut text),
        2 => four(&mut text),
        3 => beam(&mut text),
        4 => corner(&mut text),
        _ => pin(&mut text),
    }
    (KINDS[kind], text.done())
}

/// Blocks on top of each other, each within the width of the one below; a pressure, or a rigid top side under a force.
fn pile(text: &mut Text) {
    let count = text.integer(2, 5);
    let (mut left, mut width, mut y) = (0.0, 2.0, 0.0);
    let on_plane = text.random.unit() < 0.3;
    let mut below = String::new();
    for k in 0..count {
        let height = text.between(0.4, 1.2);
        let mut more = String::new();
        if k == 0 && !on_plane {
            more += CLAMPED;
        }
        if k + 1 == count {
            let load = text.between(1.0, 30.0);
            if text.random.unit() < 0.4 {
                let moment = load * width * text.between(-0.1, 0.1);
                let sideways = if text.random.unit() < 0.5 { "ux = 0.0\n" } else { "" };
                let _ = writeln!(
                    more,
                    "[[body.rigid]]\non = \"top\"\n{sideways}force = [0.0, {:?}]\nmoment = {moment:?}",
                    -load
                );
            } else {
                let slope = load * text.between(-0.8, 0.8);
                let place = format!("({:?}*(x-({:?})))", slope / width, left + 0.5 * width);
                more += &traction("top", "0", &format!("-({load:?}+{place})"));
            }
        }
        let name = text.block([left, y], [width, height], &more);
        if k > 0 {
            text.pair([&name, &below], ["bottom", "top"]);
        } else if on_plane {
            text.plane(&name, "bottom", [0.0, 0.0], [0.0, 1.0]);
        }
        y += height;
        let next = width * text.between(0.5, 1.0);
        left += (width - next) * text.random.unit();
        (width, below) = (next, name);
    }
}

/// A and B clamped side by side, C on both.
fn three(text: &mut Text) {
    let push = text.between(0.0, 20.0);
    let pushed = CLAMPED.to_owned() + &traction("left", &format!("{push:?}"), "0");
    let a = text.block([0.0, 0.0], [1.0, 1.0], &pushed);
    let b = text.block([1.0, 0.0], [1.0, 1.0], CLAMPED);
    let [p, q] = [text.between(1.0, 20.0), text.between(1.0, 20.0)];
    let [left, right] = [text.between(0.0, 0.6), text.between(1.4, 2.0)];
    let height = text.between(0.3, 0.9);
    let load = traction("top", "0", &format!("-({p:?}+({:?})*x)", 0.5 * (q - p)));
    let c = text.block([left, 1.0], [right - left, height], &load);
    text.pair([&a, &b], ["right", "left"]);
    text.pair([&c, &a], ["bottom", "top"]);
    text.pair([&c, &b], ["bottom", "top"]);
}

/// Four blocks around a point, against a wall on the left.
fn four(text: &mut Text) {
    let [split, height] = [text.between(0.7, 1.3), text.between(0.7, 1.3)];
    let [push, c_load, d_load] = [text.between(0.5, 15.0), text.between(5.0, 30.0), text.between(5.0, 30.0)];
    let a = text.block([0.0, 0.0], [split, 1.0], CLAMPED);
    let b = text.block([split, 0.0], [2.0 - split, 1.0], CLAMPED);
    let top = |load: f64| traction("top", "0", &format!("-{load:?}"));
    let right = traction("right", &format!("-{push:?}"), "0");
    let c = text.block([split, 1.0], [2.0 - split, height], &(right + &top(c_load)));
    let d = text.block([0.0, 1.0], [split, height], &top(d_load));
    text.pair([&a, &b], ["right", "left"]);
    text.pair([&c, &b], ["bottom", "top"]);
    text.pair([&d, &c], ["right", "left"]);
    text.pair([&d, &a], ["bottom", "top"]);
    text.plane(&d, "left", [0.0, 0.0], [1.0, 0.0]);
}

/// A beam on two or three rollers, on a clamped base or on a rigid plane.
fn beam(text: &mut Text) {
    let count = text.integer(1, 3);
    let radius = text.between(0.3, 0.6);
    let on_plane = text.random.unit() < 0.5;
    let base = if on_plane { None } else { Some(text.block([0.0, -1.0], [4.0, 1.0], CLAMPED)) };
    let mut rollers = Vec::new();
    for k in 0..count {
        let x = 4.0 * (k as f64 + 0.5) / count as f64 + text.between(-0.2, 0.2);
        rollers.push(text.disc([x, radius], radius, ""));
    }
    let [load, slope] = [text.between(1.0, 20.0), text.between(-0.2, 0.2)];
    let mut more = traction("top", "0", &format!("-{load:?}*(1+({slope:?})*(x-2))"));
    if count == 1 || text.random.unit() < 0.5 {
        more += "[[body.displacement]]\non = \"left\"\nux = 0.0\n";
    }
    let height = text.between(0.4, 1.0);
    let beam = text.block([0.0, 2.0 * radius], [4.0, height], &more);
    for roller in &rollers {
        match &base {
            Some(base) => text.pair([roller, base], ["rim", "top"]),
            None => text.plane(roller, "rim", [0.0, 0.0], [0.0, 1.0]),
        }
        text.pair([roller, &beam], ["rim", "bottom"]);
    }
}

/// Blocks side by side on a rigid floor between a rigid wall and a load, under a stamp or a pressure.
fn corner(text: &mut Text) {
    let count = text.integer(1, 4);
    let [push, down] = [text.between(0.5, 20.0), text.between(1.0, 30.0)];
    let (mut x, mut left): (f64, Option<String>) = (0.0, None);
    for k in 0..count {
        let [width, height] = [text.between(0.4, 1.2), text.between(0.6, 1.2)];
        let stamp = k == 0 && text.random.unit() < 0.5;
        let mut more = String::new();
        if !stamp {
            let slope = text.between(-0.5, 0.5) * down / width;
            more += &traction("top", "0", &format!("-({down:?}+({slope:?})*(x-{:?}))", x + 0.5 * width));
        }
        if k + 1 == count {
            more += &traction("right", &format!("-{push:?}"), "0");
        }
        let name = text.block([x, 0.0], [width, height], &more);
        text.plane(&name, "bottom", [0.0, 0.0], [0.0, 1.0]);
        if stamp {
            let force = format!("ux = 0.0, rotation = 0.0, force = [0.0, {:?}]", -down * width);
            let radius = text.between(2.0, 10.0);
            let centre = [x + 0.5 * width, height + radius];
            text.obstacle(
                &name,
                "top",
                &format!("kind = \"circle\", centre = {centre:?}, radius = {radius:?}, {force}"),
            );
        }
        match &left {
            None => text.plane(&name, "left", [0.0, 0.0], [1.0, 0.0]),
            Some(left) => text.pair([left, &name], ["right", "left"]),
        }
        x += width;
        left = Some(name);
    }
}

/// A roller in a bore, or an eye around a pin, with clearance. Their nodes face each other: a node that is moved for the other side shifts the
/// centroid, and then nothing resists the moment of the body force.
fn pin(text: &mut Text) {
    let clearance = text.between(0.0, 0.02);
    let [push, up] = [text.between(-10.0, 10.0), text.between(-10.0, 10.0)];
    let cells = text.integer(3, 6);
    let ring = |text: &mut Text, radii: [f64; 2]| {
        let cells = [6 * cells, text.integer(2, 4)];
        format!("kind = \"ring\", radii = {radii:?}, cells = {cells:?}")
    };
    let load = format!("body_force = [{push:?}, {up:?}]\n");
    if text.random.unit() < 0.5 {
        let disc = format!("kind = \"disc\", centre = [0.0, 0.0], radius = 1.0, cells = {cells}");
        let disc = text.body(&disc, &load);
        let bore = ring(text, [1.0 + clearance, 2.0]);
        let bore = text.body(&bore, "[[body.displacement]]\non = \"outer\"\nfixed = true\n");
        text.pair([&disc, &bore], ["rim", "inner"]);
    } else {
        let inner = ring(text, [0.4, 1.0]);
        let inner = text.body(&inner, "[[body.displacement]]\non = \"inner\"\nfixed = true\n");
        let middle = ring(text, [1.0 + clearance, 1.6]);
        let middle = text.body(&middle, &load);
        text.pair([&inner, &middle], ["outer", "inner"]);
        if text.random.unit() < 0.5 {
            let outer = ring(text, [1.6 + clearance, 2.0]);
            let outer = text.body(&outer, &load);
            text.pair([&middle, &outer], ["outer", "inner"]);
        }
    }
}

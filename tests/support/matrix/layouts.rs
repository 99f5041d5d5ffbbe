//! The shapes of the random problems: which bodies there are, what holds and loads them, where they touch.

use super::draw::{Draw, Member};
use crate::kinked;
use crate::model::Made;
use std::fmt::Write as _;

/// Facts about a problem that are known without solving it.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    /// The integral of the pressure of all pairs.
    pub(super) force: Option<f64>,
    /// A column under a uniform pressure: the exact displacements.
    pub(super) column: Option<Column>,
    /// The torque on a pin that may spin in its bore.
    pub(super) torque: Option<Torque>,
}

/// A torque on a pin that no friction holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Torque {
    /// The torque over the pin's radius, and the weight that presses it into the bore, N/m.
    pub(super) loads: [f64; 2],
    /// The largest angle between two nodes that follow each other on the pin or on the bore, rad.
    pub(super) angle: f64,
}

/// Blocks of one width on top of each other under a uniform pressure, on rollers below and on the left: the exact solution is linear in
/// each block.
#[derive(Clone, Debug)]
pub(super) struct Column {
    /// Of each block: its lowest `y`, and the strains along `x` and `y`.
    pub(super) blocks: Vec<(f64, [f64; 2])>,
    /// The left side, from which `x` is counted, and the displacement of each block's lowest side.
    pub(super) left: f64,
    /// Displacements of the lowest sides.
    pub(super) sunk: Vec<f64>,
}

pub(super) const CLAMPED: &str = "[[body.displacement]]\non = \"@bottom\"\nfixed = true\n";

/// The keys of a gap and of friction for a pair on the line `y = const` between two places.
struct Between<'a> {
    ends: [f64; 2],
    /// The features of the laws that the bodies allow.
    friction: &'a [&'static str],
    gaps: &'a [&'static str],
}

impl Draw {
    /// Names a condition if there are load steps.
    fn named(&self) -> &'static str {
        if self.steps.is_empty() { "" } else { "name = \"push\"\n" }
    }

    pub(super) fn displaced(&self, side: &str, components: &str) -> String {
        format!("[[body.displacement]]\n{}on = \"@{side}\"\n{components}\n", self.named())
    }

    fn pulled(&self, side: &str, [x, y]: [&str; 2]) -> String {
        format!("[[body.traction]]\n{}on = \"@{side}\"\nvector = [\"{x}\", \"{y}\"]\n", self.named())
    }

    /// A traction on a side, of a random size and direction.
    pub(super) fn random_traction(&mut self, side: &str) -> String {
        let load = self.stress * self.strain;
        let [x, y] = [0, 1].map(|_| format!("{:?}", load * self.random.signed()));
        self.pulled(side, [&x, &y])
    }

    /// The load on the top of a floating body between two places: a pressure, a traction, or a rigid side under a force; returns the
    /// force downwards.
    pub(super) fn pressed(&mut self, [left, right]: [f64; 2]) -> (String, f64) {
        let width = self.length * (right - left);
        let load = self.stress * self.strain * self.between(0.2, 1.0);
        let middle = 0.5 * (left + right);
        match self.random.integer(0, 3) {
            0 => {
                self.mark("rigid side");
                let moment = load * width * width * self.between(-0.1, 0.1);
                let sideways = if self.random.unit() < 0.5 { "ux = 0.0\n" } else { "" };
                let text = format!(
                    "[[body.rigid]]\n{}on = \"@top\"\n{sideways}force = [0.0, {:?}]\nmoment = {moment:?}\n",
                    self.named(),
                    -load * width
                );
                (text, load * width)
            }
            1 => {
                let text = format!("[[body.traction]]\n{}on = \"@top\"\npressure = {load:?}\n", self.named());
                (text, load * width)
            }
            _ => {
                let slope = self.between(-0.6, 0.6) / (right - left);
                let y = self.linear(load, [-1.0, slope], middle);
                (self.pulled("top", ["0", &y]), load * width)
            }
        }
    }

    /// The keys of a gap that keeps an overlap which is drawn.
    fn drawn_overlap(&mut self) -> &'static str {
        self.mark("interference: drawn");
        "gap = \"geometric\"\ninterference = true\n"
    }

    /// The key of a gap that load steps scale.
    fn scaled_gap(&mut self) -> &'static str {
        let scaled = self.presses && !self.steps.is_empty();
        if scaled {
            self.mark("interference: load steps");
        }
        if scaled { "name = \"push\"\n" } else { "" }
    }

    /// The keys of a pair: its gap, its friction, who carries λ.
    fn keys(&mut self, of: &Between<'_>) -> String {
        let mut keys = String::new();
        let [left, right] = of.ends;
        if !of.gaps.is_empty() {
            let gap = of.gaps[self.random.integer(0, of.gaps.len() - 1)];
            self.mark(gap);
            let open = self.strain * self.random.unit();
            match gap {
                "gap: number" => {
                    let _ =
                        writeln!(keys, "gap = {:?}", self.length * if self.presses { -open } else { open });
                }
                "gap: expression" if self.presses => {
                    let gap = [-open, 2.0 * open * self.random.unit() / (right - left)];
                    let _ = writeln!(keys, "gap = \"{}\"", self.linear(self.length, gap, left));
                }
                "gap: expression" => {
                    let slope = open / (right - left);
                    let _ =
                        writeln!(keys, "gap = \"max(0, {})\"", self.linear(self.length, [0.0, slope], left));
                }
                "gap: geometric" if self.presses => keys += self.drawn_overlap(),
                "gap: geometric" => keys += "gap = \"geometric\"\n",
                _ => {}
            }
            if self.presses && gap != "gap: geometric" {
                self.mark("interference: given");
            }
            keys += self.scaled_gap();
        }
        if !of.friction.is_empty() && self.random.unit() < 0.22 {
            let law = of.friction[self.random.integer(0, of.friction.len() - 1)];
            self.mark(law);
            if law == "friction: Coulomb" {
                let _ =
                    writeln!(keys, "friction = {{ law = \"coulomb\", mu = {:?} }}", self.between(0.05, 0.6));
            } else {
                let size = self.strain * 10f64.powf(self.between(-2.0, 1.0));
                let [a, b] = [0, 1].map(|_| size * self.random.unit());
                let limit = self.linear(self.stress, [a, (b - a) / (right - left)], left);
                let _ = writeln!(keys, "friction = {{ law = \"tresca\", limit = \"max(0, {limit})\" }}");
            }
        }
        if self.on(0.1, "imposed of a pair") {
            let _ = writeln!(keys, "imposed = \"{}\"", ["first", "second"][self.random.integer(0, 1)]);
        }
        keys
    }
}

const GAPS: [&str; 4] = ["gap: none", "gap: number", "gap: expression", "gap: geometric"];
const LAWS: [&str; 3] = ["friction: Tresca", "friction: Tresca", "friction: Coulomb"];

/// Two blocks that are held: the upper one is pressed down by its top side.
pub(super) fn blocks(d: &mut Draw) -> Made<Known> {
    let [height, depth] = [d.between(0.3, 1.5), d.between(0.3, 1.5)];
    let overlap = d.on(0.35, "partial overlap");
    let [left, right] = if overlap { [d.between(-0.4, 0.7), d.between(1.2, 2.4)] } else { [0.0, 2.0] };
    let down = d.length * d.strain * height;
    let along = down * d.random.signed();
    // Where both bodies are clamped an overlap is refused.
    let clamped = !overlap && !d.presses && d.on(0.2, "clamped end of a contact line");
    let held = !clamped && !overlap && d.on(0.2, "held node of a contact line");
    let mut upper = String::new();
    let mut lower = CLAMPED.to_owned();
    let fixed = |side: &str| format!("[[body.displacement]]\non = \"@{side}\"\nfixed = true\n");
    if clamped {
        let both = d.random.unit() < 0.5;
        for side in ["left", "right"].into_iter().take(if both { 2 } else { 1 }) {
            upper += &fixed(side);
            lower += &fixed(side);
        }
        let load = d.stress * d.strain * d.between(0.2, 1.0);
        let _ = writeln!(upper, "[[body.traction]]\n{}on = \"@top\"\npressure = {load:?}", d.named());
    } else {
        let tilt = d.between(-0.4, 0.4) * d.strain * d.length;
        let y = format!("{:?}+({:?})*(x-({:?}))", -down, tilt / d.length, d.at(0, 1.0));
        if held {
            let roller = "[[body.displacement]]\non = \"@left\"\nux = 0.0\n";
            upper += &(d.displaced("top", &format!("uy = \"{y}\"")) + roller);
            lower += roller;
        } else if d.on(0.2, "roller along a normal") {
            upper += &d.displaced("top", &format!("normal = {:?}", -down));
            upper += "[[body.displacement]]\non = \"@left\"\nux = 0.0\n";
        } else {
            upper += &d.displaced("top", &format!("ux = {along:?}\nuy = \"{y}\""));
        }
        if d.random.unit() < 0.5 {
            upper += &d.random_traction("right");
        }
    }
    if d.on(0.2, "body force") {
        upper = body_force(d, height) + &upper;
    }
    let apart = if d.random.unit() < 0.15 { d.strain * d.random.unit() } else { 0.0 };
    let apart = if d.presses && d.random.unit() < 0.5 { -d.strain * (0.1 + d.random.unit()) } else { apart };
    let upper = d.block([left, apart], [right - left, height], &upper)?;
    let lower = d.block([0.0, -depth], [2.0, depth], &lower)?;
    let gaps: &[&str] = match () {
        () if apart != 0.0 => &["gap: geometric"],
        () if d.presses => &GAPS[1..3],
        () => &GAPS,
    };
    let ends = [left.max(0.0), right.min(2.0)];
    let mut keys = d.keys(&Between { ends, friction: &LAWS, gaps });
    if d.on(0.1, "given normal") {
        keys += "normal = [0.0, -1.0]\n";
    }
    d.pair([&upper, &lower], ["bottom", "top"], &keys);
    Ok(Known::default())
}

pub(super) fn body_force(d: &mut Draw, height: f64) -> String {
    let weight = 0.3 * d.stress * d.strain / (d.length * height);
    format!("body_force = [{:?}, {:?}]\n", weight * 0.3 * d.random.signed(), -weight * d.random.unit())
}

/// Blocks on top of each other that only contact holds in the vertical, on a clamped one or on a plane.
pub(super) fn pile(d: &mut Draw) -> Made<Known> {
    let count = d.random.integer(2, 8).min(d.random.integer(2, 8));
    d.triangles /= count as f64;
    d.triangles = d.triangles.max(8.0);
    let on_plane = d.random.unit() < 0.3;
    let narrower = d.on(0.5, "partial overlap");
    let [mut left, mut width, mut y] = [0.0, 2.0, 0.0];
    let mut below: Option<Member> = None;
    let mut force = 0.0;
    for k in 0..count {
        let height = d.between(0.4, 1.2);
        let mut more = if k == 0 && !on_plane { CLAMPED.to_owned() } else { String::new() };
        if k + 1 == count {
            let (load, down) = d.pressed([left, left + width]);
            more += &load;
            force = down;
        }
        if k > 0 || on_plane {
            d.mark("floating body");
            more += "[[body.displacement]]\non = \"@left\"\nux = 0.0\n";
        }
        let name = d.block([left, y], [width, height], &more)?;
        let ends = [left, left + width];
        let between = Between { ends, friction: &LAWS[..2], gaps: &["gap: none", "gap: geometric"] };
        put_onto(d, &name, (below.as_ref(), on_plane), |d| d.keys(&between));
        y += height;
        let next = if narrower { width * d.between(0.5, 1.0) } else { width };
        left += (width - next) * d.random.unit();
        (width, below) = (next, Some(name));
    }
    let pairs = count - usize::from(!on_plane);
    Ok(Known { force: Some(force * pairs as f64), ..Known::default() })
}

/// Pairs a block with the one below; the lowest one with a plane, if there is one.
///
/// * `keys`: of the pair of blocks.
pub(super) fn put_onto(
    d: &mut Draw,
    block: &Member,
    (below, on_plane): (Option<&Member>, bool),
    keys: impl FnOnce(&mut Draw) -> String,
) {
    match below {
        Some(below) => {
            let keys = keys(d);
            d.pair([block, below], ["bottom", "top"], &keys);
        }
        None if on_plane => {
            let plane = d.plane([0.0, 0.0], [0.0, 1.0]);
            d.mark("obstacle: fixed plane");
            d.obstacle(block, "bottom", &plane, "");
        }
        None => {}
    }
}

/// Blocks of one width under a uniform pressure, between rollers: linear displacements, whatever the meshes.
pub(super) fn column(d: &mut Draw) -> Made<Known> {
    let count = d.random.integer(1, 4);
    d.triangles = (d.triangles / count as f64).max(8.0);
    d.mark("exact solution is linear");
    let width = d.between(0.5, 2.0);
    let load = d.stress * d.strain * d.between(0.2, 1.0);
    let on_plane = count == 1 || d.random.unit() < 0.4;
    let mut y = 0.0;
    let mut below: Option<Member> = None;
    let mut column = Column { blocks: Vec::new(), left: d.at(0, 0.0), sunk: Vec::new() };
    let mut sinks = 0.0;
    d.isotropic = true;
    for k in 0..count {
        let height = d.between(0.4, 1.2);
        let mut more = "[[body.displacement]]\non = \"@left\"\nux = 0.0\n".to_owned();
        if k == 0 && !on_plane {
            more += "[[body.displacement]]\non = \"@bottom\"\nuy = 0.0\n";
        }
        if k + 1 == count {
            let _ = writeln!(more, "[[body.traction]]\n{}on = \"@top\"\npressure = {load:?}", d.named());
        }
        let name = d.block([0.0, y], [width, height], &more)?;
        let plane = d.plane_stress;
        let (young, nu) = (name.young, name.poisson);
        let strains = if plane {
            [nu * load / young, -load / young]
        } else {
            [nu * (1.0 + nu) * load / young, -(1.0 - nu * nu) * load / young]
        };
        column.blocks.push((d.at(1, y), strains));
        column.sunk.push(sinks);
        sinks += strains[1] * d.length * height;
        match &below {
            Some(below) => d.pair([&name, below], ["bottom", "top"], ""),
            None if on_plane => {
                let obstacle = d.plane([0.0, 0.0], [0.0, 1.0]);
                d.mark("obstacle: fixed plane");
                d.obstacle(&name, "bottom", &obstacle, "");
            }
            None => {}
        }
        if k > 0 || on_plane {
            d.mark("floating body");
        }
        y += height;
        below = Some(name);
    }
    let pairs = count - usize::from(!on_plane);
    let force = load * d.length * width * pairs as f64;
    Ok(Known { force: Some(force), column: Some(column), ..Known::default() })
}

/// Blocks around a point: two clamped ones side by side, one or two on both.
pub(super) fn corner_of_blocks(d: &mut Draw) -> Made<Known> {
    d.mark("corner of two pairs");
    d.triangles = (d.triangles / 3.0).max(8.0);
    let load = d.stress * d.strain;
    let [split, height] = [d.between(0.7, 1.3), d.between(0.5, 1.2)];
    let push = load * d.between(0.0, 1.0);
    let pushed = CLAMPED.to_owned() + &d.pulled("left", [&format!("{push:?}"), "0"]);
    let a = d.block([0.0, 0.0], [split, 1.0], &pushed)?;
    let b = d.block([split, 0.0], [2.0 - split, 1.0], CLAMPED)?;
    let sides = Between { ends: [split - 1.0, split + 1.0], friction: &LAWS[..2], gaps: &[] };
    let tops = Between { ends: [0.0, 2.0], friction: &LAWS[..2], gaps: &[] };
    let keys = d.keys(&sides);
    d.pair([&a, &b], ["right", "left"], &keys);
    if d.random.unit() < 0.5 {
        let [left, right] = [d.between(0.0, 0.5), d.between(1.5, 2.0)];
        let (top, _) = d.pressed([left, right]);
        d.mark("floating body");
        let more = top + "[[body.displacement]]\non = \"@left\"\nux = 0.0\n";
        let c = d.block([left, 1.0], [right - left, height], &more)?;
        let keys = [d.keys(&tops), d.keys(&tops)];
        d.pair([&c, &a], ["bottom", "top"], &keys[0]);
        d.pair([&c, &b], ["bottom", "top"], &keys[1]);
        return Ok(Known::default());
    }
    let [(c_top, _), (d_top, _)] = [d.pressed([split, 2.0]), d.pressed([0.0, split])];
    let inwards = format!("{:?}", -load * d.between(0.05, 0.5));
    let pushed = d.pulled("right", [&inwards, "0"]) + &c_top;
    let c = d.block([split, 1.0], [2.0 - split, height], &pushed)?;
    let e = d.block([0.0, 1.0], [split, height], &d_top)?;
    d.mark("floating body");
    d.pair([&c, &b], ["bottom", "top"], "");
    d.pair([&e, &c], ["right", "left"], "");
    d.pair([&e, &a], ["bottom", "top"], "");
    let wall = d.plane([0.0, 0.0], [1.0, 0.0]);
    d.mark("obstacle: fixed plane");
    d.obstacle(&e, "left", &wall, "");
    Ok(Known::default())
}

/// Blocks side by side between a floor, a wall and a load, under a stamp or a pressure.
pub(super) fn room(d: &mut Draw) -> Made<Known> {
    let count = d.random.integer(1, 4);
    d.triangles = (d.triangles / count as f64).max(8.0);
    let load = d.stress * d.strain;
    let push = load * d.between(0.05, 1.0);
    let mut x = 0.0;
    let mut left: Option<Member> = None;
    for k in 0..count {
        let [width, height] = [d.between(0.4, 1.2), d.between(0.6, 1.2)];
        let stamp = k == 0 && d.random.unit() < 0.6;
        let mut more = String::new();
        if !stamp {
            more += &d.pressed([x, x + width]).0;
        }
        if k + 1 == count {
            let inwards = format!("{:?}", -push);
            more += &d.pulled("right", [&inwards, "0"]);
        }
        d.mark("floating body");
        let name = d.block([x, 0.0], [width, height], &more)?;
        let floor = d.plane([0.0, 0.0], [0.0, 1.0]);
        let moved = if d.on(0.2, "obstacle: moved") {
            format!("motion = [0.0, {:?}]\n", d.length * d.strain * d.between(-0.1, 0.1))
        } else {
            d.mark("obstacle: fixed plane");
            String::new()
        };
        let between = Between { ends: [x, x + width], friction: &LAWS[..1], gaps: &[] };
        let keys =
            d.keys(&between).replace("imposed = \"first\"\n", "").replace("imposed = \"second\"\n", "");
        d.obstacle(&name, "bottom", &floor, &(moved + &keys));
        if stamp {
            stamped(d, &name, [x, width, height], load);
        }
        match &left {
            None => {
                let wall = d.plane([0.0, 0.0], [1.0, 0.0]);
                d.mark("corner of two pairs");
                d.obstacle(&name, "left", &wall, "");
            }
            Some(left) => d.pair([left, &name], ["right", "left"], ""),
        }
        x += width;
        left = Some(name);
    }
    Ok(Known::default())
}

/// Presses a stamp on the top of a block: a plane or a circle, driven by a force or moved.
fn stamped(d: &mut Draw, name: &Member, [x, width, height]: [f64; 3], load: f64) {
    let moved = d.random.unit() < 0.3;
    let how = if moved {
        d.mark("obstacle: moved");
        format!("ux = 0.0, uy = {:?}, rotation = 0.0", -d.length * d.strain * height)
    } else {
        d.mark("obstacle: driven by a force");
        let down = load * d.length * width;
        let turns = if d.random.unit() < 0.5 { "rotation = 0.0" } else { "moment = 0.0" };
        let turns =
            if d.random.unit() < 0.3 { format!("rotation = {:?}", 0.1 * d.strain) } else { turns.into() };
        let about = d.point([x + 0.5 * width, height]);
        format!("ux = 0.0, {turns}, force = [0.0, {:?}], about = {about}", -down)
    };
    if d.random.unit() < 0.5 {
        d.mark("obstacle: circle");
        d.nested = false;
        let radius = d.between(2.0, 10.0);
        let how = how.replace("moment = 0.0", "rotation = 0.0");
        let centre = d.point([x + 0.5 * width, height + radius]);
        let circle = format!(
            "kind = \"circle\", centre = {centre}, radius = {:?}, side = \"outside\", {how}",
            d.length * radius
        );
        d.obstacle(name, "top", &circle, "");
    } else {
        let plane = d.plane([x, height], [0.0, -1.0]);
        d.obstacle(name, "top", &format!("{plane}, {how}"), "");
    }
}

/// A beam on rollers, on a clamped base or on a plane.
pub(super) fn beam(d: &mut Draw) -> Made<Known> {
    let count = d.random.integer(1, 4);
    d.triangles = (d.triangles / (count + 1) as f64).max(24.0);
    d.mark("bent contact line");
    d.mark("floating body");
    d.mark("gap: geometric");
    d.nested = false;
    let radius = d.between(0.3, 0.6);
    let base = if d.random.unit() < 0.5 { None } else { Some(d.block([0.0, -1.0], [4.0, 1.0], CLAMPED)?) };
    let curve =
        if d.on(0.5, "declared arc") { "[[body.curve]]\non = \"@rim\"\nkind = \"arc\"\n" } else { "" };
    let mut rollers = Vec::new();
    for k in 0..count {
        let x = 4.0 * (k as f64 + 0.5) / count as f64 + d.between(-0.2, 0.2);
        rollers.push(d.disc([x, radius], radius, curve));
    }
    let load = d.stress * d.strain * d.between(0.2, 1.0);
    let slope = d.between(-0.1, 0.1);
    let y = d.linear(load, [-1.0, slope], 2.0);
    let mut more = d.pulled("top", ["0", &y]);
    if count == 1 || d.random.unit() < 0.5 {
        more += "[[body.displacement]]\non = \"@left\"\nux = 0.0\n";
    }
    let height = d.between(0.4, 1.0);
    let beam = d.block([0.0, 2.0 * radius], [4.0, height], &more)?;
    for roller in &rollers {
        match &base {
            Some(base) => d.pair([roller, base], ["rim", "top"], "gap = \"geometric\"\n"),
            None => {
                let plane = d.plane([0.0, 0.0], [0.0, 1.0]);
                d.mark("obstacle: fixed plane");
                d.obstacle(roller, "rim", &plane, "");
            }
        }
        d.pair([roller, &beam], ["rim", "bottom"], "gap = \"geometric\"\n");
    }
    Ok(Known::default())
}

/// A pin in a bore, or rings in each other, with or without clearance.
pub(super) fn pin(d: &mut Draw) -> Made<Known> {
    d.triangles = (0.5 * d.triangles).max(48.0);
    d.mark("bent contact line");
    d.mark("closed contact line");
    d.mark("gap: geometric");
    d.nested = false;
    let clearance = if d.random.unit() < 0.4 { 0.0 } else { d.between(0.0, 0.02) };
    let clearance = if d.presses { -d.strain * (0.1 + d.random.unit()) } else { clearance };
    let weight = d.stress * d.strain / d.length;
    let [x, y] = [0, 1].map(|_| weight * d.random.signed());
    let load = format!("body_force = [{x:?}, {y:?}]\n");
    let arc = d.on(0.4, "declared arc");
    let curve = |side: &str, kind: &str| match arc {
        true => format!("[[body.curve]]\non = \"@{side}\"\nkind = \"{kind}\"\n"),
        false => String::new(),
    };
    let cells = ((d.triangles / 6.0).sqrt().round() as usize).clamp(3, 12);
    let around = if d.matching { 6 * cells } else { d.random.integer(16, 40) };
    let fixed = |side: &str| format!("[[body.displacement]]\non = \"@{side}\"\nfixed = true\n");
    let (first, side, second) = if d.random.unit() < 0.5 {
        d.mark("floating body");
        let disc = d.disc([0.0, 0.0], 1.0, &(load + &curve("rim", "arc")));
        let more = fixed("outer") + &curve("inner", "arc");
        (disc, "rim", d.ring([1.0 + clearance, 2.0], [0.0, 360.0], around, &more))
    } else {
        let inner = d.ring([0.4, 1.0], [0.0, 360.0], around, &(fixed("inner") + &curve("outer", "arc")));
        let smooth = if arc && d.on(0.3, "declared smooth curve") { "smooth" } else { "arc" };
        d.mark("floating body");
        let more = load + &curve("inner", smooth);
        (inner, "outer", d.ring([1.0 + clearance, 1.7], [0.0, 360.0], around, &more))
    };
    let gap = if d.presses { d.drawn_overlap() } else { "gap = \"geometric\"\n" }.to_owned();
    let keys = gap + d.scaled_gap();
    d.pair([&first, &second], [side, "inner"], &keys);
    Ok(Known::default())
}

/// A pin that may spin in its bore, both declared as arcs, under its weight and a torque that is zero, below or above the error of the polygon.
pub(super) fn spun(d: &mut Draw) -> Made<Known> {
    for feature in
        ["bent contact line", "closed contact line", "gap: geometric", "declared arc", "floating body"]
    {
        d.mark(feature);
    }
    d.mark("torque on a pin");
    d.nested = false;
    d.triangles = (0.5 * d.triangles).max(48.0);
    const BORE: f64 = 0.4;
    let clearance = if d.random.unit() < 0.3 { 0.0 } else { d.between(0.0, 0.02) };
    let around = d.random.integer(16, 48);
    let other = if d.matching { around } else { d.random.integer(16, 48) };
    let turned = if d.random.unit() < 0.5 { 0.0 } else { d.between(0.0, 360.0 / around as f64) };
    let size = d.stress * d.strain * d.length;
    let force = [0, 1].map(|_| size * d.random.signed());
    let weight = size * 1e-3 + force[0].hypot(force[1]);
    let torque = match d.random.integer(0, 3) {
        0 => 0.0,
        _ => weight * 10f64.powf(d.between(-6.0, 0.0)) * d.random.signed().signum(),
    };
    let area = std::f64::consts::PI * (1.0 - BORE * BORE) * d.length.powi(2);
    let [x, y] = [force[0] / area, force[1] / area - 1e-3 * size / area];
    let slope = torque * d.length / (std::f64::consts::TAU * (BORE * d.length).powi(3));
    let [cx, cy] = [d.at(0, 0.0), d.at(1, 0.0)];
    let around_centre = [format!("{:?}*(y-({cy:?}))", -slope), format!("{slope:?}*(x-({cx:?}))")];
    let twisted = d.pulled("inner", [&around_centre[0], &around_centre[1]]);
    let arc = |side: &str| format!("[[body.curve]]\non = \"@{side}\"\nkind = \"arc\"\n");
    let load = format!("body_force = [{x:?}, {y:?}]\n") + &twisted + &arc("outer");
    let pin = d.ring([BORE, 1.0], [turned, turned + 360.0], around, &load);
    let held = "[[body.displacement]]\non = \"@outer\"\nfixed = true\n".to_owned() + &arc("inner");
    let bore = d.ring([1.0 + clearance, 2.0], [0.0, 360.0], other, &held);
    d.pair([&pin, &bore], ["outer", "inner"], "gap = \"geometric\"\n");
    let angle = std::f64::consts::TAU / around.min(other) as f64;
    let loads = [torque, f64::hypot(x, y) * area];
    Ok(Known { torque: Some(Torque { loads, angle }), ..Known::default() })
}

/// Parts of two rings, both held: a bent contact line without gap.
pub(super) fn arcs(d: &mut Draw) -> Made<Known> {
    d.mark("bent contact line");
    d.triangles = (0.5 * d.triangles).max(16.0);
    let [middle, half] = [d.between(60.0, 120.0), d.between(20.0, 60.0)];
    let closed = d.on(0.3, "closed contact line");
    let columns = ((d.triangles * 0.5).sqrt() * 1.4).round().max(5.0) as usize;
    let columns = if closed { columns.max(12) } else { columns };
    let other = if d.matching { columns } else { d.random.integer(5, 30).max(if closed { 12 } else { 5 }) };
    let angles = |half: f64| if closed { [0.0, 360.0] } else { [middle - half, middle + half] };
    let beyond = if !closed && d.on(0.3, "partial overlap") { d.between(2.0, 15.0) } else { 0.0 };
    let size = d.length * d.strain;
    let [along, away] = [size * d.random.signed(), size * d.between(0.2, 1.0)];
    let curve = d.on(0.3, "declared arc");
    d.nested = !curve;
    let arc = |side: &str| match curve {
        true => format!("[[body.curve]]\non = \"@{side}\"\nkind = \"arc\"\n"),
        false => String::new(),
    };
    let fixed = |side: &str| format!("[[body.displacement]]\non = \"@{side}\"\nfixed = true\n");
    let (first, second) = if closed {
        let shrink = d.strain;
        let [x, y] = [d.at(0, 0.0), d.at(1, 0.0)];
        let components = format!(
            "ux = \"{:?}-{shrink:?}*(x-({x:?}))\"\nuy = \"{:?}-{shrink:?}*(y-({y:?}))\"",
            0.3 * along,
            0.3 * away
        );
        (fixed("inner"), d.displaced("outer", &components))
    } else {
        (d.displaced("inner", &format!("ux = {along:?}\nuy = {away:?}")), fixed("outer"))
    };
    let inner = d.ring([1.0, 1.5], angles(half), columns, &(first + &arc("outer")));
    let pressed = if d.presses { d.strain * (0.1 + d.random.unit()) } else { 0.0 };
    let drawn = d.presses && d.random.unit() < 0.7;
    let radius = if drawn { 1.5 - pressed } else { 1.5 };
    let outer = d.ring([radius, 2.0], angles(half + beyond), other, &(second + &arc("inner")));
    let gaps: &[&str] = if d.presses { &[] } else { &["gap: none", "gap: number"] };
    let keys = d.keys(&Between { ends: [-2.0, 2.0], friction: &LAWS, gaps });
    // A gap of zero is the same on every mesh.
    let keys = if keys.contains("gap = ") {
        let lines = keys.lines().filter(|line| !line.starts_with("gap"));
        lines.fold("gap = 0.0\n".to_owned(), |text, line| text + line + "\n")
    } else {
        keys
    };
    let keys = match (d.presses, drawn) {
        (false, _) => keys,
        (true, true) => {
            // The vector between the nodes of concentric polygons is the same on every mesh.
            d.nested &= d.matching && beyond == 0.0;
            keys + d.drawn_overlap() + d.scaled_gap()
        }
        (true, false) => {
            d.nested = false;
            d.mark("interference: given");
            keys + &format!("gap = {:?}\n", -d.length * pressed) + d.scaled_gap()
        }
    };
    d.pair([&inner, &outer], ["outer", "inner"], &keys);
    Ok(Known::default())
}

/// Two bodies that touch along a straight stretch and a declared arc, between which there is a corner.
pub(super) fn kinked(d: &mut Draw) -> Made<Known> {
    for feature in ["corner of one side", "bent contact line", "declared arc"] {
        d.mark(feature);
    }
    d.nested = false;
    d.triangles = (0.5 * d.triangles).max(16.0);
    let turn = d.between(1.2, 15.0) * d.random.signed().signum();
    let columns = |d: &Draw| ((0.25 * d.triangles).sqrt().round() as usize).clamp(2, 12);
    let first = columns(d);
    let second = if d.matching { first } else { d.random.integer(2, 12) };
    let rows =
        [first, second].map(|columns| ((0.25 * d.triangles / columns as f64).round() as usize).clamp(1, 20));
    let above = if d.random.unit() < 0.5 {
        d.mark("floating body");
        let sideways = "[[body.displacement]]\non = \"@left\"\nux = 0.0\n";
        let slope = d.between(-0.3, 0.3);
        let y = d.linear(d.stress * d.strain, [-1.0, slope], 0.0);
        d.pulled("top", ["0", &y]) + sideways
    } else {
        let size = d.length * d.strain;
        let [along, down] = [size * d.random.signed(), size * d.between(0.2, 1.0)];
        d.displaced("top", &format!("ux = {along:?}\nuy = {:?}", -down))
    };
    let arc = "[[body.curve]]\non = \"@round\"\nkind = \"arc\"\n";
    let angle = turn.to_radians();
    let upper = d.of_mesh(&kinked::mesh(true, angle, [2 * first, rows[0]])?, &(above + arc))?;
    let lower =
        d.of_mesh(&kinked::mesh(false, angle, [2 * second, rows[1]])?, &(CLAMPED.to_owned() + arc))?;
    let gap = if d.on(0.5, "gap: geometric") { "gap = \"geometric\"\n" } else { "" };
    if gap.is_empty() {
        d.mark("gap: none");
    }
    d.pair_on([&upper, &lower], kinked::PARTS, gap);
    Ok(Known::default())
}

/// Half a disc on a block or on a plane, pressed by a rigid side.
pub(super) fn half_disc(d: &mut Draw) -> Made<Known> {
    d.triangles = (0.5 * d.triangles).max(24.0);
    d.mark("bent contact line");
    d.mark("gap: geometric");
    d.nested = false;
    let radius = d.between(0.8, 3.0);
    let force = d.stress * d.strain * d.length * radius * d.between(0.1, 0.5);
    let top = if d.random.unit() < 0.5 {
        d.mark("rigid side");
        d.mark("floating body");
        format!(
            "[[body.rigid]]\n{}on = \"@flat\"\nux = 0.0\nrotation = 0.0\nforce = [0.0, {:?}]\n",
            d.named(),
            -force
        )
    } else {
        d.displaced("flat", &format!("ux = 0.0\nuy = {:?}", -d.length * d.strain * 0.1 * radius))
    };
    let arc =
        if d.on(0.4, "declared arc") { "[[body.curve]]\non = \"@contact\"\nkind = \"arc\"\n" } else { "" };
    let half = d.half_disc([0.0, 0.0], radius, &(top + arc));
    let against = d.random.unit();
    if against < 0.3 {
        d.mark("obstacle: fixed plane");
        let plane = d.plane([0.0, 0.0], [0.0, 1.0]);
        d.obstacle(&half, "contact", &plane, "");
    } else if against < 0.5 {
        d.mark("obstacle: hollow circle");
        let hollow = radius * d.between(1.2, 5.0);
        let centre = d.point([0.0, hollow]);
        let circle = format!(
            "kind = \"circle\", centre = {centre}, radius = {:?}, side = \"inside\"",
            d.length * hollow
        );
        d.obstacle(&half, "contact", &circle, "");
    } else {
        let base = d.block([-radius, -radius], [2.0 * radius, radius], CLAMPED)?;
        d.pair([&half, &base], ["contact", "top"], "gap = \"geometric\"\n");
    }
    Ok(Known::default())
}

/// One body without contact.
pub(super) fn alone(d: &mut Draw) -> Made<Known> {
    d.mark("no contact");
    let load = d.random_traction("right");
    let more = body_force(d, 1.0) + CLAMPED + &load;
    let top = d.at(1, 0.5);
    let part = format!("part = {{ y = [{top:?}, {:?}] }}\n", d.at(1, 2.0));
    let more = if d.on(0.5, "part of a side") {
        more.replace("on = \"@right\"\n", &format!("on = \"@right\"\n{part}"))
    } else {
        more
    };
    d.block([0.0, 0.0], [2.0, 1.0], &more)?;
    Ok(Known::default())
}

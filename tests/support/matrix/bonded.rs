//! Random problems with bonded bodies.

use super::draw::{Draw, Member};
use super::layouts::{CLAMPED, Known, body_force, put_onto};
use crate::model::Made;
use std::fmt::Write as _;

/// Blocks that are bonded: a stack with contact between some of them, two that are bonded in part and touch beside the bond, or four around a point.
pub(super) fn layout(d: &mut Draw) -> Made<Known> {
    d.mark("bonded pair");
    match d.random.integer(0, 3) {
        0 => bonded_in_part(d),
        1 => bonded_quarters(d),
        _ => bonded_stack(d),
    }
}

impl Draw {
    /// The keys of a bond, with a random offset or without one.
    fn bond(&mut self) -> String {
        let mut keys = "law = \"bonded\"\n".to_owned();
        if self.on(0.5, "offset of a bond") {
            let offset = [0, 1].map(|_| self.length * self.strain * self.random.signed());
            let _ = writeln!(keys, "offset = {offset:?}");
        }
        keys
    }

    /// Holds or loads the top of the last block.
    fn topped(&mut self, ends: [f64; 2]) -> String {
        if self.random.unit() < 0.4 {
            let down = -self.length * self.strain * self.between(-0.3, 1.0);
            return self.displaced("top", &format!("ux = {:?}\nuy = {down:?}", 0.5 * down));
        }
        self.pressed(ends).0 + &self.random_traction("right")
    }
}

fn bonded_stack(d: &mut Draw) -> Made<Known> {
    let count = d.random.integer(2, 4);
    d.triangles = (d.triangles / count as f64).max(8.0);
    let on_plane = d.random.unit() < 0.3;
    let narrower = d.on(0.4, "partial overlap");
    let [mut left, mut width, mut y] = [0.0, 2.0, 0.0];
    let weight = if d.on(0.2, "body force") { body_force(d, 1.0) } else { String::new() };
    // A last block that lies on the stack.
    let lies = !on_plane && d.random.unit() < 0.4;
    let mut below: Option<Member> = None;
    for k in 0..count {
        let height = d.between(0.4, 1.2);
        let mut more = weight.clone();
        if k == 0 && !on_plane {
            more += CLAMPED;
        }
        if k + 1 == count && !lies {
            more += &d.topped([left, left + width]);
        }
        if k == 0 && on_plane {
            d.mark("floating body");
            more += "[[body.displacement]]\non = \"@left\"\nux = 0.0\n";
        }
        let name = d.block([left, y], [width, height], &more)?;
        // Contact holds a block against sliding only with friction, which is not solved beside bonds.
        put_onto(d, &name, (below.as_ref(), on_plane), Draw::bond);
        y += height;
        let next = if narrower { width * d.between(0.5, 1.0) } else { width };
        left += (width - next) * d.random.unit();
        (width, below) = (next, Some(name));
    }
    if lies {
        d.mark("floating body");
        let (top, _) = d.pressed([left, left + width]);
        let more = weight + "[[body.displacement]]\non = \"@left\"\nux = 0.0\n" + &top;
        let last = d.block([left, y], [width, 0.7], &more)?;
        if let Some(below) = &below {
            d.pair([&last, below], ["bottom", "top"], "");
        }
    }
    Ok(Known::default())
}

/// Two blocks that are bonded for `x ≤ 1` and touch beyond.
fn bonded_in_part(d: &mut Draw) -> Made<Known> {
    d.mark("contact beside a bond");
    d.triangles = (0.5 * d.triangles).max(16.0);
    let parts = |d: &Draw| {
        let side = |name: &str, from: f64, to: f64| {
            format!(
                "[[body.side]]\nname = \"@{name}\"\nbox = {{ x = [{:?}, {:?}], y = [{:?}, {:?}] }}\n",
                d.at(0, from),
                d.at(0, to),
                d.at(1, 0.0),
                d.at(1, 0.0)
            )
        };
        side("glued", 0.0, 1.0) + &side("touching", 1.0, 2.0)
    };
    let [height, depth] = [d.between(0.3, 1.2), d.between(0.3, 1.2)];
    let upper = parts(d) + &d.topped([0.0, 2.0]);
    let lower = parts(d) + CLAMPED;
    let upper = d.block([0.0, 0.0], [2.0, height], &upper)?;
    let lower = d.block([0.0, -depth], [2.0, depth], &lower)?;
    // The other way round the bodies overlap at the end of the bond, and are refused.
    let mut keys = "law = \"bonded\"\n".to_owned();
    if d.on(0.5, "offset of a bond") {
        let offset = [d.random.signed(), d.random.unit()].map(|x| d.length * d.strain * x);
        let _ = writeln!(keys, "offset = {offset:?}");
    }
    d.pair([&upper, &lower], ["glued"; 2], &keys);
    d.pair([&upper, &lower], ["touching"; 2], "");
    Ok(Known::default())
}

/// Four blocks around a point, each bonded to its neighbours: the last bond closes the circle.
fn bonded_quarters(d: &mut Draw) -> Made<Known> {
    d.mark("corner of two pairs");
    d.triangles = (0.25 * d.triangles).max(8.0);
    let [x, y] = [d.between(0.7, 1.3), d.between(0.7, 1.3)];
    let a = d.block([0.0, 0.0], [x, y], CLAMPED)?;
    let pulled = d.random_traction("right");
    let b = d.block([x, 0.0], [2.0 - x, y], &pulled)?;
    let (top, _) = d.pressed([x, 2.0]);
    let c = d.block([x, y], [2.0 - x, 2.0 - y], &top)?;
    let e = d.block([0.0, y], [x, 2.0 - y], "")?;
    let open = d.random.unit() < 0.5;
    let bond = "law = \"bonded\"\n";
    d.pair([&a, &b], ["right", "left"], bond);
    d.pair([&b, &c], ["top", "bottom"], bond);
    d.pair([&c, &e], ["left", "right"], bond);
    if open {
        d.mark("contact beside a bond");
    }
    d.pair([&e, &a], ["bottom", "top"], if open { "" } else { bond });
    Ok(Known::default())
}

//! The scaling table of `cargo xtask bench --assemblies`: processor time of `check` and `solve` as the number of bodies, obstacles or pairs doubles.

use super::numbers::{exponent, spread_of};
use super::process;
use crate::workspace::{Outcome, Workspace};
use std::fmt::Write as _;

/// Doublings of each family.
const DOUBLINGS: u32 = 4;

/// A family of cases.
struct Family {
    name: &'static str,
    /// The last size.
    largest: usize,
    /// The exponent that it must not exceed.
    most: f64,
    case: fn(usize) -> String,
}

const FAMILIES: [Family; 4] = [
    Family { name: "masonry wall, blocks", largest: 2000, most: 1.6, case: wall },
    Family { name: "circles below one beam", largest: 256, most: 1.3, case: circles },
    Family { name: "blocks on one side", largest: 1024, most: 1.3, case: row },
    Family { name: "one pair of blocks, repeated", largest: 500, most: 1.3, case: pairs },
];

/// The beginning of every case.
const HEAD: &str = "schema = 1\n[materials.a]\nyoung = 1000.0\npoisson = 0.2\n[output]\nvtu = false\n";

fn block(text: &mut String, name: &str, [x, y]: [f64; 2], [w, h]: [f64; 2], [nx, ny]: [usize; 2]) {
    let _ = write!(
        text,
        "[[body]]\nname = \"{name}\"\nmaterial = \"a\"\ngenerator = {{ kind = \"block\", origin = [{x:?}, {y:?}], \
         size = [{w:?}, {h:?}], cells = [{nx}, {ny}] }}\n"
    );
}

fn condition(text: &mut String, kind: &str, side: &str, value: &str) {
    let _ = write!(text, "[[body.{kind}]]\non = \"{side}\"\n{value}\n");
}

fn contact(text: &mut String, bodies: [&str; 2], surfaces: [&str; 2]) {
    let _ = write!(text, "[[contact]]\nbodies = {bodies:?}\nsurfaces = {surfaces:?}\n");
}

/// A wall of about as many blocks of 4 or 8 cells in running bond, twice as wide as high, pressed from above and held at its ends.
fn wall(blocks: usize) -> String {
    let courses = ((blocks as f64 / 2.0).sqrt().round() as usize).max(2);
    let width = blocks / courses;
    let length = 2.0 * width as f64;
    let ends = |course: usize| -> Vec<f64> {
        let odd = course % 2;
        let inner = (1 - odd..width).map(|k| 2.0 * k as f64 + odd as f64);
        std::iter::once(0.0).chain(inner).chain([length]).collect()
    };
    let mut text = HEAD.to_owned();
    for course in 0..courses {
        for (k, x) in ends(course).windows(2).enumerate() {
            let size = [x[1] - x[0], 1.0];
            block(&mut text, &format!("b{course}_{k}"), [x[0], course as f64], size, [size[0] as usize, 2]);
            if course == 0 {
                condition(&mut text, "displacement", "bottom", "uy = 0.0");
            }
            for (side, place) in [("left", 0.0), ("right", length)] {
                if x[usize::from(side == "right")] == place {
                    condition(&mut text, "displacement", side, "ux = 0.0");
                }
            }
            if course + 1 == courses {
                condition(&mut text, "traction", "top", "pressure = 1.0");
            }
        }
    }
    for course in 0..courses {
        let own = ends(course);
        for k in 0..own.len() - 1 {
            let name = format!("b{course}_{k}");
            if k > 0 {
                contact(&mut text, [&format!("b{course}_{}", k - 1), &name], ["right", "left"]);
            }
            let below = if course > 0 { ends(course - 1) } else { Vec::new() };
            let faces = |x: &[f64]| x[0] < own[k + 1] && x[1] > own[k];
            for j in (0..below.len().saturating_sub(1)).filter(|j| faces(&below[*j..j + 2])) {
                contact(&mut text, [&name, &format!("b{}_{j}", course - 1)], ["bottom", "top"]);
            }
        }
    }
    text
}

/// A beam on as many circles, pressed from above.
fn circles(count: usize) -> String {
    let mut text = HEAD.to_owned();
    block(&mut text, "beam", [0.0, 0.0], [count as f64, 1.0], [2 * count, 1]);
    condition(&mut text, "traction", "top", "pressure = 1.0");
    condition(&mut text, "displacement", "left", "ux = 0.0");
    for k in 0..count {
        let centre = k as f64 + 0.5;
        let _ = write!(
            text,
            "[[contact]]\nbodies = [\"beam\"]\nsurfaces = [\"bottom\"]\nobstacle = {{ kind = \"circle\", centre = \
             [{centre:?}, -1.0], radius = 1.0 }}\ngap = \"geometric\"\n"
        );
    }
    text
}

/// Blocks side by side on one side of a body.
fn row(count: usize) -> String {
    let mut text = HEAD.to_owned();
    block(&mut text, "base", [0.0, 0.0], [2.0 * count as f64, 1.0], [2 * count, 1]);
    condition(&mut text, "displacement", "bottom", "fixed = true");
    for k in 0..count {
        block(&mut text, &format!("b{k}"), [2.0 * k as f64, 1.0], [1.0, 1.0], [2, 2]);
        condition(&mut text, "traction", "top", "pressure = 1.0");
        condition(&mut text, "displacement", "left", "ux = 0.0");
    }
    for k in 0..count {
        contact(&mut text, [&format!("b{k}"), "base"], ["bottom", "top"]);
    }
    text
}

/// Pairs of blocks that do not touch other pairs.
fn pairs(count: usize) -> String {
    let mut text = HEAD.to_owned();
    for k in 0..count {
        let x = 2.0 * k as f64;
        block(&mut text, &format!("lower{k}"), [x, 0.0], [1.0, 1.0], [2, 2]);
        condition(&mut text, "displacement", "bottom", "fixed = true");
        block(&mut text, &format!("upper{k}"), [x, 1.0], [1.0, 1.0], [2, 2]);
        condition(&mut text, "displacement", "left", "ux = 0.0");
        condition(&mut text, "traction", "top", "pressure = 1.0");
    }
    for k in 0..count {
        contact(&mut text, [&format!("upper{k}"), &format!("lower{k}")], ["bottom", "top"]);
    }
    text
}

/// Measures all families, and returns the table.
pub(super) fn table(workspace: &Workspace, runs: usize) -> Outcome<String> {
    let mut text = "\nMedian processor time of the whole process, seconds; the exponent is the slope of a line through the logarithms.\n\n\
                    | family | command | sizes | seconds | exponent | at most |\n|---|---|---|---|---|---|\n"
        .to_owned();
    for Family { name, largest, most, case } in FAMILIES {
        let sizes: Vec<usize> = (0..=DOUBLINGS).rev().map(|k| largest >> k).collect();
        for command in ["check", "solve"] {
            let mut points = Vec::new();
            for size in &sizes {
                println!("{command}: {name}, {size}");
                points.push([*size as f64, seconds(workspace, command, &case(*size), runs)?]);
            }
            let join = |of: usize, digits: usize| {
                points.iter().map(|p| format!("{:.digits$}", p[of])).collect::<Vec<_>>().join(", ")
            };
            let slope = exponent(&points).map_or("-".to_owned(), |p| format!("{p:.2}"));
            let _ =
                writeln!(text, "| {name} | {command} | {} | {} | {slope} | {most} |", join(0, 0), join(1, 2));
        }
    }
    Ok(text)
}

/// The median processor time of a command.
fn seconds(workspace: &Workspace, command: &str, text: &str, runs: usize) -> Outcome<f64> {
    let case = workspace.target.join("scaling.toml");
    workspace.write(&case, text)?;
    let mut all = Vec::new();
    for _ in 0..runs {
        let done = process::run(command, &workspace.nndd(), |run| {
            run.current_dir(&workspace.root).arg(command).arg(&case);
            if command == "solve" {
                run.arg("--quiet").arg("--out").arg(workspace.target.join("bench")).arg("--force");
            }
        })?;
        all.push(done.processor.unwrap_or(done.seconds));
    }
    spread_of(all).map(|[median, ..]| median).ok_or_else(|| format!("{command}: no runs"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_have_about_the_bodies_and_pairs_of_their_size() {
        let count = |text: &str, what: &str| text.matches(what).count();
        assert!(count(&wall(2000), "[[body]]").abs_diff(2000) < 60);
        assert_eq!(count(&circles(16), "[[contact]]"), 16);
        assert_eq!((count(&row(8), "[[body]]"), count(&row(8), "[[contact]]")), (9, 8));
        assert_eq!((count(&pairs(5), "[[body]]"), count(&pairs(5), "[[contact]]")), (10, 5));
    }
}

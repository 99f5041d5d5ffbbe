//! The `[[body]]` tables: names, meshes, displacements and tractions.

use super::body::file_stem;
use super::regions::regions;
use super::{
    BodyCase, CurveCase, Displacement, Imposition, Load, MeshSource, Part, RigidCase, SideCase, Traction,
    Value,
};
use super::{read_contact, side};
use crate::case_file::Reader;
use crate::diagnostic::{Diagnostic, code, excerpt};
use fem_core::body::CurveKind;
use fem_core::mesh::generate::Facing;
use std::collections::HashMap;

/// Reads the bodies.
pub(super) fn bodies(root: &mut Reader<'_>) -> Vec<BodyCase> {
    let Some(mut readers) = root.tables("body") else { return Vec::new() };
    let mut bodies = Vec::with_capacity(readers.len());
    let mut names = HashMap::new();
    for r in &mut readers {
        bodies.push(body(r, &mut names));
    }
    if bodies.is_empty() {
        root.refuse("body", "there is no body", "one [[body]] table or more", "write a [[body]]");
    }
    for r in readers {
        r.finish();
    }
    bodies
}

fn body(r: &mut Reader<'_>, others: &mut HashMap<String, String>) -> BodyCase {
    r.require(&["name", "material"]);
    let name = r.string("name");
    if let Some(name) = &name {
        check_name(r, name, others);
        others.entry(file_stem(name).to_lowercase()).or_insert_with(|| name.clone());
    }
    let name = name.unwrap_or_default();
    let material = r.string("material").unwrap_or_default();
    let mesh = mesh(r).unwrap_or_default();
    let regions = regions(r);
    let body_force = r.pair("body_force").unwrap_or_default();
    let mut sides = side::sides(r);
    let s = &mut sides;
    let displacements =
        r.tables("displacement").unwrap_or_default().into_iter().map(|r| displacement(r, s)).collect();
    let tractions = r.tables("traction").unwrap_or_default().into_iter().map(|r| traction(r, s)).collect();
    let rigid = r.tables("rigid").unwrap_or_default().into_iter().map(|r| rigid(r, s)).collect();
    let curves = r.tables("curve").unwrap_or_default().into_iter().filter_map(|r| curve(r, s)).collect();
    BodyCase { name, material, regions, mesh, body_force, displacements, tractions, sides, rigid, curves }
}

/// Bytes of the name of a body, at most: it also names files.
const LONGEST_NAME: usize = 100;

/// Checks that a name can name a file that no other has, on a file system that ignores case too.
///
/// * `others`: the names of the bodies before, by the stems of their files.
fn check_name(r: &Reader<'_>, name: &str, others: &HashMap<String, String>) {
    let forbidden = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    let stem = |name: &str| file_stem(name).to_lowercase();
    if name.trim().is_empty()
        || name.starts_with('.')
        || name.len() > LONGEST_NAME
        || name.contains(forbidden)
    {
        r.refuse(
            "name",
            format!("the body name {} cannot name a file", excerpt(name)),
            "at most 100 bytes of letters, digits, blanks, - and _",
            "name it after what it is, such as \"upper\"",
        );
    } else if stem(name) == "contact" || stem(name).starts_with("contact-") {
        r.refuse(
            "name",
            "a body cannot be called \"contact\" or \"contact-…\": these files are those of the contact lines",
            "another name",
            "name it after what it is, such as \"upper\"",
        );
    } else if let Some(other) = others.get(&stem(name)) {
        let message = if other.to_lowercase() == name.to_lowercase() {
            format!("two bodies are called {}", excerpt(name))
        } else {
            let [a, b] = [other.as_str(), name].map(excerpt);
            format!("the bodies {a} and {b} would write the same file, {}.vtu", file_stem(name))
        };
        let diagnostic = Diagnostic::new(code::DUPLICATE, r.place_of("name"), message);
        let expected = "two names that differ in letters or digits, not only in case, blanks or signs";
        r.findings().push(diagnostic.expected(expected).fix("rename one of the two"));
    }
}

fn mesh(r: &mut Reader<'_>) -> Option<MeshSource> {
    let source = r.table("generator").and_then(generator);
    let file = r.table("mesh").and_then(mesh_file);
    match (r.has("generator"), r.has("mesh")) {
        (true, true) => {
            let message = "a body has either a `generator` or a `mesh`, not both";
            r.refuse("mesh", message, "one of the two", "take one of them out");
        }
        (false, false) => {
            let expected = "`generator = { kind = \"block\", … }` or `mesh = { file = \"name.msh\", region = \"name\" }`";
            let fix =
                "write `generator = { kind = \"block\", size = [2.0, 1.0], cells = [18, 9] }` to begin with";
            r.refuse("", "this body has no mesh: neither `generator` nor `mesh` is there", expected, fix);
        }
        _ => {}
    }
    source.or(file)
}

fn mesh_file(mut r: Reader<'_>) -> Option<MeshSource> {
    r.require(&["file"]);
    let file = r.string("file");
    if file.as_ref().is_some_and(|name| name.trim().is_empty()) {
        let expected = "the name of a mesh file, relative to the case file";
        r.refuse("file", "`mesh.file` is empty", expected, "write it as in `file = \"blocks.msh\"`");
    }
    let region = r.names("region").unwrap_or_default();
    let merge = r.boolean("merge").unwrap_or(false);
    let duplicate_interface = r.boolean("duplicate_interface").unwrap_or(false);
    r.finish();
    Some(MeshSource::File { file: file?, region, merge, duplicate_interface })
}

/// The generators, each with its reader.
type Generator = fn(Reader<'_>) -> Option<MeshSource>;
const KINDS: &[(&str, Generator)] =
    &[("block", block), ("ring", ring), ("disc", disc), ("half_disc", half_disc)];

const FACINGS: &[(&str, Facing)] = &[("down", Facing::Down), ("up", Facing::Up)];

/// Writes the word of a direction.
pub(super) fn facing_name<S: serde::Serializer>(facing: &Facing, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(FACINGS.iter().find(|(_, f)| f == facing).map_or("", |(name, _)| name))
}

/// Reads the table of a generator.
pub(super) fn generator(mut r: Reader<'_>) -> Option<MeshSource> {
    // Without a kind the keys of a block are expected.
    let generator = if r.has("kind") { r.choice("kind", KINDS)? } else { block };
    generator(r)
}

fn ring(mut r: Reader<'_>) -> Option<MeshSource> {
    r.require(&["radii", "cells"]);
    let centre = r.pair("centre").unwrap_or_default();
    let radii = r.pair("radii");
    let angles = r.pair("angles").unwrap_or([0.0, 360.0]);
    let cells = r.count_pair("cells");
    r.finish();
    Some(MeshSource::Ring { centre, radii: radii?, angles, cells: cells? })
}

fn disc(mut r: Reader<'_>) -> Option<MeshSource> {
    r.require(&["radius", "cells"]);
    let centre = r.pair("centre").unwrap_or_default();
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    let cells = r.count("cells", 1);
    let start = r.number("start").unwrap_or(0.0);
    r.finish();
    Some(MeshSource::Disc { centre, radius: radius?, cells: cells?, start })
}

/// Half the width of the contact side of a half disc over its radius, at most.
const WIDEST: f64 = 0.3;

fn half_disc(mut r: Reader<'_>) -> Option<MeshSource> {
    r.require(&["radius", "facing", "half_width", "cells"]);
    let pole = r.pair("pole").unwrap_or_default();
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    let largest = WIDEST * radius.filter(|radius| *radius > 0.0).unwrap_or(f64::INFINITY);
    let half_width = r.number_where(
        "half_width",
        |width| width > 0.0 && width <= largest,
        "a number > 0, at most 0.3 times `radius`",
    );
    let facing = r.choice("facing", FACINGS);
    let cells = r.count("cells", 1);
    r.finish();
    Some(MeshSource::HalfDisc {
        pole,
        radius: radius?,
        facing: facing?,
        half_width: half_width?,
        cells: cells?,
    })
}

fn block(mut r: Reader<'_>) -> Option<MeshSource> {
    r.require(&["kind", "size", "cells"]);
    let origin = r.pair("origin").unwrap_or_default();
    let size = r.pair("size");
    if size.is_some_and(|s| s.iter().any(|&v| v <= 0.0)) {
        r.refuse(
            "size",
            "a block needs a width and a height",
            "two numbers > 0",
            "write it as in `size = [2.0, 1.0]`",
        );
    }
    let cells = r.count_pair("cells");
    r.finish();
    Some(MeshSource::Block { origin, size: size?, cells: cells? })
}

/// Reads `on`: the name of a side, or a list of names, which becomes a side of its own.
fn on(r: &mut Reader<'_>, sides: &mut Vec<SideCase>) -> String {
    r.require(&["on"]);
    let names = r.names("on").unwrap_or_default();
    if side::has_point(&names, sides) {
        r.refuse("on", ON_POINT, "a side with edges", "name a side, or select one with `box` or `facing`");
    }
    side::joined(names, sides)
}

/// Why a single node is refused.
const ON_POINT: &str =
    "a single node (`point` of a side) takes a [[body.displacement]] only: it has no length";

/// Reads `on` of a displacement: a side, a list of sides, or a single node.
fn on_displaced(r: &mut Reader<'_>, sides: &mut Vec<SideCase>) -> String {
    r.require(&["on"]);
    let names = r.names("on").unwrap_or_default();
    if side::has_point(&names, sides) {
        let expected = "`ux`, `uy` or `fixed` on it alone";
        if names.len() > 1 {
            let message = "a single node (`point` of a side) is in a list of sides";
            r.refuse("on", message, expected, "write a [[body.displacement]] of its own for it");
        }
        for key in ["normal", "part"].into_iter().filter(|key| r.has(key)) {
            let message = format!("a single node (`point` of a side) has no `{key}`");
            r.refuse(key, message, expected, &format!("take `{key}` out"));
        }
    }
    side::joined(names, sides)
}

fn displacement(mut r: Reader<'_>, sides: &mut Vec<SideCase>) -> Displacement {
    let name = r.string("name");
    let on = on_displaced(&mut r, sides);
    let part = Part::read(&mut r, "part");
    let given: Vec<&str> = ["ux", "uy", "normal", "fixed"].into_iter().filter(|key| r.has(key)).collect();
    let components = [r.value("ux"), r.value("uy")];
    let normal = r.value("normal");
    let fixed = r.boolean("fixed");
    let expected = "`ux` and/or `uy`, or `normal`, or `fixed = true`";
    match given[..] {
        [] => r.refuse(
            "",
            "this condition imposes no displacement",
            expected,
            "write `fixed = true` to hold it",
        ),
        ["ux"] | ["uy"] | ["ux", "uy"] | ["normal"] => {}
        ["fixed"] if fixed != Some(false) => {}
        ["fixed"] => {
            r.refuse("fixed", "`fixed = false` imposes nothing", expected, "take the whole condition out")
        }
        // The last of the keys is the one that does not go with the others.
        [.., last] => {
            let message = format!("`{}` exclude each other", given.join("`, `"));
            r.refuse(last, message, expected, &format!("take `{last}` out"));
        }
    }
    r.finish();
    let imposition = match (normal, fixed) {
        (Some(value), _) => Imposition::Normal(value),
        (None, Some(_)) => Imposition::Fixed,
        (None, None) => Imposition::Components(components),
    };
    Displacement { name, on, part, imposition }
}

fn rigid(mut r: Reader<'_>, sides: &mut Vec<SideCase>) -> RigidCase {
    let name = r.string("name");
    let on = on(&mut r, sides);
    let part = Part::read(&mut r, "part");
    let rigid = read_contact::rigid(&mut r);
    r.finish();
    RigidCase { name, on, part, rigid }
}

const CURVES: &[(&str, CurveKind)] = &[("arc", CurveKind::Arc), ("smooth", CurveKind::Smooth)];

/// Writes the word of a curve.
pub(super) fn curve_name<S: serde::Serializer>(kind: &CurveKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(CURVES.iter().find(|(_, k)| k == kind).map_or("", |(name, _)| name))
}

fn curve(mut r: Reader<'_>, sides: &mut Vec<SideCase>) -> Option<CurveCase> {
    let on = on(&mut r, sides);
    r.require(&["kind"]);
    let kind = if r.has("kind") { r.choice("kind", CURVES) } else { None };
    r.finish();
    Some(CurveCase { on, kind: kind? })
}

fn traction(mut r: Reader<'_>, sides: &mut Vec<SideCase>) -> Traction {
    let name = r.string("name");
    let on = on(&mut r, sides);
    let part = Part::read(&mut r, "part");
    let (vector, pressure) = (r.value_pair("vector"), r.value("pressure"));
    let expected = "either `vector = [tx, ty]` or `pressure = p`";
    match (r.has("vector"), r.has("pressure")) {
        (true, true) => r.refuse(
            "pressure",
            "`vector` and `pressure` exclude each other",
            expected,
            "take one of them out",
        ),
        (false, false) => r.refuse("", "this condition applies no load", expected, "write `pressure = 1.0`"),
        _ => {}
    }
    r.finish();
    let load = match (vector, pressure) {
        (Some(vector), _) => Load::Vector(vector),
        (None, pressure) => Load::Pressure(pressure.unwrap_or_else(Value::default)),
    };
    Traction { name, on, part, load }
}

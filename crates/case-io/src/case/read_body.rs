//! The `[[body]]` tables: names, meshes, displacements, tractions, springs and cuts.

use super::body::file_stem;
use super::cuts::cut;
use super::dimension::{Keys, refuse_foreign};
use super::names::{LONGEST_NAME, Names};
use super::regions::regions;
use super::springs::spring;
use super::{
    BodyCase, CurveCase, Displacement, Imposition, Load, MeshSource, Part, RigidCase, SideCase, SpringCase,
    Traction, Value,
};
use super::{inside, read_contact, side};
use crate::case_file::Reader;
use crate::diagnostic::{Diagnostic, code, excerpt};
use std::collections::HashMap;

/// Reads the bodies.
pub(super) fn bodies<S: Keys>(root: &mut Reader<'_>) -> Vec<BodyCase<S>> {
    let Some(mut readers) = root.tables("body") else { return Vec::new() };
    let mut bodies = Vec::with_capacity(readers.len());
    let (mut names, mut cuts) = (HashMap::new(), Names::default());
    for r in &mut readers {
        bodies.push(body::<S>(r, &mut names, &mut cuts));
    }
    if bodies.is_empty() {
        root.refuse("body", "there is no body", "one [[body]] table or more", "write a [[body]]");
    }
    for r in readers {
        r.finish();
    }
    bodies
}

fn body<S: Keys>(
    r: &mut Reader<'_>,
    others: &mut HashMap<String, String>,
    cut_names: &mut Names,
) -> BodyCase<S> {
    let foreign = refuse_foreign::<S>(r, "body");
    r.require(&["name", "material"]);
    let name = r.string("name");
    if let Some(name) = &name {
        check_name(r, name, others);
        others.entry(file_stem(name).to_lowercase()).or_insert_with(|| name.clone());
    }
    let name = name.unwrap_or_default();
    let material = r.string("material").unwrap_or_default();
    let mesh = mesh::<S>(r).unwrap_or_default();
    let regions = regions(r);
    let body_force = r.values::<S>("body_force").unwrap_or_else(|| S::data(|_| Value::default()));
    let body_force = S::data(|c| inside::value_inside(Some(body_force[c].clone()), r, "body_force"));
    let temperatures =
        r.tables("temperature").unwrap_or_default().into_iter().map(inside::temperature).collect();
    let mut sides = side::sides::<S>(r);
    let s = &mut sides;
    let displacements =
        r.tables("displacement").unwrap_or_default().into_iter().map(|r| displacement(r, s)).collect();
    let tractions = r.tables("traction").unwrap_or_default().into_iter().map(|r| traction(r, s)).collect();
    let rigid = r.tables("rigid").unwrap_or_default().into_iter().map(|r| rigid(r, s)).collect();
    let springs = r.tables("spring").unwrap_or_default().into_iter().map(|r| on_springs(r, s)).collect();
    let cuts = r.tables("cut").unwrap_or_default();
    let cuts = cuts.into_iter().filter_map(|r| cut(r, cut_names)).collect();
    let curves = if foreign { None } else { r.tables(S::CURVE_TABLE) };
    let curves = curves.unwrap_or_default().into_iter().filter_map(|r| curve(r, s)).collect();
    BodyCase {
        name,
        material,
        regions,
        mesh,
        body_force,
        temperatures,
        displacements,
        tractions,
        sides,
        rigid,
        springs,
        cuts,
        curves,
    }
}

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

fn mesh<S: Keys>(r: &mut Reader<'_>) -> Option<MeshSource<S>> {
    let source = r.table("generator").and_then(generator::<S>).map(MeshSource::Generator);
    let file = r.table("mesh").and_then(mesh_file);
    match (r.has("generator"), r.has("mesh")) {
        (true, true) => {
            let message = "a body has either a `generator` or a `mesh`, not both";
            r.refuse("mesh", message, "one of the two", "take one of them out");
        }
        (false, false) => {
            let [expected, fix] = S::MESH;
            r.refuse("", "this body has no mesh: neither `generator` nor `mesh` is there", expected, fix);
        }
        _ => {}
    }
    source.or(file)
}

fn mesh_file<S: Keys>(mut r: Reader<'_>) -> Option<MeshSource<S>> {
    r.require(&["file"]);
    let file = r.string("file");
    if file.as_ref().is_some_and(|name| name.trim().is_empty()) {
        let expected = "the name of a mesh file, relative to the case file";
        r.refuse("file", "`mesh.file` is empty", expected, "write it as in `file = \"blocks.msh\"`");
    }
    let region = r.names("region").unwrap_or_default();
    let merge = r.boolean("merge").unwrap_or(false);
    let duplicate_interface = r.boolean("duplicate_interface").unwrap_or(false);
    let connected_to = r.string("connected_to");
    r.finish();
    Some(MeshSource::File { file: file?, region, merge, duplicate_interface, connected_to })
}

/// Reads the table of a generator.
pub(super) fn generator<S: Keys>(mut r: Reader<'_>) -> Option<S::Generator> {
    if refuse_foreign::<S>(&mut r, "generator") {
        return None;
    }
    // Without a kind the keys of the first are expected.
    let [(_, first), ..] = S::GENERATORS else { return None };
    let generator = if r.has("kind") { r.choice("kind", S::GENERATORS)? } else { *first };
    generator(r)
}

/// Reads `on`: the name of a side, or a list of names, which becomes a side of its own.
fn on<S: Keys>(r: &mut Reader<'_>, sides: &mut Vec<SideCase<S>>) -> String {
    r.require(&["on"]);
    let names = r.names("on").unwrap_or_default();
    if side::has_point(&names, sides) {
        let expected = format!("a side with {}", S::WORDS.facets);
        let message = format!(
            "a single node (`point` of a side) takes a [[body.displacement]] only: it has no {}",
            S::EXTENT
        );
        r.refuse("on", message, &expected, "name a side, or select one with `box` or `facing`");
    }
    side::joined(names, sides)
}

/// Reads `on` of a displacement: a side, a list of sides, or a single node.
fn on_displaced<S: Keys>(r: &mut Reader<'_>, sides: &mut Vec<SideCase<S>>) -> String {
    r.require(&["on"]);
    let names = r.names("on").unwrap_or_default();
    if side::has_point(&names, sides) {
        let expected = format!("{} or `fixed` on it alone", components::<S>(", ", ", "));
        let expected = expected.as_str();
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

/// Lists the keys of the components of a displacement.
///
/// * `last`: what is before the last one.
fn components<S: Keys>(between: &str, last: &str) -> String {
    let keys: Vec<String> = S::MOTIONS.iter().take(S::DIM).map(|key| format!("`{key}`")).collect();
    match &keys[..] {
        [all @ .., end] => format!("{}{last}{end}", all.join(between)),
        [] => String::new(),
    }
}

fn displacement<S: Keys>(mut r: Reader<'_>, sides: &mut Vec<SideCase<S>>) -> Displacement<S> {
    let name = r.string("name");
    let on = on_displaced(&mut r, sides);
    let part = Part::read(&mut r, "part");
    let axes = &S::MOTIONS[..S::DIM];
    let keys = axes.iter().chain(&["normal", "fixed"]);
    let given: Vec<&str> = keys.copied().filter(|key| r.has(key)).collect();
    let imposed = S::data(|c| r.value(axes[c]));
    let normal = r.value("normal");
    let fixed = r.boolean("fixed");
    let expected = format!("{}, or `normal`, or `fixed = true`", components::<S>(", ", " and/or "));
    let expected = expected.as_str();
    match given[..] {
        [] => r.refuse(
            "",
            "this condition imposes no displacement",
            expected,
            "write `fixed = true` to hold it",
        ),
        ["normal"] => {}
        _ if given.iter().all(|key| axes.contains(key)) => {}
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
        (None, None) => Imposition::Components(imposed),
    };
    Displacement { name, on, part, imposition }
}

fn rigid<S: Keys>(mut r: Reader<'_>, sides: &mut Vec<SideCase<S>>) -> RigidCase<S> {
    let name = r.string("name");
    let on = on(&mut r, sides);
    let part = Part::read(&mut r, "part");
    let rigid = read_contact::rigid(&mut r);
    r.finish();
    RigidCase { name, on, part, rigid }
}

fn on_springs<S: Keys>(mut r: Reader<'_>, sides: &mut Vec<SideCase<S>>) -> SpringCase<S> {
    let name = r.string("name");
    let on = on(&mut r, sides);
    let part = Part::read(&mut r, "part");
    spring(r, name, on, part)
}

fn curve<S: Keys>(mut r: Reader<'_>, sides: &mut Vec<SideCase<S>>) -> Option<CurveCase<S>> {
    let on = on(&mut r, sides);
    r.require(&["kind"]);
    let kind = if r.has("kind") { r.choice("kind", S::CURVES) } else { None };
    r.finish();
    Some(CurveCase { on, kind: kind? })
}

fn traction<S: Keys>(mut r: Reader<'_>, sides: &mut Vec<SideCase<S>>) -> Traction<S> {
    let name = r.string("name");
    let on = on(&mut r, sides);
    let part = Part::read(&mut r, "part");
    let (vector, pressure) = (r.values::<S>("vector"), r.value("pressure"));
    let vector_of: Vec<String> = S::COORDINATES.iter().map(|c| format!("t{c}")).collect();
    let expected = format!("either `vector = [{}]` or `pressure = p`", vector_of.join(", "));
    let expected = expected.as_str();
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

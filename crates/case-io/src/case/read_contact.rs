//! The `[[contact]]` tables.

use super::contact::{CircleSide, Contact, Friction, Obstacle, Rigid, Shape};
use super::dimension::{Keys, refuse_foreign};
use super::names::Names;
use super::side::{Cylinder, cylinder_keys, has_point, joined, up};
use super::{BodyCase, Imposed, Value};
use crate::case_file::{NodeValue, Reader};
use crate::diagnostic::{Diagnostic, code, did_you_mean, excerpt};
use mesh_io::words::listed;
use std::collections::{BTreeSet, HashMap};

/// The key of a rotation.
const ROTATION: &str = "rotation";

/// The gap between the meshes, measured.
pub(super) const GEOMETRIC: &str = "geometric";

/// The law of surfaces that hang together.
pub(super) const BONDED: &str = "bonded";

/// Reads the pairs: an array of tables, or one table if there are two bodies.
pub(super) fn contacts<S: Keys>(root: &mut Reader<'_>, bodies: &mut [BodyCase<S>]) -> Vec<Contact<S>> {
    let single = matches!(root.node("contact").map(|n| &n.value), Some(NodeValue::Table(_)));
    let readers = if single {
        root.table("contact").into_iter().collect()
    } else {
        root.tables("contact").unwrap_or_default()
    };
    let only = readers.len() == 1;
    let mut found: Vec<Contact<S>> = Vec::new();
    let (mut names, mut pairs) = (Names::default(), HashMap::new());
    let numbers = numbers(bodies);
    for (k, mut r) in readers.into_iter().enumerate() {
        let path = if single { "contact".to_owned() } else { format!("contact.{k}") };
        let mut contact = contact(&mut r, (bodies, &numbers), only, path);
        match r.string("name") {
            Some(name) => {
                names.check(&r, &name, "pair", "rename it, or leave `name` out");
                (contact.name, contact.named) = (name, true);
            }
            None => contact.name = names.free(std::mem::take(&mut contact.name)),
        }
        names.take(&contact.name);
        if contact.obstacle.is_none() {
            let members: BTreeSet<(usize, String)> =
                contact.bodies.iter().copied().zip(contact.surfaces.iter().cloned()).collect();
            let first: usize = *pairs.entry(members).or_insert(found.len());
            if first < found.len() && contact.bodies.len() == 2 {
                let message = format!("this is the pair {} again", excerpt(&found[first].name));
                r.refuse("surfaces", message, "each pair of sides once", "take one of the two out");
            }
        }
        r.finish();
        found.push(contact);
    }
    found
}

/// The number of each body by its name, the first one if there are two.
fn numbers<S: Keys>(bodies: &[BodyCase<S>]) -> HashMap<String, usize> {
    let names = bodies.iter().enumerate().rev();
    names.map(|(number, body)| (body.name.clone(), number)).collect()
}

/// Reads one pair, with its default name.
fn contact<S: Keys>(
    r: &mut Reader<'_>,
    (bodies, numbers): (&mut [BodyCase<S>], &HashMap<String, usize>),
    only: bool,
    path: String,
) -> Contact<S> {
    let foreign = refuse_foreign::<S>(r, "contact");
    let named = r.strings("bodies");
    let obstacle = r.table("obstacle").and_then(obstacle::<S>);
    let against = r.has("obstacle");
    r.require(&["surfaces"]);
    let members: Vec<usize> = match &named {
        Some(names) => {
            names.iter().enumerate().filter_map(|(k, name)| number(r, (bodies, numbers), k, name)).collect()
        }
        None if !against && only && bodies.len() == 2 => vec![0, 1],
        None if against && bodies.len() == 1 => vec![0],
        None => {
            if !r.has("bodies") {
                r.require(&["bodies"]);
            }
            Vec::new()
        }
    };
    let wanted = if against { 1 } else { 2 };
    let counted = |what: &str| match wanted {
        1 => format!("one {what}: the other partner is the obstacle"),
        _ => format!("two {what}s, or one and an `obstacle`"),
    };
    if let Some(names) = named.as_ref().filter(|names| names.len() != wanted) {
        let message = format!("`{}` has {} entries", r.path_of("bodies"), names.len());
        r.refuse(
            "bodies",
            message,
            &counted("body").replace("bodys", "bodies"),
            "name the bodies that touch",
        );
    } else if members.len() == 2 && members[0] == members[1] {
        let message = "a body cannot touch itself";
        r.refuse("bodies", message, "two different bodies", "name the other body, or split this one in two");
    }
    let surfaces = r.lists_of_strings("surfaces");
    if let Some(surfaces) = surfaces.as_ref().filter(|surfaces| surfaces.len() != wanted) {
        let message = format!("`{}` has {} entries", r.path_of("surfaces"), surfaces.len());
        r.refuse(
            "surfaces",
            message,
            &counted("side"),
            "name a side of each body, in the order of the bodies",
        );
    }
    let (gap, geometric, interference) = gap(r);
    let normal = if foreign { None } else { r.axes::<S>(S::DIRECTION) };
    if normal == Some(S::axes(|_| 0.0)) {
        r.refuse(
            S::DIRECTION,
            format!("`{}` has no direction", r.path_of(S::DIRECTION)),
            "a direction out of the first body, such as [0.0, -1.0]",
            "leave it out: normals are averaged at the nodes then",
        );
    }
    let imposed = r.choice("imposed", Imposed::NAMES);
    let friction = if foreign { None } else { friction(r) };
    let bond = bond::<S>(r, against);
    let motion = r.axes::<S>("motion");
    let obstacle = against_obstacle::<S>(r, obstacle, motion);
    let name = |b: &usize| bodies.get(*b).map_or("", |body| body.name.as_str());
    let name = match members[..] {
        [a] if against => format!("{}-obstacle", name(&a)),
        [a, b] => format!("{}-{}", name(&a), name(&b)),
        _ => String::new(),
    };
    let joined = |(entry, names): (usize, Vec<String>)| match members.get(entry) {
        Some(body) => {
            let sides = &mut bodies[*body].sides;
            if has_point(&names, sides) {
                let message = format!(
                    "a single node (`point` of a side) is no contact surface: it has no {}",
                    S::EXTENT
                );
                let expected = format!("sides with {}", S::WORDS.facets);
                r.refuse("surfaces", message, &expected, "name the sides that touch");
            }
            joined(names, sides)
        }
        None => names.concat(),
    };
    let surfaces = surfaces.unwrap_or_default().into_iter().enumerate().map(joined).collect();
    Contact {
        name,
        bodies: members,
        surfaces,
        obstacle,
        named: false,
        gap,
        geometric,
        interference,
        bond,
        normal,
        imposed,
        friction,
        path,
    }
}

/// Reads the gap of a pair: a number or an expression, whether it is measured, and whether an overlap that is drawn is kept.
fn gap(r: &mut Reader<'_>) -> (Value, bool, bool) {
    let geometric = matches!(r.node("gap").map(|n| &n.value), Some(NodeValue::String(s)) if s == GEOMETRIC);
    let gap = if geometric { Value::default() } else { r.value_beside("gap", GEOMETRIC).unwrap_or_default() };
    let interference = r.boolean("interference") == Some(true);
    if interference && !geometric && r.has("gap") {
        let message =
            format!("`{}` keeps an overlap that is drawn, and the gap is given", r.path_of("interference"));
        let fix = "write `gap = \"geometric\"`, or take `interference` out: a negative gap is an interference already";
        r.refuse("interference", message, "a gap that is measured", fix);
    }
    (gap, geometric || interference, interference)
}

/// Reads the law of a pair: `None` if its sides touch and part, and the offset if they are bonded.
fn bond<S: Keys>(r: &mut Reader<'_>, against: bool) -> Option<S::Axes<f64>> {
    let bonded = r.choice("law", &[("unilateral", false), (BONDED, true)]).unwrap_or_default();
    let offset = r.axes::<S>("offset");
    if !bonded {
        if offset.is_some() {
            let message =
                format!("`{}` is the jump of a bond, and this pair is not bonded", r.path_of("offset"));
            r.refuse("offset", message, "a pair with `law = \"bonded\"`", "take it out, or add the law");
        }
        return None;
    }
    if against {
        let message = "a body cannot be bonded to an obstacle";
        let fix = "hold its side by a [[body.displacement]] or a [[body.rigid]]";
        r.refuse("law", message, "two bodies", fix);
        return None;
    }
    let without = ["friction", "gap", "interference", "imposed", S::DIRECTION];
    for key in without.into_iter().filter(|key| r.has(key)) {
        let message = format!("`{}` has no meaning in a bonded pair", r.path_of(key));
        r.refuse(key, message, "a bonded pair with `offset` at most", "take it out");
    }
    Some(offset.unwrap_or(S::axes(|_| 0.0)))
}

/// The laws of friction, each with its reader.
type Law = fn(&mut Reader<'_>) -> Option<Friction>;
const LAWS: &[(&str, Law)] = &[("tresca", tresca), ("coulomb", coulomb)];

fn friction(r: &mut Reader<'_>) -> Option<Friction> {
    let coefficient = match r.node("friction").map(|n| &n.value) {
        Some(NodeValue::Float(value)) => Some(*value),
        Some(NodeValue::Integer(value)) => Some(*value as f64),
        _ => None,
    };
    if let Some(mu) = coefficient {
        let message = format!("`{}` is a number, and friction is a law", r.path_of("friction"));
        let fix = format!("write `friction = {{ law = \"coulomb\", mu = {mu:?} }}`");
        r.refuse("friction", message, "a table with `law`", &fix);
        return None;
    }
    let mut r = r.table("friction")?;
    r.require(&["law"]);
    let law = r.choice("law", LAWS).and_then(|read| read(&mut r));
    r.finish();
    law
}

fn tresca(r: &mut Reader<'_>) -> Option<Friction> {
    r.require(&["limit"]);
    let limit = r.value("limit")?;
    if limit.number().is_some_and(|limit| limit < 0.0) {
        let message = format!("`{}` is negative", r.path_of("limit"));
        r.refuse("limit", message, "a number >= 0, or an expression", "write its absolute value");
    }
    Some(Friction::Tresca { limit })
}

fn coulomb(r: &mut Reader<'_>) -> Option<Friction> {
    r.require(&["mu"]);
    let mu = r.number_where("mu", |mu| mu >= 0.0, "a number >= 0");
    Some(Friction::Coulomb { mu: mu.unwrap_or_default() })
}

/// Checks what an obstacle excludes, and gives it its motion.
fn against_obstacle<S: Keys>(
    r: &Reader<'_>,
    obstacle: Option<Obstacle<S>>,
    motion: Option<S::Axes<f64>>,
) -> Option<Obstacle<S>> {
    if !r.has("obstacle") {
        if r.has("motion") {
            let expected = "a pair with an `obstacle`";
            r.refuse(
                "motion",
                "`motion` moves an obstacle, and this pair has no obstacle",
                expected,
                "take it out",
            );
        }
        return None;
    }
    for key in ["normal", "imposed"].into_iter().filter(|key| r.has(key)) {
        let message = format!("`{}` has no meaning against an obstacle", r.path_of(key));
        let expected = "the obstacle's own normal; the obstacle carries lambda";
        r.refuse(key, message, expected, "take it out");
    }
    let mut obstacle = obstacle?;
    if let Some(by) = motion {
        if obstacle.rigid != Rigid::default() {
            let message = "`motion` and a rigid motion inside `obstacle` exclude each other";
            let keys = S::MOTIONS[..S::DIM].join(", ");
            let fix = format!("write {keys} and {ROTATION} inside `obstacle`");
            r.refuse("motion", message, "one of the two", &fix);
        }
        obstacle.rigid.motion = S::components(|k| Some(if k < S::DIM { by[k] } else { 0.0 }));
    }
    if obstacle.rigid == Rigid::default() {
        obstacle.rigid.motion = S::components(|_| Some(0.0));
    }
    Some(obstacle)
}

/// Finds a body by its name.
fn number<S: Keys>(
    r: &Reader<'_>,
    (bodies, numbers): (&[BodyCase<S>], &HashMap<String, usize>),
    entry: usize,
    name: &str,
) -> Option<usize> {
    let found = numbers.get(name).copied();
    if found.is_none() {
        let message = format!("`{}.{entry}` is {}, which is no body", r.path_of("bodies"), excerpt(name));
        let mut diagnostic = Diagnostic::new(code::REFERENCE, r.place_of("bodies"), message);
        if !r.findings().are_many() {
            let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
            let all = format!("one of the bodies {}", listed(&names));
            diagnostic = diagnostic.expected(all).help(did_you_mean(name, names, '"'));
        }
        r.findings().push(diagnostic.fix("write the name of a [[body]]"));
    }
    found
}

/// The reader of a shape of obstacles.
type Kind<S> = fn(&mut Reader<'_>) -> Option<Shape<S>>;
const SIDES: &[(&str, CircleSide)] = &[("outside", CircleSide::Outside), ("inside", CircleSide::Inside)];

fn obstacle<S: Keys>(mut r: Reader<'_>) -> Option<Obstacle<S>> {
    r.require(&["kind"]);
    if refuse_foreign::<S>(&mut r, "obstacle") {
        return None;
    }
    let kinds: [(&'static str, Kind<S>); 3] = [("plane", plane), (S::CIRCLE, circle), ("cylinder", cylinder)];
    let kinds = if S::CYLINDERS { &kinds[..] } else { &kinds[..2] };
    // The other keys are those of the kind.
    let read = r.choice("kind", kinds)?;
    let shape = read(&mut r);
    let rigid = rigid(&mut r);
    r.finish();
    Some(Obstacle { shape: shape?, rigid })
}

fn plane<S: Keys>(r: &mut Reader<'_>) -> Option<Shape<S>> {
    r.require(&["point", "normal"]);
    let (point, normal) = (r.axes::<S>("point"), r.axes::<S>("normal"));
    if normal == Some(S::axes(|_| 0.0)) {
        let message = format!("`{}` has no direction", r.path_of("normal"));
        r.refuse(
            "normal",
            message,
            "a direction out of the obstacle",
            &format!("write it as in `normal = {}`", up::<S>()),
        );
    }
    Some(Shape::Plane { point: point?, normal: normal? })
}

fn circle<S: Keys>(r: &mut Reader<'_>) -> Option<Shape<S>> {
    r.require(&["centre", "radius"]);
    let centre = r.axes::<S>("centre");
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    let side = r.choice("side", SIDES).unwrap_or_default();
    Some(Shape::Circle { centre: centre?, radius: radius?, side })
}

fn cylinder<S: Keys>(r: &mut Reader<'_>) -> Option<Shape<S>> {
    let read = cylinder_keys::<S>(r);
    let side = r.choice("side", SIDES).unwrap_or_default();
    let Cylinder { point, axis, radius } = read?;
    Some(Shape::Cylinder { point, axis, radius, side })
}

/// Reads the motion and the load of something rigid.
pub(super) fn rigid<S: Keys>(r: &mut Reader<'_>) -> Rigid<S> {
    let displacement = S::axes(|c| r.number(S::MOTIONS[c]));
    let rotation = S::spin(r, ROTATION).map(|spin| S::motion(S::Vector::default(), spin));
    let rigid = Rigid::<S> {
        motion: S::components(|k| if k < S::DIM { displacement[k] } else { rotation.map(|of| of[k]) }),
        force: r.axes::<S>("force"),
        moment: S::spin(r, "moment"),
        about: r.axes::<S>("about"),
    };
    let load = S::motion(rigid.force(), rigid.moment.unwrap_or_default());
    let loaded = |k: &usize| load[*k] != 0.0 && rigid.motion[*k].is_some();
    let translations = (0..S::DIM).filter(loaded).map(|k| S::MOTIONS[k]);
    let rotations = (S::DIM..S::COMPONENTS).find(loaded).map(|_| ROTATION);
    for key in translations.chain(rotations) {
        let message = format!("`{}` is imposed, and a load acts along it", r.path_of(key));
        r.refuse(key, message, "one of the two", "take one of the two out");
    }
    rigid
}

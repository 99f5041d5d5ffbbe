//! Sides by their place, and lists of names.

use crate::Case;
use crate::case::AnyCase;
use fem_core::mesh::TriMesh;
use fem_core::space::Solid;

fn case(body: &str, contact: &str) -> String {
    format!(
        "schema = 1\n{contact}\n[materials.m]\nyoung = 1.0\npoisson = 0.3\n[[body]]\nname = \"a\"\nmaterial = \"m\"\n{body}"
    )
}

fn mesh(body: &str) -> TriMesh {
    let case = Case::parse(&case(body, "contact = []"), "case.toml", &[]).unwrap();
    case.build_bodies().unwrap()[0].mesh().clone()
}

fn refused(body: &str) -> String {
    let text = case(body, "contact = []");
    match Case::parse(&text, "case.toml", &[]) {
        Ok(case) => case.build_bodies().unwrap_err().to_string(),
        Err(error) => error.to_string(),
    }
}

const BLOCK: &str = "generator = { kind = \"block\", size = [2.0, 1.0], cells = [4, 2] }\n";

#[test]
fn sides_are_selected_by_box_direction_and_circle() {
    let sides = "[[body.side]]\nname = \"low\"\nfacing = [0.0, -2.0]\n\
                 [[body.side]]\nname = \"right half\"\nfacing = [0.0, 1.0]\nwithin = 1.0\nbox = { x = [1.0, 3.0] }\n\
                 [[body.side]]\nname = \"lower part\"\nbox = { y = [-1.0, 0.5] }\n";
    let mesh = mesh(&(BLOCK.to_owned() + sides));
    assert_eq!(mesh.group("low"), mesh.group("bottom"));
    assert_eq!(mesh.group("right half").unwrap().len(), 2);
    // The bottom, and half of each of the two sides.
    assert_eq!(mesh.group("lower part").unwrap().len(), 6);
    let ring = "generator = { kind = \"ring\", radii = [1.0, 2.0], cells = [24, 2] }\n\
                [[body.side]]\nname = \"hole\"\ncircle = { centre = [0.0, 0.0], radius = 1.0 }\n\
                [[body.side]]\nname = \"upper rim\"\ncircle = { centre = [0.0, 0.0], radius = 2.0 }\nfacing = [0.0, 1.0]\nwithin = 45.0\n";
    let mesh = self::mesh(ring);
    assert_eq!(mesh.group("hole"), mesh.group("inner"));
    assert_eq!(mesh.group("upper rim").unwrap().len(), 6);
}

#[test]
fn a_list_of_names_is_a_side() {
    let text = BLOCK.to_owned()
        + "[[body.displacement]]\non = [\"left\", \"bottom\"]\nfixed = true\n[[body.traction]]\non = [\"top\"]\npressure = 1.0\n";
    let case = Case::parse(&case(&text, "contact = []"), "case.toml", &[]).unwrap();
    let bodies = case.build_bodies().unwrap();
    assert_eq!(bodies[0].supports()[0].nodes.len(), 4 + 3);
    assert_eq!(case.bodies[0].displacements[0].on, "left + bottom");
    assert_eq!(case.bodies[0].tractions[0].on, "top");
}

#[test]
fn a_contact_may_join_sides() {
    let two = "[[body]]\nname = \"b\"\nmaterial = \"m\"\ngenerator = { kind = \"block\", origin = [0.0, -1.0], size = [2.0, 1.0], \
               cells = [4, 2] }\n[[body.displacement]]\non = \"bottom\"\nfixed = true\n\
               [[body.side]]\nname = \"first\"\nbox = { x = [0.0, 1.0] }\nfacing = [0.0, 1.0]\n\
               [[body.side]]\nname = \"second\"\nbox = { x = [1.0, 2.0] }\nfacing = [0.0, 1.0]\n\
               [contact]\nsurfaces = [\"bottom\", [\"first\", \"second\"]]\n";
    let text = case(&(BLOCK.to_owned() + two), "");
    let case = Case::parse(&text, "case.toml", &[]).unwrap();
    let problem = case.build().unwrap().0;
    assert_eq!(problem.contacts[0].interface.pairs().len(), 5);
}

#[test]
fn a_side_may_be_a_single_node() {
    let pin = "[[body.side]]\nname = \"pin\"\npoint = [2.0, 1.0]\n";
    let on = |condition: &str| format!("{BLOCK}{pin}{condition}");
    let held = on("[[body.displacement]]\non = \"pin\"\nux = 0.5\n");
    let bodies = Case::parse(&case(&held, "contact = []"), "case.toml", &[]).unwrap().build_bodies().unwrap();
    let nodes = &bodies[0].supports()[0].nodes;
    assert_eq!(nodes.len(), 1);
    assert_eq!(<[f64; 2]>::from(bodies[0].mesh().points()[nodes[0]]), [2.0, 1.0]);
    assert!(bodies[0].mesh().group("pin").is_none());
    for (condition, words) in [
        ("[[body.traction]]\non = \"pin\"\npressure = 1.0\n", "takes a [[body.displacement]] only"),
        ("[[body.rigid]]\non = \"pin\"\n", "takes a [[body.displacement]] only"),
        ("[[body.curve]]\non = \"pin\"\nkind = \"arc\"\n", "takes a [[body.displacement]] only"),
        ("[[body.displacement]]\non = \"pin\"\nnormal = 0.0\n", "has no `normal`"),
        ("[[body.displacement]]\non = \"pin\"\nfixed = true\npart = { x = [0, 1] }\n", "has no `part`"),
        ("[[body.displacement]]\non = [\"left\", \"pin\"]\nfixed = true\n", "is in a list of sides"),
        ("[[body.side]]\nname = \"x\"\npoint = [0, 0]\nfacing = [0, 1]\n", "`facing` takes edges"),
    ] {
        let found = refused(&on(condition));
        assert!(found.contains(words), "{found}");
    }
    let surface = case(
        &on(""),
        "contact = { bodies = [\"a\"], surfaces = [\"pin\"], obstacle = { kind = \"plane\" } }",
    );
    let found = Case::parse(&surface, "case.toml", &[]).unwrap_err().to_string();
    assert!(found.contains("is no contact surface"), "{found}");
}

#[test]
fn faults_of_sides_have_their_places() {
    let side = |text: &str| refused(&format!("{BLOCK}[[body.side]]\n{text}"));
    assert!(side("name = \"x\"\n").contains("this side takes no edges"));
    assert!(side("name = \"top\"\nfacing = [0.0, 1.0]\n").contains("its mesh has a side \"top\""));
    assert!(side("name = \"x\"\nfacing = [0.0, 0.0]\n").contains("has no direction"));
    assert!(side("name = \"x\"\nwithin = 10.0\nbox = { x = [0.0, 1.0] }\n").contains("angle about `facing`"));
    let off = side("name = \"x\"\ncircle = { centre = [1.0, 0.5], radius = 0.4 }\n");
    assert!(off.contains("no boundary edge") && off.contains("off the circle"), "{off}");
    let unknown = refused(&format!("{BLOCK}[[body.traction]]\non = [\"top\", \"lft\"]\npressure = 1.0\n"));
    assert!(unknown.contains("there is no side \"lft\"") && unknown.contains("\"left\""), "{unknown}");
}

/// A tube around the z axis, with other conditions.
fn tube(sides: &str) -> String {
    format!(
        "schema = 1\ncontact = []\n[materials.m]\nyoung = 1.0\npoisson = 0.3\n[[body]]\nname = \"a\"\nmaterial = \"m\"\n\
         generator = {{ kind = \"tube\", origin = [1, 2, 0], radii = [1, 1.8], length = 2, angles = [0, 360], cells = [12, 1, 2] }}\n\
         {sides}[[body.displacement]]\non = \"bottom\"\nfixed = true\n"
    )
}

fn solid(text: &str) -> Result<Case<Solid>, crate::CaseError> {
    match AnyCase::parse(text, "case.toml", &[])? {
        AnyCase::Solid(case) => Ok(*case),
        AnyCase::Plane(_) => panic!("a plane case"),
    }
}

#[test]
fn sides_of_solids_are_selected_by_every_shape() {
    let text = tube(
        "[[body.side]]\nname = \"bore\"\ncylinder = { point = [1, 2, 7], axis = [0, 0, -2], radius = 1.0 }\n\
         [[body.side]]\nname = \"half\"\ncylinder = { point = [1, 2, 0], axis = [0, 0, 1], radius = 1.8 }\nbox = { z = [0, 1] }\n\
         [[body.side]]\nname = \"up\"\nfacing = [0, 0, 1]\nwithin = 1\n\
         [[body.side]]\nname = \"rim\"\nsphere = { centre = [1, 2, 0], radius = 1.8 }\nbox = { z = [-1, 1] }\n",
    );
    // No face has all its corners on the sphere.
    let found = solid(&text).unwrap().build_bodies().unwrap_err().to_string();
    assert!(found.contains("\"rim\"") && found.contains("off the sphere"), "{found}");
    let text = text.split("[[body.side]]\nname = \"rim\"").next().unwrap().to_owned()
        + "[[body.displacement]]\non = \"bottom\"\nfixed = true\n";
    let case = solid(&text).unwrap();
    let bodies = case.build_bodies().unwrap();
    let mesh = bodies[0].mesh();
    let same = |a: &str, b: &str| assert_eq!(mesh.group(a), mesh.group(b), "{a} {b}");
    same("bore", "inner");
    same("up", "top");
    let [half, outer] = ["half", "outer"].map(|name| mesh.group(name).unwrap());
    assert_eq!(2 * half.len(), outer.len());
    assert!(half.iter().all(|facet| outer.contains(facet)));
    let written = serde_json::to_value(&case.bodies[0].sides[0]).unwrap();
    assert_eq!(written["cylinder"]["radius"], 1.0);
    let wrong = |side: &str| {
        let text = tube(&format!("[[body.side]]\nname = \"x\"\ncylinder = {{ {side} }}\n"));
        solid(&text).and_then(|case| case.build_bodies().map(|_| ())).unwrap_err().to_string()
    };
    assert!(wrong("point = [0, 0, 0], axis = [0, 0, 0], radius = 1").contains("has no direction"));
    assert!(wrong("point = [0, 0, 0], axis = [0, 0, 1]").contains("radius"));
    assert!(wrong("point = [0, 2, 0], axis = [0, 0, 1], radius = 1").contains("off the cylinder"));
}

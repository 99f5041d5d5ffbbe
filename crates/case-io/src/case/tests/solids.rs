//! Obstacles of solids that are refused, with the place of each fault.

use crate::case::AnyCase;
use crate::{Case, CaseError};
use fem_core::space::Solid;

/// A cube above an obstacle.
fn cube(obstacle: &str) -> String {
    format!(
        r#"schema = 1
[materials.m]
young = 1.0
poisson = 0.3
[[body]]
name = "a"
material = "m"
generator = {{ kind = "box", size = [1, 1, 1], cells = [1, 1, 1] }}
[[contact]]
surfaces = ["bottom"]
obstacle = {{ {obstacle} }}
"#
    )
}

/// Checks the single fault of a case, in the line of the obstacle.
fn only<T: std::fmt::Debug>(read: Result<T, CaseError>, expected: &str) {
    let found: Vec<String> = read.unwrap_err().diagnostics.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), 1, "{found:#?}");
    let (place, words) = found[0].split_once(": ").unwrap();
    assert!(place.starts_with("c.toml:11:"), "{place}");
    assert!(words.starts_with(expected), "\nfound    {words}\nexpected {expected}");
}

fn refused(obstacle: &str, expected: &str) {
    only(AnyCase::parse(&cube(obstacle), "c.toml", &[]), expected);
}

const SPHERE: &str = r#"kind = "sphere", centre = [0, 0, -1], radius = 1"#;
const CYLINDER: &str = r#"kind = "cylinder", point = [0, 0, -1], axis = [0, 1, 0], radius = 1"#;

#[test]
fn spheres_and_cylinders_are_read() {
    for shape in [SPHERE, CYLINDER] {
        for rest in ["", ", side = \"inside\"", ", force = [0, 0, 1], rotation = [0, 0, 0], ux = 0, uy = 0"] {
            assert!(AnyCase::parse(&cube(&format!("{shape}{rest}")), "c.toml", &[]).is_ok(), "{shape}{rest}");
        }
    }
}

#[test]
fn wrong_spheres_and_cylinders_are_refused_at_their_key() {
    for shape in [SPHERE, CYLINDER] {
        for (radius, shown) in [("0", "0"), ("-1.5", "-1.5"), ("nan", "NaN"), ("inf", "inf")] {
            let wrong = shape.replace("radius = 1", &format!("radius = {radius}"));
            refused(&wrong, &format!("`contact.0.obstacle.radius` is {shown}"));
        }
        refused(&shape.replace(", radius = 1", ""), "the key `contact.0.obstacle.radius` is missing");
        refused(
            &format!("{shape}, side = \"out\""),
            "`contact.0.obstacle.side` is \"out\"; expected \"outside\" or \"inside\"",
        );
        refused(&format!("{shape}, rotation = 0"), "`contact.0.obstacle.rotation` is the integer 0");
    }
    refused(
        &SPHERE.replace("[0, 0, -1]", "[0, 0]"),
        "`contact.0.obstacle.centre` has 2 entries; expected an array of three numbers",
    );
    refused(
        &CYLINDER.replace("[0, 1, 0]", "[0, 0, 0]"),
        "`contact.0.obstacle.axis` has no direction; expected a direction along the axis of the cylinder; \
         help: write it as in `axis = [0.0, 0.0, 1.0]`",
    );
    refused(
        "kind = \"circle\", centre = [0, 0, -1], radius = 1",
        "`contact.0.obstacle.kind`: circles touch plane bodies, and this case is one of solids; expected \"plane\", \"sphere\" or \
         \"cylinder\"; help: write `kind = \"sphere\"`",
    );
    // The keys of an unknown kind are not told.
    refused(
        &SPHERE.replace("sphere", "spher"),
        "`contact.0.obstacle.kind` is \"spher\"; expected \"plane\" or \"sphere\" or \"cylinder\"; help: did you mean \"sphere\"?",
    );
}

#[test]
fn balls_are_read_and_wrong_ones_are_refused_at_their_key() {
    let case = |keys: &str| {
        let text = cube("kind = \"plane\", point = [0, 0, -1], normal = [0, 0, 1]");
        text.replace(
            "kind = \"box\", size = [1, 1, 1], cells = [1, 1, 1]",
            &format!("kind = \"ball\", {keys}"),
        )
    };
    for (keys, nodes) in [
        ("radius = 2, cells = 2", 125),
        ("radius = 2, cells = 2, part = \"half\"", 75),
        ("radius = 2, cells = 2, part = \"quarter\", facing = \"up\", growth = 5", 45),
        ("radius = 2, cells = 2, part = \"eighth\", centre = [1, 2, 3], growth = 1", 27),
    ] {
        let Ok(AnyCase::Solid(read)) = AnyCase::parse(&case(keys), "c.toml", &[]) else { panic!("{keys}") };
        let generator = match &read.bodies[0].mesh {
            crate::case::MeshSource::Generator(generator) => generator,
            other => panic!("{other:?}"),
        };
        let mesh = <Solid as crate::case::Dimension>::generated(generator).unwrap();
        assert_eq!(
            (mesh.points().len(), <Solid as crate::case::Dimension>::nodes(generator)),
            (nodes, nodes as u64)
        );
    }
    let refused = |keys: &str, expected: &str| {
        let found = AnyCase::parse(&case(keys), "c.toml", &[]).unwrap_err();
        let words: Vec<String> = found.diagnostics.iter().map(ToString::to_string).collect();
        assert!(words.len() == 1 && words[0].starts_with("c.toml:8:"), "{words:#?}");
        assert!(words[0].contains(expected), "{}", words[0]);
    };
    refused("cells = 2", "the key `body.0.generator.radius` is missing");
    refused("radius = 0, cells = 2", "`body.0.generator.radius` is 0; expected a number > 0");
    refused("radius = 1, cells = 0", "`body.0.generator.cells` is 0");
    refused("radius = 1, cells = [2, 2, 2]", "`body.0.generator.cells`");
    refused(
        "radius = 1, cells = 2, part = \"third\"",
        "`body.0.generator.part` is \"third\"; expected \"whole\" or \"half\"",
    );
    refused("radius = 1, cells = 2, facing = \"up\"", "a whole ball has a pole on either side");
    refused("radius = 1, cells = 2, part = \"half\", facing = \"left\"", "expected \"down\" or \"up\"");
    refused(
        "radius = 1, cells = 2, growth = 0.5",
        "`body.0.generator.growth` is 0.5; expected a number from 1 to 5",
    );
    refused("radius = 1, cells = 2, growth = 9", "`body.0.generator.growth` is 9");
}

#[test]
fn the_plane_has_circles_in_place_of_spheres_and_cylinders() {
    let generators = [
        "kind = \"box\", size = [1, 1, 1], cells = [1, 1, 1]",
        "kind = \"block\", size = [1, 1], cells = [1, 1]",
    ];
    for (shape, word) in [(SPHERE, "sphere"), (CYLINDER, "cylinder")] {
        let text = cube(shape).replace(generators[0], generators[1]);
        let expected = format!(
            "`contact.0.obstacle.kind`: {word}s touch solid bodies, and this case is plane; expected \"plane\" or \"circle\"; \
             help: write `kind = \"circle\"`"
        );
        only(Case::parse(&text, "c.toml", &[]), &expected);
    }
}

//! Obstacles of solids that are refused, with the place of each fault.

use crate::case::AnyCase;
use crate::{Case, CaseError};

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

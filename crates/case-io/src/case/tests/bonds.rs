//! Bonded pairs.

use super::{minimal, parse};
use crate::Case;

fn refused(rest: &str) -> String {
    match Case::parse(&minimal(rest), "case.toml", &[]) {
        Ok(case) => case.build().unwrap_err().to_string(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_pair_is_bonded_with_an_offset_or_without() {
    let bonded = "law = \"bonded\"\n";
    for (rest, expected) in
        [(bonded.to_owned(), [0.0, 0.0]), (format!("{bonded}offset = [0.1, 0.2]"), [0.1, 0.2])]
    {
        let case = parse(&minimal(&rest));
        assert_eq!(case.contacts[0].bond, Some(expected));
        let (problem, _) = case.build().unwrap();
        assert!(problem.contacts[0].is_bonded());
        assert_eq!(case.settings_json()["contact"]["offset"][1], expected[1]);
    }
    let plain = parse(&minimal("law = \"unilateral\""));
    assert_eq!(plain.contacts[0].bond, None);
    assert_eq!(plain.hash(), parse(&minimal("")).hash());
}

#[test]
fn what_a_bond_has_not_is_refused_by_name() {
    for (key, value) in [
        ("gap", "0.0"),
        ("friction", "{ law = \"tresca\", limit = 1.0 }"),
        ("normal", "[0.0, -1.0]"),
        ("imposed", "\"first\""),
    ] {
        let said = refused(&format!("law = \"bonded\"\n{key} = {value}"));
        assert!(said.contains(&format!("`contact.{key}` has no meaning in a bonded pair")), "{said}");
    }
    assert!(refused("offset = [0.0, 1.0]").contains("this pair is not bonded"));
    assert!(refused("law = \"glued\"").contains("\"unilateral\" or \"bonded\""));
}

#[test]
fn bodies_that_cannot_be_bonded_are_refused_with_the_pair() {
    let apart = minimal("law = \"bonded\"").replace(
        "size = [1, 1], cells = [2, 2] }\n[contact]",
        "size = [1, 0.9], cells = [2, 2] }\n[contact]",
    );
    let error = parse(&apart).build().unwrap_err().to_string();
    assert!(error.contains("apart"), "{error}");
    let heavy = minimal("law = \"bonded\"").replacen("[contact]", "body_force = [0.0, -1.0]\n[contact]", 1);
    let error = parse(&heavy).build().unwrap_err().to_string();
    assert!(error.contains("the pair \"a-b\": the bonded bodies have different body forces"), "{error}");
}

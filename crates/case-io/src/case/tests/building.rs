//! fem-core's errors at the places of their keys.

use super::*;

fn case(overrides: &[(&str, &str)]) -> Case {
    let overrides: Vec<_> = overrides.iter().map(|(k, v)| set(k, v)).collect();
    Case::parse(crate::template::PAPER, "paper.toml", &overrides).unwrap()
}

/// Changes the text of the paper's case and returns what building its bodies says.
fn body_fault(from: &str, to: &str) -> String {
    assert!(crate::template::PAPER.contains(from), "{from}");
    let text = crate::template::PAPER.replacen(from, to, 1);
    Case::parse(&text, "paper.toml", &[]).unwrap().build_bodies().err().unwrap().to_string()
}

fn contact_fault(overrides: &[(&str, &str)]) -> String {
    case(overrides).build().unwrap_err().to_string()
}

#[test]
fn the_paper_has_380_nodes_and_19_pairs() {
    let (problem, _) = case(&[]).build().unwrap();
    let nodes = |body: usize| problem.bodies[body].mesh().points().len();
    assert_eq!([0, 1].map(nodes), [190, 190]);
    let interface = &problem.contacts[0].interface;
    assert_eq!((interface.pairs().len(), interface.measure()), (19, 2.0));
    assert_eq!(interface.pairs()[0].normal, fem_core::geometry::Vector::new(0.0, -1.0));
}

#[test]
fn a_pair_that_a_program_has_broken_is_refused() {
    let mut broken = case(&[]);
    broken.contacts[0].surfaces.pop();
    let fault = broken.build().unwrap_err().to_string();
    assert!(fault.contains("a pair of the bodies [0, 1] and the surfaces [\"bottom\"]"), "{fault}");
}

#[test]
fn unknown_groups_are_found_at_their_condition() {
    let fault = body_fault("on = \"right\"", "on = \"rigth\"");
    assert!(
        fault.starts_with(
            "paper.toml:37:6: body \"upper\": traction condition 1: there is no edge group \"rigth\""
        ),
        "{fault}"
    );
    assert!(fault.ends_with("help: did you mean \"right\"?"), "{fault}");
    let fault = body_fault("on = \"bottom\"", "on = \"base\"");
    assert!(fault.starts_with("paper.toml:46:6: body \"lower\": displacement condition 1: "), "{fault}");
    assert!(!fault.contains("did you mean"), "{fault}");
}

#[test]
fn both_bodies_are_looked_at() {
    let case = case(&[("body.0.displacement.0.on", "x"), ("body.1.displacement.0.on", "y")]);
    let error = case.build_bodies().err().unwrap();
    let places: Vec<String> =
        error.diagnostics.iter().map(|d| d.place.as_ref().unwrap().to_string()).collect();
    assert_eq!(places, ["--set body.0.displacement.0.on=x", "--set body.1.displacement.0.on=y"]);
}

#[test]
fn conditions_that_make_no_sense_are_found() {
    let fault = body_fault("vector = [0.0, 30.0]", "vector = [0.0, 30.0]\npart = { x = [5.0, 6.0] }");
    assert!(
        fault.starts_with("paper.toml:39:8: body \"upper\": traction condition 1: no edge of \"right\""),
        "{fault}"
    );
    let moved = [("body.0.traction.0.on", "left"), ("body.0.traction.0.vector", "[1, 0]")];
    let fault = case(&moved).build_bodies().err().unwrap().to_string();
    assert!(
        fault
            .starts_with("--set body.0.traction.0.vector=[1, 0]: body \"upper\": traction condition 1 loads"),
        "{fault}"
    );
    // Both conditions hold the corner they share, with different values.
    let fault = body_fault("on = \"top\"", "ux = 1.0\non = \"top\"");
    assert!(
        fault.starts_with("paper.toml:32:1: body \"upper\": displacement condition 2 and an earlier one"),
        "{fault}"
    );
    assert!(case(&[("body.0.body_force", "[0, 1e308]")]).build_bodies().is_ok());
}

#[test]
fn meshes_that_cannot_be_made_are_found_at_their_generator() {
    let fault =
        case(&[("body.1.generator.cells", "[999999999, 2]")]).build_bodies().err().unwrap().to_string();
    assert!(fault.starts_with("paper.toml:43:13: body \"lower\": a block of "), "{fault}");
    assert!(case(&[("body.1.generator.cells", "[999999999, 999999999]")]).node_counts()[1] > 1 << 59);
}

#[test]
fn surfaces_that_cannot_be_paired_are_found_in_contact() {
    let fault = contact_fault(&[("contact.surfaces", "[\"bottom\", \"topp\"]")]);
    assert!(
        fault.starts_with(
            "--set contact.surfaces=[\"bottom\", \"topp\"]: body \"lower\" has no edge group \"topp\""
        ),
        "{fault}"
    );
    assert!(fault.ends_with("help: did you mean \"top\"?"), "{fault}");
    // Nodes that do not match are no fault: there is a common refinement.
    assert!(case(&[("body.0.generator.cells", "[17, 9]")]).build().is_ok());
    let fault = contact_fault(&[("body.1.displacement.0.on", "top")]);
    assert!(fault.starts_with("paper.toml:50:23: the contact edge of body \"lower\""), "{fault}");
}

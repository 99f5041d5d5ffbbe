//! Temperatures, body forces by expressions, rotation and acceleration.

use super::*;
use fem_core::geometry::Vector;

const MATERIAL: &str = "poisson = 0.0";
const BODY: &str = "name = \"b\"";

/// The minimal case with keys of the material and of the second body, and with `[model]`.
fn with(material: &str, body: &str, model: &str) -> String {
    let text = minimal(&format!("[model]\n{model}\n"));
    text.replacen(MATERIAL, &format!("{MATERIAL}\n{material}"), 1).replacen(
        BODY,
        &format!("{BODY}\n{body}"),
        1,
    )
}

#[test]
fn what_acts_inside_bodies_is_read_and_written() {
    let text = with(
        "expansion = 1e-5\ndensity = 2",
        "body_force = [\"3*x\", 1]\ntemperature = [{ value = \"100*x\" }, { name = \"heat\", value = 5 }]",
        "rotation = { speed = 3, point = [1, 2] }\nacceleration = [0, -9.81]",
    );
    let case = parse(&text);
    let conditions = case.boundary_conditions(1);
    let force = conditions.force_field.unwrap();
    assert_eq!([0, 1].map(|c: usize| force[c].at([2.0, 7.0])), [6.0, 1.0]);
    let per_mass = conditions.per_mass.unwrap();
    assert_eq!(per_mass.at(Vector::new(2.0, 4.0)), Vector::new(9.0, 18.0 - 9.81));
    assert_eq!(conditions.temperatures.len(), 2);
    assert_eq!(conditions.temperatures[0].at([2.0, 7.0]), 200.0);
    let settings = case.settings_json();
    assert_eq!(settings["model"]["rotation"]["speed"], 3.0);
    assert_eq!(settings["model"]["acceleration"][1], -9.81);
    assert_eq!(settings["materials"]["m"]["expansion"], 1e-5);
    assert_eq!(settings["body"][1]["temperature"][1]["name"], "heat");
    // Written settings are the same case.
    let body = &case.build_bodies().unwrap()[1];
    assert!(body.has_heat() && body.has_varying_force());
    assert_eq!(body.material(0).density(), 2.0);
}

#[test]
fn what_would_have_no_effect_or_no_meaning_is_refused() {
    let rotation = "rotation = { speed = 3, point = [1, 2] }";
    for (material, body, model, expected) in [
        ("", "temperature = [{ value = 5 }]", "", "does not expand"),
        ("", "", rotation, "has no density"),
        ("density = -1", "", "", "the density is -1"),
        ("expansion = 2", "", "", "the expansion is 2"),
        (
            "density = 1",
            "",
            "rotation = { speed = 3, point = [1, 2], axis = [0, 0, 1] }",
            "turns about a point",
        ),
        ("expansion = 1e-5", "temperature = [{ value = \"1/x\" }]", "", "a finite number is needed"),
        ("", "body_force = [\"1/x\", 0]", "", "finite numbers are needed"),
    ] {
        let read = Case::parse(&with(material, body, model), "c.toml", &[]);
        let error = read.and_then(|case| case.build_bodies()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

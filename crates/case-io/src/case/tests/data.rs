//! Expressions, materials and regions: what is made of them, and what is refused.

use super::*;
use crate::diagnostic::code;

/// The minimal case with other lines for its material and at the end of its first body.
fn with(material: &str, body: &str, rest: &str) -> String {
    let text = minimal(rest);
    let (from, to) = ("young = 1.0\npoisson = 0.0\n", format!("{material}\n"));
    assert!(text.contains(from), "{text}");
    let text = if material.is_empty() { text } else { text.replacen(from, &to, 1) };
    let second = text.rfind("[[body]]").unwrap();
    format!("{}{body}\n{}", &text[..second], &text[second..])
}

fn fault(text: &str) -> Diagnostic {
    let error = Case::parse(text, "c.toml", &[])
        .map_or_else(|e| e, |case| case.build_bodies().map(|_| ()).unwrap_err());
    assert_eq!(error.diagnostics.len(), 1, "{error}");
    error.diagnostics[0].clone()
}

#[test]
fn expressions_become_functions_of_the_point() {
    let body = "[[body.displacement]]\non = 'left'\nux = '1e-3 * (1 - y)'\nuy = '2 * 3'\n\
        [[body.traction]]\non = 'right'\nvector = ['x * y^2', 4.0]";
    let case = parse(&with("", body, "gap = 'x^2'\n[solver]\nlambda = '-0.1 * x'"));
    let conditions = case.boundary_conditions(0);
    let fem_core::boundary::Support::Components([Some(ux), Some(uy)]) = &conditions.displacements[0].support
    else {
        unreachable!()
    };
    assert_eq!((ux.at([5.0, 0.25]), ux.constant()), (0.75e-3, None));
    // Without x and y it is a number.
    assert_eq!(uy.constant(), Some(6.0));
    assert_eq!(case.solver.lambda.scalar::<Plane>().at([2.0, 0.0]), -0.2);
    assert_eq!(case.contacts[0].gap.scalar::<Plane>().at([-3.0, 0.0]), 9.0);
    let settings = case.settings_json();
    assert_eq!(settings["contact"]["gap"], "x^2");
    assert_eq!(settings["body"][0]["traction"][0]["vector"][0], "x * y^2");
}

#[test]
fn notes_say_what_is_interpolated_and_how_much() {
    let body = "[[body.displacement]]\non = 'left'\nux = '1e-3 * (1 - y)'\n\
        [[body.traction]]\non = 'right'\nvector = ['y^2', '3*y']";
    let case = parse(&with("", body, "gap = 'x*(1-x)'"));
    let (problem, _) = case.build().unwrap();
    let notes = case.data_notes(&problem);
    assert_eq!(notes.len(), 2, "{notes:#?}");
    assert!(
        notes[0].contains("traction x = \"y^2\" on \"right\": not linear along the edges"),
        "{}",
        notes[0]
    );
    assert!(notes[0].contains("the bound is for interpolated data"), "{}", notes[0]);
    assert!(notes[1].starts_with("contact.gap = \"x*(1-x)\": not linear"), "{}", notes[1]);
}

#[test]
fn faults_of_expressions_stand_at_the_character() {
    let of = |quoted: &str| fault(&with("", "", &format!("gap = {quoted}")));
    let cases = [
        ("'0.1 * sinn(x)'", "0.1 * ", "unknown function \"sinn\"; expected numbers, `x`"),
        ("\"x + z\"", "x + ", "unknown name \"z\""),
        ("\"\"\"x + z\"\"\"", "\"\"x + ", "unknown name \"z\""),
        ("'(x'", "", "`(` is not closed"),
    ];
    for (quoted, before, message) in cases {
        let fault = of(quoted);
        assert_eq!(fault.code, code::EXPRESSION);
        // Behind `gap = ` and the quotation mark.
        assert_eq!(fault.place.as_ref().unwrap().column, 8 + before.len(), "{quoted}: {fault}");
        assert!(fault.to_string().contains(&format!("`contact.gap`: {message}")), "{fault}");
    }
    // With an escape in it the text is not what is written: the place is the string.
    let fault = of("\"x + \\u007A\"");
    assert_eq!(fault.place.as_ref().unwrap().column, 7, "{fault}");
}

#[test]
fn values_that_are_not_finite_name_the_point_and_the_key() {
    let load = |load: &str| fault(&with("", &format!("[[body.traction]]\non = 'right'\n{load}"), ""));
    // The minimal case's first body begins at y = 1 or 0; the right side has a node at its lower end.
    let found = load("pressure = '1 / (x - x)'");
    assert!(found.message.contains("the value at ("), "{found}");
    assert!(found.message.contains("a finite number is needed"), "{found}");
    assert_eq!(found.place.as_ref().unwrap().column, "pressure = ".len() + 1, "{found}");
    let found = load("vector = [0.0, 'sqrt(-1 - x^2)']");
    assert!(found.message.contains("is NaN"), "{found}");
    assert_eq!(found.place.as_ref().unwrap().column, "vector = [0.0, ".len() + 1, "{found}");
    let found = fault(&with("", "[[body.displacement]]\non = 'right'\nuy = 'ln(x - x)'", ""));
    assert!(found.message.contains("is -inf"), "{found}");
    assert_eq!(found.place.as_ref().unwrap().column, "uy = ".len() + 1, "{found}");
}

#[test]
fn materials_of_three_kinds_are_read() {
    let law = |text: &str| parse(&with(text, "", "")).materials[0].clone();
    let wood = law("young_1 = 11\nyoung_2 = 1\npoisson_12 = 0.4\nshear = 0.7\nangle = 90");
    let MaterialLaw::Orthotropic(c) = &wood.law else { unreachable!() };
    assert_eq!((c.young_3, c.poisson_13, c.poisson_23, c.angle), (1.0, 0.4, 0.4, 90.0));
    // Turned by a right angle the stiff axis is y.
    let model = Model { hypothesis: Hypothesis::PlaneStress, thickness: 1.0 };
    let d = *wood.elastic(&model).unwrap().stiffness();
    assert!(d[(1, 1)] > 10.0 && d[(0, 0)] < 1.1 && d[(0, 2)].abs() < 1e-12, "{d}");
    let full = law("stiffness = [[4, 1, 0.2], [1.0, 3, -0.1], [0.2, -0.1, 1]]");
    assert_eq!(full.law, MaterialLaw::Stiffness([[4.0, 1.0, 0.2], [1.0, 3.0, -0.1], [0.2, -0.1, 1.0]]));
    assert_eq!(full.json()["stiffness"][0][2], 0.2);
}

#[test]
fn materials_that_are_none_are_refused_at_their_key() {
    let of = |text: &str| {
        let found = fault(&with(text, "", ""));
        let place = found.place.as_ref().unwrap();
        (place.line, place.column, found.to_string())
    };
    let wood = "young_1 = 11\nyoung_2 = 1\nshear = 0.7\n";
    for (text, line, column, words) in [
        (
            format!("{wood}poisson_12 = 4.0"),
            6,
            14,
            "poisson_12` is 4 (and so are `poisson_13` and `poisson_23`",
        ),
        (format!("{wood}poisson_12 = 0.1\nyoung_3 = -1"), 7, 11, "young_3 is -1"),
        (format!("{wood}poisson_12 = 0.1\npoisson_23 = 1.5"), 7, 14, "poisson_23 is 1.5"),
        (wood.to_owned(), 2, 1, "the key `materials.m.poisson_12` is missing"),
        (
            format!("{wood}poisson_12 = 0.1\nyoung = 3"),
            3,
            11,
            "`young` and `young_1` are constants of different",
        ),
        ("stiffness = 3".into(), 3, 13, "is the integer 3; expected three rows"),
        ("stiffness = [[1, 0], [0, 1]]".into(), 3, 13, "has 2 entries; expected three rows"),
        (
            "stiffness = [[1, 0, 0], [0, 1], [0, 0, 1]]".into(),
            3,
            25,
            "`materials.m.stiffness.1` has 2 entries",
        ),
        ("stiffness = [[1, 0, 0], [0, 1, 'a'], [0, 0, 1]]".into(), 3, 32, "is the string \"a\""),
        (
            "stiffness = [[1, 0, 0], [0.5, 1, 0], [0, 0, 1]]".into(),
            3,
            13,
            "entry (1, 2) is 0 and entry (2, 1) is 0.5",
        ),
        ("stiffness = [[1, 2, 0], [2, 1, 0], [0, 0, 1]]".into(), 3, 13, "smallest eigenvalue is -1"),
    ] {
        let found = of(&text);
        assert_eq!((found.0, found.1), (line, column), "{text}: {}", found.2);
        assert!(found.2.contains(words), "{text}: {}", found.2);
    }
    let error = Case::parse(&with("stifness = 1", "", ""), "c.toml", &[]).unwrap_err().to_string();
    assert!(error.contains("did you mean `stiffness`?"), "{error}");
}

#[test]
fn regions_give_cells_another_material() {
    let spare = "young = 1.0\npoisson = 0.0\n[materials.hard]\nyoung = 9.0\npoisson = 0.0";
    let body = "[[body.region]]\nmaterial = 'hard'\nbox = { x = [0.0, 0.5] }";
    let case = parse(&with(spare, body, ""));
    let [first, second] = <[_; 2]>::try_from(case.build_bodies().unwrap()).unwrap();
    let stiff = (0..first.mesh().cells().len()).filter(|t| first.material(*t).stiffness()[(0, 0)] > 5.0);
    let stiff: Vec<usize> = stiff.collect();
    assert!(!stiff.is_empty() && stiff.len() < first.mesh().cells().len());
    for t in stiff {
        let c = first.mesh().corners(t);
        assert!((c[0][0] + c[1][0] + c[2][0]) / 3.0 <= 0.5);
    }
    assert_eq!(second.materials().list().len(), 1);
    assert!(case.warnings().is_empty(), "{:?}", case.warnings());
    assert_eq!(case.settings_json()["body"][0]["region"][0]["box"]["x"][1], 0.5);
    let names: Vec<&str> = case.materials_of(0).iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["m", "hard"]);
}

#[test]
fn regions_that_make_no_sense_are_refused() {
    let of = |body: &str| fault(&with("", &format!("[[body.region]]\n{body}"), "")).to_string();
    assert!(of("material = 'm'\nbox = { x = [7.0, 8.0] }").contains("no cell lies in this region"));
    assert!(of("material = 'm'\nbox = { x = [1.0, 0.0] }").contains("are in the wrong order"));
    assert!(of("material = 'm'\nbox = {}").contains("the box has no limits"));
    assert!(of("material = 'm'").contains("this region takes no cells"));
    assert!(of("box = { x = [0.0, 1.0] }").contains("region.0.material` is missing"));
    assert!(of("material = 'n'\nbox = { x = [0.0, 1.0] }").contains("there is no material \"n\""));
    assert!(of("material = 'm'\ngroup = 'a'").contains("has no mesh file"));
    assert!(of("material = 'm'\ngroup = 'a'\nbox = { x = [0.0, 1.0] }").contains("exclude each other"));
}

#[test]
fn groups_of_a_mesh_file_are_regions_too() {
    let deck = "*NODE\n1, 0, 0\n2, 1, 0\n3, 2, 0\n4, 0, 1\n5, 1, 1\n6, 2, 1\n\
        *ELEMENT, TYPE=CPS4, ELSET=all\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n\
        *ELSET, ELSET=inclusion\n2\n*NSET, NSET=low\n1, 2, 3\n*NSET, NSET=high\n4, 5, 6\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.inp"), deck).unwrap();
    let text = |group: &str| {
        format!(
            "schema = 1\n[materials.m]\nyoung = 1.0\npoisson = 0.0\n[materials.hard]\nyoung = 9.0\npoisson = 0.0\n\
             [[body]]\nname = 'a'\nmaterial = 'm'\nmesh = {{ file = 'm.inp', region = 'all' }}\n\
             [[body.region]]\nmaterial = 'hard'\ngroup = '{group}'\n\
             [[body]]\nname = 'b'\nmaterial = 'm'\n\
             generator = {{ kind = 'block', origin = [0.0, 1.0], size = [2.0, 1.0], cells = [2, 1] }}\n\
             [contact]\nsurfaces = ['high', 'bottom']\n"
        )
    };
    let built = |group: &str| {
        let mut case = parse(&text(group));
        case.read_mesh_files(folder.path()).unwrap();
        case.build_body(0)
    };
    let body = built("inclusion").unwrap();
    let moduli: Vec<f64> = (0..4).map(|t| body.material(t).stiffness()[(0, 0)]).collect();
    assert_eq!(moduli, [1.0, 1.0, 9.0, 9.0]);
    let error = built("inclusions").unwrap_err().to_string();
    assert!(error.contains("no group of cells \"inclusions\"; expected \"all\", \"inclusion\""), "{error}");
    assert!(error.contains("did you mean \"inclusion\"?"), "{error}");
}

#[test]
fn half_discs_of_impossible_widths_are_refused_at_their_key() {
    let disc = |radius: &str, width: &str| {
        let disc =
            format!("kind = 'half_disc', radius = {radius}, facing = 'up', half_width = {width}, cells = 4");
        minimal("").replacen("kind = \"block\", size = [1, 1], cells = [2, 2]", &disc, 1)
    };
    assert!(Case::parse(&disc("2.0", "0.5"), "c.toml", &[]).is_ok());
    for (radius, width, expected) in [
        ("2.0", "0", "`body.1.generator.half_width` is 0; expected a number > 0, at most 0.3 times `radius`"),
        ("2.0", "-1.0", "`body.1.generator.half_width` is -1; expected a number > 0"),
        ("2.0", "0.7", "`body.1.generator.half_width` is 0.7; expected a number > 0, at most 0.3"),
        ("0.0", "0.5", "`body.1.generator.radius` is 0; expected a number > 0"),
    ] {
        let found = fault(&disc(radius, width)).to_string();
        assert!(found.contains(expected), "{radius} {width}: {found}");
    }
}

#[test]
fn warnings_are_capped_and_counted() {
    let spare: String =
        (0..30).map(|k| format!("[materials.spare_{k}]\nyoung = 1.0\npoisson = 0.3\n")).collect();
    let warnings = parse(&minimal(&spare)).warnings();
    assert_eq!(warnings.len(), 21);
    assert!(warnings[19].message.contains("no body uses the material"), "{}", warnings[19].message);
    assert_eq!(warnings[20].message, "and 10 more warnings");
}

#[test]
fn settings_that_a_method_ignores_are_named() {
    let said = |method: &str| {
        let solver = format!(
            "[solver]\nmethod = \"{method}\"\ntheta = 0.4\nweights = \"half\"\nimposed = \"first\"\n"
        );
        let warnings = parse(&minimal(&solver)).warnings();
        warnings.into_iter().map(|warning| warning.message).collect::<Vec<_>>().join("\n")
    };
    let newton_nn = "method newton-nn updates lambda on its own; it ignores `theta`, `weights`";
    assert_eq!(said("newton-nn"), newton_nn);
    let exact =
        "the exact method uses only `max_iterations` and `qp`; it ignores `imposed`, `theta`, `weights`";
    assert_eq!(said("exact"), exact);
    assert_eq!(said("nndd"), "");
}

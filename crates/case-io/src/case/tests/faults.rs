//! Cases that are refused, with the place of each fault.

use super::*;

/// Returns what is wrong with the minimal case and a text at its end, as strings.
fn faults(text: &str) -> Vec<String> {
    let error = Case::parse(text, "c.toml", &[]).unwrap_err();
    error.diagnostics.iter().map(ToString::to_string).collect()
}

/// Checks the single fault of a case that is the minimal one with `rest` at its end (from line 15 on).
fn refused(rest: &str, expected: &str) {
    let found = faults(&minimal(rest));
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].starts_with(expected), "\nfound    {}\nexpected {expected}", found[0]);
}

/// Checks the single fault of the minimal case with one text replaced by another.
fn replaced(from: &str, to: &str, expected: &str) {
    let text = minimal("");
    assert!(text.contains(from));
    let found = faults(&text.replacen(from, to, 1));
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].starts_with(expected), "\nfound    {}\nexpected {expected}", found[0]);
}

#[test]
fn thousands_of_faulty_tables_are_counted_after_the_first_twenty() {
    let bodies: String =
        (0..10_000).map(|k| format!("[[body]]\nname = \"b{k}\"\nmaterial = \"m{k}\"\n")).collect();
    let pairs = "[[contact]]\nbodies = [\"a\", \"c\"]\nsurfaces = [\"top\", \"bottom\"]\n".repeat(10_000);
    let text = format!("schema = 1\n[materials.a]\nyoung = 1.0\npoisson = 0.3\n{bodies}{pairs}");
    let error = Case::parse(&text, "c.toml", &[]).unwrap_err();
    assert_eq!(error.diagnostics.len(), 20);
    // No generator, and no material, of each body; two names of no body in each pair.
    assert_eq!(error.omitted + 20, 4 * 10_000);
    assert!(error.diagnostics[0].to_string().starts_with("c.toml:5:1"), "{}", error.diagnostics[0]);
}

#[test]
fn a_file_of_control_characters_or_brackets_has_one_fault() {
    for (text, found) in [
        ("\r".repeat(15_000_000), "c.toml:1:1: a carriage return without a line feed"),
        ("a = 1\n\u{1}".to_owned(), "c.toml:2:1: the control character 0x01"),
        ("[".repeat(15_000_000), "c.toml:1:2000001: more than 2000000 lines, brackets and commas"),
    ] {
        let found_faults = faults(&text);
        assert!(found_faults.len() == 1 && found_faults[0].starts_with(found), "{:.200}", found_faults[0]);
    }
    assert!(Case::parse(&minimal("").replace('\n', "\r\n"), "c.toml", &[]).is_ok());
}

#[test]
fn unknown_keys_get_the_nearest_name() {
    refused(
        "[solver]\ntheata = 1",
        "c.toml:16:1: unknown key `theata` in `solver`; expected only the keys `method`, `subdomains`, `imposed`, `path`, `qp`, `theta`, \
         `weights`, `acceleration`, `lambda`, `coarse`, `max_iterations`, `friction_tolerance`, \
         `friction_steps`, `stop`; help: did you mean `theta`?",
    );
    refused(
        "[solvr]\n",
        "c.toml:15:2: unknown key `solvr` at the top level; expected only the keys `schema`",
    );
    refused(
        "[output]\nzzz = 1",
        "c.toml:16:1: unknown key `zzz` in `output`; expected only the keys `directory`, `vtu`, `path`; help: take it out",
    );
    // No key is listed twice.
    refused(
        "gip = 1",
        "c.toml:15:1: unknown key `gip` in `contact`; expected only the keys `bodies`, `obstacle`, `surfaces`, `gap`, `interference`, `normal`, \
         `imposed`, `friction`, `law`, `offset`, `motion`, `name`; help: did you",
    );
    replaced("young = 1.0", "young = 1.0\nnu = 1", "c.toml:4:1: unknown key `nu` in `materials.m`");
    replaced(
        "cells = [2, 2] }",
        "cells = [2, 2], cell = 1 }",
        "c.toml:8:83: unknown key `cell` in `body.0.generator`",
    );
}

#[test]
fn both_types_are_named() {
    replaced(
        "poisson = 0.0",
        "poisson = \"0.3\"",
        "c.toml:4:11: `materials.m.poisson` is the string \"0.3\"; expected a number; help: write 0.3 without quotes",
    );
    refused(
        "[solver]\nmax_iterations = 1.5",
        "c.toml:16:18: `solver.max_iterations` is the number 1.5; expected a whole number, at least 0",
    );
    refused(
        "[solver]\nmax_iterations = -1",
        "c.toml:16:18: `solver.max_iterations` is -1; expected a whole number",
    );
    refused("[output]\nvtu = 1", "c.toml:16:7: `output.vtu` is the integer 1; expected true or false");
    refused("[solver]\ntheta = true", "c.toml:16:9: `solver.theta` is the boolean true; expected a number");
    refused("[solver]\nstop = 2026-01-01", "c.toml:16:8: `solver.stop` is a date; expected a table");
    replaced("name = \"a\"", "name = 1", "c.toml:6:8: `body.0.name` is the integer 1; expected a string");
    replaced(
        "surfaces = [\"bottom\", \"top\"]",
        "surfaces = [\"bottom\"]",
        "c.toml:14:12: `contact.surfaces` has 1 entries; expected two sides, or one and an `obstacle`",
    );
    replaced(
        "size = [1, 1]",
        "size = [1, true]",
        "c.toml:8:63: `body.0.generator.size.1` is the boolean true; expected a number",
    );
    replaced(
        "[materials.m]\nyoung = 1.0\npoisson = 0.0",
        "materials.m = 1",
        "c.toml:2:15: `materials.m` is an integer; expected a table with",
    );
}

#[test]
fn missing_keys_are_reported_at_their_table() {
    replaced("schema = 1\n", "", "c.toml:1:1: the key `schema` is missing");
    replaced("young = 1.0\n", "", "c.toml:2:1: the key `materials.m.young` is missing");
    replaced("material = \"m\"\n", "", "c.toml:5:1: the key `body.0.material` is missing");
    replaced("surfaces = [\"bottom\", \"top\"]", "", "c.toml:13:1: the key `contact.surfaces` is missing");
    replaced("kind = \"block\", ", "", "c.toml:8:13: the key `body.0.generator.kind` is missing");
    let found = faults("schema = 1\ntitle = 'x'\n");
    assert_eq!(found.len(), 3, "{found:?}");
}

#[test]
fn other_schemas_say_who_reads_them() {
    let error = faults("schema = 2\nnew = 'keys'\n");
    assert_eq!(error.len(), 1);
    assert!(
        error[0].starts_with("c.toml:1:10: `schema` is 2, which a newer nndd reads; this is version "),
        "{error:?}"
    );
    assert!(faults("schema = 0\n")[0].contains("expected schema = 1"));
    assert!(faults("schema = '1'\n")[0].contains("`schema` is a string; expected schema = 1"));
}

#[test]
fn bodies_have_different_names_and_a_contact_says_which_touch() {
    let body = "[[body]]\nname = \"c\"\nmaterial = \"m\"\ngenerator = { kind = 'block', size = [1, 1], cells = [2, 2] }\n";
    refused(body, "c.toml:13:1: the key `contact.bodies` is missing");
    let text = minimal("");
    let start = text.find("[[body]]\nname = \"b\"").unwrap();
    let one = format!("{}{}", &text[..start], &text[text.find("[contact]").unwrap()..]);
    assert!(faults(&one)[0].starts_with("c.toml:9:1: the key `contact.bodies` is missing"));
    assert!(
        faults("schema = 1\nbody = []\nmaterials = {}\n[contact]\nsurfaces = ['a', 'b']")[0]
            .starts_with("c.toml:2:8: there is no body")
    );
    replaced("name = \"b\"", "name = \"a\"", "c.toml:10:8: two bodies are called \"a\"");
    replaced("name = \"b\"", "name = \"A\"", "c.toml:10:8: two bodies are called \"A\"");
    let sign =
        minimal("").replace("name = \"a\"", "name = \"a b\"").replace("name = \"b\"", "name = \"A_B\"");
    assert!(
        faults(&sign)[0]
            .contains("\"a b\" and \"A_B\" would write the same file, A_B.vtu; expected two names")
    );
    replaced("name = \"b\"", "name = \"Contact\"", "c.toml:10:8: a body cannot be called \"contact\"");
    for wrong in ["../x", "", ".x", "a/b", "a\\u0000"] {
        replaced("name = \"b\"", &format!("name = \"{wrong}\""), "c.toml:10:8: the body name ");
    }
    refused("[body.x]", "c.toml:15:7: unknown key `x` in `body.1`");
}

#[test]
fn materials_exist_and_are_in_range() {
    replaced(
        "material = \"m\"\n",
        "material = \"n\"\n",
        "c.toml:7:12: there is no material \"n\"; expected \"m\"; help: did you mean \"m\"?",
    );
    replaced("young = 1.0", "young = -1", "c.toml:3:9: Young's modulus is -1.0; it must be positive");
    replaced("young = 1.0", "young = 1e308", "c.toml:3:9: Young's modulus is 1e308; it must");
    replaced(
        "poisson = 0.0",
        "poisson = 0.5",
        "c.toml:4:11: Poisson's ratio is 0.5; it must lie in (-1, 0.5)",
    );
    let text = minimal("").replace("young = 1.0\npoisson = 0.0", "young = 0\npoisson = -1");
    assert_eq!(faults(&text).len(), 2);
}

#[test]
fn numbers_must_be_finite_and_in_range() {
    for (value, shown) in [("nan", "NaN"), ("inf", "inf"), ("-inf", "-inf"), ("1e999", "inf")] {
        replaced(
            "young = 1.0",
            &format!("young = {value}"),
            &format!("c.toml:3:9: `materials.m.young` is {shown}; expected a finite number"),
        );
        refused(&format!("[solver]\ntheta = {value}"), &format!("c.toml:16:9: `solver.theta` is {shown}"));
        refused(&format!("[solver]\nlambda = {value}"), &format!("c.toml:16:10: `solver.lambda` is {shown}"));
        replaced(
            "size = [1, 1]",
            &format!("size = [1, {value}]"),
            "c.toml:8:63: `body.0.generator.size.1` is ",
        );
    }
    refused(
        "gap = -1.0\ninterference = true",
        "c.toml:16:16: `contact.interference` keeps an overlap that is drawn",
    );
    refused("friction = 0.3", "c.toml:15:12: `contact.friction` is a number, and friction is a law");
    refused("[model]\nthickness = 0", "c.toml:16:13: `model.thickness` is 0; expected a number > 0");
    refused("[solver]\ntheta = 0", "c.toml:16:9: `solver.theta` is 0; expected a number > 0, or \"auto\"");
    refused("[solver]\ntheta = \"aut\"", "c.toml:16:9: `solver.theta` is the string \"aut\"");
    refused("[solver.stop]\nratio = -0.1", "c.toml:16:9: `solver.stop.ratio` is -0.1");
    refused("[solver.stop]\ntolerance = 0.0", "c.toml:16:13: `solver.stop.tolerance` is 0");
    replaced(
        "cells = [2, 2]",
        "cells = [0, 2]",
        "c.toml:8:76: `body.0.generator.cells.0` is 0; expected a whole number, at least 1",
    );
    replaced(
        "cells = [2, 2]",
        "cells = [2.0, 2]",
        "c.toml:8:76: `body.0.generator.cells.0` is the number 2.0",
    );
    replaced(
        "size = [1, 1]",
        "size = [1, -1]",
        "c.toml:8:59: a block needs a width and a height; expected two numbers > 0",
    );
    refused(
        "[limits]\nmemory = \"4 gigs\"",
        "c.toml:16:10: `limits.memory` is \"4 gigs\"; expected an amount of memory",
    );
    refused("[limits]\ntime = \"soon\"", "c.toml:16:8: `limits.time` is \"soon\"; expected a time");
    refused("[output]\ndirectory = \"\"", "c.toml:16:13: `output.directory` is not a path");
    assert!(Case::parse(&minimal("[solver]\nmax_iterations = 0"), "c", &[]).is_ok());
}

#[test]
fn words_get_the_nearest_one() {
    refused(
        "[solver]\nmethod = \"newtn\"",
        "c.toml:16:10: `solver.method` is \"newtn\"; expected \"auto\" or \"nndd\" or \"newton\" or \"exact\" or \"newton-nn\"; help: did you mean \"newton\"?",
    );
    refused(
        "[model]\nhypothesis = \"axisymmetric\"",
        "c.toml:16:14: `model.hypothesis` is \"axisymmetric\"; expected \"plane_strain\" or \"plane_stress\"; help: there are no \
         problems with an axis of symmetry: take a sector as a solid, with rollers (`normal = 0.0`) on its two flat sides",
    );
    replaced(
        "kind = \"block\"",
        "kind = \"rign\"",
        "c.toml:8:22: `body.0.generator.kind` is \"rign\"; expected \"block\" or \"ring\" or \"disc\" or \"half_disc\"; help: did you mean \"ring\"?",
    );
}

#[test]
fn conditions_impose_exactly_one_thing() {
    let with = |condition: &str| {
        minimal("").replacen("[[body]]\nname = \"b\"", &format!("{condition}\n[[body]]\nname = \"b\""), 1)
    };
    let check = |condition: &str, expected: &str| {
        let found = faults(&with(condition));
        assert_eq!(found.len(), 1, "{found:#?}");
        assert!(found[0].starts_with(expected), "\nfound    {}\nexpected {expected}", found[0]);
    };
    check(
        "[[body.displacement]]\non = 'top'",
        "c.toml:9:1: this condition imposes no displacement; expected `ux`",
    );
    check("[[body.displacement]]\nux = 0", "c.toml:9:1: the key `body.0.displacement.0.on` is missing");
    check("[[body.displacement]]\non = 'top'\nfixed = false", "c.toml:11:9: `fixed = false` imposes nothing");
    check(
        "[[body.displacement]]\non = 'top'\nux = 1\nfixed = true",
        "c.toml:12:9: `ux`, `fixed` exclude each other",
    );
    check(
        "[[body.displacement]]\non = 'top'\nux = 1\nnormal = 0",
        "c.toml:12:10: `ux`, `normal` exclude each other",
    );
    check(
        "[[body.traction]]\non = 'top'",
        "c.toml:9:1: this condition applies no load; expected either `vector",
    );
    check(
        "[[body.traction]]\non = 'top'\nvector = [0, 1]\npressure = 1",
        "c.toml:12:12: `vector` and `pressure` exclude each other",
    );
    check(
        "[[body.traction]]\non = 'top'\nvector = [0, nan]",
        "c.toml:11:14: `body.0.traction.0.vector.1` is NaN",
    );
    check(
        "[[body.traction]]\non = 'top'\npressure = 1\npart = { x = [1, 0] }",
        "c.toml:12:14: the limits of the part are in the wrong order",
    );
    check(
        "[[body.traction]]\non = 'top'\npressure = 1\npart = { z = [1, 0] }",
        "c.toml:12:10: unknown key `z` in `body.0.traction.0.part`",
    );
    check(
        "[body.displacement]\non = 'top'\nux = 1",
        "c.toml:9:1: `body.0.displacement` is a table; expected an array of tables, each under [[displacement]]",
    );
}

#[test]
fn nonsense_of_adaptive_runs_is_refused() {
    let fraction = |line: &str, found: &str, expected: &str| {
        refused_too(
            &format!("[adapt]\ntarget_relative_error = 0.02\n{line}"),
            &format!("c.toml:17:{found}; expected {expected}"),
        );
    };
    for (value, shown) in [("1.5", "1.5"), ("0.0", "0"), ("-0.5", "-0.5")] {
        let found = format!("12: `adapt.fraction` is {shown}");
        fraction(&format!("fraction = {value}"), &found, "a number > 0 and <= 1");
    }
    fraction("max_steps = 0", "13: `adapt.max_steps` is 0", "a whole number, at least 1");
    fraction("max_nodes = 0", "13: `adapt.max_nodes` is 0", "a whole number, at least 1");
    for (value, shown) in [("0.0", "0"), ("-0.02", "-0.02"), ("1.0", "1"), ("2.0", "2")] {
        let expected =
            format!("c.toml:16:25: `adapt.target_relative_error` is {shown}; expected a number > 0 and < 1");
        refused_too(&format!("[adapt]\ntarget_relative_error = {value}"), &expected);
    }
    refused_too("[adapt]\ntarget = 0.02", "c.toml:16:1: unknown key `target` in `adapt`");
    refused_too("[adapt]\nmax_steps = 3", "c.toml:15:1: the key `adapt.target_relative_error` is missing");
}

#[test]
fn relaxation_is_by_steps_or_by_tolerance() {
    let until = |rest: &str| Case::parse(&minimal(rest), "c.toml", &[]).unwrap().estimator;
    assert_eq!(until("").until, Some(Plane::RELAX_UNTIL));
    let steps = until("[estimator]\nrelaxation = 3");
    assert_eq!((steps.relaxation, steps.until), (3, None));
    assert_eq!(until("[estimator]\nmax_steps = 4").until.unwrap().max_steps, 4);
    let by_tolerance = until("[estimator]\ntolerance = 0.02");
    assert_eq!(by_tolerance.until, Some(RelaxUntil { tolerance: 0.02, max_steps: 100 }));
    let few = until("[estimator]\ntolerance = 0.02\nmax_steps = 4");
    assert_eq!(few.until.unwrap().max_steps, 4);
    refused_too("[estimator]\nrelaxation = 2\ntolerance = 0.02", "c.toml:17:13: `estimator.relaxation` and");
    let both = "[estimator]\nrelaxation = 2\nmax_steps = 2";
    refused_too(both, "c.toml:17:13: `estimator.relaxation` and `estimator.max_steps` both");
    refused_too("[estimator]\ntolerance = 1.0", "c.toml:16:13: `estimator.tolerance` is 1");
    // Default settings are among the settings that identify the case.
    let settings = Case::parse(&minimal(""), "c.toml", &[]).unwrap().settings_json();
    assert_eq!(settings["estimator"], serde_json::json!({ "tolerance": 0.02, "max_steps": 100, "every": 0 }));
}

fn refused_too(rest: &str, expected: &str) {
    let found = faults(&minimal(rest));
    assert!(found.iter().any(|f| f.starts_with(expected)), "{found:#?}");
}

#[test]
fn words_of_other_programs_get_a_sentence() {
    for (rest, sentence) in [
        ("[model]\nhypothesis = \"axisymmetric\"", "there are no problems with an axis of symmetry"),
        ("mu = 0.3", "`friction = { law = \"coulomb\", mu = 0.3 }`"),
        ("friction = 0.3", "`friction = { law = \"coulomb\", mu = 0.3 }`"),
        ("[solver]\nNLgeom = true", "displacements and strains are small throughout"),
        ("clearance = 0.1", "this is `gap`"),
    ] {
        let found = faults(&minimal(rest));
        assert!(found.len() == 1 && found[0].contains(sentence), "{found:#?}");
    }
}

#[test]
fn a_modulus_that_no_solid_has_in_the_units_is_a_warning() {
    let said = |young: &str, units: &str| -> Vec<String> {
        let text =
            minimal(&format!("[units]\n{units}")).replacen("young = 1.0", &format!("young = {young}"), 1);
        Case::parse(&text, "c", &[]).unwrap().warnings().iter().map(ToString::to_string).collect()
    };
    let millimetres = "length = \"mm\"\nforce = \"N\"";
    let found = said("210e9", millimetres).concat();
    assert!(found.contains("2.1e17 Pa") && found.contains("if it is in Pa, write 2.1e5"), "{found}");
    let found = said("0.21", "length = \"m\"\nforce = \"N\"").concat();
    assert!(found.contains("if it is in GPa, write 2.1e8"), "{found}");
    assert!(said("210e3", millimetres).is_empty());
    // The names of other units are not known.
    assert!(said("210e9", "length = \"ell\"\nforce = \"N\"").is_empty());
}

#[test]
fn adaptive_runs_have_their_defaults() {
    let case = Case::parse(&minimal("[adapt]\ntarget_relative_error = 0.02\n"), "c", &[]).unwrap();
    let target = Target::RelativeError(0.02);
    let expected = Adapt { target, max_steps: 30, max_nodes: 2_000_000, fraction: 0.5 };
    assert_eq!(case.adapt, Some(expected));
}

#[test]
fn independent_faults_come_together() {
    let text = minimal("[solver]\ntheata = 0.4\nmethod = 'newtn'\n[output]\nvtu = 'yes'\n")
        .replace("young = 1.0", "young = nan");
    let found = faults(&text);
    let places: Vec<&str> = found.iter().map(|f| f.split(": ").next().unwrap()).collect();
    assert_eq!(places, ["c.toml:3:9", "c.toml:16:1", "c.toml:17:10", "c.toml:19:7"], "{found:#?}");
}

#[test]
fn many_faults_are_counted() {
    let many: String = (0..500).map(|k| format!("key{k} = 1\n")).collect();
    let error = Case::parse(&minimal(&format!("[solver]\n{many}")), "c", &[]).unwrap_err();
    assert_eq!((error.diagnostics.len(), error.omitted), (20, 480));
}

#[test]
fn what_is_not_toml_has_its_place() {
    assert!(faults("schema = \n")[0].starts_with("c.toml:1:10: "));
    assert!(
        faults("schema = 1\nschema = 1\n")[0].contains("duplicate key"),
        "{:?}",
        faults("schema = 1\nschema = 1\n")
    );
    assert!(faults("schema = 1\n[materials.a]\n[materials.a]\n")[0].starts_with("c.toml:3:"));
    // The message names the first key of the same table, or the first header. Keys under the second header are not reported as well.
    let twice =
        faults("[a]\nx = 1\n[b]\nxy = 1\nx = 1\nx = 2\n[c]\nx = 1\n[c]\nx = 1\n[d]\ny = { z = 1, z = 2 }\n");
    let firsts: Vec<_> = twice
        .iter()
        .map(|f| f.split("first defined in line ").nth(1).and_then(|rest| rest.split(';').next()))
        .collect();
    assert_eq!(firsts, [Some("5"), Some("7"), Some("12")], "{twice:#?}");
    let two = faults("a = 1 2\nb = 3\nc = \"x\n");
    assert_eq!(two.len(), 2, "{two:?}");
    // A fault that follows from another fault is not reported again.
    assert_eq!(faults("a = [1, 2\nb = 3\n[c]\nd = 4\ne = \n").len(), 1);
    let open = faults("a = { b = [1, 2 }\nb = 3\n[c]\nd = 4\ne = \n");
    assert_eq!(open.len(), 2, "{open:?}");
    assert!(open[0].starts_with("c.toml:1:") && open[1].starts_with("c.toml:5:"), "{open:?}");
    assert_eq!(faults("[materials.a\nyoung = 1\n[materials.b]\nyoung = 1\n").len(), 1);
    assert_eq!(faults("a = 1\nb = 2\na = 3\nb = 4\n").len(), 2);
    assert!(faults("<!DOCTYPE html>\n")[0].starts_with("c.toml:1:1: "));
    for (text, what) in [("", "the case file is empty"), ("# nothing\n", "the case file sets nothing")] {
        assert!(
            faults(text)[0]
                .starts_with(&format!("c.toml:1:1: {what}; expected the tables of a case; help: write")),
            "{text}"
        );
    }
}

#[test]
fn what_is_not_text_has_its_place() {
    let error = Case::parse_bytes(b"schema = 1\ntitle = \"caf\xE9\"\n", "c.toml", &[]).unwrap_err();
    assert!(error.to_string().starts_with("c.toml:2:13: the byte 0xE9 is not UTF-8 text"), "{error}");
    let error = Case::parse_bytes(b"\xFF\xFEs\0", "c.toml", &[]).unwrap_err();
    assert!(error.to_string().contains("looks like UTF-16"), "{error}");
    assert!(Case::parse_bytes(b"a\0b = 1", "c.toml", &[]).is_err());
}

#[test]
fn hostile_files_end_at_once() {
    let deep = format!("{}a = 1\n", "a.".repeat(200_000));
    let nested = format!("a = {}\n", "[".repeat(200_000));
    let tables: String = (0..20_000).map(|k| format!("[t{k}]\nx = 1\n")).collect();
    for text in [deep, nested, tables, "\0".repeat(1000), "[[body]]\n".repeat(20_000)] {
        assert!(Case::parse(&text, "c", &[]).is_err());
    }
}

#[test]
fn wrong_overrides_name_themselves() {
    let fault =
        |key: &str, value: &str| Case::parse(&minimal(""), "c", &[set(key, value)]).unwrap_err().to_string();
    assert!(fault("solver.theata", "1").starts_with(
        "--set solver.theata=1: unknown key `theata` in `solver`; expected only the keys `method`"
    ));
    assert!(
        fault("solver.theta", "-1")
            .starts_with("--set solver.theta=-1: `solver.theta` is -1; expected a number > 0")
    );
    assert!(fault("solver.theta", "[1,").starts_with("--set solver.theta=[1,: the value is not TOML"));
    assert!(fault("a b", "1").starts_with("--set a b=1: `a b` is not a key"));
    assert!(fault("body.2.name", "x").starts_with("--set body.2.name=x: `body` has the entries 0 to 1"));
    assert!(
        fault("body.name", "x")
            .starts_with("--set body.name=x: `body` has the entries 0 to 1, so there is no `name`")
    );
    assert!(fault("schema.x", "1").starts_with("--set schema.x=1: `schema` is an integer, so it has no `x`"));
    assert!(fault("body.0.traction.0.pressure", "1").starts_with("--set body.0.traction.0.pressure=1: "));
    assert!(fault("solver", "3").starts_with("--set solver=3: `solver` is the integer 3; expected a table"));
    assert!(fault("solver.theta", "nan").starts_with("--set solver.theta=nan: `solver.theta` is NaN"));
}

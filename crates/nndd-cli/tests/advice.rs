//! The advice of messages is followed here, and must help.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").canonicalize().unwrap()
}

fn nndd(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nndd")).current_dir(directory).args(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    let text = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
    String::from_utf8_lossy(&text).into_owned()
}

/// Solves a case with settings, and returns its exit status and what it said.
fn solved(case: &str, settings: &[&str]) -> (Option<i32>, String) {
    let temp = tempfile::tempdir().unwrap();
    let path = cases().join(case);
    let mut arguments = vec!["solve", path.to_str().unwrap(), "--out", "out"];
    settings.iter().for_each(|setting| arguments.extend(["--set", setting]));
    let output = nndd(temp.path(), &arguments);
    (output.status.code(), said(&output))
}

/// The setting that a message advises: "set KEY to VALUE or more".
fn advised(text: &str) -> String {
    let (_, rest) =
        text.split_once("; set ").or_else(|| text.split_once(": set ")).unwrap_or_else(|| panic!("{text}"));
    let (setting, _) = rest.split_once(" or more").unwrap_or_else(|| panic!("{text}"));
    setting.replace(" to ", "=")
}

#[test]
fn a_criterion_below_round_off_is_told_the_value_it_may_have() {
    let case = "bad/case_below_round_off.toml";
    for settings in [
        &["solver.stop.criterion=eta_nndd"][..],
        // The forces of the exact solution are equal: the iteration's are not.
        &["solver.stop.criterion=precision", "solver.method=nndd"],
        &["solver.stop.criterion=estimator", "solver.stop.ratio=1e-30"],
    ] {
        let (code, text) = solved(case, settings);
        assert_eq!(code, Some(5), "{text}");
        let advice = advised(&text);
        let (code, text) = solved(case, &[settings, &[&advice[..]]].concat());
        assert_eq!(code, Some(0), "{advice}: {text}");
    }
}

#[test]
fn nothing_is_said_of_a_bound_that_is_not_valid() {
    let (code, text) = solved("bad/case_not_certified.toml", &[]);
    assert!(code == Some(6) && text.contains("the bound is not valid"), "{text}");
    assert!(!text.contains("the bound is large"), "{text}");
    let (code, text) = solved("bad/case_nearly_incompressible.toml", &[]);
    assert!(code == Some(0) && text.contains("the bound is large"), "{text}");
    // Nearly all of this bound is the iteration's, which no material explains.
    let (code, text) = solved("true_numbers/absurd-allowance.toml", &[]);
    assert!(code == Some(0) && !text.contains("the bound is large"), "{text}");
}

#[test]
fn an_exact_solution_does_not_stop_by_a_criterion_of_iterations() {
    let (code, text) = solved("stack.toml", &[]);
    assert!(code == Some(0) && text.contains("\n  stop       at the exact solution; relaxation"), "{text}");
    let (code, text) = solved("expressions.toml", &[]);
    assert!(code == Some(0) && text.contains("\n  stop       estimator ratio 0.01"), "{text}");
}

/// The first iterates of these blocks are apart, the solution is not.
#[test]
fn no_contact_is_said_of_solutions_only() {
    let (code, text) = solved("bad/adapt_iteration_stopped.toml", &[]);
    assert!(code == Some(5) && !text.contains("no contact"), "{text}");
    let (code, text) = solved("bad/case_opens.toml", &[]);
    assert!(code == Some(0) && text.contains("no contact: no pressure acts"), "{text}");
}

#[test]
fn a_target_below_round_off_is_told_the_one_that_can_be_reached() {
    let case = "bad/adapt_below_round_off.toml";
    // Below the allowance for round-off, and between that and what the iteration reaches.
    for target in ["1e-17", "1e-12"] {
        let (code, text) = solved(case, &[&format!("adapt.target_relative_error={target}")]);
        assert_eq!(code, Some(5), "{text}");
        let advice = advised(&text);
        let (code, text) = solved(case, &[&advice]);
        assert_eq!(code, Some(0), "{advice}: {text}");
    }
}

#[test]
fn a_poissons_ratio_that_is_too_large_is_told_one_that_is_not() {
    let case = cases().join("bad/orthotropic_poisson.toml");
    for hypothesis in ["plane_strain", "plane_stress"] {
        let hypothesis = format!("model.hypothesis={hypothesis}");
        let check = |more: &[&str]| {
            let arguments = [&["check", case.to_str().unwrap(), "--set", &hypothesis], more].concat();
            nndd(&cases(), &arguments)
        };
        let refused = check(&[]);
        let text = said(&refused);
        assert_eq!(refused.status.code(), Some(3), "{text}");
        let (_, rest) = text.split_once("expected at most ").unwrap();
        let (largest, _) = rest.split_once(' ').unwrap();
        let setting = format!("materials.m.poisson_12={largest}");
        let taken = check(&["--set", &setting]);
        assert_eq!(taken.status.code(), Some(0), "{setting}: {}", said(&taken));
        // It is not smaller than necessary.
        let more = format!("materials.m.poisson_12={}", 1.02 * largest.parse::<f64>().unwrap());
        assert_eq!(check(&["--set", &more]).status.code(), Some(3), "{more}");
    }
}

#[test]
fn a_curved_roller_is_named_and_helped_by_both_components() {
    let (code, text) = solved("bad/curved_roller.toml", &[]);
    assert_eq!(code, Some(6), "{text}");
    assert!(text.contains("the check supports (") && text.contains("impose ux and uy on it"), "{text}");
    let temp = tempfile::tempdir().unwrap();
    let case = std::fs::read_to_string(cases().join("bad/curved_roller.toml")).unwrap();
    let held = case.replace("normal = -0.01", "ux = \"-0.005 * x\"\nuy = \"-0.005 * y\"");
    assert!(held != case);
    std::fs::write(temp.path().join("case.toml"), held).unwrap();
    let output = nndd(temp.path(), &["solve", "case.toml", "--out", "out"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

#[test]
fn every_file_that_cannot_be_used_comes_with_what_was_expected_and_a_fix() {
    let temp = tempfile::tempdir().unwrap();
    std::fs::write(temp.path().join("file"), "").unwrap();
    let case = cases().join("patch.toml");
    let case = case.to_str().unwrap();
    for (arguments, code, fix) in [
        (&["check", "none.toml"][..], 7, "nndd new paper > none.toml"),
        (&["check", "."], 7, "name the file in it"),
        (&["new", "papr"], 2, "write `nndd new paper`"),
        (&["solve", case, "--out", "file"], 7, "choose another with --out"),
        (&["solve", case, "--out", "file/below"], 7, "choose another with --out"),
    ] {
        let output = nndd(temp.path(), arguments);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
        assert!(
            text.contains("\n  expected: ") && text.contains("\n  fix: ") && text.contains(fix),
            "{text}"
        );
    }
    let mesh = cases().join("meshes/blocks.msh");
    let output = nndd(temp.path(), &["solve", mesh.to_str().unwrap()]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(text.contains("a case file in TOML") && text.contains("nndd mesh "), "{text}");
}

#[test]
fn a_misspelt_geometric_gap_is_told_the_word() {
    let (code, text) = solved("rings.toml", &["contact.gap=geometrc"]);
    assert_eq!(code, Some(3), "{text}");
    assert!(
        text.contains("or the word \"geometric\"") && text.contains("did you mean \"geometric\"?"),
        "{text}"
    );
}

#[test]
fn what_is_not_a_number_is_told_an_example_of_its_key() {
    for (key, example) in [("materials.stiff.poisson", "poisson = 0.3"), ("solver.theta", "theta = 0.4")] {
        let (code, text) = solved("paper.toml", &[&format!("{key}=inf")]);
        assert_eq!(code, Some(3), "{text}");
        assert!(text.contains(&format!("as in `{example}`")) && !text.contains("1e12"), "{text}");
    }
}

#[test]
fn printed_bounds_of_iterations_and_meshes_are_not_below_the_numbers() {
    let temp = tempfile::tempdir().unwrap();
    let case = cases().join("paper.toml");
    let settings = ["--set", "adapt.target_relative_error=0.1"];
    for more in [&[][..], &settings] {
        let arguments = [&["solve", case.to_str().unwrap(), "--out", "out", "--force"], more].concat();
        let output = nndd(temp.path(), &arguments);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(0), "{text}");
        let report = std::fs::read_to_string(temp.path().join("out/report.json")).unwrap();
        let report = Report::from_json(&report).unwrap();
        let page = std::fs::read_to_string(temp.path().join("out/report.html")).unwrap();
        let bounds: Vec<f64> = if report.adaptive.is_empty() {
            report.iterations.iter().filter_map(|row| row.e_cre).collect()
        } else {
            report.adaptive.iter().map(|row| row.e_cre.unwrap()).collect()
        };
        // The column of the console by its head; adaptive tables have it last but two words, "x %".
        let head = text.lines().find(|line| line.contains("e_cre")).unwrap();
        let end = head.find("e_cre").unwrap() + "e_cre".len();
        let shown = text.lines().filter_map(|line| line.get(end - 9..end)?.trim().parse::<f64>().ok());
        let shown: Vec<f64> = shown.collect();
        assert_eq!(shown.len(), bounds.len(), "{text}");
        for (shown, bound) in shown.iter().zip(&bounds) {
            assert!(shown >= bound && *shown <= 1.001 * bound, "{shown} {bound}");
        }
        // The page has a number not below each of them too.
        let cells: Vec<f64> =
            page.split("<td>").filter_map(|cell| cell.split('<').next()?.parse().ok()).collect();
        for bound in bounds {
            assert!(cells.iter().any(|cell| *cell >= bound && *cell <= 1.001 * bound), "{bound}");
        }
    }
}

/// Solves a case with settings; returns its report.
fn reported(case: &str, settings: &[&str]) -> Report {
    let temp = tempfile::tempdir().unwrap();
    let path = cases().join(case);
    let mut arguments = vec!["solve", path.to_str().unwrap(), "--out", "out", "--quiet"];
    settings.iter().for_each(|setting| arguments.extend(["--set", setting]));
    nndd(temp.path(), &arguments);
    Report::from_json(&std::fs::read_to_string(temp.path().join("out/report.json")).unwrap()).unwrap()
}

fn notes_of_growth(report: &Report) -> Vec<&str> {
    report.notes.iter().map(String::as_str).filter(|note| note.contains("grows without limit")).collect()
}

#[test]
fn a_stress_that_is_said_to_grow_does_and_another_does_not() {
    // The roller of the upper block ends in the middle of its top.
    let stress = |case: &str, cells: &str, place: &str, more: &[&str]| {
        let cells = [format!("body.0.generator.cells={cells}"), format!("body.1.generator.cells={cells}")];
        let report = reported(case, &[&[cells[0].as_str(), &cells[1]], more].concat());
        let notes = notes_of_growth(&report).join("\n");
        assert!(notes.contains(&format!("the largest stress is at the end of a {place}")), "{notes}");
        report.results.peak_stress.unwrap().von_mises
    };
    let place = "support of body \"upper\" at (1, 1)";
    // On 16 x 8 cells another place has the largest stress.
    let found = ["[32, 16]", "[64, 32]", "[128, 64]"]
        .map(|cells| stress("singular.toml", cells, place, &["adapt.max_steps=1"]));
    // Like 1/√h.
    assert!(found[1] > 1.25 * found[0] && found[2] > 1.25 * found[1], "{found:?}");
    // Like −ln h where the tangential load of the right side ends at the roller.
    let place = "roller, where a tangential load ends, of body \"upper\" at (2, 2)";
    let found = ["[16, 8]", "[32, 16]", "[64, 32]"].map(|cells| stress("paper.toml", cells, place, &[]));
    let steps = [found[1] - found[0], found[2] - found[1]];
    assert!(steps[0] > 0.0 && steps[1] > 0.7 * steps[0], "{found:?}");
    for smooth in ["kirsch.toml", "patch.toml", "points.toml"] {
        let report = reported(smooth, &[]);
        assert!(notes_of_growth(&report).is_empty(), "{smooth}: {:?}", report.notes);
    }
}

#[test]
fn a_pressure_that_is_said_to_grow_is_at_a_sharp_edge() {
    let report = reported("punch_corner.toml", &[]);
    let notes = notes_of_growth(&report);
    let found = notes.iter().find(|note| note.contains("the largest pressure is at a sharp contact edge"));
    assert!(found.is_some_and(|note| note.contains("of body \"upper\"")), "{notes:?}");
    let curved = reported("hertz.toml", &[]);
    assert!(!notes_of_growth(&curved).iter().any(|note| note.contains("pressure")), "{:?}", curved.notes);
}

#[test]
fn rigid_sides_beside_supports_and_round_obstacles_that_may_move_aside_get_a_note() {
    let case = r#"
        schema = 1
        materials.soft = { young = 1000.0, poisson = 0.3 }
        [[body]]
        name = "block"
        material = "soft"
        generator = { kind = "block", origin = [0.0, 0.0], size = [2.0, 1.0], cells = [8, 4] }
        [[body.displacement]]
        on = "left"
        ux = 0.0
        [[body.rigid]]
        on = "bottom"
        ux = 0.0
        uy = 0.0
        rotation = 0.0
        [[contact]]
        bodies = ["block"]
        surfaces = ["top"]
        obstacle = { kind = "circle", centre = [1.0, 2.0], radius = 1.0, uy = -0.01, rotation = 0.0 }
        gap = "geometric"
    "#;
    let temp = tempfile::tempdir().unwrap();
    let notes = |case: &str| {
        std::fs::write(temp.path().join("case.toml"), case).unwrap();
        let output = nndd(temp.path(), &["check", "case.toml"]);
        assert!(output.status.success(), "{}", said(&output));
        let said = said(&output);
        ["imposes `ux`, and a support on \"left\"", "write `ux = 0.0` if it must not"]
            .map(|note| said.contains(note))
    };
    assert_eq!(notes(case), [true, true]);
    assert_eq!(notes(&case.replace("uy = -0.01,", "uy = -0.01, ux = 0.0,")), [true, false]);
    assert_eq!(
        notes(&case.replace("on = \"left\"\n        ux = 0.0", "on = \"left\"\n        uy = 0.0")),
        [false, true]
    );
}

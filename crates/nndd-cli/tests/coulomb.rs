//! Coulomb friction from case files: a residual in place of a certificate, and nothing that could be read as one.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(name)
}

/// Runs a command of the program on an example case with settings.
fn run(here: &Path, command: &str, name: &str, settings: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_nndd"));
    program.current_dir(here).arg(command).arg(case(name));
    settings.iter().for_each(|setting| {
        program.args(["--set", setting]);
    });
    if command != "check" {
        program.args(["--out", "out", "--force"]);
    }
    program.output().unwrap()
}

fn said(output: &Output) -> String {
    let text = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
    let text = String::from_utf8(text).unwrap();
    assert!(!text.contains("panicked"), "{text}");
    text
}

/// Solves a case that leaves a report.
fn solved(here: &Path, name: &str, settings: &[&str]) -> (Report, String) {
    let output = run(here, "solve", name, settings);
    let text = said(&output);
    let report = std::fs::read_to_string(here.join("out/report.json")).unwrap();
    let report = Report::from_json(&report).unwrap();
    assert_eq!(output.status.code(), Some(i32::from(report.status.code)), "{text}");
    (report, text)
}

/// Every file under a directory.
fn files(directory: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Reads the number of a field of a whole ParaView file, in its appended raw block behind its length in eight bytes.
fn field(file: &[u8], name: &str) -> Option<f64> {
    let mark = b"<AppendedData encoding=\"raw\">\n   _";
    let start = file.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
    let header = std::str::from_utf8(&file[..start]).unwrap();
    let tag = header.lines().find(|line| line.contains(&format!("Name=\"{name}\"")))?;
    let offset: usize = tag.split("offset=\"").nth(1)?.split('"').next()?.parse().ok()?;
    let block = start + offset + 8;
    Some(f64::from_le_bytes(file[block..block + 8].try_into().unwrap()))
}

/// Asserts that no text says that something is certified; the only array of this name in a ParaView file is 0.
fn nothing_is_certified(text: &str, out: &Path) {
    let says = |text: &str| {
        let text = text.to_lowercase();
        text.contains("certified") || text.contains("guaranteed")
    };
    assert!(!says(text), "{text}");
    let all = files(out);
    let mut arrays = 0;
    for file in &all {
        if file.extension().is_some_and(|e| e == "vtu") {
            let bytes = std::fs::read(file).unwrap();
            assert_eq!(field(&bytes, "certified"), Some(0.0), "{}", file.display());
            assert!(
                field(&bytes, "e_cre").is_none() && field(&bytes, "e_b") > Some(0.0),
                "{}",
                file.display()
            );
            arrays += 1;
        } else {
            assert!(!says(&std::fs::read_to_string(file).unwrap()), "{}", file.display());
        }
    }
    assert!(arrays >= 2 && all.iter().any(|file| file.ends_with("report.html")), "{all:?}");
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
}

#[test]
fn the_figures_of_an_independent_code_come_from_the_case_file() {
    let best = [
        "solver.friction_tolerance=1e-13",
        "solver.friction_steps=80",
        "estimator.tolerance=1e-12",
        "estimator.max_steps=400",
    ];
    let rows = [
        (0.3, [0.698430686688, 0.354783326205], 0.182607249418, [26.4822308467, 4.54856899229], true),
        (0.6, [0.682882125647, 0.364235756451], 0.182720275607, [26.4540475087, 4.86635337656], false),
    ];
    for (mu, energies, e_b, [pressed, dragged], has_estimate) in rows {
        let temp = tempfile::tempdir().unwrap();
        let mu_is = format!("contact.friction.mu={mu:?}");
        let settings: Vec<&str> = best.iter().copied().chain([mu_is.as_str(), "output.vtu=false"]).collect();
        let (report, text) = solved(temp.path(), "coulomb.toml", &settings);
        assert_eq!((report.status.word.as_str(), report.status.code), ("converged", 0), "{text}");
        assert!(report.status.reason.starts_with("one solution found: "), "{}", report.status.reason);
        for (found, expected) in report.results.energy_norm_squared.as_ref().unwrap().iter().zip(energies) {
            near(*found, expected, 1e-11);
        }
        assert!(report.certificate.is_none() && report.problem == "coulomb");
        let coulomb = report.coulomb.as_ref().unwrap();
        near(coulomb.e_b.unwrap(), e_b, 1e-9);
        let norm = energies.iter().sum::<f64>().sqrt();
        near(coulomb.relative.unwrap(), e_b / norm, 1e-9);
        // κ = 2.12 on this mesh, c = μ κ, and no estimate from 0.9 on.
        let (kappa, c) = (coulomb.kappa.unwrap(), coulomb.coupling.unwrap());
        assert!(coulomb.one_sign && (kappa - 2.12).abs() < 0.005, "{kappa}");
        near(c, mu * kappa, 1e-12);
        assert_eq!(coulomb.estimate.is_some(), has_estimate);
        if let Some(estimate) = coulomb.estimate {
            near(estimate, coulomb.e_b.unwrap() / (1.0 - c * c).sqrt(), 1e-12);
        }
        let contact = &report.contact[0];
        near(contact.contact_force.unwrap(), pressed, 1e-11);
        let friction = contact.friction.as_ref().unwrap();
        assert_eq!((friction.law.as_str(), friction.mu), ("coulomb", Some(mu)));
        near(friction.tangential_force.size(), dragged, 1e-11);
        let line = friction.line.as_ref().unwrap();
        assert_eq!((line.stick_intervals.len(), line.slip_intervals.len()), (1, 1));
    }
}

#[test]
fn the_lines_say_that_there_is_no_bound() {
    let temp = tempfile::tempdir().unwrap();
    let (report, text) = solved(temp.path(), "coulomb.toml", &[]);
    assert_eq!(report.status.code, 0, "{text}");
    let lines: Vec<&str> = text.lines().collect();
    let first =
        lines.iter().position(|line| line.starts_with("no bound exists for Coulomb friction; ")).unwrap();
    let percent = |line: &str, before: &str, after: &str| -> f64 {
        let number = line.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
        number.unwrap_or_else(|| panic!("{line}")).parse().unwrap()
    };
    let residual = percent(
        lines[first],
        "no bound exists for Coulomb friction; residual e_b = ",
        " % of the energy norm (an indicator, zero only for an exact solution)",
    );
    let before = "bound if the friction limit were the given one of contact.csv: ";
    let frozen = percent(lines[first + 1], before, " %");
    let before = "estimate, if the exact slip has the same sign: ";
    let estimate = percent(lines[first + 2], before, " %");
    let coulomb = report.coulomb.as_ref().unwrap();
    // Rounded up to four digits.
    let rounded_up = |shown: f64, exact: f64| shown >= 100.0 * exact && shown <= 100.1 * exact;
    assert!(rounded_up(residual, coulomb.relative.unwrap()) && residual == frozen, "{text}");
    assert!(rounded_up(estimate, coulomb.relative_estimate.unwrap()) && estimate > residual, "{text}");
    let page = std::fs::read_to_string(temp.path().join("out/report.html")).unwrap();
    lines[first..first + 3].iter().for_each(|line| assert!(page.contains(line), "{line}"));
    nothing_is_certified(&text, &temp.path().join("out"));
    // The residual is called no bound of the problem that was solved.
    assert!(page.contains("an indicator and no bound"), "{page}");
    // No estimate from c = 0.9 on: two lines.
    let (_, text) = solved(temp.path(), "coulomb.toml", &["contact.friction.mu=0.6"]);
    assert!(text.contains("no bound exists") && !text.contains("estimate, if"), "{text}");
}

#[test]
fn the_limit_of_the_table_is_that_of_the_bound_for_another_problem() {
    let temp = tempfile::tempdir().unwrap();
    let settings = ["output.vtu=false", "estimator.relaxation=2", "solver.friction_tolerance=1e-12"];
    let (report, _) = solved(temp.path(), "coulomb.toml", &settings);
    let table = std::fs::read_to_string(temp.path().join("out/contact.csv")).unwrap();
    let mut lines = table.lines();
    let head = lines.next().unwrap();
    assert_eq!(head, "s,x,y,gap,opening,pressure,active,tangential,slip,limit,state");
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let number = |row: &[&str], k: usize| row[k].parse::<f64>().unwrap();
    let mut states = std::collections::BTreeSet::new();
    // An expression with hats at the nodes, 2/18 apart: the limit of the table, linear between them.
    let hat = |row: &Vec<&str>| format!("{:?}*max(0, 1 - 9*abs(x - {:?}))", number(row, 9), number(row, 1));
    for row in &rows {
        assert!((number(row, 9) - 0.3 * number(row, 5)).abs() < 1e-9 * (1.0 + number(row, 5)), "{row:?}");
        assert!(number(row, 7).abs() <= number(row, 9) * (1.0 + 1e-9) + 1e-12, "{row:?}");
        states.insert(row[10].to_owned());
    }
    assert_eq!(states.into_iter().collect::<Vec<_>>(), ["open", "slip", "stick"]);
    let limit: Vec<String> = rows.iter().filter(|row| number(row, 9) > 0.0).map(hat).collect();
    let limit = format!("contact.friction.limit=\"{}\"", limit.join(" + "));
    let settings = [&limit, "output.vtu=false", "estimator.relaxation=2"];
    let here = temp.path().join("tresca");
    std::fs::create_dir(&here).unwrap();
    let (tresca, text) = solved(&here, "tresca.toml", &settings);
    let bound = tresca.certificate.as_ref().unwrap();
    assert!(bound.valid, "{text}");
    near(report.coulomb.unwrap().e_b.unwrap(), bound.e_cre.unwrap(), 1e-7);
}

#[test]
fn a_slope_is_held_up_to_its_coefficient() {
    let temp = tempfile::tempdir().unwrap();
    let (report, text) = solved(temp.path(), "slope.toml", &[]);
    assert_eq!(report.status.code, 0, "{text}");
    nothing_is_certified(&text, &temp.path().join("out"));
    let contact = &report.contact[0];
    // The weight is 2 × 10, its part along the slope 2 × 4.
    near(contact.contact_force.unwrap(), 20.0, 1e-10);
    near(contact.friction.as_ref().unwrap().tangential_force.size().abs(), 8.0, 1e-10);
    let steeper = ["body.0.body_force=[6.0, -10.0]"];
    for command in ["solve", "check"] {
        let here = tempfile::tempdir().unwrap();
        let output = run(here.path(), command, "slope.toml", &steeper);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(4), "{text}");
        assert!(
            text.contains("the load is not balanced within the friction cones: body \"block\" can "),
            "{text}"
        );
        assert!(text.contains(" in that direction, which no contact forces"), "{text}");
        assert!(text.contains("\n  expected: ") && text.contains("\n  fix: "), "{text}");
        assert!(!here.path().join("out/report.json").exists());
    }
    let output = run(temp.path(), "check", "slope.toml", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

/// Full stick holds the eye around the pin where nothing presses, and pressures of zero made limits of zero.
#[test]
fn friction_holds_an_eye_with_clearance_against_a_torque() {
    let solved = |torque: &str, mu: &str| {
        let temp = tempfile::tempdir().unwrap();
        let friction = format!("contact.0.friction={{law=\"coulomb\",mu={mu}}}");
        let load = format!("body.1.traction.0.vector=[60.0, {torque}]");
        solved(temp.path(), "true_numbers/pin-free/pin_arc.toml", &[&friction, &load])
    };
    for torque in ["0.0", "1e-9", "6.0"] {
        let (report, text) = solved(torque, "0.3");
        assert_eq!(report.status.word, "converged", "{torque}: {text}");
        assert!(report.coulomb.as_ref().unwrap().restarts == 1, "{torque}: {text}");
        let contact = &report.contact[0];
        let (force, friction) = (contact.contact_force.unwrap(), contact.friction.as_ref().unwrap());
        let friction = friction.tangential_force.size().abs();
        assert!(friction <= 0.3 * force, "{torque}: {friction} {force}");
        // A moment of 170 N/mm times the outer radius, over the radius of the pin.
        let balances = if torque == "6.0" { 340.0 } else { 0.0 };
        assert!((friction - balances).abs() < 2.0, "{torque}: {friction}");
    }
    for (torque, mu) in [("30.0", "0.3"), ("6.0", "0.01")] {
        let (report, text) = solved(torque, mu);
        assert_eq!((report.status.word.as_str(), report.status.code), ("stalled", 5), "{text}");
        assert!(text.contains("friction is too small to hold the bodies with the pressures found"), "{text}");
        assert!(text.contains(": body \"eye\" can rotate about (0, 0) (load "), "{text}");
        assert!(text.contains(" in that direction is left)"), "{text}");
    }
}

#[test]
fn a_fixed_point_that_does_not_converge_is_said() {
    let temp = tempfile::tempdir().unwrap();
    let (report, text) = solved(temp.path(), "coulomb.toml", &["solver.friction_steps=2"]);
    assert_eq!((report.status.word.as_str(), report.status.code), ("max_iterations", 5), "{text}");
    assert!(text.contains("raise solver.friction_steps"), "{text}");
    // The residual belongs to the pair that was reached, and is still no bound.
    assert!(report.certificate.is_none() && report.coulomb.as_ref().unwrap().steps == 2);
    nothing_is_certified(&text, &temp.path().join("out"));
}

#[test]
fn an_adaptive_run_ends_with_its_residual() {
    let temp = tempfile::tempdir().unwrap();
    let (report, text) = solved(temp.path(), "coulomb.toml", &["adapt.target_coulomb_residual=0.04"]);
    assert_eq!((report.status.word.as_str(), report.status.code), ("residual_reached", 0), "{text}");
    assert!(report.coulomb.as_ref().unwrap().relative.unwrap() <= 0.04);
    assert!(report.adaptive.len() > 2, "{text}");
    for row in &report.adaptive {
        assert!(row.e_cre.is_none() && row.relative.is_none());
    }
    let residuals: Vec<f64> = report.adaptive.iter().map(|row| row.relative_residual.unwrap()).collect();
    assert!(residuals.windows(2).all(|pair| pair[1] < pair[0]), "{residuals:?}");
    let table = std::fs::read_to_string(temp.path().join("out/adaptive.csv")).unwrap();
    assert!(table.starts_with("step,nodes,pairs,e_b,relative_residual,iterations,"), "{table}");
    nothing_is_certified(&text, &temp.path().join("out"));
    let (report, text) = solved(
        temp.path(),
        "coulomb.toml",
        &["adapt.target_coulomb_residual=0.01", "adapt.max_nodes=900", "output.vtu=false"],
    );
    assert_eq!((report.status.word.as_str(), report.status.code), ("target_missed", 6), "{text}");
    assert!(report.status.reason.starts_with("relative residual "), "{}", report.status.reason);
}

#[test]
fn what_coulomb_friction_does_not_support_is_refused_with_its_place() {
    let temp = tempfile::tempdir().unwrap();
    let refused = |command: &str, name: &str, settings: &[&str], words: &[&str]| {
        let output = run(temp.path(), command, name, settings);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(3), "{settings:?}: {text}");
        assert!(text.contains("expected ") && text.contains("help: "), "{text}");
        words.iter().for_each(|word| assert!(text.contains(word), "\"{word}\" is not in\n{text}"));
        assert!(!temp.path().join("out").exists());
    };
    for command in ["solve", "check"] {
        let no_certificate =
            ["adapt.target_relative_error", "no certificate exists", "use target_coulomb_residual"];
        refused(command, "coulomb.toml", &["adapt.target_relative_error=0.05"], &no_certificate);
        let place = "--set solver.method";
        refused(
            command,
            "coulomb.toml",
            &["solver.method=nndd"],
            &[place, "does not support Coulomb friction"],
        );
        let words = ["--set solver.path", "both words gave the same numbers"];
        refused(command, "coulomb.toml", &["solver.path=literal"], &words);
        let words = ["--set solver.theta", "does not support Coulomb friction"];
        refused(command, "coulomb.toml", &["solver.theta=0.5"], &words);
        let words = ["target_coulomb_residual` is for Coulomb friction", "target_relative_error"];
        refused(command, "tresca.toml", &["adapt.target_coulomb_residual=0.1"], &words);
    }
    for mu in ["nan", "inf", "-0.1", "\"x\"", "[]"] {
        let setting = format!("contact.friction.mu={mu}");
        refused("solve", "coulomb.toml", &[&setting], &["`contact.friction.mu` is "]);
    }
    for (setting, word) in [
        ("solver.friction_tolerance=0.0", "a number > 0"),
        ("solver.friction_steps=0", "`solver.friction_steps` is"),
        ("contact.friction.mus=0.3", "mu"),
    ] {
        refused("solve", "coulomb.toml", &[setting], &[word]);
    }
    for over in ["solver.theta=0.4:0.6:0.1", "contact.friction.mu=[0.3, 0.4]"] {
        let mut sweep = Command::new(env!("CARGO_BIN_EXE_nndd"));
        sweep.current_dir(temp.path()).arg("sweep").arg(case("coulomb.toml"));
        let output = sweep.args(["--out", "out", "--over", over]).output().unwrap();
        let text = said(&output);
        assert_eq!(output.status.code(), Some(3), "{text}");
        assert!(text.contains("Coulomb friction") && !temp.path().join("out/sweep.json").exists(), "{text}");
    }
}

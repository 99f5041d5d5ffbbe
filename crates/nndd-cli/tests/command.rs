//! Runs the binary as a user does: example cases, wrong inputs, output directories, reports.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use nndd_report::words::{certified_digits, with_digits};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases")
}

fn nndd(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).current_dir(directory).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn solve(case: &Path, out: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["solve", case.to_str().unwrap(), "--out", out.to_str().unwrap()];
    arguments.extend(more);
    nndd(&arguments, out.parent().unwrap())
}

fn report(out: &Path) -> Report {
    Report::from_json(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap()
}

#[test]
fn every_bad_case_ends_as_it_says() {
    let mut cases: Vec<PathBuf> =
        std::fs::read_dir(cases().join("bad")).unwrap().map(|entry| entry.unwrap().path()).collect();
    cases.retain(|case| case.extension().is_some_and(|e| e == "toml"));
    cases.sort();
    assert!(cases.len() >= 100, "only {} bad cases found", cases.len());
    let wrong: Vec<String> =
        cases.iter().filter_map(|case| Some(format!("{}: {}", case.display(), fault(case)?))).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// Finds an error of some output that does not say what was expected and one fix.
fn without_cure(said: &str) -> Option<&str> {
    said.lines().find(|line| {
        let cured = line.contains("; expected ") && line.contains("; help: ");
        // Errors that have no place take three lines.
        let in_lines = said.contains("\n  expected: ") && said.contains("\n  fix: ");
        line.starts_with("error") && !cured && !in_lines
    })
}

/// Says what a bad case does otherwise than its first lines say.
fn fault(case: &Path) -> Option<String> {
    let source = std::fs::read_to_string(case).unwrap();
    let line = |head: &str| source.lines().find_map(|l| l.strip_prefix(head)).map(str::trim);
    let (Some(expected), Some(words)) = (line("# expect: exit "), line("# words: ")) else {
        return Some("no line \"# expect: exit \" or \"# words: \"".into());
    };
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(case, &out, &[]);
    let said = text(&output.stdout) + &text(&output.stderr);
    let code = output.status.code();
    if code != expected.parse().ok() || said.contains("panicked") {
        return Some(format!("exit {code:?}, expected {expected}\n{said}"));
    }
    if let Some(word) = words.split(" | ").find(|word| !said.contains(word)) {
        return Some(format!("\"{word}\" is not in\n{said}"));
    }
    if let Some(line) = without_cure(&said) {
        return Some(format!("no expectation or no fix in\n{line}"));
    }
    // No result of a run that made no sense; always one of a run that did, once there is an iterate.
    let exists = out.join("report.json").exists();
    if exists != matches!(expected, "0" | "5" | "6") && expected != "8" {
        return Some(format!("report.json exists: {exists}"));
    }
    let notes = line("# notes: ")?;
    let found = report(&out).notes.join("\n");
    let word = notes.split(" | ").find(|word| !found.contains(word))?;
    Some(format!("\"{word}\" is not in the notes\n{found}"))
}

#[test]
fn the_papers_case_gives_a_complete_result() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("paper");
    let output = solve(&cases().join("paper.toml"), &out, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("certified error <="));
    let files = [
        "report.html",
        "history.csv",
        "contact.csv",
        "upper.vtu",
        "lower.vtu",
        "contact.vtu",
        "figures/problem.svg",
        "figures/convergence.svg",
        "figures/deformed.svg",
        "figures/von_mises.svg",
        "figures/displacement.svg",
        "figures/contact.svg",
    ];
    for file in files {
        assert!(out.join(file).metadata().unwrap().len() > 100, "{file}");
    }
    let report = report(&out);
    assert_eq!((report.status.word.as_str(), report.status.code), ("converged", 0));
    assert!(report.certificate.as_ref().unwrap().valid);
    let split = &report.certificate.as_ref().unwrap().split;
    let sum = split.discretisation.unwrap().powi(2) + split.algebraic.unwrap().powi(2);
    let e_cre = report.certificate.as_ref().unwrap().e_cre.unwrap();
    assert!((sum - e_cre * e_cre).abs() <= 1e-12 * e_cre * e_cre);
    assert!(report.run["clarabel_calls"].as_u64().unwrap() >= 1);
    let t = &report.timings;
    let parts = t.mesh + t.assembly + t.factorisation + t.iterations + t.estimate + t.write;
    assert!((parts - t.total).abs() <= 0.02 * t.total);
    for (name, fx, fy) in report.results.reactions.iter().flatten().map(|r| (&r.on, r.fx, r.fy)) {
        assert!(fx.is_finite() && fy.is_finite(), "{name}");
    }
}

#[test]
fn an_output_directory_is_kept_from_harm() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let paper = cases().join("paper.toml");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("thesis.tex"), "precious").unwrap();
    let refused = solve(&paper, &out, &[]);
    assert_eq!(refused.status.code(), Some(7));
    assert!(text(&refused.stderr).contains("--force"));
    assert_eq!(solve(&paper, &out, &["--force"]).status.code(), Some(0));
    // The same case again replaces its own result, which would be the same; another case does not.
    assert_eq!(solve(&paper, &out, &[]).status.code(), Some(0));
    let before = std::fs::read(out.join("report.json")).unwrap();
    let other = solve(&paper, &out, &["--set", "solver.theta=0.3"]);
    assert_eq!(other.status.code(), Some(7));
    assert!(text(&other.stderr).contains("--force"));
    assert_eq!(std::fs::read(out.join("report.json")).unwrap(), before);
    assert_eq!(std::fs::read_to_string(out.join("thesis.tex")).unwrap(), "precious");
}

#[test]
fn missing_files_and_wrong_arguments_have_their_status() {
    let temp = tempfile::tempdir().unwrap();
    let here = temp.path();
    assert_eq!(nndd(&["solve", "absent.toml"], here).status.code(), Some(7));
    assert_eq!(nndd(&["solve"], here).status.code(), Some(2));
    assert_eq!(nndd(&[], here).status.code(), Some(2));
    assert_eq!(nndd(&["new", "nothing"], here).status.code(), Some(2));
    let paper = cases().join("paper.toml");
    let wrong = nndd(&["check", paper.to_str().unwrap(), "--set", "solver.theata=1"], here);
    assert_eq!(wrong.status.code(), Some(3));
    assert!(text(&wrong.stderr).contains("did you mean"));
}

#[test]
fn templates_are_cases_that_solve() {
    let temp = tempfile::tempdir().unwrap();
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/cases/meshes/blocks.msh");
    std::fs::copy(mesh, temp.path().join("blocks.msh")).unwrap();
    for name in ["paper", "patch", "hertz", "adaptive", "gmsh", "solid"] {
        let template = nndd(&["new", name], temp.path());
        let case = temp.path().join(format!("{name}.toml"));
        std::fs::write(&case, &template.stdout).unwrap();
        assert_eq!(nndd(&["check", case.to_str().unwrap()], temp.path()).status.code(), Some(0));
        let output = solve(&case, &temp.path().join(name), &["--quiet"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn check_describes_a_case_as_one_object() {
    let temp = tempfile::tempdir().unwrap();
    let paper = cases().join("paper.toml");
    let checked = nndd(&["check", paper.to_str().unwrap(), "--format", "json"], temp.path());
    assert_eq!(checked.status.code(), Some(0));
    let object: serde_json::Value = serde_json::from_str(&text(&checked.stdout)).unwrap();
    assert_eq!(object["event"], "checked");
    assert_eq!((&object["bodies"][0]["nodes"], &object["contact"][0]["pairs"]), (&190.into(), &19.into()));
    assert!(object["memory_bytes"].as_u64().is_some_and(|bytes| bytes > 0), "{object}");
    let wrong = nndd(&["check", "absent.toml", "--format", "json"], temp.path());
    assert_eq!(wrong.status.code(), Some(7));
    assert_eq!(serde_json::from_str::<serde_json::Value>(&text(&wrong.stdout)).unwrap()["event"], "failed");
}

#[test]
fn units_label_and_change_no_number() {
    let temp = tempfile::tempdir().unwrap();
    let paper = cases().join("paper.toml");
    let units = ["--set", "units.length=\"mm\"", "--set", "units.force=\"N\""];
    let bare = solve(&paper, &temp.path().join("bare"), &[]);
    let labelled = solve(&paper, &temp.path().join("mm"), &units);
    assert_eq!((bare.status.code(), labelled.status.code()), (Some(0), Some(0)));
    assert!(text(&labelled.stdout).contains("lengths mm, forces N, stresses MPa"));
    assert!(key_results(&text(&labelled.stdout)).unwrap().contains(" MPa, "));
    let read =
        |folder: &str, file: &str| std::fs::read_to_string(temp.path().join(folder).join(file)).unwrap();
    let report =
        |folder: &str| serde_json::from_str::<serde_json::Value>(&read(folder, "report.json")).unwrap();
    let [bare, labelled] = [report("bare"), report("mm")];
    for key in ["results", "certificate", "iterations"] {
        assert_eq!(bare[key], labelled[key]);
    }
    assert_eq!(bare["run"]["case_hash"], labelled["run"]["case_hash"]);
    assert!(
        read("mm", "report.html").contains("x [mm]") && !read("mm", "report.html").contains("length units")
    );
    for head in ["energy norm [√N]", "e_cre [√N]", "contact force of upper [N/mm]", "force x [N/mm]"] {
        assert!(read("mm", "report.html").contains(head), "{head}");
    }
    let refused = solve(&paper, &temp.path().join("no"), &["--set", "units.length=\"a long name\""]);
    assert_eq!(refused.status.code(), Some(3));
}

/// The line about the contact and the largest stress.
fn key_results(said: &str) -> Option<&str> {
    said.lines().find(|line| line.contains("; these are not bounds"))
}

#[test]
fn a_run_ends_with_its_force_pressure_and_stress() {
    let temp = tempfile::tempdir().unwrap();
    let units = ["--set", "units.length=\"mm\"", "--set", "units.force=\"N\""];
    let out = temp.path().join("out");
    let said = text(&solve(&cases().join("paper.toml"), &out, &units).stdout);
    let report = report(&out);
    let (r, certificate) = (&report.results, report.certificate.as_ref().unwrap());
    let digits = certified_digits(certificate.relative);
    let shown = |x: Option<f64>| with_digits(x.unwrap(), digits);
    let expected = format!(
        "integral of the pressure {} N/mm, largest nodal pressure {} MPa, largest recovered von Mises stress {} MPa; these are not bounds",
        shown(r.contact_force),
        shown(r.max_pressure),
        shown(r.peak_stress.as_ref().map(|peak| peak.von_mises))
    );
    assert_eq!(key_results(&said), Some(expected.as_str()), "{said}");
    // Nodal pressures oscillate on surfaces that do not match.
    let out = temp.path().join("nonmatching");
    let said = text(&solve(&cases().join("nonmatching.toml"), &out, &[]).stdout);
    let report = self::report(&out);
    let digits = certified_digits(report.certificate.as_ref().unwrap().relative);
    let most = with_digits(report.results.max_pressure_recovered.unwrap(), digits);
    let line = key_results(&said).unwrap();
    assert!(
        line.contains(&format!(", largest recovered pressure {most}, ")) && !line.contains("nodal"),
        "{said}"
    );
    // Without a certificate nothing is said of its digits, and an adaptive run speaks of its peak.
    let coulomb = text(&solve(&cases().join("coulomb.toml"), &temp.path().join("coulomb"), &[]).stdout);
    assert!(coulomb.contains("no bound exists") && key_results(&coulomb).is_none(), "{coulomb}");
    let adaptive = text(&solve(&cases().join("adaptive.toml"), &temp.path().join("adaptive"), &[]).stdout);
    assert!(adaptive.contains("against the mesh before") && key_results(&adaptive).is_none(), "{adaptive}");
}

/// Two blocks on a base: the surfaces of the first do not match, those of the second do and have the largest pressure.
#[test]
fn a_nodal_pressure_is_not_called_recovered() {
    let block = |name: &str, x: f64, cells: usize, pressure: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"soft\"\n\
             generator = {{ kind = \"block\", origin = [{x:?}, 1.0], size = [1.0, 1.0], cells = [{cells}, 2] }}\n\
             [[body.displacement]]\non = \"left\"\nux = 0.0\n[[body.traction]]\non = \"top\"\npressure = {pressure:?}\n\
             [[contact]]\nbodies = [\"{name}\", \"base\"]\nsurfaces = [\"bottom\", \"top\"]\n"
        )
    };
    let base = "schema = 1\n[materials.soft]\nyoung = 1e5\npoisson = 0.3\n[[body]]\nname = \"base\"\nmaterial = \"soft\"\n\
                generator = { kind = \"block\", origin = [0.0, 0.0], size = [5.0, 1.0], cells = [10, 2] }\n\
                [[body.displacement]]\non = \"bottom\"\nfixed = true\n";
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("case.toml");
    std::fs::write(&case, [base, &block("a", 0.5, 3, 1.0), &block("b", 3.0, 2, 10.0)].concat()).unwrap();
    let out = temp.path().join("out");
    let said = text(&solve(&case, &out, &[]).stdout);
    let recovered =
        report(&out).contact.iter().map(|pair| pair.max_pressure_recovered.is_some()).collect::<Vec<_>>();
    assert_eq!(recovered, [true, false]);
    let line = key_results(&said).unwrap_or_else(|| panic!("{said}"));
    assert!(line.contains(", largest pressure (recovered on pairs that do not match) 12, "), "{line}");
}

#[test]
fn json_events_are_one_object_a_line() {
    let temp = tempfile::tempdir().unwrap();
    let output = solve(&cases().join("paper.toml"), &temp.path().join("j"), &["--format", "json"]);
    let said = text(&output.stdout);
    let events: Vec<String> = said
        .lines()
        .map(|line| {
            serde_json::from_str::<serde_json::Value>(line).unwrap()["event"].as_str().unwrap().to_string()
        })
        .collect();
    assert_eq!(events.first().map(String::as_str), Some("started"));
    assert_eq!(events.last().map(String::as_str), Some("finished"));
    assert!(events[1..events.len() - 1].iter().all(|e| e == "iteration"));
}

#[test]
fn a_failure_is_an_event_too() {
    let temp = tempfile::tempdir().unwrap();
    let case = cases().join("bad/case_unknown_key.toml");
    let output = solve(&case, &temp.path().join("f"), &["--format", "json"]);
    assert_eq!(output.status.code(), Some(3));
    let said = text(&output.stdout);
    let event: serde_json::Value = serde_json::from_str(said.trim_end()).unwrap();
    assert_eq!((&event["event"], &event["code"]), (&"failed".into(), &3.into()));
    assert!(event["message"].as_str().unwrap().contains("unknown key `theata`"), "{said}");
    assert!(text(&output.stderr).contains("unknown key `theata`"));
}

#[test]
fn what_is_not_known_is_null_and_in_no_table() {
    // Diverges at once: there is no iterate with numbers.
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let huge = ["--set", "body.0.displacement.1.uy=-1e300", "--format", "json"];
    let output = solve(&cases().join("adaptive.toml"), &out, &huge);
    assert_eq!(output.status.code(), Some(5), "{}", text(&output.stderr));
    let events: Vec<serde_json::Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(events.iter().all(|event| event["event"].is_string()), "{events:?}");
    let steps: Vec<_> = events.iter().filter(|event| event["event"] == "step").collect();
    assert!(!steps.is_empty() && steps.iter().all(|step| step["e_cre"].is_null() && step["nodes"].is_u64()));
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
    for key in [
        "energy_norm_squared",
        "contact_force",
        "max_pressure",
        "max_edge_pressure",
        "min_opening",
        "max_displacement",
    ] {
        assert!(report["results"].as_object().unwrap()[key].is_null(), "{key}: {}", report["results"]);
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains("<h2>Results</h2>"), "{page}");
}

#[test]
fn the_first_event_carries_the_notes() {
    let temp = tempfile::tempdir().unwrap();
    let case = cases().join("expressions.toml");
    let output = solve(&case, &temp.path().join("e"), &["--format", "json"]);
    let said = text(&output.stdout);
    let notes = |line: &str| {
        let event: serde_json::Value = serde_json::from_str(line).unwrap();
        event["notes"].as_array().unwrap().clone()
    };
    let (first, last) = (notes(said.lines().next().unwrap()), notes(said.lines().last().unwrap()));
    assert!(!first.is_empty() && first.iter().all(|note| last.contains(note)), "{first:?}\n{last:?}");
}

#[test]
fn an_adaptive_run_has_a_row_and_files_for_every_mesh() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("adaptive");
    let output = solve(&cases().join("adaptive.toml"), &out, &[]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = report(&out);
    assert_eq!(report.status.word, "converged");
    let relative = report.certificate.as_ref().unwrap().relative.unwrap();
    assert!(report.certificate.as_ref().unwrap().valid && relative <= 0.03);
    let last = report.adaptive.last().unwrap();
    assert_eq!((last.relative, last.step), (Some(relative), report.adaptive.len()));
    assert_eq!(last.nodes, report.bodies.iter().map(|b| b.nodes).sum::<usize>());
    assert!(said.contains("adapt      until") && said.contains("on mesh"), "{said}");
    for row in &report.adaptive {
        assert!(said.contains(&format!("{:>4} {:>9}", row.step, row.nodes)), "{said}");
        for body in ["upper", "lower"] {
            let file = format!("fields/{body}-step-{:02}.vtu", row.step);
            assert!(out.join(&file).exists(), "{file}");
            assert!(std::fs::read_to_string(out.join("adaptive.pvd")).unwrap().contains(&file), "{file}");
        }
    }
    let table = std::fs::read_to_string(out.join("adaptive.csv")).unwrap();
    assert_eq!(table.lines().count(), report.adaptive.len() + 1);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Bounds of the exact solution") && page.contains("Meshes"));
    assert!(std::fs::read_to_string(out.join("figures/adaptive.svg")).unwrap().contains("N^(-1/2)"));
    let [low, high] = report.certificate.as_ref().unwrap().bounds.energy_norm.unwrap();
    let norm = report.results.energy_norm_squared.unwrap().iter().sum::<f64>().sqrt();
    assert!(low < norm && norm < high && high - low < 0.07 * norm);
    assert_eq!(report.run["adaptive_seconds"].as_array().unwrap().len(), report.adaptive.len());
    // A run that needs fewer meshes leaves no file of the others behind.
    let again = solve(&cases().join("adaptive.toml"), &out, &["--set", "adapt.max_steps=2", "--force"]);
    assert_eq!(again.status.code(), Some(6), "{}", text(&again.stderr));
    assert!(out.join("fields/upper-step-02.vtu").exists());
}

#[test]
fn adaptive_runs_do_not_depend_on_threads() {
    let temp = tempfile::tempdir().unwrap();
    let reports: Vec<String> = ["1", "2"]
        .into_iter()
        .map(|threads| {
            let out = temp.path().join(threads);
            let output = solve(&cases().join("singular.toml"), &out, &["--threads", threads]);
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            let mut report = report(&out);
            report.timings = Default::default();
            report.run = Default::default();
            report.to_json().unwrap()
        })
        .collect();
    assert_eq!(reports[0], reports[1]);
}

#[test]
fn limits_of_an_adaptive_run_keep_its_certificate() {
    let temp = tempfile::tempdir().unwrap();
    let case = cases().join("adaptive.toml");
    let out = temp.path().join("m");
    // Enough for the first mesh, not for all of them.
    let memory = solve(&case, &out, &["--set", "limits.memory=\"22MiB\""]);
    assert_eq!(memory.status.code(), Some(8), "{}", text(&memory.stderr));
    let found = report(&out);
    assert!(
        found.certificate.as_ref().unwrap().valid && found.status.reason.contains("limits.memory"),
        "{:?}",
        found.status
    );
    assert!(!found.adaptive.is_empty());
    // On a busy machine no iterate exists yet when the clock is looked at first, and then there is no report.
    let in_time = |seconds: &str| {
        let out = temp.path().join(seconds);
        let limit = format!("limits.time=\"{seconds}s\"");
        let more = ["--set", &limit, "--set", "adapt.target_relative_error=0.001"];
        let time = solve(&case, &out, &more);
        assert_eq!(time.status.code(), Some(8), "{}", text(&time.stderr));
        out.join("report.json").exists().then(|| report(&out))
    };
    let kept = ["0.000001", "1", "10"].into_iter().find_map(in_time).unwrap();
    assert!(kept.certificate.as_ref().unwrap().valid);
    let sweep = ["sweep", case.to_str().unwrap(), "--over", "solver.theta=0.1:0.9:0.1"];
    assert_eq!(nndd(&sweep, temp.path()).status.code(), Some(2));
}

#[test]
fn relaxation_may_go_on_until_it_gains_too_little() {
    let temp = tempfile::tempdir().unwrap();
    let case = cases().join("singular.toml");
    let run = |name: &str, more: &[&str]| {
        let out = temp.path().join(name);
        let output = solve(&case, &out, more);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        (report(&out), text(&output.stdout))
    };
    let (steps, _) = run("steps", &["--set", "estimator.relaxation=2"]);
    let (tolerance, said) = run("tolerance", &["--set", "estimator.tolerance=0.002"]);
    assert!(said.contains("relaxation until less than 0.002 is left to gain"), "{said}");
    assert_eq!(tolerance.case["estimator"]["tolerance"], 0.002);
    // The first meshes are the same: the bound is sharper, and still valid.
    assert!(tolerance.adaptive[0].e_cre < steps.adaptive[0].e_cre);
    assert!(tolerance.certificate.as_ref().unwrap().valid);
}

/// Solves the paper's case with other settings.
fn paper_with(settings: &[&str]) -> Report {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let more: Vec<&str> = settings.iter().flat_map(|s| ["--set", s]).collect();
    let _ = solve(&cases().join("paper.toml"), &out, &more);
    report(&out)
}

#[test]
fn a_slow_iteration_is_ended_by_its_limit() {
    let settings = ["solver.theta=0.0005", "solver.max_iterations=80", "estimator.every=0"];
    let criterion = ["solver.stop.criterion=\"eta_nndd\"", "solver.stop.tolerance=1e-3"];
    let report = paper_with(&[settings.as_slice(), &criterion].concat());
    assert_eq!((report.status.word.as_str(), report.iterations.len()), ("max_iterations", 80));
    assert!(report.status.reason.contains("raise solver.max_iterations"));
}

#[test]
fn what_left_the_numbers_is_named() {
    let report = paper_with(&["solver.theta=1e308", "body.0.displacement.1.uy=-2e4"]);
    assert_eq!(report.status.word, "diverged");
    assert!(report.status.reason.contains("lambda overflowed"), "{}", report.status.reason);
}

#[test]
fn newton_takes_active_set_steps_and_calls_clarabel_beyond_its_limit() {
    let of = |limit: &str| paper_with(&["solver.method=\"newton\"", limit]);
    let report = of("solver.max_iterations=5");
    assert_eq!(report.status.word, "converged", "{}", report.status.reason);
    assert_eq!(report.iterations[0].qp_path.as_deref(), Some("active-set"));
    let report = of("solver.max_iterations=1");
    assert_eq!(report.status.word, "converged", "{}", report.status.reason);
    assert_eq!(report.iterations[0].qp_path.as_deref(), Some("clarabel"));
}

#[test]
fn check_counts_every_load_and_prints_the_resultant() {
    let temp = tempfile::tempdir().unwrap();
    let case = "schema = 1\n[materials.m]\nyoung = 6.0\npoisson = 0.4\n[[body]]\nname = \"block\"\nmaterial = \"m\"\n\
         body_force = [0.5, -2.0]\n\
         generator = { kind = \"block\", origin = [0.0, 0.0], size = [4.0, 2.0], cells = [8, 4] }\n\
         [[body.displacement]]\non = \"left\"\nux = 0.0\n\
         [[body.traction]]\non = \"right\"\npressure = 3.0\n\
         [[contact]]\nname = \"table\"\nbodies = [\"block\"]\nsurfaces = [\"bottom\"]\n\
         obstacle = { kind = \"plane\", point = [0.0, 0.0], normal = [0.0, 1.0] }\n\
         [[contact]]\nname = \"stamp\"\nbodies = [\"block\"]\nsurfaces = [\"top\"]\n\
         obstacle = { kind = \"circle\", centre = [2.0, 7.0], radius = 5.0, ux = 0.0, rotation = 0.0, force = [0.0, -0.8] }\n";
    std::fs::write(temp.path().join("case.toml"), case).unwrap();
    let shown = text(&nndd(&["check", "case.toml"], temp.path()).stdout);
    // 8 square units under the body force, 2 units of length under the pressure.
    assert!(shown.contains("    loads           2 conditions, resultant (-2, -16)\n"), "{shown}");
    assert!(
        shown.contains("  all loads       resultant (-2, -16.8), 1 loaded obstacle included\n"),
        "{shown}"
    );
    let object: serde_json::Value =
        serde_json::from_str(&text(&nndd(&["check", "case.toml", "--format", "json"], temp.path()).stdout))
            .unwrap();
    assert_eq!(object["bodies"][0]["loads"], 2);
    let resultants = [&object["resultant"], &object["bodies"][0]["resultant"]];
    for (resultant, expected) in resultants.into_iter().zip([[-2.0, -16.8], [-2.0, -16.0]]) {
        let found: [f64; 2] = serde_json::from_value(resultant.clone()).unwrap();
        assert!(found.iter().zip(expected).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-12), "{object}");
    }
    // Two contact forces have no common direction.
    let solved = text(&nndd(&["solve", "case.toml"], temp.path()).stdout);
    assert!(solved.contains("sum of the contact forces of 2 pairs "), "{solved}");
    assert!(!solved.contains("integral of the pressure"), "{solved}");
}

#[test]
fn a_quiet_run_says_on_stderr_why_it_missed_what_was_asked_for() {
    let temp = tempfile::tempdir().unwrap();
    let case = cases().join("paper.toml");
    let case = case.to_str().unwrap();
    let set = |more: &[&str]| {
        let out = temp
            .path()
            .join(format!("out_{}", more.concat()).replace(['[', ']', '=', '.', ' ', '{', '}'], "_"));
        let mut arguments = vec!["solve", "-q", case, "--out", out.to_str().unwrap()];
        arguments.extend(more.iter().flat_map(|setting| ["--set", setting]));
        let output = nndd(&arguments, temp.path());
        assert!(output.stdout.is_empty());
        (output.status.code(), text(&output.stderr))
    };
    let (code, said) = set(&["solver.max_iterations=1", "solver.method='nndd'"]);
    assert_eq!(code, Some(5));
    assert!(
        said.starts_with("max_iterations: eta_nndd <= 0.1 eta_dis not met after 1 iteration"),
        "{said:?}"
    );
    let (code, said) = set(&["adapt={ target_relative_error = 0.01, max_steps = 1 }"]);
    assert_eq!(code, Some(6));
    assert!(said.starts_with("target_missed: "), "{said:?}");
    let (code, said) = set(&[]);
    assert_eq!((code, said.as_str()), (Some(0), ""));
}

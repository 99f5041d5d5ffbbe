//! `cargo xtask verify`: every check a change must pass, one after the other, and a table at the end.

mod alone;
mod compiler;

use crate::steps::Steps;
use crate::workspace::{Outcome, Workspace, read, stream};
use crate::{docs, tidy};
use clap::{Args, ValueEnum};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `verify`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Run only this step (may be given several times)
    #[arg(long, value_name = "STEP")]
    only: Vec<Step>,
    /// Leave this step out (may be given several times)
    #[arg(long, value_name = "STEP")]
    skip: Vec<Step>,
}

/// The steps, in the order in which they run.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Step {
    /// The compiler is the one that rust-version names
    Compiler,
    /// cargo fmt --check
    Format,
    /// cargo clippy, warnings denied
    Clippy,
    /// cargo check of each crate alone
    Crates,
    /// cargo test
    Tests,
    /// cargo doc, warnings denied
    Docs,
    /// nndd solve on every file of tests/cases and tests/cases/solid
    Cases,
    /// cargo xtask tidy
    Tidy,
}

impl Step {
    fn name(self) -> &'static str {
        match self {
            Step::Compiler => "compiler",
            Step::Format => "format",
            Step::Clippy => "clippy",
            Step::Crates => "crates",
            Step::Tests => "tests",
            Step::Docs => "docs",
            Step::Cases => "cases",
            Step::Tidy => "tidy",
        }
    }

    /// Runs the step; `Ok(false)` if it found something wrong.
    fn run(self, workspace: &Workspace) -> Outcome<bool> {
        let cargo = |arguments: &[&str]| stream(&mut workspace.cargo(arguments)).map(|code| code == Some(0));
        match self {
            Step::Compiler => compiler::check(workspace),
            Step::Format => cargo(&["fmt", "--all", "--check"]),
            Step::Clippy => {
                cargo(&["clippy", "--workspace", "--all-targets", "--release", "--", "-D", "warnings"])
            }
            Step::Crates => alone::check(workspace),
            Step::Tests => cargo(&["test", "--workspace", "--release"]),
            Step::Docs => docs::check(workspace),
            Step::Cases => cases(workspace),
            Step::Tidy => tidy::run(workspace),
        }
    }
}

/// Runs the steps asked for, continuing after one that fails, and returns whether all passed.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<bool> {
    let chosen =
        |s: &Step| (arguments.only.is_empty() || arguments.only.contains(s)) && !arguments.skip.contains(s);
    let mut steps = Steps::default();
    for step in Step::value_variants().iter().copied().filter(chosen) {
        steps.run(step.name(), || step.run(workspace));
    }
    Ok(steps.finish("verify"))
}

/// Builds the program and solves every case; says of each whether it ended as its file expects.
fn cases(workspace: &Workspace) -> Outcome<bool> {
    if !workspace.build_program()? {
        return Ok(false);
    }
    let folder = workspace.root.join("tests").join("cases");
    let mut files = case_files(&folder)?;
    files.extend(case_files(&folder.join("solid"))?);
    if files.is_empty() {
        return Err("tests/cases holds no case file, expected at least one".to_owned());
    }
    let mut failed = 0;
    for file in &files {
        let name = workspace.shown(file);
        let start = Instant::now();
        let verdict = case(workspace, file);
        let seconds = start.elapsed().as_secs_f64();
        match verdict {
            Ok(code) => println!("{name}: exit {code} as expected, {seconds:.1} s"),
            Err(error) => {
                failed += 1;
                println!("{name}: FAILED: {error}, {seconds:.1} s");
            }
        }
    }
    println!("cases: {} passed, {failed} failed", files.len() - failed);
    Ok(failed == 0)
}

/// The case files right in the folder, in alphabetical order.
fn case_files(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let paths = entries.filter_map(Result::ok).map(|e| e.path());
    let mut files: Vec<PathBuf> =
        paths.filter(|p| p.is_file() && p.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    Ok(files)
}

/// Solves one case and returns its exit status, which was the expected one.
fn case(workspace: &Workspace, file: &Path) -> Outcome<i32> {
    let expected = expected_exit(&read(file)?)?;
    let [folder, name] =
        [file.parent().and_then(Path::file_name), file.file_stem()].map(Option::unwrap_or_default);
    let out = workspace.target.join("verify").join(folder).join(name);
    // An old report must not be taken for a new one.
    if out.exists() {
        std::fs::remove_dir_all(&out).map_err(|e| format!("{}: {e}", workspace.shown(&out)))?;
    }
    if let Some(parent) = out.parent() {
        std::fs::create_dir_all(parent).map_err(|e| format!("{}: {e}", workspace.shown(parent)))?;
    }
    let code = workspace.solve(file.strip_prefix(&workspace.root).unwrap_or(file), &[], &out)?;
    if code != Some(expected) {
        let found = code.map_or("a signal".to_owned(), |c| format!("exit {c}"));
        return Err(format!("found {found}, expected exit {expected}"));
    }
    let report = out.join("report.json");
    match expected {
        0 | 5 | 6 => check_report(&read(&report)?, expected)?,
        // A limit may be met before there is an iterate to report.
        8 if !report.exists() => {}
        8 => check_report(&read(&report)?, expected)?,
        _ if report.exists() => {
            return Err(format!("found a report.json, expected none for exit {expected}"));
        }
        _ => {}
    }
    Ok(expected)
}

/// The exit status a case file asks for: `# expect: exit N` among the comments it begins with, otherwise 0.
fn expected_exit(text: &str) -> Outcome<i32> {
    let head = text.lines().map(str::trim).take_while(|l| l.is_empty() || l.starts_with('#'));
    let asked = head.filter_map(|l| l.trim_start_matches('#').trim().strip_prefix("expect:")).next();
    let Some(asked) = asked else { return Ok(0) };
    let number = asked.trim().strip_prefix("exit").and_then(|n| n.trim().parse().ok());
    number.ok_or_else(|| format!("found `# expect:{asked}`, expected `# expect: exit N`"))
}

/// Checks that a report is JSON, says the status it ended with, and holds a valid certificate for status 0; with Coulomb friction none, and
/// a residual.
fn check_report(text: &str, code: i32) -> Outcome<()> {
    let report: Value = serde_json::from_str(text).map_err(|e| format!("report.json: {e}"))?;
    if report["status"]["code"].as_i64() != Some(i64::from(code)) {
        return Err(format!("report.json: found status.code {}, expected {code}", report["status"]["code"]));
    }
    if report["problem"] == "coulomb" {
        if !report["certificate"].is_null() || code == 0 && !report["coulomb"]["e_b"].is_number() {
            return Err("report.json: expected a residual and no certificate with Coulomb friction".into());
        }
        return Ok(());
    }
    let valid = &report["certificate"]["valid"];
    if code == 0 && *valid != Value::Bool(true) {
        return Err(format!("report.json: found certificate.valid {valid}, expected true"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expected_status_is_read_from_the_leading_comments() {
        assert_eq!(expected_exit("schema = 1\n"), Ok(0));
        assert_eq!(expected_exit("# A case.\n\n# expect: exit 5\nschema = 1\n"), Ok(5));
        assert_eq!(expected_exit("schema = 1\n# expect: exit 5\n"), Ok(0));
        assert!(expected_exit("# expect: failure\n").is_err());
    }

    #[test]
    fn report_of_success_needs_a_valid_certificate() {
        let report = |code: i32, valid: &str| {
            format!(r#"{{"status": {{"code": {code}}}, "certificate": {{"valid": {valid}}}}}"#)
        };
        assert_eq!(check_report(&report(0, "true"), 0), Ok(()));
        assert_eq!(check_report(&report(5, "false"), 5), Ok(()));
        assert!(check_report(&report(0, "false"), 0).is_err());
        assert!(check_report(&report(0, "true"), 5).is_err());
        assert!(check_report(r#"{"status": {"code": 0}, "certificate": null}"#, 0).is_err());
        let coulomb = |certificate: &str, e_b: &str| {
            format!(
                r#"{{"status": {{"code": 0}}, "problem": "coulomb", "certificate": {certificate}, "coulomb": {{"e_b": {e_b}}}}}"#
            )
        };
        assert!(check_report(&coulomb("null", "0.1"), 0).is_ok());
        assert!(check_report(&coulomb("null", "null"), 0).is_err());
        assert!(check_report(&coulomb(r#"{"valid": true}"#, "0.1"), 0).is_err());
        assert!(check_report(r#"{"status": {"code": NaN}}"#, 0).is_err());
    }
}

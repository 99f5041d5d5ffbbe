//! `cargo xtask reproduce mutations`: named faults are written into a copy of the sources, one at a time, and a test must see each.
//!
//! The list is `mutations.toml`. A line of code that can be changed without a test that fails is either not tested or has no effect.

use crate::workspace::{Outcome, Workspace, read, stream};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const LIST: &str = include_str!("mutations.toml");

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    mutation: Vec<Mutation>,
}

/// One edit of one file, and the test that must fail with it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Mutation {
    /// The fault in words.
    name: String,
    /// From the top folder.
    file: String,
    /// Occurs once in the file.
    from: String,
    /// Takes its place.
    to: String,
    /// Arguments of `cargo test` that choose the test: package, target, name.
    test: Vec<String>,
}

/// Writes `bench-results/mutations/README.md`.
///
/// # Errors
/// An edit that does not fit, does not compile or that no test sees.
pub(crate) fn run(workspace: &Workspace) -> Outcome<()> {
    let list: List = toml::from_str(LIST).map_err(|e| format!("mutations.toml: {e}"))?;
    let copy = Copy::new(workspace)?;
    let (mut rows, mut failures) = (vec![], vec![]);
    for mutation in &list.mutation {
        println!("== {}", mutation.name);
        match copy.failing_test(mutation) {
            Ok(test) => rows.push(format!("| {} | `{}` | `{test}` |", mutation.name, mutation.file)),
            Err(error) => failures.push(format!("{}: {error}", mutation.name)),
        }
    }
    if !failures.is_empty() {
        return Err(failures.join("\n"));
    }
    let commit = workspace.commit()?;
    let page = format!(
        "# Faults that tests must see\n\nWritten by `cargo xtask reproduce mutations` at commit {commit}. Each fault was written into a copy \
         of the sources; the test passes without it and fails with it.\n\n| fault | file | test that fails |\n|---|---|---|\n{}\n",
        rows.join("\n")
    );
    workspace.write(&workspace.root.join("bench-results").join("mutations").join("README.md"), &page)
}

/// A clone of the last commit with a build folder of its own.
struct Copy {
    root: PathBuf,
    target: PathBuf,
}

impl Copy {
    fn new(workspace: &Workspace) -> Outcome<Self> {
        let folder = workspace.target.join("mutations");
        let root = folder.join("copy");
        if root.exists() {
            std::fs::remove_dir_all(&root).map_err(|e| format!("{}: {e}", root.display()))?;
        }
        let mut clone = workspace.git(&["clone", "--quiet", "--shared", "."]);
        if stream(clone.arg(&root))? != Some(0) {
            return Err("the sources cannot be cloned".to_owned());
        }
        Ok(Self { root, target: folder.join("target") })
    }

    /// Applies an edit, names the test that fails, and takes the edit back.
    fn failing_test(&self, mutation: &Mutation) -> Outcome<String> {
        let path = self.root.join(&mutation.file);
        let text = read(&path)?;
        let count = text.matches(&mutation.from).count();
        if count != 1 {
            return Err(format!("found {count} places in {} for its edit, expected 1", mutation.file));
        }
        let sound = self.test(mutation)?;
        if !sound.status.success() || failed(&sound).is_some() || passed(&sound) == 0 {
            return Err("its test does not pass, or does not run, without the edit".to_owned());
        }
        write(&path, &text.replacen(&mutation.from, &mutation.to, 1))?;
        let seen = self.compiles(mutation).and_then(|()| self.test(mutation));
        write(&path, &text)?;
        failed(&seen?).ok_or_else(|| "no test fails".to_owned())
    }

    fn compiles(&self, mutation: &Mutation) -> Outcome<()> {
        match stream(self.cargo(mutation).arg("--no-run"))? {
            Some(0) => Ok(()),
            _ => Err("the edit does not compile".to_owned()),
        }
    }

    fn test(&self, mutation: &Mutation) -> Outcome<Output> {
        self.cargo(mutation).output().map_err(|e| format!("cargo test: {e}"))
    }

    /// Little optimisation: compiling takes most of the time.
    fn cargo(&self, mutation: &Mutation) -> Command {
        let mut command = Command::new("cargo");
        command.current_dir(&self.root).args(["test", "--quiet"]).args(&mutation.test);
        command.env("CARGO_TARGET_DIR", &self.target);
        command.env("CARGO_PROFILE_DEV_OPT_LEVEL", "1").env("CARGO_PROFILE_DEV_DEBUG", "0");
        command
    }
}

/// The first test that failed, from the list at the end of the output.
fn failed(run: &Output) -> Option<String> {
    let text = String::from_utf8_lossy(&run.stdout);
    let (_, list) = text.rsplit_once("\nfailures:\n")?;
    list.lines().map(str::trim).find(|line| !line.is_empty()).map(str::to_owned)
}

/// Counts the tests that passed.
fn passed(run: &Output) -> usize {
    let text = String::from_utf8_lossy(&run.stdout);
    let counts = text
        .lines()
        .filter_map(|line| line.strip_prefix("test result: ok. ")?.split(' ').next()?.parse::<usize>().ok());
    counts.sum()
}

fn write(path: &Path, text: &str) -> Outcome<()> {
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

//! `cargo xtask python`: the Python package. Builds the wheel, installs it into a virtual environment of its own and checks it
//! there: tests, examples in its documentation, notebooks, types, style.

use crate::python::last_line;
use crate::steps::Steps;
use crate::workspace::{Outcome, Workspace, output, stream};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The crate.
const CRATE: &str = "crates/nndd-python";
/// The file of the packages to install, with their versions: maturin beside the compiler, everything else beside the wheel.
const REQUIREMENTS: &str = "requirements.txt";
const MATURIN: &str = "maturin==";

/// Runs every check of the package and returns whether all passed.
///
/// # Errors
/// No Python, no package index, a wheel that does not build.
pub(crate) fn run(workspace: &Workspace) -> Outcome<bool> {
    let package = workspace.root.join(CRATE);
    let pinned = pinned(&crate::workspace::read(&package.join(REQUIREMENTS))?);
    let (tool, packages): (Vec<String>, Vec<String>) =
        pinned.into_iter().partition(|line| line.starts_with(MATURIN));
    let folder = workspace.target.join("python");
    let build = environment(&folder.join("build"), &tool)?;
    let wheel = wheel(workspace, &build, &folder.join("wheels"))?;
    let test = environment(&folder.join("test"), &packages)?;
    let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall"];
    output(Command::new(&test).args(install).arg(&wheel)).map_err(|e| last_line(&e).to_owned())?;
    // The program that the package is compared with.
    if !workspace.build_program()? {
        return Err("the program does not build".to_owned());
    }
    let python = |arguments: &[&str], folder: &Path| {
        let mut command = Command::new(&test);
        // Nothing of Rust is there.
        let path =
            std::env::join_paths([test.parent().unwrap_or(folder), "/usr/bin".as_ref(), "/bin".as_ref()]);
        command.current_dir(folder).args(arguments).env("NNDD_COMMAND", workspace.nndd());
        command.env("PATH", path.unwrap_or_default()).env("PYTHONDONTWRITEBYTECODE", "1");
        stream(&mut command).map(|code| code == Some(0))
    };
    let settings = format!("{CRATE}/pyproject.toml");
    let examples = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", &settings];
    let examples = [&examples[..], &["--doctest-modules", "--pyargs", "nndd"]].concat();
    let steps: [(&'static str, &[&str], &Path); 7] = [
        ("style", &["-m", "ruff", "check", "--no-cache", "."], &package),
        ("format", &["-m", "ruff", "format", "--no-cache", "--check", "."], &package),
        ("types", &["-m", "mypy", "--cache-dir", NOWHERE, "python/nndd", "tests"], &package),
        ("stubs", &["-m", "mypy.stubtest", "--ignore-disjoint-bases", "nndd._nndd"], &folder),
        ("examples", &examples, &workspace.root),
        ("tests", &["-m", "pytest", "-p", "no:cacheprovider", "--durations=5"], &package),
        ("import", &["-I", "-c", "import nndd; print(nndd.__version__)"], &folder),
    ];
    let mut run = Steps::default();
    for (name, arguments, folder) in steps {
        run.run(name, || python(arguments, folder));
    }
    Ok(run.finish("python"))
}

/// The place of mypy's cache: nowhere.
const NOWHERE: &str = if cfg!(windows) { "nul" } else { "/dev/null" };

/// Lists what a file of requirements names.
fn pinned(text: &str) -> Vec<String> {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(str::to_owned).collect()
}

/// Makes a virtual environment, or completes the one of an earlier run; returns its interpreter.
fn environment(folder: &Path, packages: &[String]) -> Outcome<PathBuf> {
    let python = folder.join("bin").join("python");
    if !python.exists() {
        let made = output(Command::new("python3").args(["-m", "venv", "--clear"]).arg(folder));
        made.map_err(|e| {
            format!(
                "no virtual environment of Python ({}); expected python3 3.9 or newer with venv and pip, such as those of the \
                 packages python3-venv and python3-pip",
                last_line(&e)
            )
        })?;
    }
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    output(Command::new(&python).args(install).args(packages)).map_err(|e| {
        format!(
            "the packages of {REQUIREMENTS} do not install ({}); they come from the package index",
            last_line(&e)
        )
    })?;
    Ok(python)
}

/// Builds the wheel and returns its path.
fn wheel(workspace: &Workspace, python: &Path, folder: &Path) -> Outcome<PathBuf> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(|e| format!("{}: {e}", workspace.shown(folder)))?;
    }
    let mut command = Command::new(python);
    command.current_dir(&workspace.root).args(["-m", "maturin", "build", "--release", "--locked", "--quiet"]);
    command.args(["--manifest-path", &format!("{CRATE}/Cargo.toml"), "--interpreter"]).arg(python);
    command.args(["--compatibility", "linux", "--out"]).arg(folder);
    // The features and the target folder of the other tasks.
    command.env("CARGO_TARGET_DIR", &workspace.target);
    if stream(&mut command)? != Some(0) {
        return Err("the wheel does not build".to_owned());
    }
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", workspace.shown(folder)))?;
    let mut paths = entries.filter_map(Result::ok).map(|entry| entry.path());
    paths
        .find(|path| path.extension().is_some_and(|e| e == "whl"))
        .ok_or_else(|| "maturin left no wheel".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_no_requirements() {
        assert_eq!(pinned("# tried\na==1\n\n b==2 \n"), ["a==1", "b==2"]);
    }
}

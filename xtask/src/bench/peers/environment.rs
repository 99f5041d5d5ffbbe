//! The Python virtual environment of the peers, made below the target folder, and what could not be installed.

use crate::workspace::{Outcome, Workspace, output};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Packages that are installed together, with the versions that were tried.
struct Group {
    name: &'static str,
    /// What other packages are built with; none where wheels exist.
    tools: &'static [&'static str],
    packages: &'static [[&'static str; 2]],
    /// What to do where they do not install.
    hint: &'static str,
}

/// What every peer in Python needs: without it there is none.
pub(super) const BASE: &str = "scikit-fem";
/// The group of PARDISO.
pub(super) const PARDISO: &str = "pypardiso";
/// The group of CHOLMOD.
pub(super) const CHOLMOD: &str = "scikit-sparse";

const GROUPS: [Group; 3] = [
    Group {
        name: BASE,
        tools: &[],
        packages: &[["numpy", "2.4.6"], ["scipy", "1.17.1"], ["scikit-fem", "12.0.2"]],
        hint: "it needs Python 3.11 or newer and the package index",
    },
    Group {
        name: PARDISO,
        tools: &[],
        packages: &[["pypardiso", "0.4.7"]],
        hint: "MKL is there for Intel and AMD processors only",
    },
    Group {
        name: CHOLMOD,
        tools: &["wheel", "setuptools<81", "cython"],
        packages: &[["scikit-sparse", "0.4.15"]],
        hint: "`apt install libsuitesparse-dev` and a C compiler may be missing",
    },
];

/// The environment, and what is missing in it.
pub(super) struct Environment {
    folder: PathBuf,
    /// Groups that are not there, with the reason.
    pub(super) missing: Vec<(&'static str, String)>,
}

impl Environment {
    /// Makes the environment or completes the one of an earlier run.
    pub(super) fn make(workspace: &Workspace) -> Outcome<Environment> {
        let mut made = Environment { folder: workspace.target.join("peers-venv"), missing: vec![] };
        if !made.python().exists()
            && let Err(error) = output(Command::new("python3").args(["-m", "venv"]).arg(&made.folder))
        {
            let reason =
                format!("no virtual environment ({}); `apt install python3-venv`", last_line(&error));
            made.missing = GROUPS.iter().map(|g| (g.name, reason.clone())).collect();
            return Ok(made);
        }
        for group in &GROUPS {
            if made.has(BASE) || group.name == BASE {
                if let Err(error) = made.install(group) {
                    let reason = format!("does not install: {} ({})", last_line(&error), group.hint);
                    made.missing.push((group.name, reason));
                }
            } else {
                made.missing.push((group.name, format!("needs {BASE}")));
            }
        }
        Ok(made)
    }

    /// Whether a group is there.
    pub(super) fn has(&self, group: &str) -> bool {
        !self.missing.iter().any(|(name, _)| *name == group)
    }

    /// The interpreter.
    pub(super) fn python(&self) -> PathBuf {
        self.folder.join("bin").join("python")
    }

    /// MKL as a shared library, which also holds a BLAS.
    pub(super) fn mkl(&self) -> Option<PathBuf> {
        let entries = std::fs::read_dir(self.folder.join("lib")).ok()?;
        let is_mkl =
            |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("libmkl_rt.so"));
        entries.filter_map(Result::ok).map(|e| e.path()).find(is_mkl)
    }

    /// Names and versions of everything installed.
    pub(super) fn versions(&self) -> String {
        let python = output(Command::new(self.python()).arg("--version")).unwrap_or_default();
        let frozen = output(Command::new(self.python()).args(["-m", "pip", "freeze", "--all"]));
        let listed = frozen.unwrap_or_default().trim().replace("==", " ").replace('\n', ", ");
        format!("{}, {listed}", python.trim())
    }

    fn install(&self, group: &Group) -> Outcome<()> {
        if group.packages.iter().all(|[name, version]| self.installed(name).as_deref() == Some(*version)) {
            return Ok(());
        }
        println!("installing {} into {}", group.name, self.folder.display());
        if !group.tools.is_empty() {
            output(&mut self.pip(&[], group.tools.iter().map(|tool| (*tool).to_owned())))?;
        }
        let options: &[&str] = if group.tools.is_empty() { &[] } else { &["--no-build-isolation"] };
        let pinned = group.packages.iter().map(|[name, version]| format!("{name}=={version}"));
        output(&mut self.pip(options, pinned)).map(|_| ())
    }

    fn installed(&self, package: &str) -> Option<String> {
        let ask = format!("import importlib.metadata as m; print(m.version('{package}'))");
        output(Command::new(self.python()).args(["-c", &ask])).ok().map(|said| said.trim().to_owned())
    }

    fn pip(&self, options: &[&str], packages: impl Iterator<Item = String>) -> Command {
        let mut command = Command::new(self.python());
        command.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        command.args(options).args(packages);
        command
    }
}

/// The last line of a message: what pip, a compiler or an interpreter says in the end.
pub(super) fn last_line(message: &str) -> &str {
    message.lines().rev().map(str::trim).find(|l| !l.is_empty()).unwrap_or_default()
}

/// A program in the folders where the system looks for programs.
pub(super) fn program(name: &str) -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(name)).find(|path| Path::is_file(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_lines_hold_text() {
        assert_eq!(last_line("pip: exit status 1: a\n  error: no wheel \n\n"), "error: no wheel");
        assert_eq!(last_line(""), "");
    }

    #[test]
    fn what_is_missing_is_named() {
        let folder = PathBuf::from("nowhere");
        let environment = Environment { folder, missing: vec![(CHOLMOD, "no compiler".into())] };
        assert!(environment.has(BASE) && environment.has(PARDISO) && !environment.has(CHOLMOD));
        assert_eq!(environment.mkl(), None);
        assert_eq!(program("a program of this name is not installed"), None);
    }
}

//! A Python virtual environment below the target folder, and what could not be installed in it.

use crate::workspace::{Outcome, output};
use std::path::PathBuf;
use std::process::Command;

/// Packages that are installed together, with the versions that were tried.
pub(crate) struct Group {
    pub(crate) name: &'static str,
    /// Tools that build the other packages; empty if wheels exist.
    pub(crate) tools: &'static [&'static str],
    pub(crate) packages: &'static [[&'static str; 2]],
    /// Advice if they do not install.
    pub(crate) hint: &'static str,
}

/// The environment, and what is missing in it.
pub(crate) struct Environment {
    pub(crate) folder: PathBuf,
    /// Groups that are not there, with the reason.
    pub(crate) missing: Vec<(&'static str, String)>,
}

impl Environment {
    /// Makes the environment or completes the one of an earlier run.
    ///
    /// Without the first group the others are not installed.
    pub(crate) fn make(folder: PathBuf, groups: &[Group]) -> Environment {
        let mut made = Environment { folder, missing: vec![] };
        if !made.python().exists()
            && let Err(error) = output(Command::new("python3").args(["-m", "venv"]).arg(&made.folder))
        {
            let reason =
                format!("no virtual environment ({}); `apt install python3-venv`", last_line(&error));
            made.missing = groups.iter().map(|g| (g.name, reason.clone())).collect();
            return made;
        }
        for (k, group) in groups.iter().enumerate() {
            if k == 0 || made.has(groups[0].name) {
                if let Err(error) = made.install(group) {
                    let reason = format!("does not install: {} ({})", last_line(&error), group.hint);
                    made.missing.push((group.name, reason));
                }
            } else {
                made.missing.push((group.name, format!("needs {}", groups[0].name)));
            }
        }
        made
    }

    /// Tells if a group is installed.
    pub(crate) fn has(&self, group: &str) -> bool {
        !self.missing.iter().any(|(name, _)| *name == group)
    }

    /// The interpreter.
    pub(crate) fn python(&self) -> PathBuf {
        self.folder.join("bin").join("python")
    }

    /// Names and versions of everything installed.
    pub(crate) fn versions(&self) -> String {
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
pub(crate) fn last_line(message: &str) -> &str {
    message.lines().rev().map(str::trim).find(|l| !l.is_empty()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_lines_hold_text() {
        assert_eq!(last_line("pip: exit status 1: a\n  error: no wheel \n\n"), "error: no wheel");
        assert_eq!(last_line(""), "");
    }
}

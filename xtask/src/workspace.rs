//! The workspace as cargo describes it, and how its commands are run.

use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The result of a task, or a sentence if it could not be carried out.
pub(crate) type Outcome<T> = Result<T, String>;

/// The workspace as `cargo metadata` describes it.
pub(crate) struct Workspace {
    /// Its top folder.
    pub(crate) root: PathBuf,
    /// The folder in which cargo builds.
    pub(crate) target: PathBuf,
    /// Its packages in alphabetical order.
    pub(crate) packages: Vec<Package>,
}

/// One package of the workspace.
pub(crate) struct Package {
    /// Its name.
    pub(crate) name: String,
    /// Its manifest, from the top folder, with forward slashes.
    pub(crate) manifest: String,
    /// Normal dependencies on packages of the workspace, in alphabetical order.
    pub(crate) internal: Vec<String>,
    /// Normal dependencies on other packages, in alphabetical order.
    pub(crate) external: Vec<String>,
    /// Its features and what each switches on.
    pub(crate) features: BTreeMap<String, Vec<String>>,
    /// Its benchmark targets.
    pub(crate) benches: Vec<String>,
    /// Its examples whose tests `cargo test` does not run.
    pub(crate) untested_examples: Vec<String>,
}

impl Package {
    /// Tells if the package is one of `crates/`.
    pub(crate) fn is_crate(&self) -> bool {
        self.manifest.starts_with("crates/")
    }
}

impl Workspace {
    /// Asks cargo about the workspace around the current folder.
    pub(crate) fn find() -> Outcome<Workspace> {
        let text = output(cargo().args(["metadata", "--format-version", "1", "--no-deps"]))?;
        Workspace::parse(&text)
    }

    /// Reads the answer of `cargo metadata --no-deps`.
    pub(crate) fn parse(text: &str) -> Outcome<Workspace> {
        let Metadata { workspace_root: root, target_directory: target, packages } =
            serde_json::from_str(text).map_err(|e| format!("cargo metadata: {e}"))?;
        let names: Vec<&str> = packages.iter().map(|p| p.name.as_str()).collect();
        let mut packages: Vec<Package> = packages.iter().map(|p| p.package(&root, &names)).collect();
        packages.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Workspace { root, target, packages })
    }

    /// A cargo command that runs in the top folder.
    pub(crate) fn cargo(&self, arguments: &[&str]) -> Command {
        let mut command = cargo();
        command.current_dir(&self.root).args(arguments);
        command
    }

    /// A git command that runs in the top folder.
    pub(crate) fn git(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new("git");
        command.current_dir(&self.root).args(arguments);
        command
    }

    /// Builds the program, as the tests build it: a plain build has fewer features switched on and would compile everything again.
    ///
    /// # Errors
    /// Cargo that cannot be run.
    pub(crate) fn build_program(&self) -> Outcome<bool> {
        let build = ["test", "--workspace", "--release", "--no-run", "--quiet"];
        Ok(stream(&mut self.cargo(&build))? == Some(0))
    }

    /// Builds the program alone.
    ///
    /// # Errors
    /// It does not compile.
    pub(crate) fn build_nndd(&self) -> Outcome<()> {
        match stream(&mut self.cargo(&["build", "--release", "--bin", "nndd"]))? {
            Some(0) => Ok(()),
            _ => Err("the program does not build".to_owned()),
        }
    }

    /// Solves a case file of the workspace into a folder, and returns the exit status.
    pub(crate) fn solve(&self, file: &Path, settings: &[&str], out: &Path) -> Outcome<Option<i32>> {
        let mut command = Command::new(self.nndd());
        command.current_dir(&self.root).arg("solve").arg(file).args(settings);
        stream(command.arg("--out").arg(out).args(["--force", "--quiet"]))
    }

    /// Returns the short hash of the commit that is checked out.
    pub(crate) fn commit(&self) -> Outcome<String> {
        Ok(output(&mut self.git(&["rev-parse", "--short", "HEAD"]))?.trim().to_owned())
    }

    /// Writes a file, and the folder for it, and says so.
    pub(crate) fn write(&self, path: &Path, text: &str) -> Outcome<()> {
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        let written = made.and_then(|()| std::fs::write(path, text));
        written.map_err(|e| format!("{}: {e}", self.shown(path)))?;
        println!("wrote {}", self.shown(path));
        Ok(())
    }

    /// The program `nndd`, where a release build puts it.
    pub(crate) fn nndd(&self) -> PathBuf {
        self.target.join("release").join(format!("nndd{}", std::env::consts::EXE_SUFFIX))
    }

    /// A path as the top folder sees it, for messages.
    pub(crate) fn shown(&self, path: &Path) -> String {
        path.strip_prefix(&self.root).unwrap_or(path).display().to_string()
    }
}

/// The part of the output of `cargo metadata` that is used.
#[derive(Deserialize)]
struct Metadata {
    workspace_root: PathBuf,
    target_directory: PathBuf,
    packages: Vec<Described>,
}

/// A package there.
#[derive(Deserialize)]
struct Described {
    name: String,
    manifest_path: PathBuf,
    dependencies: Vec<Dependency>,
    #[serde(default)]
    features: BTreeMap<String, Vec<String>>,
    targets: Vec<Target>,
}

/// A dependency of a package; one without a kind is a normal one.
#[derive(Deserialize)]
struct Dependency {
    name: String,
    kind: Option<String>,
}

/// A library, program, example, test or benchmark of a package.
#[derive(Deserialize)]
struct Target {
    name: String,
    kind: Vec<String>,
    #[serde(default)]
    test: bool,
}

impl Described {
    /// Makes the package; `names` holds the names of all packages of the workspace.
    fn package(&self, root: &Path, names: &[&str]) -> Package {
        let manifest = self.manifest_path.strip_prefix(root).unwrap_or(&self.manifest_path);
        let normal = self.dependencies.iter().filter(|d| d.kind.is_none());
        let dependencies: BTreeSet<String> = normal.map(|d| d.name.clone()).collect();
        let (internal, external) = dependencies.into_iter().partition(|d| names.contains(&d.as_str()));
        let targets =
            |kind: &'static str| self.targets.iter().filter(move |t| t.kind.iter().any(|k| k == kind));
        let untested = targets("example").filter(|t| !t.test);
        Package {
            name: self.name.clone(),
            manifest: manifest.to_string_lossy().replace('\\', "/"),
            internal,
            external,
            features: self.features.clone(),
            benches: targets("bench").map(|t| t.name.clone()).collect(),
            untested_examples: untested.map(|t| t.name.clone()).collect(),
        }
    }
}

fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// How a command reads in messages: program and arguments, the program without its folder.
pub(crate) fn described(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|w| w.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// Runs a command, its output shown as it comes, and returns its exit status; `None` if a signal ended it.
pub(crate) fn stream(command: &mut Command) -> Outcome<Option<i32>> {
    println!("$ {}", described(command));
    let status = command.status().map_err(|e| format!("{}: {e}", described(command)))?;
    Ok(status.code())
}

/// Runs a command and returns what it wrote to its standard output.
pub(crate) fn output(command: &mut Command) -> Outcome<String> {
    let out = command.output().map_err(|e| format!("{}: {e}", described(command)))?;
    if !out.status.success() {
        let said = String::from_utf8_lossy(&out.stderr);
        return Err(format!("{}: {}: {}", described(command), out.status, said.trim()));
    }
    String::from_utf8(out.stdout).map_err(|_| format!("{}: its output is not UTF-8", described(command)))
}

/// Returns how busy the machine was in the last minute.
pub(crate) fn load_average() -> String {
    let table = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    table.split_whitespace().next().unwrap_or("unknown").to_owned()
}

/// Reads a text file.
pub(crate) fn read(path: &Path) -> Outcome<String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_gives_packages_and_their_dependencies() {
        let text = r#"{ "workspace_root": "/w", "target_directory": "/w/target", "packages": [
            { "name": "nndd", "manifest_path": "/w/crates/nndd/Cargo.toml",
              "dependencies": [
                { "name": "rayon", "kind": null }, { "name": "fem-core", "kind": null },
                { "name": "criterion", "kind": "dev" } ],
              "features": { "default": ["drawings"], "drawings": [] },
              "targets": [ { "name": "nndd", "kind": ["lib"] }, { "name": "steps", "kind": ["bench"] },
                { "name": "blocks", "kind": ["example"], "test": true }, { "name": "new", "kind": ["example"], "test": false } ] },
            { "name": "fem-core", "manifest_path": "/w/crates/fem-core/Cargo.toml",
              "dependencies": [], "targets": [] },
            { "name": "xtask", "manifest_path": "/w/xtask/Cargo.toml", "dependencies": [], "targets": [] } ] }"#;
        let workspace = Workspace::parse(text).unwrap();
        let [fem_core, nndd, xtask] = &workspace.packages[..] else { panic!("three packages") };
        assert_eq!((fem_core.name.as_str(), nndd.manifest.as_str()), ("fem-core", "crates/nndd/Cargo.toml"));
        assert_eq!(
            (&nndd.internal[..], &nndd.external[..]),
            (&["fem-core".to_owned()][..], &["rayon".to_owned()][..])
        );
        assert_eq!(
            (&nndd.benches[..], &nndd.untested_examples[..]),
            (&["steps".to_owned()][..], &["new".to_owned()][..])
        );
        assert_eq!(nndd.features["default"], ["drawings"]);
        assert!(fem_core.features.is_empty());
        assert!(nndd.is_crate() && !xtask.is_crate());
    }

    #[test]
    fn metadata_that_is_none_is_an_error() {
        assert!(Workspace::parse("[]").is_err());
        assert!(Workspace::parse("{").is_err());
    }
}

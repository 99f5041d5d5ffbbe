//! `cargo xtask docs`: the documentation of every crate, its formulae typeset.

use crate::workspace::{Outcome, Package, Workspace, stream};
use std::path::Path;

/// Header of every page; docs.rs finds it through each crate's manifest.
const HEADER: &str = "crates/fem-core/katex.html";
/// The typesetter, which the header looks for beside the pages.
const KATEX: &str = "xtask/katex";

/// Crates whose library is not for other Rust programs.
const UNDOCUMENTED: [&str; 2] = ["nndd-cli", "nndd-python"];

/// Builds the documentation with warnings denied; returns whether there were none.
pub(crate) fn run(workspace: &Workspace) -> Outcome<bool> {
    let pages = workspace.target.join("doc");
    // rustdoc links to another crate only if its pages are there when it begins: one crate after the other.
    for name in ordered(&workspace.packages) {
        if !document(workspace, &["--package", name])? {
            return Ok(false);
        }
    }
    copy(&workspace.root.join(KATEX), &pages.join("katex"))?;
    println!("start at {}", workspace.shown(&pages.join("certified_contact").join("index.html")));
    Ok(true)
}

/// Builds the documentation of everything at once; only its warnings count.
pub(crate) fn check(workspace: &Workspace) -> Outcome<bool> {
    document(workspace, &["--workspace"])
}

/// Documents some packages in the profile of the other tasks, so that nothing is compiled once more.
fn document(workspace: &Workspace, packages: &[&str]) -> Outcome<bool> {
    let header = workspace.root.join(HEADER);
    let flags = ["-D", "warnings", "--html-in-header", &header.to_string_lossy()].join("\u{1f}");
    let mut command = workspace.cargo(&["doc", "--no-deps", "--release"]);
    let status = stream(command.args(packages).env("CARGO_ENCODED_RUSTDOCFLAGS", flags))?;
    Ok(status == Some(0))
}

/// Lists the crates with a library, each after those it depends on.
fn ordered(packages: &[Package]) -> Vec<&str> {
    let mut rest: Vec<&Package> =
        packages.iter().filter(|p| p.is_crate() && !UNDOCUMENTED.contains(&p.name.as_str())).collect();
    let mut found: Vec<&str> = Vec::with_capacity(rest.len());
    while !rest.is_empty() {
        let (ready, later): (Vec<_>, Vec<_>) =
            rest.into_iter().partition(|p| p.internal.iter().all(|name| found.contains(&name.as_str())));
        if ready.is_empty() {
            break;
        }
        found.extend(ready.iter().map(|p| p.name.as_str()));
        rest = later;
    }
    found
}

/// Copies a folder with all that is below it.
fn copy(from: &Path, to: &Path) -> Outcome<()> {
    let fault = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    std::fs::create_dir_all(to).map_err(|e| fault(to, e))?;
    for entry in std::fs::read_dir(from).map_err(|e| fault(from, e))? {
        let entry = entry.map_err(|e| fault(from, e))?;
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &target)?;
        } else {
            std::fs::copy(&path, &target).map_err(|e| fault(&path, e))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crates_come_after_those_they_depend_on() {
        let package = |name: &str, internal: &[&str]| Package {
            name: name.to_owned(),
            manifest: format!("crates/{name}/Cargo.toml"),
            internal: internal.iter().map(|s| (*s).to_owned()).collect(),
            external: vec![],
            features: Default::default(),
            benches: vec![],
            untested_examples: vec![],
        };
        let packages =
            [package("a", &["b", "c"]), package("b", &["c"]), package("c", &[]), package("nndd-cli", &["a"])];
        assert_eq!(ordered(&packages), ["c", "b", "a"]);
    }
}

//! The compiler in use against `rust-version` of Cargo.toml.
//!
//! `rust-version` says which compilers can build this workspace, and only the one that runs these checks is known to.
//! This is a check of `verify` alone: newer compilers may build.

use crate::workspace::{Outcome, Workspace, output, read};
use std::process::Command;

/// Compares major and minor version of `rustc` with `rust-version`; an error that says both if they differ.
pub(super) fn check(workspace: &Workspace) -> Outcome<bool> {
    let promised = promised(&read(&workspace.root.join("Cargo.toml"))?)?;
    let said = output(Command::new("rustc").current_dir(&workspace.root).arg("--version"))?;
    compare(&promised, &said)?;
    println!("{} is rust-version {promised}", said.trim());
    Ok(true)
}

/// Reads `rust-version` of the workspace.
fn promised(manifest: &str) -> Outcome<String> {
    let manifest: toml::Table = manifest.parse().map_err(|e| format!("Cargo.toml: {e}"))?;
    let package = manifest.get("workspace").and_then(|w| w.get("package"));
    let version = package.and_then(|p| p.get("rust-version")).and_then(toml::Value::as_str);
    version
        .map(str::to_owned)
        .ok_or_else(|| "Cargo.toml: found no rust-version in [workspace.package]".to_owned())
}

/// * `promised`: such as `1.95`.
/// * `said`: the answer of `rustc --version`, such as `rustc 1.95.0 (59807616e 2026-04-14)`.
fn compare(promised: &str, said: &str) -> Outcome<()> {
    let minor = |version: &str| version.split('.').take(2).collect::<Vec<_>>().join(".");
    let found = said.split_whitespace().nth(1).map(minor).unwrap_or_default();
    if found == minor(promised) {
        return Ok(());
    }
    Err(format!(
        "found `{}`, expected {promised}, the rust-version of Cargo.toml; run with that compiler, or change \
         rust-version to {found} if all checks pass with it (--skip compiler)",
        said.trim()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn major_and_minor_version_must_agree() {
        assert_eq!(compare("1.95", "rustc 1.95.0 (59807616e 2026-04-14)\n"), Ok(()));
        assert_eq!(compare("1.95.0", "rustc 1.95.2"), Ok(()));
        for other in ["rustc 1.96.0 (a 2026-06-01)", "rustc 1.9.5", "rustc 1.97.0-nightly", "2.95.0", ""] {
            assert!(compare("1.95", other).is_err(), "{other}");
        }
        let message = compare("1.95", "rustc 1.96.0 (a 2026-06-01)").unwrap_err();
        assert!(message.contains("rustc 1.96.0") && message.contains("expected 1.95"), "{message}");
    }

    #[test]
    fn the_promise_is_read_from_the_manifest() {
        let manifest = "[workspace.package]\nrust-version = \"1.95\"\n";
        assert_eq!(promised(manifest), Ok("1.95".to_owned()));
        assert!(promised("[workspace.package]\n").is_err() && promised("[").is_err());
    }
}

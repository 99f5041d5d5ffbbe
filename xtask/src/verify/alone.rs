//! Each crate of `crates/` checked alone.
//!
//! Cargo gives a dependency every feature that any crate of one command asks for. So in a command for the whole
//! workspace a crate may use a feature that only another crate asks for, and nobody who depends on this crate
//! alone could build it.

use crate::workspace::{Outcome, Workspace, stream};
use std::collections::{BTreeMap, BTreeSet};

/// Runs `cargo check` for one crate after the other and returns whether all passed.
///
/// The release profile and the shared target folder let it reuse the dependencies that clippy has checked, as far as
/// their features agree.
pub(super) fn check(workspace: &Workspace) -> Outcome<bool> {
    let mut failed = vec![];
    for package in workspace.packages.iter().filter(|p| p.is_crate()) {
        for features in combinations(&package.features) {
            let mut command = workspace.cargo(&["check", "--release", "--package", &package.name]);
            if stream(command.args(features))? != Some(0) {
                failed.push(
                    std::iter::once(package.name.as_str()).chain(features).collect::<Vec<_>>().join(" "),
                );
            }
        }
    }
    for name in &failed {
        println!(
            "{name}: does not compile alone; it may use a feature of a dependency that only another crate asks for"
        );
    }
    Ok(failed.is_empty())
}

/// The arguments for a crate's own features: its default, none and all of them, each set of features once.
fn combinations(features: &BTreeMap<String, Vec<String>>) -> Vec<Option<&'static str>> {
    let default = switched_on(features, vec!["default"]);
    let all = switched_on(features, features.keys().map(String::as_str).collect());
    let mut combinations = vec![None];
    if !default.is_empty() {
        combinations.push(Some("--no-default-features"));
    }
    if all != default {
        combinations.push(Some("--all-features"));
    }
    combinations
}

/// Returns the features that some features switch on, themselves included, without `default`.
fn switched_on<'a>(
    features: &'a BTreeMap<String, Vec<String>>,
    mut asked: Vec<&'a str>,
) -> BTreeSet<&'a str> {
    let mut on = BTreeSet::new();
    while let Some(name) = asked.pop() {
        if on.insert(name) {
            asked.extend(features.get(name).into_iter().flatten().map(String::as_str));
        }
    }
    on.remove("default");
    on
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_set_of_features_is_checked_once() {
        let found = |features: &[(&str, &[&str])]| {
            let owned = |l: &[&str]| l.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
            let features = features.iter().map(|(name, on)| ((*name).to_owned(), owned(on))).collect();
            combinations(&features).into_iter().flatten().collect::<Vec<_>>()
        };
        assert!(found(&[]).is_empty() && found(&[("default", &[])]).is_empty());
        assert_eq!(found(&[("a", &[])]), ["--all-features"]);
        assert_eq!(found(&[("default", &["a"]), ("a", &["dep:x"])]), ["--no-default-features"]);
        let both = ["--no-default-features", "--all-features"];
        assert_eq!(found(&[("default", &["a"]), ("a", &[]), ("b", &["a"])]), both);
    }
}

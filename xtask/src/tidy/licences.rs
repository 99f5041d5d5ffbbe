//! Licences and origins of all packages that Cargo.lock names, against deny.toml.

use super::finding::Finding;
use crate::workspace::{Outcome, Workspace, output, read};
use serde_json::Value;
use std::iter::Peekable;

/// The list of what is allowed, which cargo-deny reads too.
const LIST: &str = "deny.toml";
/// The only origin of packages that are not in this workspace.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Asks cargo for all packages, those for other systems and for development included, and judges each.
pub(super) fn check(workspace: &Workspace) -> Outcome<Vec<Finding>> {
    let list = read(&workspace.root.join(LIST))?;
    let text = output(&mut workspace.cargo(&["metadata", "--format-version", "1", "--locked"]))?;
    let metadata: Value = serde_json::from_str(&text).map_err(|e| format!("cargo metadata: {e}"))?;
    let packages = metadata["packages"].as_array().ok_or("cargo metadata: found no packages")?;
    findings(&list, packages)
}

fn findings(list: &str, packages: &[Value]) -> Outcome<Vec<Finding>> {
    let list: toml::Table = list.parse().map_err(|e| format!("{LIST}: {e}"))?;
    let allowed = list.get("licenses").and_then(|l| l.get("allow")).and_then(toml::Value::as_array);
    let allowed = allowed.ok_or_else(|| format!("{LIST}: found no list `allow` in [licenses]"))?;
    let allowed: Vec<&str> = allowed.iter().filter_map(toml::Value::as_str).collect();
    let mut found = vec![];
    for package in packages {
        let text = |key: &str| package[key].as_str().unwrap_or("nothing");
        let [name, version, licence, source] = ["name", "version", "license", "source"].map(text);
        if permitted(licence, &allowed) != Some(true) {
            found.push(format!(
                "found `{licence}` as the licence of {name} {version}, expected an allowed one"
            ));
        }
        if !package["source"].is_null() && source != REGISTRY {
            found.push(format!("found {name} {version} from {source}, expected crates.io"));
        }
    }
    Ok(found.into_iter().map(|what| Finding::new(LIST, 1, what)).collect())
}

/// Tells if the allowed licences satisfy an SPDX expression; `None` if the expression cannot be read.
fn permitted(expression: &str, allowed: &[&str]) -> Option<bool> {
    // Before SPDX, a slash was cargo's OR.
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let mut words = spaced.split_whitespace().peekable();
    let verdict = alternatives(&mut words, allowed)?;
    words.next().is_none().then_some(verdict)
}

/// `A AND B OR C`: AND binds more strongly.
fn alternatives<'a>(words: &mut Peekable<impl Iterator<Item = &'a str>>, allowed: &[&str]) -> Option<bool> {
    let mut any = false;
    loop {
        let mut all = licence(words, allowed)?;
        while words.next_if_eq(&"AND").is_some() {
            all &= licence(words, allowed)?;
        }
        any |= all;
        if words.next_if_eq(&"OR").is_none() {
            return Some(any);
        }
    }
}

/// A licence, with its exception if it has one, or an expression in parentheses.
fn licence<'a>(words: &mut Peekable<impl Iterator<Item = &'a str>>, allowed: &[&str]) -> Option<bool> {
    let name = words.next()?;
    if name == "(" {
        let verdict = alternatives(words, allowed)?;
        return words.next_if_eq(&")").map(|_| verdict);
    }
    if words.next_if_eq(&"WITH").is_some() {
        let exception = words.next()?;
        return Some(allowed.contains(&format!("{name} WITH {exception}").as_str()));
    }
    if ["AND", "OR", "WITH", ")"].contains(&name) { None } else { Some(allowed.contains(&name)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn expressions_are_read_as_spdx_means_them() {
        let allowed = ["MIT", "Unicode-3.0", "Apache-2.0 WITH LLVM-exception"];
        for met in [
            "MIT",
            "GPL-3.0-only OR MIT",
            "Apache-2.0/MIT",
            "Apache-2.0 / MIT",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "GPL-3.0-only AND ISC OR MIT",
            "Apache-2.0 WITH LLVM-exception",
        ] {
            assert_eq!(permitted(met, &allowed), Some(true), "{met}");
        }
        for not_met in
            ["GPL-3.0-only", "MIT AND ISC", "Apache-2.0", "MIT AND (ISC OR Zlib)", "MIT WITH Nothing"]
        {
            assert_eq!(permitted(not_met, &allowed), Some(false), "{not_met}");
        }
        for unread in ["", "MIT OR", "OR MIT", "(MIT", "MIT)", "MIT MIT", "MIT WITH"] {
            assert_eq!(permitted(unread, &allowed), None, "{unread}");
        }
    }

    #[test]
    fn licences_and_origins_that_are_not_allowed_are_found() {
        let list = "[licenses]\nallow = [\"MIT\"]\n";
        let packages = [
            json!({"name": "a", "version": "1.0.0", "license": "MIT", "source": REGISTRY}),
            json!({"name": "b", "version": "2.0.0", "license": "GPL-3.0-only", "source": REGISTRY}),
            json!({"name": "c", "version": "3.0.0", "license": null, "source": null}),
            json!({"name": "d", "version": "4.0.0", "license": "MIT", "source": "git+https://example.org/d"}),
        ];
        let what: Vec<String> = findings(list, &packages).unwrap().into_iter().map(|f| f.what).collect();
        assert_eq!(what.len(), 3, "{what:?}");
        assert!(what[0].contains("`GPL-3.0-only`") && what[0].contains("b 2.0.0"), "{what:?}");
        assert!(what[1].contains("c 3.0.0") && what[2].contains("git+https"), "{what:?}");
        assert!(findings("[licenses]\n", &packages).is_err());
    }
}

//! Single files: what manifests inherit, what no tracked file may hold, what may be at the top.

use super::finding::Finding;
use std::collections::BTreeSet;

/// Fields every package takes from the workspace.
const INHERITED: [&str; 4] = ["version", "edition", "rust-version", "license"];
/// Fields that packages of `crates/` take too.
const INHERITED_BY_CRATES: [&str; 2] = ["keywords", "categories"];
/// Largest tracked file in bytes.
const LARGEST: u64 = 1_000_000;
/// Names allowed at the top.
const TOP: &str = include_str!("top.txt");
/// Folders of one machine; cut in two so that this file passes its own check.
const MACHINE_PATHS: [&str; 4] =
    [concat!("/ho", "me/"), concat!("/ro", "ot/"), concat!("/Us", "ers/"), concat!("\\Us", "ers\\")];
/// A folder outside the repository.
const OUTSIDE: &str = concat!("../sha", "red");
/// Marks of unfinished work.
const UNFINISHED: [&str; 5] = [
    concat!("todo", "!"),
    concat!("unimplemented", "!"),
    concat!("dbg", "!"),
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
];

/// Checks that a manifest takes package fields and lints from the workspace.
pub(super) fn of_manifest(file: &str, text: &str, of_crates: bool) -> Vec<Finding> {
    let manifest: toml::Table = match text.parse() {
        Ok(table) => table,
        Err(error) => return vec![Finding::new(file, 1, format!("found {error}, expected TOML"))],
    };
    let inherits = |v: Option<&toml::Value>| {
        v.and_then(|v| v.get("workspace")).and_then(toml::Value::as_bool) == Some(true)
    };
    let package = manifest.get("package");
    let line = text.lines().position(|l| l.trim() == "[package]").map_or(1, |i| i + 1);
    let fields = INHERITED.iter().chain(INHERITED_BY_CRATES.iter().filter(|_| of_crates));
    let mut findings: Vec<Finding> = fields
        .filter(|f| !inherits(package.and_then(|p| p.get(**f))))
        .map(|f| Finding::new(file, line, format!("found no inherited {f}, expected `{f}.workspace = true`")))
        .collect();
    let readme = package.and_then(|p| p.get("readme")).and_then(|r| r.as_str());
    if of_crates && readme != Some("README.md") {
        let what = "found no page of its own, expected `readme = \"README.md\"`";
        findings.push(Finding::new(file, line, what));
    }
    if !inherits(manifest.get("lints")) {
        findings.push(Finding::new(file, 1, "found no inherited lints, expected `lints.workspace = true`"));
    }
    findings
}

/// Checks one tracked file: its size, its encoding if it is a case, and its words.
pub(super) fn of_file(file: &str, bytes: &[u8]) -> Vec<Finding> {
    let mut findings = vec![];
    let mut add = |line: usize, what: String| findings.push(Finding::new(file, line, what));
    if bytes.len() as u64 > LARGEST {
        add(1, format!("found {} bytes, expected at most {LARGEST}", bytes.len()));
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            if file.starts_with("tests/cases/") {
                let line = bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
                add(line, "found bytes that are not UTF-8, expected text".to_owned());
            }
            return findings;
        }
    };
    for (line, text) in (1..).zip(text.lines()) {
        if let Some(path) = MACHINE_PATHS.iter().find(|p| is_machine_path(text, p)) {
            add(line, format!("found a path below {path}, expected none of one machine"));
        }
        if text.contains(OUTSIDE) {
            add(line, format!("found {OUTSIDE}, expected nothing outside the repository"));
        }
        for word in UNFINISHED.iter().filter(|w| file.ends_with(".rs") && has_mark(text, w)) {
            add(line, format!("found {word}, expected finished work"));
        }
    }
    findings
}

/// Tells if a line holds an absolute path below a folder: nothing of a longer path or address before it, a name after.
fn is_machine_path(line: &str, folder: &str) -> bool {
    let before = |c: char| c.is_alphanumeric() || "._-~/}])>*".contains(c);
    let after = |c: char| c.is_alphanumeric() || "._-".contains(c);
    line.match_indices(folder).any(|(i, _)| {
        !line[..i].chars().next_back().is_some_and(before)
            && line[i + folder.len()..].chars().next().is_some_and(after)
    })
}

/// Tells if a line holds a mark that does not continue a longer word.
fn has_mark(line: &str, mark: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(mark).any(|(i, _)| {
        let after = line[i + mark.len()..].chars().next();
        let continues = if mark.ends_with('!') { after == Some('=') } else { after.is_some_and(part) };
        !line[..i].chars().next_back().is_some_and(part) && !continues
    })
}

/// Checks that only known names are at the top.
pub(super) fn of_top(files: &[String]) -> Vec<Finding> {
    let top: BTreeSet<&str> = files.iter().filter_map(|f| f.split('/').next()).collect();
    let stray = top.into_iter().filter(|t| !TOP.lines().any(|known| known == *t));
    stray.map(|t| Finding::new(t, 1, "found at the top, expected inside one of its folders")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifests_inherit() {
        let good = "[package]\nname = \"a\"\nversion.workspace = true\nedition.workspace = true\nrust-version.workspace = true\nlicense.workspace = true\n[lints]\nworkspace = true\n";
        assert_eq!(of_manifest("xtask/Cargo.toml", good, false), []);
        assert_eq!(of_manifest("crates/a/Cargo.toml", good, true).len(), 3);
        let bad =
            good.replace("edition.workspace = true", "edition = \"2024\"").replace("[lints]", "[other]");
        let found = of_manifest("xtask/Cargo.toml", &bad, false);
        assert!(found.len() == 2 && found[0].what.contains("edition") && found[1].what.contains("lints"));
    }

    #[test]
    fn words_and_paths_are_found() {
        let home = MACHINE_PATHS[0];
        for (line, wrong) in [
            (format!("see {home}someone/x"), true),
            (format!("\"{home}someone\""), true),
            (format!("https://example.org{home}page"), false),
            (format!("crates{home}page"), false),
            (format!("paths such as {home}, say"), false),
            (format!("cat {OUTSIDE}/design.md"), true),
        ] {
            assert_eq!(!of_file("README.md", line.as_bytes()).is_empty(), wrong, "{line}");
        }
        for word in UNFINISHED {
            assert_eq!(of_file("a.rs", format!("// {word} later").as_bytes()).len(), 1, "{word}");
            assert!(of_file("a.md", format!("{word} later").as_bytes()).is_empty());
        }
        assert!(of_file("a.rs", b"let my_dbg = x; // AUTODOC").is_empty());
    }

    #[test]
    fn cases_are_text_and_files_small() {
        assert_eq!(
            of_file("tests/cases/a.toml", b"x = 1\n\xff"),
            [Finding::new("tests/cases/a.toml", 2, "found bytes that are not UTF-8, expected text")]
        );
        assert!(of_file("tests/a.bin", b"\xff").is_empty());
        assert_eq!(of_file("big.txt", &vec![b' '; 1_000_001]).len(), 1);
    }

    #[test]
    fn top_holds_nothing_else() {
        let files = ["Cargo.toml", "crates/a/src/lib.rs", "notes.txt", "docs/a.md"].map(str::to_owned);
        let found: Vec<String> = of_top(&files).into_iter().map(|f| f.file).collect();
        assert_eq!(found, ["docs", "notes.txt"]);
    }
}

//! `cargo xtask tidy`: what no compiler checks.
//!
//! The crate graph in ARCHITECTURE.md equals the one cargo sees; manifests inherit from the workspace; external
//! dependencies are named on the map; every source that a comment cites stands in REFERENCES.bib; the tests of every
//! example run; tracked files hold no path of one machine, no word that marks unfinished
//! work, and are neither large nor out of place.

use crate::citations;
use crate::workspace::{Outcome, Package, Workspace, output, read};
use std::collections::{BTreeMap, BTreeSet};

const MAP: &str = "ARCHITECTURE.md";
const MARKER: &str = "<!-- crate graph: checked by cargo xtask tidy -->";
/// Fields every package takes from the workspace.
const INHERITED: [&str; 4] = ["version", "edition", "rust-version", "license"];
/// Fields those of `crates/` take too.
const INHERITED_BY_CRATES: [&str; 3] = ["keywords", "categories", "readme"];
/// Largest tracked file in bytes.
const LARGEST: u64 = 1_000_000;
/// Rust files beyond so many lines are named.
const LONG: usize = 500;
/// What may stand at the top.
const TOP: [&str; 22] = [
    "Cargo.toml",
    "Cargo.lock",
    "crates",
    "xtask",
    "tests",
    "bench-results",
    "README.md",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "LICENSE-MIT",
    "LICENSE-APACHE",
    "REFERENCES.bib",
    "CITATION.cff",
    "rustfmt.toml",
    "clippy.toml",
    "deny.toml",
    ".cargo",
    ".ci",
    ".gitignore",
    ".gitattributes",
    ".github",
];
/// Folders of one machine; cut in two so that this file passes its own check.
const MACHINE_PATHS: [&str; 4] =
    [concat!("/ho", "me/"), concat!("/ro", "ot/"), concat!("/Us", "ers/"), concat!("\\Us", "ers\\")];
/// What lies outside the repository.
const OUTSIDE: &str = concat!("../sha", "red");
/// Marks of unfinished work.
const UNFINISHED: [&str; 5] = [
    concat!("todo", "!"),
    concat!("unimplemented", "!"),
    concat!("dbg", "!"),
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
];

/// Something that is not as it should be.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Finding {
    pub(crate) file: String,
    pub(crate) line: usize,
    pub(crate) what: String,
}

impl Finding {
    pub(crate) fn new(file: &str, line: usize, what: impl Into<String>) -> Finding {
        Finding { file: file.to_owned(), line, what: what.into() }
    }
}

/// Runs every check, prints what it found, and returns whether it found nothing.
pub(crate) fn run(workspace: &Workspace) -> Outcome<bool> {
    let files = tracked(workspace)?;
    let mut findings = vec![];
    match read(&workspace.root.join(MAP)) {
        Ok(map) => findings.extend(map_findings(&map, &workspace.packages)),
        Err(error) => {
            findings.push(Finding::new(MAP, 1, format!("found {error}, expected a map of the crates")))
        }
    }
    for package in &workspace.packages {
        let text = read(&workspace.root.join(&package.manifest))?;
        findings.extend(manifest_findings(&package.manifest, &text, package.is_crate()));
        let example =
            |name| format!("found no tests of the example {name}, expected `test = true` in its [[example]]");
        let untested = package.untested_examples.iter().map(example);
        findings.extend(untested.map(|what| Finding::new(&package.manifest, 1, what)));
    }
    let sources = citations::entries(&read(&workspace.root.join(citations::BIBLIOGRAPHY))?);
    let mut notes = vec![];
    for file in &files {
        let Ok(bytes) = std::fs::read(workspace.root.join(file)) else { continue };
        findings.extend(file_findings(file, &bytes));
        if file.ends_with(".rs") {
            let text = String::from_utf8_lossy(&bytes);
            // The citations' own tests cite what is not there.
            if !file.ends_with("/citations.rs") {
                findings.extend(citations::findings(file, &text, &sources));
            }
            let lines = text.lines().count();
            if lines > LONG {
                notes.push(format!("note: {file}: {lines} lines, a look for a seam may be worth it"));
            }
        }
    }
    findings.extend(top_findings(&files));
    findings.sort();
    for Finding { file, line, what } in &findings {
        println!("{file}:{line}: {what}");
    }
    for note in &notes {
        println!("{note}");
    }
    println!(
        "tidy: {} files, {} packages, {} findings",
        files.len(),
        workspace.packages.len(),
        findings.len()
    );
    Ok(findings.is_empty())
}

/// The tracked files that exist, from the top folder.
fn tracked(workspace: &Workspace) -> Outcome<Vec<String>> {
    let listed = output(&mut workspace.git(&["ls-files", "-z"]))?;
    let files = listed.split('\0').filter(|f| !f.is_empty()).map(str::to_owned);
    let files: Vec<String> = files.filter(|f| workspace.root.join(f).exists()).collect();
    if files.is_empty() { Err("git tracks no file, expected the workspace".to_owned()) } else { Ok(files) }
}

/// A crate graph: for each name, the line it stands on and what it depends on.
type Graph = BTreeMap<String, (usize, BTreeSet<String>)>;

/// Reads the crate graph of the map: the fenced block after the marker, lines `name -> name, name`.
fn parse_graph(map: &str) -> Result<Graph, Finding> {
    let mut lines = map.lines().enumerate().skip_while(|(_, l)| l.trim() != MARKER);
    let Some((at, _)) = lines.next() else {
        return Err(Finding::new(
            MAP,
            1,
            format!("found no line `{MARKER}`, expected one above the crate graph"),
        ));
    };
    let fenced = |l: &str| l.trim_start().starts_with("```");
    if !lines.by_ref().find(|(_, l)| !l.trim().is_empty()).is_some_and(|(_, l)| fenced(l)) {
        return Err(Finding::new(
            MAP,
            at + 1,
            "found no fenced block below the marker, expected the crate graph",
        ));
    }
    let mut graph = Graph::new();
    for (i, line) in lines {
        if fenced(line) {
            return Ok(graph);
        }
        let (name, needs) = line.split_once("->").unwrap_or((line, ""));
        let name = name.trim();
        if name.is_empty() && needs.is_empty() {
            continue;
        }
        let words: Vec<&str> = needs.split(',').map(str::trim).filter(|w| !w.is_empty()).collect();
        if name.is_empty()
            || name.contains(char::is_whitespace)
            || words.iter().any(|w| w.contains(char::is_whitespace))
        {
            return Err(Finding::new(
                MAP,
                i + 1,
                format!("found `{}`, expected `crate -> crate, crate`", line.trim()),
            ));
        }
        let needs = words.into_iter().map(str::to_owned).collect();
        if graph.insert(name.to_owned(), (i + 1, needs)).is_some() {
            return Err(Finding::new(MAP, i + 1, format!("found `{name}` a second time, expected it once")));
        }
    }
    Err(Finding::new(MAP, at + 1, "found a fenced block without an end, expected ```"))
}

/// Compares the map with the packages: the graph, and the names of external dependencies.
///
/// Every package of `crates/` must stand in the graph; others may.
fn map_findings(map: &str, packages: &[Package]) -> Vec<Finding> {
    let mut findings = vec![];
    match parse_graph(map) {
        Err(finding) => findings.push(finding),
        Ok(graph) => {
            for package in packages {
                let real: BTreeSet<String> = package.internal.iter().cloned().collect();
                match graph.get(&package.name) {
                    None if package.is_crate() => findings.push(Finding::new(
                        MAP,
                        1,
                        format!(
                            "found no `{}` in the crate graph, expected `{}`",
                            package.name,
                            edge(&package.name, &real)
                        ),
                    )),
                    Some((line, drawn)) if *drawn != real => findings.push(Finding::new(
                        MAP,
                        *line,
                        format!(
                            "found `{}`, expected `{}`",
                            edge(&package.name, drawn),
                            edge(&package.name, &real)
                        ),
                    )),
                    _ => {}
                }
            }
            for (name, (line, _)) in graph.iter().filter(|(n, _)| !packages.iter().any(|p| p.name == **n)) {
                findings.push(Finding::new(
                    MAP,
                    *line,
                    format!("found `{name}`, expected a package of the workspace"),
                ));
            }
        }
    }
    let externals: BTreeSet<&String> =
        packages.iter().filter(|p| p.is_crate()).flat_map(|p| &p.external).collect();
    for name in externals.into_iter().filter(|n| !names(map, n)) {
        findings.push(Finding::new(
            MAP,
            1,
            format!("found no mention of the dependency `{name}`, expected its purpose"),
        ));
    }
    findings
}

fn edge(name: &str, needs: &BTreeSet<String>) -> String {
    let needs: Vec<&str> = needs.iter().map(String::as_str).collect();
    format!("{name} -> {}", needs.join(", ")).trim_end().to_owned()
}

/// Whether a text names a package: the name stands alone, not within a longer one.
fn names(text: &str, name: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    text.match_indices(name).any(|(i, _)| {
        !text[..i].chars().next_back().is_some_and(part)
            && !text[i + name.len()..].chars().next().is_some_and(part)
    })
}

/// Checks that a manifest takes package fields and lints from the workspace.
fn manifest_findings(file: &str, text: &str, of_crates: bool) -> Vec<Finding> {
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
    if !inherits(manifest.get("lints")) {
        findings.push(Finding::new(file, 1, "found no inherited lints, expected `lints.workspace = true`"));
    }
    findings
}

/// Checks one tracked file: its size, its encoding where it is a case, and its words.
fn file_findings(file: &str, bytes: &[u8]) -> Vec<Finding> {
    let mut findings = vec![];
    if bytes.len() as u64 > LARGEST {
        findings.push(Finding::new(
            file,
            1,
            format!("found {} bytes, expected at most {LARGEST}", bytes.len()),
        ));
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            if file.starts_with("tests/cases/") {
                let line = bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
                findings.push(Finding::new(file, line, "found bytes that are not UTF-8, expected text"));
            }
            return findings;
        }
    };
    for (i, line) in text.lines().enumerate() {
        if let Some(path) = MACHINE_PATHS.iter().find(|p| is_machine_path(line, p)) {
            findings.push(Finding::new(
                file,
                i + 1,
                format!("found a path below {path}, expected none of one machine"),
            ));
        }
        if line.contains(OUTSIDE) {
            findings.push(Finding::new(
                file,
                i + 1,
                format!("found {OUTSIDE}, expected nothing outside the repository"),
            ));
        }
        if file.ends_with(".rs") {
            for word in UNFINISHED.iter().filter(|w| has_mark(line, w)) {
                findings.push(Finding::new(file, i + 1, format!("found {word}, expected finished work")));
            }
        }
    }
    findings
}

/// Whether a line holds an absolute path below a folder: nothing of a longer path or address before it, a name after.
fn is_machine_path(line: &str, folder: &str) -> bool {
    let before = |c: char| c.is_alphanumeric() || "._-~/}])>*".contains(c);
    let after = |c: char| c.is_alphanumeric() || "._-".contains(c);
    line.match_indices(folder).any(|(i, _)| {
        !line[..i].chars().next_back().is_some_and(before)
            && line[i + folder.len()..].chars().next().is_some_and(after)
    })
}

/// Whether a line holds a mark that does not continue a longer word.
fn has_mark(line: &str, mark: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(mark).any(|(i, _)| {
        let after = line[i + mark.len()..].chars().next();
        let continues = if mark.ends_with('!') { after == Some('=') } else { after.is_some_and(part) };
        !line[..i].chars().next_back().is_some_and(part) && !continues
    })
}

/// Checks that nothing tracked stands at the top that has no business there.
fn top_findings(files: &[String]) -> Vec<Finding> {
    let top: BTreeSet<&str> = files.iter().filter_map(|f| f.split('/').next()).collect();
    let stray = top.into_iter().filter(|t| !TOP.contains(t));
    stray.map(|t| Finding::new(t, 1, "found at the top, expected inside one of its folders")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAPH: &str = "# Map\n\n<!-- crate graph: checked by cargo xtask tidy -->\n```text\nfem-core\nnndd -> contact-qp, fem-core\n\ncontact-qp ->\n```\n\nfaer and `clarabel`.\n";

    fn package(name: &str, internal: &[&str], external: &[&str]) -> Package {
        let owned = |l: &[&str]| l.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
        let manifest = format!("crates/{name}/Cargo.toml");
        Package {
            name: name.to_owned(),
            manifest,
            internal: owned(internal),
            external: owned(external),
            benches: vec![],
            untested_examples: vec![],
        }
    }

    fn packages() -> Vec<Package> {
        vec![
            package("contact-qp", &[], &["clarabel"]),
            package("fem-core", &[], &["faer"]),
            package("nndd", &["contact-qp", "fem-core"], &[]),
        ]
    }

    #[test]
    fn graph_block_is_read() {
        let graph = parse_graph(GRAPH).unwrap();
        assert_eq!(graph.len(), 3);
        assert_eq!(graph["nndd"].0, 6);
        assert_eq!(graph["nndd"].1.iter().collect::<Vec<_>>(), ["contact-qp", "fem-core"]);
        assert!(graph["fem-core"].1.is_empty() && graph["contact-qp"].1.is_empty());
    }

    #[test]
    fn graph_block_that_is_none_is_a_finding() {
        for map in [
            "# Map\n",
            "<!-- crate graph: checked by cargo xtask tidy -->\n",
            "<!-- crate graph: checked by cargo xtask tidy -->\ntext\n",
            "<!-- crate graph: checked by cargo xtask tidy -->\n```\na -> b\n",
            "<!-- crate graph: checked by cargo xtask tidy -->\n```\na needs b\n```\n",
            "<!-- crate graph: checked by cargo xtask tidy -->\n```\na\na -> b\n```\n",
        ] {
            assert!(parse_graph(map).is_err(), "{map}");
        }
    }

    #[test]
    fn map_that_matches_has_no_finding() {
        assert_eq!(map_findings(GRAPH, &packages()), []);
    }

    #[test]
    fn map_that_drifted_is_found() {
        let mut now = packages();
        now[1].external.push("nalgebra".to_owned());
        now[2].internal.pop();
        now.push(package("case-io", &["fem-core"], &[]));
        let what: Vec<String> =
            map_findings(GRAPH, &now).into_iter().map(|f| format!("{}: {}", f.line, f.what)).collect();
        assert_eq!(what.len(), 3, "{what:?}");
        assert!(
            what[0].contains("expected `nndd -> contact-qp`") && what[0].starts_with("6:"),
            "{}",
            what[0]
        );
        assert!(what[1].contains("`case-io -> fem-core`") && what[2].contains("nalgebra"), "{what:?}");
        let gone = map_findings(GRAPH, &packages()[..2]);
        assert!(gone.len() == 1 && gone[0].what.contains("`nndd`"));
    }

    #[test]
    fn names_stand_alone() {
        assert!(
            names("uses `serde`, and", "serde")
                && !names("uses serde_json", "serde")
                && !names("pre-serde", "serde")
        );
    }

    #[test]
    fn manifests_inherit() {
        let good = "[package]\nname = \"a\"\nversion.workspace = true\nedition.workspace = true\nrust-version.workspace = true\nlicense.workspace = true\n[lints]\nworkspace = true\n";
        assert_eq!(manifest_findings("xtask/Cargo.toml", good, false), []);
        assert_eq!(manifest_findings("crates/a/Cargo.toml", good, true).len(), 3);
        let bad =
            good.replace("edition.workspace = true", "edition = \"2024\"").replace("[lints]", "[other]");
        let found = manifest_findings("xtask/Cargo.toml", &bad, false);
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
            assert_eq!(!file_findings("README.md", line.as_bytes()).is_empty(), wrong, "{line}");
        }
        for word in UNFINISHED {
            assert_eq!(file_findings("a.rs", format!("// {word} later").as_bytes()).len(), 1, "{word}");
            assert!(file_findings("a.md", format!("{word} later").as_bytes()).is_empty());
        }
        assert!(file_findings("a.rs", b"let my_dbg = x; // AUTODOC").is_empty());
    }

    #[test]
    fn cases_are_text_and_files_small() {
        assert_eq!(
            file_findings("tests/cases/a.toml", b"x = 1\n\xff"),
            [Finding::new("tests/cases/a.toml", 2, "found bytes that are not UTF-8, expected text")]
        );
        assert!(file_findings("tests/a.bin", b"\xff").is_empty());
        assert_eq!(file_findings("big.txt", &vec![b' '; 1_000_001]).len(), 1);
    }

    #[test]
    fn top_holds_nothing_else() {
        let files = ["Cargo.toml", "crates/a/src/lib.rs", "notes.txt", "docs/a.md"].map(str::to_owned);
        let found: Vec<String> = top_findings(&files).into_iter().map(|f| f.file).collect();
        assert_eq!(found, ["docs", "notes.txt"]);
    }
}

//! The map of the crates, ARCHITECTURE.md, against what cargo sees.

use super::finding::Finding;
use crate::workspace::Package;
use std::collections::{BTreeMap, BTreeSet};

/// The file of the map.
pub(super) const MAP: &str = "ARCHITECTURE.md";
const MARKER: &str = "<!-- crate graph: checked by cargo xtask tidy -->";

/// A crate graph: for each name, the line it is on and what it depends on.
type Graph = BTreeMap<String, (usize, BTreeSet<String>)>;

/// Reads the crate graph of the map: the fenced block after the marker, lines `name -> name, name`.
fn parse_graph(map: &str) -> Result<Graph, Finding> {
    let fault = |line: usize, what: &str| Err(Finding::new(MAP, line, what));
    let mut lines = (1..).zip(map.lines()).skip_while(|(_, l)| l.trim() != MARKER);
    let Some((at, _)) = lines.next() else {
        return fault(1, &format!("found no line `{MARKER}`, expected one above the crate graph"));
    };
    let fenced = |l: &str| l.trim_start().starts_with("```");
    if !lines.by_ref().find(|(_, l)| !l.trim().is_empty()).is_some_and(|(_, l)| fenced(l)) {
        return fault(at, "found no fenced block below the marker, expected the crate graph");
    }
    let mut graph = Graph::new();
    for (number, line) in lines {
        if fenced(line) {
            return Ok(graph);
        }
        let (name, needs) = line.split_once("->").unwrap_or((line, ""));
        let name = name.trim();
        if name.is_empty() && needs.is_empty() {
            continue;
        }
        let words: Vec<&str> = needs.split(',').map(str::trim).filter(|w| !w.is_empty()).collect();
        let has_blank = |word: &&str| word.contains(char::is_whitespace);
        if name.is_empty() || words.iter().chain([&name]).any(has_blank) {
            return fault(number, &format!("found `{}`, expected `crate -> crate, crate`", line.trim()));
        }
        let needs = words.into_iter().map(str::to_owned).collect();
        if graph.insert(name.to_owned(), (number, needs)).is_some() {
            return fault(number, &format!("found `{name}` a second time, expected it once"));
        }
    }
    fault(at, "found a fenced block without an end, expected ```")
}

/// Compares the map with the packages: the graph, and the names of external dependencies.
///
/// Every package of `crates/` must be in the graph; others may.
pub(super) fn findings(map: &str, packages: &[Package]) -> Vec<Finding> {
    let mut findings = vec![];
    let mut add = |line: usize, what: String| findings.push(Finding::new(MAP, line, what));
    match parse_graph(map) {
        Err(Finding { line, what, .. }) => add(line, what),
        Ok(graph) => {
            for package in packages {
                let real: BTreeSet<String> = package.internal.iter().cloned().collect();
                let expected = edge(&package.name, &real);
                match graph.get(&package.name) {
                    None if package.is_crate() => {
                        add(
                            1,
                            format!("found no `{}` in the crate graph, expected `{expected}`", package.name),
                        );
                    }
                    Some((line, drawn)) if *drawn != real => {
                        add(*line, format!("found `{}`, expected `{expected}`", edge(&package.name, drawn)));
                    }
                    _ => {}
                }
            }
            for (name, (line, _)) in graph.iter().filter(|(n, _)| !packages.iter().any(|p| p.name == **n)) {
                add(*line, format!("found `{name}`, expected a package of the workspace"));
            }
        }
    }
    let externals: BTreeSet<&String> =
        packages.iter().filter(|p| p.is_crate()).flat_map(|p| &p.external).collect();
    for name in externals.into_iter().filter(|n| !names(map, n)) {
        add(1, format!("found no mention of the dependency `{name}`, expected its purpose"));
    }
    findings
}

fn edge(name: &str, needs: &BTreeSet<String>) -> String {
    let needs: Vec<&str> = needs.iter().map(String::as_str).collect();
    format!("{name} -> {}", needs.join(", ")).trim_end().to_owned()
}

/// Tells if a text names a package: the whole name, not a part of a longer one.
fn names(text: &str, name: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    text.match_indices(name).any(|(i, _)| {
        !text[..i].chars().next_back().is_some_and(part)
            && !text[i + name.len()..].chars().next().is_some_and(part)
    })
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
            features: Default::default(),
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
        assert_eq!(findings(GRAPH, &packages()), []);
    }

    #[test]
    fn map_that_drifted_is_found() {
        let mut now = packages();
        now[1].external.push("nalgebra".to_owned());
        now[2].internal.pop();
        now.push(package("case-io", &["fem-core"], &[]));
        let what: Vec<String> =
            findings(GRAPH, &now).into_iter().map(|f| format!("{}: {}", f.line, f.what)).collect();
        assert_eq!(what.len(), 3, "{what:?}");
        assert!(
            what[0].contains("expected `nndd -> contact-qp`") && what[0].starts_with("6:"),
            "{}",
            what[0]
        );
        assert!(what[1].contains("`case-io -> fem-core`") && what[2].contains("nalgebra"), "{what:?}");
        let gone = findings(GRAPH, &packages()[..2]);
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
}

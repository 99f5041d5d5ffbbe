//! `cargo xtask tidy`: what no compiler checks.
//!
//! The crate graph in ARCHITECTURE.md equals the one cargo sees; manifests inherit from the workspace; external
//! dependencies are named on the map; every source that a comment cites is in REFERENCES.bib, and every one
//! there is cited; the tests of every example run; tracked files hold no path of one machine, no word that marks unfinished
//! work and, if they are Rust or pages, no phrase that is hard to read, and are neither large nor out of place;
//! every key and value on the page of case files has its place in the matrix of promises;
//! neighbouring modules of a crate take from each other in one direction; every package in Cargo.lock has a licence that
//! deny.toml allows and comes from crates.io.

mod citations;
mod files;
mod finding;
mod keys;
mod licences;
mod map;
mod modules;
mod words;

use crate::workspace::{Outcome, Workspace, output, read};
use finding::Finding;
use map::MAP;
use std::collections::BTreeSet;

/// Rust files with more lines than this are named.
const LONG: usize = 500;
/// Runs every check, prints what it found, and returns whether it found nothing.
pub(crate) fn run(workspace: &Workspace) -> Outcome<bool> {
    let files = tracked(workspace)?;
    let mut findings = vec![];
    match read(&workspace.root.join(MAP)) {
        Ok(map) => findings.extend(map::findings(&map, &workspace.packages)),
        Err(error) => {
            findings.push(Finding::new(MAP, 1, format!("found {error}, expected a map of the crates")))
        }
    }
    for package in &workspace.packages {
        let text = read(&workspace.root.join(&package.manifest))?;
        findings.extend(files::of_manifest(&package.manifest, &text, package.is_crate()));
        let example =
            |name| format!("found no tests of the example {name}, expected `test = true` in its [[example]]");
        let untested = package.untested_examples.iter().map(example);
        findings.extend(untested.map(|what| Finding::new(&package.manifest, 1, what)));
    }
    let sources = citations::entries(&read(&workspace.root.join(citations::BIBLIOGRAPHY))?);
    let mut cited = BTreeSet::new();
    let mut notes = vec![];
    let mut counts = words::Counts::default();
    let mut rust = vec![];
    for file in &files {
        let Ok(bytes) = std::fs::read(workspace.root.join(file)) else { continue };
        findings.extend(files::of_file(file, &bytes));
        let is_rust = file.ends_with(".rs");
        if !is_rust && !file.ends_with(".md") {
            continue;
        }
        let text = String::from_utf8_lossy(&bytes);
        findings.extend(words::findings(file, &text));
        counts.add(file, &text);
        // The citations' own tests cite what is not there.
        if !file.ends_with("/citations.rs") {
            cited.extend(citations::cited(file, &text, &sources));
            if is_rust {
                findings.extend(citations::findings(file, &text, &sources));
            }
        }
        let lines = text.lines().count();
        if is_rust {
            rust.push((file.clone(), text.clone().into_owned()));
        }
        if is_rust && lines > LONG {
            notes.push(format!("note: {file}: {lines} lines, consider splitting this file"));
        }
    }
    findings.extend(citations::uncited(&sources, &cited));
    findings.extend(modules::findings(&rust));
    findings.extend(licences::check(workspace)?);
    findings.extend(files::of_top(&files));
    let [page, table] = [keys::PAGE, keys::TABLE].map(|file| read(&workspace.root.join(file)));
    findings.extend(keys::findings(&page?, &table?));
    findings.sort();
    for Finding { file, line, what } in &findings {
        println!("{file}:{line}: {what}");
    }
    for note in &notes {
        println!("{note}");
    }
    println!("{counts}");
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

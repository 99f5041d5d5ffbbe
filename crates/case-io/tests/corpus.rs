//! Replays what fuzzing has found, and what it started from: no panic, and memory within a multiple of the input.
//!
//! `tests/corpus` has one folder per target. A file that once made a target fail goes there and stays.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic, unreachable_pub)]

#[path = "../fuzz/exercise.rs"]
mod exercise;

use std::path::{Path, PathBuf};

#[global_allocator]
static MEMORY: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

type Target = fn(&[u8]);

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|f| f.is_file() && f.to_string_lossy().ends_with(ending)).collect();
    files.sort();
    files
}

// One test: memory is counted for the whole process.
#[test]
fn every_file_of_the_corpus_is_read_within_bounds() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let cases = here.join("../../tests/cases");
    let targets: [(&str, &str, Target); 6] = [
        ("case", ".toml", exercise::case),
        ("msh", ".msh", exercise::msh),
        ("inp", ".inp", exercise::inp),
        ("exo", ".e", exercise::exo),
        ("vtu", ".vtu", exercise::vtu),
        ("expression", ".txt", exercise::expression),
    ];
    for (name, ending, target) in targets {
        let mut found = files(&here.join("tests/corpus").join(name), "");
        for folder in ["", "bad", "meshes", "bad/meshes"] {
            found.extend(files(&cases.join(folder), ending));
        }
        found.extend(files(&here.join("../mesh-io/tests/data"), ending));
        assert!(found.len() >= 10, "{name}: {} files", found.len());
        for file in &found {
            println!("{}", file.display());
            exercise::bounded(&MEMORY, target, &std::fs::read(file).unwrap());
        }
    }
}

//! Faults that no case file alone can bring about: odd files, full disks, pipes, signals, two runs at once, odd
//! environments. Wrong inputs are in `tests/cases/bad/`.

// All of this is test code: a failed unwrap is a failed test, and skipped tests are printed.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stderr)]
#![cfg(unix)]

#[path = "faults/assemblies.rs"]
mod assemblies;
#[path = "faults/files.rs"]
mod files;
#[path = "faults/limits.rs"]
mod limits;
#[path = "faults/names.rs"]
mod names;
#[path = "faults/processes.rs"]
mod processes;
#[path = "faults/results.rs"]
mod results;
#[path = "faults/scales.rs"]
mod scales;
#[path = "faults/text.rs"]
mod text;

use case_io::report::Report;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").canonicalize().unwrap()
}

/// The program, to be run in a directory.
fn nndd(directory: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.current_dir(directory);
    command
}

/// The program as a shell starts it after some preparation, `$1` being the case and `$2` the output directory.
fn prepared(preparation: &str, case: &Path, out: &Path) -> Output {
    let script = format!("{preparation}; exec \"$0\" solve \"$1\" --out \"$2\"");
    let mut command = Command::new("sh");
    command.arg("-c").arg(script).arg(env!("CARGO_BIN_EXE_nndd")).arg(case).arg(out);
    command.output().unwrap()
}

fn solve(case: &Path, out: &Path, more: &[&str]) -> Output {
    nndd(&cases()).arg("solve").arg(case).arg("--out").arg(out).args(more).output().unwrap()
}

fn said(output: &Output) -> String {
    let text = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    assert!(!text.contains("panicked"), "{text}");
    text
}

fn report(out: &Path) -> Report {
    Report::from_json(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap()
}

/// The report less what may differ between two runs.
fn numbers(out: &Path) -> String {
    let mut report = report(out);
    report.timings = Default::default();
    report.run = Default::default();
    report.to_json().unwrap()
}

fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(120), "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Every file under a directory; empty if it is not there.
fn files_below(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files_below(&path)) } else { found.push(path) }
    }
    found
}

/// Checks that every file with a final name is complete; returns how many such files there are.
fn whole_files(out: &Path) -> usize {
    let files = files_below(out);
    let hidden = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(".nndd");
    for path in files.iter().filter(|path| !hidden(path)) {
        let bytes = std::fs::read(path).unwrap();
        let end: &[u8] = match path.extension().unwrap().to_str().unwrap() {
            "vtu" | "pvd" => b"</VTKFile>\n",
            "svg" => b"</svg>\n",
            "html" => b"</html>\n",
            "json" => b"}\n",
            _ => b"\n",
        };
        assert!(bytes.ends_with(end), "{} is cut: {} bytes", path.display(), bytes.len());
    }
    files.iter().filter(|path| !hidden(path)).count()
}

//! The cost of a fresh clone before the first answer: a cold build of the program, and its dearest units.

use super::machine::{Machine, provenance};
use super::process;
use crate::workspace::{Outcome, Workspace, output, read};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Units that the page lists.
const LISTED: usize = 10;

/// One rustc or build script, with its time.
#[derive(Debug, PartialEq)]
struct Unit {
    name: String,
    seconds: f64,
}

/// A cold build.
struct Build {
    seconds: f64,
    /// Processor time of all its processes; `None` without GNU time.
    processor: Option<f64>,
    /// Units, the dearest first.
    units: Vec<Unit>,
    /// Bytes of the program.
    size: u64,
}

/// Builds the program into an empty folder and writes the page.
pub(super) fn run(workspace: &Workspace, command: &str) -> Outcome<()> {
    // Downloads are no part of a build.
    output(&mut workspace.cargo(&["fetch", "--locked"]))?;
    let build = measure(workspace)?;
    let machine = Machine::look();
    let table = provenance(workspace, &machine, command, &[])?;
    let text = page(&build);
    let title = format!("# Cold build of {} on {}", super::today(), machine.slug());
    super::write_all(workspace, &machine, &[("build.md", format!("{title}\n\n{table}\n{text}"))])?;
    print!("\n{text}");
    Ok(())
}

fn measure(workspace: &Workspace) -> Outcome<Build> {
    let target: PathBuf = workspace.target.join("bench-build");
    if target.exists() {
        std::fs::remove_dir_all(&target).map_err(|e| format!("{}: {e}", workspace.shown(&target)))?;
    }
    println!("building the program into {}", workspace.shown(&target));
    let cargo = workspace.cargo(&[]);
    let done = process::run("cargo build", cargo.get_program().as_ref(), |command| {
        command
            .current_dir(&workspace.root)
            .args(["build", "--release", "--locked", "--bin", "nndd", "--timings", "--target-dir"])
            .arg(&target);
    })?;
    let program = target.join("release").join(format!("nndd{}", std::env::consts::EXE_SUFFIX));
    let size = std::fs::metadata(&program).map_err(|e| format!("{}: {e}", workspace.shown(&program)))?.len();
    let units = units(&read(&target.join("cargo-timings/cargo-timing.html"))?)?;
    let build = Build { seconds: done.seconds, processor: done.processor, units, size };
    std::fs::remove_dir_all(&target).map_err(|e| format!("{}: {e}", workspace.shown(&target)))?;
    Ok(build)
}

/// Reads the units from the page that `cargo build --timings` writes, and sorts them, the dearest first.
fn units(page: &str) -> Outcome<Vec<Unit>> {
    let fault = |what: &str| format!("the page of cargo's --timings {what}");
    let (_, data) = page.split_once("const UNIT_DATA = ").ok_or_else(|| fault("has no list of units"))?;
    let mut values = serde_json::Deserializer::from_str(data).into_iter::<Vec<Value>>();
    let list =
        values.next().ok_or_else(|| fault("ends early"))?.map_err(|e| fault(&format!("is damaged: {e}")))?;
    let text = |unit: &Value, key: &str| unit[key].as_str().unwrap_or_default().to_owned();
    let mut units: Vec<Unit> = list
        .iter()
        .map(|unit| Unit {
            name: format!("{} {}{}", text(unit, "name"), text(unit, "version"), text(unit, "target")),
            seconds: unit["duration"].as_f64().unwrap_or_default(),
        })
        .collect();
    units.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    Ok(units)
}

fn page(build: &Build) -> String {
    let processor = build.processor.map_or("not measured".to_owned(), |s| format!("{s:.0} s"));
    let size = build.size as f64 / f64::from(1 << 20);
    let mut text = format!(
        "`cargo build --release` into an empty folder, everything downloaded before.\n\n\
         | wall time | processor time | units | program |\n|---|---|---|---|\n\
         | {:.0} s | {processor} | {} | {size:.1} MiB |\n\n\
         | dearest units | s |\n|---|---|\n",
        build.seconds,
        build.units.len(),
    );
    for unit in build.units.iter().take(LISTED) {
        let _ = writeln!(text, "| {} | {:.1} |", unit.name, unit.seconds);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_cargos_page() {
        let html = r#"<script>
const UNIT_DATA = [
  { "i": 0, "name": "a", "version": "1.0.0", "mode": "todo", "target": " build script", "start": 0.1, "duration": 0.5 },
  { "i": 1, "name": "b", "version": "2.0.0", "mode": "todo", "target": "", "start": 0.1, "duration": 7.25 }
];
const CONCURRENCY_DATA = [];"#;
        let found = units(html).unwrap();
        assert_eq!(found[0], Unit { name: "b 2.0.0".into(), seconds: 7.25 });
        assert_eq!(found[1].name, "a 1.0.0 build script");
        assert!(units("<html>").unwrap_err().contains("no list of units"));
        let text = page(&Build { seconds: 61.4, processor: None, units: found, size: 3 << 20 });
        assert!(text.contains("| 61 s | not measured | 2 | 3.0 MiB |"), "{text}");
        assert!(text.ends_with("| b 2.0.0 | 7.2 |\n| a 1.0.0 build script | 0.5 |\n"), "{text}");
    }
}

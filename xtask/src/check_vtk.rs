//! `cargo xtask check-vtk`: reads the ParaView files of every example case back by VTK and meshio, which share no code with this
//! program, and compares them with report.json (`xtask/vtk/read_back.py`).

use crate::python::{Environment, Group};
use crate::workspace::{Outcome, Workspace, stream};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Arguments of `check-vtk`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Draw the first case's deformed bodies from the files, as a picture
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
}

const READERS: [Group; 1] = [Group {
    name: "vtk",
    tools: &[],
    packages: &[["vtk", "9.5.2"], ["meshio", "5.3.5"]],
    hint: "they need Python 3.9 or newer and the package index",
}];

/// The case whose bodies are drawn; it comes first.
const DRAWN: &str = "paper";

/// Solves the cases and reads their files back; whether all agree. Skipped by name if Python or its packages are not
/// available.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<bool> {
    let environment = Environment::make(workspace.target.join("vtk-venv"), &READERS);
    if let Some((name, reason)) = environment.missing.first() {
        println!("check-vtk: skipped, {name}: {reason}");
        return Ok(true);
    }
    workspace.build_nndd()?;
    let mut failed = 0;
    let cases = cases(workspace)?;
    for (k, case) in cases.iter().enumerate() {
        let out = workspace.target.join("check-vtk").join(case);
        let file = format!("tests/cases/{case}.toml");
        let solved = workspace.solve(Path::new(&file), &[], &out)? == Some(0);
        let mut command = Command::new(environment.python());
        command.arg(workspace.root.join("xtask/vtk/read_back.py")).arg(&out);
        if let Some(picture) = arguments.picture.as_ref().filter(|_| k == 0) {
            command.arg(picture);
        }
        if !solved || stream(&mut command)? != Some(0) {
            failed += 1;
            println!("{case}: FAILED");
        }
    }
    println!("check-vtk: {} cases agree, {failed} do not", cases.len() - failed);
    Ok(failed == 0)
}

/// Lists the example cases by name.
fn cases(workspace: &Workspace) -> Outcome<Vec<String>> {
    let folder = workspace.root.join("tests/cases");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut cases: Vec<String> =
        names.filter_map(|name| Some(name.strip_suffix(".toml")?.to_owned())).collect();
    cases.sort_by_key(|case| (case != DRAWN, case.clone()));
    Ok(cases)
}

//! `cargo xtask check-vtk`: reads the ParaView files of some cases back by VTK and meshio, which share no code with this
//! program, and compares them with report.json (`xtask/vtk/read_back.py`).

use crate::python::{Environment, Group};
use crate::workspace::{Outcome, Workspace, stream};
use clap::Args;
use std::path::PathBuf;
use std::process::Command;

/// What `check-vtk` takes from the command line.
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

/// One body softer than the other, a gap, a curved line, meshes cut to each other, a series of meshes.
const CASES: [&str; 5] = ["paper", "hertz", "rings", "nonmatching", "adaptive"];

/// Solves the cases and reads their files back; whether all agree. Skipped by name where Python or its packages are not
/// to be had.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<bool> {
    let environment = Environment::make(workspace.target.join("vtk-venv"), &READERS);
    if let Some((name, reason)) = environment.missing.first() {
        println!("check-vtk: skipped, {name}: {reason}");
        return Ok(true);
    }
    if stream(&mut workspace.cargo(&["build", "--release", "--bin", "nndd"]))? != Some(0) {
        return Err("the program does not build".to_owned());
    }
    let mut failed = 0;
    for (k, case) in CASES.into_iter().enumerate() {
        let out = workspace.target.join("check-vtk").join(case);
        let mut command = Command::new(workspace.nndd());
        command.current_dir(&workspace.root).arg("solve").arg(format!("tests/cases/{case}.toml"));
        command.arg("--out").arg(&out).args(["--force", "--quiet"]);
        let solved = stream(&mut command)? == Some(0);
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
    println!("check-vtk: {} cases agree, {failed} do not", CASES.len() - failed);
    Ok(failed == 0)
}

//! `cargo xtask reproduce`: runs the studies of the package `tests` and writes their tables to `bench-results/`.

use crate::workspace::{Outcome, Workspace, output, stream};
use std::process::Command;

/// Writes `bench-results/iterations/README.md`.
pub(crate) fn run(workspace: &Workspace) -> Outcome<()> {
    let mut build = workspace.cargo(&["build", "--release", "-p", "tests", "--bin", "reproduce"]);
    if stream(&mut build)? != Some(0) {
        return Err("the studies do not build".to_owned());
    }
    let program = workspace.nndd().with_file_name("reproduce");
    let table = output(Command::new(program).current_dir(&workspace.root))?;
    let commit =
        output(Command::new("git").args(["rev-parse", "--short", "HEAD"]).current_dir(&workspace.root))?;
    let text = format!(
        "# Iterations to reduce eta_nndd by 1e-10\n\n\
         Written by `cargo xtask reproduce` at commit {}. The problems are those of `tests/support/blocks.rs`; all \
         settings are the defaults (stiffness weights, Anderson, theta auto), from lambda = 0.\n\n\
         `cells` is the number of contact edges. `auto` lets the stiffer body carry lambda; `first` and `second` \
         force it on the upper and on the lower body. `stall` and `div` say where a run gave up: with the much \
         softer body carrying lambda the iteration is not reliable, which is why `auto` is the default.\n\n{table}",
        commit.trim()
    );
    let folder = workspace.root.join("bench-results/iterations");
    let path = folder.join("README.md");
    std::fs::create_dir_all(&folder)
        .and_then(|()| std::fs::write(&path, text))
        .map_err(|e| format!("{}: {e}", workspace.shown(&path)))?;
    println!("wrote {}", workspace.shown(&path));
    Ok(())
}

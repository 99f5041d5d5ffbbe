//! Tasks of the workspace, run as `cargo xtask TASK`: everything that is not plain cargo.
//!
//! - `verify` runs every check a change must pass,
//! - `docs` builds the documentation with its formulae typeset,
//! - `tidy` checks what no compiler checks: the crate graph on the map, stray files, forbidden words,
//! - `bench` runs the benchmark suites and writes `bench-results/`; with `--peers`, other programs beside this one,
//!   with `--limits`, the phases of a solve beside the limits of the machine,
//! - `python` builds the wheel of the Python package and runs its tests,
//! - `check-vtk` reads the ParaView files back by other programs,
//! - `gallery` makes the pictures of `bench-results/gallery` again,
//! - `reproduce` runs the studies whose tables are in `bench-results/`,
//! - `deep` runs what needs tools beyond the stable compiler: licences, AddressSanitizer, Miri.

// Reporting is what these tasks are for.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod bench;
mod check_vtk;
mod deep;
mod docs;
mod gallery;
mod package;
mod python;
mod reproduce;
mod steps;
mod tidy;
mod verify;
mod workspace;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use workspace::Workspace;

/// The command line.
#[derive(Parser)]
#[command(name = "cargo xtask", about = "Tasks of the workspace")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Run every check: compiler, format, clippy, crates, tests, docs, cases, tidy
    Verify(verify::Arguments),
    /// Build the documentation, formulae typeset
    Docs,
    /// Check the crate graph, the manifests and the tracked files
    Tidy,
    /// Run the benchmark suites and write a folder of bench-results
    Bench(bench::Arguments),
    /// Build the Python package and check it: tests, examples, notebooks, types, style
    Python,
    /// Read the ParaView files of some cases back by VTK and meshio
    CheckVtk(check_vtk::Arguments),
    /// Solve the gallery's cases and write their pictures to bench-results/gallery
    Gallery,
    /// Run the studies and write their tables to bench-results
    Reproduce(reproduce::Arguments),
    /// Check licences, memory accesses and undefined behaviour with what is installed
    Deep,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let outcome = Workspace::find().and_then(|workspace| match arguments.task {
        Task::Verify(arguments) => verify::run(&workspace, &arguments),
        Task::Docs => docs::run(&workspace),
        Task::Tidy => tidy::run(&workspace),
        Task::Bench(arguments) => bench::run(&workspace, &arguments).map(|()| true),
        Task::Python => package::run(&workspace),
        Task::CheckVtk(arguments) => check_vtk::run(&workspace, &arguments),
        Task::Gallery => gallery::run(&workspace).map(|()| true),
        Task::Reproduce(arguments) => reproduce::run(&workspace, &arguments).map(|()| true),
        Task::Deep => deep::run(&workspace),
    });
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("xtask: {error}");
            ExitCode::FAILURE
        }
    }
}

//! The command line.

use crate::help;
use crate::threads;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use std::path::PathBuf;

/// Solves unilateral contact between elastic bodies, with or without friction, and certifies the answer.
#[derive(Debug, Parser)]
#[command(name = "nndd", version, after_help = help::of_program(), arg_required_else_help = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Solve a case and certify the answer.
    #[command(after_help = help::of_command("solve"))]
    Solve(Solve),
    /// Check a case without factorising anything: bodies, groups, supports, sizes, memory.
    #[command(after_help = help::of_command("check"))]
    Check(Check),
    /// Run a case for several values of one setting, a few iterations each: the paper's figure 2.
    #[command(after_help = help::of_command("sweep"))]
    Sweep(Sweep),
    /// Certify displacements that another code computed on the meshes of a case.
    #[command(after_help = help::of_command("certify"))]
    Certify(Certify),
    /// Compare the results of two runs, and say if their intervals meet.
    #[command(after_help = help::of_command("compare"))]
    Compare(Compare),
    /// Show what a mesh file holds: groups, cells, bounding box, quality, possible problems.
    #[command(after_help = help::of_command("mesh"))]
    Mesh(Mesh),
    /// Print a commented case file to start from: paper, patch, hertz, adaptive, assembly, gmsh, solid.
    New {
        /// Name of the template.
        template: String,
    },
    /// Print the manual page, of all commands: nndd man > nndd.1 && man ./nndd.1
    Man,
    /// Print a completion script.
    Completions {
        /// For which shell.
        shell: Shell,
    },
}

impl Command {
    /// Says whether the output is read by a program.
    pub(crate) fn is_for_programs(&self) -> bool {
        match self {
            Self::Solve(options) => options.format == Format::Json,
            Self::Check(options) => options.format == Format::Json,
            Self::Mesh(options) => options.format == Format::Json,
            Self::Certify(options) => options.format == Format::Json,
            Self::Compare(options) => options.format == Format::Json,
            _ => false,
        }
    }
}

/// Reads a number of threads.
fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if threads <= threads::MOST => Ok(threads),
        _ => Err(format!("expected a whole number from 0 to {}", threads::MOST)),
    }
}

/// Reads a number of iterations.
fn iteration_count(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|count| *count > 0)
        .ok_or_else(|| "expected a whole number, at least 1".to_owned())
}

/// What every command that reads a case takes.
#[derive(Args, Clone, Debug)]
pub(crate) struct CaseOptions {
    /// The case file.
    #[arg(value_name = "CASE.toml")]
    pub(crate) case: PathBuf,
    /// Override a setting; VALUE is TOML, arrays are addressed by index: body.0.generator.cells=[36,18].
    #[arg(long = "set", help_heading = "Input", value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

/// What every command that computes takes.
#[derive(Args, Clone, Debug)]
pub(crate) struct RunOptions {
    /// Write results here instead of the case's output directory.
    #[arg(long, help_heading = "Output", value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write even if the directory contains something else.
    #[arg(long, help_heading = "Output")]
    pub(crate) force: bool,
    /// Number of threads, at most 1024; 0 for one per core.
    #[arg(long, help_heading = "Running", value_name = "N", default_value_t = 0, value_parser = thread_count)]
    pub(crate) threads: usize,
    /// Print only errors, and the reason if the result is not what was asked for.
    #[arg(long, short, help_heading = "Output", conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Print more about every automatic choice.
    #[arg(long, short, help_heading = "Output")]
    pub(crate) verbose: bool,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct Solve {
    #[command(flatten)]
    pub(crate) case: CaseOptions,
    #[command(flatten)]
    pub(crate) run: RunOptions,
    /// Resume an interrupted adaptive run of this case.
    #[arg(long, help_heading = "Running", conflicts_with = "force")]
    pub(crate) resume: bool,
    /// How to print progress and result.
    #[arg(long, help_heading = "Output", value_enum, default_value_t = Format::Human)]
    pub(crate) format: Format,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) case: CaseOptions,
    /// How to print the result.
    #[arg(long, help_heading = "Output", value_enum, default_value_t = Format::Human)]
    pub(crate) format: Format,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct Certify {
    #[command(flatten)]
    pub(crate) case: CaseOptions,
    /// One file per body, in the order of the case file: .vtu with the array `displacement` at its points, or .csv with the columns x,
    /// y, ux, uy.
    #[arg(long, help_heading = "Input", value_name = "FILE", num_args = 1.., required = true)]
    pub(crate) displacement: Vec<PathBuf>,
    /// Write report.json, report.html and a .vtu file of each body here; nothing is written by default.
    #[arg(long, help_heading = "Output", value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write even if the directory contains something else.
    #[arg(long, help_heading = "Output", requires = "out")]
    pub(crate) force: bool,
    /// Number of threads, at most 1024; 0 for one per core.
    #[arg(long, help_heading = "Running", value_name = "N", default_value_t = 0, value_parser = thread_count)]
    pub(crate) threads: usize,
    /// How to print the result.
    #[arg(long, help_heading = "Output", value_enum, default_value_t = Format::Human)]
    pub(crate) format: Format,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct Sweep {
    #[command(flatten)]
    pub(crate) case: CaseOptions,
    #[command(flatten)]
    pub(crate) run: RunOptions,
    /// The setting and its values: KEY=a:b:h or KEY=[v1, v2].
    #[arg(long, help_heading = "Running", value_name = "KEY=RANGE")]
    pub(crate) over: String,
    /// Iterations of each run, at least 1.
    #[arg(long, help_heading = "Running", value_name = "N", default_value_t = 3, value_parser = iteration_count)]
    pub(crate) iterations: usize,
    /// A further panel with other settings: "KEY=VALUE; KEY=VALUE".
    #[arg(long, help_heading = "Running", value_name = "SETTINGS")]
    pub(crate) panel: Vec<String>,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct Compare {
    /// The folder of one run, which `nndd solve` wrote.
    #[arg(value_name = "A")]
    pub(crate) first: PathBuf,
    /// The folder of another run with the same bodies.
    #[arg(value_name = "B")]
    pub(crate) second: PathBuf,
    /// How to print.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub(crate) format: Format,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct Mesh {
    /// The mesh file: Gmsh MSH 1, 2 or 4, an Abaqus-style input deck, Exodus II, or VTK XML (.vtu).
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// How to print.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub(crate) format: Format,
}

/// How to print.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A table for people.
    Human,
    /// One JSON object per line.
    Json,
}

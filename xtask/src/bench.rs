//! `cargo xtask bench`: measures this program, or with `--peers` this program beside others, and writes
//! `bench-results/<date>-<machine>/`.
//!
//! | what | where |
//! |---|---|
//! | criterion suites | [`criterion`] |
//! | the factorisation beside faer's | [`factor`] |
//! | phases beside the limits of the machine | [`limits`] |
//! | the program as a whole process | [`process`] |
//! | a cold build of the program | [`build`] |
//! | other programs on the same meshes | [`peers`] |
//! | assemblies and friction | [`assemblies`] |
//! | their scaling with the number of bodies | [`scaling`] |
//! | solids | [`solids`] |
//! | machine, commit, compiler | [`machine`] |
//! | the page of an ordinary run | [`page`] |

mod assemblies;
mod build;
mod criterion;
mod factor;
mod limits;
mod machine;
mod numbers;
mod page;
pub(crate) mod peers;
mod process;
mod scaling;
mod solids;

use crate::workspace::{Outcome, Workspace};
use clap::Args;
use machine::Machine;

/// Arguments of `bench`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Let criterion stop as soon as its estimate settles
    #[arg(long)]
    quick: bool,
    /// Time 1280x640 cells per body as well: minutes, and several GiB of memory
    #[arg(long)]
    large: bool,
    /// Time what a user would pick instead, beside this program and on the same meshes, and nothing else
    #[arg(long)]
    peers: bool,
    /// Time a cold build of the program, count its units and weigh the binary, and nothing else
    #[arg(long, conflicts_with = "peers")]
    build: bool,
    /// Time the factorisation beside faer's, and nothing else
    #[arg(long, conflicts_with_all = ["peers", "build"])]
    factor: bool,
    /// Time the phases of a solve beside the limits of the machine, and nothing else
    #[arg(long, conflicts_with_all = ["peers", "build", "factor"])]
    limits: bool,
    /// Time assemblies and pairs with friction beside a linear solve of PARDISO, and nothing else
    #[arg(long, conflicts_with_all = ["peers", "build", "factor", "limits"])]
    assemblies: bool,
    /// Time contact and certificate of solids beside PARDISO, and nothing else; with --quick on small boxes alone
    #[arg(long, conflicts_with_all = ["peers", "build", "factor", "limits", "assemblies"])]
    solids: bool,
    /// Runs of each process, after a discarded first run
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// With --peers: only meshes of at most this many cells per side
    #[arg(long, requires = "peers", value_name = "CELLS")]
    up_to: Option<usize>,
}

impl Arguments {
    /// The command line that these arguments come from.
    fn command(&self) -> String {
        let flags = [
            (self.peers, " --peers"),
            (self.build, " --build"),
            (self.factor, " --factor"),
            (self.limits, " --limits"),
            (self.assemblies, " --assemblies"),
            (self.solids, " --solids"),
            (self.quick, " --quick"),
            (self.large, " --large"),
        ];
        let given: String = flags.into_iter().filter_map(|(given, flag)| given.then_some(flag)).collect();
        let runs = if self.runs == 5 { String::new() } else { format!(" --runs {}", self.runs) };
        let up_to = self.up_to.map(|n| format!(" --up-to {n}")).unwrap_or_default();
        format!("cargo xtask bench{given}{runs}{up_to}")
    }
}

/// Measures, and writes the results.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<()> {
    if arguments.build {
        return build::run(workspace, &arguments.command());
    }
    if arguments.factor {
        return factor::run(workspace, &arguments.command(), arguments.runs);
    }
    if arguments.limits {
        return limits::run(workspace, &arguments.command(), arguments.large);
    }
    if arguments.assemblies {
        workspace.build_nndd()?;
        return assemblies::run(workspace, &arguments.command(), arguments.runs as usize);
    }
    if arguments.solids {
        workspace.build_nndd()?;
        return solids::run(workspace, &arguments.command(), arguments.quick);
    }
    if arguments.peers {
        workspace.build_nndd()?;
        return peers::run(workspace, arguments);
    }
    let suites: Vec<&str> = workspace
        .packages
        .iter()
        .filter(|p| p.is_crate())
        .flat_map(|p| p.benches.iter().map(String::as_str))
        .filter(|name| *name != factor::SUITE)
        .collect();
    let quick: &[&str] = if arguments.quick { &["--quick"] } else { &[] };
    let estimates = criterion::measure(workspace, &suites, quick)?;
    workspace.build_nndd()?;
    let processes = process::time_all(workspace, arguments.large, arguments.runs as usize)?;
    let machine = Machine::look();
    let readme = page::readme(workspace, &arguments.command(), &machine, &estimates, &processes)?;
    write_all(
        workspace,
        &machine,
        &[
            ("README.md", readme),
            ("criterion.csv", page::criterion_csv(&estimates)),
            ("whole-process.csv", page::process_csv(&processes)),
            ("phases.csv", page::phases_csv(&processes)),
        ],
    )?;
    print!("\n{}", page::summary(&estimates, &processes));
    factor::run(workspace, &arguments.command(), arguments.runs)
}

/// Today's date, as it is in the names of folders.
fn today() -> String {
    let now = humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string();
    now.chars().take_while(|c| *c != 'T').collect()
}

/// Writes files to the folder of this day and machine.
fn write_all(workspace: &Workspace, machine: &Machine, files: &[(&str, String)]) -> Outcome<()> {
    let folder = workspace.root.join("bench-results").join(format!("{}-{}", today(), machine.slug()));
    files.iter().try_for_each(|(name, text)| workspace.write(&folder.join(name), text))
}

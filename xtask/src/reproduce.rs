//! `cargo xtask reproduce`: runs the studies of the package `tests` and writes their pages to `bench-results/`.

mod fiat;
mod mutations;
mod peers;

use crate::workspace::{Outcome, Workspace, load_average, output, stream};
use clap::Args;
use std::path::Path;
use std::process::Command;

/// Arguments of `reproduce`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Only this study: iterations, effectivity, adaptivity, adversarial, friction, solids, fiat or mutations
    study: Option<String>,
    /// Fewer and smaller meshes
    #[arg(long)]
    quick: bool,
    /// Repeats this problem of the study adversarial and prints its case file and verdicts
    #[arg(long, value_name = "N")]
    only: Option<u64>,
    /// Only the problems of solids of the study adversarial: their part of the page, or with --only one of them
    #[arg(long)]
    solids: bool,
    /// Number of problems of the study adversarial
    #[arg(long, value_name = "N")]
    problems: Option<u64>,
}

/// The studies, each with its title and the text above its tables.
const PAGES: [(&str, &str); 7] = [
    ("iterations", include_str!("reproduce/iterations.md")),
    ("effectivity", include_str!("reproduce/effectivity.md")),
    ("adaptivity", include_str!("reproduce/adaptivity.md")),
    ("adversarial", include_str!("reproduce/adversarial.md")),
    ("friction", include_str!("reproduce/friction.md")),
    ("solids", include_str!("reproduce/printed.md")),
    (FIAT, include_str!("reproduce/fiat.md")),
];
/// The study whose page needs a program of others.
const FIAT: &str = "fiat";

/// Writes `bench-results/STUDY/` for each study.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<()> {
    if arguments.study.as_deref() == Some("mutations") {
        return mutations::run(workspace);
    }
    let wanted = |(study, _): &&(&str, &str)| arguments.study.as_ref().is_none_or(|s| s == study);
    if PAGES.iter().filter(wanted).count() == 0 {
        let names = PAGES.map(|(study, _)| study).join(", ");
        return Err(format!("no such study; there are {names}, mutations"));
    }
    // These need nothing but the package of the studies.
    let alone = arguments.solids || ["solids", FIAT].map(Some).contains(&arguments.study.as_deref());
    let packages: &[&str] = if alone { &["-p", "tests"] } else { &["--workspace"] };
    let mut build = workspace.cargo(&[&["build", "--release", "--bin", "reproduce"], packages].concat());
    if stream(&mut build)? != Some(0) {
        return Err("the studies do not build".to_owned());
    }
    if let Some(number) = arguments.only {
        let mut command = program(workspace, "adversarial", &workspace.target.join("adversarial"), arguments);
        return match stream(command.arg("--only").arg(number.to_string()))? {
            Some(0) => Ok(()),
            _ => Err(format!("problem {number} violates a promise")),
        };
    }
    let commit = workspace.commit()?;
    if arguments.solids {
        return write_solids(workspace, &commit, arguments);
    }
    for (study, page) in PAGES.iter().filter(wanted) {
        write(workspace, study, page, &commit, arguments)?;
    }
    if arguments.study.is_none() { mutations::run(workspace) } else { Ok(()) }
}

/// Makes the command of a study.
fn program(workspace: &Workspace, study: &str, folder: &Path, arguments: &Arguments) -> Command {
    let mut command = Command::new(workspace.nndd().with_file_name("reproduce"));
    command.arg(study).arg(folder).current_dir(&workspace.root);
    for (flag, given) in [("--quick", arguments.quick), ("--solids", arguments.solids)] {
        if given {
            command.arg(flag);
        }
    }
    if let Some(problems) = arguments.problems {
        command.arg("--problems").arg(problems.to_string());
    }
    command
}

/// The flags of a study, as they are on its page.
fn flags(arguments: &Arguments) -> String {
    let mut flags = String::new();
    for (flag, given) in [(" --quick", arguments.quick), (" --solids", arguments.solids)] {
        flags += if given { flag } else { "" };
    }
    flags + &arguments.problems.map_or_else(String::new, |n| format!(" --problems {n}"))
}

/// The title of the last part of the page of the study adversarial.
const SOLIDS: &str = "## Solids\n\n";
/// The text below this title.
const SOLIDS_TEXT: &str = include_str!("reproduce/solids.md");

/// Replaces the part about solids of the page of the study adversarial.
fn write_solids(workspace: &Workspace, commit: &str, arguments: &Arguments) -> Outcome<()> {
    let folder = workspace.root.join("bench-results").join("adversarial");
    let (load, file) = (load(), folder.join("README.md"));
    let table = output(&mut program(workspace, "adversarial", &folder, arguments))?;
    let page = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", workspace.shown(&file)))?;
    let (before, _) = page.split_once(SOLIDS).unwrap_or((&page, ""));
    let written = format!(
        "This part was written by `cargo xtask reproduce adversarial{}` at commit {commit}, on {load}.",
        flags(arguments)
    );
    let table = table.trim_start_matches(SOLIDS).trim();
    let text = format!("{}\n\n{SOLIDS}{written}\n\n{SOLIDS_TEXT}\n{table}\n", before.trim_end());
    workspace.write(&file, &text)?;
    if table.matches(" violated.").count() == table.matches(" 0 violated.").count() {
        Ok(())
    } else {
        Err("promises are violated: see solids-violations.csv beside the page".to_owned())
    }
}

fn write(workspace: &Workspace, study: &str, page: &str, commit: &str, arguments: &Arguments) -> Outcome<()> {
    let folder = workspace.root.join("bench-results").join(study);
    // FIAT's cells are no result.
    let files = if study == FIAT { workspace.target.join(study) } else { folder.clone() };
    let mut command = program(workspace, study, &files, arguments);
    let load = load();
    let mut tables = output(&mut command)?;
    if study == FIAT {
        match fiat::judge(workspace, &files)? {
            Ok(found) => tables = found,
            Err(reason) => {
                println!("skipped {reason}");
                return Ok(());
            }
        }
    }
    if study == "adaptivity" {
        let file = folder.join("adaptivity.csv");
        let csv = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", workspace.shown(&file)))?;
        tables = format!("{}\n{}", tables.trim_end(), peers::section(workspace, &csv)?);
    }
    if study == "adversarial" {
        tables = tables.replace(SOLIDS, &format!("{SOLIDS}{SOLIDS_TEXT}\n"));
    }
    let flag = flags(arguments);
    let (title, text) = page.split_once("\n\n").unwrap_or((page, ""));
    let text = format!(
        "{title}\n\nWritten by `cargo xtask reproduce {study}{flag}` at commit {commit}, on {load}.\n\n{text}\n{}\n",
        tables.trim_end()
    );
    workspace.write(&folder.join("README.md"), &text)?;
    let missed = study == FIAT && tables.contains("missed");
    if missed { Err(format!("a target of {study} is missed: see its page")) } else { Ok(()) }
}

/// Describes the machine as far as times depend on it: processors, and how busy they were before the run.
fn load() -> String {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{processors} processors with a load of {} before it began", load_average())
}

//! `cargo xtask reproduce`: runs the studies of the package `tests` and writes their pages to `bench-results/`.

mod mutations;
mod peers;

use crate::workspace::{Outcome, Workspace, load_average, output, stream};
use clap::Args;
use std::process::Command;

/// Arguments of `reproduce`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Only this study: iterations, effectivity, adaptivity, adversarial, friction or mutations
    study: Option<String>,
    /// Fewer and smaller meshes
    #[arg(long)]
    quick: bool,
    /// Repeats this problem of the study adversarial and prints its case file and verdicts
    #[arg(long, value_name = "N")]
    only: Option<u64>,
}

/// The studies, each with its title and the text above its tables.
const PAGES: [(&str, &str); 5] = [
    ("iterations", include_str!("reproduce/iterations.md")),
    ("effectivity", include_str!("reproduce/effectivity.md")),
    ("adaptivity", include_str!("reproduce/adaptivity.md")),
    ("adversarial", include_str!("reproduce/adversarial.md")),
    ("friction", include_str!("reproduce/friction.md")),
];

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
    let mut build = workspace.cargo(&["build", "--release", "--workspace", "--bin", "reproduce"]);
    if stream(&mut build)? != Some(0) {
        return Err("the studies do not build".to_owned());
    }
    if let Some(number) = arguments.only {
        let mut command = Command::new(workspace.nndd().with_file_name("reproduce"));
        command
            .arg("adversarial")
            .arg(workspace.target.join("adversarial"))
            .arg("--only")
            .arg(number.to_string());
        return match stream(&mut command)? {
            Some(0) => Ok(()),
            _ => Err(format!("problem {number} violates a promise")),
        };
    }
    let commit = workspace.commit()?;
    for (study, page) in PAGES.iter().filter(wanted) {
        write(workspace, study, page, &commit, arguments.quick)?;
    }
    if arguments.study.is_none() { mutations::run(workspace) } else { Ok(()) }
}

fn write(workspace: &Workspace, study: &str, page: &str, commit: &str, quick: bool) -> Outcome<()> {
    let folder = workspace.root.join("bench-results").join(study);
    let program = workspace.nndd().with_file_name("reproduce");
    let mut command = Command::new(program);
    command.arg(study).arg(&folder).current_dir(&workspace.root);
    if quick {
        command.arg("--quick");
    }
    let load = load();
    let mut tables = output(&mut command)?;
    if study == "adaptivity" {
        let file = folder.join("adaptivity.csv");
        let csv = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", workspace.shown(&file)))?;
        tables = format!("{}\n{}", tables.trim_end(), peers::section(workspace, &csv)?);
    }
    let flag = if quick { " --quick" } else { "" };
    let (title, text) = page.split_once("\n\n").unwrap_or((page, ""));
    let text = format!(
        "{title}\n\nWritten by `cargo xtask reproduce {study}{flag}` at commit {commit}, on {load}.\n\n{text}\n{}\n",
        tables.trim_end()
    );
    workspace.write(&folder.join("README.md"), &text)
}

/// Describes the machine as far as times depend on it: processors, and how busy they were before the run.
fn load() -> String {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{processors} processors with a load of {} before it began", load_average())
}

//! `cargo xtask reproduce`: runs the studies of the package `tests` and writes their pages to `bench-results/`.

use crate::workspace::{Outcome, Workspace, output, stream};
use clap::Args;
use std::process::Command;

/// What `reproduce` can be asked.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Only this study: iterations, effectivity, adaptivity, adversarial or friction
    study: Option<String>,
    /// Fewer and smaller meshes
    #[arg(long)]
    quick: bool,
}

/// A page: its folder, its title and the text above the tables.
struct Page {
    study: &'static str,
    title: &'static str,
    text: &'static str,
}

const PAGES: [Page; 5] = [
    Page {
        study: "iterations",
        title: "Iterations to reduce eta_nndd by 1e-10",
        text: "The problems are those of `tests/support/blocks.rs`; all settings are the defaults (stiffness weights, \
               Anderson, theta auto), from lambda = 0.\n\n\
               `cells` is the number of contact edges. `auto` lets the stiffer body carry lambda; `first` and `second` \
               force it on the upper and on the lower body. `stall` and `div` say where a run gave up: with the much \
               softer body carrying lambda the iteration is not reliable, which is why `auto` is the default.",
    },
    Page {
        study: "effectivity",
        title: "Effectivity: the bound over the true error",
        text: "`e_CRE/‖u − u_p‖` for every problem, mesh and iteration, from lambda = 0 with the default settings until \
               `eta_nndd` has fallen by 1e-6; with EET alone, with two steps of relaxation (the default takes more if they pay), and with \
               relaxation until a step gains less than 0.002 (at most 50 steps). If the exact solution is known the \
               error is integrated. Elsewhere it is enclosed by a solution on a finer mesh that contains the coarse one, \
               whose certified error is stated (`tests/support/overkill.rs`): such effectivities are intervals, and their \
               upper ends are compared with the targets. Bounds whose checks fail are counted as refused, not measured. \
               All iterations: `effectivity.csv`. The study fails if a bound is below the error.",
    },
    Page {
        study: "adaptivity",
        title: "Uniform against adaptive meshes",
        text: "`certified_contact::solve_adaptively` with the default settings, from 18 × 9 cells per body, against \
               uniform meshes. A target is met when the certified relative error is at most as large. Times are wall times \
               of one run; the cost of a step includes refining towards its mesh. The last mesh alone is solved again \
               from lambda = 0. All meshes: `adaptivity.csv`.",
    },
    Page {
        study: "adversarial",
        title: "Attempts to prove a bound wrong",
        text: "Random problems made to break the bound (`tests/support/adversarial.rs`), each against an admissible field of a mesh with \
               four or sixteen times as many cells (`tests/support/witness.rs`). The exact solution `u` has the least potential energy \
               `J` of all admissible fields, so a field `w` with `2 (J(v) − J(w)) > e_CRE²` proves the bound of `v` wrong, however `w` was \
               found; the difference is computed without cancellation, in double-double arithmetic. A quarter of the runs stops after \
               one to four iterations, some use Newton's method.\n\n\
               - The columns `e_CRE` to `contact force` count violations. Intervals are violated if those of the two meshes do not meet. \
               `eta_nndd` is compared with the discrete solution that Newton's method finds with the bodies exchanged: the two must not \
               be farther apart than both bounds together, nor may that solution have less energy than `eta_nndd` allows.\n\
               - `a → b`: a violations at commit 21dceb3 (`before.csv`), b now (`violations.csv`).\n\
               - Effectivities are smallest / middle / largest of `e_CRE/√(2 (J(v) − J(w)))`. They are at most this: the finer field is \
               not exact, least of all on slivers and with contrasts: the last column shows how much of the largest is certain. \
               Two steps of relaxation were the default before; the next column is the default now.\n\
               - Stacked layers and slender bodies whose exact solution the mesh holds (`tests/support/stacks.rs`) are measured in \
               double-double arithmetic: nothing but round-off and the iteration is left of the error.\n\
               - The last table is of problems on which a stress is hard to make sharp (`tests/support/sharp.rs`), against the potential \
               energy by quadratic triangles on the same mesh and three finer ones, extrapolated (`tests/support/quadratic.rs`).\n\n\
               Every problem: `adversarial.csv` and `exact.csv`. The study fails if anything is violated.",
    },
    Page {
        study: "friction",
        title: "The bound with friction of Tresca",
        text: "Random problems (`tests/support/tresca.rs`): limits from zero to stick, moduli up to 1e4 apart, meshes that do not match, bent \
               and closed contact lines, bodies that only contact and friction hold. Each certified bound is compared with the distance to \
               the solution of a finer mesh, with twice as many cells in each direction, four times as many for every tenth problem: it \
               must not be larger (`tests/support/finer.rs`).\n\n\
               Effectivities are smallest / middle / largest of the bound over this distance, which is smaller than the true error. The \
               second table is for two blocks of 18 × 9 cells with the default settings, against a mesh with eight times as many cells in \
               each direction.\n\n\
               On bent lines a limit far above the friction costs sharpness: the lift of a contact node lets it slip a little, and the limit \
               times this slip enters the bound. Limits of 1e6 times the stress there give the largest effectivities.\n\n\
               Every problem: `friction.csv`. The study fails if a bound is below the distance.",
    },
];

/// Writes `bench-results/STUDY/` for each study.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<()> {
    let wanted = |page: &&Page| arguments.study.as_ref().is_none_or(|s| s == page.study);
    if PAGES.iter().filter(wanted).count() == 0 {
        let names = PAGES.map(|p| p.study).join(", ");
        return Err(format!("no such study; there are {names}"));
    }
    let mut build = workspace.cargo(&["build", "--release", "--workspace", "--bin", "reproduce"]);
    if stream(&mut build)? != Some(0) {
        return Err("the studies do not build".to_owned());
    }
    let commit =
        output(Command::new("git").args(["rev-parse", "--short", "HEAD"]).current_dir(&workspace.root))?;
    for page in PAGES.iter().filter(wanted) {
        write(workspace, page, commit.trim(), arguments.quick)?;
    }
    Ok(())
}

fn write(workspace: &Workspace, page: &Page, commit: &str, quick: bool) -> Outcome<()> {
    let folder = workspace.root.join("bench-results").join(page.study);
    let program = workspace.nndd().with_file_name("reproduce");
    let mut command = Command::new(program);
    command.arg(page.study).arg(&folder).current_dir(&workspace.root);
    if quick {
        command.arg("--quick");
    }
    let load = load();
    let tables = output(&mut command)?;
    let flag = if quick { " --quick" } else { "" };
    let text = format!(
        "# {}\n\nWritten by `cargo xtask reproduce {}{flag}` at commit {commit}, on {load}.\n\n{}\n\n{}\n",
        page.title,
        page.study,
        page.text,
        tables.trim_end()
    );
    let path = folder.join("README.md");
    std::fs::create_dir_all(&folder)
        .and_then(|()| std::fs::write(&path, text))
        .map_err(|e| format!("{}: {e}", workspace.shown(&path)))?;
    println!("wrote {}", workspace.shown(&path));
    Ok(())
}

/// Describes the machine as far as times depend on it: processors, and how busy they were before the run.
fn load() -> String {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let average = std::fs::read_to_string("/proc/loadavg").ok();
    let average = average.as_deref().and_then(|s| s.split_whitespace().next()).unwrap_or("unknown");
    format!("{processors} processors with a load of {average} before it began")
}

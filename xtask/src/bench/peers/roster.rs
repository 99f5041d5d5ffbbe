//! Who is compared, and how each is run on one mesh.

use super::super::process;
use super::THREADS;
use super::environment::{BASE, CHOLMOD, PARDISO, mkl, program};
use crate::python::Environment;
use crate::workspace::{Outcome, Workspace};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The executable of CalculiX.
const CALCULIX: &str = "ccx";

/// The task of a peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// Analysis, factorisation and one solve of the two stiffnesses: argument of `linear.py`.
    Linear(&'static str),
    /// The contact problem from assembly on: argument of `active_set.py`.
    ActiveSet(&'static str),
    /// The contact problem by CalculiX, as a whole process.
    CalculiX,
}

/// A program, or a way to use one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peer {
    pub(super) name: &'static str,
    pub(super) task: Task,
    /// Cells along the interface of the finest mesh it is run on.
    finest: usize,
    /// True if MKL's BLAS replaces the system's.
    on_mkl: bool,
}

const fn peer(name: &'static str, task: Task, finest: usize) -> Peer {
    Peer { name, task, finest, on_mkl: false }
}

/// PARDISO is first, so that it runs right after this program.
const PEERS: [Peer; 8] = [
    peer("PARDISO", Task::Linear("pardiso"), usize::MAX),
    peer("PARDISO, minimum degree", Task::Linear("pardiso-minimum-degree"), 1280),
    peer("CHOLMOD", Task::Linear("cholmod"), 640),
    peer("SuperLU", Task::Linear("superlu"), 320),
    peer("active set, CHOLMOD", Task::ActiveSet("cholmod"), 320),
    Peer { on_mkl: true, ..peer("active set, CHOLMOD on MKL's BLAS", Task::ActiveSet("cholmod"), 320) },
    peer("active set, SuperLU", Task::ActiveSet("superlu"), 320),
    peer("CalculiX", Task::CalculiX, 320),
];

impl Peer {
    /// Tells if it solves the same discrete problem as this program, so that the answers agree to round-off.
    pub(super) fn is_exact(&self) -> bool {
        matches!(self.task, Task::ActiveSet(_))
    }

    /// Tells if it solves the contact problem at all.
    pub(super) fn solves_contact(&self) -> bool {
        !matches!(self.task, Task::Linear(_))
    }

    pub(super) fn takes(&self, cells: [usize; 2]) -> bool {
        cells[0] <= self.finest
    }

    /// Why it cannot run here.
    fn hindrance(&self, environment: &Environment) -> Option<String> {
        let groups = match self.task {
            Task::Linear(name) if name.starts_with("pardiso") => vec![BASE, PARDISO],
            Task::Linear("cholmod") | Task::ActiveSet("cholmod") => vec![BASE, CHOLMOD],
            Task::Linear(_) | Task::ActiveSet(_) | Task::CalculiX => vec![BASE],
        };
        let missing = environment.missing.iter().find(|(name, _)| groups.contains(name));
        if let Some((group, reason)) = missing {
            return Some(format!("{group} {reason}"));
        }
        if self.task == Task::CalculiX && program(CALCULIX).is_none() {
            return Some(format!("no executable {CALCULIX}; `apt install calculix-ccx`"));
        }
        if self.on_mkl && mkl(environment).is_none() {
            return Some("no MKL in the environment".to_owned());
        }
        None
    }
}

/// The peers that can run here, and those that cannot with the reason.
pub(super) fn muster(environment: &Environment) -> (Vec<Peer>, Vec<String>) {
    let (mut able, mut skipped) = (vec![], vec![]);
    for peer in PEERS {
        match peer.hindrance(environment) {
            None => able.push(peer),
            Some(reason) => skipped.push(format!("{}: {reason}", peer.name)),
        }
    }
    (able, skipped)
}

/// One run of a peer.
#[derive(Clone, Debug)]
pub(in crate::bench) struct Answer {
    /// The time of its [`Task`].
    pub(in crate::bench) seconds: f64,
    /// Wall time of its process.
    pub(super) whole: f64,
    /// Memory in bytes: of the solver alone for [`Task::Linear`], of the process otherwise.
    pub(in crate::bench) memory: Option<f64>,
    /// Peak of its whole process, bytes.
    pub(in crate::bench) process_memory: Option<f64>,
    /// Everything else it says.
    pub(super) details: Value,
}

impl Answer {
    fn new(task: Task, run: &process::Run, details: Value) -> Self {
        let process_memory = run.memory.map(|kib| kib * 1024.0);
        let of_process = if task == Task::CalculiX { process_memory } else { None };
        let memory = details["memory_bytes"].as_f64().or(of_process);
        let seconds = details["seconds"].as_f64().unwrap_or(run.seconds);
        Self { seconds, whole: run.seconds, memory, process_memory, details }
    }
}

/// One linear solve of PARDISO with the stiffnesses of any even number of blocks, or of two boxes, each held by its supports, as one
/// block-diagonal matrix.
pub(in crate::bench) struct Pardiso<'a> {
    workspace: &'a Workspace,
    environment: Environment,
}

impl<'a> Pardiso<'a> {
    /// Installs it; says why not if that fails.
    pub(in crate::bench) fn new(workspace: &'a Workspace) -> Outcome<Self> {
        let environment = super::environment::make(workspace);
        match PEERS[0].hindrance(&environment) {
            None => Ok(Self { workspace, environment }),
            Some(reason) => Err(reason),
        }
    }

    /// Writes the matrix of some blocks.
    pub(in crate::bench) fn prepare(&self, cells: [usize; 2], bodies: usize) -> Outcome<()> {
        let runner = self.runner(cells);
        std::fs::create_dir_all(runner.folder()).map_err(|e| format!("the folder of PARDISO: {e}"))?;
        runner.python("linear.py", None, |command| {
            command.arg("matrix").args(cells.map(|n| n.to_string())).arg(runner.matrix());
            command.arg((bodies / 2).to_string());
        })?;
        Ok(())
    }

    /// Solves once in each of its two orders, and returns the seconds.
    pub(in crate::bench) fn run(&self, cells: [usize; 2]) -> Outcome<[f64; 2]> {
        let runner = self.runner(cells);
        let [first, second] = [0, 1].map(|k| runner.run(&PEERS[k]).map(|answer| answer.seconds));
        Ok([first?, second?])
    }

    /// Writes the matrix of two boxes with this many cubes of six tetrahedra along each edge, each held on one side.
    pub(in crate::bench) fn prepare_boxes(&self, cells: usize, matrix: &Path) -> Outcome<()> {
        let write = |command: &mut Command| {
            command.arg(cells.to_string()).arg(matrix);
        };
        self.runner([cells; 2]).python("boxes.py", None, write).map(|_| ())
    }

    /// Solves once with a written matrix: in its default order, or in the other one.
    pub(in crate::bench) fn solve(&self, matrix: &Path, other: bool) -> Outcome<Answer> {
        self.runner([0; 2]).linear(PEERS[usize::from(other)], matrix)
    }

    /// Names and versions of what is installed.
    pub(in crate::bench) fn versions(&self) -> String {
        self.environment.versions()
    }

    fn runner(&self, cells: [usize; 2]) -> Runner<'_> {
        Runner { workspace: self.workspace, environment: &self.environment, cells }
    }
}

/// Runs peers on one mesh.
pub(super) struct Runner<'a> {
    pub(super) workspace: &'a Workspace,
    pub(super) environment: &'a Environment,
    pub(super) cells: [usize; 2],
}

impl Runner<'_> {
    /// Writes what a task reads.
    pub(super) fn prepare(&self, peers: &[Peer]) -> Outcome<()> {
        let folder = self.folder();
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", self.workspace.shown(&folder)))?;
        if peers.iter().any(|p| matches!(p.task, Task::Linear(_))) {
            self.script("linear.py", &["matrix"], &self.matrix(), None)?;
        }
        if peers.iter().any(|p| p.task == Task::CalculiX) {
            self.script("calculix.py", &["deck"], &folder.join("job"), None)?;
        }
        Ok(())
    }

    /// Runs a peer once.
    pub(super) fn run(&self, peer: &Peer) -> Outcome<Answer> {
        let blas = if peer.on_mkl { mkl(self.environment) } else { None };
        let (run, details) = match peer.task {
            Task::Linear(_) => return self.linear(*peer, &self.matrix()),
            Task::ActiveSet(solver) => {
                let [nx, ny] = self.cells.map(|n| n.to_string());
                let run = self.python("active_set.py", blas.as_deref(), |c| {
                    c.args([solver, &nx, &ny]);
                })?;
                let details = json(&run.said)?;
                (run, details)
            }
            Task::CalculiX => {
                let ccx = program(CALCULIX).ok_or_else(|| format!("no executable {CALCULIX}"))?;
                let folder = self.folder();
                let run = process::run(peer.name, &ccx, |command| {
                    command.current_dir(&folder).arg("job").env("OMP_NUM_THREADS", THREADS.to_string());
                })?;
                let said = self.script("calculix.py", &["read"], &folder.join("job"), None)?;
                (run, json(&said)?)
            }
        };
        Ok(Answer::new(peer.task, &run, details))
    }

    /// Runs a linear solver once on a matrix.
    fn linear(&self, peer: Peer, matrix: &Path) -> Outcome<Answer> {
        let Task::Linear(solver) = peer.task else { return Err(format!("{} takes no matrix", peer.name)) };
        let run = self.python("linear.py", None, |c| {
            c.arg(solver).arg(matrix);
        })?;
        let details = json(&run.said)?;
        Ok(Answer::new(peer.task, &run, details))
    }

    fn folder(&self) -> PathBuf {
        self.workspace.target.join("peers").join(format!("{}x{}", self.cells[0], self.cells[1]))
    }

    fn matrix(&self) -> PathBuf {
        self.folder().join("stiffness.npz")
    }

    /// Runs a script with the mesh and a file as arguments, and returns what it prints.
    fn script(&self, name: &str, first: &[&str], file: &Path, blas: Option<&Path>) -> Outcome<String> {
        let run = self.python(name, blas, |c| {
            c.args(first).args(self.cells.map(|n| n.to_string())).arg(file);
        })?;
        Ok(run.said)
    }

    fn python(
        &self,
        name: &str,
        blas: Option<&Path>,
        prepare: impl Fn(&mut Command),
    ) -> Outcome<process::Run> {
        let script = self.workspace.root.join("xtask").join("peers").join(name);
        process::run(name, &self.environment.python(), |command| {
            // No compiled scripts beside the tracked ones.
            command.arg("-B").arg(&script);
            for variable in ["OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"] {
                command.env(variable, THREADS.to_string());
            }
            if let Some(library) = blas {
                // CHOLMOD calls a BLAS from its own threads; two sets of threads hinder each other badly.
                command.env("LD_PRELOAD", library).env("MKL_THREADING_LAYER", "SEQUENTIAL");
            }
            prepare(command);
        })
    }
}

fn json(said: &str) -> Outcome<Value> {
    serde_json::from_str(said.trim()).map_err(|e| format!("found {:?}, expected JSON: {e}", said.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_solvers_do_not_answer_the_contact_problem() {
        for peer in PEERS {
            assert_eq!(peer.solves_contact(), !matches!(peer.task, Task::Linear(_)), "{}", peer.name);
            assert!(peer.solves_contact() || !peer.is_exact(), "{}", peer.name);
            assert!(peer.takes([18, 9]), "{}", peer.name);
        }
        assert!(PEERS[0].takes([1280, 640]) && !PEERS[PEERS.len() - 1].takes([640, 320]));
    }

    #[test]
    fn answers_are_json() {
        assert!(json(" {\"seconds\": 1.5}\n").is_ok_and(|v| v["seconds"].as_f64() == Some(1.5)));
        assert!(json("Traceback").is_err());
    }
}

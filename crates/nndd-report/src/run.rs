//! From a case file to a solved problem.

use crate::adapt;
use crate::check;
use crate::convert;
use crate::failure::Failure;
use crate::host::{Event, Host};
use crate::memory;
use crate::outcome;
use crate::resume::RunDirectory;
use crate::run_observer::RunObserver;
use crate::solved::{RunResult, Solved};
use crate::steps;
use crate::stopwatch::Stopwatch;
use case_io::Case;
use case_io::case::Notes;
use case_io::case_file::split_override;
use case_io::output::Presence;
use fem_core::interface::ContactProblem;
use std::path::{Path, PathBuf};

/// Splits settings of the form `KEY=VALUE`.
///
/// # Errors
/// A text without a key or a value.
pub fn overrides(set: &[String]) -> Result<Vec<(String, String)>, Failure> {
    set.iter().map(|argument| split_override(argument).map_err(Failure::from)).collect()
}

/// A case that is read several times with other overrides: a file, or what a program keeps in memory.
pub trait Source {
    /// Parses the case alone.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn parse(&self, overrides: &[(String, String)]) -> Result<Case, Failure>;

    /// Parses the case and reads its meshes.
    ///
    /// # Errors
    /// Everything that is wrong with it, and with the meshes.
    fn read(&self, overrides: &[(String, String)]) -> Result<Case, Failure>;
}

/// A case file, read once.
pub struct CaseFile {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl CaseFile {
    /// Reads the bytes of a case file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let bytes = case_io::case_file::read(path).map_err(|e| Failure::unreadable(path, &e))?;
        Ok(Self { path: path.to_owned(), bytes })
    }
}

impl Source for CaseFile {
    fn parse(&self, overrides: &[(String, String)]) -> Result<Case, Failure> {
        Ok(Case::parse_bytes(&self.bytes, &self.path.to_string_lossy(), overrides)?)
    }

    fn read(&self, overrides: &[(String, String)]) -> Result<Case, Failure> {
        let mut case = self.parse(overrides)?;
        // Mesh files lie beside the case file.
        case.read_mesh_files(self.path.parent().unwrap_or(Path::new("")))?;
        Ok(case)
    }
}

/// Reads a case file with overrides, and the mesh files that it names.
///
/// # Errors
/// Files that cannot be read, and everything that is wrong with them.
pub fn read_case(file: &Path, overrides: &[(String, String)]) -> Result<Case, Failure> {
    CaseFile::open(file)?.read(overrides)
}

/// Makes the contact problem of a case, bodies in the file's order, if there is memory to solve it, and notes about it.
///
/// # Errors
/// A problem that makes no sense, or that needs too much memory.
pub fn build(case: &Case, host: &dyn Host) -> Result<(ContactProblem, Notes), Failure> {
    begins(case, "making the bodies and their contact lines", host);
    memory::check_counts(case, host)?;
    let (problem, notes) = case.build()?;
    memory::check_problem(case, &problem, host)?;
    Ok((problem, notes))
}

/// Tells the host that a step of a case begins that has no result to keep.
pub fn begins(case: &Case, step: &'static str, host: &dyn Host) {
    host.begins(step, case.limits.time.as_ref().map(|limit| limit.value));
}

/// Makes the contact problem of a case as [`build`] does, with the factors at the end of its last load step.
///
/// # Errors
/// See [`build`]; conditions that contradict each other with these factors.
pub fn build_last(case: &Case, host: &dyn Host) -> Result<(ContactProblem, Notes), Failure> {
    let (problem, notes) = build(case, host)?;
    let Some(factors) = case.step_ends().pop() else { return Ok((problem, notes)) };
    Ok((check::with_factors(case, &problem, &factors)?, notes))
}

/// Solves a case, adaptively if it has a target.
///
/// * `problem`, `notes`: the result of [`build`].
/// * `place`: where the meshes of an adaptive run are written to, and the state it resumes from.
///
/// # Errors
/// No unique solution, too little memory or time for a first result, files that cannot be written. How an iteration
/// ended is the status of the result.
pub fn solve(
    case: &Case,
    (problem, notes): (ContactProblem, Notes),
    place: &mut RunDirectory,
    watch: &mut Stopwatch,
    host: &mut dyn Host,
) -> Result<Solved, Failure> {
    let solved = match &case.adapt {
        None if !case.steps.is_empty() => steps::solve(case, problem, place, watch, host),
        None => solve_once(case, problem, place.presence(), watch, host),
        Some(adapt) => {
            let follower = RunObserver::new(case, watch, host, place.presence());
            adapt::solve(case, adapt, problem, follower, place)
        }
    };
    Ok(Solved { case_notes: notes, ..solved? })
}

/// Solves a case on its own mesh.
///
/// * `output`: the directory that must stay until the end.
pub(crate) fn solve_once(
    case: &Case,
    problem: ContactProblem,
    output: Presence,
    watch: &mut Stopwatch,
    host: &mut dyn Host,
) -> Result<Solved, Failure> {
    let mut follower = RunObserver::new(case, watch, host, output);
    let answer = if case.coulomb_pair().is_some() {
        let (settings, relaxation) = (convert::coulomb(case), convert::relaxation(case));
        let found = certified_contact::solve_coulomb(problem, &settings, relaxation, &mut follower);
        let result = found.map_err(|e| follower.failure(case, &e))?;
        follower.tell(Event::Iteration(&result.row()));
        RunResult::Coulomb(Box::new(result))
    } else {
        let found = certified_contact::solve(problem, &convert::settings(case), &mut follower);
        let solution = found.map_err(|e| follower.failure(case, &e))?;
        RunResult::Certified(Box::new(solution))
    };
    let status = outcome::judge_answer(case, &answer, follower.ended);
    Ok(Solved { longest_step: follower.longest, ..Solved::of(answer, status) })
}

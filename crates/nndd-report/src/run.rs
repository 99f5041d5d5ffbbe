//! From a case file to a solved problem.

use crate::adapt;
use crate::check;
use crate::failure::Failure;
use crate::host::Host;
use crate::memory::{self, Plan};
use crate::once;
use crate::resume::RunDirectory;
use crate::run_observer::RunObserver;
use crate::solved::Solved;
use crate::space::ReportSpace;
use crate::steps;
use crate::stopwatch::Stopwatch;
use case_io::Case;
use case_io::case::{AnyCase, Dimension, Notes};
use case_io::case_file::split_override;
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
    /// * `volumes`: whether its mesh files hold tetrahedra, see [`AnyCase::parse_as`].
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn parse(&self, overrides: &[(String, String)], volumes: bool) -> Result<AnyCase, Failure>;

    /// Parses the case and reads its meshes.
    ///
    /// # Errors
    /// Everything that is wrong with it, and with the meshes.
    fn read(&self, overrides: &[(String, String)]) -> Result<AnyCase, Failure>;
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
    fn parse(&self, overrides: &[(String, String)], volumes: bool) -> Result<AnyCase, Failure> {
        Ok(AnyCase::parse_as(&self.bytes, &self.path.to_string_lossy(), overrides, volumes)?)
    }

    fn read(&self, overrides: &[(String, String)]) -> Result<AnyCase, Failure> {
        // Mesh files lie beside the case file.
        let folder = self.path.parent().unwrap_or(Path::new(""));
        Ok(AnyCase::read(&self.bytes, &self.path.to_string_lossy(), overrides, folder)?)
    }
}

/// Reads a case file with overrides, and the mesh files that it names.
///
/// # Errors
/// Files that cannot be read, and everything that is wrong with them.
pub fn read_case(file: &Path, overrides: &[(String, String)]) -> Result<AnyCase, Failure> {
    CaseFile::open(file)?.read(overrides)
}

/// The contact problem of a case, ready to be solved.
pub struct Built<S: ReportSpace> {
    /// Bodies in the file's order.
    pub problem: ContactProblem<S>,
    /// On the case and its meshes.
    pub notes: Notes,
    /// How it is solved in the memory that there is.
    pub plan: Plan,
    /// See [`Plan::estimate`], bytes.
    pub memory: f64,
}

/// Makes the contact problem of a case, if there is memory to solve it.
///
/// # Errors
/// A problem that makes no sense, or that needs too much memory.
pub fn build<S: ReportSpace>(case: &Case<S>, host: &dyn Host) -> Result<Built<S>, Failure> {
    build_for(case, true, host)
}

/// * `planned`: whether it is solved in whatever way fits in memory, or in the one that it asks for.
fn build_for<S: ReportSpace>(case: &Case<S>, planned: bool, host: &dyn Host) -> Result<Built<S>, Failure> {
    begins(case, "making the bodies and their contact lines", host);
    memory::check_counts(case, planned, host)?;
    let (problem, mut notes) = case.build()?;
    let (plan, memory) = memory::plan(case, &problem, planned, host)?;
    notes.extend(plan.note(case));
    Ok(Built { problem, notes, plan, memory })
}

/// Tells the host that a step of a case begins that has no result to keep.
pub fn begins<S: Dimension>(case: &Case<S>, step: &'static str, host: &dyn Host) {
    host.begins(step, case.limits.time.as_ref().map(|limit| limit.value));
}

/// Makes the contact problem of a case as [`build`] does, with the factors at the end of its last load step, to be solved as the case asks for.
///
/// # Errors
/// See [`build`]; conditions that contradict each other with these factors.
pub fn build_last<S: ReportSpace>(case: &Case<S>, host: &dyn Host) -> Result<Built<S>, Failure> {
    let mut built = build_for(case, false, host)?;
    if let Some(factors) = case.step_ends().pop() {
        built.problem = check::with_factors(case, &built.problem, &factors)?;
    }
    Ok(built)
}

/// Solves a case: once, in load steps, or on meshes that become finer if it has a target.
///
/// * `built`: see [`build`].
/// * `place`: where the meshes of an adaptive run are written to, and the state it resumes from.
///
/// # Errors
/// No unique solution, too little memory or time for a first result, files that cannot be written. How an iteration
/// ended is the status of the result.
pub fn solve<S: ReportSpace>(
    case: &Case<S>,
    built: Built<S>,
    place: &mut RunDirectory,
    watch: &mut Stopwatch,
    host: &mut dyn Host,
) -> Result<Solved<S>, Failure> {
    let Built { problem, notes, plan, .. } = built;
    let solved = match &case.adapt {
        None if !case.steps.is_empty() => steps::solve((case, &plan), problem, place, watch, host)?,
        None => once::solve((case, &plan), problem, place.presence(), (watch, host))?,
        Some(adapt) => {
            let follower = RunObserver::new(case, watch, host, place.presence());
            adapt::solve((case, adapt, plan), problem, follower, place)?
        }
    };
    Ok(Solved { case_notes: notes, ..solved })
}

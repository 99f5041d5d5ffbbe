//! Runs a case file as the program does: read, build, solve, report, without a process.

use case_io::Case;
use case_io::case::AnyCase;
use case_io::report::Report;
use fem_core::interface::ContactProblem;
use fem_core::space::Plane;
use nndd_report::run::{self, Built, Source};
use nndd_report::{Event, Failure, Host, RunDirectory, Solved, Stopwatch, files};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A case in memory, its mesh files in a folder.
pub(super) struct CaseText {
    /// The case file.
    pub(super) text: String,
    /// The folder of its mesh files.
    pub(super) folder: PathBuf,
}

impl Source for CaseText {
    fn parse(&self, overrides: &[(String, String)], _: bool) -> Result<AnyCase, Failure> {
        Ok(AnyCase::parse(&self.text, "case.toml", overrides)?)
    }

    fn read(&self, overrides: &[(String, String)]) -> Result<AnyCase, Failure> {
        let mut case = self.parse(overrides, false)?;
        case.read_mesh_files(&self.folder)?;
        Ok(case)
    }
}

/// The program around a run, which may interrupt it after some meshes.
pub(super) struct Quiet {
    start: Instant,
    meshes: usize,
    /// Interrupts a run when this many meshes have been solved.
    pub(super) meshes_until_stop: usize,
}

impl Quiet {
    /// Starts the clock of a run that nothing interrupts.
    pub(super) fn new() -> Self {
        Self { start: Instant::now(), meshes: 0, meshes_until_stop: usize::MAX }
    }
}

impl Default for Quiet {
    fn default() -> Self {
        Self::new()
    }
}

impl Host for Quiet {
    fn elapsed(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn interrupted(&self) -> Option<u8> {
        (self.meshes >= self.meshes_until_stop).then_some(130)
    }

    fn event(&mut self, event: Event<'_>) -> Result<(), Failure> {
        if let Event::Step(_) = event {
            self.meshes += 1;
        }
        Ok(())
    }
}

/// A run that left a report.
pub(super) struct Done {
    /// The case.
    pub(super) case: Case,
    /// The problem on its first mesh.
    pub(super) problem: ContactProblem,
    /// The solution.
    pub(super) solved: Solved,
    /// Its report.
    pub(super) report: Report,
}

/// Runs a case into a folder.
///
/// # Errors
/// As the command: a refusal, or no first result.
pub(super) fn run(source: &CaseText, out: &Path, host: &mut Quiet) -> Result<Done, Failure> {
    let case = source.read(&[])?.into_plane()?;
    let built = run::build(&case, host)?;
    let place = RunDirectory::open(&case, out, true)?;
    finish(case, built, place, host)
}

/// Resumes the interrupted run of a case in a folder.
///
/// # Errors
/// As the command.
pub(super) fn resume(source: &CaseText, out: &Path) -> Result<Done, Failure> {
    let mut host = Quiet::new();
    let case = source.read(&[])?.into_plane()?;
    let built = run::build(&case, &host)?;
    let place = RunDirectory::resume(&case, out)?;
    finish(case, built, place, &mut host)
}

/// Runs a case into a folder and writes all its files.
///
/// # Errors
/// As the command.
pub(super) fn run_and_write(source: &CaseText, out: &Path, host: &mut Quiet) -> Result<Report, Failure> {
    let case = source.read(&[])?.into_plane()?;
    let built = run::build(&case, host)?;
    let mut place = RunDirectory::open(&case, out, true)?;
    let mut watch = Stopwatch::start(host.elapsed());
    let solved = run::solve(&case, built, &mut place, &mut watch, host)?;
    Ok(files::write(&case, &solved, place, serde_json::Map::new(), &mut watch, host)?.report)
}

fn finish(
    case: Case,
    built: Built<Plane>,
    mut place: RunDirectory,
    host: &mut Quiet,
) -> Result<Done, Failure> {
    let mut watch = Stopwatch::start(host.elapsed());
    let problem = built.problem.clone();
    let solved = run::solve(&case, built, &mut place, &mut watch, host)?;
    let report = files::report(&case, &solved, serde_json::Map::new());
    Ok(Done { case, problem, solved, report })
}

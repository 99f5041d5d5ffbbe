//! A solved case, and its arrays.

use crate::arrays;
use crate::job;
use case_io::Case;
use case_io::case::AnyCase;
use case_io::table::ContactRow;
use mesh_io::vtu::{VtuArray, VtuData, VtuMesh};
use nndd_report::memory_limit;
use nndd_report::notes::of_problem;
use nndd_report::run::{self, Built, Source};
use nndd_report::verdict::verdict;
use nndd_report::view::Picture;
use nndd_report::{Failure, Host, ReportSpace, RunDirectory, Solved, Stopwatch, check, files, view};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;

/// What a solution shows, of the plane or of solids.
pub(crate) trait Shown: Send + Sync {
    /// Returns the text of report.json, the verdict and the warnings.
    fn said(&self) -> (&str, &str, &[String]);
    /// Makes points, cells and sides of the last mesh of a body.
    fn mesh<'py>(&self, py: Python<'py>, body: usize) -> PyResult<Bound<'py, PyDict>>;
    /// Makes a field of a body.
    fn field(&self, body: usize, name: &str) -> Option<VtuArray>;
    /// Makes the rows of contact.csv of a pair.
    fn contact(&self, pair: usize) -> Vec<ContactRow>;
    /// Makes the edges or faces of a pair with all fields.
    fn contact_grid(&self, pair: usize) -> Option<(VtuMesh, VtuData)>;
    /// Draws the figures.
    fn pictures(&self) -> Vec<Picture>;
    /// Writes what the command writes; returns the names of the files.
    fn save(&self, directory: &Path, force: bool, host: &mut dyn Host) -> Result<Vec<String>, Failure>;
}

/// The result of a run, with the data to write its files.
struct Run<S: ReportSpace> {
    case: Case<S>,
    solved: Solved<S>,
    watch: Stopwatch,
    about: Map<String, Value>,
    /// Contents of report.json.
    report: String,
    verdict: String,
    warnings: Vec<String>,
    kept: Kept,
}

/// The files that a run of several meshes or load steps wrote on its way. A forked process does not remove them.
struct Kept {
    files: Option<(RunDirectory, TempDir)>,
    process: u32,
}

impl Drop for Kept {
    fn drop(&mut self) {
        if self.process != std::process::id() {
            std::mem::forget(self.files.take());
        }
    }
}

impl<S: ReportSpace> Shown for Run<S> {
    fn said(&self) -> (&str, &str, &[String]) {
        (&self.report, self.verdict.trim(), &self.warnings)
    }

    fn mesh<'py>(&self, py: Python<'py>, body: usize) -> PyResult<Bound<'py, PyDict>> {
        arrays::mesh(py, view::problem(&self.solved).bodies[body].mesh())
    }

    fn field(&self, body: usize, name: &str) -> Option<VtuArray> {
        view::field(&self.case, &self.solved, body, name)
    }

    fn contact(&self, pair: usize) -> Vec<ContactRow> {
        view::contact(&self.solved, pair)
    }

    fn contact_grid(&self, pair: usize) -> Option<(VtuMesh, VtuData)> {
        view::contact_grid(&self.solved, pair)
    }

    fn pictures(&self) -> Vec<Picture> {
        let report = files::report(&self.case, &self.solved, self.about.clone());
        view::pictures(&self.case, &self.solved, &report)
    }

    fn save(&self, directory: &Path, force: bool, host: &mut dyn Host) -> Result<Vec<String>, Failure> {
        let mut place = RunDirectory::open(&self.case, directory, force)?;
        if let Some((earlier, _)) = &self.kept.files {
            place.copy_from(earlier)?;
        }
        let mut about = self.about.clone();
        about.insert("output".into(), directory.display().to_string().into());
        let mut watch = self.watch.clone();
        Ok(files::write(&self.case, &self.solved, place, about, &mut watch, host)?.files)
    }
}

/// Solves a case as the command does, in a temporary directory.
pub(crate) fn solve(
    source: &dyn Source,
    set: &[String],
    host: &mut dyn Host,
) -> Result<Arc<dyn Shown>, Failure> {
    let watch = Stopwatch::start(host.elapsed());
    let started = humantime::format_rfc3339_nanos(std::time::SystemTime::now()).to_string();
    let mut about = Map::new();
    about.insert("host".into(), memory_limit::host().into());
    about.insert("threads".into(), rayon::current_num_threads().into());
    about.insert("overrides".into(), set.into());
    about.insert("started".into(), started.into());
    Ok(match source.read(&run::overrides(set)?)? {
        AnyCase::Plane(case) => Arc::new(run_case(*case, about, watch, host)?),
        AnyCase::Solid(case) => Arc::new(run_case(*case, about, watch, host)?),
    })
}

fn run_case<S: ReportSpace>(
    case: Case<S>,
    mut about: Map<String, Value>,
    mut watch: Stopwatch,
    host: &mut dyn Host,
) -> Result<Run<S>, Failure> {
    let mut built = run::build(&case, host)?;
    run::begins(&case, "the question whether the bodies are held", host);
    check::held(&case, &mut built.problem)?;
    let warnings = case.warnings().iter().map(ToString::to_string).collect();
    about.insert("memory_estimate".into(), built.memory.round().into());
    let folder = tempfile::tempdir()?;
    let mut place = RunDirectory::open(&case, folder.path(), false)?;
    let solved = run::solve(&case, built, &mut place, &mut watch, host)?;
    about.insert("memory_peak".into(), memory_limit::peak().into());
    let mut report = files::report(&case, &solved, about.clone());
    report.timings = watch.read(host.elapsed());
    let verdict = verdict(&report);
    let report = report.to_json()?;
    let in_parts = case.adapt.is_some() || !case.steps.is_empty();
    let kept = Kept { files: in_parts.then_some((place, folder)), process: std::process::id() };
    Ok(Run { case, solved, watch, about, report, verdict, warnings, kept })
}

/// A solved case.
#[pyclass(frozen, module = "nndd._nndd")]
pub(crate) struct Solution {
    run: Arc<dyn Shown>,
}

impl Solution {
    pub(crate) fn new(run: Arc<dyn Shown>) -> Self {
        Self { run }
    }
}

#[pymethods]
impl Solution {
    /// Returns the text of report.json.
    fn report(&self) -> &str {
        self.run.said().0
    }

    /// Returns two sentences: how the run ended, and what is certified.
    fn verdict(&self) -> &str {
        self.run.said().1
    }

    /// Lists what is allowed in the case and probably not meant.
    fn warnings(&self) -> Vec<String> {
        self.run.said().2.to_vec()
    }

    /// Returns points, cells and sides of the last mesh of a body.
    fn mesh<'py>(&self, py: Python<'py>, body: usize) -> PyResult<Bound<'py, PyDict>> {
        self.run.mesh(py, body)
    }

    /// Returns a field of a body; `None` without an estimate, and if it is unknown.
    fn field<'py>(&self, py: Python<'py>, body: usize, name: String) -> PyResult<Option<Bound<'py, PyAny>>> {
        let run = Arc::clone(&self.run);
        let made = job::run(py, 0, None, move |_| Ok(run.field(body, &name)))?;
        made.map(|field| arrays::field(py, field)).transpose()
    }

    /// Returns the columns of contact.csv of a pair.
    fn contact<'py>(&self, py: Python<'py>, pair: usize) -> PyResult<Bound<'py, PyDict>> {
        let run = Arc::clone(&self.run);
        let rows = job::run(py, 1, None, move |_| Ok(run.contact(pair)))?;
        let dict = PyDict::new(py);
        let put = |name: &str, of: &dyn Fn(&ContactRow) -> Option<f64>| {
            let values: Option<Vec<f64>> = rows.iter().map(of).collect();
            values.map_or(Ok(()), |values| dict.set_item(name, PyArray1::from_vec(py, values)))
        };
        put("s", &|row| row.s)?;
        put("x", &|row| Some(row.x))?;
        put("y", &|row| Some(row.y))?;
        put("z", &|row| row.z)?;
        put("gap", &|row| Some(row.gap))?;
        put("opening", &|row| Some(row.opening))?;
        put("pressure", &|row| Some(row.pressure))?;
        put("pressure_recovered", &|row| row.pressure_recovered)?;
        let in_space: Option<Vec<[[f64; 3]; 2]>> =
            rows.iter().map(|row| row.friction.as_ref()?.in_space).collect();
        match in_space.filter(|_| !rows.is_empty()) {
            // Vectors of solids, one row per pair of nodes.
            Some(vectors) => {
                for (place, name) in ["tangential", "slip"].into_iter().enumerate() {
                    let values: Vec<Vec<f64>> = vectors.iter().map(|both| both[place].to_vec()).collect();
                    dict.set_item(name, PyArray2::from_vec2(py, &values)?)?;
                }
            }
            None => {
                put("tangential", &|row| Some(row.friction.as_ref()?.tangential))?;
                put("slip", &|row| Some(row.friction.as_ref()?.slip))?;
            }
        }
        put("limit", &|row| Some(row.friction.as_ref()?.limit))?;
        dict.set_item("active", PyArray1::from_iter(py, rows.iter().map(|row| row.active != 0)))?;
        let states: Option<Vec<&str>> =
            rows.iter().map(|row| Some(row.friction.as_ref()?.state.as_str())).collect();
        if let Some(states) = states {
            dict.set_item("state", PyList::new(py, states)?)?;
        }
        Ok(dict)
    }

    /// Returns points, cells and fields of the edges or faces of a pair; `None` without an estimate.
    fn contact_grid<'py>(&self, py: Python<'py>, pair: usize) -> PyResult<Option<Bound<'py, PyDict>>> {
        let run = Arc::clone(&self.run);
        let made = job::run(py, 1, None, move |_| Ok(run.contact_grid(pair)))?;
        made.map(|(mesh, data)| arrays::grid(py, mesh, data)).transpose()
    }

    /// Draws the figures: name, SVG and caption of each.
    fn figures(&self, py: Python<'_>) -> PyResult<Vec<[String; 3]>> {
        let run = Arc::clone(&self.run);
        let made = job::run(py, 0, None, move |_| Ok(run.pictures()))?;
        Ok(made.into_iter().map(|picture| [picture.name, picture.svg, picture.caption]).collect())
    }

    /// Writes what the command writes; returns the names of the files.
    fn save(&self, py: Python<'_>, directory: PathBuf, force: bool) -> PyResult<Vec<String>> {
        let run = Arc::clone(&self.run);
        job::run(py, 0, None, move |host| run.save(&directory, force, host))
    }
}

/// Checks a case; returns what `nndd check --format json` prints.
pub(crate) fn check(source: &dyn Source, set: &[String], host: &dyn Host) -> Result<Value, Failure> {
    match source.read(&run::overrides(set)?)? {
        AnyCase::Plane(case) => check_case(&case, host),
        AnyCase::Solid(case) => check_case(&case, host),
    }
}

fn check_case<S: ReportSpace>(case: &Case<S>, host: &dyn Host) -> Result<Value, Failure> {
    let Built { problem, mut notes, memory, .. } = run::build(case, host)?;
    notes.extend(of_problem(case, &problem));
    run::begins(case, "the checks of loads, supports and free motions", host);
    let bodies = nndd_report::check::check(case, &problem)?;
    Ok(nndd_report::check::summary(case, &problem, &bodies, &notes, memory))
}

//! The native part of the Python package `nndd`: cases in, arrays out. It has no algorithm of its own.
//!
//! ```text
//! python/nndd: dict ─► tree: keys, meshes, functions ─► source ─► case_io::Case ─► nndd_report::run ─► solution: arrays
//!                                                       job: threads, callbacks, signals
//! ```

mod arrays;
mod errors;
mod job;
mod json;
mod solution;
mod source;
mod tree;

use arrays::Rows;
use case_io::case::{AnyCase, is_solid_generator, mesh_of_generator, solid_mesh_of_generator};
use fem_core::body::Body;
use fem_core::space::{Plane, Solid};
use json::loads;
use mesh_io::{MeshFile, RegionOptions};
use nndd_report::run::{self, Source};
use nndd_report::sweep::{SweepOptions, sweep_of};
use nndd_report::{Failure, ReportSpace, certify, view};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use serde_json::Value;
use solution::Solution;
use source::{File, Keys};
use std::path::PathBuf;
use std::sync::Arc;
use tree::{Reading, Settings};

/// The mesh of a body, and the density of the squared error in its cells.
type Density = (Py<PyDict>, Py<PyAny>);

/// Makes the arrays of the densities of all bodies.
type Densities = Box<dyn FnOnce(Python<'_>) -> PyResult<Vec<Density>> + Send>;

/// A case: a file, or a dict with meshes and data.
#[pyclass(frozen, module = "nndd._nndd")]
struct Case {
    source: Arc<dyn Source + Send + Sync>,
}

impl Case {
    /// Runs work on the case.
    fn work<T: Send + 'static>(
        &self,
        py: Python<'_>,
        threads: usize,
        callback: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&dyn Source, &mut job::Caller) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let source = Arc::clone(&self.source);
        job::run(py, threads, callback, move |host| work(&*source, host))
    }
}

#[pymethods]
impl Case {
    /// Makes a case of a dict.
    #[staticmethod]
    fn keys(keys: &Bound<'_, PyMapping>) -> PyResult<Self> {
        let mut reading = Reading::default();
        let table = reading.table(keys, "")?;
        Ok(Self { source: Arc::new(Keys { table, meshes: Arc::new(reading.into_meshes()) }) })
    }

    /// Makes a case of a case file.
    #[staticmethod]
    fn file(path: PathBuf) -> Self {
        Self { source: Arc::new(File(path)) }
    }

    /// Solves it.
    #[pyo3(signature = (set, threads, callback))]
    fn solve(
        &self,
        py: Python<'_>,
        set: Settings,
        threads: usize,
        callback: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Solution> {
        let run = self.work(py, threads, callback.as_ref(), move |source, host| {
            solution::solve(source, &set.0, host)
        })?;
        Ok(Solution::new(run))
    }

    /// Checks it; returns what `nndd check --format json` prints.
    fn check<'py>(&self, py: Python<'py>, set: Settings, threads: usize) -> PyResult<Bound<'py, PyAny>> {
        let found =
            self.work(py, threads, None, move |source, host| solution::check(source, &set.0, host))?;
        loads(py, &found)
    }

    /// Compares values of one setting; returns the contents of sweep.json.
    #[pyo3(signature = (over, set, iterations, panel, out, force, threads, callback))]
    #[expect(clippy::too_many_arguments, reason = "the options of the command")]
    fn sweep(
        &self,
        py: Python<'_>,
        over: String,
        set: Settings,
        iterations: usize,
        panel: Vec<String>,
        out: Option<PathBuf>,
        force: bool,
        threads: usize,
        callback: Option<Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        self.work(py, threads, callback.as_ref(), move |source, host| {
            let folder = tempfile::tempdir()?;
            let mut options = SweepOptions::new("".as_ref(), &over);
            (options.set, options.iterations, options.panel, options.force) =
                (set.0, iterations, panel, force);
            options.out = Some(out.unwrap_or_else(|| folder.path().to_owned()));
            let swept = sweep_of(source, &options, host)?;
            swept.failure.map_or(Ok(()), Err)?;
            Ok(swept.record.to_json()?)
        })
    }

    /// Bounds the error of displacements; returns numbers, and by body the mesh and the density of the squared error.
    #[pyo3(signature = (set, displacements, pressures, threads))]
    fn certify<'py>(
        &self,
        py: Python<'py>,
        set: Settings,
        displacements: Vec<Bound<'py, PyArray2<f64>>>,
        pressures: Option<Vec<Bound<'py, PyArray1<f64>>>>,
        threads: usize,
    ) -> PyResult<(Bound<'py, PyAny>, Vec<Density>)> {
        let fields = displacements.iter().map(Rows::read).collect::<PyResult<Vec<_>>>()?;
        let pressures = pressures
            .map(|all| all.iter().map(|array| Ok(array.to_vec()?)).collect::<PyResult<Vec<Vec<f64>>>>())
            .transpose()?;
        let (numbers, densities) = self.work(py, threads, None, move |source, host| {
            match source.read(&run::overrides(&set.0)?)? {
                AnyCase::Plane(case) => certified(&case, &fields, pressures, host),
                AnyCase::Solid(case) => certified(&case, &fields, pressures, host),
            }
        })?;
        Ok((loads(py, &numbers)?, densities(py)?))
    }

    /// Returns points, triangles and sides of the mesh of a body, as the case describes it.
    fn mesh<'py>(&self, py: Python<'py>, body: usize) -> PyResult<Bound<'py, PyDict>> {
        match self.work(py, 1, None, move |source, _| source.read(&[]))? {
            AnyCase::Plane(case) => mesh_of(py, case, body),
            AnyCase::Solid(case) => mesh_of(py, case, body),
        }
    }
}

/// Certifies displacements in memory; returns numbers, and what makes the arrays of the densities.
fn certified<S: ReportSpace>(
    case: &case_io::Case<S>,
    fields: &[Rows],
    mut pressures: Option<Vec<Vec<f64>>>,
    host: &mut job::Caller,
) -> Result<(Value, Densities), Failure> {
    let problem = run::build_last(case, host)?.problem;
    let mut fields = fields.iter().map(Rows::vectors::<S>).collect::<Result<Vec<_>, _>>()?;
    let bodies = (0..).zip(&mut fields);
    bodies.for_each(|(body, field)| source::to_mesh(case, body, field, S::Vector::default()));
    let firsts = case.contacts.iter().filter_map(|contact| contact.bodies.first());
    let pairs = firsts.zip(pressures.iter_mut().flatten());
    pairs.for_each(|(body, pressure)| source::to_mesh(case, *body, pressure, 0.0));
    run::begins(case, "the certificate of the field", host);
    let found = certify::of_fields(case, &problem, &fields, pressures.as_deref())?;
    let numbers = certify::summary(case, &found);
    let densities = move |py: Python<'_>| {
        let bodies = problem.bodies.iter().zip(&found.estimate.cre.by_cell);
        let of_body = |(body, cells): (&Body<S>, &Vec<f64>)| {
            let mesh = body.mesh();
            let density = cells.iter().enumerate().map(|(t, squared)| squared / mesh.measure(t));
            Ok((arrays::mesh(py, mesh)?.unbind(), PyArray1::from_iter(py, density).into_any().unbind()))
        };
        bodies.map(of_body).collect()
    };
    Ok((numbers, Box::new(densities)))
}

/// Makes the mesh of a generator, given by its keys.
#[pyfunction]
fn generate<'py>(py: Python<'py>, keys: &Bound<'py, PyMapping>) -> PyResult<Bound<'py, PyDict>> {
    let keys = Reading::default().table(keys, "generator")?;
    if is_solid_generator(&keys) {
        return arrays::mesh(py, &job::run(py, 1, None, move |_| Ok(solid_mesh_of_generator(&keys)?))?);
    }
    arrays::mesh(py, &job::run(py, 1, None, move |_| Ok(mesh_of_generator(&keys)?))?)
}

/// Makes the arrays of the mesh of a body.
fn mesh_of<S: ReportSpace>(
    py: Python<'_>,
    case: Box<case_io::Case<S>>,
    body: usize,
) -> PyResult<Bound<'_, PyDict>> {
    arrays::mesh(py, &job::run(py, 1, None, move |_| Ok(case.mesh_of(body)?))?)
}

/// Reads a mesh file: points, triangles or tetrahedra, edges or faces by side, numbers of cells by region; and notes.
#[pyfunction]
fn read_mesh(py: Python<'_>, path: PathBuf) -> PyResult<(Bound<'_, PyDict>, Vec<String>)> {
    let file = job::run(py, 1, None, move |_| Ok(mesh_io::read(&path)?))?;
    if file.has_volumes() { whole::<Solid>(py, file) } else { whole::<Plane>(py, file) }
}

/// Takes all cells of a mesh file that are in a group; all cells if there is no group.
fn whole<S: ReportSpace>(py: Python<'_>, file: MeshFile) -> PyResult<(Bound<'_, PyDict>, Vec<String>)> {
    let (region, regions) = job::run(py, 1, None, move |_| {
        let dimension = S::DIM as u8;
        let names: Vec<&str> = file.group_names(dimension).collect();
        let region = S::region(&file, &names, RegionOptions::default())?;
        let cells = names.iter().map(|name| {
            let numbers = file.cells_of_group(dimension, name).unwrap_or_default();
            let is_inside = |t: &usize| numbers.binary_search(&region.cell_numbers()[*t]).is_ok();
            let inside = (0..region.cells().len()).filter(is_inside);
            ((*name).to_owned(), inside.map(|t| t as i64).collect())
        });
        let cells: Vec<(String, Vec<i64>)> = cells.collect();
        Ok((region, cells))
    })?;
    let sides = region.sides().map(|(name, facets)| {
        (name, facets.iter().flat_map(|facet| facet.as_ref().iter().copied().map(i64::from)).collect())
    });
    let corners =
        region.cells().iter().flat_map(|cell| cell.as_ref().iter().copied().map(i64::from)).collect();
    let made = arrays::of_parts::<S>(py, region.points(), corners, sides)?;
    let cells = PyDict::new(py);
    for (name, numbers) in regions {
        cells.set_item(name, PyArray1::from_vec(py, numbers))?;
    }
    made.set_item("regions", cells)?;
    Ok((made, region.notes().to_vec()))
}

/// The native module.
#[pymodule]
fn _nndd(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("POINT_FIELDS", view::POINT_FIELDS)?;
    module.add("CELL_FIELDS", view::CELL_FIELDS)?;
    module.add_class::<Case>()?;
    module.add_class::<Solution>()?;
    module.add_function(wrap_pyfunction!(generate, module)?)?;
    module.add_function(wrap_pyfunction!(read_mesh, module)?)
}

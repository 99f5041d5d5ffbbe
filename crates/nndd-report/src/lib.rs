//! Runs cases of the contact solver and writes what they found: everything of the command `nndd` but its command line.
//!
//! ```text
//! case.toml ─ read_case ─► Case ─ build ─► ContactProblem ─ check ─► CheckedBody …
//!                                               └─ solve ─► Solved ─ write ─► report.json, report.html, figures, tables, .vtu
//! case.toml, SweepOptions ─ sweep ─► Swept, and sweep.json, sweep.csv, figures
//! ```
//! | to | use |
//! |---|---|
//! | read a case file with its meshes | [`run::read_case`] |
//! | look at it without solving | [`run::build`], [`check::check`], [`notes`], [`memory::Plan`] |
//! | look at the sides of a mesh file, and which face each other | [`mesh_file::sides`] |
//! | choose the directory, or resume an adaptive run | [`RunDirectory::open`], [`RunDirectory::resume`] |
//! | solve, adaptively if the case has a target | [`run::solve`] |
//! | write everything, the report last | [`files::write`] |
//! | look at the result in memory | [`files::report`], [`view`] |
//! | say how it ended, in two sentences | [`verdict::verdict`] |
//! | compare values of one setting | [`sweep::sweep`] |
//! | compare two runs | [`compare::compare`] |
//! | bound the error of another code's field | [`certify::certify`], [`certify::of_fields`] |
//! | answer how much memory there is, as a [`Host`] | [`memory_limit::smallest`] |
//! | convert the settings of a case to the library's | [`convert::settings`] |
//!
//! Nothing is printed here, no signal and no clock is read, and the process is never ended. A run gets everything
//! from outside by a [`Host`]: the time, the wish to end, the free memory. It tells the host what happens by [`Event`]s.
//! A run that ends without a result is a [`Failure`], with the exit status of the command and the words for it.
//!
//! # Example
//! ```
//! use nndd_report::{Failure, Host, RunDirectory, Stopwatch, files, run};
//!
//! struct Quiet(std::time::Instant);
//!
//! impl Host for Quiet {
//!     fn elapsed(&self) -> f64 {
//!         self.0.elapsed().as_secs_f64()
//!     }
//! }
//!
//! # fn example(file: &std::path::Path, out: &std::path::Path) -> Result<(), Failure> {
//! let mut host = Quiet(std::time::Instant::now());
//! let mut watch = Stopwatch::start(host.elapsed());
//! let case = run::read_case(file, &run::overrides(&["output.vtu=false".to_owned()])?)?.into_plane()?;
//! let built = run::build(&case, &host)?;
//! let mut place = RunDirectory::open(&case, out, false)?;
//! let solved = run::solve(&case, built, &mut place, &mut watch, &mut host)?;
//! let written = files::write(&case, &solved, place, serde_json::Map::new(), &mut watch, &host)?;
//! assert_eq!((written.report.status.word.as_str(), written.report.valid_certificate().is_some()), ("converged", true));
//! assert!(written.files.contains(&"report.html".to_owned()));
//! # Ok(()) }
//! # let folder = tempfile::tempdir().unwrap();
//! # let file = folder.path().join("paper.toml");
//! # std::fs::write(&file, case_io::template::PAPER).unwrap();
//! # example(&file, &folder.path().join("out")).unwrap_or_else(|failure| panic!("{failure:?}"));
//! ```

mod adapt;
mod body_fields;
pub mod certify;
pub mod check;
pub mod compare;
pub mod convert;
mod corners;
mod curves;
mod deadline;
pub mod failure;
mod figures;
pub mod files;
mod host;
mod html;
pub mod memory;
pub mod memory_limit;
pub mod mesh_file;
mod motion;
mod nodal;
pub mod notes;
mod once;
mod outcome;
mod paraview;
mod paths;
mod plane;
mod plot;
mod render;
pub mod report;
mod resume;
pub mod run;
mod run_observer;
mod settings;
mod solid;
mod solved;
mod space;
mod steps;
mod stopwatch;
mod stress_limits;
pub mod sweep;
pub mod verdict;
pub mod view;
pub mod words;

pub use adapt::{adaptive_row, without_bound};
pub use deadline::Deadline;
pub use failure::Failure;
pub use host::{Event, Host, MemoryLimit};
pub use outcome::NOT_CONVERGED;
pub use resume::RunDirectory;
pub use solved::{RunResult, Solved, SolvedStep};
pub use space::ReportSpace;
pub use stopwatch::Stopwatch;

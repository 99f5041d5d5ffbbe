//! Case files, checkpoints, reports and tables of the contact solver. Meshes and ParaView files come from [`mesh_io`].
//!
//! # The way data flows
//! ```text
//! case.toml ─► case_file ─► Case ─► ContactProblem, notes                  (fem-core)
//! .msh, .inp ─► mesh_io::Region ─► TriMesh                                   (fem-core)
//! Report ─► report.json      IterationRow, ContactRow, SweepRow ─► .csv
//!                            all of them through one OutputDirectory
//! ```
//! | to | use |
//! |---|---|
//! | read a case file, with overrides | [`Case::parse`], [`case_file::split_override`] |
//! | read the mesh files it names | [`Case::read_mesh_files`] |
//! | evaluate data in x and y | [`Expression`] |
//! | vary one setting | [`case_file::Sweep`] |
//! | say what is wrong with it, and where | [`CaseError`], [`Diagnostic`], [`SourcePosition`] |
//! | make the contact problem of it, with notes | [`Case::build`] |
//! | record every setting, name the case | [`Case::settings_json`], [`Case::hash`] |
//! | write what a run found | [`report::Report`], [`table`] |
//! | write it safely | [`output::OutputDirectory`] |
//! | resume an adaptive run | [`checkpoint`] |
//! | start from something | [`template`] |
//!
//! Solver settings leave this crate as plain typed tables; it knows no solver. Numbers that are not finite are
//! refused on the way in and on the way out.
//!
//! # Example
//! ```
//! use case_io::{Case, case_file::split_override, template};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let overrides = [split_override("solver.theta=0.45")?, split_override("body.0.generator.cells=[4, 2]")?,
//!     split_override("body.1.generator.cells=[4, 2]")?];
//! let case = Case::parse(template::PAPER, "paper.toml", &overrides)?;
//! let (problem, notes) = case.build()?;
//! assert_eq!((problem.node_pairs(), notes.len()), (5, 0));
//!
//! // A misspelt key is found, with its place and the key that was meant.
//! let error = Case::parse(template::PAPER, "paper.toml", &[split_override("solver.theata=0.45")?]).unwrap_err();
//! let said = error.to_string();
//! assert!(said.starts_with("--set solver.theata=0.45: unknown key `theata` in `solver`; expected only the keys `method`"));
//! assert!(said.ends_with("; help: did you mean `theta`?"));
//! # Ok(()) }
//! ```

pub mod case;
pub mod case_file;
pub mod checkpoint;
pub mod diagnostic;
pub mod expression;
pub mod output;
pub mod report;
pub mod table;
pub mod template;

pub use case::Case;
pub use diagnostic::{CaseError, Diagnostic, Source, SourcePosition};
pub use expression::{Expression, ExpressionError};
pub use mesh_io::BrokenLink;

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

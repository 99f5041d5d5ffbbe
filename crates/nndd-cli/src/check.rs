//! `nndd check`: every check that needs no factorisation.

use crate::args::Check;
use crate::console;
use crate::failure::Failure;
use crate::memory::{self, mebibytes};
use crate::notes;
use crate::run;
use crate::words::counted;
use case_io::Case;
use certified_contact::SolveError;
use fem_core::assembly::AssemblyError;
use fem_core::body::NodeConstraint;
use fem_core::interface::ContactProblem;
use fem_core::prepared::PrepareError;
use std::fmt::Write as _;

pub(crate) fn command(options: &Check) -> Result<u8, Failure> {
    let (_, mut case) = run::read_case(&options.case, &run::overrides(&options.case.set)?)?;
    let problem = run::build(&mut case)?;
    console::warnings(&case.warnings());
    console::notes(case.notes());
    console::notes(&notes::of_problem(&case, problem.bodies.each_ref(), problem.interpolated_gap()));
    supports(&case, &problem)?;
    let mut text = console::header(&case, &problem, &case.output_directory());
    for (body, model) in case.bodies.iter().zip(&problem.bodies) {
        let mesh = model.mesh();
        let groups: Vec<String> = mesh
            .groups()
            .iter()
            .map(|(name, edges)| format!("{name} ({})", counted(edges.len(), "edge")))
            .collect();
        let held = model.node_constraints().iter().filter(|c| **c != NodeConstraint::Free).count();
        let _ = writeln!(text, "\n  body \"{}\"", body.name);
        let _ = writeln!(text, "    edge groups     {}", groups.join(", "));
        let _ = writeln!(
            text,
            "    supports        {} on {}",
            counted(model.supports().len(), "condition"),
            counted(held, "node")
        );
        let _ = writeln!(text, "    loads           {}", counted(body.tractions.len(), "condition"));
        let _ = writeln!(text, "    smallest angle  {:.1} degrees", mesh.smallest_angle());
    }
    let _ = writeln!(text, "\n  memory estimate {}", mebibytes(memory::estimate(&problem)));
    text += "  ok: no problem found\n";
    console::print(&text)?;
    Ok(0)
}

/// Refuses bodies that can move freely, before anything is computed or written.
pub(crate) fn supports(case: &Case, problem: &ContactProblem) -> Result<(), Failure> {
    for (body, model) in problem.bodies.iter().enumerate() {
        if let Some(motion) = model.free_motion() {
            let source = AssemblyError::Floating { motion };
            return Err(Failure::solve(case, &SolveError::Prepare(PrepareError::Assembly { body, source })));
        }
    }
    Ok(())
}

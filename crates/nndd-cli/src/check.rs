//! `nndd check`: every check that needs no factorisation.

use crate::args::Check;
use crate::console;
use crate::machine::Machine;
use nndd_report::memory::{self, mebibytes};
use nndd_report::words::counted;
use nndd_report::{Failure, notes, run};
use std::fmt::Write as _;

pub(crate) fn command(options: &Check) -> Result<u8, Failure> {
    let mut case = run::read_case(&options.case.case, &run::overrides(&options.case.set)?)?;
    let problem = run::build(&mut case, &Machine::start())?;
    console::warnings(&case.warnings());
    console::notes(case.notes());
    console::notes(&notes::of_problem(&case, &problem));
    let bodies = nndd_report::check::check(&case, &problem)?;
    let mut text = console::header(&case, &problem, &case.output_directory());
    for body in bodies {
        let sides: Vec<String> =
            body.sides.iter().map(|(name, edges)| format!("{name} ({})", counted(*edges, "edge"))).collect();
        let [supports, loads] = [body.supports, body.loads].map(|count| counted(count, "condition"));
        let _ = writeln!(text, "\n  body \"{}\"", body.name);
        let _ = writeln!(text, "    edge groups     {}", sides.join(", "));
        let _ = writeln!(text, "    supports        {supports} on {}", counted(body.held_nodes, "node"));
        let _ = writeln!(text, "    loads           {loads}");
        let _ = writeln!(text, "    smallest angle  {:.1} degrees", body.smallest_angle);
    }
    let _ = writeln!(text, "\n  memory estimate {}", mebibytes(memory::estimate(&problem)));
    text += "  ok: no problem found\n";
    console::print(&text)?;
    Ok(0)
}

//! `nndd check`: every check that needs no factorisation.

use crate::args::{Check, Format};
use crate::console;
use crate::machine::Machine;
use nndd_report::check::summary;
use nndd_report::memory::{self, mebibytes};
use nndd_report::words::counted;
use nndd_report::{Failure, notes, run};
use std::fmt::Write as _;

pub(crate) fn command(options: &Check) -> Result<u8, Failure> {
    let mut case = run::read_case(&options.case.case, &run::overrides(&options.case.set)?)?;
    let problem = run::build(&mut case, &Machine::start())?;
    console::warnings(&case.warnings());
    console::notes(case.notes());
    let said = notes::of_problem(&case, &problem);
    console::notes(&said);
    let bodies = nndd_report::check::check(&case, &problem)?;
    if options.format == Format::Json {
        console::print_json(&summary(&case, &problem, &bodies, &said))?;
        return Ok(0);
    }
    let mut text = console::header(&case, &problem, &case.output_directory());
    for body in bodies {
        let sides: Vec<String> =
            body.sides.iter().map(|(name, edges)| format!("{name} ({})", counted(*edges, "edge"))).collect();
        let [supports, loads] = [body.supports, body.loads].map(|count| counted(count, "condition"));
        let _ = writeln!(text, "\n  body \"{}\"", body.name);
        let _ = writeln!(text, "    edge groups     {}", sides.join(", "));
        let _ = writeln!(text, "    supports        {supports} on {}", counted(body.held_nodes, "node"));
        if body.rigid_sides > 0 {
            let _ = writeln!(text, "    rigid           {}", counted(body.rigid_sides, "side"));
        }
        let _ = writeln!(text, "    loads           {loads}");
        let _ = writeln!(text, "    smallest angle  {:.1} degrees", body.smallest_angle);
    }
    for (given, pair) in case.contacts.iter().zip(&problem.contacts) {
        let _ = writeln!(text, "\n  contact \"{}\"", given.name);
        let bodies = given.bodies.iter().zip(&given.surfaces);
        let sides = bodies.map(|(b, side)| format!("\"{side}\" of \"{}\"", case.bodies[*b].name));
        let obstacle = given.obstacle.as_ref().map(|_| "a rigid obstacle".to_owned());
        let sides: Vec<String> = sides.chain(obstacle).collect();
        let _ = writeln!(text, "    between         {}", sides.join(" and "));
        let length = nndd_report::words::seven(pair.interface.length());
        let _ =
            writeln!(text, "    pairs           {} on a length of {length}", pair.interface.pairs().len());
    }
    let floating = problem.bodies.iter().filter(|body| body.free_motion().is_some()).count();
    let free = problem.obstacles.iter().filter(|obstacle| !obstacle.free_motions().is_empty()).count();
    let bodies = match floating {
        1 => "1 body".to_owned(),
        n => format!("{n} bodies"),
    };
    let held = [(floating, bodies), (free, counted(free, "obstacle"))];
    let held: Vec<String> =
        held.into_iter().filter(|(count, _)| *count > 0).map(|(_, words)| words).collect();
    if !held.is_empty() {
        let _ = writeln!(text, "\n  held            {} by contact only", held.join(" and "));
    }
    let _ = writeln!(text, "\n  memory estimate {}", mebibytes(memory::estimate(&problem)));
    text += "  ok: no problem found\n";
    console::print(&text)?;
    Ok(0)
}

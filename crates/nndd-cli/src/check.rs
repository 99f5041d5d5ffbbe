//! `nndd check`: every check that needs no factorisation.

use crate::args::{Check, Format};
use crate::console;
use crate::machine::Machine;
use fem_core::geometry::Vector;
use fem_core::interface::ContactProblem;
use nndd_report::check::{CheckedBody, resultant, summary};
use nndd_report::memory::{self, mebibytes};
use nndd_report::words::{counted, one_line, seven};
use nndd_report::{Failure, run};
use std::fmt::Write as _;

/// Writes what a body consists of.
fn describe(text: &mut String, body: &CheckedBody) {
    let sides: Vec<String> =
        body.sides.iter().map(|(name, edges)| format!("{name} ({})", counted(*edges, "edge"))).collect();
    let [supports, loads] = [body.supports, body.loads].map(|count| counted(count, "condition"));
    let _ = writeln!(text, "\n  body \"{}\"", one_line(&body.name));
    let _ = writeln!(text, "    edge groups     {}", sides.join(", "));
    let _ = writeln!(text, "    supports        {supports} on {}", counted(body.held_nodes, "node"));
    if body.rigid_sides > 0 {
        let _ = writeln!(text, "    rigid           {}", counted(body.rigid_sides, "side"));
    }
    let resultant =
        if body.loads == 0 { String::new() } else { format!(", resultant {}", components(body.resultant)) };
    let _ = writeln!(text, "    loads           {loads}{resultant}");
    let _ = writeln!(text, "    smallest angle  {:.1} degrees", body.smallest_angle);
}

/// Writes the resultant of all loads.
fn all_loads(problem: &ContactProblem, bodies: &[CheckedBody]) -> String {
    let loaded = problem.obstacles.iter().filter(|obstacle| obstacle.load_size() > 0.0).count();
    let with = if loaded == 0 {
        String::new()
    } else {
        format!(", {} included", counted(loaded, "loaded obstacle"))
    };
    format!("  all loads       resultant {}{with}", components(resultant(problem, bodies)))
}

/// Writes the components of a force.
fn components(force: Vector) -> String {
    format!("({}, {})", seven(force[0]), seven(force[1]))
}

pub(crate) fn command(options: &Check) -> Result<u8, Failure> {
    let machine = Machine::start(options.format == Format::Json);
    let case = run::read_case(&options.case.case, &run::overrides(&options.case.set)?)?;
    let (problem, mut notes) = run::build(&case, &machine)?;
    console::warnings(&case.warnings());
    notes.extend(nndd_report::notes::of_problem(&case, &problem));
    console::notes(&notes);
    run::begins(&case, "the checks of loads, supports and free motions", &machine);
    let bodies = nndd_report::check::check(&case, &problem)?;
    machine.has_result();
    if options.format == Format::Json {
        console::print_json(&summary(&case, &problem, &bodies, &notes))?;
        return Ok(0);
    }
    let mut text = console::header(&case, &problem, &case.output_directory());
    let all = all_loads(&problem, &bodies);
    bodies.iter().for_each(|body| describe(&mut text, body));
    for (given, pair) in case.contacts.iter().zip(&problem.contacts) {
        let _ = writeln!(text, "\n  contact \"{}\"", one_line(&given.name));
        let bodies = given.bodies.iter().zip(&given.surfaces);
        let sides = bodies.map(|(b, side)| format!("\"{side}\" of \"{}\"", case.bodies[*b].name));
        let obstacle = given.obstacle.as_ref().map(|_| "a rigid obstacle".to_owned());
        let sides: Vec<String> = sides.chain(obstacle).collect();
        let _ = writeln!(text, "    between         {}", sides.join(" and "));
        let length = seven(pair.interface.measure());
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
    let _ = writeln!(text, "\n{all}");
    let _ = writeln!(text, "  memory estimate {}", mebibytes(memory::estimate(&problem)));
    text += "  ok: no problem found\n";
    console::print(&text)?;
    Ok(0)
}

//! `nndd check`: every check that needs no factorisation.

use crate::args::{Check, Format};
use crate::console;
use crate::machine::Machine;
use case_io::Case;
use case_io::case::AnyCase;
use fem_core::geometry::Coordinates;
use fem_core::interface::ContactProblem;
use nndd_report::check::{CheckedBody, resultant, summary};
use nndd_report::memory::mebibytes;
use nndd_report::run::{self, Built};
use nndd_report::words::{components, counted, one_line, seven};
use nndd_report::{Failure, ReportSpace};
use std::fmt::Write as _;

/// Writes what a body consists of.
fn describe<S: ReportSpace>(text: &mut String, body: &CheckedBody<S>) {
    let sides: Vec<String> = body
        .sides
        .iter()
        .map(|(name, edges)| format!("{name} ({})", counted(*edges, S::WORDS.facet)))
        .collect();
    let [supports, loads] = [body.supports, body.loads].map(|count| counted(count, "condition"));
    let _ = writeln!(text, "\n  body \"{}\"", one_line(&body.name));
    let _ = writeln!(text, "    {:<15} {}", format!("{} groups", S::WORDS.facet), sides.join(", "));
    let _ = writeln!(text, "    supports        {supports} on {}", counted(body.held_nodes, "node"));
    if body.springs > 0 {
        let _ = writeln!(text, "    on springs      {}", counted(body.springs, "side"));
    }
    if body.cuts > 0 {
        let _ = writeln!(text, "    tightened       {}", counted(body.cuts, "cut"));
    }
    if body.rigid_sides > 0 {
        let _ = writeln!(text, "    rigid           {}", counted(body.rigid_sides, "side"));
    }
    let resultant =
        if body.loads == 0 { String::new() } else { format!(", resultant {}", shown(body.resultant)) };
    let _ = writeln!(text, "    loads           {loads}{resultant}");
    let _ = writeln!(text, "    smallest angle  {:.1} degrees", body.smallest_angle);
}

/// Writes the resultant of all loads.
fn all_loads<S: ReportSpace>(problem: &ContactProblem<S>, bodies: &[CheckedBody<S>]) -> String {
    let loaded = problem.obstacles.iter().filter(|obstacle| obstacle.load_size() > 0.0).count();
    let with = if loaded == 0 {
        String::new()
    } else {
        format!(", {} included", counted(loaded, "loaded obstacle"))
    };
    format!("  all loads       resultant {}{with}", shown(resultant(problem, bodies)))
}

/// Writes the components of a force.
fn shown<V: Coordinates>(force: V) -> String {
    components(force.entries(), seven)
}

/// Sides that are named in a line.
const MOST_UNPAIRED: usize = 20;

/// Lists the sides that face each other and are in no contact.
fn unpaired<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>) -> String {
    let mut all = nndd_report::check::facing(case, problem);
    all.retain(|facing| facing.contact.is_none());
    let mut text = String::new();
    for facing in all.iter().take(MOST_UNPAIRED) {
        let [first, second] = facing.sides.each_ref().map(|(body, side)| format!("\"{side}\" of \"{body}\""));
        let _ = writeln!(text, "  in no contact     {first} faces {second}");
    }
    if let Some(more) = all.len().checked_sub(MOST_UNPAIRED).filter(|more| *more > 0) {
        let _ = writeln!(text, "  in no contact     {more} more sides face each other");
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}

pub(crate) fn command(options: &Check) -> Result<u8, Failure> {
    let machine = Machine::start(options.format == Format::Json);
    match run::read_case(&options.case.case, &run::overrides(&options.case.set)?)? {
        AnyCase::Plane(case) => check(options, &case, &machine),
        AnyCase::Solid(case) => check(options, &case, &machine),
    }
}

fn check<S: ReportSpace>(options: &Check, case: &Case<S>, machine: &Machine) -> Result<u8, Failure> {
    let Built { problem, mut notes, memory, .. } = run::build(case, machine)?;
    console::warnings(&case.warnings());
    notes.extend(nndd_report::notes::of_problem(case, &problem));
    console::notes(&notes);
    run::begins(case, "the checks of loads, supports and free motions", machine);
    let bodies = nndd_report::check::check(case, &problem)?;
    machine.has_result();
    if options.format == Format::Json {
        console::print_json(&summary(case, &problem, &bodies, &notes, memory))?;
        return Ok(0);
    }
    let mut text = console::header(case, &problem, (&case.output_directory(), memory));
    let all = all_loads(&problem, &bodies);
    bodies.iter().for_each(|body| describe(&mut text, body));
    for (given, pair) in case.contacts.iter().zip(&problem.contacts) {
        let _ = writeln!(text, "\n  contact \"{}\"", one_line(&given.name));
        let bodies = given.bodies.iter().zip(&given.surfaces);
        let sides = bodies.map(|(b, side)| format!("\"{side}\" of \"{}\"", case.bodies[*b].name));
        let obstacle = given.obstacle.as_ref().map(|_| "a rigid obstacle".to_owned());
        let sides: Vec<String> = sides.chain(obstacle).collect();
        let _ = writeln!(text, "    between         {}", sides.join(" and "));
        let (pairs, extent) = (pair.interface.pairs().len(), seven(pair.interface.measure()));
        let _ = writeln!(text, "    pairs           {pairs}, {} {extent}", S::EXTENT);
    }
    text += &unpaired(case, &problem);
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
    let _ = writeln!(text, "  memory estimate {}", mebibytes(memory));
    text += "  ok: no problem found\n";
    console::print(&text)?;
    Ok(0)
}

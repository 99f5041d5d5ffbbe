//! The console: results on stdout, errors on stderr.

mod excerpt;
mod fit;
mod remark;
mod table;

use case_io::Case;
use case_io::case::{Material, Target};
use case_io::diagnostic::Diagnostic;
use certified_contact::Step;
use fem_core::geometry::bounding_box;
use fem_core::interface::{ContactPair, ContactProblem};
use nndd_report::convert;
use nndd_report::memory::mebibytes;
use nndd_report::words::{self, one_line, plain, seven, short};
use nndd_report::{Failure, ReportSpace};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};

pub(crate) use remark::remark;
pub(crate) use table::Layout;

/// Prints to stdout. A closed pipe is not an error.
pub(crate) fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(plain(text).as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(full),
    }
}

/// Prints one JSON object on a line to stdout.
pub(crate) fn print_json(value: &Value) -> io::Result<()> {
    print(&format!("{}\n", words::json(value)))
}

/// Says that standard output cannot be written to.
pub(crate) fn full(error: io::Error) -> io::Error {
    let what = format!("cannot write to standard output: {error}; redirect it to a disk with free space");
    io::Error::new(error.kind(), what)
}

/// Prints to stderr; a failure to write there cannot be reported.
fn complain(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// The width of the terminal that results go to, `None` if they go elsewhere.
pub(crate) fn width() -> Option<usize> {
    let out = io::stdout();
    let size = out.is_terminal().then(|| terminal_size::terminal_size_of(&out)).flatten();
    size.map(|(width, _)| usize::from(width.0))
}

/// Makes the one object that `--format json` gets of a failure.
fn failed(failure: &Failure) -> Value {
    let diagnostics = failure.diagnostics.iter().map(ToString::to_string);
    let message: Vec<String> = diagnostics.chain(failure.message.clone()).collect();
    json!({ "event": "failed", "code": failure.code, "message": message.join("\n") })
}

/// Prints why a command failed, for programs as an object on stdout too.
pub(crate) fn end(cause: &Failure, for_programs: bool) {
    if for_programs {
        // If stdout itself failed, only the text on stderr remains.
        let _ = print_json(&failed(cause));
    }
    failure(cause);
}

/// Prints why a command failed.
pub(crate) fn failure(failure: &Failure) {
    let mut text = String::new();
    for diagnostic in &failure.diagnostics {
        text += &render("error", diagnostic);
    }
    if let Some(message) = &failure.message {
        let prefix = if failure.diagnostics.is_empty() { "error: " } else { "" };
        let _ = writeln!(text, "{prefix}{}", plain(message));
    }
    complain(&text);
}

/// Prints to stderr why a run without further output ended as it did.
pub(crate) fn reason(text: &str) {
    complain(&plain(text.trim_start()));
}

/// Prints warnings about a case.
pub(crate) fn warnings(diagnostics: &[Diagnostic]) {
    for diagnostic in diagnostics {
        complain(&render("warning", diagnostic));
    }
}

/// Prints what is worth knowing about how a case was read.
pub(crate) fn notes(notes: &[String]) {
    for note in notes {
        complain(&format!("note: {}\n", plain(note)));
    }
}

/// Longer lines do not help on a console: a message is cut, and a source line is not shown.
const LONGEST_LINE: usize = 2000;

/// Renders a diagnostic with its place: one plain line first, then the source as people like to see it.
fn render(kind: &str, diagnostic: &Diagnostic) -> String {
    let mut text = plain(&format!("{kind}[{}]: {diagnostic}", diagnostic.code)).into_owned();
    if let Some((end, _)) = text.char_indices().nth(LONGEST_LINE) {
        text.truncate(end);
        text += " …";
    }
    text.push('\n');
    let Some(place) = diagnostic.place.as_ref().filter(|p| !p.source.is_command_line()) else { return text };
    let mut shown = place.source.text().lines().skip(place.line.saturating_sub(2)).take(3);
    if shown.any(|line| line.len() > LONGEST_LINE) {
        return text;
    }
    let colour = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    text + &excerpt::excerpt(place, place.source.text(), colour)
}

/// The header: version, sizes, settings; no wider than the terminal.
pub(crate) fn header<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    (output, memory): (&str, f64),
) -> String {
    let mut text = format!("nndd {}   {}\n", env!("CARGO_PKG_VERSION"), case.file_name());
    if !case.title.is_empty() {
        let _ = writeln!(text, "  {}", one_line(&case.title));
    }
    for (k, (body, model)) in case.bodies.iter().zip(&problem.bodies).enumerate() {
        let [low, high] = bounding_box(model.mesh().points());
        let materials: Vec<String> = case.materials_of(k).into_iter().map(Material::summary).collect();
        let sides: Vec<String> =
            (0..S::DIM).map(|c| format!("[{}, {}]", seven(low[c]), seven(high[c]))).collect();
        let _ = writeln!(
            text,
            "  {:<10} {:>8} nodes {:>8} {}   {}   {}",
            one_line(&body.name),
            model.mesh().points().len(),
            model.mesh().cells().len(),
            S::WORDS.cells,
            materials.join(" | "),
            sides.join(" x ")
        );
    }
    for (given, ContactPair { interface, .. }) in case.contacts.iter().zip(&problem.contacts) {
        let name = if case.contacts.len() == 1 { "contact" } else { given.name.as_str() };
        let _ = writeln!(
            text,
            "  {:<10} {:>8} pairs, {} {}",
            one_line(name),
            interface.pairs().len(),
            S::EXTENT,
            seven(interface.measure())
        );
    }
    if let Some(units) = &case.units {
        let _ = writeln!(
            text,
            "  {:<10} lengths {}, forces {}, stresses {}; forces and energies{} {} and {}",
            "units",
            units.length,
            units.force,
            units.stress(),
            if S::thickness(&case.model).is_some() { " per thickness" } else { "" },
            S::force_unit(units),
            S::moment_unit(units)
        );
    }
    let _ = writeln!(text, "  {:<10} about {} of memory", "needs", mebibytes(memory));
    text += &solver_lines(case, problem, output);
    if let Some(adapt) = &case.adapt {
        let what = match adapt.target {
            Target::RelativeError(_) => "certified relative error",
            Target::CoulombResidual(_) => "relative residual, which is no bound,",
        };
        let _ = writeln!(
            text,
            "  adapt      until the {what} <= {}; at most {} meshes, {} nodes; fraction {}",
            short(adapt.target.value()),
            adapt.max_steps,
            adapt.max_nodes,
            short(adapt.fraction)
        );
    }
    fit::fit(&text, width())
}

/// How the case is solved, and when the iteration stops.
fn solver_lines<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>, output: &str) -> String {
    let mut text = String::new();
    let solver = &case.solver;
    if case.coulomb_pair().is_some() {
        let text = format!(
            "  solver     exact, a fixed point of the limit of Coulomb friction: change <= {}, at most {} steps; qp {}\n",
            short(solver.friction_tolerance),
            solver.friction_steps,
            solver.qp
        );
        return text + &format!("  residual   {}\n", relaxation_and_output(case, output));
    }
    let theta = match solver.theta {
        case_io::case::Theta::Auto => "auto".to_string(),
        case_io::case::Theta::Value(theta) => short(theta),
    };
    let method = convert::method(case, problem);
    let of_iteration = match method {
        case_io::case::Method::Nndd => format!(
            " theta {theta}, weights {}, acceleration {}, lambda on {}",
            solver.weights, solver.acceleration, solver.imposed
        ),
        _ => String::new(),
    };
    let chosen = match (solver.method, &case.adapt) {
        (case_io::case::Method::Auto, Some(_)) => " (auto, on this mesh)",
        (case_io::case::Method::Auto, None) => " (auto)",
        _ => "",
    };
    let _ = writeln!(text, "  solver     {method}{chosen}{of_iteration}; qp {}", solver.qp);
    let _ = writeln!(text, "             {}", words::of_method(method));
    let stop = &solver.stop;
    let bound = match stop.criterion {
        case_io::case::Criterion::Estimator => {
            let balance = stop.force_balance.map(|part| format!(", force balance {}", short(part)));
            format!("ratio {}{}", short(stop.ratio), balance.unwrap_or_default())
        }
        case_io::case::Criterion::Iterations => String::new(),
        _ => format!("tolerance {:e}", stop.tolerance),
    };
    // An exact solution meets every criterion; on finer meshes of an adaptive run there may be an iteration.
    let end = match (method, &case.adapt) {
        (case_io::case::Method::Exact, None) => "at the exact solution".to_owned(),
        _ => format!("{} {bound}, at most {} iterations", stop.criterion, solver.max_iterations),
    };
    let _ = writeln!(text, "  stop       {end}; {}", relaxation_and_output(case, output));
    text
}

fn relaxation_and_output<S: ReportSpace>(case: &Case<S>, output: &str) -> String {
    format!(
        "relaxation {}; threads {}; output {output}",
        match case.estimator.until {
            None => case.estimator.relaxation.to_string(),
            Some(until) => format!("until less than {} is left to gain", short(until.tolerance)),
        },
        rayon::current_num_threads()
    )
}

/// The head of the table of an adaptive run, with a column of times or without one.
///
/// * `residual`: whether its numbers are residuals, which bound nothing.
pub(crate) fn step_head(residual: bool, timed: bool) -> String {
    let time = if timed { "  time [s]" } else { "" };
    let columns =
        if residual { "     steps        e_b      residual" } else { "iterations      e_cre     certified" };
    format!("\nstep     nodes   pairs  {columns}{time}\n")
}

/// One mesh of an adaptive run.
///
/// * `seconds`: since the program began, if times are shown.
pub(crate) fn step(step: &Step, seconds: Option<f64>) -> String {
    let error = step.e_cre.or(step.e_b);
    let error = error.map_or_else(|| format!("{:>10}", "-"), |x| scientific_up(x, 10, 3));
    let relative = match step.relative.or(step.relative_residual) {
        _ if !step.certified && step.e_b.is_none() => "not valid".to_string(),
        Some(relative) => format!("{} %", words::rounded_up(100.0 * relative)),
        None => "-".to_string(),
    };
    format!(
        "{:>4} {:>9} {:>7} {:>11} {error} {relative:>13}{}\n",
        step.step,
        step.nodes,
        step.pairs,
        step.iterations,
        seconds.map_or_else(String::new, |seconds| format!(" {seconds:>9.2}"))
    )
}

/// The same of a bound, never smaller than it is.
fn scientific_up(x: f64, width: usize, digits: usize) -> String {
    scientific(words::raised(x, digits + 1), width, digits)
}

/// Writes a number with a signed exponent of two digits, so that columns line up; a dash if it is not finite.
fn scientific(x: f64, width: usize, digits: usize) -> String {
    if !x.is_finite() {
        return format!("{:>width$}", "-");
    }
    let text = format!("{x:.digits$e}");
    let text = match text.split_once('e') {
        Some((mantissa, exponent)) => match exponent.parse::<i32>() {
            Ok(e) => format!("{mantissa}e{}{:02}", if e < 0 { '-' } else { '+' }, e.abs()),
            Err(_) => text,
        },
        None => text,
    };
    format!("{text:>width$}")
}

#[cfg(test)]
mod tests {
    use super::{scientific, scientific_up};

    #[test]
    fn columns_have_signed_exponents_and_dashes() {
        assert_eq!(scientific(-1234.5, 12, 3), "  -1.234e+03");
        assert_eq!(scientific(f64::NAN, 4, 3), "   -");
        assert_eq!(scientific(f64::INFINITY, 4, 3), "   -");
        assert_eq!(scientific_up(1.242487, 10, 3), " 1.243e+00");
        assert_eq!(scientific_up(9.9991e-5, 9, 3), "1.000e-04");
    }
}

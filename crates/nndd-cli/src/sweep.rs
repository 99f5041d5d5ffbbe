//! `nndd sweep`: a case for several values of one setting, a few iterations each.

use crate::args::Sweep as Options;
use crate::console;
use crate::machine::{Machine, Showing};
use nndd_report::failure::NOT_CERTIFIED;
use nndd_report::sweep::{self, SweepOptions, Swept};
use nndd_report::{Event, Failure, Host, NOT_CONVERGED};

pub(crate) fn command(options: &Options) -> Result<u8, Failure> {
    let mut of_library = SweepOptions::new(&options.case.case, &options.over);
    of_library.set.clone_from(&options.case.set);
    of_library.iterations = options.iterations;
    of_library.panel.clone_from(&options.panel);
    of_library.out.clone_from(&options.run.out);
    of_library.force = options.run.force;
    let mut width = 0;
    let show = |event: Event<'_>| show(options, &mut width, event);
    let mut host = Showing { machine: Machine::listen(false)?, show };
    let swept = sweep::sweep(&of_library, &mut host)?;
    let signal = host.interrupted();
    let record = &swept.record;
    let why = reason(&swept, signal);
    if options.run.quiet {
        why.iter().for_each(|why| console::reason(why));
    } else {
        for panel in &record.panels {
            console::print(&sweep::best(&record.key, panel))?;
        }
        why.iter().try_for_each(|why| console::print(why))?;
        console::print(&format!("wrote {}: {}\n", swept.path.display(), swept.files.join(" ")))?;
    }
    let code = match (swept.has_valid(), swept.has_value()) {
        (true, _) => 0,
        (false, true) => NOT_CERTIFIED,
        (false, false) => NOT_CONVERGED,
    };
    match swept.failure {
        Some(failure) => Err(failure),
        None => Ok(signal.unwrap_or(code)),
    }
}

/// Says why a sweep has no value, or not all of them; `None` if it has them, and for a failure, which says so itself.
fn reason(swept: &Swept, signal: Option<u8>) -> Option<String> {
    let record = &swept.record;
    if signal.is_some() {
        let (done, all) = (swept.rows().count(), swept.asked);
        return Some(format!("interrupted: by a signal after {done} of {all} runs\n"));
    }
    if swept.has_valid() || swept.failure.is_some() {
        return None;
    }
    if swept.has_value() {
        return Some("not certified: no run of this sweep has a valid bound\n".to_owned());
    }
    let word = swept.rows().map(|row| row.status.as_str()).next().unwrap_or("stalled");
    Some(format!("{word}: no run of this sweep has an eta_nndd; try other values of {}\n", record.key))
}

/// Shows an event of the sweep.
///
/// * `width`: of the first column.
fn show(options: &Options, width: &mut usize, event: Event<'_>) -> Result<(), Failure> {
    let layout = console::Layout::default();
    match event {
        Event::Panel { name, sweep } => {
            let texts = sweep.values.iter().chain([&sweep.key]);
            *width = texts.map(|text| text.chars().count()).max().unwrap_or(0).clamp(12, 40);
            let (width, key, head) = (*width, &sweep.key, &layout.head()[1..]);
            if !options.run.quiet {
                console::print(&format!("\n{name}\n{key:>width$} {head}"))?;
            }
        }
        Event::Value { value, row, choices, .. } => {
            let width = *width;
            if let Some(row) = row.filter(|_| !options.run.quiet) {
                console::print(&format!("{value:>width$} {}", layout.row(row, 0.0)))?;
            }
            if options.run.verbose {
                console::print(choices)?;
            }
        }
        _ => {}
    }
    Ok(())
}

//! `nndd certify`: the error of displacements that another code computed.

use crate::args::{Certify, Format};
use crate::console;
use crate::machine::Machine;
use case_io::Case;
use case_io::case::AnyCase;
use nndd_report::failure::NOT_CERTIFIED;
use nndd_report::run::{self, Built};
use nndd_report::{Failure, ReportSpace, certify};

pub(crate) fn command(options: &Certify) -> Result<u8, Failure> {
    let machine = Machine::start(options.format != Format::Human);
    match run::read_case(&options.case.case, &run::overrides(&options.case.set)?)? {
        AnyCase::Plane(case) => certified(options, &case, &machine),
        AnyCase::Solid(case) => certified(options, &case, &machine),
    }
}

fn certified<S: ReportSpace>(options: &Certify, case: &Case<S>, machine: &Machine) -> Result<u8, Failure> {
    let for_people = options.format == Format::Human;
    let Built { problem, notes, .. } = run::build_last(case, machine)?;
    run::begins(case, "the certificate of the field", machine);
    let found = certify::certify(case, &problem, &options.displacement)?;
    machine.has_result();
    if for_people {
        // Nodes that were added or moved so that surfaces match.
        console::notes(&notes);
        console::print(&certify::verdict(case, &found))?;
    }
    if let Some(path) = &options.out {
        let place = (path.as_path(), options.force);
        let files = certify::write(case, (&problem, &notes), &found, &options.displacement, place)?;
        if for_people {
            console::print(&format!("wrote {}: {}\n", path.display(), files.join(" ")))?;
        }
    }
    if !for_people {
        console::print(&format!("{}\n", certify::summary(case, &found)))?;
    }
    Ok(if found.bound().is_some() { 0 } else { NOT_CERTIFIED })
}

//! `nndd compare`: the results of two runs, their differences, and the intervals that meet.

use crate::args::{Compare, Format};
use crate::console;
use nndd_report::{Failure, compare};

pub(crate) fn command(options: &Compare) -> Result<u8, Failure> {
    let found = compare::compare([&options.first, &options.second])?;
    match options.format {
        Format::Human => console::print(&compare::table(&found))?,
        Format::Json => console::print_json(&compare::summary(&found))?,
    }
    Ok(0)
}

//! The texts of `--help` and of the manual page beside the options: examples, exit status, files.

use std::fmt::Write as _;

/// A name or a command line, and what it means.
pub(crate) type Pair = (&'static str, &'static str);

/// The examples, each with its command; the examples of `nndd` itself are the first steps.
const EXAMPLES: &str = include_str!("help/examples.txt");
/// The exit status and what it means.
pub(crate) const EXIT_STATUS: &str = include_str!("help/exit_status.txt");
/// The files of an output directory.
pub(crate) const FILES: &str = include_str!("help/files.txt");

/// Returns the rows of a table of two columns.
pub(crate) fn rows(table: &'static str) -> impl Iterator<Item = Pair> {
    table.lines().filter_map(|line| line.split_once(" | "))
}

/// Returns the examples of a command.
pub(crate) fn examples(of: &str) -> impl Iterator<Item = Pair> {
    let own = rows(EXAMPLES).filter(move |(command, _)| *command == of);
    own.filter_map(|(_, example)| example.split_once(" | "))
}

/// The text below the options of the program.
pub(crate) fn of_program() -> String {
    let mut text = listed("nndd");
    text += "\nExit status:\n";
    for (status, meaning) in rows(EXIT_STATUS) {
        let _ = writeln!(text, "  {status:<13} {meaning}");
    }
    text + "\n" + MANUAL
}

/// The text below the options of a command.
pub(crate) fn of_command(name: &str) -> String {
    listed(name) + "\n" + MANUAL
}

/// The column at which the meaning of an example begins.
const COLUMN: usize = 54;

const MANUAL: &str = "The whole manual: nndd man > nndd.1 && man ./nndd.1";

fn listed(of: &str) -> String {
    let mut text = String::from("Examples:\n");
    for (line, meaning) in examples(of) {
        // A long line has its meaning below it.
        let gap = match COLUMN.checked_sub(line.len()) {
            Some(blanks) => " ".repeat(blanks),
            None => format!("\n  {:<COLUMN$}", ""),
        };
        let _ = writeln!(text, "  {line}{gap} {meaning}");
    }
    text
}

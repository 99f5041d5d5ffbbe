//! `nndd man`: one manual page with every command, so that it refers to no other.

use crate::args::Arguments;
use crate::help::{EXAMPLES, EXIT_STATUS, Example, FILES};
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};

const DESCRIPTION: [&str; 3] = [
    "nndd solves frictionless unilateral contact between two elastic bodies in the plane by the Neumann-Neumann domain \
     decomposition, and certifies the answer: it prints a guaranteed bound of the error in the energy norm, split into \
     what the mesh and what the iteration contribute.",
    "A case file, in TOML, names bodies, materials, supports, loads and the two sides in contact. Every key that is not \
     required has a default of its own; those of a template from nndd new are commented. With adapt.target_relative_error set, both meshes are \
     refined until that error is certified.",
    "Results go to stdout, progress and errors to stderr. Errors name the file, line and column, what was found, what was \
     expected, and one thing to do.",
];

/// Writes the page.
pub(crate) fn page() -> String {
    let mut program = Arguments::command();
    // Fills in what options inherit, and the usage lines.
    program.build();
    let mut roff = Roff::new();
    // An empty date would be left out, and move what follows.
    roff.control("TH", ["nndd", "1", " ", &format!("nndd {}", env!("CARGO_PKG_VERSION")), "User Commands"]);
    roff.control("SH", ["NAME"]);
    let about = program.get_about().map(ToString::to_string).unwrap_or_default();
    roff.text([roman(format!("nndd - {}", about.trim_end_matches('.').replacen('S', "s", 1)))]);
    let commands: Vec<Command> =
        program.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect();
    roff.control("SH", ["SYNOPSIS"]);
    for command in &commands {
        roff.text([bold(usage(command))]);
        roff.control("br", []);
    }
    roff.text([bold("nndd --help"), roman(" | "), bold("--version")]);
    roff.control("SH", ["DESCRIPTION"]);
    for paragraph in DESCRIPTION {
        roff.control("PP", []);
        roff.text([roman(paragraph)]);
    }
    roff.control("SH", ["COMMANDS"]);
    let head = roff.to_roff();
    let sections: String = commands.iter().map(section).collect();
    let mut roff = Roff::new();
    roff.control("SH", ["EXIT STATUS"]);
    pairs(&mut roff, &EXIT_STATUS);
    roff.control("SH", ["FILES"]);
    roff.text([roman("In the output directory, each written under a temporary name and renamed:")]);
    pairs(&mut roff, &FILES);
    roff.control("SH", ["ENVIRONMENT"]);
    pairs(&mut roff, &[("NO_COLOR", "if it is set, errors are shown without colour")]);
    roff.control("SH", ["EXAMPLES"]);
    examples(&mut roff, "");
    head + &sections + &roff.to_roff()
}

/// One command with its arguments, options and examples.
fn section(command: &Command) -> String {
    let mut roff = Roff::new();
    roff.control("SS", [format!("nndd {}", command.get_name()).as_str()]);
    roff.text([roman(command.get_about().map(ToString::to_string).unwrap_or_default())]);
    roff.control("PP", []);
    roff.text([bold(usage(command))]);
    let mut tail = Roff::new();
    examples(&mut tail, command.get_name());
    roff.to_roff() + &options(command) + &tail.to_roff()
}

/// The options of a command, without the headings of its `--help`, which would begin sections of the page.
fn options(command: &Command) -> String {
    let mut text = Vec::new();
    let shown = command.clone().mut_arg("help", |help| help.hide(true));
    // Writing into memory does not fail.
    let _ = Man::new(shown).render_options_section(&mut text);
    let text = String::from_utf8_lossy(&text);
    text.lines().filter(|line| !line.starts_with(".SH")).map(|line| format!("{line}\n")).collect()
}

/// The usage line of a command, without its first word.
fn usage(command: &Command) -> String {
    command.clone().render_usage().to_string().trim_start_matches("Usage: ").to_owned()
}

fn pairs(roff: &mut Roff, pairs: &[(&str, &str)]) {
    for (name, meaning) in pairs {
        roff.control("TP", []);
        roff.text([bold(*name)]);
        roff.text([roman(*meaning)]);
    }
}

fn examples(roff: &mut Roff, of: &str) {
    for Example { line, meaning, .. } in EXAMPLES.iter().filter(|example| example.of == of) {
        roff.control("PP", []);
        roff.text([roman(format!("{}:", capitalised(meaning)))]);
        roff.control("PP", []);
        roff.control("RS", ["4"]);
        roff.control("nf", []);
        roff.text([bold(*line)]);
        roff.control("fi", []);
        roff.control("RE", []);
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

//! `nndd man`: one manual page with every command, so that it refers to no other.

use crate::args::Arguments;
use crate::help::{EXIT_STATUS, FILES, Pair, examples, rows};
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};
use std::io;

const DESCRIPTION: [&str; 3] = [
    "nndd solves unilateral contact, with friction or without, between elastic bodies in the plane and in space by the Neumann-Neumann domain \
     decomposition, and certifies the answer: it prints a guaranteed bound of the error in the energy norm, split into \
     what the mesh and what the iteration contribute.",
    "A case file, in TOML, names bodies, materials, supports, loads and the two sides in contact. Every key that is not \
     required has a default of its own; those of a template from nndd new are commented. With adapt.target_relative_error set, both meshes are \
     refined until that error is certified. Friction is that of Tresca, with a given limit, or of Coulomb, which has a residual in place of a \
     bound, since none is known.",
    "Results go to stdout, progress and errors to stderr. Errors name the file, line and column, what was found, what was \
     expected, and one thing to do.",
];

/// Writes the page.
pub(crate) fn page() -> String {
    let mut program = Arguments::command();
    // Fills in what options inherit, and the usage lines.
    program.build();
    let commands: Vec<Command> =
        program.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect();
    // An empty date would be left out, and move what follows.
    let man = Man::new(program).date(" ").manual("User Commands");
    let mut page = rendered(|page| man.render_title(page)) + &rendered(|page| man.render_name_section(page));
    let mut roff = Roff::new();
    roff.control("SH", ["SYNOPSIS"]);
    for command in &commands {
        roff.text([bold(usage(command))]).control("br", []);
    }
    roff.text([bold("nndd --help"), roman(" | "), bold("--version")]);
    roff.control("SH", ["DESCRIPTION"]);
    for paragraph in DESCRIPTION {
        roff.control("PP", []).text([roman(paragraph)]);
    }
    roff.control("SH", ["COMMANDS"]);
    page += &roff.to_roff();
    page.extend(commands.iter().map(section));
    let mut roff = Roff::new();
    let environment = [("NO_COLOR", "if it is set, errors are shown without colour")];
    pairs(&mut roff, "EXIT STATUS", rows(EXIT_STATUS));
    pairs(&mut roff, "FILES", rows(FILES));
    pairs(&mut roff, "ENVIRONMENT", environment);
    pairs(&mut roff, "EXAMPLES", examples("nndd"));
    page + &roff.to_roff()
}

/// Returns a part of the page as clap_mangen writes it into memory, which does not fail.
fn rendered(part: impl FnOnce(&mut dyn io::Write) -> io::Result<()>) -> String {
    let mut text = Vec::new();
    let _ = part(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

/// One command with its arguments, options and examples.
fn section(command: &Command) -> String {
    let mut roff = Roff::new();
    roff.control("SS", [format!("nndd {}", command.get_name()).as_str()]);
    roff.text([roman(command.get_about().map(ToString::to_string).unwrap_or_default())]);
    roff.control("PP", []).text([bold(usage(command))]);
    let man = Man::new(command.clone().mut_arg("help", |help| help.hide(true)));
    // Without the headings of its `--help`, which would begin sections of the page.
    let options = rendered(|text| man.render_options_section(text));
    let options = options.lines().filter(|line| !line.starts_with(".SH")).map(|line| format!("{line}\n"));
    let mut tail = Roff::new();
    items(&mut tail, examples(command.get_name()));
    roff.to_roff() + &options.collect::<String>() + &tail.to_roff()
}

/// The usage line of a command, without its first word.
fn usage(command: &Command) -> String {
    command.clone().render_usage().to_string().trim_start_matches("Usage: ").to_owned()
}

fn pairs(roff: &mut Roff, head: &str, pairs: impl IntoIterator<Item = Pair>) {
    roff.control("SH", [head]);
    items(roff, pairs);
}

fn items(roff: &mut Roff, pairs: impl IntoIterator<Item = Pair>) {
    for (name, meaning) in pairs {
        roff.control("TP", []).text([bold(name)]).text([roman(meaning)]);
    }
}

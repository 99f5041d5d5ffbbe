//! `nndd man`: one manual page with every command, so that it refers to no other.

use crate::args::Arguments;
use crate::help::{EXAMPLES, EXIT_STATUS, Example, FILES};
use clap::{Arg, ArgAction, Command, CommandFactory};
use clap_mangen::roff::{Inline, Roff, bold, italic, roman};

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
    for command in &commands {
        section(&mut roff, command);
    }
    roff.control("SH", ["EXIT STATUS"]);
    pairs(&mut roff, &EXIT_STATUS);
    roff.control("SH", ["FILES"]);
    roff.text([roman("In the output directory, each written under a temporary name and renamed:")]);
    pairs(&mut roff, &FILES);
    roff.control("SH", ["ENVIRONMENT"]);
    pairs(&mut roff, &[("NO_COLOR", "if it is set, errors are shown without colour")]);
    roff.control("SH", ["EXAMPLES"]);
    examples(&mut roff, "");
    roff.to_roff()
}

/// One command with its arguments, options and examples.
fn section(roff: &mut Roff, command: &Command) {
    roff.control("SS", [format!("nndd {}", command.get_name()).as_str()]);
    roff.text([roman(command.get_about().map(ToString::to_string).unwrap_or_default())]);
    roff.control("PP", []);
    roff.text([bold(usage(command))]);
    let shown = |arg: &&Arg| !["help", "version"].contains(&arg.get_id().as_str());
    for arg in command.get_arguments().filter(shown) {
        item(roff, head(arg), &description(arg));
    }
    examples(roff, command.get_name());
}

/// The usage line of a command, without its first word.
fn usage(command: &Command) -> String {
    command.clone().render_usage().to_string().trim_start_matches("Usage: ").to_owned()
}

/// An option or argument as it is typed.
fn head(arg: &Arg) -> Vec<Inline> {
    let mut head = Vec::new();
    if let Some(short) = arg.get_short() {
        head.extend([bold(format!("-{short}")), roman(", ")]);
    }
    if let Some(long) = arg.get_long() {
        head.extend([bold(format!("--{long}")), roman(" ")]);
    }
    if takes_value(arg) {
        let names = arg.get_value_names().unwrap_or_default();
        head.push(italic(names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(" ")));
    }
    head
}

/// The help of an option or argument, with its values and default.
fn description(arg: &Arg) -> String {
    let mut text =
        arg.get_long_help().or_else(|| arg.get_help()).map(ToString::to_string).unwrap_or_default();
    if !text.ends_with('.') {
        text.push('.');
    }
    if !takes_value(arg) {
        return text;
    }
    let values: Vec<String> = arg
        .get_possible_values()
        .iter()
        .map(|value| match value.get_help() {
            Some(help) => format!("{} ({})", value.get_name(), help.to_string().trim_end_matches('.')),
            None => value.get_name().to_owned(),
        })
        .collect();
    if !values.is_empty() {
        text += &format!(" One of: {}.", values.join(", "));
    }
    let default: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    if !default.is_empty() {
        text += &format!(" Default: {}.", default.join(" "));
    }
    if matches!(arg.get_action(), ArgAction::Append) {
        text += " May be repeated.";
    }
    text
}

fn takes_value(arg: &Arg) -> bool {
    arg.get_num_args().is_some_and(|range| range.takes_values())
}

fn pairs(roff: &mut Roff, pairs: &[(&str, &str)]) {
    for (name, meaning) in pairs {
        item(roff, vec![bold(*name)], meaning);
    }
}

fn item(roff: &mut Roff, head: Vec<Inline>, text: &str) {
    roff.control("TP", []);
    roff.text(head);
    roff.text([roman(text)]);
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

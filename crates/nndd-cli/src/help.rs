//! What `--help` and the manual page say beside the options: examples, exit status, files.

use std::fmt::Write as _;

/// A command line, and what it is good for.
pub(crate) struct Example {
    /// The command whose help shows it.
    pub(crate) of: &'static str,
    pub(crate) line: &'static str,
    pub(crate) meaning: &'static str,
}

const fn example(of: &'static str, line: &'static str, meaning: &'static str) -> Example {
    Example { of, line, meaning }
}

/// The examples of all commands; those without a command are the first steps.
pub(crate) const EXAMPLES: [Example; 13] = [
    example("", "nndd new paper > case.toml", "start from a commented case file"),
    example("", "nndd solve case.toml", "solve it, and certify the answer"),
    example("", "nndd new gmsh > mine.toml", "the same for a mesh of your own"),
    example("", "nndd sweep case.toml --over solver.theta=0.1:0.9:0.05", "the paper's figure 2"),
    example(
        "solve",
        "nndd solve case.toml --set adapt.target_relative_error=0.02",
        "until 2 % are certified",
    ),
    example(
        "solve",
        "nndd solve case.toml --set 'body.0.generator.cells=[72, 36]' --out fine",
        "another mesh",
    ),
    example("solve", "nndd solve case.toml --resume", "resume an interrupted adaptive run"),
    example("solve", "nndd solve case.toml --format json", "one JSON object per line, for programs"),
    example("check", "nndd check case.toml", "all faults at once, each with its line"),
    example("sweep", "nndd sweep case.toml --over solver.theta=0.1:0.9:0.05", "a range, its end included"),
    example(
        "sweep",
        "nndd sweep case.toml --over 'solver.theta=[0.3, 0.4]' --panel solver.weights=stiffness",
        "values, beside other weights",
    ),
    example(
        "certify",
        "nndd certify case.toml --displacement upper.vtu lower.vtu",
        "the error of another code's displacements, one file per body",
    ),
    example("mesh", "nndd mesh mine.msh", "names to use in a case file, possible problems"),
];

/// The exit status and what it means.
pub(crate) const EXIT_STATUS: [(&str, &str); 10] = [
    ("0", "converged, or the given number of iterations completed"),
    ("1", "a defect of this program"),
    ("2", "wrong command line"),
    ("3", "invalid input"),
    ("4", "no unique solution: a body can move freely, or its loads are outside the friction cones"),
    ("5", "not converged"),
    ("6", "no valid certificate, or its target missed"),
    ("7", "cannot read or write"),
    ("8", "memory or time limit"),
    ("129, 130, 143", "interrupted by SIGHUP, Ctrl-C, SIGTERM"),
];

/// The files of an output directory.
pub(crate) const FILES: [(&str, &str); 15] = [
    ("report.json", "everything: status, certificate, results, settings, timings; written last"),
    ("report.html", "the same for people: one page with figures, without network or script"),
    ("history.csv", "one row per iteration"),
    ("contact.csv", "initial gap, opening, pressure and friction along the contact line"),
    ("adaptive.csv", "one row per mesh of an adaptive run"),
    ("sweep.json, sweep.csv, sweep-2.csv", "rows of a sweep, and of its further panels"),
    ("figures/NAME.svg", "the figures of the page"),
    (
        "BODY.vtu",
        "a body for ParaView: displacement, reaction, stress, strain, density of the error. Open those of all bodies and press \
         Apply; choose von_mises_recovered in place of Solid Color; add the filter Warp By Vector",
    ),
    (
        "contact.vtu",
        "the contact line for ParaView: initial gap, opening, pressure, tractions, its part of the error",
    ),
    (
        "fields/BODY-step-NN.vtu, fields/contact-step-NN.vtu",
        "the same on every mesh of an adaptive run, or in every load step",
    ),
    ("adaptive.pvd", "all meshes of an adaptive run, bodies and contact line, for ParaView"),
    ("steps.pvd", "all load steps, bodies and contact line, for ParaView"),
    (
        "BODY.vtu.series, contact.vtu.series",
        "one body, or the contact line, on all meshes or in all load steps",
    ),
    ("checkpoint.nndd, checkpoint-previous.nndd", "the state from which --resume continues an adaptive run"),
    (".nndd.lock, .nndd-tmp-run", "lock of a run that is writing there; its files until it ends"),
];

/// The text below the options of the program.
pub(crate) fn of_program() -> String {
    let mut text = examples("");
    text += "\nExit status:\n";
    for (status, meaning) in EXIT_STATUS {
        let _ = writeln!(text, "  {status:<13} {meaning}");
    }
    text + "\n" + MANUAL
}

/// The text below the options of a command.
pub(crate) fn of_command(name: &str) -> String {
    examples(name) + "\n" + MANUAL
}

/// Where the meaning of an example begins.
const COLUMN: usize = 54;

const MANUAL: &str = "The whole manual: nndd man > nndd.1 && man ./nndd.1";

fn examples(of: &str) -> String {
    let mut text = String::from("Examples:\n");
    for example in EXAMPLES.iter().filter(|example| example.of == of) {
        let Example { line, meaning, .. } = example;
        // A long line has its meaning below it.
        let gap = match COLUMN.checked_sub(line.len()) {
            Some(blanks) => " ".repeat(blanks),
            None => format!("\n  {:<COLUMN$}", ""),
        };
        let _ = writeln!(text, "  {line}{gap} {meaning}");
    }
    text
}

//! The command `nndd`: solves contact between elastic bodies and certifies the answer. A library, so that
//! Cargo compiles it at the same time as the crates that it uses; the program is [`run`].

mod args;
mod certify;
mod check;
mod compare;
mod console;
mod help;
mod machine;
mod manual;
mod mesh;
mod printer;
mod progress;
mod signals;
mod solve;
mod sweep;
mod threads;

use args::{Arguments, Command};
use clap::{CommandFactory, Parser};
use nndd_report::{Failure, failure};
use std::io::ErrorKind;
use std::process::ExitCode;

/// Does what the command line asks for, and returns the exit status.
pub fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return no_command(&error),
    };
    match signals::outlive_file_size_limit().map_err(Failure::from).and_then(|()| dispatch(&arguments)) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            console::end(&failure, arguments.command.is_for_programs());
            ExitCode::from(failure.code)
        }
    }
}

/// Ends without a command: a wrong command line, or a request for help or the version.
fn no_command(error: &clap::Error) -> ExitCode {
    let code = match error.print() {
        Err(e) if !error.use_stderr() && e.kind() != ErrorKind::BrokenPipe => {
            console::failure(&Failure::from(console::full(e)));
            return ExitCode::from(failure::FILES);
        }
        _ => error.exit_code(),
    };
    ExitCode::from(u8::try_from(code).unwrap_or(1))
}

fn dispatch(arguments: &Arguments) -> Result<u8, Failure> {
    match &arguments.command {
        Command::Solve(options) => threads::run(options.run.threads, || solve::command(options)),
        Command::Check(options) => threads::run(0, || check::command(options)),
        Command::Sweep(options) => threads::run(options.run.threads, || sweep::command(options)),
        Command::Certify(options) => threads::run(options.threads, || certify::command(options)),
        Command::Compare(options) => compare::command(options),
        Command::Mesh(options) => threads::run(0, || mesh::command(options)),
        Command::New { template } => {
            let text = case_io::template::find(template).ok_or_else(|| {
                let known: Vec<&str> = case_io::template::TEMPLATES.iter().map(|(name, _)| *name).collect();
                Failure::command_line(format!(
                    "there is no template \"{template}\"\n  expected: {}\n  fix: write `nndd new {}`",
                    known.join(", "),
                    case_io::diagnostic::nearest(template, known.iter().copied()).unwrap_or("paper")
                ))
            })?;
            console::print(text)?;
            Ok(0)
        }
        Command::Man => {
            console::print(&manual::page())?;
            Ok(0)
        }
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::command(), "nndd", &mut script);
            console::print(&String::from_utf8_lossy(&script))?;
            Ok(0)
        }
    }
}

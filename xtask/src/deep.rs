//! `cargo xtask deep`: checks that need tools beyond the stable compiler. Each is skipped by name if its tool is not
//! there.
//!
//! No crate here has unsafe code (`[workspace.lints]` forbids it). The sanitizer and Miri look at the unsafe code of the
//! dependencies, as these crates call it.

use crate::workspace::{Outcome, Workspace, output, stream};
use std::process::Command;

/// Crates small enough for Miri: readers and the contact programme.
const INTERPRETED: [&str; 3] = ["mesh-io", "case-io", "contact-qp"];

/// Runs the checks and tells whether none failed.
pub(crate) fn run(workspace: &Workspace) -> Outcome<bool> {
    let checks = [
        ("licences and sources", licences as fn(&Workspace) -> Outcome<Option<bool>>),
        ("AddressSanitizer", address),
        ("Miri", miri),
    ];
    let mut sound = true;
    let mut rows = vec![];
    for (name, check) in checks {
        println!("== {name}");
        let verdict = match check(workspace) {
            Ok(Some(true)) => "ok".to_owned(),
            Ok(Some(false)) => "FAILED".to_owned(),
            Ok(None) => "skipped: its tool is not installed".to_owned(),
            Err(error) => format!("FAILED: {error}"),
        };
        sound &= !verdict.starts_with("FAILED");
        rows.push((name, verdict));
    }
    println!();
    for (name, verdict) in rows {
        println!("{name}: {verdict}");
    }
    Ok(sound)
}

/// A cargo command of the nightly compiler in the top folder.
fn nightly(workspace: &Workspace, arguments: &[&str]) -> Command {
    let mut command = Command::new("rustup");
    command.current_dir(&workspace.root).args(["run", "nightly", "cargo"]).args(arguments);
    // The cargo that runs this task has set these variables for its own compiler.
    for variable in ["CARGO", "RUSTUP_TOOLCHAIN", "RUSTC", "RUSTDOC"] {
        command.env_remove(variable);
    }
    command
}

fn passes(mut command: Command) -> Outcome<Option<bool>> {
    Ok(Some(stream(&mut command)? == Some(0)))
}

/// Licences, versions and sources of all dependencies against `deny.toml`.
fn licences(workspace: &Workspace) -> Outcome<Option<bool>> {
    if output(&mut workspace.cargo(&["deny", "--version"])).is_err() {
        return Ok(None);
    }
    passes(workspace.cargo(&["deny", "check", "licenses", "bans", "sources"]))
}

/// The unit tests of the libraries with every access to memory checked.
fn address(workspace: &Workspace) -> Outcome<Option<bool>> {
    let Ok(version) = output(&mut nightly(workspace, &["--version", "--verbose"])) else { return Ok(None) };
    let Some(host) = version.lines().find_map(|line| line.strip_prefix("host: ")) else { return Ok(None) };
    let mut command = nightly(workspace, &["test", "--workspace", "--release", "--lib", "--target", host]);
    // Tests of bounded memory count allocations themselves, which the sanitizer makes larger.
    command.env("RUSTFLAGS", "-Zsanitizer=address").env("CARGO_TARGET_DIR", workspace.target.join("address"));
    passes(command)
}

/// The unit tests of small crates, interpreted.
fn miri(workspace: &Workspace) -> Outcome<Option<bool>> {
    if output(&mut nightly(workspace, &["miri", "--version"])).is_err() {
        return Ok(None);
    }
    let mut command = nightly(workspace, &["miri", "test", "--lib"]);
    for package in INTERPRETED {
        command.args(["--package", package]);
    }
    command
        .env("MIRIFLAGS", "-Zmiri-disable-isolation")
        .env("CARGO_TARGET_DIR", workspace.target.join("miri"));
    passes(command)
}

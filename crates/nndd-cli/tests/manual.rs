//! `--help` and `nndd man`: complete, of one mind, and readable.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const COMMANDS: [&str; 8] = ["solve", "check", "sweep", "compare", "mesh", "new", "man", "completions"];

fn nndd(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The page without roff's escapes, as far as options need it.
fn plain(page: &str) -> String {
    ["\\fB", "\\fI", "\\fR"].iter().fold(page.replace("\\-", "-"), |text, font| text.replace(font, ""))
}

#[test]
fn the_manual_page_has_every_option_of_every_command() {
    let page = nndd(&["man"]);
    assert!(page.contains(".TH nndd 1"), "{page}");
    let text = plain(&page);
    for command in COMMANDS {
        let (_, section) = text.split_once(&format!(".SS \"nndd {command}\"")).unwrap();
        let section = section.split("\n.S").next().unwrap();
        let help = nndd(&[command, "--help"]);
        let options = help.lines().filter_map(|line| {
            let option = line.trim_start().split(", ").find(|word| word.starts_with("--"))?;
            Some(option.split(' ').next().unwrap())
        });
        for option in options.filter(|option| *option != "--help") {
            assert!(
                section.contains(&format!("{option} ")) || section.contains(&format!("{option}\n")),
                "{option}"
            );
        }
        let example = format!("nndd {command} case.toml");
        assert_eq!(help.contains(&example), section.contains(&example), "{command}");
    }
    for head in ["EXIT STATUS", "FILES", "ENVIRONMENT", "EXAMPLES"] {
        assert!(text.contains(&format!(".SH \"{head}\"")) || text.contains(&format!(".SH {head}")), "{head}");
    }
    assert!(text.contains("report.json") && text.contains("129, 130, 143"));
    // No page that does not exist is referred to.
    assert!(!COMMANDS.iter().any(|command| text.contains(&format!("nndd-{command}"))), "{text}");
}

#[test]
fn the_manual_page_names_every_file_of_a_run() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/adaptive.toml");
    nndd(&["solve", "--quiet", case.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let page = plain(&nndd(&["man"]));
    let mut seen = 0;
    for folder in ["", "figures", "fields"] {
        for entry in std::fs::read_dir(out.join(folder)).unwrap().map(Result::unwrap) {
            if entry.path().is_dir() {
                continue;
            }
            let name = entry.file_name().into_string().unwrap();
            let general = match folder {
                "figures" => "figures/NAME.svg".to_owned(),
                "fields" => format!("fields/{}-step-NN.vtu", name.split("-step-").next().unwrap()),
                _ => name,
            };
            let general = ["upper", "lower"].iter().fold(general, |name, body| name.replace(body, "BODY"));
            assert!(page.contains(&general), "{general}");
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn help_leads_to_the_manual() {
    assert!(nndd(&["--help"]).contains("nndd man"));
    let solve = nndd(&["solve", "--help"]);
    for part in ["Input:", "Output:", "Running:", "Examples:", "nndd man"] {
        assert!(solve.contains(part), "{part}");
    }
}

#[test]
fn the_manual_page_is_shown_without_complaint() {
    let shown = Command::new("man")
        .args(["--warnings", "-l", "-"])
        .env("MANWIDTH", "80")
        .env("MANPAGER", "cat")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let Ok(mut man) = shown else {
        eprintln!("skipped: man is not installed");
        return;
    };
    man.stdin.take().unwrap().write_all(nndd(&["man"]).as_bytes()).unwrap();
    let output = man.wait_with_output().unwrap();
    let (text, said) = (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    );
    if !output.status.success() {
        eprintln!("skipped: this man does not read from a pipe: {said}");
        return;
    }
    assert!(said.is_empty(), "{said}");
    assert!(text.contains("EXIT STATUS") && text.contains("--resume"), "{text}");
    // Nothing of the source is left over.
    assert!(!text.lines().any(|line| line.trim_start().starts_with(".T")), "{text}");
}

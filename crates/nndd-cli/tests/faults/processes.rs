//! Signals, limits, several runs at once, threads and environments.

use super::*;
use std::process::{Child, Stdio};

/// A run that takes a while: many iterations on a finer mesh, each with a relaxed estimate.
pub(crate) fn long_run(out: &Path) -> Child {
    long(nndd(&cases()), &cases().join("paper.toml"), out)
}

/// The same by another command.
pub(crate) fn long(mut command: Command, case: &Path, out: &Path) -> Child {
    command.arg("solve").arg(case).arg("--out").arg(out).args([
        "--set",
        "body.0.generator.cells=[72,36]",
        "--set",
        "body.1.generator.cells=[72,36]",
        "--set",
        "solver.max_iterations=1000000",
        "--set",
        "solver.stop.criterion=iterations",
        "--set",
        "estimator.every=1",
    ]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

pub(crate) fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Waits until the first iteration is printed, then lets a thread read the rest.
pub(crate) fn wait_for_iterations(child: &mut Child) {
    use std::io::{BufRead, BufReader, Read};
    let mut lines = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while lines.read_line(&mut line).unwrap() > 0 && !line.trim_start().starts_with("2 ") {
        line.clear();
    }
    std::thread::spawn(move || lines.read_to_end(&mut Vec::new()));
}

#[test]
fn a_signal_ends_the_run_with_its_certificate() {
    // SIGTERM ends a run as Ctrl-C does, with the status of its own signal.
    for (name, code) in [("INT", 130), ("TERM", 143)] {
        let temp = tempfile::tempdir().unwrap();
        let out = temp.path().join("out");
        let mut child = long_run(&out);
        wait_for_iterations(&mut child);
        signal(&child, name);
        let status = child.wait().unwrap();
        assert_eq!(status.code(), Some(code));
        let report = report(&out);
        assert_eq!((report.status.word.as_str(), i32::from(report.status.code)), ("interrupted", code));
        assert!(report.certificate.as_ref().unwrap().valid);
        assert_eq!(report.iterations.len(), report.iterations.last().unwrap().iteration);
        whole_files(&out);
        assert!(!out.join(".nndd.lock").exists());
    }
}

#[test]
fn a_second_signal_ends_the_run_at_once() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    // A mesh whose factorisation alone takes far longer than the time between the two signals.
    let cells = ["body.0.generator.cells=[400,200]", "body.1.generator.cells=[400,200]"];
    let mut command = nndd(&cases());
    command.args(["solve", "paper.toml", "--quiet", "--set", cells[0], "--set", cells[1], "--out"]).arg(&out);
    let mut child = command.spawn().unwrap();
    wait_until("the output directory", || out.exists());
    signal(&child, "INT");
    std::thread::sleep(Duration::from_millis(20));
    signal(&child, "TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert!(!out.join("report.json").exists());
    // The lock that it left behind does not block another run.
    let again = solve(&cases().join("paper.toml"), &out, &[]);
    assert_eq!(again.status.code(), Some(0), "{}", said(&again));
}

#[test]
fn a_reader_that_goes_away_costs_nothing() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let mut command = nndd(&cases());
    command.args(["solve", "paper.toml", "--out"]).arg(&out).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.lines().all(|line| line.is_empty() || line.starts_with("note: ")), "{errors}");
    assert!(report(&out).certificate.as_ref().unwrap().valid);
}

#[test]
fn a_killed_run_leaves_whole_files_and_can_be_run_again() {
    // An adaptive run writes while it is running.
    killed_and_run_again("adaptive.toml", &[]);
}

#[test]
fn a_killed_run_of_an_assembly_leaves_whole_files_and_can_be_run_again() {
    // An obstacle with a stamp, and a rigid side.
    for case in ["press.toml", "plate.toml"] {
        killed_and_run_again(case, &["--set", "adapt.target_relative_error=0.02"]);
    }
}

/// Kills runs of a case when they have written some files, and runs it again each time.
fn killed_and_run_again(case: &str, settings: &[&str]) {
    let temp = tempfile::tempdir().unwrap();
    let whole = temp.path().join("whole");
    let case = cases().join(case);
    assert_eq!(solve(&case, &whole, settings).status.code(), Some(0));
    let (expected, all) = (numbers(&whole), whole_files(&whole));
    let mut killed = 0;
    for wanted in [1, 2, 4, 6, all - 1] {
        let out = temp.path().join(wanted.to_string());
        let mut command = nndd(&cases());
        command.arg("solve").arg(&case).arg("--out").arg(&out).args(settings);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        wait_until("files of the run", || {
            out.exists() && files_below_if_quiet(&out) >= wanted || child.try_wait().unwrap().is_some()
        });
        child.kill().unwrap();
        let status = child.wait().unwrap();
        whole_files(&out);
        killed += usize::from(status.code().is_none());
        assert_eq!(solve(&case, &out, &[settings, &["--force"]].concat()).status.code(), Some(0));
        assert_eq!(
            numbers(&out).replace(&*out.to_string_lossy(), ""),
            expected.replace(&*whole.to_string_lossy(), "")
        );
    }
    assert!(killed > 0, "no run was killed in time");
}

/// Counts files while they come and go.
fn files_below_if_quiet(directory: &Path) -> usize {
    let count = |path: &Path| {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        entries.filter(|e| e.path().is_file() && !e.file_name().to_string_lossy().starts_with('.')).count()
    };
    ["", "fields", "figures"].iter().map(|below| count(&directory.join(below))).sum()
}

#[test]
fn too_little_memory_is_said_before_anything_is_computed() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(&cases().join("paper.toml"), &out, &["--set", "limits.memory=\"1MiB\""]);
    assert_eq!(output.status.code(), Some(8));
    let text = said(&output);
    assert!(text.contains("limits.memory is 1MiB, enough for about") && text.contains("380 nodes"), "{text}");
    assert!(!out.exists());
}

#[test]
fn the_time_limit_keeps_the_certificate() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(&cases().join("paper.toml"), &out, &["--set", "limits.time=\"0.000001s\""]);
    assert_eq!(output.status.code(), Some(8), "{}", said(&output));
    let report = report(&out);
    assert!(report.status.reason.contains("limits.time") && report.certificate.as_ref().unwrap().valid);
}

#[test]
fn two_runs_do_not_share_a_directory() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let mut first = long_run(&out);
    wait_for_iterations(&mut first);
    for more in [&[][..], &["--force"]] {
        let second = solve(&cases().join("paper.toml"), &out, more);
        assert_eq!(second.status.code(), Some(7));
        let text = said(&second);
        assert!(text.contains(&format!("in use by another run (process {})", first.id())), "{text}");
    }
    signal(&first, "TERM");
    assert_eq!(first.wait().unwrap().code(), Some(143));
    whole_files(&out);
}

#[test]
fn any_number_of_threads_gives_the_same_numbers() {
    let temp = tempfile::tempdir().unwrap();
    let paper = cases().join("paper.toml");
    let out = temp.path().join("out");
    let automatic = ["--set", "solver.acceleration=anderson", "--set", "solver.theta=auto", "--force"];
    for settings in [&[][..], &automatic] {
        let all = ["0", "1", "2", "7", "64", "2"].map(|threads| {
            let output = solve(&paper, &out, &[settings, &["--threads", threads]].concat());
            assert_eq!(output.status.code(), Some(0), "{}", said(&output));
            numbers(&out)
        });
        assert!(all.iter().all(|one| *one == all[0]));
    }
    // Decision: not any number is accepted, since to start tens of thousands takes minutes.
    for threads in ["-1", "1025", "1000000", "two"] {
        let output = solve(&paper, &temp.path().join("none"), &["--threads", threads]);
        assert_eq!(output.status.code(), Some(2), "{threads}: {}", said(&output));
    }
    assert!(!temp.path().join("none").exists());
}

#[test]
fn threads_that_do_not_start_are_said() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    // Room for the program, not for the stacks of this many threads.
    let script = "ulimit -v 600000; exec \"$0\" solve \"$1\" --out \"$2\" --threads 1024";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_nndd")]).arg(cases().join("paper.toml")).arg(&out);
    let output = command.output().unwrap();
    let text = said(&output);
    assert_eq!(output.status.code(), Some(8), "{text}");
    assert!(text.contains("cannot start 1024 threads"), "{text}");
    assert!(!out.exists());
}

#[test]
fn the_environment_does_not_matter() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let run = |change: &dyn Fn(&mut Command)| {
        let mut command = nndd(&cases());
        command.args(["solve", "paper.toml", "--out"]).arg(&out);
        change(&mut command);
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        (said(&output), numbers(&out))
    };
    let usual = run(&|_| {});
    let changes: [&dyn Fn(&mut Command); 5] = [
        &|c| _ = c.env("LC_ALL", "de_DE.UTF-8").env("LANG", "de_DE.UTF-8").env("LC_NUMERIC", "de_DE.UTF-8"),
        &|c| _ = c.env("TZ", "Pacific/Chatham"),
        &|c| _ = c.env("TZ", "no such zone").env_remove("HOME"),
        &|c| _ = c.env("COLUMNS", "20").env("NO_COLOR", "1").env("TERM", "dumb"),
        &|c| _ = c.env_clear(),
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let found = run(change);
        assert!(found == usual, "change {k}: {}\n{}", found.0, usual.0);
    }
}

#[test]
fn a_narrow_terminal_shows_the_same() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let usual = solve(&cases().join("paper.toml"), &out, &[]);
    let inner = format!("stty cols 20 rows 5; exec {} solve paper.toml --out {}", program(), out.display());
    let mut command = Command::new("script");
    command.args(["-qec", &inner]).arg(temp.path().join("typescript")).current_dir(cases());
    let Some(output) = command.env("NO_COLOR", "1").stdin(Stdio::null()).output().ok() else {
        eprintln!("skipped, there is no program `script` that makes a terminal");
        return;
    };
    let shown = said(&output).replace("\r\n", "\n");
    // If the machine is busy, a progress bar is written and erased: keep the text after it.
    let seen = |line: &str| line.rsplit("\r\u{1b}[K").next().unwrap_or_default().to_owned() + "\n";
    let shown: String = shown.lines().map(seen).collect();
    assert!(!shown.contains('\u{1b}'), "{shown}");
    let lines = |text: &str| {
        text.lines().filter(|l| l.starts_with("certified")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(lines(&shown), lines(&said(&usual)), "{shown}");
}

/// The program's path as a word of a shell.
fn program() -> String {
    format!("'{}'", env!("CARGO_BIN_EXE_nndd").replace('\'', "'\\''"))
}

#[test]
fn more_memory_than_the_machine_has_is_said_at_once() {
    // No limit is given, so the memory of the machine is the limit. This many nodes need a terabyte.
    let memory = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let total = memory
        .lines()
        .find_map(|l| l.strip_prefix("MemTotal:")?.trim().strip_suffix("kB")?.trim().parse().ok());
    if total.is_none_or(|kibibytes: u64| kibibytes > 800 << 20) {
        eprintln!("skipped, this machine does not say how much memory it has, or has a lot");
        return;
    }
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let cells = ["body.0.generator.cells=[11000,11000]", "body.1.generator.cells=[11000,11000]"];
    let output = solve(&cases().join("paper.toml"), &out, &["--set", cells[0], "--set", cells[1]]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(8), "{text}");
    assert!(text.contains("are needed for 242044002 nodes; this machine has"), "{text}");
    assert!(!out.exists());
}

#[test]
fn times_are_never_negative() {
    // The program times with the system's monotonic clock, which a test cannot turn back; it can only see that what
    // is reported is sound.
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    assert_eq!(solve(&cases().join("paper.toml"), &out, &[]).status.code(), Some(0));
    let t = report(&out).timings;
    let parts = [t.mesh, t.assembly, t.factorisation, t.iterations, t.estimate, t.write];
    assert!(parts.iter().all(|x| x.is_finite() && *x >= 0.0), "{parts:?}");
    assert!(t.total > 0.0);
}

//! `nndd solve --resume`: an adaptive run that was killed, limited or interrupted gives the same numbers.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::checkpoint::{NEWEST, PREVIOUS};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// Six meshes or more, the last ones of which take long enough to be killed while they are solved.
const SETTINGS: [&str; 3] = ["adapt.target_relative_error=0.012", "output.vtu=true", "limits.time=\"10min\""];

fn command(case: &str, out: &Path, settings: &[&str], more: &[&str]) -> Command {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(case);
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.arg("solve").arg(case).arg("--out").arg(out).args(more);
    for setting in settings {
        command.args(["--set", setting]);
    }
    command.current_dir(out.parent().unwrap());
    command
}

fn solve(out: &Path, settings: &[&str], more: &[&str]) -> Output {
    command("adaptive.toml", out, settings, more).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// The report less what may differ between two runs, and what `run` says.
fn report(out: &Path) -> (String, serde_json::Value) {
    let text = std::fs::read_to_string(out.join("report.json")).unwrap();
    let mut report: serde_json::Value = serde_json::from_str(&text).unwrap();
    let object = report.as_object_mut().unwrap();
    object.remove("timings").unwrap();
    let run = object.remove("run").unwrap();
    // Two directories are not two cases.
    report["case"]["output"].as_object_mut().unwrap().remove("directory");
    (report.to_string(), run)
}

/// The checkpoint's body, or nothing without a checkpoint.
fn checkpoint(out: &Path) -> Option<serde_json::Value> {
    let text = std::fs::read_to_string(out.join(NEWEST)).ok()?;
    serde_json::from_str(text.split_once('\n')?.1).ok()
}

fn meshes_in(checkpoint: &serde_json::Value) -> usize {
    checkpoint["progress"]["meshes"].as_array().map_or(0, Vec::len)
}

fn files(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}

fn same_files(a: &Path, b: &Path) {
    let relative = |root: &Path| -> Vec<PathBuf> {
        files(root).iter().map(|f| f.strip_prefix(root).unwrap().to_owned()).collect()
    };
    assert_eq!(relative(a), relative(b));
    for file in relative(a).iter().filter(|f| f.extension().is_some_and(|e| e == "vtu" || e == "csv")) {
        assert_eq!(std::fs::read(a.join(file)).unwrap(), std::fs::read(b.join(file)).unwrap(), "{file:?}");
    }
}

/// Kills a run (with SIGKILL) as soon as its checkpoint has this many finer meshes; false if it was too late.
fn kill_at(mut child: Child, out: &Path, meshes: usize) -> bool {
    while checkpoint(out).is_none_or(|c| meshes_in(&c) < meshes) {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(std::time::Duration::from_micros(200));
    }
    child.kill().unwrap();
    !child.wait().unwrap().success()
}

/// Starts a run, and resumes it, killing it at each of these numbers of finer meshes. On a busy machine a run may come
/// to its end before it is killed; then everything starts again.
fn killed(case: &str, out: &Path, settings: &[&str], meshes: &[usize]) {
    for _ in 0..20 {
        let _ = std::fs::remove_dir_all(out);
        let all = meshes.iter().enumerate().all(|(k, &meshes)| {
            let more: &[&str] = if k == 0 { &[] } else { &["--resume"] };
            let mut command = command(case, out, settings, more);
            kill_at(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap(), out, meshes)
        });
        if all {
            return;
        }
    }
    panic!("no run could be killed in time");
}

#[test]
fn a_killed_run_goes_on_to_the_same_numbers() {
    let temp = tempfile::tempdir().unwrap();
    let (whole, killed_run) = (temp.path().join("whole"), temp.path().join("killed"));
    let output = solve(&whole, &SETTINGS, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(!whole.join(NEWEST).exists() && !whole.join(PREVIOUS).exists());
    // Killed three times, further on each time; the second and third time while it is being resumed.
    killed("adaptive.toml", &killed_run, &SETTINGS, &[1, 2, 3]);
    assert!(!killed_run.join("report.json").exists());
    // Without --resume nothing of it is touched.
    let refused = solve(&killed_run, &SETTINGS, &[]);
    assert_eq!(refused.status.code(), Some(7));
    assert!(said(&refused).contains("--resume"), "{}", said(&refused));
    let resumed = solve(&killed_run, &SETTINGS, &["--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    assert!(said(&resumed).contains("the run continues with mesh"), "{}", said(&resumed));
    let ((expected, _), (found, run)) = (report(&whole), report(&killed_run));
    assert_eq!(found, expected);
    assert!(run["resumed_on_mesh"].as_u64().unwrap() >= 4);
    let meshes = run["adaptive_seconds"].as_array().unwrap();
    assert!(meshes.windows(2).all(|w| w[0].as_f64() <= w[1].as_f64()), "{meshes:?}");
    same_files(&whole, &killed_run);
    // It is complete now.
    let again = solve(&killed_run, &SETTINGS, &["--resume"]);
    assert_eq!(again.status.code(), Some(7));
    assert!(said(&again).contains("has finished (converged)"), "{}", said(&again));
}

#[test]
fn killed_runs_of_assemblies_go_on_to_the_same_numbers() {
    // A stamp that moves freely, a rigid side that does, friction, and solids.
    for (case, setting) in [
        ("press.toml", "adapt.target_relative_error=0.008"),
        ("plate.toml", "adapt.target_relative_error=0.008"),
        ("tresca.toml", "adapt.target_relative_error=0.012"),
        ("coulomb.toml", "adapt.target_coulomb_residual=0.012"),
        ("solid/adaptive.toml", "adapt.target_relative_error=0.23"),
    ] {
        let temp = tempfile::tempdir().unwrap();
        let (whole, killed_run) = (temp.path().join("whole"), temp.path().join("killed"));
        let settings = [setting];
        let run = |out: &Path, more: &[&str]| command(case, out, &settings, more).output().unwrap();
        let output = run(&whole, &[]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        killed(case, &killed_run, &settings, &[1, 3]);
        let output = run(&killed_run, &["--resume"]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert!(said(&output).contains("the run continues with mesh"), "{}", said(&output));
        assert_eq!(report(&killed_run).0, report(&whole).0, "{case}");
        same_files(&killed_run, &whole);
    }
}

#[test]
fn a_run_killed_on_its_first_mesh_begins_again() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    killed("singular.toml", &out, &[], &[0]);
    let resumed = command("singular.toml", &out, &[], &["--resume"]).output().unwrap();
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    let whole = temp.path().join("whole");
    assert_eq!(command("singular.toml", &whole, &[], &[]).output().unwrap().status.code(), Some(0));
    assert_eq!(report(&out).0, report(&whole).0);
}

/// A run that a time limit ended on its first mesh, with checkpoint.
fn limited(out: &Path) -> Output {
    let mut settings = SETTINGS.to_vec();
    settings[2] = "limits.time=\"0.000001s\"";
    solve(out, &settings, &[])
}

#[test]
fn a_limit_may_be_raised_to_go_on() {
    let temp = tempfile::tempdir().unwrap();
    let (whole, out) = (temp.path().join("whole"), temp.path().join("out"));
    let time = limited(&out);
    assert_eq!(time.status.code(), Some(8), "{}", said(&time));
    assert!(out.join(NEWEST).exists() && out.join("report.json").exists());
    let resumed = solve(&out, &SETTINGS, &["--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    assert_eq!(solve(&whole, &SETTINGS, &[]).status.code(), Some(0));
    assert_eq!(report(&out).0, report(&whole).0);
    same_files(&whole, &out);
    // The memory limit ends a run between two meshes; resumed under the same limit it ends there again.
    let (small, large) = ("limits.memory=\"22MiB\"", "limits.memory=\"4GiB\"");
    let out = temp.path().join("memory");
    let first = solve(&out, &[SETTINGS[0], small], &[]);
    assert_eq!(first.status.code(), Some(8), "{}", said(&first));
    let before = report(&out).0;
    let again = solve(&out, &[SETTINGS[0], small], &["--resume"]);
    assert_eq!((again.status.code(), report(&out).0), (Some(8), before));
    let resumed = solve(&out, &[SETTINGS[0], large], &["--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    let whole = temp.path().join("memory-whole");
    assert_eq!(solve(&whole, &[SETTINGS[0], large], &[]).status.code(), Some(0));
    assert_eq!(report(&out).0, report(&whole).0);
    same_files(&whole, &out);
}

#[test]
fn what_could_go_on_is_not_thrown_away() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let time = limited(&out);
    assert_eq!(time.status.code(), Some(8), "{}", said(&time));
    assert!(said(&time).contains("continue with --resume"), "{}", said(&time));
    let before: Vec<Vec<u8>> = files(&out).iter().map(|f| std::fs::read(f).unwrap()).collect();
    // Neither the limit nor the title makes another case.
    let mut titled = SETTINGS.to_vec();
    titled.push("title=\"the same again\"");
    for settings in [&SETTINGS[..], &titled] {
        let refused = solve(&out, settings, &[]);
        assert_eq!(refused.status.code(), Some(7), "{}", said(&refused));
        assert!(said(&refused).contains("holds an unfinished run"), "{}", said(&refused));
        assert!(said(&refused).contains("fix: continue it with --resume"), "{}", said(&refused));
        let after: Vec<Vec<u8>> = files(&out).iter().map(|f| std::fs::read(f).unwrap()).collect();
        assert!(before == after);
    }
    let forced = solve(&out, &titled, &["--force"]);
    assert_eq!(forced.status.code(), Some(0), "{}", said(&forced));
    assert!(!out.join(NEWEST).exists());
    // Complete now, and so replaced.
    assert_eq!(solve(&out, &titled, &[]).status.code(), Some(0));
}

#[test]
fn a_changed_case_says_what_differs() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    assert_eq!(limited(&out).status.code(), Some(8));
    let before: Vec<Vec<u8>> = files(&out).iter().map(|f| std::fs::read(f).unwrap()).collect();
    let mut settings = SETTINGS.to_vec();
    settings.extend(["materials.soft.young=1001.0", "adapt.fraction=0.6"]);
    let refused = solve(&out, &settings, &["--resume"]);
    assert_eq!(refused.status.code(), Some(3), "{}", said(&refused));
    for words in
        ["materials.soft.young was 1000.0 and is 1001.0", "adapt.fraction was 0.5 and is 0.6", "fix: "]
    {
        assert!(said(&refused).contains(words), "{words}: {}", said(&refused));
    }
    let after: Vec<Vec<u8>> = files(&out).iter().map(|f| std::fs::read(f).unwrap()).collect();
    assert!(before == after);
}

#[test]
fn the_older_checkpoint_serves_where_the_newest_is_damaged() {
    let temp = tempfile::tempdir().unwrap();
    let (whole, out) = (temp.path().join("whole"), temp.path().join("out"));
    killed("adaptive.toml", &out, &SETTINGS, &[2]);
    let mut bytes = std::fs::read(out.join(NEWEST)).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(out.join(NEWEST), bytes).unwrap();
    let resumed = solve(&out, &SETTINGS, &["--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    assert!(
        said(&resumed).contains("checkpoint.nndd is damaged; the run resumes from"),
        "{}",
        said(&resumed)
    );
    assert_eq!(solve(&whole, &SETTINGS, &[]).status.code(), Some(0));
    assert_eq!(report(&out).0, report(&whole).0);
    same_files(&whole, &out);
    // Neither can be used.
    let out = temp.path().join("both");
    assert_eq!(limited(&out).status.code(), Some(8));
    for name in [NEWEST, PREVIOUS] {
        std::fs::write(out.join(name), "nndd checkpoint 2 00\n{}").unwrap();
    }
    let refused = solve(&out, &SETTINGS, &["--resume"]);
    assert_eq!(refused.status.code(), Some(7));
    assert!(said(&refused).contains("no checkpoint in"), "{}", said(&refused));
}

#[test]
fn there_must_be_something_to_go_on_with() {
    let temp = tempfile::tempdir().unwrap();
    let nowhere = solve(&temp.path().join("nowhere"), &SETTINGS, &["--resume"]);
    assert_eq!(nowhere.status.code(), Some(7));
    assert!(said(&nowhere).contains("was ever started in"), "{}", said(&nowhere));
    let plain = command("paper.toml", &temp.path().join("plain"), &[], &["--resume"]).output().unwrap();
    assert_eq!(plain.status.code(), Some(2));
    assert!(said(&plain).contains("has no [adapt]"), "{}", said(&plain));
    let both = solve(&temp.path().join("both"), &SETTINGS, &["--resume", "--force"]);
    assert_eq!(both.status.code(), Some(2));
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on() {
    let temp = tempfile::tempdir().unwrap();
    let (whole, out) = (temp.path().join("whole"), temp.path().join("out"));
    let interrupted = || {
        let _ = std::fs::remove_dir_all(&out);
        let mut command = command("adaptive.toml", &out, &SETTINGS, &[]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while checkpoint(&out).is_none_or(|c| meshes_in(&c) < 2) && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
        child.wait().unwrap().code() == Some(143)
    };
    assert!((0..20).any(|_| interrupted()), "no run could be interrupted in time");
    assert!(report(&out).0.contains("\"interrupted\"") && report(&out).0.contains("continue with --resume"));
    let resumed = solve(&out, &SETTINGS, &["--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    assert_eq!(solve(&whole, &SETTINGS, &[]).status.code(), Some(0));
    assert_eq!(report(&out).0, report(&whole).0);
    same_files(&whole, &out);
}

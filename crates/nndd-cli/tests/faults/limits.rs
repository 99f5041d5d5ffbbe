//! Limits of memory, file size and time, and what is left behind when one of them ends a run.

use super::processes::{long_run, signal, wait_for_iterations};
use super::*;
use std::process::Stdio;

/// The entries of a directory; empty if it is not there.
fn entries(directory: &Path) -> Vec<String> {
    let names = std::fs::read_dir(directory).into_iter().flatten();
    names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

/// Every file under a directory with its content.
fn contents(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all: Vec<_> =
        files_below(directory).into_iter().map(|f| (f.clone(), std::fs::read(f).unwrap())).collect();
    all.sort();
    all
}

#[test]
fn a_limit_of_the_address_space_ends_a_run_with_8_and_leaves_nothing() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let mut codes = Vec::new();
    // From just enough to start the program to plenty, in kibibytes.
    for k in 0..20 {
        let limit = 60_000.0 * 100f64.powf(f64::from(k) / 19.0);
        let mut command = Command::new("sh");
        let script = "ulimit -v $3; exec \"$0\" solve \"$1\" --out \"$2\" --threads 2";
        command.args(["-c", script, env!("CARGO_BIN_EXE_nndd")]).arg(cases().join("adaptive.toml")).arg(&out);
        let output = command.arg(format!("{limit:.0}")).output().unwrap();
        let text = said(&output);
        let code = output.status.code();
        assert!(matches!(code, Some(0 | 8)), "{limit:.0}: {code:?} {text}");
        if code == Some(8) && !out.join("report.json").exists() {
            assert!(text.contains("are needed") && text.contains("ulimit -v"), "{text}");
            assert_eq!(entries(&out), [""; 0], "{limit:.0}: {text}");
        }
        let _ = std::fs::remove_dir_all(&out);
        codes.push(code);
    }
    assert_eq!((codes[0], codes[19]), (Some(8), Some(0)), "{codes:?}");
}

#[test]
fn if_memory_is_short_coefficients_are_computed_again_and_the_bound_is_the_same() {
    let temp = tempfile::tempdir().unwrap();
    let whole = ["--set", "solver.subdomains=1"];
    let runs = [("plenty", "4GiB", false), ("short", "45MiB", true)].map(|(name, limit, is_short)| {
        let out = temp.path().join(name);
        let limit = format!("limits.memory=\"{limit}\"");
        let more = [&whole[..], &["--set", &limit]].concat();
        let output = solve(&cases().join("solid/subdomains.toml"), &out, &more);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert_eq!(said(&output).contains("since memory is short"), is_short, "{}", said(&output));
        let report = std::fs::read_to_string(out.join("report.json")).unwrap();
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        [report["certificate"].to_string(), report["iterations"].to_string()]
    });
    assert_eq!(runs[0], runs[1]);
}

#[test]
fn a_generous_memory_limit_does_not_hide_what_the_machine_has() {
    let temp = tempfile::tempdir().unwrap();
    let cells = ["body.0.generator.cells=[11000,11000]", "body.1.generator.cells=[11000,11000]"];
    let more = ["--set", cells[0], "--set", cells[1], "--set", "limits.memory=\"8000GiB\""];
    if !Path::new("/proc/meminfo").exists() {
        eprintln!("skipped: this system does not say how much memory it has");
        return;
    }
    let output = solve(&cases().join("paper.toml"), &temp.path().join("out"), &more);
    assert_eq!(output.status.code(), Some(8), "{}", said(&output));
    assert!(said(&output).contains("leaves") || said(&output).contains("free"), "{}", said(&output));
}

#[test]
fn the_limit_of_a_control_group_is_kept() {
    // Both versions; only root can make a group, and only if the system has one of them.
    let name = format!("nndd-test-{}", std::process::id());
    let versions = [("/sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("/sys/fs/cgroup", "memory.max")];
    let mut tried = 0;
    for (mount, limit) in versions {
        let group = Path::new(mount).join(&name);
        if std::fs::create_dir(&group).is_err() {
            continue;
        }
        // The kernel makes the files of a group; anything else is only a directory.
        if !group.join(limit).exists() {
            std::fs::remove_dir(&group).unwrap();
            continue;
        }
        let script = "echo 67108864 > \"$3/$4\" && echo $$ > \"$3/cgroup.procs\" || exit 99; \
                      exec \"$0\" solve \"$1\" --out \"$2\" --set body.0.generator.cells=[200,100]";
        let temp = tempfile::tempdir().unwrap();
        let mut command = Command::new("sh");
        command.args(["-c", script, env!("CARGO_BIN_EXE_nndd")]).arg(cases().join("paper.toml"));
        let output = command.arg(temp.path().join("out")).arg(&group).arg(limit).output().unwrap();
        let _ = std::fs::remove_dir(&group);
        if output.status.code() == Some(99) {
            continue;
        }
        assert_eq!(output.status.code(), Some(8), "{}", said(&output));
        assert!(said(&output).contains("the limit of the control group leaves"), "{}", said(&output));
        assert!(!temp.path().join("out").exists());
        tried += 1;
    }
    if tried == 0 {
        eprintln!("skipped: no control group can be made here");
    }
}

#[test]
fn a_file_size_limit_leaves_nothing_that_blocks_the_next_run() {
    let temp = tempfile::tempdir().unwrap();
    for case in ["paper.toml", "adaptive.toml"] {
        let mut codes = Vec::new();
        for blocks in [0, 4, 40, 100, 300, 4000] {
            let out = temp.path().join(format!("{case}-{blocks}"));
            // The usual signal of the limit, which ends a program that does not expect it.
            let output = prepared(&format!("ulimit -c 0; ulimit -f {blocks}"), &cases().join(case), &out);
            let code = output.status.code();
            assert!(matches!(code, Some(0 | 7)), "{case} {blocks}: {code:?} {}", said(&output));
            if code == Some(7) {
                assert!(said(&output).contains("raise the limit of the file size"), "{}", said(&output));
                assert!(!out.join("report.json").exists());
            }
            let next = solve(&cases().join(case), &out, &[]);
            assert_eq!(next.status.code(), Some(0), "{case} {blocks}: {}", said(&next));
            assert!(entries(&out).iter().all(|name| !name.starts_with('.')), "{:?}", entries(&out));
            codes.push(code);
        }
        assert_eq!((codes[0], codes[5]), (Some(7), Some(0)), "{case}: {codes:?}");
    }
}

#[test]
fn a_run_that_could_not_write_may_be_resumed() {
    let temp = tempfile::tempdir().unwrap();
    let (out, whole) = (temp.path().join("out"), temp.path().join("whole"));
    let case = cases().join("adaptive.toml");
    assert_eq!(solve(&case, &whole, &[]).status.code(), Some(0));
    // Some mesh is the first one whose files are too large.
    let failed = [400, 300, 200, 100].into_iter().any(|blocks| {
        let output = prepared(&format!("ulimit -f {blocks}"), &case, &out);
        assert!(matches!(output.status.code(), Some(0 | 7)), "{}", said(&output));
        said(&output).contains("--resume")
    });
    assert!(failed, "no limit ended the run after its first mesh");
    let resumed = solve(&case, &out, &["--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    let same = |path: &Path| numbers(path).replace(&*path.to_string_lossy(), "");
    assert_eq!(same(&out), same(&whole));
    assert_eq!(whole_files(&out), whole_files(&whole));
}

#[test]
fn force_on_a_full_disk_loses_nothing() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let paper = cases().join("paper.toml");
    assert_eq!(solve(&paper, &out, &["--set", "solver.theta=0.3"]).status.code(), Some(0));
    std::fs::write(out.join("notes.txt"), "mine\n").unwrap();
    let before = contents(&out);
    // The result of another case, with room for the first files only, then for all but the largest.
    for blocks in [0, 8, 40, 100] {
        let script =
            format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" solve \"$1\" --out \"$2\" --force");
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_nndd")]).arg(&paper).arg(&out);
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(7), "{blocks}: {}", said(&output));
        assert!(contents(&out) == before, "{blocks}: {:?}", entries(&out));
    }
    // With room it is replaced, and what is not ours stays.
    assert_eq!(solve(&paper, &out, &["--force"]).status.code(), Some(0));
    assert_eq!(std::fs::read_to_string(out.join("notes.txt")).unwrap(), "mine\n");
    assert!(contents(&out) != before && whole_files(&out) > 5);
}

#[test]
fn a_time_limit_names_the_longest_step_and_may_end_a_run_before_its_first_iterate() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let limited = |cells: &str| {
        let cells = ["0", "1"].map(|body| format!("body.{body}.generator.cells={cells}"));
        let time = "limits.time=\"0.000001s\"";
        solve(&cases().join("paper.toml"), &out, &["--set", &cells[0], "--set", &cells[1], "--set", time])
    };
    // Time for one iteration and its certificate is given.
    let output = limited("[18,9]");
    assert_eq!(output.status.code(), Some(8), "{}", said(&output));
    let found = report(&out);
    assert!(
        found.certificate.as_ref().unwrap().valid && found.status.reason.contains("the longest step"),
        "{}",
        found.status.reason
    );
    let step = &found.run["longest_step"];
    assert!(step["step"].is_string() && step["seconds"].as_f64().unwrap() > 0.0, "{step}");
    // Assembly and factorisation of this one take longer than that on any machine: there is no iterate to report.
    std::fs::remove_dir_all(&out).unwrap();
    let output = limited("[900,450]");
    let text = said(&output);
    assert_eq!(output.status.code(), Some(8), "{text}");
    // A busy machine may end it from outside, within one step.
    let within = text.contains("before there was a result");
    let between = text.contains("before the first iteration") && text.contains("the longest step");
    assert!(within || between && !out.exists(), "{text}");
}

#[test]
fn an_output_directory_removed_in_mid_run_ends_it_at_once() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let mut child = long_run(&out);
    wait_for_iterations(&mut child);
    std::fs::remove_dir_all(&out).unwrap();
    // Nobody sends a signal; the iterations alone would take hours.
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(7), "{}", said(&output));
    assert!(
        said(&output).contains("was removed or replaced while the run was using it"),
        "{}",
        said(&output)
    );
    assert!(!out.exists());
}

#[test]
fn a_lost_terminal_ends_the_run_with_its_certificate_unless_it_is_ignored() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    // The tests themselves may run under nohup, which a program inherits.
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP", env!("CARGO_BIN_EXE_nndd")]).stdin(Stdio::null());
    let mut child = processes::long(command, &cases().join("paper.toml"), &out);
    wait_for_iterations(&mut child);
    signal(&child, "HUP");
    assert_eq!(child.wait().unwrap().code(), Some(129));
    let found = report(&out);
    assert_eq!((found.status.word.as_str(), found.status.code), ("interrupted", 129));
    assert!(found.certificate.as_ref().unwrap().valid);
    // As nohup does it.
    let mut command = Command::new("sh");
    command.args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_nndd")]).stdin(Stdio::null());
    let out = temp.path().join("ignored");
    let mut child = processes::long(command, &cases().join("paper.toml"), &out);
    wait_for_iterations(&mut child);
    signal(&child, "HUP");
    std::thread::sleep(Duration::from_millis(100));
    assert!(child.try_wait().unwrap().is_none());
    signal(&child, "TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert_eq!(report(&out).status.code, 143);
}

#[test]
fn threads_from_the_environment_are_capped_like_those_of_the_command_line() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let run = |count: &str, command: &[&str]| {
        let mut run = nndd(&cases());
        run.env("RAYON_NUM_THREADS", count).args(command).arg("paper.toml");
        if command[0] != "check" {
            run.arg("--out").arg(&out);
        }
        run.output().unwrap()
    };
    for count in ["1025", "1000000", "99999999999999999999999"] {
        for command in [&["solve"][..], &["check"], &["sweep", "--over", "solver.theta=0.4"]] {
            let output = run(count, command);
            assert_eq!(output.status.code(), Some(2), "{count} {command:?}: {}", said(&output));
            assert!(said(&output).contains("RAYON_NUM_THREADS is 1") || count.starts_with('9'));
        }
    }
    assert!(!out.exists());
    // A value that rayon does not read has no effect, nor has a value that the command line overrides.
    assert_eq!(run("many", &["solve"]).status.code(), Some(0));
    assert_eq!(run("1000000", &["solve", "--threads", "3"]).status.code(), Some(0));
    assert_eq!(report(&out).run["threads"], 3);
}

#[test]
fn twenty_thousand_unused_materials_give_twenty_warnings() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("many.toml");
    let mut text = std::fs::read_to_string(cases().join("paper.toml")).unwrap();
    text.extend((0..20_000).map(|k| format!("\n[materials.spare_{k}]\nyoung = 1.0\npoisson = 0.495\n")));
    std::fs::write(&case, text).unwrap();
    let out = temp.path().join("out");
    let output = solve(&case, &out, &[]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(0), "{}", &text[..text.len().min(4000)]);
    assert_eq!(text.matches("warning[").count(), 21);
    assert!(text.contains("and 39980 more warnings") && text.len() < 30_000, "{} bytes", text.len());
    assert_eq!(
        report(&out)
            .notes
            .iter()
            .filter(|note| note.contains("spare_") || note.contains("incompressible"))
            .count(),
        20
    );
}

/// Blocks side by side on one body, too many to be checked within a second.
fn many_blocks() -> String {
    let mut text = "schema = 1\n[materials.a]\nyoung = 1000.0\npoisson = 0.2\n".to_owned();
    let count = 20_000;
    let mut body = |name: &str, [x, y]: [usize; 2], width: usize, cells: usize, condition: &str| {
        text += &format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"a\"\ngenerator = {{ kind = \"block\", origin = [{x}.0, {y}.0], \
             size = [{width}.0, 1.0], cells = [{cells}, 1] }}\n[[body.displacement]]\non = {condition}\n"
        );
    };
    body("base", [0, 0], 2 * count, 2 * count, "\"bottom\"\nfixed = true");
    for k in 0..count {
        body(&format!("b{k}"), [2 * k, 1], 1, 2, "\"left\"\nux = 0.0");
    }
    for k in 0..count {
        text += &format!("[[contact]]\nbodies = [\"b{k}\", \"base\"]\nsurfaces = [\"bottom\", \"top\"]\n");
    }
    text
}

#[test]
fn the_time_limit_ends_work_that_has_no_result_in_whatever_loop_it_is() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("many.toml");
    std::fs::write(&case, many_blocks()).unwrap();
    let out = temp.path().join("out");
    for command in ["check", "solve", "certify", "sweep"] {
        let mut run = nndd(temp.path());
        run.arg(command).arg(&case).args(["--set", "limits.time=\"0.001s\""]);
        match command {
            "solve" => run.arg("--out").arg(&out),
            "certify" => run.arg("--displacement").arg("none.vtu"),
            "sweep" => run.args(["--over", "solver.theta=[0.4, 0.5]", "--out"]).arg(&out),
            _ => &mut run,
        };
        let output = run.output().unwrap();
        assert_eq!(output.status.code(), Some(8), "{command}: {}", said(&output));
        let text = said(&output);
        assert!(text.contains("limits.time = 0.001 s reached") && text.contains("in making"), "{text}");
        // A sweep opens its directory before its first run; a stale lock does not keep the next one out.
        assert!(!out.join("sweep.json").exists() && (command == "sweep" || !out.exists()), "{command}");
    }
}

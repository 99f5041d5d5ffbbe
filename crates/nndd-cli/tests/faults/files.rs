//! Files and directories that are not what they should be, and disks that are full.

use super::*;
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{PermissionsExt, symlink};

#[test]
fn what_is_no_case_file_is_refused_at_once() {
    let temp = tempfile::tempdir().unwrap();
    let here = temp.path();
    let fifo = here.join("fifo.toml");
    if Command::new("mkfifo").arg(&fifo).status().is_ok_and(|s| s.success()) {
        let output = solve(&fifo, &here.join("out"), &[]);
        assert_eq!(output.status.code(), Some(7));
        assert!(said(&output).contains("not a regular file"));
    } else {
        eprintln!("skipped the pipe, there is no mkfifo");
    }
    let output = solve(here, &here.join("out"), &[]);
    assert_eq!(output.status.code(), Some(7));
    assert!(said(&output).contains("a directory, not a case file"));
    let large = here.join("large.toml");
    // Sparse: it takes no room.
    std::fs::File::create(&large).unwrap().set_len(2 << 30).unwrap();
    let output = solve(&large, &here.join("out"), &[]);
    assert_eq!(output.status.code(), Some(7));
    assert!(said(&output).contains("this is not a case file"));
    assert!(!here.join("out").exists());
}

#[test]
fn output_directories_that_cannot_be() {
    let temp = tempfile::tempdir().unwrap();
    let here = temp.path();
    let paper = cases().join("paper.toml");
    std::fs::write(here.join("file"), "precious").unwrap();
    for out in ["file", "file/below"] {
        let output = solve(&paper, &here.join(out), &[]);
        assert_eq!(output.status.code(), Some(7), "{out}: {}", said(&output));
    }
    assert_eq!(std::fs::read_to_string(here.join("file")).unwrap(), "precious");
    // A missing one is created, with those above it.
    assert_eq!(solve(&paper, &here.join("a/b/c"), &[]).status.code(), Some(0));
}

/// The program as run by a user who may not write everywhere; `None` if that cannot be arranged.
fn as_nobody() -> Option<Command> {
    let root = Command::new("id").arg("-u").output().ok()?.stdout == b"0\n";
    let command = || {
        // Who is not root is good enough.
        let mut command = Command::new(if root { "setpriv" } else { "env" });
        if root {
            command.args(["--reuid", "65534", "--regid", "65534", "--clear-groups"]);
        }
        command.arg(env!("CARGO_BIN_EXE_nndd"));
        command
    };
    // The program may be in a folder that this user cannot read.
    let probe = command().arg("--version").output().ok()?;
    if !probe.status.success() {
        eprintln!("skipped, there is nobody else to run the program");
        return None;
    }
    Some(command())
}

#[test]
fn an_unreadable_mesh_file_is_said() {
    let temp = open_folder();
    let mesh = temp.path().join("sound.msh");
    std::fs::copy(cases().join("bad/meshes/sound.msh"), &mesh).unwrap();
    std::fs::set_permissions(&mesh, std::fs::Permissions::from_mode(0o000)).unwrap();
    let Some(mut command) = as_nobody() else { return };
    let output = command.arg("mesh").arg(&mesh).output().unwrap();
    assert_eq!(output.status.code(), Some(7), "{}", said(&output));
    assert!(
        said(&output).contains("sound.msh") && said(&output).contains("cannot be read"),
        "{}",
        said(&output)
    );
}

#[test]
fn what_this_user_may_not_read_is_told_to_be_allowed() {
    let temp = open_folder();
    let here = temp.path();
    for name in ["sound.msh", "case.toml", "whole.inp"] {
        std::fs::write(here.join(name), "").unwrap();
        std::fs::set_permissions(here.join(name), std::fs::Permissions::from_mode(0o000)).unwrap();
    }
    std::fs::write(here.join("open.inp"), "*INCLUDE, INPUT=whole.inp\n").unwrap();
    let case = std::fs::read_to_string(cases().join("bad/mesh_unknown_side.toml")).unwrap();
    std::fs::write(here.join("open.toml"), case.replace("meshes/sound.msh", "sound.msh")).unwrap();
    for arguments in
        [["mesh", "sound.msh"], ["mesh", "open.inp"], ["check", "case.toml"], ["check", "open.toml"]]
    {
        let Some(mut command) = as_nobody() else { return };
        let output = command.current_dir(here).args(arguments).output().unwrap();
        let text = said(&output);
        assert_eq!(output.status.code(), Some(7), "{arguments:?}: {text}");
        assert!(
            text.contains("allow this user to read it") && !text.contains("check the name"),
            "{arguments:?}: {text}"
        );
    }
}

#[test]
fn a_dangling_link_is_said_to_be_one() {
    let temp = tempfile::tempdir().unwrap();
    let here = temp.path();
    for name in ["dl", "dl.toml", "dl.msh"] {
        symlink("nowhere", here.join(name)).unwrap();
    }
    let paper = cases().join("paper.toml");
    let paper = paper.to_str().unwrap();
    let adaptive = cases().join("adaptive.toml");
    let adaptive = adaptive.to_str().unwrap();
    let case = std::fs::read_to_string(cases().join("bad/mesh_unknown_side.toml")).unwrap();
    std::fs::write(here.join("mesh.toml"), case.replace("meshes/sound.msh", "dl.msh")).unwrap();
    for arguments in [
        &["solve", paper, "--out", "dl"][..],
        &["solve", paper, "--out", "dl/below"],
        &["solve", paper, "--out", "dl", "--force"],
        &["solve", adaptive, "--out", "dl", "--resume"],
        &["sweep", paper, "--over", "solver.theta=0.4:0.5:0.1", "--out", "dl"],
        &["solve", "dl.toml"],
        &["check", "dl.toml"],
        &["check", "mesh.toml"],
        &["mesh", "dl.msh"],
    ] {
        let output = nndd(here).args(arguments).output().unwrap();
        let text = said(&output);
        assert_eq!(output.status.code(), Some(7), "{arguments:?}: {text}");
        // Long lines may be broken.
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            words.contains("is a link to ") && words.contains("nowhere, which does not exist"),
            "{arguments:?}: {text}"
        );
        assert!(!text.contains("File exists") && !text.contains("No such file"), "{arguments:?}: {text}");
    }
    assert!(!here.join("nowhere").exists());
}

/// A temporary directory into which everybody may look.
fn open_folder() -> tempfile::TempDir {
    let temp = tempfile::tempdir().unwrap();
    std::fs::set_permissions(temp.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
    temp
}

#[test]
fn an_output_directory_without_leave_to_write_is_said() {
    let temp = open_folder();
    let locked = temp.path().join("locked");
    std::fs::create_dir(&locked).unwrap();
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).unwrap();
    let case = temp.path().join("paper.toml");
    std::fs::copy(cases().join("paper.toml"), &case).unwrap();
    for out in [locked.clone(), locked.join("below")] {
        let Some(mut command) = as_nobody() else { return };
        let output = command.arg("solve").arg(&case).arg("--out").arg(&out).output().unwrap();
        assert_eq!(output.status.code(), Some(7), "{}", said(&output));
        assert!(said(&output).contains("locked"), "{}", said(&output));
    }
    assert_eq!(files_below(&locked).len(), 0);
}

#[test]
fn an_output_directory_that_becomes_read_only_is_said() {
    let temp = open_folder();
    let out = temp.path().join("out");
    std::fs::create_dir(&out).unwrap();
    let allow = |mode| std::fs::set_permissions(&out, std::fs::Permissions::from_mode(mode)).unwrap();
    allow(0o777);
    let case = temp.path().join("paper.toml");
    std::fs::copy(cases().join("paper.toml"), &case).unwrap();
    let Some(command) = as_nobody() else { return };
    let mut child = processes::long(command, &case, &out);
    processes::wait_for_iterations(&mut child);
    allow(0o555);
    processes::signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(7), "{}", said(&output));
    assert!(said(&output).contains("cannot write"), "{}", said(&output));
    whole_files(&out);
    assert!(!out.join("report.json").exists());
}

#[test]
fn an_output_directory_that_becomes_a_file_is_said() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let mut child = processes::long_run(&out);
    processes::wait_for_iterations(&mut child);
    std::fs::remove_dir_all(&out).unwrap();
    std::fs::write(&out, "precious").unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(7));
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "precious");
}

/// Sizes from "nothing fits" to "everything fits", as the shell counts them (512 bytes each).
const BLOCKS: [usize; 7] = [0, 1, 4, 16, 40, 100, 4000];

#[test]
fn a_disk_that_fills_up_leaves_no_cut_file() {
    // The limit of the file size replaces a full disk: with its signal ignored a write fails as on a full disk.
    for case in ["paper", "press", "plate"] {
        let temp = tempfile::tempdir().unwrap();
        let mut codes = Vec::new();
        for blocks in BLOCKS {
            let out = temp.path().join(blocks.to_string());
            let file = cases().join(case).with_extension("toml");
            let output = prepared(&format!("trap '' XFSZ; ulimit -f {blocks}"), &file, &out);
            let code = output.status.code().unwrap();
            assert!(code == 0 || code == 7, "{case} {blocks}: {}", said(&output));
            whole_files(&out);
            assert_eq!(out.join("report.json").exists(), code == 0, "{case} {blocks}");
            let left = files_below(&out).iter().any(|p| p.to_string_lossy().contains(".nndd-tmp-"));
            assert!(!left, "{case} {blocks}");
            codes.push(code);
        }
        assert_eq!((codes.first(), codes.last()), (Some(&7), Some(&0)), "{case}: {codes:?}");
    }
}

#[test]
fn a_death_in_the_middle_of_a_file_leaves_no_cut_file() {
    // Here the limit kills the program in the middle of a write, wherever that is.
    for case in ["paper.toml", "press.toml", "plate.toml"] {
        let temp = tempfile::tempdir().unwrap();
        for blocks in BLOCKS {
            let out = temp.path().join(blocks.to_string());
            prepared(&format!("ulimit -c 0; ulimit -f {blocks}"), &cases().join(case), &out);
            whole_files(&out);
        }
    }
}

#[test]
fn a_real_disk_that_is_full_leaves_no_cut_file() {
    // A disk of a few pages, in a space of its own; what lies on it is copied out of there before it goes.
    let temp = tempfile::tempdir().unwrap();
    let disk = temp.path().join("disk");
    std::fs::create_dir(&disk).unwrap();
    for size in ["8k", "40k", "120k"] {
        let kept = temp.path().join(size);
        let script = "mount -t tmpfs -o size=$1 tmpfs \"$2\" || exit 99; \"$0\" solve \"$3\" --out \"$2/out\"; code=$?; \
                      [ ! -e \"$2/out\" ] || cp -r \"$2/out\" \"$4\"; exit $code";
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", script, env!("CARGO_BIN_EXE_nndd"), size]);
        let output = command.arg(&disk).arg(cases().join("paper.toml")).arg(&kept).output();
        let Some(output) = output.ok().filter(|o| !matches!(o.status.code(), Some(1 | 99) | None)) else {
            eprintln!("skipped, no disk can be mounted here");
            return;
        };
        assert_eq!(output.status.code(), Some(7), "{size}: {}", said(&output));
        assert!(said(&output).contains("cannot write"), "{size}: {}", said(&output));
        whole_files(&kept);
        assert!(!kept.join("report.json").exists(), "{size}");
    }
}

#[test]
fn an_earlier_result_survives_a_full_disk() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let paper = cases().join("paper.toml");
    assert_eq!(solve(&paper, &out, &[]).status.code(), Some(0));
    let before = numbers(&out);
    let output = prepared("trap '' XFSZ; ulimit -f 8", &paper, &out);
    assert_eq!(output.status.code(), Some(7), "{}", said(&output));
    assert_eq!(numbers(&out), before);
    whole_files(&out);
}

#[test]
fn a_full_console_is_said() {
    if !Path::new("/dev/full").exists() {
        eprintln!("skipped, there is no /dev/full");
        return;
    }
    let temp = tempfile::tempdir().unwrap();
    let mut command = nndd(temp.path());
    command.arg("solve").arg(cases().join("paper.toml")).stdout(std::fs::File::create("/dev/full").unwrap());
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(7));
    assert!(said(&output).contains("cannot write to standard output"), "{}", said(&output));
    assert!(!temp.path().join("runs").exists());
}

#[test]
fn a_full_console_is_said_by_every_command() {
    if !Path::new("/dev/full").exists() {
        eprintln!("skipped, there is no /dev/full");
        return;
    }
    let temp = tempfile::tempdir().unwrap();
    let paper = cases().join("paper.toml");
    let paper = paper.to_str().unwrap();
    let commands: [&[&str]; 7] = [
        &["--help"],
        &["--version"],
        &["solve", "--help"],
        &["check", paper],
        &["sweep", paper, "--over", "solver.theta=0.4"],
        &["solve", paper, "--format", "json"],
        &["new", "paper"],
    ];
    for arguments in commands {
        let mut command = nndd(temp.path());
        let output =
            command.args(arguments).stdout(std::fs::File::create("/dev/full").unwrap()).output().unwrap();
        assert_eq!(output.status.code(), Some(7), "{arguments:?}: {}", said(&output));
        assert!(said(&output).contains("cannot write to standard output"), "{}", said(&output));
    }
    assert_eq!(std::fs::read_dir(temp.path()).unwrap().count(), 0);
}

#[test]
fn exits_without_a_result_leave_no_directory() {
    let temp = tempfile::tempdir().unwrap();
    let bad = cases().join("bad");
    for (case, code) in [("case_nearly_singular.toml", 4), ("case_infinite_lambda.toml", 3)] {
        let out = temp.path().join("made/for").join(case);
        let output = solve(&bad.join(case), &out, &[]);
        assert_eq!(output.status.code(), Some(code), "{case}: {}", said(&output));
        assert_eq!(std::fs::read_dir(temp.path()).unwrap().count(), 0, "{case}");
        // One that was there stays.
        let out = temp.path().join("there");
        std::fs::create_dir(&out).unwrap();
        assert_eq!(solve(&bad.join(case), &out, &[]).status.code(), Some(code));
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 0, "{case}");
        std::fs::remove_dir(&out).unwrap();
    }
}

#[test]
fn paths_of_every_kind() {
    let temp = tempfile::tempdir().unwrap();
    let here = temp.path();
    let paper = cases().join("paper.toml");
    for name in [OsStr::new("mit Leerzeichen ä 上 \"'"), OsStr::from_bytes(b"not \xFF text")] {
        let folder = here.join(name);
        if std::fs::create_dir(&folder).is_err() {
            eprintln!("skipped {name:?}, this file system does not take it");
            continue;
        }
        std::fs::copy(&paper, folder.join("case.toml")).unwrap();
        let output = solve(&folder.join("case.toml"), &folder.join(name), &[]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        whole_files(&folder.join(name));
        assert!(report(&folder.join(name)).certificate.as_ref().unwrap().valid);
    }
    symlink(here.join("one"), here.join("two")).unwrap();
    symlink(here.join("two"), here.join("one")).unwrap();
    assert_eq!(solve(&here.join("one"), &here.join("out"), &[]).status.code(), Some(7));
    assert_eq!(solve(&paper, &here.join("one/out"), &[]).status.code(), Some(7));
    let long = here.join("x".repeat(300));
    assert_eq!(solve(&long, &here.join("out"), &[]).status.code(), Some(7));
    assert_eq!(solve(&paper, &long, &[]).status.code(), Some(7));
    // Long as a whole, but each part is allowed.
    let deep = here.join(["y".repeat(100), "y".repeat(100), "y".repeat(100)].join("/"));
    assert_eq!(solve(&paper, &deep, &[]).status.code(), Some(0));
}

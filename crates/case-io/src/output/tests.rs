//! The rules of a directory of results.

use super::lock::LOCK_FILE;
use super::*;
use crate::report::tests::sample;
use std::fs;

fn names(path: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(path).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Leaves a complete result behind.
fn run(path: &Path, hash: &str, force: bool, extra: &[&str]) -> Result<(), OutputError> {
    let mut output = OutputDirectory::open(path, ResultKind::Solve, hash, force)?;
    for name in extra {
        output.write(name, name.as_bytes())?;
    }
    output.write("report.json", sample(hash).to_json().unwrap().as_bytes())?;
    output.finish()
}

#[test]
fn a_missing_directory_is_created_and_an_empty_one_is_fine() {
    let root = tempfile::tempdir().unwrap();
    let deep = root.path().join("runs/über a/paper");
    run(&deep, "h", false, &["figures/a.svg", "upper.vtu"]).unwrap();
    assert_eq!(names(&deep), ["figures", "report.json", "upper.vtu"]);
    let empty = root.path().join("empty");
    fs::create_dir(&empty).unwrap();
    assert!(run(&empty, "h", false, &[]).is_ok());
}

#[test]
fn the_same_case_is_replaced_and_its_old_files_go() {
    let root = tempfile::tempdir().unwrap();
    run(root.path(), "h", false, &["figures/a.svg", "upper.vtu", "history.csv"]).unwrap();
    fs::write(root.path().join("notes.txt"), "mine").unwrap();
    run(root.path(), "h", false, &["history.csv"]).unwrap();
    assert_eq!(names(root.path()), ["figures", "history.csv", "notes.txt", "report.json"]);
    assert_eq!(names(&root.path().join("figures")), Vec::<String>::new());
}

#[test]
fn another_case_needs_force() {
    let root = tempfile::tempdir().unwrap();
    run(root.path(), "h", false, &["upper.vtu"]).unwrap();
    assert!(matches!(run(root.path(), "other", false, &[]), Err(OutputError::OtherCase { .. })));
    assert_eq!(names(root.path()), ["report.json", "upper.vtu"]);
    let mut output = OutputDirectory::open(root.path(), ResultKind::Solve, "other", true).unwrap();
    assert!(output.replaces_a_result());
    output.write("lower.vtu", b"new").unwrap();
    // Dropped here, the run has changed nothing.
    drop(output);
    assert_eq!(names(root.path()), ["report.json", "upper.vtu"]);
    run(root.path(), "other", true, &["lower.vtu"]).unwrap();
    assert_eq!(names(root.path()), ["lower.vtu", "report.json"]);
}

#[test]
fn a_run_that_ends_without_result_leaves_no_directory() {
    let root = tempfile::tempdir().unwrap();
    let deep = root.path().join("a/b/c");
    let mut output = OutputDirectory::open(&deep, ResultKind::Solve, "h", false).unwrap();
    output.write("figures/a.svg", b"half").unwrap();
    assert!(deep.is_dir());
    drop(output);
    assert_eq!(names(root.path()), Vec::<String>::new());
}

#[test]
fn a_run_killed_while_its_files_take_their_places_blocks_nothing() {
    let root = tempfile::tempdir().unwrap();
    fs::create_dir(root.path().join(STAGING)).unwrap();
    fs::write(root.path().join("history.csv"), "1").unwrap();
    fs::write(root.path().join("upper.vtu"), "1").unwrap();
    run(root.path(), "h", false, &["history.csv"]).unwrap();
    assert_eq!(names(root.path()), ["history.csv", "report.json"]);
    // Beside a foreign file it is refused as well.
    fs::remove_file(root.path().join("report.json")).unwrap();
    fs::create_dir(root.path().join(STAGING)).unwrap();
    fs::write(root.path().join("thesis.tex"), "mine").unwrap();
    assert!(matches!(run(root.path(), "h", false, &[]), Err(OutputError::NotOurs { .. })));
}

#[cfg(unix)]
#[test]
fn a_directory_that_was_removed_is_not_made_again() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("out");
    let mut output = OutputDirectory::open(&path, ResultKind::Solve, "h", false).unwrap();
    let presence = output.presence();
    assert!(presence.lasts());
    fs::remove_dir_all(&path).unwrap();
    assert!(!presence.lasts());
    assert!(matches!(output.write("a.csv", b"1"), Err(OutputError::Vanished { .. })));
    // Another one of that name is not the same.
    fs::create_dir(&path).unwrap();
    assert!(matches!(output.write("a.csv", b"1"), Err(OutputError::Vanished { .. })));
    drop(output);
    assert!(path.is_dir());
}

#[test]
fn a_result_with_a_checkpoint_beside_it_is_not_complete() {
    let root = tempfile::tempdir().unwrap();
    run(root.path(), "h", false, &[CHECKPOINT_BEFORE]).unwrap();
    match run(root.path(), "h", false, &[]) {
        Err(error @ OutputError::Unfinished { .. }) => assert!(error.to_string().contains("unfinished")),
        other => panic!("{other:?}"),
    }
    assert!(matches!(run(root.path(), "other", false, &[]), Err(OutputError::OtherCase { .. })));
    assert_eq!(names(root.path()), [CHECKPOINT_BEFORE, "report.json"]);
    run(root.path(), "h", true, &[]).unwrap();
    assert_eq!(names(root.path()), ["report.json"]);
}

#[test]
fn a_solve_and_a_sweep_are_kept_apart() {
    let root = tempfile::tempdir().unwrap();
    run(root.path(), "h", false, &["upper.vtu"]).unwrap();
    for (kind, hash) in [(ResultKind::Sweep, "h"), (ResultKind::Sweep, "s")] {
        let refused = OutputDirectory::open(root.path(), kind, hash, false);
        assert!(matches!(refused, Err(OutputError::OtherCase { .. })), "{refused:?}");
    }
    let mut sweep = OutputDirectory::open(root.path(), ResultKind::Sweep, "s", true).unwrap();
    for name in ["sweep.csv", "sweep-2.csv"] {
        sweep.write(name, b"1").unwrap();
    }
    sweep.write("sweep.json", br#"{"run": {"case_hash": "s"}}"#).unwrap();
    sweep.finish().unwrap();
    assert_eq!(names(root.path()), ["sweep-2.csv", "sweep.csv", "sweep.json"]);
    assert!(matches!(run(root.path(), "s", false, &[]), Err(OutputError::OtherCase { .. })));
    let mut again = OutputDirectory::open(root.path(), ResultKind::Sweep, "s", false).unwrap();
    again.write("sweep.csv", b"2").unwrap();
    again.finish().unwrap();
    assert!(!root.path().join("sweep-2.csv").exists());
}

#[test]
fn anything_else_needs_force_and_stays() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("thesis.tex"), "mine").unwrap();
    match run(root.path(), "h", false, &[]) {
        Err(OutputError::NotOurs { found, .. }) => assert_eq!(found, "thesis.tex"),
        other => panic!("{other:?}"),
    }
    assert_eq!(names(root.path()), ["thesis.tex"]);
    run(root.path(), "h", true, &[]).unwrap();
    assert_eq!(names(root.path()), ["report.json", "thesis.tex"]);
    // A report that does not say which case it belongs to, or a broken one, is not a complete result.
    for broken in ["{}", "{", "not json"] {
        fs::write(root.path().join("report.json"), broken).unwrap();
        assert!(matches!(run(root.path(), "h", false, &[]), Err(OutputError::NotOurs { .. })), "{broken}");
    }
    let file = root.path().join("thesis.tex");
    assert!(matches!(run(&file, "h", true, &[]), Err(OutputError::NotADirectory { .. })));
    assert!(matches!(run(&file.join("below"), "h", true, &[]), Err(OutputError::Io { .. })));
}

#[test]
fn two_runs_cannot_share_a_directory() {
    let root = tempfile::tempdir().unwrap();
    let first = OutputDirectory::open(root.path(), ResultKind::Solve, "h", false).unwrap();
    match OutputDirectory::open(root.path(), ResultKind::Solve, "h", true) {
        Err(OutputError::Locked { holder, .. }) => assert_eq!(holder, Some(std::process::id())),
        other => panic!("{other:?}"),
    }
    drop(first);
    assert_eq!(names(root.path()), Vec::<String>::new());
    // A killed run leaves the file, not the lock; nor does its temporary file count as content.
    fs::write(root.path().join(LOCK_FILE), "99999").unwrap();
    fs::write(root.path().join(".nndd-tmp-abc"), "half").unwrap();
    assert!(OutputDirectory::open(root.path(), ResultKind::Solve, "h", false).is_ok());
}

#[test]
fn a_failing_write_leaves_the_old_file() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("history.csv");
    write_file(&path, |out| out.write_all(b"old")).unwrap();
    let full = || io::Error::from(io::ErrorKind::StorageFull);
    let error = write_file(&path, |out| out.write_all(b"ne").and_then(|()| Err(full()))).unwrap_err();
    assert!(error.to_string().starts_with("cannot write "), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(root.path()), ["history.csv"]);
}

#[test]
fn names_stay_below_the_directory() {
    let root = tempfile::tempdir().unwrap();
    let mut output = OutputDirectory::open(root.path(), ResultKind::Solve, "h", false).unwrap();
    for name in ["", "../x", "/tmp/x", "a/../../x", LOCK_FILE, "."] {
        assert!(matches!(output.write(name, b""), Err(OutputError::Name { .. })), "{name}");
    }
    output.write("a/b/c.txt", b"deep").unwrap();
    assert_eq!(output.written().collect::<Vec<_>>(), [Path::new("a/b/c.txt")]);
}

#[cfg(unix)]
#[test]
fn results_have_the_usual_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("a");
    write_file(&path, |out| out.write_all(b"x")).unwrap();
    fs::write(root.path().join("b"), b"x").unwrap();
    let mode = |name: &str| fs::metadata(root.path().join(name)).unwrap().permissions().mode();
    assert_eq!(mode("a"), mode("b"));
}

#[cfg(unix)]
mod links {
    use super::*;
    use std::os::unix::fs::symlink;

    /// A directory of results beside a file that is somebody else's.
    fn with_victim() -> (tempfile::TempDir, PathBuf, PathBuf) {
        let root = tempfile::tempdir().unwrap();
        let (victim, results) = (root.path().join("victim"), root.path().join("d"));
        fs::write(&victim, "mine").unwrap();
        fs::create_dir(&results).unwrap();
        (root, results, victim)
    }

    #[test]
    fn a_lock_that_is_a_link_is_not_followed() {
        let (_root, results, victim) = with_victim();
        let lock = results.join(LOCK_FILE);
        symlink("../victim", &lock).unwrap();
        for force in [false, true] {
            let error = run(&results, "h", force, &[]).unwrap_err();
            assert!(matches!(error, OutputError::Io { .. }), "{error}");
        }
        assert_eq!(fs::read_to_string(&victim).unwrap(), "mine");
        assert!(lock.is_symlink());
        // Nor is a file made where a broken link leads, or another name of a file written to.
        fs::remove_file(&lock).unwrap();
        symlink("../nothing", &lock).unwrap();
        assert!(run(&results, "h", true, &[]).is_err());
        assert!(!results.join("../nothing").exists());
        fs::remove_file(&lock).unwrap();
        fs::hard_link(&victim, &lock).unwrap();
        assert!(run(&results, "h", true, &[]).is_err());
        assert_eq!(fs::read_to_string(&victim).unwrap(), "mine");
        // The lock file that a killed run left behind is taken over.
        fs::remove_file(&lock).unwrap();
        fs::write(&lock, "123456789\n").unwrap();
        run(&results, "h", false, &[]).unwrap();
        assert_eq!(names(&results), ["report.json"]);
    }

    #[test]
    fn no_directory_of_results_is_a_link() {
        for below in ["figures", "fields"] {
            let (root, results, _) = with_victim();
            let elsewhere = root.path().join("elsewhere");
            fs::create_dir(&elsewhere).unwrap();
            fs::write(elsewhere.join("a.svg"), "mine").unwrap();
            fs::write(elsewhere.join("a.vtu"), "mine").unwrap();
            run(&results, "h", false, &["upper.vtu"]).unwrap();
            symlink("../elsewhere", results.join(below)).unwrap();
            for force in [false, true] {
                let refused = run(&results, "h", force, &[&format!("{below}/a.svg")]);
                assert!(matches!(refused, Err(OutputError::Link { .. })), "{refused:?}");
            }
            assert!(matches!(OutputDirectory::reopen(&results), Err(OutputError::Link { .. })));
            // A link that appears while the run continues.
            fs::remove_file(results.join(below)).unwrap();
            let mut output = OutputDirectory::open(&results, ResultKind::Solve, "h", false).unwrap();
            output.write(&format!("{below}/a.svg"), b"new").unwrap();
            symlink("../elsewhere", results.join(below)).unwrap();
            assert!(matches!(output.finish(), Err(OutputError::Link { .. })));
            assert_eq!(names(&elsewhere), ["a.svg", "a.vtu"]);
            assert_eq!(fs::read_to_string(elsewhere.join("a.svg")).unwrap(), "mine");
        }
    }

    #[test]
    fn collected_files_do_not_go_where_a_link_leads() {
        let (root, results, _) = with_victim();
        let elsewhere = root.path().join("elsewhere");
        fs::create_dir(&elsewhere).unwrap();
        fs::write(elsewhere.join("a.txt"), "mine").unwrap();
        symlink("../elsewhere", results.join(STAGING)).unwrap();
        assert!(matches!(OutputDirectory::reopen(&results), Err(OutputError::Link { .. })));
        // A run that begins removes the link, and nothing behind it.
        run(&results, "h", false, &["upper.vtu"]).unwrap();
        assert_eq!(names(&elsewhere), ["a.txt"]);
        assert_eq!(names(&results), ["report.json", "upper.vtu"]);
    }

    #[test]
    fn files_that_are_links_are_replaced_themselves() {
        let (_root, results, victim) = with_victim();
        run(&results, "h", false, &["upper.vtu"]).unwrap();
        for name in ["report.json", "upper.vtu"] {
            let kept = fs::read(results.join(name)).unwrap();
            fs::write(&victim, &kept).unwrap();
            fs::remove_file(results.join(name)).unwrap();
            symlink("../victim", results.join(name)).unwrap();
            run(&results, "h", true, &["upper.vtu", "new.vtu"]).unwrap();
            assert_eq!(fs::read(&victim).unwrap(), kept);
            assert!(!results.join(name).is_symlink());
        }
        // Checkpoints are renamed and written likewise.
        fs::write(&victim, "mine").unwrap();
        symlink("../victim", results.join(CHECKPOINT)).unwrap();
        let mut output = OutputDirectory::reopen(&results).unwrap();
        for _ in 0..3 {
            output.write_after_renaming(CHECKPOINT, CHECKPOINT_BEFORE, &[b"state"]).unwrap();
            assert_eq!(fs::read_to_string(&victim).unwrap(), "mine");
        }
    }

    #[test]
    fn a_record_that_has_no_end_is_not_read() {
        let (_root, results, _) = with_victim();
        symlink("/dev/zero", results.join("report.json")).unwrap();
        symlink("/dev/zero", results.join(CHECKPOINT)).unwrap();
        assert!(matches!(run(&results, "h", false, &[]), Err(OutputError::NotOurs { .. })));
        assert!(crate::checkpoint::read(&results).is_err());
        run(&results, "h", true, &[]).unwrap();
    }
}

//! report.html as a browser sees it; without Chromium only its text is checked.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stderr)]

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Solves a case and returns its output directory.
fn solved(case: &str, folder: &Path) -> PathBuf {
    let out = folder.join(case);
    assert_eq!(run(case, &out, &[]), Some(0));
    out
}

/// Solves a case with further arguments; the exit status.
fn run(case: &str, out: &Path, more: &[&str]) -> Option<i32> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(format!("{case}.toml"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.args(["solve", "--quiet", "--out"]).arg(out).arg(&file).args(more);
    command.status().unwrap().code()
}

fn page(out: &Path) -> String {
    std::fs::read_to_string(out.join("report.html")).unwrap()
}

/// Chromium, by the names under which systems install it.
fn chromium() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&folders).flat_map(|f| names.map(|n| f.join(n))).find(|p| p.is_file())
}

/// Returns what Chromium says about a page, on stdout and stderr; it is killed after some minutes.
fn looked_at(browser: &Path, page: &Path, profile: &Path, width: u32) -> (String, String) {
    let (dom, log) = (profile.join("dom"), profile.join("log"));
    std::fs::create_dir_all(profile).unwrap();
    let mut child = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--dump-dom"])
        .arg(format!("--window-size={width},900"))
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("file://{}", page.display()))
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&dom).unwrap())
        .stderr(std::fs::File::create(&log).unwrap())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(300) {
            child.kill().unwrap();
            panic!("Chromium does not come to an end");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    (std::fs::read_to_string(dom).unwrap(), std::fs::read_to_string(log).unwrap())
}

/// Everything the page loads or links to.
fn references(page: &str) -> Vec<&str> {
    ["src=\"", "href=\"", "url(", "@import"]
        .iter()
        .flat_map(|key| page.split(key).skip(1).map(|rest| rest.split(['"', ')']).next().unwrap_or("")))
        .collect()
}

#[test]
fn the_page_needs_nothing_but_itself() {
    let temp = tempfile::tempdir().unwrap();
    let out = solved("hertz", temp.path());
    let page = page(&out);
    assert!(!page.contains("<script"));
    for reference in references(&page) {
        assert!(out.join(reference).is_file(), "\"{reference}\" is not beside the page");
    }
    // Every figure has an alternative text; the seventh title is the page's.
    let figures = page.matches("<figure>").count();
    assert_eq!((figures, page.matches("role=\"img\" aria-label=").count()), (6, 6));
    assert_eq!((page.matches("<title>").count(), page.matches("<desc>").count()), (7, 6));
    assert!(page.contains("@page{size:A4"));
    // The gap is drawn as it is, so displacements are not magnified.
    assert!(page.contains("displacements × 1)"));
}

#[test]
fn of_many_contact_lines_those_with_the_largest_forces_are_drawn() {
    const CIRCLES: usize = 40;
    let here = tempfile::tempdir().unwrap();
    let mut case = format!(
        "schema = 1\n[materials.a]\nyoung = 1000.0\npoisson = 0.2\n[[body]]\nname = \"beam\"\nmaterial = \"a\"\n\
         generator = {{ kind = \"block\", origin = [0.0, 0.0], size = [{CIRCLES}.0, 1.0], cells = [{}, 1] }}\n\
         [[body.displacement]]\non = \"left\"\nux = 0.0\n[[body.traction]]\non = \"top\"\npressure = \"1+x\"\n",
        2 * CIRCLES
    );
    for k in 0..CIRCLES {
        case += &format!(
            "[[contact]]\nname = \"c{k}\"\nbodies = [\"beam\"]\nsurfaces = [\"bottom\"]\ngap = \"geometric\"\n\
             obstacle = {{ kind = \"circle\", centre = [{k}.5, -1.0], radius = 1.0 }}\n"
        );
    }
    std::fs::write(here.path().join("many.toml"), case).unwrap();
    let out = here.path().join("out");
    assert_eq!(run(here.path().join("many").to_str().unwrap(), &out, &[]), Some(0));
    let is_drawn = |k: usize| out.join(format!("figures/contact-c{k}.svg")).is_file();
    // The load grows along the beam.
    assert_eq!((0..CIRCLES).map(is_drawn).collect::<Vec<_>>(), [vec![false; 8], vec![true; 32]].concat());
    assert!(page(&out).contains("32 of 40 contact lines are drawn"));
}

#[test]
fn the_page_is_the_same_in_every_run() {
    let temp = tempfile::tempdir().unwrap();
    let pages = ["1", "2"].map(|threads| {
        let out = temp.path().join(threads);
        assert_eq!(run("gmsh", &out, &["--threads", threads]), Some(0));
        page(&out)
    });
    assert_eq!(pages[0], pages[1]);
}

#[test]
fn the_page_says_how_to_come_to_it_again() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let more = ["--set", "solver.theta=0.5", "--set", "adapt={ target_relative_error = 0.15 }"];
    assert_eq!(run("gmsh", &out, &more), Some(0));
    let page = page(&out);
    let command = "gmsh.toml --set solver.theta=0.5 --set 'adapt={ target_relative_error = 0.15 }'";
    assert!(page.contains("<pre>nndd solve ") && page.contains(command), "{page}");
    // The file itself, by a hash that `sha256sum` prints too.
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/meshes/blocks.msh");
    let digest: String =
        Sha256::digest(std::fs::read(file).unwrap()).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        page.matches(&format!("<td>meshes/blocks.msh</td><td class=\"long\">{digest}</td>")).count(),
        1
    );
    // The settings are a case file.
    assert!(
        page.contains("schema = 1\n") && page.contains("[solver]\n") && page.contains("\ntheta = 0.5\n"),
        "{page}"
    );
    for head in ["<th>unknowns</th>", "<th>smallest angle</th>", "stiff: E 2000  nu 0.3"] {
        assert!(page.contains(head), "{head}");
    }
}

#[test]
fn the_page_has_the_results_first_and_each_by_its_name() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    assert_eq!(run("rings", &out, &[]), Some(0));
    let rings = page(&out);
    let at = |what: &str| rings.find(what).unwrap();
    assert!(at("<h2>Results</h2>") < at("<h2>Bodies</h2>") && at("</figure>") < at("<h2>Results</h2>"));
    // The largest pressure has a place, and so have the largest stress and both principal ones.
    assert_eq!(rings.matches("<td>its place, x</td>").count(), 4, "{rings}");
    assert!(rings.contains("<td>moment about the origin</td>"));
    // On a bent line it is said why the force has no bounds.
    assert!(
        !rings.contains("<td>contact force")
            && rings.contains("The contact force has none: contact line 1 is bent")
    );
    let out = temp.path().join("stack");
    assert_eq!(run("stack", &out, &[]), Some(0));
    let stack = page(&out);
    assert!(stack.contains("<th>∫ p ds</th>") && !stack.contains("<th>contact force</th>"));
    assert!(stack.contains("<th>its place</th>"));
    // The pin is in the middle of its hole: the contact has no moment about its centre, the origin.
    let out = temp.path().join("pin");
    assert_eq!(run("pin", &out, &[]), Some(0));
    let pin = page(&out);
    assert!(pin.contains("<td>moment about the origin</td><td>0</td><td>0</td>"), "{pin}");
}

#[test]
fn what_is_not_known_has_no_table() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    assert_eq!(run("paper", &out, &["--set", "body.0.displacement.1.uy=-1e300"]), Some(5));
    let page = page(&out);
    assert!(page.contains("no certificate") && page.contains("<h2>Bodies</h2>"));
    assert!(!page.contains("<h2>Results</h2>") && !page.contains("<h2>Checks"), "{page}");
}

#[test]
fn a_browser_shows_the_verdict_without_complaint() {
    let Some(browser) = chromium() else {
        eprintln!("skipped: Chromium is not installed");
        return;
    };
    let temp = tempfile::tempdir().unwrap();
    let out = solved("paper", temp.path());
    for width in [390, 1000] {
        let profile = temp.path().join(format!("profile-{width}"));
        let (dom, log) = looked_at(&browser, &out.join("report.html"), &profile, width);
        assert!(dom.contains("certified error &lt;= 18."), "{log}");
        assert_eq!(dom.matches("<figure>").count(), 6, "{log}");
        assert!(!log.contains("CONSOLE"), "{log}");
    }
}

//! The figures and the page of solids.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stderr)]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Solves a case of solids and returns its report.
fn solved(case: &str, out: &Path, more: &[&str]) -> Value {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/solid").join(format!("{case}.toml"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.args(["solve", "--quiet", "--set", "output.vtu=false", "--out"]).arg(out).arg(&file).args(more);
    assert!(command.status().unwrap().success());
    serde_json::from_str(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap()
}

fn page(out: &Path) -> String {
    std::fs::read_to_string(out.join("report.html")).unwrap()
}

/// The figures by their names.
fn figures(out: &Path) -> BTreeMap<String, String> {
    let files = std::fs::read_dir(out.join("figures")).unwrap().map(|entry| entry.unwrap().path());
    let named = |file: PathBuf| {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        (name, std::fs::read_to_string(file).unwrap())
    };
    files.map(named).collect()
}

/// The colours of the pictures inside a figure.
fn colours(svg: &str) -> BTreeSet<Vec<u8>> {
    let mut colours = BTreeSet::new();
    for text in svg.split("data:image/png;base64,").skip(1) {
        let png = STANDARD.decode(text.split('"').next().unwrap()).unwrap();
        let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        let width = number(16);
        let rows = miniz_oxide::inflate::decompress_to_vec_zlib(&png[41..41 + number(33)]).unwrap();
        let mut above = vec![0u8; 4 * width];
        for row in rows.chunks(4 * width + 1) {
            // Each row is the difference to the one above.
            above.iter_mut().zip(&row[1..]).for_each(|(above, change)| *above = above.wrapping_add(*change));
            colours.extend(above.chunks(4).map(<[u8]>::to_vec));
        }
    }
    colours
}

/// Returns a number of a report with three digits, as alternative texts have them.
fn three(value: &Value) -> String {
    nndd_report::words::with_digits(value.as_f64().unwrap(), 3)
}

#[test]
fn every_figure_of_a_solid_is_drawn_and_its_text_has_the_peak() {
    let temp = tempfile::tempdir().unwrap();
    let report = solved("half_open", temp.path(), &[]);
    let figures = figures(temp.path());
    let results = &report["results"];
    let peaks = [
        ("von_mises", &results["peak_stress"]["von_mises"]),
        ("displacement", &results["max_displacement"]),
        ("contact", &results["max_pressure"]),
    ];
    for (name, peak) in peaks {
        let text = figures[name].split("<desc>").nth(1).unwrap().split("</desc>").next().unwrap();
        assert!(text.contains(&format!(" is {} ", three(peak))), "{name}: {text}");
    }
    let area = &report["contact"][0]["area"];
    let [certain, possible, total] = ["certain", "possible", "total"].map(|key| three(&area[key]));
    assert!(
        figures["contact"].contains(&format!("The area in contact is {certain} to {possible} of {total}."))
    );
    for name in ["problem", "von_mises", "displacement", "contact", "deformed"] {
        let count = colours(&figures[name]).len();
        assert!(count > 16, "{name}: {count} colours");
    }
    assert!(figures["deformed"].contains("largest") && figures["convergence"].contains("<svg"));
    assert!(figures["problem"].contains(">fixed<") && figures["problem"].contains(">in contact<"));
}

#[test]
fn pictures_do_not_depend_on_threads() {
    let temp = tempfile::tempdir().unwrap();
    let [one, two] = ["1", "2"].map(|threads| {
        let out = temp.path().join(threads);
        solved("stack", &out, &["--threads", threads]);
        (figures(&out), page(&out))
    });
    assert_eq!(one.0.len(), 6, "{:?}", one.0.keys());
    assert!(one == two);
}

#[test]
fn displacements_beside_a_round_obstacle_are_not_made_small() {
    // Normals on the corners of a cube that touches a sphere are longer than one.
    let temp = tempfile::tempdir().unwrap();
    solved("sphere", temp.path(), &[]);
    let figure = &figures(temp.path())["displacement"];
    assert!(figure.contains("(drawn × 0.5)"), "{}", &figure[..400]);
}

/// Elements without an end.
const EMPTY: [&str; 4] = ["meta", "input", "br", "!DOCTYPE"];

#[test]
fn the_page_of_a_solid_is_whole_and_needs_no_network() {
    let temp = tempfile::tempdir().unwrap();
    solved("stack", temp.path(), &[]);
    let page = page(temp.path());
    let mut open: Vec<&str> = Vec::new();
    let mut rest = page.as_str();
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        // Inside a script there are no elements.
        if open.last() == Some(&"script") && !rest.starts_with("/script>") {
            continue;
        }
        let tag = &rest[..rest.find('>').unwrap()];
        let name = tag.split([' ', '\n', '/']).find(|word| !word.is_empty()).unwrap();
        match (tag.starts_with('/'), tag.ends_with('/') || EMPTY.contains(&name)) {
            (true, _) => assert_eq!(open.pop(), Some(name), "{tag}"),
            (false, true) => {}
            (false, false) => open.push(name),
        }
    }
    assert!(open.is_empty(), "{open:?}");
    let foreign = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    assert!(!foreign.contains("://"), "an address on the page");
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
}

#[test]
fn load_steps_can_be_chosen() {
    let temp = tempfile::tempdir().unwrap();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/solid/half_open.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let named = text.replacen("[[body.traction]]", "[[body.traction]]\nname = \"load\"", 1);
    assert_ne!(text, named);
    let case = temp.path().join("case.toml");
    std::fs::write(&case, named + "\n[[step]]\nfactors = { load = 1.0 }\ncount = 2\n").unwrap();
    let out = temp.path().join("out");
    let run = Command::new(env!("CARGO_BIN_EXE_nndd"))
        .args(["solve", "--quiet", "--out"])
        .arg(&out)
        .arg(&case)
        .output();
    assert!(run.as_ref().unwrap().status.success(), "{run:?}");
    let page = page(&out);
    let data = page.split("id=\"skin\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    let steps = data["steps"].as_array().unwrap();
    assert_eq!((steps.len(), steps[1]["name"].as_str()), (2, Some("step 2")));
    assert_ne!(steps[0]["fields"][1]["said"], steps[1]["fields"][1]["said"]);
}

/// Chromium, by the names under which systems install it.
fn chromium() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&folders).flat_map(|f| names.map(|n| f.join(n))).find(|p| p.is_file())
}

/// Turns the view by a key, chooses a field, opens the contact and cuts; the page then says after which of them the picture differs.
const TRIAL: &str = r##"<script>
const canvas = document.querySelector("#viewer canvas"), seen = [];
const set = (name, value, event) => {
  const control = document.querySelector(`#viewer [name=${name}]`);
  control.value = value;
  control.dispatchEvent(new Event(event));
};
const trials = [
  () => {},
  () => canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" })),
  () => set("field", 1, "change"),
  () => set("opened", 1, "input"),
  () => set("factor", 0, "input"),
  () => set("clip", "x", "input"),
];
const next = (k) => {
  if (k === trials.length) { document.body.dataset.changes = seen.slice(1).map((s, i) => s !== seen[i]).join(); return; }
  trials[k]();
  setTimeout(() => { seen.push(canvas.toDataURL()); next(k + 1); }, 100);
};
next(0);
</script></body>"##;

#[test]
fn a_browser_turns_the_view() {
    let Some(browser) = chromium() else {
        eprintln!("skipped: Chromium is not installed");
        return;
    };
    let temp = tempfile::tempdir().unwrap();
    solved("stack", temp.path(), &[]);
    let trial = temp.path().join("trial.html");
    // A browser without a window has few frames: the view is drawn without waiting for one.
    let at_once = "<head><script>window.requestAnimationFrame = (draw) => setTimeout(draw, 0);</script>";
    let text = page(temp.path()).replace("<head>", at_once).replace("</body>", TRIAL);
    std::fs::write(&trial, text).unwrap();
    let mut command = Command::new(browser);
    command.args([
        "--headless",
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--dump-dom",
    ]);
    command
        .arg("--virtual-time-budget=60000")
        .arg(format!("--user-data-dir={}", temp.path().join("p").display()));
    let found = command.arg(format!("file://{}", trial.display())).stdin(Stdio::null()).output().unwrap();
    let dom = String::from_utf8_lossy(&found.stdout);
    if !dom.contains("id=\"viewer\" class=\"turns\"") {
        eprintln!("skipped: this Chromium has no WebGL");
        return;
    }
    assert!(
        dom.contains("data-changes=\"true,true,true,true,true\""),
        "{}",
        &dom[dom.len().saturating_sub(3000)..]
    );
}

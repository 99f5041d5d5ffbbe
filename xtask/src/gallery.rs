//! `cargo xtask gallery`: solves the gallery's cases and writes `bench-results/gallery/`, pictures and page.

use crate::workspace::{Outcome, Workspace, read};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// The exhibits: a case file, its title, a text, settings and figures.
const EXHIBITS: &str = include_str!("gallery.toml");

/// Solves the cases, copies their figures and writes the page.
pub(crate) fn run(workspace: &Workspace) -> Outcome<()> {
    workspace.build_nndd()?;
    let folder = workspace.root.join("bench-results").join("gallery");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", workspace.shown(&folder)))?;
    let exhibits: toml::Table = EXHIBITS.parse().map_err(|e| format!("gallery.toml: {e}"))?;
    let exhibits: Vec<&toml::Value> = exhibits.values().filter_map(toml::Value::as_array).flatten().collect();
    let mut page = format!(
        "# Gallery\n\n{} cases, solved and certified by the program; figures and numbers come from its output folders. \
         Written by `cargo xtask gallery` at commit {}. They look like this on the page of a run too.\n",
        exhibits.len(),
        workspace.commit()?
    );
    for exhibit in exhibits {
        page += &show(workspace, exhibit, &folder)?;
    }
    page += "\n## In ParaView's format\n\n![The paper's blocks, drawn from the ParaView files](paraview.png)\n\n\
             Drawn from `upper.vtu` and `lower.vtu` by `cargo xtask check-vtk --picture \
             bench-results/gallery/paraview.png`, which reads every field back by VTK and meshio.\n";
    workspace.write(&folder.join("README.md"), &page)
}

/// Solves one case, copies its figures, and returns its part of the page.
fn show(workspace: &Workspace, exhibit: &toml::Value, folder: &Path) -> Outcome<String> {
    let text_of = |key: &str| exhibit.get(key).and_then(toml::Value::as_str).unwrap_or_default();
    let list = |key: &str| -> Vec<&str> {
        let items = exhibit.get(key).and_then(toml::Value::as_array);
        items.into_iter().flatten().filter_map(toml::Value::as_str).collect()
    };
    let [case, title, text] = ["case", "title", "text"].map(text_of);
    let set = list("set");
    let file = format!("tests/cases/{case}.toml");
    let out = workspace.target.join("gallery").join(case);
    let settings: Vec<&str> = set.iter().flat_map(|s| ["--set", *s]).collect();
    if workspace.solve(Path::new(&file), &settings, &out)? != Some(0) {
        return Err(format!("{file} does not end as it should"));
    }
    let report: Value =
        serde_json::from_str(&read(&out.join("report.json"))?).map_err(|e| format!("{case}: {e}"))?;
    let mut page = format!("\n## {title}\n\n{text}\n\n");
    let typed: String = set.iter().map(|s| format!(" --set '{s}'")).collect();
    let _ =
        writeln!(page, "[`{file}`](../../{file}), `nndd solve {file}{typed}`\n\n{}\n", measured(&report)?);
    page += &compared(exhibit, &report)?;
    for name in list("figures") {
        let from = out.join("figures").join(format!("{name}.svg"));
        let to = format!("{}-{name}.svg", case.replace('/', "-"));
        let drawn = read(&from)?;
        let alternative = between(&drawn, "<title>", "</title>").unwrap_or(title);
        std::fs::write(folder.join(&to), &drawn).map_err(|e| format!("{to}: {e}"))?;
        let _ = writeln!(page, "![{title}: {alternative}]({to})");
    }
    Ok(page)
}

/// A table of the closed forms of an exhibit beside what the program found; nothing if it has none.
fn compared(exhibit: &toml::Value, report: &Value) -> Outcome<String> {
    let rows = exhibit.get("closed").and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
    let mut table = String::new();
    for row in rows {
        let text = |key: &str| row.get(key).and_then(toml::Value::as_str);
        let found = |pointer: &str| {
            let value = report.pointer(pointer).and_then(Value::as_f64);
            value.ok_or_else(|| format!("report.json has no number at {pointer}"))
        };
        let what = text("what").unwrap_or_default();
        let exact = row
            .get("exact")
            .and_then(toml::Value::as_float)
            .ok_or_else(|| format!("{what}: no closed form"))?;
        let low = found(text("at").unwrap_or_default())?;
        let (computed, difference) = match text("to").map(found).transpose()? {
            None => {
                // Tenths of a percent, without a sign at zero.
                let tenths = (1000.0 * (low / exact - 1.0)).round() + 0.0;
                (digits(low), format!("{:.1} %", tenths / 10.0))
            }
            Some(high) => {
                let word = if low <= exact && exact <= high { "within" } else { "outside" };
                (format!("{} to {}", digits(low), digits(high)), word.to_owned())
            }
        };
        let _ = writeln!(table, "| {what} | {exact} | {computed} | {difference} |");
    }
    if table.is_empty() {
        return Ok(table);
    }
    Ok(format!("| | closed form | computed | difference |\n|---|---|---|---|\n{table}\n"))
}

/// Writes a number with four digits.
fn digits(value: f64) -> String {
    let places = (3.0 - value.abs().log10().floor()).clamp(0.0, 12.0);
    format!("{value:.*}", places as usize)
}

/// One line of what the program measured.
fn measured(report: &Value) -> Outcome<String> {
    let relative = report["certificate"]["relative"].as_f64();
    let relative = relative.filter(|_| report["certificate"]["valid"] == Value::Bool(true));
    let percent = relative.ok_or("a case of the gallery has no valid certificate")? * 100.0;
    let bodies = report["bodies"].as_array().map_or(&[][..], Vec::as_slice);
    let nodes: u64 = bodies.iter().filter_map(|b| b["nodes"].as_u64()).sum();
    let count = |key: &str| report[key].as_array().map_or(0, Vec::len);
    let meshes = match count("adaptive") {
        0 => String::new(),
        n => format!(" on the last of {n} meshes"),
    };
    let iterations = match count("iterations") {
        1 => "1 iteration".to_owned(),
        n => format!("{n} iterations"),
    };
    // As many digits as the page of the run has.
    let digits = (3.0 - percent.log10()).ceil().clamp(2.0, 6.0) as usize;
    // A bound is rounded up.
    let percent = (100.0 * percent).ceil() / 100.0;
    let force = report["results"]["contact_force"].as_f64().unwrap_or(f64::NAN);
    let force: f64 = format!("{force:.*e}", digits - 1).parse().unwrap_or(force);
    let integral = match bodies.iter().any(|body| body.get("tetrahedra").is_some()) {
        true => format!("∫ p dA = {force}"),
        false => format!("∫ p ds = {force} per unit thickness"),
    };
    Ok(format!(
        "Certified error at most **{percent:.2} %** of the energy norm; {nodes} nodes, {iterations}{meshes}; {integral}."
    ))
}

/// The text between two others.
fn between<'a>(text: &'a str, from: &str, to: &str) -> Option<&'a str> {
    text.split_once(from)?.1.split_once(to).map(|(inside, _)| inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_without_certificate_is_not_shown() {
        let report = |valid: bool| {
            serde_json::json!({ "certificate": { "valid": valid, "relative": 0.1876 }, "bodies": [{ "nodes": 190 }, { "nodes": 190 }],
                "iterations": [1, 2], "adaptive": [], "results": { "contact_force": 26.23618 } })
        };
        assert!(measured(&report(false)).is_err());
        let line = measured(&report(true)).unwrap();
        assert!(
            line.contains("18.76 %") && line.contains("380 nodes, 2 iterations; ∫ p ds = 26 per unit"),
            "{line}"
        );
    }

    #[test]
    fn closed_forms_are_beside_what_was_found() {
        let report = serde_json::json!({ "contact": [{ "max_pressure": 11.0, "area": { "certain": 0.5, "possible": 0.75 } }] });
        let table = |text: &str| compared(&toml::Value::Table(text.parse().unwrap()), &report);
        let pressure = "{ what = \"p\", exact = 10.0, at = \"/contact/0/max_pressure\" }";
        let area = |exact: f64| {
            format!(
                "{{ what = \"A\", exact = {exact:?}, at = \"/contact/0/area/certain\", to = \"/contact/0/area/possible\" }}"
            )
        };
        let found = table(&format!("closed = [{pressure}, {}, {}]", area(0.6), area(0.8))).unwrap();
        let rows: Vec<&str> = found.lines().skip(2).filter(|line| !line.is_empty()).collect();
        assert_eq!(
            rows,
            [
                "| p | 10 | 11.00 | 10.0 % |",
                "| A | 0.6 | 0.5000 to 0.7500 | within |",
                "| A | 0.8 | 0.5000 to 0.7500 | outside |"
            ]
        );
        assert_eq!(table("").unwrap(), "");
        assert!(table("closed = [{ what = \"p\", exact = 1.0, at = \"/none\" }]").is_err());
    }
}

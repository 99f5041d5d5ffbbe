//! `cargo xtask gallery`: solves the gallery's cases and writes `bench-results/gallery/`, pictures and page.

use crate::workspace::{Outcome, Workspace, output, read, stream};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// One case of the gallery.
struct Exhibit {
    case: &'static str,
    title: &'static str,
    text: &'static str,
    /// Settings beside those of the case file, so that the pictures stay small.
    set: &'static [&'static str],
    figures: &'static [&'static str],
}

const EXHIBITS: [Exhibit; 12] = [
    Exhibit {
        case: "paper",
        title: "Two blocks that lose contact",
        text: "The paper's problem: the upper block is pushed down on its left half and lifts off on its right.",
        set: &[],
        figures: &["problem", "von_mises", "displacement", "contact", "deformed"],
    },
    Exhibit {
        case: "gears",
        title: "A gear pair",
        text: "Involute teeth, refined adaptively to more than 40,000 nodes; fine meshes are drawn as fields without lines.",
        set: &["adapt.target_relative_error=0.03"],
        figures: &["problem", "von_mises", "displacement", "contact", "deformed"],
    },
    Exhibit {
        case: "bearing",
        title: "A roller bearing",
        text: "Ten bodies and sixteen pairs with clearance: only contact holds the rollers and the outer ring, and a radial force \
               drives them.",
        set: &["adapt.target_relative_error=0.05"],
        figures: &["problem", "von_mises", "deformed", "adaptive"],
    },
    Exhibit {
        case: "tresca",
        title: "Friction with a given limit",
        text: "The law of Tresca: the friction is at most 4 per unit area, and the certificate holds with it. The contact line shows \
               pressure, friction and its limit.",
        set: &[],
        figures: &["problem", "von_mises", "contact", "deformed"],
    },
    Exhibit {
        case: "shear",
        title: "A cycle of loads with friction",
        text: "Pressed, then pushed to and fro in 51 increments: the force lags behind the displacement.",
        set: &[],
        figures: &["problem", "path", "contact"],
    },
    Exhibit {
        case: "punch_corner",
        title: "A corner that presses",
        text: "The pressure and the stress at the corner grow with every refinement: scales end below such a peak, and its \
               value is written.",
        set: &[],
        figures: &["problem", "von_mises", "contact", "deformed"],
    },
    Exhibit {
        case: "roller_half",
        title: "A roller on a block",
        text: "Half of it by symmetry, refined adaptively.",
        set: &[],
        figures: &["problem", "von_mises", "contact", "deformed"],
    },
    Exhibit {
        case: "hertz",
        title: "Hertz: two cylinders",
        text: "Half discs pressed together; the gap is measured on the meshes, and drawn as it is.",
        set: &[],
        figures: &["problem", "von_mises", "contact", "deformed"],
    },
    Exhibit {
        case: "rings",
        title: "Nested rings",
        text: "A curved line of contact with normals averaged at its nodes, rollers on the axes of symmetry.",
        set: &[],
        figures: &["problem", "von_mises", "deformed"],
    },
    Exhibit {
        case: "nonmatching",
        title: "Meshes that do not match",
        text: "The surfaces are cut differently and face each other only in part; both are refined in common.",
        set: &[],
        figures: &["problem", "von_mises", "deformed"],
    },
    Exhibit {
        case: "singular",
        title: "A singular corner, adaptively",
        text: "Where the supports end the stress grows without bound: the meshes are refined there until the certified \
               error is small enough.",
        set: &[],
        figures: &["problem", "von_mises", "deformed", "adaptive"],
    },
    Exhibit {
        case: "materials",
        title: "Several materials",
        text: "Regions of other stiffness, and one that is orthotropic.",
        set: &[],
        figures: &["problem", "von_mises", "deformed"],
    },
];

/// Solves the cases, copies their figures and writes the page.
pub(crate) fn run(workspace: &Workspace) -> Outcome<()> {
    if stream(&mut workspace.cargo(&["build", "--release", "--bin", "nndd"]))? != Some(0) {
        return Err("the program does not build".to_owned());
    }
    let folder = workspace.root.join("bench-results").join("gallery");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", workspace.shown(&folder)))?;
    let commit =
        output(Command::new("git").args(["rev-parse", "--short", "HEAD"]).current_dir(&workspace.root))?;
    let mut page = format!(
        "# Gallery\n\nTwelve cases, solved and certified by the program; figures and numbers come from its output folders. \
         Written by `cargo xtask gallery` at commit {}. They look like this on the page of a run too.\n",
        commit.trim()
    );
    for exhibit in &EXHIBITS {
        page += &show(workspace, exhibit, &folder)?;
    }
    page += "\n## In ParaView's format\n\n![The paper's blocks, drawn from the ParaView files](paraview.png)\n\n\
             Drawn from `upper.vtu` and `lower.vtu` by `cargo xtask check-vtk --picture \
             bench-results/gallery/paraview.png`, which reads every field back by VTK and meshio.\n";
    let path = folder.join("README.md");
    std::fs::write(&path, page).map_err(|e| format!("{}: {e}", workspace.shown(&path)))?;
    println!("wrote {}", workspace.shown(&path));
    Ok(())
}

/// Solves one case, copies its figures, and returns its part of the page.
fn show(workspace: &Workspace, exhibit: &Exhibit, folder: &Path) -> Outcome<String> {
    let Exhibit { case, title, text, set, figures } = exhibit;
    let file = format!("tests/cases/{case}.toml");
    let out = workspace.target.join("gallery").join(case);
    let settings: Vec<&str> = set.iter().flat_map(|s| ["--set", *s]).collect();
    let mut command = Command::new(workspace.nndd());
    command.current_dir(&workspace.root).args(["solve", &file]).args(&settings);
    command.arg("--out").arg(&out).args(["--force", "--quiet"]);
    if stream(&mut command)? != Some(0) {
        return Err(format!("{file} does not end as it should"));
    }
    let report: Value =
        serde_json::from_str(&read(&out.join("report.json"))?).map_err(|e| format!("{case}: {e}"))?;
    let mut page = format!("\n## {title}\n\n{text}\n\n");
    let typed: String = set.iter().map(|s| format!(" --set '{s}'")).collect();
    let _ =
        writeln!(page, "[`{file}`](../../{file}), `nndd solve {file}{typed}`\n\n{}\n", measured(&report)?);
    for name in *figures {
        let (from, to) = (out.join("figures").join(format!("{name}.svg")), format!("{case}-{name}.svg"));
        let drawn = read(&from)?;
        let alternative = between(&drawn, "<title>", "</title>").unwrap_or(title);
        std::fs::write(folder.join(&to), &drawn).map_err(|e| format!("{to}: {e}"))?;
        let _ = writeln!(page, "![{title}: {alternative}]({to})");
    }
    Ok(page)
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
    // A bound is rounded up.
    let percent = (100.0 * percent).ceil() / 100.0;
    Ok(format!(
        "Certified error at most **{percent:.2} %** of the energy norm; {nodes} nodes, {iterations}{meshes}; contact force {:.5} \
         per unit thickness.",
        report["results"]["contact_force"].as_f64().unwrap_or(f64::NAN)
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
                "iterations": [1, 2], "adaptive": [], "results": { "contact_force": 26.1 } })
        };
        assert!(measured(&report(false)).is_err());
        let line = measured(&report(true)).unwrap();
        assert!(
            line.contains("18.76 %") && line.contains("380 nodes, 2 iterations; contact force 26.1"),
            "{line}"
        );
    }
}

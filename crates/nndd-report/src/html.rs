//! report.html: one page with everything, for people. No network, no script.

use crate::figures::Picture;
use crate::words::{self, one_line, plain};
use case_io::Case;
use case_io::report::Report;
use serde_json::Value;
use std::fmt::Write as _;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:64rem;margin:1rem auto;padding:0 .75rem;color:#222}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums;display:block;overflow-x:auto}\
td,th{padding:.15rem .6rem;text-align:right;border-bottom:1px solid #ddd;white-space:nowrap}\
th{background:#f4f4f4}td:first-child,th:first-child{text-align:left}\
h1,h2{line-height:1.25}\
.verdict{border:2px solid;padding:.6rem 1rem;border-radius:.4rem;margin:1rem 0}\
.ok{border-color:#0072b2}.no{border-color:#d55e00}.verdict p{margin:.2rem 0}.verdict p:nth-child(2){font-weight:bold}\
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,27rem),1fr));gap:1rem;align-items:start}\
figure{margin:0}figure svg{width:100%;height:auto}figcaption{font-size:.875rem;color:#555;padding:0 .5rem}\
p,li{overflow-wrap:anywhere}pre{overflow-x:auto;background:#f7f7f7;padding:.6rem}\
@page{size:A4;margin:15mm}\
@media print{body{max-width:none;margin:0;padding:0;font-size:10pt}h2{break-after:avoid}\
.figures{grid-template-columns:1fr 1fr;gap:.5rem}figure svg{max-height:78mm}figcaption{font-size:8pt;line-height:1.3}figure,tr,.verdict{break-inside:avoid}\
table{display:table;font-size:8pt}td,th{white-space:normal;padding:.1rem .3rem}\
pre{white-space:pre-wrap;overflow-wrap:anywhere;font-size:8pt}}";

/// Writes the page.
///
/// * `angles`: the smallest of each body's mesh, degrees.
pub(crate) fn page(case: &Case, report: &Report, angles: &[f64], pictures: &[Picture]) -> String {
    let title = escape(&one_line(if case.title.is_empty() { case.file_name() } else { &case.title }));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>{title}</title><style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
    );
    verdict(&mut page, report);
    notes(&mut page, report);
    figures(&mut page, pictures);
    bodies(&mut page, case, report, angles);
    if report.certificate.e_cre.is_some() {
        parts(&mut page, report);
        checks(&mut page, report);
        results(&mut page, case, report);
    }
    bounds(&mut page, report);
    steps(&mut page, report);
    iterations(&mut page, report);
    let settings = serde_json::to_string_pretty(&report.case).unwrap_or_default();
    let _ = writeln!(page, "<h2>Settings</h2>\n<pre>{}</pre>", escape(&settings));
    reproduce(&mut page, case, report);
    page.push_str("</body></html>\n");
    page
}

/// What is needed to reproduce this page. Times and the machine are not on it, so that it is the same every time.
fn reproduce(page: &mut String, case: &Case, report: &Report) {
    let mut command = format!("nndd solve {}", shell_word(case.file_name()));
    let overrides = report.run.get("overrides").and_then(Value::as_array);
    for text in overrides.into_iter().flatten().filter_map(Value::as_str) {
        let _ = write!(command, " --set {}", shell_word(text));
    }
    let _ = writeln!(page, "<h2>How to reproduce</h2>\n<pre>{}</pre>", escape(&command));
    let mut files: Vec<_> = (0..case.bodies.len()).filter_map(|body| case.mesh_file_of(body)).collect();
    files.dedup();
    let own = [("nndd", env!("CARGO_PKG_VERSION")), ("settings and meshes", &case.hash())];
    let rows = own.into_iter().chain(files).map(|(what, mark)| vec![what.to_owned(), mark.to_owned()]);
    table(page, "", &["what", "SHA-256 or version"], rows);
    page.push_str(
        "<p>Times, threads and host are in <a href=\"report.json\">report.json</a>: this page is the same \
         in every run of the case.</p>\n",
    );
}

/// Writes a word as a POSIX shell reads it, in quotes if it must be.
fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Writes a table below a title, the cells of each row as text.
fn table(page: &mut String, title: &str, heads: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
    let row = |kind: &str, cells: &mut dyn Iterator<Item = &str>| {
        let cells: String = cells.map(|cell| format!("<{kind}>{}</{kind}>", escape(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    if !title.is_empty() {
        let _ = writeln!(page, "<h2>{title}</h2>");
    }
    page.push_str("<table>");
    page.push_str(&row("th", &mut heads.iter().copied()));
    page.extend(rows.into_iter().map(|cells| row("td", &mut cells.iter().map(String::as_str))));
    page.push_str("</table>\n");
}

/// The sizes of the bodies on the last mesh.
fn bodies(page: &mut String, case: &Case, report: &Report, angles: &[f64]) {
    let rows = report.bodies.iter().zip(angles).enumerate().map(|(k, (body, angle))| {
        let materials = case.materials_of(k).into_iter().map(|m| format!("{}: {}", m.name, m.summary()));
        let [nodes, triangles, unknowns] = [body.nodes, body.triangles, body.unknowns].map(|n| n.to_string());
        let materials = materials.collect::<Vec<_>>().join("; ");
        vec![body.name.clone(), nodes, triangles, unknowns, format!("{angle:.1}°"), materials]
    });
    table(page, "Bodies", &["body", "nodes", "triangles", "unknowns", "smallest angle", "material"], rows);
    if let [contact] = report.contact.as_slice()
        && !contact.imposed.is_empty()
    {
        let _ = writeln!(
            page,
            "<p>Contact line: {} pairs, length {}; λ is carried by {}.</p>",
            contact.pairs,
            number(Some(contact.length)),
            escape(&contact.imposed)
        );
        return;
    }
    let rows = report.contact.iter().map(|contact| {
        let partners = match contact.bodies.as_slice() {
            [only] => format!("{only} and an obstacle"),
            all => all.join(" and "),
        };
        let mut cells = vec![contact.name.clone(), partners, contact.pairs.to_string()];
        cells.push(contact.active.map_or_else(|| number(None), |active| active.to_string()));
        cells.extend([Some(contact.length), contact.contact_force, contact.max_pressure].map(number));
        cells
    });
    if !report.contact.is_empty() {
        let heads = ["pair", "of", "nodes", "in contact", "length", "contact force", "largest pressure"];
        table(page, "Contact", &heads, rows);
    }
}

fn verdict(page: &mut String, report: &Report) {
    let class = if report.certificate.valid && report.status.code == 0 { "ok" } else { "no" };
    let text = crate::verdict::verdict(report);
    let lines: Vec<String> = text.lines().filter(|l| !l.is_empty()).map(escape).collect();
    let _ = writeln!(page, "<div class=\"verdict {class}\"><p>{}</p></div>", lines.join("</p><p>"));
    if report.certificate.valid && report.certificate.relative.is_some() {
        let exact = report.certificate.relative_guaranteed.map_or_else(String::new, |relative| {
            format!(
                "; over that of the exact ones the error is at most {} %",
                words::rounded_up(100.0 * relative)
            )
        });
        let _ = writeln!(
            page,
            "<p>The percentage is the bound over the energy norm of the computed displacements{exact}.</p>"
        );
    }
}

/// What a reader of the numbers must know.
fn notes(page: &mut String, report: &Report) {
    if report.notes.is_empty() {
        return;
    }
    page.push_str("<h2>Notes</h2>\n<ul>");
    for note in &report.notes {
        let _ = write!(page, "<li>{}</li>", escape(note));
    }
    page.push_str("</ul>\n");
}

fn figures(page: &mut String, pictures: &[Picture]) {
    page.push_str("<div class=\"figures\">\n");
    for picture in pictures {
        let _ = write!(page, "<figure>{}<figcaption>{}", picture.svg, escape(picture.caption));
        if let Some(file) = picture.numbers {
            let _ = write!(page, " Numbers: <a href=\"{file}\">{file}</a>.");
        }
        page.push_str("</figcaption></figure>\n");
    }
    page.push_str("</div>\n");
}

/// What the bound is made of.
fn parts(page: &mut String, report: &Report) {
    page.push_str(
        "<h2>Parts of the bound</h2>\n<p>The squares of all but round-off add up to the square of the bound without \
         round-off.</p>\n",
    );
    let parts = &report.certificate.parts;
    let rows = [
        ("mesh", parts.mesh, "a finer mesh"),
        ("iteration, at most eta_nndd", parts.iteration, "more iterations"),
        ("contact law, which holds at the nodes only", parts.contact, "a finer mesh at the contact line"),
        ("lift on a bent contact line", parts.lift, "a finer mesh at the contact line"),
        ("gap that bent edges cannot represent", parts.gap_data, "a finer mesh at the contact line"),
        ("friction", parts.friction, "a finer mesh at the contact line"),
        ("round-off", parts.round_off, "nothing"),
    ];
    let rows = rows.into_iter().filter(|(_, value, _)| *value != Some(0.0));
    let rows = rows.map(|(name, value, cure)| vec![name.into(), number(value), cure.into()]);
    table(page, "", &["part", "energy norm", "what lowers it"], rows);
}

fn checks(page: &mut String, report: &Report) {
    let checks = report.certificate.checks.named();
    let rows = checks.into_iter().map(|(key, value)| vec![key.replace('_', " "), number(value)]);
    table(page, "Checks of the certificate", &["residual", "relative"], rows);
}

fn results(page: &mut String, case: &Case, report: &Report) {
    let r = &report.results;
    let t = case.model.thickness;
    // Without a solution nothing of it is known.
    let Some(energies) = &r.energy_norm_squared else { return };
    let mut rows = vec![];
    let mut row = |name: &str, value: Option<f64>, by_thickness: bool| {
        let whole = value.filter(|_| by_thickness).map(|x| x * t);
        rows.push(vec![name.to_owned(), number(value), number(whole)]);
    };
    for (body, a) in report.bodies.iter().zip(energies) {
        row(&format!("energy norm² of {}", body.name), Some(*a), true);
    }
    for contact in &report.contact {
        let of = if report.contact.len() > 1 { format!(" of {}", contact.name) } else { String::new() };
        let [x, y] = contact.resultant.map_or([None; 2], |force| force.map(Some));
        row(&format!("resultant x of the contact{of}, on the first body"), x, true);
        row(&format!("resultant y of the contact{of}, on the first body"), y, true);
        if let Some([x, y]) = contact.centre {
            row(&format!("centre of pressure{of}, x"), Some(x), false);
            row(&format!("centre of pressure{of}, y"), Some(y), false);
        }
    }
    row("integral of the pressure, ∫ p ds", r.contact_force, true);
    row("largest nodal pressure", r.max_pressure, false);
    row("largest mean pressure of an edge", r.max_edge_pressure, false);
    row("smallest opening", r.min_opening, false);
    row("largest displacement", r.max_displacement, false);
    if r.max_von_mises.is_some() {
        row("largest von Mises stress of a cell", r.max_von_mises, false);
    }
    if let Some(peak) = &r.peak_stress {
        row(&format!("largest recovered von Mises stress, in {}", peak.body), Some(peak.von_mises), false);
        row("its place, x", Some(peak.x), false);
        row("its place, y", Some(peak.y), false);
        if peak.change.is_some() {
            row("its relative change from the mesh before", peak.change, false);
        }
    }
    for reaction in r.reactions.iter().flatten() {
        row(&format!("reaction x of {} on {}", reaction.on, reaction.body), Some(reaction.fx), true);
        row(&format!("reaction y of {} on {}", reaction.on, reaction.body), Some(reaction.fy), true);
    }
    for body in &report.bodies {
        for side in &body.rigid_sides {
            let of = format!("of the rigid side {} of {}", side.on, body.name);
            for (what, value) in ["ux", "uy", "rotation"].into_iter().zip(side.motion) {
                row(&format!("{what} {of}"), Some(value), false);
            }
            let [fx, fy] = side.force;
            for (what, value) in [("force x", fx), ("force y", fy), ("moment", side.moment)] {
                row(&format!("{what} {of}"), Some(value), true);
            }
        }
    }
    for (body, balance) in report.bodies.iter().zip(r.balance.iter().flatten()) {
        let quantities = ["force x", "force y", "moment about the centroid"];
        for (quantity, sum) in quantities.into_iter().zip(balance) {
            row(&format!("balance of {}: {quantity}", body.name), Some(*sum), true);
        }
    }
    let whole = format!("for the thickness {}", words::short(t));
    table(page, "Results", &["quantity", "per unit thickness", &whole], rows);
}

/// What the certificate says about other quantities.
fn bounds(page: &mut String, report: &Report) {
    let b = &report.certificate.bounds;
    let rows = [
        ("energy norm", b.energy_norm),
        ("potential energy", b.potential_energy),
        ("contact force", b.contact_force),
    ];
    if rows.iter().all(|(_, bounds)| bounds.is_none()) {
        return;
    }
    let rows = rows.into_iter().filter_map(|(name, bounds)| {
        let [low, high] = bounds?;
        Some(vec![name.to_owned(), words::at_least(low), words::at_most(high)])
    });
    table(
        page,
        "Bounds of the exact solution",
        &["quantity, per unit thickness", "at least", "at most"],
        rows,
    );
    page.push_str("<p>These bounds hold whenever the certified error bound holds.</p>\n");
}

/// The meshes of an adaptive run.
fn steps(page: &mut String, report: &Report) {
    if report.adaptive.is_empty() {
        return;
    }
    let rows = report.adaptive.iter().map(|row| {
        let relative = row.relative.map_or_else(|| number(None), words::rounded_up);
        let [step, nodes, pairs, iterations] =
            [row.step, row.nodes, row.pairs, row.iterations].map(|n| n.to_string());
        vec![step, nodes, pairs, words::rounded_up(row.e_cre), relative, iterations]
    });
    table(page, "Meshes", &["step", "nodes", "pairs", "e_cre", "relative", "iterations"], rows);
}

fn iterations(page: &mut String, report: &Report) {
    let forces: Vec<String> = match report.bodies.as_slice() {
        [first, second] => [first, second].map(|body| format!("contact force of {}", body.name)).into(),
        _ => ["first", "second"].map(|side| format!("contact force of the {side} bodies")).into(),
    };
    let mut heads = vec!["it", "theta", "precision", "eta_nndd", "eta_dis", "e_cre", "contact nodes"];
    heads.extend(forces.iter().map(String::as_str));
    heads.push("contact problem");
    let rows = report.iterations.iter().map(|row| {
        let mut cells = vec![row.iteration.to_string()];
        cells.extend([row.theta, row.precision, row.eta_nndd, row.eta_dis].map(number));
        cells.push(row.e_cre.map_or_else(|| number(None), words::at_most));
        cells.push(row.contact_nodes.to_string());
        cells.extend(row.contact_forces.map(number));
        cells.push(format!("{} {}", row.qp_path.as_deref().unwrap_or("–"), row.qp_iterations));
        cells
    });
    table(page, "Iterations", &heads, rows);
}

fn number(value: Option<f64>) -> String {
    match value {
        None => "–".into(),
        Some(0.0) => "0".into(),
        Some(x) if (1e-3..1e5).contains(&x.abs()) => format!("{x:.6}"),
        Some(x) => format!("{x:.5e}"),
    }
}

fn escape(text: &str) -> String {
    words::escaped(&plain(text))
}

#[cfg(test)]
mod tests {
    use super::shell_word;

    #[test]
    fn words_are_quoted_where_a_shell_would_read_them_otherwise() {
        assert_eq!(shell_word("solver.theta=0.5"), "solver.theta=0.5");
        assert_eq!(shell_word("body.0.generator.cells=[36,18]"), "'body.0.generator.cells=[36,18]'");
        assert_eq!(shell_word("title=\"a b\""), "'title=\"a b\"'");
        assert_eq!(shell_word("it's"), "'it'\\''s'");
        assert_eq!(shell_word(""), "''");
        assert_eq!(shell_word("$HOME"), "'$HOME'");
    }
}

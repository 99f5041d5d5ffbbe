//! report.html: one page with everything, for people. No network; the only script turns the view of solids.

mod glance;
mod results;
mod view;

use crate::convert;
use crate::figures::Picture;
use crate::settings;
use crate::space::ReportSpace;
use crate::words::{self, one_line, plain, with_digits};
use case_io::Case;
use case_io::case::{BodyCase, Method, Units};
use case_io::report::{Certificate, Checks, ContactSummary, Coulomb, Report};
use cre_estimator::FieldCertificate;
use fem_core::body::Body;
use fem_core::geometry::Coordinates;
use fem_core::interface::ContactProblem;
use glance::glance;
use results::results;
use serde_json::Value;
use std::fmt::Write as _;

/// The style sheet; the page holds it on one line.
const STYLE: &str = include_str!("html/style.css");

/// Writes the page of another code's field.
///
/// * `lines`: what was found; `picture`: a map of the error, in place of which a table may stand; `files`: with the field.
pub(crate) fn of_field<S: ReportSpace>(
    case: &Case<S>,
    (problem, found): (&ContactProblem<S>, &FieldCertificate<S>),
    lines: &str,
    picture: Option<&Picture>,
    files: &[String],
) -> String {
    let mut page = head(case);
    let class = if found.bound().is_some() { "ok" } else { "no" };
    let lines: Vec<String> = lines.lines().map(escape).collect();
    let _ = writeln!(page, "<div class=\"verdict {class}\"><p>{}</p></div>", lines.join("</p><p>"));
    match picture {
        Some(picture) => figures(&mut page, std::slice::from_ref(picture)),
        None => largest_errors(&mut page, case, problem, found),
    }
    let valid = found.bound().is_some();
    let e_cre = found.estimate.unchecked().e_cre;
    let shown = |value: f64| words::rounded_up(value);
    let rows = [
        ("bound: the sum of the next two", found.bound().map_or_else(|| number(None), shown)),
        ("bound for the admissible field", if valid { shown(e_cre) } else { number(None) }),
        ("energy norm of what was changed to make it admissible", shown(found.change)),
        ("energy norm of the admissible field", number(Some(found.estimate.energy_norm()))),
    ];
    let rows = rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]);
    table(&mut page, "Bound", &["part", &with_unit(case, "energy norm", Units::energy_norm::<S>)], rows);
    let failed = found.estimate.admissibility.failed();
    let failed: Vec<_> = failed.map(|(key, x)| vec![key.replace('_', " "), with_digits(x, 2)]).collect();
    if !failed.is_empty() {
        table(&mut page, "Checks that failed", &["residual", "relative"], failed);
    }
    table(&mut page, "Files", &["file of the field"], files.iter().map(|file| vec![file.clone()]));
    page.push_str("</body></html>\n");
    page
}

/// Writes where the squared error of a field is, if there is no map of it: its share in each body, and the cell of the largest density.
fn largest_errors<S: ReportSpace>(
    page: &mut String,
    case: &Case<S>,
    problem: &ContactProblem<S>,
    found: &FieldCertificate<S>,
) {
    let of_bodies = &found.estimate.cre.by_cell;
    let total: f64 = of_bodies.iter().flatten().sum();
    let row = |((body, given), squared): ((&Body<S>, &BodyCase<S>), &Vec<f64>)| {
        let density = |t: &usize| squared[*t] / body.mesh().measure(*t);
        let cells = 0..squared.len();
        let largest = cells.max_by(|a, b| density(a).total_cmp(&density(b))).unwrap_or_default();
        let middle = body.mesh().corners(largest).into_iter().sum::<S::Vector>() / (S::DIM + 1) as f64;
        let mut sorted = squared.clone();
        sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let own: f64 = squared.iter().sum();
        let sums = sorted.iter().scan(0.0, |sum, e| Some(std::mem::replace(sum, *sum + e)));
        let half = sums.take_while(|before| *before < 0.5 * own).count();
        let share = if total > 0.0 { with_digits(100.0 * own / total, 3) } else { number(None) };
        let place = middle.entries().iter().map(|x| with_digits(*x, 4)).collect::<Vec<_>>().join(", ");
        vec![given.name.clone(), share, half.to_string(), squared.len().to_string(), format!("({place})")]
    };
    let rows = problem.bodies.iter().zip(&case.bodies).zip(of_bodies).map(row);
    let heads =
        ["body", "% of the squared error", "cells with half of the body's", "cells", "largest density at"];
    table(page, "Where the error is", &heads, rows);
    page.push_str(
        "<p>Solids have no map of the error on this page: the `.vtu` file of each body has the error density of every \
         cell. What was changed to make the given field admissible is not in it.</p>\n",
    );
}

/// Writes the page.
///
/// * `problem`: on the last mesh.
pub(crate) fn page<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    report: &Report,
    pictures: &[Picture],
) -> String {
    let mut page = head(case);
    verdict(&mut page, report);
    glance(&mut page, case, report);
    figures(&mut page, pictures);
    notes(&mut page, report);
    if report.certificate.as_ref().is_some_and(|found| found.e_cre.is_some()) || report.coulomb.is_some() {
        results(&mut page, case, problem, report);
    }
    let angles: Vec<f64> = problem.bodies.iter().map(|body| body.mesh().smallest_angle()).collect();
    bodies(&mut page, case, report, &angles);
    if let Some(certificate) = report.certificate.as_ref().filter(|found| found.e_cre.is_some()) {
        parts(&mut page, case, certificate);
        checks(&mut page, "Checks of the certificate", &certificate.checks);
    }
    if let Some(coulomb) = &report.coulomb {
        fixed_point(&mut page, coulomb);
        checks(&mut page, "Checks of the stresses of the residual", &coulomb.checks);
    }
    bounds(&mut page, case, report);
    steps(&mut page, case, report);
    iterations(&mut page, case, convert::method(case, problem), report);
    let settings = settings::toml(&report.case);
    let _ = writeln!(page, "<h2>Settings</h2>\n<pre>{}</pre>", escape(&settings));
    reproduce(&mut page, case, report);
    page.push_str("</body></html>\n");
    page
}

/// Begins a page with its title.
fn head<S: ReportSpace>(case: &Case<S>) -> String {
    let title = escape(&one_line(if case.title.is_empty() { case.file_name() } else { &case.title }));
    let style = STYLE.replace('\n', "");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>{title}</title><style>{style}</style></head><body>\n<h1>{title}</h1>\n"
    )
}

/// Writes how to reproduce this page. Times and the machine are left out, so that the page is the same every time.
fn reproduce<S: ReportSpace>(page: &mut String, case: &Case<S>, report: &Report) {
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

/// Rows of a table that is not split over two sheets of paper.
const MOST_ON_A_SHEET: usize = 20;

/// Characters of a cell that is not broken into lines, such as a number with its unit.
const LONG: usize = 20;

/// Writes a table below a title, the cells of each row as text.
fn table(page: &mut String, title: &str, heads: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
    table_of(page, title, heads, &mut rows.into_iter());
}

fn table_of(page: &mut String, title: &str, heads: &[&str], rows: &mut dyn Iterator<Item = Vec<String>>) {
    let row = |kind: &str, cells: &mut dyn Iterator<Item = &str>| {
        let cell = |(k, cell): (usize, &str)| {
            let long = k > 0 && kind == "td" && cell.chars().count() > LONG;
            format!("<{kind}{}>{}</{kind}>", if long { " class=\"long\"" } else { "" }, escape(cell))
        };
        let cells: String = cells.enumerate().map(cell).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: Vec<String> = rows.map(|cells| row("td", &mut cells.iter().map(String::as_str))).collect();
    // A short table stays on one sheet with its title.
    let class = if rows.len() <= MOST_ON_A_SHEET { " class=\"short\"" } else { "" };
    let _ = writeln!(page, "<div{class}>");
    if !title.is_empty() {
        let _ = writeln!(page, "<h2>{title}</h2>");
    }
    let head = row("th", &mut heads.iter().copied());
    let _ = writeln!(page, "<table><thead>{head}</thead><tbody>\n{}</tbody></table></div>", rows.concat());
}

/// The sizes of the bodies on the last mesh.
fn bodies<S: ReportSpace>(page: &mut String, case: &Case<S>, report: &Report, angles: &[f64]) {
    let rows = report.bodies.iter().zip(angles).enumerate().map(|(k, (body, angle))| {
        let materials = case.materials_of(k).into_iter().map(|m| format!("{}: {}", m.name, m.summary()));
        let [nodes, cells, unknowns] = [body.nodes, body.cells.count(), body.unknowns].map(|n| n.to_string());
        let materials = materials.collect::<Vec<_>>().join("; ");
        vec![body.name.clone(), nodes, cells, unknowns, format!("{angle:.1}°"), materials]
    });
    table(page, "Bodies", &["body", "nodes", S::WORDS.cells, "unknowns", "smallest angle", "material"], rows);
    let measure = |contact: &ContactSummary| {
        let length = contact.line.as_ref().map(|line| line.length);
        number(length.or(contact.surface.as_ref().map(|surface| surface.area.total)))
    };
    if let [contact] = report.contact.as_slice()
        && !contact.imposed.is_empty()
    {
        let _ = writeln!(
            page,
            "<p>{}: {} pairs, {} {}; λ is carried by {}.</p>",
            sentence(S::INTERFACE).trim_end_matches('.'),
            contact.pairs,
            S::EXTENT,
            escape(format!("{} {}", measure(contact), unit(case, S::extent_unit)).trim_end()),
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
        cells.push(measure(contact));
        let digits = words::certified_digits(certified(report));
        let shown = |x: Option<f64>| x.map_or_else(|| number(None), |x| with_digits(x, digits));
        cells.extend([contact.contact_force, contact.max_pressure].map(shown));
        let place = |at: &Vec<f64>| words::place(at, at.iter().fold(0.0, |most, x| x.abs().max(most)));
        cells.push(contact.max_pressure_at.as_ref().map_or_else(|| number(None), place));
        cells
    });
    if !report.contact.is_empty() {
        let extent = with_unit(case, S::EXTENT, S::extent_unit);
        let force = with_unit(case, S::PRESSURE_INTEGRAL, S::force_unit);
        let pressure = with_unit(case, "largest pressure", Units::stress);
        let place = with_unit(case, "its place", |u| u.length.clone());
        let heads = ["pair", "of", "nodes", "in contact", &extent, &force, &pressure, &place];
        table(page, "Contact", &heads, rows);
    }
}

fn verdict(page: &mut String, report: &Report) {
    let valid = report.valid_certificate();
    let class = if valid.is_some() && report.status.code == 0 { "ok" } else { "no" };
    let text = crate::verdict::verdict(report);
    let lines: Vec<String> = text.lines().filter(|l| !l.is_empty()).map(escape).collect();
    let _ = writeln!(page, "<div class=\"verdict {class}\"><p>{}</p></div>", lines.join("</p><p>"));
    if let Some(certificate) = valid.filter(|found| found.relative.is_some()) {
        let exact = certificate.relative_guaranteed.map_or_else(String::new, |relative| {
            format!(
                "; over that of the exact ones the error is at most {} %",
                words::rounded_up(100.0 * relative)
            )
        });
        let _ = writeln!(
            page,
            "<p>The percentage is the bound over the energy norm of the computed displacements{exact}.</p>"
        );
        let percent =
            certificate.relative.map_or_else(String::new, |relative| words::rounded_up(100.0 * relative));
        let _ = writeln!(
            page,
            "<p>What {percent} % means: the energy norm of a displacement is the root of twice its strain energy. For the difference between the \
             computed and the exact displacements it is at most this part of its value for the computed ones. A stress at a point may be \
             off by more. The guide says how the bound is found: ‘What the indicators mean’ in <code>tests/cases/GUIDE.md</code>.</p>"
        );
    }
}

/// Writes the notes that a reader of the numbers must know.
fn notes(page: &mut String, report: &Report) {
    if report.notes.is_empty() {
        return;
    }
    page.push_str("<h2>Notes</h2>\n<ul>");
    for note in &report.notes {
        let _ = write!(page, "<li>{}</li>", escape(&sentence(note)));
    }
    page.push_str("</ul>\n");
}

/// Writes a note as a sentence.
fn sentence(note: &str) -> String {
    let mut letters = note.chars();
    // A key of the case file is written as it is.
    let key = note.split([' ', ':']).next().is_some_and(|word| word.contains(['.', '_', '=', '[']));
    let first = letters.next().map(|c| if key { c.to_string() } else { c.to_uppercase().to_string() });
    let end = if note.ends_with('.') { "" } else { "." };
    format!("{}{}{end}", first.unwrap_or_default(), letters.as_str())
}

fn figures(page: &mut String, pictures: &[Picture]) {
    page.push_str("<div class=\"figures\">\n");
    for picture in pictures {
        page.push_str("<figure>");
        if let Some(data) = &picture.view {
            view::write(page, data);
        }
        let _ = write!(page, "{}<figcaption>{}", picture.svg, escape(&picture.caption));
        if let Some(file) = &picture.numbers {
            let _ = write!(page, " Numbers: <a href=\"{file}\">{file}</a>.");
        }
        page.push_str("</figcaption></figure>\n");
    }
    page.push_str("</div>\n");
}

/// Writes the table of the parts of the bound.
fn parts<S: ReportSpace>(page: &mut String, case: &Case<S>, certificate: &Certificate) {
    page.push_str(
        "<h2>Parts of the bound</h2>\n<p>The squares of all but round-off add up to the square of the bound without \
         round-off.</p>\n",
    );
    let parts = &certificate.parts;
    let finer = &*format!("a finer mesh at the {}", S::INTERFACE);
    let rows = [
        ("mesh", parts.mesh, "a finer mesh"),
        ("iteration, at most eta_nndd", parts.iteration, "more iterations"),
        ("contact law, which holds at the nodes only", parts.contact, finer),
        ("lift on bent contact", parts.lift, finer),
        ("gap that bent edges cannot represent", parts.gap_data, finer),
        ("friction", parts.friction, finer),
        ("round-off", parts.round_off, "nothing"),
    ];
    let rows = rows.into_iter().filter(|(_, value, _)| *value != Some(0.0));
    // Each is a bound.
    let shown = |value: Option<f64>| value.map_or_else(|| number(None), words::rounded_up);
    let rows = rows.map(|(name, value, cure)| vec![name.into(), shown(value), cure.into()]);
    table(
        page,
        "",
        &["part", &with_unit(case, "energy norm", Units::energy_norm::<S>), "what lowers it"],
        rows,
    );
}

/// How the limit of Coulomb friction was found, and what is known of the residual.
fn fixed_point(page: &mut String, coulomb: &Coulomb) {
    let signs = if coulomb.one_sign { "one sign in each pair" } else { "both signs in a pair" };
    let rows = [
        ("residual e_b, an indicator and no bound", number(coulomb.e_b)),
        ("over the energy norm", number(coulomb.relative)),
        ("steps of the fixed point", coulomb.steps.to_string()),
        ("relative change of the friction limit in the last step", number(coulomb.change)),
        ("slips", signs.to_owned()),
        ("coupling between pressure and slip on this mesh, without the coefficients", number(coulomb.kappa)),
        ("with the coefficients", number(coulomb.coupling)),
    ];
    let rows = rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]);
    table(page, "Coulomb friction", &["quantity", "value"], rows);
}

fn checks(page: &mut String, title: &str, checks: &Checks) {
    let shown = |value: Option<f64>| value.map_or_else(|| number(None), |x| with_digits(x, 2));
    let rows = checks.named().into_iter().filter(|(key, _)| *key != "rotation");
    let rows = rows.map(|(key, value)| vec![key.replace('_', " "), shown(value)]);
    table(page, title, &["residual", "relative"], rows);
    if checks.rotation.is_some_and(|angle| angle > 0.0) {
        let _ = writeln!(
            page,
            "<p>The largest rigid rotation is {} radians; up to 0.1 displacements are small.</p>",
            shown(checks.rotation)
        );
    }
}

/// Returns a unit of the case; an empty text if it names none.
fn unit<S: ReportSpace>(case: &Case<S>, of: fn(&Units) -> String) -> String {
    case.units.as_ref().map(of).unwrap_or_default()
}

/// Adds the unit to the name of a quantity, if the case names units.
fn with_unit<S: ReportSpace>(case: &Case<S>, what: &str, of: fn(&Units) -> String) -> String {
    case.units.as_ref().map_or_else(|| what.to_owned(), |units| format!("{what} [{}]", of(units)))
}

/// The certified relative error, if the certificate is valid.
fn certified(report: &Report) -> Option<f64> {
    report.valid_certificate()?.relative
}

/// Writes the bounds of other quantities that follow from the certificate.
fn bounds<S: ReportSpace>(page: &mut String, case: &Case<S>, report: &Report) {
    let Some(b) = report.certificate.as_ref().map(|found| &found.bounds) else { return };
    let rows = [
        (with_unit(case, "energy norm", Units::energy_norm::<S>), b.energy_norm),
        (with_unit(case, "potential energy", S::moment_unit), b.potential_energy),
        (
            with_unit(case, &format!("contact force, {}", S::PRESSURE_INTEGRAL), S::force_unit),
            b.contact_force,
        ),
    ];
    if rows.iter().all(|(_, bounds)| bounds.is_none()) {
        return;
    }
    let rows = rows.into_iter().filter_map(|(name, bounds)| {
        let [low, high] = bounds?;
        Some(vec![name, words::at_least(low), words::at_most(high)])
    });
    table(
        page,
        "Bounds of the exact solution",
        &[
            if S::thickness(&case.model).is_some() { "quantity, per unit thickness" } else { "quantity" },
            "at least",
            "at most",
        ],
        rows,
    );
    let reason = b.contact_force_reason.as_ref().filter(|_| !report.contact.is_empty());
    let none =
        reason.map(|reason| format!(" The contact force has none: {}.", escape(reason))).unwrap_or_default();
    let _ = writeln!(page, "<p>These bounds hold whenever the certified error bound holds.{none}</p>");
}

/// The meshes of an adaptive run.
fn steps<S: ReportSpace>(page: &mut String, case: &Case<S>, report: &Report) {
    if report.adaptive.is_empty() {
        return;
    }
    // In load steps the numbers of a mesh are those of one step.
    let in_steps = report.adaptive.iter().any(|row| row.load_step.is_some());
    let rows = report.adaptive.iter().map(|row| {
        let shown = |x: Option<f64>| x.map_or_else(|| number(None), words::rounded_up);
        let (error, relative) = (row.e_cre.or(row.e_b), row.relative.or(row.relative_residual));
        let [step, nodes, pairs, iterations] =
            [row.step, row.nodes, row.pairs, row.iterations].map(|n| n.to_string());
        let load_step = row.load_step.map(|step| step.to_string()).filter(|_| in_steps);
        let cells = [Some(step), Some(nodes), Some(pairs), load_step];
        cells.into_iter().flatten().chain([shown(error), shown(relative), iterations]).collect()
    });
    let error = if report.coulomb.is_some() { "e_b" } else { "e_cre" };
    let error = with_unit(case, error, Units::energy_norm::<S>);
    let of_step: &[&str] = if in_steps { &["load step"] } else { &[] };
    let heads = [&["mesh", "nodes", "pairs"], of_step, &[&error, "relative", "iterations"]].concat();
    table(page, "Meshes", &heads, rows);
}

fn iterations<S: ReportSpace>(page: &mut String, case: &Case<S>, method: Method, report: &Report) {
    let forces: Vec<String> = match report.bodies.as_slice() {
        [first, second] => [first, second].map(|body| format!("contact force of {}", body.name)).into(),
        _ => ["first", "second"].map(|side| format!("contact force of the {side} bodies")).into(),
    };
    if report.coulomb.is_none() {
        let _ = writeln!(page, "<h2>Method</h2>\n<p><code>{method}</code>: {}</p>", words::of_method(method));
    }
    // Newton's steps have no theta.
    let in_steps = report.iterations.iter().any(|row| row.step.is_some());
    let of_method: &[&str] = if in_steps { &["step", "inner"] } else { &["theta"] };
    let mut heads: Vec<String> =
        [&["it"], of_method, &["precision"]].concat().into_iter().map(Into::into).collect();
    heads.extend(["eta_nndd", "eta_dis", "e_cre"].map(|what| with_unit(case, what, Units::energy_norm::<S>)));
    heads.push("contact nodes".into());
    heads.extend(forces.iter().map(|what| with_unit(case, what, S::force_unit)));
    heads.push("contact problem".into());
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let rows = report.iterations.iter().map(|row| {
        let mut cells = vec![row.iteration.to_string()];
        match in_steps {
            true => {
                cells.extend([row.step, row.inner].map(|n| n.map_or_else(|| number(None), |n| n.to_string())))
            }
            false => cells.push(number(row.theta)),
        }
        cells.extend([row.precision, row.eta_nndd, row.eta_dis].map(number));
        cells.push(row.e_cre.map_or_else(|| number(None), words::rounded_up));
        cells.push(row.contact_nodes.to_string());
        cells.extend(row.contact_forces.map(number));
        cells.push(format!("{} {}", row.qp_path.as_deref().unwrap_or("–"), row.qp_iterations));
        cells
    });
    table(page, "Iterations", &heads, rows);
}

/// Digits of indicators and other numbers that are no results.
const DIGITS: usize = 4;

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |x| with_digits(x, DIGITS))
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

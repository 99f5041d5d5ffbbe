//! From the document to a [`Case`]: every section with its defaults and checks, except the bodies'.

use super::dimension::{Keys, refuse_foreign};
use super::{
    Acceleration, Case, Contact, Criterion, Dimension, Estimator, Friction, Imposed, Limit, Limits, Method,
    Output, OutputPath, QpChoice, SCHEMA, Solver, Subdomains, Theta, Value, Weights,
};
use super::{inside, materials, path, read_adapt, read_body, read_contact, regions, steps, units};
use crate::case_file::{self, Document, Findings, NodeValue, Reader};
use crate::diagnostic::{CaseError, Diagnostic, code, excerpt};
use mesh_io::numeral;

/// Reads all sections and collects what is wrong with any of them.
pub(super) fn case<S: Keys>(document: &Document, file_name: &str) -> Result<Case<S>, CaseError> {
    let findings = Findings::new(S::COORDINATES);
    let mut root = Reader::new(&findings, &document.root, String::new(), &document.at);
    schema(&mut root)?;
    let foreign = refuse_foreign::<S>(&mut root, "");
    root.require(&["body", "contact", "materials"]);
    let title = root.string("title").unwrap_or_default();
    let units = units::units(root.table("units"));
    let mut reader = root.table("model");
    let model = S::model(reader.as_mut());
    let inertia = reader.as_mut().and_then(inside::inertia::<S>);
    if let Some(reader) = reader {
        reader.finish();
    }
    let materials = root.table("materials").map(|r| materials::materials::<S>(r, &model)).unwrap_or_default();
    let mut bodies = read_body::bodies::<S>(&mut root);
    regions::check_references(&root, &materials, &bodies);
    inside::check(&root, (&materials, &bodies), inertia.as_ref());
    let contacts = read_contact::contacts(&mut root, &mut bodies);
    let solver = solver(root.table("solver"));
    let estimator = estimator::<S>(root.table("estimator"));
    let adapt = if foreign { None } else { read_adapt::adapt(&mut root, &contacts) };
    refuse_with_friction(&root, &contacts, &solver);
    refuse_with_subdomains(&root, &contacts, &solver);
    let steps = if foreign { Vec::new() } else { steps::steps(&mut root, (&bodies, &contacts)) };
    let (output, paths) = output(root.table("output"));
    let limits = root.table("limits").map(limits).unwrap_or_default();
    root.finish();
    let (diagnostics, omitted, places) = findings.into_parts();
    match diagnostics.is_empty() {
        true => Ok(Case {
            title,
            units,
            model,
            inertia,
            materials,
            bodies,
            contacts,
            solver,
            estimator,
            adapt,
            steps,
            output,
            paths,
            limits,
            meshes: Default::default(),
            file_name: file_name.to_owned(),
            places,
        }),
        false => Err(CaseError::new(diagnostics).and_more(omitted)),
    }
}

/// Checks the version first: in a file of another version every other message would mislead.
fn schema(root: &mut Reader<'_>) -> Result<(), CaseError> {
    let version = env!("CARGO_PKG_VERSION");
    let fault = |code, root: &Reader<'_>, message: String| {
        CaseError::from(
            Diagnostic::new(code, root.place_of("schema"), message)
                .expected(format!("schema = {SCHEMA}"))
                .fix(format!("write `schema = {SCHEMA}`, or use the nndd the file was written for")),
        )
    };
    let Some(node) = root.node("schema") else {
        root.require(&["schema"]);
        return Ok(());
    };
    match node.value {
        NodeValue::Integer(found) if found == i128::from(SCHEMA) => Ok(()),
        NodeValue::Integer(found) if found > i128::from(SCHEMA) => Err(fault(
            code::VALUE,
            root,
            format!(
                "`schema` is {found}, which a newer nndd reads; this is version {version}, which reads schema {SCHEMA}"
            ),
        )),
        NodeValue::Integer(found) => Err(fault(code::VALUE, root, format!("`schema` is {found}"))),
        ref other => Err(fault(code::TYPE, root, format!("`schema` is {}", other.type_name()))),
    }
}

/// Refuses what friction is not supported with.
fn refuse_with_friction<S: Dimension>(root: &Reader<'_>, contacts: &[Contact<S>], solver: &Solver) {
    let refuse = |key: &str, what: &str, (law, pair): (&str, &Contact<S>), expected: &str| {
        let message = format!("{what}, and the pair {} has {law}", excerpt(&pair.name));
        let place = root.findings().place(key);
        let diagnostic = Diagnostic::new(code::VALUE, place, message).expected(expected);
        root.findings().push(diagnostic.fix(format!("take it out, or `{}.friction`", pair.path)));
    };
    let in_space = contacts.iter().find(|contact| !S::ONE_TANGENT && contact.friction.is_some());
    if let Some(pair) = in_space.filter(|_| solver.method == Method::Nndd) {
        let what = "`solver.method` = \"nndd\" does not support friction of solids";
        refuse("solver.method", what, ("it", pair), "`method = \"auto\"`");
        return;
    }
    let coulomb = contacts.iter().find(|contact| matches!(contact.friction, Some(Friction::Coulomb { .. })));
    let Some(pair) = coulomb else { return };
    if solver.method == Method::Nndd {
        let what = "`solver.method` = \"nndd\" does not support Coulomb friction";
        refuse("solver.method", what, ("it", pair), "`method = \"auto\"`");
    }
    if let Theta::Value(_) = solver.theta {
        let what = "`solver.theta` belongs to the iteration, which does not support Coulomb friction";
        refuse("solver.theta", what, ("it", pair), "no `theta`, or `theta = \"auto\"`");
    }
}

fn positive(value: f64) -> bool {
    value > 0.0
}

/// Iterations at most, by default.
const MAX_ITERATIONS: usize = 50;
/// Change of the limit of friction at the end, by default, and steps at most.
const FRICTION_TOLERANCE: f64 = 1e-6;
const FRICTION_STEPS: usize = 50;

fn solver(reader: Option<Reader<'_>>) -> Solver {
    let mut solver = Solver {
        coarse: true,
        max_iterations: MAX_ITERATIONS,
        friction_tolerance: FRICTION_TOLERANCE,
        friction_steps: FRICTION_STEPS,
        ..Solver::default()
    };
    let Some(mut r) = reader else { return solver };
    solver.method = r.choice("method", Method::NAMES).unwrap_or_default();
    solver.subdomains = subdomains(&mut r);
    solver.imposed = r.choice("imposed", Imposed::NAMES).unwrap_or_default();
    // Kept for old cases.
    r.choice_or(
        "path",
        &[("condensed", ())],
        |_| "take it out: both words gave the same numbers, and one of them is left",
    );
    solver.qp = r.choice("qp", QpChoice::NAMES).unwrap_or_default();
    solver.theta = theta(&mut r);
    solver.weights = r.choice("weights", Weights::NAMES).unwrap_or_default();
    solver.acceleration = r.choice("acceleration", Acceleration::NAMES).unwrap_or_default();
    solver.lambda = r.value("lambda").unwrap_or_default();
    if let Value::Given(_) = solver.lambda {
        let expected = r.findings().expression();
        r.refuse("lambda", "`solver.lambda` takes no values at nodes", &expected, "write a number there");
    }
    solver.coarse = r.boolean("coarse").unwrap_or(true);
    solver.max_iterations = r.count("max_iterations", 0).unwrap_or(solver.max_iterations);
    let tolerance = r.number_where("friction_tolerance", positive, "a number > 0");
    solver.friction_tolerance = tolerance.unwrap_or(solver.friction_tolerance);
    solver.friction_steps = r.count("friction_steps", 1).unwrap_or(solver.friction_steps);
    if let Some(mut r) = r.table("stop") {
        let stop = &mut solver.stop;
        stop.criterion = r.choice("criterion", Criterion::NAMES).unwrap_or_default();
        let ratio = r.number_where("ratio", positive, "a number > 0");
        let balance = r.number_where("force_balance", positive, "a number > 0");
        // A ratio alone is the only condition.
        stop.force_balance = if ratio.is_some() { balance } else { balance.or(stop.force_balance) };
        stop.ratio = ratio.unwrap_or(stop.ratio);
        stop.tolerance = r.number_where("tolerance", positive, "a number > 0").unwrap_or(stop.tolerance);
        r.finish();
    }
    r.finish();
    solver
}

fn subdomains(r: &mut Reader<'_>) -> Subdomains {
    match r.node("subdomains").map(|n| &n.value) {
        None => Subdomains::Auto,
        Some(NodeValue::String(word)) if word == "auto" => Subdomains::Auto,
        Some(NodeValue::String(word)) => {
            let message = format!("`solver.subdomains` is the string {}", excerpt(word));
            r.refuse(
                "subdomains",
                message,
                "a whole number ≥ 1, or \"auto\"",
                "write `subdomains = \"auto\"`",
            );
            Subdomains::Auto
        }
        Some(_) => r.count("subdomains", 1).map_or(Subdomains::Auto, Subdomains::Count),
    }
}

/// Refuses what bodies in subdomains are not supported with.
fn refuse_with_subdomains<S: Dimension>(root: &Reader<'_>, contacts: &[Contact<S>], solver: &Solver) {
    let Subdomains::Count(2..) = solver.subdomains else { return };
    let refuse = |message: String, expected: &str, fix: String| {
        let place = root.findings().place("solver.subdomains");
        let diagnostic = Diagnostic::new(code::VALUE, place, message).expected(expected);
        root.findings().push(diagnostic.fix(fix));
    };
    if !matches!(solver.method, Method::Auto | Method::NewtonNn) {
        let message = "`solver.subdomains` needs the method \"newton-nn\"".to_owned();
        let fix = "take `solver.method` out, or write `subdomains = 1`".to_owned();
        refuse(message, "`method = \"newton-nn\"` or \"auto\"", fix);
    }
    if let Some(pair) = contacts.iter().find(|contact| contact.friction.is_some()) {
        let message = format!(
            "`solver.subdomains` does not go with friction, and the pair {} has it",
            excerpt(&pair.name)
        );
        let fix = format!("write `subdomains = 1`, or take `{}.friction` out", pair.path);
        refuse(message, "bodies in one piece, or contact without friction", fix);
    }
}

fn theta(r: &mut Reader<'_>) -> Theta {
    let expected = "a number > 0, or \"auto\"";
    match r.node("theta").map(|n| &n.value) {
        None => Theta::Auto,
        Some(NodeValue::String(word)) if word == "auto" => Theta::Auto,
        Some(NodeValue::String(word)) => {
            let advice = numeral::advice(word);
            let and = advice.as_ref().map_or("", |_| ", which is not a number");
            let message = format!("`solver.theta` is the string {}{and}", excerpt(word));
            let fix = advice.unwrap_or_else(|| "write `theta = \"auto\"`".to_owned());
            r.refuse("theta", message, expected, &fix);
            Theta::Auto
        }
        Some(_) => r.number_where("theta", positive, expected).map_or(Theta::Auto, Theta::Value),
    }
}

fn estimator<S: Dimension>(reader: Option<Reader<'_>>) -> Estimator {
    let mut estimator = Estimator { relaxation: 0, until: Some(S::RELAX_UNTIL), every: 0 };
    let Some(mut r) = reader else { return estimator };
    estimator.until = read_adapt::relax_until::<S>(&mut r);
    if let Some(steps) = r.count("relaxation", 0) {
        (estimator.relaxation, estimator.until) = (steps, None);
    }
    estimator.every = r.count("every", 0).unwrap_or(estimator.every);
    r.finish();
    estimator
}

fn output<S: Keys>(reader: Option<Reader<'_>>) -> (Output, Vec<OutputPath<S>>) {
    let mut output = Output { directory: None, vtu: true };
    let Some(mut r) = reader else { return (output, Vec::new()) };
    output.directory = r.string("directory");
    if output.directory.as_ref().is_some_and(|d| d.trim().is_empty() || d.contains('\0')) {
        let expected = "a directory, such as \"runs/paper\"";
        r.refuse("directory", "`output.directory` is not a path", expected, "leave it out for runs/NAME");
    }
    output.vtu = r.boolean("vtu").unwrap_or(output.vtu);
    let paths = path::paths(&mut r);
    r.finish();
    (output, paths)
}

fn limits(mut r: Reader<'_>) -> Limits {
    let memory =
        limit(&mut r, "memory", case_file::memory, "an amount of memory, such as \"4GiB\" or \"512MB\"");
    let time = limit(&mut r, "time", case_file::time, "a time, such as \"30s\", \"10min\" or \"2h\"");
    r.finish();
    Limits { memory, time }
}

fn limit<T>(
    r: &mut Reader<'_>,
    key: &'static str,
    parse: impl Fn(&str) -> Option<T>,
    expected: &str,
) -> Option<Limit<T>> {
    let written = r.string(key)?;
    match parse(&written) {
        Some(value) => Some(Limit { written, value }),
        None => {
            let message = format!("`limits.{key}` is {}", excerpt(&written));
            r.refuse(key, message, expected, "write a number above 0 and its unit, in quotes");
            None
        }
    }
}

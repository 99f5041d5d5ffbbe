//! Random settings: every method and criterion, early stops, adaptivity, load steps.

use super::draw::Draw;
use std::fmt::Write as _;

/// Settings as dotted keys and their values.
pub(super) type Settings = Vec<(&'static str, String)>;

fn quoted(word: &str) -> String {
    format!("\"{word}\"")
}

/// The properties of a problem that decide which settings it allows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowed {
    /// True for two held bodies with one pair.
    pub(super) held: bool,
    /// True for Coulomb friction.
    pub(super) coulomb: bool,
    /// How often the mesh is refined; 0: never.
    pub(super) adapt: f64,
    /// True if there is a contact pair.
    pub(super) contact: bool,
}

/// Draws the settings of a run.
pub(super) fn draw(d: &mut Draw, of: Allowed) -> Settings {
    let mut all: Settings = vec![("output.vtu", "false".into())];
    if d.on(0.05, "labels of units") {
        all.extend([("units.length", quoted("mm")), ("units.force", quoted("N"))]);
    }
    if d.on(0.05, "limits") {
        all.extend([("limits.memory", quoted("4GiB")), ("limits.time", quoted("10min"))]);
    }
    if of.adapt > 0.0 && d.on(of.adapt, "adaptive") {
        let key = if of.coulomb { "adapt.target_coulomb_residual" } else { "adapt.target_relative_error" };
        all.push((key, format!("{:?}", d.between(0.005, 0.2))));
        all.push(("adapt.max_steps", d.random.integer(2, 4).to_string()));
        all.push(("adapt.max_nodes", "2500".into()));
        all.push(("adapt.fraction", format!("{:?}", d.between(0.2, 0.8))));
    }
    if d.on(0.2, "fixed relaxation") {
        all.push(("estimator.relaxation", d.random.integer(0, 5).to_string()));
    } else if d.on(0.15, "relaxation by tolerance") {
        all.push(("estimator.tolerance", format!("{:?}", d.between(0.005, 0.1))));
        all.push(("estimator.max_steps", d.random.integer(2, 40).to_string()));
    }
    if of.coulomb {
        if d.on(0.3, "Coulomb steps") {
            all.push(("solver.friction_tolerance", "1e-8".into()));
            all.push(("solver.friction_steps", "100".into()));
        }
        return all;
    }
    if d.on(0.15, "estimate every iteration") {
        all.push(("estimator.every", d.random.integer(1, 3).to_string()));
    }
    let method = d.pick([
        "method: auto",
        "method: auto",
        "method: nndd",
        "method: newton",
        "method: exact",
        "method: newton-nn",
        "method: newton-nn",
    ]);
    let word = method.split_at("method: ".len()).1;
    all.push(("solver.method", quoted(word)));
    if d.on(0.3, "programme") {
        all.push(("solver.qp", quoted(["clarabel", "active-set", "auto"][d.random.integer(0, 2)])));
    }
    if d.on(0.3, "imposed") {
        all.push(("solver.imposed", quoted(["first", "second", "auto"][d.random.integer(0, 2)])));
    }
    if word == "nndd" && of.contact {
        iteration(d, of, &mut all);
    }
    all
}

/// Cuts bodies into subdomains, some of them with few iterations: every iterate has a bound.
pub(super) fn cut(d: &mut Draw, all: &mut Settings) {
    let of = |key: &str| all.iter().find(|(known, _)| *known == key).map(|(_, value)| value.as_str());
    if !matches!(of("solver.method"), Some("\"auto\"" | "\"newton-nn\"")) || !d.on(0.2, "subdomains") {
        return;
    }
    all.push(("solver.subdomains", d.random.integer(2, 12).to_string()));
    if d.on(0.5, "subdomains: few iterations") {
        all.retain(|(key, _)| *key != "solver.method");
        all.push(("solver.method", quoted("newton-nn")));
        all.push(("solver.stop.criterion", quoted("iterations")));
        all.push(("solver.max_iterations", d.random.integer(1, 8).to_string()));
    }
}

/// The settings of the iteration alone.
fn iteration(d: &mut Draw, of: Allowed, all: &mut Settings) {
    if d.on(0.25, "theta") {
        all.push(("solver.theta", format!("{:?}", d.between(0.1, 0.9))));
    }
    if d.on(0.3, "weights: half") {
        all.push(("solver.weights", quoted("half")));
    }
    if d.on(0.4, "acceleration") {
        all.push(("solver.acceleration", quoted(["none", "aitken", "anderson"][d.random.integer(0, 2)])));
    }
    if d.on(0.2, "initial λ") {
        let size = d.length * d.strain;
        all.push(("solver.lambda", format!("{:?}", size * d.random.signed())));
    }
    if !of.held && d.on(0.2, "no coarse space") {
        all.push(("solver.coarse", "false".into()));
    }
    if d.on(0.35, "early stop") {
        all.push(("solver.stop.criterion", quoted("iterations")));
        all.push(("solver.max_iterations", d.random.integer(1, 5).to_string()));
        return;
    }
    all.push(("solver.max_iterations", d.random.integer(20, 200).to_string()));
    match d.pick(["criterion: estimator", "criterion: precision", "criterion: eta_nndd"]) {
        "criterion: estimator" => {
            all.push(("solver.stop.ratio", format!("{:?}", 10f64.powf(d.between(-3.0, -0.5)))));
            if d.on(0.3, "force balance") {
                all.push(("solver.stop.force_balance", format!("{:?}", 10f64.powf(d.between(-5.0, -1.0)))));
            }
        }
        criterion => {
            all.push(("solver.stop.criterion", quoted(criterion.split_at("criterion: ".len()).1)));
            all.push(("solver.stop.tolerance", format!("{:?}", 10f64.powf(d.between(-10.0, -1.0)))));
        }
    }
}

/// Draws load steps for the conditions named `push`; returns the last factor.
pub(super) fn load_steps(d: &mut Draw) -> f64 {
    d.mark("load steps");
    let mut last = 1.0;
    for _ in 0..d.random.integer(1, 3) {
        last = [1.0, 1.0, 0.3, 0.01, 0.0][d.random.integer(0, 4)];
        let mut text = format!("[[step]]\nfactors = {{ push = {last:?} }}\n");
        let count = d.random.integer(1, 2);
        let _ = writeln!(text, "count = {count}");
        d.steps.push(text);
    }
    last
}

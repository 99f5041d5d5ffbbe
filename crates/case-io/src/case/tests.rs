//! Every default, every check with its place.

mod bonds;
mod building;
mod data;
mod faults;
mod given;
mod inside;
mod mesh_files;

mod numbers;
mod sides;
mod solids;

use super::*;
use fem_core::material::Hypothesis;

/// The shortest case there is, with the given text at its end.
fn minimal(rest: &str) -> String {
    format!(
        r#"schema = 1
[materials.m]
young = 1.0
poisson = 0.0
[[body]]
name = "a"
material = "m"
generator = {{ kind = "block", origin = [0.0, 1.0], size = [1, 1], cells = [2, 2] }}
[[body]]
name = "b"
material = "m"
generator = {{ kind = "block", size = [1, 1], cells = [2, 2] }}
[contact]
surfaces = ["bottom", "top"]
{rest}"#
    )
}

fn parse(text: &str) -> Case {
    Case::parse(text, "case.toml", &[]).unwrap()
}

fn set(key: &str, value: &str) -> (String, String) {
    (key.to_owned(), value.to_owned())
}

#[test]
fn every_key_has_its_own_default() {
    let case = parse(&minimal(""));
    assert_eq!(case.title, "");
    assert_eq!(case.model, Model { hypothesis: Hypothesis::PlaneStrain, thickness: 1.0 });
    assert_eq!(case.contacts[0].gap, Value::Number(0.0));
    let expected = Solver {
        method: Method::Auto,
        subdomains: Subdomains::Auto,
        imposed: Imposed::Auto,
        qp: QpChoice::Auto,
        theta: Theta::Auto,
        weights: Weights::Stiffness,
        acceleration: Acceleration::Anderson,
        coarse: true,
        lambda: Value::Number(0.0),
        max_iterations: 50,
        friction_tolerance: 1e-6,
        friction_steps: 50,
        stop: Stop {
            criterion: Criterion::Estimator,
            ratio: 0.01,
            force_balance: Some(1e-3),
            tolerance: 1e-8,
        },
    };
    assert_eq!(case.solver, expected);
    assert_eq!(case.estimator, Estimator { relaxation: 0, until: Some(Plane::RELAX_UNTIL), every: 0 });
    assert_eq!(case.adapt, None);
    assert_eq!(case.output, Output { directory: None, vtu: true });
    assert_eq!(case.output_directory(), "runs/case");
    assert_eq!(case.limits, Limits::default());
    assert_eq!(case.bodies[0].body_force, [Value::Number(0.0), Value::Number(0.0)]);
    // The tables alone change nothing, nor does one key change another's default.
    let tables = "[model]\n[solver]\n[solver.stop]\n[estimator]\n[output]\n[limits]\n";
    assert_eq!(parse(&minimal(tables)).settings_json(), case.settings_json());
    let one = parse(&minimal("[solver]\ntheta = 0.3\n"));
    assert_eq!(one.solver, Solver { theta: Theta::Value(0.3), ..expected });
}

#[test]
fn the_example_of_the_contract_is_read() {
    let case = parse(crate::template::PAPER);
    assert_eq!(case.title, "Two blocks, loss of contact");
    assert_eq!(case.materials.len(), 2);
    for (material, name, young) in [(0, "stiff", 2000.0), (1, "soft", 1000.0)] {
        let law = MaterialLaw::Isotropic { young, poisson: 0.3 };
        assert_eq!(
            case.materials[material],
            Material { name: name.into(), law, expansion: 0.0, density: None, limit: None }
        );
    }
    let upper = BodyCase {
        name: "upper".into(),
        material: "stiff".into(),
        regions: vec![],
        mesh: MeshSource::Generator(PlaneGenerator::Block {
            origin: [0.0, 1.0],
            size: [2.0, 1.0],
            cells: [18, 9],
        }),
        curves: vec![],
        body_force: [Value::Number(0.0), Value::Number(0.0)],
        temperatures: vec![],
        displacements: vec![
            Displacement {
                name: None,
                on: "left".into(),
                part: Part::default(),
                imposition: Imposition::Components([Some(Value::Number(0.0)), None]),
            },
            Displacement {
                name: None,
                on: "top".into(),
                part: Part::default(),
                imposition: Imposition::Components([None, Some(Value::Number(-0.02))]),
            },
        ],
        tractions: vec![Traction {
            name: None,
            on: "right".into(),
            part: Part::default(),
            load: Load::Vector([Value::Number(0.0), Value::Number(30.0)]),
        }],
        sides: vec![],
        rigid: vec![],
        springs: vec![],
        cuts: vec![],
    };
    assert_eq!(case.bodies[0], upper);
    assert_eq!(case.bodies[1].displacements[0].imposition, Imposition::Fixed);
    assert_eq!(case.contacts[0].surfaces, ["bottom", "top"]);
    let solver = Solver {
        method: Method::Nndd,
        subdomains: Subdomains::Auto,
        imposed: Imposed::First,
        qp: QpChoice::Auto,
        theta: Theta::Value(0.4),
        weights: Weights::Half,
        acceleration: Acceleration::None,
        coarse: true,
        lambda: Value::Number(0.0),
        max_iterations: 50,
        friction_tolerance: 1e-6,
        friction_steps: 50,
        stop: Stop { criterion: Criterion::Estimator, ratio: 0.1, force_balance: None, tolerance: 1e-8 },
    };
    assert_eq!(case.solver, solver);
    assert_eq!(case.estimator, Estimator { relaxation: 2, until: None, every: 1 });
    assert_eq!(case.output_directory(), "runs/paper");
    assert_eq!(case.node_counts(), [190, 190]);
    assert!(case.warnings().is_empty());
}

#[test]
fn every_word_of_every_choice_is_read() {
    let words = [
        ("imposed", "first second auto"),
        ("method", "auto nndd newton"),
        ("qp", "auto clarabel active-set"),
        ("weights", "half stiffness"),
        ("acceleration", "none aitken anderson"),
        ("theta", "auto"),
        ("stop.criterion", "estimator precision eta_nndd iterations"),
    ];
    for (key, words) in words {
        for word in words.split(' ') {
            let case = Case::parse(&minimal(""), "c", &[set(&format!("solver.{key}"), word)]).unwrap();
            let json = case.settings_json();
            let pointer = format!("/solver/{}", key.replace('.', "/"));
            assert_eq!(json.pointer(&pointer).unwrap(), word);
        }
    }
}

#[test]
fn a_ratio_that_is_written_counts_alone() {
    let stop = |text: &str| {
        let stop = parse(&minimal(&format!("[solver.stop]\n{text}\n"))).solver.stop;
        (stop.ratio, stop.force_balance)
    };
    assert_eq!(stop(""), (0.01, Some(1e-3)));
    assert_eq!(stop("ratio = 0.01"), (0.01, None));
    assert_eq!(stop("force_balance = 1e-4"), (0.01, Some(1e-4)));
    assert_eq!(stop("ratio = 0.1\nforce_balance = 1e-4"), (0.1, Some(1e-4)));
    // They are different cases.
    assert_ne!(parse(&minimal("[solver.stop]\nratio = 0.01\n")).hash(), parse(&minimal("")).hash());
}

#[test]
fn conditions_of_every_kind_are_read() {
    let text = minimal("").replace(
        "[[body]]\nname = \"b\"",
        "body_force = [0, -9.81]\n\
         displacement = [{ on = 'left', ux = 1, part = { x = [0, 1] } }, { on = 'top', normal = 0.5 }]\n\
         traction = [{ on = 'right', pressure = 5, part = { y = [0.5, 2.0], x = [0, 1] } }]\n\
         [[body]]\nname = \"b\"",
    );
    let case = parse(&text);
    let body = &case.bodies[0];
    assert_eq!(body.body_force, [Value::Number(0.0), Value::Number(-9.81)]);
    assert_eq!(body.displacements[0].part, Part { limits: [Some([0.0, 1.0]), None] });
    assert_eq!(body.displacements[1].imposition, Imposition::Normal(Value::Number(0.5)));
    assert_eq!(body.tractions[0].load, Load::Pressure(Value::Number(5.0)));
    let conditions = case.boundary_conditions(0);
    let part = conditions.displacements[0].edges.part.unwrap();
    assert_eq!(part, [[0.0, 1.0], [f64::NEG_INFINITY, f64::INFINITY]]);
    assert_eq!(conditions.tractions[0].edges.part.unwrap(), [[0.0, 1.0], [0.5, 2.0]]);
    assert_eq!(case.settings_json()["body"][0]["traction"][0]["part"]["y"][0], 0.5);
}

#[test]
fn limits_keep_their_words() {
    let case = parse(&minimal("[limits]\nmemory = \"4GiB\"\ntime = \"10min\"\n"));
    assert_eq!(case.limits.memory, Some(Limit { written: "4GiB".into(), value: 4 << 30 }));
    assert_eq!(case.limits.time, Some(Limit { written: "10min".into(), value: 600.0 }));
    assert_eq!(case.settings_json()["limits"]["memory"], "4GiB");
}

#[test]
fn byte_order_marks_and_carriage_returns_are_accepted() {
    let plain = parse(crate::template::PAPER).hash();
    let windows = format!("\u{FEFF}{}", crate::template::PAPER.replace('\n', "\r\n"));
    assert_eq!(parse(&windows).hash(), plain);
    assert_eq!(Case::parse_bytes(windows.as_bytes(), "c", &[]).unwrap().hash(), plain);
}

#[test]
fn overrides_replace_and_create_keys() {
    let overrides = [
        set("solver.theta", "0.3"),
        set("solver.stop.ratio", "0.2"),
        set("solver.method", "newton"),
        set("body.0.generator.cells", "[36,18]"),
        set("materials.soft.young", "5e3"),
        set("output.directory", "runs/über x"),
        set("body.0.displacement.1.uy", "-1"),
        set("limits.memory", "2GiB"),
        set("solver.theta", "0.35"),
    ];
    let case = Case::parse(crate::template::PAPER, "paper.toml", &overrides).unwrap();
    assert_eq!(case.solver.theta, Theta::Value(0.35));
    assert_eq!(case.solver.stop.ratio, 0.2);
    assert_eq!(case.solver.method, Method::Newton);
    assert_eq!(
        case.bodies[0].mesh,
        MeshSource::Generator(PlaneGenerator::Block {
            origin: [0.0, 1.0],
            size: [2.0, 1.0],
            cells: [36, 18]
        })
    );
    assert_eq!(case.materials[1].law, MaterialLaw::Isotropic { young: 5e3, poisson: 0.3 });
    assert_eq!(case.output_directory(), "runs/über x");
    assert_eq!(case.place("solver.theta").unwrap().to_string(), "--set solver.theta=0.35");
    assert_eq!(case.place("solver.coarse").unwrap().to_string(), "paper.toml:57:18");
    assert!(case.warnings()[0].message.contains("ignores `imposed`, `theta`"), "{:?}", case.warnings());
    // In a file without the tables they are made.
    let case = Case::parse(&minimal(""), "c", &[set("solver.stop.tolerance", "1e-6")]).unwrap();
    assert_eq!(case.solver.stop.tolerance, 1e-6);
}

#[test]
fn the_settings_make_a_case_file_again() {
    let case = parse(crate::template::PAPER);
    let mut settings = case.settings_json();
    settings.as_object_mut().unwrap().remove("limits");
    let text = toml::to_string(&settings).unwrap();
    assert_eq!(parse(&text).settings_json(), case.settings_json());
}

#[test]
fn the_hash_names_the_case_and_not_its_text() {
    let hash = |overrides: &[(String, String)]| {
        Case::parse(crate::template::PAPER, "paper.toml", overrides).unwrap().hash()
    };
    let paper = hash(&[]);
    assert_eq!(paper.len(), 64);
    assert_eq!(hash(&[set("output.directory", "elsewhere")]), paper);
    assert_eq!(
        hash(&[set("output.vtu", "false"), set("limits.time", "10min"), set("title", "again")]),
        paper
    );
    assert_eq!(hash(&[set("solver.theta", "4e-1")]), paper);
    assert_eq!(hash(&[set("solver.lambda", "-0.0")]), paper);
    assert_ne!(hash(&[set("solver.theta", "0.41")]), paper);
    assert_ne!(hash(&[set("contact.gap", "1e-9")]), paper);
    let text: String =
        crate::template::PAPER.lines().map(|l| format!("{}\n", l.split('#').next().unwrap())).collect();
    assert_eq!(parse(&text).hash(), paper);
}

#[test]
fn doubtful_settings_are_warned_of() {
    let overrides = [set("materials.m.poisson", "0.499"), set("materials.spare", "{young=1,poisson=0}")];
    let case = Case::parse(&minimal(""), "c", &overrides).unwrap();
    let messages: Vec<String> = case.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(messages.len(), 2, "{messages:?}");
    assert!(
        messages[0].starts_with("--set materials.m.poisson=0.499: Poisson's ratio 0.499"),
        "{messages:?}"
    );
    assert!(messages[1].contains("no body uses the material \"spare\""), "{messages:?}");
}

#[test]
fn an_adaptive_run_with_another_criterion_is_warned_of() {
    let adaptive = |stop: &str| {
        let text = minimal(&format!("[adapt]\ntarget_relative_error = 0.02\n{stop}"));
        Case::parse(&text, "c", &[]).unwrap().warnings()
    };
    assert!(adaptive("").is_empty());
    let warnings = adaptive("[solver.stop]\ncriterion = 'precision'");
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].to_string().starts_with("c:18:13: an adaptive run with the criterion"),
        "{}",
        warnings[0]
    );
}

#[test]
fn every_template_is_a_valid_case() {
    let meshes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/meshes");
    fn is_valid<S: Dimension>(mut case: Case<S>, name: &str, meshes: &std::path::Path) {
        case.read_mesh_files(meshes).unwrap();
        let problem = case.build().unwrap().0;
        assert_eq!(problem.contacts.len(), case.contacts.len(), "{name}");
        assert_eq!(case.output_directory(), format!("runs/{name}"));
    }
    for (name, text) in crate::template::TEMPLATES {
        match AnyCase::parse(text, &format!("{name}.toml"), &[]).unwrap() {
            AnyCase::Plane(case) => is_valid(*case, name, &meshes),
            AnyCase::Solid(case) => is_valid(*case, name, &meshes),
        }
        assert_eq!(crate::template::find(name), Some(*text));
    }
    assert_eq!(crate::template::find("herz"), None);
}

//! Assemblies from case files: patches driven by forces, obstacles, and the bound against finer meshes.

use case_io::Case;
use certified_contact::{CertifiedSolution, Settings, Silent, solve};
use fem_core::geometry::Vector;
use fem_core::interface::ContactProblem;
use nndd::NewtonSettings;
use tests::distance::{Outcome, outcome};

fn problem(text: &str, set: &[(&str, String)]) -> ContactProblem {
    let set: Vec<_> = set.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    Case::parse(text, "case.toml", &set).unwrap().build().unwrap().0
}

/// The wedge, whose mesh is a file.
fn wedge() -> ContactProblem {
    let mut case = Case::parse(include_str!("../cases/wedge.toml"), "wedge.toml", &[]).unwrap();
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    case.read_mesh_files(&folder).unwrap();
    case.build().unwrap().0
}

fn solved(problem: ContactProblem) -> CertifiedSolution {
    solve(problem, &Settings::default(), &mut Silent).unwrap()
}

/// Asserts that the stress is the same in all bodies, and the bound round-off.
fn assert_uniform(solution: &CertifiedSolution, [xx, yy]: [f64; 2], what: &str) {
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(solution.is_certified(), "{what}: {:?}", estimate.admissibility);
    for fields in &estimate.pair.bodies {
        for s in &fields.stress {
            let off = (s.xx - xx).abs().max((s.yy - yy).abs()).max(s.xy.abs());
            assert!(off <= 1e-10 * xx.hypot(yy), "{what}: {s:?}");
        }
    }
    assert!(estimate.cre.e_cre() <= 1e-9 * estimate.energy_norm(), "{what}: {:e}", estimate.cre.e_cre());
}

/// Blocks of 3 × 1 on top of each other, held sideways at the left and below at the bottom, pressed from above.
fn pile(cells: &[usize], poisson: f64, hypothesis: &str) -> String {
    let mut text = format!(
        "schema = 1\n[model]\nhypothesis = \"{hypothesis}\"\n[materials.m]\nyoung = 1000.0\npoisson = {poisson}\n"
    );
    for (k, n) in cells.iter().enumerate() {
        text += &format!(
            "[[body]]\nname = \"{k}\"\nmaterial = \"m\"\n\
             generator = {{ kind = \"block\", origin = [0.0, {k}.0], size = [3.0, 1.0], cells = [{n}, 4] }}\n\
             [[body.displacement]]\non = \"left\"\nux = 0.0\n"
        );
        if k == 0 {
            text += "[[body.displacement]]\non = \"bottom\"\nuy = 0.0\n";
        }
        if k + 1 == cells.len() {
            text += "[[body.traction]]\non = \"top\"\npressure = 10.0\n";
        }
    }
    for k in 1..cells.len() {
        text +=
            &format!("[[contact]]\nbodies = [\"{}\", \"{k}\"]\nsurfaces = [\"top\", \"bottom\"]\n", k - 1);
    }
    text
}

#[test]
fn blocks_that_only_contact_and_a_force_hold_have_uniform_stress() {
    for cells in [[6, 7], [2, 3], [18, 7], [8, 11]] {
        for poisson in [0.3, 0.4] {
            for hypothesis in ["plane_strain", "plane_stress"] {
                let three = [cells[0], cells[1], cells[0] + 1];
                for cells in [&cells[..], &three[..]] {
                    let text = pile(cells, poisson, hypothesis);
                    let what = format!("{cells:?} {poisson} {hypothesis}");
                    assert_uniform(&solved(problem(&text, &[])), [0.0, -10.0], &what);
                }
            }
        }
    }
}

#[test]
fn a_punch_and_the_base_beside_it_under_one_pressure_have_uniform_stress() {
    let text = include_str!("../cases/punch_force.toml");
    for cells in ["[7, 4]", "[4, 2]"] {
        let solution = solved(problem(text, &[("body.0.generator.cells", cells.to_owned())]));
        assert_uniform(&solution, [0.0, -10.0], cells);
    }
}

#[test]
fn nested_rings_under_pressure_outside_have_the_same_stress_on_every_radius() {
    let ring = |name: &str, radii: &str, more: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"m\"\n\
             generator = {{ kind = \"ring\", radii = {radii}, angles = [0.0, 90.0], cells = [24, 6] }}\n\
             [[body.displacement]]\non = \"start\"\nuy = 0.0\n[[body.displacement]]\non = \"end\"\nux = 0.0\n{more}"
        )
    };
    let text = format!(
        "schema = 1\n[materials.m]\nyoung = 1000.0\npoisson = 0.3\n{}{}[contact]\nsurfaces = [\"outer\", \"inner\"]\n",
        ring("inside", "[1.0, 1.5]", ""),
        ring("outside", "[1.5, 2.0]", "[[body.traction]]\non = \"outer\"\npressure = 5.0\n")
    );
    let solution = solved(problem(&text, &[]));
    assert!(solution.is_certified());
    // The pressure of thick rings (Lamé): p(r) = 5·4/(4 − 1) (1 − 1/r²) at r = 1.5.
    let exact = 5.0 * 4.0 / 3.0 * (1.0 - 1.0 / 2.25);
    let pressure = &solution.estimate.as_ref().unwrap().pair.contacts[0].pressure;
    let mean = pressure.iter().sum::<f64>() / pressure.len() as f64;
    assert!((mean / exact - 1.0).abs() < 0.02, "{mean} {exact}");
}

/// Returns the bound on a mesh, and the distance of its displacements from those on a mesh with four times as many cells
/// in each direction.
fn bound_and_error(coarse: ContactProblem) -> [f64; 2] {
    match outcome(coarse, 2).unwrap() {
        Outcome::Certified { bound, error } => [bound, error],
        other => panic!("{other:?}"),
    }
}

/// A ring whose bore stays rigid, pushed into a groove of two planes.
const LUG: &str = "schema = 1
[materials.m]
young = 1000.0
poisson = 0.3
[[body]]
name = \"lug\"
material = \"m\"
generator = { kind = \"ring\", radii = [0.5, 1.0], cells = [48, 6] }
[[body.rigid]]
on = \"inner\"
force = [1.0, -20.0]
[[contact]]
bodies = [\"lug\"]
surfaces = [\"outer\"]
obstacle = { kind = \"plane\", point = [-0.5, -0.8660254037844386], normal = [0.5, 0.8660254037844386] }
[[contact]]
bodies = [\"lug\"]
surfaces = [\"outer\"]
obstacle = { kind = \"plane\", point = [0.5, -0.8660254037844386], normal = [-0.5, 0.8660254037844386] }
";

/// Two blocks, of which the lower one is clamped at the right end of the contact.
const CLAMPED_IN_ONE: &str = "schema = 1
[materials.m]
young = 1000.0
poisson = 0.3
[[body]]
name = \"upper\"
material = \"m\"
generator = { kind = \"block\", origin = [0.0, 1.0], size = [2.0, 1.0], cells = [18, 9] }
[[body.displacement]]
on = \"left\"
ux = 0.0
[[body.displacement]]
on = \"top\"
uy = -0.002
[[body]]
name = \"lower\"
material = \"m\"
generator = { kind = \"block\", size = [2.0, 1.0], cells = [18, 9] }
[[body.displacement]]
on = \"right\"
fixed = true
[contact]
surfaces = [\"bottom\", \"top\"]
";

/// A block that is clamped on its left and lies on a rigid plane, from its clamped corner on.
const CLAMPED_ON_OBSTACLE: &str = "schema = 1
[materials.m]
young = 1000.0
poisson = 0.3
[[body]]
name = \"block\"
material = \"m\"
generator = { kind = \"block\", size = [2.0, 1.0], cells = [18, 9] }
[[body.displacement]]
on = \"left\"
ux = 0.0
uy = 0.0
[[body.traction]]
on = \"top\"
pressure = 3.0
[[contact]]
bodies = [\"block\"]
surfaces = [\"bottom\"]
obstacle = { kind = \"plane\", point = [0.0, 0.0], normal = [0.0, 1.0] }
motion = [0.0, 0.0]
";

#[test]
fn a_clamped_node_on_an_obstacle_is_checked_on_its_data() {
    let set = |up: f64| [("contact.0.motion", format!("[0.0, {up:?}]"))];
    for (up, opening) in [(0.0, 0.0), (-0.001, 0.001)] {
        let problem = problem(CLAMPED_ON_OBSTACLE, &set(up));
        let interface = &problem.contacts[0].interface;
        assert_eq!((interface.pairs().len(), interface.facets().len()), (18, 18));
        let clamped: Vec<_> = interface.facets().iter().flat_map(|edge| edge.clamped).flatten().collect();
        assert!(clamped.len() == 1 && (clamped[0].opening - opening).abs() < 1e-15, "{clamped:?}");
        let [bound, error] = bound_and_error(problem);
        assert!(bound >= error, "{up}: {bound} {error}");
    }
    // Raised, the obstacle would have to pass through the clamped corner.
    let set: Vec<_> = set(0.001).into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    let refused = Case::parse(CLAMPED_ON_OBSTACLE, "case.toml", &set).unwrap().build();
    let said = format!("{}", refused.unwrap_err());
    assert!(said.contains("is clamped at (0, 0)") && said.contains("1.000e-3"), "{said}");
    // Only a held obstacle leaves the opening known.
    let free = CLAMPED_ON_OBSTACLE.replace(
        "[0.0, 1.0] }\nmotion = [0.0, 0.0]",
        "[0.0, 1.0], ux = 0.0, rotation = 0.0, force = [0.0, 5.0] }",
    );
    let refused = Case::parse(&free, "case.toml", &[]).unwrap().build();
    let said = format!("{}", refused.unwrap_err());
    assert!(said.contains("in two directions"), "{said}");
}

#[test]
fn a_rigid_side_moves_as_one_under_its_resultants() {
    let solution = solved(problem(include_str!("../cases/plate.toml"), &[]));
    assert!(solution.is_certified());
    let side = &solution.results.as_ref().unwrap().rigid_sides[0];
    let [x, y] = side.force.into();
    // ux is imposed, and the contact takes no force along x.
    assert!(x.abs() < 1e-10 && (y + 20.0).abs() < 1e-10 && side.moment.abs() < 1e-10, "{side:?}");
    // The motion as imposed values gives the same forces.
    let motion = [("ux", 0.0), ("uy", side.motion.translation[1]), ("rotation", side.motion.spin)];
    let text = include_str!("../cases/plate.toml").replace("ux    = 0.0\nforce = [0.0, -20.0]\n", "");
    let imposed: String = motion.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
    let text = text.replace("about = [1.1, 2.0]\n", &format!("{imposed}about = [1.1, 2.0]\n"));
    let exact = Settings::default().with_method(NewtonSettings::default());
    let other = solve(problem(&text, &[]), &exact, &mut Silent).unwrap();
    let found = &other.results.as_ref().unwrap().rigid_sides[0];
    assert!((found.force - side.force).norm() < 1e-9 && found.moment.abs() < 1e-9, "{found:?}");
    // A load on a body that floats with its plate.
    let lug = solved(problem(LUG, &[]));
    let results = lug.results.as_ref().unwrap();
    assert!((results.rigid_sides[0].force - Vector::new(1.0, -20.0)).norm() < 1e-10, "{results:?}");
    assert!(results.balance[0].force.norm() < 1e-9 && results.balance[0].moment.abs() < 1e-9);
}

#[test]
fn the_traction_on_a_rigid_side_keeps_its_resultants_under_relaxation() {
    for steps in [0, 2, 40] {
        let settings = relaxed(steps);
        let text = include_str!("../cases/plate.toml");
        let solution = solve(problem(text, &[]), &settings, &mut Silent).unwrap();
        let estimate = solution.estimate.as_ref().unwrap();
        assert!(estimate.admissibility.rigid_balance < 1e-12, "{steps}: {:?}", estimate.admissibility);
    }
}

#[test]
fn a_clamped_end_takes_the_pressure_of_its_neighbour() {
    let settings = relaxed(60);
    let text = include_str!("../cases/four_cycle.toml");
    let solution = solve(problem(text, &[]), &settings, &mut Silent).unwrap();
    let found = solution.estimate.as_ref().unwrap().unchecked().e_cre;
    // The best bound of the space, and what remains of it in the contact law.
    assert!((0.0776329118970..0.077635).contains(&found), "{found}");
    let contact = solution.estimate.as_ref().unwrap().unchecked().parts.contact;
    assert!((contact - 0.00474445382).abs() < 1e-10, "{contact}");
}

fn relaxed(steps: usize) -> Settings {
    let mut settings = Settings::default();
    settings.relaxation = certified_contact::cre_estimator::Relaxation::Steps(steps);
    settings
}

fn adapted(text: &str, target: f64) -> certified_contact::AdaptiveSolution {
    let adapt = certified_contact::AdaptSettings::new(target);
    certified_contact::solve_adaptively(problem(text, &[]), &Settings::default(), &adapt, &mut Silent)
        .unwrap()
}

#[test]
fn a_roller_between_plates_is_refined_where_it_touches() {
    let answer = adapted(include_str!("../cases/roller.toml"), 0.06);
    assert!(matches!(answer.end, certified_contact::AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert!(answer.history.last().unwrap().nodes < 40_000, "{:?}", answer.history);
}

#[test]
fn a_mesh_without_a_pressure_in_balance_is_refined() {
    // The resultant acts 0.02 from the end of the contact; within h/3 no linear pressure has it.
    let block = |name: &str, y: f64, more: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"m\"\ngenerator = {{ kind = \"block\", origin = [0.0, {y:.1}], \
             size = [1.0, 1.0], cells = [10, 10] }}\n{more}"
        )
    };
    let load =
        "[[body.traction]]\non = \"top\"\npart = { x = [0.9, 1.0] }\nvector = [0.0, \"-4000*(x-0.9)^3\"]\n";
    let text = format!(
        "schema = 1\n[materials.m]\nyoung = 1000.0\npoisson = 0.3\n{}{}[contact]\nsurfaces = [\"bottom\", \"top\"]\n",
        block("block", 1.0, load),
        block("base", 0.0, "[[body.displacement]]\non = \"bottom\"\nfixed = true\n"),
    );
    let answer = adapted(&text, 0.2);
    assert!(matches!(answer.end, certified_contact::AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert!(!answer.history[0].certified && answer.step > 1, "{:?}", answer.history);
}

#[test]
fn a_bearing_is_refined_though_its_normals_leave_rollers_out_of_balance() {
    // On the second mesh pressures in balance differ from the discrete forces by 0.15 of the mesh error.
    let found = adapted(include_str!("../cases/bearing.toml"), 0.1);
    assert!(matches!(found.end, certified_contact::AdaptiveEnd::TargetMet), "{:?}", found.end);
    assert!(
        found.solution.is_certified() && found.solution.relative().is_some_and(|relative| relative <= 0.1)
    );
}

#[test]
fn the_bound_is_above_the_distance_from_a_finer_solution() {
    let regular = [
        ("stack", include_str!("../cases/stack.toml"), 1.35),
        ("three_cycle", include_str!("../cases/three_cycle.toml"), 1.35),
        ("four_cycle", include_str!("../cases/four_cycle.toml"), 1.35),
        ("table", include_str!("../cases/table.toml"), 2.0),
        ("press", include_str!("../cases/press.toml"), 2.0),
        ("roller", include_str!("../cases/roller.toml"), 4.0),
        ("pin", include_str!("../cases/pin.toml"), 2.0),
        ("plate", include_str!("../cases/plate.toml"), 1.35),
        ("lug", LUG, 4.0),
        ("node clamped in one body", CLAMPED_IN_ONE, 1.5),
        ("node clamped on an obstacle", CLAMPED_ON_OBSTACLE, 1.5),
    ];
    let regular = regular.map(|(name, text, most)| (name, problem(text, &[]), most));
    for (name, problem, most) in regular.into_iter().chain([("wedge", wedge(), 1.35)]) {
        let [bound, error] = bound_and_error(problem);
        println!("{name}: bound {bound:.4e}, error {error:.4e}, effectivity {:.3}", bound / error);
        assert!(bound >= error, "{name}: {bound} {error}");
        assert!(bound <= most * error, "{name}: {bound} {error}");
    }
}

#[test]
fn a_wedge_presses_on_both_sides_as_equilibrium_says() {
    // The force 24 on the top is the vertical part of what the slope carries, on a line along (0.6, 2).
    let solution = solved(wedge());
    assert!(solution.is_certified());
    let contacts = &solution.results.as_ref().unwrap().contacts;
    let exact = [24.0 * 2.0 / 0.6, 24.0 * f64::hypot(0.6, 2.0) / 0.6];
    for (found, exact) in contacts.iter().zip(exact) {
        assert!((found.contact_force - exact).abs() < 1e-9 * exact, "{} {exact}", found.contact_force);
    }
    let sum = contacts[0].resultant + contacts[1].resultant;
    assert!((sum - Vector::new(0.0, 24.0)).norm() < 1e-9 * 24.0, "{sum:?}");
}

#[test]
fn one_body_alone_is_certified() {
    let text = "schema = 1\ncontact = []\n[materials.m]\nyoung = 1000.0\npoisson = 0.3\n[[body]]\nname = \"beam\"\n\
                material = \"m\"\ngenerator = { kind = \"block\", size = [4.0, 1.0], cells = [16, 4] }\n\
                [[body.displacement]]\non = \"left\"\nfixed = true\n[[body.traction]]\non = \"right\"\nvector = [0.0, 1.0]\n";
    let [bound, error] = bound_and_error(problem(text, &[]));
    assert!(bound >= error && bound <= 1.5 * error, "{bound} {error}");
}

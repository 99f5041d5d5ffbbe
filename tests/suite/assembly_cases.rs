//! Assemblies from case files: patches driven by forces, obstacles, and the bound against finer meshes.

use case_io::Case;
use certified_contact::{CertifiedSolution, Settings, Silent, solve};
use fem_core::geometry::Vector;
use fem_core::interface::ContactProblem;
use fem_core::mesh::refine::RefinementEdges;
use fem_core::norm::energy_norm_squared;

fn problem(text: &str, set: &[(&str, String)]) -> ContactProblem {
    let set: Vec<_> = set.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    Case::parse(text, "case.toml", &set).unwrap().build_problem().unwrap()
}

/// The wedge, whose mesh is a file.
fn wedge() -> ContactProblem {
    let mut case = Case::parse(include_str!("../cases/wedge.toml"), "wedge.toml", &[]).unwrap();
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    case.read_mesh_files(&folder).unwrap();
    case.build_problem().unwrap()
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

/// Refines all cells, and takes displacements of the nodes with them.
fn finer(problem: &ContactProblem, u: &[Vec<Vector>]) -> (ContactProblem, Vec<Vec<Vector>>) {
    let edges: Vec<RefinementEdges> =
        problem.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect();
    let marked: Vec<Vec<bool>> =
        problem.bodies.iter().map(|body| vec![true; body.mesh().topology().edges().len()]).collect();
    let found = problem.refined(&edges, &marked).unwrap();
    let u = found.refinements.iter().zip(u).map(|(refinement, u)| refinement.prolong(u)).collect();
    (found.problem, u)
}

/// Returns the bound on a mesh, and the distance of its displacements from those on a mesh with four times as many cells
/// in each direction.
fn bound_and_error(coarse: ContactProblem) -> [f64; 2] {
    let solution = solved(coarse.clone());
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(solution.is_certified(), "{:?}", estimate.admissibility);
    let mut u: Vec<Vec<Vector>> = estimate.pair.bodies.iter().map(|body| body.displacement.clone()).collect();
    let mut problem = coarse;
    for _ in 0..2 {
        (problem, u) = finer(&problem, &u);
    }
    let fine = solved(problem);
    let fields = &fine.estimate.as_ref().unwrap().pair.bodies;
    let squared = fine.problem.bodies.iter().zip(fields).zip(&u).map(|((body, fields), u)| {
        let difference: Vec<Vector> = fields.displacement.iter().zip(u).map(|(a, b)| a - b).collect();
        energy_norm_squared(body, &difference)
    });
    [estimate.unchecked().e_cre, squared.sum::<f64>().sqrt()]
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

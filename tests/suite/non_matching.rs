//! Bodies whose surfaces do not match: the patch stays exact, the bound a bound, and the answer the same.

use case_io::Case;
use certified_contact::{AdaptSettings, AdaptiveEnd, Settings, Silent, solve_adaptively};
use cre_estimator::{Estimate, Relaxation, estimate_with};
use fem_core::body::Body;
use fem_core::geometry::Vector;
use fem_core::interface::ContactState;
use fem_core::material::Hypothesis;
use fem_core::mesh::TriMesh;
use fem_core::norm::{energy_error_squared, energy_norm_squared};
use fem_core::prepared::PreparedProblem;
use nndd::NnddSettings;
use tests::random::Random;
use tests::run::{newton, refined_in_common};
use tests::shapes::{moved, turned};
use tests::{certify, displacements, iterates, patch, prepare, signorini};

type Materials = [(f64, f64); 2];

const EQUAL: Materials = [(1.0, 0.3), (1.0, 0.3)];
const CONTRAST: Materials = [(1.0, 0.2), (20.0, 0.4)];

#[test]
fn the_patch_is_exact_for_any_ratio_and_angle() {
    let materials = [(2000.0, 0.3), (1000.0, 0.2)];
    for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
        for [m, n] in [[2, 3], [6, 7], [17, 40], [40, 17], [3, 100]] {
            for angle in [0.0, 0.3, -2.0] {
                let case = format!("{hypothesis:?} {m}:{n} at {angle}");
                let bodies = patch::bodies(materials, hypothesis, angle, [[m, 3], [n, 5]]).unwrap();
                let (problem, changes) = refined_in_common(bodies).unwrap();
                assert!(changes.is_some_and(|c| c.free == [0.0; 2]), "{case}: {changes:?}");
                let prepared = prepare(&problem);
                let (solution, _) = iterates(&prepared, &NnddSettings::default(), 1e-12).unwrap();
                let estimate = certify(&prepared, &solution.last).unwrap();
                let norm = crate::patch::assert_exact(&estimate, materials, hypothesis, &case);
                println!("patch {case}: e_CRE/norm {:.1e}", estimate.cre.e_cre() / norm);
            }
        }
    }
}

/// The exact error and the bound, relaxed by `steps`, of one iterate.
fn measure(
    prepared: &PreparedProblem,
    materials: Materials,
    iterate: &nndd::Iterate,
    steps: usize,
) -> [f64; 2] {
    let problem = prepared.problem();
    let u = displacements(prepared, iterate);
    let state = ContactState::between([&u[0], &u[1]], &iterate.contact.normal_reaction, &iterate.opening);
    let e: Estimate = estimate_with(prepared, &state, Relaxation::Steps(steps)).unwrap();
    assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
    assert!(e.cre.split_defect() < 1e-12, "{:e}", e.cre.split_defect());
    let exact = signorini::exact(materials, 0.0);
    let field = |b: usize| &e.pair.bodies[b].displacement;
    let error = |b: usize| energy_error_squared(&problem.bodies[b], field(b), |x| exact[b].stress(x));
    [(error(0) + error(1)).sqrt(), e.unchecked().e_cre]
}

/// Asserts the bound at every iteration and returns the effectivity of the discrete solution.
fn effectivity(materials: Materials, bodies: [Body; 2], steps: usize) -> f64 {
    let (problem, changes) = refined_in_common(bodies).unwrap();
    let prepared = prepare(&problem);
    let (_, all) = iterates(&prepared, &NnddSettings::default(), 1e-9).unwrap();
    for iterate in &all {
        let [error, bound] = measure(&prepared, materials, iterate, steps);
        assert!(bound >= error, "{changes:?}: {bound} < {error}");
    }
    let [error, bound] = measure(&prepared, materials, &newton(&prepared).unwrap(), steps);
    assert!(bound >= error, "{changes:?}: {bound} < {error}");
    bound / error
}

fn same(x: Vector) -> Vector {
    x
}

#[test]
fn the_bound_stays_sharp_on_meshes_that_do_not_match() {
    for materials in [EQUAL, CONTRAST] {
        for cells in [[[16, 8], [23, 11]], [[8, 4], [31, 15]], [[23, 11], [16, 8]]] {
            let bodies = signorini::bodies(materials, 0.0, cells, same).unwrap();
            let e = effectivity(materials, bodies, 2);
            println!("Signorini {materials:?} {cells:?}: effectivity {e:.4}");
            assert!(e <= 1.1, "{materials:?} {cells:?}: {e}");
        }
    }
}

#[test]
fn nodes_a_little_apart_do_no_harm() {
    // 32 cells against 16: every other inner node is beside one of the other side, by a fraction of the smaller edge.
    let bodies = |offset: f64| {
        let shift =
            move |x: Vector| if x[0].abs() < 0.999 { Vector::new(x[0] + offset / 16.0, x[1]) } else { x };
        signorini::bodies(CONTRAST, 0.0, [[16, 8], [32, 16]], shift).unwrap()
    };
    let aligned = effectivity(CONTRAST, bodies(0.0), 2);
    for offset in [1e-12, 1e-9, 1e-6, 1e-3, 0.01, 0.05, 0.19] {
        let (_, changes) = refined_in_common(bodies(offset)).unwrap();
        let snapped = if offset < 1e-9 { 0 } else { 15 };
        assert!(
            changes.is_some_and(|c| c.snapped == [snapped, 0] || offset == 1e-9),
            "{offset}: {changes:?}"
        );
        let e = effectivity(CONTRAST, bodies(offset), 2);
        assert!((e - aligned).abs() < 0.02, "{offset}: {e} against {aligned}");
    }
    // Farther apart they are inserted, and thin fans are bisected.
    for offset in [0.21, 0.3, 0.5] {
        let e = effectivity(CONTRAST, bodies(offset), 2);
        assert!(e <= 1.1, "{offset}: {e}");
    }
}

#[test]
fn energies_of_matching_and_other_meshes_tend_to_each_other() {
    let energy = |cells: [[usize; 2]; 2]| -> f64 {
        let (problem, _) = refined_in_common(signorini::bodies(CONTRAST, 0.0, cells, same).unwrap()).unwrap();
        let prepared = prepare(&problem);
        let u = displacements(&prepared, &newton(&prepared).unwrap());
        (0..2).map(|b| energy_norm_squared(&problem.bodies[b], &u[b])).sum()
    };
    let distance = |n: usize| {
        let matching = energy([[2 * n, n]; 2]);
        (energy([[2 * n, n], [3 * n - 1, n]]) / matching - 1.0).abs()
    };
    let d = [8, 16, 32].map(distance);
    println!("energies of matching and other meshes differ by {d:?}");
    assert!(d[1] < 0.5 * d[0] && d[2] < 0.5 * d[1] && d[2] < 1e-2, "{d:?}");
}

/// A block whose columns are at random places, turned by an angle.
fn random_block(random: &mut Random, y: f64, columns: usize, rows: usize, angle: f64) -> TriMesh {
    // Neighbouring columns differ by up to a factor of 20.
    let widths: Vec<f64> = (0..columns).map(|_| 0.05 + 0.95 * random.unit()).collect();
    let total: f64 = widths.iter().sum();
    let mut places = vec![0.0];
    for w in &widths {
        places.push(places[places.len() - 1] + 2.0 * w / total);
    }
    places[columns] = 2.0;
    let mesh = fem_core::mesh::generate::block([0.0, y], [2.0, 1.0], [columns, rows]).unwrap();
    let column = |x: f64| (x * columns as f64 / 2.0).round() as usize;
    turned(&moved(&mesh, |x| Vector::new(places[column(x[0])], x[1])).unwrap(), angle).unwrap()
}

#[test]
fn any_two_random_meshes_have_a_sound_common_refinement() {
    let mut random = Random::new(5);
    let material = fem_core::material::LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let shortest = |body: &Body, group: &str| {
        let mesh = body.mesh();
        mesh.group(group).unwrap().iter().map(|&e| mesh.facet_measure(e)).fold(f64::INFINITY, f64::min)
    };
    for trial in 0..300 {
        let mut count = || 1 + (random.unit() * 24.0) as usize;
        let [m, n, j, k] = [count(), count(), count(), count()];
        let angle = if trial % 3 == 0 { 0.0 } else { 6.0 * random.unit() };
        let meshes =
            [random_block(&mut random, 1.0, m, j, angle), random_block(&mut random, 0.0, n, k, angle)];
        let conditions = fem_core::boundary::BoundaryConditions::new();
        let bodies = meshes.map(|mesh| Body::new(mesh, material.clone(), &conditions).unwrap());
        let shortest_before = shortest(&bodies[0], "bottom").min(shortest(&bodies[1], "top"));
        // Pairing asks for the same number of nodes, each less than 5 % of an edge from its partner.
        let (problem, changes) = refined_in_common(bodies).unwrap();
        let case = format!("{trial}: {m} {n} at {angle}: {changes:?}");
        for (b, group) in [(0, "bottom"), (1, "top")] {
            let mesh = problem.bodies[b].mesh();
            let area: f64 = (0..mesh.cells().len()).map(|t| mesh.measure(t)).sum();
            assert!((area - 2.0).abs() < 1e-12, "{case}: area {area}");
            // A disc whose boundary is one line: no crack, no hole.
            let euler = mesh.points().len() + mesh.cells().len() - mesh.topology().facets().len();
            assert_eq!(euler, 1, "{case}");
            assert_eq!(
                mesh.group(group).unwrap().len() + 1,
                problem.contacts[0].interface.pairs().len(),
                "{case}"
            );
            // Two neighbours may each have moved by 0.2, and no others are closer than that.
            assert!(shortest(&problem.bodies[b], group) > 0.1 * shortest_before, "{case}");
        }
        for pair in problem.contacts[0].interface.pairs() {
            let [p, q] = [0, 1].map(|b| problem.bodies[b].mesh().points()[pair.nodes[b]]);
            assert!((p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9 * shortest_before, "{case}: {p:?} {q:?}");
        }
        assert!((problem.contacts[0].interface.measure() - 2.0).abs() < 1e-12, "{case}");
    }
}

#[test]
fn an_adaptive_run_starts_from_meshes_that_do_not_match() {
    let coarse = [("body.0.generator.cells", "[7, 4]"), ("body.1.generator.cells", "[11, 5]")];
    let overrides: Vec<(String, String)> = coarse.map(|(k, v)| (k.into(), v.into())).into();
    let case = Case::parse(case_io::template::PAPER, "paper.toml", &overrides).unwrap();
    let (problem, notes) = case.build().unwrap();
    assert!(notes[0].contains("refined in common"), "{notes:?}");
    let answer =
        solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(0.05), &mut Silent).unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert!(answer.history.iter().all(|s| s.certified));
    assert!(answer.history.len() > 2 && answer.history.last().unwrap().nodes < 3500, "{:?}", answer.history);
}

//! Contact of solids of tetrahedra on flat matching surfaces.
//!
//! The figures are those of an independent code (Python, with another solver), which a second one reproduced.

use certified_contact::estimate;
use cre_estimator::{Estimate, Relaxation};
use fem_core::assembly::external_forces;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::field::stresses;
use fem_core::interface::{ContactInterface, ContactProblem, Gap, Obstacle, RigidLine};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::norm::energy_norm_squared;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nalgebra::{Matrix3, Rotation3, Vector3};
use nndd::stopping::EtaNndd;
use nndd::{Method, NewtonSettings, NnddSettings, NnddSolution, NnddStatus, solve};
use tests::solids::{Hertz, circle, half_open};

type Conditions = BoundaryConditions<Solid>;

/// The numbers of a solution.
struct Found {
    /// `½ a(u, u) − f·u`, J.
    energy: f64,
    /// `a(u, u)` of each body, J.
    bodies: Vec<f64>,
    /// The sum of the contact forces, N.
    force: f64,
    /// Pairs of nodes with a force.
    closed: usize,
}

fn found(prepared: &PreparedProblem<Solid>, solution: &NnddSolution) -> Found {
    let fields = prepared.displacements(&solution.last.fields(&prepared.system()));
    let bodies = &prepared.problem().bodies;
    let energies: Vec<f64> =
        bodies.iter().zip(&fields).map(|(body, u)| energy_norm_squared(body, u)).collect();
    let work = |(body, u): (&Body<Solid>, &Vec<Vector3<f64>>)| -> f64 {
        external_forces(body).iter().zip(u).map(|(f, u)| f.dot(u)).sum()
    };
    let work: f64 = bodies.iter().zip(&fields).map(work).sum();
    let force = &solution.last.contact.normal_reaction;
    Found {
        energy: 0.5 * energies.iter().sum::<f64>() - work,
        bodies: energies,
        force: force.iter().sum(),
        closed: force.iter().filter(|force| **force > 0.0).count(),
    }
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found:.13} is not {expected}");
}

#[test]
fn half_open_blocks_have_the_forces_of_another_code() {
    let known = [
        (2, 15, 12, 13.311_005_296_1, 0.193_219_090_71),
        (4, 45, 30, 11.792_162_388_6, 0.162_120_223_154),
        (8, 153, 90, 11.035_494_692_9, 0.144_298_330_688),
    ];
    for (n, pairs, closed, force, energy) in known {
        let prepared = PreparedProblem::new(half_open(n).unwrap()).unwrap();
        let solution = exact(&prepared);
        let found = found(&prepared, &solution);
        assert_eq!((prepared.node_pairs(), found.closed), (pairs, closed));
        assert_near(found.force, force, 1e-11);
        assert_near(found.energy, energy, 1e-10);
        if n == 2 {
            assert_near(found.bodies[0], 0.224_504_065_268, 1e-11);
            assert_near(found.bodies[1], 0.121_497_965_157, 1e-11);
        }
        // The opening is the gap less the difference of the fields.
        let fields = prepared.displacements(&solution.last.fields(&prepared.system()));
        let interface = &prepared.problem().contacts[0].interface;
        for (pair, opening) in interface.pairs().iter().zip(&solution.last.opening) {
            let [u, v] = [0, 1].map(|b: usize| fields[b][pair.nodes[b].index()]);
            assert!((pair.gap - (u - v).dot(&pair.normal) - opening).abs() < 1e-15);
        }
    }
}

#[test]
fn the_iteration_of_half_open_blocks_has_the_history_of_another_code() {
    let mut settings = NnddSettings::paper(0.4);
    settings.max_iterations = 100;
    for (n, iterations) in [(2, 58), (4, 65), (8, 72)] {
        let prepared = PreparedProblem::new(half_open(n).unwrap()).unwrap();
        let start = vec![0.0; prepared.rows()];
        let mut stop = EtaNndd::new(1e-10);
        let solution = solve(&prepared.system(), start, settings.clone(), &mut stop).unwrap();
        assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
        let history: Vec<f64> = solution.history.iter().map(|row| row.eta_nndd).collect();
        assert_eq!(history.len(), iterations);
        if n == 4 {
            for (found, known) in history.iter().zip([0.671308, 0.168909, 0.0828234, 0.0560132]) {
                assert_near(*found, known, 1e-5);
            }
        }
    }
}

#[test]
fn a_circular_contact_zone_has_the_force_of_another_code() {
    // Derivatives of the field: the traction on x = 1 is the one of Hooke's law.
    let field = Hertz { modulus: 1.0, nu: 0.3 };
    let (x, step) = (Vector3::new(1.0, 0.3, 0.4), 1e-5);
    let along = |k: usize| {
        let d = Vector3::ith(k, step);
        (field.displacement(x + d) - field.displacement(x - d)) / (2.0 * step)
    };
    let gradient = [0, 1, 2].map(along);
    let divergence: f64 = (0..3).map(|k| gradient[k][k]).sum();
    let shear = field.modulus / (2.0 * (1.0 + field.nu));
    let lambda = 2.0 * shear * field.nu / (1.0 - 2.0 * field.nu);
    let hooke = Vector3::from_fn(|k, _| {
        let volume = if k == 0 { lambda * divergence } else { 0.0 };
        volume + shear * (gradient[0][k] + gradient[k][0])
    });
    assert!((field.traction(0, x) - hooke).norm() < 1e-9, "{hooke} {}", field.traction(0, x));
    for (n, closed, force) in
        [(3, 4, 0.021_362_717_833_6), (6, 15, 0.019_576_732_261_9), (12, 50, 0.019_029_604_701_3)]
    {
        let prepared = PreparedProblem::new(circle(n).unwrap()).unwrap();
        let solution = exact(&prepared);
        let found = found(&prepared, &solution);
        assert_eq!((prepared.node_pairs(), found.closed), ((n + 1) * (n + 1), closed));
        // The loads are integrated by another rule.
        assert_near(found.force, force, 1e-6);
    }
}

#[test]
fn floating_boxes_stacked_along_any_axis_carry_a_uniform_stress() {
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.1);
    let turned = |mesh: &TetMesh| {
        let facets = |ids: &[_]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
        let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
        Mesh::new(mesh.points().iter().map(|x| turn * x).collect(), mesh.cells().to_vec(), groups).unwrap()
    };
    let body = |z: f64, modulus: f64, conditions: Conditions| {
        let mesh = turned(&cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap());
        Body::new(mesh, LinearElastic::isotropic_solid(modulus, 0.3).unwrap(), &conditions).unwrap()
    };
    // Contact alone holds the upper two; nothing but the absence of a load keeps them from sliding and spinning.
    let bodies = vec![
        body(0.0, 10.0, Conditions::default().roller("bottom", 0.0).roller("left", 0.0).roller("front", 0.0)),
        body(1.0, 25.0, Conditions::default()),
        body(2.0, 4.0, Conditions::default().pressure("top", 0.7)),
    ];
    let interface = |upper: usize| {
        let sides = ["bottom", "top"];
        ContactInterface::pair_flat(&bodies[upper], &bodies[upper - 1], sides, &Gap::Touching).unwrap()
    };
    let pairs = [interface(1), interface(2)];
    let [low, high] = pairs;
    let problem = ContactProblem::new(bodies).contact([1, 0], low).contact([2, 1], high);
    let prepared = PreparedProblem::new(problem).unwrap();
    assert_eq!(prepared.rigid_motions().len(), 12);
    let axis = turn * Vector3::z();
    let expected = -0.7 * axis * axis.transpose();
    for method in [Method::from(NewtonSettings::default()), NnddSettings::default().into()] {
        let start = vec![0.0; prepared.rows()];
        let solution = solve(&prepared.system(), start, method, &mut EtaNndd::new(1e-13)).unwrap();
        let fields = prepared.displacements(&solution.last.fields(&prepared.system()));
        for (body, u) in prepared.problem().bodies.iter().zip(&fields) {
            for s in stresses(body, u) {
                let stress = Matrix3::new(s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz);
                assert!((stress - expected).norm() < 1e-10, "{stress}");
            }
        }
        let force: f64 = solution.last.contact.normal_reaction.iter().sum();
        assert!((force - 2.0 * 1.4).abs() < 1e-11, "{force}");
    }
}

#[test]
fn a_stamp_that_may_tilt_presses_a_box_onto_a_fixed_plane() {
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap();
    let conditions = Conditions::default().roller("left", 0.0).roller("front", 0.0);
    let body = Body::new(mesh, LinearElastic::isotropic_solid(20.0, 0.3).unwrap(), &conditions).unwrap();
    let plane = |z: f64, up: f64| {
        let (point, normal) = (Vector3::new(5.0, 3.0, z), Vector3::new(0.0, 0.0, up));
        Obstacle::<Solid>::fixed(RigidLine::Plane { point, normal })
    };
    let motion = [Some(0.0), Some(0.0), None, None, None, Some(0.0)];
    let pressed = |force: f64, arm: f64| {
        let load = (Vector3::new(0.0, 0.0, -force), Vector3::zeros());
        let (below, above) = (plane(0.0, 1.0), plane(1.25, -1.0).stamp(motion, load, [1.0, 0.5 + arm, 1.25]));
        let low = ContactInterface::against_obstacle(&body, "bottom", &below, None).unwrap();
        let high = ContactInterface::against_obstacle(&body, "top", &above, None).unwrap();
        assert!(low.pairs().iter().all(|pair| pair.gap == 0.0));
        assert!(high.pairs().iter().all(|pair| pair.gap == 0.25));
        let problem =
            ContactProblem::new(vec![body.clone()]).obstacle(0, low, below).obstacle(0, high, above);
        let prepared = PreparedProblem::new(problem).unwrap();
        // The box is free along z; the stamp moves and tilts.
        assert_eq!(prepared.rigid_motions().len(), 1 + 3);
        let solution = exact(&prepared);
        (prepared.displacements(&solution.last.fields(&prepared.system())), solution)
    };
    let (fields, solution) = pressed(1.4, 0.0);
    for s in stresses(&body, &fields[0]) {
        let others = [s.xx, s.yy, s.xy, s.xz, s.yz].into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!((s.zz + 0.7).abs() < 1e-12 && others < 1e-12, "{s:?}");
    }
    // The stamp closes the gap and compresses the box.
    assert!(fields[2].iter().all(|u| (u - Vector3::new(0.0, 0.0, -0.25 - 0.7 / 20.0)).norm() < 1e-12));
    let half = solution.last.contact.normal_reaction.len() / 2;
    let force: f64 = solution.last.contact.normal_reaction[half..].iter().sum();
    assert!((force - 1.4).abs() < 1e-12, "{force}");
    // Beside the centre it tilts: the forces of the stamp have the moment of its load.
    let (fields, solution) = pressed(1.4, 0.1);
    let mesh = body.mesh();
    let mut top: Vec<_> =
        mesh.group("top").unwrap().iter().flat_map(|f| mesh.topology().facets()[*f]).collect();
    top.sort_unstable();
    top.dedup();
    let forces = &solution.last.contact.normal_reaction[half..];
    let arm: f64 = top.iter().zip(forces).map(|(node, f)| f * mesh.points()[*node][1]).sum::<f64>() / 1.4;
    assert!((arm - 0.6).abs() < 1e-12, "{arm}");
    assert!(fields[2][0][2] - fields[2][top.len() - 1][2] > 1e-3);
}

fn exact(prepared: &PreparedProblem<Solid>) -> NnddSolution {
    let start = vec![0.0; prepared.rows()];
    solve(&prepared.system(), start, NewtonSettings::default(), &mut EtaNndd::new(1e-12)).unwrap()
}

fn certified(prepared: &PreparedProblem<Solid>, solution: &NnddSolution, steps: usize) -> Estimate<Solid> {
    let found = estimate(prepared, &solution.last, Relaxation::Steps(steps)).unwrap();
    assert!(found.certificate().is_some(), "{:?}", found.admissibility);
    assert!(found.cre.split_defect() < 1e-12 && found.round_off < 1e-9 * found.unchecked().e_cre);
    found
}

#[test]
fn errors_of_solids_in_contact_are_those_of_another_code() {
    // The last digit is the printed one.
    for (n, known, digit) in [(2, 2.201_825_61, 5e-9), (4, 1.669_669, 5e-7), (8, 1.201_888, 5e-7)] {
        let prepared = PreparedProblem::new(half_open(n).unwrap()).unwrap();
        let found = certified(&prepared, &exact(&prepared), 0).unchecked().e_cre;
        assert!((found - known).abs() < digit, "{found} {known}");
    }
    // With loads that another rule integrates.
    for (n, known) in [(3, 0.494_544_672), (6, 0.289_234_537)] {
        let prepared = PreparedProblem::new(circle(n).unwrap()).unwrap();
        let solution = exact(&prepared);
        let found = certified(&prepared, &solution, 0);
        assert_near(found.unchecked().e_cre, known, 1e-5);
        if n == 3 {
            let mesh = |b: usize| found.cre.discretisation_by_cell[b].iter().sum::<f64>().sqrt();
            assert_near(mesh(0), 0.406_193_698, 1e-5);
            assert_near(mesh(1), 0.281_501_066, 1e-5);
            let contact = found.cre.contact_squared();
            assert_near(contact, 2.330_776_96e-4, 1e-4);
            assert_near(found.cre.algebraic_squared - contact, 1.051_843_9e-4, 1e-4);
            continue;
        }
        // Over the error of the field, whose quadrature has five digits.
        let distance = 0.046_382_204_7;
        for (steps, effectivity) in [(1, 1.558), (2, 1.251), (3, 1.162), (5, 1.095), (8, 1.067)] {
            let found = certified(&prepared, &solution, steps).unchecked().e_cre / distance;
            assert!(found > 1.0 && (found - effectivity).abs() < 2e-3, "{found} {effectivity}");
        }
    }
}

//! Contact of solids of tetrahedra on flat matching surfaces.
//!
//! The figures are those of an independent code, see `tests/support/formulation.rs`.

use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::field::stresses;
use fem_core::interface::{ContactProblem, Gap, Obstacle, RigidLine};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nalgebra::{Matrix3, Rotation3, Vector3};
use nndd::stopping::EtaNndd;
use nndd::{Method, NewtonSettings, NnddSettings, NnddSolution, solve};
use tests::formulation::{PRINTED, compared};
use tests::solids::{Hertz, OnSphere, half_open, on_each_other};

type Conditions = BoundaryConditions<Solid>;

#[test]
fn figures_are_those_of_another_code() {
    for row in PRINTED.iter().filter(|row| row.2 <= 12) {
        for of in compared(row, None).unwrap() {
            let near = of.reason().is_some_and(|(_, most)| of.difference().abs() <= most);
            assert!(of.agrees() || near, "{of:?}");
        }
    }
}

#[test]
fn openings_are_gaps_less_differences_of_displacements() {
    let prepared = PreparedProblem::new(half_open(4).unwrap()).unwrap();
    let solution = exact(&prepared);
    let fields = prepared.displacements(&solution.last.fields(&prepared.system()));
    let interface = &prepared.problem().contacts[0].interface;
    for (pair, opening) in interface.pairs().iter().zip(&solution.last.opening) {
        let [u, v] = [0, 1].map(|b: usize| fields[b][pair.nodes[b].index()]);
        assert!((pair.gap - (u - v).dot(&pair.normal) - opening).abs() < 1e-15);
    }
}

#[test]
fn the_traction_of_a_circular_contact_zone_is_that_of_its_displacement() {
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
        contact_geometry::pair_solids(&bodies[upper], &bodies[upper - 1], sides, &Gap::Touching).unwrap()
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
        let low = contact_geometry::solid_against(&body, "bottom", &below, None).unwrap();
        let high = contact_geometry::solid_against(&body, "top", &above, None).unwrap();
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

#[test]
fn a_ball_in_a_declared_socket_may_spin_and_is_not_held_against_a_torque() {
    for n in [2, 4] {
        let free = certified_contact::free_motions(&on_each_other(n, OnSphere::Socket).unwrap()).unwrap();
        assert_eq!(free.len(), 3);
        for motion in free {
            assert!(!motion.weak && motion.load == 0.0, "{motion:?}");
            // The centre of the sphere stays.
            let centre = motion.bodies[0].1.at(Vector3::new(0.0, 0.0, -1.0));
            assert!(centre.norm() < 1e-12, "{centre}");
        }
        let turned = certified_contact::support(&on_each_other(n, OnSphere::Turned).unwrap()).unwrap();
        let motion = turned.unresisted.unwrap();
        assert!(motion.load > 0.5, "{motion:?}");
    }
}

#[test]
fn a_ball_in_a_socket_is_certified_and_its_error_is_below_the_bound() {
    let solved = |n: usize| {
        let prepared = PreparedProblem::new(on_each_other(n, OnSphere::Socket).unwrap()).unwrap();
        let last = exact(&prepared).last;
        let found =
            certified_contact::estimate(&prepared, &last, cre_estimator::Relaxation::Steps(4)).unwrap();
        (found.certificate().map(|of| of.e_cre), found.energy_norm())
    };
    let (bound, norm) = solved(4);
    // The meshes of a sphere are not nested: the energies differ by what the faces leave out as well.
    let (finer, fine) = solved(8);
    let (bound, finer) = (bound.unwrap(), finer.unwrap());
    assert!(finer < bound && (fine - norm).abs() < bound, "{bound} {finer}, {norm} {fine}");
}

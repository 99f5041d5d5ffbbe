//! Solids through `solve`, with the settings of a user: bounds and their sharpness, forces, moments, reactions, balance.

use certified_contact::{CertifiedSolution, Criterion, Results, Settings, Silent, solve};
use cre_estimator::Relaxation;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, RigidCondition};
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::space::Solid;
use nalgebra::{Rotation3, Vector3};
use nndd::NnddSettings;
use tests::formulation::printed;
use tests::solids::{circle, cube, half_open};

fn solved(problem: ContactProblem<Solid>, relaxation: Relaxation) -> CertifiedSolution<Solid> {
    let mut settings = Settings::<Solid>::default();
    settings.relaxation = relaxation;
    let found = solve(problem, &settings, &mut Silent).unwrap();
    assert!(found.is_certified(), "{:?}", found.estimate.map(|e| e.admissibility));
    found
}

fn results(solution: &CertifiedSolution<Solid>) -> &Results<Solid> {
    solution.results.as_ref().unwrap()
}

fn bound(solution: &CertifiedSolution<Solid>) -> f64 {
    solution.estimate.as_ref().unwrap().unchecked().e_cre
}

#[test]
fn bounds_with_default_settings_are_near_the_fully_relaxed_ones() {
    for (name, problem) in [("cube", cube(10)), ("circle", circle(8)), ("half-open", half_open(6))] {
        let problem = problem.unwrap();
        let best = bound(&solved(problem.clone(), Relaxation::Steps(100)));
        let found = solved(problem, Relaxation::default());
        println!("{name}: {} of the fully relaxed bound {best}", bound(&found) / best);
        assert!(bound(&found) < 1.1 * best, "{name}: {} {best}", bound(&found));
    }
}

#[test]
fn the_error_of_half_open_blocks_is_between_nested_meshes_and_the_bound() {
    let [coarse, fine] = [4, 8].map(|n| solved(half_open(n).unwrap(), Relaxation::default()));
    let [a, b] = [&coarse, &fine].map(|of| of.bounds.unwrap());
    for [a, b] in [[a.energy_norm, b.energy_norm], [a.potential_energy, b.potential_energy]] {
        assert!(a[0] <= b[1] && b[0] <= a[1], "{a:?} {b:?}");
    }
    // The energy of the finer mesh is the lower one, and inside the bounds of the coarser one.
    assert!(b.potential_energy[1] < a.potential_energy[1] && b.potential_energy[1] > a.potential_energy[0]);
    let force = results(&coarse).contact_force;
    // The iteration stops at one percent of the error of the mesh.
    assert!((force / printed("half-open", 4, "force, pair 1") - 1.0).abs() < 1e-5, "{force}");
    let area = &results(&coarse).contacts[0].area;
    assert!(area.inner < area.outer && area.outer < 2.0 && area.patches.len() == 1, "{area:?}");
}

#[test]
fn reactions_balance_a_block_on_three_rollers() {
    // Node (0, 0, 0) is on all three sides.
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.5], [4, 2, 3]).unwrap();
    let conditions = BoundaryConditions::<Solid>::default()
        .roller("left", 0.0)
        .roller("front", 0.0)
        .roller("bottom", 0.0)
        .traction("right", [3.0.into(), 0.0.into(), 0.0.into()])
        .traction("back", [0.0.into(), (-5.0).into(), 0.0.into()])
        .traction("top", [0.0.into(), 0.0.into(), 7.0.into()]);
    let material = LinearElastic::isotropic_solid(100.0, 0.3).unwrap();
    let body = Body::new(mesh, material, &conditions).unwrap();
    let found = solved(ContactProblem::new(vec![body]), Relaxation::default());
    let r = results(&found);
    let known = [
        ("left", Vector3::new(-3.0 * 1.5, 0.0, 0.0)),
        ("front", Vector3::new(0.0, 5.0 * 3.0, 0.0)),
        ("bottom", Vector3::new(0.0, 0.0, -7.0 * 2.0)),
    ];
    for (reaction, (side, force)) in r.reactions.iter().zip(known) {
        assert_eq!(reaction.on, side);
        assert!((reaction.force - force).norm() < 1e-12, "{reaction:?}");
    }
    assert!(r.balance[0].force.norm() < 1e-12 && r.balance[0].moment.norm() < 1e-12, "{:?}", r.balance);
    // The stress is uniform: σ_xx = 3, σ_yy = −5, σ_zz = 7.
    let pairs = (3.0 + 5.0f64).powi(2) + (-5.0 - 7.0f64).powi(2) + (7.0 - 3.0f64).powi(2);
    for stress in [r.max_von_mises.unwrap(), r.peak_stress.unwrap().von_mises] {
        assert!((stress - (0.5 * pairs).sqrt()).abs() < 1e-11, "{stress}");
    }
}

#[test]
fn a_pressed_block_has_the_resultants_of_its_load() {
    let material = LinearElastic::isotropic_solid(100.0, 0.3).unwrap();
    let body = |z: f64, conditions: BoundaryConditions<Solid>| {
        let mesh = cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap();
        Body::new(mesh, material.clone(), &conditions).unwrap()
    };
    let upper =
        body(1.0, BoundaryConditions::default().traction("top", [0.0.into(), 0.0.into(), (-3.0).into()]));
    let lower = body(0.0, BoundaryConditions::default().fix("bottom"));
    let interface = contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching).unwrap();
    let found = solved(ContactProblem::between([upper, lower], interface), Relaxation::default());
    let r = results(&found);
    let pair = &r.contacts[0];
    assert!((pair.resultant - Vector3::new(0.0, 0.0, 6.0)).norm() < 1e-11, "{pair:?}");
    // The load acts in the middle of the side, at (1, ½).
    assert!((pair.moment - Vector3::new(3.0, -6.0, 0.0)).norm() < 1e-11, "{pair:?}");
    assert!((pair.centre.unwrap() - Vector3::new(1.0, 0.5, 1.0)).norm() < 1e-11, "{pair:?}");
    assert_eq!((pair.area.inner, pair.area.outer, pair.area.patches.len()), (2.0, 2.0, 1));
    assert!((r.reactions[0].force - Vector3::new(0.0, 0.0, 6.0)).norm() < 1e-11, "{:?}", r.reactions);
    for balance in &r.balance {
        assert!(balance.force.norm() < 1e-11 && balance.moment.norm() < 1e-11, "{balance:?}");
    }
    let [low, high] = found.bounds.unwrap().contact_force.unwrap();
    assert!(low <= 6.0 && high >= 6.0 && high - low < 1e-9, "{low} {high}");
}

#[test]
fn bounds_of_the_contact_force_do_not_use_a_motion_along_the_contact() {
    // The lower block may slide along x: the traces of this motion along the contact normals are rounding if the blocks are turned.
    for k in 0..20 {
        let angle = 0.3 * f64::from(k);
        let turn = Rotation3::from_euler_angles(angle, 0.7 - angle, 2.0 * angle);
        let turned = |mesh: &TetMesh| {
            let facets = |ids: &[_]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
            let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
            let points: Vec<Vector3<f64>> = mesh.points().iter().map(|x| turn * x).collect();
            Mesh::new(points, mesh.cells().to_vec(), groups).unwrap()
        };
        let material = LinearElastic::isotropic_solid(100.0, 0.3).unwrap();
        let body = |z: f64, conditions: BoundaryConditions<Solid>| {
            let mesh = turned(&cuboid([0.0, 0.0, z], [1.0; 3], [2; 3]).unwrap());
            Body::new(mesh, material.clone(), &conditions.roller("front", 0.0)).unwrap()
        };
        let upper = body(1.0, BoundaryConditions::default().roller("left", 0.0).pressure("top", 3.0));
        let lower = body(0.0, BoundaryConditions::default().roller("bottom", 0.0));
        let interface =
            contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching).unwrap();
        let found = solved(ContactProblem::between([upper, lower], interface), Relaxation::default());
        let [low, high] = found.bounds.unwrap().contact_force.unwrap();
        assert!(low <= 3.0 && high >= 3.0 && high - low < 1e-9, "{low} {high}");
    }
}

#[test]
fn a_rigid_side_beside_rollers_is_certified_with_its_load() {
    // No wrench of the relaxation runs from the rigid side to a roller around their common edge.
    let mesh = cuboid([0.0; 3], [1.0, 1.0, 2.0], [2, 2, 4]).unwrap();
    let rigid = RigidCondition {
        edges: "top".into(),
        force: Vector3::new(0.0, 0.0, -0.8),
        moment: Vector3::new(-0.03, 0.08, 0.0),
        ..Default::default()
    };
    let conditions = BoundaryConditions::<Solid>::default()
        .roller("left", 0.0)
        .roller("front", 0.0)
        .roller("bottom", 0.0)
        .rigid(rigid)
        .body_force([0.0, 0.0, -0.9]);
    let material = LinearElastic::isotropic_solid(100.0, 0.3).unwrap();
    let problem = ContactProblem::new(vec![Body::new(mesh, material, &conditions).unwrap()]);
    let [eet, relaxed] =
        [Relaxation::NONE, Relaxation::default()].map(|relaxation| solved(problem.clone(), relaxation));
    assert!(bound(&relaxed) < 0.7 * bound(&eet), "{} {}", bound(&relaxed), bound(&eet));
    let force = results(&relaxed).rigid_sides[0].force;
    assert!((force[2] + 0.8).abs() < 1e-11, "{force}");
}

#[test]
fn the_paper_s_iteration_without_contact_takes_its_steps() {
    let mut method = NnddSettings::default();
    method.max_iterations = 3;
    let mut settings = Settings::<Solid>::default().with_method(method);
    settings.criterion = Criterion::Iterations;
    let found = solve(cube(2).unwrap(), &settings, &mut Silent).unwrap();
    assert!(found.is_certified() && found.rows.len() == 3, "{} {:?}", found.rows.len(), found.nndd.status);
}

#[test]
fn a_block_that_nothing_holds_is_refused_with_its_motion() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [2; 3]).unwrap();
    let pushed = BoundaryConditions::<Solid>::default().traction("top", [1.0.into(), 0.0.into(), 0.0.into()]);
    let body = Body::new(mesh, LinearElastic::isotropic_solid(100.0, 0.3).unwrap(), &pushed).unwrap();
    let error = solve(ContactProblem::new(vec![body]), &Settings::default(), &mut Silent).unwrap_err();
    assert!(error.to_string().contains("not held"), "{error}");
}

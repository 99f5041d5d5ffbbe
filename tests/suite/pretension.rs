//! Cuts through bolts that are tightened: figures of an independent code, closed forms, nested meshes, refusals.
//!
//! The figures of [`CANONICAL`] are those of a prototype in another language: a T-shaped bolt, half of it, through a hole in a flange.

use certified_contact::{CertifiedSolution, ContactSpace, Settings, Silent, SolveError, solve};
use cre_estimator::{Estimate, Relaxation};
use fem_core::body::{Body, BodyError};
use fem_core::boundary::{BoundaryConditions, CutLoad, SpringDirection};
use fem_core::field;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::{block, cuboid};
use fem_core::mesh::id::NodeId;
use fem_core::mesh_field::MeshField;
use fem_core::norm::sum_over_cells;
use fem_core::space::Solid;
use nalgebra::Vector3;
use nndd::NewtonSettings;

fn material(young: f64, poisson: f64) -> LinearElastic {
    LinearElastic::isotropic(young, poisson, Hypothesis::PlaneStrain).unwrap()
}

/// Keeps the cells of a block whose centroids satisfy a condition, and names the boundary edges by their middles.
fn part_of(
    block: &TriMesh,
    keep: impl Fn(Vector) -> bool,
    sides: &[(&str, &dyn Fn(Vector) -> bool)],
) -> TriMesh {
    let middle =
        |nodes: &[NodeId]| nodes.iter().map(|n| block.points()[*n]).sum::<Vector>() / nodes.len() as f64;
    let kept: Vec<[NodeId; 3]> = block.cells().iter().filter(|cell| keep(middle(*cell))).copied().collect();
    let (mut number, mut points) = (vec![NodeId::NONE; block.points().len()], Vec::new());
    for node in kept.iter().flatten() {
        if number[node.index()] == NodeId::NONE {
            number[node.index()] = NodeId::new(points.len());
            points.push(block.points()[*node]);
        }
    }
    let cells: Vec<[NodeId; 3]> = kept.iter().map(|cell| cell.map(|n| number[n.index()])).collect();
    let bare = TriMesh::new(points.clone(), cells.clone(), Vec::new()).unwrap();
    let side = |on: &dyn Fn(Vector) -> bool| -> Vec<[NodeId; 2]> {
        let facets = bare.topology().boundary_facets().iter();
        facets
            .filter(|facet| on(bare.facet_middle(**facet)))
            .map(|facet| bare.topology().facets()[*facet])
            .collect()
    };
    let groups = sides.iter().map(|(name, on)| ((*name).to_owned(), side(*on))).collect();
    TriMesh::new(points, cells, groups).unwrap()
}

/// The bolt and the flange of the figures, with cells of 1/(8n).
fn flange(n: usize, load: CutLoad) -> ContactProblem {
    let at = |c: usize, value: f64| move |x: Vector| (x[c] - value).abs() < 1e-9;
    let whole = block([0.0, 0.0], [1.25, 2.0], [10 * n, 16 * n]).unwrap();
    let bolt = part_of(
        &whole,
        |x| x[0] < 0.5 || x[1] > 1.5,
        &[("left", &at(0, 0.0)), ("bottom", &at(1, 0.0)), ("under", &|x| at(1, 1.5)(x) && x[0] > 0.625)],
    );
    let bolt_conditions = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("bottom", None, Some(0.0.into()))
        .cut("bolt", [0.0, 0.75], [0.0, 1.0], load);
    let whole = block([0.625, 0.0], [1.375, 1.5], [11 * n, 12 * n]).unwrap();
    let ring = part_of(
        &whole,
        |_| true,
        &[("right", &at(0, 2.0)), ("bottom", &at(1, 0.0)), ("top", &|x| at(1, 1.5)(x) && x[0] < 1.25)],
    );
    let ring_conditions = BoundaryConditions::new().displace("right", Some(0.0.into()), None).displace(
        "bottom",
        None,
        Some(0.0.into()),
    );
    let bodies = [
        Body::new(bolt, material(2000.0, 0.3), &bolt_conditions).unwrap(),
        Body::new(ring, material(1000.0, 0.3), &ring_conditions).unwrap(),
    ];
    let interface =
        contact_geometry::pair(&bodies[0], &bodies[1], ["under", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between(bodies, interface)
}

fn solved<S: ContactSpace>(problem: ContactProblem<S>, relaxation: Relaxation) -> CertifiedSolution<S> {
    let mut settings = Settings::default().with_method(NewtonSettings::default());
    settings.relaxation = relaxation;
    solve(problem, &settings, &mut Silent).unwrap()
}

/// The estimate of a certified solution.
fn certified<S: ContactSpace>(solution: &CertifiedSolution<S>) -> &Estimate<S> {
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(estimate.admissibility.is_valid(), "{:?}", estimate.admissibility);
    assert!(estimate.cre.split_defect() < 1e-12, "{:e}", estimate.cre.split_defect());
    estimate
}

/// `∫ σ : E⁻¹ σ` of the shank below the cut, of the head and the shank above it, and of the flange.
fn energies(solution: &CertifiedSolution) -> [f64; 3] {
    let estimate = solution.estimate.as_ref().unwrap();
    let energy = |b: usize, part: fn(Vector) -> bool| {
        let body = &solution.problem.bodies[b];
        let stress = field::stresses(body, &estimate.pair.bodies[b].displacement);
        let of_cell = |t: usize| {
            let middle = body.mesh().corners(t).into_iter().sum::<Vector>() / 3.0;
            let energy = body.mesh().measure(t) * body.material(t).complementary(stress[t], stress[t]);
            if part(middle) { energy } else { 0.0 }
        };
        sum_over_cells(stress.len(), of_cell)
    };
    [energy(0, |x| x[1] < 0.75), energy(0, |x| x[1] > 0.75), energy(1, |_| true)]
}

/// The error of a solution on a mesh against the one on a finer, nested mesh.
fn error(coarse: &CertifiedSolution, fine: &CertifiedSolution) -> f64 {
    let of_body = |b: usize| {
        let [u, v] = [coarse, fine].map(|of| &of.estimate.as_ref().unwrap().pair.bodies[b].displacement);
        MeshField::of_body(&coarse.problem.bodies[b], u).energy_distance_squared(&fine.problem.bodies[b], v)
    };
    (0..2).map(of_body).sum::<f64>().sqrt()
}

fn near(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found:.13} is not {expected:.13}");
}

/// Force and shortening, energies, active nodes, the bound by EET, after two steps, and with the best stress, of a load.
type Figures = (CutLoad, [f64; 2], [f64; 3], [f64; 3]);

const CANONICAL: [Figures; 2] = [
    (
        CutLoad::Force(2.0),
        [2.0, 0.0128860192443],
        [0.00271959189599, 0.0122160329406, 0.0108364136521],
        [0.157875246928, 0.0608, 0.0567619337671],
    ),
    (
        CutLoad::Shortening(0.02),
        [3.10413939647, 0.02],
        [0.006551280257, 0.0294274503245, 0.0261040573478],
        [0.245033386858, 0.0943, 0.0880984774103],
    ),
];

#[test]
fn a_bolt_in_a_flange_has_the_figures_of_an_independent_code() {
    for (load, [force, shortening], energy, [by_eet, by_two, best]) in CANONICAL {
        let solution = solved(flange(1, load), Relaxation::NONE);
        near(certified(&solution).cre.e_cre(), by_eet, 1e-8);
        let cut = &solution.problem.bodies[0].cuts()[0];
        let displacement = &solution.estimate.as_ref().unwrap().pair.bodies[0].displacement;
        near(cut.shortening, shortening, 1e-11);
        near(solution.problem.bodies[0].cut_forces(displacement)[0][0], force, 1e-11);
        energies(&solution)
            .into_iter()
            .zip(energy)
            .for_each(|(found, expected)| near(found, expected, 1e-10));
        let active = solution.last().contact.active.as_slice();
        assert_eq!(active.iter().filter(|active| **active).count(), 4, "{active:?}");
        // The bolt pulls with the force with which the flange presses.
        near(solution.results.as_ref().unwrap().contact_force, force, 1e-10);
        let two = solved(flange(1, load), Relaxation::Steps(2));
        near(certified(&two).cre.e_cre(), by_two, 2e-2);
        let all = solved(flange(1, load), Relaxation::Steps(4000));
        near(certified(&all).cre.e_cre(), best, 1e-6);
        let truth = error(&solution, &solved(flange(8, load), Relaxation::NONE));
        let effectivity = certified(&all).cre.e_cre() / truth;
        assert!((1.0..1.25).contains(&effectivity), "{effectivity}");
    }
}

/// A bar along its last axis, of the size 1 × … × 3, clamped at both ends.
fn bar(load: CutLoad) -> ContactProblem {
    let conditions =
        BoundaryConditions::new().fix("bottom").fix("top").cut("bolt", [0.0, 1.0], [0.0, 2.0], load);
    let mesh = block([0.0, 0.0], [1.0, 3.0], [3, 9]).unwrap();
    ContactProblem::new(vec![Body::new(mesh, material(200.0, 0.0), &conditions).unwrap()])
}

fn solid_bar(load: CutLoad) -> ContactProblem<Solid> {
    let conditions = BoundaryConditions::<Solid>::default().fix("bottom").fix("top");
    let conditions = conditions.cut("bolt", Vector3::new(0.5, 0.5, 1.0), Vector3::new(0.0, 0.0, 1.0), load);
    let mesh = cuboid([0.0; 3], [1.0, 1.0, 3.0], [2, 2, 6]).unwrap();
    let material = LinearElastic::<Solid>::isotropic_solid(200.0, 0.0).unwrap();
    ContactProblem::new(vec![Body::new(mesh, material, &conditions).unwrap()])
}

/// Shortening, force, energy and bound of a solution, which is exact.
fn check_bar<S: ContactSpace>(problem: ContactProblem<S>, [force, shortening]: [f64; 2]) {
    let solution = solved(problem, Relaxation::default());
    assert!(solution.is_certified());
    let results = solution.results.as_ref().unwrap();
    near(results.cuts[0].force, force, 1e-11);
    near(results.cuts[0].shortening, shortening, 1e-11);
    // The energy of the bar, F δ.
    near(results.energy_norm_squared[0], force * shortening, 1e-11);
    assert!(solution.relative().unwrap() < 1e-9, "{:?}", solution.relative());
}

#[test]
fn a_clamped_bar_has_the_stress_of_its_shortening() {
    // σ = E δ / L.
    let (force, shortening) = (200.0 * 0.02 / 3.0, 0.02);
    for load in [CutLoad::Shortening(shortening), CutLoad::Force(force)] {
        check_bar(bar(load), [force, shortening]);
        check_bar(solid_bar(load), [force, shortening]);
    }
    check_bar(bar(CutLoad::Force(-force)), [-force, -shortening]);
}

#[test]
fn loads_beside_a_cut_do_work_in_it() {
    // A bar that hangs from its top under its weight and a traction along its sides, and is held at its bottom as well: the same stress follows
    // without a cut if the bottom moves up by the shortening.
    let loaded = |conditions: BoundaryConditions| {
        let along = [0.0.into(), 3.0.into()];
        conditions.body_force([0.0, -5.0]).traction("left", along.clone()).traction("right", along)
    };
    let body = |conditions: &BoundaryConditions| {
        let mesh = block([0.0, 0.0], [1.0, 3.0], [3, 9]).unwrap();
        Body::new(mesh, material(200.0, 0.3), conditions).unwrap()
    };
    let held = BoundaryConditions::new().fix("top");
    let cut =
        loaded(held.clone()).fix("bottom").cut("bolt", [0.0, 1.0], [0.0, 1.0], CutLoad::Shortening(0.02));
    let moved = loaded(held).displace("bottom", Some(0.0.into()), Some((-0.02).into()));
    let [cut, moved] =
        [cut, moved].map(|of| solved(ContactProblem::new(vec![body(&of)]), Relaxation::default()));
    let [a, b] = [&cut, &moved].map(|of| of.results.as_ref().unwrap());
    near(a.energy_norm_squared[0], b.energy_norm_squared[0], 1e-11);
    near(certified(&cut).cre.e_cre(), certified(&moved).cre.e_cre(), 1e-9);
    // Below the cut the bar of the second problem is 0.02 lower, with its weight and its traction of 2·3 − 5.
    let [a, b] = [&cut, &moved].map(|of| of.bounds.unwrap().potential_energy);
    for k in 0..2 {
        near(a[k], b[k] - 0.02 * (6.0 - 5.0), 1e-9);
    }
    // The force follows from the reaction at the bottom.
    let results = cut.results.as_ref().unwrap();
    let reaction = results.reactions.iter().find(|of| of.on == "bottom").unwrap().force[1];
    near(results.cuts[0].force, -reaction + 5.0 - 6.0, 1e-9);
    // With this force the shortening comes back.
    let given = BoundaryConditions::new().fix("top").fix("bottom");
    let given = loaded(given).cut("bolt", [0.0, 1.0], [0.0, 1.0], CutLoad::Force(results.cuts[0].force));
    let again = solved(ContactProblem::new(vec![body(&given)]), Relaxation::default());
    near(again.results.as_ref().unwrap().cuts[0].shortening, 0.02, 1e-10);
    // F δ is work of the given force. The lower bounds differ: with a given force no stress passes another one from the bottom to the top.
    near(again.bounds.unwrap().potential_energy[1], a[1] - 0.02 * results.cuts[0].force, 1e-9);
}

/// A frame, a square with a square hole, cut through its left leg: clamped at its bottom, or resting on a roller and a node.
fn frame(n: usize, load: CutLoad, held: impl Fn(BoundaryConditions) -> BoundaryConditions) -> ContactProblem {
    let whole = block([0.0, 0.0], [3.0, 3.0], [6 * n, 6 * n]).unwrap();
    let inside = |x: f64| (1.0..2.0).contains(&x);
    let at = |c: usize, value: f64| move |x: Vector| (x[c] - value).abs() < 1e-9;
    let mesh = part_of(
        &whole,
        |x| !(inside(x[0]) && inside(x[1])),
        &[("bottom", &at(1, 0.0)), ("right", &at(0, 3.0)), ("top", &at(1, 3.0))],
    );
    let mut conditions = held(BoundaryConditions::new()).cut("leg", [0.5, 1.5], [0.0, 1.0], load);
    conditions.cuts[0].part = Some([[0.0, 1.0], [0.0, 3.0]]);
    ContactProblem::new(vec![Body::new(mesh, material(1000.0, 0.3), &conditions).unwrap()])
}

#[test]
fn a_frame_is_cut_without_parting_it() {
    let clamped = |conditions: BoundaryConditions| conditions.fix("bottom");
    // Two supports: a column passes a force from one to the other, through the cut or beside it.
    let between = |conditions: BoundaryConditions| conditions.fix("bottom").fix("top");
    for (held, loads) in [(&clamped as &dyn Fn(_) -> _, [0.03, 4.0]), (&between, [0.03, -4.0])] {
        for load in [CutLoad::Shortening(loads[0]), CutLoad::Force(loads[1])] {
            let steps = Relaxation::Steps(30);
            let [coarse, fine] = [2, 8].map(|n| solved(frame(n, load, held), steps));
            let bound = certified(&coarse).cre.e_cre();
            let of = |solution: &CertifiedSolution| {
                solution.estimate.as_ref().unwrap().pair.bodies[0].displacement.clone()
            };
            let (u, v) = (of(&coarse), of(&fine));
            let field = MeshField::of_body(&coarse.problem.bodies[0], &u);
            let error = field.energy_distance_squared(&fine.problem.bodies[0], &v).sqrt();
            assert!(bound >= error && bound < 1.5 * error, "{load:?}: {bound} and {error}");
            let [a, b] = [&coarse, &fine].map(|of| of.bounds.unwrap());
            for [a, b] in [[a.energy_norm, b.energy_norm], [a.potential_energy, b.potential_energy]] {
                assert!(a[0] <= b[1] && b[0] <= a[1], "{load:?}: {a:?} and {b:?}");
            }
            if let CutLoad::Force(force) = load {
                near(coarse.results.as_ref().unwrap().cuts[0].force, force, 1e-10);
            }
        }
    }
}

#[test]
fn a_solid_bolt_is_tightened_by_two_nested_meshes() {
    // A quarter of a bolt in a block: half its head presses on the flange.
    let bolt = |n: usize, load: CutLoad| {
        let shank = cuboid([0.0, 0.0, 0.0], [2.0, 1.0, 2.0], [4 * n, 2 * n, 4 * n]).unwrap();
        let conditions = BoundaryConditions::<Solid>::default().fix("bottom").pressure("right", 0.5).cut(
            "bolt",
            Vector3::new(0.0, 0.0, 1.0),
            Vector3::new(0.0, 0.0, 3.0),
            load,
        );
        let conditions = conditions.components("top", [None, None, Some(0.0.into())]);
        let material = LinearElastic::<Solid>::isotropic_solid(1000.0, 0.3).unwrap();
        ContactProblem::new(vec![Body::new(shank, material, &conditions).unwrap()])
    };
    for load in [CutLoad::Shortening(0.01), CutLoad::Force(7.0)] {
        let [coarse, fine] = [1, 3].map(|n| solved(bolt(n, load), Relaxation::Steps(10)));
        let bound = certified(&coarse).cre.e_cre();
        let of = |solution: &CertifiedSolution<Solid>| {
            solution.estimate.as_ref().unwrap().pair.bodies[0].displacement.clone()
        };
        let (u, v) = (of(&coarse), of(&fine));
        let field = MeshField::of_body(&coarse.problem.bodies[0], &u);
        let error = field.energy_distance_squared(&fine.problem.bodies[0], &v).sqrt();
        assert!(bound >= error && bound < 2.0 * error, "{load:?}: {bound} and {error}");
        let [a, b] = [&coarse, &fine].map(|of| of.bounds.unwrap().potential_energy);
        assert!(a[0] <= b[1] && b[0] <= a[1], "{load:?}: {a:?} and {b:?}");
    }
}

#[test]
fn forces_that_nothing_resists_are_refused() {
    // A head that is free of contact: the bolt is free to shorten.
    let mut problem = flange(1, CutLoad::Force(2.0));
    let alone = ContactProblem::new(vec![problem.bodies.remove(0)]);
    let error = solve(alone, &Settings::default(), &mut Silent).unwrap_err();
    assert!(matches!(error, SolveError::CutForce { .. }), "{error}");
    // A bolt that is pressed does not close its contact.
    let error = solve(flange(1, CutLoad::Force(-2.0)), &Settings::default(), &mut Silent).unwrap_err();
    assert!(matches!(error, SolveError::CutForce { .. }), "{error}");
}

#[test]
fn two_cuts_of_a_frame_share_their_force() {
    // Nothing holds the legs but the frame itself: their forces are opposite.
    let tightened = |loads: [CutLoad; 2]| {
        let mut problem = frame(2, loads[0], |conditions| conditions.fix("bottom"));
        let mesh = problem.bodies.remove(0).mesh().clone();
        let mut conditions = BoundaryConditions::new().fix("bottom");
        for (k, load) in loads.into_iter().enumerate() {
            conditions = conditions.cut(["left", "right"][k], [0.5, 1.5], [0.0, 1.0], load);
            conditions.cuts[k].part = Some([[2.0 * k as f64, 2.0 * k as f64 + 1.0], [0.0, 3.0]]);
        }
        ContactProblem::new(vec![Body::new(mesh, material(1000.0, 0.3), &conditions).unwrap()])
    };
    let both = solved(tightened([CutLoad::Force(2.0), CutLoad::Force(-2.0)]), Relaxation::Steps(2));
    certified(&both);
    let cuts = &both.results.as_ref().unwrap().cuts;
    near(cuts[0].force, 2.0, 1e-9);
    near(cuts[1].force, -2.0, 1e-9);
    let one = solved(
        tightened([CutLoad::Force(2.0), CutLoad::Shortening(cuts[1].shortening)]),
        Relaxation::Steps(2),
    );
    near(one.results.as_ref().unwrap().cuts[0].shortening, cuts[0].shortening, 1e-8);
    let error =
        solve(tightened([CutLoad::Force(2.0), CutLoad::Force(1.0)]), &Settings::default(), &mut Silent);
    assert!(matches!(error, Err(SolveError::CutForce { .. })));
}

#[test]
fn a_bolt_is_untightened() {
    let loose = solved(flange(1, CutLoad::Force(0.0)), Relaxation::Steps(2));
    assert!(certified(&loose).energy_norm() < 1e-9);
    let little = solved(flange(1, CutLoad::Force(1e-7)), Relaxation::Steps(2));
    near(little.results.as_ref().unwrap().cuts[0].force, 1e-7, 1e-8);
}

#[test]
fn cuts_that_are_no_cuts_are_refused() {
    let fault = |conditions: BoundaryConditions| {
        let mesh = block([0.0, 0.0], [1.0, 3.0], [3, 9]).unwrap();
        Body::new(mesh, material(200.0, 0.3), &conditions).unwrap_err()
    };
    let load = CutLoad::Shortening(0.01);
    let cut = |at: [f64; 2], normal: [f64; 2]| {
        BoundaryConditions::new().fix("bottom").cut("bolt", at, normal, load)
    };
    let boxed = |part: [[f64; 2]; 2]| {
        let mut conditions = cut([0.0, 1.0], [0.0, 1.0]);
        conditions.cuts[0].part = Some(part);
        conditions
    };
    let found = [
        fault(cut([0.0, 1.1], [0.0, 1.0])),
        fault(cut([0.0, 0.0], [0.0, 1.0])),
        fault(boxed([[0.0, 0.7], [0.0, 2.0]])),
        fault(cut([0.0, 1.0], [0.0, 0.0])),
        fault(cut([0.0, 1.0], [0.0, 1.0]).fix("left")),
        fault(cut([0.0, 1.0], [0.0, 1.0]).spring("left", 3.0, SpringDirection::All)),
        fault(cut([0.0, 1.0], [0.0, 1.0]).cut("other", [0.0, 1.0], [0.0, 1.0], load)),
        fault(cut([0.0, f64::NAN], [0.0, 1.0])),
    ];
    assert!(matches!(found[0], BodyError::CutMisses { .. }), "{}", found[0]);
    assert!(matches!(found[1], BodyError::CutMisses { .. }), "{}", found[1]);
    assert!(matches!(found[2], BodyError::CutEnds { .. }), "{}", found[2]);
    assert!(matches!(found[3], BodyError::NotFinite { .. }), "{}", found[3]);
    assert!(matches!(found[4], BodyError::CutHeld { .. }), "{}", found[4]);
    assert!(matches!(found[5], BodyError::CutHeld { .. }), "{}", found[5]);
    assert!(matches!(found[6], BodyError::CutTwice { .. }), "{}", found[6]);
    assert!(matches!(found[7], BodyError::NotFinite { .. }), "{}", found[7]);
    // What is perpendicular to the axis continues across a cut.
    let mesh = block([0.0, 0.0], [1.0, 3.0], [3, 9]).unwrap();
    let rolls = cut([0.0, 1.0], [0.0, 1.0]).roller("left", 0.0).spring("right", 3.0, SpringDirection::Normal);
    assert!(Body::new(mesh, material(200.0, 0.3), &rolls).is_ok());
    // Both legs of the frame.
    let mut conditions = BoundaryConditions::new().fix("bottom").cut("legs", [0.5, 1.5], [0.0, 1.0], load);
    let whole = frame(1, load, |conditions| conditions.fix("bottom")).bodies.remove(0).mesh().clone();
    let error = Body::new(whole.clone(), material(1.0, 0.3), &conditions).unwrap_err();
    assert!(matches!(error, BodyError::CutParts { parts: 2, .. }), "{error}");
    conditions.cuts[0].part = Some([[2.0, 3.0], [0.0, 3.0]]);
    assert!(Body::new(whole, material(1.0, 0.3), &conditions).is_ok());
}

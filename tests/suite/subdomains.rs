//! Bodies cut into subdomains: the fields, the iteration and the bounds are those of the bodies in one piece.

use certified_contact::{CertifiedSolution, Criterion, Settings, Silent, solve};
use cre_estimator::Relaxation;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::ContactProblem;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::mesh::id::NodeId;
use fem_core::prepared::PreparedProblem;
use fem_core::space::{Plane, Solid};
use neumann_neumann::{Balancing, BodySolvers, Broken, Skeleton};
use std::borrow::Cow;
use tests::solids::{cube, half_open, of_case};

/// A block on a roller and a spring, heavy and pulled.
fn plane_body() -> ContactProblem<Plane> {
    let conditions = BoundaryConditions::new()
        .fix("left")
        .displace("right", None, Some(0.01.into()))
        .pressure("top", 3.0)
        .body_force([0.3, -1.0]);
    let material = LinearElastic::isotropic(200.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let mesh = block([0.0, 0.0], [2.0, 1.0], [24, 13]).unwrap();
    ContactProblem::new(vec![Body::new(mesh, material, &conditions).unwrap()])
}

#[test]
fn the_field_of_a_body_in_subdomains_is_that_of_the_body() {
    let forces = |n: usize| [(NodeId::new(n / 2), 0.1), (NodeId::new(n - 1), -0.2)];
    let whole = PreparedProblem::new(plane_body()).unwrap();
    let nodes = whole.problem().bodies[0].mesh().points().len();
    let plane = forces(nodes).map(|(node, f)| (node, fem_core::geometry::Vector::new(f, 2.0 * f)));
    let solid_whole = PreparedProblem::new(cube(5).unwrap()).unwrap();
    let solid_nodes = solid_whole.problem().bodies[0].mesh().points().len();
    let solid = forces(solid_nodes).map(|(node, f)| (node, nalgebra::Vector3::new(f, 2.0 * f, -f)));
    for count in [2, 3, 8, 27] {
        let cut = PreparedProblem::prepare(plane_body(), &[count], |_| true).unwrap();
        let found = BodySolvers::new(&cut).unwrap();
        let expected = BodySolvers::new(&whole).unwrap();
        let [a, b] = [&found, &expected].map(|of| of.bodies()[0].displacement_from_nodal_forces(&plane));
        let size = b.iter().map(|u| u.norm()).fold(0.0, f64::max);
        let off = a.iter().zip(&b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-12 * size, "plane, {count}: {off} of {size}");

        let cut = PreparedProblem::prepare(cube(5).unwrap(), &[count], |_| true).unwrap();
        let found = BodySolvers::new(&cut).unwrap();
        let expected = BodySolvers::new(&solid_whole).unwrap();
        let [a, b] = [&found, &expected].map(|of| of.bodies()[0].displacement_from_nodal_forces(&solid));
        let size = b.iter().map(|u| u.norm()).fold(0.0, f64::max);
        let off = a.iter().zip(&b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-12 * size, "solid, {count}: {off} of {size}");
        assert_eq!(cut.bodies()[0].unknowns(), solid_whole.bodies()[0].unknowns());
    }
}

#[test]
fn the_iterations_of_a_cube_in_eight_boxes_are_the_printed_ones() {
    let prepared = PreparedProblem::prepare(cube(6).unwrap(), &[8], |_| true).unwrap();
    let broken = Broken::new(Cow::Owned(prepared.system_of(0, &[])), &[]).unwrap();
    let linear = Balancing::new(&broken, Skeleton::new(&broken, &[], &[])).unwrap();
    let mut inner = linear.step_1(&broken, &broken.load, &vec![0.0; broken.len()]);
    let whole = PreparedProblem::new(cube(6).unwrap()).unwrap();
    let exact = BodySolvers::new(&whole).unwrap().bodies()[0].displacement_from_nodal_forces(&[]);
    let body = &whole.problem().bodies[0];
    for (k, printed) in [2.114162, 0.2547547, 0.03806076, 0.006075022, 7.445992e-4].into_iter().enumerate() {
        let eta = inner.squared.sqrt();
        let cut = prepared.bodies()[0].cut().unwrap();
        let field = |(k, part): (usize, &fem_core::subdomains::Subdomain<Solid>)| {
            part.condensed.displacement_from_trace(&inner.x[broken.of_body(k)])
        };
        let field = cut.joined(&cut.subdomains().iter().enumerate().map(field).collect::<Vec<_>>());
        let error = fem_core::norm::energy_distance_squared(body, &field, &exact).sqrt();
        assert!((eta / printed - 1.0).abs() < 1e-6, "{k}: {eta} {printed}");
        assert!(eta >= error * (1.0 - 1e-9), "{k}: {eta} {error}");
        assert!(linear.update(&broken, &mut inner));
    }
}

/// Solves a problem to convergence.
fn converged(
    problem: ContactProblem<Solid>,
    count: usize,
    relaxation: Relaxation,
) -> CertifiedSolution<Solid> {
    let mut settings = Settings::<Solid>::default();
    settings.criterion = Criterion::EtaNndd { tolerance: 1e-12 };
    (settings.relaxation, settings.subdomains, settings.exact) = (relaxation, count, None);
    let found = solve(problem, &settings, &mut Silent).unwrap();
    assert!(found.is_certified(), "{:?} {:?}", found.no_estimate, found.nndd.status);
    found
}

#[test]
fn the_bound_of_a_curved_pair_does_not_depend_on_the_number_of_subdomains() {
    let solved =
        |count: usize| converged(of_case("press_fit.toml", 2, 12).unwrap(), count, Relaxation::Steps(3));
    let whole = solved(1);
    assert!(whole.problem.contacts[0].interface.has_bent_facets());
    for count in [2, 8] {
        let found = solved(count);
        let [a, b] = [&found, &whole].map(|of| of.estimate.as_ref().unwrap().unchecked().e_cre);
        assert!((a / b - 1.0).abs() < 1e-8, "{count}: {a} {b}");
        let off = found.last().contact_force() / whole.last().contact_force() - 1.0;
        assert!(off.abs() < 1e-9, "{count}: {off}");
        assert_eq!(found.last().contact.active.as_slice(), whole.last().contact.active.as_slice());
    }
}

#[test]
fn the_bound_at_convergence_does_not_depend_on_the_number_of_subdomains() {
    let solved = |count: usize, relaxation: Relaxation| converged(half_open(4).unwrap(), count, relaxation);
    // The relaxation rounds its coefficients to single precision: its bounds differ by that.
    for (relaxation, tolerance) in [(Relaxation::NONE, 1e-11), (Relaxation::Steps(3), 1e-8)] {
        let whole = solved(1, relaxation);
        for count in [2, 4, 8, 64] {
            let found = solved(count, relaxation);
            let [a, b] = [&found, &whole].map(|of| of.estimate.as_ref().unwrap().unchecked().e_cre);
            assert!((a / b - 1.0).abs() < tolerance, "{count}: {a} {b}");
            assert_eq!(found.last().contact.active.as_slice(), whole.last().contact.active.as_slice());
            let [a, b] = [&found, &whole].map(|of| of.bounds.as_ref().unwrap());
            for (a, b) in [(a.energy_norm, b.energy_norm), (a.potential_energy, b.potential_energy)] {
                let size = b[0].abs().max(b[1].abs());
                assert!((0..2).all(|k| (a[k] - b[k]).abs() < 1e-7 * size), "{a:?} {b:?}");
            }
            let [a, b] = [a, b].map(|of| of.contact_force.unwrap());
            let size = b[0].abs().max(b[1].abs());
            assert!((0..2).all(|k| (a[k] - b[k]).abs() < 1e-7 * size), "{a:?} {b:?}");
            // Which of two supports with a common edge has a force there, depends on the stress: the sum does not.
            let [a, b] = [&found, &whole].map(|of| of.results.as_ref().unwrap());
            for body in 0..2 {
                let of_body = |of: &certified_contact::Reaction<Solid>| of.body == body;
                let [sum, expected] = [a, b].map(|of| {
                    let own = of.reactions.iter().filter(|of| of_body(of));
                    own.map(|of| of.force).sum::<nalgebra::Vector3<f64>>()
                });
                let off = (sum - expected).norm();
                assert!(off < 1e-9 * whole.last().contact_force(), "{count}: {sum} {expected}");
                assert!(a.balance[body].force.norm() < 1e-9 * whole.last().contact_force(), "{count}");
            }
        }
    }
}

#[test]
fn every_iterate_has_a_strict_bound() {
    let exact = PreparedProblem::new(half_open(4).unwrap()).unwrap();
    let exact_solution =
        nndd::solve_exactly(&exact.system(), &nndd::contact_qp::QpSettings::default()).unwrap();
    let exact_fields = exact.displacements(&exact_solution.fields);
    let mut before = f64::INFINITY;
    for iterations in 1..12 {
        let mut settings = Settings::<Solid>::default();
        settings.relaxation = Relaxation::Steps(3);
        (settings.subdomains, settings.criterion) = (4, Criterion::Iterations);
        settings = settings.with_method(
            nndd::Method::NewtonNn(nndd::NewtonSettings::default()).with_max_iterations(iterations),
        );
        let found = solve(half_open(4).unwrap(), &settings, &mut Silent).unwrap();
        assert!(
            found.is_certified(),
            "{iterations} {:?} {:?} {:?}",
            found.nndd.status,
            found.no_estimate,
            found.estimate.map(|e| e.admissibility)
        );
        let estimate = found.estimate.as_ref().unwrap();
        let bound = estimate.unchecked();
        let distance: f64 = found
            .problem
            .bodies
            .iter()
            .zip(&exact_fields)
            .zip(&estimate.pair.bodies)
            .map(|((body, u), pair)| fem_core::norm::energy_distance_squared(body, u, &pair.displacement))
            .sum();
        assert!(bound.eta_nndd >= distance.sqrt() * (1.0 - 1e-9));
        assert!(bound.e_cre >= distance.sqrt());
        before = before.min(bound.e_cre);
    }
    assert!(before < 0.4);
}

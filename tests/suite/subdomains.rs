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
fn bodies_without_loads_and_a_gap_apart_have_no_error() {
    let mut problem = half_open(3).unwrap().with_factors(&|_, _| 0.0, &|_| 1.0).unwrap();
    let gaps = vec![0.01; problem.node_pairs()];
    problem.contacts[0].interface.replace_gaps(&gaps);
    let found = converged(problem, 4, Relaxation::NONE);
    let bound = found.estimate.as_ref().unwrap().unchecked();
    assert_eq!([bound.e_cre, bound.eta_nndd], [0.0, 0.0]);
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

#[test]
fn the_field_of_a_floating_body_in_subdomains_is_that_of_the_body_but_for_a_motion() {
    let problem = || of_case("stack.toml", 4, 8).unwrap();
    let whole = PreparedProblem::new(problem()).unwrap();
    let body = &whole.problem().bodies[1];
    // Its own loads taken away, and forces from the centre outwards: they have neither resultant nor moment.
    let nodes = body.mesh().points();
    let centre = nodes.iter().sum::<nalgebra::Vector3<f64>>() / nodes.len() as f64;
    let own = fem_core::assembly::external_forces(body);
    let force = |(n, (own, x)): (usize, (&nalgebra::Vector3<f64>, &nalgebra::Vector3<f64>))| {
        (NodeId::new(n), 0.3 * (x - centre) - own)
    };
    let forces: Vec<_> = own.iter().zip(nodes).enumerate().map(force).collect();
    let expected = BodySolvers::new(&whole).unwrap().bodies()[1].displacement_from_nodal_forces(&forces);
    for count in [2, 3, 8, 27] {
        let cut = PreparedProblem::prepare(problem(), &[1, count], |_| true).unwrap();
        let found = BodySolvers::new(&cut).unwrap().bodies()[1].displacement_from_nodal_forces(&forces);
        let distance = fem_core::norm::energy_distance_squared(body, &found, &expected).sqrt();
        let size = fem_core::norm::energy_norm_squared(body, &expected).sqrt();
        assert!(distance < 1e-12 * size, "{count}: {distance} of {size}");
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

/// Solves a problem of a case with more and more subdomains: the bound is that of the bodies in one piece.
fn the_bound_stays(problem: impl Fn() -> ContactProblem<Solid>) -> CertifiedSolution<Solid> {
    let solved = |count: usize| converged(problem(), count, Relaxation::Steps(3));
    let whole = solved(1);
    for count in [2, 4, 8] {
        let found = solved(count);
        let [a, b] = [&found, &whole].map(|of| of.estimate.as_ref().unwrap().unchecked().e_cre);
        assert!((a / b - 1.0).abs() < 1e-8, "{count}: {a} {b}");
        let off = found.last().contact_force() / whole.last().contact_force() - 1.0;
        assert!(off.abs() < 1e-9, "{count}: {off}");
        assert_eq!(found.last().contact.active.as_slice(), whole.last().contact.active.as_slice());
        let [a, b] = [&found, &whole].map(|of| of.bounds.as_ref().unwrap().contact_force);
        if let (Ok(a), Ok(b)) = (a, b) {
            assert!((0..2).all(|k| (a[k] - b[k]).abs() < 1e-7 * b[1].abs()), "{count}: {a:?} {b:?}");
        }
    }
    whole
}

#[test]
fn the_bound_of_a_curved_pair_does_not_depend_on_the_number_of_subdomains() {
    let whole = the_bound_stays(|| of_case("press_fit.toml", 2, 12).unwrap());
    assert!(whole.problem.contacts[0].interface.has_bent_facets());
}

#[test]
fn the_bound_of_a_floating_body_does_not_depend_on_the_number_of_subdomains() {
    let whole = the_bound_stays(|| of_case("stack.toml", 4, 8).unwrap());
    let motions = whole.problem.bodies.iter().filter(|body| body.free_motion().is_some()).count();
    assert_eq!(motions, 1);
    // The printed one of section 14.
    let e_cre = whole.estimate.as_ref().unwrap().unchecked().e_cre;
    assert!((e_cre / 0.50275347 - 1.0).abs() < 1e-2, "{e_cre}");
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
    let least = bounded_at_every_iterate(|| half_open(4).unwrap());
    assert!(least < 0.4, "{least}");
    let least = bounded_at_every_iterate(|| of_case("stack.toml", 4, 8).unwrap());
    assert!(least < 0.51, "{least}");
}

/// Stops after 1 to 11 iterations, and compares the bounds with the distance from the discrete solution; returns the smallest bound.
fn bounded_at_every_iterate(problem: impl Fn() -> ContactProblem<Solid>) -> f64 {
    let exact = PreparedProblem::new(problem()).unwrap();
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
        let found = solve(problem(), &settings, &mut Silent).unwrap();
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
        assert!(
            bound.eta_nndd >= distance.sqrt() * (1.0 - 1e-9),
            "{iterations}: {} {distance}",
            bound.eta_nndd
        );
        assert!(bound.e_cre >= distance.sqrt());
        before = before.min(bound.e_cre);
    }
    before
}

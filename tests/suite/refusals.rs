//! Faults that invalidate a certificate, and least sizes of its allowances and intervals: each test is named after the fault it
//! would let pass.

use certified_contact::{CertifiedSolution, Criterion, Imposed, Settings, Silent, solve};
use cre_estimator::{
    AdmissiblePair, EquilibratedStress, Estimate, Relaxation, check, check_stress, estimate_with,
};
use fem_core::assembly::external_forces;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::field::stresses;
use fem_core::geometry::{Vector, norm};
use fem_core::interface::{ContactProblem, ContactState, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::norm::energy_norm_squared;
use fem_core::tensor::SymTensor2;
use tests::blocks::Blocks;
use tests::run::{certify, displacements, newton, prepare, solve_alone};
use tests::{paper, rings};

/// The converged pair of the paper's problem.
fn pair() -> (ContactProblem, AdmissiblePair) {
    let problem = paper::problem(paper::COARSE).unwrap();
    let prepared = prepare(&problem);
    let pair = certify(&prepared, &newton(&prepared).unwrap()).unwrap().pair;
    assert!(check(&problem, &pair).is_valid());
    (problem, pair)
}

/// Sliding arcs, whose line is bent and partly open.
fn bent() -> (ContactProblem, AdmissiblePair) {
    let problem = rings::sliding([(1.0, 0.3), (2.0, 0.2)], [0.003, -0.01], [12, 3]).unwrap();
    let prepared = prepare(&problem);
    let pair = certify(&prepared, &newton(&prepared).unwrap()).unwrap().pair;
    assert!(check(&problem, &pair).is_valid(), "{:?}", check(&problem, &pair));
    (problem, pair)
}

#[track_caller]
fn refused(problem: &ContactProblem, pair: &AdmissiblePair, name: &str) {
    let failed: Vec<_> = check(problem, pair).failed().collect();
    assert!(failed.iter().any(|(what, _)| *what == name), "{name} is not among {failed:?}");
}

#[test]
fn a_traction_that_jumps_between_triangles_is_refused() {
    let (problem, pair) = pair();
    for b in 0..2 {
        let topology = problem.bodies[b].mesh().topology();
        let forces = pair.bodies[b].equilibrated.facet_moments.as_flattened().iter().map(|m| norm(*m));
        let largest = forces.fold(0.0, f64::max);
        let inner = (0..topology.facets().len()).filter(|&e| !topology.is_boundary(FacetId::new(e)));
        for edge in inner.step_by(37) {
            let mut wrong = pair.clone();
            wrong.bodies[b].equilibrated.facet_moments[edge][0][1] += 1e-6 * largest;
            refused(&problem, &wrong, "traction_jump");
        }
    }
}

#[test]
fn a_shear_traction_on_a_roller_is_refused() {
    // In equilibrium everywhere, with a friction on the roller that the problem does not have.
    let steel = || LinearElastic::isotropic(2.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let mesh = || block([0.0; 2], [2.0, 1.0], [6, 3]).unwrap();
    let held = || {
        let pushed = BoundaryConditions::new().roller("left", 0.0).roller("bottom", 0.0);
        pushed.traction("top", [0.0.into(), (-0.1).into()])
    };
    let smooth = Body::new(mesh(), steel(), &held()).unwrap();
    for friction in [1e-7, 0.01] {
        let rough = held().traction("left", [0.0.into(), friction.into()]);
        let rough = Body::new(mesh(), steel(), &rough).unwrap();
        let fields = stresses(&rough, &solve_alone(&rough));
        let mut stress = EquilibratedStress::recover(&rough, fields, rough.facet_conditions().to_vec());
        assert!(check_stress(&rough, &stress).is_valid());
        stress.conditions = smooth.facet_conditions().to_vec();
        let found = check_stress(&smooth, &stress);
        assert!(found.failed().any(|(what, _)| what == "boundary_traction"), "{friction}: {found:?}");
    }
}

#[test]
fn a_displacement_off_its_roller_is_refused() {
    let (problem, pair) = pair();
    let body = &problem.bodies[0];
    let largest = pair.bodies[0].displacement.iter().map(|u| norm(*u)).fold(0.0, f64::max);
    let interface: Vec<NodeId> = problem.contacts[0].interface.pairs().iter().map(|p| p.nodes[0]).collect();
    let mut tried = 0;
    for (node, constraint) in body.node_constraints().iter().enumerate() {
        let [direction] = constraint.held.basis() else { continue };
        if interface.contains(&NodeId::new(node)) {
            continue;
        }
        let mut wrong = pair.clone();
        for c in 0..2 {
            wrong.bodies[0].displacement[node][c] += 1e-9 * largest * direction[c];
        }
        let failed: Vec<_> = check(&problem, &wrong).failed().map(|(what, _)| what).collect();
        assert!(failed.iter().any(|what| what.starts_with("imposed")), "node {node}: {failed:?}");
        tried += 1;
    }
    assert!(tried > 5);
}

#[test]
fn an_opening_that_is_not_that_of_the_displacements_is_refused() {
    let (problem, pair) = pair();
    let open = (0..pair.contacts[0].opening.len())
        .filter(|&k| pair.contacts[0].opening[k] > 0.0)
        .collect::<Vec<_>>();
    assert!(!open.is_empty());
    for k in open {
        // Less than there is, which would make the contact term smaller.
        let mut wrong = pair.clone();
        wrong.contacts[0].opening[k] = 0.0;
        refused(&problem, &wrong, "penetration");
    }
}

#[test]
fn an_opening_between_the_nodes_of_a_bent_line_that_is_not_that_of_the_displacements_is_refused() {
    let (problem, pair) = bent();
    let largest = pair.contacts[0].middle_opening.iter().copied().fold(0.0, f64::max);
    let wide = (0..pair.contacts[0].middle_opening.len())
        .filter(|&k| pair.contacts[0].middle_opening[k] > 0.1 * largest);
    let mut tried = 0;
    for k in wide {
        let mut wrong = pair.clone();
        wrong.contacts[0].middle_opening[k] = 0.0;
        refused(&problem, &wrong, "penetration");
        tried += 1;
    }
    assert!(tried > 0);
}

/// Two blocks of flat cells; the first one is moved away without strain, so that nothing but rounding is left.
fn moved(poisson: f64, [width, height]: [f64; 2]) -> (ContactProblem, Estimate) {
    let size = [6.0 * width, 4.0 * height];
    let steel = |nu| LinearElastic::isotropic(1.0, nu, Hypothesis::PlaneStrain).unwrap();
    let lifted = BoundaryConditions::new().displace("top", Some(1.0.into()), Some(0.5.into()));
    let upper = Body::new(block([0.0; 2], size, [6, 4]).unwrap(), steel(poisson), &lifted).unwrap();
    let mesh = block([0.0, -size[1]], size, [6, 4]).unwrap();
    let lower = Body::new(mesh, steel(0.3), &BoundaryConditions::new().fix("bottom")).unwrap();
    let gap = Gap::Given(0.0.into());
    let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &gap).unwrap();
    let problem = ContactProblem::between([upper, lower], interface);
    let prepared = prepare(&problem);
    let e = certify(&prepared, &newton(&prepared).unwrap()).unwrap();
    (problem, e)
}

/// Computes the error that rounding of the displacements may hide, by the model of `cre_estimator`: each term of a strain is off by
/// 32 ε; the stiffest direction turns this into a force, and the softest one carries it.
fn model(body: &Body, displacement: &[Vector]) -> f64 {
    let mesh = body.mesh();
    let triangles = mesh.cells().len();
    let of_triangle = |t: usize| {
        let c = mesh.corners(t);
        let lengths = [0, 1, 2].map(|k| norm(c[(k + 1) % 3] - c[k]));
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let perimeter: f64 = lengths.iter().sum();
        let flatness = (longest * longest / (4.0 * mesh.measure(t))).max(1.0);
        let stiffness = body.material(t).stiffness().amax();
        let unit = |s: SymTensor2| body.material(t).complementary(s, s);
        let softness = unit(SymTensor2::new(1.0, 0.0, 0.0))
            + unit(SymTensor2::new(0.0, 1.0, 0.0))
            + unit(SymTensor2::new(0.0, 0.0, 1.0));
        stiffness * stiffness * softness * perimeter * perimeter / (4.0 * mesh.measure(t)) * flatness.powi(3)
    };
    let sum: f64 = (0..triangles).map(of_triangle).sum();
    let largest = displacement.iter().map(|u| norm(*u)).fold(0.0, f64::max);
    32.0 * f64::EPSILON * largest * ((1.0 + (triangles as f64).ln()) * sum).sqrt()
}

#[test]
fn the_allowance_for_round_off_is_not_left_out() {
    let (problem, e) = moved(0.3, [1.0, 1.0]);
    let least = model(&problem.bodies[0], &e.pair.bodies[0].displacement);
    assert!(e.round_off >= 0.999 * least, "{} against {least}", e.round_off);
    assert!(e.unchecked().e_cre >= e.round_off);
}

#[test]
fn the_allowance_grows_with_the_stiffest_direction_on_the_softest() {
    for poisson in [0.4999, 0.499_999] {
        let (problem, e) = moved(poisson, [1.0, 1.0]);
        let least = model(&problem.bodies[0], &e.pair.bodies[0].displacement);
        assert!(e.round_off >= 0.999 * least, "{poisson}: {} against {least}", e.round_off);
    }
}

#[test]
fn the_allowance_grows_with_the_third_power_of_the_flatness() {
    for width in [20.0, 200.0] {
        let (problem, e) = moved(0.3, [width, 1.0]);
        let least = model(&problem.bodies[0], &e.pair.bodies[0].displacement);
        assert!(e.round_off >= 0.999 * least, "{width}: {} against {least}", e.round_off);
    }
}

#[test]
fn the_allowance_holds_the_work_of_the_pressure_on_a_penetration_that_passes_the_checks() {
    let problem = paper::problem(paper::COARSE).unwrap();
    let prepared = prepare(&problem);
    let iterate = newton(&prepared).unwrap();
    let mut fields = displacements(&prepared, &iterate);
    let (first, second) = fields.split_at_mut(1);
    let (first, second) = (&mut first[0], &second[0]);
    let pairs = problem.contacts[0].interface.pairs();
    let trace = pairs.iter().map(|p| norm(first[p.nodes[0]])).fold(0.0, f64::max);
    let depth = 0.5e-12 * trace;
    for pair in pairs {
        let node = &mut first[pair.nodes[0]];
        *node += depth * pair.normal;
    }
    let force = &iterate.contact.normal_reaction;
    let opening: Vec<f64> = iterate.opening.iter().map(|o| o - depth).collect();
    let state = ContactState::between([first, second], force, &opening);
    let e = estimate_with(&prepared, &state, Relaxation::Steps(2)).unwrap();
    assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
    let least = (2.0 * depth * force.iter().sum::<f64>()).sqrt();
    assert!(e.round_off >= 0.999 * least, "{} against {least}", e.round_off);
}

/// Two pressed blocks; the upper one is pulled at its left side as well.
fn pulled(traction: f64) -> ContactProblem {
    let steel = || LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let pushed = BoundaryConditions::new().displace("top", Some(0.0.into()), Some((-0.05).into()));
    let pushed = pushed.traction("left", [traction.into(), 0.0.into()]);
    let upper = Body::new(block([0.0; 2], [6.0, 4.0], [12, 8]).unwrap(), steel(), &pushed).unwrap();
    let mesh = block([0.0, -4.0], [6.0, 4.0], [12, 8]).unwrap();
    let lower = Body::new(mesh, steel(), &BoundaryConditions::new().fix("bottom")).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between([upper, lower], interface)
}

#[test]
fn an_imbalance_of_the_stress_is_measured_and_counts_twice() {
    const PART: f64 = 1e-9;
    let problem = pulled(0.01);
    let prepared = prepare(&problem);
    let iterate = newton(&prepared).unwrap();
    let fields = displacements(&prepared, &iterate);
    let state =
        ContactState::between([&fields[0], &fields[1]], &iterate.contact.normal_reaction, &iterate.opening);
    // The factorised bodies carry a load that differs a little from the problem's.
    let bound = |part: f64| {
        let mut other = prepared.clone();
        let changed = prepare(&pulled(0.01 * (1.0 + part)));
        for (b, body) in changed.bodies().iter().enumerate() {
            *other.whole_mut(b).unwrap() = body.whole().unwrap().clone();
        }
        estimate_with(&other, &state, Relaxation::Steps(2)).unwrap().unchecked().e_cre
    };
    let force = external_forces(&problem.bodies[0]);
    let alone = prepared.bodies()[0].whole().unwrap().displacement_from_nodal_forces(&[]);
    let free = prepare(&pulled(0.0));
    let unloaded = free.bodies()[0].whole().unwrap().displacement_from_nodal_forces(&[]);
    let work: f64 = force.iter().zip(&alone).zip(&unloaded).map(|((f, u), v)| f.dot(&(*u - *v))).sum();
    let residual = PART * work.sqrt();
    // Terms that are linear in the imbalance cancel.
    let added = 0.5 * (bound(PART) + bound(-PART)) - bound(0.0);
    let round_off = certify(&prepared, &iterate).unwrap().round_off;
    assert!(residual > 10.0 * round_off, "{residual} {round_off}");
    assert!(added >= 1.9 * residual - round_off, "{added} {residual}");
}

#[test]
fn an_imbalance_of_the_stress_of_eta_dis_is_measured_and_counts_twice() {
    let problem = pulled(0.0);
    let prepared = prepare(&problem);
    let iterate = newton(&prepared).unwrap();
    let fields = displacements(&prepared, &iterate);
    let inner = problem.bodies[0].mesh().points().iter().position(|p| *p == Vector::new(3.0, 2.0)).unwrap();
    let indicator = |part: f64| {
        let mut first = fields[0].clone();
        first[inner][0] += part;
        let state =
            ContactState::between([&first, &fields[1]], &iterate.contact.normal_reaction, &iterate.opening);
        estimate_with(&prepared, &state, Relaxation::Steps(2)).unwrap().unchecked().eta_dis
    };
    // Little enough to pass the checks.
    const PART: f64 = 3e-13;
    let mut moved = vec![Vector::zeros(); fields[0].len()];
    moved[inner][0] = PART;
    let residual = energy_norm_squared(&problem.bodies[0], &moved).sqrt();
    let added = 0.5 * (indicator(PART) + indicator(-PART)) - indicator(0.0);
    let round_off = certify(&prepared, &iterate).unwrap().round_off;
    assert!(residual > round_off, "{residual} {round_off}");
    assert!(added >= 1.9 * residual - round_off, "{added} {residual}");
}

/// Blocks of unequal stiffness after a few iterations, when the forces of the two bodies differ.
fn early(contrast: f64, iterations: usize) -> CertifiedSolution {
    let mut settings = Settings::default();
    settings.imposed = Imposed::First;
    settings.criterion = Criterion::Iterations;
    settings.method = settings.method.with_max_iterations(iterations);
    let found =
        solve(Blocks::half_open(contrast).cells(6).problem().unwrap(), &settings, &mut Silent).unwrap();
    assert!(found.is_certified());
    found
}

/// The forces of both bodies, their stiffnesses `1ᵀ S 1`, and `2∫ p o`.
fn force_data(found: &CertifiedSolution) -> ([f64; 2], [f64; 2], f64) {
    let prepared = prepare(&found.problem);
    let stiffness = [0, 1].map(|b: usize| {
        let body = prepared.bodies()[b].whole().unwrap();
        let mut force = vec![0.0; body.interface().len()];
        body.interface().apply_schur(&vec![1.0; body.interface().len()], &mut force);
        force.iter().sum::<f64>()
    });
    let last = found.last();
    let forces = [-last.reaction.iter().sum::<f64>(), last.contact.normal_reaction.iter().sum()];
    let contact = found.estimate.as_ref().unwrap().cre.by_contact_edge[0].iter().sum();
    (forces, stiffness, contact)
}

#[test]
fn the_contact_force_is_bounded_with_the_contact_term() {
    let mut counted = 0;
    for contrast in [0.05, 1.0, 20.0] {
        for iterations in 2..5 {
            let found = early(contrast, iterations);
            let (_, [s, t], contact) = force_data(&found);
            let e = found.estimate.as_ref().unwrap().unchecked().e_cre;
            let [low, high] = found.bounds.unwrap().contact_force.unwrap();
            let radius = 0.5 * (e * e + contact).sqrt() * (s * t / (s + t)).sqrt();
            if low > 0.0 {
                assert!(0.5 * (high - low) >= (1.0 - 1e-12) * radius, "{contrast}, {iterations}");
                counted += usize::from(contact > 1e-6 * e * e);
            }
        }
    }
    assert!(counted > 0, "no contact term, or no interval above zero");
}

#[test]
fn the_contact_force_is_shared_by_the_stiffness_of_the_other_body() {
    let mut counted = 0;
    for contrast in [0.05, 20.0] {
        for iterations in 2..5 {
            let found = early(contrast, iterations);
            let ([first, second], [s, t], _) = force_data(&found);
            let [low, high] = found.bounds.unwrap().contact_force.unwrap();
            // Virtual work of the least energy: the first body's force counts by the second one's stiffness.
            let mean = 0.5 * (second + (t * first + s * second) / (s + t));
            let wrong = 0.5 * (second + (s * first + t * second) / (s + t));
            if low > 0.0 {
                let centre = 0.5 * (low + high);
                assert!(
                    (centre - mean).abs() <= 1e-9 * mean.abs(),
                    "{contrast}, {iterations}: {centre} {mean}"
                );
                counted += usize::from((wrong - mean).abs() > 1e-6 * mean.abs());
            }
        }
    }
    assert!(counted > 0, "the two forces do not differ, or no interval is above zero");
}

#[test]
fn no_force_is_bounded_on_a_bent_line() {
    let problem = rings::sliding([(1.0, 0.3), (2.0, 0.2)], [0.003, -0.01], [12, 3]).unwrap();
    let found = solve(problem, &Settings::default(), &mut Silent).unwrap();
    assert!(found.is_certified());
    let bounds = found.bounds.unwrap();
    assert!(bounds.contact_force.is_err(), "{bounds:?}");
}

//! Bonded pairs against figures of an independent code (a prototype in Python: canonical problems), against one mesh of the whole, and the ways in which
//! bonds go wrong.

mod solids;

use crate::{BondResults, CertifiedSolution, ContactSpace, Settings, Silent, SolveError, solve};
use contact_geometry::{Contact, ContactNormal, Sides, paired};
use cre_estimator::Relaxation;
use fem_core::body::{Body, JoinError};
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::{Vector, norm};
use fem_core::interface::{BondError, Bonds, ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::space::{Plane, Space};

/// The paper's blocks on 18×9 cells each, without contact.
fn blocks(cells: [usize; 2]) -> Vec<Body> {
    let pressed = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("top", None, Some((-0.02).into()))
        .traction("right", [0.0.into(), 30.0.into()]);
    let held = BoundaryConditions::new().fix("bottom");
    vec![
        body([0.0, 1.0], [2.0, 1.0], cells, 2000.0, &pressed),
        body([0.0, 0.0], [2.0, 1.0], cells, 1000.0, &held),
    ]
}

fn body(origin: [f64; 2], size: [f64; 2], cells: [usize; 2], young: f64, on: &BoundaryConditions) -> Body {
    let material = LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap();
    Body::new(block(origin, size, cells).unwrap(), material, on).unwrap()
}

fn bonded(offset: [f64; 2]) -> Gap {
    Gap::Bonded { offset: Vector::from(offset) }
}

/// The numbers of two bodies, the names of their sides, and what is between them.
type Bond<S> = ([usize; 2], [&'static str; 2], Gap<S>);

fn contacts<S: Space>(pairs: &[Bond<S>]) -> Vec<Contact<S>> {
    let contact = |(k, (bodies, surfaces, gap)): (usize, &Bond<S>)| Contact {
        name: format!("pair {k}"),
        sides: Sides::Bodies {
            bodies: *bodies,
            surfaces: surfaces.map(str::to_owned),
            gap: gap.clone(),
            normal: ContactNormal::Averaged,
        },
        friction: None,
    };
    pairs.iter().enumerate().map(contact).collect()
}

fn problem(bodies: Vec<Body>, pairs: &[Bond<Plane>]) -> ContactProblem {
    paired(bodies, &contacts(pairs)).unwrap().problem
}

fn glued(offset: [f64; 2]) -> ContactProblem {
    problem(blocks([18, 9]), &[([0, 1], ["bottom", "top"], bonded(offset))])
}

/// The paper's blocks, bonded for x ≤ 1 and in contact beyond.
fn half_bonded(offset: [f64; 2]) -> ContactProblem {
    let mut bodies = blocks([18, 9]);
    for (b, side) in [(0, "bottom"), (1, "top")] {
        let edges = bodies[b].mesh().group(side).unwrap().to_vec();
        let is_left = |body: &Body, edge| body.mesh().facet_middle(edge)[0] < 1.0;
        let (left, right) = edges.into_iter().partition(|edge| is_left(&bodies[b], *edge));
        bodies[b].add_group("glued", left);
        bodies[b].add_group("touching", right);
    }
    let both = ["glued"; 2];
    problem(bodies, &[([0, 1], both, bonded(offset)), ([0, 1], ["touching"; 2], Gap::Touching)])
}

fn solved<S: ContactSpace>(problem: ContactProblem<S>, relaxation: Relaxation) -> CertifiedSolution<S> {
    let settings = Settings { relaxation, ..Settings::default() };
    let found = solve(problem, &settings, &mut Silent).unwrap();
    let failed: Vec<_> = found.estimate.as_ref().unwrap().admissibility.failed().collect();
    assert!(found.is_certified(), "{failed:?}");
    found
}

fn e_cre(problem: &ContactProblem, relaxation: Relaxation) -> f64 {
    let found = solved(problem.clone(), relaxation);
    found.estimate.unwrap().certificate().unwrap().e_cre
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} and not {expected}");
}

/// Compares with a canonical problem: `a(u, u)` of both blocks, and the bound by EET, after two steps and at its best.
#[track_caller]
fn agrees(problem: &ContactProblem, energies: [f64; 2], [eet, two, best]: [f64; 3]) -> CertifiedSolution {
    let found = solved(problem.clone(), Relaxation::NONE);
    let a = &found.results.as_ref().unwrap().energy_norm_squared;
    near(a[0], energies[0], 1e-11);
    near(a[1], energies[1], 1e-11);
    near(found.estimate.as_ref().unwrap().certificate().unwrap().e_cre, eet, 1e-9);
    // Two steps depend on the order of the stars, to 1 %; the last digits of the best are those of single precision.
    let found_two = e_cre(problem, Relaxation::Steps(2));
    assert!(best < found_two && found_two < 1.001 * two, "{found_two} {two}");
    near(e_cre(problem, Relaxation::Steps(1500)), best, 1e-7);
    found
}

/// Compares the force of the bond on the lower block.
#[track_caller]
fn pulls(found: &CertifiedSolution, x: f64, y: f64) {
    let results = found.results.as_ref().unwrap();
    let force = -results.contacts[0].resultant;
    near(force[0], x, 1e-8);
    near(force[1], y, 1e-8);
    for balance in &results.balance {
        assert!(norm(balance.force) < 1e-11 && balance.moment.abs() < 1e-11, "{balance:?}");
    }
}

#[test]
fn two_bonded_blocks_are_the_canonical_ones() {
    let bounds = [0.454405089241, 0.1752, 0.159136731331];
    let found = agrees(&glued([0.0; 2]), [0.586153564672, 0.38602213755], bounds);
    pulls(&found, 4.70822485, -25.82920321);
}

#[test]
fn an_offset_is_a_jump_of_the_displacement_and_not_of_the_stress() {
    let bounds = [0.419859388739, 0.1667, 0.151815081497];
    let found = agrees(&glued([0.002, -0.01]), [0.381766745629, 0.126061255427], bounds);
    pulls(&found, 2.91287994, -10.23125684);
    let fields = &found.estimate.as_ref().unwrap().pair.bodies;
    for pair in found.problem.contacts[0].interface.pairs() {
        let [upper, lower] = [0, 1].map(|b| fields[b].displacement[pair.nodes[b].index()]);
        assert!(norm(upper - lower - Vector::new(0.002, -0.01)) < 1e-16);
    }
}

#[test]
fn contact_goes_on_where_a_bond_ends() {
    let bounds = [0.568272100726, 0.2100, 0.189723263437];
    let found = agrees(&half_bonded([0.0; 2]), [0.741211288255, 0.349666711749], bounds);
    let contact = &found.results.as_ref().unwrap().contacts[1];
    near(contact.contact_force, 9.31779045067, 1e-10);
    assert_eq!(contact.active, 6);
}

#[test]
fn a_pair_within_a_body_is_solved_exactly_and_refused_by_the_iteration() {
    let settings = Settings::default().with_method(nndd::NnddSettings::default());
    let error = solve(half_bonded([0.0; 2]), &settings, &mut Silent).unwrap_err();
    assert!(matches!(error, SolveError::Nndd(nndd::NnddError::WithinABody { pair: 1 })), "{error}");
    // Two bodies that are bonded as a whole leave the iteration nothing to do.
    let found = solve(glued([0.0; 2]), &settings, &mut Silent).unwrap();
    assert!(found.is_certified(), "{:?}", found.nndd.status);
    let error = fem_core::prepared::PreparedProblem::new(glued([0.0; 2])).unwrap_err();
    assert!(matches!(error, fem_core::prepared::PrepareError::Bonded { pair: 0 }), "{error}");
}

#[test]
fn two_blocks_on_one_mesh_give_the_same_bound() {
    // The whole as one block of two materials, and the same from two blocks; a bond in the middle of a support as well.
    let whole = |split: bool| -> f64 {
        let held = || BoundaryConditions::new().fix("bottom").displace("left", Some(0.0.into()), None);
        let pulled = held().traction("right", [0.0.into(), 3.0.into()]);
        let cells = |x: usize| [x, 6];
        let bodies = match split {
            false => vec![body([0.0, 0.0], [2.0, 1.0], cells(12), 1000.0, &pulled)],
            true => vec![
                body([0.0, 0.0], [1.0, 1.0], cells(6), 1000.0, &held()),
                body(
                    [1.0, 0.0],
                    [1.0, 1.0],
                    cells(6),
                    1000.0,
                    &BoundaryConditions::new().fix("bottom").traction("right", [0.0.into(), 3.0.into()]),
                ),
            ],
        };
        let bond = ([0, 1], ["right", "left"], bonded([0.0; 2]));
        let pairs = if split { vec![bond] } else { vec![] };
        e_cre(&problem(bodies, &pairs), Relaxation::NONE)
    };
    near(whole(true), whole(false), 1e-12);
}

/// Four quarters of a block around a common corner, each bonded to its neighbours, with offsets `d` of the bonds in a circle.
fn quarters(offsets: [[f64; 2]; 4]) -> ContactProblem {
    let (fixed, free) = (BoundaryConditions::new().fix("bottom"), BoundaryConditions::new());
    let pulled = || BoundaryConditions::new().traction("top", [2.0.into(), 5.0.into()]);
    let quarter = |x: f64, y: f64, on: &BoundaryConditions| body([x, y], [1.0, 1.0], [4, 4], 1000.0, on);
    let bodies = vec![
        quarter(0.0, 0.0, &fixed),
        quarter(1.0, 0.0, if offsets == [[0.0; 2]; 4] { &fixed } else { &free }),
        quarter(1.0, 1.0, &pulled()),
        quarter(0.0, 1.0, &pulled()),
    ];
    let sides = [["right", "left"], ["top", "bottom"], ["left", "right"], ["bottom", "top"]];
    let pairs = [0, 1, 2, 3].map(|k: usize| ([k, (k + 1) % 4], sides[k], bonded(offsets[k])));
    problem(bodies, &pairs)
}

#[test]
fn four_bonded_quarters_are_one_block() {
    let on = BoundaryConditions::new().fix("bottom").traction("top", [2.0.into(), 5.0.into()]);
    let whole = problem(vec![body([0.0, 0.0], [2.0, 2.0], [8, 8], 1000.0, &on)], &[]);
    let (one, four) = (solved(whole, Relaxation::NONE), solved(quarters([[0.0; 2]; 4]), Relaxation::NONE));
    let energy =
        |of: &CertifiedSolution| of.results.as_ref().unwrap().energy_norm_squared.iter().sum::<f64>();
    near(energy(&four), energy(&one), 1e-12);
    let bound = |of: &CertifiedSolution| of.estimate.as_ref().unwrap().certificate().unwrap().e_cre;
    near(bound(&four), bound(&one), 1e-12);
    // Two quarters carry the loads of two others: the bonds between them carry all of the load.
    let carried = |k: usize| four.results.as_ref().unwrap().contacts[k].resultant;
    let sum = carried(1) - carried(3);
    assert!(norm(sum - Vector::new(4.0, 10.0)) < 1e-11, "{sum:?}");
}

#[test]
fn offsets_around_a_corner_add_up_to_zero_or_are_refused() {
    let closed = quarters([[0.01, 0.0], [0.0, 0.02], [-0.01, 0.01], [0.0, -0.03]]);
    assert!(solve(closed, &Settings::default(), &mut Silent).unwrap().is_certified());
    let open = quarters([[0.01, 0.0], [0.0, 0.02], [-0.01, 0.01], [0.0, -0.02]]);
    let error = solve(open, &Settings::default(), &mut Silent).unwrap_err();
    let SolveError::Bonds(BondError::Circle { distance, .. }) = error else { panic!("{error}") };
    near(distance, 0.01, 1e-12);
}

#[test]
fn supports_of_both_sides_differ_by_the_offset_or_are_refused() {
    let columns = |imposed: f64| {
        let on = |ux: f64| BoundaryConditions::new().fix("bottom").displace("right", Some(ux.into()), None);
        let upper = BoundaryConditions::new().displace("left", Some(imposed.into()), None).displace(
            "top",
            None,
            Some(0.01.into()),
        );
        let bodies = vec![
            body([0.0, 1.0], [1.0, 1.0], [3, 3], 1000.0, &upper),
            body([0.0, 0.0], [1.0, 1.0], [3, 3], 1000.0, &on(0.0).displace("left", Some(0.0.into()), None)),
        ];
        problem(bodies, &[([0, 1], ["bottom", "top"], bonded([0.003, 0.001]))])
    };
    assert!(solve(columns(0.003), &Settings::default(), &mut Silent).unwrap().is_certified());
    let error = solve(columns(0.0), &Settings::default(), &mut Silent).unwrap_err();
    let SolveError::Bonds(BondError::Join { source: JoinError::Supports { values, .. }, .. }) = error else {
        panic!("{error}")
    };
    assert!((values[0] - values[1]).abs() > 0.0029, "{values:?}");
}

#[test]
fn a_support_holds_its_own_side_of_a_bond() {
    // The upper block is held at its left side, and the lower block only by the bond there: its corner moves by -d.
    let found = solved(glued([0.002, -0.01]), Relaxation::NONE);
    let fields = &found.estimate.as_ref().unwrap().pair.bodies;
    let corner = found.problem.contacts[0].interface.pairs().iter();
    let corner = corner
        .min_by(|a, b| {
            let x = |pair: &fem_core::interface::NodePair| {
                found.problem.bodies[0].mesh().points()[pair.nodes[0]][0]
            };
            x(a).total_cmp(&x(b))
        })
        .unwrap();
    assert_eq!(fields[0].displacement[corner.nodes[0].index()][0], 0.0);
    near(fields[1].displacement[corner.nodes[1].index()][0], -0.002, 1e-12);
}

#[test]
fn bonded_bodies_are_held_together_or_not_at_all() {
    let pulled = BoundaryConditions::new().traction("top", [1.0.into(), 2.0.into()]);
    let bodies = |held: &BoundaryConditions| {
        vec![
            body([0.0, 1.0], [2.0, 1.0], [6, 3], 2000.0, &pulled),
            body([0.0, 0.0], [2.0, 1.0], [6, 3], 1000.0, held),
        ]
    };
    let bond = || [([0, 1], ["bottom", "top"], bonded([0.0; 2]))];
    let held = problem(bodies(&BoundaryConditions::new().fix("bottom")), &bond());
    assert!(crate::support(&held).unwrap().unresisted.is_none());
    assert!(solve(held, &Settings::default(), &mut Silent).unwrap().is_certified());
    let free = problem(bodies(&BoundaryConditions::new()), &bond());
    let error = solve(free, &Settings::default(), &mut Silent).unwrap_err();
    let SolveError::NotHeld { motion } = error else { panic!("{error}") };
    assert_eq!(motion.bodies.len(), 2);
}

#[test]
fn an_open_mouth_beside_a_bond_needs_room() {
    // The offset lifts the upper block by 0.01: contact beyond the bond is open there. The other way round it overlaps at the end of the bond.
    let found = solved(half_bonded([0.0, 0.01]), Relaxation::NONE);
    assert!(found.results.unwrap().contacts[1].min_opening >= 0.0);
    let error = solve(half_bonded([0.0, -0.01]), &Settings::default(), &mut Silent).unwrap_err();
    assert!(matches!(error, SolveError::Bonds(BondError::Interface { pair: 1, .. })), "{error}");
}

#[test]
fn sides_that_do_not_match_are_refined_in_common_and_bonded() {
    let mut bodies = blocks([18, 9]);
    bodies[1] = body([0.0, 0.0], [2.0, 1.0], [13, 7], 1000.0, &BoundaryConditions::new().fix("bottom"));
    let unmatched = problem(bodies, &[([0, 1], ["bottom", "top"], bonded([0.0; 2]))]);
    let found = solved(unmatched.clone(), Relaxation::Steps(20));
    // The energy of the exact solution is known to within the bounds of both.
    let matched = solved(glued([0.0; 2]), Relaxation::Steps(20));
    let [a, b] = [&found, &matched].map(|of| of.bounds.unwrap().potential_energy);
    assert!(a[0] <= b[1] && b[0] <= a[1], "{a:?} {b:?}");
    near(found.results.unwrap().contacts[0].resultant[1], 25.829, 0.02);
}

#[test]
fn finer_meshes_stay_bonded() {
    let adapt = crate::AdaptSettings::new(0.06);
    let found = crate::solve_adaptively(half_bonded([0.001, 0.0]), &Settings::default(), &adapt, &mut Silent)
        .unwrap();
    assert!(matches!(found.end, crate::AdaptiveEnd::TargetMet), "{:?}", found.end);
    assert!(found.history.len() > 1 && found.solution.is_certified());
    let bonds = Bonds::new(&found.solution.problem).unwrap().unwrap();
    assert_eq!(bonds.joined.bodies.len(), 1);
}

#[test]
fn the_largest_tension_is_that_of_a_bar() {
    let on = BoundaryConditions::new().displace("left", Some(0.0.into()), None).displace(
        "bottom",
        None,
        Some(0.0.into()),
    );
    let pulled = BoundaryConditions::new().traction("right", [7.0.into(), 0.0.into()]).displace(
        "bottom",
        None,
        Some(0.0.into()),
    );
    let bodies = vec![
        body([0.0, 0.0], [1.0, 1.0], [3, 3], 1000.0, &on),
        body([1.0, 0.0], [1.0, 1.0], [3, 3], 1000.0, &pulled),
    ];
    let found =
        solved(problem(bodies, &[([0, 1], ["right", "left"], bonded([0.5, 0.0]))]), Relaxation::Steps(50));
    let pair = &found.results.as_ref().unwrap().contacts[0];
    let Some(BondResults { max_tension, .. }) = &pair.bond else { panic!("{pair:?}") };
    near(*max_tension, 7.0, 1e-9);
    assert!(pair.bond.iter().flat_map(|bond| &bond.pressure).all(|p| (p + 7.0).abs() < 1e-8), "{pair:?}");
    near(pair.resultant[0], 7.0, 1e-12);
    // The loads do work on the offset: J(u) = −½ ∫ F·u − ½ F d.
    let [low, high] = found.bounds.unwrap().potential_energy;
    let compliance = (1.0 - 0.09) / 1000.0;
    let expected = -0.5 * 49.0 * compliance * 2.0 + 7.0 * 0.5;
    assert!(low <= expected + 1e-9 && expected - 1e-9 <= high, "{low} {expected} {high}");
}

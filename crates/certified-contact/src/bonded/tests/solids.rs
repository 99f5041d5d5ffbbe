//! Bonded solids: against one mesh of the whole, and against closed forms.

use super::{Bond, contacts, near, solved};
use crate::{AdaptSettings, CertifiedSolution, Settings, Silent, solve_adaptively};
use contact_geometry::paired_solids;
use cre_estimator::Relaxation;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::space::{Solid, Space};

type Vector = <Solid as Space>::Vector;
type Conditions = BoundaryConditions<Solid>;

fn brick(origin: [f64; 3], size: [f64; 3], cells: [usize; 3], poisson: f64, on: &Conditions) -> Body<Solid> {
    let material = LinearElastic::isotropic_solid(1000.0, poisson).unwrap();
    Body::new(cuboid(origin, size, cells).unwrap(), material, on).unwrap()
}

fn bonded(offset: [f64; 3]) -> Gap<Solid> {
    Gap::Bonded { offset: Vector::of(|k| offset[k]) }
}

fn problem(bodies: Vec<Body<Solid>>, pairs: &[Bond<Solid>]) -> ContactProblem<Solid> {
    paired_solids(bodies, &contacts(pairs)).unwrap().problem
}

fn e_cre(of: &CertifiedSolution<Solid>) -> f64 {
    of.estimate.as_ref().unwrap().certificate().unwrap().e_cre
}

fn energy(of: &CertifiedSolution<Solid>) -> f64 {
    of.results.as_ref().unwrap().energy_norm_squared.iter().sum()
}

fn pulled() -> Conditions {
    Conditions::default().traction("right", [0.0.into(), 1.0.into(), (-2.0).into()])
}

#[test]
fn two_bonded_bricks_are_one() {
    let held = Conditions::default().fix("left");
    let whole = brick([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], 0.3, &pulled().fix("left"));
    let one = solved(problem(vec![whole], &[]), Relaxation::NONE);
    let halves = |offset| {
        let first = brick([0.0; 3], [1.0; 3], [2; 3], 0.3, &held);
        let second = brick([1.0, 0.0, 0.0], [1.0; 3], [2; 3], 0.3, &pulled());
        problem(vec![first, second], &[([0, 1], ["right", "left"], bonded(offset))])
    };
    for offset in [[0.0; 3], [0.01, 0.02, -0.03]] {
        let two = solved(halves(offset), Relaxation::NONE);
        near(energy(&two), energy(&one), 1e-11);
        near(e_cre(&two), e_cre(&one), 1e-11);
        let results = two.results.as_ref().unwrap();
        let force = results.contacts[0].resultant;
        assert!((force - Vector::new(0.0, 1.0, -2.0)).norm() < 1e-11, "{force:?}");
        for balance in &results.balance {
            assert!(balance.force.norm() < 1e-11 && balance.moment.norm() < 1e-11, "{balance:?}");
        }
    }
}

#[test]
fn a_bar_between_walls_is_stretched_by_the_offset_of_a_bond() {
    let wall = |side: &str| Conditions::default().fix(side);
    for cells in [[2, 2, 2], [2, 3, 3]] {
        let bodies = vec![
            brick([0.0; 3], [1.0; 3], [2; 3], 0.0, &wall("left")),
            brick([1.0, 0.0, 0.0], [1.0; 3], cells, 0.0, &wall("right")),
        ];
        let bond = ([0, 1], ["right", "left"], bonded([0.006, 0.0, 0.0]));
        // Other cells on the second side: the surfaces are laid over each other.
        let found = solved(problem(bodies, &[bond]), Relaxation::Steps(30));
        let results = found.results.as_ref().unwrap();
        near(results.contacts[0].bond.as_ref().unwrap().max_tension, 3.0, 1e-6);
        near(results.contacts[0].resultant[0], 3.0, 1e-10);
        near(energy(&found), 2.0 * 9.0 / 1000.0, 1e-10);
        assert!(e_cre(&found) < 1e-6 * energy(&found).sqrt(), "{}", e_cre(&found));
    }
}

/// Two bricks on each other, bonded where x is below 1 and in contact beyond.
fn partly_bonded(held: &Conditions) -> ContactProblem<Solid> {
    let pressed = Conditions::default().traction("top", [1.0.into(), 0.0.into(), (-8.0).into()]);
    let mut bodies = vec![
        brick([0.0, 0.0, 1.0], [2.0, 1.0, 0.5], [4, 2, 1], 0.3, &pressed),
        brick([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], 0.3, held),
    ];
    for (b, side) in [(0, "bottom"), (1, "top")] {
        let faces = bodies[b].mesh().group(side).unwrap().to_vec();
        let (left, right) = faces.into_iter().partition(|face| bodies[b].mesh().facet_middle(*face)[0] < 1.0);
        bodies[b].add_group("glued", left);
        bodies[b].add_group("touching", right);
    }
    let offset = bonded([0.0, 0.0, 0.001]);
    problem(bodies, &[([0, 1], ["glued"; 2], offset), ([0, 1], ["touching"; 2], Gap::Touching)])
}

#[test]
fn reactions_balance_the_loads_where_clamped_nodes_are_in_contact_within_a_bonded_body() {
    // The clamp ends at nodes of the contact.
    let found = solved(partly_bonded(&Conditions::default().fix("right")), Relaxation::NONE);
    let results = found.results.as_ref().unwrap();
    assert!(results.contacts[1].contact_force > 0.1, "{:?}", results.contacts[1]);
    let sum: Vector = results.reactions.iter().map(|reaction| reaction.force).sum();
    assert!((sum - Vector::new(-2.0, 0.0, 16.0)).norm() < 1e-10, "{sum:?}");
}

#[test]
fn contact_of_solids_goes_on_where_a_bond_ends_and_finer_meshes_stay_bonded() {
    let coarse = solved(partly_bonded(&Conditions::default().fix("bottom")), Relaxation::Steps(4));
    let contact = &coarse.results.as_ref().unwrap().contacts[1];
    assert!(contact.contact_force > 0.1 && contact.active > 0, "{contact:?}");
    let mut adapt = AdaptSettings::new(1e-3);
    adapt.max_steps = 2;
    let fine = solve_adaptively(coarse.problem.clone(), &Settings::default(), &adapt, &mut Silent).unwrap();
    assert!(fine.history.len() == 2 && fine.solution.is_certified(), "{:?}", fine.end);
    let [a, b] = [&coarse, &fine.solution].map(|of| of.bounds.unwrap().potential_energy);
    assert!(a[0] <= b[1] && b[0] <= a[1] && b[1] < a[1], "{a:?} {b:?}");
}

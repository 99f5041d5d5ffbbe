//! Random assemblies: which are held, and the exact solution against Clarabel.

use contact_qp::{QpMethod, QpSettings};
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::{ContactInterface, ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::norm::energy_norm_squared;
use nndd::{NnddError, solve_exactly, support};
use tests::prepare;
use tests::random::Random;

/// What acts on the top block of a pile.
#[derive(Clone, Copy)]
struct Load {
    /// Where the resultant acts, along the width of 2, and its size downwards.
    at: f64,
    down: f64,
    /// On the left side of a floating block.
    sideways: f64,
}

/// Two to five blocks of 2 × 1 on top of each other, the lowest one clamped, all others held by contact only.
fn pile(random: &mut Random, load: Load) -> ContactProblem {
    let count = 2 + (4.0 * random.unit()) as usize;
    let body = |k: usize, random: &mut Random| {
        let young = 10f64.powf(1.0 + 2.5 * random.unit());
        let material =
            LinearElastic::isotropic(young, 0.45 * random.unit(), Hypothesis::PlaneStrain).unwrap();
        let mut conditions = BoundaryConditions::new();
        if k == 0 {
            conditions = conditions.fix("bottom");
        }
        if k == count - 1 {
            // A linear pressure with this resultant: on the width of 2 its moment about the middle is 2/3 of its slope.
            let (mean, slope) = (0.5 * load.down, 1.5 * load.down * (load.at - 1.0));
            let pressure = ScalarData::function(move |x| -(mean + slope * (x[0] - 1.0)));
            conditions = conditions.traction("top", [0.0.into(), pressure]);
        }
        if k == 1 && load.sideways != 0.0 {
            conditions = conditions.traction("left", [load.sideways.into(), 0.0.into()]);
        }
        Body::new(block([0.0, k as f64], [2.0, 1.0], [6, 3]).unwrap(), material, &conditions).unwrap()
    };
    let bodies: Vec<Body> = (0..count).map(|k| body(k, random)).collect();
    let gap = Gap::Given(0.0.into());
    let interfaces: Vec<ContactInterface> = (1..count)
        .map(|k| ContactInterface::pair(&bodies[k], &bodies[k - 1], ["bottom", "top"], &gap).unwrap())
        .collect();
    let problem = ContactProblem::new(bodies);
    interfaces.into_iter().enumerate().fold(problem, |all, (k, interface)| all.contact([k + 1, k], interface))
}

/// A load that the contacts can carry.
fn carried(random: &mut Random) -> Load {
    Load { at: 0.02 + 1.96 * random.unit(), down: 0.1 + 10.0 * random.unit(), sideways: 0.0 }
}

#[test]
fn two_hundred_assemblies_that_contact_holds_are_accepted() {
    let mut random = Random::new(15);
    for k in 0..200 {
        let load = carried(&mut random);
        let found = support(&pile(&mut random, load)).unwrap();
        assert!(found.unheld.is_none(), "{k}, at {}: {:?}", load.at, found.unheld);
        // Each floating block can slide.
        assert!(!found.free_motions.is_empty());
    }
}

#[test]
fn two_hundred_assemblies_that_nothing_holds_are_refused() {
    let mut random = Random::new(16);
    for k in 0..200 {
        let mut load = carried(&mut random);
        match k % 3 {
            // Beside the block, pulled, or pushed to the side.
            0 => load.at = if random.unit() < 0.5 { -0.02 - random.unit() } else { 2.02 + random.unit() },
            1 => load.down = -load.down,
            _ => load.sideways = 0.01 + random.unit(),
        }
        let problem = pile(&mut random, load);
        let motion = support(&problem).unwrap().unheld;
        let motion = motion.unwrap_or_else(|| panic!("{k}: at {}, {} down", load.at, load.down));
        assert!(motion.load > 0.0 && !motion.bodies.is_empty());
        let largest = motion.bodies.iter().flat_map(|(b, motion)| motion.displacements(&problem.bodies[*b]));
        let largest = largest.map(|u| u.norm()).fold(0.0, f64::max);
        assert!((largest - 1.0).abs() < 1e-9, "{k}: {largest}");
        if k < 30 {
            let refused = solve_exactly(&prepare(&problem), &QpSettings::default());
            assert!(matches!(refused, Err(NnddError::NotHeld { .. })));
        }
    }
}

#[test]
fn five_hundred_exact_solutions_agree_with_an_interior_point_method() {
    let mut random = Random::new(17);
    let mut without = 0;
    for k in 0..500 {
        let load = carried(&mut random);
        let prepared = prepare(&pile(&mut random, load));
        let found = solve_exactly(&prepared, &QpSettings::default()).unwrap();
        let judge = solve_exactly(&prepared, &QpSettings::default().with_method(QpMethod::Clarabel)).unwrap();
        assert!(found.status.is_solved() && judge.status.is_solved(), "{k}");
        assert!(found.kkt.max() < 1e-10, "{k}: {:?}", found.kkt);
        without += usize::from(found.clarabel_calls == 0);
        let energies = |u: &[Vec<fem_core::geometry::Vector>]| -> Vec<f64> {
            prepared.problem().bodies.iter().zip(u).map(|(b, u)| energy_norm_squared(b, u)).collect()
        };
        let (a, b) = (energies(&found.displacement), energies(&judge.displacement));
        let size: f64 = b.iter().sum();
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1e-6 * size), "{k}: {a:?} {b:?}");
        for (p, q) in found.contact_force.iter().flatten().zip(judge.contact_force.iter().flatten()) {
            assert!((p - q).abs() <= 1e-6 * load.down, "{k}: {p} {q}");
        }
    }
    println!("{without} of 500 without Clarabel");
    assert!(without >= 480, "{without}");
}

//! Every certificate rests on a stress in exact equilibrium and a pair that is exactly admissible.

use crate::check;
use crate::model::{Motion, models};
use cre_estimator::Relaxation;
use proptest::prelude::*;
use tests::prepare;
use tests::random::Random;
use tests::run::{cell_imbalance, certify_with, pair_of};

#[test]
fn stresses_are_in_equilibrium_and_pairs_admissible_whatever_lambda() {
    let lambdas = (-4.0..0.0f64, any::<u64>(), 0usize..4, -3.2..3.2f64);
    check("equilibrium", 1000, &(models(), lambdas), |(model, (size, seed, steps, angle))| {
        let problem = model.problem(&Motion { angle, ..Motion::NONE });
        let prepared = prepare(&problem);
        let mut random = Random::new(seed);
        let lambda = problem.contacts[0]
            .interface
            .pairs()
            .iter()
            .map(|_| 10f64.powf(size) * random.signed())
            .collect();
        let iterate = pair_of(&prepared, lambda).unwrap();
        let e = certify_with(&prepared, &iterate, Relaxation::Steps(steps)).unwrap();
        let a = e.admissibility;
        prop_assert!(a.is_valid(), "{a:?}");
        prop_assert!(
            a.equilibrium <= 1e-10 && a.traction_jump <= 1e-10 && a.boundary_traction <= 1e-10,
            "{a:?}"
        );
        // Of the turned coordinates nothing but round-off is left.
        prop_assert!(a.penetration <= 1e-12 && a.pressure_sign == 0.0, "{a:?}");
        prop_assert!(e.cre.split_defect() < 1e-12, "{:e}", e.cre.split_defect());
        // Once more by other means: force and moment of every cell.
        for b in 0..2 {
            let [force, moment] = cell_imbalance(&problem.bodies[b], &e.pair.bodies[b].equilibrated);
            prop_assert!(force < 1e-10 && moment < 1e-10, "body {b}: {force:e} {moment:e}");
        }
        for (o, r) in iterate.opening.iter().zip(&iterate.contact.normal_reaction) {
            prop_assert!(*o >= 0.0 && *r >= 0.0 && o * r == 0.0, "opening {o}, force {r}");
        }
        Ok(())
    });
}

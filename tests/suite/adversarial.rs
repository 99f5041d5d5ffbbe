//! Attempts to prove bounds wrong: a sample of `cargo xtask reproduce adversarial`.

use tests::adversarial::Family;
use tests::run::{certify_with, condense_both, newton};
use tests::signorini;
use tests::trial::Trial;
use tests::witness::{Ladder, Law};

/// Random problems of each family.
const SAMPLE: u64 = 3;

fn trials() -> impl Iterator<Item = (Family, Trial)> {
    let members = Family::ALL.into_iter().flat_map(|family| (1000..1000 + SAMPLE).map(move |n| (family, n)));
    members.filter_map(|(family, n)| Trial::new(family, n).unwrap().map(|trial| (family, trial)))
}

#[test]
fn a_bound_below_the_error_is_refuted() {
    // The witness must see a tenth: four times finer meshes leave a sixteenth of the squared error.
    let problem = signorini::problem([(1.0, 0.3), (2.0, 0.2)], 0.0, [8, 4]).unwrap();
    let bodies = condense_both(&problem);
    let iterate = newton(&problem, &bodies).unwrap();
    let e = certify_with(&problem, &bodies, &iterate, cre_estimator::Relaxation::Steps(30)).unwrap();
    let ladder = Ladder::new(&problem, 2).unwrap();
    let finer = condense_both(ladder.finest());
    let w = tests::displacements(&finer, &newton(ladder.finest(), &finer).unwrap());
    let v = &e.pair.displacement;
    let witness = ladder.witness([&v[0], &v[1]], [&w[0], &w[1]], Law::Everywhere).unwrap();
    assert!(!witness.refutes(e.e_cre), "{} against {}", e.e_cre, witness.error());
    assert!(witness.refutes(0.9 * e.e_cre), "{} against {}", e.e_cre, witness.error());
    assert!(witness.refutes(f64::NAN));
}

#[test]
fn no_finer_field_refutes_a_bound_of_a_random_problem() {
    let mut count = 0;
    for (family, trial) in trials() {
        let [two, default, _, norm, energy, force] = trial.violations;
        assert!(!(two || default || norm || energy || force), "{}: {trial:?}", family.name());
        count += usize::from(trial.error.is_some());
    }
    assert!(count as u64 > 11 * SAMPLE, "only {count} problems were tried");
}

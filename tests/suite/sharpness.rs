//! Hard materials and cells: by default the bound is as sharp as promised.

use cre_estimator::Relaxation;
use tests::run::{certify_with, displacements, newton, prepare};
use tests::sharp::Sharp;

#[test]
fn the_default_relaxation_is_sharp_on_hard_problems() {
    for sharp in Sharp::ALL {
        let problem = sharp.problem().unwrap();
        let prepared = prepare(&problem);
        let iterate = newton(&prepared).unwrap();
        let [_, error] = sharp.norm_and_error(&problem, &displacements(&prepared, &iterate));
        let effectivity =
            |relaxation| certify_with(&prepared, &iterate, relaxation).unwrap().unchecked().e_cre / error;
        let default = effectivity(Relaxation::default());
        let relaxed = effectivity(Relaxation::Steps(300));
        println!("{}: e_CRE/error {default:.3}, fully relaxed {relaxed:.3}", sharp.name());
        assert!(relaxed >= 1.0, "{}: {relaxed}", sharp.name());
        assert!(default <= (1.1 * relaxed).max(2.0), "{}: {default}, fully relaxed {relaxed}", sharp.name());
    }
}

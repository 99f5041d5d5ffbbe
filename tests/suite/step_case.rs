//! Load steps in case files.

use case_io::{Case, CaseError};

const SHEAR: &str = include_str!("../cases/shear.toml");

fn faults(text: &str) -> String {
    let error: CaseError = Case::parse(text, "case.toml", &[]).unwrap_err();
    error.to_string()
}

#[test]
fn increments_are_linear_from_the_factor_before() {
    let case = Case::parse(SHEAR, "shear.toml", &[]).unwrap();
    let increments = case.increments();
    assert_eq!(increments.len(), 51);
    let of = |k: usize, name: &str| increments[k].of(Some(name));
    // The press is whole from the first step on; the push comes, turns, and comes again.
    assert!((0..51).all(|k| of(k, "press") == 1.0 && increments[k].of(None) == 1.0));
    assert_eq!([of(0, "push"), of(10, "push"), of(30, "push"), of(50, "push")], [0.0, 1.0, -1.0, 1.0]);
    assert!((of(1, "push") - 0.1).abs() < 1e-15 && (of(12, "push") - 0.8).abs() < 1e-15);
    // A name that no step has named yet acts not at all.
    assert_eq!(increments[0].of(Some("later")), 0.0);
    let body = &case.bodies[0];
    let place =
        |index| fem_core::body::ConditionPlace { list: fem_core::body::ConditionList::Displacement, index };
    assert_eq!([body.condition_name(place(0)), body.condition_name(place(1))], [Some("press"), Some("push")]);
    assert_eq!(body.condition_name(place(2)), None);
}

#[test]
fn wrong_steps_are_refused_with_their_place() {
    for (from, to, said) in [
        ("push = -1.0", "pull = -1.0", "no condition and no contact is called \"pull\""),
        ("push = -1.0", "push = nan", "the factor of \"push\" is not a finite number"),
        ("push = -1.0", "push = \"x\"", "the factor of \"push\" is not a finite number"),
        ("factors = { push = -1.0 }", "factors = {}", "this step names no condition"),
        ("factors = { push = -1.0 }\n", "", "`step.2.factors` is missing"),
        ("count   = 10", "count   = 0", "`step.1.count` is 0"),
        ("count   = 10", "count   = 20000", "the steps have 20041 increments together"),
        ("count   = 10", "cuont   = 10", "unknown key `cuont`"),
    ] {
        let text = SHEAR.replacen(from, to, 1);
        assert_ne!(text, SHEAR, "{from}");
        let found = faults(&text);
        assert!(found.contains(said), "{to}:\n{found}");
        assert!(found.contains("case.toml:"), "{found}");
    }
    // A condition that no step names has no effect, and that is probably not meant.
    let named = SHEAR.replacen(
        "[[step]]",
        "[[body.traction]]\nname = \"weight\"\non = \"top\"\npressure = 1.0\n[[step]]",
        1,
    );
    let warnings = Case::parse(&named, "case.toml", &[]).unwrap().warnings();
    assert!(warnings.iter().any(|w| w.message.contains("no load step names the condition \"weight\"")));
    assert!(Case::parse(SHEAR, "case.toml", &[]).unwrap().warnings().is_empty());
    // Names without any step are fine: all conditions then act whole.
    let (without, _) = SHEAR.split_once("[[step]]").unwrap();
    assert!(Case::parse(without, "case.toml", &[]).unwrap().increments().is_empty());
}

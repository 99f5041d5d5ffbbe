//! Lengths, moduli and loads beyond all use: a status and a reason, never a defect, and never NaN or an infinite number.

use super::*;

/// Two blocks, one on the other.
///
/// * `load`: a condition on the top of the upper one.
fn blocks(length: f64, young: [f64; 2], load: &str) -> String {
    let (a, b) = (young[0], young[1]);
    format!(
        "schema = 1\n[materials.a]\nyoung = {a:e}\npoisson = 0.3\n[materials.b]\nyoung = {b:e}\npoisson = 0.3\n\
         [[body]]\nname = \"upper\"\nmaterial = \"a\"\n\
         generator = {{ kind = \"block\", origin = [0.0, {length:e}], size = [{0:e}, {length:e}], cells = [4, 3] }}\n\
         {load}\n\
         [[body]]\nname = \"lower\"\nmaterial = \"b\"\n\
         generator = {{ kind = \"block\", origin = [0.0, 0.0], size = [{0:e}, {length:e}], cells = [4, 3] }}\n\
         [[body.displacement]]\non = \"bottom\"\nux = 0.0\nuy = 0.0\n\
         [[contact]]\nbodies = [\"upper\", \"lower\"]\nsurfaces = [\"bottom\", \"top\"]\n",
        2.0 * length
    )
}

fn pushed(by: f64) -> String {
    format!("[[body.displacement]]\non = \"top\"\nux = 0.0\nuy = {by:e}")
}

fn loaded(by: f64, body_force: f64) -> String {
    format!(
        "body_force = [0.0, {body_force:e}]\n[[body.traction]]\non = \"top\"\nvector = [0.0, {by:e}]\n\
         [[body.displacement]]\non = \"left\"\nux = 0.0"
    )
}

/// Checks and solves; the exit statuses.
fn statuses(case: &str) -> ([Option<i32>; 2], String) {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("case.toml");
    std::fs::write(&file, case).unwrap();
    let checked = nndd(temp.path()).args(["check", "case.toml"]).output().unwrap();
    let out = temp.path().join("out");
    let solved = solve(&file, &out, &[]);
    let text = said(&checked) + &said(&solved);
    if solved.status.code() == Some(0) {
        let certificate = report(&out).certificate.unwrap();
        assert!(certificate.valid && certificate.e_cre.unwrap() >= 0.0, "{text}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }
    ([checked.status.code(), solved.status.code()], text)
}

#[test]
fn lengths_of_which_cubes_overflow_are_refused_with_their_place() {
    for length in
        [1e101, 1e103, 1e108, 1e109, 1e120, 1e153, 1e160, 1e300, 1e-101, 1e-108, 1e-154, 1e-160, 1e-300]
    {
        let (codes, text) = statuses(&blocks(length, [1.0, 10.0], &pushed(-0.01 * length)));
        assert_eq!(codes, [Some(3); 2], "{length:e}: {text}");
        let told =
            ["case.toml:11:13", "expected lengths whose cubes are numbers too", "the unit of the lengths"];
        assert!(told.iter().all(|told| text.contains(told)), "{length:e}: {text}");
    }
    for length in [1e96, 1e30, 1e-30, 1e-98] {
        let (codes, text) = statuses(&blocks(length, [1.0, 10.0], &pushed(-0.01 * length)));
        assert_eq!(codes, [Some(0); 2], "{length:e}: {text}");
    }
}

#[test]
fn data_of_any_size_are_solved_or_refused() {
    // Each ended as a defect with NaN in the report or in a programme.
    let cases = [
        blocks(2.6e96, [5.4e94; 2], &pushed(-2.6e94)),
        blocks(8.8e60, [4.5e-65, 4.5e-60], &loaded(-1.2e211, 0.0)),
        blocks(1.0, [1.0, 10.0], &loaded(-1.0, -7.9e307)),
        blocks(1.0, [1e-300, 1e300], &pushed(-0.01)),
        blocks(1.0, [1e300; 2], &pushed(-0.01)),
        blocks(1e-60, [1e-60; 2], &loaded(-1e-200, 0.0)),
        blocks(1.0, [1.0; 2], &pushed(-1e200)),
    ];
    for case in &cases {
        let (codes, text) = statuses(case);
        assert!(
            codes.iter().all(|code| [0, 3, 4, 5, 6].map(Some).contains(code)),
            "{codes:?} {case}\n{text}"
        );
        if codes[1] == Some(3) {
            assert!(
                text.contains("expected") && (text.contains("fix: ") || text.contains("help: ")),
                "{text}"
            );
        }
    }
}

//! Numbers written in ways that TOML does not accept, and words without quotes.

use super::*;

/// Returns the single fault of the minimal case with one text replaced by another.
fn fault(from: &str, to: &str) -> String {
    let text = minimal("");
    assert!(text.contains(from));
    only(Case::parse(&text.replacen(from, to, 1), "c.toml", &[]))
}

fn only(read: Result<Case, crate::CaseError>) -> String {
    let error = read.unwrap_err();
    assert_eq!(error.diagnostics.len(), 1, "{error}");
    error.to_string()
}

const UNIT: &str = "write it without unit: 2000 (all units must agree)";

#[test]
fn a_number_with_a_unit_a_percent_sign_or_a_foreign_exponent_is_told_how_to_write_it() {
    for (value, help) in [
        ("2000.0 MPa", "write it without unit: 2000.0 (all units must agree)"),
        ("2000MPa  # a steel", UNIT),
        ("2000 [N/mm^2]", UNIT),
        ("40%", "write the fraction: 0.4"),
        ("2D3", "Fortran exponent: write 2E3"),
        ("2,5", "decimal comma: write 2.5"),
        ("2 000", "write the digits together: 2000"),
        ("2*10^3", "write the power of ten with E: 2E3"),
        ("“2000”", "write 2000 without quotes"),
        ("\u{2212}5", "the dash is not a minus sign: write -5"),
        ("2000,", "take the sign behind it out: write 2000"),
    ] {
        let found = fault("young = 1.0", &format!("young = {value}"));
        let shown = value.split("  #").next().unwrap();
        let expected = format!("c.toml:3:9: `{shown}` is not a number; expected a number; help: {help}");
        assert_eq!(found, expected);
    }
    // The same for other keys, and in arrays, inline tables and arrays over several lines.
    let of = |line: &str| only(Case::parse(&minimal(line), "c.toml", &[]));
    assert!(of("[solver]\ntheta = 40%").starts_with("c.toml:16:9: `40%` is not a number"));
    assert!(of("gap = 2000 mm").ends_with(UNIT));
    assert!(of("normal = [0, 2000 mm]").starts_with("c.toml:15:14: `2000 mm` is not a number"));
    assert!(of("gap = { x = 0,5 }").starts_with("c.toml:15:13: `0,5` is not a number"));
    assert!(
        fault("size = [1, 1]", "size = [\n 1,\n 2000 mm]")
            .starts_with("c.toml:10:2: `2000 mm` is not a number")
    );
}

#[test]
fn each_line_with_a_wrong_number_is_told() {
    let text = minimal("").replace("young = 1.0\npoisson = 0.0", "young = 2 GPa\npoisson = 30 %");
    let error = Case::parse(&text, "c.toml", &[]).unwrap_err();
    let places: Vec<String> =
        error.diagnostics.iter().map(|d| d.place.as_ref().unwrap().to_string()).collect();
    assert_eq!(places, ["c.toml:3:9", "c.toml:4:11"], "{error}");
}

#[test]
fn numbers_in_quotes_and_on_the_command_line_are_told_the_same() {
    for (value, help) in
        [("2000 MPa", UNIT), ("40%", "write the fraction: 0.4"), ("2D3", "Fortran exponent: write 2E3")]
    {
        let set = ("materials.m.young".to_owned(), value.to_owned());
        let of_command_line = only(Case::parse(&minimal(""), "c.toml", &[set]));
        let of_file = fault("young = 1.0", &format!("young = \"{value}\""));
        let words = format!(
            "`materials.m.young` is the string \"{value}\", which is not a number; expected a number; help: {help}"
        );
        assert_eq!(of_command_line, format!("--set materials.m.young={value}: {words}"));
        assert_eq!(of_file, format!("c.toml:3:9: {words}"));
    }
    let set = |key: &str, value: &str| {
        only(Case::parse(&minimal(""), "c.toml", &[(key.to_owned(), value.to_owned())]))
    };
    assert!(set("solver.theta", "0,4").ends_with("help: decimal comma: write 0.4"));
    assert!(set("contact.gap", "0,1").ends_with("expected a number, or an expression in x and y; or the word \"geometric\" alone; help: decimal comma: write 0.1"));
    assert!(set("contact.gap", "2000 mm").ends_with(UNIT));
    assert!(set("body.0.generator.size", "[2000 mm, 1]").ends_with(UNIT));
    assert!(set("solver.theta", "“0.4”").ends_with("help: write 0.4 without quotes"));
    assert!(set("solver.max_iterations", "1e2").ends_with("help: write 100, without point or exponent"));
    let over = crate::case_file::Sweep::parse("solver.theta=0,1:0,9:0,1").unwrap_err().to_string();
    assert!(over.contains("`0,1` is not a finite number: decimal comma: write 0.1"), "{over}");
    let over = crate::case_file::Sweep::parse("solver.theta=[0.1, 40%]").unwrap_err().to_string();
    assert!(over.contains("`40%` is not a number: write the fraction: 0.4"), "{over}");
}

#[test]
fn numbers_that_toml_spells_otherwise_are_told_its_spelling() {
    for (value, toml) in [(".5", "0.5"), ("5.", "5.0"), ("007", "7"), ("1.e3", "1.0e3")] {
        let found = fault("young = 1.0", &format!("young = {value}"));
        assert!(
            found.starts_with(&format!("c.toml:3:9: `{value}` is not a number of TOML; expected digits")),
            "{found}"
        );
        assert!(found.ends_with(&format!("help: write {toml}")), "{found}");
    }
    assert!(
        fault("size = [1, 1]", "size = [1,0, 0,5]")
            .ends_with("help: decimals have a point: [0.5, 1.5], not [0,5, 1,5]")
    );
    assert!(fault("young = 1.0", "young = 1.2.3").starts_with("c.toml:3:9: `1.2.3` is not a number"));
    assert!(
        fault("young = 1.0", "young = NaN")
            .starts_with("c.toml:3:9: `NaN` is not a number; expected a finite")
    );
    assert!(
        fault("young = 1.0", "young =")
            .starts_with("c.toml:3:8: `young` has no value; expected a value behind `=`")
    );
}

#[test]
fn curly_quotes_and_missing_quotes_are_told_the_straight_ones() {
    for (value, help) in
        [("“a”", "a"), ("‘a’", "a"), ("„a“", "a"), ("\"a”", "a"), ("a", "a"), ("2nd body", "2nd body")]
    {
        let found = fault("name = \"a\"", &format!("name = {value}"));
        assert!(found.starts_with(&format!("c.toml:6:8: `{value}` has ")), "{found}");
        assert!(found.ends_with(&format!("help: write \"{help}\"")), "{found}");
    }
    let surfaces = "surfaces = [\"bottom\", \"top\"]";
    assert!(
        fault(surfaces, "surfaces = [“bottom”, “top”]")
            .starts_with("c.toml:14:13: `“bottom”` has curly quotes")
    );
    assert!(fault(surfaces, "surfaces = [bottom, top]").starts_with("c.toml:14:13: `bottom` has no quotes"));
    assert!(
        fault(surfaces, "surfaces = [\n\"bottom\",\ntop]").starts_with("c.toml:16:1: `top` has no quotes")
    );
    assert!(fault("kind = \"block\"", "kind = block").starts_with("c.toml:8:22: `block` has no quotes"));
    let of = |line: &str| only(Case::parse(&minimal(line), "c.toml", &[]));
    assert!(
        of("[limits]\nmemory = 4GiB")
            .ends_with("`4GiB` has no quotes; expected a text in quotes; help: write \"4GiB\"")
    );
    assert!(
        of("gap = 0.1*x").ends_with("expected a number, or an expression in quotes; help: write \"0.1*x\"")
    );
    assert!(of("[output]\nvtu = yes").ends_with("expected true or false; help: write true"));
    let title = ("title".to_owned(), "“a”".to_owned());
    assert!(only(Case::parse(&minimal(""), "c.toml", &[title])).ends_with("help: write \"a\""));
    // The header of a table is not a value.
    assert!(fault("[materials.m]", "[materials.m").contains("unclosed table"));
}

#[test]
fn a_stiffness_of_two_rows_is_told_the_third() {
    let stiffness = |rows: &str| fault("young = 1.0\npoisson = 0.0", &format!("stiffness = {rows}"));
    let two = stiffness("[[1.0, 0.3], [0.3, 1.0]]");
    assert!(
        two.starts_with("c.toml:3:13: `materials.m.stiffness` has 2 entries; expected three rows"),
        "{two}"
    );
    assert!(two.contains("help: give three rows; the last holds the shear modulus"), "{two}");
    let short = stiffness("[[1.0, 0.3], [0.3, 1.0], [0.0, 0.5]]");
    assert!(
        short.contains("`materials.m.stiffness.0` has 2 entries")
            && short.contains("give three numbers in each row")
    );
    assert!(stiffness("[1, 0, 0, 0, 1, 0, 0, 0, 1]").ends_with("put the numbers of each row into brackets"));
    let nearly = stiffness("[[1, 0, 0], [0, 1, 0], [0, 0, 1e-18]]");
    assert!(nearly.starts_with("c.toml:3:13: the stiffness is too nearly singular: ratio 1e-18"), "{nearly}");
}

#[test]
fn a_hypothesis_that_is_not_plane_is_told_that_only_plane_problems_are_solved() {
    let of =
        |word: &str| only(Case::parse(&minimal(&format!("[model]\nhypothesis = \"{word}\"")), "c.toml", &[]));
    for word in ["axisymmetric", "axisymmetry", "Axisymmetric"] {
        assert!(of(word).contains("help: there are no problems with an axis of symmetry"), "{}", of(word));
    }
    for word in ["3d", "3D", "three_dimensional"] {
        assert!(
            of(word).ends_with("help: only plane problems are solved, in plane strain or plane stress"),
            "{}",
            of(word)
        );
    }
    for (word, near) in
        [("plane-strain", "plane_strain"), ("planestress", "plane_stress"), ("Plane_Strain", "plane_strain")]
    {
        assert!(of(word).ends_with(&format!("help: did you mean \"{near}\"?")), "{}", of(word));
    }
    assert!(
        of("2d").ends_with("\"plane_strain\" for a long body, \"plane_stress\" for a thin sheet"),
        "{}",
        of("2d")
    );
}

#[test]
fn numbers_of_300_digits_are_shown_with_an_exponent() {
    for (from, to) in [
        ("poisson = 0.0", "poisson = 1e300"),
        ("poisson = 0.0", "poisson = -1e300\n[model]\nthickness = -1e300"),
        ("origin = [0.0, 1.0], size = [1, 1]", "origin = [1e300, 0.0], size = [1e-300, 1]"),
    ] {
        let text = minimal("").replacen(from, to, 1);
        let said = match Case::parse(&text, "c.toml", &[]) {
            Err(error) => error.to_string(),
            Ok(case) => case.build_bodies().unwrap_err().to_string(),
        };
        assert!(said.contains("e300") && !said.contains("000000"), "{said}");
    }
}

#[test]
fn numbers_are_spelled_as_toml_has_them() {
    for text in [".5", "5.", "+007", "-.5e3", "1.e-9", "000"] {
        assert!(toml::de::DeValue::parse(&mesh_io::numeral::spelled(text)).is_ok(), "{text}");
    }
}

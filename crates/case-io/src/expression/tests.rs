use super::*;
use std::f64::consts::PI;

fn at(text: &str, point: [f64; 2]) -> f64 {
    Expression::parse(text).unwrap_or_else(|e| unreachable!("{text}: {e}")).at(point)
}

#[test]
fn values_are_those_of_the_usual_rules() {
    let (x, y): (f64, f64) = (1.7, -0.4);
    for (text, value) in [
        ("3", 3.0),
        (" 1e-3*2.5E+2 ", 0.25),
        (".5 + 2.", 2.5),
        ("1 - 2 + 3", 2.0),
        ("1 - 2 - 3", -4.0),
        ("8 / 4 * 2", 4.0),
        ("8 / 4 / 2", 1.0),
        ("x / 2 * 3", x / 2.0 * 3.0),
        ("2 * 3 / x * 4", 2.0 * 3.0 / x * 4.0),
        ("1 - x - 2 + y", 1.0 - x - 2.0 + y),
        ("-x^2", -x.powf(2.0)),
        ("(-x)^2", x.powf(2.0)),
        ("2^-x", 2f64.powf(-x)),
        ("2^-sin(x)*3", 2f64.powf(-x.sin()) * 3.0),
        ("3/-x^2*4", 3.0 / -x.powf(2.0) * 4.0),
        ("3*-x^2", 3.0 * -x.powf(2.0)),
        ("3 - -x", 3.0 + x),
        ("3 + -x*y", 3.0 - x * y),
        ("+x - +y", x - y),
        ("2*x^3*y", 2.0 * x.powf(3.0) * y),
        ("(2^3)^2 + 2^(3^2)", 64.0 + 512.0),
        ("x^2 - (x + y)^2 / y^2", x.powf(2.0) - (x + y).powf(2.0) / y.powf(2.0)),
        ("pi * x", PI * x),
        ("max(0, min(1, x))", 1.0),
        ("min(max(x, y), max(-x, -y)) + 1", 1.4),
        ("sin(max(x, -max(y, 2*x)) - 1)^2", (x - 1.0f64).sin().powf(2.0)),
        ("atan2(y, x) * 2", 2.0 * y.atan2(x)),
        ("atan2 ( y , - 1 )", y.atan2(-1.0)),
        ("abs(y) + sqrt(x) - ln(x) + log10(x)", 0.4 + x.sqrt() - x.ln() + x.log10()),
        ("exp(-x^2) * cosh(y) / tanh(x)", (-x * x).exp() * y.cosh() / x.tanh()),
        ("cos(sin(tan(y)))", y.tan().sin().cos()),
        ("asin(y) + acos(y) + atan(y) + sinh(y)", y.asin() + y.acos() + y.atan() + y.sinh()),
        ("-(-(-(x)))", -x),
        ("-max(x, y)^2", -x.powf(2.0)),
        ("(((x)))*((y))", x * y),
    ] {
        let found = at(text, [x, y]);
        assert!((found - value).abs() <= 1e-15 * value.abs().max(1.0), "{text}: {found} against {value}");
    }
    assert!(Expression::parse("2 * pi").unwrap().is_constant());
    assert!(!Expression::parse("0 * x").unwrap().is_constant());
}

#[test]
fn what_is_not_defined_is_not_a_number() {
    for text in ["sqrt(x)", "ln(x)", "min(sqrt(x), 1)", "max(1, 0/(x+1))", "x^0.5", "acos(2*x)"] {
        assert!(at(text, [-1.0, 0.0]).is_nan(), "{text}");
    }
    assert_eq!(at("1/y", [-1.0, 0.0]), f64::INFINITY);
}

/// A tree of random operations with its value, computed beside its text.
struct Trees(u64);

impl Trees {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % n
    }

    /// Returns a text, its value, and how strongly it binds: 0 sum, 1 product, 2 power, 3 operand.
    fn tree(&mut self, depth: u32, [x, y]: [f64; 2]) -> (String, f64, u8) {
        let choice = if depth == 0 { self.below(4) } else { self.below(13) };
        if choice < 4 {
            let number = self.below(4000) as f64 / 1000.0;
            return match choice {
                0 => ("x".into(), x, 3),
                1 => ("y".into(), y, 3),
                2 => (format!("{number:e}"), number, 3),
                _ => (number.to_string(), number, 3),
            };
        }
        let (a, va, pa) = self.tree(depth - 1, [x, y]);
        let (b, vb, pb) = self.tree(depth - 1, [x, y]);
        let within = |text: &str, binds: u8, least: u8| {
            if binds < least { format!("({text})") } else { text.to_owned() }
        };
        match choice {
            4 => (format!("{} + {}", within(&a, pa, 0), within(&b, pb, 1)), va + vb, 0),
            5 => (format!("{}-{}", within(&a, pa, 0), within(&b, pb, 1)), va - vb, 0),
            6 => (format!("{} *{}", within(&a, pa, 1), within(&b, pb, 2)), va * vb, 1),
            7 => (format!("{}/{}", within(&a, pa, 1), within(&b, pb, 2)), va / vb, 1),
            8 => (format!("{}^{}", within(&a, pa, 3), within(&b, pb, 3)), va.powf(vb), 2),
            9 => (format!("-{}", within(&a, pa, 2)), -va, 0),
            10 => (format!("cos({a})"), va.cos(), 3),
            11 => {
                (format!("max({a}, {b})"), if va.is_nan() || vb.is_nan() { f64::NAN } else { va.max(vb) }, 3)
            }
            _ => (format!("atan2({a},{b})"), va.atan2(vb), 3),
        }
    }
}

#[test]
fn random_expressions_have_the_values_of_their_trees() {
    let mut trees = Trees(7);
    let mut finite = 0;
    for k in 0..20_000 {
        let point = [0.3 + f64::from(k % 17) / 10.0, 1.1 - f64::from(k % 13) / 8.0];
        let (text, value, _) = trees.tree(5, point);
        if text.len() > LONGEST_EXPRESSION {
            continue;
        }
        let found = at(&text, point);
        let same = found == value || (found.is_nan() && value.is_nan());
        assert!(same, "{text} at {point:?}: {found} against {value}");
        finite += u32::from(value.is_finite());
    }
    assert!(finite > 10_000, "{finite} are finite");
}

#[test]
fn faults_are_located() {
    for (text, span, message) in [
        ("", 0..0, "the expression is empty"),
        ("  ", 0..2, "the expression is empty"),
        ("2 * z", 4..5, "unknown name \"z\""),
        ("30 * sinn(x)", 5..9, "unknown function \"sinn\""),
        ("2x", 0..2, "\"2x\" is not a number"),
        ("x y", 2..3, "an operator is missing before \"y\""),
        ("2 (x)", 2..3, "an operator is missing before \"(\""),
        ("(x) 3.5", 4..7, "an operator is missing before \"3.5\""),
        ("1.2.3", 0..5, "\"1.2.3\" is not a number"),
        ("1 + .", 4..5, "\".\" is not a number"),
        ("1e999", 0..5, "\"1e999\" is not a number"),
        ("1e", 0..2, "\"1e\" is not a number"),
        ("1_000", 0..5, "\"1_000\" is not a number"),
        ("x +", 3..3, "something is missing before the end"),
        ("* x", 0..1, "something is missing before `*`"),
        ("x ** 2", 2..4, "`**` is not an operator"),
        ("x * / 2", 4..5, "something is missing before `/`"),
        ("--x", 1..2, "two consecutive signs"),
        ("(x", 0..1, "`(` is not closed"),
        ("x)", 1..2, "`)` closes nothing"),
        ("()", 1..2, "something is missing before `)`"),
        ("sin x", 0..3, "`sin` is a function without its arguments"),
        ("max(x)", 5..6, "`max` has 1 argument"),
        ("max(x, y, 1)", 8..9, "`max` has more than 2 arguments"),
        ("sin(x, y)", 5..6, "`sin` has more than 1 argument"),
        ("max(, x)", 4..5, "something is missing before `,`"),
        ("0,5", 1..2, "`,` is outside the arguments of a function"),
        ("(0,5)", 2..3, "`,` is outside the arguments of a function"),
        ("x^y^2", 3..4, "a power of a power"),
        ("x^sin(y^2)^2", 10..11, "a power of a power"),
        ("x^-(y)^2", 6..7, "a power of a power"),
        ("x = 1", 2..3, "the character \"=\" is not allowed here"),
        ("{x}", 0..1, "the character \"{\" is not allowed here"),
        ("2 * π", 4..6, "the character \"π\" is not allowed here"),
        ("a\u{301}", 0..1, "unknown name \"a\""),
        ("x\0", 1..2, "the character"),
    ] {
        let error = Expression::parse(text).unwrap_err();
        assert_eq!(error.span, span, "{text}: {error}");
        assert!(error.message.starts_with(message), "{text}: {error}");
    }
}

#[test]
fn nearest_names_are_offered() {
    let help = |text| Expression::parse(text).unwrap_err().help.unwrap();
    assert_eq!(help("sinn(x)"), "did you mean `sin`?");
    assert_eq!(help("X"), "did you mean `x`?");
    assert_eq!(help("2*PI"), "did you mean `pi`?");
    assert_eq!(help("arctan2(x, y)"), "did you mean `atan2`?");
    assert!(help("q").starts_with("the names here are x, y, pi, abs"));
    assert_eq!(help("z"), "only cases of solids have the coordinate `z`");
    assert!(help("e^x").contains("exp(1)"));
}

#[test]
fn hostile_texts_end_in_an_error_or_a_value() {
    let deep = |n: usize, open: &str, close: &str| format!("{}x{}", open.repeat(n), close.repeat(n));
    for (open, close) in [("(", ")"), ("sin(", ")"), ("max(1,", ")"), ("-(", ")"), ("2^(", ")")] {
        // Towers of powers are infinite, nothing else is lost.
        assert!(!Expression::parse(&deep(DEEPEST_EXPRESSION, open, close)).unwrap().at([0.1, 0.0]).is_nan());
        let error = Expression::parse(&deep(DEEPEST_EXPRESSION + 1, open, close)).unwrap_err();
        assert!(error.message.contains("nested too deeply"), "{error}");
        let error = Expression::parse(&deep(1_000_000, open, close)).unwrap_err();
        assert!(error.message.contains("bytes"), "{error}");
    }
    // The longest chains that the limit lets through.
    for (piece, last) in [("x+", "x"), ("1e308*", "1"), ("-x*", "x"), ("2^x/", "1"), ("1e-308+", "x")] {
        let text = format!("{}{last}", piece.repeat((LONGEST_EXPRESSION - 1) / piece.len()));
        assert!(text.len() <= LONGEST_EXPRESSION && text.len() > LONGEST_EXPRESSION - 20);
        let _ = at(&text, [0.5, 0.5]);
    }
    // Random characters, mostly of those that expressions are made of.
    let mut random = Trees(11);
    let pieces: Vec<&str> =
        "( ) ( ) x y pi 1 2.5 1e3 + - * / ^ , sin max( atan2( sqrt( { } π é \0 \" % e _ . max min"
            .split(' ')
            .collect();
    let mut good = 0;
    for _ in 0..50_000 {
        let count = 1 + random.below(12);
        let text: String = (0..count).map(|_| pieces[random.below(pieces.len() as u64) as usize]).collect();
        if let Ok(expression) = Expression::parse(&text) {
            let _ = expression.at([0.5, -2.0]);
            good += 1;
        }
    }
    assert!(good > 500, "{good}");
}

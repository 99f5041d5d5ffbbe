//! Numbers and texts as people read them.

use case_io::Case;
use case_io::case::{Dimension, Method};
use fem_core::geometry::shown;
use serde_json::Value;
use std::borrow::Cow;

pub use mesh_io::words::counted;
pub(crate) use mesh_io::words::escaped;

/// Writes a number exactly, with an exponent if it would be a long row of digits.
pub use fem_core::geometry::shown as short;

/// The nearest number of this many significant digits that is not below `x`, or not above it.
fn outward(x: f64, digits: usize, up: bool) -> f64 {
    let nearest = format!("{x:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = nearest.split_once('e') else { return x };
    let Ok(value) = nearest.parse::<f64>() else { return x };
    if if up { value >= x } else { value <= x } {
        return value;
    }
    let (Ok(mantissa), Ok(exponent)) = (mantissa.replace('.', "").parse::<i64>(), exponent.parse::<i64>())
    else {
        return x;
    };
    let (next, last) = (mantissa + if up { 1 } else { -1 }, exponent + 1 - digits as i64);
    format!("{next}e{last}").parse().unwrap_or(x)
}

/// Says what a method does, and how it is related to the two steps of the paper's iteration.
pub fn of_method(method: Method) -> &'static str {
    match method {
        Method::Nndd => {
            "The paper's iteration: step 1 imposes a trace on one body and solves contact for the other. \
             Step 2 turns the difference of their forces into a correction of the trace, which theta scales. \
             eta_nndd bounds the distance from the discrete solution at every iteration."
        }
        Method::NewtonNn => {
            "Two iterations of the paper, or full contact if contact alone holds a body, give a set of closed nodes, and Newton's method \
             corrects it. \
             With the set held, the paper's two steps are linear: conjugate gradients take the place of theta. \
             eta_nndd bounds the distance from the discrete solution at every step, also while the set is wrong."
        }
        Method::Auto | Method::Exact | Method::Newton => {
            "The bodies are condensed to the nodes of contact, and an active set solves this problem exactly. \
             None of the paper's two steps is taken: the answer is the limit of its iteration. \
             eta_nndd is the rounding of this solution."
        }
    }
}

/// At most seven significant digits.
pub fn seven(x: f64) -> String {
    short(format!("{x:.6e}").parse().unwrap_or(x))
}

/// The nearest number of this many significant digits that is not below a bound.
pub fn raised(x: f64, digits: usize) -> f64 {
    outward(x, digits, true)
}

/// The nearest number of this many significant digits that is not above a bound.
pub(crate) fn lowered(x: f64, digits: usize) -> f64 {
    outward(x, digits, false)
}

/// Four significant digits of a bound, none of them smaller than the bound itself.
pub fn rounded_up(x: f64) -> String {
    let value = raised(x, 4);
    if value == 0.0 || !(1e-3..1e4).contains(&value.abs()) {
        return if value == 0.0 { "0".into() } else { format!("{value:.3e}") };
    }
    let digits = (3 - value.abs().log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

/// How many digits of a result the certified relative error leaves: one more than are certain, at least 2 and at most 6; 3 if
/// nothing is certified.
///
/// `d = ⌈−log₁₀ ε⌉ + 1`: 2.7 % leaves 3 digits.
pub fn certified_digits(relative: Option<f64>) -> usize {
    match relative {
        Some(relative) if relative > 0.0 => (1.0 - relative.log10()).ceil().clamp(2.0, 6.0) as usize,
        Some(_) => 6,
        None => 3,
    }
}

/// Writes the place of a point with four digits; rounding beside the given size is zero.
pub(crate) fn place(point: &[f64], size: f64) -> String {
    let rounded = |c: f64| {
        let c = if c.abs() <= ROUNDING * size { 0.0 } else { c };
        shown(with_digits(c, 4).parse().unwrap_or(c))
    };
    components(point, rounded)
}

/// Writes the components of a vector between brackets.
pub fn components(entries: &[f64], written: impl Fn(f64) -> String) -> String {
    format!("({})", entries.iter().map(|c| written(*c)).collect::<Vec<_>>().join(", "))
}

/// Numbers below this part of the largest of their kind are rounding.
pub(crate) const ROUNDING: f64 = 1e-9;

/// Writes a number with this many significant digits, with an exponent if it would have others, or many zeros.
pub fn with_digits(x: f64, digits: usize) -> String {
    let digits = digits.max(1);
    let text = format!("{x:.*e}", digits - 1);
    let exponent = text.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok());
    match exponent {
        _ if x == 0.0 => "0".into(),
        Some(e) if e >= -3 && e < digits.max(3) as i32 => {
            let rounded = text.parse::<f64>().unwrap_or(x);
            format!("{rounded:.*}", (digits as i32 - 1 - e).max(0) as usize)
        }
        _ => text,
    }
}

/// Seven significant digits of a lower bound, rounded down.
pub(crate) fn at_least(x: f64) -> String {
    short(lowered(x, 7))
}

/// Seven significant digits of an upper bound, rounded up.
pub fn at_most(x: f64) -> String {
    short(raised(x, 7))
}

/// Says whether a character would command a terminal.
fn commands(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t' || turns(c)
}

/// Says whether a character turns the direction of the text after it, or is not allowed in XML.
fn turns(c: char) -> bool {
    matches!(c, '\u{fffe}' | '\u{ffff}' | '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Writes control characters by their codes, line ends among them: a title or a name is one line.
pub fn one_line(text: &str) -> Cow<'_, str> {
    by_code(text, |c| c.is_control() || turns(c))
}

/// Writes characters that would command a terminal by their codes.
pub fn plain(text: &str) -> Cow<'_, str> {
    by_code(text, commands)
}

/// Writes some characters by their codes.
fn by_code(text: &str, which: fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(which) {
        return text.into();
    }
    let shown = |c: char| if which(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect::<String>().into()
}

/// Writes JSON, without characters that would command a terminal: in its strings these are written as `\u202e`, which readers of
/// JSON and of TOML take for the character.
pub fn json(value: &Value) -> String {
    let mut text = String::new();
    for c in value.to_string().chars() {
        // All of them are below U+10000: one code is enough.
        if commands(c) { text += &format!("\\u{:04x}", u32::from(c)) } else { text.push(c) }
    }
    text
}

/// Replaces such characters by blanks, each byte by one, so that places in the text stay where they are.
pub fn blanked(text: &str) -> String {
    let mut blanked = String::with_capacity(text.len());
    for c in text.chars() {
        if commands(c) { blanked.extend(std::iter::repeat_n(' ', c.len_utf8())) } else { blanked.push(c) }
    }
    blanked
}

/// Names what there is a ParaView file of: the bodies in the file's order, and the contact interfaces.
pub(crate) fn parts<S: Dimension>(case: &Case<S>) -> Vec<String> {
    case.bodies.iter().map(|body| body.file_stem()).chain(contact_parts(case)).collect()
}

/// The file of a part on a mesh of an adaptive run, or in a load step.
pub(crate) fn step_file(part: &str, step: usize) -> String {
    format!("fields/{part}-step-{step:02}.vtu")
}

/// Names the contact interfaces: the only one is "contact".
pub(crate) fn contact_parts<S: Dimension>(case: &Case<S>) -> Vec<String> {
    match case.contacts.as_slice() {
        [_] => vec!["contact".to_owned()],
        all => all.iter().map(|pair| format!("contact-{}", pair.file_stem())).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_rows_of_digits_get_an_exponent() {
        let written = [0.0, 0.1, -2.5, 1e-30, -1e300].map(short);
        assert_eq!(written, ["0", "0.1", "-2.5", "1e-30", "-1e300"]);
        assert_eq!([3.011352812508667, 1.0, -2e-9, 0.1 + 0.2].map(seven), ["3.011353", "1", "-2e-9", "0.3"]);
        assert_eq!([1, 2].map(|n| counted(n, "mesh node")), ["1 mesh node", "2 mesh nodes"]);
    }

    #[test]
    fn a_bound_is_never_printed_below_itself() {
        let cases = [
            (18.831_7, "18.84"),
            (1.301_44, "1.302"),
            (1.5, "1.500"),
            (0.999_94, "1.000"),
            (9_999.1, "1.000e4"),
            (3.200_4e-9, "3.201e-9"),
        ];
        for (x, shown) in cases {
            assert_eq!(rounded_up(x), shown);
        }
        let mut x = 1.234_567e-12;
        while x < 1e9 {
            let shown: f64 = rounded_up(x).parse().unwrap();
            assert!(shown >= x && shown <= 1.0011 * x, "{x} {shown}");
            x *= 1.371;
        }
    }

    #[test]
    fn bounds_are_rounded_away_from_what_they_enclose() {
        assert_eq!([at_least(0.842_456_74), at_most(30.047_109_07)], ["0.8424567", "30.04711"]);
        assert_eq!([at_least(-35.515_046_6), at_most(-35.515_046_6)], ["-35.51505", "-35.51504"]);
        assert_eq!([at_least(0.0), at_most(2.5), at_most(9.999_999_9)], ["0", "2.5", "10"]);
        let mut x = -1.234_567_891e-9;
        while x > -1e9 {
            let [low, high] = [at_least(x), at_most(x)].map(|text| text.parse::<f64>().unwrap());
            assert!(low <= x && x <= high && high - low <= 2e-6 * x.abs(), "{low} {x} {high}");
            x *= 2.371;
        }
    }

    #[test]
    fn a_result_has_the_digits_that_its_bound_leaves() {
        let of = |relative| certified_digits(Some(relative));
        assert_eq!([0.5, 0.2368, 0.1, 0.027, 0.01, 1e-3, 1e-9, 0.0].map(of), [2, 2, 2, 3, 3, 4, 6, 6]);
        assert_eq!(certified_digits(None), 3);
        let written =
            [91_900.35, 919.0, 26.236, 0.012_774, 4.336e6, -1.25e-8, 0.0, 9.996].map(|x| with_digits(x, 3));
        assert_eq!(written, ["9.19e4", "919", "26.2", "0.0128", "4.34e6", "-1.25e-8", "0", "10.0"]);
        assert_eq!([919.0, 26.236, 0.276].map(|x| with_digits(x, 2)), ["920", "26", "0.28"]);
    }

    #[test]
    fn json_without_commands_is_the_same_json() {
        for c in (0..0x3000).chain(0xd000..0x11000).filter_map(char::from_u32) {
            let value = serde_json::json!({ format!("a{c}\"\\"): [format!("{c}{c}"), 1.5, null] });
            let text = json(&value);
            assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value, "{text}");
            assert_eq!(plain(&text), text);
        }
    }

    #[test]
    fn nothing_commands_the_terminal() {
        assert_eq!(plain("a\u{1b}[31mb\nü\t\u{9b}"), "a\\u{1b}[31mb\nü\t\\u{9b}");
        assert!(matches!(plain("Größe\n"), Cow::Borrowed(_)));
        assert_eq!(one_line("a\u{1b}[31mb\nü\t\u{202e}"), "a\\u{1b}[31mb\\nü\\t\\u{202e}");
        assert!(matches!(one_line("Größe 上"), Cow::Borrowed(_)));
        let text = "a\u{1b}ü\u{9b}\r\n";
        assert_eq!((blanked(text).as_str(), blanked(text).len()), ("a ü   \n", text.len()));
    }
}

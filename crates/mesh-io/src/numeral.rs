//! Texts that are nearly numbers, and how the number that was meant is written.

/// Longer texts are not taken for numbers.
const LONGEST: usize = 60;

/// Dashes that look like a minus sign.
const DASHES: [char; 7] =
    ['\u{2212}', '\u{2013}', '\u{2014}', '\u{2010}', '\u{2011}', '\u{FE63}', '\u{FF0D}'];

/// Quotes of word processors, and the plain ones.
const QUOTES: [char; 16] = ['"', '\'', '`', '´', '“', '”', '„', '‟', '‘', '’', '‚', '‛', '«', '»', '‹', '›'];

/// Tells how to write the number that a text means: `write it without unit: 2000.0 (all units must agree)`.
///
/// Returns `None` for a text that is a number already, and for one that does not look like a number.
///
/// * `text`: such as `2000.0 MPa`, `40%`, `2D3`, `0,5`, `2 000`, `2×10³`, or a number in quotes.
pub fn advice(text: &str) -> Option<String> {
    let text = text.trim();
    if text.len() > LONGEST || is_number(text) {
        return None;
    }
    let ways = [trailing, in_quotes, dash, fortran, percent, decimal_comma, groups, power_of_ten, unit];
    ways.into_iter().find_map(|way| way(text))
}

/// Says whether a text is a finite number in digits, with a decimal point.
pub fn is_number(text: &str) -> bool {
    text.contains(|c: char| c.is_ascii_digit()) && text.parse::<f64>().is_ok_and(f64::is_finite)
}

/// Says whether a character is a quote other than `"` and `'`.
pub fn is_curly(c: char) -> bool {
    QUOTES.contains(&c) && c != '"' && c != '\''
}

/// Takes the quotes of any kind off both ends.
pub fn without_quotes(text: &str) -> &str {
    text.trim_matches(|c| QUOTES.contains(&c)).trim()
}

/// Writes a number as strict formats such as TOML require it: digits on both sides of the point, no zeros in front, an
/// `E` as it is.
pub fn spelled(number: &str) -> String {
    let (sign, digits) = match number.strip_prefix('-') {
        Some(digits) => ("-", digits),
        None => ("", number.trim_start_matches('+')),
    };
    let (mantissa, exponent) = digits.split_at(digits.find(['e', 'E']).unwrap_or(digits.len()));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let whole = whole.trim_start_matches('0');
    let whole = if whole.is_empty() { "0" } else { whole };
    match (mantissa.contains('.'), fraction) {
        (false, _) => format!("{sign}{whole}{exponent}"),
        (true, "") => format!("{sign}{whole}.0{exponent}"),
        (true, fraction) => format!("{sign}{whole}.{fraction}{exponent}"),
    }
}

fn trailing(text: &str) -> Option<String> {
    let number = text.strip_suffix([',', ';'])?.trim_end();
    is_number(number).then(|| format!("take the sign behind it out: write {}", spelled(number)))
}

fn in_quotes(text: &str) -> Option<String> {
    let inner = without_quotes(text);
    if !text.starts_with(QUOTES) {
        return None;
    }
    if is_number(inner) { Some(format!("write {} without quotes", spelled(inner))) } else { advice(inner) }
}

fn dash(text: &str) -> Option<String> {
    let replaced = text.replace(DASHES, "-");
    if replaced == text {
        return None;
    }
    if is_number(&replaced) {
        Some(format!("the dash is not a minus sign: write {}", spelled(&replaced)))
    } else {
        advice(&replaced)
    }
}

fn fortran(text: &str) -> Option<String> {
    let (mantissa, exponent) = text.split_once(['d', 'D', 'q', 'Q'])?;
    let mantissa = mantissa.replace(',', ".");
    let digits = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
    let whole = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    let number = format!("{mantissa}E{exponent}");
    let fits = whole && is_number(&mantissa) && is_number(&number);
    fits.then(|| format!("Fortran exponent: write {}", spelled(&number)))
}

fn percent(text: &str) -> Option<String> {
    let number = text.strip_suffix('%').or_else(|| text.strip_suffix("percent"))?.trim_end();
    let number = number.replace(',', ".");
    // Exactly the decimal number, unless it has an exponent of its own.
    let fraction = match format!("{number}e-2").parse::<f64>() {
        Ok(fraction) => fraction,
        Err(_) => number.parse::<f64>().ok()? / 100.0,
    };
    let fits = is_number(&number) && fraction.is_finite();
    fits.then(|| format!("write the fraction: {fraction:?}"))
}

fn decimal_comma(text: &str) -> Option<String> {
    let (whole, fraction) = text.split_once(',')?;
    let number = format!("{whole}.{fraction}");
    if fraction.contains(',') || !is_number(&number) {
        return None;
    }
    let thousands = whole.trim_start_matches(['+', '-']);
    let ambiguous = (1..=3).contains(&thousands.len())
        && !thousands.starts_with('0')
        && fraction.len() == 3
        && fraction.bytes().all(|b| b.is_ascii_digit());
    let or = if ambiguous { format!(", or {whole}{fraction} if it means thousands") } else { String::new() };
    Some(format!("decimal comma: write {}{or}", spelled(&number)))
}

fn groups(text: &str) -> Option<String> {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let sign = if text.starts_with('-') { "-" } else { "" };
    let of = |separator: char| {
        let point = if separator == '.' { ',' } else { '.' };
        let (whole, fraction) = digits.split_once(point).unwrap_or((digits, ""));
        let mut parts = whole.split(separator);
        let first = parts.next()?;
        let is_digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
        let grouped = whole.contains(separator) && parts.all(|part| part.len() == 3 && is_digits(part));
        let sound = grouped && (1..=3).contains(&first.len()) && is_digits(first) && is_digits(fraction);
        let point = if fraction.is_empty() { "" } else { "." };
        sound.then(|| {
            format!("write the digits together: {sign}{}{point}{fraction}", whole.replace(separator, ""))
        })
    };
    [',', '.', '\'', '’', ' ', '\u{A0}', '\u{202F}', '\u{2009}'].into_iter().find_map(of)
}

fn power_of_ten(text: &str) -> Option<String> {
    let text: String = text.chars().filter(|c| !c.is_whitespace()).map(plain_digit).collect();
    let (mantissa, rest) = ["×10", "x10", "X10", "·10", "⋅10", "*10"]
        .iter()
        .find_map(|ten| text.split_once(ten))
        .or_else(|| text.strip_prefix("10").map(|rest| ("1", rest)))?;
    let exponent = rest.trim_start_matches(['^', '*']).trim_matches(['(', ')', '{', '}']);
    let digits = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
    let number = format!("{}E{exponent}", mantissa.replace(',', "."));
    let fits = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) && is_number(&number);
    fits.then(|| format!("write the power of ten with E: {}", spelled(&number)))
}

/// Turns a raised digit or sign into a plain one.
fn plain_digit(c: char) -> char {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    if c == '⁻' {
        return '-';
    }
    let place = RAISED.chars().position(|raised| raised == c).and_then(|k| u32::try_from(k).ok());
    place.and_then(|k| char::from_digit(k, 10)).unwrap_or(c)
}

fn unit(text: &str) -> Option<String> {
    let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.,eE".contains(c))).unwrap_or(text.len());
    let (number, unit) = (1..=end).rev().find_map(|k| {
        let (number, unit) = (text[..k].replace(',', "."), text[k..].trim());
        (is_number(&number) && !unit.is_empty()).then_some((number, unit))
    })?;
    let begins = unit.starts_with(|c: char| c.is_alphabetic() || "°'′\"″[(".contains(c));
    let allowed = |c: char| c.is_alphanumeric() || " /^*·⋅.-⁻°'′\"″()[]_%".contains(c);
    let mut words = unit.split(|c: char| !c.is_alphanumeric());
    let of_expression = words.clone().any(|word| ["x", "y", "pi"].contains(&word))
        || words.next().is_some_and(|name| !name.is_empty() && unit[name.len()..].starts_with('('));
    let fits = begins && !of_expression && unit.chars().all(allowed);
    fits.then(|| format!("write it without unit: {} (all units must agree)", spelled(&number)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nearly_a_number_is_told_the_number() {
        for (text, said) in [
            ("2000.0 MPa", "write it without unit: 2000.0 (all units must agree)"),
            ("2000MPa", "write it without unit: 2000 (all units must agree)"),
            ("210e9 N/m^2", "write it without unit: 210e9 (all units must agree)"),
            ("2,5 mm", "write it without unit: 2.5 (all units must agree)"),
            ("-.5mm", "write it without unit: -0.5 (all units must agree)"),
            ("2000 [N/mm²]", "write it without unit: 2000 (all units must agree)"),
            ("45°", "write it without unit: 45 (all units must agree)"),
            ("5e", "write it without unit: 5 (all units must agree)"),
            ("40%", "write the fraction: 0.4"),
            ("33.3 %", "write the fraction: 0.333"),
            ("7 %", "write the fraction: 0.07"),
            ("1e1%", "write the fraction: 0.1"),
            ("0,5 %", "write the fraction: 0.005"),
            ("2D3", "Fortran exponent: write 2E3"),
            ("1.5d-03", "Fortran exponent: write 1.5E-03"),
            ("-1.D+2", "Fortran exponent: write -1.0E+2"),
            ("1,5D3", "Fortran exponent: write 1.5E3"),
            ("0,5", "decimal comma: write 0.5"),
            ("-0,25e-3", "decimal comma: write -0.25e-3"),
            (",5", "decimal comma: write 0.5"),
            ("0,125", "decimal comma: write 0.125"),
            ("2,000", "decimal comma: write 2.000, or 2000 if it means thousands"),
            ("2,000.5", "write the digits together: 2000.5"),
            ("2,000,000", "write the digits together: 2000000"),
            ("2.000.000,5", "write the digits together: 2000000.5"),
            ("210 000", "write the digits together: 210000"),
            ("-2'000", "write the digits together: -2000"),
            ("2×10³", "write the power of ten with E: 2E3"),
            ("2.1 * 10^11", "write the power of ten with E: 2.1E11"),
            ("10⁻³", "write the power of ten with E: 1E-3"),
            ("2000,", "take the sign behind it out: write 2000"),
            ("2000;", "take the sign behind it out: write 2000"),
            ("“2000”", "write 2000 without quotes"),
            ("„0,5“", "decimal comma: write 0.5"),
            ("‘2 mm’", "write it without unit: 2 (all units must agree)"),
            ("−5", "the dash is not a minus sign: write -5"),
            ("1e–3", "the dash is not a minus sign: write 1e-3"),
            ("–0,5", "decimal comma: write -0.5"),
        ] {
            assert_eq!(advice(text).as_deref(), Some(said), "{text}");
        }
    }

    #[test]
    fn numbers_words_and_expressions_are_left_alone() {
        for text in [
            "", "5", "1e-3", ".5", "steel", "inf", "nan", "x", "2x", "2*x", "2D3 * x", "2sin(x)", "2pi",
            "1/3", "auto", "D3", "e5",
        ] {
            assert_eq!(advice(text), None, "{text}");
        }
        assert_eq!(advice(&format!("2{}", "a".repeat(100))), None);
    }

    #[test]
    fn numbers_are_spelled_with_digits_around_the_point() {
        for (text, strict) in [
            (".5", "0.5"),
            ("5.", "5.0"),
            ("+007", "7"),
            ("-.5e3", "-0.5e3"),
            ("1.e-9", "1.0e-9"),
            ("000", "0"),
        ] {
            assert_eq!(spelled(text), strict);
        }
    }
}

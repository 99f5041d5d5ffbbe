//! `--over KEY=RANGE`: the values of a sweep.

use super::overrides::key_path;
use super::tree::At;
use super::value_hints;
use crate::diagnostic::{CaseError, Diagnostic, Source, code};
use mesh_io::numeral;
use toml::de::{DeArray, DeValue};

/// The most values one sweep may have.
pub const MOST_SWEEP_VALUES: usize = 10_000;

/// A setting and the values it takes one after the other; each goes into [`crate::Case::parse`] as an override.
///
/// ```
/// let sweep = case_io::case_file::Sweep::parse("solver.theta=0.1:0.9:0.2")?;
/// assert_eq!(sweep.key, "solver.theta");
/// assert_eq!(sweep.values, ["0.1", "0.3", "0.5", "0.7", "0.9"]);
/// # Ok::<(), case_io::CaseError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Sweep {
    /// The dotted key.
    pub key: String,
    /// The values as TOML.
    pub values: Vec<String>,
}

impl Sweep {
    /// Reads `KEY=a:b:h` (from a to b by steps of h, the end included within h/2), `KEY=[v1, v2]`, or one value.
    ///
    /// # Errors
    /// A missing key or value, numbers that do not make a range, or more than [`MOST_SWEEP_VALUES`] values.
    pub fn parse(argument: &str) -> Result<Self, CaseError> {
        let source = Source::new(&format!("--over {argument}"), argument, true);
        let place = At::new(&source, 0..argument.len()).place();
        let fault = |message: String| {
            CaseError::from(
                Diagnostic::new(code::OVERRIDE, Some(place.clone()), message)
                    .expected("KEY=a:b:h or KEY=[v1, v2], such as solver.theta=0.1:0.9:0.05")
                    .fix("give the first value, the last and the step, or list the values"),
            )
        };
        let (key, text) = argument
            .split_once('=')
            .map(|(k, v)| (k.trim(), v.trim()))
            .filter(|(k, v)| !v.is_empty() && key_path(k).is_some())
            .ok_or_else(|| fault("a sweep without a key and its values".to_owned()))?;
        let values = if text.starts_with('[') { list(text) } else { range(text) }.map_err(fault)?;
        Ok(Self { key: key.to_owned(), values })
    }

    /// Returns the values as numbers; `None` for those that are not numbers.
    pub fn numbers(&self) -> Vec<Option<f64>> {
        self.values.iter().map(|v| v.parse().ok().filter(|x: &f64| x.is_finite())).collect()
    }
}

fn list(text: &str) -> Result<Vec<String>, String> {
    let parsed = DeValue::parse(text).map_err(|e| {
        let source = Source::new("", text, true);
        let hint = value_hints::in_line(text, 0..text.len(), &source, 0);
        let Some(hint) = hint else { return format!("the list is not TOML: {}", e.message()) };
        hint.help.map_or(hint.message.clone(), |help| format!("{}: {help}", hint.message))
    })?;
    let empty = DeArray::new();
    let items = parsed.get_ref().as_array().unwrap_or(&empty);
    if items.is_empty() || items.len() > MOST_SWEEP_VALUES {
        return Err(format!("a list of {} values; 1 to {MOST_SWEEP_VALUES} are possible", items.len()));
    }
    Ok(items.iter().map(|item| text.get(item.span()).unwrap_or_default().to_owned()).collect())
}

fn range(text: &str) -> Result<Vec<String>, String> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [first, last, step] = parts[..] else {
        if parts.len() == 1 {
            return Ok(vec![text.to_owned()]);
        }
        return Err(format!("{} numbers in a range that has three", parts.len()));
    };
    let [a, b, h] = [number(first)?, number(last)?, number(step)?];
    // Strictly less than half a step beyond the end.
    let count = ((b - a) / h + 0.5 - 1e-9).floor();
    if h == 0.0 || count.is_nan() || count < 0.0 {
        return Err(format!("steps of {h} do not lead from {a} to {b}"));
    }
    if count >= MOST_SWEEP_VALUES as f64 {
        return Err(format!("more than {MOST_SWEEP_VALUES} values"));
    }
    let decimals = decimals(first).zip(decimals(step)).map(|(m, n)| m.max(n));
    Ok((0..=count as usize).map(|k| value(a + k as f64 * h, decimals)).collect())
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
        let advice = numeral::advice(text).map_or_else(String::new, |advice| format!(": {advice}"));
        format!("`{text}` is not a finite number{advice}")
    })
}

/// Counts the decimals of a number written without an exponent.
fn decimals(text: &str) -> Option<usize> {
    if text.contains(['e', 'E']) {
        return None;
    }
    Some(text.split_once('.').map_or(0, |(_, fraction)| fraction.len()).min(17))
}

/// Writes a value of a range. Decimal ranges have decimal values: 0.1 + 4 · 0.05 is 0.3, not 0.30000000000000004. Whole ranges have
/// integers, as counts need.
fn value(x: f64, decimals: Option<usize>) -> String {
    match decimals {
        Some(0) => format!("{x:.0}"),
        Some(n) => format!("{:?}", format!("{x:.n$}").parse().unwrap_or(x)),
        None => format!("{x:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        Sweep::parse(&format!("solver.theta={text}")).unwrap().values
    }

    #[test]
    fn ranges_include_their_end_within_half_a_step() {
        let paper = values("0.1:0.9:0.05");
        assert_eq!(paper.len(), 17);
        assert_eq!((paper[4].as_str(), paper[16].as_str()), ("0.3", "0.9"));
        assert_eq!(values("0:1:0.4"), ["0.0", "0.4", "0.8"]);
        assert_eq!(values("0.1:0.9:0.3"), ["0.1", "0.4", "0.7", "1.0"]);
        assert_eq!(values("0:1:0.3"), ["0.0", "0.3", "0.6", "0.9"]);
        assert_eq!(values("1:3:1"), ["1", "2", "3"]);
        assert_eq!(values("3:1:-1"), ["3", "2", "1"]);
        assert_eq!(values("1e-3:3e-3:1e-3").len(), 3);
        assert_eq!(values("2:2:1"), ["2"]);
    }

    #[test]
    fn lists_and_single_values() {
        assert_eq!(values("[0.1, 'auto', [36, 18]]"), ["0.1", "'auto'", "[36, 18]"]);
        assert_eq!(values("auto"), ["auto"]);
        let sweep = Sweep::parse("solver.theta=[0.1, 'auto']").unwrap();
        assert_eq!(sweep.numbers(), [Some(0.1), None]);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for wrong in ["", "0.1:0.9", "a:b:c", "0:1:0", "1:0:0.1", "0:1:nan", "0:1e9:1", "[", "[]", "1:2:3:4"]
        {
            let error = Sweep::parse(&format!("solver.theta={wrong}")).unwrap_err();
            assert!(error.to_string().starts_with("--over solver.theta="), "{error}");
        }
        assert!(Sweep::parse("0.1:0.9:0.1").is_err());
    }
}

//! Medians, times, exponents, and fields of tables.

/// The middle of some ascending numbers, with the smallest and the largest.
pub(super) fn spread(sorted: &[f64]) -> Option<[f64; 3]> {
    let n = sorted.len();
    let median = 0.5 * (sorted.get(n.checked_sub(1)? / 2)? + sorted.get(n / 2)?);
    Some([median, *sorted.first()?, *sorted.last()?])
}

/// The same of numbers in any order.
pub(super) fn spread_of(mut numbers: Vec<f64>) -> Option<[f64; 3]> {
    numbers.sort_by(f64::total_cmp);
    spread(&numbers)
}

/// The exponent `p` of `y ~ x^p` by least squares in logarithms; `None` for fewer than two sizes.
pub(super) fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> =
        points.iter().filter(|p| p.iter().all(|v| *v > 0.0)).map(|p| p.map(f64::ln)).collect();
    let n = logs.len() as f64;
    let mean = [0, 1].map(|c| logs.iter().map(|p| p[c]).sum::<f64>() / n);
    let moment = |c: usize| logs.iter().map(|p| (p[0] - mean[0]) * (p[c] - mean[c])).sum::<f64>();
    let slope = moment(1) / moment(0);
    (logs.len() > 1 && slope.is_finite()).then_some(slope)
}

/// Nanoseconds as a reader likes them.
pub(super) fn time(ns: f64) -> String {
    match ns {
        _ if ns < 1e3 => format!("{ns:.1} ns"),
        _ if ns < 1e6 => format!("{:.2} µs", ns * 1e-3),
        _ if ns < 1e9 => format!("{:.2} ms", ns * 1e-6),
        _ => format!("{:.3} s", ns * 1e-9),
    }
}

/// A field of a comma-separated table, in quotes if it needs them.
pub(super) fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_of_few_numbers() {
        assert_eq!(spread(&[]), None);
        assert_eq!(spread(&[2.0]), Some([2.0; 3]));
        assert_eq!(spread(&[1.0, 2.0, 4.0, 9.0]), Some([3.0, 1.0, 9.0]));
        assert_eq!(spread_of(vec![9.0, 1.0, 2.0]), Some([2.0, 1.0, 9.0]));
    }

    #[test]
    fn exponents_of_powers() {
        let points = [1.0, 2.0, 8.0].map(|x: f64| [x, 3.0 * x.powf(1.5)]);
        assert!(exponent(&points).is_some_and(|p| (p - 1.5).abs() < 1e-12));
        assert_eq!(exponent(&points[..1]), None);
        assert_eq!(exponent(&[[2.0, 1.0], [2.0, 3.0]]), None);
        assert_eq!(exponent(&[[2.0, 0.0], [4.0, 3.0]]), None);
    }
}

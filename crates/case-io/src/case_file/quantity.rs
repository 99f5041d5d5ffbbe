//! Amounts of memory and time with their units, such as `4GiB` and `1h30min`.

/// Reads an amount of memory in bytes: a number and one of B, kB, MB, GB, TB, KiB, MiB, GiB, TiB.
pub(crate) fn memory(text: &str) -> Option<u64> {
    let (number, unit, rest) = amount(text)?;
    let factor = match unit {
        "B" => 1.0,
        "kB" | "KB" => 1e3,
        "MB" => 1e6,
        "GB" => 1e9,
        "TB" => 1e12,
        "KiB" | "kiB" => 1024.0,
        "MiB" => 1024f64.powi(2),
        "GiB" => 1024f64.powi(3),
        "TiB" => 1024f64.powi(4),
        _ => return None,
    };
    let bytes = number * factor;
    // Casts saturate; a larger value means no limit.
    (rest.is_empty() && (1.0..9e18).contains(&bytes)).then_some(bytes as u64)
}

/// Reads a time in seconds: numbers with ms, s, min, h or d, such as `90s` or `1h30min`.
pub(crate) fn time(text: &str) -> Option<f64> {
    let mut rest = text;
    let mut seconds = 0.0;
    loop {
        let (number, unit, after) = amount(rest)?;
        let factor = match unit {
            "ms" => 1e-3,
            "s" => 1.0,
            "min" => 60.0,
            "h" => 3600.0,
            "d" => 86400.0,
            _ => return None,
        };
        seconds += number * factor;
        rest = after;
        if rest.is_empty() {
            return (seconds > 0.0 && seconds.is_finite()).then_some(seconds);
        }
    }
}

/// Splits off a leading number and its unit.
fn amount(text: &str) -> Option<(f64, &str, &str)> {
    let text = text.trim_start();
    let digits = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let (number, rest) = text.split_at(digits);
    let number: f64 = number.parse().ok()?;
    let rest = rest.trim_start();
    let letters = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
    let (unit, rest) = rest.split_at(letters);
    Some((number, unit, rest.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_in_powers_of_ten_and_two() {
        for (text, bytes) in [
            ("4GiB", 4 << 30),
            ("512MB", 512_000_000),
            ("1.5 KiB", 1536),
            ("100B", 100),
            ("2TB", 2_000_000_000_000),
        ] {
            assert_eq!(memory(text), Some(bytes), "{text}");
        }
        for text in ["", "4", "GiB", "4 gigs", "-4GiB", "nanGB", "0GB", "4GiB!", "1e3GB", "99999999999999TB"]
        {
            assert_eq!(memory(text), None, "{text}");
        }
    }

    #[test]
    fn times_add_up() {
        for (text, seconds) in
            [("10min", 600.0), ("30s", 30.0), ("2h", 7200.0), ("1h30min", 5400.0), ("250 ms", 0.25)]
        {
            assert_eq!(time(text), Some(seconds), "{text}");
        }
        for text in ["", "10", "min", "10m", "0s", "-1s", "1h30", "1.2.3s"] {
            assert_eq!(time(text), None, "{text}");
        }
    }
}

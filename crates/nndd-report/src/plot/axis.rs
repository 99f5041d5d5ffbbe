//! One axis, linear, logarithmic or of square roots, which knows its ticks and how to write them.

/// Magnitudes beyond this (or below its inverse, on a logarithmic axis) are not drawn.
const LARGEST: f64 = 1e100;
/// How far from an axis, in its lengths, a place may be.
const BEYOND: f64 = 10.0;

/// Tells if a number can be drawn on a linear axis.
pub(super) fn drawable(v: f64) -> bool {
    v.is_finite() && v.abs() <= LARGEST
}

/// Tells if a number can be drawn on a logarithmic axis.
pub(super) fn drawable_log(v: f64) -> bool {
    drawable(v) && v >= LARGEST.recip()
}

/// Smallest and largest of some numbers, `None` if there are no numbers.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().fold(None, |e, v| match e {
        None => Some((v, v)),
        Some((lo, hi)) => Some((lo.min(v), hi.max(v))),
    })
}

/// How ticks are written.
#[derive(Clone, Debug)]
enum Style {
    /// `0.25`: this many decimals.
    Fixed(usize),
    /// `2.5e-7`: this many digits after the point, trailing zeros dropped.
    Exponent(usize),
}

/// How values become places on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Linear,
    /// By the square root, from zero.
    Root,
    Log,
}

/// An axis with its ticks.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    lo: f64,
    hi: f64,
    kind: Kind,
    /// The values that carry a label, with it.
    major: Vec<(f64, String)>,
    minor: Vec<f64>,
}

impl Axis {
    /// A linear axis over exactly `lo..hi` (widened if the two coincide) with at most `ticks` or so labels.
    pub(super) fn linear(lo: f64, hi: f64, ticks: usize) -> Axis {
        let (lo, hi) = widened(lo, hi);
        // A coarse step may leave one label or none: then a finer one.
        let (mut exponent, mut major) = (0, vec![]);
        for n in [ticks.max(1), 2 * ticks.max(1), 4 * ticks.max(1)] {
            let (step, e) = nice_step((hi - lo) / n as f64);
            (exponent, major) = (e, multiples(lo, hi, step));
            if major.len() > 1 {
                break;
            }
        }
        Axis { lo, hi, kind: Kind::Linear, major: style(lo, hi, exponent).labelled(major), minor: vec![] }
    }

    /// An axis of square roots from zero to `hi`, with one more label in its first step.
    pub(super) fn root(hi: f64, ticks: usize) -> Axis {
        let mut axis = Axis { kind: Kind::Root, ..Axis::linear(0.0, hi, ticks) };
        if let [(zero, _), (first, _), ..] = axis.major[..]
            && zero == 0.0
        {
            let (step, exponent) = nice_step(0.15 * first);
            axis.major.insert(1, (step, style(0.0, step, exponent).write(step)));
        }
        axis
    }

    /// A linear axis over `lo..hi` with a margin of 4 % on both sides.
    pub(super) fn padded(lo: f64, hi: f64, ticks: usize) -> Axis {
        let (lo, hi) = widened(lo, hi);
        let margin = 0.04 * (hi - lo);
        Axis::linear(lo - margin, hi + margin, ticks)
    }

    /// A linear axis for whole numbers: no tick falls between two of them.
    pub(super) fn whole(lo: usize, hi: usize, ticks: usize) -> Axis {
        let (lo, hi) = (lo as f64, hi as f64);
        if hi - lo >= ticks as f64 {
            return Axis::padded(lo, hi, ticks);
        }
        let margin = (0.04 * (hi - lo)).max(0.25);
        let major = Style::Fixed(0).labelled(multiples(lo, hi, 1.0));
        Axis { lo: lo - margin, hi: hi + margin, kind: Kind::Linear, major, minor: vec![] }
    }

    /// A logarithmic axis over exactly `lo..hi`, both positive, widened if they (nearly) coincide.
    pub(super) fn log(lo: f64, hi: f64, ticks: usize) -> Axis {
        let (lo, hi) = if hi / lo > 1.0 + 1e-6 { (lo, hi) } else { (lo / 2.0, hi * 2.0) };
        let decades = (hi / lo).log10();
        let (first, last) = (lo.log10().floor() as i32, hi.log10().ceil() as i32);
        let within = |v: &f64| *v >= lo * (1.0 - 1e-9) && *v <= hi * (1.0 + 1e-9);
        let scaled = |m: &[f64]| -> Vec<f64> {
            (first..=last).flat_map(|k| m.iter().map(move |m| m * power_of_ten(k))).filter(within).collect()
        };
        let (major, minor, style) = if decades >= 2.0 {
            let stride = (decades / ticks.max(1) as f64).ceil().max(1.0) as i32;
            let major = (first..=last).filter(|k| k.rem_euclid(stride) == 0).map(power_of_ten).filter(within);
            let minor = match stride {
                1 if decades <= 6.0 => scaled(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
                1 => vec![],
                _ => scaled(&[1.0]),
            };
            (major.collect(), minor, Style::Exponent(0))
        } else if decades >= 0.7 {
            (scaled(&[1.0, 2.0, 5.0]), scaled(&[3.0, 4.0, 6.0, 7.0, 8.0, 9.0]), Style::Exponent(1))
        } else {
            let (step, exponent) = nice_step((hi - lo) / ticks.max(1) as f64);
            (multiples(lo, hi, step), vec![], exponent_style(hi, exponent))
        };
        Axis { lo, hi, kind: Kind::Log, major: style.labelled(major), minor }
    }

    /// A logarithmic axis over `lo..hi` with a margin of 5 % of its length on both sides.
    pub(super) fn log_padded(lo: f64, hi: f64, ticks: usize) -> Axis {
        let factor = (hi / lo).powf(0.05).max(1.05);
        Axis::log(lo / factor, hi * factor, ticks)
    }

    /// Returns the position of a value on the axis: 0 at its beginning, 1 at its end.
    pub(super) fn position(&self, v: f64) -> f64 {
        let t = match self.kind {
            Kind::Log => (v.max(LARGEST.recip()) / self.lo).ln() / (self.hi / self.lo).ln(),
            Kind::Root => (v / self.hi).max(0.0).sqrt(),
            Kind::Linear => (v - self.lo) / (self.hi - self.lo),
        };
        if t.is_finite() { t.clamp(-BEYOND, BEYOND) } else { 0.0 }
    }

    /// The values that carry a label, with it.
    pub(super) fn major(&self) -> &[(f64, String)] {
        &self.major
    }

    /// Positions of the values with a label, or of the other lines of a grid.
    pub(super) fn positions(&self, major: bool) -> Vec<f64> {
        let values = if major { self.major.iter().map(|m| m.0).collect() } else { self.minor.clone() };
        values.into_iter().map(|v| self.position(v)).collect()
    }

    pub(super) fn kind(&self) -> Kind {
        self.kind
    }

    /// The two ends.
    pub(super) fn ends(&self) -> (f64, f64) {
        (self.lo, self.hi)
    }
}

impl Style {
    fn labelled(&self, values: Vec<f64>) -> Vec<(f64, String)> {
        values.into_iter().map(|v| (v, self.write(v))).collect()
    }

    fn write(&self, value: f64) -> String {
        match self {
            _ if value == 0.0 => "0".into(),
            Style::Exponent(digits) => exponent(value, *digits),
            Style::Fixed(decimals) => {
                let text = format!("{value:.decimals$}");
                if text.trim_start_matches(['-', '0', '.']).is_empty() { "0".into() } else { text }
            }
        }
    }
}

/// `2.5e-7`: at most `digits` digits after the point, trailing zeros dropped.
fn exponent(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    match text.split_once('e') {
        Some((m, e)) if m.contains('.') => format!("{}e{e}", m.trim_end_matches('0').trim_end_matches('.')),
        _ => text,
    }
}

/// A number with at most four significant digits, for titles and descriptions.
pub(super) fn short(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-3..1e5).contains(&magnitude) {
        return exponent(value, 3);
    }
    let decimals = if magnitude == 0.0 { 0 } else { (3 - magnitude.log10().floor() as i32).max(0) as usize };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The two ends, apart from each other by a width that arithmetic can divide.
fn widened(lo: f64, hi: f64) -> (f64, f64) {
    let size = lo.abs().max(hi.abs());
    if hi - lo > 1e-9 * size && hi - lo > LARGEST.recip() {
        return (lo, hi);
    }
    let centre = 0.5 * lo + 0.5 * hi;
    let half = if centre.abs() > LARGEST.recip() { 0.1 * centre.abs() } else { 1.0 };
    (centre - half, centre + half)
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `raw`, and the power's exponent.
fn nice_step(raw: f64) -> (f64, i32) {
    let exponent = raw.log10().floor() as i32;
    for (m, k) in [(1.0, exponent), (2.0, exponent), (5.0, exponent), (1.0, exponent + 1)] {
        let step = m * power_of_ten(k);
        if step >= raw * (1.0 - 1e-9) {
            return (step, k);
        }
    }
    (power_of_ten(exponent + 1), exponent + 1)
}

/// The multiples of `step` within `lo..=hi`, not more than a hundred.
fn multiples(lo: f64, hi: f64, step: f64) -> Vec<f64> {
    let (first, last) = ((lo / step - 1e-6).ceil(), (hi / step + 1e-6).floor());
    (0..100).map(|i| first + f64::from(i)).take_while(|k| *k <= last).map(|k| k * step).collect()
}

pub(super) fn power_of_ten(k: i32) -> f64 {
    // A negative power by division, which rounds once: 1e-3 is then exactly the nearest number to 0.001.
    if k < 0 { 1.0 / 10f64.powi(-k) } else { 10f64.powi(k) }
}

/// How to write multiples of a step of this decimal exponent between `lo` and `hi`.
fn style(lo: f64, hi: f64, step_exponent: i32) -> Style {
    let size = lo.abs().max(hi.abs());
    if (1e-3..1e5).contains(&size) && step_exponent >= -6 {
        Style::Fixed((-step_exponent).max(0) as usize)
    } else {
        exponent_style(size, step_exponent)
    }
}

fn exponent_style(size: f64, step_exponent: i32) -> Style {
    Style::Exponent((size.log10().floor() as i32 - step_exponent).clamp(0, 9) as usize)
}

//! Colours that remain distinct to colour-blind readers, as SVG writes them.

/// Okabe and Ito's blue.
pub(super) const BLUE: &str = "#0072B2";
/// Okabe and Ito's vermillion.
pub(super) const VERMILLION: &str = "#D55E00";
/// Okabe and Ito's bluish green.
pub(super) const GREEN: &str = "#009E73";
/// Okabe and Ito's orange.
pub(super) const ORANGE: &str = "#E69F00";
/// The orange as a shade behind other things.
pub(super) const PALE_ORANGE: &str = "#F9EAC7";
/// A body without a quantity to colour it by.
pub(super) const PALE_BLUE: &str = "#DCE6EE";
/// Text, axes and the fourth series.
pub(super) const INK: &str = "#191919";
/// Undeformed outlines and remarks.
pub(super) const GREY: &str = "#6E6E6E";

/// Colours of the viridis map at equal steps.
const VIRIDIS: [[f64; 3]; 10] = [
    [68.0, 1.0, 84.0],
    [72.0, 40.0, 120.0],
    [62.0, 74.0, 137.0],
    [49.0, 104.0, 142.0],
    [38.0, 130.0, 142.0],
    [31.0, 158.0, 137.0],
    [53.0, 183.0, 121.0],
    [110.0, 206.0, 88.0],
    [181.0, 222.0, 43.0],
    [253.0, 231.0, 37.0],
];

/// The viridis map between 0 and 1: dark violet at 0, yellow at 1; red, green and blue.
pub(super) fn viridis(t: f64) -> [u8; 3] {
    let x = t * (VIRIDIS.len() - 1) as f64;
    let i = (x as usize).min(VIRIDIS.len() - 2);
    let f = x - i as f64;
    [0, 1, 2].map(|c| (VIRIDIS[i][c] * (1.0 - f) + VIRIDIS[i + 1][c] * f).round() as u8)
}

/// Reads a colour as this file writes it.
pub(super) fn parts(colour: &str) -> [u8; 3] {
    let part = |c: usize| colour.get(2 * c + 1..2 * c + 3).and_then(|text| u8::from_str_radix(text, 16).ok());
    [0, 1, 2].map(|c| part(c).unwrap_or_default())
}

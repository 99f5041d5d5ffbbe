//! Colours that remain distinct to colour-blind readers.

use plotters::style::RGBColor;

/// Okabe and Ito's blue.
pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Okabe and Ito's vermillion.
pub(super) const VERMILLION: RGBColor = RGBColor(213, 94, 0);
/// Okabe and Ito's bluish green.
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
/// Okabe and Ito's orange.
pub(super) const ORANGE: RGBColor = RGBColor(230, 159, 0);
/// The orange as it looks where it shades white paper.
pub(super) const PALE_ORANGE: RGBColor = RGBColor(249, 234, 199);
/// Text, axes and the fourth series.
pub(super) const INK: RGBColor = RGBColor(25, 25, 25);
/// Undeformed outlines and remarks.
pub(super) const GREY: RGBColor = RGBColor(110, 110, 110);

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

/// The viridis map: dark violet at 0, yellow at 1.
pub(super) fn viridis(t: f64) -> RGBColor {
    let x = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 } * (VIRIDIS.len() - 1) as f64;
    let i = (x.floor() as usize).min(VIRIDIS.len() - 2);
    let f = x - i as f64;
    let [r, g, b] = [0, 1, 2].map(|c| (VIRIDIS[i][c] * (1.0 - f) + VIRIDIS[i + 1][c] * f).round() as u8);
    RGBColor(r, g, b)
}

//! The sides of a pair.

/// The sign of the pressure's forces on a side: −1 on the first, from which the normal points.
pub(crate) fn side_sign(side: usize) -> f64 {
    if side == 0 { -1.0 } else { 1.0 }
}

//! The measured gap between two pairs: a cubic, if the surfaces represent smooth curves.
//!
//! Polygons on curved surfaces are apart by the square of their edge length, more than the deformation of the bodies. A
//! measured gap therefore follows the smooth curves through the nodes of the first meshes, and finer meshes use the
//! same curves.

use crate::body::Piece;

/// A gap that differs from a linear one by less than this fraction of the edge is linear.
const LINEAR: f64 = 1e-12;

/// The gap along a contact edge: the four Bernstein coefficients of a cubic, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    cubic: [f64; 4],
    /// The pieces of both bodies between which it was measured, if they are known exactly: finer meshes measure again.
    pub pieces: Option<[Piece; 2]>,
}

impl Profile {
    /// Creates the cubic with the given values at 0, ⅓, ⅔ and 1 of the edge; `None` if it is linear to round-off.
    ///
    /// * `length`: of the edge, m.
    pub fn through([a, b, c, d]: [f64; 4], length: f64) -> Option<Self> {
        let bend = [b - (2.0 * a + d) / 3.0, c - (a + 2.0 * d) / 3.0];
        let is_linear = bend.iter().all(|x| x.abs() <= LINEAR * length);
        let inner =
            [(-5.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / 6.0, (2.0 * a - 9.0 * b + 18.0 * c - 5.0 * d) / 6.0];
        let cubic = [a, inner[0], inner[1], d];
        (!is_linear && inner.iter().all(|x| x.is_finite())).then_some(Self { cubic, pieces: None })
    }

    /// Creates the cubic of a gap measured between two pieces, unless both are straight.
    ///
    /// * `ends`: the gaps at the two ends, m; `between`: those at ⅓ and ⅔.
    pub fn of_pieces(pieces: [Piece; 2], [a, d]: [f64; 2], [b, c]: [f64; 2], length: f64) -> Option<Self> {
        if let [Piece::Line { .. }, Piece::Line { .. }] = pieces {
            return None;
        }
        let linear = Self { cubic: [a, (2.0 * a + d) / 3.0, (a + 2.0 * d) / 3.0, d], pieces: None };
        let found = Self::through([a, b, c, d], length).unwrap_or(linear);
        Some(Self { pieces: Some(pieces), ..found })
    }

    /// Evaluates the distance at a fraction of the edge, m; it is negative if the smooth curves overlap, see [`super::Gap::kept`].
    pub fn at(&self, t: f64) -> f64 {
        let [a, b, c, d] = self.cubic;
        let s = 1.0 - t;
        s * s * s * a + 3.0 * s * t * (s * b + t * c) + t * t * t * d
    }

    /// Returns the profiles of the edge's two halves.
    pub fn halves(&self) -> [Self; 2] {
        let mean = |x: f64, y: f64| 0.5 * (x + y);
        let [a, b, c, d] = self.cubic;
        let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
        let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
        let middle = mean(abc, bcd);
        [[a, ab, abc, middle], [middle, bcd, cd, d]].map(|cubic| Self { cubic, ..*self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::Gap;
    use crate::space::Plane;

    #[test]
    fn halves_are_the_same_cubic() {
        let cubic = |t: f64| 1.0 + 0.5 * t - 2.0 * t * t + 1.25 * t * t * t;
        let profile = Profile::through([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(cubic), 1.0).unwrap();
        let [left, right] = profile.halves();
        for k in 0..=10 {
            let t = f64::from(k) / 10.0;
            assert!((profile.at(t) - cubic(t)).abs() < 1e-14);
            assert!((left.at(t) - cubic(0.5 * t)).abs() < 1e-14);
            assert!((right.at(t) - cubic(0.5 + 0.5 * t)).abs() < 1e-14);
        }
        assert_eq!(Profile::through([0.0, 1.0, 2.0, 3.0], 1.0), None);
        // An overlap counts as closed, unless it is kept.
        let overlap = Profile::through([0.0, -1.0, -1.0, 0.0], 1.0).unwrap().at(0.5);
        assert_eq!([Gap::<Plane>::Geometric, Gap::Interference].map(|gap| gap.kept(overlap)), [0.0, -1.125]);
    }
}

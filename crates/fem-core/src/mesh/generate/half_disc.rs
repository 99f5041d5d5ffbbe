//! Half discs with a fine mesh at the contact: Hertz contact.

use super::MAX_CELLS;
use crate::geometry::Vector;
use crate::mesh::{MeshError, TriMesh};
use std::f64::consts::{FRAC_PI_2, PI};

/// The side on which the pole of a half disc, the middle of its arc, lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// The arc is below, the flat side above.
    Down,
    /// The arc is above, the flat side below.
    Up,
}

/// Meshes a half disc with small cells near the pole.
///
/// ```text
///   ────────flat────────       a block of 2·cells × cells cells, as wide as the contact and half as deep, and
///    \ \  \ _____ /  / /       rays from its sides to the flat side whose steps grow with the distance
///  arc\  \ |block| /  /arc
///       `--contact--´          ← pole
/// ```
/// The sides are named `contact` (within `half_width` of the pole along x, nodes at equal steps of x, so that two half discs
/// of any radii match), `arc` (the rest of it) and `flat`.
///
/// * `pole`: the middle of the arc; `radius`: of the disc, m.
/// * `half_width`: of `contact` along x, m; at most 0.3 of the radius.
/// * `cells`: from the pole to the end of `contact`.
///
/// # Errors
/// Lengths that are not positive and finite, a contact too wide, no or too many cells.
pub fn half_disc(
    pole: impl Into<Vector>,
    radius: f64,
    facing: Facing,
    half_width: f64,
    cells: usize,
) -> Result<TriMesh, MeshError> {
    let pole = pole.into();
    let fault = |reason| Err(MeshError::Generator { kind: "half_disc", reason });
    if !(pole[0].is_finite() && pole[1].is_finite()) {
        return fault("the pole must be finite");
    }
    if !(radius > 0.0 && radius.is_finite() && half_width > 0.0) {
        return fault("radius and half width of the contact must be positive and finite");
    }
    if half_width > 0.3 * radius {
        return fault("the contact may be at most 0.3 radii wide to each side");
    }
    let n = cells;
    let layers = layers(radius, half_width, n);
    if n == 0 || n > MAX_CELLS || layers * 4.0 * n as f64 + (2 * n * n) as f64 > MAX_CELLS as f64 {
        return fault("at least one cell is needed, and at most 2^28 in total");
    }
    let grid = Grid { n, layers: layers as usize, radius, half_width };
    let sign = if facing == Facing::Down { 1.0 } else { -1.0 };
    let points = grid.points().into_iter().map(|p| pole + Vector::new(p[0], sign * p[1])).collect();
    let mut triangles = grid.cells();
    if facing == Facing::Up {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    TriMesh::new(points, triangles, grid.groups())
}

/// Counts the nodes of a [`half_disc`] without creating it.
pub fn half_disc_nodes(radius: f64, half_width: f64, cells: usize) -> u64 {
    let n = cells as f64;
    ((2.0 * n + 1.0) * (n + 1.0) + (4.0 * n + 1.0) * layers(radius, half_width, cells)) as u64
}

/// The number of steps along a ray that are about as long as the rays are apart.
fn layers(radius: f64, half_width: f64, cells: usize) -> f64 {
    ((radius / half_width).ln() / (PI / (4.0 * cells as f64)).ln_1p()).ceil().max(2.0)
}

/// The half disc with its arc below and its pole at the origin.
struct Grid {
    n: usize,
    layers: usize,
    radius: f64,
    half_width: f64,
}

impl Grid {
    /// Node of the block, column `i` of `2n`, row `j` of `n` from the arc.
    fn block(&self, i: usize, j: usize) -> u32 {
        (j * (2 * self.n + 1) + i) as u32
    }

    /// Node of ray `i` of `4n`, from the left end of the contact over the block to its right end; `j = 0` on the block.
    fn ray(&self, i: usize, j: usize) -> u32 {
        let n = self.n;
        if j == 0 {
            return match i {
                _ if i <= n => self.block(0, i),
                _ if i <= 3 * n => self.block(i - n, n),
                _ => self.block(2 * n, 4 * n - i),
            };
        }
        ((2 * n + 1) * (n + 1) + (j - 1) * (4 * n + 1) + i) as u32
    }

    fn on_arc(&self, x: f64) -> f64 {
        // This form avoids cancellation near the pole.
        x * x / (self.radius + ((self.radius - x) * (self.radius + x)).sqrt())
    }

    fn points(&self) -> Vec<Vector> {
        let (n, w, r) = (self.n, self.half_width, self.radius);
        let mut points = Vec::with_capacity((2 * n + 1) * (n + 1) + (4 * n + 1) * self.layers);
        let depth = self.on_arc(w) + w;
        for j in 0..=n {
            for i in 0..=2 * n {
                let x = w * (i as f64 - n as f64) / n as f64;
                let y = self.on_arc(x);
                points.push(Vector::new(x, y + (depth - y) * j as f64 / n as f64));
            }
        }
        let first = (w / r).asin();
        let ratio = (r / w).powf(1.0 / self.layers as f64);
        let steps = ratio.powi(self.layers as i32) - 1.0;
        for j in 1..=self.layers {
            let t = (ratio.powi(j as i32) - 1.0) / steps;
            let angle = first + t * (FRAC_PI_2 - first);
            // The point on the arc, and that on a straight ray from the end of the contact.
            let arc = Vector::new(r * angle.sin(), r * (1.0 - angle.cos()));
            let straight = Vector::new(w + t * (r - w), self.on_arc(w) + t * (r - self.on_arc(w)));
            let bulge = arc - straight;
            for i in 0..=4 * n {
                let inner = points[self.ray(i, 0) as usize];
                let s = i as f64 / (2 * n) as f64 - 1.0;
                let outer = Vector::new(r * s, r);
                if j == self.layers {
                    points.push(outer);
                    continue;
                }
                // The bulge of the outermost rays fades towards the middle.
                let p = inner + t * (outer - inner);
                points.push(p + Vector::new(s * s.abs() * bulge[0], s * s * bulge[1]));
            }
        }
        points
    }

    fn cells(&self) -> Vec<[u32; 3]> {
        let n = self.n;
        let mut triangles = Vec::with_capacity(4 * n * n + 8 * n * self.layers);
        // Corners counter-clockwise. The diagonals of the rays' two halves are mirror images. In the block they are parallel,
        // so that the pole has as many cells as its neighbours; with another number its nodal pressure is off by 5 %.
        let mut cut = |[a, b, c, d]: [u32; 4], left: bool| {
            triangles.extend(if left { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] });
        };
        for j in 0..n {
            for i in 0..2 * n {
                let corners =
                    [self.block(i, j), self.block(i + 1, j), self.block(i + 1, j + 1), self.block(i, j + 1)];
                cut(corners, false);
            }
        }
        for j in 0..self.layers {
            for i in 0..4 * n {
                let corners =
                    [self.ray(i, j), self.ray(i + 1, j), self.ray(i + 1, j + 1), self.ray(i, j + 1)];
                cut(corners, i < 2 * n);
            }
        }
        triangles
    }

    fn groups(&self) -> Vec<(String, Vec<[u32; 2]>)> {
        let n = self.n;
        let contact = (0..2 * n).map(|i| [self.block(i, 0), self.block(i + 1, 0)]).collect();
        let along = |i: usize, j: usize| [self.ray(i, j), self.ray(i, j + 1)];
        let arc = [0, 4 * n].into_iter().flat_map(|i| (0..self.layers).map(move |j| along(i, j))).collect();
        let flat = (0..4 * n).map(|i| [self.ray(i, self.layers), self.ray(i + 1, self.layers)]).collect();
        vec![("contact".to_string(), contact), ("arc".to_string(), arc), ("flat".to_string(), flat)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::norm;

    #[test]
    fn half_discs_are_round_flat_and_well_shaped() {
        for (facing, sign) in [(Facing::Down, 1.0), (Facing::Up, -1.0)] {
            for (width, cells) in [(0.1, 4), (0.29, 8), (0.02, 3)] {
                let m = half_disc([1.0, 2.0], 3.0, facing, 3.0 * width, cells).unwrap();
                assert_eq!(m.points().len() as u64, half_disc_nodes(3.0, 3.0 * width, cells));
                let centre = Vector::new(1.0, 2.0 + sign * 3.0);
                for name in ["contact", "arc"] {
                    for &e in m.group(name).unwrap() {
                        for node in m.topology().facets()[e] {
                            let r = norm(m.points()[node] - centre);
                            assert!((r - 3.0).abs() < 1e-13, "{r}");
                        }
                    }
                }
                for &e in m.group("flat").unwrap() {
                    assert_eq!(m.facet_normal(e), Vector::new(0.0, sign));
                }
                assert_eq!(m.group("contact").unwrap().len(), 2 * cells);
                let area: f64 = (0..m.cells().len()).map(|t| m.measure(t)).sum();
                assert!(area < 4.5 * PI && area > 4.5 * PI * 0.98, "{area}");
                assert!(m.smallest_angle() > 12.0, "{width} {cells}: {}", m.smallest_angle());
            }
        }
    }

    #[test]
    fn impossible_half_discs_are_refused() {
        let make = |radius, width, cells| half_disc([0.0, 0.0], radius, Facing::Up, width, cells);
        assert!(make(0.0, 0.1, 4).is_err());
        assert!(make(1.0, 0.8, 4).is_err());
        assert!(make(1.0, f64::NAN, 4).is_err());
        assert!(make(1.0, 0.1, 0).is_err());
        assert!(make(1.0, 0.1, usize::MAX).is_err());
    }
}

//! From cells in space to triangles of the plane: the plane, the split of quadrilaterals, the sense of corners.

use super::{MeshCell, MeshFault, MeshFile, MeshFileError};
use crate::words::counted;
use fem_core::geometry::{self, Coordinates, Vector, shown};

/// Coordinates that differ by less than this part of the mesh's size are the same.
pub(super) const SAME: f64 = 1e-9;

/// Triangles of a region and what was done to get them.
#[derive(Default)]
pub(super) struct Triangles {
    /// Corners, counter-clockwise, as places in the file's list of nodes.
    pub(super) corners: Vec<[u32; 3]>,
    /// The file's number of the cell each was made of.
    pub(super) cells: Vec<u64>,
    pub(super) split: usize,
    pub(super) reduced: usize,
    pub(super) turned: usize,
    /// Cells without an area: how many, and the first.
    pub(super) degenerate: usize,
    pub(super) first_degenerate: Option<MeshCell>,
}

impl Triangles {
    /// Says what was done to the cells.
    ///
    /// * `title`: what the cells belong to.
    pub(super) fn describe(&self, title: &str) -> Vec<String> {
        let done = [
            (self.split, "quadrilateral", "split into two triangles along the shorter diagonal"),
            (self.reduced, "quadratic cell", "reduced to the corners: curved sides become polygons"),
            (self.turned, "clockwise cell", "turned counter-clockwise"),
        ];
        let sentence = |(count, what, done): (usize, &str, &str)| {
            let was = if count == 1 { "was" } else { "were" };
            format!("{} of {title} {was} {done}", counted(count, what))
        };
        done.into_iter().filter(|(count, ..)| *count > 0).map(sentence).collect()
    }
}

impl MeshFile {
    /// Cuts cells into triangles with corners in the counter-clockwise sense.
    pub(super) fn triangulate(
        &self,
        cells: impl Iterator<Item = u32>,
        map: &dyn Fn(u32) -> u32,
    ) -> Triangles {
        let mut out = Triangles::default();
        for cell in cells.filter_map(|c| self.cells.get(c as usize)) {
            out.reduced += usize::from(cell.kind.is_quadratic());
            let corners = cell.first_four().map(map);
            let done = if cell.kind.corners() == 4 {
                out.split += 1;
                self.split(corners)
            } else {
                self.turn([corners[0], corners[1], corners[2]]).map(|(t, turned)| ([t; 2], turned))
            };
            match done {
                Some((triangles, turned)) => {
                    out.turned += usize::from(turned);
                    // Two of a quadrilateral, one of a triangle.
                    for triangle in &triangles[..cell.kind.corners() - 2] {
                        out.corners.push(*triangle);
                        out.cells.push(cell.number);
                    }
                }
                None => {
                    out.degenerate += 1;
                    out.first_degenerate.get_or_insert(*cell);
                }
            }
        }
        out
    }

    pub(super) fn xy(&self, node: u32) -> Vector {
        let [x, y, _] = self.points[node as usize];
        Vector::new(x, y)
    }

    /// Turns a triangle counter-clockwise; nothing for one without an area.
    fn turn(&self, t: [u32; 3]) -> Option<([u32; 3], bool)> {
        let area = geometry::sure_area(t.map(|n| self.xy(n)))?;
        Some(if area > 0.0 { (t, false) } else { ([t[0], t[2], t[1]], true) })
    }

    /// Splits a quadrilateral along its shorter diagonal, or along the other one if that one lies outside.
    fn split(&self, corners: [u32; 4]) -> Option<([[u32; 3]; 2], bool)> {
        let p = corners.map(|n| self.xy(n));
        let diagonals = [p[2] - p[0], p[3] - p[1]];
        let turned = geometry::cross(diagonals[0], diagonals[1]) < 0.0;
        let [a, b, c, d] = corners;
        let [a, b, c, d] = if turned { [a, d, c, b] } else { [a, b, c, d] };
        let first = [[a, b, c], [a, c, d]];
        let second = [[a, b, d], [b, c, d]];
        // Equal diagonals go through the first corner, independently of round-off.
        let first_is_shorter = geometry::norm(diagonals[0]) <= (1.0 + SAME) * geometry::norm(diagonals[1]);
        let order = if first_is_shorter { [first, second] } else { [second, first] };
        let sound = |pair: &[[u32; 3]; 2]| {
            pair.iter().all(|t| geometry::sure_area(t.map(|n| self.xy(n))).is_some_and(|area| area > 0.0))
        };
        order.into_iter().find(sound).map(|pair| (pair, turned))
    }

    /// Computes the two corners of the box around some nodes.
    pub(super) fn extent(&self, nodes: &[u32]) -> [[f64; 3]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &node in nodes {
            for (c, x) in self.points[node as usize].into_iter().enumerate() {
                (low[c], high[c]) = (low[c].min(x), high[c].max(x));
            }
        }
        [low, high]
    }

    /// Counts pairs of nodes at one place, of which there is at least one, and describes the first.
    ///
    /// * `title`: what the nodes belong to.
    pub(super) fn twins(&self, pairs: &[[u32; 2]], nodes: &[u32], title: &str) -> String {
        let [a, b] = pairs.first().map_or([0; 2], |pair| pair.map(|k| nodes[k as usize]));
        let place = self.points[a as usize].map(shown);
        let place = place[..if self.has_volumes() { 3 } else { 2 }].join(", ");
        let [a, b] = [a, b].map(|node| self.node_numbers[node as usize]);
        let others = if pairs.len() == 1 { "coincides with another" } else { "coincide with others" };
        format!("{} of {title} {others} (nodes {a} and {b} at ({place}))", counted(pairs.len(), "node"))
    }

    /// Checks that nodes lie in a plane of constant z; returns a note about that z if it is not zero.
    ///
    /// * `title`: what the nodes belong to.
    pub(super) fn check_plane(&self, nodes: &[u32], title: &str) -> Result<Option<String>, MeshFileError> {
        let [low, high] = self.extent(nodes);
        let extent = [0, 1, 2].map(|c| high[c] - low[c]);
        let tolerance = SAME * extent[0].max(extent[1]).max(extent[2]);
        if extent[2] <= tolerance || nodes.is_empty() {
            let z = low[2];
            return Ok((z.is_finite() && z.abs() > tolerance)
                .then(|| format!("all nodes of {title} have z = {}, which is left out", shown(z))));
        }
        let outside = nodes.iter().find(|n| self.points[**n as usize][2] != low[2]);
        let number = outside.map_or(0, |n| self.node_numbers[*n as usize]);
        let found = format!(
            "the mesh is not plane: z runs from {} to {} (node {number} is one that leaves the plane)",
            low[2], high[2]
        );
        let flat = [0, 1].into_iter().find(|c| extent[*c] <= tolerance);
        let help = match flat {
            Some(0) => "the mesh lies in the y-z plane: turn it into the x-y plane, or swap the coordinates",
            Some(_) => "the mesh lies in the x-z plane: turn it into the x-y plane, or swap the coordinates",
            None => "mesh the flat region itself, not a curved surface or the skin of a volume",
        };
        Err(self.fault(MeshFault::Content, found).expected("one value of z for all nodes").help(help))
    }
}

/// Computes the smallest angle of a triangle, degrees.
pub(super) fn smallest_angle(p: [Vector; 3]) -> f64 {
    let mut sides = [0, 1, 2].map(|k| geometry::norm(p[(k + 1) % 3] - p[k]));
    sides.sort_by(f64::total_cmp);
    // The angle against the shortest side lies between the other two.
    let sine = 2.0 * geometry::signed_area(p).abs() / (sides[1] * sides[2]);
    if sine.is_finite() { sine.min(1.0).asin().to_degrees() } else { 0.0 }
}

/// Returns an integer that is ordered as [`f64::total_cmp`] orders the number.
fn ordered(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

/// Tells whether a triangle certainly has no angle below a limit whose sine is given; in doubt it does not.
pub(super) fn is_wide([a, b, c]: [Vector; 3], sine: f64) -> bool {
    let mut squares = [b - a, c - b, a - c].map(|side| side.norm_squared());
    squares.sort_by(f64::total_cmp);
    // Twice the limit, for rounding; NaN and what overflows is in doubt.
    (2.0 * geometry::signed_area([a, b, c])).powi(2) > 4.0 * sine * sine * squares[1] * squares[2]
}

/// Finds nodes at the same place: pairs of the place kept and the one that equals it.
pub(super) fn coincident<V: Coordinates>(points: &[V]) -> Vec<[u32; 2]> {
    let tolerance = SAME * geometry::diagonal(points);
    let at = |n: u32, c: usize| points[n as usize][c];
    let mut by_x: Vec<(i64, u32)> = (0..points.len() as u32).map(|n| (ordered(at(n, 0)), n)).collect();
    by_x.sort_unstable();
    let mut order: Vec<u32> = by_x.into_iter().map(|(_, n)| n).collect();
    let mut pairs = Vec::new();
    for run in order.chunk_by_mut(|a, b| at(*b, 0) - at(*a, 0) <= tolerance) {
        near_in_run(points, run, 1, tolerance, &mut pairs);
    }
    pairs.sort_unstable_by_key(|[a, b]| (*b, *a));
    pairs
}

/// Adds the pairs of a run of nodes whose coordinates before an axis are chains of near ones.
fn near_in_run<V: Coordinates>(
    points: &[V],
    run: &mut [u32],
    axis: usize,
    tolerance: f64,
    pairs: &mut Vec<[u32; 2]>,
) {
    let at = |n: u32, c: usize| points[n as usize][c];
    let last = V::ZERO.entries().len() - 1;
    run.sort_by(|a, b| at(*a, axis).total_cmp(&at(*b, axis)).then(a.cmp(b)));
    if axis < last {
        for near in run.chunk_by_mut(|a, b| at(*b, axis) - at(*a, axis) <= tolerance) {
            near_in_run(points, near, axis + 1, tolerance, pairs);
        }
        return;
    }
    let is_near = |a: &u32, b: &u32| (0..=last).all(|c| (at(*b, c) - at(*a, c)).abs() <= tolerance);
    for near in run.chunk_by(is_near) {
        let kept = near.iter().copied().min().unwrap_or(0);
        pairs.extend(near.iter().filter(|n| **n != kept).map(|n| [kept, *n]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_ordered_as_their_numbers() {
        let numbers = [f64::NEG_INFINITY, -2.0, -1e-300, -0.0, 0.0, 1e-300, 3.0, f64::INFINITY];
        assert!(numbers.map(ordered).is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn only_triangles_without_doubt_are_wide() {
        let triangle = |degrees: f64, size: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            [[0.0, 0.0], [size, 0.0], [size * cosine, size * sine]].map(Vector::from)
        };
        let sine = 0.1f64.to_radians().sin();
        let wide = |degrees, size| is_wide(triangle(degrees, size), sine);
        assert!(wide(0.21, 1.0) && wide(60.0, 1e-3) && wide(0.21, 1e30));
        // Below the limit, near it, and so small or large that squares are lost.
        assert!(!wide(0.05, 1.0) && !wide(0.15, 1.0) && !wide(60.0, 1e-200) && !wide(60.0, 1e200));
    }
}

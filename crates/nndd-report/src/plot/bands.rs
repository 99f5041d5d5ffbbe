//! A field that is linear in each triangle, as filled bands between equal steps of a colour scale.
//!
//! Band `k` is the region where the field is at least `k / BANDS`, drawn over the bands below it: so there are no seams, and the
//! lines between the bands are level lines of the field itself. Inner edges of a region cancel; the file grows with
//! the length of these lines, not with the number of triangles.

use super::colour::viridis;
use crate::nodal::NodalPatch;
use fem_core::geometry::{Vector, cross};
use fem_core::mesh::id::NodeId;
use fem_core::parallel::each_task;
use std::fmt::Write as _;

/// Bands of the colour scale.
pub(super) const BANDS: usize = 40;
/// Points of a line nearer to each other than this are drawn as one, in units of the sheet.
const FINE: f64 = 4.0;
/// Closed lines around less than this are not drawn, in square units: a square pixel.
const SPECK: f64 = 16.0;

/// Above this length, in bytes, fewer bands are drawn.
const LARGEST: usize = 1_000_000;

/// A point of a band's boundary: a node, twice, or the place on an edge where the field passes the level.
type Place = [u32; 2];

/// The colour of a band.
pub(super) fn colour_of(band: usize) -> String {
    let [r, g, b] = parts_of(band);
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Red, green and blue of a band.
pub(super) fn parts_of(band: usize) -> [u8; 3] {
    viridis((band as f64 + 0.5) / BANDS as f64)
}

/// Returns the SVG elements of some patches.
///
/// * `patches`: each with the places of the mesh's points on the sheet.
/// * `position`: places a value on the colour scale, 0 to 1.
pub(super) fn elements(
    patches: &[(&NodalPatch, &[Option<Vector>])],
    position: impl Fn(f64) -> f64 + Sync,
) -> String {
    let height = |value: &f64| position(*value).clamp(0.0, 1.0);
    let heights: Vec<Vec<f64>> =
        patches.iter().map(|(patch, _)| patch.values.iter().map(height).collect()).collect();
    let surfaces: Vec<Surface<'_>> = each_task(patches.len(), |k| {
        let (patch, places) = patches[k];
        Surface::new(&patch.triangles, places, &heights[k])
    });
    let path = |band: usize| -> String { surfaces.iter().map(|surface| surface.above(band)).collect() };
    let paths: Vec<String> = each_task(BANDS, path);
    // The lines of a field that is mere noise fill the picture: then fewer bands are drawn.
    let length = |step: usize| paths.iter().step_by(step).map(String::len).sum::<usize>();
    let step = [1, 2, 4].into_iter().find(|step| length(*step) <= LARGEST).unwrap_or(8);
    // A line of the same colour hides the seams between patches.
    let mut out = "<g stroke-width=\"2\" stroke-linejoin=\"round\" fill-rule=\"evenodd\">\n".to_owned();
    for (band, path) in paths.iter().enumerate().step_by(step).filter(|(_, path)| !path.is_empty()) {
        let colour = colour_of(band + step / 2);
        let _ = writeln!(out, "<path fill=\"{colour}\" stroke=\"{colour}\" d=\"{path}\"/>");
    }
    out + "</g>\n"
}

/// The triangles of a patch that can be drawn, with the heights of their nodes.
struct Surface<'a> {
    triangles: Vec<[u32; 3]>,
    /// The edges of one triangle only, in its direction.
    rim: Vec<Place>,
    places: &'a [Option<Vector>],
    heights: &'a [f64],
    /// The uppermost band that holds each node.
    bands: Vec<u8>,
    /// The lowest and the uppermost of them in each triangle.
    spans: Vec<[u8; 2]>,
}

impl<'a> Surface<'a> {
    fn new(triangles: &[[NodeId; 3]], places: &'a [Option<Vector>], heights: &'a [f64]) -> Self {
        let known = |v: &u32| places[*v as usize].is_some() && heights[*v as usize].is_finite();
        let triangles: Vec<[u32; 3]> =
            triangles.iter().map(|t| t.map(|v| v.index() as u32)).filter(|t| t.iter().all(known)).collect();
        let bands: Vec<u8> = heights.iter().map(|height| band_of(*height)).collect();
        let span = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| bands[v as usize]);
            [a.min(b).min(c), a.max(b).max(c)]
        };
        let spans = triangles.iter().map(span).collect();
        Self { rim: rim(&triangles, places.len()), triangles, places, heights, bands, spans }
    }

    /// Returns the region of a band and those above it as closed lines.
    fn above(&self, band: usize) -> String {
        let inside = |v: u32| usize::from(self.bands[v as usize]) >= band;
        let between = |a: u32, b: u32| [a.min(b), a.max(b)];
        // The two ends of each piece of the boundary.
        let mut pieces: Vec<(Place, Place)> = Vec::new();
        for [a, b] in self.rim.iter().copied() {
            match (inside(a), inside(b)) {
                (true, true) => pieces.push(([a, a], [b, b])),
                (true, false) => pieces.push(([a, a], between(a, b))),
                (false, true) => pieces.push((between(a, b), [b, b])),
                (false, false) => {}
            }
        }
        let passes = |[low, high]: [u8; 2]| usize::from(low) < band && band <= usize::from(high);
        for ([a, b, c], _) in self.triangles.iter().zip(&self.spans).filter(|(_, span)| passes(**span)) {
            let edges = [[*a, *b], [*b, *c], [*c, *a]];
            let leaves = edges.iter().find(|[v, w]| inside(*v) && !inside(*w));
            let enters = edges.iter().find(|[v, w]| !inside(*v) && inside(*w));
            if let (Some([v, w]), Some([x, y])) = (leaves, enters) {
                pieces.push((between(*v, *w), between(*x, *y)));
            }
        }
        pieces.sort_unstable();
        let (mut path, mut used) = (String::new(), vec![false; pieces.len()]);
        for first in 0..pieces.len() {
            if used[first] {
                continue;
            }
            let (mut line, mut at) = (Vec::new(), Some(first));
            while let Some(k) = at {
                used[k] = true;
                line.push(self.place(pieces[k].0, level(band)));
                let (start, end) = (pieces.partition_point(|p| p.0 < pieces[k].1), pieces[k].1);
                at = (start..pieces.len()).take_while(|j| pieces[*j].0 == end).find(|j| !used[*j]);
            }
            if line.len() > 1 {
                closed(&mut path, &line);
            }
        }
        path
    }

    fn place(&self, [a, b]: Place, level: f64) -> Vector {
        let of = |v: u32| self.places[v as usize].unwrap_or_default();
        let [low, high] = [a, b].map(|v| self.heights[v as usize]);
        if a == b || low == high {
            return of(a);
        }
        of(a) + ((level - low) / (high - low)).clamp(0.0, 1.0) * (of(b) - of(a))
    }
}

/// The height at which a band begins.
fn level(band: usize) -> f64 {
    band as f64 / BANDS as f64
}

/// The uppermost band whose level is at most a height.
fn band_of(height: f64) -> u8 {
    (1..BANDS).take_while(|band| height >= level(*band)).count() as u8
}

/// The edges that belong to one triangle only, in its direction and sorted by node.
fn rim(triangles: &[[u32; 3]], nodes: usize) -> Vec<Place> {
    let edges = || triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    // By their smaller node, with the larger one and whether the triangle has them the other way round.
    let mut ends = vec![0; nodes + 1];
    edges().for_each(|[a, b]| ends[a.min(b) as usize + 1] += 1);
    for v in 0..nodes {
        ends[v + 1] += ends[v];
    }
    let mut sorted = vec![(0, false); 3 * triangles.len()];
    for [a, b] in edges() {
        let next = &mut ends[a.min(b) as usize];
        sorted[*next] = (a.max(b), b < a);
        *next += 1;
    }
    let (mut alone, mut start) = (Vec::new(), 0);
    for (a, end) in ends[..nodes].iter().enumerate() {
        let of_node = &mut sorted[start..*end];
        of_node.sort_unstable();
        let single = of_node.chunk_by(|p, q| p.0 == q.0).filter(|same| same.len() == 1).flatten();
        alone.extend(single.map(|(b, turned)| if *turned { [*b, a as u32] } else { [a as u32, *b] }));
        start = *end;
    }
    alone
}

/// Adds a closed line to a path, its points rounded to whole units.
fn closed(path: &mut String, line: &[Vector]) {
    let mut kept: Vec<Vector> = Vec::new();
    for p in line.iter().map(|p| p.map(f64::round)) {
        if kept.last().is_none_or(|q| (p - q).amax() >= FINE) {
            if let [.., a, b] = kept[..]
                && cross(b - a, p - b) == 0.0
                && (b - a).dot(&(p - b)) > 0.0
            {
                kept.pop();
            }
            kept.push(p);
        }
    }
    let Some(first) = kept.first().copied() else { return };
    let twice: f64 = kept.windows(2).map(|w| cross(w[0] - first, w[1] - first)).sum();
    if twice.abs() < 2.0 * SPECK {
        return;
    }
    let _ = write!(path, "M{} {}l", first[0], first[1]);
    for (k, pair) in kept.windows(2).enumerate() {
        let d = pair[1] - pair[0];
        let _ = write!(path, "{}{} {}", if k == 0 { "" } else { " " }, d[0], d[1]);
    }
    path.push('z');
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::mesh::TriMesh;

    /// A square of `n × n` cells on 400 × 400 units.
    fn square(n: usize) -> (Vec<[NodeId; 3]>, Vec<Option<Vector>>) {
        let at = |k: usize| 400.0 * k as f64 / n as f64;
        let id = |i: usize, j: usize| (j * (n + 1) + i) as u32;
        let points: Vec<[f64; 2]> = (0..=n).flat_map(|j| (0..=n).map(move |i| [at(i), at(j)])).collect();
        let cells = (0..n * n).map(|k| (k % n, k / n)).flat_map(|(i, j)| {
            [[id(i, j), id(i + 1, j), id(i + 1, j + 1)], [id(i, j), id(i + 1, j + 1), id(i, j + 1)]]
        });
        let mesh = TriMesh::new(points, cells.collect(), vec![]).unwrap();
        (mesh.cells().to_vec(), mesh.points().iter().map(|p| Some(*p)).collect())
    }

    /// The area inside the closed lines of a path.
    fn area(path: &str) -> f64 {
        let of = |line: &str| {
            let (start, steps) = line.trim_end_matches('z').split_once('l').unwrap();
            let numbers = |text: &str| -> Vec<f64> { text.split(' ').map(|n| n.parse().unwrap()).collect() };
            let mut at = Vector::from_column_slice(&numbers(start));
            let first = at;
            let mut twice = 0.0;
            for step in numbers(steps).chunks(2) {
                let next = at + Vector::new(step[0], step[1]);
                twice += cross(at - first, next - first);
                at = next;
            }
            0.5 * twice
        };
        path.split('M').skip(1).map(of).sum()
    }

    #[test]
    fn a_band_is_the_region_above_its_level() {
        let (triangles, places) = square(10);
        let heights: Vec<f64> = places.iter().flatten().map(|p| p[0] / 400.0).collect();
        let surface = Surface::new(&triangles, &places, &heights);
        for band in [0, 10, 20, 29] {
            let (path, below) = (surface.above(band), level(band));
            assert_eq!(path.matches('M').count(), 1);
            assert!((area(&path) - 160_000.0 * (1.0 - below)).abs() < 200.0, "{band}: {}", area(&path));
        }
    }

    #[test]
    fn holes_and_hills_are_closed_lines() {
        let (triangles, places) = square(20);
        let ring = |p: &Vector| 1.0 - ((p - Vector::new(200.0, 200.0)).norm() / 100.0 - 1.0).abs();
        let heights: Vec<f64> = places.iter().flatten().map(ring).collect();
        let path = Surface::new(&triangles, &places, &heights).above(BANDS / 2);
        assert_eq!(path.matches('M').count(), 2);
        // Between the radii 50 and 150, up to the cells.
        let exact = std::f64::consts::PI * (150.0f64.powi(2) - 50.0f64.powi(2));
        assert!((area(&path) / exact - 1.0).abs() < 0.02, "{} {exact}", area(&path));
    }

    #[test]
    fn what_is_not_known_is_left_out() {
        let (triangles, mut places) = square(4);
        places[12] = None;
        let mut heights = vec![0.5; places.len()];
        heights[0] = f64::NAN;
        let path = Surface::new(&triangles, &places, &heights).above(0);
        // 32 triangles of 5000 less six around the middle and two at the corner.
        assert!((area(&path) - 24.0 * 5000.0).abs() < 1.0, "{}", area(&path));
    }
}

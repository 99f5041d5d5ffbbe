//! Two triangulations of the same part of the plane, laid over each other.

use rstar::primitives::{GeomWithData, Line, Rectangle};
use rstar::{AABB, RTree};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::{BTreeMap, BTreeSet};

/// Nodes that are this part of the edges there apart are one, and a node this close to an edge is on it.
pub(super) const TOGETHER: f64 = 1e-9;
/// A triangle lies in a face if its centroid is this far inside, in barycentric coordinates. The centroid of a sound triangle is farther inside.
const INSIDE: f64 = 1e-6;
/// The parts of a face add up to it to this part of its area.
const WHOLE: f64 = 1e-7;
/// Triangles that are lower than this part of the faces they lie in are refused: the cells over them would be useless.
const THIN: f64 = 1e-3;

/// A point of the plane.
pub(super) type Flat = [f64; 2];

/// A triangulation.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    pub(super) points: Vec<Flat>,
    pub(super) faces: Vec<[usize; 3]>,
}

/// A point of the common triangulation, and the node of each patch that it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub(super) at: Flat,
    pub(super) nodes: [Option<usize>; 2],
}

/// An edge of a patch, from the node with the smaller number, and the vertices on it with their places from 0 to 1, ascending.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    pub(super) ends: [usize; 2],
    pub(super) on: Vec<(f64, usize)>,
}

/// A triangle of the common triangulation, and the face of each patch that it lies in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) corners: [usize; 3],
    pub(super) faces: [Option<usize>; 2],
}

/// The common triangulation of two patches.
#[derive(Clone, Debug)]
pub(super) struct Arrangement {
    pub(super) vertices: Vec<Vertex>,
    pub(super) chains: [Vec<Chain>; 2],
    pub(super) triangles: Vec<Triangle>,
    /// The smallest height of a triangle over the size of the smaller face around it.
    pub(super) lowest: f64,
}

/// Why two patches have no common triangulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fault {
    /// Nodes or edges are too close to each other, at this point: a triangle would be of this part of the faces there.
    Thin(Flat, f64),
    /// A patch covers itself at this point.
    Folded(Flat),
}

pub(super) fn minus(a: Flat, b: Flat) -> Flat {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn cross(a: Flat, b: Flat) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn length(a: Flat) -> f64 {
    a[0].hypot(a[1])
}

pub(super) fn mix(a: Flat, b: Flat, t: f64) -> Flat {
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

/// Computes twice the signed area of a triangle.
fn twice_area([a, b, c]: [Flat; 3]) -> f64 {
    cross(minus(b, a), minus(c, a))
}

fn centroid(corners: [Flat; 3]) -> Flat {
    std::array::from_fn(|k| corners.iter().map(|x| x[k]).sum::<f64>() / 3.0)
}

/// Computes barycentric coordinates.
pub(super) fn barycentric(corners: [Flat; 3], x: Flat) -> [f64; 3] {
    let [a, b, c] = corners;
    let whole = twice_area(corners);
    [twice_area([x, b, c]), twice_area([a, x, c]), twice_area([a, b, x])].map(|part| part / whole)
}

impl Patch {
    fn corners(&self, face: usize) -> [Flat; 3] {
        self.faces[face].map(|node| self.points[node])
    }

    /// Lists the edges, each once, from the node with the smaller number.
    pub(super) fn edges(&self) -> BTreeSet<[usize; 2]> {
        let of = |[a, b, c]: &[usize; 3]| [[*a, *b], [*b, *c], [*c, *a]];
        self.faces.iter().flat_map(of).map(|[a, b]| [a.min(b), a.max(b)]).collect()
    }

    /// Returns the length of the shortest edge at each node.
    pub(super) fn spacing(&self) -> Vec<f64> {
        let mut spacing = vec![f64::INFINITY; self.points.len()];
        for ends in self.edges() {
            let [a, b] = ends.map(|node| self.points[node]);
            ends.iter().for_each(|node| spacing[*node] = spacing[*node].min(length(minus(b, a))));
        }
        spacing
    }
}

/// Lays two patches over each other: vertices are the nodes of both and the crossings of their edges, and the triangles are Delaunay's, constrained by
/// the edges of both.
///
/// # Errors
/// Triangles that are too thin, a patch that covers itself.
pub(super) fn arrange(patches: &[Patch; 2]) -> Result<Arrangement, Fault> {
    let (mut vertices, vertex_of) = joined(patches);
    let mut chains = [0, 1].map(|b: usize| {
        let chain = |ends| Chain { ends, on: Vec::new() };
        patches[b].edges().into_iter().map(chain).collect::<Vec<_>>()
    });
    cross_chains(&mut vertices, &vertex_of, &mut chains);
    let mut segments: BTreeSet<[usize; 2]> = BTreeSet::new();
    for (chains, vertex_of) in chains.iter_mut().zip(&vertex_of) {
        for chain in chains {
            chain.on.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            chain.on.dedup_by_key(|(_, vertex)| *vertex);
            let [first, last] = chain.ends.map(|node| vertex_of[node]);
            let all: Vec<usize> = std::iter::once(first)
                .chain(chain.on.iter().map(|(_, vertex)| *vertex))
                .chain(std::iter::once(last))
                .collect();
            segments.extend(all.windows(2).map(|w| [w[0].min(w[1]), w[0].max(w[1])]));
        }
    }
    let corners = triangulated(&vertices, segments)?;
    let (triangles, lowest) = located(patches, &vertices, corners)?;
    Ok(Arrangement { vertices, chains, triangles, lowest })
}

/// Joins the nodes of both patches that are at the same place, and returns the vertex of each node.
fn joined(patches: &[Patch; 2]) -> (Vec<Vertex>, [Vec<usize>; 2]) {
    let spacing = [patches[0].spacing(), patches[1].spacing()];
    let first = patches[0].points.iter().enumerate();
    let tree = RTree::bulk_load(first.clone().map(|(k, at)| GeomWithData::new(*at, k)).collect());
    let mut vertices: Vec<Vertex> = first.map(|(k, at)| Vertex { at: *at, nodes: [Some(k), None] }).collect();
    let mut second = Vec::with_capacity(patches[1].points.len());
    for (k, at) in patches[1].points.iter().enumerate() {
        let near = tree.nearest_neighbor(at).map(|near| near.data).filter(|&n| {
            let apart = length(minus(vertices[n].at, *at));
            apart <= TOGETHER * spacing[0][n].min(spacing[1][k]) && vertices[n].nodes[1].is_none()
        });
        second.push(near.unwrap_or(vertices.len()));
        match near {
            Some(n) => vertices[n].nodes[1] = Some(k),
            None => vertices.push(Vertex { at: *at, nodes: [None, Some(k)] }),
        }
    }
    (vertices, [(0..patches[0].points.len()).collect(), second])
}

/// Puts the vertices of each patch that lie on edges of the other, and the crossings of their edges, on these edges.
fn cross_chains(vertices: &mut Vec<Vertex>, vertex_of: &[Vec<usize>; 2], chains: &mut [Vec<Chain>; 2]) {
    let [first, second] = chains;
    let line = |(k, chain): (usize, &Chain)| {
        let [a, b] = chain.ends.map(|node| vertices[vertex_of[1][node]].at);
        GeomWithData::new(Line::new(a, b), k)
    };
    let tree = RTree::bulk_load(second.iter().enumerate().map(line).collect());
    for own in first {
        let e = own.ends.map(|node| vertex_of[0][node]);
        let [a, b] = e.map(|vertex| vertices[vertex].at);
        let margin = TOGETHER * length(minus(b, a));
        let low = [a[0].min(b[0]) - margin, a[1].min(b[1]) - margin];
        let high = [a[0].max(b[0]) + margin, a[1].max(b[1]) + margin];
        for near in tree.locate_in_envelope_intersecting(&AABB::from_corners(low, high)) {
            let other = &mut second[near.data];
            let f = other.ends.map(|node| vertex_of[1][node]);
            let [c, d] = f.map(|vertex| vertices[vertex].at);
            let mut touching = e.iter().any(|vertex| f.contains(vertex));
            let apart = |of: [usize; 2], ends: [usize; 2]| of.into_iter().filter(move |v| !ends.contains(v));
            for vertex in apart(f, e) {
                if let Some(t) = along([a, b], vertices[vertex].at) {
                    own.on.push((t, vertex));
                    touching = true;
                }
            }
            for vertex in apart(e, f) {
                if let Some(t) = along([c, d], vertices[vertex].at) {
                    other.on.push((t, vertex));
                    touching = true;
                }
            }
            if touching {
                continue;
            }
            let [of_a, of_b] = [a, b].map(|x| twice_area([c, d, x]));
            let [of_c, of_d] = [c, d].map(|x| twice_area([a, b, x]));
            if (of_a < 0.0) != (of_b < 0.0) && (of_c < 0.0) != (of_d < 0.0) {
                let (t, s) = (of_a / (of_a - of_b), of_c / (of_c - of_d));
                own.on.push((t, vertices.len()));
                other.on.push((s, vertices.len()));
                vertices.push(Vertex { at: mix(a, b, t), nodes: [None; 2] });
            }
        }
    }
}

/// Returns the place of a point on a segment, between 0 and 1; `None` if it is not on it.
fn along([a, b]: [Flat; 2], x: Flat) -> Option<f64> {
    let (edge, arm) = (minus(b, a), minus(x, a));
    let size = length(edge);
    let t = (edge[0] * arm[0] + edge[1] * arm[1]) / (size * size);
    ((cross(edge, arm) / size).abs() <= TOGETHER * size && t > 0.0 && t < 1.0).then_some(t)
}

/// Triangulates the vertices such that no triangle crosses a segment.
fn triangulated(vertices: &[Vertex], segments: BTreeSet<[usize; 2]>) -> Result<Vec<[usize; 3]>, Fault> {
    // Coordinates of the size of one: the library refuses very small and large ones.
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for vertex in vertices {
        for k in 0..2 {
            (low[k], high[k]) = (low[k].min(vertex.at[k]), high[k].max(vertex.at[k]));
        }
    }
    let scale = 1.0 / length(minus(high, low)).max(f64::MIN_POSITIVE);
    let place =
        |vertex: &Vertex| Point2::new(scale * (vertex.at[0] - low[0]), scale * (vertex.at[1] - low[1]));
    let mut conflict: Option<[usize; 2]> = None;
    let found = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        vertices.iter().map(place).collect(),
        segments.into_iter().collect(),
        |segment| conflict = Some(segment),
    );
    let crossed = || conflict.and_then(|[a, _]| vertices.get(a)).map_or(low, |vertex| vertex.at);
    let found = found.map_err(|_| Fault::Thin(crossed(), 0.0))?;
    if conflict.is_some() || found.num_vertices() != vertices.len() {
        return Err(Fault::Thin(crossed(), 0.0));
    }
    Ok(found.inner_faces().map(|face| face.vertices().map(|vertex| vertex.index())).collect())
}

/// Finds the faces that triangles lie in, and keeps those that lie in one; and the smallest height over the size of a face.
fn located(
    patches: &[Patch; 2],
    vertices: &[Vertex],
    corners: Vec<[usize; 3]>,
) -> Result<(Vec<Triangle>, f64), Fault> {
    let trees = [0, 1].map(|b: usize| {
        let of = |face: usize| {
            let corners = patches[b].corners(face);
            let low: Flat =
                std::array::from_fn(|k| corners.iter().map(|x| x[k]).fold(f64::INFINITY, f64::min));
            let high: Flat =
                std::array::from_fn(|k| corners.iter().map(|x| x[k]).fold(f64::NEG_INFINITY, f64::max));
            GeomWithData::new(Rectangle::from_corners(low, high), face)
        };
        RTree::bulk_load((0..patches[b].faces.len()).map(of).collect())
    });
    let mut covered = [0, 1].map(|b: usize| vec![0.0; patches[b].faces.len()]);
    let (mut triangles, mut lowest) = (Vec::new(), f64::INFINITY);
    for corners in corners {
        let places = corners.map(|vertex| vertices[vertex].at);
        let (middle, area) = (centroid(places), twice_area(places).abs());
        let mut faces = [None; 2];
        let mut size = f64::INFINITY;
        for b in 0..2 {
            let around = trees[b].locate_in_envelope_intersecting(&AABB::from_point(middle));
            for face in around.map(|near| near.data) {
                let of_face = patches[b].corners(face);
                if barycentric(of_face, middle).iter().all(|part| *part >= INSIDE) {
                    if faces[b].is_some() {
                        return Err(Fault::Folded(middle));
                    }
                    faces[b] = Some(face);
                    covered[b][face] += area;
                    size = size.min(twice_area(of_face).abs().sqrt());
                }
            }
        }
        if faces == [None; 2] {
            continue;
        }
        let [p, q, r] = places;
        let longest = [minus(q, p), minus(r, q), minus(p, r)].map(length).into_iter().fold(0.0, f64::max);
        let height = area / longest / size;
        if !(height >= THIN) {
            return Err(Fault::Thin(middle, height));
        }
        lowest = lowest.min(height);
        triangles.push(Triangle { corners, faces });
    }
    for (patch, covered) in patches.iter().zip(&covered) {
        for (face, covered) in covered.iter().enumerate() {
            let (corners, all) = (patch.corners(face), twice_area(patch.corners(face)).abs());
            if !((covered - all).abs() <= WHOLE * all) {
                return Err(Fault::Thin(centroid(corners), 0.0));
            }
        }
    }
    Ok((triangles, lowest))
}

/// Lists the triangles of each face of a patch.
pub(super) fn by_face(triangles: &[Triangle], patch: usize) -> BTreeMap<usize, Vec<[usize; 3]>> {
    let mut parts: BTreeMap<usize, Vec<[usize; 3]>> = BTreeMap::new();
    for triangle in triangles {
        if let Some(face) = triangle.faces[patch] {
            parts.entry(face).or_default().push(triangle.corners);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of `n` by `n` cells, of two triangles each, turned and moved.
    fn square(n: usize, (low, size): (Flat, f64), angle: f64) -> Patch {
        let (sine, cosine) = angle.sin_cos();
        let at = |i: usize, j: usize| {
            let [x, y] = [low[0] + size * i as f64 / n as f64, low[1] + size * j as f64 / n as f64];
            [cosine * x - sine * y, sine * x + cosine * y]
        };
        let node = |i: usize, j: usize| j * (n + 1) + i;
        let cells = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let faces = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        let points = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
        Patch { points, faces: faces.collect() }
    }

    fn area(found: &Arrangement, wanted: impl Fn(&Triangle) -> bool) -> f64 {
        let of = |t: &Triangle| twice_area(t.corners.map(|v| found.vertices[v].at)).abs() / 2.0;
        found.triangles.iter().filter(|t| wanted(t)).map(of).sum()
    }

    #[test]
    fn squares_of_any_cells_cover_each_other() {
        for (m, n, angle) in [(1, 1, 0.0), (2, 3, 0.0), (6, 7, 0.4), (5, 9, 1.0), (4, 8, 0.3)] {
            let patches = [m, n].map(|cells| square(cells, ([0.0, 0.0], 2.0), angle));
            let found = arrange(&patches).unwrap();
            let both = area(&found, |t| t.faces.iter().all(Option::is_some));
            assert!((both - 4.0).abs() < 1e-12, "{m} {n}: {both}");
            assert_eq!(found.triangles.len() == patches[1].faces.len(), n % m == 0, "{m} {n}");
        }
    }

    #[test]
    fn a_small_square_leaves_the_rest_of_a_large_one() {
        for angle in [0.0, 0.7] {
            let large = square(2, ([0.0, 0.0], 3.0), angle);
            // In the inside of one face, and across the rim.
            for (low, common) in [([1.7, 1.55], 0.04), ([2.9, 1.0], 0.02)] {
                let found = arrange(&[square(2, (low, 0.2), angle), large.clone()]).unwrap();
                let both = area(&found, |t| t.faces.iter().all(Option::is_some));
                assert!((both - common).abs() < 1e-12, "{both}");
                assert!((area(&found, |t| t.faces[1].is_some()) - 9.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn patches_that_are_almost_the_same_are_refused() {
        let shifted =
            |by: f64| arrange(&[square(3, ([0.0, 0.0], 1.0), 0.2), square(3, ([by, 0.0], 1.0), 0.2)]);
        assert!(shifted(1e-13).is_ok());
        assert!(matches!(shifted(1e-6), Err(Fault::Thin(_, height)) if height < 1e-3));
        assert!((shifted(0.05).unwrap().lowest - 0.1).abs() < 0.1);
    }
}

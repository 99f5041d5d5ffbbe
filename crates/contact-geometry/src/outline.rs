//! Contact sides of declared curves and straight stretches: they are known exactly, whatever the first mesh.
//!
//! At a node between two pieces that meet within 1 degree the normal is the mean of theirs, weighted by the lengths of the edges. Beyond that it is a
//! corner, at which the contact line ends.

use fem_core::body::{Body, Piece};
use fem_core::geometry::{Vector, angle_between, cross, norm};
use fem_core::interface::{ContactFacet, NodePair, Radial};
use fem_core::mesh::id::FacetId;

/// Nodes of a straight stretch may be this fraction of its length off the line.
const COLLINEAR: f64 = 1e-9;
/// Pieces that meet at a smaller angle have one tangent, radians.
const TANGENT: f64 = 1e-9;
/// Pieces that meet at a larger angle make a corner, 1 degree in radians.
pub(super) const CORNER: f64 = std::f64::consts::PI / 180.0;

/// Finds the piece over each edge of a contact side: the declared curve, or the line of a straight stretch. An undeclared side that is
/// bent has none.
///
/// A side without declared curves is straight as a whole. Beside declared curves a stretch of two edges is, or one between two of them.
///
/// * `edges`: of a connected part, in order; `points`: its nodes, one more, a closed one ends with its first; `cut`: whether the part ends at a
///   corner of a longer one with declared curves.
pub(super) fn pieces(body: &Body, edges: &[FacetId], points: &[Vector], cut: bool) -> Vec<Option<Piece>> {
    let mut pieces: Vec<Option<Piece>> = edges.iter().map(|edge| body.curve(*edge).copied()).collect();
    let declared: Vec<bool> = pieces.iter().map(Option::is_some).collect();
    let is_curved = |k: usize| declared.get(k).is_none_or(|is| *is);
    let any = cut || declared.contains(&true);
    let mut from = 0;
    while from < edges.len() {
        let mut to = from + 1;
        if !declared[from] {
            while to < edges.len() && !declared[to] && continues(&points[from..=to + 1]) {
                to += 1;
            }
            let alone = (from == 0 || declared[from - 1]) && is_curved(to);
            if alone || (any && to > from + 1) {
                let way = points[to] - points[from];
                let line = Piece::Line { point: points[from], direction: 1.0 / norm(way) * way };
                pieces[from..to].fill(Some(line));
            }
        }
        from = to;
    }
    pieces
}

/// Tells whether the last of several points continues the line through the others.
fn continues(points: &[Vector]) -> bool {
    let (start, last) = (points[0], points.len() - 1);
    let (known, way) = (points[last - 1] - start, points[last] - start);
    let reach = norm(known).max(norm(way));
    known.dot(&way) > 0.0 && cross(known, way).abs() <= COLLINEAR * norm(known).min(norm(way)) * reach
}

/// The known pieces beside a node of a side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    /// Before and after it: the unit normal there, the length of the edge, and the piece.
    pieces: [Option<(Vector, f64, Piece)>; 2],
    /// True if the two are parts of one curve.
    same: bool,
}

impl Beside {
    /// Tells whether two known pieces meet at a corner.
    pub(super) fn is_corner(&self) -> bool {
        matches!(self.pieces, [Some((a, ..)), Some((b, ..))] if !self.same && angle_between(a, b) > CORNER)
    }

    /// Tells whether the pieces on both sides are known and make no corner.
    pub(super) fn is_smooth(&self) -> bool {
        self.pieces.iter().all(Option::is_some) && !self.is_corner()
    }

    /// Computes the normal: of the piece, and where two meet, the mean weighted by the lengths of the edges. `None` between edges without pieces.
    pub(super) fn normal(&self) -> Option<Vector> {
        match self.pieces {
            [Some((a, la, p)), Some((b, lb, q))] => {
                let tangent = angle_between(a, b) <= TANGENT;
                match (p, q) {
                    _ if p == q => Some(a),
                    // The edges of a straight stretch have one normal.
                    (Piece::Line { .. }, _) if tangent => Some(a),
                    (_, Piece::Line { .. }) if tangent => Some(b),
                    _ => Some(1.0 / norm(la * a + lb * b) * (la * a + lb * b)),
                }
            }
            [Some((normal, ..)), None] | [None, Some((normal, ..))] => Some(normal),
            [None, None] => None,
        }
    }
}

/// Finds the known pieces beside the nodes of a side.
///
/// * `outward`: the normal of each edge; `closed`: whether the last node is the first.
pub(super) fn beside(
    pieces: &[Option<Piece>],
    points: &[Vector],
    outward: impl Fn(usize) -> Vector,
    closed: bool,
) -> Vec<Beside> {
    let last = pieces.len();
    let one_sided = |k: usize, edge: usize| {
        let piece = pieces[edge]?;
        Some((piece.normal(points[k], outward(edge)), norm(points[edge + 1] - points[edge]), piece))
    };
    let at = |k: usize| {
        let before = if k > 0 { Some(k - 1) } else { closed.then(|| last - 1) };
        let after = if k < last { Some(k) } else { closed.then_some(0) };
        let pieces = [before, after].map(|edge| edge.and_then(|edge| one_sided(k, edge)));
        let same = matches!(pieces, [Some((.., p)), Some((.., q))] if p.continues(&q, points[k]));
        Beside { pieces, same }
    };
    (0..points.len()).map(at).collect()
}

/// Computes the unit normals at the nodes of a side with declared curves, see [`Beside::normal`]; `None` if no curve is declared.
///
/// * `closed`: see [`beside`]; `cut`: see [`pieces`].
pub(super) fn normals(
    pieces: &[Option<Piece>],
    points: &[Vector],
    outward: impl Fn(usize) -> Vector,
    [closed, cut]: [bool; 2],
) -> Vec<Option<Vector>> {
    let is_curve = |piece: &Option<Piece>| matches!(piece, Some(Piece::Arc { .. } | Piece::Smooth(_)));
    if !cut && !pieces.iter().any(is_curve) {
        return vec![None; points.len()];
    }
    beside(pieces, points, outward, closed).iter().map(Beside::normal).collect()
}

/// Divides a connected part at its corners: the numbers of the first and the last node of each stretch, and whether it begins and ends at a corner. A
/// closed part is divided from its first corner on, and its nodes are counted beyond its end.
///
/// * `edges`: their number; `corners`: numbers of nodes, ascending.
pub(super) fn divided(edges: usize, closed: bool, corners: &[usize]) -> Vec<([usize; 2], [bool; 2])> {
    let bounds: Vec<usize> = match corners.first() {
        Some(first) if closed => corners.iter().copied().chain([first + edges]).collect(),
        _ => [0].into_iter().chain(corners.iter().copied()).chain([edges]).collect(),
    };
    let all = closed && !corners.is_empty();
    let last = bounds.len() - 2;
    (0..=last).map(|k| ([bounds[k], bounds[k + 1]], [all || k > 0, all || k < last])).collect()
}

/// Returns centre and radius of the arc on which all edges are declared; `None` if they are not.
fn one_arc(body: &Body, mut edges: impl Iterator<Item = FacetId>) -> Option<(Vector, f64)> {
    let first = body.curve(edges.next()?)?;
    let &Piece::Arc { centre, radius } = first else { return None };
    edges.all(|edge| body.curve(edge) == Some(first)).then_some((centre, radius))
}

/// Tells whether all edges are declared as one arc.
pub(super) fn is_one_arc(body: &Body, edges: impl Iterator<Item = FacetId>) -> bool {
    one_arc(body, edges).is_some()
}

/// Directions that differ by less than this angle are the same, radians.
const SAME_DIRECTION: f64 = 1e-9;

/// Finds the arc from whose centre all normals point, or to which they point; `None` if there is no such arc. Of two the one of a body that
/// its supports do not hold.
pub(super) fn radial(bodies: [&Body; 2], pairs: &[NodePair], edges: &[ContactFacet]) -> Option<Radial> {
    let floats = bodies.map(|body| body.has_curves() && body.free_motion().is_some());
    let order = if floats[1] && !floats[0] { [1, 0] } else { [0, 1] };
    order.into_iter().find_map(|side| {
        let (centre, radius) = one_arc(bodies[side], edges.iter().map(|edge| edge.facets[side]))?;
        let points = bodies[side].mesh().points();
        let out = (points[pairs.first()?.nodes[side]] - centre).dot(&pairs[0].normal).signum();
        let found = Radial { side, centre, radius: out * radius };
        let agrees =
            |pair: &NodePair| angle_between(found.normal(bodies, pair.nodes), pair.normal) <= SAME_DIRECTION;
        pairs.iter().all(agrees).then_some(found)
    })
}

/// Measures the gap between two pieces on a line through a point, m, negative if they overlap; `None` if the line misses one.
///
/// * `normal`: out of the first body; `near`: points of the bodies near the place.
pub(super) fn gap(pieces: &[Piece; 2], point: Vector, normal: Vector, near: [Vector; 2]) -> Option<f64> {
    let unit = 1.0 / norm(normal) * normal;
    let meet = |b: usize| pieces[b].meet(point + (near[b] - point).dot(&unit) * unit, unit);
    Some((meet(1)? - meet(0)?).dot(&unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(centre: [f64; 2], radius: f64) -> Piece {
        Piece::Arc { centre: centre.into(), radius }
    }

    #[test]
    fn the_gap_past_a_tangent_point_is_that_of_the_arc() {
        let line = Piece::Line { point: Vector::new(1.0, 0.0), direction: Vector::x() };
        let pieces = [arc([5.0, 10.0], 10.0), line];
        for x in [0.0, 1e-4, 0.024, 0.3, 2.0] {
            let exact = 10.0 - (100.0f64 - x * x).sqrt();
            let point = Vector::new(5.0 + x, exact);
            let found = gap(&pieces, point, -Vector::y(), [point, Vector::new(3.0, 0.0)]).unwrap();
            assert!((found - exact).abs() < 1e-14, "{x}: {found:e} {exact:e}");
        }
    }

    #[test]
    fn the_normal_between_two_pieces_is_their_mean_weighted_by_length() {
        let turn = 0.5f64.to_radians();
        let points = [[-2.0, 0.0], [0.0, 0.0], [turn.cos(), -turn.sin()]].map(Vector::from);
        let straight = |k: usize| {
            let way = points[k + 1] - points[k];
            Piece::Line { point: points[k], direction: 1.0 / norm(way) * way }
        };
        let up = |_| Vector::y();
        let declared = [Some(straight(0)), Some(arc([0.0, -10.0], 10.0))];
        let found = normals(&declared, &points, up, [false; 2]);
        assert_eq!(found[1], Some(Vector::y()));
        let tilted = [Some(straight(0)), Some(arc([-10.0 * turn.sin(), -10.0 * turn.cos()], 10.0))];
        let mean = normals(&tilted, &points, up, [false; 2])[1].unwrap();
        let expected = Vector::new(turn.sin(), 2.0 + turn.cos());
        assert!(angle_between(mean, expected) < 1e-14, "{mean:?}");
        // Straight lines alone keep the normals of their edges.
        assert_eq!(normals(&[Some(straight(0)), Some(straight(1))], &points, up, [false; 2]), [None; 3]);
    }

    #[test]
    fn a_corner_has_two_normals_and_within_one_degree_there_is_their_mean() {
        for (degrees, corner) in [(5.0f64, true), (1.01, true), (0.99, false), (0.0, false)] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            // An arc of radius 2 that begins at the origin at this angle below the x axis.
            let centre = Vector::new(-2.0 * sine, -2.0 * cosine);
            let end = centre
                + 2.0
                    * Vector::new(
                        (2.0 * degrees.to_radians() + 0.1).sin(),
                        (2.0 * degrees.to_radians() + 0.1).cos(),
                    );
            let points = [Vector::new(-1.0, 0.0), Vector::zeros(), end];
            let line = Piece::Line { point: points[0], direction: Vector::x() };
            let pieces = [Some(line), Some(Piece::Arc { centre, radius: 2.0 })];
            let found = beside(&pieces, &points, |_| Vector::y(), false)[1];
            assert_eq!((found.is_corner(), found.is_smooth()), (corner, !corner), "{degrees}");
            let sided = found.pieces.map(|piece| piece.unwrap().0);
            assert_eq!(sided[0], Vector::y());
            assert!(angle_between(sided[1], Vector::new(sine, cosine)) < 1e-14);
            let mean = norm(points[1] - points[0]) * sided[0] + norm(end) * sided[1];
            assert!(angle_between(found.normal().unwrap(), mean) < 1e-14);
            // Each alone has its own normal.
            let alone =
                |k: usize| normals(&pieces[k..=k], &points[k..=k + 1], |_| Vector::y(), [false, true]);
            assert_eq!([alone(0)[1], alone(1)[0]], sided.map(Some));
        }
    }

    #[test]
    fn a_closed_part_is_divided_from_its_first_corner_on() {
        assert_eq!(divided(5, false, &[2]), [([0, 2], [false, true]), ([2, 5], [true, false])]);
        assert_eq!(divided(5, false, &[]), [([0, 5], [false, false])]);
        assert_eq!(divided(5, true, &[1, 3]), [([1, 3], [true, true]), ([3, 6], [true, true])]);
        assert_eq!(divided(5, true, &[4]), [([4, 9], [true, true])]);
        assert_eq!(divided(5, true, &[]), [([0, 5], [false, false])]);
    }
}

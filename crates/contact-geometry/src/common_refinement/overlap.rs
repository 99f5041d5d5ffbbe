//! The range in which two surfaces face each other, and the nodes of both along the common line.

use super::Facing;
use super::chain::{self, Chain, Fixed, Motion};
use super::curve::{Between, Curve};
use super::error::CommonRefinementError;
use super::line::{self, Line, Opposite, Uncut};
use crate::{ContactNormal, FACING};
use fem_core::body::Body;
use fem_core::geometry::{Vector, norm, right_normal};
use fem_core::mesh::id::NodeId;
use fem_core::smooth::is_off_chord;
use std::collections::HashMap;

/// Ends, corners and other fixed nodes are moved by at most this fraction of the smaller adjacent edge.
pub(super) const SAME: f64 = 0.01;
/// Fraction of the smaller adjacent edge up to which nodes face each other to round-off.
pub(super) const ROUND_OFF: f64 = 1e-9;
/// Fraction of the smaller adjacent edge below which nodes are snapped.
pub(super) const SNAP: f64 = 0.2;

/// A node at its place on the common line. A node of one side belongs to a node of the other if their `s` are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Site {
    pub(super) s: f64,
    pub(super) node: NodeId,
    pub(super) motion: Motion,
}

/// One stretch on which the surfaces face each other.
#[derive(Clone, Debug)]
pub(super) struct Overlap {
    pub(super) curve: Curve,
    /// The nodes of each body, `s` ascending; they may reach beyond the common range by one.
    pub(super) sites: [Vec<Site>; 2],
    /// The body on whose surface `s` is measured.
    reference: usize,
    /// The common range of `s`.
    pub(super) range: [f64; 2],
    /// Mean distance of the surfaces.
    distance: f64,
    /// Both surfaces before the cuts.
    uncut: [Uncut; 2],
}

impl Overlap {
    fn contains(&self, s: f64) -> bool {
        s >= self.range[0] && s <= self.range[1]
    }

    /// Returns the arc lengths of the other body's nodes between sites `k` and `k + 1` of body `b`.
    pub(super) fn targets(&self, b: usize, k: usize) -> impl DoubleEndedIterator<Item = f64> + '_ {
        let [from, to] = [self.sites[b][k].s, self.sites[b][k + 1].s];
        let other = &self.sites[1 - b];
        let start = other.partition_point(|x| x.s <= from);
        let end = other.partition_point(|x| x.s < to).max(start);
        other[start..end].iter().map(|x| x.s).filter(|s| self.contains(*s))
    }

    /// Returns the pairs of neighbouring sites of body `b` that lie in the common range.
    pub(super) fn common(&self, b: usize) -> impl Iterator<Item = [NodeId; 2]> + '_ {
        let inside = |w: &&[Site]| self.contains(w[0].s) && self.contains(w[1].s);
        self.sites[b].windows(2).filter(inside).map(|w| [w[0].node, w[1].node])
    }

    /// Lists the nodes that face each other on the common range, after the cuts.
    ///
    /// * `reference`: the body on whose surface `s` is measured, and the number of its nodes before the cuts.
    pub(super) fn facing<'a>(
        &'a self,
        (body, nodes): (&'a Body, usize),
    ) -> impl Iterator<Item = Facing> + use<'a> {
        let inside = |b: usize| self.sites[b].iter().filter(|x| self.contains(x.s));
        let lengths = self.normal_lengths(body, nodes);
        let first = self.sites[self.reference].iter().position(|x| self.contains(x.s)).unwrap_or(0);
        inside(0).zip(inside(1)).zip(lengths.into_iter().skip(first)).map(|((x, y), length)| {
            let facing = self.facing_at([x.node, y.node], x.s);
            Facing { normal: length * facing.normal, ..facing }
        })
    }

    /// Computes the length of the normal at every site of the reference: one at the nodes that it had before the cuts; between
    /// them the length of the linear normal.
    fn normal_lengths(&self, body: &Body, nodes: usize) -> Vec<f64> {
        let sites = &self.sites[self.reference];
        let points = body.mesh().points();
        let old = |k: &usize| sites[*k].node.index() < nodes;
        let normal = |k: usize| self.curve.at(sites[k].s).1;
        let unit = |k: usize| 1.0 / norm(normal(k)) * normal(k);
        let mut lengths = vec![1.0; sites.len()];
        for k in (0..sites.len()).filter(|k| !old(k)) {
            let around = (0..k).rev().find(old).zip((k + 1..sites.len()).find(old));
            lengths[k] = match around {
                Some((i, j)) => {
                    let [from, to, at] = [i, j, k].map(|k| points[sites[k].node]);
                    // A node on a declared arc is as far from its centre as the old ones.
                    if is_off_chord(at, [from, to]) {
                        continue;
                    }
                    let t = (at - from).dot(&(to - from)) / (to - from).dot(&(to - from));
                    norm((1.0 - t) * unit(i) + t * unit(j))
                }
                // Beside the node at which a closed line was opened.
                None => norm(normal(k)),
            };
        }
        lengths
    }

    /// Measures the gap between neighbouring nodes of the first body on the common range.
    pub(super) fn between(&self) -> impl Iterator<Item = ([NodeId; 2], Between)> + '_ {
        let inside = |w: &&[Site]| self.contains(w[0].s) && self.contains(w[1].s);
        self.sites[0].windows(2).filter(inside).map(|w| {
            let at = |t: f64| (1.0 - t) * w[0].s + t * w[1].s;
            // On the edges between the two nodes, not on further ones.
            let edge = [0, 1].map(|b| self.uncut[b].edge(at(0.5)));
            let gaps = [1.0 / 3.0, 2.0 / 3.0].map(|t| self.gap_at(at(t), edge).0);
            let uncertainty = (0..2).map(|b| self.uncut[b].curve.uncertainty(edge[b])).sum();
            let pieces = Curve::both([0, 1].map(|b| &self.uncut[b].curve), edge);
            ([w[0].node, w[1].node], Between { gaps, uncertainty, pieces })
        })
    }

    /// Measures the gap at one point between the smooth curves over the given edges, and returns it with the normal.
    fn gap_at(&self, s: f64, edge: [usize; 2]) -> (f64, Vector) {
        let normal = self.curve.at(s).1;
        let normal = 1.0 / norm(normal) * normal;
        let point = |b: usize| self.uncut[b].curve.smooth_crossing(edge[b], &self.curve, s);
        ((point(1 - self.reference) - point(self.reference)).dot(&normal), normal)
    }

    fn facing_at(&self, nodes: [NodeId; 2], s: f64) -> Facing {
        let edge = [0, 1].map(|b| self.uncut[b].edge(s));
        let (gap, normal) = self.gap_at(s, edge);
        let [first, second] = [0, 1].map(|b| {
            let (curve, k) = (&self.uncut[b].curve, edge[b]);
            (curve.arc()[k + 1] - curve.arc()[k], curve.sagitta(k), curve.uncertainty(k))
        });
        Facing {
            nodes,
            normal: if self.reference == 0 { normal } else { -normal },
            gap,
            sagitta: first.1 + second.1,
            uncertainty: first.2 + second.2,
            spacing: first.0.min(second.0),
        }
    }

    /// Merges two sites, one of each body, without motion, and returns their position.
    fn join(&mut self, at: [usize; 2]) -> f64 {
        let s = self.sites[self.reference][at[self.reference]].s;
        let other = 1 - self.reference;
        self.sites[other][at[other]].s = s;
        s
    }

    /// Computes the smallest edge next to a site, m along the common line.
    pub(super) fn spacing(&self, b: usize, k: usize) -> f64 {
        let sites = &self.sites[b];
        let before = if k > 0 { sites[k].s - sites[k - 1].s } else { f64::INFINITY };
        let after = sites.get(k + 1).map_or(f64::INFINITY, |x| x.s - sites[k].s);
        before.min(after)
    }
}

/// Finds where the surfaces of the two bodies face each other.
///
/// * `fixed`: the nodes of each body that may not slide.
/// * `chains`: the stretches of each body's surface; closed ones that face each other begin at the same point.
/// * `reference`: the body whose surface is the common line; `normal`: the direction of projection.
pub(super) fn find(
    bodies: [&Body; 2],
    fixed: [&Fixed; 2],
    chains: &[Vec<Chain>; 2],
    reference: usize,
    normal: ContactNormal,
) -> Result<Vec<Overlap>, CommonRefinementError> {
    let motions = [0, 1].map(|b| chain::motions(bodies[b], &chains[b], fixed[b]));
    let (r, o) = (reference, 1 - reference);
    let lines: Vec<Line<'_>> = chains[r].iter().map(|c| Line::new(bodies[r], c, r, normal)).collect();
    let others: Vec<Opposite> = chains[o].iter().map(|c| Opposite::new(bodies[o], c)).collect();
    let mut found = Vec::new();
    for (i, near) in line::candidates(&lines, &others).into_iter().enumerate() {
        for j in near {
            if let Some(overlap) = between(&lines[i], &others[j], reference, &motions)? {
                found.push((overlap, i, j));
            }
        }
    }
    // If several stretches lie behind each other, the nearest ones face each other.
    found.sort_by(|a, b| a.0.distance.total_cmp(&b.0.distance).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut kept: Vec<(Overlap, usize, usize)> = Vec::new();
    // Places in `kept` by stretch of the reference and of the other body.
    let mut places = [vec![Vec::new(); lines.len()], vec![Vec::new(); others.len()]];
    for (overlap, i, j) in found {
        let behind = places[0][i].iter().any(|&k: &usize| {
            let range = kept[k].0.range;
            let [low, high] = [range[0].max(overlap.range[0]), range[1].min(overlap.range[1])];
            high - low > SAME * (range[1] - range[0])
        });
        let shared = || {
            let others = places[1][j].iter().filter(|&&k| kept[k].1 != i);
            others.into_iter().any(|&k| shares_edge(&kept[k].0, &overlap, o))
        };
        if !behind && !shared() {
            places[0][i].push(kept.len());
            places[1][j].push(kept.len());
            kept.push((overlap, i, j));
        }
    }
    kept.sort_by_key(|k| (k.1, k.2));
    Ok(kept.into_iter().map(|k| k.0).collect())
}

/// Tells whether two overlaps have a whole edge of body `b` in common.
fn shares_edge(a: &Overlap, b: &Overlap, body: usize) -> bool {
    let edges: std::collections::HashSet<[NodeId; 2]> = a.common(body).collect();
    b.common(body).any(|e| edges.contains(&e) || edges.contains(&[e[1], e[0]]))
}

/// Finds where one stretch of the reference faces one of the other body.
pub(super) fn between(
    line: &Line<'_>,
    other: &Opposite,
    reference: usize,
    motions: &[HashMap<NodeId, Motion>; 2],
) -> Result<Option<Overlap>, CommonRefinementError> {
    let (own, curve, q) = (line.own, &line.curve, &other.points);
    // Closed lines begin near each other.
    let mut hint = if own.is_closed() && other.closed { 0 } else { curve.nearest(q[0]) };
    let s: Vec<f64> = q.iter().map(|&q| curve.parameter(q, &mut hint)).collect();
    let Some([first, last]) = facing_run(curve, q, &s)? else { return Ok(None) };
    let motion = |b: usize, node: NodeId| motions[b].get(&node).copied().unwrap_or(Motion::None);
    let place = |b: usize, node: NodeId, s: f64| Site { s, node, motion: motion(b, node) };
    let distance = |k: usize| norm(q[k] - curve.at(s[k].clamp(0.0, curve.length())).0);
    let distance = (first..=last).map(distance).sum::<f64>() / (last - first + 1) as f64;
    let mine = own.nodes.iter().zip(curve.arc()).map(|(&n, &s)| place(reference, n, s)).collect();
    let theirs = (first..=last).map(|k| place(1 - reference, other.nodes[k], s[k])).collect();
    let sites: [Vec<Site>; 2] = if reference == 0 { [mine, theirs] } else { [theirs, mine] };
    let range = [s[first].max(0.0), s[last].min(curve.length())];
    let uncut_curve = Curve::new(q[first..=last].to_vec())
        .kept_open(!other.closed)
        .with_pieces(other.pieces[first..last].to_vec());
    let uncut_other = Uncut { curve: uncut_curve, s: s[first..=last].to_vec() };
    let uncut_own = line.uncut.clone();
    let uncut = if reference == 0 { [uncut_own, uncut_other] } else { [uncut_other, uncut_own] };
    let mut overlap = Overlap { curve: curve.clone(), sites, reference, range, distance, uncut };
    join_ends(&mut overlap);
    let shortest =
        |b: usize| (0..overlap.sites[b].len()).map(|k| overlap.spacing(b, k)).fold(f64::INFINITY, f64::min);
    let low = SAME * shortest(0).min(shortest(1));
    Ok((overlap.range[1] - overlap.range[0] > low).then_some(overlap))
}

/// Finds the first and the last node of the part that faces the curve.
fn facing_run(curve: &Curve, q: &[Vector], s: &[f64]) -> Result<Option<[usize; 2]>, CommonRefinementError> {
    let length = curve.length();
    let mut run: Option<[usize; 2]> = None;
    for k in 0..q.len() - 1 {
        let within = s[k].min(s[k + 1]) < length && s[k].max(s[k + 1]) > 0.0;
        // The outward normal lies on the left of the reversed stretch.
        let outward = -right_normal(q[k], q[k + 1]);
        let middle = 0.5 * (s[k].clamp(0.0, length) + s[k + 1].clamp(0.0, length));
        let normal = curve.at(middle).1;
        if !(within && s[k + 1] > s[k] && outward.dot(&normal) < FACING * norm(normal)) {
            continue;
        }
        run = match run {
            None => Some([k, k + 1]),
            Some([first, last]) if last == k => Some([first, k + 1]),
            Some(_) => return Err(CommonRefinementError::Folded { point: q[k] }),
        };
    }
    Ok(run)
}

/// Merges ends of the two surfaces that coincide to round-off into one site.
fn join_ends(overlap: &mut Overlap) {
    for end in [0, 1] {
        let k = [0, 1].map(|b| if end == 0 { 0 } else { overlap.sites[b].len() - 1 });
        let spacing = overlap.spacing(0, k[0]).min(overlap.spacing(1, k[1]));
        let s = [0, 1].map(|b| overlap.sites[b][k[b]].s);
        if (s[0] - s[1]).abs() <= ROUND_OFF * spacing {
            overlap.range[end] = overlap.join(k);
        }
    }
}

/// Snaps nodes of one surface onto nodes of the other that are closer than 0.2 of the smaller edge next to them.
///
/// * `moved`: the new positions of each body's moved nodes; new ones are added.
///
/// The node with the longer edges moves, along its own surface. Ends, corners, supported nodes and nodes at which a group or
/// a material begins move only if they are closer than 0.01 of the edge and no other node can. Two nodes that cannot move stay apart: cells
/// become finer towards them.
///
/// # Errors
/// Surfaces that fold.
pub(super) fn snap(
    overlap: &mut Overlap,
    bodies: [&Body; 2],
    moved: &mut [HashMap<NodeId, Vector>; 2],
) -> Result<(), CommonRefinementError> {
    let spacings =
        [0, 1].map(|b| (0..overlap.sites[b].len()).map(|k| overlap.spacing(b, k)).collect::<Vec<f64>>());
    let mut j = 0;
    for i in 0..overlap.sites[0].len() {
        let s = overlap.sites[0][i].s;
        // The nearest node of the other side.
        while j + 1 < overlap.sites[1].len()
            && (overlap.sites[1][j + 1].s - s).abs() <= (overlap.sites[1][j].s - s).abs()
        {
            j += 1;
        }
        let offset = (overlap.sites[1][j].s - s).abs();
        let spacing = [spacings[0][i], spacings[1][j]];
        let smaller = spacing[0].min(spacing[1]);
        if offset == 0.0 || offset >= SNAP * smaller {
            continue;
        }
        let at = [i, j];
        if offset <= ROUND_OFF * smaller {
            overlap.join(at);
            continue;
        }
        let mut order = [0, 1];
        if movable_first(overlap, bodies, at, spacing) == 1 {
            order.reverse();
        }
        let least = if offset <= SAME * smaller { Motion::Shifts } else { Motion::Slides };
        move_one(overlap, bodies, at, order, least, moved)?;
    }
    // Ends that moved may have moved the ends of the common range.
    let ends = |b: usize| overlap.sites[b].first().zip(overlap.sites[b].last()).map(|(f, l)| [f.s, l.s]);
    if let [Some(a), Some(b)] = [ends(0), ends(1)] {
        overlap.range = [a[0].max(b[0]), a[1].min(b[1])];
    }
    Ok(())
}

/// Moves one of two nodes onto the other, if it may: one that slides first, then one that shifts, each in the given order of the bodies.
///
/// * `least`: how freely a node must be able to move.
fn move_one(
    overlap: &mut Overlap,
    bodies: [&Body; 2],
    at: [usize; 2],
    order: [usize; 2],
    least: Motion,
    moved: &mut [HashMap<NodeId, Vector>; 2],
) -> Result<(), CommonRefinementError> {
    for motion in [Motion::Slides, Motion::Shifts].into_iter().filter(|m| *m >= least) {
        for b in order {
            let may = overlap.sites[b][at[b]].motion == motion;
            if may && try_motion(overlap, bodies[b], b, at, &mut moved[b])? {
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Chooses the body whose node moves: the one with the longer edges; for equal ones the one with the larger (x, y),
/// so that the order of the bodies does not matter.
fn movable_first(overlap: &Overlap, bodies: [&Body; 2], at: [usize; 2], spacing: [f64; 2]) -> usize {
    let [p, q] = [0, 1].map(|b| bodies[b].mesh().points()[overlap.sites[b][at[b]].node]);
    let order = spacing[0].total_cmp(&spacing[1]).then(p[0].total_cmp(&q[0])).then(p[1].total_cmp(&q[1]));
    usize::from(order.is_lt())
}

/// Moves a node of body `b` to the site of the other body's, along the smooth curve of its surface, unless a triangle would
/// lose most of its area.
pub(super) fn try_motion(
    overlap: &mut Overlap,
    body: &Body,
    b: usize,
    at: [usize; 2],
    moved: &mut HashMap<NodeId, Vector>,
) -> Result<bool, CommonRefinementError> {
    let (mesh, k) = (body.mesh(), at[b]);
    let (site, s) = (overlap.sites[b][k], overlap.sites[1 - b][at[1 - b]].s);
    if moved.contains_key(&site.node) {
        return Ok(false);
    }
    let towards =
        if s > site.s { overlap.sites[b].get(k + 1) } else { k.checked_sub(1).map(|k| &overlap.sites[b][k]) };
    let Some(towards) = towards else { return Ok(false) };
    let [from, to] = [site.node, towards.node].map(|n| mesh.points()[n]);
    let t = overlap.curve.crossing(s, from, to);
    if !(0.0..=1.0).contains(&t) {
        return Err(CommonRefinementError::Folded { point: from });
    }
    let uncut = &overlap.uncut[b];
    let point = uncut.curve.smooth_crossing(uncut.edge(0.5 * (site.s + s)), &overlap.curve, s);
    let place = |n: NodeId| moved.get(&n).copied().unwrap_or(mesh.points()[n]);
    for &cell in mesh.topology().cells_around(site.node) {
        let corners = mesh.cells()[cell as usize].map(|n| if n == site.node { point } else { place(n) });
        if fem_core::geometry::signed_area(corners) < 0.3 * mesh.measure(cell as usize) {
            return Ok(false);
        }
    }
    moved.insert(site.node, point);
    overlap.sites[b][k].s = s;
    Ok(true)
}

//! Cuts contact edges at the other side's nodes: inwards by bisection first where a fan would be too thin.

use super::chain::Motion;
use super::curve::Curve;
use super::error::CommonRefinementError;
use super::overlap::{Overlap, Site};
use fem_core::body::Body;
use fem_core::geometry::{self, Vector, norm};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::refine::{self, RefinementEdges};
use std::collections::HashMap;

/// Fans with a smaller angle, degrees, are too thin, unless an angle of the cell itself is less than twice as large.
const THIN: f64 = 8.0;
/// A bisected contact edge is cut at the other side's node nearest to its middle if that lies within this fraction of its
/// ends; in the middle otherwise.
const CENTRAL: f64 = 0.25;
/// A declared curve is at most this part of an edge away from it.
const NEAR: f64 = 0.5;
/// Each pass halves edges; after 60 passes edges have 2⁻⁶⁰ of their length, below round-off.
const PASSES: usize = 120;

/// One body during its refinement.
pub(super) struct Side {
    pub(super) body: Body,
    pub(super) refinement_edges: RefinementEdges,
}

/// The point at which a contact edge is to be cut.
#[derive(Clone, Copy, Debug)]
struct Cut {
    s: f64,
    point: Vector,
    /// The point of the declared curve over the edge.
    on_curve: Option<Vector>,
}

impl Cut {
    /// Finds the point of the edge between sites `k` and `k + 1` at an arc length.
    fn new(
        body: &Body,
        overlap: &Overlap,
        (b, k): (usize, usize),
        s: f64,
        edge: FacetId,
    ) -> Result<Self, CommonRefinementError> {
        let point = point_at(body, overlap, b, k, s)?;
        Ok(Self { s, point, on_curve: on_curve(body, &overlap.curve, edge, s, point) })
    }
}

/// Two surfaces while they are cut.
pub(super) struct Pair {
    /// The numbers of their bodies among those that are cut.
    pub(super) bodies: [usize; 2],
    /// The surface that is cut first; the other one takes its new nodes into account.
    pub(super) first: usize,
    pub(super) overlaps: Vec<Overlap>,
    /// Nodes that were added to each body.
    pub(super) added: [usize; 2],
}

/// A surface on a body: the number of its pair, and 0 or 1.
type Surface = (usize, usize);

/// Cuts until the nodes of both surfaces on every overlap are the same.
pub(super) fn cut_all(sides: &mut [Side], pairs: &mut [Pair]) -> Result<(), CommonRefinementError> {
    let mut on_body: Vec<Vec<Surface>> = vec![Vec::new(); sides.len()];
    for (k, pair) in pairs.iter().enumerate() {
        pair.bodies.iter().enumerate().for_each(|(b, body)| on_body[*body].push((k, b)));
    }
    // The surfaces of all pairs that are cut first, then the others.
    let cut_first = |(k, b): &Surface| pairs[*k].first == *b;
    let turns = on_body.iter().map(|all| all.iter().partition::<Vec<Surface>, _>(|of| cut_first(of)));
    let (firsts, seconds): (Vec<_>, Vec<_>) = turns.unzip();
    for _ in 0..PASSES {
        let (mut thin, mut open) = (false, false);
        for turn in [&firsts, &seconds] {
            for (side, surfaces) in turn.iter().enumerate().filter(|(_, surfaces)| !surfaces.is_empty()) {
                let marks = marks(&sides[side].body, pairs, surfaces)?;
                open |= marks.open;
                if !marks.thin.is_empty() {
                    thin = true;
                    bisect((&mut sides[side], side), pairs, &on_body[side], marks.thin)?;
                }
            }
        }
        if thin {
            continue;
        }
        if !open {
            return Ok(());
        }
        for turn in [&firsts, &seconds] {
            for (side, surfaces) in turn.iter().enumerate() {
                split((&mut sides[side], side), pairs, &on_body[side], surfaces)?;
            }
        }
    }
    let overlap = pairs.iter().flat_map(|pair| &pair.overlaps).next();
    let point = overlap.map_or(Vector::repeat(f64::NAN), |o| o.curve.at(o.range[0]).0);
    Err(CommonRefinementError::Folded { point })
}

/// Whether contact edges hold nodes of the other side, and the edges among them whose fan would be too thin, by surface.
#[derive(Default)]
struct Marks {
    open: bool,
    thin: Vec<(Surface, Vec<FacetId>)>,
}

fn marks(body: &Body, pairs: &[Pair], surfaces: &[Surface]) -> Result<Marks, CommonRefinementError> {
    let mut marks = Marks::default();
    for &(pair, b) in surfaces {
        let mut thin = Vec::new();
        for overlap in &pairs[pair].overlaps {
            for k in 0..overlap.sites[b].len() - 1 {
                if overlap.targets(b, k).next().is_none() {
                    continue;
                }
                marks.open = true;
                let edge = edge_of(body, overlap, b, k)?;
                if is_thin(body, overlap, b, k, edge)? {
                    thin.push(edge);
                }
            }
        }
        if !thin.is_empty() {
            marks.thin.push(((pair, b), thin));
        }
    }
    Ok(marks)
}

fn edge_of(body: &Body, overlap: &Overlap, b: usize, k: usize) -> Result<FacetId, CommonRefinementError> {
    let [i, j] = [overlap.sites[b][k].node, overlap.sites[b][k + 1].node];
    let found = body.mesh().topology().find_edge(i, j);
    found.ok_or(CommonRefinementError::Folded { point: body.mesh().points()[i] })
}

/// Finds the point of the edge between sites `k` and `k + 1` at an arc length.
fn point_at(
    body: &Body,
    overlap: &Overlap,
    b: usize,
    k: usize,
    s: f64,
) -> Result<Vector, CommonRefinementError> {
    let [from, to] = [k, k + 1].map(|k| body.mesh().points()[overlap.sites[b][k].node]);
    let t = overlap.curve.crossing(s, from, to);
    if !(t > 0.0 && t < 1.0) {
        return Err(CommonRefinementError::Folded { point: from });
    }
    Ok((1.0 - t) * from + t * to)
}

/// Finds the point of the declared curve over an edge on the normal of the common line at an arc length; `None` if there is no
/// curve, or none near the edge.
pub(super) fn on_curve(body: &Body, line: &Curve, edge: FacetId, s: f64, on_chord: Vector) -> Option<Vector> {
    let found = body.curve(edge)?.meet(on_chord, line.at(s).1)?;
    (norm(found - on_chord) <= NEAR * body.mesh().facet_measure(edge)).then_some(found)
}

/// Tells whether the fan that the other side's nodes make of a contact cell has too small an angle.
fn is_thin(
    body: &Body,
    overlap: &Overlap,
    b: usize,
    k: usize,
    edge: FacetId,
) -> Result<bool, CommonRefinementError> {
    let mesh = body.mesh();
    let cell = mesh.topology().facet_cells()[edge][0] as usize;
    let ends = [k, k + 1].map(|k| overlap.sites[b][k].node);
    let apex = mesh.cells()[cell].iter().find(|n| !ends.contains(n)).map(|&n| mesh.points()[n]);
    let Some(apex) = apex else { return Ok(false) };
    let mut previous = mesh.points()[ends[0]];
    let mut smallest = f64::INFINITY;
    let mut look = |next: Vector| {
        // The cell may lie on either side of the stretch.
        let angle = geometry::smallest_angle([previous, next, apex])
            .abs()
            .min(geometry::smallest_angle([next, previous, apex]).abs());
        smallest = smallest.min(angle);
        previous = next;
    };
    for s in overlap.targets(b, k) {
        look(point_at(body, overlap, b, k, s)?);
    }
    look(mesh.points()[ends[1]]);
    Ok(smallest < THIN.min(0.5 * geometry::smallest_angle(mesh.corners(cell))))
}

/// Bisects the given contact edges and further edges that newest-vertex bisection requires.
///
/// * `surfaces`: all on the body; `edges`: to be bisected, by surface.
fn bisect(
    (side, number): (&mut Side, usize),
    pairs: &mut [Pair],
    surfaces: &[Surface],
    edges: Vec<(Surface, Vec<FacetId>)>,
) -> Result<(), CommonRefinementError> {
    let mesh = side.body.mesh();
    let mut marked = vec![false; mesh.topology().facets().len()];
    for ((pair, b), edges) in edges {
        pairs[pair].added[b] += refine::mark(mesh, &side.refinement_edges, &mut marked, edges);
    }
    let mut cuts = HashMap::new();
    for &(pair, b) in surfaces {
        for overlap in &pairs[pair].overlaps {
            for k in 0..overlap.sites[b].len() - 1 {
                let edge = edge_of(&side.body, overlap, b, k)?;
                if !marked[edge] {
                    continue;
                }
                let [from, to] = [k, k + 1].map(|k| overlap.sites[b][k].s);
                let middle = 0.5 * (from + to);
                let near =
                    nearest(overlap, b, k).filter(|s| (s - middle).abs() <= (0.5 - CENTRAL) * (to - from));
                if near.is_some() || !cuts.contains_key(&edge) {
                    let s = near.unwrap_or(middle);
                    cuts.insert(edge, Cut::new(&side.body, overlap, (b, k), s, edge)?);
                }
            }
        }
    }
    let edges = side.refinement_edges.clone();
    apply((side, number), pairs, surfaces, (&edges, &marked), &cuts)
}

/// Cuts every contact edge that holds nodes of the other side at the one nearest to its middle, and its cell from there
/// to the opposite corner.
///
/// * `surfaces`: all on the body; `now`: those that are cut.
fn split(
    (side, number): (&mut Side, usize),
    pairs: &mut [Pair],
    surfaces: &[Surface],
    now: &[Surface],
) -> Result<(), CommonRefinementError> {
    let mesh = side.body.mesh();
    let mut cuts = HashMap::new();
    for &(pair, b) in now {
        let before = cuts.len();
        for overlap in &pairs[pair].overlaps {
            for k in 0..overlap.sites[b].len() - 1 {
                if let Some(s) = nearest(overlap, b, k) {
                    let edge = edge_of(&side.body, overlap, b, k)?;
                    cuts.insert(edge, Cut::new(&side.body, overlap, (b, k), s, edge)?);
                }
            }
        }
        pairs[pair].added[b] += cuts.len() - before;
    }
    if cuts.is_empty() {
        return Ok(());
    }
    let mut marked = vec![false; mesh.topology().facets().len()];
    cuts.keys().for_each(|edge| marked[*edge] = true);
    let edges = RefinementEdges::preferring(mesh, &marked);
    apply((side, number), pairs, surfaces, (&edges, &marked), &cuts)
}

/// Finds the other side's node nearest to the middle of the edge between sites `k` and `k + 1`.
fn nearest(overlap: &Overlap, b: usize, k: usize) -> Option<f64> {
    let middle = 0.5 * (overlap.sites[b][k].s + overlap.sites[b][k + 1].s);
    overlap.targets(b, k).min_by(|x, y| (x - middle).abs().total_cmp(&(y - middle).abs()))
}

/// Cuts the marked edges of a body.
///
/// * `surfaces`: all on the body; their new nodes become sites.
fn apply(
    (side, number): (&mut Side, usize),
    pairs: &mut [Pair],
    surfaces: &[Surface],
    (edges, marked): (&RefinementEdges, &[bool]),
    cuts: &HashMap<FacetId, Cut>,
) -> Result<(), CommonRefinementError> {
    let old = side.body.mesh();
    let curve = |e: FacetId| match cuts.get(&e) {
        Some(cut) => cut.on_curve,
        None => side.body.curve_middle(e),
    };
    let refinement = refine::refine_onto(old, edges, marked, |e| cuts.get(&e).map(|c| c.point), curve)
        .map_err(|source| CommonRefinementError::Mesh { body: number, source })?;
    for &(pair, b) in surfaces {
        for overlap in &mut pairs[pair].overlaps {
            let mut sites = Vec::with_capacity(overlap.sites[b].len());
            for w in overlap.sites[b].windows(2) {
                sites.push(w[0]);
                let edge = old.topology().find_edge(w[0].node, w[1].node);
                let new = edge.map_or(NodeId::NONE, |e| refinement.middle[e]);
                if let Some(cut) = edge.and_then(|e| cuts.get(&e)).filter(|_| new != NodeId::NONE) {
                    sites.push(Site { s: cut.s, node: new, motion: Motion::None });
                }
            }
            sites.extend(overlap.sites[b].last());
            overlap.sites[b] = sites;
        }
    }
    side.body = side
        .body
        .refined(&refinement)
        .map_err(|source| CommonRefinementError::Body { body: number, source })?;
    side.refinement_edges = refinement.refinement_edges;
    Ok(())
}

//! Surfaces of several pairs that are cut at once.

use super::chain::{Chain, Fixed};
use super::corners;
use super::cut::{self, Side};
use super::error::CommonRefinementError;
use super::moved::{Moves, replaced, with_moved};
use super::overlap::{self, Overlap};
use super::{
    Changes, Looked, Matched, Measured, Surfaces, centre, chains, reference, restricted, seam, surface_angle,
};
use crate::ContactNormal;
use fem_core::body::Body;
use fem_core::geometry::Vector;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::refine::RefinementEdges;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Lists the first pair, and the others whose cells share no node with the cells of an earlier one. Closed surfaces are cut alone.
pub(super) fn independent(bodies: &[Body], pairs: &[Surfaces<'_>]) -> Vec<usize> {
    let mut taken: HashSet<(usize, NodeId)> = HashSet::new();
    let mut found = Vec::new();
    for (k, pair) in pairs.iter().enumerate() {
        let own: Vec<HashSet<(usize, NodeId)>> =
            (0..2).map(|b| surroundings(bodies, pair.bodies[b], pair.groups[b])).collect();
        let is_closed = || (0..2).any(|b| is_closed(&bodies[pair.bodies[b]], b, pair.groups[b]));
        if k == 0 && is_closed() {
            return vec![0];
        }
        if k == 0 || (own.iter().all(|nodes| taken.is_disjoint(nodes)) && !is_closed()) {
            found.push(k);
            taken.extend(own.into_iter().flatten());
        }
    }
    found
}

/// Lists the nodes of the cells that touch a surface.
fn surroundings(bodies: &[Body], body: usize, group: &str) -> HashSet<(usize, NodeId)> {
    let mesh = bodies[body].mesh();
    let nodes = mesh.group(group).unwrap_or(&[]).iter().flat_map(|e| mesh.topology().facets()[*e]);
    let cells = nodes.flat_map(|node| mesh.topology().cells_around(node));
    cells.flat_map(|t| mesh.cells()[*t as usize]).map(|node| (body, node)).collect()
}

fn is_closed(body: &Body, number: usize, group: &str) -> bool {
    chains(body, number, group).is_ok_and(|chains| chains.iter().any(Chain::is_closed))
}

/// A pair before its surfaces are cut.
struct Prepared {
    /// Its number.
    number: usize,
    /// The places of its bodies among those that are cut.
    bodies: [usize; 2],
    chains: [Vec<Chain>; 2],
    reference: usize,
    angle: [f64; 2],
    moves: Moves,
    /// Nodes that opening closed surfaces added.
    added: [usize; 2],
}

/// Makes the surfaces of independent pairs match, and changes the bodies if all can be cut.
///
/// # Errors
/// The error of one of them.
pub(super) fn match_all(
    bodies: &mut [Body],
    pairs: &[Surfaces<'_>],
    together: &[usize],
) -> Result<Vec<Looked>, CommonRefinementError> {
    let mut numbers: Vec<usize> = Vec::new();
    let mut place: HashMap<usize, usize> = HashMap::new();
    for body in together.iter().flat_map(|k| pairs[*k].bodies) {
        place.entry(body).or_insert_with(|| {
            numbers.push(body);
            numbers.len() - 1
        });
    }
    let mut now: Vec<Body> = numbers.iter().map(|b| bodies[*b].clone()).collect();
    let nodes: Vec<usize> = now.iter().map(|body| body.mesh().points().len()).collect();
    let (mut results, mut prepared) = (BTreeMap::new(), Vec::new());
    for &number in together {
        match prepare(&mut now, &pairs[number], number, &place) {
            Ok(pair) => prepared.push(pair),
            Err(fault) => drop(results.insert(number, Err(fault))),
        }
    }
    let fixed: Vec<Fixed> = now.iter().map(Fixed::new).collect();
    let mut moved: Vec<HashMap<NodeId, Vector>> = vec![HashMap::new(); now.len()];
    let (mut ready, mut cut_pairs) = (Vec::new(), Vec::new());
    for mut pair in prepared {
        let given = &pairs[pair.number];
        match overlaps(&now, &fixed, &mut pair, given, &mut moved) {
            Ok(overlaps) => {
                let (bodies, first, added) = (pair.bodies, pair.reference, pair.added);
                cut_pairs.push(cut::Pair { bodies, first, overlaps, added });
                ready.push(pair);
            }
            Err(fault) => drop(results.insert(pair.number, Err(fault))),
        }
    }
    if ready.is_empty() {
        return Ok(results.into_iter().collect());
    }
    let mut sides = Vec::new();
    for (b, body) in now.into_iter().enumerate() {
        let body = with_moved(body, b, &moved[b])?;
        let refinement_edges = RefinementEdges::longest(body.mesh());
        sides.push(Side { body, refinement_edges });
    }
    cut::cut_all(&mut sides, &mut cut_pairs)?;
    let mut now: Vec<Body> = sides.into_iter().map(|side| side.body).collect();
    let free = restrict(&mut now, pairs, &ready, &cut_pairs)?;
    now.iter_mut().zip(&nodes).for_each(|(body, from)| body.note_inserted(*from));
    for ((pair, cut), free) in ready.iter().zip(&cut_pairs).zip(free) {
        results.insert(pair.number, Ok(matched(&now, &nodes, &pairs[pair.number], (pair, cut), free)));
    }
    numbers.into_iter().zip(now).for_each(|(b, body)| bodies[b] = body);
    Ok(results.into_iter().collect())
}

/// Collects the stretches of a pair, and opens closed ones.
fn prepare(
    bodies: &mut [Body],
    pair: &Surfaces<'_>,
    number: usize,
    place: &HashMap<usize, usize>,
) -> Result<Prepared, CommonRefinementError> {
    let at = pair.bodies.map(|b| place[&b]);
    let both = at.map(|b| &bodies[b]);
    let mut chains = [chains(both[0], 0, pair.groups[0])?, chains(both[1], 1, pair.groups[1])?];
    let reference = reference(both, pair.groups, &chains);
    let angle = [0, 1].map(|b| surface_angle(both[b], pair.groups[b]));
    let (mut moves, mut added) = (Moves::default(), [0; 2]);
    if pair.normal == ContactNormal::Averaged {
        let (same, other) = (corners::end_stretches(both, &mut chains, reference), 1 - reference);
        moves.add(other, both[other], &same);
        if !same.is_empty() {
            bodies[at[other]] = with_moved(bodies[at[other]].clone(), other, &same)?;
        }
    }
    // Only a pair alone may have closed stretches.
    if let [first, second] = bodies
        && chains.iter().flatten().any(Chain::is_closed)
    {
        let mut open = [first.clone(), second.clone()];
        seam::open(&mut open, &mut chains, reference, pair.normal, &mut moves)?;
        added = [0, 1].map(|b| open[b].mesh().points().len() - bodies[b].mesh().points().len());
        bodies.clone_from_slice(&open);
    }
    Ok(Prepared { number, bodies: at, chains, reference, angle, moves, added })
}

/// Finds the overlaps of a pair, and snaps nodes.
fn overlaps(
    bodies: &[Body],
    fixed: &[Fixed],
    pair: &mut Prepared,
    given: &Surfaces<'_>,
    moved: &mut [HashMap<NodeId, Vector>],
) -> Result<Vec<Overlap>, CommonRefinementError> {
    let both = pair.bodies.map(|b| &bodies[b]);
    let fixed = pair.bodies.map(|b| &fixed[b]);
    let mut found = overlap::find(both, fixed, &pair.chains, pair.reference, given.normal)?;
    if found.is_empty() {
        return Err(CommonRefinementError::NoOverlap {
            points: [0, 1].map(|b| centre(both[b], &pair.chains[b])),
        });
    }
    let mut now = [HashMap::new(), HashMap::new()];
    for overlap in &mut found {
        overlap::snap(overlap, both, &mut now)?;
    }
    for (b, now) in now.into_iter().enumerate() {
        pair.moves.add(b, both[b], &now);
        moved[pair.bodies[b]].extend(now);
    }
    Ok(found)
}

/// Keeps only the edges of the overlaps in the groups of the contact surfaces, and returns the length of the others.
fn restrict(
    bodies: &mut [Body],
    pairs: &[Surfaces<'_>],
    ready: &[Prepared],
    cut: &[cut::Pair],
) -> Result<Vec<[f64; 2]>, CommonRefinementError> {
    let mut free = vec![[0.0; 2]; ready.len()];
    let mut changed: Vec<BTreeMap<&str, Vec<FacetId>>> = vec![BTreeMap::new(); bodies.len()];
    for (k, (pair, cut)) in ready.iter().zip(cut).enumerate() {
        for (b, at) in pair.bodies.into_iter().enumerate() {
            let group = pairs[pair.number].groups[b];
            if let Some((kept, length)) = restricted(&bodies[at], b, group, &cut.overlaps) {
                free[k][b] = length;
                changed[at].insert(group, kept);
            }
        }
    }
    for (b, changed) in changed.iter().enumerate().filter(|(_, changed)| !changed.is_empty()) {
        bodies[b] = replaced(&bodies[b], b, bodies[b].mesh().points().to_vec(), changed)?;
    }
    Ok(free)
}

/// Measures what was made to match.
///
/// * `nodes`: of the bodies before.
fn matched(
    bodies: &[Body],
    nodes: &[usize],
    given: &Surfaces<'_>,
    (pair, cut): (&Prepared, &cut::Pair),
    free: [f64; 2],
) -> Matched {
    let angle = |b: usize| surface_angle(&bodies[pair.bodies[b]], given.groups[b]);
    let changes = Changes {
        added: cut.added,
        snapped: pair.moves.count,
        largest_move: pair.moves.largest,
        angle_before: pair.angle,
        smallest_angle: [0, 1].map(angle),
        free,
    };
    let nothing = changes.added == [0; 2] && changes.snapped == [0; 2] && changes.free == [0.0; 2];
    let on = pair.bodies[pair.reference];
    let facing =
        cut.overlaps.iter().map(|overlap| overlap.facing((&bodies[on], nodes[on])).collect()).collect();
    let between = cut.overlaps.iter().flat_map(Overlap::between).collect();
    (Measured { facing, between }, (!nothing).then_some(changes))
}

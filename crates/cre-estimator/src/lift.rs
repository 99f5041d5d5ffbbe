//! Makes the opening of a contact line nowhere negative.
//!
//! If the normal changes along an edge, the opening between two pairs that touch is a quadratic with the Bernstein coefficients `o_i`, `o_m`,
//! `o_j`. It is nowhere negative if and only if
//! ```math
//! o_i ≥ 0,   o_j ≥ 0,   o_m ≥ −√(o_i o_j)
//! ```
//! (the matrix of the quadratic form is copositive). The middle one can be lower, by the square of the edge length if the bodies
//! slide. The lift `l` moves contact nodes of one body back until the condition holds on every edge: `l = −ε D`, with the shortest free
//! displacement `D` that opens **every** pair of the node by at least one, `ν_k·D ≥ 1`, `ν_k` outward from the moving body. A node that several
//! pairs move takes the largest `ε`. Nodes that penetrate by the rounding of displacements are lifted, too. Only the bound uses the lift, the computed
//! displacement is not changed:
//! ```math
//! e_CRE² = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫ p (o + l_n) + ‖l‖² ≥ ‖u − v‖²     (26)
//! ```
//! All lines are tested on the final displacements by [`crate::check()`].

use crate::node_lines::NodeLines;
use crate::recovery::Recovery;
use crate::side::side_sign;
use crate::size::larger;
use fem_core::body::{Body, FacetSprings};
use fem_core::element::Element;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair, ContactProblem, NodePair};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::Space;
use std::collections::HashMap;

/// The lift that makes all coefficients positive is twice the least one at most. From its half it grows by this factor.
const GROWTH: f64 = 1.05;

/// The lift of the contact nodes of one body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lift {
    /// The body whose nodes move.
    pub body: usize,
    /// Its side in the pair, 0 or 1.
    pub side: usize,
    /// Added opening of each pair, ≥ 0, m.
    pub by_pair: Vec<f64>,
    /// `‖l‖²` of the P1 field that vanishes at all other nodes, J/m.
    pub energy: f64,
}

impl Lift {
    /// Returns the largest lift, m.
    pub fn largest(&self) -> f64 {
        self.by_pair.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the moved nodes of [`Self::body`] and their displacement `l`, m. A node of two stretches of the pair moves by the larger amount.
    ///
    /// * `interface`: of the pair.
    pub fn field<S: Recovery>(
        &self,
        problem: &ContactProblem<S>,
        interface: &ContactInterface<S>,
    ) -> Vec<(NodeId, S::Vector)> {
        self.field_on(&NodeLines::new(problem), interface)
    }

    fn field_on<S: Recovery>(
        &self,
        lines: &NodeLines<'_, S>,
        interface: &ContactInterface<S>,
    ) -> Vec<(NodeId, S::Vector)> {
        let sign = side_sign(self.side);
        let pairs = interface.pairs().iter().zip(&self.by_pair).filter(|(_, lift)| **lift > 0.0);
        let mut moved: Vec<(NodeId, S::Vector)> = Vec::new();
        let mut places = HashMap::new();
        for (pair, lift) in pairs {
            let Some(direction) = lines.direction(self.body, self.side, pair) else { continue };
            let (node, l) = (pair.nodes[self.side], direction * (sign * lift));
            let place = *places.entry(node).or_insert(moved.len());
            match moved.get_mut(place) {
                Some((_, largest)) if l.times(&l) > largest.times(largest) => *largest = l,
                Some(_) => {}
                None => moved.push((node, l)),
            }
        }
        moved
    }

    /// Returns a displacement of [`Self::body`] with the lift added, m.
    ///
    /// * `interface`: of the pair.
    pub fn added_to<S: Recovery>(
        &self,
        problem: &ContactProblem<S>,
        interface: &ContactInterface<S>,
        displacement: &[S::Vector],
    ) -> Vec<S::Vector> {
        self.lifted(&NodeLines::new(problem), interface, displacement)
    }

    fn lifted<S: Recovery>(
        &self,
        lines: &NodeLines<'_, S>,
        interface: &ContactInterface<S>,
        displacement: &[S::Vector],
    ) -> Vec<S::Vector> {
        let mut lifted = displacement.to_vec();
        for (node, l) in self.field_on(lines, interface) {
            lifted[node] += l;
        }
        lifted
    }
}

/// Joins the lifts of all contact lines: the displacement of all nodes of each body, m; `None` for a body that no lift moves. A node that
/// several lines move has one direction, and the largest of their amounts.
///
/// * `lifts`: one per pair.
pub(crate) fn joined<'a, S: Recovery>(
    problem: &ContactProblem<S>,
    lifts: impl IntoIterator<Item = &'a Lift>,
) -> Vec<Option<Vec<S::Vector>>> {
    let mut joined: Vec<Option<Vec<S::Vector>>> = vec![None; problem.bodies.len()];
    let mut lines = None;
    for (pair, lift) in problem.contacts.iter().zip(lifts).filter(|(_, lift)| lift.largest() > 0.0) {
        let nodes = problem.bodies[lift.body].mesh().points().len();
        let all = joined[lift.body].get_or_insert_with(|| vec![S::Vector::ZERO; nodes]);
        let lines = lines.get_or_insert_with(|| NodeLines::new(problem));
        for (node, l) in lift.field_on(lines, &pair.interface) {
            if l.times(&l) > all[node].times(&all[node]) {
                all[node] = l;
            }
        }
    }
    joined
}

/// Computes the opening that the lifts of one side add at each pair of nodes, m; empty without a lift.
///
/// * `moved`: of the body of that side, see [`joined`].
pub(crate) fn added<S: Recovery>(
    interface: &ContactInterface<S>,
    side: usize,
    moved: Option<&[S::Vector]>,
) -> Vec<f64> {
    let of = |l: &[S::Vector], pair: &NodePair<S>| {
        side_sign(side) * l[pair.nodes[side].index()].times(&pair.normal)
    };
    moved.map(|l| interface.pairs().iter().map(|pair| of(l, pair)).collect()).unwrap_or_default()
}

/// Computes by how much a bent edge penetrates between its ends, m: `−o_m − √(o_i o_j)`, negative if it does not.
///
/// * `ends`: the openings at its ends.
pub(crate) fn depth_of_edge(middle: f64, [a, b]: [f64; 2]) -> f64 {
    -middle - (a.max(0.0) * b.max(0.0)).sqrt()
}

/// Lists the facets of a contact surface, each with the middle openings of its edges, m.
pub(crate) fn with_middles<'a, S: Space>(
    interface: &'a ContactInterface<S>,
    middle: &'a [f64],
) -> impl Iterator<Item = (&'a ContactFacet<S>, &'a [f64])> {
    interface.facets().iter().zip(middle.chunks(ContactFacet::<S>::EDGES))
}

/// Computes `‖l‖²` of the lifts of all contact lines together, J/m: the lifts of two lines may move neighbouring nodes.
///
/// * `lifts`: one per pair; `joined`: see [`joined`].
pub(crate) fn total_energy<S: Recovery>(
    problem: &ContactProblem<S>,
    lifts: &[Lift],
    joined: &[Option<Vec<S::Vector>>],
) -> f64 {
    let lifts: Vec<_> = lifts.iter().filter(|lift| lift.energy > 0.0).collect();
    if let [lift] = lifts.as_slice() {
        return lift.energy;
    }
    let of_body = |(body, sum): (&Body<S>, &Option<Vec<S::Vector>>)| {
        let moved = sum.iter().flatten().enumerate().filter(|(_, l)| **l != S::Vector::ZERO);
        energy(body, &moved.map(|(node, l)| (NodeId::new(node), *l)).collect::<Vec<_>>())
    };
    problem.bodies.iter().zip(joined).map(of_body).sum()
}

/// Computes the middle openings of displacements with a lift, m.
///
/// * `displacement`: of the first and the second body of the pair.
fn lifted_middle_openings<S: Recovery>(
    lines: &NodeLines<'_, S>,
    pair: &ContactPair<S>,
    displacement: [&[S::Vector]; 2],
    lift: &Lift,
) -> Vec<f64> {
    let lifted = lift.lifted(lines, &pair.interface, displacement[lift.side]);
    let fields = if lift.side == 0 { [&lifted, displacement[1]] } else { [displacement[0], &lifted] };
    S::middle_openings(&pair.interface, fields)
}

/// Finds the lift of a pair for the openings of a displacement: it moves the body that costs less energy.
///
/// * `displacement`: of the first and the second body of the pair; `opening`: at its pairs of nodes, `middle`: the middle ones along its
///   edges, m; `penetrates`: whether openings at nodes are negative by more than round-off.
pub(crate) fn find<S: Recovery>(
    lines: &NodeLines<'_, S>,
    pair: &ContactPair<S>,
    displacement: [&[S::Vector]; 2],
    (opening, penetrates, middle): (&[f64], bool, &[f64]),
) -> Lift {
    let interface = &pair.interface;
    let deepest = depth_between(interface, opening, middle);
    if !(deepest > 0.0) && !penetrates {
        let none = vec![0.0; interface.pairs().len()];
        return Lift { body: pair.body, by_pair: none, ..Lift::default() };
    }
    let least: Vec<f64> = opening.iter().map(|o| if penetrates { (-o).max(0.0) } else { 0.0 }).collect();
    let mut moves: Vec<bool> = least.iter().map(|least| *least > 0.0).collect();
    let negative = with_middles(interface, middle)
        .filter(|(facet, middle)| facet.bent && middle.iter().any(|middle| *middle < 0.0));
    for (edge, _) in negative {
        edge.free_corners().for_each(|corner| moves[edge.pairs[corner] as usize] = true);
    }
    let of_side = |(side, body): (usize, usize)| {
        let all = interface.pairs().iter().zip(&moves);
        let directions: Vec<Option<S::Vector>> =
            all.map(|(of, moves)| if *moves { lines.direction(body, side, of) } else { None }).collect();
        let mut stuck = 0.0f64;
        let mut most = by_pair(interface, &directions, middle);
        for ((lift, least), direction) in most.iter_mut().zip(&least).zip(&directions) {
            match direction {
                Some(_) => *lift = lift.max(*least),
                None => stuck = stuck.max(*least),
            }
        }
        let by_pair = sharpened(interface, &directions, (opening, middle), (&least, most));
        let mut lift = Lift { body, side, by_pair, energy: 0.0 };
        lift.energy = energy(&lines.problem.bodies[body], &lift.field_on(lines, interface));
        let opened = lifted_middle_openings(lines, pair, displacement, &lift);
        let ends: Vec<f64> = opening.iter().zip(&lift.by_pair).map(|(o, l)| o + l).collect();
        (lift, stuck.max(depth_between(interface, &ends, &opened)))
    };
    let size = middle.iter().chain(opening).fold(0.0f64, |m, o| m.max(-o));
    // A body whose supports prevent it from opening every edge is used only if the other one is no better.
    let opens = |left: f64| left <= 1e-9 * size;
    let better = |first: (Lift, f64), second: (Lift, f64)| {
        let second_is_better = match (opens(first.1), opens(second.1)) {
            (true, true) => second.0.energy < first.0.energy,
            (a, b) => b && !a,
        };
        if second_is_better { second } else { first }
    };
    let found = pair.elastic_sides().map(of_side).reduce(better);
    found.map_or_else(Lift::default, |found| found.0)
}

/// Computes the largest [`Recovery::depth`] of the bent facets of a contact surface, m.
fn depth_between<S: Recovery>(interface: &ContactInterface<S>, opening: &[f64], middle: &[f64]) -> f64 {
    let facets = with_middles(interface, middle).filter(|(facet, _)| facet.bent);
    facets.fold(0.0, |most, (facet, middle)| larger(most, S::depth(&facet.openings(opening), middle)))
}

/// Computes the added opening of each pair, `ε ≥ 0`, m, that makes all Bernstein coefficients non-negative. Zero on straight edges.
///
/// * `directions`: in which the nodes move, see [`NodeLines::direction`].
fn by_pair<S: Recovery>(
    interface: &ContactInterface<S>,
    directions: &[Option<S::Vector>],
    middle: &[f64],
) -> Vec<f64> {
    let mut lift = vec![0.0f64; directions.len()];
    for (facet, middle) in with_middles(interface, middle).filter(|(facet, _)| facet.bent) {
        for (ends, middle) in ends(interface, facet).zip(middle).filter(|(_, middle)| !(**middle >= 0.0)) {
            let gains = gains::<S>(directions, ends);
            // If one node cannot move, the other one moves by the whole amount.
            let movable = gains.iter().filter(|g| **g > 0.0).count() as f64;
            let moved = ends.iter().zip(gains).filter(|(_, gain)| *gain > 0.0);
            for (k, gain) in moved.filter_map(|((k, _), gain)| Some(((*k)?, gain))) {
                lift[k] = lift[k].max(-2.0 * middle / (movable * gain));
            }
        }
    }
    lift
}

/// An end of an edge: the number of its pair, `None` if it is clamped, and its normal.
type End<S> = (Option<usize>, <S as Space>::Vector);

/// Lists the ends of each edge of a facet.
fn ends<S: Space>(
    interface: &ContactInterface<S>,
    facet: &ContactFacet<S>,
) -> impl Iterator<Item = [End<S>; 2]> + use<S> {
    let corners: S::Axes<End<S>> = S::axes(|corner| {
        let pair = facet.clamped[corner].is_none().then_some(facet.pairs[corner] as usize);
        (pair, interface.corner_pair(facet, corner).normal)
    });
    ContactFacet::<S>::edges().map(move |ends| ends.map(|corner| corners[corner]))
}

/// Computes by how much the middle coefficient of an edge grows per lift of its ends, twice: it grows by `½ (ε_i d_i·n_j + ε_j d_j·n_i)`. Zero
/// for a node that does not move.
fn gains<S: Recovery>(directions: &[Option<S::Vector>], [i, j]: [End<S>; 2]) -> [f64; 2] {
    let gain = |(own, (_, normal)): (End<S>, End<S>)| {
        own.0.and_then(|k| directions[k]).map_or(0.0, |d| d.times(&normal))
    };
    [(i, j), (j, i)].map(gain)
}

/// Lessens a lift that makes all Bernstein coefficients non-negative to one with which no facet penetrates: it grows from its half if a facet
/// still does.
///
/// * `opening`, `middle`: without a lift, m; `least`: what nodes need that penetrate themselves; `most`: the lift.
fn sharpened<S: Recovery>(
    interface: &ContactInterface<S>,
    directions: &[Option<S::Vector>],
    (opening, middle): (&[f64], &[f64]),
    (least, most): (&[f64], Vec<f64>),
) -> Vec<f64> {
    let mut lift: Vec<f64> =
        most.iter().zip(least).map(|(most, least)| (0.5 * most).max(*least).min(*most)).collect();
    loop {
        let mut grows = vec![false; lift.len()];
        for (facet, middle) in with_middles(interface, middle).filter(|(facet, _)| facet.bent) {
            let lifted = ends(interface, facet).zip(middle).map(|([i, j], middle)| {
                let [gain_i, gain_j] = gains::<S>(directions, [i, j]);
                let by = |end: End<S>| end.0.map_or(0.0, |k| lift[k]);
                middle + 0.5 * (by(i) * gain_i + by(j) * gain_j)
            });
            let lifted: Vec<f64> = lifted.collect();
            let mut opened = facet.openings(opening);
            for corner in facet.free_corners() {
                opened[corner] += lift[facet.pairs[corner] as usize];
            }
            if S::depth(&opened, &lifted) > 0.0 {
                facet.free_corners().for_each(|corner| grows[facet.pairs[corner] as usize] = true);
            }
        }
        let mut grown = false;
        for ((lift, most), _) in lift.iter_mut().zip(&most).zip(&grows).filter(|(_, grows)| **grows) {
            grown |= *lift < *most;
            *lift = (GROWTH * *lift).min(*most);
        }
        if !grown {
            return lift;
        }
    }
}

/// Computes `‖l‖²` of a P1 field that vanishes at all nodes but the given ones, J/m.
fn energy<S: Recovery>(body: &Body<S>, field: &[(NodeId, S::Vector)]) -> f64 {
    let mesh = body.mesh();
    let mut triangles: Vec<u32> =
        field.iter().flat_map(|(n, _)| mesh.topology().cells_around(*n).iter().copied()).collect();
    triangles.sort_unstable();
    triangles.dedup();
    let mut nodes = field.to_vec();
    nodes.sort_unstable_by_key(|(n, _)| *n);
    let at = |n: NodeId| {
        nodes.binary_search_by_key(&n, |(m, _)| *m).map_or(S::Vector::ZERO, |place| nodes[place].1)
    };
    let of_cell = |t: u32| {
        let t = t as usize;
        let nodes = &mesh.cells()[t];
        let strain = Element::<S>::new(mesh.corners(t)).strain(S::corners(|k| at(nodes[k])));
        mesh.measure(t) * S::contracted(body.material(t).stress(strain), strain)
    };
    let of_springs = |(facet, springs): (FacetId, &FacetSprings<S>)| {
        let nodes = mesh.topology().facets()[facet];
        springs.energy(&S::axes(|k| at(nodes[k])), mesh.facet_measure(facet))
    };
    triangles.into_iter().map(of_cell).sum::<f64>() + body.facet_springs().map(of_springs).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::body::Body;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::geometry::Vector;
    use fem_core::interface::{Gap, Obstacle, RigidLine};
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::generate::{block, ring};
    use fem_core::norm::energy_norm_squared;
    use fem_core::space::Plane;

    #[test]
    fn the_lift_closes_what_penetrates_where_a_support_is_oblique_too() {
        // The contact line is an arc from 0 to 60 degrees; at its end, x is fixed: 30 degrees off the tangent.
        let body = |radii| {
            let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
            let mesh = ring([0.0; 2], radii, [0.0, 60.0], [4, 2]).unwrap();
            let held = BoundaryConditions::new().displace("start", None, Some(0.0.into()));
            Body::new(mesh, material, &held.displace("end", Some(0.0.into()), None)).unwrap()
        };
        let bodies = [body([1.0, 1.5]), body([1.5, 2.0])];
        let interface =
            contact_geometry::pair(&bodies[0], &bodies[1], ["outer", "inner"], &Gap::Geometric).unwrap();
        let problem = ContactProblem::between(bodies, interface);
        let (pair, lines) = (&problem.contacts[0], NodeLines::new(&problem));
        let nodes = [0, 1].map(|b| vec![Vector::zeros(); problem.bodies[b].mesh().points().len()]);
        let edges = pair.interface.facets().len();
        for penetrating in 0..edges {
            let middle: Vec<f64> = (0..edges).map(|k| if k == penetrating { -1e-3 } else { 0.0 }).collect();
            for side in [0, 1] {
                let all = pair.interface.pairs().iter().map(|of| lines.direction(side, side, of));
                let by_pair = by_pair(&pair.interface, &all.collect::<Vec<_>>(), &middle);
                let lift = Lift { body: side, side, by_pair, energy: 0.0 };
                let opened = lifted_middle_openings(&lines, pair, [&nodes[0], &nodes[1]], &lift);
                assert!((opened[penetrating] - 1e-3).abs() < 1e-12, "{penetrating}: {opened:?}");
                assert!(opened.iter().all(|o| *o >= -1e-15), "{penetrating}: {opened:?}");
                let moved = lift.added_to(&problem, &pair.interface, &nodes[side]);
                for (u, held) in moved.iter().zip(problem.bodies[side].node_constraints()) {
                    assert!(held.violation(*u) < 1e-15, "{penetrating}");
                }
            }
        }
    }

    /// A block whose bottom and left side lie in two circles: the node at the corner belongs to both lines. Two gaps per node are open or closed
    /// under a random displacement.
    fn groove(random: &mut impl FnMut() -> f64, inside: bool, held: bool) -> (ContactProblem, Vec<Vector>) {
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let mesh = block([0.0, 0.0], [1.0, 1.0], [4, 4]).unwrap();
        let mut conditions = BoundaryConditions::new();
        if held {
            conditions = conditions.displace("right", Some(0.0.into()), None);
        }
        let body = Body::new(mesh, steel, &conditions).unwrap();
        let out = if inside { 20.0 } else { -20.0 };
        let mut problem = ContactProblem::new(vec![body.clone()]);
        for (name, centre) in [("bottom", Vector::new(0.5, out)), ("left", Vector::new(out, 0.5))] {
            let line = RigidLine::Circle { centre, radius: 20.0, inside };
            let obstacle = Obstacle::fixed(line);
            let gap = Gap::Given(0.0.into());
            let interface = contact_geometry::against(&body, name, &obstacle, Some(&gap)).unwrap();
            problem = problem.obstacle(0, interface, obstacle);
        }
        let u: Vec<Vector> =
            body.mesh().points().iter().map(|_| Vector::new(random() - 0.5, random() - 0.5)).collect();
        for pair in &mut problem.contacts {
            let mut opening = || if random() < 0.6 { 0.0 } else { 0.1 * random() };
            let gaps: Vec<f64> =
                pair.interface.pairs().iter().map(|p| u[p.nodes[0]].dot(&p.normal)).collect();
            let gaps: Vec<f64> = gaps.iter().map(|g| g + opening()).collect();
            pair.interface.replace_gaps(&gaps);
        }
        (problem, u)
    }

    #[test]
    fn a_node_of_two_lines_leaves_both_and_the_lift_is_at_most_that_of_bernstein() {
        let mut random = crate::random::random(1);
        let (mut corners, mut smaller) = (0, 0);
        for number in 0..200 {
            let (problem, u) = groove(&mut random, number % 2 == 0, number % 3 == 0);
            let lines = NodeLines::new(&problem);
            let rest: Vec<Vec<Vector>> =
                problem.obstacles.iter().map(|o| vec![Vector::zeros(); o.imposed().len()]).collect();
            let fields = |pair: &ContactPair, moved: &[Vector]| {
                [moved.to_vec(), rest[problem.places_of(pair)[1] - 1].clone()]
            };
            let lifts: Vec<Lift> = problem
                .contacts
                .iter()
                .map(|pair| {
                    let [a, b] = fields(pair, &u);
                    let middle = Plane::middle_openings(&pair.interface, [&a, &b]);
                    let of = |p: &NodePair| p.gap - u[p.nodes[0]].dot(&p.normal);
                    let opening: Vec<f64> = pair.interface.pairs().iter().map(|p| of(p).max(0.0)).collect();
                    let lift = find(&lines, pair, [&a, &b], (&opening, false, &middle));
                    let all = pair.interface.pairs().iter().map(|of| lines.direction(0, 0, of));
                    let whole = by_pair(&pair.interface, &all.collect::<Vec<_>>(), &middle);
                    assert!(lift.by_pair.iter().zip(&whole).all(|(l, w)| *l <= *w && *l >= 0.5 * w));
                    smaller += usize::from(lift.by_pair.iter().zip(&whole).any(|(l, w)| *l < 0.9 * w));
                    lift
                })
                .collect();
            let corner = |lift: &Lift, k: usize| lift.by_pair.get(k).is_some_and(|l| *l > 0.0);
            let joined = joined(&problem, &lifts);
            let moved: Vec<Vector> = match &joined[0] {
                Some(l) => u.iter().zip(l).map(|(u, l)| u + l).collect(),
                None => u.clone(),
            };
            // Of all nodes together: the lifts of both lines move the corner, or neighbours of it.
            let exact = joined[0].as_ref().map_or(0.0, |l| energy_norm_squared(&problem.bodies[0], l));
            assert!((total_energy(&problem, &lifts, &joined) - exact).abs() <= 1e-12 * exact, "{number}");
            corners += usize::from(lifts.iter().any(|lift| {
                let last = lift.by_pair.len().saturating_sub(1);
                corner(lift, 0) || corner(lift, last)
            }));
            for pair in &problem.contacts {
                let [a, b] = fields(pair, &moved);
                let opening: Vec<f64> =
                    pair.interface.pairs().iter().map(|p| p.gap - a[p.nodes[0]].dot(&p.normal)).collect();
                assert!(opening.iter().all(|o| *o >= -1e-14), "{number}: {opening:?}");
                let deepest = depth_between(
                    &pair.interface,
                    &opening,
                    &Plane::middle_openings(&pair.interface, [&a, &b]),
                );
                assert!(deepest <= 1e-8, "{number}: {deepest:e}");
            }
        }
        assert!(corners > 50 && smaller > 50, "{corners} {smaller}");
    }
}

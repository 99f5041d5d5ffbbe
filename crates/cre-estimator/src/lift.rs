//! Makes the opening of a contact line nowhere negative.
//!
//! If the normal changes along an edge, the opening between two pairs that touch is a quadratic whose middle Bernstein
//! coefficient can be negative, by the square of the edge length if the bodies slide. The lift `l` moves the contact nodes of one
//! body back along their normals until no coefficient is negative; a supported node moves along its free
//! direction. So does a lift of nodes that penetrate by the rounding of displacements. Only the bound uses the lift, the computed
//! displacement is not changed:
//! ```math
//! e_CRE² = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫ p (o + l_n) + ‖l‖² ≥ ‖u − v‖²     (26)
//! ```

use fem_core::body::{Body, NodeConstraint};
use fem_core::element::Triangle;
use fem_core::geometry::{Vector, cross, perpendicular};
use fem_core::interface::{ContactEdge, ContactInterface, ContactPair, ContactProblem, NodePair};
use fem_core::mesh::id::NodeId;

/// A node whose motion opens the edge by less than this fraction is not moved; the checks reject a remaining
/// penetration.
const SMALLEST_GAIN: f64 = 0.1;

/// Directions are parallel up to this sine of their angle.
const PARALLEL: f64 = 1e-9;

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

    /// Returns the moved nodes of [`Self::body`] and their displacement `l`, m.
    ///
    /// * `interface`: of the pair.
    pub fn field(&self, problem: &ContactProblem, interface: &ContactInterface) -> Vec<(NodeId, Vector)> {
        let sign = side_sign(self.side);
        let pairs = interface.pairs().iter().zip(&self.by_pair).filter(|(_, lift)| **lift > 0.0);
        pairs
            .filter_map(|(pair, lift)| {
                let direction = direction(problem, self.body, self.side, pair)?;
                Some((pair.nodes[self.side], sign * lift * direction))
            })
            .collect()
    }

    /// Returns a displacement of [`Self::body`] with the lift added, m.
    ///
    /// * `interface`: of the pair.
    pub fn added_to(
        &self,
        problem: &ContactProblem,
        interface: &ContactInterface,
        displacement: &[Vector],
    ) -> Vec<Vector> {
        let mut lifted = displacement.to_vec();
        for (node, l) in self.field(problem, interface) {
            lifted[node] += l;
        }
        lifted
    }
}

/// Adds up the lifts of all contact lines: the displacement of all nodes of each body, m; `None` for a body that no lift moves. The lift
/// of one line moves the nodes that it shares with another one along that.
///
/// * `lifts`: one per pair.
pub(crate) fn sums<'a>(
    problem: &ContactProblem,
    lifts: impl IntoIterator<Item = &'a Lift>,
) -> Vec<Option<Vec<Vector>>> {
    let mut sums: Vec<Option<Vec<Vector>>> = vec![None; problem.bodies.len()];
    for (pair, lift) in problem.contacts.iter().zip(lifts).filter(|(_, lift)| lift.largest() > 0.0) {
        let nodes = problem.bodies[lift.body].mesh().points().len();
        let sum = sums[lift.body].get_or_insert_with(|| vec![Vector::zeros(); nodes]);
        for (node, l) in lift.field(problem, &pair.interface) {
            sum[node] += l;
        }
    }
    sums
}

/// Computes `‖l‖²` of the lifts of all contact lines together, J/m: those of two lines may move neighbouring nodes.
///
/// * `lifts`: one per pair; `sums`: see [`sums`].
pub(crate) fn total_energy(problem: &ContactProblem, lifts: &[Lift], sums: &[Option<Vec<Vector>>]) -> f64 {
    let lifts: Vec<_> = lifts.iter().filter(|lift| lift.energy > 0.0).collect();
    if let [lift] = lifts.as_slice() {
        return lift.energy;
    }
    let of_body = |(body, sum): (&Body, &Option<Vec<Vector>>)| {
        let moved = sum.iter().flatten().enumerate().filter(|(_, l)| **l != Vector::zeros());
        energy(body, &moved.map(|(node, l)| (NodeId::new(node), *l)).collect::<Vec<_>>())
    };
    problem.bodies.iter().zip(sums).map(of_body).sum()
}

/// Computes the middle Bernstein coefficient of the opening along every contact edge, m.
pub(crate) fn middle_openings(interface: &ContactInterface, displacement: [&[Vector]; 2]) -> Vec<f64> {
    let jump = |k: usize| {
        let [a, b] = interface.pairs()[k].nodes;
        displacement[0][a] - displacement[1][b]
    };
    interface.edges().iter().map(|edge| interface.middle_opening(edge, jump)).collect()
}

/// Computes the middle openings of displacements with a lift, m.
///
/// * `displacement`: of the first and the second body of the pair.
pub(crate) fn lifted_middle_openings(
    problem: &ContactProblem,
    pair: &ContactPair,
    displacement: [&[Vector]; 2],
    lift: &Lift,
) -> Vec<f64> {
    let lifted = lift.added_to(problem, &pair.interface, displacement[lift.side]);
    let fields = if lift.side == 0 { [&lifted, displacement[1]] } else { [displacement[0], &lifted] };
    middle_openings(&pair.interface, fields)
}

/// Finds the lift of a pair for the openings of a displacement: it moves the body that costs less energy.
///
/// * `displacement`: of the first and the second body of the pair; `opening`: at its pairs of nodes, empty if none counts, `middle`: the middle ones along its
///   edges, m.
pub(crate) fn find(
    problem: &ContactProblem,
    pair: &ContactPair,
    displacement: [&[Vector]; 2],
    (opening, middle): (&[f64], &[f64]),
) -> Lift {
    let interface = &pair.interface;
    let penetrates = |(edge, middle): (&ContactEdge, &f64)| *middle < 0.0 && edge.bent;
    if !interface.edges().iter().zip(middle).any(penetrates) && opening.iter().all(|o| *o >= 0.0) {
        let none = vec![0.0; interface.pairs().len()];
        return Lift { body: pair.bodies[0], by_pair: none, ..Lift::default() };
    }
    let of_side = |(side, body): (usize, usize)| {
        let mut by_pair = by_pair(problem, body, (interface, side), middle);
        let mut stuck = 0.0f64;
        for ((lift, opening), of) in by_pair.iter_mut().zip(opening).zip(interface.pairs()) {
            match direction(problem, body, side, of) {
                Some(_) => *lift = lift.max(-opening),
                None => stuck = stuck.max(-opening),
            }
        }
        let mut lift = Lift { body, side, by_pair, energy: 0.0 };
        lift.energy = energy(&problem.bodies[body], &lift.field(problem, interface));
        let opened = lifted_middle_openings(problem, pair, displacement, &lift);
        let edges = interface.edges().iter().zip(&opened);
        let left = edges.filter(|(edge, _)| edge.bent).fold(stuck, |m, (_, o)| m.max(-o));
        (lift, left)
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
    let found = problem.bodies_of(pair).map(of_side).reduce(better);
    found.map_or_else(Lift::default, |found| found.0)
}

/// The sign of the pressure's forces on a side: −1 on the first, from which the normal points.
pub(crate) fn side_sign(side: usize) -> f64 {
    if side == 0 { -1.0 } else { 1.0 }
}

/// Returns the direction `d` in which the node of a body moves to open its pair by one, `d·n = 1`: along the normal, along the free
/// direction of its support, or along the other contact line of which it is a node, whose opening then remains; `None` if it cannot move.
pub(crate) fn direction(
    problem: &ContactProblem,
    body: usize,
    side: usize,
    pair: &NodePair,
) -> Option<Vector> {
    let (node, normal) = (pair.nodes[side], pair.normal);
    let along = |free: Vector| 1.0 / free.dot(&normal) * free;
    let other = other_normal(problem, body, node, normal);
    match (problem.bodies[body].node_constraints()[node], other) {
        (NodeConstraint::Free, None) => Some(1.0 / normal.dot(&normal) * normal),
        (NodeConstraint::Free, Some(other)) => Some(along(perpendicular(other))),
        (NodeConstraint::Along { direction, .. }, None) => Some(along(perpendicular(direction))),
        (NodeConstraint::Along { direction, .. }, Some(other))
            if cross(direction, other).abs() <= PARALLEL =>
        {
            Some(along(perpendicular(direction)))
        }
        _ => None,
    }
}

/// Finds the normal of another contact line at a node of a body, unless it is parallel to the given one.
fn other_normal(problem: &ContactProblem, body: usize, node: NodeId, normal: Vector) -> Option<Vector> {
    // A body with one contact line has no other.
    problem.sides_of(body).nth(1)?;
    problem.sides_of(body).find_map(|(k, side)| {
        let mut pairs = problem.contacts[k].interface.pairs().iter();
        pairs
            .find(|pair| pair.nodes[side] == node)
            .map(|pair| pair.normal)
            .filter(|other| cross(*other, normal).abs() > PARALLEL)
    })
}

/// Computes the required added opening of each pair, `ε ≥ 0`, m. Zero on straight edges.
fn by_pair(
    problem: &ContactProblem,
    body: usize,
    (interface, side): (&ContactInterface, usize),
    middle: &[f64],
) -> Vec<f64> {
    let pairs = interface.pairs();
    let mut lift = vec![0.0f64; pairs.len()];
    for (edge, &middle) in interface.edges().iter().zip(middle) {
        if middle >= 0.0 || !edge.bent {
            continue;
        }
        let [i, j] = edge.pairs.map(|k| k as usize);
        // The coefficient grows by ½ (ε_i d_i·n_j + ε_j d_j·n_i).
        let gain = |k: usize, other: usize| {
            direction(problem, body, side, &pairs[k]).map_or(0.0, |d| d.dot(&pairs[other].normal))
        };
        let gains = [gain(i, j), gain(j, i)].map(|g| if g > SMALLEST_GAIN { g } else { 0.0 });
        // If one node cannot move, the other one moves by the whole amount.
        let movable = gains.iter().filter(|g| **g > 0.0).count() as f64;
        for (k, gain) in [(i, gains[0]), (j, gains[1])] {
            if gain > 0.0 {
                lift[k] = lift[k].max(-2.0 * middle / (movable * gain));
            }
        }
    }
    lift
}

/// Computes `‖l‖²` of a P1 field that vanishes at all nodes but the given ones, J/m.
fn energy(body: &Body, field: &[(NodeId, Vector)]) -> f64 {
    let mesh = body.mesh();
    let mut triangles: Vec<u32> =
        field.iter().flat_map(|(n, _)| mesh.topology().triangles_around(*n).iter().copied()).collect();
    triangles.sort_unstable();
    triangles.dedup();
    let mut nodes = field.to_vec();
    nodes.sort_unstable_by_key(|(n, _)| *n);
    let at = |n: NodeId| {
        nodes.binary_search_by_key(&n, |(m, _)| *m).map_or(Vector::zeros(), |place| nodes[place].1)
    };
    let of_cell = |t: u32| {
        let t = t as usize;
        let strain = Triangle::new(mesh.corners(t)).strain(mesh.triangles()[t].map(at));
        mesh.area(t) * body.material(t).stress(strain).contract(strain)
    };
    triangles.into_iter().map(of_cell).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::body::Body;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::interface::{ContactInterface, Gap};
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::generate::ring;

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
            ContactInterface::pair(&bodies[0], &bodies[1], ["outer", "inner"], &Gap::Geometric).unwrap();
        let problem = ContactProblem::between(bodies, interface);
        let pair = &problem.contacts[0];
        let nodes = [0, 1].map(|b| vec![Vector::zeros(); problem.bodies[b].mesh().points().len()]);
        let edges = pair.interface.edges().len();
        for penetrating in 0..edges {
            let middle: Vec<f64> = (0..edges).map(|k| if k == penetrating { -1e-3 } else { 0.0 }).collect();
            for side in [0, 1] {
                let by_pair = by_pair(&problem, side, (&pair.interface, side), &middle);
                let lift = Lift { body: side, side, by_pair, energy: 0.0 };
                let opened = lifted_middle_openings(&problem, pair, [&nodes[0], &nodes[1]], &lift);
                assert!((opened[penetrating] - 1e-3).abs() < 1e-12, "{penetrating}: {opened:?}");
                assert!(opened.iter().all(|o| *o >= -1e-15), "{penetrating}: {opened:?}");
                let moved = lift.added_to(&problem, &pair.interface, &nodes[side]);
                for (u, held) in moved.iter().zip(problem.bodies[side].node_constraints()) {
                    if let NodeConstraint::Along { direction, .. } = held {
                        assert!(u.dot(direction).abs() < 1e-15, "{penetrating}");
                    }
                }
            }
        }
    }
}

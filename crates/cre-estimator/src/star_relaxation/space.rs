//! Which Airy functions the boundary allows: the functions whose stress does not change given tractions.

use crate::equilibrated::EquilibratedStress;
use crate::springs::relaxes;
use fem_core::body::{Body, FacetCondition, FacetSprings};
use fem_core::directions::Directions;
use fem_core::geometry::{Vector, cross, norm, perpendicular};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::norm::sum_over_cells;
use rayon::prelude::*;

/// Directions closer than this (sine of the angle) are the same; the resulting traction error
/// stays below the tolerance of [`crate::check()`].
const SAME_DIRECTION: f64 = 1e-11;
/// A reaction closer than this to the edge's tangent, and not along it, would make the space ill-conditioned.
const NEARLY_TANGENTIAL: f64 = 1e-3;

/// The map from the three unknowns of a node to value and gradient: `φ = value x₀`, `∇φ = slopes₀ x₁ + slopes₁ x₂`,
/// with the space's typical length as `value`. Zeros if the boundary allows no change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NodeBasis {
    pub(super) value: f64,
    pub(super) slopes: [Vector; 2],
}

/// The mean gradient on an edge from node `a` to node `b`, `m = along (φ_b − φ_a) + across q`; the edge's
/// unknown `q` is the mean normal derivative over the edge's length, times the space's typical length.
#[derive(Clone, Copy, Debug)]
struct EdgeBasis {
    along: Vector,
    across: Vector,
}

/// The admissible Airy functions: three unknowns per node, then one per edge (its mean normal derivative).
///
/// The stress function vector `ψ = (∂_y φ, −∂_x φ)` has the traction as its derivative along an edge. So:
/// * whole traction given: `∇φ` is constant along the edge; together with the stars' outer edges, zero;
/// * traction unknown along `d` only: `d·∇φ` is constant along the edge, that is zero, also in the mean;
/// * traction unknown: no condition;
/// * rigid side: no condition between its ends. At the ends `φ` and `∇φ` are zero, so that resultant and moment do not
///   change.
pub(super) struct Space<'a> {
    body: &'a Body,
    /// A typical length of the cells: with it all unknowns have the same unit, and their couplings fit single
    /// precision in any unit of length.
    length: f64,
    /// The bases: first that of the interior nodes, which are free, then one per boundary node.
    bases: Vec<NodeBasis>,
    /// The basis of every node.
    basis_of: Vec<u32>,
    /// Per boundary edge: the factor `κ` of `q = κ (φ_b − φ_a)`, and whether `q` is free (1 or 0).
    boundary: Vec<[f64; 2]>,
    /// The edges on springs whose traction is unknown, ascending.
    springs: Vec<(FacetId, FacetSprings)>,
}

/// The functions on an edge on springs: the numbers of their unknowns, and the moments of each in the direction of the edge's triangle.
pub(super) struct SpringColumns {
    pub(super) unknowns: [usize; 7],
    pub(super) moments: [[Vector; 2]; 7],
}

impl<'a> Space<'a> {
    pub(super) fn new(body: &'a Body, conditions: &[FacetCondition]) -> Self {
        let mesh = body.mesh();
        let triangles = mesh.cells().len();
        let length = (sum_over_cells(triangles, |t| mesh.measure(t)) / triangles as f64).sqrt();
        let free = NodeBasis { value: length, slopes: [Vector::x(), Vector::y()] };
        let mut bases = vec![free];
        let mut basis_of = vec![0u32; mesh.points().len()];
        let (mut boundary, mut springs) = (Vec::with_capacity(conditions.len()), Vec::new());
        for (&edge, condition) in mesh.topology().boundary_facets().iter().zip(conditions) {
            let [a, b] = mesh.topology().oriented_facet(edge, mesh.cells()).map(|n| mesh.points()[n]);
            let length = norm(b - a);
            let normal = 1.0 / length * rotated(b - a);
            let mut keep_value = true;
            let freedom = match condition.reaction.basis() {
                [] => {
                    keep_value = false;
                    [0.0, 0.0]
                }
                [d] => {
                    let (n, t) = (d.dot(&normal), cross(normal, *d));
                    keep_value = n.abs() >= NEARLY_TANGENTIAL;
                    // d·m = 0 with m = t (φ_b − φ_a)/L + L n q, t and n unit vectors.
                    let tangential = n.abs() <= SAME_DIRECTION;
                    if keep_value {
                        [-t / (n * length * length), 0.0]
                    } else {
                        [0.0, f64::from(u8::from(tangential))]
                    }
                }
                _ => [0.0, 1.0],
            };
            boundary.push(freedom);
            if relaxes(condition) {
                springs.push((edge, condition.springs));
            }
            for node in mesh.topology().facets()[edge] {
                let place = &mut basis_of[node];
                if *place == 0 {
                    *place = bases.len() as u32;
                    bases.push(free);
                }
                let basis = &mut bases[*place as usize];
                if !keep_value {
                    basis.value = 0.0;
                }
                restrict(&mut basis.slopes, condition.reaction);
            }
        }
        // The resultants of a rigid side depend on value and gradient at its ends only.
        let free = body.rigid_sides().iter().filter(|side| !side.motions.is_empty());
        for node in free.flat_map(|side| &side.ends) {
            bases[basis_of[*node] as usize] = NodeBasis { value: 0.0, slopes: [Vector::zeros(); 2] };
        }
        Self { body, length, bases, basis_of, boundary, springs }
    }

    /// Returns the edges on springs whose traction is unknown, ascending.
    pub(super) fn springs(&self) -> &[(FacetId, FacetSprings)] {
        &self.springs
    }

    /// Returns the springs on an edge, if its traction is unknown along them.
    pub(super) fn springs_on(&self, edge: FacetId) -> Option<&FacetSprings> {
        let place = self.springs.binary_search_by_key(&edge, |(of, _)| *of).ok()?;
        Some(&self.springs[place].1)
    }

    /// Lists the functions on a boundary edge, those of its first node, of its second one and its own.
    pub(super) fn spring_columns(&self, edge: FacetId) -> SpringColumns {
        let mesh = self.body.mesh();
        let nodes = mesh.topology().oriented_facet(edge, mesh.cells()).map(|n| n.index());
        let [a, b] = nodes.map(|n| mesh.points()[n]);
        let basis = self.edge(edge, mesh.topology().facet_cells()[edge][0] as usize, a, b);
        let [of_a, of_b] = nodes.map(|n| self.node(n));
        let zero = Vector::zeros();
        // Of the mean gradient m and those at the ends: R(m − ∇φ_a), R(∇φ_b − m).
        let moments = |m: Vector, ga: Vector, gb: Vector| [rotated(m - ga), rotated(gb - m)];
        let unknowns = nodes.map(|n| 3 * n);
        SpringColumns {
            unknowns: [
                unknowns[0],
                unknowns[0] + 1,
                unknowns[0] + 2,
                unknowns[1],
                unknowns[1] + 1,
                unknowns[1] + 2,
                self.edge_unknown(edge),
            ],
            moments: [
                moments(-of_a.value * basis.along, zero, zero),
                moments(zero, of_a.slopes[0], zero),
                moments(zero, of_a.slopes[1], zero),
                moments(of_b.value * basis.along, zero, zero),
                moments(zero, zero, of_b.slopes[0]),
                moments(zero, zero, of_b.slopes[1]),
                moments(basis.across, zero, zero),
            ],
        }
    }

    /// Marks the vertices whose stars have another basis than in the space `other` of the same mesh.
    pub(super) fn differences(&self, other: &Self) -> Vec<bool> {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let mut differs: Vec<bool> =
            (0..self.basis_of.len()).map(|n| self.node(n) != other.node(n)).collect();
        for (k, &edge) in topology.boundary_facets().iter().enumerate() {
            let sprung = [self, other].map(|space| space.springs_on(edge).is_some());
            if self.boundary[k] != other.boundary[k] || sprung[0] != sprung[1] {
                for n in topology.facets()[edge] {
                    differs[n] = true;
                }
            }
        }
        let mut marked = vec![false; differs.len()];
        for nodes in mesh.cells().iter().filter(|nodes| nodes.iter().any(|&n| differs[n])) {
            for &n in nodes {
                marked[n] = true;
            }
        }
        marked
    }

    /// Counts the unknowns, including those that are always zero.
    pub(super) fn len(&self) -> usize {
        3 * self.basis_of.len() + self.body.mesh().topology().facets().len()
    }

    pub(super) fn body(&self) -> &'a Body {
        self.body
    }

    pub(super) fn node(&self, node: usize) -> NodeBasis {
        self.bases[self.basis_of[node] as usize]
    }

    /// Tells whether a node is in the interior of the body.
    pub(super) fn is_interior(&self, node: NodeId) -> bool {
        self.basis_of[node] == 0
    }

    /// Place of an edge's unknown.
    pub(super) fn edge_unknown(&self, edge: FacetId) -> usize {
        3 * self.basis_of.len() + edge.index()
    }

    /// The factor `κ` of an edge's tilt, and the sense of its own unknown in the direction of the triangle: 1 or −1, and 0 if the boundary allows
    /// no change.
    #[inline(always)]
    pub(super) fn restriction(&self, edge: FacetId, triangle: usize) -> [f64; 2] {
        let topology = self.body.mesh().topology();
        if topology.is_boundary(edge) {
            return self.boundary[topology.boundary_place(edge)];
        }
        let first = topology.facet_cells()[edge][0] as usize == triangle;
        [0.0, if first { 1.0 } else { -1.0 }]
    }

    /// Basis of an edge in the direction of the triangle `triangle`, from `a` to `b`.
    fn edge(&self, edge: FacetId, triangle: usize, a: Vector, b: Vector) -> EdgeBasis {
        let t = b - a;
        let [tilt, sense] = self.restriction(edge, triangle);
        EdgeBasis {
            along: 1.0 / t.dot(&t) * t + tilt * rotated(t),
            across: sense * (1.0 / self.length) * rotated(t),
        }
    }

    /// A typical length of the cells.
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// Adds the edge moments of an Airy function: `b_a = R(m − ∇φ_a)`, `b_b = R(∇φ_b − m)`, `R(x, y) = (y, −x)`.
    pub(super) fn add_moments(&self, unknown: impl Fn(usize) -> f64 + Sync, stress: &mut EquilibratedStress) {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let conditions = &stress.conditions;
        stress.facet_moments.par_iter_mut().enumerate().with_min_len(1024).for_each(|(e, moments)| {
            let e = FacetId::new(e);
            let nodes = topology.oriented_facet(e, mesh.cells()).map(|n| n.index());
            let [a, b] = nodes.map(|n| mesh.points()[n]);
            let first = topology.facet_cells()[e][0] as usize;
            let basis = self.edge(e, first, a, b);
            let value = nodes.map(|n| self.node(n).value * unknown(3 * n));
            let [ga, gb] = nodes.map(|n| {
                let s = self.node(n).slopes;
                unknown(3 * n + 1) * s[0] + unknown(3 * n + 2) * s[1]
            });
            let q = unknown(self.edge_unknown(e));
            let m = (value[1] - value[0]) * basis.along + q * basis.across;
            let mut added = [rotated(m - ga), rotated(gb - m)];
            if let Ok(place) = topology.boundary_facets().binary_search(&e) {
                // Removes round-off from the given components.
                let held = conditions[place].reaction;
                added = added.map(|b| held.basis().iter().map(|d| d.dot(&b) / d.dot(d) * d).sum());
            }
            if topology.facets()[e][0].index() != nodes[0] {
                added.reverse();
            }
            for (moment, x) in moments.iter_mut().zip(added) {
                *moment += x;
            }
        });
    }
}

/// Restricts the gradient at a node to the directions that an edge through it allows.
fn restrict(slopes: &mut [Vector; 2], reaction: Directions) {
    let zero = [Vector::zeros(); 2];
    match reaction.basis() {
        [] => *slopes = zero,
        [d] if slopes[1] != Vector::zeros() => *slopes = [perpendicular(1.0 / norm(*d) * d), Vector::zeros()],
        [d] if slopes[0].dot(d).abs() > SAME_DIRECTION => *slopes = zero,
        _ => {}
    }
}

/// `R`, a turn by −90 degrees: it takes `∇φ` to the vector whose derivative along an edge is the traction.
fn rotated(a: Vector) -> Vector {
    Vector::new(a[1], -a[0])
}

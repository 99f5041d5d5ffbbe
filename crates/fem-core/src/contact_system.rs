//! The algebra of an assembly: condensed bodies, the rows of its contacts, and rigid motions in these rows. It has no mesh, no directions and no
//! dimension: all that a solver of contact needs.
//!
//! A row is one direction at one pair of nodes. Traces in it are along the outward normal of each of the two bodies, or along the tangent that goes with
//! it, so a force that presses on both bodies has one sign.

use crate::condensation::{CondensedBody, InterfaceOperator};
use crate::geometry::Coordinates;
use crate::interface::{ContactPair, ContactProblem};
use crate::motions::{BodyMotion, largest};
use crate::prepared::PreparedProblem;
use crate::space::Space;
use std::ops::Range;

pub use crate::interface::{Partner, Roles};

/// Condensed bodies, and the rows in which they touch each other and obstacles.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ContactSystem<'a> {
    /// The bodies. One that its supports do not hold is on springs, see [`crate::assembly::System::stabilised`].
    pub bodies: Vec<&'a InterfaceOperator>,
    /// The rows of each body, pair after pair.
    pub of_body: Vec<Vec<BodyRow>>,
    /// All rows, and the motions in them.
    pub rows: ContactRows,
    /// Each of [`ContactRows::motions`] in the interface unknowns of its body; empty for those of obstacles.
    pub free: Vec<Vec<f64>>,
    /// The rigid motions of each body that is not entirely free in its interface unknowns: the motions of its supports left out.
    pub rigid: Vec<Vec<Vec<f64>>>,
}

/// A number below this fraction of its terms is rounding: a trace of a rigid motion, and a load along it.
pub const ROUNDING: f64 = 1e-12;

/// Returns a trace of a rigid motion, or a load along it, or 0 if it is rounding: forces of 1e16 would balance a load with it.
///
/// * `size`: of its terms.
pub fn without_rounding(value: f64, size: f64) -> f64 {
    if value.abs() > ROUNDING * size { value } else { 0.0 }
}

/// The rows of all pairs, and the rigid motions in them.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ContactRows {
    /// The number of bodies.
    pub bodies: usize,
    /// The pairs.
    pub pairs: Vec<PairRows>,
    /// The rows, pair after pair: first those along normals, then, with friction, those along tangents.
    pub rows: Vec<ContactRow>,
    /// The rigid motions of floating bodies and of obstacles that are free, a basis of each, in the order of [`ContactProblem::rigid_motions`].
    pub motions: Vec<RowMotion>,
    /// The sum of the sizes of all loads, N/m.
    pub load_size: f64,
    /// See [`ContactProblem::balancing`], N/m.
    pub balancing: Vec<f64>,
    /// How far the normals may be off, see [`Space::NORMAL_ERROR`].
    pub normal_error: f64,
}

/// One pair among the rows.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PairRows {
    /// The first body.
    pub body: usize,
    /// The second body, or an obstacle.
    pub partner: Partner,
    /// Who carries λ.
    pub roles: Roles,
    /// Its rows along normals.
    pub normal: Range<usize>,
    /// Its rows along tangents, those along the first tangent of all pairs of nodes before those along the second; none without friction.
    pub tangential: Range<usize>,
}

/// What the force in a row may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RowLaw {
    /// Contact: `P ≥ 0`.
    Unilateral,
    /// Friction within a given limit: `−S ≤ Q ≤ S`, in space `|Q| ≤ S` of both rows together.
    Tresca {
        /// `S = ℓ s`, N/m.
        limit: f64,
    },
    /// Friction within `μ P`.
    Coulomb {
        /// `μ`.
        mu: f64,
    },
}

/// One direction at one pair of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactRow {
    /// The pair.
    pub pair: usize,
    /// The pair of nodes, among those of all pairs.
    pub node_pair: usize,
    /// What the force may be.
    pub law: RowLaw,
    /// The initial gap, m; along a tangent the slip before this load step, 0 from rest.
    pub gap: f64,
    /// The tributary length, m.
    pub length: f64,
    /// The imposed trace of the obstacle, m; `None` between two bodies.
    pub obstacle: Option<f64>,
}

/// A row of one body: the trace `Σ a_k x_k + c` in its interface unknowns `x`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyRow {
    /// Number of the row.
    pub row: usize,
    /// The side of the body in the pair, 0 or 1.
    pub side: usize,
    /// Interface unknowns with their factors, none of which is 0.
    pub terms: Vec<(usize, f64)>,
    /// The constant, which supports impose, m.
    pub imposed: f64,
}

/// A rigid motion in the rows.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RowMotion {
    /// The body or the obstacle.
    pub partner: Partner,
    /// Row and trace, by row: zero traces of its body among them.
    pub traces: Vec<(usize, f64)>,
    /// The load along it, `e = f·R`, N/m.
    pub load: f64,
}

/// The data that determine the displacements of all bodies and obstacles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyFields {
    /// One entry per body.
    pub bodies: Vec<BodyField>,
    /// The amount of each rigid motion, in the order of [`ContactRows::motions`].
    pub amounts: Vec<f64>,
}

/// The data that determine the displacements of a body, but for rigid motions.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyField {
    /// Imposed interface unknowns, m; rigid motions are part of them.
    Traces(Vec<f64>),
    /// Forces on the interface unknowns, N/m: `u = K⁺ (f + r) + R a`.
    Forces(Vec<f64>),
}

/// The sign of a side in the rows: normals point out of the first body.
fn sign(side: usize) -> f64 {
    if side == 0 { 1.0 } else { -1.0 }
}

impl RowLaw {
    /// Returns the limit of the force, N/m: infinite for contact, and for the law of Coulomb, whose limit is not known.
    pub fn limit(self) -> f64 {
        match self {
            Self::Tresca { limit } => limit,
            Self::Coulomb { mu } if !(mu > 0.0) => 0.0,
            Self::Unilateral | Self::Coulomb { .. } => f64::INFINITY,
        }
    }

    /// Tells whether the row is along a tangent.
    pub fn is_tangential(self) -> bool {
        self != Self::Unilateral
    }
}

impl BodyRow {
    /// Computes the trace without the constant.
    pub fn of(&self, unknowns: &[f64]) -> f64 {
        self.terms.iter().map(|(k, a)| a * unknowns[*k]).sum()
    }
}

impl PairRows {
    /// Lists the rows along the tangents of a pair of nodes.
    ///
    /// * `k`: the pair of nodes, from the first one of this pair.
    pub fn tangents(&self, k: usize) -> impl Iterator<Item = usize> + use<> {
        self.tangential.clone().skip(k).step_by(self.normal.len().max(1))
    }

    /// Returns all rows of the pair.
    pub fn all(&self) -> Range<usize> {
        self.normal.start..self.tangential.end
    }

    /// Tells whether it has rows along tangents.
    pub fn has_friction(&self) -> bool {
        !self.tangential.is_empty()
    }
}

impl ContactRows {
    /// Takes the rows of a problem.
    ///
    /// * `motions`: see [`ContactProblem::rigid_motions`]; `load_sizes`: the sum of the sizes of the loads of each body and obstacle, N/m.
    fn new<S: Space>(problem: &ContactProblem<S>, motions: &[BodyMotion<S>], load_sizes: &[f64]) -> Self {
        let (mut pairs, mut rows) = (Vec::with_capacity(problem.contacts.len()), Vec::new());
        for ((k, pair), block) in problem.contacts.iter().enumerate().zip(problem.blocks()) {
            let start = rows.len();
            rows.extend(rows_of(problem, k, pair, block.start));
            let normal = start..start + block.len();
            pairs.push(PairRows {
                body: pair.body,
                partner: pair.partner,
                roles: pair.roles,
                tangential: normal.end..rows.len(),
                normal,
            });
        }
        let mut found = Self {
            bodies: problem.bodies.len(),
            pairs,
            rows,
            motions: Vec::with_capacity(motions.len()),
            load_size: load_sizes.iter().sum(),
            balancing: problem.balancing.clone(),
            normal_error: S::NORMAL_ERROR,
        };
        let sides = problem.sides();
        for of in motions {
            let moved = problem.moved_by(of);
            let place = of.partner.place(found.bodies);
            let traces = sides[place].iter().flat_map(|side| found.traces_of(problem, *side, &moved));
            let mut traces: Vec<(usize, f64)> = traces.collect();
            // A pair within a body has both sides there.
            traces.sort_by_key(|(row, _)| *row);
            traces.dedup_by(|next, sum| {
                let same = next.0 == sum.0;
                sum.1 += if same { next.1 } else { 0.0 };
                same
            });
            let largest = largest(&moved);
            let traces =
                traces.into_iter().map(|(row, trace)| (row, without_rounding(trace, largest))).collect();
            let load = without_rounding(of.load, load_sizes[place] * largest);
            found.motions.push(RowMotion { partner: of.partner, traces, load });
        }
        found
    }

    /// Lists the traces of the moved nodes of one side of a pair, with their rows.
    fn traces_of<S: Space>(
        &self,
        problem: &ContactProblem<S>,
        (pair, side): (usize, usize),
        moved: &[S::Vector],
    ) -> Vec<(usize, f64)> {
        let rows = self.pairs[pair].all().zip(problem.contacts[pair].rows());
        rows.map(|(row, of)| (row, sign(side) * moved[of.nodes[side]].times(&of.direction))).collect()
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Tells whether nothing touches.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Counts the pairs of nodes.
    pub fn node_pairs(&self) -> usize {
        self.pairs.iter().map(|pair| pair.normal.len()).sum()
    }

    /// Tells whether a row is along a tangent.
    pub fn is_tangential(&self, row: usize) -> bool {
        self.rows[row].law.is_tangential()
    }

    /// Lists the two rows along the tangents of each pair of nodes with friction in space; none in the plane.
    pub fn tangential_planes(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.pairs.iter().flat_map(|pair| {
            let nodes = pair.normal.len();
            let planes = if pair.tangential.len() > nodes { nodes } else { 0 };
            (pair.tangential.start..).take(planes).map(move |row| [row, row + nodes])
        })
    }

    /// Lists the limits of the forces by row, N/m, see [`RowLaw::limit`].
    pub fn limits(&self) -> Vec<f64> {
        self.rows.iter().map(|row| row.law.limit()).collect()
    }

    /// Returns the lower and upper bounds of the forces: `0 ≤ P`, `−S ≤ Q ≤ S`.
    ///
    /// * `limits`: `S` by row, infinite along normals, N/m.
    pub fn bounds(&self, limits: &[f64]) -> [Vec<f64>; 2] {
        let lower = |(row, s): (&ContactRow, &f64)| if row.law.is_tangential() { 0.0 - s } else { 0.0 };
        [self.rows.iter().zip(limits).map(lower).collect(), limits.to_vec()]
    }

    /// Takes the values of all rows along normals.
    pub fn normals<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.pairs.iter().flat_map(|pair| &values[pair.normal.clone()]).copied().collect()
    }

    /// Takes the values of all rows along tangents.
    pub fn tangentials<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.pairs.iter().flat_map(|pair| &values[pair.tangential.clone()]).copied().collect()
    }

    /// Joins values along normals and tangents to those of all rows.
    pub fn joined<T: Copy>(&self, normals: &[T], tangentials: &[T]) -> Vec<T> {
        let (mut normals, mut tangentials) = (normals.iter(), tangentials.iter());
        let next = |row: &ContactRow| match row.law.is_tangential() {
            true => tangentials.next(),
            false => normals.next(),
        };
        self.rows.iter().filter_map(next).copied().collect()
    }

    /// Sorts one value per row by pair, those along the normals.
    pub fn by_pair<T: Copy>(&self, values: &[T]) -> Vec<Vec<T>> {
        self.pairs.iter().map(|pair| values[pair.normal.clone()].to_vec()).collect()
    }
}

/// Lists the rows of a pair.
///
/// * `first`: number of its first pair of nodes among all.
fn rows_of<S: Space>(
    problem: &ContactProblem<S>,
    number: usize,
    pair: &ContactPair<S>,
    first: usize,
) -> Vec<ContactRow> {
    let imposed = problem.obstacle_of(pair).map(|obstacle| obstacle.imposed());
    let limits = pair.friction_limit(&problem.bodies[pair.body]);
    let nodes = pair.interface.pairs();
    let row = |(place, row): (usize, crate::interface::PairRow<S>)| {
        let (node, k) = (&nodes[row.pair], row.pair);
        let tangential = place >= nodes.len();
        let before = |row: usize| pair.slip_before.as_ref().map_or(0.0, |before| before.rows[row]);
        let law = match (tangential, pair.friction.coulomb(), &limits) {
            (false, ..) => RowLaw::Unilateral,
            (true, Some(mu), _) => RowLaw::Coulomb { mu },
            (true, None, limits) => {
                let limit = limits.as_ref().map_or(0.0, |limits| limits[k]);
                RowLaw::Tresca { limit: node.weight * limit }
            }
        };
        ContactRow {
            pair: number,
            node_pair: first + k,
            law,
            gap: if tangential { before(place - nodes.len()) } else { node.gap },
            length: node.weight,
            obstacle: imposed.as_ref().map(|imposed| sign(1) * imposed[k].times(&row.direction)),
        }
    };
    pair.rows().enumerate().map(row).collect()
}

impl<S: Space> ContactProblem<S> {
    /// Returns the rows of the contacts: what can be asked before a body is factorised.
    pub fn contact_rows(&self) -> ContactRows {
        let forces: Vec<Vec<S::Vector>> = self.bodies.iter().map(crate::assembly::external_forces).collect();
        self.contact_rows_under(&forces, &self.rigid_motions_under(&forces))
    }

    fn contact_rows_under(&self, forces: &[Vec<S::Vector>], motions: &[BodyMotion<S>]) -> ContactRows {
        let of_bodies = forces.iter().map(|forces| forces.iter().map(|f| f.times(f).sqrt()).sum());
        let of_obstacles = self.obstacles.iter().map(|obstacle| obstacle.load_size());
        ContactRows::new(self, motions, &of_bodies.chain(of_obstacles).collect::<Vec<f64>>())
    }
}

impl<S: Space> PreparedProblem<S> {
    /// Returns the algebra of the problem, for a solver of contact.
    pub fn system(&self) -> ContactSystem<'_> {
        let rows = self.problem().contact_rows_under(self.external_forces(), self.rigid_motions());
        let sides = self.problem().sides();
        let of_body = |(b, body): (usize, &CondensedBody<S>)| {
            let of_side = |(block, &(pair, side)): (usize, &(usize, usize))| {
                let of_rows = rows.pairs[pair].all().zip(body.dofs().rows(block));
                let of_row = |(number, row): (usize, &crate::dof::TraceRow)| BodyRow {
                    row: number,
                    side,
                    terms: row.terms().map(|(k, a)| (k, sign(side) * a)).collect(),
                    imposed: sign(side) * row.imposed,
                };
                of_rows.map(of_row).collect::<Vec<_>>()
            };
            sides[b].iter().enumerate().flat_map(of_side).collect()
        };
        let of_body = self.bodies().iter().enumerate().map(of_body).collect();
        let bodies = self.bodies().iter().map(CondensedBody::interface).collect();
        ContactSystem { bodies, of_body, rows, free: self.free_motions(), rigid: self.held_motions() }
    }

    /// Returns the rigid motions that supports leave free in the interface unknowns of their bodies.
    fn free_motions(&self) -> Vec<Vec<f64>> {
        let in_unknowns = |of: &BodyMotion<S>| {
            let Some(body) = of.partner.body() else { return Vec::new() };
            let moved = self.moved_by(of);
            self.bodies()[body].dofs().interface_components(|node| moved[node])
        };
        self.rigid_motions().iter().map(in_unknowns).collect()
    }

    /// Returns the rigid motions of the bodies that their supports hold in their interface unknowns, without the imposed ones.
    fn held_motions(&self) -> Vec<Vec<Vec<f64>>> {
        let of_body = |(b, body): (usize, &CondensedBody<S>)| {
            let free = self.rigid_motions().iter().filter(|of| of.partner == Partner::Body(b)).count();
            if free == S::COMPONENTS {
                return Vec::new();
            }
            let points = self.problem().bodies[b].mesh().points();
            let centre = points.iter().copied().sum::<S::Vector>() / points.len().max(1) as f64;
            let of = |k: usize| {
                let (translation, spin) = S::parts(&S::components(|j| if j == k { 1.0 } else { 0.0 }));
                let moved = |node: usize| translation + S::turned(spin, points[node] - centre);
                body.dofs().interface_components(moved)
            };
            (0..S::COMPONENTS).map(of).collect()
        };
        self.bodies().iter().enumerate().map(of_body).collect()
    }

    /// Computes the displacement of each body, and then of the points of each obstacle, Cartesian, m.
    ///
    /// # Panics
    /// If there is not one field per body and one amount per rigid motion.
    pub fn displacements(&self, of: &BodyFields) -> Vec<Vec<S::Vector>> {
        let (found, expected) =
            ((of.bodies.len(), of.amounts.len()), (self.bodies().len(), self.rigid_motions().len()));
        assert!(found == expected, "{found:?} fields and amounts, and {expected:?} bodies and rigid motions");
        let moved = |partner: Partner, u: &mut [S::Vector]| {
            let motions = self.rigid_motions().iter().zip(&of.amounts);
            for (motion, amount) in motions.filter(|(motion, _)| motion.partner == partner) {
                u.iter_mut().zip(self.moved_by(motion)).for_each(|(u, moved)| *u += moved * *amount);
            }
        };
        let mut all = crate::each_body(self.bodies().len(), |b| match &of.bodies[b] {
            BodyField::Traces(unknowns) => self.bodies()[b].displacement_from_trace(unknowns),
            BodyField::Forces(forces) => {
                let mut u = self.bodies()[b].displacement_from_force(forces);
                moved(Partner::Body(b), &mut u);
                u
            }
        });
        for (k, obstacle) in self.problem().obstacles.iter().enumerate() {
            let mut u = obstacle.imposed();
            moved(Partner::Obstacle(k), &mut u);
            all.push(u);
        }
        all
    }
}

impl ContactSystem<'_> {
    /// Sums up forces in the rows of a body on its interface unknowns, `Bᵀ r`, N/m.
    ///
    /// * `force`: along the body's outward normal or tangent, N/m.
    pub fn on_unknowns(&self, body: usize, force: impl Fn(&BodyRow) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.bodies[body].len()];
        for row in &self.of_body[body] {
            let force = force(row);
            row.terms.iter().for_each(|(k, a)| sum[*k] += a * force);
        }
        sum
    }

    /// Tells whether a body may move rigidly.
    pub fn floats(&self, body: usize) -> bool {
        self.rows.motions.iter().any(|motion| motion.partner == Partner::Body(body))
    }
}

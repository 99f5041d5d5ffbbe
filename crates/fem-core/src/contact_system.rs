//! The algebra of an assembly: condensed bodies, the rows of its contacts, and rigid motions in these rows. It has no mesh, no directions and no
//! dimension: all that a solver of contact needs.
//!
//! A row is one direction at one pair of nodes. Traces in it are along the outward normal of each of the two bodies, or along the tangent that goes with
//! it, so a force that presses on both bodies has one sign.

mod of_problem;

use crate::condensation::InterfaceOperator;
use std::ops::Range;

pub use crate::interface::{Partner, Roles};

/// Condensed bodies, and the rows in which they touch each other and obstacles.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ContactSystem<'a> {
    /// The bodies, and in the place of a body that was cut its subdomains. One that its supports do not hold is on springs, see
    /// [`crate::assembly::System::stabilised`].
    pub bodies: Vec<&'a InterfaceOperator>,
    /// The body that each of them belongs to.
    pub body_of: Vec<usize>,
    /// The displacements that subdomains share.
    pub subdomains: Vec<SharedUnknowns>,
    /// The rows of each of `bodies`, pair after pair; a row at a node that subdomains share is in the first of them.
    pub of_body: Vec<Vec<BodyRow>>,
    /// All rows, and the motions in them.
    pub rows: ContactRows,
    /// Each of [`ContactRows::motions`] in the interface unknowns of its body, of subdomains one after the other; empty for those of obstacles.
    pub free: Vec<Vec<f64>>,
    /// The rigid motions of each of `bodies` that is not entirely free in its interface unknowns: the motions of its supports left out.
    pub rigid: Vec<Vec<Vec<f64>>>,
}

/// The interface unknowns of one of [`ContactSystem::bodies`] that is a subdomain; empty for a body in one piece.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SharedUnknowns {
    /// Numbers of the unknowns: unknowns of the same body with one number are one displacement.
    pub numbers: Vec<u32>,
    /// The diagonal of its stiffness, N/m²: the weights of the unknowns. Much cheaper than those of `S`, and as good.
    pub stiffness: Vec<f64>,
    /// The rigid motions that its own supports leave free, in its interface unknowns.
    pub free: Vec<Vec<f64>>,
    /// The load along each of them, N/m.
    pub loads: Vec<f64>,
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
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ContactRows {
    /// The number of bodies.
    pub bodies: usize,
    /// The pairs.
    pub pairs: Vec<PairRows>,
    /// The rows, pair after pair: first those along normals, then, with friction, those along tangents.
    pub rows: Vec<ContactRow>,
    /// The rigid motions of floating bodies and of obstacles that are free, a basis of each, in the order of [`ContactProblem::rigid_motions`](crate::interface::ContactProblem::rigid_motions).
    pub motions: Vec<RowMotion>,
    /// The sum of the sizes of all loads, N/m.
    pub load_size: f64,
    /// See [`ContactProblem::balancing`](crate::interface::ContactProblem::balancing), N/m.
    pub balancing: Vec<f64>,
    /// How far the normals may be off, see [`Space::NORMAL_ERROR`](crate::space::Space::NORMAL_ERROR).
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

    /// Tells whether one of [`Self::bodies`] that is in one piece may move rigidly.
    pub fn floats(&self, body: usize) -> bool {
        let own = Partner::Body(self.body_of[body]);
        !self.is_subdomain(body) && self.rows.motions.iter().any(|motion| motion.partner == own)
    }

    /// Tells whether one of [`Self::bodies`] is a subdomain.
    pub fn is_subdomain(&self, body: usize) -> bool {
        !self.subdomains[body].numbers.is_empty()
    }

    /// Tells whether a body was cut into subdomains.
    pub fn has_subdomains(&self) -> bool {
        (0..self.bodies.len()).any(|body| self.is_subdomain(body))
    }
}

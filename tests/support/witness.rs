//! A witness against a bound: an admissible field of a finer mesh that has less energy than the bound allows.
//!
//! The exact solution `u` has the least potential energy `J` of all admissible fields. For the certified field `v`, with
//! the pressure `p` of `u` and the opening `o` of `v`,
//! ```text
//! J(v) − J(u) = ½ ‖u − v‖² + ∫ p o          (u solves the problem, and is in contact where it presses)
//! e_CRE²      ≥ ‖u − v‖² + 2 ∫ p o          (what the bound claims)
//! ```
//! So every admissible `w` proves a bound wrong whose square is below `2 (J(v) − J(w)) ≤ 2 (J(v) − J(u))`. It needs no
//! certificate of `w`, and no accuracy: only that `w` satisfies supports and contact condition of `v`'s problem.
//!
//! With `w = v + d`, `2 (J(v) − J(w)) = 2 ℓ(d) − 2 a(v, d) − a(d, d)` has no cancellation of energies. `d` is zero on supports; the
//! opening is that of the coarse problem, with its frozen normals, and `d` is corrected until it is nowhere negative. Products
//! are computed in double-double arithmetic. The noise is what rounding of the loads and of `v` at supports and contact does.

use crate::finer::halve;
use crate::model::{Body, ContactProblem, Made, Vector};
use crate::precise::{Cell, Precise, energy_product, minus, precise, product, rounded};
use fem_core::body::{EdgeReaction, NodeConstraint};
use fem_core::field::nodal_residual;
use fem_core::geometry::{norm, perpendicular};
use fem_core::interface::RefinedProblem;
use qd::Quad;

/// Attempts to remove what penetrates.
const ATTEMPTS: usize = 8;

/// What a finer field says of a bound.
#[derive(Clone, Copy, Debug)]
pub struct Witness {
    /// `2 (J(v) − J(w))`: the square of a bound must not be below.
    pub gain: f64,
    /// What rounding may have added to it.
    pub noise: f64,
}

impl Witness {
    /// Tells whether a bound is proven wrong. NaN is.
    pub fn refutes(&self, bound: f64) -> bool {
        !(bound * bound >= self.gain - self.noise)
    }

    /// Computes the least error of `v` that the witness proves; 0 if it proves nothing.
    pub fn error(&self) -> f64 {
        (self.gain - self.noise).max(0.0).sqrt()
    }
}

/// Where a field satisfies the contact condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// On the whole line: the problem that `e_CRE` is about.
    Everywhere,
    /// At the pairs: the discrete problem, that `η_NNDD` is about.
    Nodes,
}

/// The meshes between a coarse problem and a finer one, with fields carried over exactly.
pub struct Ladder {
    coarse: ContactProblem,
    steps: Vec<RefinedProblem>,
    /// Of each body's finest mesh: the nodes, and the coarse triangle of each triangle.
    points: [Vec<Precise>; 2],
    parents: [Vec<u32>; 2],
    /// The contact normals and gaps of the coarse problem at the finest pairs, not of length one between coarse pairs.
    normals: Vec<Precise>,
    gaps: Vec<Quad>,
}

fn mean<const C: usize>(a: [Quad; C], b: [Quad; C]) -> [Quad; C] {
    std::array::from_fn(|c| (a[c] + b[c]) * Quad::from_f64(0.5))
}

impl Ladder {
    /// Halves the cells of a problem this many times: 0 compares with fields on the same mesh.
    ///
    /// # Errors
    /// None, for sound problems.
    pub fn new(coarse: &ContactProblem, halvings: usize) -> Made<Self> {
        let mut steps: Vec<RefinedProblem> = Vec::new();
        let mut points = [0, 1].map(|b: usize| -> Vec<Precise> {
            coarse.bodies[b].mesh().points().iter().map(|x| precise(*x)).collect()
        });
        let mut parents = [0, 1]
            .map(|b: usize| (0..coarse.bodies[b].mesh().triangles().len() as u32).collect::<Vec<u32>>());
        let pairs = coarse.contacts[0].interface.pairs();
        let mut normals: Vec<Precise> = pairs.iter().map(|p| precise(p.normal)).collect();
        let mut gaps: Vec<Quad> = pairs.iter().map(|p| Quad::from_f64(p.gap)).collect();
        for _ in 0..halvings {
            let finer = halve(steps.last().map_or(coarse, |s| &s.problem))?;
            for b in 0..2 {
                let refinement = &finer.refinements[b];
                for ends in &refinement.parent_nodes {
                    let [p, q] = ends.map(|n| points[b][n]);
                    points[b].push(mean(p, q));
                }
                parents[b] = refinement.parent_cell.iter().map(|&t| parents[b][t as usize]).collect();
            }
            let from = |p: &[u32; 2]| p.map(|k| k as usize);
            let parents = finer.pairs[0].parents.iter().map(from);
            (normals, gaps) =
                parents.map(|[i, j]| (mean(normals[i], normals[j]), mean([gaps[i]], [gaps[j]])[0])).unzip();
            steps.push(finer);
        }
        Ok(Self { coarse: coarse.clone(), steps, points, parents, normals, gaps })
    }

    /// Returns the finest problem.
    pub fn finest(&self) -> &ContactProblem {
        self.steps.last().map_or(&self.coarse, |s| &s.problem)
    }

    fn prolonged(&self, b: usize, v: &[Vector]) -> Vec<Precise> {
        let mut field: Vec<Precise> = v.iter().map(|u| precise(*u)).collect();
        for step in &self.steps {
            for ends in &step.refinements[b].parent_nodes {
                let [p, q] = ends.map(|n| field[n]);
                field.push(mean(p, q));
            }
        }
        field
    }

    /// Compares a field on the finest meshes with one on the coarse ones; `None` if it cannot be made admissible.
    ///
    /// * `v`, `w`: displacements of both bodies.
    /// * `law`: where the opening must not be negative.
    pub fn witness(&self, v: [&[Vector]; 2], w: [&[Vector]; 2], law: Law) -> Option<Witness> {
        let start = [0, 1].map(|b| self.prolonged(b, v[b]));
        let mut d = [0, 1].map(|b| {
            let body = &self.finest().bodies[b];
            let nodes = start[b].iter().zip(w[b]).zip(body.node_constraints());
            nodes
                .map(|((v, w), held)| free_part(minus(precise(*w), *v).map(rounded).into(), held))
                .collect::<Vec<_>>()
        });
        self.open(&start, &mut d, law)?;
        let (mut gain, mut noise) = (Quad::ZERO, 0.0);
        for (b, d) in d.iter().enumerate() {
            let [work, size] = self.work(b, d);
            gain += Quad::from_f64(2.0) * (work - self.products(b, v[b], d));
            noise += 8.0 * f64::EPSILON * (rounded(size) + self.reactions(b, v[b]));
        }
        Some(Witness { gain: rounded(gain), noise })
    }

    /// Adds up what supports and contact do on the displacements they hold, `Σ |R_i| |v_i|`: rounded displacements satisfy their
    /// conditions to a few ε, and energies see that to the first order, while distances see it to the second.
    fn reactions(&self, b: usize, v: &[Vector]) -> f64 {
        nodal_residual(&self.coarse.bodies[b], v).iter().zip(v).map(|(r, v)| norm(*r) * norm(*v)).sum()
    }

    /// Computes `a(v, d) + ½ a(d, d)` of a body.
    fn products(&self, b: usize, v: &[Vector], d: &[Vector]) -> Quad {
        let (coarse, fine) = (&self.coarse.bodies[b], &self.finest().bodies[b]);
        let mesh = coarse.mesh();
        let strains: Vec<[Quad; 3]> = (0..mesh.triangles().len())
            .map(|t| {
                let u = mesh.triangles()[t].map(|n| precise(v[n]));
                Cell::new(mesh.corners(t).map(precise)).strain(u)
            })
            .collect();
        let mut sum = Quad::ZERO;
        for (t, corners) in fine.mesh().triangles().iter().enumerate() {
            let cell = Cell::new(corners.map(|n| self.points[b][n]));
            let own = cell.strain(corners.map(|n| precise(d[n])));
            let coarse = strains[self.parents[b][t] as usize];
            let both = std::array::from_fn(|k| coarse[k] + own[k] * Quad::from_f64(0.5));
            sum += cell.area * energy_product(fine.material(t), both, own);
        }
        sum
    }

    /// Computes `ℓ(d)` of a body, and the sum of the sizes of its terms.
    fn work(&self, b: usize, d: &[Vector]) -> [Quad; 2] {
        let body = &self.finest().bodies[b];
        let mesh = body.mesh();
        let (mut work, mut size) = (Quad::ZERO, Quad::ZERO);
        let mut add = |weight: Quad, force: Vector, u: Vector| {
            let term = weight * product(precise(force), precise(u));
            work += term;
            size += term.abs();
        };
        for (&edge, condition) in mesh.topology().boundary_edges().iter().zip(body.edge_conditions()) {
            if condition.reaction == EdgeReaction::Both {
                continue;
            }
            let ends = mesh.topology().edges()[edge].map(|n| n.index());
            let along = minus(self.points[b][ends[1]], self.points[b][ends[0]]);
            let sixth = product(along, along).sqrt() / Quad::from_f64(6.0);
            for k in 0..2 {
                let force = 2.0 * condition.traction[k] + condition.traction[1 - k];
                add(sixth, force, d[ends[k]]);
            }
        }
        if body.body_force() != Vector::zeros() {
            for corners in mesh.triangles() {
                let third = Cell::new(corners.map(|n| self.points[b][n])).area / Quad::from_f64(3.0);
                corners.iter().for_each(|&n| add(third, body.body_force(), d[n]));
            }
        }
        [work, size]
    }

    /// Moves the first body's contact nodes back along the normals until the opening is nowhere negative.
    fn open(&self, start: &[Vec<Precise>; 2], d: &mut [Vec<Vector>; 2], law: Law) -> Option<()> {
        let interface = &self.finest().contacts[0].interface;
        let pairs = interface.pairs();
        for _ in 0..ATTEMPTS {
            let jump: Vec<Precise> = (pairs.iter())
                .map(|p| {
                    let [first, second] = [0, 1].map(|b| {
                        let n = p.nodes[b].index();
                        let part = precise(d[b][n]);
                        [start[b][n][0] + part[0], start[b][n][1] + part[1]]
                    });
                    minus(first, second)
                })
                .collect();
            let mut back = vec![0.0f64; pairs.len()];
            let mut closed = |k: usize, opening: Quad| {
                if opening < Quad::ZERO {
                    back[k] = back[k].max(-rounded(opening));
                }
            };
            for k in 0..pairs.len() {
                closed(k, self.gaps[k] - product(jump[k], self.normals[k]));
            }
            for edge in interface.edges().iter().filter(|_| law == Law::Everywhere) {
                let [i, j] = edge.pairs.map(|k| k as usize);
                let middle = self.gaps[i] + self.gaps[j]
                    - product(jump[i], self.normals[j])
                    - product(jump[j], self.normals[i]);
                let middle = middle * Quad::from_f64(0.5);
                // Of a constant normal it is the mean of the two others.
                if edge.bent || self.normals[i] != self.normals[j] {
                    closed(i, middle);
                    closed(j, middle);
                }
            }
            if back.iter().all(|x| *x == 0.0) {
                return Some(());
            }
            for (k, pair) in pairs.iter().enumerate().filter(|(k, _)| back[*k] > 0.0) {
                let n = pair.nodes[0].index();
                let direction = away(&self.finest().bodies[0], n, self.normals[k].map(rounded).into())?;
                // A little more than needed: rounding must not leave a rest.
                let step = 1.01 * back[k] + 4.0 * f64::EPSILON * (d[0][n][0].abs() + d[0][n][1].abs());
                d[0][n] -= step * direction;
            }
        }
        None
    }
}

/// Takes away what a support holds.
fn free_part(d: Vector, held: &NodeConstraint) -> Vector {
    match *held {
        NodeConstraint::Free => d,
        NodeConstraint::Fixed { .. } | NodeConstraint::Rigid { .. } => Vector::zeros(),
        NodeConstraint::Along { direction, .. } => {
            let free = perpendicular(direction);
            free.dot(&d) * free
        }
    }
}

/// The direction in which a node moves that its support leaves free, its part along the normal being one.
fn away(body: &Body, node: usize, normal: Vector) -> Option<Vector> {
    let direction = match body.node_constraints()[node] {
        NodeConstraint::Free => normal,
        NodeConstraint::Fixed { .. } | NodeConstraint::Rigid { .. } => return None,
        NodeConstraint::Along { direction, .. } => perpendicular(direction),
    };
    let along = direction.dot(&normal);
    (along.abs() > 0.1).then(|| 1.0 / along * direction)
}

//! The jumps of a displacement whose stresses no star reaches: rigid motions of supports, and across cuts from hole to hole.
//!
//! A stress without loads passes a wrench from support to support, and through a cut from a hole to the outside. Stars change no such wrench
//! unless it can pass along the boundary from facet to facet. The wrenches that are left belong to the fields of the *jumps*: `R_p` on each
//! supported patch `p`, and `Q_j` times cocycle `j` along every path. A jump counts if neighbouring facets move alike, apart from
//! motions that no wrench that both carry can feel:
//! ```math
//! w · (R_A + ∑ φ_Aj Q_j − R_B − ∑ φ_Bj Q_j) = 0 for all w ∈ W_A ∩ W_B,   w · ∑ c_j(ℓ) Q_j = 0 for all w ∈ W_p
//! ```
//! at each common node (in space, edge) of patches A and B, and for each closed path `ℓ` on a patch; `φ_pj` is the sum of cocycle `j` along a path
//! on patch `p`, with the opposite sign. Common motions of all patches of a piece, and motions that a patch does not feel, cause no stress.

use super::cocycles::Cocycles;
use super::patches::{Frame, Patch, Patches, Wrench, split};
use fem_core::body::Body;
use fem_core::directions::Directions;
use fem_core::geometry::Coordinates;
use fem_core::mesh::id::NodeId;
use fem_core::space::Space;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// An eigenvalue of a sum of projections below this is zero.
const ZERO: f64 = 1e-8;

/// More unknowns than this are not worth it: the supports are many small ones, as along a polygon of rollers.
const MOST: usize = 384;

/// The sums of the cocycles from a node of a patch to its others, with the opposite sign.
type Potentials = BTreeMap<NodeId, Vec<f64>>;

/// The displacement of a node in the motion of a patch, and the directions in which the patch holds it.
type Motion<S> = (Directions<S>, <S as Space>::Vector);

/// The jumps of a body.
#[derive(Clone, Debug)]
pub(super) struct Jumps<S: Space> {
    frame: Frame<S>,
    cocycles: Cocycles,
    patches: Vec<Patch<S>>,
    potentials: Vec<Potentials>,
    /// The motions `Q_j` of each jump, then its motions `R_p`.
    motions: Vec<Vec<Wrench<S>>>,
}

impl<S: Space> Jumps<S> {
    /// Finds a basis of the jumps of a body, in time proportional to its boundary if there are no jumps, as in a body without holes on one support.
    ///
    /// * `holes`: whether the body has any.
    pub(super) fn new(body: &Body<S>, holes: bool) -> Self {
        let frame = Frame::new(body);
        let mut found = Self {
            frame,
            cocycles: Cocycles::none(),
            patches: Vec::new(),
            potentials: Vec::new(),
            motions: Vec::new(),
        };
        let Patches { list, ridges } = Patches::new(body, &frame);
        let mut pieces: Vec<u32> = list.iter().map(|patch| patch.piece).collect();
        pieces.sort_unstable();
        if !holes && pieces.windows(2).all(|two| two[0] != two[1]) {
            return found;
        }
        if holes {
            let Some(cocycles) = Cocycles::new(body.mesh()) else { return found };
            found.cocycles = cocycles;
        }
        found.patches = list;
        pieces.dedup();
        let unknowns = S::COMPONENTS * (found.cocycles.len() + found.patches.len());
        if unknowns > 0 && unknowns <= MOST {
            found.solve(body, &ridges, &pieces);
        }
        found
    }

    /// Returns how many there are.
    pub(super) fn len(&self) -> usize {
        self.motions.len()
    }

    /// Finds the motions as the common null space of all conditions and of the jumps that cause no stress.
    fn solve(&mut self, body: &Body<S>, ridges: &[([usize; 2], NodeId)], pieces: &[u32]) {
        let holes = self.cocycles.len();
        let count = holes + self.patches.len();
        let mut squares = DMatrix::<f64>::zeros(S::COMPONENTS * count, S::COMPONENTS * count);
        let mut require = |w: &Wrench<S>, parts: &[(usize, f64)]| add_square::<S>(&mut squares, w, parts);
        for (p, patch) in self.patches.iter().enumerate() {
            let (potentials, sums) = potentials(body, patch, &self.cocycles);
            for sum in sums {
                let parts: Vec<(usize, f64)> = sum.into_iter().enumerate().collect();
                patch.carried.iter().for_each(|w| require(w, &parts));
            }
            self.potentials.push(potentials);
            let [_, unfelt] = split::<S>(patch.resultants.iter().copied());
            unfelt.iter().for_each(|motion| require(motion, &[(holes + p, 1.0)]));
        }
        let mut done: Vec<([usize; 2], Vec<f64>)> = Vec::new();
        for (pair, node) in ridges {
            let at = |p: usize| self.potentials[pair[p]].get(node);
            let Some((a, b)) = at(0).zip(at(1)) else { continue };
            let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            let condition = (*pair, difference);
            if done.contains(&condition) {
                continue;
            }
            let mut parts: Vec<(usize, f64)> = condition.1.iter().copied().enumerate().collect();
            parts.extend([(holes + pair[0], 1.0), (holes + pair[1], -1.0)]);
            let [a, b] = pair.map(|p| &self.patches[p].carried);
            common::<S>(a, b).iter().for_each(|w| require(w, &parts));
            done.push(condition);
        }
        for piece in pieces {
            let of_piece = self.patches.iter().enumerate().filter(|(_, patch)| patch.piece == *piece);
            let parts: Vec<(usize, f64)> = of_piece.map(|(p, _)| (holes + p, 1.0)).collect();
            for k in 0..S::COMPONENTS {
                require(&S::components(|j| if j == k { 1.0 } else { 0.0 }), &parts);
            }
        }
        let eigen = squares.symmetric_eigen();
        let free = (0..eigen.eigenvalues.len()).filter(|k| eigen.eigenvalues[*k] <= ZERO);
        let motion = |k: usize, m: usize| S::components(|c| eigen.eigenvectors[(S::COMPONENTS * m + c, k)]);
        self.motions = free.map(|k| (0..count).map(|m| motion(k, m)).collect()).collect();
    }

    /// Computes the displacement of each node of the supports in jump `k`, of the size of the motions; zero elsewhere.
    pub(super) fn imposed(&self, body: &Body<S>, k: usize) -> Vec<S::Vector> {
        let points = body.mesh().points();
        let holes = self.cocycles.len();
        let mut at: BTreeMap<NodeId, Vec<Motion<S>>> = BTreeMap::new();
        for (p, (patch, potentials)) in self.patches.iter().zip(&self.potentials).enumerate() {
            for (node, sums) in potentials {
                let own = self.frame.moved(&self.motions[k][holes + p], points[*node]);
                let jumps = self.motions[k].iter().zip(sums);
                let jumps = jumps.map(|(motion, sum)| self.frame.moved(motion, points[*node]) * *sum);
                at.entry(*node).or_default().push((patch.reaction, own + jumps.sum::<S::Vector>()));
            }
        }
        let mut imposed = vec![S::Vector::ZERO; points.len()];
        for (node, motions) in at {
            imposed[node] = agreed::<S>(&motions);
        }
        imposed
    }

    /// Computes the displacement that jump `k` adds at the corners of a cell, beyond the cuts seen from its first corner.
    pub(super) fn beyond_cuts(&self, body: &Body<S>, k: usize, cell: usize) -> S::Corners<S::Vector> {
        let nodes = body.mesh().cells()[cell];
        S::corners(|corner| {
            let jump = |j: usize| {
                let along = self.cocycles.along(j, nodes[0], nodes[corner]);
                let moved =
                    || self.frame.moved(&self.motions[k][j], body.mesh().points()[nodes[corner]]) * along;
                if along == 0.0 { S::Vector::ZERO } else { moved() }
            };
            if corner == 0 { S::Vector::ZERO } else { (0..self.cocycles.len()).map(jump).sum() }
        })
    }
}

/// Finds the sums of the cocycles from one node of a patch to the others, with the opposite sign, and their sums along closed paths on the patch.
fn potentials<S: Space>(
    body: &Body<S>,
    patch: &Patch<S>,
    cocycles: &Cocycles,
) -> (Potentials, Vec<Vec<f64>>) {
    let mut beside: BTreeMap<NodeId, Vec<NodeId>> = BTreeMap::new();
    for facet in &patch.facets {
        let nodes = body.mesh().topology().facets()[*facet];
        for a in nodes {
            beside.entry(a).or_default().extend(nodes.into_iter().filter(|b| *b != a));
        }
    }
    let (mut found, mut closed) = (Potentials::new(), Vec::<Vec<f64>>::new());
    for root in beside.keys() {
        if found.contains_key(root) {
            continue;
        }
        found.insert(*root, vec![0.0; cocycles.len()]);
        let mut waiting = vec![*root];
        while let Some(a) = waiting.pop() {
            let own = found[&a].clone();
            for b in beside.get(&a).into_iter().flatten() {
                let sums: Vec<f64> =
                    own.iter().enumerate().map(|(j, sum)| sum - cocycles.along(j, a, *b)).collect();
                match found.get(b) {
                    Some(known) => {
                        let around: Vec<f64> =
                            sums.iter().zip(known).map(|(sum, known)| sum - known).collect();
                        if around.iter().any(|sum| sum.abs() > ZERO) && !closed.contains(&around) {
                            closed.push(around);
                        }
                    }
                    None => {
                        found.insert(*b, sums);
                        waiting.push(*b);
                    }
                }
            }
        }
    }
    (found, closed)
}

/// Finds an orthonormal basis of the wrenches that are in the spans of both orthonormal lists.
fn common<S: Space>(a: &[Wrench<S>], b: &[Wrench<S>]) -> Vec<Wrench<S>> {
    let lost = [a, b].map(|span| split::<S>(span.iter().copied())[1].clone()).concat();
    split::<S>(lost.into_iter())[1].clone()
}

/// Finds the displacement of a node whose products with the directions of each of its patches are those of the patch's motion: by least squares.
fn agreed<S: Space>(motions: &[Motion<S>]) -> S::Vector {
    if let [(_, motion)] = motions {
        return *motion;
    }
    let (mut left, mut right) = (DMatrix::zeros(S::DIM, S::DIM), DVector::zeros(S::DIM));
    for (directions, motion) in motions {
        for d in directions.basis() {
            let d = DVector::from_row_slice(d.entries());
            right += &d * d.dot(&DVector::from_row_slice(motion.entries()));
            left += &d * d.transpose();
        }
    }
    match left.pseudo_inverse(ZERO) {
        Ok(inverse) => {
            let found = inverse * right;
            S::Vector::of(|k| found[k])
        }
        Err(_) => S::Vector::ZERO,
    }
}

/// Adds the square of the condition `w · Σ factor motion = 0` on rigid motions, each given by its number.
fn add_square<S: Space>(squares: &mut DMatrix<f64>, w: &Wrench<S>, parts: &[(usize, f64)]) {
    let mut row = DVector::<f64>::zeros(squares.nrows());
    for (motion, factor) in parts {
        for (k, w) in w.as_ref().iter().enumerate() {
            row[S::COMPONENTS * motion + k] += factor * w;
        }
    }
    let size = row.norm();
    if size > ZERO {
        row /= size;
        *squares += &row * row.transpose();
    }
}

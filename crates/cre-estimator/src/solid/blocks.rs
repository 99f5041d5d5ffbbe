//! The blocks of the edges of a cluster, and their inverses.

use super::cell::FACE;
use super::energy::EnergyMatrix;
use super::potentials::{FaceSpaces, carried};
use super::stars::{Cluster, Matrices, Rows, Star, StarCell, StarFace, WRENCH};
use crate::inverse::{invert, packed};
use crate::lanes::{LaneRow, MOST_LANES};
use fem_core::geometry::norm;
use fem_core::mesh::id::NodeId;
use nalgebra::{Matrix6, Vector6};
use std::collections::HashSet;

/// A pivot of the block of an edge below this fraction of its diagonal entry is round-off of single precision: its unknown is left out.
const DEPENDENT: f64 = 1e-7;

/// The round-off of the energy of a wrench, as a fraction of the parts that cancel in it. Wrenches are damped by as much, times these parts over what is left:
/// around flat cells nearly nothing is left, and one star that takes round-off for a stiffness ends the relaxation of its body.
const ROUNDING: f64 = 1e-6;

/// The blocks of the edges of a cluster.
#[derive(Default)]
pub(crate) struct Blocks {
    /// The wrenches of edges with restricted ones, as columns.
    bases: Vec<Matrix6<f64>>,
    /// The place there of each edge.
    basis_of: Vec<Option<u32>>,
    /// The inverses: eight rows after eight rows, column by column.
    pub(super) inverses: Vec<Rows>,
}

impl Blocks {
    #[inline(always)]
    pub(super) fn basis(&self, star: usize) -> Option<&Matrix6<f64>> {
        self.basis_of[star].map(|basis| &self.bases[basis as usize])
    }
}

impl Cluster {
    /// Restricts the wrenches as the faces with conditions demand, and inverts the blocks.
    ///
    /// * `found`: others, whose memory is used again.
    pub(crate) fn blocks(
        &self,
        (spaces, rims): (&FaceSpaces<'_>, &HashSet<[NodeId; 2]>),
        energy: Matrices<'_>,
        mut found: Blocks,
    ) -> Blocks {
        let (mesh, length) = (spaces.body.mesh(), spaces.length);
        found.bases.clear();
        found.basis_of.clear();
        found.inverses.resize(self.rows, Rows::default());
        for star in &self.stars {
            let faces = self.star_faces[star.of_faces()].iter().map(|face| face.face);
            let limits: Vec<_> = faces
                .map(|face| (face, spaces.reaction(face)))
                .filter(|(_, reaction)| !reaction.is_all())
                .map(|(face, reaction)| (mesh.facet_corners(face), reaction))
                .collect();
            let basis = if rims.contains(&star.nodes) {
                Some(Matrix6::zeros())
            } else if !limits.is_empty() {
                let [i, j] = star.nodes.map(|n| mesh.points()[n]);
                Some(carried(&limits, ((i + j) / 2.0, norm(j - i)), length))
            } else {
                None
            };
            found.basis_of.push(basis.is_some().then_some(found.bases.len() as u32));
            found.bases.extend(basis);
        }
        let mut order: Vec<usize> = (0..self.stars.len()).collect();
        order.sort_by_key(|k| self.stars[*k].faces);
        let (mut blocks, mut columns, mut block) = (Vec::new(), Vec::new(), Vec::new());
        for alike in order.chunk_by(|a, b| self.stars[*a].faces == self.stars[*b].faces) {
            let size = self.stars[alike[0]].size();
            let entries = size * (size + 1) / 2;
            for group in alike.chunks(MOST_LANES) {
                blocks.clear();
                blocks.resize(entries, LaneRow::default());
                for (lane, k) in group.iter().enumerate() {
                    block.clear();
                    block.resize(entries, 0.0);
                    let (star, basis) = (&self.stars[*k], found.basis(*k));
                    let assembly = Assembly { cluster: self, star, basis, energy, block: &mut block };
                    pulp::Arch::new().dispatch(assembly);
                    blocks.iter_mut().zip(&block).for_each(|(row, entry)| row[lane] = *entry);
                }
                invert(&mut blocks, size, DEPENDENT, &mut columns);
                for (lane, k) in group.iter().enumerate() {
                    let rows = &mut found.inverses[self.stars[*k].of_inverse()];
                    for (i, columns) in rows.chunks_exact_mut(size).enumerate() {
                        for (j, column) in columns.iter_mut().enumerate() {
                            for (row, entry) in (8 * i..size).zip(column) {
                                *entry = blocks[packed(row, j)][lane] as f32;
                            }
                        }
                    }
                }
            }
        }
        found
    }
}

/// Adds up the block of an edge, lower half by rows.
struct Assembly<'a> {
    cluster: &'a Cluster,
    star: &'a Star,
    basis: Option<&'a Matrix6<f64>>,
    energy: Matrices<'a>,
    block: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Assembly<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { cluster, star, basis, energy, block } = self;
        let faces = &cluster.star_faces[star.of_faces()];
        let (mut wrenches, mut squares) = ([[0.0; WRENCH]; WRENCH], [0.0; WRENCH]);
        for around in &cluster.star_cells[star.of_cells()] {
            let place = around.cell as usize;
            let matrix = energy.of(cluster.cells[place], place);
            // The energy of unit wrenches and all coordinates of both faces.
            let mut of_wrenches = [[0.0; 2 * FACE]; WRENCH];
            for (local, place) in around.sides() {
                let face = &faces[place as usize];
                let mut rows = [[0.0; 2 * FACE]; WRENCH];
                for (both, row) in rows.iter_mut().zip(&matrix[FACE * usize::from(local) + 3..]) {
                    for (both, (other, _)) in both.chunks_exact_mut(FACE).zip(around.sides()) {
                        let row = &row[FACE * usize::from(other)..][..FACE];
                        for (x, entry) in both.iter_mut().zip(row) {
                            *x = f64::from(*entry);
                        }
                    }
                }
                let [f0, f1, f2, t0, t1, t2] = rows;
                for i in 0..2 * FACE {
                    let gathered = face.gathered([f0[i], f1[i], f2[i], t0[i], t1[i], t2[i]]);
                    for k in 0..WRENCH {
                        of_wrenches[k][i] += gathered[k];
                    }
                }
            }
            squares.iter_mut().zip(sizes(matrix, around, faces)).for_each(|(sum, size)| *sum += size * size);
            for (k, of_wrench) in of_wrenches.iter().enumerate() {
                for ((_, place), of_face) in around.sides().into_iter().zip(of_wrench.chunks_exact(FACE)) {
                    let place = place as usize;
                    if let [b0, b1, b2, f0, f1, f2, t0, t1, t2] = *of_face {
                        let gathered = faces[place].gathered([f0, f1, f2, t0, t1, t2]);
                        for i in 0..WRENCH {
                            wrenches[k][i] += gathered[i];
                        }
                        for (b, entry) in [b0, b1, b2].into_iter().enumerate() {
                            block[packed(WRENCH + 3 * place + b, k)] += entry;
                        }
                    }
                }
            }
            for (local, place) in around.sides() {
                for (other, column) in around.sides().into_iter().filter(|(_, column)| *column <= place) {
                    for b in 0..3 {
                        let row = &matrix[FACE * usize::from(local) + b][FACE * usize::from(other)..][..3];
                        let first = packed(WRENCH + 3 * place as usize + b, WRENCH + 3 * column as usize);
                        let count = if column == place { b + 1 } else { 3 };
                        for (sum, entry) in block[first..first + count].iter_mut().zip(row) {
                            *sum += f64::from(*entry);
                        }
                    }
                }
            }
        }
        for (k, size) in squares.into_iter().enumerate() {
            let rest = wrenches[k][k].max(ROUNDING * size);
            wrenches[k][k] += if rest > 0.0 { ROUNDING * size * (size / rest) } else { 0.0 };
        }
        let mut own = Matrix6::from_fn(|i, j| wrenches[i][j]);
        if let Some(basis) = basis {
            own = basis.tr_mul(&own) * basis;
            for row in WRENCH..star.size() {
                let entries = &mut block[packed(row, 0)..][..WRENCH];
                let along = basis.tr_mul(&Vector6::from_column_slice(entries));
                entries.copy_from_slice(along.as_slice());
            }
        }
        for (i, j) in (0..WRENCH).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            block[packed(i, j)] = own[(i, j)];
        }
    }
}

/// Bounds the square roots of the energies of unit wrenches in a cell, before parts of them cancel: their rounding is a fraction of these.
fn sizes(matrix: &EnergyMatrix, around: &StarCell, faces: &[StarFace]) -> [f64; WRENCH] {
    let mut sizes = [0.0; WRENCH];
    for (local, place) in around.sides() {
        let first = FACE * usize::from(local) + 3;
        let [f0, f1, f2, t0, t1, t2] =
            std::array::from_fn(|i| f64::from(matrix[first + i][first + i]).max(0.0).sqrt());
        let [d0, d1, d2] = [0, 1, 2].map(|axis| faces[place as usize].lever[axis].abs());
        let own = [f0 + d2 * t1 + d1 * t2, f1 + d0 * t2 + d2 * t0, f2 + d1 * t0 + d0 * t1, t0, t1, t2];
        sizes.iter_mut().zip(own).for_each(|(size, own)| *size += own);
    }
    sizes
}

//! The sweeps over a cluster of edges.

use super::blocks::Blocks;
use super::cell::FACE;
use super::energy::CellNumbers;
use super::stars::{Cluster, Matrices, Rows, Star, WRENCH};
use crate::atomic_slots::AtomicSlots;
use fem_core::mesh::TetMesh;
use nalgebra::{Matrix6, Vector6};

/// Working space of the sweeps of a cluster.
#[derive(Default)]
struct Work {
    /// What is left of the residual, by cells: that of a face is the sum of its cells.
    left: Vec<CellNumbers>,
    /// The residual on each face of a ring, then the change of its coordinates.
    sums: Vec<[f32; FACE]>,
    /// Products of the residual with the unknowns of an edge, and the amounts of these.
    products: Vec<f32>,
    amounts: Vec<Rows>,
}

/// A sweep over a cluster.
pub(crate) struct Sweep<'a> {
    pub(crate) mesh: &'a TetMesh,
    pub(crate) energy: Matrices<'a>,
    pub(crate) cluster: &'a Cluster,
    pub(crate) blocks: &'a Blocks,
    pub(crate) back: bool,
    /// The residual that is left, over `scale`.
    pub(crate) left: &'a AtomicSlots,
    pub(crate) z: &'a AtomicSlots,
    pub(crate) scale: f64,
}

impl pulp::NullaryFnOnce for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut work = Work { left: vec![[0.0; 40]; self.cluster.cells.len()], ..Work::default() };
        self.load(&mut work.left);
        let stars = &self.cluster.stars;
        for k in 0..stars.len() {
            let k = if self.back { stars.len() - 1 - k } else { k };
            self.improve(&stars[k], self.blocks.basis(k), &mut work);
        }
        self.store(&work.left);
    }
}

impl Sweep<'_> {
    /// Lists the faces of the cells: the slots of their numbers, cell and place in the cell.
    fn faces(&self, first: bool) -> impl Iterator<Item = (usize, usize, usize)> {
        let cells = self.cluster.cells.iter().zip(&self.cluster.first).enumerate();
        cells.flat_map(move |(place, (cell, firsts))| {
            let facets = self.mesh.topology().cell_facets()[*cell as usize];
            let chosen = (0..4).filter(move |k| firsts[*k] == first);
            chosen.map(move |k| (FACE * facets[k].index(), place, FACE * k))
        })
    }

    fn load(&self, left: &mut [CellNumbers]) {
        for (slot, cell, k) in self.faces(true) {
            let numbers = left[cell][k..k + FACE].iter_mut();
            numbers.enumerate().for_each(|(i, x)| *x = self.left.get(slot + i) as f32);
        }
    }

    fn store(&self, left: &[CellNumbers]) {
        for (slot, cell, k) in self.faces(true) {
            let numbers = left[cell][k..k + FACE].iter();
            numbers.enumerate().for_each(|(i, x)| self.left.set(slot + i, f64::from(*x)));
        }
        for (slot, cell, k) in self.faces(false) {
            let numbers = left[cell][k..k + FACE].iter();
            numbers
                .enumerate()
                .for_each(|(i, x)| self.left.set(slot + i, self.left.get(slot + i) + f64::from(*x)));
        }
    }

    /// Adds the best wrench and bars of an edge to `z`, and takes their part from the residual.
    // Loops, not closures, which would be compiled without the vectors of the processor.
    #[inline(always)]
    fn improve(&self, star: &Star, basis: Option<&Matrix6<f64>>, work: &mut Work) {
        let Self { cluster, z, scale, .. } = self;
        let Work { left, sums, products, amounts } = work;
        let (faces, cells) = (&cluster.star_faces[star.of_faces()], &cluster.star_cells[star.of_cells()]);
        sums.clear();
        sums.resize(faces.len(), [0.0; FACE]);
        for around in cells {
            let left = &left[around.cell as usize];
            for (local, place) in around.sides() {
                let own = &left[FACE * usize::from(local)..][..FACE];
                for (sum, x) in sums[place as usize].iter_mut().zip(own) {
                    *sum += x;
                }
            }
        }
        products.resize(star.size(), 0.0);
        let (of_wrench, of_bars) = products.split_at_mut(WRENCH);
        let mut wrench = Vector6::zeros();
        for ((face, [b0, b1, b2, numbers @ ..]), bars) in
            faces.iter().zip(&*sums).zip(of_bars.chunks_exact_mut(3))
        {
            bars.copy_from_slice(&[*b0, *b1, *b2]);
            let mut wide = [0.0; WRENCH];
            for (wide, x) in wide.iter_mut().zip(numbers) {
                *wide = f64::from(*x);
            }
            wrench += Vector6::from(face.gathered(wide));
        }
        if let Some(basis) = basis {
            wrench = basis.tr_mul(&wrench);
        }
        for (product, x) in of_wrench.iter_mut().zip(&wrench) {
            *product = *x as f32;
        }
        let inverse = &self.blocks.inverses[star.of_inverse()];
        amounts.clear();
        for columns in inverse.chunks_exact(products.len()) {
            let mut rows = Rows::default();
            for (column, product) in columns.iter().zip(&*products) {
                for (row, entry) in rows.iter_mut().zip(column) {
                    *row += product * entry;
                }
            }
            amounts.push(rows);
        }
        let (of_wrench, of_bars) = amounts.as_flattened().split_at(WRENCH);
        for (amount, x) in wrench.iter_mut().zip(of_wrench) {
            *amount = f64::from(*x);
        }
        if let Some(basis) = basis {
            wrench = basis * wrench;
        }
        for ((face, bars), change) in faces.iter().zip(of_bars.chunks_exact(3)).zip(&mut *sums) {
            let [f0, f1, f2, t0, t1, t2] = face.through(&wrench);
            let amounts =
                [f64::from(bars[0]), f64::from(bars[1]), f64::from(bars[2]), f0, f1, f2, t0, t1, t2];
            let slot = FACE * face.face.index();
            for (k, (change, x)) in change.iter_mut().zip(amounts).enumerate() {
                *change = x as f32;
                z.set(slot + k, z.get(slot + k) + scale * x);
            }
        }
        for around in cells {
            let place = around.cell as usize;
            let (mut own, matrix) = (left[place], self.energy.of(cluster.cells[place], place));
            for (local, place) in around.sides() {
                let rows = &matrix[FACE * usize::from(local)..][..FACE];
                for (row, amount) in rows.iter().zip(&sums[place as usize]) {
                    for (sum, entry) in own.iter_mut().zip(row) {
                        *sum -= amount * entry;
                    }
                }
            }
            left[place] = own;
        }
    }
}

//! A cluster of edges: their stars, the inverses of their blocks, and the sweeps over them.

use super::cell::FACE;
use super::energy::{CellNumbers, EnergyMatrix};
use super::potentials::{FaceSpace, carried, centroid};
use super::rings::Rings;
use crate::atomic_slots::AtomicSlots;
use crate::inverse::{invert, packed};
use crate::lanes::{LaneRow, MOST_LANES};
use fem_core::geometry::norm;
use fem_core::mesh::TetMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use nalgebra::{Matrix6, Vector3, Vector6};
use std::collections::HashSet;
use std::ops::Range;

/// A pivot of the block of an edge below this fraction of its diagonal entry is round-off of single precision: its unknown is left out.
const DEPENDENT: f64 = 1e-7;

/// The round-off of the energy of a wrench, as a fraction of the parts that cancel in it. Wrenches are damped by as much, times these parts over what is left:
/// around flat cells nearly nothing is left, and one star that takes round-off for a stiffness ends the relaxation of its body.
const ROUNDING: f64 = 1e-6;

/// Unknowns of a wrench.
const WRENCH: usize = 6;

/// A few rows of a column of an inverse.
type Rows = [f32; 8];

/// An edge: its unknowns are a wrench and three bars of each face of its ring.
struct Star {
    nodes: [NodeId; 2],
    /// The first of its faces, cells and rows of its inverse in the cluster.
    first: [u32; 3],
    /// How many there are.
    faces: u32,
    cells: u32,
}

/// A face of a ring.
struct StarFace {
    face: FacetId,
    /// The sense in which wrenches run through it.
    sign: f64,
    /// From the middle of the edge to its centroid, over the length of the body.
    lever: Vector3<f64>,
}

/// A cell of a ring: its place in the cluster, and its two faces that contain the edge, by their places in the cell and in the ring.
struct StarCell {
    cell: u32,
    sides: [(u8, u32); 2],
}

/// Edges that are swept one after the other, in this order.
#[derive(Default)]
pub(crate) struct Cluster {
    /// The cells around the edges, ascending.
    cells: Vec<u32>,
    /// Whether the cell is the first one of the cluster at each of its faces.
    first: Vec<[bool; 4]>,
    stars: Vec<Star>,
    star_faces: Vec<StarFace>,
    star_cells: Vec<StarCell>,
    /// Entries of the inverses.
    rows: usize,
}

/// The blocks of the edges of a cluster.
#[derive(Default)]
pub(crate) struct Blocks {
    /// The wrenches of edges with restricted ones, as columns.
    bases: Vec<Matrix6<f64>>,
    /// The place there of each edge.
    basis_of: Vec<Option<u32>>,
    /// The inverses: eight rows after eight rows, column by column.
    inverses: Vec<Rows>,
}

impl Blocks {
    #[inline(always)]
    fn basis(&self, star: usize) -> Option<&Matrix6<f64>> {
        self.basis_of[star].map(|basis| &self.bases[basis as usize])
    }
}

/// Energy matrices over the unit: of all cells of a body, or of those of a cluster.
#[derive(Clone, Copy)]
pub(crate) enum Matrices<'a> {
    OfBody(&'a [EnergyMatrix]),
    OfCells(&'a [EnergyMatrix]),
}

impl<'a> Matrices<'a> {
    /// * `place`: of the cell in the cluster.
    #[inline(always)]
    pub(crate) fn of(self, cell: u32, place: usize) -> &'a EnergyMatrix {
        match self {
            Self::OfBody(all) => &all[cell as usize],
            Self::OfCells(own) => &own[place],
        }
    }
}

impl Star {
    fn size(&self) -> usize {
        WRENCH + 3 * self.faces as usize
    }

    fn of_faces(&self) -> Range<usize> {
        let first = self.first[0] as usize;
        first..first + self.faces as usize
    }

    fn of_cells(&self) -> Range<usize> {
        let first = self.first[1] as usize;
        first..first + self.cells as usize
    }

    fn of_inverse(&self) -> Range<usize> {
        let first = self.first[2] as usize;
        first..first + self.size().div_ceil(8) * self.size()
    }
}

impl StarFace {
    /// The force and torque of a wrench.
    #[inline(always)]
    fn through(&self, wrench: &Vector6<f64>) -> [f64; WRENCH] {
        let force = self.sign * Vector3::new(wrench[0], wrench[1], wrench[2]);
        let torque = self.sign * Vector3::new(wrench[3], wrench[4], wrench[5]) - self.lever.cross(&force);
        [force[0], force[1], force[2], torque[0], torque[1], torque[2]]
    }

    /// The transpose of [`Self::through`].
    #[inline(always)]
    fn gathered(&self, [f0, f1, f2, t0, t1, t2]: [f64; WRENCH]) -> [f64; WRENCH] {
        let d = &self.lever;
        let force =
            [f0 + (d[1] * t2 - d[2] * t1), f1 + (d[2] * t0 - d[0] * t2), f2 + (d[0] * t1 - d[1] * t0)];
        let sign = self.sign;
        [sign * force[0], sign * force[1], sign * force[2], sign * t0, sign * t1, sign * t2]
    }
}

impl Cluster {
    /// Collects the stars of some edges.
    ///
    /// * `length`: of the body.
    pub(crate) fn new(mesh: &TetMesh, rings: &Rings, edges: &[u32], length: f64) -> Self {
        let topology = mesh.topology();
        let mut cluster = Self::default();
        let around = edges.iter().flat_map(|edge| rings.get(*edge as usize).cells);
        cluster.cells = around.map(|around| around.cell).collect();
        cluster.cells.sort_unstable();
        cluster.cells.dedup();
        let mut place = 0;
        for edge in edges {
            let ring = rings.get(*edge as usize);
            let [i, j] = ring.nodes.map(|n| mesh.points()[n]);
            let middle = (i + j) / 2.0;
            let first = [cluster.star_faces.len() as u32, cluster.star_cells.len() as u32, place];
            cluster.star_faces.extend(ring.faces.iter().map(|&face| {
                let corners = mesh.facet_corners(face);
                let third =
                    topology.facets()[face].iter().zip(corners).find(|(n, _)| !ring.nodes.contains(n));
                let across = third.map_or(Vector3::zeros(), |(_, x)| (j - i).cross(&(x - i)));
                let sign = if mesh.facet_normal(face).dot(&across) > 0.0 { 1.0 } else { -1.0 };
                StarFace { face, sign, lever: (centroid(&corners) - middle) / length }
            }));
            for around in ring.cells {
                let cell = cluster.cells.binary_search(&around.cell).unwrap_or(0) as u32;
                let side = |k: usize| (around.faces[k], around.places[k]);
                cluster.star_cells.push(StarCell { cell, sides: [side(0), side(1)] });
            }
            let (faces, cells) = (ring.faces.len() as u32, ring.cells.len() as u32);
            let star = Star { nodes: ring.nodes, first, faces, cells };
            place = star.of_inverse().end as u32;
            cluster.stars.push(star);
        }
        cluster.rows = place as usize;
        let mut faces: Vec<(FacetId, u32)> = Vec::with_capacity(4 * cluster.cells.len());
        for cell in &cluster.cells {
            faces.extend(topology.cell_facets()[*cell as usize].map(|face| (face, *cell)));
        }
        faces.sort_unstable();
        faces.dedup_by_key(|(face, _)| *face);
        let is_first = |face: FacetId, cell: u32| faces.binary_search(&(face, cell)).is_ok();
        let of_cell = |cell: &u32| topology.cell_facets()[*cell as usize].map(|face| is_first(face, *cell));
        cluster.first = cluster.cells.iter().map(of_cell).collect();
        cluster
    }

    /// The cells around the edges.
    pub(crate) fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Restricts the wrenches as the faces with conditions demand, and inverts the blocks.
    ///
    /// * `found`: others, whose memory is used again.
    pub(crate) fn blocks(
        &self,
        mesh: &TetMesh,
        (spaces, rims): (&[FaceSpace], &HashSet<[NodeId; 2]>),
        length: f64,
        energy: Matrices<'_>,
        mut found: Blocks,
    ) -> Blocks {
        found.bases.clear();
        found.basis_of.clear();
        found.inverses.resize(self.rows, Rows::default());
        for star in &self.stars {
            let faces = self.star_faces[star.of_faces()].iter().map(|face| face.face);
            let limits: Vec<_> = faces
                .map(|face| (face, spaces[face.index()].reaction))
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
            for (local, place) in around.sides {
                let face = &faces[place as usize];
                let mut rows = [[0.0; 2 * FACE]; WRENCH];
                for (both, row) in rows.iter_mut().zip(&matrix[FACE * usize::from(local) + 3..]) {
                    for (both, (other, _)) in both.chunks_exact_mut(FACE).zip(around.sides) {
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
                for ((_, place), of_face) in around.sides.into_iter().zip(of_wrench.chunks_exact(FACE)) {
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
            for (local, place) in around.sides {
                for (other, column) in around.sides.into_iter().filter(|(_, column)| *column <= place) {
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
    for (local, place) in around.sides {
        let first = FACE * usize::from(local) + 3;
        let [f0, f1, f2, t0, t1, t2] =
            std::array::from_fn(|i| f64::from(matrix[first + i][first + i]).max(0.0).sqrt());
        let [d0, d1, d2] = [0, 1, 2].map(|axis| faces[place as usize].lever[axis].abs());
        let own = [f0 + d2 * t1 + d1 * t2, f1 + d0 * t2 + d2 * t0, f2 + d1 * t0 + d0 * t1, t0, t1, t2];
        sizes.iter_mut().zip(own).for_each(|(size, own)| *size += own);
    }
    sizes
}

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
            for (local, place) in around.sides {
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
            for (local, place) in around.sides {
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

//! The energy of the cells for the coordinates of their faces, several cells side by side.

use super::cell::{BLOCK, CellMap, FACE, MOMENTS, PAIRS, Reference, order};
use super::potentials::{FaceMoment, FaceSpaces};
use crate::lanes::{LaneRow, Lanes, MOST_LANES};
use fem_core::body::tractions;
use fem_core::space::Solid;
use pulp::Simd;

/// Numbers of the four faces of a cell, with some zeros: whole vectors of the processor.
pub(crate) type CellNumbers = [f32; 40];

/// The energy matrix of a cell for the coordinates of its faces as the mesh stores them, row by row.
pub(crate) type EnergyMatrix = [CellNumbers; MOMENTS];

/// Cells side by side.
pub(crate) struct Batch {
    /// Of the fixed matrices of the reference tetrahedron.
    factors: [LaneRow; PAIRS],
    /// The moments on the reference tetrahedron of each coordinate of each face, by moments.
    maps: [[LaneRow; FACE * FACE]; 4],
    cells: usize,
}

impl Default for Batch {
    fn default() -> Self {
        let none = LaneRow::default();
        Self { factors: [none; PAIRS], maps: [[none; FACE * FACE]; 4], cells: 0 }
    }
}

impl Batch {
    /// Puts a cell in the next lane.
    ///
    /// * `factors`: see [`CellMap::factors`]; `columns`: the moments on each face of its coordinates.
    pub(crate) fn enter(&mut self, map: &CellMap, factors: [f64; PAIRS], columns: [[FaceMoment; FACE]; 4]) {
        let lane = self.cells;
        self.factors.iter_mut().zip(factors).for_each(|(row, factor)| row[lane] = factor);
        for (rows, columns) in self.maps.iter_mut().zip(columns) {
            for (j, column) in columns.into_iter().enumerate() {
                let moments = column.map(|moment| map.pulled_back(moment));
                for (k, value) in moments.iter().flat_map(|m| m.iter()).enumerate() {
                    rows[FACE * k + j][lane] = *value;
                }
            }
        }
        self.cells += 1;
    }

    /// Computes the energy matrices of the cells, and is empty again.
    pub(crate) fn take(&mut self, to: &mut [EnergyMatrix]) {
        pulp::Arch::new().dispatch(Energies { batch: self, to });
        self.cells = 0;
    }
}

/// Computes the energy matrices of some cells, over `unit`.
pub(crate) fn energies(
    (spaces, unit): (&FaceSpaces<'_>, f64),
    cells: impl Iterator<Item = usize>,
    to: &mut [EnergyMatrix],
) {
    for (place, cell) in energies_of_cells((spaces, unit), cells, to) {
        add_springs((spaces, unit), cell, &mut to[place]);
    }
}

/// Computes the energy matrices of some cells without springs, over `unit`; returns the places of cells on springs, and these.
fn energies_of_cells(
    (spaces, unit): (&FaceSpaces<'_>, f64),
    cells: impl Iterator<Item = usize>,
    to: &mut [EnergyMatrix],
) -> Vec<(usize, usize)> {
    let body = spaces.body;
    let (mesh, mut batch, mut left) = (body.mesh(), Batch::default(), to);
    let mut on_springs = Vec::new();
    let mut cells = cells.enumerate().peekable();
    while let Some((place, cell)) = cells.next() {
        let map = CellMap::new(mesh.corners(cell));
        let faces = mesh.topology().cell_facets()[cell];
        if faces.iter().any(|face| spaces.springs(*face).is_some()) {
            on_springs.push((place, cell));
        }
        let order = order(body, cell);
        let columns = std::array::from_fn(|k| {
            let (places, sign) = order[k];
            let columns = spaces.columns(faces[k]);
            columns.map(|column| places.map(|place| sign * column[place]))
        });
        batch.enter(&map, map.factors(|stress| body.material(cell).strain(stress), unit), columns);
        if batch.cells == MOST_LANES || cells.peek().is_none() {
            let (own, rest) = std::mem::take(&mut left).split_at_mut(batch.cells);
            batch.take(own);
            left = rest;
        }
    }
    on_springs
}

/// Adds the energy `∫ t·K⁻¹ t` of the tractions on the faces on springs to the energy matrix of a cell, over `unit`.
fn add_springs((spaces, unit): (&FaceSpaces<'_>, f64), cell: usize, matrix: &mut EnergyMatrix) {
    let mesh = spaces.body.mesh();
    for (k, face) in mesh.topology().cell_facets()[cell].into_iter().enumerate() {
        let Some(springs) = spaces.springs(face) else { continue };
        let columns = spaces.columns(face);
        let strained = columns.map(|of| springs.strained(&tractions::<Solid>(&of, mesh.facet_measure(face))));
        for (i, own) in columns.iter().enumerate() {
            for (j, other) in strained.iter().enumerate() {
                let energy: f64 = own.iter().zip(other).map(|(m, t)| m.dot(t)).sum();
                matrix[FACE * k + i][FACE * k + j] += (energy / unit) as f32;
            }
        }
    }
}

struct Energies<'a> {
    batch: &'a Batch,
    to: &'a mut [EnergyMatrix],
}

/// A block of two faces, by rows.
type Block<S> = [[Lanes<S>; FACE]; FACE];

impl pulp::WithSimd for Energies<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { batch, to } = self;
        let pairs = (0..4).flat_map(|k| (0..=k).map(move |l| (k, l)));
        for (part, cells) in to[..batch.cells].chunks_mut(S::F64_LANES).enumerate() {
            let load = |row: &LaneRow| Lanes::load_part(simd, row, part);
            let zero = [[Lanes::splat(simd, 0.0); FACE]; FACE];
            let factors: [Lanes<S>; PAIRS] = std::array::from_fn(|q| load(&batch.factors[q]));
            for ((k, l), reference) in pairs.clone().zip(&Reference::get().energy) {
                let of_moments = block(zero, &factors, reference);
                let [left, right] = [k, l].map(|face: usize| &batch.maps[face]);
                // H U
                let mut half = zero;
                for (half, row) in half.iter_mut().zip(&of_moments) {
                    for (h, right) in row.iter().zip(right.chunks_exact(FACE)) {
                        for (sum, u) in half.iter_mut().zip(right) {
                            *sum = sum.plus(*h, load(u));
                        }
                    }
                }
                let mut rows = [[LaneRow::default(); FACE]; FACE];
                for (i, row) in rows.iter_mut().enumerate() {
                    let mut sums = zero[0];
                    for (left, half) in left.chunks_exact(FACE).zip(&half) {
                        let u = load(&left[i]);
                        for (sum, h) in sums.iter_mut().zip(half) {
                            *sum = sum.plus(u, *h);
                        }
                    }
                    row.iter_mut().zip(sums).for_each(|(row, sum)| sum.store(row));
                }
                for (lane, to) in cells.iter_mut().enumerate() {
                    for (i, row) in rows.iter().enumerate() {
                        for (j, entry) in row.iter().enumerate() {
                            let entry = entry[lane] as f32;
                            to[FACE * k + i][FACE * l + j] = entry;
                            to[FACE * l + j][FACE * k + i] = entry;
                        }
                    }
                }
            }
        }
    }
}

/// Adds up the fixed matrices of a pair of faces.
#[inline(always)]
fn block<S: Simd>(
    zero: Block<S>,
    factors: &[Lanes<S>; PAIRS],
    reference: &[[f64; PAIRS]; BLOCK],
) -> Block<S> {
    let mut block = zero;
    for (sums, entries) in block.iter_mut().zip(reference.chunks_exact(FACE)) {
        for (q, factor) in factors.iter().enumerate() {
            for (sum, entries) in sums.iter_mut().zip(entries) {
                *sum = sum.plus_times(entries[q], *factor);
            }
        }
    }
    block
}

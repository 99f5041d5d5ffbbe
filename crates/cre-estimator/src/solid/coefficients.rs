//! The energy matrices of the cells of a body: stored, or computed again when a sweep needs them.

use super::blocks::Blocks;
use super::cell::MOMENTS;
use super::energy::{EnergyMatrix, energies};
use super::potentials::FaceSpaces;
use super::stars::{Cluster, Matrices};
use crate::recovery::StarMemory;
use fem_core::mesh::id::NodeId;
use rayon::prelude::*;
use std::collections::HashSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Cells handled by one task.
const CHUNK: usize = 256;

/// The energy matrices of a body.
pub(super) struct Coefficients<'a> {
    pub(super) spaces: FaceSpaces<'a>,
    /// The unit of energies of moments, 1/(Pa m): single precision has a small range.
    pub(super) unit: f64,
    /// Of all cells, over the unit; `None` if they are computed again. Zeros of plain numbers come from the system: each thread touches its own memory
    /// first.
    stored: Option<Vec<f32>>,
    /// Memory of matrices and blocks that were computed again, for the next ones.
    spare: Mutex<Vec<Vec<f32>>>,
    spare_blocks: Mutex<Vec<Blocks>>,
}

/// Locks a list of memory.
fn locked<T>(spare: &Mutex<Vec<T>>) -> MutexGuard<'_, Vec<T>> {
    spare.lock().unwrap_or_else(PoisonError::into_inner)
}

fn matrices(numbers: &[f32]) -> &[EnergyMatrix] {
    numbers.as_chunks().0.as_chunks().0
}

fn matrices_mut(numbers: &mut [f32]) -> &mut [EnergyMatrix] {
    numbers.as_chunks_mut().0.as_chunks_mut().0
}

/// Finds memory for the matrices of some cells: the used one if it suffices. What pads the rows is zero.
fn memory(cells: usize, used: Option<Vec<f32>>) -> Vec<f32> {
    let numbers = cells * size_of::<EnergyMatrix>() / size_of::<f32>();
    match used {
        Some(mut used) if used.capacity() >= numbers => {
            used.resize(numbers, 0.0);
            used
        }
        used => {
            drop(used);
            vec![0.0; numbers]
        }
    }
}

impl<'a> Coefficients<'a> {
    /// * `memory`: whether they are stored, and where.
    pub(super) fn new(spaces: FaceSpaces<'a>, unit: f64, memory: StarMemory<Coefficients<'_>>) -> Self {
        let mut made =
            Self { spaces, unit, stored: None, spare: Mutex::default(), spare_blocks: Mutex::default() };
        if let StarMemory::Stored(used) = memory {
            let mut stored =
                self::memory(made.spaces.body.mesh().cells().len(), used.and_then(|used| used.stored));
            matrices_mut(&mut stored).par_chunks_mut(CHUNK).enumerate().for_each(|(k, to)| {
                let cells = k * CHUNK..k * CHUNK + to.len();
                energies((&made.spaces, unit), cells, to);
            });
            made.stored = Some(stored);
        }
        made
    }

    /// Computes those of some cells again.
    ///
    /// * `changed`: cells whose faces have other spaces, ascending.
    pub(super) fn renew(&mut self, changed: &[u32]) {
        let Self { spaces, unit, stored, .. } = self;
        let Some(stored) = stored else { return };
        let mut renewed = vec![[[0.0; 40]; MOMENTS]; changed.len()];
        renewed.par_chunks_mut(CHUNK).zip(changed.par_chunks(CHUNK)).for_each(|(to, cells)| {
            energies((spaces, *unit), cells.iter().map(|cell| *cell as usize), to);
        });
        for (cell, matrix) in changed.iter().zip(renewed) {
            matrices_mut(stored)[*cell as usize] = matrix;
        }
    }

    /// Calls a function with the matrices of some cells.
    pub(super) fn with<T>(
        &self,
        cells: impl ExactSizeIterator<Item = usize>,
        then: impl FnOnce(Matrices<'_>) -> T,
    ) -> T {
        if let Some(stored) = &self.stored {
            return then(Matrices::OfBody(matrices(stored)));
        }
        let used = locked(&self.spare).pop();
        let mut own = memory(cells.len(), used);
        energies((&self.spaces, self.unit), cells, matrices_mut(&mut own));
        let result = then(Matrices::OfCells(matrices(&own)));
        locked(&self.spare).push(own);
        result
    }

    /// Tells whether they are stored.
    pub(super) fn are_stored(&self) -> bool {
        self.stored.is_some()
    }

    /// Computes the blocks of a cluster.
    ///
    /// * `used`: others, whose memory is used again.
    pub(super) fn blocks(&self, cluster: &Cluster, rims: &HashSet<[NodeId; 2]>, used: Blocks) -> Blocks {
        self.with(cells_of(cluster), |energy| self.blocks_of((cluster, rims), energy, used))
    }

    fn blocks_of(
        &self,
        (cluster, rims): (&Cluster, &HashSet<[NodeId; 2]>),
        energy: Matrices<'_>,
        used: Blocks,
    ) -> Blocks {
        cluster.blocks((&self.spaces, rims), energy, used)
    }

    /// Calls a function with the matrices and the blocks of a cluster.
    ///
    /// * `blocks`: `None` if they are computed again.
    pub(super) fn with_cluster(
        &self,
        (cluster, rims): (&Cluster, &HashSet<[NodeId; 2]>),
        blocks: Option<&Blocks>,
        then: impl FnOnce(Matrices<'_>, &Blocks),
    ) {
        self.with(cells_of(cluster), |energy| {
            if let Some(blocks) = blocks {
                return then(energy, blocks);
            }
            let used = locked(&self.spare_blocks).pop().unwrap_or_default();
            let own = self.blocks_of((cluster, rims), energy, used);
            then(energy, &own);
            locked(&self.spare_blocks).push(own);
        });
    }
}

fn cells_of(cluster: &Cluster) -> impl ExactSizeIterator<Item = usize> + '_ {
    cluster.cells().iter().map(|cell| *cell as usize)
}

//! The memory of the stars, computed before it is allocated.

use super::band::band_size;
use crate::lanes::{LaneRow, MOST_LANES};
use fem_core::mesh::TriMesh;
use std::collections::BTreeMap;

/// Batches of a band that are not full, for each number of spokes: some of its colours.
const PARTLY_FILLED: usize = 3;

/// Counts the bytes of the stars of a mesh and of the vectors of a relaxation.
///
/// A star of `s = valence + 3` unknowns has two packed blocks of `s (s+1)/2` numbers in single precision, and the couplings
/// of each spoke; its batch has room for [`MOST_LANES`] of them. The conjugate gradients have six vectors of three unknowns per vertex and one
/// per edge. Each thread inverts a batch of the largest stars in double precision.
pub(crate) fn bytes_of_stars(mesh: &TriMesh) -> usize {
    const SPOKE: usize = 12 + 23 * size_of::<f32>();
    const VECTORS: usize = 6 * size_of::<f64>();
    let topology = mesh.topology();
    let mut spokes = vec![0usize; mesh.points().len()];
    for n in topology.facets().as_flattened() {
        spokes[*n] += 1;
    }
    let mut stars = 0;
    for band in spokes.chunks(band_size(spokes.len()).max(1)) {
        let mut kinds: BTreeMap<usize, usize> = BTreeMap::new();
        band.iter().for_each(|spokes| *kinds.entry(*spokes).or_default() += 1);
        for (spokes, count) in kinds {
            let batches = count.div_ceil(MOST_LANES) + PARTLY_FILLED.min(count - 1);
            let size = spokes + 3;
            stars += batches * MOST_LANES * (spokes * SPOKE + size * (size + 1) * size_of::<f32>());
        }
    }
    let largest = 3 + spokes.iter().copied().max().unwrap_or(0);
    let working = (largest * (largest + 1) / 2 + largest * largest) * size_of::<LaneRow>();
    stars
        + VECTORS * (3 * mesh.points().len() + topology.facets().len())
        + working * rayon::current_num_threads()
}

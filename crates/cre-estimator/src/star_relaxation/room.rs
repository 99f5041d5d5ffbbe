//! The memory of the stars, computed before it is allocated.

use fem_core::mesh::TriMesh;

/// Counts the bytes of the stars of a mesh and of the vectors of a relaxation.
///
/// A star of `s = valence + 3` unknowns has two packed blocks of `s (s+1)/2` numbers in single precision, and the couplings
/// of each spoke. The conjugate gradients have four vectors of three unknowns per vertex and one per edge.
pub(crate) fn bytes_of_stars(mesh: &TriMesh) -> usize {
    // The share of a full batch.
    const PLACE: usize = 6;
    const SPOKE: usize = 12 + 23 * size_of::<f32>();
    const VECTORS: usize = 4 * size_of::<f64>();
    let topology = mesh.topology();
    let mut spokes = vec![0usize; mesh.points().len()];
    for n in topology.edges().as_flattened() {
        spokes[*n] += 1;
    }
    let stars: usize = spokes
        .into_iter()
        .map(|spokes| {
            let size = spokes + 3;
            PLACE + spokes * SPOKE + size * (size + 1) * size_of::<f32>()
        })
        .sum();
    stars + VECTORS * (3 * mesh.points().len() + topology.edges().len())
}

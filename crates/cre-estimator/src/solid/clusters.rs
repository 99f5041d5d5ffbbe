//! Clusters of edges that are swept at the same time.

use super::rings::Rings;
use fem_core::mesh::TetMesh;
use fem_core::mesh::id::FacetId;

/// The largest number of cells of a cluster.
const CELLS: usize = 2048;

/// Sorts the edges into clusters, and lists these by colours: no two clusters of one colour share a face of the cells around their edges. Inside a
/// cluster edges ascend, so that results do not depend on the number of threads.
pub(crate) fn clusters(mesh: &TetMesh, rings: &Rings) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
    let count = mesh.cells().len();
    let mut order: Vec<u32> = (0..count as u32).collect();
    let mut of_cell = vec![0u32; count];
    let mut clusters = 0;
    split(mesh, &mut order, &mut |cells| {
        cells.iter().for_each(|cell| of_cell[*cell as usize] = clusters);
        clusters += 1;
    });
    let mut members = vec![Vec::new(); clusters as usize];
    let mut of_cells: Vec<Vec<u32>> = vec![Vec::new(); count];
    for edge in 0..rings.len() {
        let ring = rings.get(edge);
        let cluster = of_cell[ring.cells[0].cell as usize];
        members[cluster as usize].push(edge as u32);
        for around in ring.cells {
            let clusters = &mut of_cells[around.cell as usize];
            if !clusters.contains(&cluster) {
                clusters.push(cluster);
            }
        }
    }
    let mut conflicts = vec![Vec::new(); members.len()];
    for face in 0..mesh.topology().facets().len() {
        let around = mesh.topology().facet_cells()[FacetId::new(face)];
        let mut near: Vec<u32> =
            around.iter().filter_map(|cell| of_cells.get(*cell as usize)).flatten().copied().collect();
        near.sort_unstable();
        near.dedup();
        for (k, a) in near.iter().enumerate() {
            near[k + 1..].iter().for_each(|b| conflicts[*b as usize].push(*a));
        }
    }
    let mut colours: Vec<Vec<u32>> = Vec::new();
    let mut colour_of = vec![0; members.len()];
    for cluster in 0..members.len() {
        let taken =
            |colour: &usize| conflicts[cluster].iter().any(|other| colour_of[*other as usize] == *colour);
        let colour = (0..).find(|colour| !taken(colour)).unwrap_or(0);
        colour_of[cluster] = colour;
        colours.resize_with(colours.len().max(colour + 1), Vec::new);
        colours[colour].push(cluster as u32);
    }
    (members, colours)
}

/// Halves cells along the longest axis of their centroids, until each part is a cluster.
fn split(mesh: &TetMesh, cells: &mut [u32], done: &mut dyn FnMut(&[u32])) {
    if cells.len() <= CELLS {
        done(cells);
        return;
    }
    let centre = |cell: u32| mesh.corners(cell as usize).iter().sum::<nalgebra::Vector3<f64>>();
    let first = centre(cells[0]);
    let (low, high) = cells
        .iter()
        .map(|cell| centre(*cell))
        .fold((first, first), |(low, high), x| (low.inf(&x), high.sup(&x)));
    let axis = (high - low).imax();
    let half = cells.len() / 2;
    cells.select_nth_unstable_by(half, |a, b| centre(*a)[axis].total_cmp(&centre(*b)[axis]).then(a.cmp(b)));
    let (before, after) = cells.split_at_mut(half);
    split(mesh, before, done);
    split(mesh, after, done);
}

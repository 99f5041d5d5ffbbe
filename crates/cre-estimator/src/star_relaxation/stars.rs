//! The vertex stars of a mesh, coloured, and the sweeps over them.

use super::band::{Band, Work, band_size};
use super::space::Space;
use super::triangle_energy::forms;
use crate::atomic_slots::AtomicSlots;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use fem_core::parallel::for_each_task;
use rayon::prelude::*;

/// All stars of a mesh, one band of vertices after another. Stars of one colour share no edge, and no star
/// writes what another one reads: two such vertices are not neighbours.
pub(super) struct Stars {
    bands: Vec<Band>,
    /// The colour of every vertex, and how many there are.
    colour_of: Vec<u32>,
    colours: usize,
    /// `A` is divided by it, so that its coefficients fit single precision in any units.
    unit: f64,
}

impl Stars {
    /// Assembles and inverts the blocks of all stars.
    ///
    /// * `colour_of`: see [`colour`].
    /// * `used`: stars whose memory is reused, because the first access to new memory is slow.
    pub(super) fn new(space: &Space<'_>, colour_of: Vec<u32>, used: Option<Self>) -> Self {
        let colours = colour_of.iter().max().map_or(0, |&c| c as usize + 1);
        let mut first = Vec::new();
        forms(space, &[0], 1.0, &mut first);
        let unit = first.as_flattened().iter().fold(0.0, |unit: f64, x| unit.max(x.abs()));
        let unit = if unit > 0.0 { unit } else { 1.0 };
        let nodes = colour_of.len();
        let size = band_size(nodes);
        let mut bands = used.map_or_else(Vec::new, |used| used.bands);
        bands.resize_with(nodes.div_ceil(size), Band::default);
        bands.par_iter_mut().enumerate().for_each_init(Work::default, |work, (k, band)| {
            band.renew(space, unit, &colour_of, colours, k * size..nodes.min((k + 1) * size), work);
        });
        Self { bands, colour_of, colours, unit }
    }

    /// Assembles the stars of every band again in which one has changed.
    pub(super) fn update(&mut self, space: &Space<'_>, changed: &[bool]) {
        let Self { bands, colour_of, colours, unit } = self;
        let size = band_size(colour_of.len());
        let marked = bands.par_iter_mut().zip(changed.par_chunks(size)).enumerate();
        marked.filter(|(_, (_, changed))| changed.contains(&true)).for_each(|(k, (band, changed))| {
            let nodes = k * size..k * size + changed.len();
            band.renew(space, *unit, colour_of, *colours, nodes, &mut Work::default());
        });
    }

    /// The colour of every vertex.
    pub(super) fn colours(&self) -> &[u32] {
        &self.colour_of
    }

    /// Counts the spokes whose couplings are stored.
    pub(super) fn stored_couplings(&self) -> usize {
        self.bands.iter().map(|band| band.stored_couplings()).sum()
    }

    /// Returns the number by which the energy and its gradient are divided here.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// Computes `z = M⁻¹ r`, one sweep over all stars and one back from zero, and `A z`.
    ///
    /// * `r`: divided by [`Self::unit`], as is A.
    ///
    /// The last colour is not repeated: its stars are at their minimum. So `M` is symmetric and positive. What is outside of a star of the colour
    /// that ends the sweep does not change any more: its rows of `A z` cost little then. Each other edge belongs to its end of the lower colour.
    pub(super) fn precondition(&self, r: &AtomicSlots, z: &AtomicSlots, product: &AtomicSlots) {
        z.update(|_, _| 0.0);
        let back = (0..self.colours).rev().skip(1);
        let last = (2 * self.colours).saturating_sub(2);
        for (visit, colour) in (0..self.colours).chain(back).enumerate() {
            let product = if visit == last { Some(product) } else { None };
            for_each_task(self.bands.len(), &|k| self.bands[k].relax(colour, (r, z), visit == 0, product));
        }
        for_each_task(self.bands.len(), &|k| self.bands[k].multiply(z, product, &self.colour_of));
    }
}

/// Colours the vertices greedily in their order. Two vertices of one colour share no edge.
pub(super) fn colour(mesh: &TriMesh) -> Vec<u32> {
    let nodes = mesh.points().len();
    let mut colours = vec![u32::MAX; nodes];
    let mut used: Vec<u32> = Vec::new();
    for i in 0..nodes {
        // The vertex itself has no colour yet.
        for &t in mesh.topology().cells_around(NodeId::new(i)) {
            for &j in &mesh.cells()[t as usize] {
                if let Some(mark) = used.get_mut(colours[j] as usize) {
                    *mark = i as u32;
                }
            }
        }
        let free = used.iter().position(|&mark| mark != i as u32).unwrap_or(used.len());
        if free == used.len() {
            used.push(u32::MAX);
        }
        colours[i] = free as u32;
    }
    colours
}

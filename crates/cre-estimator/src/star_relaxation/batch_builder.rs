//! A batch of stars that is being filled: the blocks of the complementary energy, assembled from the forms of triangles.

use super::airy::PLACES;
use super::equal::Forms;
use super::space::Space;
use crate::inverse::packed;
use crate::lanes::{LaneRow, MOST_LANES};
use crate::star::Star;
use fem_core::mesh::id::NodeId;

/// Couplings of one spoke with the unknowns outside the star: of the vertex's three unknowns with the ring
/// vertex (3×3, rows first) and the outer edge after the spoke (3), and of the spoke's own unknown with the
/// ring vertex at its end (3), the one before (3), the one after (3), and the outer edges before and after.
pub(super) const COUPLINGS: usize = 23;

/// Unknowns around one spoke of every star of a batch.
#[derive(Clone, Copy, Default)]
pub(super) struct Spoke {
    /// Of the spoke itself.
    pub(super) own: [u32; MOST_LANES],
    /// The first of the vertex at its end.
    pub(super) ring: [u32; MOST_LANES],
    /// Of the outer edge of the triangle after it.
    pub(super) rim: [u32; MOST_LANES],
}

/// A batch that is being filled, in double precision.
#[derive(Default)]
pub(super) struct BatchBuilder {
    pub(super) nodes: [NodeId; MOST_LANES],
    pub(super) stars: usize,
    pub(super) spokes: Vec<Spoke>,
    pub(super) outer: Vec<[LaneRow; COUPLINGS]>,
    pub(super) inner: Vec<LaneRow>,
    /// The batch of the band that it will be.
    pub(super) place: usize,
    /// Whether its coefficients are stored already: all stars of its kind have the same.
    pub(super) known: bool,
}

impl BatchBuilder {
    /// Prepares it for stars of this many spokes. Lanes without a star keep what was there: nodes and edges of the same mesh, and numbers whose
    /// results are not read.
    pub(super) fn renew(&mut self, spokes: usize, place: usize) {
        let size = 3 + spokes;
        (self.stars, self.place, self.known) = (0, place, false);
        self.spokes.resize(spokes, Spoke::default());
        self.outer.resize(spokes, [[0.0; MOST_LANES]; COUPLINGS]);
        self.inner.resize(size * (size + 1) / 2, [0.0; MOST_LANES]);
    }

    /// Puts a star in the next lane: its vertex and the unknowns around it.
    pub(super) fn enter(&mut self, space: &Space<'_>, node: NodeId, star: Star<'_>) {
        let lane = self.stars;
        self.nodes[lane] = node;
        for (j, (spoke, of)) in self.spokes.iter_mut().zip(star.spokes).enumerate() {
            // The last spoke of an open star has no triangle after it: its coupling with the rim is zero.
            let rim = star.triangles.get(j).map_or(of.edge, |sector| sector.rim);
            spoke.own[lane] = space.edge_unknown(of.edge) as u32;
            spoke.ring[lane] = 3 * u32::from(of.ring);
            spoke.rim[lane] = space.edge_unknown(rim) as u32;
        }
        self.stars += 1;
    }

    /// Assembles the coefficients of the star entered last from the forms of its triangles.
    pub(super) fn assemble(&mut self, star: Star<'_>, forms: &Forms) {
        let Self { outer, inner, .. } = self;
        let lane = self.stars - 1;
        for row in outer.as_flattened_mut().iter_mut().chain(inner.iter_mut()) {
            row[lane] = 0.0;
        }
        let count = star.spokes.len();
        for (j, sector) in star.triangles.iter().enumerate() {
            let form = forms.of(sector.triangle);
            let c = usize::from(sector.corner);
            let after = if j + 1 == count { 0 } else { j + 1 };
            // Places in the triangle: ring vertices, spokes before and after, outer edge.
            let (near, far) = (3 * ((c + 1) % 3), 3 * ((c + 2) % 3));
            let (before, next, rim) = (9 + c, 9 + (c + 2) % 3, 9 + (c + 1) % 3);
            let at = |a: usize, b: usize| form[PLACES[a][b]];

            let own = [3 * c, 3 * c + 1, 3 * c + 2, before, next];
            let place = [0, 1, 2, 3 + j, 3 + after];
            for a in 0..5 {
                for b in 0..=a {
                    inner[packed(place[a], place[b])][lane] += at(own[a], own[b]);
                }
            }

            for row in 0..3 {
                for k in 0..3 {
                    outer[j][3 * row + k][lane] += at(3 * c + row, near + k);
                    outer[after][3 * row + k][lane] += at(3 * c + row, far + k);
                }
                outer[j][9 + row][lane] += at(3 * c + row, rim);
            }
            for k in 0..3 {
                outer[j][12 + k][lane] += at(before, near + k);
                outer[j][18 + k][lane] += at(before, far + k);
                outer[after][12 + k][lane] += at(next, far + k);
                outer[after][15 + k][lane] += at(next, near + k);
            }
            outer[j][22][lane] += at(before, rim);
            outer[after][21][lane] += at(next, rim);
        }
    }

    /// Gives the first star's coefficients to all lanes.
    pub(super) fn spread(&mut self) {
        for row in self.outer.as_flattened_mut().iter_mut().chain(self.inner.iter_mut()) {
            *row = [row[0]; MOST_LANES];
        }
    }
}

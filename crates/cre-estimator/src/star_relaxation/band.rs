//! Stars of consecutive vertices: their blocks of the complementary energy, assembled, inverted and applied, several stars side by side.

use super::airy::{PLACES, packed};
use super::form::{Form, forms};
use super::inverse::invert;
use super::space::Space;
use crate::lanes::{Lanes, MOST_LANES, Row};
use crate::shared::Shared;
use crate::star::{self, Star, corner};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use pulp::Simd;
use std::ops::Range;

/// Vertices handled by one task: enough that most triangles around them have all their vertices among them, few enough
/// that the forms of these triangles stay in the cache, and that a small mesh gives work to several threads.
pub(super) fn band_size(vertices: usize) -> usize {
    (vertices / 8).clamp(256, 4096)
}

/// A coefficient of every star of a batch.
type Coefficients = [f32; MOST_LANES];

/// Couplings of one spoke with the unknowns outside the star: of the vertex's three unknowns with the ring
/// vertex (3×3, rows first) and the outer edge after the spoke (3), and of the spoke's own unknown with the
/// ring vertex at its end (3), the one before (3), the one after (3), and the outer edges before and after.
const COUPLINGS: usize = 23;

/// Unknowns around one spoke of every star of a batch.
#[derive(Clone, Copy, Default)]
struct Spoke {
    /// Of the spoke itself.
    own: [u32; MOST_LANES],
    /// The first of the vertex at its end.
    ring: [u32; MOST_LANES],
    /// Of the outer edge of the triangle after it.
    rim: [u32; MOST_LANES],
}

/// Stars of one colour with the same number of spokes, one in each lane, and where their spokes and blocks begin in the band.
#[derive(Clone, Copy, Default)]
struct Batch {
    nodes: [NodeId; MOST_LANES],
    stars: u32,
    first_spoke: u32,
    spokes: u32,
    first_entry: u32,
}

impl Batch {
    /// Counts the unknowns of a star: three of the vertex, then one per spoke.
    fn size(&self) -> usize {
        3 + self.spokes as usize
    }

    fn spokes(&self) -> Range<usize> {
        let first = self.first_spoke as usize;
        first..first + self.spokes as usize
    }

    fn entries(&self) -> Range<usize> {
        let (first, size) = (self.first_entry as usize, self.size());
        first..first + size * (size + 1) / 2
    }
}

/// Stars of consecutive vertices in batches, sorted by colour and stored in the order in which a sweep visits them.
///
/// The sweeps are limited by memory bandwidth: coefficients are stored in single precision, the unknowns in double.
/// Direction and length of the steps are then accurate to 1e-7, but the added stresses are still in exact equilibrium.
#[derive(Default)]
pub(super) struct Band {
    batches: Vec<Batch>,
    /// Where each colour starts in `batches`.
    starts: Vec<u32>,
    spokes: Vec<Spoke>,
    outer: Vec<[Coefficients; COUPLINGS]>,
    /// The stars' own blocks, lower half by rows.
    inner: Vec<Coefficients>,
    /// Their inverses, at the same places.
    inverse: Vec<Coefficients>,
}

/// The forms of the triangles around some vertices.
#[derive(Default)]
struct Forms {
    first: u32,
    /// Place of each triangle from `first` on in `forms`.
    places: Vec<u32>,
    triangles: Vec<u32>,
    forms: Vec<Form>,
}

impl Forms {
    /// Computes the forms, divided by `unit`, in the place of those of other vertices.
    fn renew(&mut self, space: &Space<'_>, unit: f64, nodes: Range<usize>) {
        let topology = space.body().mesh().topology();
        let around = || nodes.clone().flat_map(|n| topology.triangles_around(NodeId::new(n)).iter().copied());
        self.first = around().min().unwrap_or(0);
        let end = around().max().map_or(self.first, |last| last + 1);
        self.places.clear();
        self.places.resize((end - self.first) as usize, u32::MAX);
        self.triangles.clear();
        for t in around() {
            let place = &mut self.places[(t - self.first) as usize];
            if *place == u32::MAX {
                *place = self.triangles.len() as u32;
                self.triangles.push(t);
            }
        }
        forms(space, &self.triangles, unit, &mut self.forms);
    }

    fn of(&self, triangle: u32) -> &Form {
        &self.forms[self.places[(triangle - self.first) as usize] as usize]
    }
}

/// A batch that is being filled, in double precision.
#[derive(Default)]
struct Open {
    nodes: [NodeId; MOST_LANES],
    stars: usize,
    spokes: Vec<Spoke>,
    outer: Vec<[Row; COUPLINGS]>,
    inner: Vec<Row>,
    /// The batch of the band that it will be.
    place: usize,
}

/// Working space for the assembly of stars, reused for the next band.
#[derive(Default)]
pub(super) struct Work {
    forms: Forms,
    star: Star,
    open: Vec<Open>,
    columns: Vec<Row>,
}

impl Band {
    /// Assembles and inverts the stars of some vertices. Neighbours are consecutive, so the forms they share are still
    /// in the cache.
    pub(super) fn renew(
        &mut self,
        space: &Space<'_>,
        unit: f64,
        colour_of: &[u32],
        colours: usize,
        nodes: Range<usize>,
        work: &mut Work,
    ) {
        let mesh = space.body().mesh();
        let kind = |n: usize| [colour_of[n], spokes_of(mesh, NodeId::new(n))];
        let kinds = self.place(colours, nodes.clone().map(kind), work);
        work.forms.renew(space, unit, nodes.clone());
        let Work { forms, star, open, columns } = work;
        for n in nodes {
            let Ok(k) = kinds.binary_search(&kind(n)) else { continue };
            star.walk(mesh, NodeId::new(n));
            open[k].assemble(space, NodeId::new(n), star, forms);
            if open[k].stars == MOST_LANES {
                self.close(&mut open[k], columns);
            }
        }
        for open in &mut open[..kinds.len()] {
            if open.stars > 0 {
                self.close(open, columns);
            }
        }
    }

    /// Computes the places of the batches of stars of the given kinds (colour and spokes), and allocates them. Returns the different kinds,
    /// sorted; each has an empty batch in `work`.
    fn place(
        &mut self,
        colours: usize,
        stars: impl Iterator<Item = [u32; 2]>,
        work: &mut Work,
    ) -> Vec<[u32; 2]> {
        let mut all: Vec<[u32; 2]> = stars.collect();
        all.sort_unstable();
        self.batches.clear();
        self.starts.clear();
        self.starts.resize(colours + 1, 0);
        let mut kinds = Vec::new();
        let (mut spokes_before, mut entries) = (0, 0);
        for group in all.chunk_by(|a, b| a == b) {
            let [colour, spokes] = group[0];
            if work.open.len() == kinds.len() {
                work.open.push(Open::default());
            }
            work.open[kinds.len()].renew(spokes as usize, self.batches.len());
            kinds.push(group[0]);
            for stars in group.chunks(MOST_LANES) {
                let batch = Batch {
                    stars: stars.len() as u32,
                    first_spoke: spokes_before,
                    spokes,
                    first_entry: entries,
                    ..Batch::default()
                };
                spokes_before += spokes;
                entries += batch.entries().len() as u32;
                self.batches.push(batch);
            }
            self.starts[colour as usize + 1] = self.batches.len() as u32;
        }
        // Colours without a star.
        for c in 0..colours {
            self.starts[c + 1] = self.starts[c + 1].max(self.starts[c]);
        }
        // All entries are overwritten.
        self.spokes.resize(spokes_before as usize, Spoke::default());
        self.outer.resize(spokes_before as usize, [[0.0; MOST_LANES]; COUPLINGS]);
        self.inner.resize(entries as usize, [0.0; MOST_LANES]);
        self.inverse.resize(entries as usize, [0.0; MOST_LANES]);
        kinds
    }

    /// Stores a batch and its inverse, and empties it for the next stars of its kind.
    fn close(&mut self, open: &mut Open, columns: &mut Vec<Row>) {
        let batch = &mut self.batches[open.place];
        batch.nodes = open.nodes;
        let batch = *batch;
        self.spokes[batch.spokes()].copy_from_slice(&open.spokes);
        let outer = self.outer[batch.spokes()].as_flattened_mut();
        store(open.outer.as_flattened(), outer);
        store(&open.inner, &mut self.inner[batch.entries()]);
        invert(&mut open.inner, batch.size(), columns);
        store(&open.inner, &mut self.inverse[batch.entries()]);
        open.stars = 0;
        open.place += 1;
    }

    /// The batches of one colour.
    fn of_colour(&self, colour: usize) -> &[Batch] {
        &self.batches[self.starts[colour] as usize..self.starts[colour + 1] as usize]
    }

    /// Minimises over each star of a colour: `x_star = A_ss⁻¹ (r − A_so x_outside)`.
    ///
    /// * `from_zero`: whether `x` is still zero everywhere.
    pub(super) fn relax(&self, colour: usize, (r, unit): (&Shared, f64), x: &Shared, from_zero: bool) {
        pulp::Arch::new().dispatch(Relaxation { band: self, colour, r, unit, x, from_zero });
    }

    /// Computes the rows of `A x` of each star's vertex and of the spokes of which it is the first node.
    pub(super) fn multiply(&self, x: &Shared, unit: f64, y: &Shared) {
        pulp::Arch::new().dispatch(Product { band: self, x, unit, y });
    }
}

/// Stores numbers in single precision.
fn store(numbers: &[Row], stored: &mut [Coefficients]) {
    for (stored, x) in stored.as_flattened_mut().iter_mut().zip(numbers.as_flattened()) {
        *stored = *x as f32;
    }
}

/// Counts the spokes of a star: an open one has one spoke more than triangles.
fn spokes_of(mesh: &TriMesh, node: NodeId) -> u32 {
    (mesh.topology().triangles_around(node).len() + usize::from(!star::is_closed(mesh, node))) as u32
}

impl Open {
    /// Prepares it for stars of this many spokes. Lanes without a star keep what was there: nodes and edges of the same mesh, and numbers whose
    /// results are not read.
    fn renew(&mut self, spokes: usize, place: usize) {
        let size = 3 + spokes;
        (self.stars, self.place) = (0, place);
        self.spokes.resize(spokes, Spoke::default());
        self.outer.resize(spokes, [[0.0; MOST_LANES]; COUPLINGS]);
        self.inner.resize(size * (size + 1) / 2, [0.0; MOST_LANES]);
    }

    /// Assembles one star from the forms of its triangles, in the next lane.
    fn assemble(&mut self, space: &Space<'_>, node: NodeId, star: &Star, forms: &Forms) {
        let mesh = space.body().mesh();
        let lane = self.stars;
        let Self { nodes, spokes, outer, inner, .. } = self;
        let count = spokes.len();
        nodes[lane] = node;
        for row in outer.as_flattened_mut().iter_mut().chain(inner.iter_mut()) {
            row[lane] = 0.0;
        }
        for (spoke, &edge) in spokes.iter_mut().zip(&star.spokes) {
            let ends = mesh.topology().edges()[edge];
            let other = if ends[0] == node { ends[1] } else { ends[0] };
            let own = space.edge_unknown(edge) as u32;
            // The last spoke of an open star has no triangle after it: its coupling with the rim is zero.
            (spoke.own[lane], spoke.ring[lane], spoke.rim[lane]) = (own, 3 * u32::from(other), own);
        }
        for (j, &t) in star.triangles.iter().enumerate() {
            let form = forms.of(t);
            let c = corner(mesh, t, node);
            let after = if j + 1 == count { 0 } else { j + 1 };
            // Places in the triangle: ring vertices, spokes before and after, outer edge.
            let (near, far) = (3 * ((c + 1) % 3), 3 * ((c + 2) % 3));
            let (before, next, rim) = (9 + c, 9 + (c + 2) % 3, 9 + (c + 1) % 3);
            let edge = mesh.topology().triangle_edges()[t as usize][(c + 1) % 3];
            spokes[j].rim[lane] = space.edge_unknown(edge) as u32;
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
                outer[j][9 + row][lane] = at(3 * c + row, rim);
            }
            for k in 0..3 {
                outer[j][12 + k][lane] += at(before, near + k);
                outer[j][18 + k][lane] = at(before, far + k);
                outer[after][12 + k][lane] += at(next, far + k);
                outer[after][15 + k][lane] = at(next, near + k);
            }
            outer[j][22][lane] = at(before, rim);
            outer[after][21][lane] = at(next, rim);
        }
        self.stars += 1;
    }
}

/// Working space for the stars of a batch: one number per row and star, and the unknowns beyond each spoke.
#[derive(Default)]
struct Side {
    rows: Vec<Row>,
    own: Vec<Row>,
    /// The three unknowns of the ring vertex, and that of the outer edge after the spoke.
    beyond: Vec<[Row; 4]>,
}

impl Side {
    /// Reads the unknowns beyond the spokes.
    #[inline(always)]
    fn read_beyond(&mut self, spokes: &[Spoke], x: &Shared) {
        self.beyond.clear();
        for spoke in spokes {
            let mut beyond = [Row::default(); 4];
            for lane in 0..MOST_LANES {
                let ring = spoke.ring[lane] as usize;
                for k in 0..3 {
                    beyond[k][lane] = x.get(ring + k);
                }
                beyond[3][lane] = x.get(spoke.rim[lane] as usize);
            }
            self.beyond.push(beyond);
        }
    }

    /// Reads the stars' own unknowns, or entries of another vector at their places.
    #[inline(always)]
    fn read_own(&mut self, batch: &Batch, spokes: &[Spoke], x: &Shared) {
        self.own.clear();
        for k in 0..3 {
            self.own.push(batch.nodes.map(|n| x.get(3 * n.index() + k)));
        }
        self.own.extend(spokes.iter().map(|spoke| spoke.own.map(|i| x.get(i as usize))));
    }

    /// Computes the part of `A x` in the stars' rows that comes from the unknowns outside.
    #[inline(always)]
    fn outside<S: Simd>(&mut self, simd: S, outer: &[[Coefficients; COUPLINGS]]) {
        let Self { rows, beyond, .. } = self;
        rows.clear();
        rows.resize(3 + outer.len(), Row::default());
        let last = outer.len() - 1;
        for part in 0..MOST_LANES / S::F64_LANES {
            let load = |row: &Row| Lanes::load_part(simd, row, part);
            let zero = Lanes::splat(simd, 0.0);
            let mut total = [zero; 3];
            for (j, couplings) in outer.iter().enumerate() {
                // An open star has no triangle before its first spoke and after its last: zero couplings.
                let before = &beyond[if j > 0 { j - 1 } else { last }];
                let after = &beyond[if j < last { j + 1 } else { 0 }];
                let c = |k: usize| Lanes::load_single(simd, &couplings[k], part);
                let near = [load(&beyond[j][0]), load(&beyond[j][1]), load(&beyond[j][2])];
                let rim = load(&beyond[j][3]);
                for row in 0..3 {
                    for k in 0..3 {
                        total[row] = total[row].plus(c(3 * row + k), near[k]);
                    }
                    total[row] = total[row].plus(c(9 + row), rim);
                }
                let mut sum = (c(21) * load(&before[3])).plus(c(22), rim);
                for k in 0..3 {
                    sum = sum.plus(c(12 + k), near[k]);
                    sum = sum.plus(c(15 + k), load(&before[k])).plus(c(18 + k), load(&after[k]));
                }
                sum.store_part(&mut rows[3 + j], part);
            }
            for (row, total) in rows.iter_mut().zip(total) {
                total.store_part(row, part);
            }
        }
    }

    /// Computes the product of the symmetric blocks with `own`, by its lower half, in the rows; added to what is there if `add`.
    #[inline(always)]
    fn multiply_own<S: Simd>(&mut self, simd: S, lower: &[Coefficients], add: bool) {
        let Self { rows, own, .. } = self;
        rows.resize(own.len(), Row::default());
        for part in 0..MOST_LANES / S::F64_LANES {
            for (i, row) in rows.iter_mut().enumerate() {
                let mut sum = if add { Lanes::load_part(simd, row, part) } else { Lanes::splat(simd, 0.0) };
                for (j, own) in own.iter().enumerate() {
                    let a = Lanes::load_single(simd, &lower[packed(i, j)], part);
                    sum = sum.plus(a, Lanes::load_part(simd, own, part));
                }
                sum.store_part(row, part);
            }
        }
    }
}

/// [`Band::relax`], for [`pulp`] to compile for every kind of processor.
struct Relaxation<'a> {
    band: &'a Band,
    colour: usize,
    r: &'a Shared,
    unit: f64,
    x: &'a Shared,
    from_zero: bool,
}

impl pulp::WithSimd for Relaxation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { band, colour, r, unit, x, from_zero } = self;
        let mut side = Side::default();
        for batch in band.of_colour(colour) {
            let spokes = &band.spokes[batch.spokes()];
            side.rows.clear();
            side.rows.resize(batch.size(), Row::default());
            if !from_zero {
                side.read_beyond(spokes, x);
                side.outside(simd, &band.outer[batch.spokes()]);
            }
            side.read_own(batch, spokes, r);
            for (own, row) in side.own.iter_mut().zip(&side.rows) {
                for lane in 0..MOST_LANES {
                    own[lane] = own[lane] / unit - row[lane];
                }
            }
            side.multiply_own(simd, &band.inverse[batch.entries()], false);
            for lane in 0..batch.stars as usize {
                let node = 3 * batch.nodes[lane].index();
                (0..3).for_each(|k| x.set(node + k, side.rows[k][lane]));
                for (spoke, row) in spokes.iter().zip(&side.rows[3..]) {
                    x.set(spoke.own[lane] as usize, row[lane]);
                }
            }
        }
    }
}

/// [`Band::multiply`], for [`pulp`] to compile for every kind of processor.
struct Product<'a> {
    band: &'a Band,
    x: &'a Shared,
    unit: f64,
    y: &'a Shared,
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { band, x, unit, y } = self;
        let mut side = Side::default();
        for batch in &band.batches {
            let spokes = &band.spokes[batch.spokes()];
            side.read_beyond(spokes, x);
            side.outside(simd, &band.outer[batch.spokes()]);
            side.read_own(batch, spokes, x);
            side.multiply_own(simd, &band.inner[batch.entries()], true);
            for lane in 0..batch.stars as usize {
                let node = batch.nodes[lane];
                (0..3).for_each(|k| y.set(3 * node.index() + k, unit * side.rows[k][lane]));
                for (spoke, row) in spokes.iter().zip(&side.rows[3..]) {
                    if u32::from(node) < spoke.ring[lane] / 3 {
                        y.set(spoke.own[lane] as usize, unit * row[lane]);
                    }
                }
            }
        }
    }
}

//! Stars of consecutive vertices: their blocks of the complementary energy, assembled, inverted and applied, several stars side by side.

use super::batch_builder::{BatchBuilder, COUPLINGS, Spoke};
use super::equal::{Forms, Walks};
use super::space::Space;
use crate::atomic_slots::AtomicSlots;
use crate::inverse::{ROUND_OFF, invert, packed};
use crate::lanes::{LaneRow, Lanes, MOST_LANES};
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

/// Stars of one colour with the same number of spokes, one in each lane, and where their spokes and coefficients begin in the band.
#[derive(Clone, Copy, Default)]
struct Batch {
    nodes: [NodeId; MOST_LANES],
    stars: u32,
    spokes: u32,
    first_spoke: u32,
    coefficients: Offsets,
}

/// The offsets of a batch's coefficients in the band. Batches of equal stars have the same ones.
#[derive(Clone, Copy, Default)]
struct Offsets {
    coupling: u32,
    entry: u32,
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

    fn couplings(&self) -> Range<usize> {
        let first = self.coefficients.coupling as usize;
        first..first + self.spokes as usize
    }

    fn entries(&self) -> Range<usize> {
        let (first, size) = (self.coefficients.entry as usize, self.size());
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

/// Working space for the assembly of stars, reused for the next band.
#[derive(Default)]
pub(super) struct Work {
    forms: Forms,
    walks: Walks,
    builders: Vec<BatchBuilder>,
    columns: Vec<LaneRow>,
}

/// What the stars of a batch have in common: colour, spokes, and the vertex whose coefficients they have if these are stored once (the number of
/// the last vertex and one more if not).
type Kind = [u32; 3];

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
        work.forms.renew(space, unit, nodes.clone());
        work.walks.renew(mesh, nodes.clone(), &work.forms);
        let own = nodes.end as u32;
        let walks = &work.walks;
        let kind =
            |n: usize| [colour_of[n], walks.star(n).spokes.len() as u32, walks.equal(n).unwrap_or(own)];
        let kinds = self.place(colours, nodes.clone().map(kind), own, &mut work.builders);
        let Work { forms, builders, columns, .. } = work;
        for n in nodes {
            let Ok(k) = kinds.binary_search(&kind(n)) else { continue };
            let (builder, [.., equal]) = (&mut builders[k], kinds[k]);
            let star = walks.star(n);
            builder.enter(space, NodeId::new(n), star);
            if equal == own {
                builder.assemble(star, forms);
            } else if !builder.known && builder.stars == 1 {
                builder.assemble(star, forms);
                builder.spread();
            }
            if builder.stars == MOST_LANES {
                self.finish(builder, equal != own, columns);
            }
        }
        for (builder, [.., equal]) in builders.iter_mut().zip(&kinds) {
            if builder.stars > 0 {
                self.finish(builder, *equal != own, columns);
            }
        }
    }

    /// Computes the places of the batches of stars of the given kinds, and allocates them. Returns the different kinds,
    /// sorted; each has an empty batch in `builders`.
    ///
    /// * `own`: the last number of a kind whose stars have coefficients of their own.
    fn place(
        &mut self,
        colours: usize,
        stars: impl Iterator<Item = Kind>,
        own: u32,
        builders: &mut Vec<BatchBuilder>,
    ) -> Vec<Kind> {
        let mut all: Vec<Kind> = stars.collect();
        all.sort_unstable();
        self.batches.clear();
        self.starts.clear();
        self.starts.resize(colours + 1, 0);
        let mut kinds = Vec::new();
        let mut known: Vec<(u32, Offsets)> = Vec::new();
        let (mut first_spoke, mut next) = (0, Offsets::default());
        for group in all.chunk_by(|a, b| a == b) {
            let [colour, spokes, equal] = group[0];
            if builders.len() == kinds.len() {
                builders.push(BatchBuilder::default());
            }
            builders[kinds.len()].renew(spokes as usize, self.batches.len());
            kinds.push(group[0]);
            for stars in group.chunks(MOST_LANES) {
                let stored = known.iter().find(|(star, _)| *star == equal).map(|(_, place)| *place);
                let batch = Batch {
                    stars: stars.len() as u32,
                    spokes,
                    first_spoke,
                    coefficients: stored.unwrap_or(next),
                    ..Batch::default()
                };
                first_spoke += spokes;
                if stored.is_none() {
                    next = Offsets { coupling: next.coupling + spokes, entry: batch.entries().end as u32 };
                    if equal != own {
                        known.push((equal, batch.coefficients));
                    }
                }
                self.batches.push(batch);
            }
            self.starts[colour as usize + 1] = self.batches.len() as u32;
        }
        // Colours without a star.
        for c in 0..colours {
            self.starts[c + 1] = self.starts[c + 1].max(self.starts[c]);
        }
        // All entries are overwritten.
        self.spokes.resize(first_spoke as usize, Spoke::default());
        self.outer.resize(next.coupling as usize, [[0.0; MOST_LANES]; COUPLINGS]);
        self.inner.resize(next.entry as usize, [0.0; MOST_LANES]);
        self.inverse.resize(next.entry as usize, [0.0; MOST_LANES]);
        kinds
    }

    /// Stores a batch, its coefficients and their inverse, and empties it for the next stars of its kind.
    ///
    /// * `same`: whether all batches of the kind have the same coefficients, which the first one has stored.
    fn finish(&mut self, builder: &mut BatchBuilder, same: bool, columns: &mut Vec<LaneRow>) {
        let batch = &mut self.batches[builder.place];
        batch.nodes = builder.nodes;
        let batch = *batch;
        self.spokes[batch.spokes()].copy_from_slice(&builder.spokes);
        builder.stars = 0;
        builder.place += 1;
        if builder.known {
            return;
        }
        builder.known = same;
        let outer = self.outer[batch.couplings()].as_flattened_mut();
        store(builder.outer.as_flattened(), outer);
        store(&builder.inner, &mut self.inner[batch.entries()]);
        invert(&mut builder.inner, batch.size(), ROUND_OFF, columns);
        store(&builder.inner, &mut self.inverse[batch.entries()]);
    }

    /// Counts the spokes of stars whose couplings are stored.
    pub(super) fn stored_couplings(&self) -> usize {
        MOST_LANES * self.outer.len()
    }

    /// The batches of one colour.
    fn of_colour(&self, colour: usize) -> &[Batch] {
        &self.batches[self.starts[colour] as usize..self.starts[colour + 1] as usize]
    }

    /// Minimises over each star of a colour: `x_star = A_ss⁻¹ (r − A_so x_outside)`, with `A` and `r` divided by the unit of the stars.
    ///
    /// * `from_zero`: whether `x` is still zero everywhere.
    /// * `product`: takes the rows of `A x` of these stars, if what is outside of them does not change any more.
    pub(super) fn relax(
        &self,
        colour: usize,
        (r, x): (&AtomicSlots, &AtomicSlots),
        from_zero: bool,
        product: Option<&AtomicSlots>,
    ) {
        pulp::Arch::new().dispatch(Relaxation { band: self, colour, r, x, from_zero, product });
    }

    /// Computes the rows of `A x`, divided by that unit, of all stars but those of the first colour: of each star's vertex, and of the spokes that
    /// end at a higher colour.
    pub(super) fn multiply(&self, x: &AtomicSlots, y: &AtomicSlots, colour_of: &[u32]) {
        pulp::Arch::new().dispatch(Product { band: self, x, y, colour_of });
    }
}

/// Stores numbers in single precision.
fn store(numbers: &[LaneRow], stored: &mut [Coefficients]) {
    for (stored, x) in stored.as_flattened_mut().iter_mut().zip(numbers.as_flattened()) {
        *stored = *x as f32;
    }
}

/// Working space for the stars of a batch: one number per row and star, and the unknowns beyond each spoke.
#[derive(Default)]
struct Side {
    rows: Vec<LaneRow>,
    /// The rows that [`Self::outside`] has computed.
    kept: Vec<LaneRow>,
    own: Vec<LaneRow>,
    /// The three unknowns of the ring vertex, and that of the outer edge after the spoke.
    beyond: Vec<[LaneRow; 4]>,
}

impl Side {
    /// Reads the unknowns beyond the spokes.
    #[inline(always)]
    fn read_beyond(&mut self, spokes: &[Spoke], x: &AtomicSlots) {
        // All entries are overwritten.
        self.beyond.resize(spokes.len(), [LaneRow::default(); 4]);
        for (spoke, beyond) in spokes.iter().zip(&mut self.beyond) {
            for lane in 0..MOST_LANES {
                let [value, slope, other] = x.three(spoke.ring[lane] as usize);
                beyond[0][lane] = value;
                beyond[1][lane] = slope;
                beyond[2][lane] = other;
                beyond[3][lane] = x.get(spoke.rim[lane] as usize);
            }
        }
    }

    /// Reads the stars' own unknowns, or entries of another vector at their places.
    #[inline(always)]
    fn read_own(&mut self, batch: &Batch, spokes: &[Spoke], x: &AtomicSlots) {
        self.own.resize(batch.size(), LaneRow::default());
        let [value, slope, other, of_spokes @ ..] = self.own.as_mut_slice() else { return };
        for (lane, n) in batch.nodes.iter().enumerate() {
            [value[lane], slope[lane], other[lane]] = x.three(3 * n.index());
        }
        for (row, spoke) in of_spokes.iter_mut().zip(spokes) {
            for (x_of, i) in row.iter_mut().zip(spoke.own) {
                *x_of = x.get(i as usize);
            }
        }
    }

    /// Writes the rows to the places of the stars' own unknowns.
    #[inline(always)]
    fn write(&self, batch: &Batch, spokes: &[Spoke], to: &AtomicSlots) {
        let [value, slope, other, of_spokes @ ..] = self.rows.as_slice() else { return };
        for lane in 0..batch.stars as usize {
            to.set_three(3 * batch.nodes[lane].index(), [value[lane], slope[lane], other[lane]]);
            for (spoke, row) in spokes.iter().zip(of_spokes) {
                to.set(spoke.own[lane] as usize, row[lane]);
            }
        }
    }

    /// Computes the part of `A x` in the stars' rows that comes from the unknowns outside.
    ///
    /// * `of_spokes`: whether in the rows of the spokes, too.
    #[inline(always)]
    fn outside<S: Simd>(&mut self, simd: S, outer: &[[Coefficients; COUPLINGS]], of_spokes: bool) {
        let Self { rows, beyond, .. } = self;
        rows.clear();
        rows.resize(if of_spokes { 3 + outer.len() } else { 3 }, LaneRow::default());
        let last = outer.len() - 1;
        for part in 0..MOST_LANES / S::F64_LANES {
            let load = |row: &LaneRow| Lanes::load_part(simd, row, part);
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
                if !of_spokes {
                    continue;
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

    /// Computes the rows that there are of the product of the symmetric blocks with `own`, by its lower half; added to what is there if `add`.
    #[inline(always)]
    fn multiply_own<S: Simd>(&mut self, simd: S, lower: &[Coefficients], add: bool) {
        let Self { rows, own, .. } = self;
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
    r: &'a AtomicSlots,
    x: &'a AtomicSlots,
    from_zero: bool,
    product: Option<&'a AtomicSlots>,
}

impl pulp::WithSimd for Relaxation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { band, colour, r, x, from_zero, product } = self;
        let mut side = Side::default();
        for batch in band.of_colour(colour) {
            let spokes = &band.spokes[batch.spokes()];
            side.rows.clear();
            side.rows.resize(batch.size(), LaneRow::default());
            if !from_zero {
                side.read_beyond(spokes, x);
                side.outside(simd, &band.outer[batch.couplings()], true);
            }
            side.read_own(batch, spokes, r);
            for (own, row) in side.own.iter_mut().zip(&side.rows) {
                own.iter_mut().zip(row).for_each(|(own, row)| *own -= row);
            }
            if product.is_some() {
                side.kept.clone_from(&side.rows);
            }
            side.multiply_own(simd, &band.inverse[batch.entries()], false);
            side.write(batch, spokes, x);
            if let Some(product) = product {
                let Side { rows, kept, own, .. } = &mut side;
                std::mem::swap(own, rows);
                std::mem::swap(rows, kept);
                side.multiply_own(simd, &band.inner[batch.entries()], true);
                side.write(batch, spokes, product);
            }
        }
    }
}

/// [`Band::multiply`], for [`pulp`] to compile for every kind of processor.
struct Product<'a> {
    band: &'a Band,
    x: &'a AtomicSlots,
    y: &'a AtomicSlots,
    colour_of: &'a [u32],
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { band, x, y, colour_of } = self;
        let mut side = Side::default();
        let colours = band.starts.len() - 1;
        for colour in 1..colours {
            // No spoke ends at a higher colour than the last one.
            let of_spokes = colour + 1 < colours;
            for batch in band.of_colour(colour) {
                let spokes = &band.spokes[batch.spokes()];
                side.read_beyond(spokes, x);
                side.outside(simd, &band.outer[batch.couplings()], of_spokes);
                side.read_own(batch, spokes, x);
                side.multiply_own(simd, &band.inner[batch.entries()], true);
                let [value, slope, other, rows @ ..] = side.rows.as_slice() else { continue };
                for lane in 0..batch.stars as usize {
                    let first = 3 * batch.nodes[lane].index();
                    y.set_three(first, [value[lane], slope[lane], other[lane]]);
                    for (spoke, row) in spokes.iter().zip(rows) {
                        if colour_of[spoke.ring[lane] as usize / 3] > colour as u32 {
                            y.set(spoke.own[lane] as usize, row[lane]);
                        }
                    }
                }
            }
        }
    }
}

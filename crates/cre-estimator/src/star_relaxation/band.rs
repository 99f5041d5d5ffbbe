//! Stars of consecutive vertices: their blocks of the complementary energy, assembled, inverted and applied.

use super::airy::{PLACES, packed};
use super::form::{Form, forms};
use super::inverse::Inverter;
use super::space::Space;
use crate::shared::Shared;
use crate::star::{self, Star, corner};
use fem_core::mesh::id::NodeId;
use std::ops::Range;

/// Vertices handled by one task: enough that most triangles around them have all their vertices among them, few enough
/// that the forms of these triangles stay in the cache, and that a small mesh gives work to several threads.
pub(super) fn band_size(vertices: usize) -> usize {
    (vertices / 8).clamp(256, 4096)
}

/// Couplings of one spoke with the unknowns outside the star, column by column: of the vertex's three unknowns and of the spoke's own with the
/// ring vertex at its end (three columns) and with the outer edge after the spoke; then, of the spoke's own alone, with the ring vertex before
/// and the outer edge before, and with the ring vertex after.
type Outer = [[f32; 4]; 6];

/// [`Outer`] in double precision, before it is stored.
type OuterSum = [[f64; 4]; 6];

/// One star: its vertex, and where its spokes and its blocks begin in the band.
#[derive(Clone, Copy, Default)]
struct Place {
    node: NodeId,
    first_spoke: u32,
    spokes: u32,
    first_entry: u32,
    closed: bool,
}

impl Place {
    /// Counts its unknowns: three of the vertex, then one per spoke.
    fn size(&self) -> usize {
        3 + self.spokes as usize
    }
}

/// Unknowns around one spoke.
#[derive(Clone, Copy, Default)]
struct Spoke {
    /// Of the spoke itself.
    own: u32,
    /// The first of the vertex at its end.
    ring: u32,
    /// Of the outer edge of the triangle after it.
    rim: u32,
}

/// Stars of consecutive vertices, sorted by colour and stored in the order in which a sweep visits them.
///
/// The sweeps are limited by memory bandwidth: coefficients are stored in single precision, the unknowns in double.
/// Direction and length of the steps are then accurate to 1e-7, but the added stresses are still in exact equilibrium.
#[derive(Default)]
pub(super) struct Band {
    places: Vec<Place>,
    /// Where each colour starts in `places`.
    starts: Vec<u32>,
    spokes: Vec<Spoke>,
    outer: Vec<Outer>,
    /// The stars' own blocks, lower half by rows.
    inner: Vec<f32>,
    /// Their inverses, at the same places.
    inverse: Vec<f32>,
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

/// Working space for the assembly of stars, reused for the next band.
#[derive(Default)]
pub(super) struct Work {
    forms: Forms,
    /// One star in double precision, before it is stored.
    star: Star,
    inner: Vec<f64>,
    outer: Vec<OuterSum>,
    inverter: Inverter,
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
        self.place(space, colour_of, colours, nodes.clone());
        work.forms.renew(space, unit, nodes.clone());
        let mut next = self.starts.clone();
        for n in nodes {
            let place = &mut next[colour_of[n] as usize];
            self.assemble(space, *place as usize, work);
            *place += 1;
        }
        work.inverter.finish(&mut self.inverse);
    }

    /// Computes the storage places of the stars of some vertices, and allocates them.
    fn place(&mut self, space: &Space<'_>, colour_of: &[u32], colours: usize, nodes: Range<usize>) {
        let mesh = space.body().mesh();
        let starts = &mut self.starts;
        starts.clear();
        starts.resize(colours + 1, 0);
        for n in nodes.clone() {
            starts[colour_of[n] as usize + 1] += 1;
        }
        for c in 0..colours {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        self.places.clear();
        self.places.resize(nodes.len(), Place::default());
        for n in nodes {
            let place = &mut next[colour_of[n] as usize];
            self.places[*place as usize].node = NodeId::new(n);
            *place += 1;
        }
        let (mut spokes, mut entries) = (0, 0);
        for place in &mut self.places {
            let node = place.node;
            place.closed = star::is_closed(mesh, node);
            // An open star has one spoke more than triangles.
            place.spokes = (mesh.topology().triangles_around(node).len() + usize::from(!place.closed)) as u32;
            (place.first_spoke, place.first_entry) = (spokes, entries);
            spokes += place.spokes;
            entries += (place.size() * (place.size() + 1) / 2) as u32;
        }
        // All entries are overwritten.
        self.spokes.resize(spokes as usize, Spoke::default());
        self.outer.resize(spokes as usize, Outer::default());
        self.inner.resize(entries as usize, 0.0);
        self.inverse.resize(entries as usize, 0.0);
    }

    /// Assembles one star from the forms of its triangles, in double precision first.
    fn assemble(&mut self, space: &Space<'_>, place: usize, work: &mut Work) {
        let mesh = space.body().mesh();
        let place = self.places[place];
        let node = place.node;
        let Work { forms, star, inner, outer, inverter } = work;
        star.walk(mesh, node);
        let (count, size) = (place.spokes as usize, place.size());
        let spokes = &mut self.spokes[place.first_spoke as usize..][..count];
        outer.clear();
        outer.resize(count, OuterSum::default());
        inner.clear();
        inner.resize(size * (size + 1) / 2, 0.0);
        for (spoke, &edge) in spokes.iter_mut().zip(&star.spokes) {
            let ends = mesh.topology().edges()[edge];
            let other = if ends[0] == node { ends[1] } else { ends[0] };
            let own = space.edge_unknown(edge) as u32;
            // The last spoke of an open star has no triangle after it: its coupling with the rim is zero.
            *spoke = Spoke { own, ring: 3 * u32::from(other), rim: own };
        }
        for (j, &t) in star.triangles.iter().enumerate() {
            let form = forms.of(t);
            let c = corner(mesh, t, node);
            let after = if j + 1 == count { 0 } else { j + 1 };
            // Places in the triangle: ring vertices, spokes before and after, outer edge.
            let (near, far) = (3 * ((c + 1) % 3), 3 * ((c + 2) % 3));
            let (before, next, rim) = (9 + c, 9 + (c + 2) % 3, 9 + (c + 1) % 3);
            let edge = mesh.topology().triangle_edges()[t as usize][(c + 1) % 3];
            spokes[j].rim = space.edge_unknown(edge) as u32;
            let at = |a: usize, b: usize| form[PLACES[a][b]];

            let own = [3 * c, 3 * c + 1, 3 * c + 2, before, next];
            let place = [0, 1, 2, 3 + j, 3 + after];
            for a in 0..5 {
                for b in 0..=a {
                    inner[packed(place[a], place[b])] += at(own[a], own[b]);
                }
            }

            for row in 0..3 {
                for k in 0..3 {
                    outer[j][k][row] += at(3 * c + row, near + k);
                    outer[after][k][row] += at(3 * c + row, far + k);
                }
                outer[j][3][row] = at(3 * c + row, rim);
            }
            for k in 0..3 {
                outer[j][k][3] += at(before, near + k);
                outer[j][5][k] = at(before, far + k);
                outer[after][k][3] += at(next, far + k);
                outer[after][4][k] += at(next, near + k);
            }
            outer[j][3][3] = at(before, rim);
            outer[after][4][3] = at(next, rim);
        }
        for (stored, spoke) in self.outer[place.first_spoke as usize..].iter_mut().zip(outer) {
            *stored = spoke.map(|column| column.map(|x| x as f32));
        }
        let first = place.first_entry as usize;
        for (stored, x) in self.inner[first..].iter_mut().zip(inner.iter()) {
            *stored = *x as f32;
        }
        inverter.push(inner, size, first, &mut self.inverse);
    }

    /// The stars of one colour.
    fn of_colour(&self, colour: usize) -> &[Place] {
        &self.places[self.starts[colour] as usize..self.starts[colour + 1] as usize]
    }

    /// Computes the part of `A x` in a star's rows that comes from the unknowns outside the star.
    #[inline(always)]
    fn outside(&self, place: &Place, x: &Shared, rows: &mut Vec<f64>) {
        let first = place.first_spoke as usize;
        let count = place.spokes as usize;
        let spokes = &self.spokes[first..first + count];
        let outer = &self.outer[first..first + count];
        // The ring vertex at the end of a spoke, and the outer edge after it.
        let beyond = |spoke: &Spoke| {
            let ring = spoke.ring as usize;
            [x.get(ring), x.get(ring + 1), x.get(ring + 2), x.get(spoke.rim as usize)]
        };
        rows.clear();
        rows.resize(3, 0.0);
        let last = count - 1;
        // An open star has no triangle before its first spoke and after its last: zero couplings.
        let mut before = if place.closed { beyond(&spokes[last]) } else { [0.0; 4] };
        let first = beyond(&spokes[0]);
        let mut near = first;
        let mut total = [0.0; 3];
        for (j, columns) in outer.iter().enumerate() {
            let after = if j < last { beyond(&spokes[j + 1]) } else { first };
            let mut sums = [0.0; 4];
            for (column, x) in columns[..4].iter().zip(near) {
                for (sum, c) in sums.iter_mut().zip(column) {
                    *sum += f64::from(*c) * x;
                }
            }
            let mut own = [0.0; 4];
            for k in 0..4 {
                own[k] = f64::from(columns[4][k]) * before[k] + f64::from(columns[5][k]) * after[k];
            }
            for (total, sum) in total.iter_mut().zip(sums) {
                *total += sum;
            }
            rows.push(sums[3] + ((own[0] + own[1]) + (own[2] + own[3])));
            (before, near) = (near, after);
        }
        rows[..3].copy_from_slice(&total);
    }

    /// Unknown of a star's row.
    #[inline(always)]
    fn unknown(&self, place: &Place, row: usize) -> usize {
        match row {
            0..3 => 3 * place.node.index() + row,
            _ => self.spokes[place.first_spoke as usize + row - 3].own as usize,
        }
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

/// [`Band::relax`], for [`pulp`] to compile for every kind of processor.
struct Relaxation<'a> {
    band: &'a Band,
    colour: usize,
    r: &'a Shared,
    unit: f64,
    x: &'a Shared,
    from_zero: bool,
}

impl pulp::NullaryFnOnce for Relaxation<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { band, colour, r, unit, x, from_zero } = self;
        let (mut rows, mut solution) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for place in band.of_colour(colour) {
            if from_zero {
                rows.clear();
                rows.resize(place.size(), 0.0);
            } else {
                band.outside(place, x, &mut rows);
            }
            for (row, value) in rows.iter_mut().enumerate() {
                *value = r.get(band.unknown(place, row)) / unit - *value;
            }
            solution.clear();
            solution.resize(rows.len(), 0.0);
            multiply_symmetric(&band.inverse[place.first_entry as usize..], &rows, &mut solution);
            for (row, value) in solution.iter().enumerate() {
                x.set(band.unknown(place, row), *value);
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

impl pulp::NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { band, x, unit, y } = self;
        let (mut rows, mut own) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for place in &band.places {
            band.outside(place, x, &mut rows);
            own.clear();
            own.extend((0..rows.len()).map(|row| x.get(band.unknown(place, row))));
            multiply_symmetric(&band.inner[place.first_entry as usize..], &own, &mut rows);
            for (row, value) in rows.iter().enumerate() {
                let other = if row < 3 {
                    u32::MAX
                } else {
                    band.spokes[place.first_spoke as usize + row - 3].ring / 3
                };
                if u32::from(place.node) < other {
                    y.set(band.unknown(place, row), unit * value);
                }
            }
        }
    }
}

/// Adds `A x` to `y`, with the lower half of a symmetric matrix by rows.
#[inline(always)]
fn multiply_symmetric(lower: &[f32], x: &[f64], y: &mut [f64]) {
    let mut rest = lower;
    for i in 0..x.len() {
        let (row, below) = rest.split_at(i + 1);
        let (xi, mut sum) = (x[i], f64::from(row[i]) * x[i]);
        for ((a, xj), yj) in row[..i].iter().map(|a| f64::from(*a)).zip(x).zip(y.iter_mut()) {
            sum += a * xj;
            *yj += a * xi;
        }
        y[i] += sum;
        rest = below;
    }
}

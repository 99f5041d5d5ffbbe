//! The vertex stars: their blocks of the complementary energy, coloured, and the sweeps over them.

use super::airy::{Cell, Form, PLACES, packed};
use super::shared::Shared;
use super::space::Space;
use crate::star::{Star, corner};
use fem_core::mesh::TriMesh;
use rayon::prelude::*;

/// Vertices whose stars are assembled by one task: enough for most triangles around them to have all their vertices
/// among them, few enough for the forms of these triangles to stay in the cache.
const BAND: usize = 4096;
/// A pivot below this fraction of its diagonal entry is round-off: its unknown is left out of the star.
const PIVOT_FLOOR: f64 = 1e-12;

/// Couplings of one spoke with the unknowns outside the star: of the vertex's three unknowns with the ring
/// vertex (3×3, rows first) and the outer edge after the spoke (3), and of the spoke's own unknown with the
/// ring vertex at its end (3), the one before (3), the one after (3), and the outer edges before and after.
type Outer = [f32; 23];

/// One star: its vertex, and where its spokes and its blocks begin in the chunk.
struct Place {
    node: u32,
    first_spoke: u32,
    spokes: u32,
    first_entry: u32,
    closed: bool,
}

/// Unknowns around one spoke.
#[derive(Clone, Copy)]
struct Spoke {
    /// Of the spoke itself.
    own: u32,
    /// The first of the vertex at its end.
    ring: u32,
    /// Of the outer edge of the triangle after it.
    rim: u32,
}

/// Stars of one colour, next to each other in memory in the order in which a sweep visits them.
///
/// The sweeps are as fast as the memory: coefficients are kept in single precision, the unknowns in double. What
/// direction the steps take and how long they are is then right to 1e-7, and what they add is in exact equilibrium
/// all the same.
struct Chunk {
    places: Vec<Place>,
    spokes: Vec<Spoke>,
    outer: Vec<Outer>,
    /// The star's own block, lower half by rows: three unknowns of the vertex, then one per spoke.
    inner: Vec<f32>,
    /// Its inverse.
    inverse: Vec<f32>,
}

/// One star in double precision, before it is stored.
#[derive(Default)]
struct Work {
    inner: Vec<f64>,
    outer: Vec<[f64; 23]>,
    columns: Vec<f64>,
}

/// All stars of a mesh by colour, one chunk per band of vertices. Stars of one colour share no edge, and none writes
/// what another reads: two such vertices are no neighbours.
pub(super) struct Stars {
    colours: Vec<Vec<Chunk>>,
    /// The colour of every vertex.
    colour_of: Vec<u32>,
    /// What the coefficients are divided by, so that single precision holds them whatever the units.
    unit: f64,
}

impl Stars {
    /// Assembles and inverts the blocks of all stars.
    pub(super) fn new(space: &Space<'_>) -> Self {
        let colour_of = colour(space.body().mesh());
        let count = colour_of.iter().max().map_or(0, |&c| c as usize + 1);
        let unit = Cell::new(space, 0).form(space).iter().fold(0.0, |unit: f64, x| unit.max(x.abs()));
        let unit = if unit > 0.0 { unit } else { 1.0 };
        let bands: Vec<Vec<Chunk>> = (0..colour_of.len().div_ceil(BAND))
            .into_par_iter()
            .map(|k| band(space, unit, &colour_of, k, count))
            .collect();
        let mut colours: Vec<Vec<Chunk>> = (0..count).map(|_| Vec::with_capacity(bands.len())).collect();
        for band in bands {
            for (colour, chunk) in colours.iter_mut().zip(band) {
                colour.push(chunk);
            }
        }
        Self { colours, colour_of, unit }
    }

    /// Assembles the stars anew of every band in which one has changed.
    pub(super) fn update(&mut self, space: &Space<'_>, changed: &[bool]) {
        let count = self.colours.len();
        for (k, _) in changed.chunks(BAND).enumerate().filter(|(_, band)| band.contains(&true)) {
            for (colour, chunk) in
                self.colours.iter_mut().zip(band(space, self.unit, &self.colour_of, k, count))
            {
                colour[k] = chunk;
            }
        }
    }

    /// Computes `y = A x`.
    pub(super) fn multiply(&self, x: &Shared, y: &Shared) {
        for chunks in &self.colours {
            chunks.par_iter().for_each(|chunk| chunk.multiply(x, self.unit, y));
        }
    }

    /// Computes `z = M⁻¹ r`: one sweep over all stars and one back, from zero.
    ///
    /// The last colour is not repeated: its stars are at their minimum. So `M` is symmetric and positive.
    pub(super) fn precondition(&self, r: &Shared, z: &Shared) {
        z.update(|_, _| 0.0);
        let back = self.colours.iter().rev().skip(1);
        for chunks in self.colours.iter().chain(back) {
            chunks.par_iter().for_each(|chunk| chunk.relax(r, self.unit, z));
        }
    }
}

/// Colours the vertices greedily in their order. Two vertices of one colour share no edge.
fn colour(mesh: &TriMesh) -> Vec<u32> {
    let (starts, neighbours) = mesh.topology().node_neighbours();
    let nodes = mesh.points().len();
    let mut colours = vec![u32::MAX; nodes];
    let mut used: Vec<u32> = Vec::new();
    for i in 0..nodes {
        for &j in &neighbours[starts[i] as usize..starts[i + 1] as usize] {
            if let Some(mark) = used.get_mut(colours[j as usize] as usize) {
                *mark = i as u32;
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

/// Assembles the stars of one band of vertices: a chunk of each colour. Neighbours follow each other, so that the
/// forms they share are still in the cache.
fn band(space: &Space<'_>, unit: f64, colour_of: &[u32], k: usize, colours: usize) -> Vec<Chunk> {
    let topology = space.body().mesh().topology();
    let nodes = k * BAND..colour_of.len().min((k + 1) * BAND);
    let forms = Forms::around(space, unit, nodes.clone());
    let mut sizes = vec![[0; 3]; colours];
    for n in nodes.clone() {
        // An open star has one spoke more than triangles, so this is enough.
        let spokes = topology.triangles_around(n).len() + 1;
        let [stars, all_spokes, entries] = &mut sizes[colour_of[n] as usize];
        *stars += 1;
        *all_spokes += spokes;
        *entries += (3 + spokes) * (4 + spokes) / 2;
    }
    let mut chunks: Vec<Chunk> = sizes.into_iter().map(Chunk::with_capacity).collect();
    let (mut star, mut work) = (Star::default(), Work::default());
    for n in nodes {
        star.walk(space.body().mesh(), n);
        chunks[colour_of[n] as usize].push(space, &forms, n as u32, &star, &mut work);
    }
    chunks
}

/// The forms of the triangles around some vertices.
struct Forms {
    first: u32,
    /// Place of each triangle from `first` on in `forms`.
    places: Vec<u32>,
    forms: Vec<Form>,
}

impl Forms {
    /// Computes the forms, divided by `unit`.
    fn around(space: &Space<'_>, unit: f64, nodes: std::ops::Range<usize>) -> Self {
        let topology = space.body().mesh().topology();
        let triangles = || nodes.clone().flat_map(|n| topology.triangles_around(n).iter().copied());
        let first = triangles().min().unwrap_or(0);
        let end = triangles().max().map_or(first, |last| last + 1);
        let mut places = vec![u32::MAX; (end - first) as usize];
        let mut forms = Vec::with_capacity(2 * nodes.len() + 64);
        for t in triangles() {
            let place = &mut places[(t - first) as usize];
            if *place == u32::MAX {
                *place = forms.len() as u32;
                forms.push(Cell::new(space, t as usize).form(space).map(|x| x / unit));
            }
        }
        Self { first, places, forms }
    }

    fn of(&self, triangle: u32) -> &Form {
        &self.forms[self.places[(triangle - self.first) as usize] as usize]
    }
}

impl Chunk {
    /// Makes an empty chunk for that many stars, spokes and entries of a block.
    fn with_capacity([stars, spokes, entries]: [usize; 3]) -> Self {
        Self {
            places: Vec::with_capacity(stars),
            spokes: Vec::with_capacity(spokes),
            outer: Vec::with_capacity(spokes),
            inner: Vec::with_capacity(entries),
            inverse: Vec::with_capacity(entries),
        }
    }

    /// Assembles one star from the forms of its triangles, in double precision first.
    fn push(&mut self, space: &Space<'_>, forms: &Forms, node: u32, star: &Star, work: &mut Work) {
        let mesh = space.body().mesh();
        let count = star.spokes.len();
        let size = 3 + count;
        let first_spoke = self.spokes.len();
        self.places.push(Place {
            node,
            first_spoke: first_spoke as u32,
            spokes: count as u32,
            first_entry: self.inner.len() as u32,
            closed: star.is_closed(),
        });
        let Work { inner, outer, columns } = work;
        outer.clear();
        outer.resize(count, [0.0; 23]);
        inner.clear();
        inner.resize(size * (size + 1) / 2, 0.0);
        for &edge in &star.spokes {
            let ends = mesh.topology().edges()[edge as usize];
            let other = if ends[0] == node { ends[1] } else { ends[0] };
            let own = space.edge_unknown(edge) as u32;
            // The last spoke of an open star has no triangle after it: its coupling with the rim is zero.
            self.spokes.push(Spoke { own, ring: 3 * other, rim: own });
        }
        for (j, &t) in star.triangles.iter().enumerate() {
            let form = forms.of(t);
            let c = corner(mesh, t, node as usize);
            let after = if j + 1 == count { 0 } else { j + 1 };
            // Places in the triangle: ring vertices, spokes before and after, outer edge.
            let (near, far) = (3 * ((c + 1) % 3), 3 * ((c + 2) % 3));
            let (before, next, rim) = (9 + c, 9 + (c + 2) % 3, 9 + (c + 1) % 3);
            let edge = mesh.topology().triangle_edges()[t as usize][(c + 1) % 3];
            self.spokes[first_spoke + j].rim = space.edge_unknown(edge) as u32;
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
                    outer[j][3 * row + k] += at(3 * c + row, near + k);
                    outer[after][3 * row + k] += at(3 * c + row, far + k);
                }
                outer[j][9 + row] = at(3 * c + row, rim);
            }
            for k in 0..3 {
                outer[j][12 + k] += at(before, near + k);
                outer[j][18 + k] = at(before, far + k);
                outer[after][12 + k] += at(next, far + k);
                outer[after][15 + k] = at(next, near + k);
            }
            outer[j][22] = at(before, rim);
            outer[after][21] = at(next, rim);
        }
        self.outer.extend(outer.iter().map(|spoke| spoke.map(|x| x as f32)));
        self.inner.extend(inner.iter().map(|x| *x as f32));
        invert(inner, size, columns);
        self.inverse.extend(inner.iter().map(|x| *x as f32));
    }

    /// Computes the part of `A x` in a star's rows that comes from the unknowns outside the star.
    fn outside(&self, place: &Place, x: &Shared, rows: &mut Vec<f64>) {
        let first = place.first_spoke as usize;
        let count = place.spokes as usize;
        let spokes = &self.spokes[first..first + count];
        let outer = &self.outer[first..first + count];
        let ring = |j: usize| {
            let i = spokes[j].ring as usize;
            [x.get(i), x.get(i + 1), x.get(i + 2)]
        };
        let rim = |j: usize| x.get(spokes[j].rim as usize);
        rows.clear();
        rows.resize(3, 0.0);
        let last = count - 1;
        // An open star has nothing before its first spoke and nothing after its last: zero couplings.
        let (mut before, mut rim_before) =
            if place.closed { (ring(last), rim(last)) } else { ([0.0; 3], 0.0) };
        let first_ring = ring(0);
        let mut near = first_ring;
        let mut total = [0.0; 3];
        for j in 0..count {
            let after = if j < last { ring(j + 1) } else { first_ring };
            let rim_after = rim(j);
            let o = outer[j].map(f64::from);
            for row in 0..3 {
                let c = &o[3 * row..3 * row + 3];
                total[row] += c[0] * near[0] + c[1] * near[1] + c[2] * near[2] + o[9 + row] * rim_after;
            }
            let mut sum = o[21] * rim_before + o[22] * rim_after;
            for k in 0..3 {
                sum += o[12 + k] * near[k] + o[15 + k] * before[k] + o[18 + k] * after[k];
            }
            rows.push(sum);
            (before, near, rim_before) = (near, after, rim_after);
        }
        rows[..3].copy_from_slice(&total);
    }

    /// Unknown of a star's row.
    fn unknown(&self, place: &Place, row: usize) -> usize {
        match row {
            0..3 => 3 * place.node as usize + row,
            _ => self.spokes[place.first_spoke as usize + row - 3].own as usize,
        }
    }

    /// Minimises over each star: `x_star = A_ss⁻¹ (r − A_so x_outside)`.
    fn relax(&self, r: &Shared, unit: f64, x: &Shared) {
        let (mut rows, mut solution) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for place in &self.places {
            self.outside(place, x, &mut rows);
            for (row, value) in rows.iter_mut().enumerate() {
                *value = r.get(self.unknown(place, row)) / unit - *value;
            }
            solution.clear();
            solution.resize(rows.len(), 0.0);
            multiply_symmetric(&self.inverse[place.first_entry as usize..], &rows, &mut solution);
            for (row, value) in solution.iter().enumerate() {
                x.set(self.unknown(place, row), *value);
            }
        }
    }

    /// Computes the rows of `A x` of each star's vertex and of the spokes of which it is the first node.
    fn multiply(&self, x: &Shared, unit: f64, y: &Shared) {
        let (mut rows, mut own) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for place in &self.places {
            self.outside(place, x, &mut rows);
            own.clear();
            own.extend((0..rows.len()).map(|row| x.get(self.unknown(place, row))));
            multiply_symmetric(&self.inner[place.first_entry as usize..], &own, &mut rows);
            for (row, value) in rows.iter().enumerate() {
                let other = if row < 3 {
                    u32::MAX
                } else {
                    self.spokes[place.first_spoke as usize + row - 3].ring / 3
                };
                if place.node < other {
                    y.set(self.unknown(place, row), unit * value);
                }
            }
        }
    }
}

/// Adds `A x` to `y`, with the lower half of a symmetric matrix by rows.
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

/// Inverts a positive semi-definite matrix (lower half by rows) in place on the unknowns with a sound pivot;
/// rows and columns of the others become zero. `columns` is working space.
fn invert(a: &mut [f64], size: usize, columns: &mut Vec<f64>) {
    // L, its unsound rows those of the identity.
    for i in 0..size {
        let (above, rest) = a.split_at_mut(packed(i, 0));
        let row = &mut rest[..=i];
        let diagonal = row[i];
        for j in 0..i {
            let other = &above[packed(j, 0)..=packed(j, j)];
            let known: f64 = row[..j].iter().zip(other).map(|(x, y)| x * y).sum();
            row[j] = (row[j] - known) / other[j];
        }
        let pivot = diagonal - row[..i].iter().map(|x| x * x).sum::<f64>();
        if pivot > PIVOT_FLOOR * diagonal {
            row[i] = pivot.sqrt();
        } else {
            row.fill(0.0);
            row[i] = f64::INFINITY;
        }
    }
    // L⁻¹, its columns one after the other; an infinite pivot leaves zeros.
    columns.clear();
    columns.resize(size * size, 0.0);
    for (j, column) in columns.chunks_exact_mut(size).enumerate() {
        column[j] = 1.0 / a[packed(j, j)];
        for i in j + 1..size {
            let row = &a[packed(i, 0)..=packed(i, i)];
            let known: f64 = row[j..i].iter().zip(&column[j..i]).map(|(x, y)| x * y).sum();
            column[i] = -known / row[i];
        }
    }
    // L⁻ᵀ L⁻¹
    for i in 0..size {
        let row = &mut a[packed(i, 0)..=packed(i, i)];
        let own = &columns[i * size + i..(i + 1) * size];
        for (entry, column) in row.iter_mut().zip(columns.chunks_exact(size)) {
            *entry = own.iter().zip(&column[i..]).map(|(x, y)| x * y).sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_leaves_out_what_has_no_pivot() {
        // Rows 0, 2 and 3 of a positive matrix; row 1 is zero and row 4 the sum of 0 and 2.
        let small = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 2.0]];
        let from = |i: usize| -> Vec<(usize, f64)> {
            match i {
                0 => vec![(0, 1.0)],
                2 => vec![(1, 1.0)],
                3 => vec![(2, 1.0)],
                4 => vec![(0, 1.0), (1, 1.0)],
                _ => vec![],
            }
        };
        let mut a = [0.0; 15];
        let mut full = [[0.0; 5]; 5];
        for i in 0..5 {
            for j in 0..=i {
                for (p, f) in from(i) {
                    for (q, g) in from(j) {
                        full[i][j] += f * g * small[p][q];
                    }
                }
                full[j][i] = full[i][j];
                a[packed(i, j)] = full[i][j];
            }
        }
        invert(&mut a, 5, &mut Vec::new());
        for i in 0..5 {
            for j in 0..5 {
                let product: f64 = (0..5).map(|k| a[packed(i, k)] * full[k][j]).sum();
                let sound = |k: usize| [0, 2, 3].contains(&k);
                if sound(i) && sound(j) {
                    assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j} {product}");
                } else if !sound(i) {
                    assert_eq!(a[packed(i, j)], 0.0);
                }
            }
        }
    }
}

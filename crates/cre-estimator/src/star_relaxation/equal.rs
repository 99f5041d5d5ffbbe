//! Equal triangles and equal stars: structured and refined meshes have few different ones, whose coefficients are computed and stored once.

use super::space::Space;
use super::triangle_energy::{TriangleEnergy, forms};
use crate::star::{Sector, Star, StarList};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use std::ops::Range;

/// Two components of sides are equal if they agree to this power of two, relative to the largest one: more than what rounds differences of
/// coordinates, and less than single precision distinguishes in a triangle that is not [`FLAT`].
const DIGITS: i32 = 36;
/// Triangles with a smaller ratio of twice the area to the square of the largest component keep forms of their own.
const FLAT: f64 = 1e-3;
/// Slots of the table of hashes, a power of two.
const SLOTS: usize = 1024;
/// Fewer equal stars keep coefficients of their own: their batches would not be full.
const FEWEST: u32 = 64;

/// Finds an equal item among those before. It has one slot per remainder of the hash, so a look-up is cheap; an item whose slot another one has taken
/// is not found again, and less is shared then.
#[derive(Default)]
struct Table(Vec<Option<u32>>);

impl Table {
    fn clear(&mut self) {
        self.0.clear();
        self.0.resize(SLOTS, None);
    }

    /// Returns the equal item, or else `new`, which takes the slot.
    fn find(&mut self, words: impl Iterator<Item = u64>, new: u32, equal: impl Fn(u32) -> bool) -> u32 {
        let mix = |hash: u64, word: u64| (hash.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let hash = words.fold(0, mix) >> (u64::BITS - SLOTS.trailing_zeros());
        match &mut self.0[hash as usize] {
            Some(known) if equal(*known) => *known,
            slot => {
                *slot = Some(new);
                new
            }
        }
    }
}

/// What the form of an interior triangle depends on: two edge vectors in units of `2^exponent`, exponent and senses of its edges in one
/// number, material.
type Key = [i64; 6];

/// Computes the key of a triangle without a boundary node; `None` for others, and for one that is flat or not finite.
fn key(space: &Space<'_>, triangle: usize) -> Option<Key> {
    let mesh = space.body().mesh();
    let nodes = mesh.cells()[triangle];
    if nodes.iter().any(|&n| !space.is_interior(n)) {
        return None;
    }
    let [a, b, c] = mesh.corners(triangle);
    let sides = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
    let longest = sides.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let area = sides[0] * sides[3] - sides[1] * sides[2];
    if !(area > FLAT * longest * longest) {
        return None;
    }
    // The exponent by its bits; it is lowered until a power of two has it.
    let exponent = (longest.to_bits() >> 52) as i32 - 1023 - DIGITS;
    if !(-1000..=900).contains(&exponent) {
        return None;
    }
    let per_unit = f64::from_bits(((1023 - exponent) as u64) << 52);
    let edges = mesh.topology().cell_facets()[triangle];
    let senses =
        (0..3).fold(0, |bits, k| 2 * bits + i64::from(space.restriction(edges[k], triangle)[1] > 0.0));
    // Rounded by hand: `round` is a call on processors without an instruction for it.
    let [x, y, z, w] = sides.map(|side| (side * per_unit + 0.5f64.copysign(side)) as i64);
    let material = space.body().materials().index(triangle) as i64;
    Some([x, y, z, w, 8 * i64::from(exponent) + senses, material])
}

/// The forms of the triangles around some vertices, one for all equal ones.
#[derive(Default)]
pub(super) struct Forms {
    first: u32,
    /// Place in `forms` of each triangle from `first` on.
    places: Vec<u32>,
    /// The first triangle of each place, and its key.
    triangles: Vec<u32>,
    keys: Vec<Option<Key>>,
    forms: Vec<TriangleEnergy>,
    table: Table,
}

impl Forms {
    /// Computes the forms, divided by `unit`, in the place of those of other vertices.
    pub(super) fn renew(&mut self, space: &Space<'_>, unit: f64, nodes: Range<usize>) {
        let Self { first, places, triangles, keys, forms: all, table } = self;
        let topology = space.body().mesh().topology();
        let around = || nodes.clone().flat_map(|n| topology.cells_around(NodeId::new(n)).iter().copied());
        *first = around().min().unwrap_or(0);
        let end = around().max().map_or(*first, |last| last + 1);
        places.clear();
        places.resize((end - *first) as usize, u32::MAX);
        triangles.clear();
        keys.clear();
        table.clear();
        for t in around() {
            let place = &mut places[(t - *first) as usize];
            if *place != u32::MAX {
                continue;
            }
            let (new, key) = (triangles.len() as u32, key(space, t as usize));
            *place = match key {
                Some(key) => {
                    table.find(key.iter().map(|x| *x as u64), new, |known| keys[known as usize] == Some(key))
                }
                None => new,
            };
            if *place == new {
                triangles.push(t);
                keys.push(key);
            }
        }
        forms(space, triangles, unit, all);
    }

    /// The place of a triangle's form: equal triangles have the same.
    fn place(&self, triangle: u32) -> u32 {
        self.places[(triangle - self.first) as usize]
    }

    pub(super) fn of(&self, triangle: u32) -> &TriangleEnergy {
        &self.forms[self.place(triangle) as usize]
    }
}

/// The stars of some vertices, and which of them are equal.
#[derive(Default)]
pub(super) struct Walks {
    first: usize,
    stars: StarList,
    /// Of each star: the first one that equals it; `None` if too few do.
    equal: Vec<Option<u32>>,
    counts: Vec<u32>,
    /// What the coefficients of each star depend on: the forms of its triangles, and which of their corners the vertex is.
    words: Vec<u64>,
    ends: Vec<usize>,
    table: Table,
}

impl Walks {
    /// Collects the stars of other vertices.
    pub(super) fn renew(&mut self, mesh: &TriMesh, nodes: Range<usize>, forms: &Forms) {
        let Self { first, stars, equal, counts, words, ends, table } = self;
        *first = nodes.start;
        words.clear();
        ends.clear();
        stars.clear();
        equal.clear();
        counts.clear();
        counts.resize(nodes.len(), 0);
        table.clear();
        for (k, n) in nodes.clone().map(NodeId::new).enumerate() {
            stars.walk(mesh, n);
            let start = words.len();
            let word = |of: &Sector| 4 * u64::from(forms.place(of.triangle)) + u64::from(of.corner);
            words.extend(stars.get(k).triangles.iter().map(word));
            ends.push(words.len());
            let of = |k: usize| &words[if k > 0 { ends[k - 1] } else { 0 }..ends[k]];
            let own = &words[start..];
            let known = table.find(own.iter().copied(), k as u32, |known| of(known as usize) == own);
            counts[known as usize] += 1;
            equal.push(Some(known));
        }
        for known in equal {
            *known = known.filter(|known| counts[*known as usize] >= FEWEST);
        }
    }

    /// Returns the star of a vertex.
    pub(super) fn star(&self, node: usize) -> Star<'_> {
        self.stars.get(node - self.first)
    }

    /// Finds the first vertex whose star has the same coefficients, if enough others do.
    pub(super) fn equal(&self, node: usize) -> Option<u32> {
        self.equal[node - self.first].map(|known| known + self.first as u32)
    }
}

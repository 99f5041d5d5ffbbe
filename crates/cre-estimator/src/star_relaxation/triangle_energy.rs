//! The complementary energy of a triangle's twelve unknowns, several triangles at a time.

use super::airy::{Gathered, Map, PACKED, PLACES, UNKNOWNS, reference};
use super::space::Space;
use crate::cells::Geometry;
use crate::lanes::{Lanes, MOST_LANES};
use fem_core::body::tractions;
use fem_core::space::Plane;
use pulp::Simd;

/// `⟨τ_i, τ_j⟩` in the complementary energy, lower half by rows.
pub(super) type TriangleEnergy = [f64; PACKED];

/// Computes `⟨τ_i, τ_j⟩ = ∫ τ_i : E⁻¹ τ_j` of the twelve unknowns of each triangle, divided by `unit`.
pub(super) fn forms(space: &Space<'_>, triangles: &[u32], unit: f64, forms: &mut Vec<TriangleEnergy>) {
    forms.resize(triangles.len(), [0.0; PACKED]);
    pulp::Arch::new().dispatch(Computation { space, triangles, unit, forms });
    if !space.springs().is_empty() {
        triangles.iter().zip(forms).for_each(|(t, form)| add_springs(space, *t as usize, unit, form));
    }
}

/// Adds `∫ t_i·K⁻¹ t_j` of the tractions on the edges on springs of a triangle, divided by `unit`.
fn add_springs(space: &Space<'_>, triangle: usize, unit: f64, form: &mut TriangleEnergy) {
    let mesh = space.body().mesh();
    for (k, edge) in mesh.topology().cell_facets()[triangle].into_iter().enumerate() {
        let Some(springs) = space.springs_on(edge) else { continue };
        let next = 3 * ((k + 1) % 3);
        let places = [3 * k, 3 * k + 1, 3 * k + 2, next, next + 1, next + 2, 9 + k];
        let columns = space.spring_columns(edge).moments;
        let strained = columns.map(|of| springs.strained(&tractions::<Plane>(&of, mesh.facet_measure(edge))));
        for (i, own) in columns.iter().enumerate() {
            for (j, other) in strained.iter().enumerate().take(i + 1) {
                form[PLACES[places[i]][places[j]]] += (own[0].dot(&other[0]) + own[1].dot(&other[1])) / unit;
            }
        }
    }
}

struct Computation<'a> {
    space: &'a Space<'a>,
    triangles: &'a [u32],
    unit: f64,
    forms: &'a mut [TriangleEnergy],
}

impl pulp::WithSimd for Computation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { space, triangles, unit, forms } = self;
        let (mut geometry, mut gathered) = (Geometry::default(), Gathered::default());
        let mut rows = [[0.0; MOST_LANES]; PACKED];
        for (triangles, forms) in triangles.chunks(S::F64_LANES).zip(forms.chunks_mut(S::F64_LANES)) {
            for (lane, &t) in triangles.iter().enumerate() {
                geometry.set(lane, space.body(), t as usize);
                gathered.set(lane, space, t as usize);
            }
            let map = Map::new(simd, &geometry, &gathered, space.length());
            let lanes = form(simd, &map, 1.0 / unit);
            for (row, lanes) in rows.iter_mut().zip(lanes) {
                lanes.store(row);
            }
            for (lane, form) in forms.iter_mut().enumerate() {
                for (x, row) in form.iter_mut().zip(&rows) {
                    *x = row[lane];
                }
            }
        }
    }
}

/// Computes `Tᵀ G T` with the form `G` of the reference gradients, times `scale`.
#[inline(always)]
fn form<S: Simd>(simd: S, map: &Map<S>, scale: f64) -> [Lanes<S>; PACKED] {
    let zero = Lanes::splat(simd, 0.0);
    let mass = &reference().mass;
    let mut factors = map.factors(simd);
    for factor in &mut factors {
        *factor = scale * *factor;
    }
    let mut gradients = [[zero; 12]; 12];
    for i in 0..12 {
        for j in 0..=i {
            let place = PLACES[i][j];
            let mut g = mass[0][place] * factors[0];
            for p in 1..6 {
                g = g.plus_times(mass[p][place], factors[p]);
            }
            gradients[i][j] = g;
            gradients[j][i] = g;
        }
    }
    // Rows of (Tᵀ G)ᵀ = G T.
    let mut half = [[zero; UNKNOWNS]; UNKNOWNS];
    for (j, gradients) in gradients.iter().enumerate() {
        let row = map.unknowns(gradients);
        for (half, x) in half.iter_mut().zip(row) {
            half[j] = x;
        }
    }
    let mut form = [zero; PACKED];
    let mut next = 0;
    for (i, half) in half.iter().enumerate() {
        let row = map.unknowns(half);
        form[next..=next + i].copy_from_slice(&row[..=i]);
        next += i + 1;
    }
    form
}

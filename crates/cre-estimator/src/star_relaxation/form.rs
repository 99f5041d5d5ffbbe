//! The complementary energy of a triangle's twelve unknowns, several triangles at a time.

use super::airy::{Cell, PACKED, PLACES, UNKNOWNS, reference};
use super::lanes::{LANES, Lanes, ZERO};
use super::space::Space;

/// `⟨τ_i, τ_j⟩` in the complementary energy, lower half by rows.
pub(super) type Form = [f64; PACKED];

/// Computes `⟨τ_i, τ_j⟩ = ∫ τ_i : E⁻¹ τ_j` of the twelve unknowns of each triangle, divided by `unit`.
pub(super) fn forms(space: &Space<'_>, triangles: &[u32], unit: f64, forms: &mut Vec<Form>) {
    forms.resize(triangles.len(), [0.0; PACKED]);
    // The same operations on every processor, with its widest vectors.
    pulp::Arch::new().dispatch(Computation { space, triangles, unit, forms });
}

struct Computation<'a> {
    space: &'a Space<'a>,
    triangles: &'a [u32],
    unit: f64,
    forms: &'a mut [Form],
}

impl pulp::NullaryFnOnce for Computation<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (triangles, forms) in self.triangles.chunks(LANES).zip(self.forms.chunks_mut(LANES)) {
            let mut cells = Cells::default();
            for (lane, &t) in triangles.iter().enumerate() {
                cells.set(lane, self.space, &Cell::new(self.space, t as usize), 1.0 / self.unit);
            }
            let mut lanes = [ZERO; PACKED];
            cells.forms(&mut lanes);
            for (lane, form) in forms.iter_mut().enumerate() {
                for (x, lanes) in form.iter_mut().zip(&lanes) {
                    *x = lanes[lane];
                }
            }
        }
    }
}

/// Input of the forms of some triangles: the factors of the reference matrices, and the map from the unknowns to the
/// reference gradients (see [`Cell`]).
#[derive(Default)]
struct Cells {
    factors: [Lanes; 6],
    along: [[Lanes; 2]; 3],
    across: [[Lanes; 2]; 3],
    values: [Lanes; 3],
    slopes: [[[Lanes; 2]; 2]; 3],
}

impl Cells {
    #[inline(always)]
    fn set(&mut self, lane: usize, space: &Space<'_>, cell: &Cell, scale: f64) {
        for (factor, x) in self.factors.iter_mut().zip(cell.factors(space)) {
            factor[lane] = scale * x;
        }
        for k in 0..3 {
            self.values[k][lane] = cell.values[k];
            for c in 0..2 {
                self.along[k][c][lane] = cell.along[k][c];
                self.across[k][c][lane] = cell.across[k][c];
                for m in 0..2 {
                    self.slopes[k][m][c][lane] = cell.slopes[k][m][c];
                }
            }
        }
    }

    /// Computes `Tᵀ G T` with the form `G` of the reference gradients.
    #[inline(always)]
    fn forms(&self, forms: &mut [Lanes; PACKED]) {
        let mass = &reference().mass;
        let f = &self.factors;
        let mut gradients = [[ZERO; 12]; 12];
        for i in 0..12 {
            for j in 0..=i {
                let m: [f64; 6] = std::array::from_fn(|p| mass[p][PLACES[i][j]]);
                let mut g = ZERO;
                for l in 0..LANES {
                    g[l] = m[0] * f[0][l]
                        + m[1] * f[1][l]
                        + m[2] * f[2][l]
                        + (m[3] * f[3][l] + m[4] * f[4][l] + m[5] * f[5][l]);
                }
                gradients[i][j] = g;
                gradients[j][i] = g;
            }
        }
        // Rows of (Tᵀ G)ᵀ = G T.
        let mut half = [[ZERO; UNKNOWNS]; UNKNOWNS];
        let mut row = [ZERO; UNKNOWNS];
        for (j, gradients) in gradients.iter().enumerate() {
            self.unknowns(gradients, &mut row);
            for (half, x) in half.iter_mut().zip(&row) {
                half[j] = *x;
            }
        }
        let mut next = 0;
        for (i, half) in half.iter().enumerate() {
            self.unknowns(half, &mut row);
            forms[next..=next + i].copy_from_slice(&row[..=i]);
            next += i + 1;
        }
    }

    /// Maps values on the reference gradients to the twelve unknowns, `Tᵀ g`.
    #[inline(always)]
    fn unknowns(&self, gradients: &[Lanes; 12], unknowns: &mut [Lanes; UNKNOWNS]) {
        let mut along = [ZERO; 3];
        for k in 0..3 {
            pair(&gradients[6 + 2 * k..], &self.along[k], &mut along[k]);
            pair(&gradients[6 + 2 * k..], &self.across[k], &mut unknowns[9 + k]);
            pair(&gradients[2 * k..], &self.slopes[k][0], &mut unknowns[3 * k + 1]);
            pair(&gradients[2 * k..], &self.slopes[k][1], &mut unknowns[3 * k + 2]);
        }
        for k in 0..3 {
            // Corner k ends edge k + 2 and starts edge k.
            let (end, start, value) = (&along[(k + 2) % 3], &along[k], &self.values[k]);
            for l in 0..LANES {
                unknowns[3 * k][l] = value[l] * (end[l] - start[l]);
            }
        }
    }
}

/// Computes `x · v` of two rows.
#[inline(always)]
fn pair(x: &[Lanes], v: &[Lanes; 2], product: &mut Lanes) {
    for l in 0..LANES {
        product[l] = x[0][l] * v[0][l] + x[1][l] * v[1][l];
    }
}

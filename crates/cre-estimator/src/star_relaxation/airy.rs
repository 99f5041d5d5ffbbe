//! The Hsieh-Clough-Tocher triangle: Airy functions whose stresses are the self-equilibrated Johnson-Mercier
//! stresses.
//!
//! `τ = R ∇²φ Rᵀ` with `R (x, y) = (y, −x)` has no divergence, and the traction `d(R∇φ)/ds` on an edge. The
//! piecewise cubic, continuously differentiable `φ` of a triangle cut at its barycentre (Clough and Tocher
//! 1965) have twelve unknowns: value and gradient at the corners, the mean normal derivative on the edges.
//! Without the three affine functions they give the nine-dimensional space of Johnson and Mercier (1978). So `τ`
//! follows from the edge moments of `R∇φ` by the same matrix as any other stress.

use super::space::Space;
use crate::cells::{Cells, Compliance, Geometry, dyads};
use crate::inverse::packed;
use crate::johnson_mercier;
use crate::lanes::{LaneRow, Lanes, MOST_LANES, Pair, Tensor, contract, cross, dot, less, load_pair, turned};
use pulp::Simd;
use std::sync::OnceLock;

/// Unknowns of one triangle: `[φ, x₁, x₂]` at its corners, then one per edge.
pub(super) const UNKNOWNS: usize = 12;
/// Entries of the lower half of a 12×12 matrix.
pub(super) const PACKED: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;

/// [`packed`] of a triangle's unknowns.
pub(super) const PLACES: [[usize; UNKNOWNS]; UNKNOWNS] = {
    let mut places = [[0; UNKNOWNS]; UNKNOWNS];
    let mut i = 0;
    while i < UNKNOWNS {
        let mut j = 0;
        while j < UNKNOWNS {
            places[i][j] = packed(i, j);
            j += 1;
        }
        i += 1;
    }
    places
};

/// The reference triangle's matrices. Columns: `∇φ` at the three corners, then its mean on the three edges.
pub(super) struct Reference {
    /// `∫ s_p s_q` of the components xx, yy, xy, pairs of different ones include the transposed term.
    pub(super) mass: [[f64; PACKED]; 6],
}

/// Pairs of components, in the order of [`Reference::mass`].
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

pub(super) fn reference() -> &'static Reference {
    static REFERENCE: OnceLock<Reference> = OnceLock::new();
    REFERENCE.get_or_init(|| {
        let stress = reference_stress();
        // A part has a sixth as its area: ∫ s t = A/12 (Σ s_m t_m + Σs Σt).
        let mass = PAIRS.map(|(p, q)| {
            let mut form = [0.0; PACKED];
            for i in 0..UNKNOWNS {
                for j in 0..=i {
                    let mut sum = 0.0;
                    for k in 0..3 {
                        let at = |m: usize, c: usize, u: usize| stress[9 * k + 3 * m + c][u];
                        let total = |c, u| (0..3).map(|m| at(m, c, u)).sum::<f64>();
                        let product = |c, d| {
                            total(c, i) * total(d, j) + (0..3).map(|m| at(m, c, i) * at(m, d, j)).sum::<f64>()
                        };
                        sum += if p == q { product(p, p) } else { product(p, q) + product(q, p) };
                    }
                    form[packed(i, j)] = sum / 72.0;
                }
            }
            form
        });
        Reference { mass }
    })
}

/// `R ∇²φ Rᵀ`; rows: part, corner, component as in [`johnson_mercier`].
fn reference_stress() -> [[f64; 12]; 27] {
    let recovery = johnson_mercier::recovery();
    std::array::from_fn(|row| {
        let mut stress = [0.0; 12];
        for (factor, weights) in recovery[row].iter().zip(&LOADS) {
            for (place, weight) in weights {
                stress[*place] += factor * weight;
            }
        }
        stress
    })
}

/// The load (traction times length) `4 k + 2 end + c` on edge `k` from corner `k`, by the gradients that it depends on:
/// `|Γ| F_a = 4 b_a − 2 b_b` with `b_a = R(m − g_a)` and `b_b = R(g_b − m)`.
const LOADS: [[(usize, f64); 3]; 12] = {
    let mut loads = [[(0, 0.0); 3]; 12];
    let mut k = 0;
    while k < 3 {
        let from = [2 * k, 2 * ((k + 1) % 3), 6 + 2 * k];
        let weights = [[-4.0, -2.0, 6.0], [2.0, 4.0, -6.0]];
        let mut i = 0;
        while i < 6 {
            let (end, place) = (i / 3, i % 3);
            loads[4 * k + 2 * end][place] = (from[place] + 1, weights[end][place]);
            loads[4 * k + 2 * end + 1][place] = (from[place], -weights[end][place]);
            i += 1;
        }
        k += 1;
    }
    loads
};

/// How the space restricts the unknowns of some triangles.
#[derive(Default)]
pub(super) struct Gathered {
    /// Per edge: [`Space::restriction`].
    restrictions: [[LaneRow; 2]; 3],
    /// Per corner: the basis of its node.
    values: [LaneRow; 3],
    slopes: [[[LaneRow; 2]; 2]; 3],
    /// Whether all corners of the triangle in the lane are in the interior: then their basis is that of every such triangle.
    are_interior: [bool; MOST_LANES],
}

impl Gathered {
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, space: &Space<'_>, triangle: usize) {
        let mesh = space.body().mesh();
        let (nodes, edges) = (mesh.cells()[triangle], mesh.topology().cell_facets()[triangle]);
        for (rows, edge) in self.restrictions.iter_mut().zip(edges) {
            let restriction = space.restriction(edge, triangle);
            (rows[0][lane], rows[1][lane]) = (restriction[0], restriction[1]);
        }
        let before = self.are_interior[lane];
        self.are_interior[lane] = nodes.iter().all(|&n| space.is_interior(n));
        if before && self.are_interior[lane] {
            return;
        }
        for k in 0..3 {
            let basis = space.node(nodes[k].index());
            self.values[k][lane] = basis.value;
            for (rows, slope) in self.slopes[k].iter_mut().zip(basis.slopes) {
                (rows[0][lane], rows[1][lane]) = (slope[0], slope[1]);
            }
        }
    }
}

/// Some triangles side by side: the map from their unknowns to the reference gradients, and their geometry.
///
/// The reference gradients are the products of `∇φ` with the two edge vectors at corner 0: two rows per corner, then
/// two per edge.
pub(super) struct Map<S: Simd> {
    /// Per edge: the two rows of its mean gradient under a unit of `φ_b − φ_a`.
    along: [Pair<S>; 3],
    /// Per edge: the two rows of its mean gradient under its own unknown.
    across: [Pair<S>; 3],
    /// Per corner: the factor of `φ`.
    values: [Lanes<S>; 3],
    /// Per corner and slope: the two rows of its gradient.
    slopes: [[Pair<S>; 2]; 3],
    /// The two edge vectors at corner 0.
    edges: [Pair<S>; 2],
    compliance: Compliance<S>,
}

impl<S: Simd> Map<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, geometry: &Geometry, gathered: &Gathered, length: f64) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let [a, b] = geometry.edges(simd);
        let rows = |v: Pair<S>| -> Pair<S> { [dot(a, v), dot(b, v)] };
        let sides = [a, less(b, a), [zero - b[0], zero - b[1]]];
        let inverse_length = 1.0 / length;
        let (mut along, mut across) = ([[zero; 2]; 3], [[zero; 2]; 3]);
        let (mut values, mut slopes) = ([zero; 3], [[[zero; 2]; 2]; 3]);
        for k in 0..3 {
            let t = sides[k];
            let turned = turned(simd, t);
            let [tilt, sense] = load_pair(simd, &gathered.restrictions[k]);
            let scale = Lanes::splat(simd, 1.0).over(dot(t, t));
            along[k] = rows([scale * t[0] + tilt * turned[0], scale * t[1] + tilt * turned[1]]);
            let normal = sense * Lanes::splat(simd, inverse_length);
            across[k] = rows([normal * turned[0], normal * turned[1]]);
            values[k] = Lanes::load(simd, &gathered.values[k]);
            for m in 0..2 {
                slopes[k][m] = rows(load_pair(simd, &gathered.slopes[k][m]));
            }
        }
        let compliance = geometry.compliance(simd);
        Self { along, across, values, slopes, edges: [a, b], compliance }
    }

    /// Computes the factors of [`Reference::mass`] in `∫ τ_i : E⁻¹ τ_j`; `τ = F s Fᵀ/J²` with the reference stress `s`.
    #[inline(always)]
    pub(super) fn factors(&self, simd: S) -> [Lanes<S>; 6] {
        let [a, b] = self.edges;
        let dyads = dyads(self.edges);
        let jacobian = cross(a, b);
        let scale = Lanes::splat(simd, 1.0).over(jacobian * jacobian * jacobian);
        let mut factors = [Lanes::splat(simd, 0.0); 6];
        for (factor, (p, q)) in factors.iter_mut().zip(PAIRS) {
            *factor = scale * contract(dyads[p], self.compliance.strain(dyads[q]));
        }
        factors
    }

    /// Maps values on the reference gradients to the twelve unknowns, `Tᵀ g`.
    #[inline(always)]
    pub(super) fn unknowns(&self, gradients: &[Lanes<S>; 12]) -> [Lanes<S>; UNKNOWNS] {
        let pair = |k: usize, v: Pair<S>| (gradients[2 * k] * v[0]).plus(gradients[2 * k + 1], v[1]);
        let along = [pair(3, self.along[0]), pair(4, self.along[1]), pair(5, self.along[2])];
        let mut unknowns = *gradients;
        for k in 0..3 {
            // Corner k ends edge k + 2 and starts edge k.
            unknowns[3 * k] = self.values[k] * (along[(k + 2) % 3] - along[k]);
            unknowns[3 * k + 1] = pair(k, self.slopes[k][0]);
            unknowns[3 * k + 2] = pair(k, self.slopes[k][1]);
            unknowns[9 + k] = pair(3 + k, self.across[k]);
        }
        unknowns
    }

    /// Computes `⟨τ − σ̂, τ_i⟩` of the twelve unknowns, and `‖τ − σ̂‖²`.
    ///
    /// * `constant`: `σ̂`, Pa.
    #[inline(always)]
    pub(super) fn gradient(
        &self,
        simd: S,
        cells: &Cells<S>,
        constant: Tensor<S>,
    ) -> ([Lanes<S>; UNKNOWNS], Lanes<S>) {
        let (energy, loads) = cells.gradient(&cells.less(constant));
        let mut gradients = [Lanes::splat(simd, 0.0); 12];
        for (load, weights) in LOADS.iter().enumerate() {
            for (place, weight) in weights {
                gradients[*place] = gradients[*place].plus_times(*weight, loads[load]);
            }
        }
        let inverse = Lanes::splat(simd, 1.0).over(cells.jacobian);
        for gradient in &mut gradients {
            *gradient = inverse * *gradient;
        }
        (self.unknowns(&gradients), energy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::johnson_mercier::REFERENCE;
    use fem_core::geometry::Vector;

    /// Reference gradients of a polynomial φ with the given gradient, at most quadratic along the edges.
    fn gradients(of: impl Fn(Vector) -> Vector) -> [f64; 12] {
        let mut u = [0.0; 12];
        for k in 0..3 {
            let (a, b) = (REFERENCE[k], REFERENCE[(k + 1) % 3]);
            let middle = 0.5 * (a + b);
            for c in 0..2 {
                u[2 * k + c] = of(a)[c];
                u[6 + 2 * k + c] = (of(a)[c] + 4.0 * of(middle)[c] + of(b)[c]) / 6.0;
            }
        }
        u
    }

    #[test]
    fn cubic_airy_functions_have_their_hessian_as_stress() {
        // φ = 2x³ − 3x²y + 5xy² + 7y³ + x² − 4xy + 3y² + 8x − y
        let gradient = |x: Vector| {
            let (x, y) = (x[0], x[1]);
            Vector::new(
                6.0 * x * x - 6.0 * x * y + 5.0 * y * y + 2.0 * x - 4.0 * y + 8.0,
                -3.0 * x * x + 10.0 * x * y + 21.0 * y * y - 4.0 * x + 6.0 * y - 1.0,
            )
        };
        // xx, yy, xy of R ∇²φ Rᵀ.
        let stress = |x: Vector| {
            let (x, y) = (x[0], x[1]);
            [10.0 * x + 42.0 * y + 6.0, 12.0 * x - 6.0 * y + 2.0, 6.0 * x - 10.0 * y + 4.0]
        };
        let u = gradients(gradient);
        let centre = Vector::repeat(1.0 / 3.0);
        let stress_of = reference_stress();
        for k in 0..3 {
            for (m, x) in [REFERENCE[k], REFERENCE[(k + 1) % 3], centre].into_iter().enumerate() {
                for (c, exact) in stress(x).into_iter().enumerate() {
                    let found: f64 = stress_of[9 * k + 3 * m + c].iter().zip(&u).map(|(s, u)| s * u).sum();
                    assert!((found - exact).abs() < 1e-12, "{found} {exact}");
                }
            }
        }
    }
}

//! The Hsieh-Clough-Tocher triangle: Airy functions whose stresses are the self-equilibrated Johnson-Mercier
//! stresses.
//!
//! `τ = R ∇²φ Rᵀ` with `R (x, y) = (y, −x)` has no divergence, and the traction `d(R∇φ)/ds` on an edge. The
//! piecewise cubic, continuously differentiable `φ` of a triangle cut at its barycentre (Clough and Tocher
//! 1965) have twelve unknowns: value and gradient at the corners, the mean normal derivative on the edges.
//! Without the three affine functions they give the nine-dimensional space of Johnson and Mercier (1978). So `τ`
//! follows from the edge moments of `R∇φ` by the same matrix as any other stress.

use super::space::Space;
use crate::equilibrated::EquilibratedStress;
use crate::johnson_mercier;
use fem_core::geometry::{Vector, cross};
use fem_core::tensor::SymTensor2;
use std::sync::OnceLock;

/// Unknowns of one triangle: `[φ, x₁, x₂]` at its corners, then one per edge.
pub(super) const UNKNOWNS: usize = 12;
/// Entries of the lower half of a 12×12 matrix.
pub(super) const PACKED: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;

/// Place of entry (i, j) of a symmetric matrix in its lower half by rows.
pub(super) const fn packed(i: usize, j: usize) -> usize {
    if i < j { j * (j + 1) / 2 + i } else { i * (i + 1) / 2 + j }
}

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
    /// `R ∇²φ Rᵀ`; rows: part, corner, component as in [`johnson_mercier`].
    stress: [[f64; 12]; 27],
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
        Reference { stress, mass }
    })
}

fn reference_stress() -> [[f64; 12]; 27] {
    // Loads (traction times length) on edge k from corner k: |Γ| F_a = 4 b_a − 2 b_b with b_a = R(m − g_a) and
    // b_b = R(g_b − m).
    let mut loads = [[0.0; 12]; 12];
    for k in 0..3 {
        let (a, b, m) = (2 * k, 2 * ((k + 1) % 3), 6 + 2 * k);
        for (end, weights) in [(0, [-4.0, -2.0, 6.0]), (1, [2.0, 4.0, -6.0])] {
            for (from, weight) in [a, b, m].into_iter().zip(weights) {
                loads[4 * k + 2 * end][from + 1] += weight;
                loads[4 * k + 2 * end + 1][from] -= weight;
            }
        }
    }
    let recovery = johnson_mercier::recovery();
    std::array::from_fn(|row| {
        std::array::from_fn(|u| (0..12).map(|l| recovery[row][l] * loads[l][u]).sum::<f64>())
    })
}

/// One triangle: the map from its unknowns to the reference gradients, and its geometry.
///
/// The reference gradients are the products of `∇φ` with the two edge vectors at corner 0: two rows per corner, then
/// two per edge.
pub(super) struct Cell {
    /// Per edge: the two rows of its mean gradient under a unit of `φ_b − φ_a`.
    pub(super) along: [Vector; 3],
    /// Per edge: the two rows of its mean gradient under its own unknown.
    pub(super) across: [Vector; 3],
    /// Per corner: the factor of `φ`.
    pub(super) values: [f64; 3],
    /// Per corner and slope: the two rows of its gradient.
    pub(super) slopes: [[Vector; 2]; 3],
    /// `a⊗a`, `b⊗b`, `a⊗b + b⊗a` of the two edge vectors at corner 0.
    dyads: [SymTensor2; 3],
    /// `a × b`, twice the area.
    jacobian: f64,
    triangle: usize,
}

impl Cell {
    pub(super) fn new(space: &Space<'_>, triangle: usize) -> Self {
        let mesh = space.body().mesh();
        let corners = mesh.corners(triangle);
        let nodes = mesh.triangles()[triangle].map(|n| space.node(n as usize));
        let edges = mesh.topology().triangle_edges()[triangle];
        let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
        let rows = |v: Vector| Vector::new(a.dot(&v), b.dot(&v));
        let bases: [_; 3] =
            std::array::from_fn(|k| space.edge(edges[k], triangle, corners[k], corners[(k + 1) % 3]));
        let dyads = [
            SymTensor2::new(a[0] * a[0], a[1] * a[1], a[0] * a[1]),
            SymTensor2::new(b[0] * b[0], b[1] * b[1], b[0] * b[1]),
            SymTensor2::new(2.0 * a[0] * b[0], 2.0 * a[1] * b[1], a[0] * b[1] + a[1] * b[0]),
        ];
        Self {
            along: bases.map(|basis| rows(basis.along)),
            across: bases.map(|basis| rows(basis.across)),
            values: nodes.map(|node| node.value),
            slopes: nodes.map(|node| node.slopes.map(rows)),
            dyads,
            jacobian: cross(a, b),
            triangle,
        }
    }

    /// Computes the factors of [`Reference::mass`] in `∫ τ_i : E⁻¹ τ_j`; `τ = F s Fᵀ/J²` with the reference stress `s`.
    pub(super) fn factors(&self, space: &Space<'_>) -> [f64; 6] {
        let material = space.body().material(self.triangle);
        let strains = self.dyads.map(|dyad| material.strain(dyad));
        let scale = 1.0 / (self.jacobian * self.jacobian * self.jacobian);
        PAIRS.map(|(p, q)| scale * self.dyads[p].contract(strains[q]))
    }

    /// Maps values on the reference gradients to the twelve unknowns, `Tᵀ g`.
    fn unknowns(&self, gradients: &[f64; 12]) -> [f64; UNKNOWNS] {
        let pair = |k: usize, v: Vector| gradients[2 * k] * v[0] + gradients[2 * k + 1] * v[1];
        let along = [0, 1, 2].map(|k| pair(3 + k, self.along[k]));
        let mut unknowns = [0.0; UNKNOWNS];
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
    #[inline(always)]
    pub(super) fn gradient(&self, space: &Space<'_>, stress: &EquilibratedStress) -> ([f64; UNKNOWNS], f64) {
        let body = space.body();
        let material = body.material(self.triangle);
        let tau = stress.cell(body, self.triangle);
        let constant = stress.finite_element[self.triangle];
        let reference = reference();
        let (mut energy, mut gradients) = (0.0, [0.0; 12]);
        for (k, part) in tau.iter().enumerate() {
            let d = part.map(|s| s.minus(constant));
            let total = d[0].plus(d[1]).plus(d[2]);
            energy += total.contract(material.strain(total));
            for (m, d) in d.into_iter().enumerate() {
                let strain = material.strain(d.plus(total));
                energy += d.contract(material.strain(d));
                for (c, dyad) in self.dyads.iter().enumerate() {
                    let weight = strain.contract(*dyad);
                    for (g, s) in gradients.iter_mut().zip(&reference.stress[9 * k + 3 * m + c]) {
                        *g += weight * s;
                    }
                }
            }
        }
        // ∫ over a part of a third of the area: see [`johnson_mercier::distance_squared`].
        let scale = 0.5 * self.jacobian / 36.0;
        let gradients = gradients.map(|g| scale / (self.jacobian * self.jacobian) * g);
        (self.unknowns(&gradients), scale * energy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::johnson_mercier::REFERENCE;

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
        for k in 0..3 {
            for (m, x) in [REFERENCE[k], REFERENCE[(k + 1) % 3], centre].into_iter().enumerate() {
                for (c, exact) in stress(x).into_iter().enumerate() {
                    let found: f64 =
                        reference().stress[9 * k + 3 * m + c].iter().zip(&u).map(|(s, u)| s * u).sum();
                    assert!((found - exact).abs() < 1e-12, "{found} {exact}");
                }
            }
        }
    }
}

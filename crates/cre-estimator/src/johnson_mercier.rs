//! The Johnson-Mercier stress: on a triangle split at its barycentre, exactly one symmetric, piecewise
//! linear, normal-continuous, divergence-free stress has given linear edge tractions in equilibrium
//! (Johnson and Mercier 1978).

use fem_core::dense::left_inverse;
use fem_core::geometry::Vector;
use fem_core::material::LinearElastic;
use fem_core::tensor::SymTensor2;
use nalgebra::DMatrix;
use std::sync::OnceLock;

/// A piecewise linear stress of one triangle: part `k` lies at edge `k` and has the corners `k`, `k+1` and
/// the barycentre, in this order.
pub(crate) type CellStress = [[SymTensor2; 3]; 3];

/// Edge tractions of one triangle times the edge's length, N/m: `loads[k][m]` at corner `k + m` of edge `k`,
/// acting on the triangle.
pub(crate) type CellLoads = [[Vector; 2]; 3];

/// Rows of the recovery matrix: part, corner, component; columns: edge, end, component.
pub(crate) type Recovery = [[f64; 12]; 27];

/// The reference triangle.
pub(crate) const REFERENCE: [Vector; 3] =
    [Vector::new(0.0, 0.0), Vector::new(1.0, 0.0), Vector::new(0.0, 1.0)];
const CENTRE: Vector = Vector::new(1.0 / 3.0, 1.0 / 3.0);

/// Computes the stress of a triangle with the given corners, edge loads and constant body force (N/m³).
///
/// The stress (20) is linear on the three parts of the triangle, symmetric, and in equilibrium with both. It maps from the reference triangle by the double Piola transform
/// `τ = (1/J) F τ̂ Fᵀ`, which preserves symmetry, divergence and tractions. A body force is carried by
/// `τ_P = −diag(b_x (x−x_c), b_y (y−y_c))`.
#[inline(always)]
pub fn cell_stress(corners: [Vector; 3], loads: &CellLoads, body_force: Vector) -> CellStress {
    // Relative to the first corner: far from the origin the differences to the centre would be round-off.
    let corners = corners.map(|c| c - corners[0]);
    let heavy = body_force != Vector::zeros();
    let reduced = if heavy { without_body_force(corners, loads, body_force) } else { *loads };
    let mut stress = divergence_free(corners, &reduced);
    if heavy {
        for (k, part) in stress.iter_mut().enumerate() {
            let points = [corners[k], corners[(k + 1) % 3], centre(corners)];
            for (s, x) in part.iter_mut().zip(points) {
                *s = s.plus(particular(corners, body_force, x));
            }
        }
    }
    stress
}

/// Computes `τ_P` at a point.
fn particular(corners: [Vector; 3], body_force: Vector, x: Vector) -> SymTensor2 {
    let d = x - centre(corners);
    SymTensor2::new(-body_force[0] * d[0], -body_force[1] * d[1], 0.0)
}

fn centre(corners: [Vector; 3]) -> Vector {
    (corners[0] + corners[1] + corners[2]) / 3.0
}

/// Computes the loads less the tractions of the stress `τ_P` that carries the body force.
pub(crate) fn without_body_force(corners: [Vector; 3], loads: &CellLoads, body_force: Vector) -> CellLoads {
    let corners = corners.map(|c| c - corners[0]);
    let mut reduced = *loads;
    for k in 0..3 {
        let t = corners[(k + 1) % 3] - corners[k];
        // Normal times length.
        let normal = Vector::new(t[1], -t[0]);
        for m in 0..2 {
            reduced[k][m] -= particular(corners, body_force, corners[(k + m) % 3]).apply(normal);
        }
    }
    reduced
}

#[inline(always)]
fn divergence_free(corners: [Vector; 3], loads: &CellLoads) -> CellStress {
    let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
    let inverse = 1.0 / (a[0] * b[1] - a[1] * b[0]);
    let mut reference = [0.0; 12];
    for k in 0..3 {
        for m in 0..2 {
            let g = loads[k][m];
            reference[4 * k + 2 * m] = inverse * (b[1] * g[0] - b[0] * g[1]);
            reference[4 * k + 2 * m + 1] = inverse * (a[0] * g[1] - a[1] * g[0]);
        }
    }
    let mut components = [[0.0; 9]; 3];
    for (column, g) in by_column().iter().zip(reference) {
        for (component, r) in components.as_flattened_mut().iter_mut().zip(column.as_flattened()) {
            *component += r * g;
        }
    }
    // Plain loops: a closure that is not inlined would be compiled without the vectors of the caller.
    let mut stress = CellStress::default();
    for k in 0..3 {
        for m in 0..3 {
            let [xx, yy, xy] = components.map(|of| of[3 * k + m]);
            // F τ̂ Fᵀ with F = [a b].
            let fa = [a[0] * xx + b[0] * xy, a[1] * xx + b[1] * xy];
            let fb = [a[0] * xy + b[0] * yy, a[1] * xy + b[1] * yy];
            stress[k][m] = SymTensor2 {
                xx: inverse * (fa[0] * a[0] + fb[0] * b[0]),
                yy: inverse * (fa[1] * a[1] + fb[1] * b[1]),
                xy: inverse * (fa[0] * a[1] + fb[0] * b[1]),
            };
        }
    }
    stress
}

/// Computes `∫ (τ − σ) : E⁻¹ (τ − σ)` over a triangle of the given area for a constant σ, J/m.
#[inline(always)]
pub(crate) fn distance_squared(
    stress: &CellStress,
    constant: SymTensor2,
    area: f64,
    material: &LinearElastic,
) -> f64 {
    // For linear d on a part of area A/3: ∫ d:C:d = A/36 (Σd : C : Σd + Σ d_m : C : d_m).
    // The nine corners, then the sums of the three parts, side by side.
    let mut d = [[0.0; 12]; 3];
    for (k, part) in stress.iter().enumerate() {
        for (m, s) in part.iter().enumerate() {
            for (c, x) in [s.xx - constant.xx, s.yy - constant.yy, s.xy - constant.xy].into_iter().enumerate()
            {
                d[c][3 * k + m] = x;
                d[c][9 + k] += x;
            }
        }
    }
    let mut energies = [0.0; 12];
    for (i, energy) in energies.iter_mut().enumerate() {
        let d = SymTensor2 { xx: d[0][i], yy: d[1][i], xy: d[2][i] };
        *energy = d.contract(material.strain(d));
    }
    area / 36.0 * energies.iter().sum::<f64>()
}

/// The 27×12 matrix of the reference triangle, computed once: the left inverse of the conditions on the
/// 27 nodal stresses (outer tractions, continuity across the three inner edges, no divergence).
pub(crate) fn recovery() -> &'static Recovery {
    static MATRIX: OnceLock<Recovery> = OnceLock::new();
    MATRIX.get_or_init(|| {
        let conditions = conditions();
        let mut matrix = [[0.0; 12]; 27];
        // Full rank: a test looks at the singular values.
        match left_inverse(conditions) {
            Some(inverse) => {
                for (row, out) in matrix.iter_mut().enumerate() {
                    for (column, value) in out.iter_mut().enumerate() {
                        *value = inverse[(row, column)];
                    }
                }
            }
            // The conditions are constants.
            None => unreachable!("the reference triangle has no stress recovery"),
        }
        matrix
    })
}

/// The transpose of [`recovery`], to be added up column by column. All xx of the nine corners come first, then yy, then xy.
fn by_column() -> &'static [[[f64; 9]; 3]; 12] {
    static MATRIX: OnceLock<[[[f64; 9]; 3]; 12]> = OnceLock::new();
    MATRIX.get_or_init(|| {
        let rows = recovery();
        std::array::from_fn(|column| {
            std::array::from_fn(|c| std::array::from_fn(|corner| rows[3 * corner + c][column]))
        })
    })
}

fn conditions() -> DMatrix<f64> {
    let mut a = DMatrix::zeros(30, 27);
    let mut row = 0;
    // Adds the two rows of `factor · τ n` for corner m of part k.
    let traction = |a: &mut DMatrix<f64>, row: usize, k: usize, m: usize, n: Vector| {
        let column = 9 * k + 3 * m;
        a[(row, column)] += n[0];
        a[(row, column + 2)] += n[1];
        a[(row + 1, column + 2)] += n[0];
        a[(row + 1, column + 1)] += n[1];
    };
    let turned = |from: Vector, to: Vector| {
        let t = to - from;
        Vector::new(t[1], -t[0])
    };
    for k in 0..3 {
        let n = turned(REFERENCE[k], REFERENCE[(k + 1) % 3]);
        for m in 0..2 {
            traction(&mut a, row, k, m, n);
            row += 2;
        }
    }
    for v in 0..3 {
        // The inner edge at corner v lies between part v (whose corner 0 it is) and part v+2 (corner 1).
        let n = turned(REFERENCE[v], CENTRE);
        for (m, other) in [(0, 1), (2, 2)] {
            traction(&mut a, row, v, m, n);
            traction(&mut a, row, (v + 2) % 3, other, -n);
            row += 2;
        }
    }
    for k in 0..3 {
        let element = fem_core::element::Triangle::new([REFERENCE[k], REFERENCE[(k + 1) % 3], CENTRE]);
        for (m, g) in element.gradients.into_iter().enumerate() {
            traction(&mut a, row, k, m, g);
        }
        row += 2;
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::geometry::{cross, norm, perpendicular};
    use fem_core::material::Hypothesis;

    const CORNERS: [Vector; 3] = [Vector::new(0.2, 0.1), Vector::new(1.7, 0.4), Vector::new(0.5, 1.3)];

    /// Computes the gradient-weighted sum that is the divergence of one part's linear stress, N/m³.
    fn part_divergence(corners: [Vector; 3], part: &[SymTensor2; 3]) -> Vector {
        let element = fem_core::element::Triangle::new(corners);
        part.iter().zip(element.gradients).map(|(s, g)| s.apply(g)).sum()
    }

    /// Loads of a linear stress that satisfies div τ + b = 0.
    fn loads_of(stress: impl Fn(Vector) -> SymTensor2) -> CellLoads {
        std::array::from_fn(|k| {
            let t = CORNERS[(k + 1) % 3] - CORNERS[k];
            std::array::from_fn(|m| stress(CORNERS[(k + m) % 3]).apply(Vector::new(t[1], -t[0])))
        })
    }

    #[test]
    fn conditions_have_full_rank() {
        let singular = conditions().singular_values();
        assert!(singular.min() > 1e-2, "{singular}");
    }

    #[test]
    fn linear_stresses_are_reproduced() {
        // div = (2 − 2, 5 − 5) + (0.3 − 0.3, …): σxx = 2x + y, σxy = −2y + 5x… chosen with its body force.
        let b = Vector::new(0.7, -1.1);
        let stress = |x: Vector| {
            let (x, y) = (x[0], x[1]);
            SymTensor2::new(
                1.0 + (2.0 - b[0]) * x + 0.4 * y,
                -3.0 + (-5.0 - b[1]) * y,
                0.5 + 5.0 * x - 2.0 * y,
            )
        };
        let found = cell_stress(CORNERS, &loads_of(stress), b);
        let centre = (CORNERS[0] + CORNERS[1] + CORNERS[2]) / 3.0;
        for k in 0..3 {
            for (s, x) in found[k].iter().zip([CORNERS[k], CORNERS[(k + 1) % 3], centre]) {
                let d = s.minus(stress(x));
                assert!(d.contract(d) < 1e-24, "{d:?}");
            }
        }
    }

    #[test]
    fn any_loads_in_equilibrium_give_an_admissible_stress() {
        // Self-equilibrated loads: random ones minus their resultant forces and moment.
        let mut loads: CellLoads =
            [[[0.3, -1.0], [2.0, 0.4]], [[-0.7, 0.1], [0.2, 1.9]], [[1.1, 0.6], [-0.4, -0.8]]]
                .map(|ends| ends.map(Vector::from));
        let total = |l: &CellLoads| {
            // ∫ of a linear traction times length is the mean of its ends.
            let mut f = [0.0; 3];
            for k in 0..3 {
                for m in 0..2 {
                    let (x, y) = (CORNERS[(k + m) % 3], CORNERS[(k + 1 - m) % 3]);
                    let g = l[k][m];
                    f[0] += 0.5 * g[0];
                    f[1] += 0.5 * g[1];
                    f[2] += cross((2.0 * x + y) / 6.0, g);
                }
            }
            f
        };
        let f = total(&loads);
        for m in 0..2 {
            loads[0][m] -= Vector::new(f[0], f[1]);
        }
        // A couple on edge 0, normal to it, balances the moment.
        let t = CORNERS[1] - CORNERS[0];
        let couple = |c: f64| [c * perpendicular(t), -c * perpendicular(t)];
        let add_couple = |mut l: CellLoads, c: f64| {
            for m in 0..2 {
                l[0][m] += couple(c)[m];
            }
            l
        };
        let unit = total(&add_couple(loads, 1.0))[2] - total(&loads)[2];
        loads = add_couple(loads, -total(&loads)[2] / unit);
        let stress = cell_stress(CORNERS, &loads, Vector::zeros());
        let centre = (CORNERS[0] + CORNERS[1] + CORNERS[2]) / 3.0;
        for k in 0..3 {
            let (p, q) = (CORNERS[k], CORNERS[(k + 1) % 3]);
            let divergence = part_divergence([p, q, centre], &stress[k]);
            assert!(norm(divergence) < 1e-12);
            let t = q - p;
            for m in 0..2 {
                let d = stress[k][m].apply(Vector::new(t[1], -t[0])) - loads[k][m];
                assert!(norm(d) < 1e-12);
            }
            let inner = centre - p;
            let other = &stress[(k + 2) % 3];
            for (s, o) in [(stress[k][0], other[1]), (stress[k][2], other[2])] {
                let jump = s.minus(o).apply(Vector::new(inner[1], -inner[0]));
                assert!(norm(jump) < 1e-12);
            }
        }
    }

    #[test]
    fn distance_to_a_constant_is_exact() {
        let material = LinearElastic::isotropic(3.0, 0.25, Hypothesis::PlaneStrain).unwrap();
        let constant = SymTensor2::new(1.0, -2.0, 0.5);
        let shifted = [[constant.plus(SymTensor2::new(0.1, 0.2, -0.3)); 3]; 3];
        let d = SymTensor2::new(0.1, 0.2, -0.3);
        let exact = 0.8 * material.complementary(d, d);
        assert!((distance_squared(&shifted, constant, 0.8, &material) - exact).abs() < 1e-16);
    }
}

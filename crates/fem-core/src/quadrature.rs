//! Quadrature on intervals and triangles.

/// Nodes in (0, 1) and weights (sum 1) of the five-point Gauss rule, exact to degree 9.
pub const GAUSS5: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Barycentric points and weights (sum 1) of Radon's seven-point rule, exact to degree 5 (Radon 1948).
pub const RADON7: [([f64; 3], f64); 7] = {
    const A: f64 = 0.101_286_507_323_456_34;
    const B: f64 = 0.470_142_064_105_115_1;
    const WA: f64 = 0.125_939_180_544_827_15;
    const WB: f64 = 0.132_394_152_788_506_2;
    const T: f64 = 1.0 / 3.0;
    [
        ([T, T, T], 0.225),
        ([1.0 - 2.0 * A, A, A], WA),
        ([A, 1.0 - 2.0 * A, A], WA),
        ([A, A, 1.0 - 2.0 * A], WA),
        ([1.0 - 2.0 * B, B, B], WB),
        ([B, 1.0 - 2.0 * B, B], WB),
        ([B, B, 1.0 - 2.0 * B], WB),
    ]
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_is_exact_to_degree_nine() {
        for degree in 0..=9 {
            let integral: f64 = GAUSS5.iter().map(|&(x, w)| w * x.powi(degree)).sum();
            assert!((integral - 1.0 / f64::from(degree + 1)).abs() < 1e-15, "degree {degree}");
        }
    }

    #[test]
    fn radon_is_exact_to_degree_five() {
        // ∫ x^i y^j over the unit triangle, divided by its area ½, is 2 i! j!/(i+j+2)!.
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for i in 0..=5 {
            for j in 0..=(5 - i) {
                let integral: f64 = RADON7.iter().map(|(l, w)| w * l[1].powi(i) * l[2].powi(j)).sum();
                let exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
                assert!((integral - exact).abs() < 1e-15, "x^{i} y^{j}");
            }
        }
    }
}

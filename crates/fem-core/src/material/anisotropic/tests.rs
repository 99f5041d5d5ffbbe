use super::*;
use crate::tensor::SymTensor2;

const BOTH: [Hypothesis; 2] = [Hypothesis::PlaneStrain, Hypothesis::PlaneStress];

fn wood(angle: f64) -> Orthotropic {
    Orthotropic {
        young_1: 11000.0,
        young_2: 900.0,
        young_3: 500.0,
        poisson_12: 0.37,
        poisson_13: 0.42,
        poisson_23: 0.47,
        shear: 750.0,
        angle,
    }
}

fn close(a: &Matrix3<f64>, b: &Matrix3<f64>) -> bool {
    (a - b).amax() <= 1e-13 * b.amax()
}

#[test]
fn with_the_constants_of_an_isotropic_material_it_is_one_at_every_angle() {
    let (young, poisson) = (2000.0, 0.3);
    for hypothesis in BOTH {
        let isotropic = LinearElastic::isotropic(young, poisson, hypothesis).unwrap();
        for angle in [0.0, 0.4, 1.7, -2.9] {
            let shear = young / (2.0 * (1.0 + poisson));
            let constants = Orthotropic::in_plane([young; 2], poisson, shear, angle);
            let turned = LinearElastic::orthotropic(&constants, hypothesis).unwrap();
            assert!(close(&turned.stiffness, &isotropic.stiffness), "{hypothesis:?} {angle}");
            assert!(close(&turned.compliance, &isotropic.compliance), "{hypothesis:?} {angle}");
            let sigma = SymTensor2::new(3.0, -1.0, 2.0);
            let (a, b) = (turned.von_mises(sigma, 0.0).unwrap(), isotropic.von_mises(sigma, 0.0).unwrap());
            assert!((a - b).abs() < 1e-13 * b);
        }
    }
}

#[test]
fn compliance_inverts_stiffness() {
    for hypothesis in BOTH {
        for angle in [0.0, 0.3, 1.0] {
            let m = LinearElastic::orthotropic(&wood(angle), hypothesis).unwrap();
            assert!((m.stiffness * m.compliance - Matrix3::identity()).amax() < 1e-12);
            assert_eq!(m.stiffness, m.stiffness.transpose());
            let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| m.stiffness[(i, j)]));
            let full = LinearElastic::from_stiffness(rows, hypothesis).unwrap();
            assert_eq!(full.stiffness, m.stiffness);
            assert!(close(&full.compliance, &m.compliance));
        }
    }
}

#[test]
fn pulled_along_its_axes_it_has_their_moduli() {
    for angle in [0.0, 0.7] {
        let m = LinearElastic::orthotropic(&wood(angle), Hypothesis::PlaneStress).unwrap();
        for (turned, young) in [(angle, 11000.0), (angle + std::f64::consts::FRAC_PI_2, 900.0)] {
            let (s, c) = turned.sin_cos();
            let pull = SymTensor2::new(c * c, s * s, c * s);
            let extension = m.strain(pull).contract(pull);
            assert!((extension * young - 1.0).abs() < 1e-13, "{angle}: {}", 1.0 / extension);
        }
    }
}

#[test]
fn plane_strain_has_no_strain_out_of_the_plane() {
    let c = wood(0.0);
    let m = LinearElastic::orthotropic(&c, Hypothesis::PlaneStrain).unwrap();
    let sigma = SymTensor2::new(3.0, -1.0, 0.5);
    let zz = m.out_of_plane_stress(sigma, 0.0).unwrap();
    let e3 = -c.poisson_13 / c.young_1 * sigma.xx - c.poisson_23 / c.young_2 * sigma.yy + zz / c.young_3;
    assert!(e3.abs() < 1e-15 * zz.abs());
    // The strain along axis 1 by the law of three dimensions.
    let e1 = sigma.xx / c.young_1 - c.poisson_12 / c.young_1 * sigma.yy - c.poisson_13 / c.young_1 * zz;
    assert!((m.strain(sigma).xx - e1).abs() < 1e-13 * e1.abs());
}

#[test]
fn what_is_not_positive_definite_is_refused() {
    let refused = |c: Orthotropic, h| LinearElastic::orthotropic(&c, h).unwrap_err();
    for h in BOTH {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-200] {
            let c = Orthotropic { shear: bad, ..wood(0.0) };
            assert!(matches!(refused(c, h), MaterialError::Modulus { name: "shear", .. }));
        }
        // √(E₁/E₂) = 3.496…
        let c = Orthotropic { poisson_12: 3.5, ..wood(0.0) };
        assert!(matches!(refused(c, h), MaterialError::PoissonPair { name: "poisson_12", .. }));
        let c = Orthotropic { angle: f64::NAN, ..wood(0.0) };
        assert!(matches!(refused(c, h), MaterialError::NotFinite { name: "angle", .. }));
    }
    // Each pair is allowed (0.11, 0.70, 0.67 of its limit), the three together are not: the determinant is −0.06. The third
    // axis does not matter in plane stress.
    let c = Orthotropic { poisson_13: 3.3, poisson_23: 0.9, ..wood(0.0) };
    assert!(matches!(refused(c, Hypothesis::PlaneStrain), MaterialError::PoissonTriple { .. }));
    assert!(LinearElastic::orthotropic(&c, Hypothesis::PlaneStress).is_ok());
    // Isotropic limits.
    let c = Orthotropic::in_plane([1.0; 2], 0.5, 1.0 / 3.0, 0.0);
    assert!(matches!(refused(c, Hypothesis::PlaneStrain), MaterialError::PoissonTriple { .. }));

    let full = |d| LinearElastic::from_stiffness(d, Hypothesis::PlaneStrain);
    let good = [[4.0, 1.0, 0.2], [1.0, 3.0, -0.1], [0.2, -0.1, 1.0]];
    assert_eq!(full(good).unwrap().von_mises(SymTensor2::new(1.0, 0.0, 0.0), 0.0), None);
    let changed = |i: usize, j: usize, value: f64| {
        let mut d = good;
        d[i][j] = value;
        full(d).unwrap_err()
    };
    assert_eq!(changed(0, 2, 0.3), MaterialError::NotSymmetric { entry: [1, 3], values: [0.3, 0.2] });
    assert!(matches!(changed(2, 2, -1.0), MaterialError::NotPositiveDefinite { .. }));
    assert!(matches!(changed(2, 2, 0.0), MaterialError::NotPositiveDefinite { .. }));
    assert!(matches!(changed(1, 1, f64::NAN), MaterialError::NotFinite { .. }));
    assert!(matches!(changed(1, 1, 1e200), MaterialError::NotFinite { .. }));
    // Positive, but lost in the round-off of the others.
    let diagonal = |last: f64| full([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, last]]);
    let nearly = diagonal(1e-18).unwrap_err();
    assert_eq!(nearly, MaterialError::NearlySingular { ratio: 1e-18 });
    assert!(nearly.to_string().contains("too nearly singular: ratio 1e-18"), "{nearly}");
    assert!(diagonal(1e-11).is_ok());
    assert!(matches!(full([[0.0; 3]; 3]), Err(MaterialError::NotPositiveDefinite { .. })));
}

#[test]
fn a_solid_material_is_the_same_whatever_its_constants_are_called() {
    let (young, poisson) = (2000.0, 0.3);
    let isotropic = LinearElastic::isotropic_solid(young, poisson).unwrap();
    let shear = young / (2.0 * (1.0 + poisson));
    let constants = Orthotropic::in_plane([young; 2], poisson, shear, 0.7);
    let plane = [Vector3::new(1.0, 2.0, -0.5), Vector3::new(0.3, 0.1, 2.0)];
    let turned = LinearElastic::orthotropic_solid(&constants, [shear; 2], plane).unwrap();
    let entries = std::array::from_fn(|i| std::array::from_fn(|j| isotropic.stiffness[(i, j)]));
    let full = LinearElastic::from_solid_stiffness(entries).unwrap();
    for other in [turned, full] {
        assert!((other.stiffness - isotropic.stiffness).amax() < 1e-12 * isotropic.stiffness.amax());
        assert!((other.compliance - isotropic.compliance).amax() < 1e-12 * isotropic.compliance.amax());
    }
}

#[test]
fn wood_is_pulled_along_its_axes_in_space() {
    // Axis 1 along z, axis 2 along x: pulled along z it shrinks by ν₁₂ along x and by ν₁₃ along y.
    let constants = wood(0.0);
    let plane = [Vector3::z(), Vector3::x()];
    let m = LinearElastic::orthotropic_solid(&constants, [600.0, 40.0], plane).unwrap();
    let strain = m.strain(SymTensor3 { zz: 11.0, ..Default::default() });
    for (found, expected) in [(strain.zz, 1e-3), (strain.xx, -0.37e-3), (strain.yy, -0.42e-3)] {
        assert!((found - expected).abs() < 1e-15);
    }
    // G₂₃ is between x and y, G₁₃ between y and z, G₁₂ between z and x.
    let shears = SymTensor3 { xy: 40.0, yz: 600.0, xz: 750.0, ..Default::default() };
    let strain = m.strain(shears);
    assert!([strain.xy, strain.yz, strain.xz].iter().all(|e| (e - 0.5).abs() < 1e-12), "{strain:?}");
    assert_eq!(
        LinearElastic::orthotropic_solid(&constants, [600.0, 40.0], [Vector3::x(), -2.0 * Vector3::x()]),
        Err(MaterialError::Axes)
    );
}

//! Symmetric tensors. The shear convention is stated here once: `xy` is always the
//! *tensor* component (`ε_xy = ½ γ_xy`), never the engineering shear.

use crate::geometry::Vector;

/// A symmetric second-order tensor of the plane: a strain (–) or a stress (Pa).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SymTensor2 {
    /// Component xx.
    pub xx: f64,
    /// Component yy.
    pub yy: f64,
    /// Tensor component xy = yx.
    pub xy: f64,
}

impl SymTensor2 {
    /// Creates a tensor from its components.
    #[inline(always)]
    pub const fn new(xx: f64, yy: f64, xy: f64) -> Self {
        Self { xx, yy, xy }
    }

    /// Applies the tensor to a vector, `T n`: the traction of a stress on a side of normal `n`.
    #[inline(always)]
    pub fn apply(self, n: Vector) -> Vector {
        Vector::new(self.xx * n[0] + self.xy * n[1], self.xy * n[0] + self.yy * n[1])
    }

    /// Computes the double contraction `S : T = S_xx T_xx + S_yy T_yy + 2 S_xy T_xy`.
    #[inline(always)]
    pub fn contract(self, other: Self) -> f64 {
        self.xx * other.xx + self.yy * other.yy + 2.0 * self.xy * other.xy
    }

    /// Adds two tensors.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self::new(self.xx + other.xx, self.yy + other.yy, self.xy + other.xy)
    }

    /// Subtracts `other`.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self::new(self.xx - other.xx, self.yy - other.yy, self.xy - other.xy)
    }

    /// Computes the principal values in the plane, ascending: `m ∓ √(¼ (xx − yy)² + xy²)` with the mean `m`.
    pub fn principal(self) -> [f64; 2] {
        let mean = 0.5 * (self.xx + self.yy);
        let radius = (0.5 * (self.xx - self.yy)).hypot(self.xy);
        [mean - radius, mean + radius]
    }

    /// Multiplies by a number.
    #[inline(always)]
    pub fn scaled(self, factor: f64) -> Self {
        Self::new(factor * self.xx, factor * self.yy, factor * self.xy)
    }
}

/// A symmetric second-order tensor of the space: a strain (–) or a stress (Pa).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SymTensor3 {
    /// Component xx.
    pub xx: f64,
    /// Component yy.
    pub yy: f64,
    /// Component zz.
    pub zz: f64,
    /// Tensor component yz = zy.
    pub yz: f64,
    /// Tensor component xz = zx.
    pub xz: f64,
    /// Tensor component xy = yx.
    pub xy: f64,
}

impl SymTensor3 {
    /// Adds two tensors.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        self.joined(other, |a, b| a + b)
    }

    /// Subtracts `other`.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        self.joined(other, |a, b| a - b)
    }

    /// Multiplies by a number.
    #[inline(always)]
    pub fn scaled(self, factor: f64) -> Self {
        self.joined(self, |a, _| factor * a)
    }

    /// Computes von Mises' equivalent stress, `√(3/2 s : s)` of the deviator `s`, Pa.
    pub fn von_mises(self) -> f64 {
        let pairs = (self.xx - self.yy).powi(2) + (self.yy - self.zz).powi(2) + (self.zz - self.xx).powi(2);
        let shears = self.yz * self.yz + self.xz * self.xz + self.xy * self.xy;
        (0.5 * pairs + 3.0 * shears).sqrt()
    }

    /// Computes the largest principal value by its size: of the mean `m` and the deviator `s` these are `m + 2 ρ cos(θ + 2kπ/3)` with
    /// `6 ρ² = s : s` and `cos 3θ = det s / 2ρ³`.
    pub fn largest_principal(self) -> f64 {
        let mean = (self.xx + self.yy + self.zz) / 3.0;
        let [a, b, c] = [self.xx - mean, self.yy - mean, self.zz - mean];
        let Self { yz, xz, xy, .. } = self;
        let squares = a * a + b * b + c * c + 2.0 * (yz * yz + xz * xz + xy * xy);
        let radius = (squares / 6.0).sqrt();
        if radius == 0.0 {
            return mean.abs();
        }
        let [a, b, c, yz, xz, xy] = [a, b, c, yz, xz, xy].map(|x| x / radius);
        let determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
        let angle = (0.5 * determinant).clamp(-1.0, 1.0).acos() / 3.0;
        let value = |k: f64| (mean + 2.0 * radius * (angle + k * std::f64::consts::TAU / 3.0).cos()).abs();
        value(0.0).max(value(1.0))
    }

    /// Computes the principal values, ascending.
    pub fn principal(self) -> [f64; 3] {
        // Moved by the largest in size, no principal value is of the other sign.
        let size = self.largest_principal();
        let moved = |by: f64| {
            Self { xx: self.xx + by, yy: self.yy + by, zz: self.zz + by, ..self }.largest_principal()
        };
        let [low, high] = [size - moved(-size), moved(size) - size];
        [low, self.xx + self.yy + self.zz - low - high, high]
    }

    #[inline(always)]
    fn joined(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let [a, b]: [[f64; 6]; 2] = [self.into(), other.into()];
        std::array::from_fn::<f64, 6, _>(|k| of(a[k], b[k])).into()
    }
}

impl From<[f64; 3]> for SymTensor2 {
    #[inline(always)]
    fn from([xx, yy, xy]: [f64; 3]) -> Self {
        Self { xx, yy, xy }
    }
}

impl From<SymTensor2> for [f64; 3] {
    #[inline(always)]
    fn from(t: SymTensor2) -> Self {
        [t.xx, t.yy, t.xy]
    }
}

impl From<[f64; 6]> for SymTensor3 {
    #[inline(always)]
    fn from([xx, yy, zz, yz, xz, xy]: [f64; 6]) -> Self {
        Self { xx, yy, zz, yz, xz, xy }
    }
}

impl From<SymTensor3> for [f64; 6] {
    #[inline(always)]
    fn from(t: SymTensor3) -> Self {
        [t.xx, t.yy, t.zz, t.yz, t.xz, t.xy]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contraction_counts_the_shear_twice() {
        let t = SymTensor2::new(1.0, 2.0, 3.0);
        assert_eq!(t.contract(t), 1.0 + 4.0 + 18.0);
    }

    #[test]
    fn principal_values_are_ascending() {
        let of = |values: [f64; 6]| SymTensor3::from(values).principal();
        let near = |found: [f64; 3], exact: [f64; 3]| {
            assert!(found.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
        };
        near(of([3.0, -5.0, 1.0, 0.0, 0.0, 0.0]), [-5.0, 1.0, 3.0]);
        // Shear in the plane of x and y: 2 ± 1.
        near(of([2.0, 2.0, -1.0, 0.0, 0.0, 1.0]), [-1.0, 1.0, 3.0]);
        near(of([0.0; 6]), [0.0; 3]);
        assert_eq!(SymTensor2::new(1.0, 7.0, 4.0).principal(), [-1.0, 9.0]);
    }

    #[test]
    fn the_largest_principal_value_has_the_largest_size() {
        let of = |values: [f64; 6]| SymTensor3::from(values).largest_principal();
        assert!((of([1.0, -3.0, 2.0, 0.0, 0.0, 0.0]) - 3.0).abs() < 1e-14);
        assert!((of([2.0, 2.0, 2.0, 0.0, 0.0, 0.0]) - 2.0).abs() < 1e-14);
        // A shear of yz alone: ±4.
        assert!((of([0.0, 0.0, 0.0, 4.0, 0.0, 0.0]) - 4.0).abs() < 1e-14);
        // [2, 1, 0; 1, 2, 0; 0, 0, -1]: 3, 1, -1.
        assert!((of([2.0, 2.0, -1.0, 0.0, 0.0, 1.0]) - 3.0).abs() < 1e-14);
    }
}

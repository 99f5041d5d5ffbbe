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

    /// Multiplies by a number.
    #[inline(always)]
    pub fn scaled(self, factor: f64) -> Self {
        Self::new(factor * self.xx, factor * self.yy, factor * self.xy)
    }

    /// Tells whether every component is finite.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.xx.is_finite() && self.yy.is_finite() && self.xy.is_finite()
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

    /// Computes von Mises' equivalent stress, `√(3/2 s : s)` of the deviator `s`, Pa.
    pub fn von_mises(self) -> f64 {
        let pairs = (self.xx - self.yy).powi(2) + (self.yy - self.zz).powi(2) + (self.zz - self.xx).powi(2);
        let shears = self.yz * self.yz + self.xz * self.xz + self.xy * self.xy;
        (0.5 * pairs + 3.0 * shears).sqrt()
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
}

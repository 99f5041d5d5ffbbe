//! The plane and the space: all that depends on the number of dimensions.
//!
//! Meshes, bodies and unknowns are generic over a [`Space`], [`Plane`] unless it is named. What they ask of it ends at the cell: arrays of
//! one value per axis or corner, the formulas of one cell and one facet, and rigid motions. Everything else is written once.
//!
//! | | [`Plane`] | [`Solid`] |
//! |---|---|---|
//! | cell, facet | triangle, edge | tetrahedron, triangle |
//! | their measures | area, length | volume, area |
//! | components of a tensor; rigid motions | 3 | 6 |
//! | a spin and a moment | number | vector |

mod array;
mod matrix;
mod plane;
mod solid;

use crate::geometry::Coordinates;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

pub use array::{Array, Item, Number};
pub use matrix::Matrix;
pub use plane::Plane;
pub(crate) use plane::SAMPLED_PARTS;
pub use solid::Solid;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Plane {}
    impl Sealed for super::Solid {}
}

/// A motion that turns by less than this fraction of its translation, over the size of the body, is a translation.
const TRANSLATION: f64 = 1e-6;

/// The words of messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Words {
    /// A cell.
    pub cell: &'static str,
    /// Several cells.
    pub cells: &'static str,
    /// A facet.
    pub facet: &'static str,
    /// Several facets.
    pub facets: &'static str,
    /// Before the word for a facet.
    pub article: &'static str,
    /// The measure of a cell.
    pub measure: &'static str,
    /// What makes the measure of a cell positive.
    pub sound: &'static str,
}

/// A number of dimensions. It is sealed: [`Plane`] and [`Solid`] are all there are.
///
/// Components of symmetric tensors are in Voigt's order: `xx, yy, xy` and `xx, yy, zz, yz, xz, xy`.
pub trait Space: sealed::Sealed + Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The number of axes.
    const DIM: usize;
    /// The number of components of a symmetric tensor, and of rigid motions.
    const COMPONENTS: usize;
    /// The names of the components of a displacement and of a rotation.
    const MOTIONS: &'static [&'static str];
    /// The words of messages.
    const WORDS: &'static Words;
    /// The unit vectors along the axes.
    const AXES: Self::Axes<Self::Vector>;
    /// The same number of vectors zero.
    const ZEROS: Self::Axes<Self::Vector>;
    /// Tells whether there is one tangent at a contact node. Friction has a sign then: the iteration solves it, and the normal may change.
    const ONE_TANGENT: bool;
    /// How far the normals of a contact surface may be off. A motion that they resist by less is free.
    const NORMAL_ERROR: f64;

    /// A point, a displacement, a force.
    type Vector: Coordinates;
    /// A symmetric tensor, made of its components.
    type Tensor: Copy
        + Debug
        + Default
        + PartialEq
        + Send
        + Sync
        + From<Self::Components<f64>>
        + Into<Self::Components<f64>>;
    /// A point as trees of boxes have it.
    type Place: rstar::Point<Scalar = f64> + Send + Sync;
    /// A linear map between components: a stiffness.
    type Matrix: Matrix<Self::Components<f64>>;
    /// A rotation, and what does work on it: a moment.
    type Spin: Copy
        + Debug
        + Default
        + PartialEq
        + Send
        + Sync
        + Add<Output = Self::Spin>
        + Sub<Output = Self::Spin>
        + Mul<f64, Output = Self::Spin>
        + Div<f64, Output = Self::Spin>
        + AddAssign
        + SubAssign;

    /// One value for each axis, or for each corner of a facet.
    type Axes<T: Item>: Array<T> + Item;
    /// One value for each corner of a cell.
    type Corners<T: Item>: Array<T> + Item;
    /// One value for each component of a tensor, or for each rigid motion.
    type Components<T: Item>: Array<T> + Item;
    /// One value for each axis that may own memory.
    type Data<T: Clone + Debug + Send + Sync>: Array<T>;

    /// Makes one value for each axis, or for each corner of a facet.
    fn axes<T: Item>(value: impl FnMut(usize) -> T) -> Self::Axes<T>;
    /// Makes one value for each corner of a cell.
    fn corners<T: Item>(value: impl FnMut(usize) -> T) -> Self::Corners<T>;
    /// Makes one value for each component.
    fn components<T: Item>(value: impl FnMut(usize) -> T) -> Self::Components<T>;
    /// Makes one value for each axis that may own memory.
    fn data<T: Clone + Debug + Send + Sync>(value: impl FnMut(usize) -> T) -> Self::Data<T>;

    /// Completes orthonormal vectors to a basis: returns orthonormal vectors that are perpendicular to them, then zeros.
    fn complement(basis: &[Self::Vector]) -> Self::Axes<Self::Vector>;

    /// Computes vectors the `k`-th of which is perpendicular to all given ones but the `k`-th; its product with that one is the determinant of all.
    fn cofactors<T: Number>(vectors: &Self::Axes<Self::Axes<T>>) -> Self::Axes<Self::Axes<T>>;

    /// Returns the corners of facet `k` of a cell of positive measure. Seen from outside they run counter-clockwise; in the plane from right
    /// to left.
    fn facet(k: usize) -> Self::Axes<usize>;
    /// Computes the signed measure of a cell, m² or m³.
    fn measure(corners: &Self::Corners<Self::Vector>) -> f64;
    /// Computes the signed measure of a cell; `None` if its sign is round-off, or if it is not finite.
    fn sure_measure(corners: &Self::Corners<Self::Vector>) -> Option<f64>;
    /// Computes the gradients of the shape functions of a cell, 1/m.
    ///
    /// * `measure`: of the cell.
    fn gradients(corners: &Self::Corners<Self::Vector>, measure: f64) -> Self::Corners<Self::Vector>;
    /// Returns a point as trees of boxes have it.
    fn place(point: Self::Vector) -> Self::Place;
    /// Cuts the common part of two cells of positive measure into cells, none of them turned over.
    fn common_part(
        a: &Self::Corners<Self::Vector>,
        b: &Self::Corners<Self::Vector>,
    ) -> Vec<Self::Corners<Self::Vector>>;
    /// Computes the smallest angle between two facets of a cell, in degrees; not positive in a triangle that runs clockwise.
    fn smallest_angle(corners: &Self::Corners<Self::Vector>) -> f64;
    /// Computes the measure of a facet, m or m².
    fn facet_measure(corners: &Self::Axes<Self::Vector>) -> f64;
    /// Computes the unit normal of a facet whose corners are in the order of [`Self::facet`].
    fn facet_normal(corners: &Self::Axes<Self::Vector>) -> Self::Vector;
    /// Returns a quadrature rule on a facet that is exact for polynomials of the fifth degree: barycentric coordinates, and weights of sum 1.
    fn facet_rule() -> &'static [(Self::Axes<f64>, f64)];
    /// Returns many points of a facet, at which functions are compared with their linear interpolants: barycentric coordinates, and weights of sum 1.
    fn facet_samples() -> Vec<(Self::Axes<f64>, f64)>;

    /// Computes the displacement of a rotation about the origin, `ω × x`.
    fn turned(spin: Self::Spin, arm: Self::Vector) -> Self::Vector;
    /// Computes the moment of a force about the origin, `x × f`.
    fn moment(arm: Self::Vector, force: Self::Vector) -> Self::Spin;
    /// Joins a translation and a spin.
    fn motion(translation: Self::Vector, spin: Self::Spin) -> Self::Components<f64>;
    /// Takes a motion apart.
    fn parts(motion: &Self::Components<f64>) -> (Self::Vector, Self::Spin);
    /// Computes the spin `ω` with `Σ w x × (ω × x) = m`.
    ///
    /// * `moment`: m; `arms`: w and x.
    fn spin_of(moment: Self::Spin, arms: impl Iterator<Item = (f64, Self::Vector)>) -> Self::Spin;

    /// Computes the normal of a flat part of a boundary; `None` if a corner is farther from one line or plane than a fraction of its size.
    ///
    /// * `facets`: each with its corners in the order of [`Self::facet`]; they are joined to each other.
    fn flat_normal(facets: &[Self::Axes<Self::Vector>], fraction: f64) -> Option<Self::Vector>;

    /// Finds a point on the axis of a motion `t + ω × x`, and in space the axis; `None` if it is a translation.
    fn screw(translation: Self::Vector, spin: Self::Spin) -> Option<(Self::Vector, Option<Self::Vector>)>;

    /// Returns the component of a symmetric tensor in row `i` and column `j`.
    #[inline(always)]
    fn component(i: usize, j: usize) -> usize {
        if i == j { i } else { Self::COMPONENTS - i - j }
    }

    /// [`Self::cofactors`] of vectors.
    fn across(vectors: &Self::Axes<Self::Vector>) -> Self::Axes<Self::Vector> {
        let rows = Self::axes(|k| Self::axes(|c| vectors[k][c]));
        let across = Self::cofactors(&rows);
        Self::axes(|k| Self::Vector::of(|c| across[k][c]))
    }

    /// Multiplies a tensor by a vector, `T n`: the traction of a stress on a side of normal `n`.
    #[inline(always)]
    fn applied(tensor: Self::Tensor, n: Self::Vector) -> Self::Vector {
        let t: Self::Components<f64> = tensor.into();
        Self::Vector::of(|i| {
            let mut sum = t[Self::component(i, 0)] * n[0];
            for j in 1..Self::DIM {
                sum += t[Self::component(i, j)] * n[j];
            }
            sum
        })
    }

    /// Computes the double contraction `A : B`, in which shears count twice.
    #[inline(always)]
    fn contracted(a: Self::Tensor, b: Self::Tensor) -> f64 {
        let (a, b): (Self::Components<f64>, Self::Components<f64>) = (a.into(), b.into());
        let mut sum = a[0] * b[0];
        for k in 1..Self::DIM {
            sum += a[k] * b[k];
        }
        for k in Self::DIM..Self::COMPONENTS {
            sum += 2.0 * a[k] * b[k];
        }
        sum
    }

    /// Computes the work of a force along all motions of a rigid body: its components, and its moments times a factor.
    #[inline]
    fn work(force: Self::Vector, arm: Self::Vector, factor: f64) -> Self::Components<f64> {
        Self::components(|k| {
            if k < Self::DIM {
                return force[k];
            }
            let (_, spin) = Self::parts(&Self::components(|j| if j == k { 1.0 } else { 0.0 }));
            force.times(&(Self::turned(spin, arm) * factor))
        })
    }
}

#[cfg(test)]
mod tests;

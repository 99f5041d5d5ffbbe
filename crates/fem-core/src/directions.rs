//! Directions in which a node or a facet is held: subspaces of the plane or the space.

use crate::geometry::{Coordinates, norm};
use crate::space::{Plane, Space};

/// A subspace of the directions of displacements and forces: none, some, or all.
///
/// Components of a vector along the basis are themselves a vector, zero beyond [`Self::count`].
///
/// ```
/// use fem_core::{directions::Directions, geometry::Vector, space::Plane};
/// let roller = Directions::<Plane>::along(Vector::new(0.6, 0.8));
/// assert_eq!(roller.complement().basis(), [Vector::new(-0.8, 0.6)]);
/// assert_eq!(roller.with(Vector::x(), 1e-9), Directions::ALL);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions<S: Space = Plane> {
    /// Orthonormal vectors, then zeros.
    basis: S::Axes<S::Vector>,
    count: usize,
}

impl<S: Space> Directions<S> {
    /// No direction.
    pub const NONE: Self = Self { basis: S::ZEROS, count: 0 };

    /// All directions, with the axes as basis.
    pub const ALL: Self = Self { basis: S::AXES, count: S::DIM };

    /// Creates the multiples of a unit vector.
    pub fn along(direction: S::Vector) -> Self {
        let mut basis = S::ZEROS;
        basis[0] = direction;
        Self { basis, count: 1 }
    }

    /// Creates the span of this subspace and a unit vector: this subspace if it contains the vector, see [`Self::contains`].
    pub fn with(self, direction: S::Vector, tolerance: f64) -> Self {
        if self.is_none() {
            return Self::along(direction);
        }
        if self.contains(direction, tolerance) {
            return self;
        }
        if self.count + 1 == S::DIM {
            return Self::ALL;
        }
        // Twice: the first remainder may be short.
        let beside = |vector: S::Vector| {
            let rest = vector - self.project(vector);
            rest / norm(rest)
        };
        let mut basis = self.basis;
        basis[self.count] = beside(beside(direction));
        Self { basis, count: self.count + 1 }
    }

    /// Creates the span of this subspace and another one, see [`Self::with`].
    pub fn joined(self, other: &Self, tolerance: f64) -> Self {
        other.basis().iter().fold(self, |span, direction| span.with(*direction, tolerance))
    }

    /// Creates the directions perpendicular to this subspace.
    pub fn complement(&self) -> Self {
        Self { basis: S::complement(self.basis()), count: S::DIM - self.count }
    }

    /// Returns the number of its dimensions.
    #[inline]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Tells whether it has no direction.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    /// Tells whether it has all directions.
    #[inline]
    pub fn is_all(&self) -> bool {
        self.count == S::DIM
    }

    /// Returns an orthonormal basis.
    #[inline]
    pub fn basis(&self) -> &[S::Vector] {
        &self.basis.as_ref()[..self.count]
    }

    /// Tells whether the part of a vector perpendicular to this subspace is at most `tolerance` long: the sine of the angle, if it is a unit vector.
    pub fn contains(&self, vector: S::Vector, tolerance: f64) -> bool {
        self.sine(vector) <= tolerance
    }

    /// Computes the length of the part of a vector perpendicular to this subspace: the sine of the angle, if it is a unit vector.
    pub fn sine(&self, vector: S::Vector) -> f64 {
        norm(self.complement().components(vector))
    }

    /// Computes the components of a vector along the basis.
    #[inline]
    pub fn components(&self, vector: S::Vector) -> S::Vector {
        S::Vector::of(|k| self.basis[k].times(&vector))
    }

    /// Computes the vector that has the given components along the basis.
    #[inline]
    pub fn combined(&self, components: S::Vector) -> S::Vector {
        (1..S::DIM).fold(self.basis[0] * components[0], |sum, k| sum + self.basis[k] * components[k])
    }

    /// Computes the part of a vector in this subspace.
    pub fn project(&self, vector: S::Vector) -> S::Vector {
        self.combined(self.components(vector))
    }

    /// Computes the unit vector of this subspace that is nearest to a vector; `None` if it is perpendicular to the vector.
    pub fn nearest(&self, vector: S::Vector) -> Option<S::Vector> {
        let components = self.components(vector);
        let length = norm(components);
        (length > 0.0).then(|| self.combined(components / length))
    }

    /// Splits a vector into a part in this subspace and a rest in `other`, and returns the part. If more than one split would do, or none, it is the
    /// projection.
    pub fn part_beside(&self, other: &Self, vector: S::Vector) -> S::Vector {
        let both = [self.basis(), other.basis()].concat();
        if both.len() != S::DIM || other.is_none() || self.is_none() {
            return self.project(vector);
        }
        let across = S::across(&S::axes(|k| both[k]));
        if across[0].times(&both[0]) == 0.0 {
            return self.project(vector);
        }
        let part = |k: usize| both[k] * (across[k].times(&vector) / across[k].times(&both[k]));
        (1..self.count).fold(part(0), |sum, k| sum + part(k))
    }
}

/// Computes the basis dual to vectors `v`, as many as there are axes: `d_i·v_j = δ_ij`.
pub(crate) fn dual<S: Space>(vectors: S::Axes<S::Vector>) -> S::Axes<S::Vector> {
    let across = S::across(&vectors);
    S::axes(|k| across[k] * (1.0 / across[k].times(&vectors[k])))
}

/// Computes the vector `u` of which the products with given vectors are known: `v_k·u`, as many as there are axes.
pub fn with_products<S: Space>(vectors: S::Axes<S::Vector>, products: S::Axes<f64>) -> S::Vector {
    let across = S::across(&vectors);
    let sum = (1..S::DIM).fold(across[0] * products[0], |sum, k| sum + across[k] * products[k]);
    sum / across[S::DIM - 1].times(&vectors[S::DIM - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::space::Solid;
    use nalgebra::Vector3;

    const SAME: f64 = 1e-9;

    fn slanted() -> Directions {
        Directions::<Plane>::along(Vector::new(0.6, 0.8))
    }

    #[test]
    fn a_subspace_and_its_complement_split_every_vector() {
        let vector = Vector::new(0.3, -1.7);
        for some in [Directions::<Plane>::NONE, slanted(), Directions::<Plane>::ALL] {
            let free = some.complement();
            assert_eq!(some.count() + free.count(), Directions::<Plane>::ALL.count());
            assert!(norm(some.project(vector) + free.project(vector) - vector) < 1e-15);
            let products = some.basis().iter().flat_map(|d| free.basis().iter().map(|f| d.dot(f)));
            assert!(products.into_iter().all(|product| product == 0.0));
            assert!((norm(some.components(vector)) - norm(some.project(vector))).abs() < 1e-15);
            assert_eq!(some.complement().complement().count(), some.count());
        }
        assert!(Directions::<Plane>::NONE.is_none() && Directions::<Plane>::ALL.is_all());
        assert!(!slanted().is_none() && !slanted().is_all());
    }

    #[test]
    fn all_directions_keep_every_bit_of_a_vector() {
        let vector = Vector::new(0.1 + 0.2, 1.0 / 3.0);
        assert_eq!(Directions::<Plane>::ALL.components(vector), vector);
        assert_eq!(Directions::<Plane>::ALL.project(vector), vector);
        assert_eq!(Directions::<Plane>::NONE.project(vector), Vector::zeros());
    }

    #[test]
    fn a_span_grows_by_new_directions_only() {
        let near = Vector::new(0.6 - 0.8e-10, 0.8 + 0.6e-10);
        assert_eq!(Directions::<Plane>::NONE.with(near, SAME), Directions::<Plane>::along(near));
        assert_eq!(slanted().with(near, SAME), slanted());
        assert_eq!(slanted().with(-near, SAME), slanted());
        assert_eq!(slanted().with(Vector::y(), SAME), Directions::<Plane>::ALL);
        assert_eq!(Directions::<Plane>::ALL.with(near, SAME), Directions::<Plane>::ALL);
        assert!(
            !Directions::<Plane>::NONE.contains(near, SAME) && Directions::<Plane>::ALL.contains(near, 0.0)
        );
    }

    #[test]
    fn the_nearest_direction_has_the_sign_of_the_vector() {
        let [d] = *slanted().basis() else { panic!("one direction") };
        assert_eq!(slanted().nearest(Vector::new(3.0, 0.1)), Some(d));
        assert_eq!(slanted().nearest(Vector::new(-3.0, 0.1)), Some(-d));
        assert_eq!(slanted().nearest(Vector::zeros()), None);
        assert_eq!(Directions::<Plane>::NONE.nearest(d), None);
        assert_eq!(Directions::<Plane>::ALL.nearest(Vector::new(0.0, -7.0)), Some(-Vector::y()));
    }

    #[test]
    fn two_directions_share_a_vector() {
        let (first, second) = (slanted(), Directions::<Plane>::along(Vector::x()));
        let vector = Vector::new(2.0, 1.0);
        let part = first.part_beside(&second, vector);
        let rest = vector - part;
        assert!(first.contains(part, 1e-15) && second.contains(rest, 1e-15));
        // A second support that holds all directions takes what the first does not.
        assert_eq!(first.part_beside(&Directions::<Plane>::ALL, vector), first.project(vector));
        assert_eq!(first.part_beside(&first, vector), first.project(vector));
        assert_eq!(Directions::<Plane>::ALL.part_beside(&Directions::<Plane>::NONE, vector), vector);
    }

    #[test]
    fn a_dual_basis_has_products_of_one_and_zero() {
        let vectors = [Vector::new(0.6, 0.8), Vector::new(2.0, -0.5)];
        let duals = dual::<Plane>(vectors);
        for (i, d) in duals.iter().enumerate() {
            for (j, v) in vectors.iter().enumerate() {
                assert!((d.dot(v) - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        let u = with_products::<Plane>(vectors, [0.7, -0.2]);
        assert!(norm(u - (0.7 * duals[0] - 0.2 * duals[1])) < 1e-15);
    }

    #[test]
    fn subspaces_of_the_space_grow_and_are_split() {
        let [a, b] = [Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.0, 1.0, 0.0)];
        let line = Directions::<Solid>::along(a);
        let plane = line.with((a + b).normalize(), SAME);
        assert_eq!((plane.count(), plane.complement().count()), (2, 1));
        assert!(plane.contains(b, 1e-15) && plane.contains(a, 0.0) && !plane.contains(Vector3::x(), 0.1));
        assert_eq!(plane.with(Vector3::x(), SAME), Directions::ALL);
        let vector = Vector3::new(0.3, -1.7, 0.4);
        for some in [line, plane, Directions::ALL, Directions::NONE] {
            let free = some.complement();
            assert!(norm(some.project(vector) + free.project(vector) - vector) < 1e-15);
            assert_eq!(free.complement().count(), some.count());
        }
        // A part in the plane and a rest along a slanted line.
        let other = Directions::along(Vector3::new(1.0, 2.0, -2.0) / 3.0);
        let part = plane.part_beside(&other, vector);
        assert!(plane.contains(part, 1e-15) && other.contains(vector - part, 1e-15));
    }

    #[test]
    fn a_dual_basis_of_the_space() {
        let vectors =
            [Vector3::new(0.6, 0.8, 0.1), Vector3::new(2.0, -0.5, 0.3), Vector3::new(-0.2, 0.4, 1.5)];
        let duals = dual::<Solid>(vectors);
        for (i, d) in duals.iter().enumerate() {
            for (j, v) in vectors.iter().enumerate() {
                assert!((d.dot(v) - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        let u = with_products::<Solid>(vectors, [0.7, -0.2, 0.4]);
        assert!(norm(u - (0.7 * duals[0] - 0.2 * duals[1] + 0.4 * duals[2])) < 1e-15);
    }
}

//! Directions in which a node or an edge is held: subspaces of the plane.

use crate::geometry::{Vector, cross, norm, perpendicular};

/// A subspace of the directions of displacements and forces: none, some, or all.
///
/// Components of a vector along the basis are themselves a [`Vector`], zero beyond [`Self::count`].
///
/// ```
/// use fem_core::{directions::Directions, geometry::Vector};
/// let roller = Directions::along(Vector::new(0.6, 0.8));
/// assert_eq!(roller.complement().basis(), [Vector::new(-0.8, 0.6)]);
/// assert_eq!(roller.with(Vector::x(), 1e-9), Directions::ALL);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions {
    /// Orthonormal vectors, then zeros.
    basis: [Vector; 2],
    count: usize,
}

impl Directions {
    /// No direction.
    pub const NONE: Self = Self { basis: [Vector::new(0.0, 0.0); 2], count: 0 };

    /// All directions, with the axes as basis.
    pub const ALL: Self = Self { basis: [Vector::new(1.0, 0.0), Vector::new(0.0, 1.0)], count: 2 };

    /// Creates the multiples of a unit vector.
    pub fn along(direction: Vector) -> Self {
        Self { basis: [direction, Vector::zeros()], count: 1 }
    }

    /// Creates the span of this subspace and a unit vector: this subspace if it contains the vector, see [`Self::contains`].
    pub fn with(self, direction: Vector, tolerance: f64) -> Self {
        match self.count {
            0 => Self::along(direction),
            _ if self.contains(direction, tolerance) => self,
            _ => Self::ALL,
        }
    }

    /// Creates the directions perpendicular to this subspace.
    pub fn complement(&self) -> Self {
        match self.basis() {
            [] => Self::ALL,
            [direction] => Self::along(perpendicular(*direction)),
            _ => Self::NONE,
        }
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
        self.count == self.basis.len()
    }

    /// Returns an orthonormal basis.
    #[inline]
    pub fn basis(&self) -> &[Vector] {
        &self.basis[..self.count]
    }

    /// Tells whether the part of a vector perpendicular to this subspace is at most `tolerance` long: the sine of the angle, if it is a unit vector.
    pub fn contains(&self, vector: Vector, tolerance: f64) -> bool {
        norm(self.complement().components(vector)) <= tolerance
    }

    /// Computes the components of a vector along the basis.
    #[inline]
    pub fn components(&self, vector: Vector) -> Vector {
        Vector::from_fn(|k, _| self.basis[k].dot(&vector))
    }

    /// Computes the vector that has the given components along the basis.
    #[inline]
    pub fn combined(&self, components: Vector) -> Vector {
        components[0] * self.basis[0] + components[1] * self.basis[1]
    }

    /// Computes the part of a vector in this subspace.
    pub fn project(&self, vector: Vector) -> Vector {
        self.combined(self.components(vector))
    }

    /// Computes the unit vector of this subspace that is nearest to a vector; `None` if it is perpendicular to the vector.
    pub fn nearest(&self, vector: Vector) -> Option<Vector> {
        let components = self.components(vector);
        let length = norm(components);
        (length > 0.0).then(|| self.combined(components / length))
    }

    /// Splits a vector into a part in this subspace and a rest in `other`, and returns the part. If more than one split would do, or none, it is the
    /// projection.
    pub fn part_beside(&self, other: &Self, vector: Vector) -> Vector {
        match (self.basis(), other.basis()) {
            ([d], [e]) if cross(*d, *e) != 0.0 => cross(vector, *e) / cross(*d, *e) * d,
            _ => self.project(vector),
        }
    }
}

/// Computes the basis dual to two vectors `v`: `d_i·v_j = δ_ij`.
pub(crate) fn dual([a, b]: [Vector; 2]) -> [Vector; 2] {
    let across = [perpendicular(b), perpendicular(a)];
    [1.0 / across[0].dot(&a) * across[0], 1.0 / across[1].dot(&b) * across[1]]
}

/// Computes the vector `u` of which two products are known: `a·u`, `b·u`.
pub fn with_products([a, b]: [Vector; 2], products: [f64; 2]) -> Vector {
    let [p, q] = products;
    Vector::new(p * b[1] - q * a[1], a[0] * q - b[0] * p) / cross(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAME: f64 = 1e-9;

    fn slanted() -> Directions {
        Directions::along(Vector::new(0.6, 0.8))
    }

    #[test]
    fn a_subspace_and_its_complement_split_every_vector() {
        let vector = Vector::new(0.3, -1.7);
        for some in [Directions::NONE, slanted(), Directions::ALL] {
            let free = some.complement();
            assert_eq!(some.count() + free.count(), Directions::ALL.count());
            assert!(norm(some.project(vector) + free.project(vector) - vector) < 1e-15);
            let products = some.basis().iter().flat_map(|d| free.basis().iter().map(|f| d.dot(f)));
            assert!(products.into_iter().all(|product| product == 0.0));
            assert!((norm(some.components(vector)) - norm(some.project(vector))).abs() < 1e-15);
            assert_eq!(some.complement().complement().count(), some.count());
        }
        assert!(Directions::NONE.is_none() && Directions::ALL.is_all());
        assert!(!slanted().is_none() && !slanted().is_all());
    }

    #[test]
    fn all_directions_keep_every_bit_of_a_vector() {
        let vector = Vector::new(0.1 + 0.2, 1.0 / 3.0);
        assert_eq!(Directions::ALL.components(vector), vector);
        assert_eq!(Directions::ALL.project(vector), vector);
        assert_eq!(Directions::NONE.project(vector), Vector::zeros());
    }

    #[test]
    fn a_span_grows_by_new_directions_only() {
        let near = Vector::new(0.6 - 0.8e-10, 0.8 + 0.6e-10);
        assert_eq!(Directions::NONE.with(near, SAME), Directions::along(near));
        assert_eq!(slanted().with(near, SAME), slanted());
        assert_eq!(slanted().with(-near, SAME), slanted());
        assert_eq!(slanted().with(Vector::y(), SAME), Directions::ALL);
        assert_eq!(Directions::ALL.with(near, SAME), Directions::ALL);
        assert!(!Directions::NONE.contains(near, SAME) && Directions::ALL.contains(near, 0.0));
    }

    #[test]
    fn the_nearest_direction_has_the_sign_of_the_vector() {
        let [d] = *slanted().basis() else { panic!("one direction") };
        assert_eq!(slanted().nearest(Vector::new(3.0, 0.1)), Some(d));
        assert_eq!(slanted().nearest(Vector::new(-3.0, 0.1)), Some(-d));
        assert_eq!(slanted().nearest(Vector::zeros()), None);
        assert_eq!(Directions::NONE.nearest(d), None);
        assert_eq!(Directions::ALL.nearest(Vector::new(0.0, -7.0)), Some(-Vector::y()));
    }

    #[test]
    fn two_directions_share_a_vector() {
        let (first, second) = (slanted(), Directions::along(Vector::x()));
        let vector = Vector::new(2.0, 1.0);
        let part = first.part_beside(&second, vector);
        let rest = vector - part;
        assert!(first.contains(part, 1e-15) && second.contains(rest, 1e-15));
        // A second support that holds all directions takes what the first does not.
        assert_eq!(first.part_beside(&Directions::ALL, vector), first.project(vector));
        assert_eq!(first.part_beside(&first, vector), first.project(vector));
        assert_eq!(Directions::ALL.part_beside(&Directions::NONE, vector), vector);
    }

    #[test]
    fn a_dual_basis_has_products_of_one_and_zero() {
        let vectors = [Vector::new(0.6, 0.8), Vector::new(2.0, -0.5)];
        let duals = dual(vectors);
        for (i, d) in duals.iter().enumerate() {
            for (j, v) in vectors.iter().enumerate() {
                assert!((d.dot(v) - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        let u = with_products(vectors, [0.7, -0.2]);
        assert!(norm(u - (0.7 * duals[0] - 0.2 * duals[1])) < 1e-15);
    }
}

//! Who carries λ.

/// The roles of the two bodies of a pair in an iteration: Ω₁, whose normal trace λ is imposed, and Ω₂, which solves the
/// unilateral problem.
///
/// Traces and forces of an iteration are along the outward normal of Ω₁. The normals of the pairs point out of the
/// first body whatever the roles, so that they differ by [`Roles::sign`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Roles {
    imposed: usize,
}

impl Roles {
    /// The first body carries λ.
    pub const FIRST: Self = Self { imposed: 0 };
    /// The second body carries λ.
    pub const SECOND: Self = Self { imposed: 1 };

    /// Returns the side of the body that carries λ, Ω₁.
    pub fn imposed(self) -> usize {
        self.imposed
    }

    /// Returns the side of the body with the unilateral problem, Ω₂.
    pub fn unilateral(self) -> usize {
        1 - self.imposed
    }

    /// Returns the sides of Ω₁ and Ω₂.
    pub fn sides(self) -> [usize; 2] {
        [self.imposed(), self.unilateral()]
    }

    /// Returns the role of a side: 0 for Ω₁, 1 for Ω₂.
    pub fn of_side(self, side: usize) -> usize {
        usize::from(side != self.imposed)
    }

    /// Sorts what belongs to Ω₁ and Ω₂ by side.
    pub fn by_side<T>(self, mut by_role: [T; 2]) -> [T; 2] {
        if self.imposed == 1 {
            by_role.reverse();
        }
        by_role
    }

    /// Returns the outward normal of Ω₁ over the normal of a pair, 1 or −1.
    pub fn sign(self) -> f64 {
        if self.imposed == 0 { 1.0 } else { -1.0 }
    }
}

impl Default for Roles {
    fn default() -> Self {
        Self::FIRST
    }
}

#[cfg(test)]
mod tests {
    use super::Roles;

    #[test]
    fn what_is_sorted_by_role_can_be_sorted_by_side() {
        for roles in [Roles::FIRST, Roles::SECOND] {
            assert_eq!(roles.by_side(roles.sides()), [0, 1]);
            assert_eq!(roles.sides().map(|side| roles.of_side(side)), [0, 1]);
        }
        assert_eq!([Roles::FIRST.sign(), Roles::SECOND.sign()], [1.0, -1.0]);
    }
}

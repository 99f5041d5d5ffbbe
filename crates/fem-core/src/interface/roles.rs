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

    /// Returns the body that carries λ, Ω₁.
    pub fn imposed(self) -> usize {
        self.imposed
    }

    /// Returns the body with the unilateral problem, Ω₂.
    pub fn unilateral(self) -> usize {
        1 - self.imposed
    }

    /// Returns Ω₁ and Ω₂.
    pub fn bodies(self) -> [usize; 2] {
        [self.imposed(), self.unilateral()]
    }

    /// Returns the number of a body's role: 0 for Ω₁, 1 for Ω₂.
    pub fn of_body(self, body: usize) -> usize {
        usize::from(body != self.imposed)
    }

    /// Sorts what belongs to Ω₁ and Ω₂ by body.
    pub fn by_body<T>(self, mut by_role: [T; 2]) -> [T; 2] {
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
    fn what_is_sorted_by_role_can_be_sorted_by_body() {
        for roles in [Roles::FIRST, Roles::SECOND] {
            assert_eq!(roles.by_body(roles.bodies()), [0, 1]);
            assert_eq!(roles.bodies().map(|b| roles.of_body(b)), [0, 1]);
        }
        assert_eq!([Roles::FIRST.sign(), Roles::SECOND.sign()], [1.0, -1.0]);
    }
}

//! A motion that nothing resists.

/// A rigid motion of the assembly that nothing resists.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnresistedMotion {
    /// Numbers of rigid motions with their amounts, see [`fem_core::contact_system::ContactRows::motions`].
    pub amounts: Vec<(usize, f64)>,
    /// The work of the loads along it, less what friction resists, J/m; 0 if no load drives it.
    pub work: f64,
    /// Whether rows resist it, by less than the error of their normals, see [`fem_core::contact_system::ContactRows::normal_error`].
    pub weak: bool,
}

impl UnresistedMotion {
    /// Takes what forces leave of the loads, `a = e − G P`, for the motion.
    ///
    /// The work is `a·a`: with the forces nearest to the loads `P·Gᵀa` is zero but for friction at its limit. The work of the loads themselves,
    /// `e·a`, is mostly rounding if little of them is left.
    pub(crate) fn along(left: &[f64]) -> Self {
        let moving = left.iter().copied().enumerate().filter(|(_, amount)| *amount != 0.0);
        Self { amounts: moving.collect(), work: left.iter().map(|a| a * a).sum(), weak: false }
    }
}

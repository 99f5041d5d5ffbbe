//! A motion that nothing resists.

/// A rigid motion of the assembly that nothing resists.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnresistedMotion {
    /// Numbers of rigid motions with their amounts, see [`fem_core::contact_system::ContactRows::motions`].
    pub amounts: Vec<(usize, f64)>,
    /// The work of the loads along it, less what friction resists, J/m; 0 if no load drives it.
    pub work: f64,
}

impl UnresistedMotion {
    pub(crate) fn new(amounts: &[f64], work: f64) -> Self {
        let moving = amounts.iter().copied().enumerate().filter(|(_, amount)| *amount != 0.0);
        Self { amounts: moving.collect(), work }
    }
}

//! Who carries λ.

use crate::subdomain::Subdomain;
use fem_core::contact_system::{ContactSystem, PairRows, Partner, Roles};
use fem_core::each_body;

/// A body counts as stiffer if it is so by more than this fraction.
const STIFFER: f64 = 1e-6;

/// Chooses for each pair the stiffer body to carry λ, floating or not, by the mean diagonal of `S` in the rows of the
/// pair; of two equal ones the first. With the softer body the iteration takes many times as long or does not converge.
///
/// An obstacle always carries λ. Pairs of a body whose rows depend on each other, which the iteration does not allow,
/// keep [`Roles::FIRST`].
pub fn stiffer_roles(system: &ContactSystem<'_>) -> Vec<Roles> {
    let rows = &system.rows;
    let diagonals = each_body(system.bodies.len(), |b| {
        let body = Subdomain::new(system, b).ok()?;
        let mut by_row = vec![0.0; rows.len()];
        body.scatter(&body.diagonal(), &mut by_row);
        Some(rows.by_pair(&by_row))
    });
    let of_pair = |(k, pair): (usize, &PairRows)| {
        let Partner::Body(second) = pair.partner else { return Roles::SECOND };
        let [first, second] =
            [pair.body, second].map(|b| Some(diagonals[b].as_ref()?[k].iter().sum::<f64>()));
        match (first, second) {
            (Some(first), Some(second)) if second > (1.0 + STIFFER) * first => Roles::SECOND,
            _ => Roles::FIRST,
        }
    };
    rows.pairs.iter().enumerate().map(of_pair).collect()
}

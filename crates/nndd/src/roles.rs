//! Who carries λ.

use crate::rows::Rows;
use crate::subdomain::Subdomain;
use fem_core::each_body;
use fem_core::interface::{ContactPair, Roles};
use fem_core::prepared::PreparedProblem;

/// A body counts as stiffer if it is so by more than this fraction.
const STIFFER: f64 = 1e-6;

/// Chooses for each pair the stiffer body to carry λ, floating or not, by the mean diagonal of `S` in the rows of the
/// pair; of two equal ones the first. With the softer body the iteration takes many times as long or does not converge.
///
/// An obstacle always carries λ. Pairs of a body whose rows depend on each other, which the iteration does not allow,
/// keep [`Roles::FIRST`].
pub fn stiffer_roles(problem: &PreparedProblem) -> Vec<Roles> {
    let rows = Rows::new(problem.problem());
    let diagonals = each_body(problem.bodies().len(), |b| {
        let body = Subdomain::new(problem, &rows, b).ok()?;
        let mut by_row = vec![0.0; rows.len()];
        body.scatter(&body.diagonal(), &mut by_row);
        Some(rows.by_pair(&by_row))
    });
    let of_pair = |(k, pair): (usize, &ContactPair)| {
        if problem.problem().obstacle_of(pair).is_some() {
            return Roles::SECOND;
        }
        let [first, second] = pair.bodies.map(|b| Some(diagonals[b].as_ref()?[k].iter().sum::<f64>()));
        match (first, second) {
            (Some(first), Some(second)) if second > (1.0 + STIFFER) * first => Roles::SECOND,
            _ => Roles::FIRST,
        }
    };
    problem.problem().contacts.iter().enumerate().map(of_pair).collect()
}

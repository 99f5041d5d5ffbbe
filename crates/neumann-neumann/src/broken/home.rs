//! Bodies in subdomains that contact alone holds.

use super::{Broken, DEPENDENT, Part, Sparse};
use crate::error::BalancingError;
use crate::vector::dot;
use contact_qp::{Combination, RowSelection, SparseRows};
use fem_core::contact_system::{ContactSystem, RowMotion};
use fem_core::dense::pseudo_inverse;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A subdomain in which the motions of its body are measured. Its springs hold the body along those that the pairs do not resist: no load is along them,
/// so that the springs take nothing.
pub(super) struct Home {
    /// The numbers of the motions, those that the pairs resist first.
    pub(super) numbers: Vec<usize>,
    pub(super) resisted: usize,
    /// The motions in its unknowns.
    pub(super) motions: DMatrix<f64>,
    /// `(Rᵀ R)⁻¹` of the motions `R` in all unknowns of the body.
    pub(super) inverse: DMatrix<f64>,
    /// The combinations of its free motions that its springs do not hold.
    pub(super) loose: Option<DMatrix<f64>>,
}

impl Broken<'_> {
    /// Lists independent motions of bodies in subdomains, of one or several together, that a set of closed rows leaves free, each in the unknowns of the homes
    /// alone: they move all subdomains, and no force resists them.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub(crate) fn left_free(&self, closed: &[bool]) -> Result<Vec<Sparse>, BalancingError> {
        if self.parts.iter().all(|part| part.home.as_ref().is_none_or(|home| home.resisted == 0)) {
            return Ok(Vec::new());
        }
        let all = &self.system.rows;
        let mut lines = SparseRows::new(closed.len());
        for number in &self.resisted {
            lines.push(all.motions[*number].traces.iter().copied().filter(|(row, _)| closed[*row]));
        }
        let groups: Vec<usize> =
            self.resisted.iter().map(|k| all.motions[*k].partner.place(all.bodies)).collect();
        let free = RowSelection::new(&lines, &vec![0.0; lines.len()], &groups, all.normal_error)?.kernel;
        let in_homes = |combination: &Combination| {
            let mut amounts = vec![0.0; all.motions.len()];
            combination.iter().for_each(|(k, amount)| amounts[self.resisted[*k]] = *amount);
            let of_part = |part: &Part<'_>| {
                let Home { numbers, motions, .. } = part.home.as_ref()?;
                let amounts = DVector::from_iterator(numbers.len(), numbers.iter().map(|k| amounts[*k]));
                let moved = motions * amounts;
                Some(part.unknowns.clone().zip(moved.iter().copied()).collect::<Sparse>())
            };
            self.parts.iter().filter_map(of_part).flatten().filter(|(_, moved)| *moved != 0.0).collect()
        };
        Ok(free.iter().map(in_homes).collect())
    }
}

impl Home {
    /// * `resisted`, `held`: the numbers of the motions that the pairs resist, and of the others; `moved`: each in the unknowns of the subdomain; `free`:
    ///   what its own supports leave free; `of_body`: see [`ContactSystem::free`].
    ///
    /// `None` if its motions are not seen.
    pub(super) fn new<'m>(
        resisted: Vec<usize>,
        held: &[usize],
        moved: impl Fn(&usize) -> &'m [f64],
        (free, of_body): (&[Vec<f64>], &[Vec<f64>]),
    ) -> Option<Self> {
        let (count, mut numbers) = (resisted.len(), resisted);
        numbers.extend_from_slice(held);
        let columns = |numbers: &[usize]| -> DMatrix<f64> {
            let columns: Vec<DVector<f64>> =
                numbers.iter().map(|number| DVector::from_column_slice(moved(number))).collect();
            DMatrix::from_columns(&columns)
        };
        let inverse = |matrix: DMatrix<f64>| {
            let zero = DEPENDENT * matrix.norm();
            pseudo_inverse(matrix, zero)
        };
        let mut loose = None;
        if !held.is_empty() {
            // What is perpendicular to the held motions, among free ones of length 1.
            let lengths = DVector::from_iterator(free.len(), free.iter().map(|q| 1.0 / dot(q, q).sqrt()));
            let unit: Vec<DVector<f64>> =
                free.iter().zip(&lengths).map(|(q, s)| DVector::from_column_slice(q) * *s).collect();
            let unit = DMatrix::from_columns(&unit);
            let of_held = inverse(unit)? * columns(held);
            let projector = &of_held * inverse(of_held.clone())?;
            let rest = DMatrix::identity(free.len(), free.len()) - projector;
            loose = Some(rest * DMatrix::from_diagonal(&lengths));
        }
        let whole: Vec<DVector<f64>> =
            numbers.iter().map(|k| DVector::from_column_slice(&of_body[*k])).collect();
        let whole = DMatrix::from_columns(&whole);
        let gram = whole.tr_mul(&whole);
        Some(Self { inverse: inverse(gram)?, motions: columns(&numbers), numbers, resisted: count, loose })
    }
}

/// Returns the place of the body in which each rigid motion is measured: of a body in subdomains the first one that it moves. None of an obstacle.
pub(super) fn homes(system: &ContactSystem<'_>, ranges: &[Range<usize>]) -> Vec<Option<usize>> {
    let of = |(of, free): (&RowMotion, &Vec<f64>)| {
        let body = of.partner.body()?;
        let first = system.body_of.iter().position(|known| *known == body)?;
        let own = (first..ranges.len()).take_while(|place| system.body_of[*place] == body);
        let moves = |place: &usize| own_part(free, ranges, first, *place).iter().any(|moved| *moved != 0.0);
        own.clone().find(moves).or(Some(first))
    };
    system.rows.motions.iter().zip(&system.free).map(of).collect()
}

/// Takes the part of a subdomain from a motion of its body.
///
/// * `first`: the place of the first subdomain.
pub(super) fn own_part<'f>(
    free: &'f [f64],
    ranges: &[Range<usize>],
    first: usize,
    place: usize,
) -> &'f [f64] {
    let start = ranges[first].start;
    &free[ranges[place].start - start..ranges[place].end - start]
}
